"""The rig of a command, and warnings of what it is not: what is left out, what does not fit."""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from analog_card.console import warn

if TYPE_CHECKING:
    from analog_card.design import Design
    from pneuservo.rigs import Rig


def baseline_rig(name: str) -> "Rig":
    """Return a rig of kind single-axis as a linear or a simple model has it, and say what it lacks.

    Parameters
    ----------
    name : str
        Of a built-in rig, or a rig file, such as the ``model.toml`` of a diagnosis.

    Returns
    -------
    Rig
        Without effects; where it has some, a warning on standard error names them.

    Raises
    ------
    InputError
        When there is no such rig, or it is of another kind.
    """
    from pneuservo.simulation.inputs import require_kind

    return without_effects(require_kind(name, "single-axis", effects=True), name)


def without_effects(rig: "Rig", name: str) -> "Rig":
    """Return a rig without effects; where it has some, a warning on standard error names them.

    Parameters
    ----------
    rig : Rig
        Of kind single-axis.
    name : str
        As it was given.
    """
    if not rig.effects:
        return rig
    warn_left_out(name, rig.effects)
    return replace(rig, effects={})


def warn_left_out(name: str, effects: Iterable[str]) -> None:
    """Say on standard error which effects a command leaves out.

    Parameters
    ----------
    name : str
        Of the rig, as it was given.
    effects : iterable of str
        Their ids.
    """
    warn(
        f"rig {name}: {', '.join(sorted(effects))} is left out here; see what it changes with "
        "pneuservo simulate or campaign and a continuous controller"
    )


def warn_of_transducer(design: "Design | None", rig: "Rig") -> None:
    """Say on standard error when a card was designed for another transducer than a rig has.

    Parameters
    ----------
    design : Design or None
        Of the card; None where there is no card.
    rig : Rig
        Of kind single-axis.
    """
    from pneuservo.controllers.requirements import other_transducer

    if design is not None and (problem := other_transducer(design, rig)):
        warn(problem)
