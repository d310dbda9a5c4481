"""``pneuservo simulate`` as typed."""

import json
import re
import shlex

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.design_file import design_to_toml
from analog_card.tuning import tune
from pneuservo.command_line import main
from pneuservo.recordings import Recording, read_recording, write_recording
from pneuservo.simulation import simulate, simulate_dead_volume

LOOP = ["--controller", "sliding-mode", "--demand", "15,24 mm", "--hold", "0.5 s"]
CARD = ["--controller", "analogue-card", *LOOP[2:]]
PROPORTIONAL = ["--controller", "proportional", *LOOP[2:]]


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run the command in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments):
        return CliRunner().invoke(main, ["simulate", *arguments])

    return invoke


def record(path, **channels):
    time = np.arange(len(next(iter(channels.values())))) * 1e-3
    return str(write_recording(Recording("r", time, channels), path))


def test_the_examples_of_the_help_run(run, tmp_path):
    helped = run("--help")
    examples = [
        line.strip() for line in helped.output.splitlines() if "pneuservo simulate --" in line
    ]
    assert len(examples) == 4
    assert helped.output.rstrip().endswith(examples[-1])
    for example in examples:
        done = run(*shlex.split(example)[2:])
        assert done.exit_code == 0, done.output
    assert (tmp_path / "replayed.csv").exists()


@pytest.mark.parametrize(
    ("controller", "kind"),
    [("proportional", "proportional"), ("digital-sliding-mode", "digital"), ("sliding-mode", None)],
)
def test_what_is_written_states_the_controller(run, tmp_path, controller, kind):
    done = run("--controller", controller, *LOOP[2:], "--out", "loop.csv")
    assert done.exit_code == 0, done.output
    assert read_recording(tmp_path / "loop.csv").controller.get("kind") == kind


@pytest.mark.parametrize("controller", ["digital-sliding-mode", "hybrid-sliding-mode"])
def test_a_sampled_controller_drives_a_repaired_rig_without_its_effects(run, tmp_path, controller):
    (tmp_path / "model.toml").write_text(
        '[rig]\nkind = "single-axis"\n[effects."leakage.rod-seal"]\narea = 1e-8\n'
    )
    done = run("--rig", "model.toml", "--controller", controller, *LOOP[2:])
    assert done.exit_code == 0, done.output
    assert "model.toml: leakage.rod-seal is left out here" in done.stderr


def test_closed_loop_writes_every_channel(run, tmp_path):
    done = run(*LOOP, "--rate", "2 kHz", "--out", "loop.parquet", "--plot", "loop.svg")
    assert done.exit_code == 0, done.output
    loop = read_recording("loop.parquet")
    assert len(loop) == 2000
    for name in ("demand", "displacement", "velocity", "acceleration", "pressure_a", "pressure_b"):
        assert name in loop
    assert "valve_voltage" in loop
    assert "spool" in loop
    assert "44 ms" in done.output  # rise time of the step
    assert (tmp_path / "loop.svg").read_text().lstrip().startswith("<?xml")


def test_a_loop_that_does_nothing_is_not_said_to_settle(run):
    shown = run("--controller", "proportional", "--gain", "0", "--demand", "15,24 mm")
    assert shown.exit_code == 0, shown.output
    assert "not reached" in shown.output
    assert "no answer" in shown.output
    assert " 0 ms" not in shown.output


def test_json_is_all_that_is_printed(run):
    done = run(*LOOP, "--json")
    report = json.loads(done.stdout)
    assert report["controller"]["boundary_layer"] == 5.0
    assert report["steps"][0]["target"] == 0.024
    assert report["steps"][0]["rise_time"] == pytest.approx(0.044, abs=1e-3)
    assert report["limit_cycle"] is None


