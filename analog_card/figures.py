"""The card in a dozen numbers, as a behavioural model of the closed loop needs them."""

import math
from dataclasses import dataclass

from analog_card.design import Design, DifferentiatorParts
from analog_card.potentiometer import loaded_gain


@dataclass(frozen=True)
class CardFigures:
    """Nominal figures of a card: gains, filters and limits, without tolerances and offsets.

    Attributes
    ----------
    transducer_gain : float
        Transducer voltage for each metre [V/m].
    rc_velocity, rc_acceleration : float
        Gain of each differentiator: V1 = -s rc_velocity Vx and V2 = -s rc_acceleration V1, each
        times its filter 1/((1 + s/w1)(1 + s/w2)) [s].
    velocity_breaks, acceleration_breaks : tuple of float
        w1 / 2 pi and w2 / 2 pi of each: series resistor first, feedback capacitor second [Hz].
    weight_displacement, weight_velocity, weight_acceleration : float
        Surface = weight_displacement (Vd - Vx) + weight_velocity V1 - weight_acceleration V2,
        in volts, Vd being the demand as transducer voltage [V/V].
    surface_limit : float
        Largest surface voltage, either sign: the smaller swing of the op-amp [V].
    output_gain : float
        Output = output_gain times surface, limited to +-level [V/V].
    level : float
        Largest output [V].
    """

    transducer_gain: float
    rc_velocity: float
    rc_acceleration: float
    velocity_breaks: tuple[float, float]
    acceleration_breaks: tuple[float, float]
    weight_displacement: float
    weight_velocity: float
    weight_acceleration: float
    surface_limit: float
    output_gain: float
    level: float

    @property
    def surface_scale(self) -> float:
        """Surface volts for each m/s2 of sigma with c3 = 1 [V s2/m]."""
        return (
            self.transducer_gain
            * self.weight_acceleration
            * self.rc_velocity
            * self.rc_acceleration
        )


def card_figures(design: Design) -> CardFigures:
    """Return the nominal figures of a card as it is soldered and turned.

    Parameters
    ----------
    design : Design
        The card.

    Returns
    -------
    CardFigures
        Its figures.

    Notes
    -----
    Ideal op-amps, real potentiometers: P1 and P2 are loaded by the resistors behind them, the
    resistor of the clamp and P4 divide the output below the clamp level.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> figures = card_figures(load_design())
    >>> round(figures.rc_velocity, 6), round(figures.surface_scale, 6), round(figures.level, 3)
    (0.012, 0.048, 5.0)
    """
    parts, turned = design.soldered, design.turned
    surface, limiter = parts.surface_amplifier, parts.output_limiter
    amplifier = parts.operational_amplifier
    return CardFigures(
        transducer_gain=design.transducer.gain,
        rc_velocity=time_constant(parts.velocity_differentiator),
        rc_acceleration=time_constant(parts.acceleration_differentiator),
        velocity_breaks=break_frequencies(parts.velocity_differentiator),
        acceleration_breaks=break_frequencies(parts.acceleration_differentiator),
        weight_displacement=loaded_gain(
            turned.displacement_weight,
            surface.displacement_potentiometer,
            surface.displacement_resistance,
            surface.feedback_resistance,
        ),
        weight_velocity=loaded_gain(
            turned.velocity_weight,
            surface.velocity_potentiometer,
            surface.velocity_resistance,
            surface.feedback_resistance,
        ),
        weight_acceleration=surface.feedback_resistance / surface.acceleration_resistance,
        surface_limit=min(amplifier.positive_swing, amplifier.negative_swing),
        output_gain=amplifier_gain(design, turned.boundary_layer)
        * clamp_division(design)
        * turned.level,
        level=limiter.clamp_level * turned.level,
    )


def time_constant(parts: DifferentiatorParts) -> float:
    """Return the gain of a differentiator at low frequency, R C [s]."""
    return parts.resistance * parts.capacitance


def break_frequencies(parts: DifferentiatorParts) -> tuple[float, float]:
    """Return the two break frequencies of a differentiator, thesis (9.4) [Hz].

    Series resistor with input capacitor first, feedback resistor with feedback capacitor second.
    """
    series = parts.series_resistance * parts.capacitance
    feedback = parts.resistance * parts.feedback_capacitance
    return 1 / (2 * math.pi * series), 1 / (2 * math.pi * feedback)


def amplifier_gain(design: Design, fraction: float) -> float:
    """Return the gain of the boundary-layer amplifier with P3 at a fraction of travel [V/V]."""
    parts = design.soldered.boundary_layer_amplifier
    feedback = parts.feedback_resistance + fraction * parts.potentiometer
    return 1 + feedback / parts.ground_resistance


def clamp_division(design: Design) -> float:
    """Return what the clamp's resistor and P4 leave of a voltage below the clamp level [V/V]."""
    parts = design.soldered.output_limiter
    return parts.potentiometer / (parts.potentiometer + parts.clamp_resistance)
