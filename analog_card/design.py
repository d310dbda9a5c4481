"""What a card consists of: the parts soldered on it and the settings of its potentiometers."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

from analog_card.design_fields import quantity
from analog_card.design_tolerances import REFERENCE_TEMPERATURE, PartTolerance, Tolerances
from analog_card.soldered import (
    AMPLIFIER_FIGURES,
    AMPLIFIERS,
    DifferentiatorParts,
    OperationalAmplifier,
    Soldered,
)

__all__ = [
    "AMPLIFIERS",
    "AMPLIFIER_FIGURES",
    "Design",
    "DifferentiatorParts",
    "OperationalAmplifier",
    "Soldered",
    "Transducer",
    "Turned",
]


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

    full_scale_voltage: float = quantity("V")
    full_scale_displacement: float = quantity("m")

    @property
    def gain(self) -> float:
        """Volts for each metre [V/m]."""
        return self.full_scale_voltage / self.full_scale_displacement


@dataclass(frozen=True)
class Turned:
    """Settings of the potentiometers, as fraction of travel from 0 to 1.

    Attributes
    ----------
    displacement_weight, velocity_weight, boundary_layer, level : float
        P1, P2, P3 and P4.
    """

    displacement_weight: float = quantity("", "fraction")
    velocity_weight: float = quantity("", "fraction")
    boundary_layer: float = quantity("", "fraction")
    level: float = quantity("", "fraction")


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
    tolerances : Tolerances
        How far its parts may be from their values, and how they change with temperature.
    own_tolerances : mapping of str to mapping
        What of `analog_card.design_tolerances.PartTolerance` is other for a single part than for
        its kind, by its dotted name, such as ``"velocity_differentiator.capacitance"``.
    sources : mapping of str to str
        Where a value comes from, by its dotted name, such as ``"turned.level"``.
    """

    title: str
    transducer: Transducer
    soldered: Soldered
    turned: Turned
    tolerances: Tolerances
    own_tolerances: Mapping[str, Mapping[str, float]] = field(default_factory=dict, hash=False)
    sources: Mapping[str, str] = field(default_factory=dict, compare=False)

    def part_tolerance(self, section: str, name: str) -> PartTolerance:
        """Return the tolerance of a part: its kind's, with what is its own.

        Parameters
        ----------
        section, name : str
            Where it is in `Soldered`.

        Examples
        --------
        >>> from analog_card.design_file import load_design
        >>> load_design().part_tolerance("surface_amplifier", "feedback_resistance").tolerance
        0.01
        """
        declared = {item.name: item for item in fields(getattr(self.soldered, section))}
        of_kind: PartTolerance = getattr(self.tolerances, declared[name].metadata["kind"])
        return replace(of_kind, **self.own_tolerances.get(f"{section}.{name}", {}))

    def netlist_parameters(self, temperature: float = REFERENCE_TEMPERATURE) -> dict[str, float]:
        """Return all values by their parameter names in the netlists.

        Parameters
        ----------
        temperature : float, optional
            Of the card [K].

        Notes
        -----
        Every netlist that includes ``values.lib`` and an op-amp has all of them; those of the
        op-amp's benches only have `OperationalAmplifier.netlist_parameters`.
        """
        parts, turned = self.soldered, self.turned
        stages = {
            "buffer": "input_buffer",
            "velocity": "velocity_differentiator",
            "acceleration": "acceleration_differentiator",
            "tap": "tap",
            "difference": "difference_amplifier",
            "inverter": "inverter",
            "surface": "surface_amplifier",
            "boundary_layer": "boundary_layer_amplifier",
            "limiter": "output_limiter",
            "potentiometer": "potentiometer_contacts",
            "supply": "supply",
        }
        values = parts.operational_amplifier.netlist_parameters() | {
            f"{stage}_{name}": value * self._made_up(section, name, temperature)
            for stage, section in stages.items()
            for name, value in vars(getattr(parts, section)).items()
        }
        offset = parts.operational_amplifier.input_offset_voltage
        values |= {f"{stage}_offset": offset for stage in AMPLIFIERS}
        # To a hundredth of a microkelvin: SPICE counts in degrees Celsius.
        celsius = round(temperature - 273.15, 8)
        values |= self.tolerances.coefficients() | {"card_temperature": celsius}
        return values | {
            "displacement_weight": turned.displacement_weight,
            "velocity_weight": turned.velocity_weight,
            "boundary_layer_setting": turned.boundary_layer,
            "level_setting": turned.level,
        }

    def _made_up(self, section: str, name: str, temperature: float) -> float:
        """Return what a part's netlist value makes up for, when its coefficient is its own.

        The netlist changes every part by the coefficient of its kind.
        """
        own = self.own_tolerances.get(f"{section}.{name}", {})
        if "temperature_coefficient" not in own:
            return 1.0
        of_part = self.part_tolerance(section, name)
        (item,) = (item for item in fields(getattr(self.soldered, section)) if item.name == name)
        of_kind = getattr(self.tolerances, item.metadata["kind"])
        return of_part.drift(temperature) / of_kind.drift(temperature)
