"""What a failed assertion says: figure, limit, where in time, which rig and which controller."""

from collections.abc import Mapping, Sequence
from typing import Any, NoReturn, Protocol, runtime_checkable

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import controller_settings
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.simulation import Simulation


@runtime_checkable
class Run(Protocol):
    """What assertions are made of: a simulation, a recording, or what is like them."""

    @property
    def time(self) -> Array:
        """Return the times of the samples [s]."""

    def __contains__(self, channel: str) -> bool:
        """Return whether there is a channel."""

    def __getitem__(self, channel: str) -> Array:
        """Return the samples of a channel."""


def samples(run: Run, channel: str) -> Array:
    """Return a channel that an assertion needs.

    Raises
    ------
    InputError
        When there is none, samples are missing, or it is no run at all: nothing could be said of
        it.
    """
    if not isinstance(run, Run):
        raise InputError(
            f"{run!r} is no run; give a simulation, such as from close_loop, or a recording, such "
            "as from read_recording"
        )
    if channel not in run:
        raise InputError(f"the run has no channel {channel!r}, which this assertion looks at")
    values = run[channel]
    missing = ~np.isfinite(values)
    if missing.any():
        raise InputError(
            f"channel {channel!r}: {int(missing.sum())} of {len(values)} samples are missing, "
            f"the first at t = {run.time[int(np.argmax(missing))]:g} s; cut the run to where it "
            "is whole"
        )
    return values


def fail(run: Run, found: Sequence[str]) -> NoReturn:
    """Raise what pytest shows of a failed assertion.

    Parameters
    ----------
    run : Run
        What failed.
    found : sequence of str
        What was found, where in time, and what is allowed; one line each.

    Raises
    ------
    AssertionError
        Always.
    """
    __tracebackhide__ = True
    raise AssertionError("\n  ".join([*found, *_about(run)]))


def _about(run: Run) -> list[str]:
    """Return which rig and which controller a run is of."""
    if isinstance(run, Simulation):
        recording = run.to_recording()
        controller = "none, a command was replayed"
        if run.controller is not None:
            controller = _listed(run.controller.kind, controller_settings(run.controller))
    elif isinstance(run, Recording):
        recording = run
        controller = _listed(run.name, run.controller)
    else:
        return []
    return [f"rig: {_listed(recording.rig, recording.conditions)}", f"controller: {controller}"]


def _listed(name: str, values: Mapping[str, Any]) -> str:
    """Return a name and the numbers that go with it, those of a card among them."""
    flat = dict(values)
    for value in values.values():
        flat |= value if isinstance(value, Mapping) else {}
    told = [
        f"{key} = {value:.6g}" if isinstance(value, float) else f"{key} = {value}"
        for key, value in flat.items()
        if isinstance(value, int | float | str)
    ]
    return ", ".join([name, *told])
