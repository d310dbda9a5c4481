"""The elements of a channel, by their names in the netlist: what its behaviour is computed from."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from analog_card.design import (
    AMPLIFIER_FIGURES,
    AMPLIFIERS,
    Design,
    DifferentiatorParts,
    OperationalAmplifier,
    Turned,
)
from analog_card.design_tolerances import REFERENCE_TEMPERATURE

CHANNEL = "xone"

# Where each op-amp of a channel sits.
PLACES = dict(
    zip(
        AMPLIFIERS,
        (
            "xtransducer",
            "xdemand",
            "xtaps.xvelocity",
            "xtaps.xacceleration",
            "xdifference",
            "xinverter",
            "xsurface",
            "xboundary",
            "xlimiter.xfollower",
        ),
        strict=True,
    )
)
DIFFERENTIATORS = {"velocity": "xtaps.xvelocity", "acceleration": "xtaps.xacceleration"}
POTENTIOMETERS = {
    "P1": "xsurface.xdisplacement.xpotentiometer",
    "P2": "xsurface.xvelocity.xpotentiometer",
    "P3": "xboundary.xpotentiometer",
    "P4": "xlimiter.xpotentiometer",
}
_SETTINGS = dict(zip(POTENTIOMETERS, (item.name for item in fields(Turned)), strict=True))
# Where in `analog_card.design.Soldered` the value of an element and of a track is.
PARTS = {
    f"{place}.{element}": (f"{stage}_differentiator", part)
    for stage, place in DIFFERENTIATORS.items()
    for element, part in (
        ("cinput", "capacitance"),
        ("rfeedback", "resistance"),
        ("rseries", "series_resistance"),
        ("cfeedback", "feedback_capacitance"),
    )
} | {
    "xdifference.rdisplacement": ("difference_amplifier", "resistance"),
    "xdifference.rground": ("difference_amplifier", "resistance"),
    "xdifference.rdemand": ("difference_amplifier", "resistance"),
    "xdifference.rfeedback": ("difference_amplifier", "resistance"),
    "xinverter.rinput": ("inverter", "resistance"),
    "xinverter.rfeedback": ("inverter", "resistance"),
    "xsurface.xdisplacement.rinput": ("surface_amplifier", "displacement_resistance"),
    "xsurface.xvelocity.rinput": ("surface_amplifier", "velocity_resistance"),
    "xsurface.racceleration": ("surface_amplifier", "acceleration_resistance"),
    "xsurface.rfeedback": ("surface_amplifier", "feedback_resistance"),
    "xboundary.rground": ("boundary_layer_amplifier", "ground_resistance"),
    "xboundary.rfeedback": ("boundary_layer_amplifier", "feedback_resistance"),
    "xlimiter.rclamp": ("output_limiter", "clamp_resistance"),
}
TRACKS = {
    "P1": ("surface_amplifier", "displacement_potentiometer"),
    "P2": ("surface_amplifier", "velocity_potentiometer"),
    "P3": ("boundary_layer_amplifier", "potentiometer"),
    "P4": ("output_limiter", "potentiometer"),
}
ZENERS = ("xlimiter.dupper[bv]", "xlimiter.dlower[bv]")
# The feedback of the boundary-layer amplifier closed by its jumper, and opened for the relay.
LINK_CLOSED, LINK_OPEN = 1e-3, 10e6
# As the netlist of the potentiometer has it: a wiper at its end leaves this much of the track.
_LEAST_TRACK = 1e-3
# Thermal voltage and saturation current of the zeners in netlists/stages/output-limiter.lib.
THERMAL_VOLTAGE, SATURATION_CURRENT = 0.025865, 1e-14

Elements = Mapping[str, float]


@dataclass(frozen=True)
class WiperSource:
    """What a potentiometer is for a load at its wiper.

    Attributes
    ----------
    fraction : float
        Open-circuit voltage for each volt at the top [V/V].
    resistance : float
        Source resistance at the wiper [ohm].
    track : float
        Resistance from top to bottom [ohm].
    """

    fraction: float
    resistance: float
    track: float


def offset_name(amplifier: str) -> str:
    """Return the name of the element that holds an op-amp's offset voltage."""
    return f"{PLACES[amplifier]}.xamplifier.xcore.voffset"


def figure_name(amplifier: str, figure: str) -> str:
    """Return the name of a figure of one op-amp among the elements."""
    return f"{PLACES[amplifier]}.xamplifier[{figure}]"


def amplifier_figures(
    amplifier: str, elements: Elements, nominal: OperationalAmplifier
) -> OperationalAmplifier:
    """Return the figures of one op-amp; those not among the elements are the nominal ones."""
    names = {figure: figure_name(amplifier, figure) for figure in AMPLIFIER_FIGURES}
    found = {figure: elements[name] for figure, name in names.items() if name in elements}
    return replace(nominal, **found)


