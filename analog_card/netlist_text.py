"""Reading a netlist ahead of the simulator: includes in place, no harm, parameters set."""

import difflib
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NoReturn

import netlists
from analog_card.errors import InputError

_DIRECTIVES = re.compile(
    r"\.(ac|csparam|dc|disto|else|elseif|end|endif|ends|four|func|global|ic|if|inc|include|meas"
    r"|measure|model|nodeset|noise|op|opt|option|options|param|plot|print|probe|pz|save|sens|subckt"
    r"|temp|tf|tran|width)"
)
# Every element of plain SPICE. Left out: A (code models, which can read files and start
# programs) and N (compiled models).
_ELEMENTS = frozenset("bcdefghijklmopqrstuvwxyz")
_MINIMUM_WORDS = {"r": 4, "c": 4, "l": 4}
# Models of plain SPICE. Left out: those of code models, and of devices that are simulated
# numerically (numd, nbjt, numos), which write files of their own.
_MODELS = frozenset(
    {"c", "cpl", "csw", "d", "l", "ltra", "njf", "nmf", "nmos", "npn", "nsoi", "pjf", "pmf",
     "pmos", "pnp", "psoi", "r", "sw", "txl", "urc", "vdmos", "vdmosn", "vdmosp"}
)  # fmt: skip
_LARGEST_FILE = 5_000_000
_LONGEST_LINE = 100_000
_MOST_FILES = 200

# Comments at the end of a line, in the three forms that ngspice knows.
_COMMENT = re.compile(r";|\s\$(\s|$)|//")
# A path may hold two of them.
_COMMENT_BEHIND_PATH = re.compile(r"\s(;|\$(\s|$)|//)")
# Looked for where words begin, so that its time grows no faster than the line.
ASSIGNMENT = re.compile(r"(?<!\w)(\w+)\s*=\s*(\{[^{}]*\}|'[^']*'|\"[^\"]*\"|[^\s={}'\"]+)")

# Names as ngspice's command line takes them: plain letters, and two of them in one command.
NAME = re.compile(r"[\w.+#-]{1,200}", re.ASCII)

_SUFFIXES = {
    "t": 12,
    "g": 9,
    "meg": 6,
    "k": 3,
    "m": -3,
    "u": -6,
    "n": -9,
    "p": -12,
    "f": -15,
    "": 0,
}
_NUMBER = re.compile(
    r"([+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[+-]?\d+)?)(meg|[tgkmunpf])?[a-z]*", re.IGNORECASE
)


@dataclass(frozen=True)
class Line:
    """One logical line of a netlist, continuation lines joined, and where it began."""

    text: str
    file: Path
    number: int

    def refuse(self, found: str, instead: str) -> NoReturn:
        """Raise an InputError that names this line."""
        raise InputError(
            f"{self.file}, line {self.number}: {found} ({self.text[:80]!r}); {instead}"
        )


@dataclass(frozen=True)
class Netlist:
    """A netlist with its includes in place, checked.

    Attributes
    ----------
    path : Path
        The file it was read from.
    lines : tuple of Line
        Title first, ``.end`` last, no comments, no includes.
    files : tuple of Path
        What was read for it: its file and those included.
    """

    path: Path
    lines: tuple[Line, ...]
    files: tuple[Path, ...] = ()

    @property
    def parameters(self) -> dict[str, str]:
        """Names and expressions of the top level's ``.param`` lines."""
        return {
            name.lower(): value
            for index in _parameter_lines(self.lines)
            for name, value in ASSIGNMENT.findall(self.lines[index].text)
        }

    def with_parameters(self, values: Mapping[str, float]) -> "Netlist":
        """Return the netlist with other values in its top-level ``.param`` lines.

        Parameters
        ----------
        values : mapping of str to float
            New values by parameter name.

        Raises
        ------
        InputError
            When the netlist has no parameter of that name.
        """
        wanted = {name.lower(): value for name, value in values.items()}
        for name in wanted.keys() - self.parameters.keys():
            raise InputError(f"{self.path}: no parameter {name!r}{nearest(name, self.parameters)}")
        lines = list(self.lines)
        for index in _parameter_lines(lines):
            lines[index] = _with_values(lines[index], wanted)
        return replace(self, lines=tuple(lines))

    def with_saved(self, nodes: Sequence[str]) -> "Netlist":
        """Return the netlist with only some nodes kept by the simulator.

        Parameters
        ----------
        nodes : sequence of str
            Names of nodes, or of branches as ``source#branch``.

        Raises
        ------
        InputError
            When something is not a name.
        """
        for node in nodes:
            if not NAME.fullmatch(node):
                raise InputError(f"{self.path}: {node!r} is not a name as in a netlist")
        words = " ".join(node if "#" in node else f"v({node})" for node in nodes)
        wanted = Line(f".save {words}", self.path, self.lines[-1].number)
        return replace(self, lines=(*self.lines[:-1], wanted, self.lines[-1]))


