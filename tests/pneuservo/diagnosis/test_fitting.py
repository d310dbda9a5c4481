"""Fits of the servo: they reach the optimum, and never end worse than they began."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import noisy, recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.fit import explained, orthonormal
from pneuservo.diagnosis.fitting import beyond_ridges, fit, polished
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import model_of
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

ANGLE = 1.0


@pytest.fixture(scope="module")
def tilted():
    """Return model, cases and baseline of a servo that is tilted."""
    rig = load_rig("single-axis")
    recording = recorded(
        rig.with_values({"load.gravity-angle:angle": ANGLE}), Proportional(), 5, duration=3.0
    )
    model = model_of(rig.kind)
    cases = model.cases(recording, rig)
    return model, cases, fit(model, cases, Hypothesis())


@pytest.fixture(scope="module")
def named(tilted):
    model, cases, baseline = tilted
    return fit(model, cases, Hypothesis().adding("load.gravity-angle"), baseline)


def test_a_size_that_begins_near_its_bound_is_found(tilted, named):
    _, _, baseline = tilted
    assert named.shared["load.gravity-angle:angle"] == pytest.approx(ANGLE, rel=0.1)
    assert explained(baseline, named) > 50.0


def test_the_last_fit_is_no_worse_and_hardly_elsewhere(tilted, named):
    model, cases, _ = tilted
    last = polished(model, cases, named)

    def cost(found):
        return float(np.sum(named.weigh(found.residuals) ** 2)) + found.penalty

    assert cost(last) <= cost(named) + 1e-6
    assert last.shared["load.gravity-angle:angle"] == pytest.approx(
        named.shared["load.gravity-angle:angle"], rel=0.05
    )


def test_an_effect_that_is_not_there_gains_next_to_nothing(tilted, named):
    model, cases, _ = tilted
    more = fit(model, cases, named.hypothesis.adding("leakage.chamber-a"), named)
    assert abs(explained(named, more)) < 20.0


def test_an_effect_of_several_sizes_of_either_sign_is_found():
    rig = load_rig("single-axis")
    errors = (0.06, -0.05, -0.08, -0.06, 0.05, 0.08)
    places = [f"{path}_{at}" for path in ("charge", "exhaust") for at in ("low", "middle", "high")]
    true = {f"spool.lineariser:{k}": e for k, e in zip(places, errors, strict=True)}
    model = model_of(rig.kind)
    cases = model.cases(recorded(rig.with_values(true), Proportional(), 6, duration=3.0), rig)
    baseline = fit(model, cases, Hypothesis())
    found = fit(model, cases, Hypothesis().adding("spool.lineariser"), baseline)
    known = [case.measured - model.predict(case, true) for case in cases]
    left = sum(
        float(np.sum(part[case.usable] ** 2)) for part, case in zip(known, cases, strict=True)
    )
    # As little as the true values leave, up to what as many parameters take of the noise.
    assert found.samples * found.rms**2 < left + 60.0
    assert explained(baseline, found) > 90.0


def test_values_stay_within_their_bounds_wherever_a_step_leads(tilted):
    _, cases, baseline = tilted
    far = np.full(len(baseline.keys), -1e6)
    shared, _ = baseline.moved(far)
    for key in baseline.tolerated:
        if key in shared and cases[0].rig[key] > 0.0:
            assert shared[key] > 0.0, key


def test_what_a_refit_absorbs_is_nothing_beyond_it(tilted):
    _, _, baseline = tilted
    absorbed = baseline.jacobian @ np.linspace(-1.0, 1.0, len(baseline.keys))
    beyond = baseline.beyond_refit(absorbed)
    whole = np.concatenate([absorbed, np.zeros(len(baseline.distance))])
    # But for what the tolerances hold back.
    held = whole - baseline.absorbed @ np.linalg.lstsq(baseline.absorbed, whole, rcond=None)[0]
    assert beyond == pytest.approx(held, abs=1e-6 * np.linalg.norm(whole))


def test_an_orthonormal_basis_leaves_out_what_is_nothing():
    basis = orthonormal(np.array([[3.0, 0.0], [4.0, 0.0], [0.0, 0.0]]))
    assert np.abs(basis[:, 0]) == pytest.approx([0.6, 0.8, 0.0])
    assert basis.shape == (3, 1)


def test_a_fit_finds_the_side_of_a_ridge_that_the_recording_is_on():
    """Whether the spool hits the end of its travel at a command a little below full voltage."""
    rig = load_rig("single-axis")
    key = "valve.spool.damping"
    calmer = rig.with_values({key: 1.12 * rig[key]})
    time = np.arange(0.0, 3.0, 1e-3)
    rng = np.random.default_rng(2)
    # With the nominal damping of 0.7 it swings to 1.005, with that of the recording to 0.985.
    voltage = 4.8 * np.repeat(rng.choice([-1.0, 1.0], 300), 10)
    start = InitialState(0.5 * rig["piston.stroke"])
    run = simulate(calmer, time=time, command=voltage, initial=start)
    model = model_of(rig.kind)
    _, held, *_ = model.readings(model.cases(noisy(run, rng), rig))
    found = beyond_ridges(model, held, fit(model, held, Hypothesis()))
    assert found.shared[key] == pytest.approx(calmer[key], rel=0.02)
    assert found.rms < 1.05


@pytest.fixture(scope="module")
def warm_leak():
    """Return model, cases and hypothesis of a leak beside heat, and the fit of heat alone."""
    rig, leak = load_rig("single-axis"), "leakage.chamber-a"
    leaking = rig.with_values(
        {f"{leak}:area": 3e-10, f"{leak}:laminar": 0.5, "chamber.heat-transfer:conductance": 0.1}
    )
    model = model_of(rig.kind)
    cases = model.cases(recorded(leaking, Proportional(), 5, duration=3.0), rig)
    warm = Hypothesis().adding("chamber.heat-transfer")
    beside = fit(model, cases, warm, fit(model, cases, Hypothesis()))
    return model, cases, warm.adding(leak), beside


def test_a_fit_that_has_come_to_a_bound_ends_where_others_do(warm_leak):
    # A dogleg was cut short there, 17 above what it reaches from elsewhere.
    model, cases, hypothesis, beside = warm_leak
    found = polished(model, cases, fit(model, cases, hypothesis, beside))
    for share in (0.0, 0.5, 1.0):
        begun = replace(found, shared=found.shared | {"leakage.chamber-a:laminar": share})
        assert abs(explained(found, polished(model, cases, begun))) < 1.0


def test_a_fit_may_begin_where_one_in_another_reading_has_ended(warm_leak):
    model, cases, hypothesis, beside = warm_leak
    short = fit(model, cases, hypothesis, beside)
    ended = polished(model, cases, short)
    again = fit(model, cases, hypothesis, beside, elsewhere=ended)
    assert explained(short, ended) > 10.0
    assert abs(explained(ended, again)) < 1.0
