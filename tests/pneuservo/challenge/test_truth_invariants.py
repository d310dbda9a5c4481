"""Laws that the truth has to keep, each by itself."""

import math

import numpy as np
import pytest

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.control import STORED, Control
from pneuservo.challenge.truth.flow import edge_flow, leak_flow
from pneuservo.challenge.truth.friction import friction_force, hold_bristles
from pneuservo.challenge.truth.network import hose_rates
from pneuservo.challenge.truth.parameters import Friction, Network, Spool
from pneuservo.challenge.truth.rig import changed, truth_of, with_rig_values
from pneuservo.challenge.truth.run import relay_field, run, start_state
from pneuservo.challenge.truth.spool import hysteresis
from pneuservo.rigs import load_rig

NONE = np.zeros(1)


@pytest.fixture(scope="module")
def truth():
    return truth_of(load_rig("single-axis"))


def still(truth, seconds=1.0, state=None, volts=0.0):
    command = np.full(round(seconds * 1000), volts)
    control = Control(STORED, 1e-3, command, NONE, NONE, NONE)
    return run(truth, control, start_state(truth, 15e-3) if state is None else state, 1e3, 0.5)


def test_choked_flow_of_the_calibrated_valve(truth):
    # 0.8 x 0.0404 x 0.870e-6 x 6.5e5 / sqrt(293): the coefficient of table 4.2 at full opening.
    flow = edge_flow(truth.valve, 0, 0.870e-6, 5.0, 6.5e5, 1.0e5, 293.0, 287.0)
    assert flow == pytest.approx(0.8 * 0.040418 * 0.870e-6 * 6.5e5 / math.sqrt(293.0), rel=1e-3)
    assert edge_flow(truth.valve, 0, 0.870e-6, 5.0, 1.0e5, 6.5e5, 293.0, 287.0) == -flow


def test_a_leak_is_the_orifice_it_is_stated_as():
    # At the reference pressures a choked orifice, whatever the viscous share.
    orifice = 0.0404 * 1e-8 * 6e5 / math.sqrt(293.0)
    for laminar in (0.1, 0.5, 0.9):
        assert leak_flow(1e-8, laminar, 6e5, 1e5, 293.0) == pytest.approx(orifice, rel=1e-6)
    small = [leak_flow(1e-8, 0.5, 3e5 + drop, 3e5, 293.0) for drop in (1.0, 2.0)]
    # Viscous at small drops: twice the drop, twice the flow.
    assert small[1] == pytest.approx(2.0 * small[0], rel=1e-3)


def test_a_valve_at_null_holds_the_pressures(truth):
    made = still(truth)
    assert np.ptp(made.readings[:, 2]) < 1.0


def test_a_leak_empties_its_chamber_and_no_other(truth):
    # A piston too heavy to move: otherwise it follows and keeps the pressure up.
    fixed = with_rig_values(truth, {"load.mass": 1e9, "load.gravity": 0.0})
    made = still(changed(fixed, "chambers", leak_b=1e-8))
    assert np.ptp(made.readings[:, 2]) < 1.0
    drop = made.readings[0, 3] - made.readings[100, 3]
    flow = leak_flow(1e-8, 0.5, made.readings[0, 3], 1.013e5, 293.0)
    volume = 412.33e-6 * 15e-3 + 1.7e-6
    # n R T m' / V over 0.1 s; the pressure that drives it falls by a tenth meanwhile.
    assert drop == pytest.approx(1.4 * 287.0 * 293.0 * flow / volume * 0.1, rel=0.1)


def test_insulated_gas_keeps_its_entropy(truth):
    # No leak, valve at null, no heat: p V^1.4 of each chamber stays while the piston is thrown.
    insulated = changed(truth, "chambers", energy_balance=1.0, wall_transfer=0.0)
    state = start_state(insulated, 15e-3)
    state[at.SPEED] = 0.3
    control = Control(STORED, 1e-4, np.zeros(500), NONE, NONE, NONE)
    made = run(insulated, control, state, 1e4, 0.01)
    x, p_a = made.motion[:, 0], made.readings[:, 2]
    kept = p_a * (490.87e-6 * x + 1.7e-6) ** 1.4
    assert np.ptp(x) > 1e-3
    assert np.ptp(kept) / kept[0] < 1e-6


