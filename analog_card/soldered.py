"""The parts soldered on a card, by stage; each declares its unit and of what kind it is."""

from dataclasses import dataclass

from analog_card.design_fields import quantity
from analog_card.errors import InputError

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
# Figures in which one op-amp of a kind differs from the next, beside its offset voltage.
AMPLIFIER_FIGURES = (
    "bias_current",
    "open_loop_gain",
    "gain_bandwidth",
    "slew_rate",
    "positive_swing",
    "negative_swing",
)
# Noise at 1 kHz over that at 10 kHz, at the most: 1/f is 3.2, which leaves either point 26 % off.
_STEEPEST = 5.0


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

    capacitance: float = quantity("F", kind="capacitor")
    resistance: float = quantity("ohm", kind="resistor")
    series_resistance: float = quantity("ohm", kind="resistor")
    feedback_capacitance: float = quantity("F", kind="capacitor")
    bias_resistance: float = quantity("ohm")
    bias_capacitance: float = quantity("F")


@dataclass(frozen=True)
class InputBuffer:
    """The followers of transducer and demand, and of the output.

    Attributes
    ----------
    series_resistance : float
        Ahead of the input [ohm].
    """

    series_resistance: float = quantity("ohm")


@dataclass(frozen=True)
class Tap:
    """The connectors of velocity and acceleration.

    Attributes
    ----------
    resistance : float
        Between op-amp and connector, against the capacitance of a cable [ohm].
    """

    resistance: float = quantity("ohm")


@dataclass(frozen=True)
class EqualResistors:
    """An amplifier of gain 1 that is made of equal resistors.

    Attributes
    ----------
    resistance : float
        Each of them [ohm].
    """

    resistance: float = quantity("ohm", kind="matched_resistor")


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

    displacement_potentiometer: float = quantity("ohm", kind="potentiometer")
    displacement_resistance: float = quantity("ohm", kind="resistor")
    velocity_potentiometer: float = quantity("ohm", kind="potentiometer")
    velocity_resistance: float = quantity("ohm", kind="resistor")
    acceleration_resistance: float = quantity("ohm", kind="resistor")
    feedback_resistance: float = quantity("ohm", kind="resistor")


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

    ground_resistance: float = quantity("ohm", kind="resistor")
    feedback_resistance: float = quantity("ohm", kind="resistor")
    potentiometer: float = quantity("ohm", kind="potentiometer")


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

    clamp_resistance: float = quantity("ohm", kind="resistor")
    clamp_level: float = quantity("V")
    zener_resistance: float = quantity("ohm")
    potentiometer: float = quantity("ohm", kind="potentiometer")


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

    end_resistance: float = quantity("ohm")
    wiper_resistance: float = quantity("ohm")


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

    lead_resistance: float = quantity("ohm")
    bulk_capacitance: float = quantity("F")
    bulk_resistance: float = quantity("ohm")
    ceramic_capacitance: float = quantity("F")


@dataclass(frozen=True)
class OperationalAmplifier:
    """Typical data-sheet figures of the op-amp, the same for all on the card.

    Attributes
    ----------
    gain_bandwidth, second_pole, slew_rate, open_loop_gain : float
        [Hz], [Hz], [V/s], [V/V].
    input_offset_voltage, offset_drift, bias_current, offset_current : float
        [V], [V/K], [A], [A].
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

    gain_bandwidth: float = quantity("Hz")
    second_pole: float = quantity("Hz")
    slew_rate: float = quantity("V/s")
    open_loop_gain: float = quantity("")
    input_offset_voltage: float = quantity("V", "any")
    offset_drift: float = quantity("V/K", "any")
    bias_current: float = quantity("A", "not negative")
    offset_current: float = quantity("A", "any")
    input_resistance: float = quantity("ohm")
    input_capacitance: float = quantity("F")
    output_resistance: float = quantity("ohm")
    common_mode_rejection: float = quantity("")
    supply_rejection: float = quantity("")
    noise_1_kilohertz: float = quantity("V")
    noise_10_kilohertz: float = quantity("V")
    positive_swing: float = quantity("V")
    negative_swing: float = quantity("V")
    source_limit: float = quantity("A")
    sink_limit: float = quantity("A")
    supply_current: float = quantity("A", "not negative")
    supply: float = quantity("V")

    def __post_init__(self) -> None:
        """Refuse noise that is neither white nor 1/f nor both."""
        low, high = self.noise_1_kilohertz, self.noise_10_kilohertz
        if not high <= low <= _STEEPEST * high:
            raise InputError(
                f"noise_1_kilohertz is {low:g} V and noise_10_kilohertz {high:g} V; white and 1/f "
                f"noise has from 1 to {_STEEPEST:g} times as much at 1 kHz. Read both again in the "
                "data sheet"
            )

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
