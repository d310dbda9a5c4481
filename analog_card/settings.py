"""Where each of the four potentiometers has to stand, and what it can reach."""

from analog_card.design import Design
from analog_card.errors import InputError
from analog_card.figures import amplifier_gain, card_figures, clamp_division
from analog_card.potentiometer import fraction_for_gain, loaded_gain
from analog_card.quantities import as_text

_FAST_RANGE = (
    "set the fast range (recommended card: settling times from 0.05 s to 0.01 s): "
    "acceleration_resistance 1 Mohm, displacement_resistance 39 kohm, velocity_resistance "
    "100 kohm in [soldered.surface_amplifier]"
)


def largest_weights(design: Design) -> tuple[float, float]:
    """Return the largest state weights c1 [1/s2] and c2 [1/s], P1 and P2 at their tops."""
    parts, figures = design.soldered.surface_amplifier, card_figures(design)
    unit = figures.weight_acceleration * figures.rc_acceleration
    displacement = loaded_gain(
        1.0,
        parts.displacement_potentiometer,
        parts.displacement_resistance,
        parts.feedback_resistance,
    )
    velocity = loaded_gain(
        1.0, parts.velocity_potentiometer, parts.velocity_resistance, parts.feedback_resistance
    )
    return displacement / (unit * figures.rc_velocity), velocity / unit


def displacement_setting(weight: float, design: Design) -> float:
    """Return the fraction of travel of P1 for a state weight c1 [1/s2].

    Raises
    ------
    InputError
        When it is out of reach.
    """
    parts, figures = design.soldered.surface_amplifier, card_figures(design)
    return _weight_setting(
        weight,
        1 / (figures.weight_acceleration * figures.rc_velocity * figures.rc_acceleration),
        parts.displacement_potentiometer,
        parts.displacement_resistance,
        parts.feedback_resistance,
        ("P1 (displacement weight)", "c1", "1/s2", "displacement_resistance"),
    )


def velocity_setting(weight: float, design: Design) -> float:
    """Return the fraction of travel of P2 for a state weight c2 [1/s].

    Raises
    ------
    InputError
        When it is out of reach.
    """
    parts, figures = design.soldered.surface_amplifier, card_figures(design)
    return _weight_setting(
        weight,
        1 / (figures.weight_acceleration * figures.rc_acceleration),
        parts.velocity_potentiometer,
        parts.velocity_resistance,
        parts.feedback_resistance,
        ("P2 (velocity weight)", "c2", "1/s", "velocity_resistance"),
    )


def boundary_layer_at(fraction: float, design: Design) -> float:
    """Return the boundary layer with P3 at a fraction of travel [m/s2].

    Notes
    -----
    P4 takes the same share of the gain and of the level, so it has no part in it.
    """
    clamp = design.soldered.output_limiter.clamp_level
    gain = amplifier_gain(design, fraction) * clamp_division(design)
    return clamp / (gain * card_figures(design).surface_scale)


def boundary_layer_setting(boundary_layer: float, design: Design) -> float:
    """Return the fraction of travel of P3 for a boundary layer [m/s2].

    Raises
    ------
    InputError
        When it is out of reach.
    """
    parts = design.soldered.boundary_layer_amplifier
    narrowest, widest = boundary_layer_at(1.0, design), boundary_layer_at(0.0, design)
    gain = amplifier_gain(design, 0.0) * widest / boundary_layer
    feedback = (gain - 1) * parts.ground_resistance
    fraction = (feedback - parts.feedback_resistance) / parts.potentiometer
    if 0 <= fraction <= 1:
        return fraction
    if fraction > 1:
        needed = as_text(feedback - parts.feedback_resistance, "ohm", 3)
        advice = f"solder a potentiometer of at least {needed}, or open its feedback for a relay"
    elif feedback > 0:
        advice = f"solder feedback_resistance of at most {as_text(feedback, 'ohm', 3)}"
    else:
        advice = "an amplifier of this kind cannot attenuate; ask for less"
    if boundary_layer / 1000 >= narrowest and fraction < 0:
        advice += f". If mm/s2 was meant, as in the thesis, write '{boundary_layer:g} mm/s2'"
    raise InputError(
        f"P3 (boundary layer) cannot reach {boundary_layer:.4g} m/s2; with this card it reaches "
        f"{narrowest:.3g} to {widest:.3g} m/s2: {advice}"
    )


def level_setting(level: float, design: Design) -> float:
    """Return the fraction of travel of P4 for an output level [V].

    Raises
    ------
    InputError
        When it is out of reach.
    """
    clamp = design.soldered.output_limiter.clamp_level
    if level > clamp:
        raise InputError(
            f"P4 (level) cannot reach {level:.4g} V; with this card it reaches 0 to {clamp:.4g} V: "
            "solder zeners with a higher clamp_level"
        )
    return level / clamp


def _weight_setting(
    weight: float,
    weight_per_gain: float,
    track: float,
    resistance: float,
    feedback: float,
    words: tuple[str, str, str, str],
) -> float:
    gain = weight / weight_per_gain
    fraction = fraction_for_gain(gain, track, resistance, feedback)
    if fraction > 1:
        name, symbol, unit, resistor = words
        most = loaded_gain(1.0, track, resistance, feedback) * weight_per_gain
        raise InputError(
            f"{name} cannot reach {symbol} = {weight:.4g} {unit}; with this card it reaches 0 to "
            f"{most:.4g} {unit}: ask for a longer settling time, solder {resistor} of at most "
            f"{as_text(feedback / gain, 'ohm', 3)}, or {_FAST_RANGE}"
        )
    return fraction
