"""A recording of the servo as its observer is fed with it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.recent import Recent
from pneuservo.diagnosis.models.servo.command import running_command, unseen
from pneuservo.diagnosis.models.servo.motion import smooth_motion
from pneuservo.diagnosis.models.servo.rests import averaged_samples, chatters
from pneuservo.diagnosis.models.servo.set_point import at_once, gain_of_set_point
from pneuservo.diagnosis.models.servo.spread import (
    MOTION_MEMORY,
    shares_of_spool,
    spread_of_pressures,
)
from pneuservo.diagnosis.models.servo.stops import (
    AVERAGED_AT_REST,
    around,
    moments_of_rest,
    resting,
    touching,
)
from pneuservo.diagnosis.noise import LIKELY_WANDER, noise_floor
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

Array = NDArray[np.float64]

PRESSURES = ("pressure_a", "pressure_b")
SUPPLY = "supply_pressure"
AT_REST = "friction at rest"
"""What is judged beside the channels while friction holds the piston."""
FOLLOWED = (*PRESSURES, "displacement")
"""Channels that the observer follows, in its order."""
CHANNELS = (*FOLLOWED, SUPPLY, "spool")
"""Judged channels."""
STICKING = 3.0
"""A piston whose velocity is not this many times its uncertainty ..."""
HELD_FOR = 8e-3
"""... for this long counts as held [s]."""
NEVER_MOVES = 1.5
"""A piston never moves whose displacement spreads by less than this many times its noise."""
CREEPING = 3e-4
"""A piston that creeps faster than this slides [m/s]."""
SLOWEST_MOTION = 5e-4
"""The velocity of a moving piston is never taken to be known better than this [m/s]."""
FINEST = 1e-4
"""No transducer is taken to be better than this, as a share of stroke, supply pressure and full
opening, unless its noise is stated: in recordings without any noise, what is made of a command
between its samples and of a motion that is smoothed was explained by delays."""
PRESSURE_SMOOTHING = 3e-3
"""Time over which pressures are averaged where their rate is wanted [s]."""


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
    set_point : (n,) array
        Of the loop; empty where it was not recorded [m].
    gain_of_set_point : float
        What a linear loop adds to the command per metre of it; 0 where it does not tell [V/m].
    in_steps : bool
        Whether the set point stays as it is from sample to sample.
    reading : (n,) array
        Displacement as measured; NaN where there is none [m].
    motion : (3, n) array
        Smoothed displacement, velocity and acceleration, SI.
    pressures : (2, n) array
        Pressures as measured, gaps closed, or as estimated [Pa].
    measured : (2,) tuple of bool
        Which of them were measured.
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
        While nothing but friction holds the piston.
    spread : (2, n) array
        Variance that each interval adds to what is known of each pressure [Pa^2].
    noise : mapping of str to float
        Noise of each judged channel [SI].
    spread_of_force : float
        What the noise of both pressures makes of the force on the piston [N].
    chatter : float
        Share of the time in which the piston chatters by less than its displacement tells [-].
    motion_memory : float
        How long a velocity that is taken over is off by `velocity_rms` [s].
    unsteadiness : float
        Unmodelled force that the observer allows for, see
        `pneuservo.diagnosis.models.servo.covariance.carry_on` [-].
    gains : (n, GAIN_ROWS, 3) array
        What each error of expectation corrects, in the observer.
    shares : (n, 3) array
        Noise of each reading over the spread of its innovation.
    spool_shares : (n,) array
        The same of the spool's readings; empty where there are none.
    steps : (n,) array of int
        Into how many steps each interval is divided, see `pneuservo.diagnosis.models.servo.steps`.
    """

    time: Array
    voltage: Array
    command: Array
    unseen: Array
    set_point: Array
    gain_of_set_point: float
    reading: Array
    motion: Array
    pressures: Array
    measured: tuple[bool, ...]
    pressure_rates: Array
    supply: Array | None
    supply_reading: Array
    spool_reading: Array
    force: Array
    held: NDArray[np.bool_]
    reversal: float
    velocity_rms: Array
    touching: NDArray[np.bool_]
    striking: NDArray[np.bool_]
    resting: NDArray[np.int64]
    stuck: NDArray[np.bool_]
    spread: Array
    noise: dict[str, float]
    spread_of_force: float
    chatter: float = 0.0
    motion_memory: float = MOTION_MEMORY
    unsteadiness: float = 1.0
    in_steps: bool = False
    gains: Array = field(default_factory=lambda: np.empty(0), repr=False)
    shares: Array = field(default_factory=lambda: np.empty(0), repr=False)
    spool_shares: Array = field(default_factory=lambda: np.empty(0), repr=False)
    steps: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64), repr=False)

    @property
    def ramped(self) -> bool:
        """Return whether the command runs on between samples instead of being held."""
        return bool(np.any(self.command[:, 0] != self.command[:, -1]))

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
        """Return how well averages of both pressures tell the force on a piston at rest [N]."""
        samples = averaged_samples(self.interval, AVERAGED_AT_REST)
        return self.spread_of_force * math.sqrt(1.0 / samples + LIKELY_WANDER**2)

    @cached_property
    def moments_of_rest(self) -> Array:
        """Return at how many moments the rest is judged that each sample is part of."""
        return moments_of_rest(self.stuck, self.interval)

    def noise_of(self, channels: Sequence[str]) -> Array:
        """Return the noise of some channels, one of those that were not recorded [SI]."""
        return np.array([self.noise.get(name, 1.0) for name in channels])


