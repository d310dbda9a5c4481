"""What a campaign can vary: every number of rig, effects, controller and card."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from analog_card.behaviour_elements import PARTS, nominal_elements
from analog_card.design import Design
from analog_card.design_fields import require_allowed
from pneuservo.loop_controller import BEHAVIOUR, CIRCUIT, TAKEN, UNITS
from pneuservo.rigs import Rig

CONTROLLER, ELEMENT = "controller.", "element."
# What of a design is varied by its name in the design file; the transducer is the rig's.
_SECTIONS = ("soldered", "turned")


@dataclass(frozen=True)
class Varied:
    """A number that can be varied.

    Attributes
    ----------
    name : str
        What it is called in a campaign.
    unit : str
        SI unit; ``""`` for a pure number.
    nominal : float or None
        Its value where it is not varied; None where that depends on others [unit].
    tolerance : float
        Standard deviation, or largest deviation if evenly spread; 0 when unknown [unit].
    even : bool
        Whether it is evenly spread.
    allowed : str
        What a design's value may be, as `analog_card.design_fields.quantity` names it.
    """

    name: str
    unit: str
    nominal: float | None = None
    tolerance: float = 0.0
    even: bool = False
    allowed: str = "any"

    def require_allowed(self, value: float, what: str) -> None:
        """Refuse a value that the number must not have."""
        require_allowed(value, {"allowed": self.allowed}, what, value)


def variable_parameters(
    rig: Rig, controller: str, design: Design | None, card: str | None
) -> dict[str, Varied]:
    """Return what can be varied in a loop.

    Parameters
    ----------
    rig : Rig
        The plant.
    controller : str
        Kind of the controller.
    design : Design or None
        Of an analogue card.
    card : str or None
        What simulates it.

    Returns
    -------
    dict of str to Varied
        By name: the rig's ids, ``effect:parameter``, ``controller.option``, names of the design
        file such as ``soldered.tap.resistance``, and ``element.`` with the name of a single element
        of the netlist.

    Examples
    --------
    >>> from pneuservo.rigs import load_rig
    >>> known = variable_parameters(load_rig("single-axis"), "proportional", None, None)
    >>> known["load.mass"].tolerance, known["controller.gain"].unit
    (0.05475, '')
    """
    found = [
        Varied(name, parameter.unit, parameter.value, parameter.tolerance)
        for name, parameter in rig.parameters.items()
    ]
    found += _effects(rig)
    found += [Varied(CONTROLLER + name, UNITS[name]) for name in TAKEN[controller] if name in UNITS]
    if design is not None:
        found += [item for name in _SECTIONS for item in _values(design, name)]
        if card in (BEHAVIOUR, CIRCUIT):
            found += _elements(design)
    return {item.name: item for item in found}


def varied_rig(rig: Rig, values: Mapping[str, float]) -> Rig:
    """Return the rig with its share of the values.

    Parameters
    ----------
    rig : Rig
        As it is.
    values : mapping of str to float
        By the names of `variable_parameters`; those of others are left alone.
    """
    return rig.with_own_values(values)


def varied_design(design: Design, values: Mapping[str, float]) -> Design:
    """Return the design with its share of the values.

    Parameters
    ----------
    design : Design
        As it is.
    values : mapping of str to float
        By the names of `variable_parameters`; those of others are left alone.

    Raises
    ------
    InputError
        When a part must not have a value.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> varied_design(load_design(), {"soldered.tap.resistance": 47.0}).soldered.tap.resistance
    47.0
    """
    for name, value in values.items():
        section, *rest = name.split(".")
        if section in _SECTIONS:
            design = _with(design, [section, *rest], value, name)
    return design


def _effects(rig: Rig) -> list[Varied]:
    # The catalogue brings the compiler along: not before it is needed.
    from pneuservo.effects import effects_of

    return [
        Varied(
            f"{effect.id}:{parameter.name}",
            parameter.unit,
            rig.effects.get(effect.id, {}).get(parameter.name, parameter.neutral),
        )
        for effect in effects_of(rig.kind)
        for parameter in effect.parameters
    ]


def _values(design: Design, path: str) -> list[Varied]:
    """Return the numbers of a section of a design, by their dotted names."""
    section: Any = design
    for part in path.split("."):
        section = getattr(section, part)
    found = []
    for item in fields(section):
        name, value = f"{path}.{item.name}", getattr(section, item.name)
        if is_dataclass(value):
            found += _values(design, name)
            continue
        share = 0.0
        if item.metadata["kind"]:
            share = design.part_tolerance(path.removeprefix("soldered."), item.name).tolerance
        about = (share * value, True, item.metadata["allowed"])
        found.append(Varied(name, item.metadata["unit"], value, *about))
    return found


def _elements(design: Design) -> list[Varied]:
    """Return the single elements that a design's part stands for, more than one of some."""
    nominal = nominal_elements(design)
    found = []
    for element, (section, part) in PARTS.items():
        unit = "F" if element.rpartition(".")[2].startswith("c") else "ohm"
        share = design.part_tolerance(section, part).tolerance
        about = (share * nominal[element], True, "positive")
        found.append(Varied(ELEMENT + element, unit, nominal[element], *about))
    return found


def _with(section: Any, path: list[str], value: float, name: str) -> Any:
    first, *rest = path
    if rest:
        return replace(section, **{first: _with(getattr(section, first), rest, value, name)})
    (item,) = (each for each in fields(section) if each.name == first)
    require_allowed(value, item.metadata, name, value)
    return replace(section, **{first: value})
