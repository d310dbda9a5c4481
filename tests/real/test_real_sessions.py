"""The even-pressure recordings of the circle seal were taken in another session than the odd ones.

None of the recordings was made by this project; see the README beside them.
"""

import json

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main

pytestmark = pytest.mark.real


def files(folder, seal, *pressures):
    return [str(folder / "seal-friction" / f"{seal}-{bar}-bar.csv") for bar in pressures]


def typed(folder, *arguments):
    """Run the command as a user does; return its document and what it printed."""
    done = CliRunner().invoke(main, ["diagnose", *arguments, "--out", str(folder)])
    assert done.exit_code == 0, done.output
    return json.loads((folder / "diagnosis.json").read_text()), done.output


def trained(folder, seal, train, test, out):
    """Diagnose some pressures against a model trained on others."""
    typed(out / "trained", *files(folder, seal, *train))
    rig = ["--rig", str(out / "trained" / "model.toml")]
    return typed(out / "other", *files(folder, seal, *test), *rig)


@pytest.fixture(scope="module")
def other_session(real_recordings, tmp_path_factory):
    out = tmp_path_factory.mktemp("sessions")
    answer, printed = trained(real_recordings, "circle", (1, 3, 5, 7), (2, 4), out)
    return answer["sessions"], printed, (out / "other" / "report.html").read_text()


def difference(sessions, what):
    (entry,) = (entry for entry in sessions["differences"] if entry["what"] == what)
    return entry


def test_the_trained_model_misses_the_other_session(other_session):
    sessions, _, _ = other_session
    assert sessions["trained_on"] == [f"circle-{bar}-bar" for bar in (1, 3, 5, 7)]
    misfit = sessions["misfit"]["force"]
    # The constant force alone is 2.2 N.
    assert misfit["here"] > 2.2 > misfit["trained"]


def test_a_constant_force_is_added(other_session):
    sessions, _, _ = other_session
    zero = difference(sessions, "sensor.force.offset")
    # Mean of push and pull less p A, beside a line through 1, 3, 5 and 7 bar, by hand: 1.67 N at 2
    # and 2.57 N at 4 bar. The line's own diameter is 0.1 N per bar larger or smaller.
    assert zero["difference"]["value"] == pytest.approx(2.12, abs=0.3)
    assert zero["difference"]["low"] > 0.0
    assert {"param.piston.diameter", "friction.asymmetric"} < set(zero["class"])
    assert {"sensor.force-gain", "sensor.pressure-gain-a"} < set(zero["class"])


def test_friction_is_higher(other_session):
    sessions, _, _ = other_session
    level = difference(sessions, "piston.coulomb_friction")
    # Half of push less pull beside the same line, by hand: 0.52 N at 2 and 0.93 N at 4 bar.
    assert level["difference"]["value"] == pytest.approx(0.72, abs=0.2)
    assert level["difference"]["low"] > 0.0


def test_it_was_sampled_and_driven_otherwise(other_session):
    sessions, _, _ = other_session
    interval = difference(sessions, "sampling interval")
    assert (interval["trained"], interval["here"]) == pytest.approx((0.010, 0.017))
    assert difference(sessions, "speed of the drive")["difference"]["low"] > 0.0


def test_report_and_command_say_so_in_words(other_session):
    _, printed, page = other_session
    for text in (printed, page):
        assert "piston.coulomb_friction: " in text
        assert "sensor.force.offset" in text
        assert "sampling interval: 0.017 s here, 0.01 s there" in text
    assert "Against the session it was fitted to" in page


def test_recordings_of_one_session_are_not_called_different(real_recordings, tmp_path):
    # Their intervals alone would say so: the zero moves by 1.4 N, nineteen standard deviations.
    answer, printed = trained(real_recordings, "kdn", (1, 7), (3, 5), tmp_path)
    parameters = [
        entry for entry in answer["sessions"]["differences"] if entry["kind"] == "parameter"
    ]
    assert not parameters
    assert "No difference is larger" in printed
