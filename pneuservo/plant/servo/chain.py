"""The whole chain of the servo with every effect: the rate of its state."""

from pneuservo.plant.analogue_card import differentiator_output, differentiator_rates
from pneuservo.plant.control_law import (
    CARD_TAPS,
    HELD_VOLTAGE,
    limited,
    switching_surface,
    unlimited_output,
)
from pneuservo.plant.piston import acceleration
from pneuservo.plant.servo.compilation import compiled
from pneuservo.plant.servo.drive import delayed_command, given
from pneuservo.plant.servo.layout import (
    COMMAND,
    DISPLACEMENT_NOISE,
    LAGGED_DISPLACEMENT,
    PLAY,
    SERVO_STATES,
    SLEWED,
    SLEWED_WHEN,
    SPOOL_STUCK,
    TIME,
)
from pneuservo.plant.servo.mechanics import force_and_piston, hanging_rates, mechanical_rates
from pneuservo.plant.servo.pneumatics import pneumatic_rates
from pneuservo.plant.servo.sensor_effects import heard_motion
from pneuservo.plant.servo.spool_effects import biased_with_play, slewed, spool_rates
from pneuservo.plant.servo.valve_side import supply_at_valve
from pneuservo.plant.single_axis import (
    CARD_DERIVATIVE_1,
    CARD_DERIVATIVE_2,
    CARD_LAGGED_1,
    CARD_LAGGED_2,
    DISPLACEMENT,
    MOTION,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    RELAY_SIGN,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
    SPOOL_RATE,
    VELOCITY,
)


@compiled
def piston_acceleration(state, modes, memory, drive, elapsed, servo):
    """Return the acceleration of the piston [m/s^2].

    Parameters
    ----------
    state, modes, memory, drive, elapsed, servo
        As in `derivative`.
    """
    force, held = force_and_piston(state, modes, memory, drive, elapsed, servo)
    return acceleration(force, modes[MOTION], held)


@compiled
def heard(state, second, servo):
    """Return the motion as the displacement transducer has it [m], [m/s], [m/s^2].

    Parameters
    ----------
    state, servo
        As in `derivative`.
    second : float
        Acceleration of the piston [m/s^2].
    """
    lagged = state[DISPLACEMENT]
    if state.shape[0] > PLANT_STATES:
        lagged = state[LAGGED_DISPLACEMENT]
    return heard_motion(
        state[DISPLACEMENT],
        state[VELOCITY],
        second,
        lagged,
        servo.plant.piston.stroke,
        servo.effects.sensor,
    )


@compiled
def reading(state, second, drive, elapsed, servo):
    """Return what the controller reads of the motion [m], [m/s], [m/s^2].

    Parameters
    ----------
    state, drive, elapsed, servo
        As in `derivative`.
    second : float
        Acceleration of the piston [m/s^2].

    Notes
    -----
    The transducer's motion with its noise, which runs straight from sample to sample, inside its
    range.
    """
    displacement, velocity, second = heard(state, second, servo)
    noisy = displacement + given(drive, DISPLACEMENT_NOISE, elapsed)
    low, high = servo.displacement_range
    if noisy < low:
        return low, 0.0, 0.0
    if noisy > high:
        return high, 0.0, 0.0
    return noisy, velocity, second


@compiled
def moving_reading(state, second, drive, elapsed, servo):
    """Return what the transducer reads [m], how fast it changes [m/s], and the acceleration.

    Parameters
    ----------
    state, second, drive, elapsed, servo
        As in `reading`; its noise changes the reading, too, but for one that is at its limit.
    """
    displacement, velocity, second = reading(state, second, drive, elapsed, servo)
    low, high = servo.displacement_range
    if low < displacement < high:
        velocity += drive[1, DISPLACEMENT_NOISE]
    return displacement, velocity, second


@compiled
def surface(state, modes, memory, drive, elapsed, servo):
    """Return the switching function of the law, in its own unit.

    Parameters
    ----------
    state, modes, memory, drive, elapsed, servo
        As in `derivative`.
    """
    law, demand = servo.law, given(drive, COMMAND, elapsed)
    if law.source == CARD_TAPS:
        displacement, _, _ = reading(state, 0.0, drive, elapsed, servo)
        return switching_surface(
            law.sensitivity * (displacement - demand),
            -differentiator_output(state[CARD_DERIVATIVE_1], law.velocity_time_constant),
            differentiator_output(state[CARD_DERIVATIVE_2], law.acceleration_time_constant),
            law,
        )
    second = piston_acceleration(state, modes, memory, drive, elapsed, servo)
    displacement, velocity, second = reading(state, second, drive, elapsed, servo)
    return switching_surface(displacement - demand, velocity, second, law)


@compiled
def commanded_voltage(state, modes, memory, drive, elapsed, servo):
    """Return the command into the valve driver before any limit [V].

    Parameters
    ----------
    state, modes, memory, drive, elapsed, servo
        As in `derivative`.
    """
    if servo.law.source == HELD_VOLTAGE:
        return given(drive, COMMAND, elapsed)
    value = surface(state, modes, memory, drive, elapsed, servo)
    return unlimited_output(value, modes[RELAY_SIGN], servo.law)


