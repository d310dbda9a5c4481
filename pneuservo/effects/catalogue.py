"""The list of all effects."""

from pneuservo.effects import (
    card,
    chamber,
    circuit,
    endstop,
    friction,
    leakage,
    line,
    load,
    sensor,
    spool,
    supply,
    unexplained,
    valve,
)
from pneuservo.effects.effect import Effect
from pneuservo.naming import require_known

_BY_BLOCK = (
    spool, valve, supply, line, leakage, chamber, friction, load, endstop, sensor, circuit, card,
)  # fmt: skip

ENTRIES: tuple[Effect, ...] = tuple(effect for module in _BY_BLOCK for effect in module.EFFECTS)
"""Every effect that has a name. An id stands twice where two kinds of rig show the same physics in
laws of their own; no kind of rig has an id twice."""

TABLES: tuple[Effect, ...] = unexplained.EFFECTS
"""What stands for physics without a name: no hypothesis to search, but part of a model."""

CATALOGUE: dict[str, Effect] = {effect.id: effect for effect in reversed((*ENTRIES, *TABLES))}
"""Id to entry, tables included; the first one where there are two."""


def effects_of(kind: str, *, tables: bool = False) -> tuple[Effect, ...]:
    """Return the effects that a kind of rig can show.

    Parameters
    ----------
    kind : str
        Kind of rig, such as ``"dead-volume"``.
    tables : bool, optional
        Whether `TABLES` count, which a model may hold but a search does not propose.

    Returns
    -------
    tuple of Effect
        In the order of the catalogue; empty when there are none.

    Examples
    --------
    >>> [effect.id for effect in effects_of("dead-volume")][:2]
    ['leakage.orifice', 'leakage.laminar']
    """
    entries = (*ENTRIES, *TABLES) if tables else ENTRIES
    return tuple(effect for effect in entries if kind in effect.rigs)


def effect_by_id(effect_id: str, kind: str = "") -> Effect:
    """Return an effect by its id.

    Parameters
    ----------
    effect_id : str
        Such as ``"friction.pressure"``.
    kind : str, optional
        Kind of rig; decides where two kinds show it in laws of their own.

    Returns
    -------
    Effect
        The entry of the catalogue.

    Raises
    ------
    InputError
        When there is none; the message names the nearest.
    """
    known = {effect.id: effect for effect in effects_of(kind, tables=True)} if kind else CATALOGUE
    require_known(effect_id, known, f"effect of a rig of kind {kind}" if kind else "effect")
    return known[effect_id]
