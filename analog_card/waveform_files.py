"""Waveforms as files and pictures: CSV, Parquet, HDF5, and curves over their axis."""

from collections.abc import Iterable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from analog_card.errors import InputError
from analog_card.files import write_whole
from analog_card.waveforms import Waveforms

_AXES = {"time": "s", "frequency": "Hz", "v-sweep": "V", "i-sweep": "A"}
FORMS = (".csv", ".parquet", ".h5")


def columns(result: Waveforms, nodes: Sequence[str] = ()) -> dict[str, tuple[str, np.ndarray]]:
    """Return a result as real columns with their units, the axis first.

    Parameters
    ----------
    result : Waveforms
        What a simulation gave.
    nodes : sequence of str, optional
        Nodes wanted; without them all.

    Returns
    -------
    dict of str to (str, ndarray)
        Unit and values by name; a complex one as magnitude and phase.

    Raises
    ------
    InputError
        When there is no such node.
    """
    axis = result.axis
    wanted = [node.lower() for node in nodes] or [name for name in result.vectors if name != axis]
    found = {axis: (_AXES[axis], result[axis].real)} if axis else {}
    for name in wanted:
        values = result[name]
        unit = "A" if name.endswith("#branch") else "V"
        if name.startswith(("onoise_", "inoise_")):
            found[name] = (f"{unit}/√Hz", values.real)
        elif np.iscomplexobj(values):
            found[f"{name}_magnitude"] = (unit, np.abs(values))
            found[f"{name}_phase"] = ("degree", np.angle(values, deg=True))
        else:
            found[name] = (unit, values)
    return found


def write_waveforms(result: Waveforms, path: str | Path, nodes: Sequence[str] = ()) -> Path:
    """Write a result to a file.

    Parameters
    ----------
    result : Waveforms
        What a simulation gave.
    path : str or Path
        The suffix says the form: ``.csv``, ``.parquet`` or ``.h5``.
    nodes : sequence of str, optional
        Nodes wanted; without them all.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        When the form or a node is not known, or the form cannot hold the name of a node.
    """
    path = Path(path)
    require_form(path)
    found = columns(result, nodes)
    content = BytesIO()
    if path.suffix == ".h5":
        _require_names_for_hdf5(path, found)
        import h5py

        with h5py.File(content, "w") as file:
            for name, (unit, values) in found.items():
                file.create_dataset(name, data=values).attrs["unit"] = unit
    else:
        import pandas as pd

        table = pd.DataFrame({f"{name} [{unit}]": data for name, (unit, data) in found.items()})
        if path.suffix == ".csv":
            table.to_csv(content, index=False)
        else:
            table.to_parquet(content, index=False)
    return write_whole(path, content.getvalue())


def require_form(path: Path) -> None:
    """Refuse a file whose form is not known, before any work is done for it.

    Raises
    ------
    InputError
        When the suffix is none of those that `write_waveforms` writes.
    """
    if path.suffix not in FORMS:
        raise InputError(f"{path}: unknown form {path.suffix!r}; there is {', '.join(FORMS)}")


def _require_names_for_hdf5(path: Path, names: Iterable[str]) -> None:
    # There a slash stands between a group and what is in it, and a dot for the group itself.
    for name in names:
        if name == "." or "/" in name:
            others = ", ".join(form for form in FORMS if form != ".h5")
            raise InputError(f"{path}: HDF5 cannot hold the name {name!r}; write {others}")


def plot_waveforms(result: Waveforms, axes: Sequence[Any], nodes: Sequence[str] = ()) -> Any:
    """Draw a result over its axis.

    Parameters
    ----------
    result : Waveforms
        What a simulation gave, other than an operating point.
    axes : sequence of matplotlib Axes
        Two for a frequency sweep, gain and phase; one for anything else.
    nodes : sequence of str, optional
        Nodes wanted; without them all node voltages outside subcircuits.

    Returns
    -------
    sequence of matplotlib Axes
        The same.

    Raises
    ------
    InputError
        When there is no such node.
    """
    axis = result.axis
    if axis is None:
        raise InputError(f"{result.netlist}: an operating point has no curve; write it with --out")
    over = result[axis].real
    names = list(nodes) or _top_level(result)
    for name in names:
        values = result[name]
        if len(axes) == 2:
            axes[0].semilogx(over, 20 * np.log10(np.maximum(np.abs(values), 1e-15)), label=name)
            axes[1].semilogx(over, np.unwrap(np.angle(values, deg=True), period=360))
        elif "onoise_spectrum" in result.vectors:
            axes[0].loglog(over, values.real, label=name)
        else:
            axes[0].plot(over, values, label=name)
    vertical = ("gain [dB]", "phase [degree]") if len(axes) == 2 else (_vertical(result, names),)
    for number, (ax, label) in enumerate(zip(axes, vertical, strict=True)):
        ax.set_ylabel(label)
        ax.grid(True, alpha=0.3)
        if number == 0:
            ax.legend(fontsize="small", frameon=False)
    axes[-1].set_xlabel(
        f"{axis.replace('v-sweep', 'source').replace('i-sweep', 'source')} [{_AXES[axis]}]"
    )
    return axes


def _top_level(result: Waveforms) -> list[str]:
    if "onoise_spectrum" in result.vectors:
        return ["onoise_spectrum", "inoise_spectrum"]
    plain = [name for name in result.vectors if "." not in name and "#" not in name]
    return [name for name in plain if name not in (result.axis, "vcc", "vee")]


def _vertical(result: Waveforms, names: Sequence[str]) -> str:
    if "onoise_spectrum" in result.vectors:
        return "noise density [V/√Hz]"
    currents = [name.endswith("#branch") for name in names]
    return "current [A]" if all(currents) else "voltage [V]" + (", current [A]" * any(currents))
