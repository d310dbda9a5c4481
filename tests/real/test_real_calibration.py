"""Leaking chambers are discharges of a dead volume: (4.34) on real recordings.

None of the recordings was made by this project; see the README beside them.
"""

import numpy as np
import pytest

from pneuservo.calibration import LEAK, fit_row, flow_curve, transient_of
from pneuservo.calibration.table import cannot_tell_apart
from pneuservo.recordings import read_recording

pytestmark = pytest.mark.real

# What the rig assumes of the chambers: 50 cm^3 at 293 K; choked coefficient (4.18).
VOLUME, GAS, TEMPERATURE, CHOKED = 50e-6, 287.0, 293.0, 0.0404184


def transient(folder, name, *window):
    recording = read_recording(folder / "leak-down" / f"{name}.csv")
    return transient_of(recording.slice(*window) if window else recording)


def choked_area(rate, pressure):
    """Effective area by hand, isothermal and choked [m^2]."""
    flow = VOLUME * rate / (GAS * TEMPERATURE)
    return flow * np.sqrt(TEMPERATURE) / (CHOKED * pressure)


def test_the_aluminium_chamber_hardly_leaks(real_recordings):
    found = transient(real_recordings, "aluminium")
    assert found.path == LEAK
    row = fit_row(found)
    rate = -np.polyfit(found.time, found.pressure, 1)[0]
    by_hand = choked_area(rate, np.mean(found.pressure))
    ratio = float(np.mean(row.curve.pressure_ratio))
    # The fall is not quite straight: the line gives the mean rate, the row that of a fixed area.
    assert row.at(ratio) == pytest.approx(by_hand, rel=0.1)
    # A hole of 3 um.
    assert 5e-12 < row.at(ratio) < 1e-11


@pytest.fixture(scope="module")
def printed(real_recordings):
    # It was held for its first seven seconds.
    return fit_row(transient(real_recordings, "ultimaker_015", 7.5, None))


def test_the_printed_chamber_leaks_a_thousand_times_more(printed):
    assert 5e-9 < printed.at(0.2) < 2e-8


def test_its_area_is_found_by_hand_too(printed):
    found = printed.transient
    early = found.time < found.time[0] + 2.0
    rate = -np.polyfit(found.time[early], found.pressure[early], 1)[0]
    by_hand = choked_area(rate, np.mean(found.pressure[early]))
    middle = float(np.mean(found.pressure_ratio(found.pressure[early])))
    # The five points of a row smooth the steepest part.
    assert printed.at(middle) == pytest.approx(by_hand, rel=0.2)


def test_its_area_closes_as_the_pressure_falls(printed):
    # No hole: pores that open under pressure (the diagnosis finds a power of 1.26).
    curve = printed.curve
    assert curve.coefficient[0] > 2.0 * curve.coefficient[len(curve.coefficient) // 2]
    assert printed.at(0.8) < 0.3 * printed.at(0.2)


def test_a_held_start_is_noticed(real_recordings):
    row = fit_row(transient(real_recordings, "ultimaker_015"))
    assert "--window" in " ".join(cannot_tell_apart([row]))


def test_assuming_adiabatic_gas_changes_the_area_by_the_index(real_recordings):
    found = transient(real_recordings, "ultimaker_015", 7.5, None)
    slow, fast = (flow_curve(found, index).coefficient for index in (1.0, 1.4))
    assert slow / fast == pytest.approx(1.4)
