"""What a surface leaves of the voltage against disturbances and further parameter changes."""

from dataclasses import dataclass

from pneuservo.linear import ServoData, advanced_servo, without_valve
from pneuservo.sliding_mode.equivalent_control import servo_gains
from pneuservo.sliding_mode.reaching import reaching_phase, sliding_phase
from pneuservo.sliding_mode.surface import Surface


@dataclass(frozen=True)
class Reserve:
    """What is left of the voltage in sliding.

    Attributes
    ----------
    control : float
        Largest equivalent control, parameter changes included [V].
    reserve : float
        What is left of the level; negative when it does not suffice [V].
    acceleration : float
        Largest disturbance acceleration that the reserve takes up; 0 without a reserve [m/s2].
    """

    control: float
    reserve: float
    acceleration: float


def reserve(
    data: ServoData, surface: Surface, level: float, origin: float, target: float
) -> Reserve:
    """Return what is left of the voltage along the sliding motion of a step.

    Parameters
    ----------
    data : ServoData
        The servo. Its parameters are those where the piston is and in the direction in which the
        valve opens; up to the surface those of mid-stroke.
    surface : Surface
        Of order 2.
    level : float
        Largest voltage [V].
    origin, target : float
        Where the piston rests before, and the demand [m].

    Notes
    -----
    Equations (7.11) and (7.16), section 7.6 and figures 7.13 and 7.14 of the thesis: the reserve
    U - |u_nom + u_par| times c3 (b0 + change) over c2 is the acceleration that may disturb, with
    neither velocity nor jerk disturbed. The smallest along the motion.
    """
    _, c2, c3 = surface.weights
    nominal = without_valve(advanced_servo(data, 0.5 * data.stroke, target > origin))
    reached = reaching_phase(nominal, surface, level, origin - target).states[-1]
    controls, accelerations = [], []
    for state in sliding_phase(surface, reached):
        at = min(max(target + state[0], 0.0), data.stroke)
        servo = advanced_servo(data, at, extending=True)
        control = float(state @ servo_gains(servo, surface))
        if control < 0.0:
            servo = advanced_servo(data, at, extending=False)
            control = float(state @ servo_gains(servo, surface))
        controls.append(abs(control))
        accelerations.append(float(c3 * servo.b0 * (level - abs(control)) / c2))
    largest = max(controls)
    return Reserve(largest, level - largest, max(min(accelerations), 0.0))
