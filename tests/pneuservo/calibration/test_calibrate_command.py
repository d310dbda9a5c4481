"""``pneuservo calibrate`` as a user runs it."""

import json

import pytest
from click.testing import CliRunner

from pneuservo.calibration import simulate_transient
from pneuservo.command_line import main
from pneuservo.recordings import Recording, write_recording


def run(*arguments):
    return CliRunner().invoke(main, ["calibrate", *map(str, arguments)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibration")
    for path in ("s_a", "a_e"):
        recording = simulate_transient(path, 5.0)
        write_recording(recording, folder / f"{path}.csv")
    leak = Recording(
        "leak",
        recording.time,
        {"dead_volume_pressure": recording["dead_volume_pressure"]},
        "dead-volume",
    )
    write_recording(leak, folder / "leak.csv")
    return folder


@pytest.fixture(scope="module")
def answer(folder):
    done = run(folder / "s_a.csv", folder / "a_e.csv", "--out", folder / "out", "--json")
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_a_rig_of_ones_own_is_simulated_with_its_own_supply_and_volume(tmp_path):
    own = tmp_path / "mine.toml"
    own.write_text(
        '[rig]\nkind = "dead-volume"\n[parameters]\n'
        '"supply.pressure" = "6.5 bar"\n"dead-volume.volume" = "60 cm**3"\n'
    )
    mine, built_in = (
        simulate_transient("s_a", 5.0, rig=rig, noise_rms=0.0) for rig in (str(own), "dead-volume")
    )
    assert mine["dead_volume_pressure"][-1] == pytest.approx(6.5e5, rel=1e-3)
    assert mine.conditions == {}
    # Choked at first: the rise goes with the supply over the volume.
    slopes = [
        (run["dead_volume_pressure"][1] - run["dead_volume_pressure"][0]) / run.time[1]
        for run in (mine, built_in)
    ]
    assert slopes[0] / slopes[1] == pytest.approx(120 / 60 * 6.5 / 7.7, rel=0.02)


def test_it_prints_one_document_with_intervals(folder, answer):
    rows = {row["path"]: row for row in answer["rows"]}
    assert set(rows) == {"s_a", "a_e"}
    for row in rows.values():
        assert row["residual"]["white"]
        seen = [point for point in row["points"] if point["high"] is not None]
        assert len(seen) >= 3
        assert all(point["low"] < point["value"] < point["high"] for point in seen)
    # Table 4.1 with the maker's 0.8, which table 4.2 has at full opening.
    area = answer["areas"]["s_a"]
    assert area["low"] < area["value"] < area["high"]
    assert area["value"] == pytest.approx(0.870e-6, rel=5e-3)
    assert "cannot tell discharge coefficient" in answer["cannot_tell_apart"][0]
    written = json.loads((folder / "out" / "calibration.json").read_text())
    assert written == answer


def test_it_writes_pictures_and_a_valve_that_a_rig_can_use(folder, answer):
    for name in ("coefficients.svg", "transients.svg"):
        assert (folder / "out" / name).read_text().startswith("<svg")
    rig = folder / "out" / "rig.toml"
    rig.write_text('[rig]\nkind = "single-axis"\nvalve = "valve.toml"\n')
    done = CliRunner().invoke(
        main,
        ["simulate", "--rig", str(rig), "--controller", "proportional",
         "--demand", "15,16 mm", "--hold", "0.1", "--json"],
    )  # fmt: skip
    assert done.exit_code == 0, done.output


def test_a_leak_is_an_area_over_pressure_ratio(folder, tmp_path):
    done = run(folder / "leak.csv", "--out", tmp_path, "--json")
    assert done.exit_code == 0, done.output
    (row,) = json.loads(done.stdout)["rows"]
    assert (row["path"], row["command"], row["unit"]) == ("leak", None, "m**2")
    assert row["polytropic_index"] == 1.0
    assert not (tmp_path / "valve.toml").exists()


def test_people_get_a_table_and_the_recording_stays_as_it_was(folder, tmp_path):
    before = (folder / "s_a.csv").read_bytes()
    done = run(folder / "s_a.csv", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert "s_a" in done.stdout
    assert "mm²" in done.stdout
    assert (folder / "s_a.csv").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "give recordings"),
        (("nowhere.csv",), "there is no such file"),
        (("{s_a}", "--simulate"), "give recordings"),
        (("{s_a}", "--rig", "single-axis"), "dead_volume_volume"),
        (("{s_a}", "--window", "0:0.003"), "at least"),
        (("{s_a}", "--index", "-1"), "not greater than 0"),
    ],
)
def test_what_cannot_be_used_is_said_without_a_traceback(folder, tmp_path, arguments, message):
    given = [word.replace("{s_a}", str(folder / "s_a.csv")) for word in arguments]
    done = run(*given, "--out", tmp_path)
    assert done.exit_code == 2, done.output
    assert message in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.output