def read_netlist(path: str | Path) -> Netlist:
    """Read a netlist, put its includes in place and refuse what could do harm.

    Parameters
    ----------
    path : str or Path
        A SPICE netlist: a title on its first line, ``.end`` on its last.

    Returns
    -------
    Netlist
        The lines that the simulator will see.

    Raises
    ------
    InputError
        When a file cannot be read; when it has no title or no ``.end``; when it holds commands
        (``.control``, ``*#``), code models, or includes from outside its own folder.

    Notes
    -----
    Includes may come from the folder of the netlist and below, and from the netlists shipped
    with this package; when the netlist is a link, its folder is that of the file it leads to.
    Only known directives and elements of plain SPICE are let through, so a netlist from a
    stranger can describe a circuit and nothing else.
    """
    path = Path(path)
    home = _followed(path).parent
    roots = (netlists.ROOT,) if home.is_relative_to(netlists.ROOT) else (home, netlists.ROOT)
    files: list[Path] = []
    lines = list(_expanded(path, roots, files))
    _require_title_and_end(path, lines)
    for line in lines[1:]:
        _refuse_harm(line)
    return Netlist(path, tuple(lines), tuple(files))


def spice_number(text: str) -> float:
    """Return a number as SPICE writes it.

    Parameters
    ----------
    text : str
        A number, with one of the suffixes t, g, meg, k, m, u, n, p, f or without; letters
        after that are a unit and are left alone, as in ``10kohm``.

    Raises
    ------
    ValueError
        When it is not a number, or beyond what floating point holds.

    Examples
    --------
    >>> spice_number("4.5meg"), spice_number("100nF"), spice_number("1M")
    (4500000.0, 1e-07, 0.001)
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number")
    # Composed as text, so that 100n is 1e-7 to the last bit.
    mantissa, _, exponent = match[1].lower().partition("e")
    number = float(f"{mantissa}e{int(exponent or 0) + _SUFFIXES[(match[2] or '').lower()]}")
    if not math.isfinite(number):
        raise ValueError(f"{text!r} is too large")
    return number


def nearest(name: str, allowed: Iterable[str]) -> str:
    """Return a phrase that names the nearest allowed name, for an error message."""
    names = sorted(allowed)
    close = difflib.get_close_matches(name, names, 1, cutoff=0.4)
    if close:
        return f"; nearest is {close[0]!r}"
    return f"; there is {', '.join(names)}" if names else "; there is none"


def _expanded(path: Path, roots: tuple[Path, ...], opened: list[Path]) -> Iterator[Line]:
    included = bool(opened)
    opened.append(path)
    if len(opened) > _MOST_FILES:
        raise InputError(
            f"{opened[0]}: more than {_MOST_FILES} included files, the last {path}; "
            "does a file include itself?"
        )
    for line in _logical_lines(path, titled=not included):
        word = line.text.split(maxsplit=1)[0].lower() if line.text else ""
        if not included and line.number == 1:
            yield line
        elif word in (".include", ".inc"):
            yield from _expanded(_included_file(line, roots), roots, opened)
        elif word == ".end" and included:
            line.refuse("an included file ends the netlist", "take .end out")
        else:
            yield line
            if word == ".end":
                return


def _included_file(line: Line, roots: tuple[Path, ...]) -> Path:
    words = line.text.split(maxsplit=1)
    if len(words) < 2:
        line.refuse("an include without a file", "write .include FILE")
    home = (_followed(line.file) if line.file.is_symlink() else line.file).parent
    included = home / words[1].strip().strip("\"'")
    if not any(_followed(included).is_relative_to(root) for root in roots):
        line.refuse(
            "an include from outside the netlist's folder",
            f"includes may come from {' or '.join(map(str, roots))}",
        )
    if not included.is_file():
        line.refuse(f"{included} is not a file", "paths are relative to the file they stand in")
    return included


def _followed(path: Path) -> Path:
    # Path.resolve raises a RuntimeError for links in a circle; opening one says what it is.
    return Path(os.path.realpath(path))


def _logical_lines(path: Path, titled: bool) -> list[Line]:
    lines: list[Line] = []
    for number, raw in enumerate(_read_text(path).splitlines(), 1):
        text = raw.strip()
        if titled and number == 1:
            lines.append(Line(text, path, number))
        elif text.startswith("*#"):
            Line(text, path, number).refuse("a hidden command", "only circuits are accepted")
        elif text.startswith("*") or text.lower().startswith(".title"):
            continue
        else:
            include = text.lower().startswith(".inc")
            comment = _COMMENT_BEHIND_PATH if include else _COMMENT
            text = comment.split(text, maxsplit=1)[0].strip()
            if text.startswith("+") and lines and not (titled and lines[-1].number == 1):
                lines[-1] = replace(lines[-1], text=f"{lines[-1].text} {text[1:].strip()}")
            elif text:
                lines.append(Line(text, path, number))
            if lines and len(lines[-1].text) > _LONGEST_LINE:
                lines[-1].refuse(
                    f"longer than {_LONGEST_LINE} characters",
                    "a line and what continues it may have no more",
                )
    return lines


def _read_text(path: Path) -> str:
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise InputError(f"{path}: larger than {_LARGEST_FILE} bytes, not read as a netlist")
        # Some editors put a mark ahead of the text, which is none of it.
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as problem:
        raise InputError(
            f"{path}: not UTF-8 text (byte {problem.start}); save it as UTF-8"
        ) from None
    except OSError as problem:
        raise InputError(f"{path}: {problem.strerror}; a netlist file is needed") from problem
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise InputError(f"{path}, line {line}: holds a zero byte; this is not a text file")
    return text


def _require_title_and_end(path: Path, lines: list[Line]) -> None:
    title = lines[0].text if lines else ""
    looks_like_code = re.match(r"\.|[rclvidqx]\d+(\s+\S+){3}", title, re.IGNORECASE)
    if not title or looks_like_code:
        raise InputError(
            f"{path}, line 1: {title[:80]!r} is not a title; "
            "SPICE never reads the first line as circuit, put a title there"
        )
    if lines[-1].text.lower() != ".end":
        raise InputError(
            f"{path}: no .end; without it nothing is simulated, end the file with .end"
        )


def _refuse_harm(line: Line) -> None:
    words = line.text.lower().split()
    if line.text.endswith("\\"):
        line.refuse("a line that ends in \\", "begin the line that continues it with +")
    if "ic.file" in line.text.lower():
        line.refuse("a state that is read from a file", "state it by .ic or ic=")
    if words[0] == ".model":
        _refuse_model(line, words)
    if words[0].startswith("."):
        if not _DIRECTIVES.fullmatch(words[0]):
            line.refuse(
                f"{words[0]} is not accepted",
                "a netlist describes a circuit and its analyses; commands (.control), libraries "
                "with sections (.lib) and compiled models are not run",
            )
        return
    # ngspice writes over the first letter of what it leaves out, and runs what begins with *#.
    if words[0][1:2] == "#":
        line.refuse("a hidden command", "a name may not begin with a letter and #")
    if ASSIGNMENT.match(line.text):
        line.refuse("an assignment in place of an element", f"write .param {line.text[:80]}")
    if words[0][0] not in _ELEMENTS:
        line.refuse("not an element of plain SPICE", "code models and commands are not run")
    if words[0][0] in "vi" and "external" in words:
        line.refuse("an external source", "nothing drives it here; give it a value or a waveform")
    if len(words) < _MINIMUM_WORDS.get(words[0][0], 1):
        line.refuse("too few words", "two nodes and a value are needed")


def _refuse_model(line: Line, words: Sequence[str]) -> None:
    kind = re.split(r"[\s(]", words[2], maxsplit=1)[0] if len(words) > 2 else ""
    if kind not in _MODELS:
        line.refuse(
            f"a model of type {kind!r}",
            f"allowed are those of plain SPICE: {', '.join(sorted(_MODELS))}",
        )


def _parameter_lines(lines: Sequence[Line]) -> Iterator[int]:
    depth = 0
    for index, line in enumerate(lines[1:], 1):
        word = line.text.split(maxsplit=1)[0].lower()
        depth += (word == ".subckt") - (word == ".ends")
        if word == ".param" and depth == 0:
            yield index


def _with_values(line: Line, wanted: Mapping[str, float]) -> Line:
    found = {name.lower() for name, _ in ASSIGNMENT.findall(line.text)}
    if not found & wanted.keys():
        return line
    if ASSIGNMENT.sub("", line.text).split() != [line.text.split()[0]]:
        line.refuse("cannot tell where a value ends", "put expressions in braces, as in a={2*b}")
    return replace(
        line,
        text=ASSIGNMENT.sub(
            lambda match: (
                f"{match[1]}={float(wanted[match[1].lower()])!r}"
                if match[1].lower() in wanted
                else match[0]
            ),
            line.text,
        ),
    )
