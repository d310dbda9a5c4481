"""How late the relay switches, by behaviour and by netlist: what gain-bandwidth does to a card."""

from collections.abc import Mapping

import numpy as np

import netlists
from analog_card.analyses import Transient
from analog_card.behaviour import CardBehaviour
from analog_card.behaviour_elements import CHANNEL, LINK_OPEN
from analog_card.behaviour_model import run_behaviour
from analog_card.design import Design
from analog_card.figures import card_figures
from analog_card.ngspice import Session

BENCH = netlists.BENCHES / "channel-relay.cir"
# How far the surface goes to either side of zero [V], and how fast [V/s]: as in a limit cycle.
_SURFACE, _RATE = 0.28, 200.0
# The demand goes no further to either side than this share of full scale.
_FURTHEST = 0.4
_STEP = 5e-6
# Below this no demand that a card takes moves its surface far enough.
LEAST_WEIGHT = 0.01


def demand_triangle(design: Design) -> tuple[float, float]:
    """Return the demand that moves the surface as in a limit cycle: to either side, and its period.

    Returns
    -------
    amplitude, period : float
        [V], [s].
    """
    weight = max(card_figures(design).weight_displacement, LEAST_WEIGHT)
    amplitude = min(_SURFACE / weight, _FURTHEST * design.transducer.full_scale_voltage)
    return amplitude, 4 * weight * amplitude / _RATE


def behaviour_delay(
    design: Design, elements: Mapping[str, float], rest: float, middle: float
) -> float:
    """Return how late the relay of a card switches, from its behaviour.

    Parameters
    ----------
    design : Design
        The card as designed.
    elements : mapping of str to float
        Values of its elements.
    rest, middle : float
        Voltages of the transducer, and of the demand where the card is at rest [V].

    Returns
    -------
    float
        Mean of both directions [s]: offsets of the comparator make one later and one earlier. Not a
        number where the surface does not pass zero.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> 55e-6 < behaviour_delay(load_design(), {}, 5.0, 5.0) < 70e-6
    True
    """
    amplitude, period = demand_triangle(design)
    time = np.arange(round(period / _STEP) + 1) * _STEP
    slope = 4 * amplitude / period
    demand = middle - amplitude + slope * np.minimum(time, period - time)
    card = CardBehaviour(design, elements, relay=True)
    found = run_behaviour(card, time, np.full(len(time), rest), demand)
    return _delay(time, found["surface"], found["control"])


def netlist_delay(
    session: Session, elements: Mapping[str, float], middle: float, period: float
) -> float:
    """Return how late the relay of a card switches, measured on `BENCH` [s].

    Parameters
    ----------
    session : Session
        With the bench loaded, its demand going as by `demand_triangle`.
    elements : mapping of str to float
        Values of the channel's elements, as the netlist has them.
    middle, period : float
        Voltage of the demand where the card is at rest [V], and its period [s].
    """
    parts = {**elements, "xboundary.rlink": LINK_OPEN}
    session.change({f"{CHANNEL}.{name}": value for name, value in parts.items()})
    session.change({"vmiddle": middle})
    found = session.run(Transient(period, _STEP))
    return _delay(found.time, found["surface"].real, found["control"].real)


def _delay(time: np.ndarray, surface: np.ndarray, control: np.ndarray) -> float:
    both = [_crossing(time, side * control) - _crossing(time, side * surface) for side in (1, -1)]
    return float(np.mean(both))


def _crossing(time: np.ndarray, signal: np.ndarray) -> float:
    """Return when a signal passes zero upwards for the first time."""
    places = np.flatnonzero((signal[:-1] < 0) & (signal[1:] >= 0))
    if not len(places):
        return float("nan")
    k = int(places[0])
    share = -signal[k] / (signal[k + 1] - signal[k])
    return float(time[k] + share * (time[k + 1] - time[k]))