def feed(recording: Recording, rig: Rig) -> Feed:
    """Return a recording as the observer of the servo is fed with it.

    Parameters
    ----------
    recording : Recording
        With valve voltage and displacement; pressures that it lacks are guessed roughly, see
        `pneuservo.diagnosis.models.servo.estimate`.
    rig : Rig
        The rig it was taken on.

    Returns
    -------
    Feed
        In SI.
    """
    time, interval = recording.time, recording.sampling_interval
    noise = {
        channel: recording.noise_rms.get(channel) or _noise(recording, channel, rig)
        for channel in CHANNELS
        if channel in recording
    }
    voltage = _closed(recording["valve_voltage"], time)
    set_point, gain, told = np.empty(0), 0.0, None
    if "demand" in recording:
        set_point = _closed(recording["demand"], time)
        gain = gain_of_set_point(time, voltage, set_point, _closed(recording["displacement"], time))
        told = at_once(voltage, set_point, gain)
    force = _closed(recording["force"], time) if "force" in recording else np.zeros_like(time)
    pressures = _pressures(recording, rig, float(force[0]))
    loads = [rig[f"piston.area_{name[-1]}"] * noise.get(name, 0.0) for name in PRESSURES]
    spread_of_force = math.hypot(*loads)
    fed = Feed(
        time=time,
        voltage=voltage,
        command=running_command(time, voltage, rig["valve.full_voltage"], told),
        unseen=unseen(voltage, told),
        set_point=set_point,
        gain_of_set_point=gain,
        reading=recording["displacement"],
        motion=np.zeros((3, len(time))),
        pressures=pressures,
        measured=tuple(name in recording for name in PRESSURES),
        pressure_rates=np.array([_rate(p, interval) for p in pressures]),
        supply=_supply(recording, interval),
        supply_reading=recording.channels.get(SUPPLY, np.empty(0)),
        spool_reading=recording.channels.get("spool", np.empty(0)),
        force=force,
        held=np.zeros(len(time), dtype=bool),
        reversal=SLOWEST_MOTION,
        velocity_rms=np.full_like(time, SLOWEST_MOTION),
        touching=np.zeros(len(time), dtype=bool),
        striking=np.zeros(len(time), dtype=bool),
        resting=np.zeros(len(time), dtype=np.int64),
        stuck=np.zeros(len(time), dtype=bool),
        spread=np.zeros((2, len(time))),
        noise=noise,
        spread_of_force=spread_of_force,
    )
    return moved_by(fed, rig, spread_of_force if all(fed.measured) else None)


def _noise(recording: Recording, channel: str, rig: Rig) -> float:
    """Return the noise of a channel of which nothing is stated [SI]."""
    largest = {"displacement": rig["piston.stroke"], "spool": 1.0}.get(
        channel, rig["supply.pressure"]
    )
    return max(noise_floor(recording[channel], recording.time), FINEST * largest)


