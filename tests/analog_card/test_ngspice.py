import math
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import netlists
from analog_card import ngspice
from analog_card.errors import InputError, SimulationError
from analog_card.ngspice import (
    FrequencySweep,
    Noise,
    OperatingPoint,
    Session,
    SourceSweep,
    Transient,
    noise_voltage,
    run,
    run_many,
)
from analog_card.simulator import SIMULATOR, Simulator

pytestmark = pytest.mark.ngspice

LOW_PASS = [
    "low pass",
    ".param r=1k c=100n",
    "Vin in 0 dc 2 ac 1 pulse(0 2 0 1n 1n 1 2)",
    "R1 in out {r}",
    "C1 out 0 {c}",
    ".end",
]


@pytest.mark.parametrize("capacitance", [100e-9, 47e-9])
def test_frequency_response_of_an_rc_circuit(circuit, capacitance):
    sweep = run(circuit(*LOW_PASS), FrequencySweep(10, 1e5, 10), {"c": capacitance})
    assert sweep.frequency[[0, -1]] == pytest.approx([10, 1e5])
    expected = 1 / (1 + 2j * np.pi * sweep.frequency * 1e3 * capacitance)
    # ngspice solves in double precision and adds a conductance of 1e-12 S.
    np.testing.assert_allclose(sweep["OUT"], expected, rtol=1e-8)


def test_step_of_an_rc_circuit(circuit):
    result = run(circuit(*LOW_PASS), Transient(1e-3, 1e-6))
    times = np.linspace(0, 1e-3, 501)
    expected = 2 * (1 - np.exp(-times / 1e-4))
    # 2 V; trapezoidal rule in steps h of 1 % of the time constant: h^2/12 of it; the source rises
    # in 1 ns instead of at once: 1e-5 of it.
    assert np.abs(result.at(times, "out") - expected).max() < 2 * (1e-4 / 12 + 1e-5)


def test_operating_point_and_numbered_nodes(circuit):
    result = run(circuit("divider", "V1 1 0 9", "R1 1 2 1k", "R2 2 0 2k", ".end"), OperatingPoint())
    assert result["2"] == pytest.approx([6.0])
    assert result["v1#branch"] == pytest.approx([-3e-3])


def test_an_unknown_node_names_the_nearest(circuit):
    with pytest.raises(InputError, match="no node 'ouput'; nearest is 'out'"):
        run(circuit(*LOW_PASS), OperatingPoint())["ouput"]


def test_the_word_error_is_not_an_error(circuit):
    file = circuit(
        "error amplifier",
        "V1 error_signal 0 3",
        "R1 error_signal error 1k",
        "R2 error 0 1k",
        ".end",
    )
    result = run(file, Transient(1e-3, 1e-4))
    assert result["error_signal"][-1] == pytest.approx(3.0)
    assert result["error"][-1] == pytest.approx(1.5)


def test_notes_on_the_way_to_an_operating_point_are_not_failures():
    result = run(netlists.DOUBLE_DIFFERENTIATOR_TRANSIENT, Transient(1e-4, 1e-5))
    assert result.warnings == ()
    # 15 mm at 333.33 V/m
    assert result["sensor"][0] == pytest.approx(5.0)


def test_options_of_one_netlist_do_not_reach_the_next(circuit):
    leaky = ["diode", "V1 a 0 1", "R1 a b 1meg", "D1 b 0 d", ".model d d(is=1e-14)", ".end"]
    before = run(circuit(*leaky), OperatingPoint())["b"][0]
    warm = run(circuit(*leaky[:-1], ".options temp=120 gmin=1e-6", ".end"), OperatingPoint())
    assert abs(warm["b"][0] - before) > 0.05
    assert run(circuit(*leaky), OperatingPoint())["b"][0] == before


def test_a_start_up_script_is_not_run(tmp_path):
    # ngspice runs .spiceinit of the current and of the home folder, shell commands included.
    (tmp_path / ".spiceinit").write_text(f"* script\nshell touch {tmp_path}/ran\n")
    before = Path.cwd(), os.environ.get("HOME", "")
    simulator = Simulator()
    try:
        os.chdir(tmp_path)
        os.environ["HOME"] = str(tmp_path)
        assert simulator.version() > 0
    finally:
        os.chdir(before[0])
        os.environ["HOME"] = before[1]
        simulator.close()
    assert not (tmp_path / "ran").exists()


