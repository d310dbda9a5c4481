"""The recording itself: a time base, named channels in SI, and how they were taken."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


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
    time: NDArray[np.float64]
    channels: Mapping[str, NDArray[np.float64]]
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

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time)

    def __contains__(self, channel: str) -> bool:
        """Return whether a channel was recorded."""
        return channel in self.channels

    def __getitem__(self, channel: str) -> NDArray[np.float64]:
        """Return the samples of a channel."""
        return self.channels[channel]
