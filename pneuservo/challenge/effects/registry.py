"""The list of all effects a case may conceal."""

from pneuservo.challenge.effects import (
    chamber,
    friction,
    load,
    network,
    outside,
    parameter,
    sensor,
    spool,
    valve,
)
from pneuservo.challenge.effects.concealed import NONE, ConcealedEffect, Form
from pneuservo.naming import require_known

_NOTHING = ConcealedEffect(
    "none", NONE, (), 1.0, 1.0, "", (Form("nothing", lambda truth, size: truth),)
)
CONCEALED: dict[str, ConcealedEffect] = {
    effect.id: effect
    for effect in (
        _NOTHING,
        *(
            effect
            for module in (
                parameter, spool, valve, network, chamber, friction, load, sensor, outside,
            )
            for effect in module.EFFECTS
        ),
    )
}  # fmt: skip


def concealed(effect_id: str) -> ConcealedEffect:
    """Return an effect by its id.

    Parameters
    ----------
    effect_id : str
        Such as ``"friction.pressure"``, ``"param.load.mass"`` or ``"none"``.

    Returns
    -------
    ConcealedEffect
        The effect.

    Raises
    ------
    InputError
        When there is none; the message names the nearest.

    Examples
    --------
    >>> concealed("leakage.rod-seal").blocks
    ('chamber.b',)
    """
    require_known(effect_id, CONCEALED, "concealed effect")
    return CONCEALED[effect_id]
