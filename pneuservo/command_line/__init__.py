"""The command ``pneuservo``: one module per subcommand, loaded when it is called."""

import importlib

import click

from analog_card.console import CommandGroup
from analog_card.errors import AnalogCardError
from pneuservo.errors import PneuservoError

_COMMANDS = {
    "bench-tune": "Tune a card by its step response: P1 and P2, then P3.",
    "calibrate": "Calibrate a valve or a leak from the pressure of a dead volume.",
    "campaign": "Run a closed loop over grids and distributions of any of its numbers.",
    "catalogue": "List the physics that the diagnosis can name.",
    "challenge": "Put the diagnosis on trial: conceal effects, diagnose blindly, score.",
    "demo": "The main job end to end: tune, simulate, close the loop, diagnose, report.",
    "design": "Design a sliding-mode controller: weights, boundary layer, level, reachability.",
    "detectable": "Say which chattering a converter still sees.",
    "diagnose": "Say where and why a simulation differs from recordings.",
    "figure": "Move an animated figure, and see what its axes do to each other.",
    "identify": "Identify mass, friction and other values of a rig from recordings.",
    "limit-cycle": "Find how fast and how far a sliding-mode loop chatters, by every method.",
    "rigs": "List the built-in rigs, or write one out to make your own of it.",
    "simulate": "Simulate a rig: replay a recording's command, or close a loop.",
    "thesis": "Recompute the thesis' tables and stated results, with a verdict on each.",
    "tolerance": "Study what tolerances of the card do to the closed loop.",
    "tune": "Find potentiometer settings that are best in the worst rig of a stated set.",
}


class _LazyGroup(CommandGroup):
    own_errors = (PneuservoError, AnalogCardError)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(_COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in _COMMANDS:
            return None
        module = importlib.import_module(f"{__name__}.{name.replace('-', '_')}")
        command: click.Command = module.command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(sorted(_COMMANDS.items()))


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="pneuservo")
def main() -> None:
    """Simulate, tune and diagnose pneumatic servos."""