def test_several_threads_may_ask(circuit):
    file, found = circuit(*LOW_PASS), {}

    def ask(resistance):
        sweep = run(file, FrequencySweep(1e3, 1e4, 5), {"r": resistance})
        found[resistance] = sweep["out"][0]

    threads = [threading.Thread(target=ask, args=(1e3 * k,)) for k in range(1, 6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for resistance, gain in found.items():
        assert gain == pytest.approx(1 / (1 + 2j * np.pi * 1e3 * resistance * 100e-9))
    assert len(found) == 5


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of forking beside threads
def test_a_forked_program_starts_its_own(circuit):
    file = circuit(*LOW_PASS)
    assert run(file, OperatingPoint())["out"] == pytest.approx([2.0])
    ours = SIMULATOR.process_id
    child = os.fork()
    if child == 0:
        found = run(file, OperatingPoint())["out"][0]
        its_own = SIMULATOR.process_id
        SIMULATOR.close()
        os._exit(0 if abs(found - 2) < 1e-6 and its_own != ours else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert run(file, OperatingPoint())["out"] == pytest.approx([2.0])
    assert SIMULATOR.process_id == ours


def resident_memory(process_id):
    pages = Path(f"/proc/{process_id}/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_thousand_runs_leave_the_memory_alone():
    sweep = FrequencySweep(1, 1e5, 2)
    for _ in range(10):
        run(netlists.RC_LOW_PASS, sweep)
    before = resident_memory(SIMULATOR.process_id)
    for _ in range(1000):
        run(netlists.RC_LOW_PASS, sweep)
    # Measured 0.4 MB, 0.4 kB a run; the circuit of each run left behind would be 30 kB a run.
    assert resident_memory(SIMULATOR.process_id) - before < 3e6


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_changed_runs_leave_the_memory_alone(circuit):
    with Session(circuit(*LOW_PASS)) as session:
        session.run(OperatingPoint())
        before = resident_memory(session.process_id)
        for k in range(500):
            session.change({"r1": 1e3 + k})
            session.run(OperatingPoint())
        assert resident_memory(session.process_id) - before < 3e6


def test_a_source_sweep(circuit):
    swept = run(circuit(*LOW_PASS[:4], "R2 out 0 3k", ".end"), SourceSweep("Vin", -2, 2, 0.5))
    assert swept.sweep == pytest.approx(np.arange(-2, 2.1, 0.5))
    np.testing.assert_allclose(swept["out"], 0.75 * swept.sweep, rtol=1e-8)


@pytest.mark.parametrize("name", ["r1", "temp", "v2"])
def test_only_a_source_is_swept(circuit, name):
    with pytest.raises(InputError, match=f"no voltage or current source '{name}' to sweep.*vin"):
        run(circuit(*LOW_PASS), SourceSweep(name, 1, 10, 1))


AXES = {
    "time": Transient(1e-3, 1e-4),
    "frequency": FrequencySweep(1, 10, 1),
    "v-sweep": SourceSweep("v1", 0, 1, 1),
    "i-sweep": SourceSweep("i1", 0, 1, 1),
}


@pytest.mark.parametrize("name", AXES)
def test_a_node_called_as_an_axis(circuit, name):
    divider = ["divider", "V1 a 0 dc 1 ac 1", "I1 0 a 0", f"R1 a {name} 1k", f"R2 {name} 0 1k"]
    file = circuit(*divider, ".end")
    for axis, analysis in AXES.items():
        if axis == name:
            with pytest.raises(InputError, match=f"line 4: a node called '{name}'"):
                run(file, analysis)
        else:
            found = run(file, analysis)
            assert found.axis == axis
            assert len(found[name]) == len(found[axis])
    point = run(file, OperatingPoint())
    assert point.axis is None
    assert point[name] == pytest.approx([0.5])


def test_time_within_a_subcircuit_as_its_name_and_in_an_expression_is_no_node_of_that_name(circuit):
    file = circuit(
        "t",
        "V1 a 0 1",
        ".subckt time a b r=2",
        "R1 a time 1k",
        "R2 time b 1k",
        ".ends",
        "X1 a 0 time",
        "X2 a 0 time r = 1",
        "B1 b 0 v = 2 * time + time",
        ".end",
    )
    found = run(file, AXES["time"])
    assert found["x1.time"][-1] == pytest.approx(0.5)
    assert found["b"][-1] == pytest.approx(3e-3)


def test_a_subcircuit_that_calls_itself_is_not_run(circuit):
    calls = [f"X{k} a b s" for k in range(3)]
    file = circuit("t", "V1 a 0 1", ".subckt s a b", *calls, ".ends", "X9 a 0 s", ".end")
    with pytest.raises(InputError, match="subcircuit 's' calls itself"):
        run(file, OperatingPoint())


def test_noise_of_a_resistor(circuit):
    result = run(circuit(*LOW_PASS), Noise("out", "Vin", 1, 1e6, 20, contributions=True))
    # sqrt(4 k T R) at 27 C behind 1/sqrt(1 + (f/fc)^2), and sqrt(k T/C) in all; 1 MHz is 630 fc.
    density = np.sqrt(4 * 1.380649e-23 * 300.15 * 1e3)
    expected = density / np.abs(1 + 2j * np.pi * result.frequency * 1e-4)
    np.testing.assert_allclose(result.noise_density, expected, rtol=1e-5)
    np.testing.assert_allclose(result["onoise_r1"].real, expected, rtol=1e-5)
    total = noise_voltage(result.frequency, result.noise_density)
    assert total == pytest.approx(np.sqrt(1.380649e-23 * 300.15 / 100e-9), rel=2e-3)


def test_a_band_outside_the_spectrum_is_refused():
    with pytest.raises(InputError, match="within 1 to 10 Hz is needed"):
        noise_voltage(np.array([1.0, 10.0]), np.ones(2), 1.0, 20.0)


def test_nodes_to_keep(circuit):
    kept = run(circuit(*LOW_PASS), Transient(1e-4, 1e-6), save=["out"])
    assert kept.vectors.keys() == {"out", "time"}


def test_changed_elements_give_what_a_new_netlist_gives(circuit):
    file, sweep = circuit(*LOW_PASS), FrequencySweep(1e3, 1e4, 1)
    trials = [{"r1": 1e3 * k, "c1": 100e-9 / k**2} for k in (1, 2, 3)]
    for trial, (response, point) in zip(
        trials, run_many(file, [sweep, OperatingPoint()], trials), strict=True
    ):
        again = run(file, sweep, {"r": trial["r1"], "c": trial["c1"]})
        # Rounding: the unknowns of a circuit that was loaded anew are the same, their order not.
        np.testing.assert_allclose(response["out"], again["out"], rtol=1e-14)
        assert point["out"] == pytest.approx([2.0])


def test_changes_within_subcircuits_and_of_models(circuit):
    file = circuit(
        "nested", ".subckt half a b", "R1 a b 1k", "R2 b 0 1k", "D1 0 b z",
        ".model z d(is=1e-14 bv=3)", ".ends", "V1 a 0 4", "Xh a b half", ".end",
    )  # fmt: skip
    with Session(file) as session:
        assert session.elements == ("v1", "xh.r1", "xh.r2", "xh.d1")
        assert session.run(OperatingPoint())["b"] == pytest.approx([2.0], abs=1e-6)
        session.change({"xh.R1": 3e3})
        assert session.run(OperatingPoint())["b"] == pytest.approx([1.0], abs=1e-6)
        session.change({"v1": 40.0})
        clamped = session.run(OperatingPoint())["b"][0]
        session.change({"xh.d1[bv]": 5.0})
        assert session.run(OperatingPoint())["b"][0] - clamped == pytest.approx(2.0, abs=0.05)


def test_a_session_survives_a_failure_without_its_changes(circuit):
    with Session(circuit(*LOW_PASS[:4], "R2 out 0 1k", ".end")) as session:
        session.change({"r2": 3e3})
        assert session.run(OperatingPoint())["out"] == pytest.approx([1.5])
        session.change({"r2[nosuch]": 1.0})
        with pytest.raises(SimulationError, match="no such parameter nosuch"):
            session.run(OperatingPoint())
        assert session.run(OperatingPoint())["out"] == pytest.approx([1.5])
        with pytest.raises(InputError, match="no element 'r9'; nearest is 'r2'"):
            session.change({"r9": 1.0})


def test_sessions_do_not_share_a_circuit(circuit, tmp_path):
    first = circuit(*LOW_PASS)
    second = tmp_path / "second.cir"
    second.write_text("divider\nV1 a 0 9\nR1 a b 1k\nR2 b 0 2k\n.end\n")
    with Session(first) as one, Session(second) as two:
        assert one.run(OperatingPoint())["out"] == pytest.approx([2.0])
        assert two.run(OperatingPoint())["b"] == pytest.approx([6.0])
        assert run(first, OperatingPoint())["out"] == pytest.approx([2.0])
        two.change({"r2": 500.0})
        assert two.run(OperatingPoint())["b"] == pytest.approx([3.0])


def corner_gain(capacitance):
    sweep = run(netlists.RC_LOW_PASS, FrequencySweep(1e3, 1e4, 1), {"capacitance": capacitance})
    return complex(sweep["out"][0])


@pytest.mark.parametrize("method", ["spawn", "fork"])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of forking beside threads
def test_several_processes(method):
    values = [100e-9, 200e-9, 300e-9]
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.map(corner_gain, values)
    # The same numbers, to the last bit, as in one process.
    assert found == [corner_gain(value) for value in values]


def folder_of_a_simulator():
    SIMULATOR.version()
    folder = Path(f"/proc/{SIMULATOR.process_id}/cwd").resolve()
    assert folder.name.startswith("analog-card-")
    return folder


def vanishes(folder):
    deadline = time.monotonic() + 10
    while folder.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    return not folder.exists()


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of forking beside threads
def test_a_worker_of_a_pool_leaves_no_folder_behind():
    # A forked worker ends without exit handlers, and closes nothing.
    with multiprocessing.get_context("fork").Pool(1) as pool:
        folder = pool.apply(folder_of_a_simulator)
    assert vanishes(folder)


BUSY = """
import netlists
from analog_card.ngspice import Transient, run
from analog_card.simulator import SIMULATOR

SIMULATOR.version()
print(SIMULATOR.process_id, flush=True)
run(netlists.RC_LOW_PASS, Transient(90.0, 1e-6))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_terminated_program_leaves_no_folder_behind():
    # Terminated with its whole group, as a time limit of a shell does, while ngspice computes.
    program = subprocess.Popen(
        [sys.executable, "-c", BUSY], stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    folder = Path("/proc", program.stdout.readline().strip(), "cwd").resolve()
    assert folder.name.startswith("analog-card-")
    os.killpg(program.pid, signal.SIGTERM)
    program.communicate()
    assert vanishes(folder)


def test_a_version_that_pyspice_does_not_know_is_fine(circuit):
    from PySpice.Spice.NgSpice.SimulationType import SIMULATION_TYPE

    # PySpice 1.5 knows none after 34 and says so on every start.
    assert ngspice.ngspice_version() not in SIMULATION_TYPE
    assert run(circuit(*LOW_PASS), OperatingPoint()).warnings == ()


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: FrequencySweep(0, 1e3),
        lambda: FrequencySweep(1e3, 10),
        lambda: Transient(1e-3, 0),
        lambda: Transient(0, 1e-6),
        lambda: Noise("out", "vin", 10, 1),
        lambda: SourceSweep("vin", 0, 1, -0.1),
        lambda: SourceSweep("vin", 0, 1, 0),
        lambda: SourceSweep("vin", 0, 1, 1e-30),
        lambda: SourceSweep("vïn", 0, 1, 0.1),
        lambda: SourceSweep("v" * 2000, 0, 1, 0.1),
        lambda: Noise("a" * 2000, "vin", 1, 10),
        lambda: FrequencySweep(1, 10, 10**11),
        lambda: FrequencySweep(1, 10, 10**400),
        lambda: FrequencySweep(1, math.inf),
        lambda: Transient(1.0, 1e-30),
    ],
)
def test_impossible_analyses_are_refused(wrong):
    with pytest.raises(InputError, match="needed"):
        wrong()


def test_version():
    assert ngspice.ngspice_version() >= 36
