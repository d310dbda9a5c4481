"""``pneuservo design``: from requirements to weights, boundary layer and level."""

import json
import math
from dataclasses import asdict
from typing import Any

import click

from analog_card.console import Quantity

EXAMPLES = """\b
Examples:
  pneuservo design --settling-time 70ms
  pneuservo design --settling-time 0.1 --overshoot 0.02 --plot out/design.svg
  pneuservo design --rig my-rig.toml --range-space physical --json
"""


@click.command("design", epilog=EXAMPLES)
@click.option("--rig", default="single-axis", show_default=True, help="The plant: name or file.")
@click.option(
    "--settling-time",
    type=Quantity("s", 0.0),
    default=0.07,
    show_default=True,
    help="Of the sliding motion, 4/(damping wn), in s.",
)
@click.option("--damping", type=Quantity("", 0.0), help="Of the sliding motion.  [default: 1]")
@click.option(
    "--overshoot", type=Quantity(""), help="Largest, as a share of the step; instead of a damping."
)
@click.option(
    "--step", type=Quantity("m", 0.0), help="Largest step of the demand.  [default: the stroke]"
)
@click.option(
    "--level", type=Quantity("V", 0.0), help="Largest voltage.  [default: opens the valve fully]"
)
@click.option(
    "--boundary-layer",
    type=Quantity("m/s**2", 0.0),
    help="In m/s2.  [default: the narrowest that stays below the valve's frequency]",
)
@click.option(
    "--range-space",
    type=click.Choice(["trajectories", "physical", "linear"]),
    default="trajectories",
    show_default=True,
    help="Where the largest velocities and accelerations come from.",
)
@click.option("--plot", metavar="FILE", help="Draw the design: .svg, .png or .pdf.")
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(
    rig: str,
    settling_time: float,
    damping: float | None,
    overshoot: float | None,
    step: float | None,
    level: float | None,
    boundary_layer: float | None,
    range_space: str,
    plot: str | None,
    as_json: bool,
) -> None:
    """Design a sliding-mode controller for a rig.

    Weights, boundary layer and level for what the loop has to do, whether the surface is
    reachable, how long reaching takes, and what is left against disturbances. With warnings.
    """
    from pneuservo.command_line.baseline_rig import baseline_rig
    from pneuservo.errors import InputError
    from pneuservo.linear import servo_data
    from pneuservo.report.picture_files import require_picture, write_picture
    from pneuservo.sliding_mode.design import Requirements, design_sliding_mode
    from pneuservo.sliding_mode.pictures import design_figure
    from pneuservo.sliding_mode.surface import damping_from_overshoot

    if damping is not None and overshoot is not None:
        raise InputError("give either --damping or --overshoot: one follows from the other")
    if overshoot is not None:
        damping = damping_from_overshoot(overshoot)
    require_picture("--plot", plot)
    used = baseline_rig(rig)
    wanted = Requirements(
        settling_time,
        1.0 if damping is None else damping,
        step,
        level,
        boundary_layer,
        range_space,
    )
    found = design_sliding_mode(used, wanted)
    if plot is not None:
        write_picture(design_figure(found, servo_data(used)), plot)
    if as_json:
        click.echo(json.dumps(_report(found), indent=2))
    else:
        _print(found)


def _report(found: Any) -> dict[str, Any]:
    c1, c2, c3 = found.surface.weights
    values = asdict(found)
    values.pop("surface")
    # A loop that no gain makes unstable has an infinite margin, which JSON cannot say.
    if not math.isfinite(found.gain_margin):
        values["gain_margin"] = None
    return {
        "weights": {"c1": c1, "c2": c2, "c3": c3},
        "settling_time": found.surface.settling_time,
        "reachable": found.over_space.reachable,
        **values,
        "warnings": list(found.warnings),
    }


def _print(found: Any) -> None:
    from rich.console import Console
    from rich.table import Table

    c1, c2, _ = found.surface.weights
    fastest = "none" if found.fastest is None else f"{1e3 * found.fastest:.0f} ms"
    needed = f"{found.over_space.voltage:.2f} V of {found.level:g} V"
    pressure = found.required_supply_pressure
    supply = "none would do" if pressure is None else f"{1e-5 * pressure:.1f} bar"
    rows = (
        ("weight c1 of the displacement", f"{c1:.5g} 1/s2"),
        ("weight c2 of the velocity", f"{c2:.5g} 1/s"),
        ("weight c3 of the acceleration", "1"),
        ("boundary layer", f"{found.boundary_layer:.3g} m/s2"),
        ("level", f"{found.level:g} V"),
        ("equivalent control over the range space", needed),
        ("fastest surface reachable there", fastest),
        ("valve needed for this one, over the valve there is", f"{found.required_opening:.2f}"),
        ("supply pressure needed instead", supply),
        ("reaching time of the largest step", f"{1e3 * found.reaching_time:.0f} ms"),
        ("reserve in sliding", f"{found.reserve.reserve:.2f} V"),
        ("largest disturbance in sliding", f"{found.reserve.acceleration:.3g} m/s2"),
        ("settling time that itself would cycle", f"{1e3 * found.without_limit_cycle:.1f} ms"),
        ("gain margin inside the boundary layer", f"{found.gain_margin:.2f}"),
    )
    table = Table("", "")
    for name, value in rows:
        table.add_row(name, value)
    console = Console(highlight=False, markup=False)
    console.print(table)
    for warning in found.warnings:
        console.print(f"Warning: {warning}", soft_wrap=True)
