"""The command ``analog-card``: one module per subcommand, loaded when it is called."""

import importlib

import click

from analog_card.console import CommandGroup

_COMMANDS = {
    "doctor": "Say whether the circuit simulator works on this computer.",
    "opamp": "Measure the op-amp's netlist against its data sheet.",
    "schematic": "Draw the card with its values.",
    "simulate": "Simulate a netlist, one of your own or one of the card.",
    "trade-off": "Weigh break frequency against noise and switching frequency.",
    "tune": "Find the settings of potentiometers P1 to P4.",
    "tolerance": "Study what tolerances of parts, op-amps and temperature do to the card.",
    "verify": "Compare the netlist of a channel with its behavioural equivalent.",
}


class _LazyGroup(CommandGroup):
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
    """Tune, simulate, draw and verify the analogue sliding-mode control card."""
