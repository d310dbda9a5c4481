"""Op-amps that differ from one another: in the netlist by elements, in the behaviour by figures."""

from dataclasses import replace

import numpy as np
import pytest

import netlists
from analog_card.amplifier_elements import core_elements, netlist_elements
from analog_card.behaviour import CardBehaviour
from analog_card.behaviour_elements import figure_name, nominal_elements
from analog_card.behaviour_model import run_behaviour
from analog_card.design_file import load_design
from analog_card.ngspice import FrequencySweep, OperatingPoint, Session, Transient

pytestmark = pytest.mark.ngspice

DESIGN = load_design()
NOMINAL = DESIGN.soldered.operational_amplifier
OTHER = replace(
    NOMINAL,
    bias_current=50e-12,
    open_loop_gain=2e4,
    gain_bandwidth=3e6,
    slew_rate=12e6,
    positive_swing=12.0,
    negative_swing=14.0,
)


def changed(session, *amplifiers):
    for place in amplifiers:
        values = core_elements(OTHER, NOMINAL)
        session.change({f"{place}.xcore.{name}": value for name, value in values.items()})


def bench(name):
    return Session(netlists.shipped()[name], NOMINAL.netlist_parameters())


def test_the_nominal_elements_are_those_of_the_netlist():
    with bench("opamp-open-loop") as session:
        before = session.run(FrequencySweep(0.1, 1e7, 5))["differential"]
        values = core_elements(NOMINAL, NOMINAL)
        session.change({f"xdifferential.xcore.{name}": value for name, value in values.items()})
        after = session.run(FrequencySweep(0.1, 1e7, 5))["differential"]
    np.testing.assert_allclose(after, before, rtol=1e-6)


def test_gain_and_bandwidth_are_met_and_rejection_stays():
    with bench("opamp-open-loop") as session:
        changed(session, "xdifferential", "xcommon")
        sweep = session.run(FrequencySweep(0.1, 1e5, 10))
    # As for the nominal figures: clamp leakage, and 0.07 % of the second pole's capacitor.
    assert abs(sweep["differential"][0]) == pytest.approx(2e4, rel=5e-4)
    bandwidth = abs(sweep["differential"][-1]) * sweep.frequency[-1]
    assert bandwidth == pytest.approx(3e6, rel=2e-3)
    rejection = abs(sweep["differential"][0] / sweep["common"][0])
    assert rejection == pytest.approx(NOMINAL.common_mode_rejection, rel=1e-4)


def test_slew_rate_is_met():
    with bench("opamp-slew") as session:
        changed(session, "xfollower")
        result = session.run(Transient(20e-6, 5e-9))
    time = np.arange(1e-6, 5e-6, 1e-9)
    out = result.at(time, "out")
    rises = [time[np.argmax(out >= level)] for level in (-4.0, 0.0)]
    # Up to 0 V the input is 5 V ahead of the output, and all of the stage's current flows; 60 ohm
    # ahead of a load of 2 kohm divide it. The samples are 1 ns of 340 ns.
    assert 4.0 / (rises[1] - rises[0]) == pytest.approx(12e6 / 1.03, rel=3e-3)


def test_swing_and_bias_current_are_met():
    with bench("opamp-output") as session:
        changed(session, "xhigh", "xlow")
        point = session.run(OperatingPoint())
    # Less than the stage's current flows in the clamps when it is driven by 1 V: 0.03 %.
    assert point["high"][0] == pytest.approx(12.0, rel=5e-4)
    assert point["low"][0] == pytest.approx(-14.0, rel=5e-4)
    with bench("opamp-input") as session:
        changed(session, "xbias")
        point = session.run(OperatingPoint())
    current = (point["vplus#branch"][0] + point["vminus#branch"][0]) / 2
    assert current == pytest.approx(50e-12, rel=1e-6)


def test_one_slow_op_amp_slows_its_stage_in_netlist_and_behaviour():
    # The acceleration's op-amp slews at a fortieth of its rate, and both have less swing: a blow of
    # 0.25 V within 50 us drives them there.
    slow = {
        figure_name("acceleration", "slew_rate"): 9e6 / 40,
        figure_name("acceleration", "gain_bandwidth"): 2e6,
        figure_name("acceleration", "positive_swing"): 11.0,
        figure_name("velocity", "negative_swing"): 13.0,
    }
    time = np.arange(0, 3e-3, 1e-6)
    transducer = 5 + 0.25 * np.clip((time - 1e-3) / 50e-6, 0, 1)
    rest = np.full(len(time), 5.0)
    parameters = DESIGN.netlist_parameters() | {"sine_amplitude": 0.0, "step_height": 0.25}
    nodes = {"first": "xone.first", "second": "xone.second"}
    bench_file = netlists.shipped()["channel-transient"]
    with Session(bench_file, parameters, list(nodes.values())) as session:
        values = netlist_elements({**nominal_elements(DESIGN), **slow}, NOMINAL)
        session.change({f"xone.{name}": value for name, value in values.items()})
        circuit = session.run(Transient(3e-3, 1e-6))
    found = run_behaviour(CardBehaviour(DESIGN, slow), time, transducer, rest)
    alike = run_behaviour(CardBehaviour(DESIGN), time, transducer, rest)
    for node, place in nodes.items():
        measured = circuit.at(time, place)
        assert np.abs(measured - found[node]).max() < 0.01 * np.ptp(measured), node
        # The op-amps as designed do something else.
        assert np.abs(measured - alike[node]).max() > 0.04 * np.ptp(measured), node