def test_a_strong_wall_is_a_baseline_with_index_one(truth):
    # With the gas held at the wall's temperature the energy balance is the rig's law with n = 1.
    state = start_state(truth, 15e-3)
    state[at.SPEED] = 0.3
    control = Control(STORED, 1e-4, np.zeros(500), NONE, NONE, NONE)
    walled = changed(truth, "chambers", energy_balance=1.0, wall_transfer=1e5)
    isothermal = with_rig_values(truth, {"chamber.polytropic_index": 1.0})
    first, second = (run(servo, control, state, 1e4, 0.01) for servo in (walled, isothermal))
    swing = np.ptp(second.readings[:, 2])
    # The gas lags its wall by m cv/(h A), 4e-5 kg x 718 / (1e5 x 2.2e-3) = 0.13 ms, at some 20 Hz:
    # 1.6 % out of phase.
    assert np.max(np.abs(first.readings[:, 2] - second.readings[:, 2])) < 0.03 * swing


def test_relays_remember_where_they_turned():
    # Return-point memory: a minor loop that closes leaves no trace.
    centres, widths = relay_field()
    spool = Spool(hysteresis=0.02)
    relays, kept = -np.ones(at.RELAYS), np.zeros(at.KEPT)
    values = [
        hysteresis(share, spool, kept, relays, centres, widths)
        for share in (-1.0, 0.1, 0.03, 0.06, 0.1, 0.2)
    ]
    plain, kept_plain = -np.ones(at.RELAYS), np.zeros(at.KEPT)
    direct = [
        hysteresis(share, spool, kept_plain, plain, centres, widths) for share in (-1.0, 0.1, 0.2)
    ]
    assert values[1] == pytest.approx(direct[1])
    assert values[4] == pytest.approx(values[1])
    assert values[5] == pytest.approx(direct[2])


def test_the_loop_of_the_relays_is_as_wide_as_asked():
    centres, widths = relay_field()
    spool = Spool(hysteresis=0.02)
    relays, kept = -np.ones(at.RELAYS), np.zeros(at.KEPT)
    up = [hysteresis(s, spool, kept, relays, centres, widths) for s in np.linspace(-1, 0, 200)]
    relays[:] = 1.0
    down = [hysteresis(s, spool, kept, relays, centres, widths) for s in np.linspace(1, 0, 200)]
    # One relay of 3000 is worth 2.5e-4 of full opening.
    assert down[-1] - up[-1] == pytest.approx(2.0 * 0.02, abs=1e-3)


def test_elements_slip_at_the_coulomb_level():
    friction, network = Friction(coulomb=5.0, viscous=0.0), Network()
    state, rates = np.zeros(at.STATES), np.zeros(at.STATES)
    state[at.SPEED] = 0.01
    state[at.BRISTLES : at.BRISTLES + at.BRISTLE_COUNT] = 3.0
    hold_bristles(state)
    assert friction_force(state, 0.0, friction, network, rates) == pytest.approx(5.0)
    state[at.BRISTLES : at.BRISTLES + at.BRISTLE_COUNT] = -0.5
    assert friction_force(state, 0.0, friction, network, rates) == pytest.approx(-2.5)


def test_a_hose_loses_what_a_pipe_loses():
    # A steady flow through the cells: the pressures that keep it are those of Hagen-Poiseuille.
    network = Network(hose_length=1.0, hose_bore=2e-3)
    flow, end = 1e-5, 4e5
    state, rates = np.zeros(at.STATES), np.zeros(at.STATES)
    density = end / (287.0 * 293.0)
    loss = 128.0 * 1.8e-5 * (flow / density) / (math.pi * (2e-3) ** 4)
    cells = np.arange(at.CELLS, 0, -1) * loss / at.CELLS
    state[at.HOSES : at.HOSES + at.CELLS] = end + cells
    state[at.HOSES + at.CELLS : at.HOSES + 2 * at.CELLS] = flow
    assert hose_rates(at.HOSES, flow, end, 1.4, network, state, rates) == flow
    drive = 0.25 * math.pi * (2e-3) ** 2 / 0.1 * loss / at.CELLS
    assert np.max(np.abs(rates[at.HOSES + at.CELLS : at.HOSES + 2 * at.CELLS])) < 0.01 * drive
    assert np.max(np.abs(rates[at.HOSES : at.HOSES + at.CELLS])) < 1e-6


def test_a_servo_that_needs_too_many_steps_comes_to_an_end(truth):
    # A stop that damps with a time constant of a picosecond.
    stiff = changed(truth, "load", stop_damping=1e13, stop_stiffness=1e18)
    state = start_state(stiff, 15e-3)
    state[at.POSITION], state[at.SPEED] = 1e-6, -0.5
    assert not still(stiff, seconds=0.1, state=state).finite