def nominal_elements(
    design: Design, relay: bool = False, temperature: float = REFERENCE_TEMPERATURE
) -> dict[str, float]:
    """Return the values of all elements of a channel that its behaviour depends on.

    Parameters
    ----------
    design : Design
        The card.
    relay : bool, optional
        Whether the feedback of the boundary-layer amplifier is opened.
    temperature : float, optional
        Of the card [K].

    Returns
    -------
    dict of str to float
        Values in SI by the names of the elements in ``netlists/stages/channel.lib``, without the
        name of the channel; figures of an op-amp in brackets behind its name.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> nominal_elements(load_design())["xtaps.xvelocity.rfeedback"]
    120000.0
    """
    warmer = temperature - REFERENCE_TEMPERATURE
    amplifier = design.soldered.operational_amplifier
    offset = amplifier.input_offset_voltage + amplifier.offset_drift * warmer
    values = {offset_name(name): offset for name in AMPLIFIERS}
    for name in AMPLIFIERS:
        values |= {figure_name(name, each): getattr(amplifier, each) for each in AMPLIFIER_FIGURES}
    for name, (section, part) in PARTS.items():
        value = getattr(getattr(design.soldered, section), part)
        values[name] = value * design.part_tolerance(section, part).drift(temperature)
    values["xboundary.rlink"] = LINK_OPEN if relay else LINK_CLOSED
    for stage, place in DIFFERENTIATORS.items():
        resistance = getattr(design.soldered, f"{stage}_differentiator").bias_resistance
        values[f"{place}.rbias"] = resistance * design.tolerances.resistor.drift(temperature)
    zener = design.tolerances.zener
    breakdown = zener_voltage(design) * (1 + zener.temperature_coefficient * warmer)
    # One of the pair breaks down, the other conducts: both drifts are put into the first.
    values |= dict.fromkeys(ZENERS, breakdown + zener.forward_drift * warmer)
    for name, (section, part) in TRACKS.items():
        track = getattr(getattr(design.soldered, section), part)
        track *= design.part_tolerance(section, part).drift(temperature)
        position, place = getattr(design.turned, _SETTINGS[name]), POTENTIOMETERS[name]
        values[f"{place}.rupper"] = max(track * (1 - position), _LEAST_TRACK)
        values[f"{place}.rlower"] = max(track * position, _LEAST_TRACK)
    return values


def differentiator_parts(stage: str, elements: Elements, design: Design) -> DifferentiatorParts:
    """Return the parts of the ``velocity`` or ``acceleration`` differentiator."""
    place = DIFFERENTIATORS[stage]
    return DifferentiatorParts(
        capacitance=elements[f"{place}.cinput"],
        resistance=elements[f"{place}.rfeedback"],
        series_resistance=elements[f"{place}.rseries"],
        feedback_capacitance=elements[f"{place}.cfeedback"],
        bias_resistance=elements[f"{place}.rbias"],
        bias_capacitance=getattr(design.soldered, f"{stage}_differentiator").bias_capacitance,
    )


def wiper_source(name: str, elements: Elements, end: float, wiper: float) -> WiperSource:
    """Return what a potentiometer is for a load at its wiper.

    Parameters
    ----------
    name : str
        ``P1`` to ``P4``.
    elements : mapping of str to float
        From `nominal_elements`.
    end, wiper : float
        Resistance at each end of the track, and of the wiper [ohm].
    """
    upper = elements[f"{POTENTIOMETERS[name]}.rupper"] + end
    lower = elements[f"{POTENTIOMETERS[name]}.rlower"] + end
    track = upper + lower
    return WiperSource(lower / track, upper * lower / track + wiper, track)


def rheostat(name: str, elements: Elements, end: float, wiper: float) -> float:
    """Return the resistance of a potentiometer with wiper and top joined [ohm]."""
    upper = elements[f"{POTENTIOMETERS[name]}.rupper"] + end
    lower = elements[f"{POTENTIOMETERS[name]}.rlower"] + end
    return lower + (upper * wiper / (upper + wiper) if wiper else 0.0)


def zener_current(design: Design) -> float:
    """Return what the zeners carry with the op-amp ahead at its positive swing [A]."""
    parts, amplifier = design.soldered.output_limiter, design.soldered.operational_amplifier
    available = (amplifier.positive_swing - parts.clamp_level) / parts.clamp_resistance
    return max(available - parts.clamp_level / parts.potentiometer, 0.1e-3)


def zener_voltage(design: Design) -> float:
    """Return the breakdown voltage of each zener with which the pair clamps at its level [V]."""
    parts, current = design.soldered.output_limiter, zener_current(design)
    forward = THERMAL_VOLTAGE * math.log(current / SATURATION_CURRENT)
    return parts.clamp_level - forward - 2 * parts.zener_resistance * current
