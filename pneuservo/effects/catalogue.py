"""The list of all effects."""

from pneuservo.effects import chamber, circuit, friction, leakage, load, sensor
from pneuservo.effects.effect import Effect
from pneuservo.naming import require_known

CATALOGUE: dict[str, Effect] = {
    effect.id: effect
    for module in (leakage, chamber, friction, load, sensor, circuit)
    for effect in module.EFFECTS
}


def effects_of(kind: str) -> tuple[Effect, ...]:
    """Return the effects that a kind of rig can show.

    Parameters
    ----------
    kind : str
        Kind of rig, such as ``"dead-volume"``.

    Returns
    -------
    tuple of Effect
        In the order of the catalogue; empty when there are none.

    Examples
    --------
    >>> [effect.id for effect in effects_of("dead-volume")][:2]
    ['leakage.orifice', 'leakage.laminar']
    """
    return tuple(effect for effect in CATALOGUE.values() if kind in effect.rigs)


def effect_by_id(effect_id: str) -> Effect:
    """Return an effect by its id.

    Parameters
    ----------
    effect_id : str
        Such as ``"friction.pressure"``.

    Returns
    -------
    Effect
        The entry of the catalogue.

    Raises
    ------
    InputError
        When there is none; the message names the nearest.
    """
    require_known(effect_id, CATALOGUE, "effect")
    return CATALOGUE[effect_id]
