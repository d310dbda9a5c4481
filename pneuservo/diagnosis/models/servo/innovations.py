"""What readings read beyond what the observer expects, and how that moves what it follows."""

from pneuservo.diagnosis.models.servo.advance import BEHIND_A, BEHIND_B
from pneuservo.diagnosis.models.servo.covariance import ESTIMATED, GAIN_ROWS
from pneuservo.plant.compilation import compiled
from pneuservo.plant.piston import driving_force
from pneuservo.plant.servo.sensor_effects import displacement_error, dynamic_pressure
from pneuservo.plant.servo.stop_effects import resting_place
from pneuservo.plant.single_axis import PRESSURE_A, PRESSURE_B


@compiled
def pressure_errors(error, reading, state, earlier, older, within, zeros):
    """Write by how much both pressures read more than is expected [Pa].

    Parameters
    ----------
    error : (3,) array
        The first two are written.
    reading : (3,) array
        NaN where there is none, SI.
    state : array
        Of the servo.
    earlier : (3,) array
        Both pressures as followed at the sample before [Pa].
    older : float
        By how much sooner than at the sample they were read, as a share of the interval [-].
    within : array
        Holds how far the pressures of the transducers are behind those of the chambers [Pa].
    zeros : (3,) array
        By how much the zeros of the transducers have wandered, SI.
    """
    error[0] = reading[0] - state[PRESSURE_A] + within[BEHIND_A] - zeros[0]
    error[1] = reading[1] - state[PRESSURE_B] + within[BEHIND_B] - zeros[1]
    error[0] += older * (state[PRESSURE_A] - earlier[0])
    error[1] += older * (state[PRESSURE_B] - earlier[1])


@compiled
def add_dynamic_pressure(error, share, flow_a, flow_b, state, gas):
    """Add what transducers at the ports miss of the pressure of what flows past them [Pa].

    Parameters
    ----------
    error : (3,) array
        As from `pressure_errors`.
    share : float
        Of the dynamic pressure that is missed [-].
    flow_a, flow_b : float
        Into the chambers [kg/s].
    state : array
        Of the servo.
    gas : Gas
        The gas.
    """
    error[0] += share * dynamic_pressure(flow_a, state[PRESSURE_A], gas)
    error[1] += share * dynamic_pressure(flow_b, state[PRESSURE_B], gas)


@compiled
def place_at_stop(side, state, external_force, servo):
    """Return where a piston lies that is pressed on a stop, and what reads it [m].

    Parameters
    ----------
    side : int
        -1 for the retracted stop, 1 for the extended one.
    state : array
        Of the servo.
    external_force : float
        At the rod, positive when it resists extension [N].
    servo : Servo
        The numbers of rig and effects.

    Returns
    -------
    place, reading : float
        Of the piston, and of its transducer but for a wiper's play [m].
    """
    plant, effects = servo.plant, servo.effects
    piston = plant.piston
    force = driving_force(
        state[PRESSURE_A], state[PRESSURE_B], 0.0, external_force, plant.ambient_pressure, piston
    )
    place = resting_place(side, force, piston.stroke, effects.stop)
    return place, place + displacement_error(place, piston.stroke, effects.sensor)


@compiled
def corrections(moved, left, error, gain, share):
    """Write what the errors of one sample correct, and each in the spread it was expected to have.

    Parameters
    ----------
    moved : (GAIN_ROWS,) array
        Written: what is corrected, SI.
    left : (3,) array
        Written where there is a reading: its innovation, counted in its spread, SI.
    error : (3,) array
        NaN where nothing was read, SI.
    gain : (GAIN_ROWS, 3) array
        What each error corrects.
    share : (3,) array
        Noise of each reading over the spread of its innovation [-].
    """
    moved[:] = 0.0
    for slot in range(3):
        if error[slot] == error[slot]:
            left[slot] = (error[slot] - moved[ESTIMATED + slot]) * share[slot]
            for row in range(GAIN_ROWS):
                moved[row] += gain[row, slot] * error[slot]