@compiled
def motor_command(command, memory, rows, drive, elapsed, servo):
    """Return the command that moves the spool, before the driver limits it [V].

    Parameters
    ----------
    command : float
        Into the valve driver [V].
    memory, rows, drive, elapsed, servo
        As in `derivative`.
    """
    now = given(drive, TIME, elapsed)
    late = delayed_command(command, memory, rows, now, servo)
    return driving(late, memory, now - memory[SLEWED_WHEN], servo)


@compiled
def driving(command, memory, passed, servo):
    """Return what drives the spool's motor, before the driver limits it [V].

    Parameters
    ----------
    command : float
        Into the valve driver, delayed [V].
    memory, servo
        As in `derivative`.
    passed : float
        Since the memory was last updated [s].
    """
    full, effects = servo.plant.valve.full_voltage, servo.effects.spool
    output = slewed(command, memory[SLEWED], passed, full, effects)
    return biased_with_play(output, memory[PLAY], full, effects)


@compiled
def pressure_share(state, drive, elapsed, servo):
    """Return the mean pressure drop over the two open edges as a share of the supply [-].

    Parameters
    ----------
    state, drive, elapsed, servo
        As in `derivative`; zero for a servo without a flow force, which alone feels it.
    """
    if servo.effects.spool.flow_force == 0.0:
        return 0.0
    supply = supply_at_valve(state, drive, elapsed, servo)
    charged, vented = state[PRESSURE_A], state[PRESSURE_B]
    if state[SPOOL] < 0.0:
        charged, vented = vented, charged
    return 0.5 * (supply - charged + vented - servo.plant.ambient_pressure) / supply


@compiled
def write_spool_rates(state, modes, memory, rows, drive, elapsed, servo, rate):
    """Write the rates of the spool: none at the end of its travel.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, servo, rate
        As in `derivative`.
    """
    rate[SPOOL], rate[SPOOL_RATE] = 0.0, 0.0
    if modes[SPOOL_LIMIT] != SPOOL_FREE:
        return
    plant = servo.plant
    command = limited(
        commanded_voltage(state, modes, memory, drive, elapsed, servo), servo.law.level
    )
    command = motor_command(command, memory, rows, drive, elapsed, servo)
    rate[SPOOL], rate[SPOOL_RATE] = spool_rates(
        limited(command, plant.valve.full_voltage),
        state[SPOOL],
        state[SPOOL_RATE],
        pressure_share(state, drive, elapsed, servo),
        memory[SPOOL_STUCK],
        plant.valve,
        servo.effects.spool,
    )


@compiled
def _write_card_rates(state, drive, elapsed, servo, rate):
    law = servo.law
    displacement, _, _ = reading(state, 0.0, drive, elapsed, servo)
    rate[CARD_LAGGED_1], rate[CARD_DERIVATIVE_1] = differentiator_rates(
        law.sensitivity * displacement,
        state[CARD_LAGGED_1],
        state[CARD_DERIVATIVE_1],
        law.velocity_lag_1,
        law.velocity_lag_2,
    )
    rate[CARD_LAGGED_2], rate[CARD_DERIVATIVE_2] = differentiator_rates(
        differentiator_output(state[CARD_DERIVATIVE_1], law.velocity_time_constant),
        state[CARD_LAGGED_2],
        state[CARD_DERIVATIVE_2],
        law.acceleration_lag_1,
        law.acceleration_lag_2,
    )


@compiled
def derivative(state, modes, memory, rows, drive, elapsed, servo, grid, rate):
    """Write the rate of the state of the whole chain.

    Parameters
    ----------
    state : (6,) or (27,) array
        In SI; places as in `layout`. Six when no effect has a state of its own.
    modes : (3,) array of int
        What the piston is doing, the limit the spool is at, which way a relay is switched.
    memory : (16,) array
        What changes only from step to step; places as in `layout`.
    rows : (1024, 4) array
        The past that delays look up.
    drive : (2, 5) array
        The inputs at the last sample and their rates; columns as in `layout`.
    elapsed : float
        Time since the last sample [s].
    servo : Servo
        The numbers of rig, effects and law.
    grid : (4, 51, 101) array
        Discharge coefficients, from `pneuservo.plant.valve.discharge_grid`.
    rate : array
        Written: the rate of the state in SI per second.
    """
    long = state.shape[0] > PLANT_STATES
    if long:
        for i in range(PLANT_STATES, SERVO_STATES):
            rate[i] = 0.0
    velocity = mechanical_rates(state, modes, memory, drive, elapsed, servo, rate)
    if long:
        hanging_rates(state, velocity, rate[VELOCITY], servo, rate)
    pneumatic_rates(state, velocity, memory, rows, drive, elapsed, servo, grid, rate)
    write_spool_rates(state, modes, memory, rows, drive, elapsed, servo, rate)
    if servo.law.source == CARD_TAPS:
        _write_card_rates(state, drive, elapsed, servo, rate)
