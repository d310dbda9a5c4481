"""A card with one element changed in its netlist: is the stage found and the fault named?"""

import numpy as np
import pytest
import truth_card as truth
from reading_answers import assert_recovered, entry_of, named

from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models.analogue_card import AnalogueCardModel
from pneuservo.diagnosis.replay import replay_model
from pneuservo.rigs import load_rig

_DESIGN = load_design()
_SURFACE = _DESIGN.soldered.surface_amplifier
_FRACTION = _DESIGN.turned.displacement_weight
_AHEAD = (
    _SURFACE.displacement_resistance
    + _FRACTION * (1.0 - _FRACTION) * _SURFACE.displacement_potentiometer
)
_WEIGHTS = card_figures(_DESIGN)
# What a summer with resistors of 1 V/V, w_x, w_v and w_a makes of its own offset.
_NOISE_GAIN = 1.0 + sum(
    (
        _SURFACE.feedback_resistance / _AHEAD,
        _SURFACE.feedback_resistance / _SURFACE.velocity_resistance,
        _WEIGHTS.weight_acceleration,
    )
)
# Effect, stage, the parameter that is planted and its value.
NAMED = {
    "first capacitor 12 % low": (
        "card.differentiator-gain-1", "card.differentiator", "error", -0.12,
    ),
    "second capacitor 15 % high": (
        "card.differentiator-gain-2", "card.differentiator", "error", 0.15,
    ),
    "first capacitor leaks": ("card.capacitor-leak", "card.differentiator", "first", 0.12),
    "offset of the surface amplifier": ("card.offset", "card.surface", "surface", None),
    "offset of the first differentiator": (
        "card.offset", "card.differentiator", "differentiator_1", 0.05,
    ),
    "wiper of P1": (
        "card.weight-loading", "card.surface", "displacement", 20e3 / (_AHEAD + 20e3),
    ),
    "asymmetric clamp": ("card.rail-asymmetry", "card.relay", "negative", None),
    "supplies of 10 V": ("card.supply-sag", "card.surface", "drop", 5.0),
    "slow op-amps": ("card.opamp-slew", "card.boundary-layer", "time", 1.0 / 0.05e6),
}  # fmt: skip

_BESIDE = ("card.capacitor-leak", "card.supply-sag", "card.opamp-slew")
"""Measured in tests of their own."""


@pytest.fixture(scope="module")
def answers():
    """Return a function that diagnoses a fault once."""
    found = {}

    def answer(fault):
        if fault not in found:
            found[fault] = document(diagnose([truth.recording(fault, 1)]))
        return found[fault]

    return answer


@pytest.mark.parametrize("seed", range(1, 7))
def test_a_healthy_card_is_consistent(seed):
    found = document(diagnose([truth.recording("healthy", seed)]))
    assert found["verdict"] == "consistent"
    assert found["missing"] == []
    assert found["corrected_parameters"] == {}


def test_the_transducer_of_a_design_is_the_one_that_was_recorded(tmp_path):
    # 10 V over 50 mm: the same volts are five thirds of the travel.
    (tmp_path / "card.toml").write_text('[transducer]\nfull_scale_displacement = "50 mm"\n')
    taken = truth.recording("healthy", 1, card={"design": str(tmp_path / "card.toml")})
    taken.channels["demand"] *= 5.0 / 3.0
    found = document(diagnose([taken]))
    assert found["verdict"] == "consistent"
    # What a rig says itself counts more.
    own = load_rig("analogue-card").with_values({"sensor.displacement.sensitivity": 198.0})
    (case, *_) = AnalogueCardModel(own.kind).cases(taken, own)
    assert case.rig["sensor.displacement.sensitivity"] == 198.0


@pytest.mark.parametrize("fault", NAMED)
def test_a_fault_is_located_and_named(fault, answers):
    effect, block, parameter, value = NAMED[fault]
    found = answers(fault)
    assert found["verdict"] == "missing-physics"
    assert found["located"][0]["block"] == block
    assert named(found) == {effect}
    entry = entry_of(found, effect)
    assert entry["block"] == block
    if value is not None and effect not in _BESIDE:
        assert_recovered(entry["parameters"][parameter], value)


def test_the_leak_is_measured(answers):
    # Of the transducer's movement, 2 V, the frequencies that drown in 2 mV of noise are left out.
    leak = entry_of(answers("first capacitor leaks"), "card.capacitor-leak")["parameters"]
    assert leak["first"]["value"] == pytest.approx(0.12, rel=0.005)


def test_the_size_of_a_limit_is_found(answers):
    # Swing and rate are the macromodel's, which the model of the diagnosis has from the same
    # design, but for the soft clamp (0.1 V) and the samples' spacing, which no interval knows of.
    sag = entry_of(answers("supplies of 10 V"), "card.supply-sag")["parameters"]
    assert sag["drop"]["value"] == pytest.approx(5.0, abs=0.15)
    slew = entry_of(answers("slow op-amps"), "card.opamp-slew")["parameters"]
    assert slew["time"]["value"] == pytest.approx(20e-6, rel=0.03)


def test_the_repair_reaches_the_noise(answers):
    for fault in ("first capacitor 12 % low", "wiper of P1", "asymmetric clamp"):
        for channel in answers(fault)["fit"]["channels"].values():
            # 1200 samples: the spread of their rms is 2 %.
            assert channel["after"]["used"] < 1.1 * channel["noise_rms"]


def test_the_offset_of_the_summer_is_magnified_by_its_noise_gain(answers):
    # 60 mV, of which 5 mV are the typical offset that every stage has, and the track of P2 that
    # loads its input by 0.4 %: within 3 %.
    shift = entry_of(answers("offset of the surface amplifier"), "card.offset")["parameters"]
    assert shift["surface"]["value"] == pytest.approx(0.06 * _NOISE_GAIN, rel=0.1)


@pytest.mark.parametrize(("noise", "stated"), [(1e-3, True), (5e-3, True), (2e-3, False)])
def test_other_noise_raises_no_alarm(noise, stated):
    found = document(diagnose([truth.recording("healthy", 11, noise, stated)]))
    assert found["verdict"] == "consistent"


def test_the_figures_of_a_sidecar_are_as_good_as_the_design():
    figures = card_figures(_DESIGN)
    names = (
        "rc_velocity", "rc_acceleration", "weight_displacement", "weight_velocity",
        "weight_acceleration", "surface_limit", "output_gain", "level",
    )  # fmt: skip
    card = {name: getattr(figures, name) for name in names} | {"break_frequency": 2.83e3}
    healthy = document(diagnose([truth.recording("healthy", 1, card=card)]))
    assert healthy["verdict"] == "consistent"
    faulty = document(diagnose([truth.recording("wiper of P1", 1, card=card)]))
    assert named(faulty) == {"card.weight-loading"}


def test_a_recording_of_the_card_is_replayed():
    """Through the model that `pneuservo simulate` runs where no plant is recorded."""
    recorded = truth.recording("healthy", 1)
    run = replay_model(recorded, load_rig("analogue-card"))
    replayed = [name for name in recorded.channels if not np.array_equal(run[name], recorded[name])]
    assert "card_output" in replayed
    for name in replayed:
        rms = np.sqrt(np.nanmean((run[name] - recorded[name]) ** 2))
        assert rms < 0.5 * np.nanstd(recorded[name]), name
