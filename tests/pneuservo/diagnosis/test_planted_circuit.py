"""Circuits with something planted in them: is it found, named and measured?"""

from dataclasses import replace

import pytest
import truth_circuit as truth
from reading_answers import assert_recovered, entry_of, named

from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models.circuit import CircuitModel
from pneuservo.rigs import load_rig

# Effect, what is planted, its parameter, and its value in the catalogue's unit: the truth's rate
# is divided by omega, and its damping signals are volts at the input.
SINGLE = [
    ("circuit.cubic-stiffness", "cubic", "coefficient", 4.0),
    ("circuit.quadratic-stiffness", "quadratic", "coefficient", 0.3),
    ("circuit.quintic-stiffness", "quintic", "coefficient", 30.0),
    ("circuit.cubic-damping", "cubic damping", "coefficient", 2.0 / truth.OMEGA**2),
    ("circuit.dry-damping", "dry", "level", 0.01 * truth.OMEGA),
]


def answer(seed, voltage, input_offset=0.0):
    recording = truth.recording(voltage, seed, input_offset=input_offset)
    return document(diagnose([recording]))


@pytest.mark.parametrize("seed", truth.SEEDS)
@pytest.mark.parametrize(
    ("effect", "law", "parameter", "value"), SINGLE, ids=[single[0] for single in SINGLE]
)
def test_one_effect(effect, law, parameter, value, seed):
    found = answer(seed, truth.output(law, seed))
    assert found["verdict"] == "missing-physics"
    assert named(found) == {effect}
    measured = entry_of(found, effect)["parameters"][parameter]
    if effect == "circuit.dry-damping":
        # Truth and catalogue round off the sign of the rate in different ways, over a tenth of
        # the rate's rms: some percent, which no interval knows of.
        assert measured["value"] == pytest.approx(value, rel=0.05)
    else:
        assert_recovered(measured, value)
    (channel,) = found["fit"]["channels"].values()
    assert channel["before"]["used"] > 3.0 * truth.NOISE
    # Two percent for the spread of 1600 samples' rms, the rest for the onset of the drive, which
    # is band-limited but for the moment at which it begins.
    assert channel["after"]["used"] < 1.1 * truth.NOISE


@pytest.mark.parametrize("seed", truth.SEEDS)
def test_two_stiffnesses_together(seed):
    found = answer(seed, truth.output("cubic and quadratic", seed))
    assert named(found) == {"circuit.cubic-stiffness", "circuit.quadratic-stiffness"}
    for effect, value in (("circuit.cubic-stiffness", 4.0), ("circuit.quadratic-stiffness", 0.3)):
        assert_recovered(entry_of(found, effect)["parameters"]["coefficient"], value)


@pytest.mark.parametrize("seed", truth.SEEDS)
def test_stiffness_and_damping_together(seed):
    found = answer(seed, truth.output("cubic and dry", seed))
    assert named(found) == {"circuit.cubic-stiffness", "circuit.dry-damping"}


@pytest.mark.parametrize("seed", truth.SEEDS)
def test_an_input_offset_within_its_tolerance_is_no_physics(seed):
    found = answer(seed, truth.linear_output(seed), input_offset=0.008)
    assert found["verdict"] == "consistent"


def test_a_circuit_on_a_bias_is_no_physics():
    # The state at the first sample is looked for beside what was read there, not beside zero.
    recording = truth.recording(truth.linear_output(1), 1)
    bias, channels = 2.5, dict(recording.channels)
    channels["circuit_input"] = channels["circuit_input"] + bias / truth.GAIN
    channels["circuit_output"] = channels["circuit_output"] + bias
    case = CircuitModel().prepare(replace(recording, channels=channels), load_rig("circuit"))
    first = CircuitModel().nuisances(case, frozenset())[0]
    assert first.low < first.start < first.high
    assert first.start == pytest.approx(bias, abs=0.5)


@pytest.mark.parametrize("seed", truth.SEEDS)
def test_an_input_offset_of_60_mv_is_a_wrong_parameter(seed):
    found = answer(seed, truth.linear_output(seed), input_offset=0.06)
    assert found["verdict"] == "parameter"
    assert set(found["corrected_parameters"]) == {"circuit.input_offset"}
    assert_recovered(found["corrected_parameters"]["circuit.input_offset"], 0.06)
