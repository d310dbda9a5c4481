"""The recording itself: a time base, named channels in SI, and how they were taken."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.naming import require_known
from pneuservo.recordings.channels import CHANNELS


@dataclass(frozen=True)
class Recording:
    """One table of samples in SI units and absolute pressures.

    Parameters
    ----------
    name : str
        Short name, for messages and legends.
    time : (n,) array
        Time of each sample, strictly increasing [s].
    channels : mapping of str to (n,) array
        Canonical channel name to samples in its SI unit (see `CHANNELS`);
        NaN where a sample is missing.
    rig : str
        Name of a built-in rig, or the path of a rig file.
    conditions : mapping of str to float, optional
        Rig parameters that were measured for this run, in SI.
    noise_rms : mapping of str to float, optional
        Noise of a channel where it is known, in the channel's unit.
    controller, card : mapping, optional
        The sidecar's tables of these names, in SI; empty when absent.
    title, taken, notes : str, optional
        Free text of the sidecar.
    warnings : tuple of str, optional
        What was found and worked around when the file was read.
    source : Path, optional
        The file it was read from.
    """

    name: str
    time: Array
    channels: Mapping[str, Array]
    rig: str = "single-axis"
    conditions: Mapping[str, float] = field(default_factory=dict)
    noise_rms: Mapping[str, float] = field(default_factory=dict)
    controller: Mapping[str, Any] = field(default_factory=dict)
    card: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""
    taken: str = ""
    notes: str = ""
    warnings: tuple[str, ...] = ()
    source: Path | None = None

    def __post_init__(self) -> None:
        # A kernel is compiled anew, for up to a minute, for samples that lie in memory in another
        # way: those of a file cannot be written to, every second one is a view.
        object.__setattr__(self, "time", _in_one_way(self.time))
        channels = {name: _in_one_way(samples) for name, samples in self.channels.items()}
        object.__setattr__(self, "channels", channels)

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time)

    def __contains__(self, channel: str) -> bool:
        """Return whether a channel was recorded."""
        return channel in self.channels

    def __getitem__(self, channel: str) -> Array:
        """Return the samples of a channel."""
        return self.channels[channel]

    @property
    def files(self) -> list[Path]:
        """Return the files that it was read from and those that it refers to."""
        own = [] if self.source is None else [self.source, self.source.with_suffix(".toml")]
        referred = (self.rig, str(self.card.get("design", "")))
        return [*own, *(Path(name) for name in referred if name.endswith(".toml"))]

    @property
    def sampling_interval(self) -> float:
        """Return the median time step [s]."""
        return float(np.median(np.diff(self.time)))

    def slice(self, start: float | None = None, stop: float | None = None) -> "Recording":
        """Return a part of the recording; its time still counts from the original start.

        Parameters
        ----------
        start : float, optional
            First time wanted [s]; from the first sample by default.
        stop : float, optional
            First time not wanted any more [s]; to the last sample by default.

        Returns
        -------
        Recording
            The samples with start <= time < stop, and everything else as it was.

        Raises
        ------
        InputError
            When no sample lies in between.

        Examples
        --------
        >>> import numpy as np
        >>> time = np.arange(5.0)
        >>> Recording("ramp", time, {"displacement": time / 10}).slice(1.0, 3.0).time
        array([1., 2.])
        """
        keep = np.ones(len(self.time), dtype=bool)
        if start is not None:
            keep &= self.time >= start
        if stop is not None:
            keep &= self.time < stop
        if not keep.any():
            raise InputError(
                f"{self.name}: no sample lies from {start} s to {stop} s; "
                f"the recording goes from {self.time[0]:g} s to {self.time[-1]:g} s"
            )
        channels = {name: values[keep] for name, values in self.channels.items()}
        return replace(self, time=self.time[keep], channels=channels)

    def from_its_start(self) -> "Recording":
        """Return the recording with time counted from its first sample.

        Returns
        -------
        Recording
            With a warning that says so; the same recording where time begins at 0.

        Examples
        --------
        >>> import numpy as np
        >>> cut = Recording("ramp", np.arange(5.0), {}).slice(3.0)
        >>> cut.from_its_start().time, cut.from_its_start().warnings
        (array([0., 1.]), ('time counts from the first sample that is used, at 3 s',))
        """
        first = float(self.time[0])
        if first == 0.0:
            return self
        warning = f"time counts from the first sample that is used, at {first:g} s"
        return replace(self, time=self.time - first, warnings=(*self.warnings, warning))

    def plot(self, channel: str, ax: Any = None) -> Any:
        """Draw a channel over time.

        Parameters
        ----------
        channel : str
            Canonical name of a recorded channel.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn onto.

        Raises
        ------
        InputError
            When the channel was not recorded.
        """
        require_known(channel, self.channels, f"{self.name}: channel")
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots()
        unit = CHANNELS[channel].unit.replace("**2", "²") or "1"
        ax.plot(self.time, self.channels[channel], linewidth=1.0, label=self.name)
        ax.set_xlabel("time [s]")
        ax.set_ylabel(f"{channel.replace('_', ' ')} [{unit}]")
        return ax


def _in_one_way(samples: ArrayLike) -> Array:
    """Return samples as most arrays are: one after the other, and to be written to."""
    return np.require(samples, np.float64, ("C_CONTIGUOUS", "WRITEABLE"))
