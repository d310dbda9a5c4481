"""The catalogue: physics that a baseline model may leave out, one small entry each."""

from pneuservo.effects.catalogue import CATALOGUE, ENTRIES, TABLES, effect_by_id, effects_of
from pneuservo.effects.effect import Effect, EffectParameter

__all__ = [
    "CATALOGUE",
    "ENTRIES",
    "TABLES",
    "Effect",
    "EffectParameter",
    "effect_by_id",
    "effects_of",
]
