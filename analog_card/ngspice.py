"""Running a netlist in ngspice: the one place through which the project simulates circuits."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Self

import numpy as np

from analog_card.analyses import (
    Analysis,
    FrequencySweep,
    Noise,
    OperatingPoint,
    SourceSweep,
    Transient,
)
from analog_card.errors import InputError, SimulationError
from analog_card.netlist_elements import change_command, elements, refuse_node
from analog_card.netlist_text import Netlist, nearest, read_netlist
from analog_card.ngspice_words import located
from analog_card.simulator import SIMULATOR, Simulator
from analog_card.waveforms import Waveforms, noise_voltage

__all__ = [
    "Analysis",
    "FrequencySweep",
    "Noise",
    "OperatingPoint",
    "Session",
    "SourceSweep",
    "Transient",
    "Waveforms",
    "ngspice_version",
    "noise_voltage",
    "run",
    "run_many",
]


def run(
    netlist: str | Path | Netlist,
    analysis: Analysis,
    parameters: Mapping[str, float] | None = None,
    time_limit: float = 600.0,
    save: Sequence[str] = (),
) -> Waveforms:
    """Simulate a netlist.

    Parameters
    ----------
    netlist : str, Path or Netlist
        A netlist file, or one already read.
    analysis : OperatingPoint, SourceSweep, FrequencySweep, Transient or Noise
        What to compute; analyses written in the netlist are left alone.
    parameters : mapping of str to float, optional
        Values for the netlist's ``.param`` names, in SPICE's base units.
    time_limit : float, optional
        Longest wait for the answer [s].
    save : sequence of str, optional
        Nodes to keep, which makes long transients faster; without it all.

    Returns
    -------
    Waveforms
        Everything ngspice computed, or the nodes to keep.

    Raises
    ------
    InputError
        When the netlist cannot be read, holds something other than a circuit or a subcircuit that
        calls itself, has no parameter or source of a name given, or a node called as the axis of
        the analysis is.
    SimulationError
        When ngspice failed, with its own words and the file, line and node it means.

    Examples
    --------
    >>> import netlists
    >>> sweep = run(netlists.DOUBLE_DIFFERENTIATOR_AC, FrequencySweep(10.0, 1000.0, 1))
    >>> abs(sweep["velocity"]).round(3)  # 2 pi f x 12 ms, until the filter bites
    array([ 0.754,  7.532, 67.826])
    """
    source = _prepared(netlist, parameters, save)
    # Which refuses subcircuits, too, that ngspice would open without end.
    _require_possible(source, elements(source), analysis)
    return _asked(SIMULATOR, source, analysis, time_limit, send=True, changes=[], keep=False)


class Session:
    """One circuit, loaded once and run many times with other values of its elements.

    Has an ngspice process of its own; use it in a ``with`` statement.

    Parameters
    ----------
    netlist : str, Path or Netlist
        A netlist file, or one already read.
    parameters : mapping of str to float, optional
        Values for the netlist's ``.param`` names; they hold for the whole session.
    save : sequence of str, optional
        Nodes to keep; without it all.
    time_limit : float, optional
        Longest wait for each answer [s].

    Raises
    ------
    InputError
        As for `run`.

    Notes
    -----
    Only values of elements and of their models change without reading the netlist again; a
    parameter needs a new session, which costs as much as ngspice's own way to change one.

    Examples
    --------
    >>> import netlists
    >>> with Session(netlists.RC_LOW_PASS) as session:
    ...     session.change({"rlowpass": 2e3})
    ...     halved = session.run(FrequencySweep(1e3, 1e4, 1))
    >>> abs(halved["out"][:1]).round(4)  # 1/sqrt(1 + 2^2): the corner is now at 500 Hz
    array([0.4472])
    """

    def __init__(
        self,
        netlist: str | Path | Netlist,
        parameters: Mapping[str, float] | None = None,
        save: Sequence[str] = (),
        time_limit: float = 600.0,
    ) -> None:
        self._netlist = _prepared(netlist, parameters, save)
        self._elements = elements(self._netlist)
        self._time_limit = time_limit
        self._simulator = Simulator()
        self._loaded = False
        self._changes: dict[str, str] = {}
        self._waiting: dict[str, str] = {}
        self._possible: set[Analysis] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    @property
    def elements(self) -> tuple[str, ...]:
        """Names of the elements, as `change` takes them."""
        return tuple(self._elements)

    @property
    def process_id(self) -> int | None:
        """The process of the session, when there is one."""
        return self._simulator.process_id

    def change(self, values: Mapping[str, float]) -> None:
        """Give elements other values, until they are changed again.

        Parameters
        ----------
        values : mapping of str to float
            New values by element, such as ``{"xone.xinverter.rinput": 22.1e3}``; a parameter of
            an element's model in brackets, as in ``xone.xlimiter.dupper[bv]``. A voltage or
            current source gets another DC value.

        Raises
        ------
        InputError
            When there is no such element.
        """
        self._waiting |= {
            name.lower(): change_command(self._netlist, self._elements, name, value)
            for name, value in values.items()
        }

    def run(self, analysis: Analysis) -> Waveforms:
        """Run one analysis of the circuit as it now is.

        Raises
        ------
        SimulationError
            When ngspice failed. The session goes on; what was changed since the last run is
            taken back.
        """
        changed = self._changes | self._waiting
        changes = list((self._waiting if self._loaded else changed).values())
        send, self._loaded, self._waiting = not self._loaded, False, {}
        # Once, and not in each of thousands of trials.
        if analysis not in self._possible:
            _require_possible(self._netlist, self._elements, analysis)
            self._possible.add(analysis)
        result = _asked(
            self._simulator, self._netlist, analysis, self._time_limit, send, changes, keep=True
        )
        self._loaded, self._changes = True, changed
        return result

    def close(self) -> None:
        """End the session's process."""
        self._simulator.close()
        self._loaded = False


