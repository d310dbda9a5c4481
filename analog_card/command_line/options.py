"""What the subcommands share: options, examples, tables."""

from pathlib import Path
from typing import Any

import click

from analog_card.files import require_apart

DESIGN = click.option(
    "--design",
    "design_file",
    metavar="FILE",
    help="Design file of the card; without it the recommended card.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON and nothing else.")


def keep_design(design_file: str | None, *outputs: str | Path | None) -> None:
    """Refuse to write over the design that is read.

    Parameters
    ----------
    design_file : str or None
        What was given with --design.
    *outputs : str, Path or None
        Files that are going to be written, where they were asked for.

    Raises
    ------
    InputError
        When it is one of them.
    """
    if design_file is not None:
        require_apart([path for path in outputs if path is not None], [design_file])


def examples(*commands: str) -> str:
    """Return the end of a help text: commands that run as they stand."""
    lines = "\n".join(f"  analog-card {command}" for command in commands)
    return f"\b\nExamples:\n{lines}"


def table(title: str, *columns: str) -> Any:
    """Return an empty table, its first two columns of text, the others of numbers."""
    from rich.table import Table

    result = Table(title=title, title_justify="left")
    for number, column in enumerate(columns):
        result.add_column(column, justify="left" if number < 2 else "right")
    return result
