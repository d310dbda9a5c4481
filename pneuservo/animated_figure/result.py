"""The run of an animated figure, and what is read off it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pneuservo.animated_figure.figure import FRAME, AnimatedFigure
from pneuservo.arrays import Array
from pneuservo.simulation import Simulation

# After this a loop has settled by itself, and what then moves it comes from elsewhere: of a step of
# 7.5 mm state feedback, the slowest, leaves up to 2.8 mm after half of it and 0.08 mm then [s].
_QUIET_AFTER = 1.0


@dataclass(frozen=True)
class Ripple:
    """What the motion of the other axes does to one that should stand still.

    Parameters
    ----------
    peak_to_peak : float
        Of its displacement [m].
    rms : float
        About its mean [m].
    """

    peak_to_peak: float
    rms: float


@dataclass(frozen=True)
class FigureRun:
    """One simulated run of a figure.

    Parameters
    ----------
    figure : AnimatedFigure
        The figure, with every value used.
    time : (n,) array
        [s].
    axes : mapping of str to Simulation
        By axis, each a run of its own; its channel ``force`` is what the member and all that
        hangs on it push against the rod.
    frame_displacement, frame_velocity, frame_acceleration : (n,) array
        Of the sway, positive where members at positive angles lean to [m], [m/s], [m/s^2].
    """

    figure: AnimatedFigure
    time: Array
    axes: Mapping[str, Simulation]
    frame_displacement: Array
    frame_velocity: Array
    frame_acceleration: Array

    def frame_vibration(self, start: float = 0.0) -> float:
        """Return the root mean square acceleration of the frame [m/s^2].

        Parameters
        ----------
        start : float, optional
            From when on [s].
        """
        return float(np.sqrt(np.mean(self.frame_acceleration[self.time >= start] ** 2)))

    def angles(self) -> Array:
        """Return the angles of the members from the upright.

        Returns
        -------
        (n, axes) array
            [rad].
        """
        coupling = self.figure.coupling
        rods = np.column_stack([run["displacement"] for run in self.axes.values()])
        joints = (rods - coupling.middles) / coupling.levers
        turned: Array = coupling.linkage.rest_angles + joints @ coupling.linkage.paths.T
        return turned

    def joints(self) -> Array:
        """Return where the joints and the ends of the members are, seen from the front.

        Returns
        -------
        (n, axes, 2, 2) array
            By time and axis the joint of a member and its end, across and upwards from where the
            frame is at rest [m].
        """
        turned, axes = self.angles(), self.figure.axes
        places = np.zeros((len(self.time), len(axes), 2, 2))
        ends = {FRAME: np.column_stack((self.frame_displacement, np.zeros(len(self.time))))}
        for k, (name, axis) in enumerate(axes.items()):
            along = np.column_stack((np.sin(turned[:, k]), np.cos(turned[:, k])))
            places[:, k, 0] = ends[axis.carrier]
            places[:, k, 1] = ends[name] = ends[axis.carrier] + axis.length * along
        return places

    def ripple(self, name: str, quiet_after: float = _QUIET_AFTER) -> Ripple | None:
        """Return what the other axes do to one while its own demand stands still.

        Parameters
        ----------
        name : str
            Of the axis.
        quiet_after : float, optional
            How long its own last step is given to settle; what is left of it then counts as moved
            by others, as does a limit cycle of its own. Give more to a slower loop [s].

        Returns
        -------
        Ripple or None
            The largest of all its holds; None when no other axis is moved during one, or each
            ends before its own step has settled.
        """
        run = self.axes[name]
        changes = np.flatnonzero(np.diff(run["demand"]) != 0.0) + 1
        others = np.zeros(len(self.time), dtype=bool)
        for other, each in self.axes.items():
            if other != name:
                others[1:] |= np.diff(each["demand"]) != 0.0
        found: Ripple | None = None
        for start, end in zip([0, *changes], [*changes, len(self.time)], strict=True):
            first = int(np.searchsorted(self.time, self.time[start] + quiet_after * bool(start)))
            if not others[first:end].any():
                continue
            part = run["displacement"][first:end]
            ripple = Ripple(
                float(np.ptp(part)),
                float(np.std(part)),
            )
            if found is None or ripple.peak_to_peak > found.peak_to_peak:
                found = ripple
        return found
