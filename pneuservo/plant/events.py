"""When the equations change: stick and slip, end stops, spool limits, relay switching.

Between such events the equations are smooth apart from kinks. What is going on is held in the
modes, which stay as they are during a step and change only where an event was located.
"""

from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import HELD_VOLTAGE, is_relay
from pneuservo.plant.lanes import select
from pneuservo.plant.piston import (
    EXTENDING,
    RETRACTING,
    friction_margin,
    is_moving,
    motion_from,
    motion_margin,
    stop_margin,
)
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

# Places in the margins.
FRICTION, STOP, SPOOL_END, RELAY = range(4)


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
    full = plant.valve.full_voltage
    command = limit * commanded_voltage(state, modes, inputs, law, plant)
    held = select(min(command, law.level) >= full, 1.0, -1.0)
    if not (law.source == HELD_VOLTAGE or is_relay(law)):
        held = select(law.level < full, held, command / full - 1.0)
    return select(limit == SPOOL_FREE, 1.0 - abs(state[SPOOL]), held)


@compiled
def margins(state, modes, inputs, law, plant):
    """Return how far the state is from each kind of event: negative once one has happened.

    Parameters
    ----------
    state, modes, inputs, law, plant
        As in `derivative`.

    Returns
    -------
    tuple of 4 floats or Lanes
        In places `FRICTION`, `STOP`, `SPOOL_END` and `RELAY`, each in its own unit: only the
        sign and the zero mean anything. 1 where there is no relay.
    """
    piston, motion = plant.piston, modes[MOTION]
    force = piston_force(state, inputs, plant)
    spool = spool_margin(state, modes, inputs, law, plant)
    relay = abs(spool) * 0.0 + 1.0
    if is_relay(law):
        relay = modes[RELAY_SIGN] * surface(state, modes, inputs, law, plant)
    return (
        friction_margin(motion, state[VELOCITY], force, piston),
        stop_margin(motion, state[DISPLACEMENT], piston),
        spool,
        relay,
    )


@compiled
def margin(state, modes, inputs, law, plant):
    """Return the least of all `margins`.

    Parameters
    ----------
    state, modes, inputs, law, plant
        As in `derivative`.
    """
    friction, stop, spool, relay = margins(state, modes, inputs, law, plant)
    return min(min(friction, stop), min(spool, relay))


@compiled
def happen(event, state, modes, inputs, law, plant):
    """Change the modes at an event that was located, and whatever else follows from it at once.

    Parameters
    ----------
    event : int
        Which of the `margins` has come to its zero.
    state, modes, inputs, law, plant
        As in `settle`.
    """
    piston = plant.piston
    if event == FRICTION and not is_moving(modes[MOTION]):
        force = piston_force(state, inputs, plant)
        modes[MOTION] = EXTENDING if force > 0.0 else RETRACTING
    elif event in (FRICTION, STOP):
        if event == STOP:
            state[DISPLACEMENT] = piston.stroke if modes[MOTION] == EXTENDING else 0.0
        state[DISPLACEMENT] = min(max(state[DISPLACEMENT], 0.0), piston.stroke)
        state[VELOCITY] = 0.0
        force = piston_force(state, inputs, plant)
        modes[MOTION] = motion_from(state[DISPLACEMENT], 0.0, force, piston)
    else:
        _settle_piston(state, modes, inputs, plant)
    if event == RELAY:
        modes[RELAY_SIGN] = -modes[RELAY_SIGN]
    else:
        _settle_relay(state, modes, inputs, law, plant)
    if event == SPOOL_END:
        _change_spool(state, modes, inputs, law, plant)
    else:
        _settle_spool(state, modes, inputs, law, plant)


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
    _settle_relay(state, modes, inputs, law, plant)
    _settle_spool(state, modes, inputs, law, plant)


@compiled
def _settle_relay(state, modes, inputs, law, plant):
    if is_relay(law) and modes[RELAY_SIGN] * surface(state, modes, inputs, law, plant) < 0.0:
        modes[RELAY_SIGN] = -modes[RELAY_SIGN]


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
    if spool_margin(state, modes, inputs, law, plant) < 0.0:
        _change_spool(state, modes, inputs, law, plant)


@compiled
def _change_spool(state, modes, inputs, law, plant):
    if modes[SPOOL_LIMIT] != SPOOL_FREE:
        modes[SPOOL_LIMIT] = SPOOL_FREE
        return
    limit = 1 if state[SPOOL] > 0.0 else -1
    state[SPOOL] = limit
    state[SPOOL_RATE] = 0.0
    modes[SPOOL_LIMIT] = limit
    if spool_margin(state, modes, inputs, law, plant) < 0.0:
        modes[SPOOL_LIMIT] = SPOOL_FREE
