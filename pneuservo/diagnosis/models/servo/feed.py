"""A recording of the servo as its observer is fed with it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.recent import Recent
from pneuservo.diagnosis.models.servo.breakaway import Departures
from pneuservo.diagnosis.models.servo.noisy_command import bends_of
from pneuservo.diagnosis.models.servo.rests import averaged_samples
from pneuservo.diagnosis.models.servo.spread import MOTION_MEMORY
from pneuservo.diagnosis.models.servo.stops import AVERAGED_AT_REST, moments_of_rest
from pneuservo.noise import LIKELY_WANDER

PRESSURES = ("pressure_a", "pressure_b")
SUPPLY = "supply_pressure"
AT_REST = "friction at rest"
"""What is judged beside the channels while friction holds the piston."""
FOLLOWED = (*PRESSURES, "displacement")
"""Channels that the observer follows, in its order."""
CHANNELS = (*FOLLOWED, SUPPLY, "spool")
"""Judged channels."""


@dataclass(frozen=True)
class Feed:
    """What the observer of the servo takes from a recording.

    Parameters
    ----------
    time, voltage : (n,) array
        [s], [V].
    command : (n, m + 1) array
        The voltage between its samples, see `pneuservo.diagnosis.models.servo.command` [V].
    unseen : (n,) array
        By how much the mean of that may be off in each interval [V].
    blind : (n,) array of bool
        While something is missing that the servo is followed by, and until that is forgotten.
    set_point : (n,) array
        Of the loop; empty where it was not recorded [m].
    gain_of_set_point : float
        What a linear loop adds to the command per metre of it; 0 where it does not tell [V/m].
    in_steps : bool
        Whether the set point stays as it is from sample to sample.
    converted : bool
        Whether a computer puts the command out a little after the sample that it is made of.
    of_noise : bool
        Whether what the command does from sample to sample is noise that its loop hears.
    jumps : (n - 1,) array of bool
        Intervals at whose end the command jumps, and until when it stays as it is; empty where it
        is not taken to.
    heard : (n,) array
        What noise of the displacement that a loop hears for an interval adds to the command of
        that; empty where it is not taken to [V].
    reading : (n,) array
        Displacement as measured; NaN where there is none [m].
    motion : (3, n) array
        Smoothed displacement, velocity and acceleration, SI.
    pressures : (2, n) array
        Pressures as measured, gaps closed, or as estimated [Pa].
    measured : (2,) tuple of bool
        Which of them were measured ...
    read : (2, n) array of bool
        ... and at which samples.
    pressure_rates : (2, n) array
        Their smoothed rates [Pa/s].
    supply : (n,) array or None
        Measured supply pressure, smoothed [Pa].
    supply_reading : (n,) array
        The same as measured; empty where it was not [Pa].
    spool_reading : (n,) array
        Spool position as measured; empty where it was not [-].
    force : (n,) array
        At the rod [N].
    force_rms : float
        Its noise; 0 where it was not measured [N].
    held : (n,) array of bool
        While the piston sticks or lies at a stop.
    reversal : float
        How well the velocity of a moving piston is known: friction turns round over this [m/s].
    velocity_rms : (n,) array
        How well the smoothed velocity is known; 0 where the piston is known not to move [m/s].
    touching, striking : (n,) array of bool
        While the piston may touch a stop, and while it moves there.
    resting : (n,) array of int
        At which stop it rests: -1 the retracted, 1 the extended, 0 none.
    stuck : (n,) array of bool
        While nothing but friction holds the piston ...
    departures : Departures
        ... and when it has left such a place.
    spread : (2, n) array
        Variance that each interval adds to what is known of each pressure [Pa^2].
    noise : mapping of str to float
        Noise of each judged channel [SI].
    spread_of_force : float
        What the noise of both pressures, and of the force at the rod, makes of the force on the
        piston [N].
    chatter : float
        Share of the time in which the piston chatters by less than its displacement tells [-].
    motion_memory : float
        How long a velocity that is taken over is off by `velocity_rms` [s].
    unsteadiness, turning_unsteadiness : float
        Unmodelled force that the observer allows for, and where the piston turns round, see
        `pneuservo.diagnosis.models.servo.covariance.carry_on` [-].
    gains : (n, GAIN_ROWS, 3) array
        What each error of expectation corrects, in the observer.
    shares : (n, 3) array
        Noise of each reading over the spread of its innovation.
    spool_shares : (n,) array
        The same of the spool's readings; empty where there are none.
    force_spread : (n,) array
        How well the observer tells the force on the piston [N].
    steps : (n,) array of int
        Into how many steps each interval is divided, see `pneuservo.diagnosis.models.servo.steps`.
    """

    time: Array
    voltage: Array
    command: Array
    unseen: Array
    blind: Mask
    set_point: Array
    gain_of_set_point: float
    reading: Array
    motion: Array
    pressures: Array
    measured: tuple[bool, ...]
    read: Mask
    pressure_rates: Array
    supply: Array | None
    supply_reading: Array
    spool_reading: Array
    force: Array
    force_rms: float
    held: Mask
    reversal: float
    velocity_rms: Array
    touching: Mask
    striking: Mask
    resting: NDArray[np.int64]
    stuck: Mask
    departures: Departures
    spread: Array
    noise: dict[str, float]
    spread_of_force: float
    chatter: float = 0.0
    motion_memory: float = MOTION_MEMORY
    unsteadiness: float = 1.0
    turning_unsteadiness: float = 1.0
    in_steps: bool = False
    converted: bool = False
    of_noise: bool = False
    jumps: Mask = field(default_factory=lambda: np.empty(0, np.bool_), repr=False)
    heard: Array = field(default_factory=lambda: np.empty(0), repr=False)
    gains: Array = field(default_factory=lambda: np.empty(0), repr=False)
    shares: Array = field(default_factory=lambda: np.empty(0), repr=False)
    spool_shares: Array = field(default_factory=lambda: np.empty(0), repr=False)
    force_spread: Array = field(default_factory=lambda: np.empty(0), repr=False)
    steps: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64), repr=False)

    @property
    def ramped(self) -> bool:
        """Return whether the command runs on between samples instead of being held."""
        return bool(np.any(self.command[:, 0] != self.command[:, -1]))

    @cached_property
    def bends(self) -> Array:
        """Return what the command may do between samples if it runs on and is its loop's noise."""
        if self.of_noise and self.ramped:
            return bends_of(self.voltage, self.command.shape[1] - 1)
        return np.empty(0)

    @cached_property
    def done(self) -> Recent:
        """Return the results of the last few runs, one for all channels."""
        return Recent()

    @cached_property
    def spools(self) -> Recent:
        """Return the last few ways in which a spool moves through the command."""
        return Recent(kept=4)

    @cached_property
    def interval(self) -> float:
        """Return the time between two samples [s]."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def force_rms_at_rest(self) -> float:
        """Return how well averages of what was measured tell the force on a piston at rest [N]."""
        samples = averaged_samples(self.interval, AVERAGED_AT_REST)
        return self.spread_of_force * math.sqrt(1.0 / samples + LIKELY_WANDER**2)

    @cached_property
    def moments_of_rest(self) -> Array:
        """Return at how many moments the rest is judged that each sample is part of.

        That at which the piston breaks away is judged for itself.
        """
        found = moments_of_rest(self.stuck, self.interval)
        found[self.breaks_away] = 1.0
        return found

    @cached_property
    def breaks_away(self) -> NDArray[np.int_]:
        """Return the samples at which the force is judged at which a piston breaks away."""
        return self.departures.at.astype(int)

    def noise_of(self, channels: Sequence[str]) -> Array:
        """Return the noise of some channels, one of those that were not recorded [SI]."""
        return np.array([self.noise.get(name, 1.0) for name in channels])
