"""The recording itself: its parts, its pictures, and what importing it costs."""

import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

from pneuservo.errors import InputError
from pneuservo.recordings import Recording

TIME = np.array([0.0, 1.0, 2.0, 3.0, 10.0])
RAMP = Recording("ramp", TIME, {"displacement": TIME / 1000, "acceleration": TIME}, title="a ramp")


def test_the_sampling_interval_is_the_median_step():
    assert RAMP.sampling_interval == 1.0


def test_a_part_keeps_the_time_and_everything_else():
    part = RAMP.slice(1.0, 3.0)
    assert np.array_equal(part.time, [1.0, 2.0])
    assert np.array_equal(part["displacement"], [0.001, 0.002])
    assert part.title == "a ramp"
    assert len(RAMP) == 5
    # Parts that follow each other share no sample and lose none.
    assert len(RAMP.slice(None, 2.0)) + len(RAMP.slice(2.0, None)) == len(RAMP)


def test_a_part_without_samples_is_refused():
    with pytest.raises(InputError, match="goes from 0 s to 10 s"):
        RAMP.slice(4.0, 9.0)


def test_a_plot_names_quantity_and_unit():
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots()
    assert RAMP.plot("acceleration", ax) is ax
    assert ax.get_xlabel() == "time [s]"
    assert ax.get_ylabel() == "acceleration [m/s²]"
    assert np.array_equal(ax.lines[0].get_ydata(), TIME)
    plt.close(figure)
    own = RAMP.plot("displacement")
    assert own.get_ylabel() == "displacement [m]"
    plt.close(own.figure)


def test_a_plot_of_a_channel_that_is_not_there_is_refused():
    with pytest.raises(InputError, match="Did you mean 'displacement'"):
        RAMP.plot("displacment")


def test_importing_the_reader_is_light():
    heavy = ("pandas", "pyarrow", "h5py", "nptdms", "scipy", "matplotlib", "pint")
    code = (
        "import sys, pneuservo.recordings\n"
        f"print([name for name in {heavy!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_samples_lie_in_memory_in_one_way_wherever_they_came_from():
    # Of a file they are not to be written to, and every second one is no array of its own: kernels
    # were compiled once for each, the observer of the servo for up to a minute.
    time, read, own = np.arange(6.0)[::2], np.arange(3.0), np.arange(3.0)
    read.setflags(write=False)
    recording = Recording("run", time, {"displacement": read, "force": own})
    for samples in (recording.time, *recording.channels.values()):
        assert samples.flags.c_contiguous
        assert samples.flags.writeable
    assert recording["force"] is own
    assert not read.flags.writeable
