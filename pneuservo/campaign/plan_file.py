"""Campaign files: what a campaign is, as TOML, with options in place of or beside it."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from analog_card.design_file import load_design
from analog_card.imperfections import Imperfections
from analog_card.quantities import to_si
from analog_card.toml_file import read_toml
from pneuservo.arrays import Array
from pneuservo.campaign.axes import Axis, Random, read_axis
from pneuservo.campaign.metrics import METRICS, OF_RECORDED, OF_SET_POINTS
from pneuservo.campaign.parameters import variable_parameters
from pneuservo.campaign.plan import Campaign
from pneuservo.controllers import AnalogueCard
from pneuservo.controllers.requirements import other_transducer
from pneuservo.errors import InputError
from pneuservo.loop_controller import CARDS, loop_controller
from pneuservo.naming import require_known
from pneuservo.recordings import read_recording
from pneuservo.rigs import Rig
from pneuservo.simulation import step_demand
from pneuservo.simulation.demand import HOLD, RATE, names_recording, set_points
from pneuservo.simulation.inputs import require_kind

# How many samples are drawn at each point of the grid, unless said.
TRIALS = 100
# What a campaign file may hold, and of which kind it is.
_KEYS: dict[str, tuple[type, ...]] = {
    "title": (str,),
    "rig": (str,),
    "controller": (str,),
    "design": (str,),
    "card": (str,),
    "without": (list, tuple),
    "demand": (str,),
    "hold": (str, int, float),
    "rate": (str, int, float),
    "metrics": (list, tuple),
    "trials": (int,),
    "seed": (int,),
    "vary": (dict,),
}
# Dots in a name are fewer: what a file has more of would only be gone into.
_MOST_PARTS = 8
_FILES = {
    "rig": lambda name: name.endswith(".toml"),
    "design": lambda name: True,
    "demand": names_recording,
}


def read_settings(path: str | Path) -> dict[str, Any]:
    """Return what a campaign file says; files that it names are beside it.

    Parameters
    ----------
    path : str or Path
        A TOML file.

    Raises
    ------
    InputError
        When it cannot be read, or holds an unknown key or a value of the wrong kind.
    """
    path = Path(path)
    data = read_toml(path, "a campaign file", InputError)
    for key, value in data.items():
        require_known(key, _KEYS, str(path))
        if not isinstance(value, _KEYS[key]) or isinstance(value, bool):
            kinds = " or ".join(kind.__name__ for kind in _KEYS[key] if kind is not tuple)
            raise InputError(f"{path}: {key} is {value!r}; {kinds} is needed")
    for key, is_file in _FILES.items():
        if key in data and is_file(data[key]):
            data[key] = str(path.parent / data[key])
    return data


def campaign_of(
    settings: Mapping[str, Any],
    where: str = "--vary",
    warn: Callable[[str], None] = lambda message: None,
) -> Campaign:
    """Return the campaign that settings describe.

    Parameters
    ----------
    settings : mapping of str to anything
        As a campaign file has them, with the axes by name of their parameter in ``vary``.
    where : str, optional
        Where the axes were given, for error messages.
    warn : callable, optional
        Told what was found wrong with a recording but could be worked around.

    Returns
    -------
    Campaign
        Checked as far as can be without simulating.

    Raises
    ------
    InputError
        When something is missing, unknown, or not a quantity of the right kind.

    Examples
    --------
    >>> campaign = campaign_of({
    ...     "controller": "sliding-mode", "demand": "15,24 mm",
    ...     "vary": {"supply.pressure": "6.5:7.7 bar:5", "load.mass": "1.8, 7 kg"},
    ... })
    >>> len(campaign), campaign.values(3)
    (10, {'supply.pressure': 680000.0, 'load.mass': 7.0})
    """
    for key, example in (("controller", "sliding-mode"), ("demand", "15,24,6,15 mm")):
        if settings.get(key) is None:
            raise InputError(
                f'a campaign needs a {key}, such as --{key} "{example}", or {key} = "{example}" '
                "in its file"
            )
    rig, time, demand = _demand(settings, warn)
    controller = settings["controller"]
    options = _options(settings, controller)
    loop = loop_controller(controller, options)
    if loop.design is not None and (problem := other_transducer(loop.design, rig)):
        warn(problem)
    known = variable_parameters(rig, controller, loop.design, loop.card)
    axes = []
    for name, given in _flat(settings.get("vary", {}), where).items():
        require_known(name, known, where)
        several = given if isinstance(given, list | tuple) else [given]
        if any(isinstance(one, bool) or not isinstance(one, str | int | float) for one in several):
            raise InputError(f"{where} {name}: {given!r} is neither a text nor a list of values")
        axes.append(read_axis(known[name], given, where))
    if not axes:
        raise InputError(
            'nothing varies: give at least one --vary, such as --vary "supply.pressure=6.5:7.7 '
            'bar:5", or a table [vary] in the campaign file'
        )
    usual = OF_RECORDED if names_recording(settings["demand"]) else OF_SET_POINTS
    metrics = tuple(settings.get("metrics") or usual)
    for metric in metrics:
        if not isinstance(metric, str):
            raise InputError(
                f"metrics: {metric!r} is no text; give names, such as metrics = "
                f'["settling_time"]. There are: {", ".join(METRICS)}'
            )
        require_known(metric, METRICS, "metrics")
    return Campaign(
        rig=rig,
        controller=controller,
        options=options,
        time=time,
        demand=demand,
        axes=tuple(axes),
        trials=_trials(axes) if settings.get("trials") is None else settings["trials"],
        seed=settings.get("seed") or 0,
        metrics=metrics,
        title=settings.get("title") or f"{rig.title}, {controller}",
    )


def _flat(table: Mapping[str, Any], where: str, prefix: str = "", depth: int = 0) -> dict[str, Any]:
    """Return a table by dotted names: TOML makes tables of names that are not quoted."""
    if depth > _MOST_PARTS:
        raise InputError(
            f"{where}: {prefix}... has more parts than any name of a parameter; write it with its "
            'value, such as "load.mass" = "1.8, 7 kg"'
        )
    found: dict[str, Any] = {}
    for key, value in table.items():
        inner = isinstance(value, Mapping)
        name = prefix + key
        found |= _flat(value, where, f"{name}.", depth + 1) if inner else {name: value}
    return found


def _trials(axes: list[Axis]) -> int:
    return TRIALS if any(isinstance(axis, Random) for axis in axes) else 1


def _demand(settings: Mapping[str, Any], warn: Callable[[str], None]) -> tuple[Rig, Array, Array]:
    """Return the rig under the conditions of the demand, and the demand over time."""
    text, name = settings["demand"], settings.get("rig")
    given = {key: settings[key] for key in ("hold", "rate") if settings.get(key) is not None}
    if not names_recording(text):
        rig = require_kind(name or "single-axis", "single-axis", effects=True)
        hold = to_si(given.get("hold", HOLD), "s", "hold")
        rate = to_si(given.get("rate", RATE), "Hz", "rate")
        return rig, *step_demand(set_points(text, rig["piston.stroke"]), hold, rate)
    if given:
        raise InputError(f"{' and '.join(given)}: not used by a recorded demand; leave it out")
    recording = read_recording(text, name)
    for message in recording.warnings:
        warn(f"{text}: {message}")
    if "demand" not in recording:
        raise InputError(
            f"{text}: there is no channel demand; there are: {', '.join(recording.channels)}"
        )
    rig = require_kind(name or recording.rig, "single-axis", effects=True)
    return rig.with_conditions(recording.conditions), recording.time, recording["demand"]


def _options(settings: Mapping[str, Any], controller: str) -> dict[str, Any]:
    """Return what shapes the controller and does not vary."""
    options = {
        key: settings[key] for key in ("design", "card", "without") if settings.get(key) is not None
    }
    if "card" in options:
        require_known(options["card"], CARDS, "card")
    if "without" in options:
        options["without"] = tuple(str(name).replace("-", "_") for name in options["without"])
        for name in options["without"]:
            require_known(name, [item.name for item in fields(Imperfections)], "without")
    if controller == AnalogueCard.kind:
        # Read once and here: other computers need not have the file.
        options["design"] = load_design(options.get("design"))
    return options
