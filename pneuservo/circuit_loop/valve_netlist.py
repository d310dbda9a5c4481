"""The discharge coefficients of a valve as a netlist: tables written as expressions."""

from collections.abc import Iterable

from pneuservo.plant.flow_paths import FlowPathTable
from pneuservo.rigs import load_valve_tables

_HEAD = """\
* Discharge coefficients of the servo valve {name}, tables 4.2 to 4.5 of the thesis.
* Written by python -m pneuservo.circuit_loop.valve_netlist {name}: change the tables there.
* Linear in pressure ratio within a row, linear in the command between rows; the first row holds
* below its command, the last above.
* Nodes of discharge: spool, its sign says which paths are open; command, that would hold it [V];
* ratio_a ratio_b, lower over higher pressure across each port's path; coefficient_a coefficient_b.
"""


def valve_netlist(name: str) -> str:
    """Return the discharge coefficients of a built-in valve as a subcircuit ``discharge``.

    Parameters
    ----------
    name : str
        Name of the valve, such as ``"ddv-27a1"``.

    Returns
    -------
    str
        The text of the file ``netlists/plant/NAME.lib``.

    Raises
    ------
    InputError
        When there is no such valve.

    Notes
    -----
    Of nested conditions ngspice computes only the branch that applies, so that a table costs two
    rows and a few comparisons.

    Examples
    --------
    >>> valve_netlist("ddv-27a1").splitlines()[0]
    '* Discharge coefficients of the servo valve ddv-27a1, tables 4.2 to 4.5 of the thesis.'
    """
    tables = load_valve_tables(name)
    lines = [".subckt discharge spool command ratio_a ratio_b coefficient_a coefficient_b"]
    for port, opened, closed in (("a", "s_a", "a_e"), ("b", "b_e", "s_b")):
        lines.append(f"B{port} coefficient_{port} 0 V=V(spool) >= 0 ?")
        lines += _table(tables[opened], f"V(ratio_{port})")
        lines.append("+ :")
        lines += _table(tables[closed], f"V(ratio_{port})")
    lines.append(".ends discharge")
    return _HEAD.format(name=name) + "\n" + "\n".join(lines) + "\n"


def _table(table: FlowPathTable, ratio: str) -> list[str]:
    rows = [
        f"pwl({ratio},{_pairs(zip(*row, strict=True))})"
        for row in zip(table.pressure_ratio, table.discharge_coefficient, strict=True)
    ]
    volts = [float(value) for value in table.command]
    lines = [f"+ (V(command) <= {volts[0]!r} ? {rows[0]} :"]
    for k in range(len(rows) - 1):
        width = volts[k + 1] - volts[k]
        between = (
            f"{rows[k]}*({volts[k + 1]!r}-V(command))/{width!r}",
            f"{rows[k + 1]}*(V(command)-{volts[k]!r})/{width!r}",
        )
        lines.append(f"+ V(command) <= {volts[k + 1]!r} ? {between[0]}")
        lines.append(f"+ +{between[1]} :")
    lines.append(f"+ {rows[-1]})")
    return lines


def _pairs(points: Iterable[tuple[float, float]]) -> str:
    return ",".join(f"{float(x)!r},{float(y)!r}" for x, y in points)


if __name__ == "__main__":
    import sys

    print(valve_netlist(sys.argv[1]), end="")
