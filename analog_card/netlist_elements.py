"""The elements of a netlist with its subcircuits opened: their names, and where they stand."""

from collections.abc import Iterator
from itertools import islice

from analog_card.errors import InputError
from analog_card.netlist_text import ASSIGNMENT, Line, Netlist, nearest

_DEEPEST = 20
_MOST = 500_000


def elements(netlist: Netlist) -> dict[str, Line]:
    """Return every element by its path.

    Parameters
    ----------
    netlist : Netlist
        The netlist.

    Returns
    -------
    dict of str to Line
        Where each stands, by path: the names of the subcircuit calls and of the element, joined
        by dots and in lower case, such as ``xone.xinverter.rinput``.

    Raises
    ------
    InputError
        When a subcircuit calls itself, or there are too many elements: ngspice would not come to
        an end either.

    Examples
    --------
    >>> import netlists
    >>> from analog_card.netlist_text import read_netlist
    >>> list(elements(read_netlist(netlists.RC_LOW_PASS)))
    ['vin', 'rlowpass', 'clowpass']
    """
    top, bodies = _split(netlist)
    visited = list(islice(_opened(top, bodies, "", ()), _MOST + 1))
    if len(visited) > _MOST:
        raise InputError(
            f"{netlist.path}: more than {_MOST} elements with its subcircuits opened; "
            "let them call fewer others"
        )
    return {path: line for path, line, call in visited if not call}


def ngspice_name(path: str) -> str:
    """Return the name that ngspice gives to an element.

    Parameters
    ----------
    path : str
        As `elements` gives it.

    Returns
    -------
    str
        Within a subcircuit the letter of its kind and the path.

    Examples
    --------
    >>> ngspice_name("xone.xinverter.rinput"), ngspice_name("rload")
    ('r.xone.xinverter.rinput', 'rload')
    """
    return f"{path.rpartition('.')[2][0]}.{path}" if "." in path else path


def refuse_node(netlist: Netlist, name: str) -> None:
    """Refuse a netlist that has a node of some name outside its subcircuits.

    Parameters
    ----------
    netlist : Netlist
        The netlist.
    name : str
        What ngspice calls the axis of an analysis: it would leave out a node of that name.

    Raises
    ------
    InputError
        When an element of the top level names it.
    """
    for line in _split(netlist)[0]:
        before, equals, _ = line.text.lower().partition("=")
        words = before.split()
        # Behind the nodes stand the name of a subcircuit and that of the first parameter.
        behind = (words[0][0] == "x") + len(equals)
        if name in words[1 : len(words) - behind]:
            line.refuse(
                f"a node called {name!r}, as what the analysis runs over", "give it another name"
            )


def change_command(netlist: Netlist, known: dict[str, Line], name: str, value: float) -> str:
    """Return the command that gives an element of a loaded circuit another value.

    Parameters
    ----------
    netlist : Netlist
        The netlist, for messages.
    known : dict of str to Line
        Its elements.
    name : str
        Path of the element, for its value; with a parameter behind it in brackets, such as
        ``xone.xlimiter.dupper[bv]``, for one of its model.
    value : float
        The new value.

    Raises
    ------
    InputError
        When there is no such element.
    """
    path, _, parameter = name.lower().removesuffix("]").partition("[")
    if path not in known:
        raise InputError(f"{netlist.path}: no element {path!r}{nearest(path, known)}")
    if not parameter:
        return f"alter {ngspice_name(path)} = {float(value)!r}"
    if not parameter.isidentifier():
        raise InputError(f"{netlist.path}: {name!r} names no parameter; write element[parameter]")
    return f"altermod {ngspice_name(path)} {parameter} = {float(value)!r}"


def _split(netlist: Netlist) -> tuple[list[Line], dict[str, list[Line]]]:
    """Return the elements of the top level, and those of each subcircuit by its name."""
    top: list[Line] = []
    bodies: dict[str, list[Line]] = {}
    open_subcircuits: list[list[Line]] = [top]
    for line in netlist.lines[1:]:
        words = line.text.lower().split()
        if words[0] == ".subckt" and len(words) > 1:
            open_subcircuits.append(bodies.setdefault(words[1], []))
        elif words[0] == ".ends" and len(open_subcircuits) > 1:
            open_subcircuits.pop()
        elif not words[0].startswith("."):
            open_subcircuits[-1].append(line)
    return top, bodies


def _opened(
    lines: list[Line], bodies: dict[str, list[Line]], prefix: str, within: tuple[str, ...]
) -> Iterator[tuple[str, Line, bool]]:
    """Yield path and line of every element, and of every call of a subcircuit ahead of its own."""
    for line in lines:
        words = ASSIGNMENT.sub("", line.text.lower()).split()
        path, called = prefix + words[0], words[-1]
        call = words[0][0] == "x" and called in bodies and len(within) < _DEEPEST
        if call and called in within:
            line.refuse(f"subcircuit {called!r} calls itself", "it would be opened without end")
        yield path, line, call
        if call:
            yield from _opened(bodies[called], bodies, f"{path}.", (*within, called))
