"""What ngspice can be asked to compute, and the analysis that a netlist itself asks for."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from analog_card.errors import InputError
from analog_card.netlist_text import NAME, Line, Netlist, spice_number

# They take 0.8 GB for each node.
_MOST_POINTS = 100_000_000


@dataclass(frozen=True)
class OperatingPoint:
    """The state the circuit settles at, sources at their values at time 0."""

    axis = None

    @property
    def command(self) -> str:
        """The analysis in ngspice's words."""
        return "op"


@dataclass(frozen=True)
class SourceSweep:
    """Operating points over the values of one source.

    Attributes
    ----------
    source : str
        Name of a voltage or current source at the top level of the netlist.
    start, stop, step : float
        First and last value, and from one to the next [V] or [A].
    """

    source: str
    start: float
    stop: float
    step: float

    def __post_init__(self) -> None:
        _require_name(self.source, "source")
        if not (self.step and (self.stop - self.start) / self.step > 0):
            raise InputError(
                f"sweep from {self.start:g} to {self.stop:g} in steps of {self.step:g}; "
                "a step that leads from the first value to the last is needed"
            )
        _require_few((self.stop - self.start) / self.step, "sweep", "a longer step is")

    @property
    def axis(self) -> str:
        """What ngspice calls the values of the source."""
        return f"{self.source[0].lower()}-sweep"

    @property
    def command(self) -> str:
        """The analysis in ngspice's words."""
        return f"dc {self.source.lower()} {self.start!r} {self.stop!r} {self.step!r}"


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

    axis = "frequency"

    def __post_init__(self) -> None:
        _require_band(self.start, self.stop, self.points_per_decade)

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
    from_initial_conditions : bool
        Start from the netlist's initial conditions instead of the operating point.
    """

    stop: float
    longest_step: float
    from_initial_conditions: bool = False

    axis = "time"

    def __post_init__(self) -> None:
        if not 0 < self.longest_step < self.stop:
            raise InputError(
                f"transient of {self.stop} s in steps of {self.longest_step} s; "
                "0 < longest step < stop is needed"
            )
        _require_few(self.stop / self.longest_step, "transient", "a longer step is")

    @property
    def command(self) -> str:
        """The analysis in ngspice's words."""
        end = " uic" if self.from_initial_conditions else ""
        return f"tran {self.longest_step!r} {self.stop!r} 0 {self.longest_step!r}{end}"


@dataclass(frozen=True)
class Noise:
    """Noise density at a node, at logarithmically spaced frequencies.

    Attributes
    ----------
    node : str
        Where the noise is wanted.
    source : str
        Name of the source that the input-referred noise refers to.
    start, stop : float
        First and last frequency [Hz].
    points_per_decade : int
        How many frequencies in each decade.
    contributions : bool
        Whether the share of every element is wanted too.

    Notes
    -----
    Gives ``onoise_spectrum`` and ``inoise_spectrum`` [V/sqrt(Hz)] over ``frequency``, and with
    contributions ``onoise_`` and the element's name, such as ``onoise_r.xone.xinverter.rinput``
    [V/sqrt(Hz)].
    """

    node: str
    source: str
    start: float
    stop: float
    points_per_decade: int = 20
    contributions: bool = False

    axis = "frequency"

    def __post_init__(self) -> None:
        _require_name(self.node, "node")
        _require_name(self.source, "source")
        _require_band(self.start, self.stop, self.points_per_decade)

    @property
    def command(self) -> str:
        """The analysis in ngspice's words."""
        each = " 1" if self.contributions else ""
        return (
            f"noise v({self.node.lower()}) {self.source.lower()} "
            f"dec {self.points_per_decade} {self.start!r} {self.stop!r}{each}"
        )


# Each tells as `axis` what ngspice calls what it runs over.
Analysis = OperatingPoint | SourceSweep | FrequencySweep | Transient | Noise


def analysis_in(netlist: Netlist, kind: str) -> Analysis:
    """Return the analysis of one kind that a netlist asks for itself.

    Parameters
    ----------
    netlist : Netlist
        The netlist.
    kind : str
        ``op``, ``dc``, ``ac``, ``tran`` or ``noise``.

    Returns
    -------
    Analysis
        That of its first line of this kind.

    Raises
    ------
    InputError
        When it has no such line, or one in a form that is not understood.

    Examples
    --------
    >>> import netlists
    >>> from analog_card.netlist_text import read_netlist
    >>> analysis_in(read_netlist(netlists.RC_LOW_PASS), "ac")
    FrequencySweep(start=10.0, stop=100000.0, points_per_decade=10)
    """
    if kind == "op":
        return OperatingPoint()
    for line in netlist.lines[1:]:
        words = line.text.split()
        if words[0].lower() == f".{kind}":
            return _understood(line, _READERS[kind], _FORMS[kind])
    raise InputError(
        f"{netlist.path}: no .{kind} line; add one ({_FORMS[kind]}) "
        "or say what is wanted by options"
    )


def _understood(line: Line, reader: Callable[[list[str]], Analysis], form: str) -> Analysis:
    try:
        return reader(line.text.split()[1:])
    except (ValueError, IndexError):
        line.refuse("not understood", f"{form} is, with plain numbers")


def _dc(words: list[str]) -> Analysis:
    source, start, stop, step = words
    return SourceSweep(source, spice_number(start), spice_number(stop), spice_number(step))


def _ac(words: list[str]) -> Analysis:
    points, start, stop = _decades(words)
    return FrequencySweep(start, stop, points)


def _tran(words: list[str]) -> Analysis:
    plain = [word for word in words if word.lower() != "uic"]
    step, stop = spice_number(plain[0]), spice_number(plain[1])
    longest = spice_number(plain[3]) if len(plain) > 3 else step
    return Transient(stop, longest, len(plain) < len(words))


def _noise(words: list[str]) -> Analysis:
    node = re.fullmatch(rf"v\(({NAME.pattern})\)", words[0], re.IGNORECASE)
    if node is None:
        raise ValueError(words[0])
    points, start, stop = _decades(words[2:6])
    return Noise(node[1], words[1], start, stop, points)


def _decades(words: list[str]) -> tuple[int, float, float]:
    kind, points, start, stop = words
    if kind.lower() != "dec":
        raise ValueError(kind)
    return int(points), spice_number(start), spice_number(stop)


_READERS = {"dc": _dc, "ac": _ac, "tran": _tran, "noise": _noise}
_FORMS = {
    "dc": ".dc SOURCE START STOP STEP",
    "ac": ".ac dec POINTS START STOP",
    "tran": ".tran STEP STOP [START [LONGEST]] [uic]",
    "noise": ".noise v(NODE) SOURCE dec POINTS START STOP",
}


def _require_band(start: float, stop: float, points: int) -> None:
    if not 0 < start < stop or points < 1:
        raise InputError(
            f"frequency sweep from {start} to {stop} Hz with {points} points a decade; "
            "0 < start < stop and points are needed"
        )
    _require_few(points, "frequency sweep", "fewer points a decade are")
    _require_few(points * math.log10(stop / start), "frequency sweep", "fewer points a decade are")


def _require_few(points: float, what: str, instead: str) -> None:
    if points > _MOST_POINTS:
        raise InputError(f"{what} of more than {_MOST_POINTS} points; {instead} needed")


def _require_name(name: str, what: str) -> None:
    # These reach ngspice's command line: nothing but a name may.
    if not NAME.fullmatch(name):
        raise InputError(
            f"{what}: {name[:80]!r} is not a name as in a netlist; "
            "1 to 200 letters from a to z, digits and . _ + # - are needed"
        )
