"""Friction of a seal from a slow drive at a held pressure."""

import numpy as np
import pytest

from pneuservo.errors import InputError
from pneuservo.identification import identify_seal_friction
from pneuservo.recordings import Recording

AREA = 0.25 * np.pi * 0.025**2


def driven(speeds, viscous=300.0, coulomb=5.0, offset=2.0, noise=0.1):
    """Strokes of 20 mm back and forth, one speed per pair, at 3 bar gauge [m/s]."""
    interval = 0.01
    position, x = 0.0, []
    for speed in speeds:
        for sign in (1.0, -1.0):
            steps = round(0.02 / (speed * interval))
            x.append(position + sign * speed * interval * np.arange(1, steps + 1))
            position = x[-1][-1]
    x = np.concatenate(x)
    time = interval * np.arange(len(x))
    velocity = np.gradient(x, interval)
    friction = viscous * velocity + coulomb * np.sign(velocity)
    force = 3e5 * AREA + offset - friction
    force = force + noise * np.random.default_rng(1).standard_normal(len(x))
    channels = {"displacement": x, "pressure_a": np.full_like(x, 4.013e5), "force": force}
    return Recording("driven", time, channels, "seal-tester", {"piston_diameter": 0.025})


def test_two_speeds_tell_viscous_from_coulomb_friction():
    found = identify_seal_friction([driven([0.005, 0.02, 0.005, 0.02])])
    for name, true in {
        "piston.viscous_friction": 300.0,
        "piston.coulomb_friction": 5.0,
        "sensor.force.offset": 2.0,
    }.items():
        estimate = found.values[name]
        # Four standard deviations, and a part in a thousand of the pressure force for the filter.
        assert abs(estimate.value - true) < 2.0 * estimate.half_width + 1e-3 * true, name


def test_one_speed_does_not_and_the_sentence_says_so():
    found = identify_seal_friction([driven([0.01, 0.01])])
    sentence = found.cannot_tell_apart()[0]
    assert "piston.viscous_friction and piston.coulomb_friction cannot be told apart" in sentence
    # What they add up to is known all the same.
    total = 0.01 * found.parameters["piston.viscous_friction"]
    total += found.parameters["piston.coulomb_friction"]
    assert total == pytest.approx(0.01 * 300.0 + 5.0, abs=0.05)


def test_a_piston_that_rests_is_refused():
    still = driven([0.01])
    channels = {**still.channels, "displacement": np.zeros(len(still))}
    with pytest.raises(InputError, match="samples move"):
        identify_seal_friction([Recording("still", still.time, channels, "seal-tester")])


def test_another_rig_is_refused():
    recording = driven([0.01])
    with pytest.raises(InputError, match="seal-tester is needed"):
        identify_seal_friction([recording], "single-axis")
