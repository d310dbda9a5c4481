"""What ngspice says when it fails, and where it says the failure is."""

import pickle

import pytest

from analog_card.errors import SimulationError
from analog_card.ngspice import OperatingPoint, Transient, run
from analog_card.ngspice_words import is_chatter, is_failure
from analog_card.simulator import Simulator

pytestmark = pytest.mark.ngspice

HEALTHY = ["divider", "V1 in 0 4", "R1 in out 1k", "R2 out 0 1k", ".end"]

FAILURES = [
    (["X1 a 0 nosuch"], "circuit.cir line 3: .*unknown subckt: x1 a 0 nosuch"),
    (["D1 a 0 nosuch"], "circuit.cir line 3"),
    (["R1 a 0 abc"], "unknown parameter"),
    (["B1 b 0 V=2*(3+", "R1 b 0 1"], "syntax error"),
    (["R1 a 0 1", "R1 a 0 1"], "device already exists"),
    (["R1 a 0 {nosuch}"], "circuit.cir line 3.*Undefined parameter .nosuch."),
    ([".subckt s a b", "R1 a b 1"], "Mismatch of .subckt"),
    ([".subckt s a b", "R1 a b 1", ".ends", "X1 a b c s"], "Too many parameters for subcircuit"),
    (["V2 a 0 98"], "node v\\d#branch: circuit.cir line [23]: "),
    # Short for direct current: ngspice gets a wrong current by a run in time and says it is fine.
    (["L1 a 0 1m"], "node l1#branch: circuit.cir line 3: "),
    (["shell touch x"], "switch|model|unknown|Error"),
]


@pytest.mark.parametrize(("lines", "words"), FAILURES, ids=lambda value: value[0][:12])
def test_failures_carry_the_words_of_ngspice(circuit, lines, words):
    file = circuit("failing", "V1 a 0 99", *lines, ".end")
    with pytest.raises(SimulationError, match=words) as caught:
        run(file, OperatingPoint())
    assert str(file) in str(caught.value)
    # Even after a failure that ngspice does not survive the next netlist runs.
    assert run(circuit(*HEALTHY), OperatingPoint())["out"] == pytest.approx([2.0])


HOPELESS = ["V1 a 0 sin(0 1 1k)", "B1 b 0 V=V(a)>0 ? 1e30*exp(1e5*V(b)) : -1e30", "R1 b 0 1k"]


@pytest.mark.parametrize(
    ("lines", "analysis", "line", "node", "said"),
    [
        (["V1 a 0 9", "R1 a 0 abc"], OperatingPoint(), 3, None, "unknown parameter (abc)"),
        (["V1 a 0 9", "X1 a 0 no"], OperatingPoint(), 3, None, "Error: unknown subckt: x1 a 0 no"),
        (["V1 a 0 9", "", "D1 a 0 no"], OperatingPoint(), 4, None, "d1 a 0 no"),
        (
            ["R1 a 0 1", "V1 a 0 9", "V2 a 0 98"],
            OperatingPoint(),
            3,
            "v1#branch",
            "Warning: singular matrix:  check node v1#branch",
        ),
        (HOPELESS, Transient(1e-3, 1e-5), None, "b", "tran simulation(s) aborted"),
    ],
    ids=["bad value", "missing subcircuit", "missing model", "voltage loop", "no convergence"],
)
def test_a_failure_tells_words_file_line_and_node(circuit, lines, analysis, line, node, said):
    file = circuit("failing", *lines, ".end")
    with pytest.raises(SimulationError) as caught:
        run(file, analysis)
    assert (caught.value.file, caught.value.line, caught.value.node) == (file, line, node)
    assert said in caught.value.words
    assert node is None or f"node {node}: " in str(caught.value)
    # A pool of processes hands exceptions on as bytes.
    again = pickle.loads(pickle.dumps(caught.value))  # noqa: S301 - our own
    assert (str(again), vars(again)) == (str(caught.value), vars(caught.value))


def test_a_failure_in_an_included_file_tells_that_file(circuit, tmp_path):
    part = tmp_path / "part.lib"
    part.write_text("* part\nR7 a b 1\nD7 b 0 missing\n")
    with pytest.raises(SimulationError) as caught:
        run(circuit("failing", "V1 a 0 1", ".include part.lib", ".end"), OperatingPoint())
    assert (caught.value.file, caught.value.line) == (part, 3)


def test_a_failed_netlist_never_returns_the_results_of_another(circuit):
    good = circuit("one volt", "V1 a 0 1", "R1 a 0 1k", ".end")
    assert run(good, OperatingPoint())["a"] == pytest.approx([1.0])
    with pytest.raises(SimulationError):
        run(circuit("99 volt", "V1 a 0 99", "X1 a 0 nosuch", ".end"), OperatingPoint())
    with pytest.raises(SimulationError):
        run(circuit("nothing", ".end"), OperatingPoint())
    again = circuit("99 volt", "V1 a 0 99", "R1 a 0 1k", ".end")
    assert run(again, OperatingPoint())["a"] == pytest.approx([99.0])


def test_a_run_that_takes_too_long_is_given_up(circuit):
    file = circuit(*HEALTHY)
    with pytest.raises(SimulationError, match=r"circuit\.cir: no result within 0\.3 s") as caught:
        run(file, Transient(90.0, 1e-6), time_limit=0.3)
    assert caught.value.file == file
    assert run(circuit(*HEALTHY), OperatingPoint())["out"] == pytest.approx([2.0])


def test_a_missing_library_says_how_to_get_it(monkeypatch):
    monkeypatch.setenv("NGSPICE_LIBRARY", "/no/such/library.so")
    simulator = Simulator()
    with pytest.raises(SimulationError, match="apt install libngspice0") as caught:
        simulator.version()
    assert (caught.value.words, caught.value.file, caught.value.line) == ((), None, None)
    simulator.close()


@pytest.mark.parametrize(
    "line",
    [
        "Note: Starting dynamic gmin stepping",
        "Trying gmin =   1.0000E-03 Note: One successful gmin step",
        "Warning: Further gmin increment",
        "Supplies reduced to   0.1000% Warning: source stepping failed",
        "Using SPARSE 1.3 as Direct Linear Solver",  # ngspice 42 and 43
        "Reference value :  1.00000e-03",
    ],
)
def test_chatter_is_no_failure(line):
    assert is_chatter(line)
    assert not is_failure(line)


@pytest.mark.parametrize(
    "line",
    [
        "Error: no such device",
        "doAnalyses: TRAN:  Timestep too small",
        "tran simulation(s) aborted",
        "Fatal error: instance is dead",
        "Undefined parameter [a]",
        "Error: ngspice.dll cannot recover and awaits to be detached",
    ],
)
def test_failures_are_no_chatter(line):
    assert is_failure(line)
    assert not is_chatter(line)


@pytest.mark.parametrize("line", ["error_signal = 3.0", "error", "V(error) 1.0", "no errors"])
def test_a_node_called_error_is_no_failure(line):
    assert not is_failure(line)
