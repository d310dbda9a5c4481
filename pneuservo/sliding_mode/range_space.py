"""The range space: which velocities and accelerations a servo can have at all."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.errors import InputError
from pneuservo.linear.servo_data import ServoData
from pneuservo.rigs import Rig
from pneuservo.simulation import InitialState, Simulation, simulate

Limits = tuple[float, float]


@dataclass(frozen=True)
class RangeSpace:
    """A box of errors, velocities and accelerations.

    Attributes
    ----------
    displacement, velocity, acceleration : (float, float)
        Lowest and highest [m], [m/s], [m/s2].
    """

    displacement: Limits
    velocity: Limits
    acceleration: Limits


@dataclass(frozen=True)
class LinearLimits:
    """The largest amplitudes of the linear model under a sinusoidal voltage.

    Attributes
    ----------
    velocity, acceleration : float
        [m/s], [m/s2].
    jerk_peak, jerk_high : float
        At resonance, and towards infinite frequency [m/s3].
    """

    velocity: float
    acceleration: float
    jerk_peak: float
    jerk_high: float

    def range_space(self, stroke: float) -> RangeSpace:
        """Return the symmetric box with errors up to the stroke.

        Parameters
        ----------
        stroke : float
            [m].
        """
        v, a = self.velocity, self.acceleration
        return RangeSpace((-stroke, stroke), (-v, v), (-a, a))


def linear_limits(servo: LinearServo, level: float) -> LinearLimits:
    """Return the peaks of the frequency responses of velocity, acceleration and jerk.

    Parameters
    ----------
    servo : LinearServo
        The servo; the dynamics of its valve are not taken in.
    level : float
        Amplitude of the voltage [V].

    Raises
    ------
    InputError
        When there is no viscous friction.

    Notes
    -----
    Equation (7.12) of the thesis. Of s G, s2 G and s3 G with damping d and wn = sqrt(a1): the peaks
    are b0/(2 d sqrt(1 - d^2)) over wn^2, b0/a2, and b0/(2 d sqrt(1 - d^2)); above d = 1/sqrt(2)
    velocity and jerk have none, and are largest at zero and infinite frequency.

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2
    >>> limits = linear_limits(conventional_servo(table_5_2()), 5.0)
    >>> round(limits.velocity, 2), round(limits.acceleration, 1)
    (0.75, 96.4)
    """
    if servo.a2 <= 0.0:
        raise InputError(
            "the servo has no viscous friction: its linear model swings without limit. Give "
            "piston.viscous_friction of the rig, or another range space"
        )
    thrust = servo.b0 * level
    damping = servo.a2 / (2 * math.sqrt(servo.a1))
    resonance = 1.0
    if damping < math.sqrt(0.5):
        resonance = 1 / (2 * damping * math.sqrt(1 - damping**2))
    return LinearLimits(
        velocity=resonance * thrust / servo.a1,
        acceleration=thrust / servo.a2,
        jerk_peak=resonance * thrust,
        jerk_high=thrust,
    )


def physical_limits(data: ServoData) -> RangeSpace:
    """Return what choked exhaust and the supply pressure leave of velocity and acceleration.

    Parameters
    ----------
    data : ServoData
        The servo.

    Returns
    -------
    RangeSpace
        Steady velocities at full opening, (5.35) and (5.39), and the accelerations with one
        chamber at the supply and the other at the exhaust pressure.

    Notes
    -----
    An outer bound: the thesis' own (7.13), -67 to 82 m/s2, cannot be derived from its words.

    Examples
    --------
    >>> from pneuservo.linear import table_5_2
    >>> [round(v, 3) for v in physical_limits(table_5_2()).velocity]
    [-0.229, 0.273]
    """
    gas = data.gas
    flow = gas.choked_coefficient * gas.gas_constant * math.sqrt(gas.temperature)
    velocity = (
        -flow * data.flow_areas.a_to_exhaust / data.area_a,
        flow * data.flow_areas.b_to_exhaust / data.area_b,
    )
    over = data.supply_pressure - data.exhaust_pressure
    acceleration = (
        (-over * data.area_b + data.load) / data.mass,
        (over * data.area_a + data.load) / data.mass,
    )
    return RangeSpace((-data.stroke, data.stroke), velocity, acceleration)


def trajectory_limits(runs: Sequence[Simulation], stroke: float) -> RangeSpace:
    """Return the box round representative motions.

    Parameters
    ----------
    runs : sequence of Simulation
        The motions, such as those of `representative_runs`.
    stroke : float
        [m].
    """
    velocity, acceleration = (
        np.concatenate([run[name] for run in runs]) for name in ("velocity", "acceleration")
    )
    return RangeSpace(
        (-stroke, stroke),
        (float(velocity.min()), float(velocity.max())),
        (float(acceleration.min()), float(acceleration.max())),
    )


def representative_runs(
    rig: Rig, voltage: float | None = None, duration: float = 0.25, rate: float = 2000.0
) -> list[Simulation]:
    """Return open-loop motions of the non-linear plant from rest, up to the end stop.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    voltage : float, optional
        By default what opens the valve fully [V].
    duration : float, optional
        Of each, if the piston does not arrive earlier [s].
    rate : float, optional
        Samples per second [Hz].

    Returns
    -------
    list of Simulation
        From either end to the other, and from mid-stroke both ways.

    Notes
    -----
    Section 7.5.2 of the thesis: a positioning servo starts at rest.
    """
    stroke = rig["piston.stroke"]
    full = rig["valve.full_voltage"] if voltage is None else voltage
    time = np.arange(0.0, duration, 1.0 / rate)
    starts = ((0.0, full), (0.5 * stroke, full), (stroke, -full), (0.5 * stroke, -full))
    return [
        _until_the_stop(
            simulate(rig, time=time, command=command, initial=InitialState(displacement=start)),
            stroke if command > 0.0 else 0.0,
        )
        for start, command in starts
    ]


def _until_the_stop(run: Simulation, stop: float) -> Simulation:
    reached = np.flatnonzero(run["displacement"] == stop)
    end = int(reached[0]) if len(reached) else len(run)
    channels = {name: samples[:end] for name, samples in run.channels.items()}
    return Simulation(run.rig, run.time[:end], channels)
