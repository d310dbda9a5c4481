"""How late the relay switches, by behaviour and by netlist: what gain-bandwidth does to a card."""

from collections.abc import Mapping

import numpy as np

import netlists
from analog_card.analyses import Transient
from analog_card.behaviour import CardBehaviour
from analog_card.behaviour_elements import CHANNEL, LINK_OPEN
from analog_card.behaviour_model import run_behaviour
from analog_card.design import Design
from analog_card.ngspice import Session

BENCH = netlists.BENCHES / "channel-relay.cir"
# As in the bench: the demand, on both sides of the transducer [V], and its period [s].
AMPLITUDE, _PERIOD = 0.6, 5.6e-3
_STEP = 5e-6


def behaviour_delay(design: Design, elements: Mapping[str, float], rest: float) -> float:
    """Return how late the relay of a card switches, from its behaviour.

    Parameters
    ----------
    design : Design
        The card as designed.
    elements : mapping of str to float
        Values of its elements.
    rest : float
        Voltage of the transducer [V].

    Returns
    -------
    float
        Mean of both directions [s]: offsets of the comparator make one later and one earlier. Not a
        number where the surface does not pass zero.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> 55e-6 < behaviour_delay(load_design(), {}, 5.0) < 70e-6
    True
    """
    parts = {**elements, "xboundary.rlink": LINK_OPEN}
    time = np.arange(round(_PERIOD / _STEP) + 1) * _STEP
    swing = 4 * AMPLITUDE / _PERIOD
    demand = rest - AMPLITUDE + swing * np.minimum(time, _PERIOD - time)
    card = CardBehaviour(design, parts, relay=True)
    found = run_behaviour(card, time, np.full(len(time), rest), demand)
    return _delay(time, found["surface"], found["control"])


def netlist_delay(session: Session, elements: Mapping[str, float]) -> float:
    """Return how late the relay of a card switches, measured on `BENCH` [s].

    Parameters
    ----------
    session : Session
        With the bench loaded.
    elements : mapping of str to float
        Values of the channel's elements, as the netlist has them.
    """
    parts = {**elements, "xboundary.rlink": LINK_OPEN}
    session.change({f"{CHANNEL}.{name}": value for name, value in parts.items()})
    found = session.run(Transient(_PERIOD, _STEP))
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
