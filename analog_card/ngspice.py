"""Running a netlist in ngspice: the one place through which the project simulates circuits."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analog_card.errors import InputError, SimulationError
from analog_card.netlist_text import Netlist, nearest, read_netlist
from analog_card.simulator import SIMULATOR


@dataclass(frozen=True)
class OperatingPoint:
    """The state the circuit settles at, sources at their values at time 0."""

    @property
    def command(self) -> str:
        """The analysis in ngspice's words."""
        return "op"


@dataclass(frozen=True)
class FrequencySweep:
    """Small-signal response at logarithmically spaced frequencies.

    Attributes
    ----------
    start, stop : float
        First and last frequency [Hz].
    points_per_decade : int
        How many frequencies in each decade.
    """

    start: float
    stop: float
    points_per_decade: int = 40

    def __post_init__(self) -> None:
        if not 0 < self.start < self.stop or self.points_per_decade < 1:
            raise InputError(
                f"frequency sweep from {self.start} to {self.stop} Hz with "
                f"{self.points_per_decade} points a decade; 0 < start < stop and points are needed"
            )

    @property
    def command(self) -> str:
        """The analysis in ngspice's words."""
        return f"ac dec {self.points_per_decade} {self.start!r} {self.stop!r}"


@dataclass(frozen=True)
class Transient:
    """Response over time, from the operating point at time 0.

    Attributes
    ----------
    stop : float
        Last time [s].
    longest_step : float
        The solver's steps are never longer than this [s].
    """

    stop: float
    longest_step: float

    def __post_init__(self) -> None:
        if not 0 < self.longest_step < self.stop:
            raise InputError(
                f"transient of {self.stop} s in steps of {self.longest_step} s; "
                "0 < longest step < stop is needed"
            )

    @property
    def command(self) -> str:
        """The analysis in ngspice's words."""
        return f"tran {self.longest_step!r} {self.stop!r} 0 {self.longest_step!r}"


Analysis = OperatingPoint | FrequencySweep | Transient


@dataclass(frozen=True)
class Waveforms:
    """What one analysis gave.

    Attributes
    ----------
    netlist : Path
        Where the circuit came from.
    vectors : dict of str to ndarray
        Node voltages by node name, branch currents as ``source#branch``, and the axis as
        ``time`` [s] or ``frequency`` [Hz]; complex for a frequency sweep. Names are lower case.
    warnings : tuple of str
        What ngspice remarked without failing.
    """

    netlist: Path
    vectors: dict[str, np.ndarray]
    warnings: tuple[str, ...] = ()

    def __getitem__(self, node: str) -> np.ndarray:
        """Return the values at a node."""
        try:
            return self.vectors[node.lower()]
        except KeyError:
            raise InputError(
                f"{self.netlist}: no node {node!r}{nearest(node.lower(), self.vectors)}"
            ) from None

    @property
    def time(self) -> np.ndarray:
        """The time points the solver chose [s]."""
        return self["time"]

    @property
    def frequency(self) -> np.ndarray:
        """The frequencies [Hz]."""
        return self["frequency"].real

    def at(self, times: np.ndarray, node: str) -> np.ndarray:
        """Return the values at a node at given times.

        The solver's own points differ from run to run; waveforms are only comparable on a
        common grid.

        Parameters
        ----------
        times : ndarray, shape (n,)
            Increasing times within the run [s].
        node : str
            Node name.

        Returns
        -------
        ndarray, shape (n,)
            Values interpolated between the solver's points.
        """
        return np.interp(times, self.time, self[node])


def run(
    netlist: str | Path | Netlist,
    analysis: Analysis,
    parameters: Mapping[str, float] | None = None,
    time_limit: float = 600.0,
) -> Waveforms:
    """Simulate a netlist.

    Parameters
    ----------
    netlist : str, Path or Netlist
        A netlist file, or one already read.
    analysis : OperatingPoint, FrequencySweep or Transient
        What to compute; analyses written in the netlist are left alone.
    parameters : mapping of str to float, optional
        Values for the netlist's ``.param`` names, in SPICE's base units.
    time_limit : float, optional
        Longest wait for the answer [s].

    Returns
    -------
    Waveforms
        Everything ngspice computed.

    Raises
    ------
    InputError
        When the netlist cannot be read, holds something other than a circuit, or has no
        parameter of a name given.
    SimulationError
        When ngspice failed, in its own words, with the file and line it means.

    Examples
    --------
    >>> import netlists
    >>> sweep = run(netlists.DOUBLE_DIFFERENTIATOR_AC, FrequencySweep(10.0, 1000.0, 1))
    >>> abs(sweep["velocity"]).round(3)  # 2 pi f x 12 ms, until the filter bites
    array([ 0.754,  7.532, 67.826])
    """
    source = netlist if isinstance(netlist, Netlist) else read_netlist(netlist)
    if parameters:
        source = source.with_parameters(parameters)
    lines = [line.text for line in source.lines]
    try:
        header, found = SIMULATOR.ask(lines, analysis.command, time_limit)
        vectors = {_node_name(name): values for name, values in found.items()}
        if "failure" in header:
            raise SimulationError(_in_its_own_words(source, header))
        if isinstance(analysis, Transient):
            _require_end(analysis, vectors["time"])
    except SimulationError as problem:
        raise SimulationError(f"{source.path}: {problem}") from problem
    return Waveforms(source.path, vectors, tuple(header["words"]))


def ngspice_version() -> int:
    """Return the version of the ngspice library in use.

    Raises
    ------
    SimulationError
        When it cannot be started.
    """
    return SIMULATOR.version()


def _require_end(analysis: Transient, time: np.ndarray) -> None:
    # What an aborted run has computed so far stays readable.
    reached = float(time[-1]) if time.size else 0.0
    if reached < analysis.stop * (1 - 1e-9):
        raise SimulationError(
            f"the transient ended at {reached:g} s, asked was {analysis.stop:g} s"
        )


def _node_name(name: str) -> str:
    # ngspice writes node 1 as V(1) because a bare number would not be a name.
    match = re.fullmatch(r"v\((.*)\)", name, re.IGNORECASE)
    return (match[1] if match else name).lower()


def _in_its_own_words(netlist: Netlist, header: Mapping[str, Any]) -> str:
    """Return what ngspice said, with its line numbers turned into files and lines."""

    def place(match: re.Match[str]) -> str:
        index = int(match[1]) - 1
        if not 0 <= index < len(netlist.lines):
            return match[0]
        line = netlist.lines[index]
        return f"{line.file.name} line {line.number}"

    words = " | ".join(header["words"]) or header["failure"]
    said = re.sub(r"(?:netlist )?line(?: no\.)? (\d+)", place, words, flags=re.IGNORECASE)
    node = re.search(r'(?:trouble with|check) node "?([\w.#]+)', said)
    return f"node {node[1]}: {said}" if node else said
