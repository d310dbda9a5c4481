"""What a card amounts to in open loop, measured on the netlist and computed from its behaviour."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

import netlists
from analog_card.amplifier_elements import netlist_elements
from analog_card.analyses import FrequencySweep, OperatingPoint
from analog_card.behaviour import CardBehaviour, card_stages
from analog_card.behaviour_elements import CHANNEL, nominal_elements, offset_name
from analog_card.behaviour_limiter import inputs
from analog_card.behaviour_model import rest_voltages, stage_responses
from analog_card.design import Design
from analog_card.figures import card_figures
from analog_card.ngspice import Session
from analog_card.tolerance_relay import BENCH as RELAY_BENCH
from analog_card.tolerance_relay import (
    LEAST_WEIGHT,
    behaviour_delay,
    demand_triangle,
    netlist_delay,
)

# Unit of each figure; the name says what it is.
FIGURES = {
    "displacement_weight": "1/s2",
    "velocity_weight": "1/s",
    "boundary_layer": "m/s2",
    "velocity_gain": "V s/m",
    "acceleration_gain": "V s2/m",
    "acceleration_phase": "degree",
    "rest_error": "m",
    "level_high": "V",
    "level_low": "V",
    "level_asymmetry": "",
    "relay_delay": "s",
}
_PROBE = 200.0  # Hz, where gain and phase of the acceleration tap are taken
_SLOW = 10.0  # Hz, where a differentiator has its gain
# Where the card is to hold the piston, as a share of the transducer's full scale: off the middle,
# so that a mismatch of the difference amplifier shows.
_HELD = 0.8
# How far the surface goes while a demand is looked for at which it, or the comparator, is zero [V].
_COARSE, _FINE = 0.6, 0.01
_SWEEP = FrequencySweep(1.0, 1e3, 10)
_BENCH = netlists.BENCHES / "channel-ac.cir"
_NODES = ("displacement", "first", "second", "deviation", "rate", "comparator")


def behaviour_figures(design: Design, elements: Mapping[str, float]) -> dict[str, float]:
    """Return the figures of one card from its behaviour.

    Parameters
    ----------
    design : Design
        The card as designed.
    elements : mapping of str to float
        Values of its elements.

    Returns
    -------
    dict of str to float
        By the names of `FIGURES`, in SI.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> round(behaviour_figures(load_design(), {})["velocity_gain"], 2)
    4.0
    """
    card = CardBehaviour(design, elements)
    stages = card_stages(card)
    slow, probe = (
        {name: values[k] for name, values in stage_responses(card, _both()).items()} for k in (0, 1)
    )
    held = _HELD * design.transducer.full_scale_voltage
    levels = (
        stages.limiter.fraction
        * np.interp(stages.comparator_swing, inputs(), stages.limiter.clamped)
        + stages.control_offset
    )
    found = _figures(
        design,
        weights=-stages.surface[:3],
        difference=float(stages.difference[0]),
        inverter=abs(slow["inverter"]),
        slow=(slow["first"], slow["second"]),
        probe=probe["first"] * probe["second"],
        comparator_gain=stages.comparator_gain,
        control_gain=stages.limiter.division * stages.limiter.fraction,
        comparator=rest_voltages(stages, held, held)["comparator"],
        levels=levels,
    )
    zero = _zero_crossing(
        *((demand, rest_voltages(stages, held, demand)["comparator"]) for demand in (held, 0.0))
    )
    return found | {"relay_delay": behaviour_delay(design, elements, held, zero)}


def netlist_figures(
    design: Design, cards: Sequence[Mapping[str, float]]
) -> Iterator[dict[str, float]]:
    """Yield the figures of cards, each measured on the netlist.

    Parameters
    ----------
    design : Design
        The card as designed.
    cards : sequence of mapping of str to float
        Values of the elements of each.

    Yields
    ------
    dict of str to float
        As from `behaviour_figures`.

    Raises
    ------
    SimulationError
        When ngspice fails.
    """
    held = _HELD * design.transducer.full_scale_voltage
    save = ["surface", "control", "transducer", *(f"{CHANNEL}.{node}" for node in _NODES)]
    parameters = {**design.netlist_parameters(), "rest": held}
    amplitude, period = demand_triangle(design)
    switched = {**parameters, "amplitude": amplitude, "period": period}
    with (
        Session(_BENCH, parameters, save) as session,
        Session(RELAY_BENCH, switched, ["surface", "control"]) as relay,
    ):
        for card in cards:
            elements = netlist_elements(
                {**nominal_elements(design), **card}, design.soldered.operational_amplifier
            )
            found, zero = _measured(design, session, elements, held)
            yield found | {"relay_delay": netlist_delay(relay, elements, zero, period)}


def _measured(
    design: Design, session: Session, elements: Mapping[str, float], held: float
) -> tuple[dict[str, float], float]:
    """Return the figures of one card from its operating points and its frequency response.

    With them the demand at which its comparator is at zero: offsets alone may saturate that of a
    card with a narrow layer, which then has no response.
    """
    session.change({f"{CHANNEL}.{name}": value for name, value in elements.items()})

    def at_rest(demand: float, node: str) -> tuple[float, float]:
        session.change({"vdemand": demand})
        return demand, float(session.run(OperatingPoint())[node][0].real)

    weight = max(card_figures(design).weight_displacement, LEAST_WEIGHT)
    comparator = f"{CHANNEL}.comparator"
    # No further than what a transducer gives.
    lower = held - min(_COARSE / weight, held / 2)
    near = _zero_crossing(*(at_rest(demand, "surface") for demand in (lower, held)))
    first, second = (at_rest(near + away / weight, comparator) for away in (-_FINE, _FINE))
    zero = _zero_crossing(first, second)
    slope = (second[1] - first[1]) / (second[0] - first[0])
    session.change({"vdemand": zero})
    sweep = session.run(_SWEEP)
    # An offset of its own drives the output to its limits whatever the surface can do.
    offset, limits = offset_name("boundary_layer"), []
    far = _beyond_limits(design)
    for sign in (-1.0, 1.0):
        session.change({f"{CHANNEL}.{offset}": elements[offset] + sign * far})
        limits.append(float(session.run(OperatingPoint())["control"][0].real))
    session.change({f"{CHANNEL}.{offset}": elements[offset]})
    node = {name: sweep[f"{CHANNEL}.{name}"] for name in _NODES}
    states = np.column_stack([node["deviation"], node["rate"], node["second"]])
    found = _figures(
        design,
        weights=_fitted(states, -sweep["surface"]),
        difference=float(abs(node["deviation"][0] / node["displacement"][0])),
        inverter=float(abs(node["rate"][0] / node["first"][0])),
        slow=_at(_SLOW, sweep.frequency, _taps(node)),
        probe=complex(np.prod(_at(_PROBE, sweep.frequency, _taps(node)))),
        comparator_gain=float(abs(node["comparator"][0] / sweep["surface"][0])),
        control_gain=float(abs(sweep["control"][0] / node["comparator"][0])),
        comparator=slope * (held - zero),
        levels=np.array(limits),
    )
    return found, zero


def _beyond_limits(design: Design) -> float:
    """Return an offset of the boundary-layer amplifier that takes it far beyond its limits [V]."""
    parts, amplifier = design.soldered, design.soldered.operational_amplifier
    feedback = parts.boundary_layer_amplifier
    least = 1 + feedback.feedback_resistance / feedback.ground_resistance
    return 2 * (amplifier.positive_swing + amplifier.negative_swing) / least


def _zero_crossing(one: tuple[float, float], other: tuple[float, float]) -> float:
    """Return where a straight line through two points is zero; the middle of them if nowhere."""
    (start, low), (end, high) = one, other
    if low == high:
        return (start + end) / 2
    return start - low * (end - start) / (high - low)


def _figures(
    design: Design,
    weights: np.ndarray,
    difference: float,
    inverter: float,
    slow: tuple[complex, complex],
    probe: complex,
    comparator_gain: float,
    control_gain: float,
    comparator: float,
    levels: np.ndarray,
) -> dict[str, float]:
    """Return the figures from gains of the stages, whoever found them.

    The surface is zero where the comparator is: off by its voltage over its gain, over the weight
    of the displacement.
    """
    scale = design.transducer.gain
    velocity, acceleration = (abs(gain) / (2 * np.pi * _SLOW) for gain in slow)
    taps = velocity * acceleration
    level = (levels[1] - levels[0]) / 2
    return {
        "displacement_weight": float(weights[0] * difference / (weights[2] * taps)),
        "velocity_weight": float(weights[1] * inverter / (weights[2] * acceleration)),
        "boundary_layer": float(
            level / (comparator_gain * control_gain * scale * weights[2] * taps)
        ),
        "velocity_gain": float(scale * velocity),
        "acceleration_gain": float(scale * abs(probe) / (2 * np.pi * _PROBE) ** 2),
        "acceleration_phase": float(np.angle(-probe, deg=True)),
        "rest_error": float(-comparator / (comparator_gain * weights[0] * difference * scale)),
        "level_high": float(levels[1]),
        "level_low": float(levels[0]),
        # By how much the upper level is above the lower, of either.
        "level_asymmetry": float((levels[1] + levels[0]) / level),
    }


def _both() -> np.ndarray:
    return np.array([_SLOW, _PROBE])


def _taps(node: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return node["first"] / node["displacement"], node["second"] / node["first"]


def _at(
    frequency: float, frequencies: np.ndarray, gains: tuple[np.ndarray, np.ndarray]
) -> tuple[complex, complex]:
    """Return gains between the points of a sweep; divided by frequency they hardly change."""
    values = [
        complex(
            np.interp(frequency, frequencies, (gain / frequencies).real),
            np.interp(frequency, frequencies, (gain / frequencies).imag),
        )
        * frequency
        for gain in gains
    ]
    return values[0], values[1]


def _fitted(states: np.ndarray, surface: np.ndarray) -> np.ndarray:
    """Return the weights of the states in the surface, each point weighted alike."""
    rows = states / np.abs(surface)[:, None]
    right = surface / np.abs(surface)
    stacked = np.vstack([rows.real, rows.imag])
    return np.linalg.lstsq(stacked, np.concatenate([right.real, right.imag]), rcond=None)[0]
