"""The command ``analog-card``."""

import click

from analog_card.console import CommandGroup


@click.group(cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="pneuservo")
def main() -> None:
    """Tune, simulate and verify the analogue sliding-mode control card."""
