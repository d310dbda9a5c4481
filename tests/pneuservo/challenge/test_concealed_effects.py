"""Every effect of the truth: it can be simulated, shows, and vanishes with its size."""

import ast
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pneuservo.challenge
from pneuservo.challenge import concealment
from pneuservo.challenge.cases import write_case
from pneuservo.challenge.concealment import LARGEST_RETUNING, Concealed, Scene, of_size, retuned
from pneuservo.challenge.dress import draw_habit, write_dressed
from pneuservo.challenge.effects import CONCEALED, NONE, PARAMETER
from pneuservo.challenge.experiments import KINDS, experiment
from pneuservo.challenge.key import Wish
from pneuservo.challenge.noise import ChannelNoise, noise, whitened
from pneuservo.challenge.truth.rig import truth_of, with_rig_values
from pneuservo.challenge.visibility import (
    VISIBLE,
    Sensitivity,
    distance,
    nuisances,
    perform,
    sensitivity,
    signature,
)
from pneuservo.recordings import Recording, read_recording
from pneuservo.rigs import load_rig

RIG = load_rig("single-axis")
QUIET = {
    "displacement": ChannelNoise(5e-6),
    "pressure_a": ChannelNoise(200.0),
    "pressure_b": ChannelNoise(200.0),
}
FORBIDDEN = (
    "plant", "effects", "diagnosis", "simulation", "controllers", "linear", "sliding_mode",
    "limit_cycle", "identification", "circuit_loop", "manipulator",
)  # fmt: skip


def test_nothing_is_shared_with_what_is_judged():
    folder = Path(pneuservo.challenge.__file__).parent
    for name in FORBIDDEN:
        assert (folder.parent / name).is_dir(), name
    for source in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(source.read_text())):
            if not isinstance(node, ast.Import | ast.ImportFrom):
                continue
            of = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
            names = [f"{of}{alias.name}" for alias in node.names]
            for name in names:
                parts = name.split(".")
                assert not (parts[0] == "pneuservo" and parts[1:2] and parts[1] in FORBIDDEN), (
                    f"{source}: {name}"
                )


@pytest.fixture(scope="module")
def truth():
    return truth_of(RIG)


@pytest.fixture(scope="module")
def trials():
    # The first three seconds of each.
    found = {kind: experiment(kind, np.random.default_rng(3)) for kind in KINDS}
    return {kind: replace(trial, control=_begun(trial.control)) for kind, trial in found.items()}


def _begun(control):
    return control._replace(demand=control.demand[: round(3.0 / control.tick)])


def test_without_an_effect_nothing_is_left(truth, trials):
    for trial in trials.values():
        made = perform(truth, trial)
        left = signature(truth, [trial], [made], QUIET)
        # Each half second starts with new steps of the integrator: far below the noise.
        assert np.sqrt(np.mean(left**2)) < 0.05, trial.kind


@pytest.mark.parametrize("name", [n for n, e in CONCEALED.items() if e.kind != NONE])
def test_effect_shows_and_vanishes(name, truth, trials):
    effect = CONCEALED[name]
    trial = trials[(effect.shown_by or ("multilevel",))[0]]
    form = effect.forms[-1]
    left = []
    for size in (effect.smallest, effect.high):
        made = perform(form.apply(truth, size), trial)
        assert made.finite, (form.name, size)
        left.append(np.linalg.norm(signature(truth, [trial], [made], QUIET)))
    small, large = left
    assert large > 10.0, form.name
    if effect.scales and effect.floor < 1.0:
        # A hundredth of what matters at least leaves a small part of the largest.
        assert small < 0.1 * large, (form.name, small, large)


def test_a_wrong_parameter_is_swallowed_by_that_parameter(truth, trials):
    trial = trials["multilevel"]
    heavy = with_rig_values(truth, {"load.mass": 1.03 * RIG["load.mass"]})
    made = perform(heavy, trial)
    left = []
    others = {key: part for key, part in nuisances(RIG).items() if key != "load.mass"}
    for free in ({**others, "load.mass": math.inf}, others):
        found = sensitivity(truth, [trial], [made], QUIET, free)
        left.append(distance(found, truth, [trial], [made], QUIET))
    # With the mass among what is re-tuned nothing that could be seen is left.
    assert left[0] < 2.0 < VISIBLE / 2.0 < left[1]


def test_a_zero_that_is_off_shows_less_than_starts_far_away_make_of_it(truth, trials):
    # A millimetre of it is as much of the dead volumes, once segments start a millimetre away.
    trial = trials["multilevel"]
    form = CONCEALED["sensor.position-offset"].forms[0]
    made = perform(form.apply(truth, 1e-3), trial)
    seen = signature(truth, [trial], [made], QUIET)
    wide = {"chamber.a.dead_volume": math.inf, "chamber.b.dead_volume": math.inf}
    found = sensitivity(truth, [trial], [made], QUIET, {**nuisances(RIG), **wide})
    linear = projected(found, seen)
    assert distance(found, truth, [trial], [made], QUIET) < VISIBLE < 0.5 * linear


def projected(found, seen):
    """What a linear projection leaves, starts of segments moved by as much as it likes."""
    wanted = np.concatenate([found.without_starts(seen), np.zeros(len(found.keys))])
    slopes = np.concatenate([found.matrix, np.diag(1.0 / found.tolerances)])
    change, *_ = np.linalg.lstsq(slopes, wanted, rcond=None)
    return np.linalg.norm(wanted - slopes @ change)