def moved_by(fed: Feed, rig: Rig, force_rms: float | None) -> Feed:
    """Return a feed whose motion is smoothed with the help of its pressures.

    Parameters
    ----------
    fed : Feed
        Its motion, and what follows from it, is replaced.
    rig : Rig
        The rig it was taken on.
    force_rms : float or None
        How well the pressures tell the force on the piston; None where they do not [N].
    """
    mass = rig["load.mass"]
    driving = None
    if force_rms is not None:
        areas = rig["piston.area_a"], rig["piston.area_b"]
        gauge = fed.pressures - rig["ambient.pressure"]
        driving = (areas[0] * gauge[0] - areas[1] * gauge[1] - fed.force) / mass
        driving += rig["load.gravity"]
    *smoothed, velocity_rms, rest = smooth_motion(
        fed.time,
        fed.reading,
        fed.noise["displacement"],
        driving,
        (force_rms or 0.0) / mass,
        rig["piston.coulomb_friction"] / mass,
    )
    chatter = 0.0
    if driving is not None and force_rms is not None:
        known = force_rms / mass, rig["piston.coulomb_friction"] / mass
        chatter = float(np.mean(chatters(driving, *known, fed.noise["displacement"], fed.interval)))
    motion, moving = np.array(smoothed), velocity_rms if rest.all() else velocity_rms[~rest]
    reversal = max(float(np.median(moving)), SLOWEST_MOTION)
    velocity_rms = np.where(rest, velocity_rms, reversal)
    if np.nanstd(fed.reading) < NEVER_MOVES * fed.noise["displacement"]:
        # Of a piston that never moves only noise would be taken for motion.
        motion = np.array(
            [np.full_like(fed.time, np.mean(motion[0])), *np.zeros((2, len(fed.time)))]
        )
        velocity_rms = np.zeros_like(fed.time)
    interval = fed.interval
    stroke, slow = rig["piston.stroke"], STICKING * reversal
    near, still = touching(motion[0], interval, stroke), _held(motion[1], slow, interval)
    rests = np.zeros(len(fed.time), dtype=np.int64)
    if driving is not None and force_rms is not None:
        friction = rig["piston.coulomb_friction"] + force_rms
        rests = resting(motion[0], still, mass * driving, friction, interval, stroke)
    motion[1:, rests != 0] = 0.0
    stuck = _held(motion[1], CREEPING, interval) & rest & ~near & (rests == 0) & all(fed.measured)
    moved = replace(
        fed,
        motion=motion,
        held=still | near,
        reversal=reversal,
        velocity_rms=np.where(rests != 0, 0.0, velocity_rms),
        touching=near,
        striking=near & around(np.abs(motion[1]) > slow, interval),
        resting=rests,
        stuck=stuck,
        chatter=chatter,
    )
    return with_spread(moved, rig)


def _pressures(recording: Recording, rig: Rig, force: float) -> Array:
    """Return both pressures, a missing one as it would be with the piston at rest."""
    from pneuservo.plant.from_rig import single_axis
    from pneuservo.plant.single_axis import PRESSURE_A, PRESSURE_B
    from pneuservo.simulation.initial_state import InitialState

    time = recording.time
    known = {name: _closed(recording[name], time) for name in PRESSURES if name in recording}
    start = InitialState(**{name: float(values[0]) for name, values in known.items()})
    plant = single_axis(rig)
    state = start.state(plant, 0.5 * plant.piston.stroke, force)
    places = dict(zip(PRESSURES, (PRESSURE_A, PRESSURE_B), strict=True))
    return np.array([known.get(n, np.full_like(time, state[places[n]])) for n in PRESSURES])


def with_spread(fed: Feed, rig: Rig) -> Feed:
    """Return a feed that knows how sure pressures and spool are between and at its samples.

    Parameters
    ----------
    fed : Feed
        What that follows from has been changed.
    rig : Rig
        The rig it was taken on.
    """
    spread = spread_of_pressures(
        fed.time,
        fed.unseen,
        fed.striking,
        fed.held,
        fed.noise,
        fed.velocity_rms,
        fed.motion_memory,
        rig,
    )
    if not len(fed.spool_reading):
        return replace(fed, spread=spread)
    shares = shares_of_spool(fed.time, fed.unseen, fed.spool_reading, fed.noise["spool"], rig)
    return replace(fed, spread=spread, spool_shares=shares)


def _closed(samples: Array, time: Array) -> Array:
    good = np.isfinite(samples)
    return np.asarray(np.interp(time, time[good], samples[good]))


def _rate(samples: Array, interval: float) -> Array:
    from scipy.signal import savgol_filter

    window = max(5, 2 * round(PRESSURE_SMOOTHING / interval) + 1)
    return np.asarray(savgol_filter(samples, min(window, len(samples) | 1), 2, 1, interval))


def _supply(recording: Recording, interval: float) -> Array | None:
    from scipy.ndimage import uniform_filter1d

    if SUPPLY not in recording:
        return None
    width = max(1, round(PRESSURE_SMOOTHING / interval))
    closed = _closed(recording[SUPPLY], recording.time)
    return np.asarray(uniform_filter1d(closed, width, mode="nearest"))


def _held(velocity: Array, slow: float, interval: float) -> NDArray[np.bool_]:
    from scipy.ndimage import binary_opening

    width = max(2, round(HELD_FOR / interval))
    return np.asarray(binary_opening(np.abs(velocity) < slow, np.ones(width)))


def held_at_stops(fed: Feed, rig: Rig) -> Feed:
    """Return the feed of a piston that counts as held at the stops alone.

    Parameters
    ----------
    fed : Feed
        With what sticks held too.
    rig : Rig
        The rig it was taken on.
    """
    rests = np.where(fed.touching, fed.resting, 0)
    stuck = np.zeros_like(fed.stuck)
    freed = replace(fed, held=fed.touching, resting=rests, stuck=stuck)
    return with_spread(freed, rig)
