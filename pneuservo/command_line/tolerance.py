"""``pneuservo tolerance``: what tolerances of the card do to the closed loop."""

from pathlib import Path

import click

from analog_card.command_line.options import keep_design
from analog_card.command_line.tolerance import REPORT, parsed_limits, report, study_options
from analog_card.command_line.tolerance_options import with_tolerances
from analog_card.console import Count, progress
from analog_card.design_file import load_design
from pneuservo.command_line.baseline_rig import warn_of_transducer
from pneuservo.rigs import load_rig
from pneuservo.tolerance import ALL_FIGURES, study_loop

_EPILOG = """\b
Examples:
  pneuservo tolerance --trials 4
  pneuservo tolerance --trials 2 --capacitor 0.01 --limit steady_state_error=-0.3mm..0.3mm --json
"""


@click.command("tolerance", epilog=_EPILOG)
@click.option(
    "--trials", type=Count(min=2), default=1000, show_default=True, help="Cards simulated."
)
@click.option("--rig", default="single-axis", show_default=True, help="The plant: name or file.")
@study_options
def command(
    trials: int,
    rig: str,
    seed: int,
    jobs: int,
    limit: tuple[str, ...],
    out: str | None,
    design_file: str | None,
    as_json: bool,
    **tolerances: float | None,
) -> None:
    """Study what tolerances of the card do to the closed loop.

    A step of 30 % of the stroke with the boundary layer and with the relay: settling, error and
    limit cycle of every card, worst cases by corners, and which part matters most. Tolerances are
    those of the design file; options replace them.
    """
    if out is not None:
        keep_design(design_file, Path(out) / REPORT)
    design, plant = with_tolerances(load_design(design_file), tolerances), load_rig(rig)
    warn_of_transducer(design, plant)
    with progress() as step:
        study = study_loop(
            design,
            plant,
            trials,
            seed,
            parsed_limits(limit, ALL_FIGURES),
            out,
            jobs,
            step,
        )
    report(study, out, as_json)
