"""The rig of a command that reckons with the baseline's laws alone."""

from dataclasses import replace
from typing import TYPE_CHECKING

from analog_card.console import warn

if TYPE_CHECKING:
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

    rig = require_kind(name, "single-axis", effects=True)
    if not rig.effects:
        return rig
    warn(
        f"rig {name}: {', '.join(sorted(rig.effects))} is left out here; "
        "see what it changes with pneuservo simulate or campaign"
    )
    return replace(rig, effects={})
