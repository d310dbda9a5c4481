"""The elements of a netlist with its subcircuits opened: their names, and where they stand."""

from collections.abc import Iterator

from analog_card.errors import InputError
from analog_card.netlist_text import ASSIGNMENT, Line, Netlist, nearest

_DEEPEST = 20


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

    Examples
    --------
    >>> import netlists
    >>> from analog_card.netlist_text import read_netlist
    >>> list(elements(read_netlist(netlists.RC_LOW_PASS)))
    ['vin', 'rlowpass', 'clowpass']
    """
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
    return dict(_opened(top, bodies, "", 0))


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


def _opened(
    lines: list[Line], bodies: dict[str, list[Line]], prefix: str, depth: int
) -> Iterator[tuple[str, Line]]:
    for line in lines:
        words = ASSIGNMENT.sub("", line.text.lower()).split()
        path = prefix + words[0]
        if words[0][0] == "x" and words[-1] in bodies and depth < _DEEPEST:
            yield from _opened(bodies[words[-1]], bodies, f"{path}.", depth + 1)
        else:
            yield path, line
