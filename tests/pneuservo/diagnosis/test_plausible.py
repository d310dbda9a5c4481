"""Numbers that no rig can have are refused by file, channel and moment."""

import numpy as np
import pytest

from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig

TIME = 10.0 + np.arange(0.0, 2.0, 1e-3)


def cases_of(**changed):
    still = np.full_like(TIME, 0.015)
    pressure = np.full_like(TIME, 4e5)
    channels = {"displacement": still, "valve_voltage": 0.0 * TIME, "pressure_a": pressure}
    recording = Recording("run", TIME, channels | changed)
    model, rig = ServoModel(), load_rig("single-axis")
    return model.cases(model.completed(recording, rig), rig)


def test_a_pressure_below_nothing_is_refused_where_it_is():
    gauge = np.where(TIME < 11.0, 4e5, -500.0)
    with pytest.raises(InputError, match=r"run: pressure_a is -500 Pa at 11 s.*gauge = true"):
        cases_of(pressure_a=gauge)


def test_millimetres_taken_for_metres_are_refused():
    with pytest.raises(InputError, match=r"displacement goes from 10 to 20 m.*stroke is 0.03 m"):
        cases_of(displacement=np.linspace(10.0, 20.0, len(TIME)))


def test_a_transducer_may_read_a_little_beyond_the_stroke():
    assert cases_of(displacement=np.linspace(-0.002, 0.033, len(TIME)))