def test_a_controller_on_a_computer_is_shaped_by_options(run):
    loop = ["--demand", "15,24 mm", "--hold", "20 ms", "--json"]
    for kind, *shape in (
        ("digital-sliding-mode", "--accelerometer", "--boundary-layer", "0"),
        ("digital-state-feedback", "--gain", "0.3", "--no-accelerometer"),
        ("hybrid-sliding-mode", "--settling-time", "50 ms"),
        ("discrete-sliding-mode", "--reaching-share", "0.4"),
    ):
        done = run("--controller", kind, "--sampling-time", "2 ms", *shape, *loop)
        assert done.exit_code == 0, done.output
        controller = json.loads(done.stdout)["controller"]
        assert controller["kind"] == kind
        assert controller["sampling_time"] == 2e-3
    wrong = run("--controller", "hybrid-sliding-mode", "--accelerometer", *loop)
    assert wrong.exit_code == 2
    assert "--accelerometer is not an option of the controller hybrid-sliding-mode" in wrong.stderr
    fast = run("--controller", "digital-sliding-mode", "--sampling-time", "15 us", *loop)
    assert fast.exit_code == 2
    assert "sample more slowly" in fast.stderr


def test_options_reach_the_controller(run):
    shape = ["--settling-time", "50 ms", "--damping", "0.8", "--boundary-layer", "6000 mm/s**2"]
    done = run(*LOOP, *shape, "--level", "4", "--json")
    assert json.loads(done.stdout)["controller"] == {
        "kind": "sliding-mode",
        "settling_time": 0.05,
        "damping": 0.8,
        "boundary_layer": 6.0,
        "level": 4.0,
    }


def test_the_card_comes_from_its_design(run):
    loop = [*CARD, "--json"]
    plain = json.loads(run(*loop).stdout)["controller"]["figures"]
    assert plain["rc_velocity"] == pytest.approx(0.012)
    tuned = json.loads(run(*loop, "--settling-time", "0.1 s").stdout)["controller"]["figures"]
    assert tuned["weight_displacement"] < plain["weight_displacement"]
    relay = json.loads(run(*loop, "--boundary-layer", "0").stdout)["controller"]["figures"]
    assert relay["output_gain"] is None  # infinite
    assert relay["level"] == pytest.approx(5.0)


def test_what_is_not_asked_for_stays_as_the_design_is_turned(run, tmp_path):
    design = tune(0.12, damping=0.8, boundary_layer=9.0, level=4.0).design
    (tmp_path / "card.toml").write_text(design_to_toml(design))

    def figures(*asked):
        done = run(*CARD, "--design", "card.toml", *asked, "--json")
        return json.loads(done.stdout)["controller"]["figures"]

    turned = figures()
    # A relay only opens the feedback of the boundary-layer amplifier.
    assert figures("--boundary-layer", "0") == {**turned, "output_gain": None}
    # P4 takes the same share of the gain and of the level.
    lower = figures("--level", "2")
    for name in ("output_gain", "level"):
        assert lower.pop(name) == pytest.approx(0.5 * turned[name])
    assert lower == {name: turned[name] for name in lower}
    # Of settling time and damping the other one is the card's: c1 goes as 1/(time damping)^2.
    damped = figures("--damping", "1")
    weights = [each["weight_displacement"] for each in (turned, damped)]
    assert weights[1] == pytest.approx(0.8**2 * weights[0])
    assert damped["weight_velocity"] == pytest.approx(turned["weight_velocity"])


def test_a_card_for_another_transducer_is_warned_of(run, tmp_path):
    (tmp_path / "card.toml").write_text('[transducer]\nfull_scale_displacement = "50 mm"\n')
    done = run(*CARD, "--design", "card.toml", "--boundary-layer", "5")
    assert done.exit_code == 0, done.output
    # 10 V over 50 mm and over 30 mm: with the gain of P3 for the former 5 m/s2 become 3 m/s2.
    for words in ("200 V/m", "333.3 V/m", "is 3 m/s2 there, not 5 m/s2"):
        assert words in done.stderr
    assert "transducer" not in run(*CARD).stderr


