"""What a card consists of: the parts soldered on it and the settings of its potentiometers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

# The op-amps of a channel, by the names of their offset voltages in the netlists.
AMPLIFIERS = (
    "transducer_buffer",
    "demand_buffer",
    "velocity",
    "acceleration",
    "difference",
    "inverter",
    "surface",
    "boundary_layer",
    "limiter",
)


def _quantity(unit: str, allowed: str = "positive") -> Any:
    """Declare a field with its SI unit and its range: positive, not negative, any or fraction."""
    return field(metadata={"unit": unit, "allowed": allowed})


@dataclass(frozen=True)
class Transducer:
    """The displacement transducer that the card listens to.

    Attributes
    ----------
    full_scale_voltage : float
        Output at full scale [V].
    full_scale_displacement : float
        Displacement at full scale [m].
    """

    full_scale_voltage: float = _quantity("V")
    full_scale_displacement: float = _quantity("m")

    @property
    def gain(self) -> float:
        """Volts for each metre [V/m]."""
        return self.full_scale_voltage / self.full_scale_displacement


@dataclass(frozen=True)
class DifferentiatorParts:
    """One differentiator stage, thesis (9.3).

    Attributes
    ----------
    capacitance, resistance : float
        Input capacitor [F] and feedback resistor [ohm]; their product is the gain.
    series_resistance, feedback_capacitance : float
        What limits the bandwidth: in series with the capacitor [ohm], across the resistor [F].
    bias_resistance, bias_capacitance : float
        At the non-inverting input, against the drop of the bias current [ohm], [F].
    """

    capacitance: float = _quantity("F")
    resistance: float = _quantity("ohm")
    series_resistance: float = _quantity("ohm")
    feedback_capacitance: float = _quantity("F")
    bias_resistance: float = _quantity("ohm")
    bias_capacitance: float = _quantity("F")


@dataclass(frozen=True)
class InputBuffer:
    """The followers of transducer and demand, and of the output.

    Attributes
    ----------
    series_resistance : float
        Ahead of the input [ohm].
    """

    series_resistance: float = _quantity("ohm")


@dataclass(frozen=True)
class Tap:
    """The connectors of velocity and acceleration.

    Attributes
    ----------
    resistance : float
        Between op-amp and connector, against the capacitance of a cable [ohm].
    """

    resistance: float = _quantity("ohm")


@dataclass(frozen=True)
class EqualResistors:
    """An amplifier of gain 1 that is made of equal resistors.

    Attributes
    ----------
    resistance : float
        Each of them [ohm].
    """

    resistance: float = _quantity("ohm")


@dataclass(frozen=True)
class SurfaceAmplifier:
    """The inverting amplifier that sums displacement, velocity and acceleration.

    Attributes
    ----------
    displacement_potentiometer, velocity_potentiometer : float
        Tracks of P1 and P2 [ohm].
    displacement_resistance, velocity_resistance, acceleration_resistance : float
        Input resistors R1, R2 (behind the wipers) and R3 [ohm].
    feedback_resistance : float
        Feedback resistor Rf [ohm].
    """

    displacement_potentiometer: float = _quantity("ohm")
    displacement_resistance: float = _quantity("ohm")
    velocity_potentiometer: float = _quantity("ohm")
    velocity_resistance: float = _quantity("ohm")
    acceleration_resistance: float = _quantity("ohm")
    feedback_resistance: float = _quantity("ohm")


@dataclass(frozen=True)
class BoundaryLayerAmplifier:
    """The non-inverting amplifier whose gain sets the boundary layer.

    Attributes
    ----------
    ground_resistance, feedback_resistance : float
        From the inverting input to ground, and the fixed part of the feedback [ohm].
    potentiometer : float
        P3, a variable resistor in series with the fixed part [ohm].
    """

    ground_resistance: float = _quantity("ohm")
    feedback_resistance: float = _quantity("ohm")
    potentiometer: float = _quantity("ohm")


@dataclass(frozen=True)
class OutputLimiter:
    """The clamp and the potentiometer that set the largest output.

    Attributes
    ----------
    clamp_resistance : float
        In series ahead of the clamp [ohm].
    clamp_level : float
        Voltage at which it clamps, either sign [V].
    zener_resistance : float
        Differential resistance of each zener [ohm].
    potentiometer : float
        Track of P4, across the clamp, its wiper into a follower [ohm].
    """

    clamp_resistance: float = _quantity("ohm")
    clamp_level: float = _quantity("V")
    zener_resistance: float = _quantity("ohm")
    potentiometer: float = _quantity("ohm")


@dataclass(frozen=True)
class PotentiometerContacts:
    """What every potentiometer has beside its track.

    Attributes
    ----------
    end_resistance : float
        At each end of the track [ohm].
    wiper_resistance : float
        Of the wiper [ohm].
    """

    end_resistance: float = _quantity("ohm")
    wiper_resistance: float = _quantity("ohm")


@dataclass(frozen=True)
class Supply:
    """Leads and decoupling of each rail.

    Attributes
    ----------
    lead_resistance : float
        From the power supply to the card [ohm].
    bulk_capacitance, bulk_resistance : float
        The electrolytic capacitor at the entry [F] and its series resistance [ohm].
    ceramic_capacitance : float
        Beside each op-amp [F].
    """

    lead_resistance: float = _quantity("ohm")
    bulk_capacitance: float = _quantity("F")
    bulk_resistance: float = _quantity("ohm")
    ceramic_capacitance: float = _quantity("F")


@dataclass(frozen=True)
class OperationalAmplifier:
    """Typical data-sheet figures of the op-amp, the same for all on the card.

    Attributes
    ----------
    gain_bandwidth, second_pole, slew_rate, open_loop_gain : float
        [Hz], [Hz], [V/s], [V/V].
    input_offset_voltage, bias_current, offset_current : float
        [V], [A], [A].
    input_resistance, input_capacitance, output_resistance : float
        [ohm], [F], [ohm].
    common_mode_rejection, supply_rejection : float
        Common voltage at the inputs, and voltage between the supplies, for each volt of offset
        that they make [V/V].
    noise_1_kilohertz, noise_10_kilohertz : float
        Voltage noise in a bandwidth of 1 Hz at these frequencies [V].
    positive_swing, negative_swing : float
        Largest output into 2 kohm, above and below ground [V].
    source_limit, sink_limit : float
        Short-circuit currents [A].
    supply_current : float
        Without load [A].
    supply : float
        Supply voltage on each side, at which the figures hold [V].
    """

    gain_bandwidth: float = _quantity("Hz")
    second_pole: float = _quantity("Hz")
    slew_rate: float = _quantity("V/s")
    open_loop_gain: float = _quantity("")
    input_offset_voltage: float = _quantity("V", "any")
    bias_current: float = _quantity("A", "not negative")
    offset_current: float = _quantity("A", "any")
    input_resistance: float = _quantity("ohm")
    input_capacitance: float = _quantity("F")
    output_resistance: float = _quantity("ohm")
    common_mode_rejection: float = _quantity("")
    supply_rejection: float = _quantity("")
    noise_1_kilohertz: float = _quantity("V")
    noise_10_kilohertz: float = _quantity("V")
    positive_swing: float = _quantity("V")
    negative_swing: float = _quantity("V")
    source_limit: float = _quantity("A")
    sink_limit: float = _quantity("A")
    supply_current: float = _quantity("A", "not negative")
    supply: float = _quantity("V")

    def netlist_parameters(self) -> dict[str, float]:
        """Return the figures by their parameter names in the netlists of the op-amp."""
        figures = {f"ca3140_{name}": value for name, value in vars(self).items()}
        del figures["ca3140_input_offset_voltage"]  # each stage has its own
        return figures


@dataclass(frozen=True)
class Soldered:
    """Everything that takes a soldering iron to change."""

    input_buffer: InputBuffer
    velocity_differentiator: DifferentiatorParts
    acceleration_differentiator: DifferentiatorParts
    tap: Tap
    difference_amplifier: EqualResistors
    inverter: EqualResistors
    surface_amplifier: SurfaceAmplifier
    boundary_layer_amplifier: BoundaryLayerAmplifier
    output_limiter: OutputLimiter
    potentiometer_contacts: PotentiometerContacts
    supply: Supply
    operational_amplifier: OperationalAmplifier


@dataclass(frozen=True)
class Turned:
    """Settings of the potentiometers, as fraction of travel from 0 to 1.

    Attributes
    ----------
    displacement_weight, velocity_weight, boundary_layer, level : float
        P1, P2, P3 and P4.
    """

    displacement_weight: float = _quantity("", "fraction")
    velocity_weight: float = _quantity("", "fraction")
    boundary_layer: float = _quantity("", "fraction")
    level: float = _quantity("", "fraction")


@dataclass(frozen=True)
class Design:
    """A card: transducer, parts and settings, all in SI units.

    Attributes
    ----------
    title : str
        What it is called.
    transducer : Transducer
        What it listens to.
    soldered : Soldered
        Its parts.
    turned : Turned
        Its settings.
    sources : mapping of str to str
        Where a value comes from, by its dotted name, such as ``"turned.level"``.
    """

    title: str
    transducer: Transducer
    soldered: Soldered
    turned: Turned
    sources: Mapping[str, str] = field(default_factory=dict, compare=False)

    def netlist_parameters(self) -> dict[str, float]:
        """Return all values by their parameter names in the netlists.

        Every netlist that includes ``values.lib`` and an op-amp has all of them; those of the
        op-amp's benches only have `OperationalAmplifier.netlist_parameters`.
        """
        parts, turned = self.soldered, self.turned
        sections = {
            "buffer": parts.input_buffer,
            "velocity": parts.velocity_differentiator,
            "acceleration": parts.acceleration_differentiator,
            "tap": parts.tap,
            "difference": parts.difference_amplifier,
            "inverter": parts.inverter,
            "surface": parts.surface_amplifier,
            "boundary_layer": parts.boundary_layer_amplifier,
            "limiter": parts.output_limiter,
            "potentiometer": parts.potentiometer_contacts,
            "supply": parts.supply,
        }
        values = parts.operational_amplifier.netlist_parameters() | {
            f"{stage}_{name}": value
            for stage, section in sections.items()
            for name, value in vars(section).items()
        }
        offset = parts.operational_amplifier.input_offset_voltage
        values |= {f"{stage}_offset": offset for stage in AMPLIFIERS}
        return values | {
            "displacement_weight": turned.displacement_weight,
            "velocity_weight": turned.velocity_weight,
            "boundary_layer_setting": turned.boundary_layer,
            "level_setting": turned.level,
        }
