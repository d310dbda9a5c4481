"""Forces on the piston and what it does, with every effect."""

from pneuservo.plant.piston import Piston, acceleration, driving_force, is_moving
from pneuservo.plant.presliding import presliding_step
from pneuservo.plant.servo.compilation import compiled
from pneuservo.plant.servo.drive import given
from pneuservo.plant.servo.friction_effects import (
    breakaway_gain,
    friction_levels,
    has_presliding,
    viscous_excess,
)
from pneuservo.plant.servo.layout import (
    BRISTLE,
    BRISTLE_PLACE,
    CUSHION_A,
    CUSHION_B,
    EXTERNAL_FORCE,
    JOINT,
    JOINT_RATE,
    LAGGED_DISPLACEMENT,
    LAGGED_VELOCITY,
    MODE,
    MODE_RATE,
    PISTON_REST,
    TIME,
)
from pneuservo.plant.servo.load_effects import (
    joint_force,
    mode_acceleration,
    mode_force,
    rigid_mass,
    spring_force,
    tilt_force,
)
from pneuservo.plant.servo.sensor_effects import lag_rate
from pneuservo.plant.servo.stop_effects import bumper_force, cushion_force, cushion_rate
from pneuservo.plant.servo.unexplained_effects import unexplained_force
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    MOTION,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    VELOCITY,
)


@compiled
def sliding_levels(state, modes, memory, drive, elapsed, servo):
    """Return the friction that holds or brakes the piston, extending and retracting [N].

    Parameters
    ----------
    state, modes, memory, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    plant, effects = servo.plant, servo.effects.friction
    moving = is_moving(modes[MOTION])
    speed = 0.0
    if moving:
        speed = state[VELOCITY]
        if effects.lag > 0.0:
            speed = state[LAGGED_VELOCITY]
    forward, backward = friction_levels(
        plant.piston.coulomb_friction,
        state[DISPLACEMENT],
        speed,
        state[PRESSURE_A],
        state[PRESSURE_B],
        plant.ambient_pressure,
        plant.piston.stroke,
        given(drive, TIME, elapsed),
        effects,
    )
    if not moving:
        gain = breakaway_gain(memory[PISTON_REST], effects)
        return forward + gain, backward + gain
    return forward, backward


@compiled
def bristle_force(state, memory, forward, backward, servo):
    """Return the friction that has built up over the way since the last step [N].

    Parameters
    ----------
    state, memory, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    forward, backward : float
        From `sliding_levels` [N].
    """
    effects = servo.effects.friction
    share = presliding_step(
        memory[BRISTLE],
        state[DISPLACEMENT] - memory[BRISTLE_PLACE],
        effects.presliding_travel,
        effects.presliding_exponent,
    )
    return share * (forward if share > 0.0 else backward)


@compiled
def smooth_force(state, drive, elapsed, servo):
    """Return every force on the piston but friction that can hold it, positive extends [N].

    Parameters
    ----------
    state, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    plant, effects = servo.plant, servo.effects
    piston = plant.piston
    x, v = state[DISPLACEMENT], state[VELOCITY]
    pa, pb = state[PRESSURE_A], state[PRESSURE_B]
    external = given(drive, EXTERNAL_FORCE, elapsed)
    force = driving_force(pa, pb, v, external, plant.ambient_pressure, piston)
    lagged = v
    if state.shape[0] > PLANT_STATES:
        lagged = state[LAGGED_VELOCITY]
    now = given(drive, TIME, elapsed)
    force -= viscous_excess(v, lagged, piston.viscous_friction, now, effects.friction)
    force += spring_force(x, piston.stroke, effects.load)
    force += tilt_force(piston.mass, piston.gravity, effects.load)
    force += bumper_force(x, v, piston.stroke, effects.stop)
    force += unexplained_force(x, v, pa, pb, state[SPOOL], now, effects)
    if state.shape[0] > PLANT_STATES:
        force += carried_force(state, servo)
    return force


@compiled
def carried_force(state, servo):
    """Return the force of the load's own motion and of the cushions, positive extends [N].

    Parameters
    ----------
    state, servo
        As in `pneuservo.plant.servo.chain.derivative`; the state is the long one.
    """
    piston, load, stop = servo.plant.piston, servo.effects.load, servo.effects.stop
    x = state[DISPLACEMENT]
    force = mode_force(piston.mass, state[MODE], state[MODE_RATE], load)
    if load.joint_share > 0.0:
        force -= load.joint_share * piston.mass * piston.gravity
        force += joint_force(state[JOINT], state[JOINT_RATE], load)
    force += cushion_force(x, state[CUSHION_A], state[PRESSURE_A], piston.area_a, stop)
    rest = piston.stroke - x
    return force - cushion_force(rest, state[CUSHION_B], state[PRESSURE_B], piston.area_b, stop)


