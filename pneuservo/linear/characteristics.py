"""Natural frequency, damping and ultimate gain, over the stroke and both directions."""

import math
from dataclasses import dataclass

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.linear.models import advanced_servo, transfer_function
from pneuservo.linear.servo_data import ServoData


def natural_frequency(servo: LinearServo) -> float:
    """Return the natural frequency of piston and gas, sqrt(a1) [rad/s].

    Parameters
    ----------
    servo : LinearServo
        The servo.

    Notes
    -----
    Equations (5.28) and (5.42) of the thesis.

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2
    >>> round(natural_frequency(conventional_servo(table_5_2())) / (2 * math.pi), 2)  # Hz
    20.9
    """
    return math.sqrt(servo.a1)


def damping_ratio(servo: LinearServo) -> float:
    """Return the damping ratio of piston and gas, a2/(2 sqrt(a1)) [-].

    Parameters
    ----------
    servo : LinearServo
        The servo.

    Notes
    -----
    Equations (5.28) and (5.43) of the thesis.
    """
    return servo.a2 / (2 * natural_frequency(servo))


def ultimate_gain(servo: LinearServo) -> float:
    """Return the proportional gain at the border of stability [V/m].

    Parameters
    ----------
    servo : LinearServo
        The servo. Without the dynamics of the valve the gain is a1 a2/b0, with them the gain
        margin of the loop.

    Notes
    -----
    Equations (5.29), (5.44) and (5.45) of the thesis, by Routh and Hurwitz; divide by the
    transducer's V/m for volts over volts.

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2, without_valve
    >>> servo = without_valve(conventional_servo(table_5_2()))
    >>> round(ultimate_gain(servo))
    894
    """
    if not math.isfinite(servo.valve_frequency):
        return servo.a1 * servo.a2 / servo.b0
    import control

    return float(control.margin(transfer_function(servo))[0])


@dataclass(frozen=True)
class OverStroke:
    """What the linear model amounts to over the stroke.

    Attributes
    ----------
    displacement : (n,) array
        [m].
    natural_frequency : (n,) array
        [rad/s].
    damping_ratio : (n,) array
        [-].
    gain_extending, gain_retracting : (n,) array
        Ultimate gain [V/m].
    """

    displacement: Array
    natural_frequency: Array
    damping_ratio: Array
    gain_extending: Array
    gain_retracting: Array


def over_stroke(data: ServoData, displacement: Array | None = None) -> OverStroke:
    """Return natural frequency, damping and ultimate gain over the stroke and both directions.

    Parameters
    ----------
    data : ServoData
        The servo.
    displacement : (n,) array, optional
        Where; by default 61 positions from end to end [m].

    Notes
    -----
    Figures 5.9 and 5.10 of the thesis. Without the dynamics of the valve.
    """
    if displacement is None:
        displacement = np.linspace(0.0, data.stroke, 61)
    rows = []
    for position in displacement:
        out, back = (advanced_servo(data, float(position), way) for way in (True, False))
        rows.append(
            (
                natural_frequency(out),
                damping_ratio(out),
                out.a1 * out.a2 / out.b0,
                back.a1 * back.a2 / back.b0,
            )
        )
    return OverStroke(np.asarray(displacement, float), *np.array(rows).T)


@dataclass(frozen=True)
class Linearisation:
    """A linear model and where it holds.

    Attributes
    ----------
    servo : LinearServo
        The model.
    displacement : float
        Piston position [m].
    extending : bool
        Direction of the valve's opening.
    ultimate_gain : float
        Without the dynamics of the valve [V/m].
    """

    servo: LinearServo
    displacement: float
    extending: bool
    ultimate_gain: float


def worst_linearisation(data: ServoData, positions: int = 61) -> Linearisation:
    """Return the linearisation with the lowest ultimate gain, on which to base a controller.

    Parameters
    ----------
    data : ServoData
        The servo at its quiescent pressures.
    positions : int, optional
        How many are looked at, from end to end.

    Raises
    ------
    InputError
        When the servo has no friction that grows with velocity: any gain is then too high.

    Notes
    -----
    The guideline of section 5.3.4 of the thesis: quiescent pressures, parameters over the stroke
    and both directions, then the condition with the lowest gain at the border of stability. The
    response of the servo itself is more damped than that of this model.

    Examples
    --------
    >>> from pneuservo.linear import table_5_2
    >>> worst = worst_linearisation(table_5_2())
    >>> worst.extending, worst.displacement
    (True, 0.0)
    """
    if data.viscous_friction <= 0.0:
        raise InputError(
            "the viscous friction is 0; the linear model is then unstable with any gain. Give "
            "piston.viscous_friction of the rig"
        )
    table = over_stroke(data, np.linspace(0.0, data.stroke, positions))
    extending = bool(table.gain_extending.min() <= table.gain_retracting.min())
    gains = table.gain_extending if extending else table.gain_retracting
    k = int(np.argmin(gains))
    at = float(table.displacement[k])
    return Linearisation(advanced_servo(data, at, extending), at, extending, float(gains[k]))
