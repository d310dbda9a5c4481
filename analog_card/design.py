"""What a card consists of: the parts soldered on it and the settings of its potentiometers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


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
    potentiometer : float
        Track of P4, across the clamp, its wiper into a follower [ohm].
    """

    clamp_resistance: float = _quantity("ohm")
    clamp_level: float = _quantity("V")
    potentiometer: float = _quantity("ohm")


@dataclass(frozen=True)
class OperationalAmplifier:
    """Typical data-sheet figures of the op-amp, the same for all on the card.

    Attributes
    ----------
    gain_bandwidth, slew_rate, open_loop_gain : float
        [Hz], [V/s], [V/V].
    input_offset_voltage, bias_current : float
        [V], [A].
    input_resistance, input_capacitance, output_resistance : float
        [ohm], [F], [ohm].
    positive_swing, negative_swing : float
        Largest output into 2 kohm, above and below ground [V].
    source_limit, sink_limit : float
        Short-circuit currents [A].
    supply : float
        Supply voltage on each side, at which the figures hold [V].
    """

    gain_bandwidth: float = _quantity("Hz")
    slew_rate: float = _quantity("V/s")
    open_loop_gain: float = _quantity("")
    input_offset_voltage: float = _quantity("V", "any")
    bias_current: float = _quantity("A", "not negative")
    input_resistance: float = _quantity("ohm")
    input_capacitance: float = _quantity("F")
    output_resistance: float = _quantity("ohm")
    positive_swing: float = _quantity("V")
    negative_swing: float = _quantity("V")
    source_limit: float = _quantity("A")
    sink_limit: float = _quantity("A")
    supply: float = _quantity("V")


@dataclass(frozen=True)
class Soldered:
    """Everything that takes a soldering iron to change."""

    velocity_differentiator: DifferentiatorParts
    acceleration_differentiator: DifferentiatorParts
    surface_amplifier: SurfaceAmplifier
    boundary_layer_amplifier: BoundaryLayerAmplifier
    output_limiter: OutputLimiter
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
        """Return the values of the parts by their parameter names in the netlists."""
        parts, amplifier = self.soldered, self.soldered.operational_amplifier
        figures = {**vars(amplifier)}
        offset = figures.pop("input_offset_voltage")
        values = {f"ca3140_{name}": value for name, value in figures.items()}
        for stage, differentiator in (
            ("velocity", parts.velocity_differentiator),
            ("acceleration", parts.acceleration_differentiator),
        ):
            values |= {f"{stage}_{name}": value for name, value in vars(differentiator).items()}
            values[f"{stage}_offset"] = offset
        return values