@compiled
def force_and_piston(state, modes, memory, drive, elapsed, servo):
    """Return the driving force [N] and the piston that the baseline's laws of motion take.

    Parameters
    ----------
    state, modes, memory, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.

    Returns
    -------
    float, Piston
        A friction of `forward` and `backward` is one of their mean against a force shifted by
        half their difference, at rest and in motion alike; the piston carries the mean and the
        mass that moves with the rod at once.
    """
    piston = servo.plant.piston
    forward, backward = sliding_levels(state, modes, memory, drive, elapsed, servo)
    force = smooth_force(state, drive, elapsed, servo)
    if has_presliding(servo.effects.friction):
        force -= bristle_force(state, memory, forward, backward, servo)
        forward, backward = 0.0, 0.0
    held = Piston(
        piston.area_a,
        piston.area_b,
        piston.stroke,
        rigid_mass(piston.mass, servo.effects.load),
        piston.gravity,
        piston.viscous_friction,
        0.5 * (forward + backward),
    )
    return force - 0.5 * (forward - backward), held


@compiled
def mechanical_rates(state, modes, memory, drive, elapsed, servo, rate):
    """Write the rates of the piston, and return its velocity [m/s].

    Parameters
    ----------
    state, modes, memory, drive, elapsed, servo, rate
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    motion = modes[MOTION]
    velocity = state[VELOCITY] if is_moving(motion) else 0.0
    force, held = force_and_piston(state, modes, memory, drive, elapsed, servo)
    rate[DISPLACEMENT] = velocity
    rate[VELOCITY] = acceleration(force, motion, held)
    return velocity


@compiled
def hanging_rates(state, velocity, second, servo, rate):
    """Write the rates of what hangs on the piston: load, cushions, transducer, lag of friction.

    Parameters
    ----------
    state, servo, rate
        As in `pneuservo.plant.servo.chain.derivative`; the state is the long one.
    velocity, second : float
        Velocity [m/s] and acceleration [m/s^2] of the piston.
    """
    effects = servo.effects
    if effects.friction.lag > 0.0:
        rate[LAGGED_VELOCITY] = (velocity - state[LAGGED_VELOCITY]) / effects.friction.lag
    rate[LAGGED_DISPLACEMENT] = lag_rate(
        state[DISPLACEMENT],
        state[LAGGED_DISPLACEMENT],
        servo.plant.piston.stroke,
        effects.sensor,
    )
    carried_rates(state, velocity, second, servo, rate)


@compiled
def throw_on(state, servo):
    """Have what hangs on the piston go on as fast as it did when the piston comes to a halt.

    Parameters
    ----------
    state, servo
        As in `pneuservo.plant.servo.chain.derivative`; the rates of the load are written.
    """
    if state.shape[0] == PLANT_STATES:
        return
    if servo.effects.load.mode_share > 0.0:
        state[MODE_RATE] += state[VELOCITY]
    if servo.effects.load.joint_share > 0.0:
        state[JOINT_RATE] += state[VELOCITY]


@compiled
def carried_rates(state, velocity, second, servo, rate):
    """Write the rates of the load and of the cushions, which follow the piston however it moves.

    Parameters
    ----------
    state, velocity, second, servo, rate
        As in `hanging_rates`.
    """
    plant, effects = servo.plant, servo.effects
    piston, load = plant.piston, effects.load
    if load.mode_share > 0.0:
        rate[MODE] = state[MODE_RATE]
        rate[MODE_RATE] = mode_acceleration(second, state[MODE], state[MODE_RATE], load)
    if load.joint_share > 0.0:
        carried = joint_force(state[JOINT], state[JOINT_RATE], load)
        rate[JOINT] = state[JOINT_RATE]
        rate[JOINT_RATE] = piston.gravity - carried / (load.joint_share * piston.mass) - second
    if effects.stop.cushion_length > 0.0:
        rate[CUSHION_A] = cushion_rate(
            state[DISPLACEMENT],
            -velocity,
            state[CUSHION_A],
            state[PRESSURE_A],
            piston.area_a,
            plant.polytropic_index,
            plant.gas,
            effects.stop,
        )
        rate[CUSHION_B] = cushion_rate(
            piston.stroke - state[DISPLACEMENT],
            velocity,
            state[CUSHION_B],
            state[PRESSURE_B],
            piston.area_b,
            plant.polytropic_index,
            plant.gas,
            effects.stop,
        )
