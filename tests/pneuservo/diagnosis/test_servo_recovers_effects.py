"""Every effect of the servo, planted in two recordings, is expected there and is recovered.

The simulator plants it and the observer expects it: what the one does to the plant the other has to
follow. The fit is one of the search: all parameters of the rig move within their tolerances beside
the effect's.
"""

import dataclasses

import numpy as np
import pytest
from servo_recordings import noisy

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis.fitting import fit, polished
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import model_of
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

RIG = load_rig("single-axis")
MODEL = model_of(RIG.kind)
NOISE = {"displacement": 5e-6, "pressure_a": 200.0, "pressure_b": 200.0}
TIME = np.arange(0.0, 2.4, 1e-3)
DEMAND = np.repeat([0.004, 0.026, 0.012, 0.016, 0.024, 0.006, 0.015, 0.0], 300)
# Hard against both stops, a slow charge, then fast swings across the null.
COMMAND = np.select(
    [TIME < 0.3, TIME < 0.5, TIME < 0.9, TIME < 1.2, TIME < 1.4],
    [5.0, 0.0, -5.0, 0.0, 1.2],
    3.0 * np.sin(40.0 * TIME) + 0.6 * np.sin(7.0 * TIME),
)
LARGER = 1.3
"""Unless stated an effect is so many times as large as where its fit begins."""
STATED = {
    "chamber.wall-warming": {"conductance": 0.3, "capacity": 0.6, "resistance": 3.0},
    "endstop.contact": {"stiffness": 2e6, "damping": 400.0, "length": 5e-4},
    "friction.position": {"sine": 1.0, "cosine": -0.5, "length": 0.03},
    "friction.presliding": {"travel": 1e-3, "exponent": 1.5},
    "friction.run-in": {"coulomb": 0.1, "viscous": 0.03},
    "friction.stribeck": {"excess": 4.0, "speed": 0.01},
    "load.compliance": {"share": 0.3, "stiffness": 5e4, "damping": 60.0},
    "load.spring": {"stiffness": 200.0},
    "sensor.position-nonlinearity": {"bow": 5e-5, "first": 2e-5, "second": 1e-5},
    "valve.reattachment": {"loss": 0.15, "at_supply": 1.0, "attach": 0.5, "detach": 0.75},
    "valve.upstream-temperature": {"difference": -25.0},
}
WITHOUT_STOPS = ("load.backlash", "load.compliance")
"""How a load goes on swinging while a stop holds the piston nothing tells."""
UNSEEN = {
    "endstop.contact:damping": "the piston comes to rest within the samples that are not judged",
    "spool.stiction:time": "no rest of the spool is long enough",
    "supply.ripple:phase": "each recording has its own",
    "valve.reattachment:attach": "no pressure ratio passes it slowly",
}
AT_REST = "friction.breakaway-dwell"
"""What a piston holds that does not move is no less than this, and may be more."""
EFFECTS = {effect.id: effect for effect in MODEL.effects}
"""All but hum and steps of a reading, which the noise alone tells (`test_hum`,
`test_recording_warnings`)."""
UNEXPLAINED = 0.1
CLOSE = 0.1
CLOSE_OF = {"sensor.position-nonlinearity": 0.2}
"""Of waves along the stroke a zero that is followed as it wanders takes a part."""


def planted(effect):
    largest = {p.name: min(LARGER * p.starts[0], p.high) for p in effect.parameters}
    return STATED.get(effect.id, largest)


def cases_of(effect, values):
    rig, rng = dataclasses.replace(RIG, effects={effect.id: values}), np.random.default_rng(3)
    run = simulate(rig, time=TIME, controller=Proportional(), demand=DEMAND)
    closed = MODEL.cases(MODEL.completed(noisy(run, rng, NOISE), RIG), RIG)
    if effect.id in WITHOUT_STOPS:
        run = simulate(rig, time=TIME, controller=SlidingMode(), demand=DEMAND[::-1])
        return closed + MODEL.cases(MODEL.completed(noisy(run, rng, NOISE), RIG), RIG)
    run = simulate(rig, time=TIME, command=COMMAND)
    # A command that nothing closes the loop of is held from sample to sample.
    _, held, *_ = MODEL.readings(MODEL.cases(MODEL.completed(noisy(run, rng, NOISE), RIG), RIG))
    return closed + held


def beyond_noise(cases, values):
    left = [(case.measured - MODEL.predict(case, values))[case.usable] for case in cases]
    return sum(float(part @ part) - len(part) for part in left)


@pytest.mark.parametrize("name", [name for name in EFFECTS if name != AT_REST])
def test_a_planted_effect_is_expected_and_recovered(name):
    effect, values = EFFECTS[name], planted(EFFECTS[name])
    cases = cases_of(effect, values)
    baseline = beyond_noise(cases, {})
    here = {effect.key(key): value for key, value in values.items()}
    assert baseline > 1000.0
    assert beyond_noise(cases, here) < UNEXPLAINED * baseline
    found = polished(MODEL, cases, fit(MODEL, cases, Hypothesis().adding(name)))
    for key, true in here.items():
        if key not in UNSEEN:
            value, low, high = found.interval_of(lambda shared, own, key=key: shared[key])
            # Twice the 95 % interval, or the error that an identified parameter may have.
            close = CLOSE_OF.get(name, CLOSE) * abs(true)
            assert abs(value - true) < max(high - low, close), (key, true, value)


def test_a_breakaway_that_grows_with_rest_is_no_smaller_than_what_it_holds():
    effect, values = EFFECTS[AT_REST], {"excess": 10.0, "time": 0.3}
    rig = dataclasses.replace(RIG, effects={AT_REST: values})
    run = simulate(rig, time=TIME, command=0.1 * np.sin(5.0 * TIME))
    recording = MODEL.completed(noisy(run, np.random.default_rng(3), NOISE), RIG)
    _, cases, *_ = MODEL.readings(MODEL.cases(recording, RIG))
    baseline = beyond_noise(cases, {})
    here = {effect.key(key): value for key, value in values.items()}
    assert baseline > 1000.0
    assert beyond_noise(cases, here) < UNEXPLAINED * baseline
    found = fit(MODEL, cases, Hypothesis().adding(AT_REST))
    assert beyond_noise(cases, found.shared) < UNEXPLAINED * baseline
    assert found.shared[effect.key("excess")] < values["excess"]
