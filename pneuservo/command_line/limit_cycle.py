"""``pneuservo limit-cycle``: how fast and how far a sliding-mode loop chatters, by every method."""

import json
from typing import Any

import click

from analog_card.console import Quantity, progress

EXAMPLES = """\b
Examples:
  pneuservo limit-cycle
  pneuservo limit-cycle --filter all --plot cycle.svg
  pneuservo limit-cycle --differentiation backward --sampling-time 1ms --json
"""


@click.command("limit-cycle", epilog=EXAMPLES)
@click.option(
    "--rig", default="single-axis", show_default=True, help="A rig of kind single-axis, or a file."
)
@click.option(
    "--position",
    type=Quantity("m", 0.0),
    default=0.015,
    show_default=True,
    help="Displacement controlled to, in m.",
)
@click.option(
    "--model",
    type=click.Choice(["advanced", "conventional"]),
    default="advanced",
    show_default=True,
    help="Linear model; the conventional one is that of a symmetric cylinder.",
)
@click.option("--valve/--no-valve", default=True, help="With or without the valve's dynamics.")
@click.option(
    "--settling-time",
    type=Quantity("s", 0.0),
    default=0.07,
    show_default=True,
    help="Of the sliding surface, 4/(damping wn), in s.",
)
@click.option("--damping", type=Quantity("", 0.0), default=1.0, show_default=True)
@click.option("--level", type=Quantity("V", 0.0), help="Largest voltage.  [default: valve full]")
@click.option(
    "--boundary-layer",
    type=Quantity("m/s**2"),
    default=0.0,
    show_default=True,
    help="Surface value at which the voltage reaches its level; 0 for a relay.",
)
@click.option(
    "--sampling-time",
    type=Quantity("s"),
    default=0.0,
    show_default=True,
    help="Of a digital controller; 0 for an analogue one.",
)
@click.option(
    "--differentiation",
    type=click.Choice(["measured", "backward", "bilinear", "analogue"]),
    default="measured",
    show_default=True,
    help="How velocity and acceleration come about.",
)
@click.option(
    "--break-frequency",
    type=Quantity("Hz", 0.0),
    help="Both breaks of both analogue differentiators.  [default: the recommended card's]",
)
@click.option(
    "--filter",
    "filtered",
    type=click.Choice(["none", "all", "displacement-velocity"]),
    default="none",
    show_default=True,
    help="States behind a Butterworth filter of second order.",
)
@click.option(
    "--filter-frequency", type=Quantity("Hz", 0.0), help="Its cut-off, in Hz.  [default: 500]"
)
@click.option(
    "--plot",
    metavar="FILE",
    help="Draw the open loop, the surface and the step: .svg, .png or .pdf.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(
    rig: str,
    position: float,
    model: str,
    valve: bool,
    settling_time: float,
    damping: float,
    level: float | None,
    boundary_layer: float,
    sampling_time: float,
    differentiation: str,
    break_frequency: float | None,
    filtered: str,
    filter_frequency: float | None,
    plot: str | None,
    as_json: bool,
) -> None:
    """Find the limit cycle of a sliding-mode loop: frequency, amplitude, asymmetry, error.

    By the describing function, the exact method of Tsypkin, and simulations of the linear and
    the non-linear plant, side by side.
    """
    from pneuservo.command_line.baseline_rig import baseline_rig
    from pneuservo.command_line.unused_options import refuse_unused
    from pneuservo.limit_cycle import Signals, compare, rig_loop
    from pneuservo.limit_cycle.pictures import overview
    from pneuservo.report.picture_files import require_picture, write_picture

    require_picture("--plot", plot)
    if filtered == "none":
        refuse_unused({"filter_frequency": filter_frequency}, "--filter none")
    if differentiation != "analogue":
        unused = {"break_frequency": break_frequency}
        refuse_unused(unused, f"--differentiation {differentiation}")
    used = baseline_rig(rig)
    velocity_breaks, acceleration_breaks = _breaks(break_frequency)
    signals = Signals(
        differentiation,
        sampling_time,
        filtered,
        Signals.filter_frequency if filter_frequency is None else filter_frequency,
        velocity_breaks,
        acceleration_breaks,
    )
    loop = rig_loop(
        used,
        position,
        settling_time=settling_time,
        damping=damping,
        level=level,
        boundary_layer=boundary_layer,
        signals=signals,
        valve=valve,
        model=model,
    )
    with progress() as step:
        found = compare(loop, used, position, step=step)
    if plot is not None:
        write_picture(overview(loop, found), plot)
    report = _report(loop, found, used, position, plot)
    if as_json:
        click.echo(json.dumps(report, indent=2))
    else:
        _print(report)


def _breaks(frequency: float | None) -> tuple[tuple[float, float], tuple[float, float]]:
    if frequency is not None:
        return (frequency, frequency), (frequency, frequency)
    from analog_card.design_file import load_design
    from analog_card.figures import card_figures

    figures = card_figures(load_design())
    (first, second), (third, fourth) = figures.velocity_breaks, figures.acceleration_breaks
    return (first, second), (third, fourth)


def _report(loop: Any, found: Any, rig: Any, position: float, plot: str | None) -> Any:
    from analog_card.linear_servo import converter_step, detectable_frequency

    seen = converter_step(rig["piston.stroke"])
    return {
        "rig": rig.name,
        "position": position,
        "weights": list(loop.weights),
        "level": loop.level,
        "boundary_layer": loop.boundary_layer,
        "gain_asymmetry": loop.asymmetry,
        "signals": vars(loop.signals),
        "methods": {name: finding.to_dict() for name, finding in found.items()},
        "detectable_frequency": detectable_frequency(loop.servo, loop.level, seen),
        "plot": plot,
    }


def _print(report: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    titles = {name: name.replace("_", " ") for name in report["methods"]}
    titles["nonlinear_simulation"] = "non-linear simulation"
    table = Table("method", "frequency", "surface, m/s2", "asymmetry", "mean error", "stable")
    for name, values in report["methods"].items():
        error = values["mean_error"]
        shown = "" if error is None else f"{1e3 * error:+.3f} mm"
        title = titles[name]
        if values["frequency"] is None:
            table.add_row(title, "none", "", "", shown, "")
            continue
        table.add_row(
            title,
            f"{values['frequency']:.1f} Hz",
            f"{values['high']:+.2f} {values['low']:+.2f}",
            f"{100 * values['asymmetry']:+.0f} %",
            shown,
            "yes" if values["stable"] else "no",
        )
    console = Console(highlight=False, markup=False)
    console.print(table)
    for name, values in report["methods"].items():
        if values["note"]:
            console.print(f"{titles[name]}: {values['note']}", soft_wrap=True)
    console.print(
        "a 12-bit converter sees the chattering of the piston up to "
        f"{report['detectable_frequency']:.0f} Hz",
        soft_wrap=True,
    )
    if report["plot"]:
        console.print(f"written: {report['plot']}", soft_wrap=True)
