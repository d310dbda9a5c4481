"""The effects of the card that no element of its netlist makes alone, and what is none of them.

The truth is the behavioural card of `analog_card`, op-amp by op-amp at 5 us, changed in one part;
what it has no part for is added to its voltages.
"""

from dataclasses import replace

import numpy as np
import pytest
import truth_card as truth
from reading_answers import entry_of, named

from analog_card.behaviour import CardBehaviour
from analog_card.behaviour_elements import figure_name
from analog_card.behaviour_model import run_behaviour
from analog_card.design import AMPLIFIERS
from analog_card.design_file import load_design
from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models import model_of
from pneuservo.diagnosis.models.card_kernels import limited_differentiator, limited_rate
from pneuservo.diagnosis.models.card_tolerances import stage_errors
from pneuservo.effects import effects_of
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig

RATE, SAMPLES, LEAD_IN = 10e3, 1200, 100
TIME = np.arange(SAMPLES) / RATE
DEMAND, SURFACE, OUTPUT = (
    truth.CHANNELS.index(n) for n in ("demand", "card_surface", "card_output")
)


def taps(elements=None, fast=0.35, change=lambda voltages: None, seed=1):
    """A recording of the behavioural card with some elements changed, or its voltages."""
    time = np.arange(SAMPLES + LEAD_IN) / RATE
    transducer = 5.0 + fast * np.cos(2 * np.pi * 60 * time)
    transducer += 2.0 * np.cos(2 * np.pi * 3 * time) + np.cos(2 * np.pi * 17 * time)
    demand = np.where(time % 0.12 < 0.06, 4.0, 6.0)
    run = run_behaviour(CardBehaviour(load_design(), elements or {}), time, transducer, demand)
    nodes = (run[name] for name in ("first", "second", "surface", "control"))
    voltages = np.array([transducer, demand, *nodes])[:, LEAD_IN:]
    change(voltages)
    voltages += truth.NOISE * np.random.default_rng(seed).standard_normal(voltages.shape)
    channels = dict(zip(truth.CHANNELS, voltages, strict=True))
    channels["demand"] = truth.METRES_PER_VOLT * channels["demand"]
    known = {name: truth.NOISE for name in truth.CHANNELS if name != "demand"}
    return Recording("taps", TIME, channels, "analogue-card", noise_rms=known)


def hum(voltages):
    voltages[SURFACE] += 0.05 * np.sin(2 * np.pi * 50 * TIME + 0.6)


def loaded(voltages):
    voltages[OUTPUT] *= 0.8


def hysteresis(voltages):
    """The output as a Schmitt trigger of 60 mV would have it, on the surface as it is."""
    side = 1.0
    for k, surface in enumerate(voltages[SURFACE]):
        if surface * side < -0.06:
            side = -side
        wanted = 20.83 * (surface + 0.06 * side)
        if abs(wanted) < 4.5 or abs(surface) < 0.3:
            voltages[OUTPUT, k] = np.clip(wanted, -5.0, 5.0)


# What is changed, the effect, its stage, the parameter, its value and how well it must be met.
PLANTED = {
    "feedback capacitor of the first differentiator doubled": (
        {"elements": {"xtaps.xvelocity.cfeedback": 940e-12}},
        ("card.differentiator-rolloff-1", "card.differentiator", "change", 1.0, 0.08),
    ),
    "series resistor of the second differentiator 200 ohm": (
        {"elements": {"xtaps.xacceleration.rseries": 200.0}},
        ("card.differentiator-rolloff-2", "card.differentiator", "change", 200 / 560 - 1, 0.08),
    ),
    "ground resistor of the boundary-layer amplifier 400 ohm": (
        # Of the gain, 1.53 times the nominal one, the tolerance of P3 takes up to 18 %.
        {"elements": {"xboundary.rground": 400.0}},
        ("card.boundary-slope", "card.boundary-layer", "change", 0.53, 0.2),
    ),
    "op-amps of 450 kHz": (
        # Behind the output follower and the second pole comes what the stage's lag leaves out.
        {"elements": {figure_name(name, "gain_bandwidth"): 0.45e6 for name in AMPLIFIERS}},
        ("card.opamp-bandwidth", "card.boundary-layer", "time", 9 / (2 * np.pi * 4.5e6), 0.3),
    ),
    "second differentiator swings to 6 V": (
        {
            "elements": {
                figure_name("acceleration", figure): 6.0
                for figure in ("positive_swing", "negative_swing")
            }
        },
        ("card.intermediate-clipping", "card.differentiator", "loss", 7.0, 0.05),
    ),
    "hum": ({"change": hum}, ("card.ground-hum", "card.surface", "sine", 0.05 * np.cos(0.6), 0.05)),
    "output loaded": ({"change": loaded}, ("card.output-load", "card.relay", "loss", 0.2, 0.1)),
    "hysteresis": (
        {"change": hysteresis},
        ("card.switch-hysteresis", "card.relay", "width", 0.06, 0.1),
    ),
}


@pytest.mark.parametrize("seed", [1, 2])
def test_an_op_amp_driven_into_its_swing_is_no_fault(seed):
    found = document(diagnose([taps(fast=0.7, seed=seed)]))
    assert found["verdict"] == "consistent"


