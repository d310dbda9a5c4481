"""``pneuservo demo``: the main job end to end."""

import json
from pathlib import Path

import click

from analog_card.console import Count, progress
from analog_card.design_file import design_to_toml
from analog_card.files import write_files
from analog_card.plain_json import plain_json
from pneuservo.command_line.recording_files import read, require_unread

_EPILOG = """\b
Examples:
  pneuservo demo --out out/demo
  pneuservo demo --out out/mine --recording out/demo/example/leaking-volume.csv
"""


@click.command("demo", epilog=_EPILOG)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("out/demo"),
    show_default=True,
    help="Folder for the results.",
)
@click.option(
    "--recording",
    type=click.Path(path_type=Path),
    help="Your own recording, in place of the example.",
)
@click.option(
    "--seed", type=Count(min=0), default=0, show_default=True, help="Seed of the example's noise."
)
def command(out: Path, recording: Path | None, seed: int) -> None:
    """Tune the card, run its netlist, close the loop, diagnose a recording, and report."""
    from pneuservo.demo import run_demo, summary
    from pneuservo.diagnosis import document
    from pneuservo.report.answer_files import NAMES, answer_files
    from pneuservo.report.demo_page import demo_page
    from pneuservo.report.words import headline
    from pneuservo.simulation.trials import processors

    # The recording first: a mistake in it should not cost the user the other steps' time.
    source = None if recording is None else read(str(recording), None)
    if source is not None:
        require_unread([out / name for name in (*NAMES, "card.toml", "summary.json")], [source])
    with progress() as step:
        demo = run_demo(out, source, seed, step, processors())
        step("writing the report")
        answer = document(demo.diagnosis)
        files = {
            "card.toml": design_to_toml(demo.tuning.design),
            "summary.json": json.dumps(plain_json(summary(demo, answer)), indent=2) + "\n",
            **answer_files(demo.diagnosis, answer),
            "report.html": demo_page(demo, answer),
        }
        write_files(out, files)
    pots = ", ".join(f"{p.name} {p.fraction:.3f}" for p in demo.tuning.potentiometers)
    worst = max(d.worst / d.limit for d in demo.verification.deviations if d.limit)
    settling = max(s.settling_time for s in demo.loop.step_responses())
    click.echo(f"card:      {pots} (fraction of travel)")
    click.echo(f"netlist:   worst deviation {worst:.2%} of its limit")
    click.echo(f"loop:      slowest step settles within {settling * 1e3:.0f} ms")
    click.echo(f"diagnosis: {answer['verdict']}: {headline(answer)}")
    click.echo(f"report:    {out / 'report.html'}")