def test_the_card_by_its_behaviour(run):
    loop = [*CARD, "--card", "behaviour", "--json"]
    report = json.loads(run(*loop, "--out", "card.csv").stdout)
    # All offsets of 5 mV are worth 81 um (worked out in test_circuit_loop).
    assert report["steady_state_error"] == pytest.approx(-81e-6, abs=10e-6)
    sidecar = read_recording("card.csv")
    assert sidecar.title == "simulated, analogue-card controller by its behaviour"
    without = run(*loop, "--without", "offset-voltage", "--without", "slew-rate")
    report = json.loads(without.stdout)
    assert abs(report["steady_state_error"]) < 10e-6
    kept = report["controller"]["behaviour"]["imperfections"]
    assert {name for name, kept in kept.items() if not kept} == {"offset_voltage", "slew_rate"}


@pytest.mark.ngspice
def test_the_card_by_its_circuit_does_what_its_behaviour_does(run):
    loop = [*CARD[:2], "--demand", "15,16 mm", "--hold", "60 ms", "--boundary-layer", "6"]
    for card in ("circuit", "behaviour", "figures"):
        done = run(*loop, "--card", card, "--out", f"{card}.csv", "--phase-plane", f"{card}.svg")
        assert done.exit_code == 0, done.output
    circuit, behaviour, figures = (
        read_recording(f"{card}.csv")["displacement"]
        for card in ("circuit", "behaviour", "figures")
    )
    # What is asked for: 0.5 % of the step. The figures know no offsets, worth some 80 um.
    assert np.abs(circuit - behaviour).max() < 5e-6
    assert np.abs(figures - behaviour).max() > 50e-6


def test_the_phase_plane_is_drawn(run, tmp_path):
    done = run(*LOOP, "--phase-plane", "phase.svg")
    assert done.exit_code == 0, done.output
    assert "written: phase.svg" in done.output
    assert "boundary layer" in (tmp_path / "phase.svg").read_text()


def test_rounded_times_are_equally_spaced_enough_for_the_behaviour(run, tmp_path):
    loop = ["--controller", "analogue-card", "--card", "behaviour", "--demand", "rounded.csv"]
    time = np.round(np.arange(100) / 3e3, 6)
    step = np.where(time < 0.01, 0.015, 0.016)
    write_recording(Recording("r", time, {"demand": step, "displacement": step}), "rounded.csv")
    assert run(*loop).exit_code == 0
    write_recording(Recording("r", time**1.1, {"demand": step, "displacement": step}), "odd.csv")
    done = run(*loop[:-1], "odd.csv")
    assert done.exit_code == 2
    # x - x^1.1 is largest at x = 1.1^-10 = 0.386 of the span.
    assert re.search(
        "needs equally spaced times: sample 3[789] is at", " ".join(done.stderr.split())
    )
    assert run(*loop[:2], "--demand", "odd.csv").exit_code == 0


def test_replay_equals_the_simulation_of_the_same_command(run):
    command = 2.0 * np.sin(np.arange(100) / 10.0)
    record("drive.csv", valve_voltage=command)
    done = run("--replay", "drive.csv", "--out", "out.h5")
    assert done.exit_code == 0, done.output
    expected = simulate(time=np.arange(100) * 1e-3, command=command)
    out = read_recording("out.h5")
    for name in expected.channels:
        np.testing.assert_array_equal(out[name], expected[name])


def test_conditions_of_the_recording_are_applied(run, tmp_path):
    record("drive.csv", valve_voltage=np.full(50, 1.0), displacement=np.full(50, 0.01))
    sidecar = tmp_path / "drive.toml"
    sidecar.write_text(sidecar.read_text() + '\n[conditions]\nload_mass = "6.82 kg"\n')
    assert run("--replay", "drive.csv", "--out", "heavy.csv").exit_code == 0
    heavy = read_recording("heavy.csv")
    assert heavy.conditions == {"load_mass": 6.82}
    assert heavy["displacement"][0] == 0.01