@pytest.mark.parametrize("what", PLANTED)
def test_an_effect_is_located_named_and_measured(what):
    how, (effect, block, parameter, value, within) = PLANTED[what]
    found = document(diagnose([taps(**how)]))
    assert named(found) == {effect}
    entry = entry_of(found, effect)
    assert entry["block"] == found["located"][0]["block"] == block
    assert entry["parameters"][parameter]["value"] == pytest.approx(value, rel=within)


@pytest.mark.parametrize(
    ("tolerance", "capacitor", "healthy"),
    [("10 %", 109e-9, True), ("5 %", 109e-9, False), ("1 %", 104.5e-9, False)],
)
def test_a_capacitor_is_judged_by_the_tolerance_of_the_design(
    tmp_path, tolerance, capacitor, healthy
):
    (tmp_path / "card.toml").write_text(f'[tolerances.capacitor]\ntolerance = "{tolerance}"\n')
    recorded = replace(
        taps({"xtaps.xvelocity.cinput": capacitor}), card={"design": str(tmp_path / "card.toml")}
    )
    found = document(diagnose([recorded]))
    assert (found["verdict"] == "consistent") is healthy
    assert named(found) == (set() if healthy else {"card.differentiator-gain-1"})


def test_the_errors_of_the_stages_by_hand():
    errors = stage_errors(load_design())
    # Capacitors of 5 %, resistors of 1 %, evenly spread, 150 ppm/K over 30 K, and 1 % beside.
    sigma, most = errors["card_velocity"]["gain_error"]
    assert sigma == pytest.approx(np.hypot(0.01, np.hypot(0.05, 0.01) / np.sqrt(3)), rel=0.03)
    assert most == pytest.approx(0.05 + 0.01 + 0.0045 + 0.01, abs=0.002)
    # 5 mV of the op-amp, three times at most, and 3 mV of the recorder.
    sigma, most = errors["card_output"]["offset"]
    assert (sigma, most) == pytest.approx((np.hypot(5e-3, 3e-3), 18e-3), rel=0.01)


def test_a_wrong_sensitivity_is_a_wrong_parameter():
    def demanded_more(voltages):
        voltages[DEMAND] /= 1.08

    found = document(diagnose([taps(change=demanded_more)]))
    assert found["verdict"] == "parameter"
    corrected = found["corrected_parameters"]["sensor.displacement.sensitivity"]
    assert corrected["value"] == pytest.approx(1.08 / 3e-3, rel=2e-3)


def test_a_stage_without_its_tap_is_left_out():
    whole = taps()
    channels = {k: v for k, v in whole.channels.items() if k != "card_surface"}
    some = Recording("some", TIME, channels, "analogue-card", noise_rms=whole.noise_rms)
    assert set(document(diagnose([some]))["fit"]["channels"]) == {
        "card_velocity",
        "card_acceleration",
    }
    none = Recording("none", TIME, {"card_sensor": whole["card_sensor"]}, "analogue-card")
    with pytest.raises(InputError, match="card_velocity with card_sensor"):
        diagnose([none])


def test_a_recording_the_stages_cannot_be_fed_from_is_refused():
    whole = taps()
    with pytest.raises(InputError, match="at least 200 samples; the recording has 150"):
        diagnose([whole.slice(stop=0.015)])
    time = np.where(TIME > 0.1, TIME + 0.01, TIME)
    with pytest.raises(InputError, match=r"evenly spaced samples; at 0\.1 s"):
        diagnose([replace(whole, time=time)])


@pytest.mark.parametrize("effect", effects_of("analogue-card"), ids=lambda effect: effect.id)
def test_an_effect_vanishes_at_its_neutral_value_only(effect):
    model, rig = model_of("analogue-card"), load_rig("analogue-card")
    cases = model.cases(taps(fast=0.6), rig)
    sensitivity = {key: parameter.value for key, parameter in rig.parameters.items()}
    starts = {effect.key(p.name): p.starts[-1] for p in effect.parameters}
    changed = []
    for case in cases:
        baseline = model.predict(case, sensitivity)
        assert model.predict(case, sensitivity | effect.neutral) == pytest.approx(baseline)
        changed.append(np.max(np.abs(model.predict(case, sensitivity | starts) - baseline)))
    assert max(changed) > 1.0  # in units of the noise


def test_limits_that_are_not_reached_change_nothing():
    signal = np.sin(np.linspace(0.0, 20.0, 200))
    assert limited_differentiator(signal, -2.0, 2.0, np.inf, 0.01) == pytest.approx(signal)
    assert limited_rate(signal, -2.0, 2.0, 1.0) == pytest.approx(signal)


def test_a_differentiator_makes_good_the_charge_it_missed():
    # 2 V wanted for 20 samples of 1 V swing: the excess, 20, is made good by as many samples at
    # the swing with nothing wanted, but for what leaks away: share 1e-4 per sample.
    wanted = np.concatenate([np.full(20, 2.0), np.zeros(40)])
    limited = limited_differentiator(wanted, -1.0, 1.0, np.inf, 1e-4)
    assert np.sum(limited) == pytest.approx(np.sum(wanted), rel=0.01)
    assert limited[38] == 1.0
    assert limited[42] == pytest.approx(0.0, abs=1e-9)


def test_a_slow_output_ramps():
    step = np.concatenate([np.zeros(5), np.full(20, 10.0)])
    ramp = limited_rate(step, -9.0, 9.0, 1.0)
    assert np.max(np.diff(ramp)) == pytest.approx(1.0)
    assert ramp[-1] == 9.0
