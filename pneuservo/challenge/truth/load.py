"""The moved mass, what is fastened to it, the frame, and the ends of the stroke."""

import math

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel


@truth_kernel
def stop_force(x, v, stroke, load):
    """Return the force of an end stop on the piston [N]; it only pushes."""
    if x < 0.0:
        return max(-load.stop_stiffness * x - load.stop_damping * v, 0.0)
    if x > stroke:
        return min(-load.stop_stiffness * (x - stroke) - load.stop_damping * v, 0.0)
    return 0.0


@truth_kernel
def pushed(time, load):
    """Return an external force that repeats in no experiment [N]."""
    return load.push * (
        math.sin(2.1 * time + 0.4) + 0.6 * math.sin(7.7 * time * (1.0 + 0.01 * time))
    )


@truth_kernel
def beyond_gap(stretch, gap):
    """Return how far a joint with play is strained [m]."""
    return math.copysign(max(abs(stretch) - 0.5 * gap, 0.0), stretch)


@truth_kernel
def motion_rates(time, gas_force, friction, y, rates, load, stroke):
    """Set the rates of everything that moves; gas force and friction in [N]."""
    x, v = y[at.POSITION], y[at.SPEED]
    mass = load.mass + load.mass_rate * time
    deflection = x - load.spring_at
    force = gas_force - friction + stop_force(x, v, stroke, load) - pushed(time, load)
    force -= load.spring * deflection * (1.0 + load.spring_cubic * deflection * deflection)
    rates[at.POSITION] = v
    if load.joint_stiffness > 0.0:
        strain = beyond_gap(x - y[at.LOAD_POSITION], load.joint_gap)
        joint = load.joint_stiffness * strain
        if strain != 0.0:
            joint += load.joint_damping * (v - y[at.LOAD_SPEED])
        rates[at.LOAD_POSITION] = y[at.LOAD_SPEED]
        rates[at.LOAD_SPEED] = joint / (mass - load.rod_mass) + load.gravity
        rates[at.SPEED] = (force - joint) / load.rod_mass + load.gravity
        return
    force += mass * load.gravity
    if load.mode_mass > 0.0:
        w = load.mode_frequency
        restoring = 2.0 * load.mode_damping * w * y[at.MODE_SPEED] + w * w * y[at.MODE]
        rates[at.SPEED] = (force + load.mode_mass * restoring) / (mass - load.mode_mass)
        rates[at.MODE] = y[at.MODE_SPEED]
        rates[at.MODE_SPEED] = -rates[at.SPEED] - restoring
        return
    rates[at.SPEED] = force / mass
    if load.frame_mass > 0.0:
        w = load.frame_frequency
        held = w * w * beyond_gap(y[at.FRAME], load.frame_gap)
        held += 2.0 * load.frame_damping * w * y[at.FRAME_SPEED]
        rates[at.FRAME] = y[at.FRAME_SPEED]
        rates[at.FRAME_SPEED] = -(gas_force - friction) / load.frame_mass - held
        rates[at.SPEED] -= rates[at.FRAME_SPEED]
