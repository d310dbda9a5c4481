"""How far the parts of a card may be from their values, and how they change with temperature."""

from collections.abc import Mapping
from dataclasses import Field, dataclass, fields, replace
from typing import Any

from analog_card.design_fields import quantity, require_allowed
from analog_card.errors import InputError

# Where the values of a design hold [K]; the netlists count from it too, in degrees Celsius.
REFERENCE_TEMPERATURE = 298.15


@dataclass(frozen=True)
class PartTolerance:
    """Resistors, capacitors or tracks of one kind.

    Attributes
    ----------
    tolerance : float
        Largest relative deviation from the value, evenly spread [-].
    temperature_coefficient : float
        Relative change with temperature, the same for all of the kind [1/K].
    """

    tolerance: float = quantity("", "share", "largest relative deviation, evenly spread")
    temperature_coefficient: float = quantity("1/K", "any", "relative change with temperature")

    def drift(self, temperature: float) -> float:
        """Return the factor that a temperature makes of the value.

        Parameters
        ----------
        temperature : float
            Of the card [K].
        """
        return 1 + self.temperature_coefficient * (temperature - REFERENCE_TEMPERATURE)


@dataclass(frozen=True)
class ZenerTolerance:
    """The pair of zeners that sets the level.

    Attributes
    ----------
    tolerance : float
        Largest relative deviation that both have in common, evenly spread [-].
    matching : float
        Largest relative deviation of each from what they have in common, evenly spread [-].
    temperature_coefficient : float
        Relative change of the breakdown voltage with temperature [1/K].
    forward_drift : float
        Change of the forward voltage, of the zener that does not break down [V/K].
    """

    tolerance: float = quantity("", "share", "largest relative deviation of the pair")
    matching: float = quantity("", "share", "largest deviation of each from the pair")
    temperature_coefficient: float = quantity("1/K", "any", "relative change with temperature")
    forward_drift: float = quantity("V/K", "any", "change of the forward voltage")


@dataclass(frozen=True)
class AmplifierTolerance:
    """The op-amps, each on its own.

    Attributes
    ----------
    offset_voltage, offset_drift : float
        Standard deviations of offset voltage [V] and of its drift [V/K], both normal about zero:
        the typical figures of a data sheet have no sign.
    bias_current, open_loop_gain : float
        Largest factor to either side, evenly spread in decibels [-].
    gain_bandwidth, slew_rate : float
        Largest relative deviation, evenly spread [-].
    positive_swing, negative_swing : float
        Largest deviation of the swing, evenly spread [V].
    """

    offset_voltage: float = quantity("V", "not negative", "standard deviation of offset voltage")
    offset_drift: float = quantity("V/K", "not negative", "standard deviation of its drift")
    bias_current: float = quantity("", "factor", "largest factor of the bias current")
    open_loop_gain: float = quantity("", "factor", "largest factor of the open-loop gain")
    gain_bandwidth: float = quantity("", "share", "largest relative deviation of GBW")
    slew_rate: float = quantity("", "share", "largest relative deviation of the slew rate")
    positive_swing: float = quantity("V", "not negative", "largest deviation of the upper swing")
    negative_swing: float = quantity("V", "not negative", "largest deviation of the lower swing")


@dataclass(frozen=True)
class TemperatureRange:
    """Temperatures of the whole card, evenly spread.

    Attributes
    ----------
    lowest, highest : float
        [K].
    """

    lowest: float = quantity("K", "positive", "lowest of the card")
    highest: float = quantity("K", "positive", "highest of the card")

    def __post_init__(self) -> None:
        """Refuse a range that is upside down."""
        if self.lowest > self.highest:
            raise InputError(
                f"temperature from {self.lowest:g} to {self.highest:g} K: the lowest comes first"
            )

    @property
    def middle(self) -> float:
        """Return the temperature half way [K]."""
        return (self.lowest + self.highest) / 2

    @property
    def half(self) -> float:
        """Return how far the ends are from the middle [K]."""
        return (self.highest - self.lowest) / 2


@dataclass(frozen=True)
class Tolerances:
    """What differs from one card of a design to the next, by kind of part.

    Attributes
    ----------
    resistor, matched_resistor, capacitor, potentiometer : PartTolerance
        Matched are the resistors of difference amplifier and inverter; of a potentiometer it is
        the track.
    zener : ZenerTolerance
        The pair of the output limiter.
    operational_amplifier : AmplifierTolerance
        Every op-amp.
    temperature : TemperatureRange
        Of the card.
    """

    resistor: PartTolerance
    matched_resistor: PartTolerance
    capacitor: PartTolerance
    potentiometer: PartTolerance
    zener: ZenerTolerance
    operational_amplifier: AmplifierTolerance
    temperature: TemperatureRange

    def with_changes(self, changes: Mapping[str, float]) -> "Tolerances":
        """Return these with others in some places.

        Parameters
        ----------
        changes : mapping of str to float
            Values in SI by kind and name, such as ``{"resistor.tolerance": 0.001}``.

        Raises
        ------
        InputError
            When a value is out of range, or there is no such name.

        Examples
        --------
        >>> from analog_card.design_file import load_design
        >>> tolerances = load_design().tolerances
        >>> tolerances.with_changes({"resistor.tolerance": 0.001}).resistor.tolerance
        0.001
        """
        known = {f"{kind}.{item.name}" for kind in vars(self) for item in _fields_of(self, kind)}
        for name in changes:
            if name not in known:
                raise InputError(f"tolerance {name!r}: there are {', '.join(sorted(known))}")
        sections = {}
        for kind in vars(self):
            found = {}
            for item in _fields_of(self, kind):
                name = f"{kind}.{item.name}"
                if name in changes:
                    value = changes[name]
                    require_allowed(value, item.metadata, f"tolerance {name}", value)
                    found[item.name] = value
            sections[kind] = replace(getattr(self, kind), **found)
        return Tolerances(**sections)

    def coefficients(self) -> dict[str, float]:
        """Return what changes with temperature, by its parameter names in the netlists."""
        kinds = ("resistor", "matched_resistor", "capacitor", "potentiometer", "zener")
        values = {
            f"{kind}_temperature_coefficient": getattr(self, kind).temperature_coefficient
            for kind in kinds
        }
        return values | {"zener_forward_drift": self.zener.forward_drift}


def _fields_of(tolerances: Tolerances, kind: str) -> "tuple[Field[Any], ...]":
    return fields(getattr(tolerances, kind))
