"""The options by which a tolerance study replaces tolerances of the design file."""

from collections.abc import Callable, Mapping
from dataclasses import Field, fields, is_dataclass, replace
from typing import Any, get_type_hints

import click

from analog_card.console import Quantity
from analog_card.design import Design
from analog_card.design_tolerances import Tolerances

_ZERO_CELSIUS = 273.15


def _places() -> dict[str, tuple[str, "Field[Any]"]]:
    """Return by option the place of its value in `Tolerances`, and the value's declaration."""
    found = {}
    for kind, section in get_type_hints(Tolerances).items():
        for item in fields(section) if is_dataclass(section) else ():
            found[_option(kind, item.name)] = (f"{kind}.{item.name}", item)
    return found


def _option(kind: str, name: str) -> str:
    """Return the name of an option: the op-amps need not be named, a tolerance is its part's."""
    if kind == "operational_amplifier":
        return name
    if kind == "temperature":
        return f"{name}_temperature"
    return {"tolerance": kind, "temperature_coefficient": f"{kind}_coefficient"}.get(
        name, f"{kind}_{name}"
    )


_PLACES = _places()


def tolerance_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add an option for every tolerance; each is None where the design file's holds."""
    for name, (place, item) in reversed(_PLACES.items()):
        unit = item.metadata["unit"]
        # Temperatures are plain numbers in degC: a plain one with a unit would be in kelvin.
        celsius = unit == "K"
        shown = "degC" if celsius else unit
        of = place.partition(".")[0].replace("_", " ").capitalize()
        text = f"{of}: {item.metadata['help']}" + (f" [{shown}]." if shown else ".")
        function = click.option(
            f"--{name.replace('_', '-')}",
            name,
            type=float if celsius else Quantity(unit),
            default=None,
            help=text,
        )(function)
    return function


def with_tolerances(design: Design, options: Mapping[str, float | None]) -> Design:
    """Return a design with the tolerances that options give.

    Parameters
    ----------
    design : Design
        As in its file.
    options : mapping of str to float or None
        By the names that `tolerance_options` gives them; None leaves the design's.

    Raises
    ------
    InputError
        When a value is out of range.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> design = with_tolerances(load_design(), {"resistor": 0.001, "lowest_temperature": 0.0})
    >>> design.tolerances.resistor.tolerance, design.tolerances.temperature.lowest
    (0.001, 273.15)
    """
    changes = {}
    for name, value in options.items():
        if value is not None:
            place, item = _PLACES[name]
            changes[place] = value + _ZERO_CELSIUS if item.metadata["unit"] == "K" else value
    return replace(design, tolerances=design.tolerances.with_changes(changes))
