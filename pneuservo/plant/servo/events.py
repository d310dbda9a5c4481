"""When the equations of the servo with effects change; see `pneuservo.plant.events`."""

from pneuservo.plant.control_law import HELD_VOLTAGE
from pneuservo.plant.events import is_relay
from pneuservo.plant.piston import is_moving, motion_from, motion_margin
from pneuservo.plant.servo.chain import commanded_voltage, motor_command, pressure_share, surface
from pneuservo.plant.servo.compilation import compiled, compiled_apart
from pneuservo.plant.servo.mechanics import force_and_piston, throw_on
from pneuservo.plant.servo.spool_effects import travel_end
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    MOTION,
    RELAY_SIGN,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
    SPOOL_RATE,
    VELOCITY,
)


@compiled
def spool_margin(state, modes, memory, rows, drive, elapsed, servo):
    """Return how far the spool is from its end of travel, or from leaving it.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.

    Notes
    -----
    As `pneuservo.plant.events.spool_margin`, with ends that may differ, the command that reaches
    the motor, and the flow that pulls the spool off its end.
    """
    limit = modes[SPOOL_LIMIT]
    if limit == SPOOL_FREE:
        return travel_end(state[SPOOL], servo.effects.spool) - abs(state[SPOOL])
    law, full = servo.law, servo.plant.valve.full_voltage
    end = travel_end(float(limit), servo.effects.spool)
    command = commanded_voltage(state, modes, memory, drive, elapsed, servo)
    pulled = limit * motor_command(command, memory, rows, drive, elapsed, servo) / full
    shut = servo.effects.spool.flow_force * end * pressure_share(state, drive, elapsed, servo)
    if law.source == HELD_VOLTAGE or is_relay(law) or law.level < full:
        return 1.0 if min(pulled, law.level / full) - shut >= end else -1.0
    return (min(pulled, 1.0) - shut if shut > 0.0 else pulled) - end


@compiled
def margin(state, modes, memory, rows, drive, elapsed, servo):
    """Return how far the state is from the next event: negative once one has happened.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    force, held = force_and_piston(state, modes, memory, drive, elapsed, servo)
    least = motion_margin(modes[MOTION], state[DISPLACEMENT], state[VELOCITY], force, held)
    least = min(least, spool_margin(state, modes, memory, rows, drive, elapsed, servo))
    if is_relay(servo.law):
        value = surface(state, modes, memory, drive, elapsed, servo)
        least = min(least, modes[RELAY_SIGN] * value)
    return least


@compiled_apart
def margin_apart(state, modes, memory, rows, drive, elapsed, servo):
    """Return what `margin` does, where it is seldom asked for.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    return margin(state, modes, memory, rows, drive, elapsed, servo)


@compiled_apart
def settle(state, modes, memory, rows, drive, elapsed, servo):
    """Bring the modes into line with the state, and the state onto what the modes hold.

    Parameters
    ----------
    state : array
        Changed where a mode holds it.
    modes : (3,) array of int
        Changed.
    memory, rows, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    _settle_piston(state, modes, memory, drive, elapsed, servo)
    if is_relay(servo.law):
        value = surface(state, modes, memory, drive, elapsed, servo)
        if modes[RELAY_SIGN] * value < 0.0:
            modes[RELAY_SIGN] = -modes[RELAY_SIGN]
    _settle_spool(state, modes, memory, rows, drive, elapsed, servo)


@compiled
def _settle_piston(state, modes, memory, drive, elapsed, servo):
    stroke = servo.plant.piston.stroke
    motion = modes[MOTION]
    force, held = force_and_piston(state, modes, memory, drive, elapsed, servo)
    displacement, velocity = state[DISPLACEMENT], state[VELOCITY]
    if motion_margin(motion, displacement, velocity, force, held) >= 0.0:
        return
    state[DISPLACEMENT] = min(max(displacement, 0.0), stroke)
    if is_moving(motion) or displacement != state[DISPLACEMENT]:
        throw_on(state, servo)
        state[VELOCITY] = 0.0
        force, held = force_and_piston(state, modes, memory, drive, elapsed, servo)
    modes[MOTION] = motion_from(state[DISPLACEMENT], state[VELOCITY], force, held)


@compiled
def _settle_spool(state, modes, memory, rows, drive, elapsed, servo):
    if spool_margin(state, modes, memory, rows, drive, elapsed, servo) >= 0.0:
        return
    if modes[SPOOL_LIMIT] != SPOOL_FREE:
        modes[SPOOL_LIMIT] = SPOOL_FREE
        return
    limit = 1 if state[SPOOL] > 0.0 else -1
    state[SPOOL] = limit * travel_end(float(limit), servo.effects.spool)
    state[SPOOL_RATE] = 0.0
    modes[SPOOL_LIMIT] = limit
    if spool_margin(state, modes, memory, rows, drive, elapsed, servo) < 0.0:
        modes[SPOOL_LIMIT] = SPOOL_FREE


@compiled_apart
def motion_at_start(state, modes, memory, drive, servo):
    """Write what the piston does at the start of a run.

    Parameters
    ----------
    state, modes, memory, drive, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    force, held = force_and_piston(state, modes, memory, drive, 0.0, servo)
    modes[MOTION] = motion_from(state[DISPLACEMENT], state[VELOCITY], force, held)
    if not is_moving(modes[MOTION]):
        state[VELOCITY] = 0.0