def test_replay_of_a_test_volume(run):
    volume = simulate_dead_volume(time=np.arange(100) * 1e-3, command=-0.5, port="b")
    write_recording(volume.to_recording("charge"), "charge.csv")
    done = run("--replay", "charge.csv", "--json")
    assert json.loads(done.stdout)["difference"]["dead_volume_pressure"]["rms"] == 0.0


def test_demand_of_a_recording(run):
    record("wanted.csv", demand=np.full(50, 0.02), displacement=np.full(50, 0.015))
    done = run("--controller", "proportional", "--demand", "wanted.csv", "--out", "got.csv")
    assert done.exit_code == 0, done.output
    got = read_recording("got.csv")
    assert got["displacement"][0] == 0.015
    assert got["valve_voltage"][0] == pytest.approx(5e-3 * 10.0 / 0.03)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "say what to simulate"),
        (["--replay", "x.csv", *LOOP], "--replay and --controller exclude each other"),
        (["--replay", "none.csv"], "none.csv: there is no such file"),
        (["--replay", "demand.csv"], "no channel valve_voltage to replay; there are: demand"),
        (["--replay", "gap.csv"], "valve_voltage is missing at 0.02 s (sample 20, 10 in all)"),
        (["--replay", "demand.csv", "--hold", "1 s"], "--hold is not used by a replay"),
        (["--controller", "sliding"], "'sliding' is not known; there are: sliding-mode"),
        (["--controller", "slidingmode"], "Did you mean 'sliding-mode'?"),
        (["--controller", "proportional"], "a closed loop needs --demand"),
        ([*LOOP, "--gain", "3"], "--gain is not an option of the controller sliding-mode"),
        ([*LOOP, "--settling-time", "70 mm"], "has the unit of a length, a time is needed"),
        ([*LOOP, "--settling-time", "-70 ms"], "settling_time is -0.07"),
        ([*LOOP, "--rig", "figure-arm"], "kind figure-arm; single-axis is needed"),
        ([*LOOP, "--rig", "nowhere"], "rig 'nowhere' is not known"),
        ([*LOOP, "--plot", "run.gif"], "a picture ends in one of: .png, .svg, .pdf"),
        ([*LOOP, "--phase-plane", "run.gif"], "--phase-plane run.gif: a picture ends in one of"),
        (["--replay", "x.csv", "--phase-plane", "x.svg"], "--phase-plane is not used by a replay"),
        ([*PROPORTIONAL, "--phase-plane", "x.svg"], "proportional has no sliding surface"),
        ([*LOOP, "--card", "circuit"], "--card is not an option of the controller sliding-mode"),
        ([*CARD, "--without", "saturation"], "simulated by its figures here. Add --card behaviour"),
        ([*CARD, "--card", "spice"], "'spice' is not one of 'figures', 'behaviour', 'circuit'"),
        ([*CARD, "--card", "circuit", "--without", "slew-rate"], "by its circuit here"),
        ([*LOOP, "--out", "run.xyz"], "run.xyz"),
        ([*LOOP, "--out", "/dev/null/run.csv"], "--out /dev/null/run.csv: cannot be written"),
        ([*LOOP[:3], "15,24"], "15 m is outside the stroke, 0 to 30 mm"),
        ([*LOOP[:3], "15,,24 mm"], "cannot be read as a number"),
        ([*LOOP[:3], "gap.csv"], "gap.csv: there is no channel demand"),
        ([*LOOP[:3], "demand.csv", "--rate", "1 kHz"], "--rate is not used by a recorded demand"),
        ([*LOOP[:3], "demand.csv", "--out", "demand.csv"], "never written over"),
        ([*LOOP, "--port", "a"], "--port is not used by a closed loop"),
    ],
)
def test_bad_input_is_refused(run, arguments, message):
    record("demand.csv", demand=np.full(50, 0.02))
    gap = np.ones(50)
    gap[20:30] = np.nan
    record("gap.csv", valve_voltage=gap)
    done = run(*arguments)
    assert done.exit_code == 2, done.output
    assert message in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.output
