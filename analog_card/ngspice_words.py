"""Judging what ngspice says: what is a failure, what is chatter, and where in the netlist it is."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from analog_card.netlist_elements import elements
from analog_card.netlist_text import Line, Netlist

# How ngspice begins a line about something that failed. Notes, warnings and the steps of the
# search for an operating point are not failures, nor is a node that has "error" in its name.
_FAILURE = re.compile(
    r"(error:|error on line|pterror|fatal\b|doanalyses:|.*simulation\(s\) aborted|undefined par"
    r"|cannot compute|could not find|.*unknown subckt|.*awaits to be detached)",
    re.IGNORECASE,
)
# ngspice 42 and 43 print "Using SPARSE 1.3 ..." on standard error before every analysis.
_CHATTER = re.compile(
    r"note:|trying gmin|supplies reduced|using sparse|reference value"
    r"|warning: .*(gmin|source step)",
    re.IGNORECASE,
)
_LINE = re.compile(r"(?:original |netlist |internal )?line(?: no\.?:?)? (\d+)", re.IGNORECASE)
_NODE = re.compile(r'(?:trouble with|check) node "?([\w.#]+)', re.IGNORECASE)


def is_failure(line: str) -> bool:
    """Whether a line that ngspice printed says that something failed.

    Examples
    --------
    >>> is_failure("Error: no such device"), is_failure("error_signal = 3.0")
    (True, False)
    """
    return bool(_FAILURE.match(line))


def is_chatter(line: str) -> bool:
    """Whether a line on standard error only tells how the work goes on.

    Examples
    --------
    >>> is_chatter("Note: Starting dynamic gmin stepping"), is_chatter("singular matrix")
    (True, False)
    """
    return bool(_CHATTER.match(line))


@dataclass(frozen=True)
class Located:
    """What ngspice said about a netlist, and where.

    Attributes
    ----------
    text : str
        Its words with line numbers turned into files and lines; the node or the place that it
        means in front, when its words name an element or repeat a line.
    line : Line or None
        The line that it means.
    node : str or None
        The node or branch that it names.
    """

    text: str
    line: Line | None
    node: str | None


def located(netlist: Netlist, words: Sequence[str]) -> Located:
    """Find the line and the node that ngspice means.

    Parameters
    ----------
    netlist : Netlist
        The netlist it was given.
    words : sequence of str
        What it said.

    Returns
    -------
    Located
        Its words in one line, and the place.
    """
    plain = " | ".join(words)
    numbered: list[Line] = []

    def place(match: re.Match[str]) -> str:
        index = int(match[1]) - 1
        if not 0 <= index < len(netlist.lines):
            return match[0]
        numbered.append(netlist.lines[index])
        return _place(numbered[-1])

    said = _LINE.sub(place, plain)
    node = _NODE.search(said)
    meant = numbered or _meant(netlist, said.lower())
    found = [f"node {node[1]}"] if node else []
    if not numbered:
        found += [_place(line) for line in meant[:1]]
    return Located(": ".join([*found, said]), meant[0] if meant else None, node and node[1])


def _meant(netlist: Netlist, said: str) -> list[Line]:
    """Return the lines that the words repeat, or else those of the elements they name."""
    repeated = [
        line for line in netlist.lines[1:] if " " in line.text and line.text.lower() in said
    ]
    if repeated:
        return repeated
    named = re.findall(r"[a-z][\w.]*(?=#branch|\b)", said)
    known = elements(netlist)
    paths = [path for name in named for path in (name, name.partition(".")[2]) if path in known]
    return [known[path] for path in paths]


def _place(line: Line) -> str:
    return f"{line.file.name} line {line.number}"
