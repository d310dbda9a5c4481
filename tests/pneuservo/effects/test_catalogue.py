"""What every entry of the catalogue has to hold."""

import math

import pytest

from pneuservo.effects import CATALOGUE, ENTRIES, TABLES, effect_by_id, effects_of
from pneuservo.effects.servo import SERVO_FIELDS, servo_effects
from pneuservo.errors import InputError
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.rigs import BUILT_IN_RIGS, load_rig

RIGS = ("dead-volume", "seal-tester", "circuit", "single-axis")
EFFECTS = (*ENTRIES, *TABLES)
IDS = [f"{effect.id} of {effect.rigs[0]}" for effect in EFFECTS]


def test_no_rig_has_an_id_twice():
    pairs = [(effect.id, rig) for effect in EFFECTS for rig in effect.rigs]
    assert len(set(pairs)) == len(pairs)
    assert set(CATALOGUE) == {effect.id for effect in EFFECTS}


@pytest.mark.parametrize("effect", EFFECTS, ids=IDS)
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


@pytest.mark.parametrize("effect", EFFECTS, ids=IDS)
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


@pytest.mark.parametrize("effect", EFFECTS, ids=IDS)
def test_its_equation_names_its_parameters(effect):
    missing = [p.name for p in effect.parameters if p.name not in effect.equation]
    assert not missing


@pytest.mark.parametrize("rig", RIGS)
def test_every_rig_has_effects(rig):
    assert effects_of(rig)
    assert all(rig in effect.rigs for effect in effects_of(rig))


def test_tables_are_part_of_a_model_and_no_hypotheses():
    for table in TABLES:
        assert effect_by_id(table.id, "single-axis") is table
        assert table not in effects_of("single-axis")
        assert table in effects_of("single-axis", tables=True)


def test_an_unknown_effect_is_named_with_its_nearest():
    with pytest.raises(InputError, match=r"leakage\.orfice.*Did you mean 'leakage\.orifice'"):
        effect_by_id("leakage.orfice")
    assert effect_by_id("leakage.orifice") is CATALOGUE["leakage.orifice"]


def test_an_id_with_a_law_per_rig_is_found_by_rig():
    tester, servo = (effect_by_id("friction.pressure", kind) for kind in ("seal-tester", RIGS[3]))
    assert [p.name for p in tester.parameters] == ["slope"]
    assert [p.name for p in servo.parameters] == ["sum", "difference"]
    with pytest.raises(InputError, match="kind circuit"):
        effect_by_id("friction.pressure", "circuit")


def test_every_parameter_of_the_servo_has_a_field_with_the_same_neutral_value():
    for effect in effects_of("single-axis", tables=True):
        for parameter in effect.parameters:
            block, name = parameter.field.split(".")
            assert getattr(getattr(NEUTRAL, block), name) == parameter.neutral, parameter
    known = {
        f"{block}.{name}" for block in NEUTRAL._fields for name in getattr(NEUTRAL, block)._fields
    }
    assert known == set(SERVO_FIELDS.values())


def test_neutral_values_are_the_baseline():
    neutral = {}
    for effect in effects_of("single-axis", tables=True):
        neutral |= effect.neutral
    assert servo_effects(neutral) == NEUTRAL


def test_values_reach_their_fields_and_shared_ones_add_up():
    effects = servo_effects(
        {
            "spool.null-bias:bias": 0.01,
            "chamber.heat-transfer:conductance": 0.1,
            "gas.moisture:conductance": 0.2,
        }
    )
    assert effects.spool.null_bias == 0.01
    assert effects.chamber.heat_conductance == pytest.approx(0.3)
    assert effects.friction == NEUTRAL.friction


def test_an_unknown_parameter_is_named_with_its_nearest():
    with pytest.raises(InputError, match=r"Did you mean 'spool\.null-bias:bias'"):
        servo_effects({"spool.null-bias:bais": 0.01})


def test_a_rig_file_may_hold_effects_of_the_servo(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text('[rig]\nkind = "single-axis"\n[effects]\n"valve.overlap" = { lap = 0.01 }\n')
    rig = load_rig(path)
    assert servo_effects(rig.effect_values).valve.overlap == 0.01
