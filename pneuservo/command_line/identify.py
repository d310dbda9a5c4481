"""``pneuservo identify``: mass, friction and other values of a rig from recordings."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import tomli_w

from analog_card.console import Count, Quantity, progress, warn
from analog_card.files import write_files
from analog_card.plain_json import plain_json
from pneuservo.command_line.recording_files import (
    Window,
    read,
    require_room_for_valve,
    require_unread,
)
from pneuservo.command_line.unused_options import refuse_unused
from pneuservo.errors import InputError
from pneuservo.rigs import Parameter, Rig, load_rig
from pneuservo.rigs.rig_file import files_beside, rig_document

METHODS = ("output-error", "least-squares", "evolution")
# Options that only some of them use.
_SIMULATING, _FILTERING = ("segment", "command"), ("cutoff", "dead_band", "direction")
_USED = {"output-error": _SIMULATING, "least-squares": _FILTERING, "evolution": _SIMULATING}
_WRITTEN = ("identification.json", "rig.toml", "fit.svg")
_EPILOG = """\b
Examples:
  pneuservo simulate --controller proportional --demand "15,20,12,15 mm" --out moves.csv
  pneuservo identify moves.csv --command continuous --json
  pneuservo identify moves.csv --method least-squares --out out/identification
"""


@click.command("identify", epilog=_EPILOG)
@click.argument("recordings", nargs=-1, required=True, metavar="REC [REC ...]")
@click.option(
    "--method",
    type=click.Choice(METHODS),
    help="How.  [default: output-error; least-squares for a seal tester]",
)
@click.option(
    "--parameter",
    "parameters",
    multiple=True,
    metavar="ID",
    help="What to look for; may be given again.  [default: mass, viscous and Coulomb friction]",
)
@click.option(
    "--direction",
    type=click.Choice(["both", "extending", "retracting"]),
    default="both",
    show_default=True,
    help="Motion that least squares uses.",
)
@click.option("--cutoff", type=Quantity("Hz", 0.0), help="Of its filter.  [default: 50 Hz]")
@click.option("--dead-band", type=Quantity("m/s", 0.0), help="Of velocity.  [default: 5 mm/s]")
@click.option("--segment", type=Quantity("s", 0.0), help="Length simulated at once.")
@click.option(
    "--command",
    "driven",
    type=click.Choice(["held", "continuous"]),
    default="held",
    show_default=True,
    help="What the valve voltage does between samples: a converter holds it, a card does not.",
)
@click.option("--rig", help="Rig name or rig file, in place of the one the recordings name.")
@click.option("--window", type=Window(), help="Use only this stretch of the recordings [s].")
@click.option(
    "--seed", type=Count(min=0), default=0, show_default=True, help="Seed of the evolution."
)
@click.option("--jobs", type=Count(1), default=1, show_default=True, help="Processes.")
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("out/identification"),
    show_default=True,
    help="Folder for the answer.",
)
@click.option("--json", "as_json", is_flag=True, help="Print identification.json, nothing else.")
def command(
    recordings: tuple[str, ...],
    method: str | None,
    window: tuple[float, float] | None,
    rig: str | None,
    out: Path,
    as_json: bool,
    **options: Any,
) -> None:
    """Identify values of a rig from recordings of its motion.

    Of the single axis mass and friction, or any other parameter; of a seal tester the friction of
    the seal.

    Writes identification.json, rig.toml (the rig with the values found, which other commands
    accept as --rig) and fit.svg. Exit status 3 when a fit failed.
    """
    with progress() as step:
        step("reading the recordings")
        used = [read(path, rig, window) for path in recordings]
        require_unread([out / name for name in _WRITTEN], used)
        known = load_rig(used[0].rig)
        require_room_for_valve(known, out, _WRITTEN)
        step("identifying")
        found, each = _identified(known.kind, method, used, rig, options)
        step("writing")
        answer = _document(found, each, known.kind)
        _write(found, answer, known, used[0].conditions, out)
    if as_json:
        click.echo(json.dumps(answer, indent=2))
    else:
        _print(answer, out)


def _identified(
    kind: str,
    method: str | None,
    recordings: list[Any],
    rig: str | None,
    options: dict[str, Any],
) -> tuple[Any, dict[tuple[str, str], Any]]:
    from pneuservo import identification

    if kind == "seal-tester":
        if method not in (None, "least-squares") or options["parameters"]:
            raise InputError(
                "a seal tester's friction is found by least squares alone; leave out --method and "
                "--parameter"
            )
        _refuse_unused(options, (), "a seal tester")
        return identification.identify_seal_friction(recordings, rig), {}
    method = method or METHODS[0]
    _refuse_unused(options, _USED[method], f"--method {method}")
    if method == "least-squares":
        return _by_least_squares(recordings, rig, options)
    parameters = options["parameters"] or identification.PARAMETERS
    segment: dict[str, Any] = {"continuous": options["driven"] == "continuous"}
    if options["segment"] is not None:
        segment["segment"] = options["segment"]
    if method == "output-error":
        return identification.identify_output_error(recordings, rig, parameters, **segment), {}
    found = identification.identify_evolution(
        recordings, rig, parameters, seed=options["seed"], jobs=options["jobs"], **segment
    )
    return found, {}


def _refuse_unused(options: dict[str, Any], used: tuple[str, ...], what: str) -> None:
    given = {
        **{name: options[name] for name in ("cutoff", "dead_band", "segment")},
        "direction": None if options["direction"] == "both" else options["direction"],
        "command": None if options["driven"] == "held" else options["driven"],
    }
    refuse_unused({name: value for name, value in given.items() if name not in used}, what)


def _by_least_squares(
    recordings: list[Any], rig: str | None, options: dict[str, Any]
) -> tuple[Any, dict[tuple[str, str], Any]]:
    from pneuservo import identification

    if options["parameters"]:
        raise InputError(
            f"--parameter: least squares finds {', '.join(identification.PARAMETERS)} and nothing "
            "else; use --method output-error for other parameters"
        )
    shape = {name: options[name] for name in ("cutoff", "dead_band") if options[name] is not None}
    found = identification.identify_least_squares(
        recordings, rig, direction=options["direction"], **shape
    )
    each = {}
    if options["direction"] == "both":
        try:
            each = identification.identify_each(recordings, rig, **shape)
        except InputError as problem:
            warn(f"no values by direction: {problem}")
    return found, each


def _values(found: Any) -> dict[str, Any]:
    return {
        name: {
            "value": entry.value,
            "low": plain_json(entry.low),
            "high": plain_json(entry.high),
            "unit": entry.unit,
        }
        for name, entry in found.values.items()
    }


def _document(found: Any, each: dict[tuple[str, str], Any], kind: str) -> dict[str, Any]:
    names = list(found.values)
    return {
        "schema": 1,
        "rig": kind,
        "method": found.method,
        "values": _values(found),
        "correlations": [
            {"between": [names[j], names[i]], "value": plain_json(float(found.correlation[i, j]))}
            for i in range(len(names))
            for j in range(i)
        ],
        "residuals": {
            name: {
                "rms": found.rms(name),
                "white": judged.white,
                "probability": judged.probability,
                "statement": judged.sentence(),
            }
            for name, judged in found.whiteness.items()
        },
        "cannot_tell_apart": found.cannot_tell_apart(),
        "notes": list(found.notes),
        "each": [
            {"recording": name, "direction": direction, "values": _values(entry)}
            for (name, direction), entry in each.items()
        ],
    }


def _write(
    found: Any, answer: dict[str, Any], rig: Rig, conditions: Mapping[str, float], out: Path
) -> None:
    from pneuservo.identification.pictures import draw_autocorrelation, draw_fit
    from pneuservo.report.svg import draw

    def paint(axes: list[Any]) -> None:
        for ax, channel in zip(axes, found.residual, strict=False):
            draw_fit(ax, found, channel)
        draw_autocorrelation(axes[len(found.residual)], found)

    count = len(found.residual) + 1
    picture = draw(paint, size=(9.0, 2.6 * count), shape=(count, 1))
    files = {
        "identification.json": json.dumps(answer, indent=2) + "\n",
        **files_beside(rig),
        "rig.toml": tomli_w.dumps(_rig(found, rig, conditions)),
        "fit.svg": picture,
    }
    write_files(out, files)


def _rig(found: Any, rig: Rig, conditions: Mapping[str, float]) -> dict[str, Any]:
    """Return the rig file of a rig with the values found, from a first recording's conditions."""
    source = f"pneuservo identify, {found.method}"
    # The rig of a seal tester has no viscous friction of its own.
    repaired = rig.with_own_values({name: entry.value for name, entry in found.values.items()})
    begun = rig.with_conditions(conditions)
    named = {
        name: replace(
            parameter,
            source=source,
            nominal=_nominal(rig.parameters[name], begun.parameters[name]),
        )
        if name in found.values
        else parameter
        for name, parameter in repaired.parameters.items()
    }
    return rig_document(replace(repaired, parameters=named))


def _nominal(given: Parameter, begun: Parameter) -> float:
    """Return what a parameter was taken to be before anything was fitted to any recording."""
    measured_anew = begun.value != given.value
    return begun.value if measured_anew or given.nominal is None else given.nominal


def _print(answer: dict[str, Any], out: Path) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)
    table = Table("parameter", "value", "95 % interval", "unit")
    for name, entry in answer["values"].items():
        interval = "none" if entry["low"] is None else f"{entry['low']:.5g} to {entry['high']:.5g}"
        table.add_row(name, f"{entry['value']:.5g}", interval, entry["unit"])
    console.print(table)
    if answer["each"]:
        names = list(answer["values"])
        parts = Table("recording", "direction", *names)
        for entry in answer["each"]:
            values = [f"{entry['values'][name]['value']:.5g}" for name in names]
            parts.add_row(entry["recording"], entry["direction"], *values)
        console.print(parts)
    for name, residual in answer["residuals"].items():
        console.print(f"residual of {name}: {residual['statement']}", soft_wrap=True)
    for sentence in (*answer["cannot_tell_apart"], *answer["notes"], f"written: {out}"):
        console.print(sentence, soft_wrap=True)
