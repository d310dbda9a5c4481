"""The behavioural card: what every stage of a channel does, as numbers, with each imperfection."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

import numpy as np

from analog_card.behaviour_elements import (
    Elements,
    differentiator_parts,
    nominal_elements,
    offset_name,
    rheostat,
    wiper_source,
)
from analog_card.behaviour_limiter import LimiterCurve, limiter_curve, output_drop
from analog_card.design import AMPLIFIERS, Design, DifferentiatorParts, OperationalAmplifier

# What an op-amp without the imperfection has: large enough to change nothing that can be measured,
# small enough for the arithmetic.
_UNLIMITED_BANDWIDTH, _UNLIMITED_GAIN = 1e11, 1e10
_NEGLIGIBLE_RESISTANCE = 1e-9


@dataclass(frozen=True)
class Imperfections:
    """What of the real card its behaviour has; each can be left out alone.

    Attributes
    ----------
    gain_bandwidth : bool
        Finite gain-bandwidth product and open-loop gain of every op-amp; it is what delays the
        relay.
    slew_rate : bool
        Limited slew rate of the differentiators and of the boundary-layer amplifier.
    offset_voltage, bias_current : bool
        Of every op-amp.
    output_resistance : bool
        Of the op-amps of the differentiators.
    saturation : bool
        Asymmetric swing of differentiators, inverter, surface and boundary-layer amplifier, with
        the recovery from it. Without it the last two stop at the smaller swing, either sign.
    common_mode : bool
        Finite common-mode rejection of buffers and difference amplifier.
    potentiometer_contacts : bool
        End and wiper resistances. The load on the wipers is never left out.
    zener_knee : bool
        The knee and the differential resistance of the zeners; without them a hard limit.

    Examples
    --------
    >>> Imperfections.none().offset_voltage, Imperfections().without("slew_rate").slew_rate
    (False, False)
    """

    gain_bandwidth: bool = True
    slew_rate: bool = True
    offset_voltage: bool = True
    bias_current: bool = True
    output_resistance: bool = True
    saturation: bool = True
    common_mode: bool = True
    potentiometer_contacts: bool = True
    zener_knee: bool = True

    @classmethod
    def none(cls) -> "Imperfections":
        """Return the ideal card's."""
        return cls(**{item.name: False for item in fields(cls)})

    @classmethod
    def only(cls, *names: str) -> "Imperfections":
        """Return those named and no others."""
        return replace(cls.none(), **dict.fromkeys(names, True))

    def without(self, *names: str) -> "Imperfections":
        """Return these without those named."""
        return replace(self, **dict.fromkeys(names, False))

    @property
    def any(self) -> bool:
        """Whether there is any."""
        return any(vars(self).values())


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
    amplifier : OperationalAmplifier
        The op-amps, at their ideal values where an imperfection is left out.
    speed : float
        2 pi times their gain-bandwidth product [1/s].
    velocity, acceleration : DifferentiatorParts
        The differentiators.
    loads : tuple of float
        Of velocity and acceleration tap, by inverter and surface amplifier [ohm].
    differentiator_offsets : ndarray, shape (2,)
        At their non-inverting inputs, with the drop of the bias current [V].
    bias_current : float
        Into their inverting inputs [A].
    buffer_gain : float
        Of both input buffers [V/V].
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
    lags : ndarray, shape (5,)
        Time constants of buffer, difference amplifier, inverter, surface amplifier, boundary-layer
        amplifier, each its noise gain over the speed; the output follower has the first [s].
    swing : ndarray, shape (2,)
        Lowest and highest voltage inside the op-amps of the taps [V].
    rate_swing, surface_swing, comparator_swing : ndarray, shape (2,)
        Lowest and highest output of inverter, surface and boundary-layer amplifier under load [V].
    slew_rate : float
        [V/s].
    limiter : LimiterCurve
        Clamp and P4.
    control_offset : float
        Of the output follower [V].
    """

    amplifier: OperationalAmplifier
    speed: float
    velocity: DifferentiatorParts
    acceleration: DifferentiatorParts
    loads: tuple[float, float]
    differentiator_offsets: np.ndarray
    bias_current: float
    buffer_gain: float
    buffer_offsets: np.ndarray
    difference: np.ndarray
    inverter: np.ndarray
    surface: np.ndarray
    comparator_gain: float
    comparator_offset: float
    lags: np.ndarray
    swing: np.ndarray
    rate_swing: np.ndarray
    surface_swing: np.ndarray
    comparator_swing: np.ndarray
    slew_rate: float
    limiter: LimiterCurve
    control_offset: float


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
    elements = {**nominal_elements(design, card.relay), **card.elements}
    amplifier = _amplifier(design.soldered.operational_amplifier, with_)
    open_loop, speed = amplifier.open_loop_gain, 2 * math.pi * amplifier.gain_bandwidth
    bias = np.array([1.0, -1.0]) * amplifier.offset_current / 2 + amplifier.bias_current
    offsets = {
        name: elements[offset_name(name)] if with_.offset_voltage else 0.0 for name in AMPLIFIERS
    }
    common = 1 / amplifier.common_mode_rejection if with_.common_mode else 0.0
    contacts = _contacts(design, with_)
    velocity, acceleration = (
        differentiator_parts(stage, elements, design) for stage in ("velocity", "acceleration")
    )

    def settled(noise_gain: float) -> float:
        return 1 / (1 + noise_gain / open_loop)

    buffered = settled(1.0)
    drop = -bias[0] * design.soldered.input_buffer.series_resistance
    difference, difference_noise = _difference(elements, common, offsets["difference"], bias[1])
    inverter, inverter_noise = _inverter(elements, offsets["inverter"], bias[1])
    surface, surface_noise = _surface(elements, contacts, offsets["surface"], bias[1])
    feedback, ground = _feedback(elements, contacts), elements["xboundary.rground"]
    comparator = 1 + feedback / ground
    noise_gains = np.array([1.0, difference_noise, inverter_noise, surface_noise, comparator])
    full, symmetric = _swings(amplifier)
    curve = limiter_curve(
        design, elements, contacts, amplifier, feedback + ground, with_.zener_knee
    )
    unlimited = np.array([-math.inf, math.inf])
    return Stages(
        amplifier=amplifier,
        speed=speed,
        velocity=velocity,
        acceleration=acceleration,
        loads=(elements["xinverter.rinput"], elements["xsurface.racceleration"]),
        differentiator_offsets=np.array(
            [
                offsets["velocity"] - bias[0] * velocity.bias_resistance,
                offsets["acceleration"] - bias[0] * acceleration.bias_resistance,
            ]
        ),
        bias_current=float(bias[1]),
        buffer_gain=buffered * (1 + common),
        buffer_offsets=buffered
        * (np.array([offsets["transducer_buffer"], offsets["demand_buffer"]]) + drop),
        difference=difference * settled(difference_noise),
        inverter=inverter * settled(inverter_noise),
        surface=surface * settled(surface_noise),
        comparator_gain=comparator * settled(comparator),
        comparator_offset=offsets["boundary_layer"],
        lags=noise_gains / (1 + noise_gains / open_loop) / speed
        if with_.gain_bandwidth
        else np.zeros(5),
        swing=full if with_.saturation else unlimited,
        rate_swing=_loaded(full, _rate_load(elements, contacts), amplifier)
        if with_.saturation
        else unlimited,
        surface_swing=_loaded(full, elements["xsurface.rfeedback"], amplifier)
        if with_.saturation
        else symmetric,
        comparator_swing=curve.loaded(full) if with_.saturation else symmetric,
        slew_rate=amplifier.slew_rate,
        limiter=curve,
        control_offset=buffered * (offsets["limiter"] + drop),
    )


def _amplifier(amplifier: OperationalAmplifier, with_: Imperfections) -> OperationalAmplifier:
    """Return the op-amp with ideal figures for the imperfections left out."""
    ideal = {
        "gain_bandwidth": {
            "gain_bandwidth": _UNLIMITED_BANDWIDTH,
            "open_loop_gain": _UNLIMITED_GAIN,
        },
        "slew_rate": {"slew_rate": math.inf},
        "bias_current": {"bias_current": 0.0, "offset_current": 0.0},
        "output_resistance": {"output_resistance": _NEGLIGIBLE_RESISTANCE},
    }
    changes = [ideal[name] for name in ideal if not getattr(with_, name)]
    return replace(
        amplifier, **{name: value for change in changes for name, value in change.items()}
    )


def _contacts(design: Design, with_: Imperfections) -> tuple[float, float]:
    contacts = design.soldered.potentiometer_contacts
    if not with_.potentiometer_contacts:
        return 0.0, 0.0
    return contacts.end_resistance, contacts.wiper_resistance


def _swings(amplifier: OperationalAmplifier) -> tuple[np.ndarray, np.ndarray]:
    """Return the swing ahead of the output resistance, and the smaller figure on both sides.

    The data sheet's is into 2 kohm.
    """
    output = np.array([-amplifier.negative_swing, amplifier.positive_swing])
    full = output + output_drop(output / 2e3, amplifier)
    smaller = min(amplifier.positive_swing, amplifier.negative_swing)
    return full, np.array([-smaller, smaller])


def _loaded(swing: np.ndarray, load: float, amplifier: OperationalAmplifier) -> np.ndarray:
    """Return a swing behind the output resistance with a load to ground."""
    return swing / (1 + amplifier.output_resistance / load)


def _rate_load(elements: Elements, contacts: tuple[float, float]) -> float:
    return 1 / (
        1 / elements["xinverter.rfeedback"] + 1 / wiper_source("P2", elements, *contacts).track
    )


def _difference(
    elements: Elements, common: float, offset: float, bias: float
) -> tuple[np.ndarray, float]:
    plus = elements["xdifference.rground"] / (
        elements["xdifference.rground"] + elements["xdifference.rdisplacement"]
    )
    ratio = elements["xdifference.rfeedback"] / elements["xdifference.rdemand"]
    # The bias current of the non-inverting input meets the same resistance and cancels.
    rest = (1 + ratio) * offset
    gains = [(1 + common) * plus * (1 + ratio), -ratio, rest]
    return np.array(gains), 1 + ratio


def _inverter(elements: Elements, offset: float, bias: float) -> tuple[np.ndarray, float]:
    feedback = elements["xinverter.rfeedback"]
    ratio = feedback / elements["xinverter.rinput"]
    return np.array([-ratio, (1 + ratio) * offset + bias * feedback]), 1 + ratio


def _surface(
    elements: Elements, contacts: tuple[float, float], offset: float, bias: float
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
    return np.array([*-weights, noise_gain * offset + bias * feedback]), noise_gain


def _feedback(elements: Elements, contacts: tuple[float, float]) -> float:
    return (
        elements["xboundary.rfeedback"]
        + rheostat("P3", elements, *contacts)
        + elements["xboundary.rlink"]
    )
