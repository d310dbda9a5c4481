"""Into how many steps each sampling interval is divided where the chambers are carried on."""

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.model import Array
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.servo.supply_effects import has_reservoir

Steps = NDArray[np.int64]

# With these, innovations of sixteen recordings differ from those with steps of 25 us by a sum of
# squares of less than 10 in each channel, or 16 of a chattering relay with a pressure missing. They
# follow the recording and the baseline alone: steps that followed the fitted motion would make
# innovations jump by as much when a parameter is moved a little.
LONGEST = 1e-3
_JUMP = 0.05
"""What a command that jumps moves by in one interval, as a share of the full voltage [-] ..."""
_ARRIVED = 5e-3
"""... and after how long the spool has followed it [s]."""
_STIFFEST = 0.3
"""Share of a pressure's deviation that may decay in one step."""
FINEST = 250e-6
"""No finer step is made for the baseline's sake, and none coarser beside what has states or a
memory of its own."""
LONGEST_OF_STIFF_EFFECTS = 100e-6
"""A small volume at the valve's end of a hose, a joint and a cushion are stiff."""


def dividing(time: Array, longest: float) -> Steps:
    """Return the number of equal steps no longer than something, in each interval.

    Parameters
    ----------
    time : (n,) array
        Of the samples [s].
    longest : float
        [s].

    Returns
    -------
    (n,) array of int
        The last one is that of no interval.

    Examples
    --------
    >>> dividing(np.array([0.0, 1e-3, 3e-3]), 250e-6).tolist()
    [4, 8, 8]
    """
    interval = np.diff(time)
    steps = np.ceil(np.append(interval, interval[-1:]) / longest - 1e-9)
    return np.maximum(steps, 1).astype(np.int64)


def steps_along(time: Array, voltage: Array, full_voltage: float, decays: Array) -> Steps:
    """Return the number of steps of each interval of a recording.

    Parameters
    ----------
    time, voltage : (n,) array
        [s], [V].
    full_voltage : float
        Command that opens the valve fully [V].
    decays : (n,) array
        Share of a pressure's deviation that decays in each interval, of the chamber in which it
        is larger [-].

    Examples
    --------
    >>> time = np.arange(12) * 1e-3
    >>> steps_along(time, np.where(time < 2e-3, 0.0, 5.0), 10.0, np.zeros(12)).tolist()
    [1, 4, 4, 4, 4, 4, 4, 1, 1, 1, 1, 1]
    """
    from scipy.ndimage import maximum_filter1d

    interval = float(np.median(np.diff(time)))
    jumps = np.abs(np.diff(voltage, append=voltage[-1])) > _JUMP * full_voltage
    followed = round(_ARRIVED / interval)
    # The window ends at each interval and looks back.
    beside = maximum_filter1d(jumps, followed + 1, mode="constant", origin=followed // 2)
    steps = np.where(beside, dividing(time, FINEST), dividing(time, LONGEST))
    steps = np.maximum(steps, np.ceil(decays / _STIFFEST).astype(np.int64))
    return np.minimum(steps, dividing(time, FINEST))


def steps_beside(steps: Steps, time: Array, effects: ServoEffects) -> Steps:
    """Return the number of steps that effects need.

    Parameters
    ----------
    steps : (n,) array of int
        What the recording needs.
    time : (n,) array
        [s].
    effects : ServoEffects
        The effects.
    """
    line, load, valve = effects.line, effects.load, effects.valve
    if line.frequency or load.joint_share or effects.stop.cushion_length:
        return dividing(time, LONGEST_OF_STIFF_EFFECTS)
    # Gas and walls have states too, but warm up slowly.
    swift = has_reservoir(effects.supply) or load.mode_share or effects.sensor.displacement_lag
    swift = swift or effects.spool.flow_force
    remembered = line.delay or valve.attached_loss or valve.exhaust_area or effects.friction.lag
    return dividing(time, FINEST) if swift or remembered else steps
