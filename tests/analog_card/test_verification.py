import json
from dataclasses import replace

import numpy as np
import pytest

from analog_card import verification
from analog_card.design_file import load_design
from analog_card.differentiator import differentiator_pair
from analog_card.verification import verify

pytestmark = pytest.mark.ngspice


@pytest.fixture(scope="module")
def result():
    return verify()


def test_the_recommended_card_passes(result):
    assert result.passed
    limited = [item for item in result.deviations if item.limit is not None]
    assert {(item.tap, item.quantity, item.limit) for item in limited} == {
        (tap, *what)
        for tap in ("velocity", "acceleration")
        for what in (("gain", 0.1), ("phase", 1.0), ("transient", 1.0))
    }
    assert len(result.deviations) == 10
    assert result.frequency[[0, -1]] == pytest.approx([1, 100e3])


def test_the_movement_uses_the_card_as_intended(result):
    # 9 mm at 333.3 V/m from 15 mm; nothing saturates, or the comparison would be of clamps.
    assert result.sensor[0] == pytest.approx(5.0)
    assert np.ptp(result.sensor) == pytest.approx(3.0, abs=0.02)
    for tap in result.netlist_taps:
        assert 1.0 < np.ptp(tap) < 13.0


def test_ideal_op_amps_would_not_pass(result, monkeypatch):
    # Left out, the finite gain-bandwidth costs 1.1 dB and 5 degrees for each stage.
    monkeypatch.setattr(
        verification, "differentiator_pair", lambda design: differentiator_pair(design, False)
    )
    worst = {(item.tap, item.quantity): item for item in verify().deviations[:4]}
    assert not worst["velocity", "gain"].passed
    assert not worst["acceleration", "phase"].passed
    assert worst["velocity", "gain"].worst == pytest.approx(1.13, abs=0.01)


def test_part_values_reach_the_netlist_and_the_model():
    # Other parts in each stage: a value that reached only one side would show.
    design = load_design()
    parts = design.soldered
    design = replace(
        design,
        soldered=replace(
            parts,
            velocity_differentiator=replace(
                parts.velocity_differentiator, resistance=100e3, feedback_capacitance=330e-12
            ),
            acceleration_differentiator=replace(
                parts.acceleration_differentiator, capacitance=82e-9, series_resistance=680
            ),
            operational_amplifier=replace(
                parts.operational_amplifier, gain_bandwidth=3e6, output_resistance=100.0
            ),
        ),
    )
    found = verify(design)
    assert found.passed
    assert np.ptp(found.netlist_taps.acceleration) < 0.8 * np.ptp(
        verify().netlist_taps.acceleration
    )


def test_a_saturating_card_fails_in_the_transient_alone():
    # 100 ms for each stage: 3.3 V for each m/s2 is far beyond the supply.
    design = load_design()
    parts = replace(design.soldered.velocity_differentiator, resistance=1e6)
    design = replace(
        design,
        soldered=replace(
            design.soldered, velocity_differentiator=parts, acceleration_differentiator=parts
        ),
    )
    failed = {(item.tap, item.quantity) for item in verify(design).deviations if not item.passed}
    assert ("acceleration", "transient") in failed
    assert not {what for _, what in failed} & {"gain", "phase"}


def test_numbers_and_picture(result):
    numbers = json.loads(json.dumps(result.to_dict()))
    assert numbers["passed"] is True
    assert {"worst", "limit", "at", "unit", "passed"} <= numbers["deviations"][0].keys()

    from matplotlib.figure import Figure

    axes = Figure().subplots(2, 2).ravel()
    assert result.plot(axes) is axes
    for axis in axes:
        assert axis.get_xlabel()
        assert axis.get_ylabel()
        assert axis.lines
