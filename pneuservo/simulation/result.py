"""The result of a simulation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import Controller, controller_settings
from pneuservo.errors import InputError
from pneuservo.recordings import CHANNELS, Recording
from pneuservo.recordings.conditions import CONTROLLER_KINDS
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation.metrics import LimitCycle, StepResponse, limit_cycle, step_responses

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Simulation:
    """One simulated run.

    Parameters
    ----------
    rig : Rig
        The rig it is of, with every value used.
    time : (n,) array
        [s].
    channels : mapping of str to (n,) array
        Canonical channel name to samples in SI (see `pneuservo.recordings.CHANNELS`). Each row is
        the state just after its time, when a command or demand of that time already acts.
    controller : Controller, optional
        What closed the loop; None when a command was replayed.
    surface : (n,) array, optional
        The controller's switching function, in its own unit.
    """

    rig: Rig
    time: Array
    channels: Mapping[str, Array]
    controller: Controller | None = None
    surface: Array | None = None

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time)

    def __contains__(self, channel: str) -> bool:
        """Return whether the run has a channel."""
        return channel in self.channels

    def __getitem__(self, channel: str) -> Array:
        """Return the samples of a channel."""
        return self.channels[channel]

    def to_recording(self, name: str = "simulation") -> Recording:
        """Return the run as a recording, complete enough to be simulated again.

        Parameters
        ----------
        name : str, optional
            Name of the recording.

        Returns
        -------
        Recording
            All channels; the rig's kind, and as conditions every value that differs from the
            built-in rig of that kind.
        """
        built_in = load_rig(self.rig.kind)
        conditions = {
            key: self.rig[parameter]
            for key, parameter in self.rig.conditions.items()
            if self.rig[parameter] != built_in[parameter]
        }
        title = "simulated, command replayed"
        notes = ""
        stated: dict[str, str] = {}
        if self.controller is not None:
            title = f"simulated, {self.controller.kind} controller"
            settings = controller_settings(self.controller)
            notes = ", ".join(f"{name} = {value!r}" for name, value in settings.items())
            stated = _stated(self.controller.kind)
        return Recording(
            name=name,
            time=self.time,
            channels={key: self.channels[key] for key in CHANNELS if key in self.channels},
            rig=self.rig.kind,
            conditions=conditions,
            controller=stated,
            title=title,
            notes=notes,
        )

    def step_responses(self, band: float = 0.02) -> list[StepResponse]:
        """Return how the loop answered every change of its demand.

        Parameters
        ----------
        band : float, optional
            Half width of the settling band, as a share of the step [-].

        Raises
        ------
        InputError
            When the run has no demand.
        """
        self._require("demand")
        return step_responses(self.time, self["demand"], self["displacement"], band)

    def settling_time(self, band: float = 0.02) -> float:
        """Return the settling time of the last step; NaN when it has not settled [s].

        Parameters
        ----------
        band : float, optional
            Half width of the settling band about the final value, as a share of the step [-].

        Raises
        ------
        InputError
            When the run has no demand, or the demand never changes.
        """
        responses = self.step_responses(band)
        if not responses:
            raise InputError(
                "the demand never changes, so that there is no step to settle from; "
                "give it two set points and more"
            )
        return responses[-1].settling_time

    def steady_state_error(self, share: float = 0.2) -> float:
        """Return demand less displacement, mean over the end of the last hold [m].

        Parameters
        ----------
        share : float, optional
            Share of the hold that is averaged [-].

        Raises
        ------
        InputError
            When the run has no demand.
        """
        self._require("demand")
        error = (self["demand"] - self["displacement"])[self._last_change() :]
        return float(np.mean(error[-max(round(len(error) * share), 1) :]))

    def limit_cycle(self, start: float | None = None) -> LimitCycle | None:
        """Return the limit cycle, counted on the switching function; None without one.

        Parameters
        ----------
        start : float, optional
            From when it is looked for; by default over the second half of the last hold [s].

        Returns
        -------
        LimitCycle or None
            Its extremes are those of the switching function, in the controller's own unit;
            of the valve voltage for a replayed command.

        Raises
        ------
        InputError
            When it is looked for from after the run's end.
        """
        signal = self["valve_voltage"] if self.surface is None else self.surface
        first = (self._last_change() + len(self)) // 2
        if start is not None:
            first = int(np.searchsorted(self.time, start))
            if first >= len(self) - 1:
                raise InputError(
                    f"a limit cycle is looked for from {start:g} s; the run ends at "
                    f"{self.time[-1]:g} s"
                )
        return limit_cycle(self.time[first:], signal[first:])

    def plot(self, ax: "Axes", *channels: str) -> "Axes":
        """Draw channels of one unit onto axes.

        Parameters
        ----------
        ax : matplotlib.axes.Axes
            Where to draw.
        *channels : str
            Names of channels; by default demand and displacement.

        Returns
        -------
        matplotlib.axes.Axes
            The same axes.
        """
        from pneuservo.simulation.plots import draw_channels

        return draw_channels(self, ax, channels)

    def figure(self) -> "Figure":
        """Return a figure of the whole run: displacement, pressures and command over time."""
        from pneuservo.simulation.plots import overview

        return overview(self)

    def phase_plane(self) -> "Figure":
        """Return a figure of the phase plane with sliding surface and boundary layer.

        Raises
        ------
        InputError
            When the controller has no sliding surface.
        """
        from pneuservo.simulation.phase_plane import phase_figure

        return phase_figure(self)

    def _require(self, channel: str) -> None:
        if channel not in self.channels:
            raise InputError(
                f"the run has no channel {channel!r}; it has: {', '.join(self.channels)}"
            )

    def _last_change(self) -> int:
        if "demand" not in self.channels:
            return 0
        changes = np.flatnonzero(np.diff(self["demand"]) != 0.0)
        return int(changes[-1]) + 1 if len(changes) else 0


def _stated(kind: str) -> dict[str, str]:
    """Return what a sidecar says of a controller; nothing where it has no word for it."""
    if kind == "discrete-sliding-mode":
        return {"kind": "digital"}
    # A digital sliding mode is a digital controller.
    return next(
        (
            {"kind": k}
            for k in CONTROLLER_KINDS
            if kind in (k, f"{k}-sliding-mode", f"{k}-state-feedback")
        ),
        {},
    )
