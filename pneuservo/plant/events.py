"""When the equations change: stick and slip, end stops, spool limits, relay switching.

Between such events the equations are smooth apart from kinks. What is going on is held in the
modes, which stay as they are during a step and change only where an event was located.
"""

import math

from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import HELD_VOLTAGE
from pneuservo.plant.piston import is_moving, motion_from, motion_margin
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    MOTION,
    RELAY_SIGN,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
    SPOOL_RATE,
    VELOCITY,
    commanded_voltage,
    piston_force,
    surface,
)


@compiled
def is_relay(law):
    """Return whether a law switches instead of acting continuously.

    Parameters
    ----------
    law : ControlLaw
        What commands the valve.
    """
    return law.source != HELD_VOLTAGE and math.isinf(law.gain)


@compiled
def spool_margin(state, modes, inputs, law, plant):
    """Return how far the spool is from its limit, or from leaving it: negative once it has to.

    Parameters
    ----------
    state, modes, inputs, law, plant
        As in `derivative`.

    Notes
    -----
    At a limit the spool leaves when its acceleration, with the command limited, points inside:
    when the command falls below the full voltage. A command that only changes in jumps has no
    zero to find, and counts as 1 or -1.
    """
    limit = modes[SPOOL_LIMIT]
    if limit == SPOOL_FREE:
        return 1.0 - abs(state[SPOOL])
    full = plant.valve.full_voltage
    command = limit * commanded_voltage(state, modes, inputs, law, plant)
    if law.source == HELD_VOLTAGE or is_relay(law) or law.level < full:
        return 1.0 if min(command, law.level) >= full else -1.0
    return command / full - 1.0


@compiled
def margin(state, modes, inputs, law, plant):
    """Return how far the state is from the next event: negative once one has happened.

    Parameters
    ----------
    state, modes, inputs, law, plant
        As in `derivative`.

    Notes
    -----
    The least of all margins, each in its own unit: only the sign and the zero mean anything.
    """
    least = motion_margin(
        modes[MOTION],
        state[DISPLACEMENT],
        state[VELOCITY],
        piston_force(state, inputs, plant),
        plant.piston,
    )
    least = min(least, spool_margin(state, modes, inputs, law, plant))
    if is_relay(law):
        least = min(least, modes[RELAY_SIGN] * surface(state, modes, inputs, law, plant))
    return least


@compiled
def settle(state, modes, inputs, law, plant):
    """Bring the modes into line with the state, and the state onto what the modes hold.

    Parameters
    ----------
    state : array
        Changed where a mode holds it: velocity 0 at rest and at a stop, spool rate 0 at a limit.
    modes : (3,) array of int
        Changed.
    inputs, law, plant
        As in `derivative`.
    """
    _settle_piston(state, modes, inputs, plant)
    # The acceleration jumps when the motion changes, so the relay is looked at afterwards.
    if is_relay(law) and modes[RELAY_SIGN] * surface(state, modes, inputs, law, plant) < 0.0:
        modes[RELAY_SIGN] = -modes[RELAY_SIGN]
    _settle_spool(state, modes, inputs, law, plant)


@compiled
def _settle_piston(state, modes, inputs, plant):
    piston = plant.piston
    motion = modes[MOTION]
    force = piston_force(state, inputs, plant)
    displacement, velocity = state[DISPLACEMENT], state[VELOCITY]
    if motion_margin(motion, displacement, velocity, force, piston) >= 0.0:
        return
    state[DISPLACEMENT] = min(max(displacement, 0.0), piston.stroke)
    if is_moving(motion) or displacement != state[DISPLACEMENT]:
        state[VELOCITY] = 0.0
        force = piston_force(state, inputs, plant)
    modes[MOTION] = motion_from(state[DISPLACEMENT], state[VELOCITY], force, piston)


@compiled
def _settle_spool(state, modes, inputs, law, plant):
    if spool_margin(state, modes, inputs, law, plant) >= 0.0:
        return
    if modes[SPOOL_LIMIT] != SPOOL_FREE:
        modes[SPOOL_LIMIT] = SPOOL_FREE
        return
    limit = 1 if state[SPOOL] > 0.0 else -1
    state[SPOOL] = limit
    state[SPOOL_RATE] = 0.0
    modes[SPOOL_LIMIT] = limit
    if spool_margin(state, modes, inputs, law, plant) < 0.0:
        modes[SPOOL_LIMIT] = SPOOL_FREE
