"""What both command lines share: errors without tracebacks, quantities as options, progress."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from analog_card.errors import AnalogCardError, InputError
from analog_card.quantities import to_si


class CommandGroup(click.Group):
    """A command group that turns the packages' own exceptions into messages.

    Exit status 2 for unusable input; an exception with an `exit_code` of its own keeps it.
    """

    own_errors: tuple[type[Exception], ...] = (AnalogCardError,)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; exceptions meant for the user become messages."""
        try:
            return super().invoke(ctx)
        except self.own_errors as problem:
            message, status = str(problem), getattr(problem, "exit_code", 2)
        except BrokenPipeError:
            # Whoever reads has seen enough, as head does; click ends quietly.
            raise
        except OSError as problem:
            where = f"{problem.filename}: " if problem.filename else ""
            message, status = f"{where}{problem.strerror or problem}", 2
        click.echo(f"Error: {message}", err=True)
        raise click.exceptions.Exit(status)


def warn(message: str) -> None:
    """Say on stderr what the user should know and need not act on.

    Parameters
    ----------
    message : str
        One sentence, without a full stop.
    """
    click.echo(f"Warning: {message}", err=True)


class Quantity(click.ParamType):
    """An option that takes a number in SI or a number with a unit, such as ``70ms``.

    Parameters
    ----------
    unit : str
        The SI unit of the value.
    minimum : float, optional
        The value has to be greater than this [unit].
    """

    def __init__(self, unit: str, minimum: float | None = None):
        self.unit = unit
        self.minimum = minimum
        self.name = unit or "number"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the value in SI."""
        try:
            number = to_si(value, self.unit, "value")
        except InputError as problem:
            # Click names the option itself.
            self.fail(str(problem).removeprefix("value: "), param, ctx)
        if self.minimum is not None and number <= self.minimum:
            self.fail(f"{value!r} is not greater than {self.minimum:g} {self.unit}", param, ctx)
        return number


class Count(click.IntRange):
    """An option that takes a whole number within limits, and says which where it is none.

    Parameters
    ----------
    min, max : int, optional
        The limits, which are allowed themselves.
    """

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number."""
        try:
            number = int(value)
        except ValueError:
            self.fail(f"{value!r} is not a whole number; allowed: {self._allowed}", param, ctx)
        low, high = self.min, self.max
        if (low is not None and number < low) or (high is not None and number > high):
            self.fail(f"{number} is out of range; allowed: {self._allowed}", param, ctx)
        return number

    @property
    def _allowed(self) -> str:
        if self.max is None:
            return f"{self.min} and more"
        return f"{self.min} to {self.max}"


@contextmanager
def writing(option: str, path: object) -> Iterator[None]:
    """Say which option's file or folder cannot be written, should it be so.

    Parameters
    ----------
    option : str
        As it is typed.
    path : object
        What was given with it.

    Raises
    ------
    InputError
        When the system refuses.
    """
    try:
        yield
    except OSError as problem:
        raise InputError(
            f"{option} {path}: cannot be written: {problem.strerror}; choose another folder"
        ) from problem


@contextmanager
def progress(total: int | None = None) -> Iterator[Any]:
    """Yield a function that names the step now running, in one line on standard error.

    Quiet when standard error is not a terminal.

    Parameters
    ----------
    total : int, optional
        How many steps there are; without it no count is shown.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
    )

    console = Console(stderr=True)
    columns: list[Any] = [SpinnerColumn(), TextColumn("{task.description}", markup=False)]
    if total is not None:
        columns += [BarColumn(bar_width=20), MofNCompleteColumn()]
    with Progress(
        *columns,
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not sys.stderr.isatty(),
    ) as bar:
        task = bar.add_task("starting", total=total, completed=-1)

        def step(description: str) -> None:
            bar.update(task, description=description, advance=1)

        yield step
