"""The behavioural card: what every stage of a channel does, as numbers, with each imperfection."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from analog_card.behaviour_amplifiers import StageAmplifier, channel_amplifiers
from analog_card.behaviour_elements import (
    DIFFERENTIATORS,
    LINK_OPEN,
    Elements,
    differentiator_parts,
    nominal_elements,
    rheostat,
    wiper_source,
)
from analog_card.behaviour_limiter import LimiterCurve, limiter_curve
from analog_card.design import Design, DifferentiatorParts, OperationalAmplifier
from analog_card.imperfections import Imperfections


@dataclass(frozen=True)
class CardBehaviour:
    """A card to be simulated by its behaviour.

    Attributes
    ----------
    design : Design
        The card.
    elements : mapping of str to float
        Values of elements that differ from the design's, by their names in
        `analog_card.behaviour_elements.nominal_elements`.
    imperfections : Imperfections
        What of the real card is in it.
    relay : bool
        Whether the feedback of the boundary-layer amplifier is opened.
    """

    design: Design
    elements: Mapping[str, float] = field(default_factory=dict)
    imperfections: Imperfections = field(default_factory=Imperfections)
    relay: bool = False


@dataclass(frozen=True)
class Stages:
    """What the stages of a channel do, in numbers.

    Attributes
    ----------
    differentiator_amplifiers : tuple of OperationalAmplifier
        Of velocity and acceleration, at their ideal values where an imperfection is left out.
    speeds : ndarray, shape (6,)
        2 pi times the gain-bandwidth products of the op-amps of `lags` [1/s].
    velocity, acceleration : DifferentiatorParts
        The differentiators.
    loads : tuple of float
        Of velocity and acceleration tap, by inverter and surface amplifier [ohm].
    differentiator_offsets : ndarray, shape (2,)
        At their non-inverting inputs, with the drop of the bias current [V].
    bias_currents : ndarray, shape (2,)
        Into their inverting inputs [A].
    buffer_gains : ndarray, shape (2,)
        Of transducer and demand buffer [V/V].
    buffer_offsets : ndarray, shape (2,)
        Of transducer and demand buffer [V].
    difference : ndarray, shape (3,)
        Gain from displacement, gain from demand (negative) [V/V], output at rest [V].
    inverter : ndarray, shape (2,)
        Gain (negative) [V/V], output at rest [V].
    surface : ndarray, shape (4,)
        Gains from deviation, rate and acceleration tap (negative) [V/V], output at rest [V].
    comparator_gain, comparator_offset : float
        Of the boundary-layer amplifier [V/V], [V].
    lags : ndarray, shape (6,)
        Time constants of transducer buffer, difference amplifier, inverter, surface amplifier,
        boundary-layer amplifier and output follower, each its noise gain over the speed [s].
    swings : ndarray, shape (2, 2)
        Lowest and highest voltage inside the op-amps of velocity and acceleration tap [V].
    rate_swing, surface_swing, comparator_swing : ndarray, shape (2,)
        Lowest and highest output of inverter, surface and boundary-layer amplifier under load [V].
    slew_rates : ndarray, shape (3,)
        Of the op-amps of velocity and acceleration tap and of the boundary-layer amplifier [V/s].
    limiter : LimiterCurve
        Clamp and P4.
    control_offset : float
        Of the output follower [V].
    """

    differentiator_amplifiers: tuple[OperationalAmplifier, OperationalAmplifier]
    speeds: np.ndarray
    velocity: DifferentiatorParts
    acceleration: DifferentiatorParts
    loads: tuple[float, float]
    differentiator_offsets: np.ndarray
    bias_currents: np.ndarray
    buffer_gains: np.ndarray
    buffer_offsets: np.ndarray
    difference: np.ndarray
    inverter: np.ndarray
    surface: np.ndarray
    comparator_gain: float
    comparator_offset: float
    lags: np.ndarray
    swings: np.ndarray
    rate_swing: np.ndarray
    surface_swing: np.ndarray
    comparator_swing: np.ndarray
    slew_rates: np.ndarray
    limiter: LimiterCurve
    control_offset: float


@dataclass(frozen=True)
class _LinearStages:
    """What the stages after the differentiators do as long as none is limited.

    Attributes
    ----------
    difference, inverter, surface : ndarray
        As in `Stages`.
    noise_gains : dict of str to float
        Of the op-amps of `Stages.lags`, in that order [V/V].
    """

    difference: np.ndarray
    inverter: np.ndarray
    surface: np.ndarray
    noise_gains: dict[str, float]


def card_stages(card: CardBehaviour) -> Stages:
    """Return what the stages of a card do.

    Parameters
    ----------
    card : CardBehaviour
        The card.

    Returns
    -------
    Stages
        In SI.

    Notes
    -----
    Each op-amp is an integrator of speed 2 pi GBW with open-loop gain A0 and an offset; a stage
    of noise gain N settles at its ideal value over 1 + N/A0, with the time constant of N/(1 + N/A0)
    over the speed. An offset appears at the output times the noise gain, which for the surface
    amplifier holds the resistances behind the wipers: 1 + sum of Rf/(R + wiper). Left out, below
    0.01 dB and 0.1 degrees up to 20 kHz: the second pole, input capacitances, output resistances
    other than of the differentiators.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> stages = card_stages(CardBehaviour(load_design()))
    >>> round(stages.comparator_gain, 2)  # 1 + (3.9 + 15.09) kohm/620 ohm, over 1 + that/A0
    31.62
    """
    design, with_ = card.design, card.imperfections
    elements = {**nominal_elements(design), **card.elements}
    if card.relay:
        # Elements of a whole card have a link of their own, closed.
        elements["xboundary.rlink"] = LINK_OPEN
    amplifiers = channel_amplifiers(elements, design, with_)
    contacts = _contacts(design, with_)
    rejection = design.soldered.operational_amplifier.common_mode_rejection
    common = 1 / rejection if with_.common_mode else 0.0
    transducer, demand, first, second = (
        amplifiers[name] for name in ("transducer_buffer", "demand_buffer", *DIFFERENTIATORS)
    )
    linear = _linear_stages(elements, contacts, common, amplifiers)
    lagging, comparator = linear.noise_gains, amplifiers["boundary_layer"]
    gain = lagging["boundary_layer"]
    curve = limiter_curve(
        design,
        elements,
        contacts,
        comparator.figures,
        _feedback(elements, contacts) + elements["xboundary.rground"],
        with_.zener_knee,
    )
    velocity, acceleration = (
        differentiator_parts(stage, elements, design) for stage in DIFFERENTIATORS
    )
    series = design.soldered.input_buffer.series_resistance
    rate_load = _rate_load(elements, contacts)
    return Stages(
        differentiator_amplifiers=(first.figures, second.figures),
        speeds=np.array([amplifiers[name].speed for name in lagging]),
        velocity=velocity,
        acceleration=acceleration,
        loads=(elements["xinverter.rinput"], elements["xsurface.racceleration"]),
        differentiator_offsets=np.array(
            [
                first.offset_behind(velocity.bias_resistance),
                second.offset_behind(acceleration.bias_resistance),
            ]
        ),
        bias_currents=np.array([first.inverting_current, second.inverting_current]),
        buffer_gains=np.array([each.settled(1.0) for each in (transducer, demand)]) * (1 + common),
        buffer_offsets=np.array([each.follower_offset(series) for each in (transducer, demand)]),
        difference=linear.difference,
        inverter=linear.inverter,
        surface=linear.surface,
        comparator_gain=gain * comparator.settled(gain),
        comparator_offset=comparator.offset,
        lags=np.array([amplifiers[name].lag(noise) for name, noise in lagging.items()]),
        swings=np.array([first.inner_swing, second.inner_swing]),
        rate_swing=amplifiers["inverter"].inner_swing / amplifiers["inverter"].division(rate_load),
        surface_swing=amplifiers["surface"].limits(
            lambda swing: swing / amplifiers["surface"].division(elements["xsurface.rfeedback"])
        ),
        comparator_swing=comparator.limits(curve.loaded),
        slew_rates=np.array([each.figures.slew_rate for each in (first, second, comparator)]),
        limiter=curve,
        control_offset=amplifiers["limiter"].follower_offset(series),
    )


def _linear_stages(
    elements: Elements,
    contacts: tuple[float, float],
    common: float,
    amplifiers: Mapping[str, StageAmplifier],
) -> _LinearStages:
    difference, difference_noise = _difference(elements, common, amplifiers["difference"])
    inverter, inverter_noise = _inverter(elements, amplifiers["inverter"])
    surface, surface_noise = _surface(elements, contacts, amplifiers["surface"])
    noise_gains = {
        "transducer_buffer": 1.0,
        "difference": difference_noise,
        "inverter": inverter_noise,
        "surface": surface_noise,
        "boundary_layer": 1 + _feedback(elements, contacts) / elements["xboundary.rground"],
        "limiter": 1.0,
    }
    return _LinearStages(difference, inverter, surface, noise_gains)


def _contacts(design: Design, with_: Imperfections) -> tuple[float, float]:
    contacts = design.soldered.potentiometer_contacts
    if not with_.potentiometer_contacts:
        return 0.0, 0.0
    return contacts.end_resistance, contacts.wiper_resistance


def _rate_load(elements: Elements, contacts: tuple[float, float]) -> float:
    return 1 / (
        1 / elements["xinverter.rfeedback"] + 1 / wiper_source("P2", elements, *contacts).track
    )


def _difference(
    elements: Elements, common: float, amplifier: StageAmplifier
) -> tuple[np.ndarray, float]:
    plus = elements["xdifference.rground"] / (
        elements["xdifference.rground"] + elements["xdifference.rdisplacement"]
    )
    ratio = elements["xdifference.rfeedback"] / elements["xdifference.rdemand"]
    noise_gain = 1 + ratio
    # The bias current of the non-inverting input meets the same resistance and cancels.
    rest = noise_gain * amplifier.offset
    gains = np.array([(1 + common) * plus * noise_gain, -ratio, rest])
    return gains * amplifier.settled(noise_gain), noise_gain


def _inverter(elements: Elements, amplifier: StageAmplifier) -> tuple[np.ndarray, float]:
    feedback = elements["xinverter.rfeedback"]
    ratio = feedback / elements["xinverter.rinput"]
    noise_gain = 1 + ratio
    rest = noise_gain * amplifier.offset + amplifier.inverting_current * feedback
    return np.array([-ratio, rest]) * amplifier.settled(noise_gain), noise_gain


def _surface(
    elements: Elements, contacts: tuple[float, float], amplifier: StageAmplifier
) -> tuple[np.ndarray, float]:
    feedback = elements["xsurface.rfeedback"]
    displacement, velocity = (wiper_source(name, elements, *contacts) for name in ("P1", "P2"))
    branches = np.array(
        [
            elements["xsurface.xdisplacement.rinput"] + displacement.resistance,
            elements["xsurface.xvelocity.rinput"] + velocity.resistance,
            elements["xsurface.racceleration"],
        ]
    )
    weights = feedback / branches * np.array([displacement.fraction, velocity.fraction, 1.0])
    noise_gain = float(1 + np.sum(feedback / branches))
    rest = noise_gain * amplifier.offset + amplifier.inverting_current * feedback
    return np.array([*-weights, rest]) * amplifier.settled(noise_gain), noise_gain


def _feedback(elements: Elements, contacts: tuple[float, float]) -> float:
    return (
        elements["xboundary.rfeedback"]
        + rheostat("P3", elements, *contacts)
        + elements["xboundary.rlink"]
    )