def run_many(
    netlist: str | Path | Netlist,
    analyses: Sequence[Analysis],
    trials: Iterable[Mapping[str, float]],
    parameters: Mapping[str, float] | None = None,
    save: Sequence[str] = (),
) -> Iterator[tuple[Waveforms, ...]]:
    """Run the same analyses for many sets of element values, as a Monte Carlo study does.

    Parameters
    ----------
    netlist : str, Path or Netlist
        A netlist file, or one already read.
    analyses : sequence of analyses
        What to compute in each trial.
    trials : iterable of mapping of str to float
        Values of elements, as for `Session.change`. A value that a later trial does not name
        stays as it is, so name the same elements in all.
    parameters, save
        As for `run`.

    Yields
    ------
    tuple of Waveforms
        For each trial the results of the analyses.

    Raises
    ------
    InputError, SimulationError
        As for `run`.
    """
    with Session(netlist, parameters, save) as session:
        for values in trials:
            session.change(values)
            yield tuple(session.run(analysis) for analysis in analyses)


def ngspice_version() -> int:
    """Return the version of the ngspice library in use.

    Raises
    ------
    SimulationError
        When it cannot be started.
    """
    return SIMULATOR.version()


def _prepared(
    netlist: str | Path | Netlist, parameters: Mapping[str, float] | None, save: Sequence[str]
) -> Netlist:
    source = netlist if isinstance(netlist, Netlist) else read_netlist(netlist)
    if parameters:
        source = source.with_parameters(parameters)
    return source.with_saved(save) if save else source


def _asked(
    simulator: Simulator,
    source: Netlist,
    analysis: Analysis,
    time_limit: float,
    send: bool,
    changes: list[str],
    keep: bool,
) -> Waveforms:
    lines = [line.text for line in source.lines] if send else None
    try:
        header, found = simulator.ask(lines, analysis.command, time_limit, changes, keep)
    except SimulationError as problem:
        raise SimulationError(
            f"{source.path}: {problem}", words=problem.words, file=source.path
        ) from problem
    vectors = {_node_name(name): values for name, values in found.items()}
    if "failure" in header:
        raise _failure(source, header["words"], header["failure"])
    if isinstance(analysis, Transient):
        _require_end(source, analysis, vectors["time"], header["words"])
    return Waveforms(source.path, vectors, tuple(header["words"]), analysis.axis)


def _require_possible(netlist: Netlist, known: Iterable[str], analysis: Analysis) -> None:
    """Refuse an analysis that ngspice would give another meaning in this netlist."""
    if isinstance(analysis, SourceSweep):
        _require_source(netlist, known, analysis.source)
    if analysis.axis is not None:
        refuse_node(netlist, analysis.axis)


def _require_source(netlist: Netlist, known: Iterable[str], name: str) -> None:
    # ngspice would sweep a resistor or the temperature too, which is neither volts nor amperes.
    sources = [path for path in known if path[0] in "vi" and "." not in path]
    if name.lower() not in sources:
        raise InputError(
            f"{netlist.path}: no voltage or current source {name!r} to sweep"
            f"{nearest(name.lower(), sources)}"
        )


def _failure(source: Netlist, words: Sequence[str], otherwise: str) -> SimulationError:
    """Return what ngspice said about a netlist, or else what is to be said of it."""
    place = located(source, words)
    return SimulationError(
        f"{source.path}: {place.text or otherwise}",
        words=words,
        file=place.line.file if place.line else source.path,
        line=place.line.number if place.line else None,
        node=place.node,
    )


def _require_end(
    source: Netlist, analysis: Transient, time: np.ndarray, words: Sequence[str]
) -> None:
    # What an aborted run has computed so far stays readable.
    reached = float(time[-1]) if time.size else 0.0
    if reached < analysis.stop * (1 - 1e-9):
        raise SimulationError(
            f"{source.path}: the transient ended at {reached:g} s, asked was {analysis.stop:g} s",
            words=words,
            file=source.path,
        )


def _node_name(name: str) -> str:
    # ngspice writes node 1 as V(1) because a bare number would not be a name.
    match = re.fullmatch(r"v\((.*)\)", name, re.IGNORECASE)
    return (match[1] if match else name).lower()