def test_retuning_against_a_stop_comes_to_an_end(truth, trials):
    # Full steps lead away from there, and a segment whose start is moved into the stop explodes.
    trial = trials["stop-test"]
    made = perform(CONCEALED["valve.reattachment"].forms[0].apply(truth, 0.05), trial)
    seen = signature(truth, [trial], [made], QUIET)
    found = sensitivity(truth, [trial], [made], QUIET, nuisances(RIG))
    assert 1.0 < distance(found, truth, [trial], [made], QUIET) < 0.1 * projected(found, seen)


def test_retuning_hides_what_it_can(truth, trials):
    scene = Scene(truth, QUIET, RIG)
    effect = CONCEALED["friction.pressure"]
    hidden = of_size(scene, effect, effect.forms[0], [trials["triangle"]], 1e-6)
    changes = retuned(hidden)
    left = hidden.found.without_starts(hidden.seen)
    moved = hidden.found.matrix @ np.array([changes[key] for key in hidden.found.keys])
    assert np.linalg.norm(left - moved) < 0.7 * np.linalg.norm(left)
    assert max(abs(change) for change in changes.values()) <= LARGEST_RETUNING * (1 + 1e-9)


def test_retuning_stays_within_bounds():
    # One parameter that would have to double.
    found = Sensitivity(["load.mass"], np.ones(1), np.ones((4, 1)), [])
    assert retuned(Concealed(1.0, 1.0, found, np.ones(4))) == pytest.approx({"load.mass": 0.15})


def test_whitening_makes_coloured_noise_white():
    level = ChannelNoise(white=1.0, drift=0.5)
    made = noise(level, 200_000, 1000.0, np.random.default_rng(1))
    white = whitened(made, level, 1000.0)[1000:]
    # Of 200 000 samples the variance is known to 0.3 %, a correlation to 0.002.
    assert np.var(white) == pytest.approx(1.0, abs=0.02)
    assert np.corrcoef(white[1:], white[:-1])[0, 1] == pytest.approx(0.0, abs=0.01)
    blocks = white[: 199 * 1000].reshape(199, 1000).mean(axis=1)
    # Means of a second of white noise: 1/sqrt(1000), known to 5 %.
    assert np.std(blocks) == pytest.approx(1000**-0.5, rel=0.2)


def test_a_case_is_what_a_user_could_have_recorded(tmp_path, monkeypatch):
    # One parameter that can hide the effect instead of twenty: for speed.
    monkeypatch.setattr(concealment, "nuisances", lambda rig: {"load.mass": 0.03})
    wish = Wish(("sensor.pressure-offset-a",), missing=("supply_pressure",), retune=True)
    key = write_case(7, wish, tmp_path)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert "rig.toml" in names
    assert "used-1.csv" in names
    assert "held-back-1.csv" in names
    for path in tmp_path.glob("*.csv"):
        recording = read_recording(path)
        assert len(recording) == 10_000
        # An analogue loop has its set point recorded.
        assert set(recording.channels) - {"demand"} == {
            "valve_voltage", "displacement", "pressure_a", "pressure_b",
        }  # fmt: skip
    for path in tmp_path.iterdir():
        # Neither what is concealed nor how large it is.
        text = path.read_text().lower()
        assert "offset" not in text.replace("offset =", "")
        assert "conceal" not in text
    assert key.blocks == (("sensor.pressure",),)
    again = write_case(7, wish, tmp_path / "again")
    assert again == key
    assert (tmp_path / "again/used-1.csv").read_bytes() == (tmp_path / "used-1.csv").read_bytes()


@pytest.mark.parametrize("seed", range(4))
def test_every_habit_is_read_as_what_was_measured(seed, tmp_path):
    rng = np.random.default_rng(seed)
    channels = {
        "valve_voltage": np.round(rng.uniform(-5.0, 5.0, 50), 4),
        "displacement": rng.uniform(0.0, 0.03, 50),
        "pressure_a": rng.uniform(1.1e5, 6e5, 50),
    }
    made = Recording(
        "r", np.arange(50) * 1e-3, channels, conditions={"load_mass": 6.8},
        noise_rms={"pressure_a": 300.0},
    )  # fmt: skip
    habit = draw_habit(rng, ["displacement", "pressure_a"])
    (tmp_path / "rig.toml").write_text('[rig]\nkind = "single-axis"\n')
    write_dressed(made, habit, RIG, "rig.toml", tmp_path / "r.csv")
    read = read_recording(tmp_path / "r.csv")
    # Digits that are kept: 10 nm, 0.1 Pa, 0.1 mV.
    for name, kept in (("displacement", 1e-8), ("pressure_a", 0.1), ("valve_voltage", 1e-9)):
        assert np.max(np.abs(read[name] - channels[name])) <= kept, name
    assert read.conditions == {"load_mass": 6.8}
    assert read.noise_rms["pressure_a"] == pytest.approx(300.0)


def test_parameters_are_of_the_rig():
    for name, effect in CONCEALED.items():
        if effect.kind == PARAMETER:
            assert name.removeprefix("param.") in RIG.parameters
