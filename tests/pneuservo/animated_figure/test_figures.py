"""Figures as data: built-in ones, files, members added and left out, demands."""

from dataclasses import replace

import numpy as np
import pytest

from pneuservo.animated_figure import BUILT_IN_FIGURES, Axis, Frame, load_figure, simulate_figure
from pneuservo.animated_figure.demand import sampled_time, stepping, waving
from pneuservo.controllers import DigitalSlidingMode, SlidingMode
from pneuservo.errors import InputError
from pneuservo.manipulator.linkage import mass_matrix
from pneuservo.rigs import load_rig

ARM = """
[frame]
mass = "20 kg"
frequency = "5 Hz"

[axes.upper]
rig = "mine.toml"
lever = "60 mm"
member = { mass = "0.5 kg", inertia = "4e-3 kg*m**2", centre = "10 cm", length = "25 cm" }

[axes.lower]
rig = "figure-rotary-axis"
carried_by = "upper"
rest_angle = "30 deg"
lever = "19.1 mm"
member = { mass = "0.2 kg", inertia = 1e-3, centre = 0.1, length = 0.2 }
parameters = { "load.mass" = "3 kg" }
"""
RIG = '[rig]\nkind = "single-axis"\n[parameters]\n"load.gravity" = "0 m/s**2"\n'


def test_built_in_figures_have_two_to_fourteen_axes_within_reach():
    assert [len(load_figure(name).axes) for name in BUILT_IN_FIGURES] == [2, 7, 14]
    for name in BUILT_IN_FIGURES:
        figure = load_figure(name)
        coupling = figure.coupling
        at_rest = mass_matrix(np.zeros(len(figure.axes)), coupling.linkage)
        moved = np.diag(at_rest) / coupling.levers**2
        moved += [axis.rig["load.mass"] for axis in figure.axes.values()]
        # What the files state, from the masses that section 9.3.6 tests.
        assert moved.min() > 2.0
        assert moved.max() < 20.0


def test_a_figure_file_with_a_rig_beside_it(tmp_path):
    (tmp_path / "mine.toml").write_text(RIG)
    (tmp_path / "arm.toml").write_text(ARM)
    figure = load_figure(tmp_path / "arm.toml")
    assert figure.frame == Frame(20.0, 5.0)
    lower = figure.axes["lower"]
    assert (lower.carrier, lower.mass, lower.rig["load.mass"]) == ("upper", 0.2, 3.0)
    assert lower.rest_angle == pytest.approx(np.pi / 6)
    assert figure.left_out == {
        "lower": ("line.restriction", "line.delay", "leakage.cross-piston"),
    }
    assert figure.coupling.linkage.rest_angles == pytest.approx([0.0, np.pi / 6])


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('rig = "mine.toml"', 'rig = "../mine.toml"', "rig is '../mine.toml'; there are: single"),
        ('rig = "mine.toml"', 'rig = "dead-volume"', "kind dead-volume; an axis of a figure"),
        ('lever = "60 mm"\n', "", "lever is missing"),
        ('lever = "60 mm"', 'lever = "60 kg"', "lever: '60 kg' has the unit of a mass"),
        ('lever = "60 mm"', "lever = 0", "lever is 0; it has to be greater than 0"),
        ('carried_by = "upper"', 'carried_by = "uper"', "stands on 'uper'; it can stand on: frame"),
        ('mass = "20 kg"\n', "", r"\[frame\]: mass is missing"),
        ("inertia = 1e-3, ", "", "member: inertia is missing"),
        ("inertia = 1e-3", "inertia = true", "True is not a quantity"),
        ("[axes.lower]", "[axes.frame]", "an axis is called 'frame'"),
        ("[axes.lower]", '[axes."../lower"]', "'../lower' cannot be the name of an axis.*letters"),
        ("[axes.lower]", '[axes.""]', "'' cannot be the name of an axis"),
        ('carried_by = "upper"', "carried = 1", "carried"),
        ('"load.mass"', '"load.mas"', "load.mass"),
        ("[frame]", "[frame", "is not valid TOML"),
    ],
)
def test_a_bad_figure_file_is_refused_by_name(tmp_path, before, after, message):
    (tmp_path / "mine.toml").write_text(RIG)
    file = tmp_path / "arm.toml"
    assert before in ARM
    file.write_text(ARM.replace(before, after))
    with pytest.raises(InputError, match=message):
        load_figure(file)


def test_an_unknown_figure_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"'ram' is not known.*arm"):
        load_figure("ram")
    with pytest.raises(InputError, match=r"none.toml: cannot be read: No such file"):
        load_figure(tmp_path / "none.toml")


def test_axes_are_added_and_left_out_with_what_they_carry():
    figure = load_figure("fourteen-axes")
    assert len(figure.without("left-shoulder", "right-hip").axes) == 14 - 3 - 3
    kept = figure.only("left-wrist", "neck")
    assert list(kept.axes) == ["trunk", "neck", "left-shoulder", "left-elbow", "left-wrist"]
    arm = load_figure("arm")
    hand = replace(arm.axes["elbow"], carrier="elbow")
    assert len(replace(arm, axes={**arm.axes, "hand": hand}).coupling.levers) == 3
    with pytest.raises(InputError, match="there is no axis"):
        arm.without("shoulder")
    with pytest.raises(InputError, match="elbow"):
        arm.only("elbwo")


def test_an_axis_is_of_a_single_axis_rig():
    with pytest.raises(InputError, match="kind circuit"):
        Axis(load_rig("circuit"), 0.05, 0.5, 1e-3, 0.1, 0.2)


def test_demands():
    figure, time = load_figure("arm"), sampled_time(3.0, 100.0)
    assert (time[0], time[-1], len(time)) == (0.0, 3.0, 301)
    wave = waving(figure, time, frequency=2.0, amplitude=0.4)
    assert all(values[time <= 0.2] == pytest.approx(0.015) for values in wave.values())
    assert np.ptp(wave["elbow"]) == pytest.approx(0.8 * 0.03, rel=0.01)
    steps = stepping(figure, time, hold=0.5, amplitude=0.25)
    moved = np.column_stack([values != 0.015 for values in steps.values()])
    # One at a time, each in its turn.
    assert (moved.sum(axis=1) <= 1).all()
    assert moved[100].tolist() == [False, True]
    with pytest.raises(InputError, match=r"amplitude is 0.6 of the stroke"):
        waving(figure, time, amplitude=0.6)
    with pytest.raises(InputError, match="samples"):
        sampled_time(1e9, 1e6)


def test_what_cannot_be_simulated_is_refused():
    figure, time = load_figure("arm"), np.linspace(0.0, 0.1, 11)
    with pytest.raises(InputError, match="is sampled"):
        simulate_figure(figure, time=time, controller=DigitalSlidingMode(), demands={})
    with pytest.raises(InputError, match="give a boundary layer"):
        simulate_figure(figure, time=time, controller=SlidingMode(boundary_layer=0.0), demands={})
    with pytest.raises(InputError, match="there is no axis 'hand'"):
        simulate_figure(figure, time=time, controller=SlidingMode(), demands={"hand": 0.01})
    with pytest.raises(InputError, match="its stroke is 0 to 30 mm"):
        simulate_figure(figure, time=time, controller=SlidingMode(), demands={"elbow": 0.04})
    axes = dict(figure.axes)
    rig = replace(axes["elbow"].rig, valve="ddv-27a1-uncalibrated")
    axes["elbow"] = replace(axes["elbow"], rig=rig)
    with pytest.raises(InputError, match="all have to have the same"):
        simulate_figure(replace(figure, axes=axes), time=time, controller=SlidingMode(), demands={})
