"""What every entry of the catalogue has to hold."""

import math

import pytest

from pneuservo.effects import CATALOGUE, effect_by_id, effects_of
from pneuservo.errors import InputError
from pneuservo.rigs import BUILT_IN_RIGS

ENTRIES = list(CATALOGUE.values())
RIGS = ("dead-volume", "seal-tester", "circuit")


@pytest.mark.parametrize("effect", ENTRIES, ids=CATALOGUE)
def test_an_entry_is_complete(effect):
    group, _, name = effect.id.partition(".")
    assert group
    assert name
    assert effect.statement.endswith(".")
    assert "the model" in effect.statement  # what the baseline does instead
    assert "=" in effect.equation
    assert effect.source
    assert effect.experiment
    assert set(effect.rigs) <= set(BUILT_IN_RIGS)
    assert effect.rigs


@pytest.mark.parametrize("effect", ENTRIES, ids=CATALOGUE)
def test_its_parameters_start_inside_their_range(effect):
    assert effect.parameters
    for parameter in effect.parameters:
        assert parameter.low <= parameter.neutral <= parameter.high or parameter.neutral == 0.0
        assert parameter.starts
        assert all(parameter.low <= start <= parameter.high for start in parameter.starts)
        assert math.isfinite(parameter.low)
        assert math.isfinite(parameter.high)
        assert parameter.meaning
    # A fit that started at the neutral size could not feel the shape.
    assert all(start != effect.parameters[0].neutral for start in effect.parameters[0].starts)


@pytest.mark.parametrize("effect", ENTRIES, ids=CATALOGUE)
def test_its_equation_names_its_parameters(effect):
    missing = [p.name for p in effect.parameters if p.name not in effect.equation]
    assert not missing


@pytest.mark.parametrize("rig", RIGS)
def test_every_rig_has_effects(rig):
    assert effects_of(rig)
    assert all(rig in effect.rigs for effect in effects_of(rig))


def test_an_unknown_effect_is_named_with_its_nearest():
    with pytest.raises(InputError, match=r"leakage\.orfice.*Did you mean 'leakage\.orifice'"):
        effect_by_id("leakage.orfice")
    assert effect_by_id("leakage.orifice") is CATALOGUE["leakage.orifice"]
