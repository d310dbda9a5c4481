"""The elements of a channel, by their names in the netlist: what its behaviour is computed from."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from analog_card.design import AMPLIFIERS, Design, DifferentiatorParts

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


def nominal_elements(design: Design, relay: bool = False) -> dict[str, float]:
    """Return the values of all elements of a channel that its behaviour depends on.

    Parameters
    ----------
    design : Design
        The card.
    relay : bool, optional
        Whether the feedback of the boundary-layer amplifier is opened.

    Returns
    -------
    dict of str to float
        Values in SI by the names of the elements in ``netlists/stages/channel.lib``, without the
        name of the channel.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> nominal_elements(load_design())["xtaps.xvelocity.rfeedback"]
    120000.0
    """
    parts, turned = design.soldered, design.turned
    surface, layer, limiter = (
        parts.surface_amplifier,
        parts.boundary_layer_amplifier,
        parts.output_limiter,
    )
    values = {
        offset_name(name): parts.operational_amplifier.input_offset_voltage for name in AMPLIFIERS
    }
    for stage, place in DIFFERENTIATORS.items():
        stage_parts = getattr(parts, f"{stage}_differentiator")
        values |= {
            f"{place}.cinput": stage_parts.capacitance,
            f"{place}.rfeedback": stage_parts.resistance,
            f"{place}.rseries": stage_parts.series_resistance,
            f"{place}.cfeedback": stage_parts.feedback_capacitance,
            f"{place}.rbias": stage_parts.bias_resistance,
        }
    for name in ("rdisplacement", "rground", "rdemand", "rfeedback"):
        values[f"xdifference.{name}"] = parts.difference_amplifier.resistance
    for name in ("rinput", "rfeedback"):
        values[f"xinverter.{name}"] = parts.inverter.resistance
    values |= {
        "xsurface.xdisplacement.rinput": surface.displacement_resistance,
        "xsurface.xvelocity.rinput": surface.velocity_resistance,
        "xsurface.racceleration": surface.acceleration_resistance,
        "xsurface.rfeedback": surface.feedback_resistance,
        "xboundary.rground": layer.ground_resistance,
        "xboundary.rfeedback": layer.feedback_resistance,
        "xboundary.rlink": LINK_OPEN if relay else LINK_CLOSED,
        "xlimiter.rclamp": limiter.clamp_resistance,
    }
    for zener in ZENERS:
        values[zener] = zener_voltage(design)
    for name, track, position in (
        ("P1", surface.displacement_potentiometer, turned.displacement_weight),
        ("P2", surface.velocity_potentiometer, turned.velocity_weight),
        ("P3", layer.potentiometer, turned.boundary_layer),
        ("P4", limiter.potentiometer, turned.level),
    ):
        place = POTENTIOMETERS[name]
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
