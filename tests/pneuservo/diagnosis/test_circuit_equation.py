"""The equation of the circuit without effects against scipy's linear systems."""

import numpy as np
import pytest
import truth_circuit as truth
from scipy.signal import lsim

from pneuservo.diagnosis.models import model_of
from pneuservo.effects import effects_of
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig

VALUES = {
    "circuit.gain": truth.GAIN,
    "circuit.frequency": truth.FREQUENCY,
    "circuit.damping": truth.DAMPING,
    "circuit.input_offset": 0.01,
    "initial_output": 0.05,
    "initial_rate": -20.0,
}


def case(rate, seed=1, seconds=2.0):
    time = np.arange(int(seconds * rate)) / rate
    signal = truth.drive(time, seed)
    channels = {"circuit_input": signal, "circuit_output": np.zeros_like(signal)}
    recording = Recording("r", time, channels, "circuit")
    return model_of("circuit").prepare(recording, load_rig("circuit"))


def linear_response(time, seed=1, finer=40):
    """scipy's answer, the drive taken at every moment of a grid so fine that straight lines do."""
    w, damping = truth.OMEGA, truth.DAMPING
    matrices = (
        [[0.0, 1.0], [-(w**2), -2.0 * damping * w]],
        [[0.0], [truth.GAIN * w**2]],
        [[1.0, 0.0]],
        [[0.0]],
    )
    fine = np.arange((len(time) - 1) * finer + 1) * (time[1] / finer)
    drive = truth.drive(fine, seed) - VALUES["circuit.input_offset"]
    start = [VALUES["initial_output"], VALUES["initial_rate"]]
    return lsim(matrices, drive, fine, X0=start)[1][::finer]


def error(rate):
    prepared = case(rate)
    response = linear_response(prepared.recording.time)
    difference = model_of("circuit").predict(prepared, VALUES) - response
    # At both ends the input between the samples is not known: 25 samples of the interpolating
    # filter, and the circuit rings on for 1/(damping omega) = 28 ms.
    inside = slice(int(0.3 * rate), -int(0.1 * rate))
    return float(np.std(difference[inside]) / np.std(response))


def test_it_is_the_linear_response():
    # Two Runge-Kutta steps per sample are 0.21 rad of the natural motion each and err by
    # 0.21^5/120; the circuit remembers 1/(0.21 damping) = 60 of them, which makes 2e-4.
    assert error(truth.RATE) < 2e-4


def test_the_error_falls_with_the_fourth_power_of_the_step():
    # What the interpolation of the input errs, 3e-5, is a fifth of the smaller error; the two
    # have nothing to do with each other and add as squares: 2 %.
    ratio = error(0.6 * truth.RATE) / error(truth.RATE)
    assert ratio == pytest.approx(0.6**-4, rel=0.1)


def test_effects_at_neutral_change_nothing():
    prepared, model = case(truth.RATE, seconds=0.5), model_of("circuit")
    neutral = {k: v for effect in effects_of("circuit") for k, v in effect.neutral.items()}
    with_effects = model.predict(prepared, VALUES | neutral)
    assert np.array_equal(with_effects, model.predict(prepared, VALUES))


@pytest.mark.parametrize("effect", effects_of("circuit"), ids=lambda e: e.id)
def test_effects_at_their_size_change_something(effect):
    prepared, model = case(truth.RATE, seconds=0.5), model_of("circuit")
    values = VALUES | {effect.key(p.name): p.starts[0] for p in effect.parameters}
    difference = model.predict(prepared, values) - model.predict(prepared, VALUES)
    assert np.max(np.abs(difference)) > 1e-7


def test_the_first_guess_comes_close_to_a_linear_circuit():
    clean = truth.recording(truth.linear_output(3), 3, noise=0.0)
    model = model_of("circuit")
    guess = model.first_guess(model.prepare(clean, load_rig("circuit")))
    # A difference equation of second order with held inputs: a start, not an estimate.
    assert guess["circuit.frequency"] == pytest.approx(truth.FREQUENCY, rel=0.1)
    assert guess["circuit.gain"] == pytest.approx(truth.GAIN, rel=0.2)
    assert guess["circuit.damping"] == pytest.approx(truth.DAMPING, rel=0.5)
