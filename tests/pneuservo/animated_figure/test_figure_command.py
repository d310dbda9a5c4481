"""The command ``pneuservo figure``, its recordings, pictures and animation."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.animation import FFMpegWriter
from matplotlib.figure import Figure
from PIL import Image

from pneuservo.animated_figure import load_figure, simulate_figure
from pneuservo.animated_figure.demand import stepping
from pneuservo.animated_figure.pictures import draw_courses, draw_pose, overview
from pneuservo.animated_figure.result import FigureRun
from pneuservo.command_line import main
from pneuservo.controllers import SlidingMode
from pneuservo.recordings import read_recording

QUICK = ["figure", "--figure", "arm", "--duration", "0.6 s", "--rate", "500 Hz"]
SLIDING = [*QUICK, "--controller", "sliding-mode"]


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_json_recordings_and_animation(tmp_path):
    gif, folder = tmp_path / "arm.gif", tmp_path / "axes"
    found = run(*SLIDING, "--moved", "elbow", "--json", "--animation", gif, "--out", folder)
    assert found.exit_code == 0, found.output
    report = json.loads(found.stdout)
    shoulder, elbow = report["axes"]["shoulder"], report["axes"]["elbow"]
    # The other axis is the only one that can have moved the shoulder.
    assert 0.0 < shoulder["ripple"]["peak_to_peak"] < 1e-3
    assert elbow["ripple"] is None
    assert elbow["error_rms"] > 10.0 * shoulder["error_rms"]
    assert report["frame"]["acceleration_rms"] > 0.0
    assert "line.delay" in report["left_out"]["elbow"]
    assert "Warning: elbow: left out of the run: line.restriction, line.delay" in found.stderr
    with Image.open(gif) as picture:
        # 0.6 s at 25 pictures a second; pictures that do not differ are joined.
        assert 2 < picture.n_frames <= 15
    recording = read_recording(folder / "elbow.csv")
    assert recording.rig == "single-axis"
    assert np.ptp(recording["force"]) > 0.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--animation", "arm.avi"],
            "--animation arm.avi: an animation ends in one of: .gif, .mp4",
        ),
        (["--plot", "arm.txt"], "--plot arm.txt: a picture ends in one of"),
        (["--without", "shoulder"], "there is no axis"),
        (["--axes", "hand"], "hand"),
        (["--amplitude", "70 %"], "amplitude is 0.7 of the stroke"),
        (["--motion", "steps", "--moved", "elbow"], "--moved is not used by --motion steps"),
        (["--gain", "2"], "--gain is not an option of the controller"),
        (["--figure", "leg"], "figure 'leg' is not known"),
        (["--out", "/dev/null/axes"], "--out /dev/null/axes: cannot be written"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    found = run(*QUICK, *arguments)
    assert found.exit_code == 2
    assert message in found.stderr
    assert found.stdout == ""


def test_no_axis_is_written_where_one_cannot_be(tmp_path):
    (tmp_path / "elbow.csv").mkdir()
    found = run(*QUICK, "--out", tmp_path)
    assert found.exit_code == 2
    assert "elbow.csv: is a folder" in found.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["elbow.csv"]


@pytest.mark.skipif(FFMpegWriter.isAvailable(), reason="ffmpeg is installed")
def test_without_ffmpeg_no_mp4():
    found = run(*QUICK, "--animation", "arm.mp4")
    assert found.exit_code == 2
    assert "needs the program ffmpeg" in found.stderr


def test_what_is_left_of_its_own_step_is_not_moved_by_others():
    time = np.linspace(0.0, 2.0, 2001)
    since = np.maximum(time - 0.2, 0.0)
    # As state feedback has it in the jaw of a figure: 0.6 mm are left of 7.5 mm after 0.5 s.
    own = 7.5e-3 * (1.0 - np.exp(-6.0 * since) * np.cos(23.0 * since))
    axes = {
        "jaw": {
            "demand": 7.5e-3 * (time >= 0.2),
            "displacement": own + 4e-5 * np.sin(80.0 * time) * (time >= 1.7),
        },
        "neck": {"demand": 7.5e-3 * ((time >= 0.5) & (time < 1.7)), "displacement": 0.0 * time},
    }
    moved = FigureRun(load_figure("arm"), time, axes, *np.zeros((3, len(time))))
    ripple = moved.ripple("jaw")
    assert ripple is not None
    assert 0.8e-4 < ripple.peak_to_peak < 1.2e-4
    # Without a change of another axis' demand once it has settled there is nothing to tell.
    earlier = {**axes, "neck": {**axes["neck"], "demand": 7.5e-3 * (time >= 0.5)}}
    assert FigureRun(moved.figure, time, earlier, *np.zeros((3, len(time)))).ripple("jaw") is None


def test_axes_of_the_largest_figure_have_a_colour_each():
    figure, time = load_figure("fourteen-axes"), np.linspace(0.0, 1.0, 2)
    still = {"demand": time, "displacement": time}
    run_of_all = FigureRun(figure, time, dict.fromkeys(figure.axes, still), *np.zeros((3, 2)))
    lines = draw_courses(run_of_all, Figure().subplots()).lines
    # The demand of an axis is dashed, in its colour.
    assert len(lines) == 2 * len({line.get_color() for line in lines}) == 2 * 14


def test_pictures_hold_what_they_say():
    time = np.linspace(0.0, 0.5, 251)
    figure = load_figure("arm")
    demands = stepping(figure, time, hold=0.2)
    moved = simulate_figure(figure, time=time, controller=SlidingMode(), demands=demands)
    rods, valves, frame = overview(moved).axes
    assert [line.get_label() for line in rods.lines[1::2]] == ["shoulder", "elbow"]
    assert "[V]" in valves.get_ylabel()
    assert "[m/s²]" in frame.get_ylabel()
    ax = draw_pose(moved, Figure().subplots(), 0.3)
    across, up = ax.lines[-1].get_data()
    # The forearm, drawn where its joints are, the sway of the frame enlarged.
    assert np.hypot(np.diff(across), np.diff(up)) == pytest.approx(figure.axes["elbow"].length)
    ripple = moved.ripple("elbow")
    assert ripple is not None
    assert 0.0 < ripple.rms < ripple.peak_to_peak
