"""Places of everything the servo with effects integrates, remembers, is given and returns."""

import math
from typing import NamedTuple

from pneuservo.plant.control_law import ControlLaw
from pneuservo.plant.outputs import OUTPUTS as BASELINE_OUTPUTS
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.single_axis import STATES_WITH_CARD, SingleAxis

# States behind those of the baseline and of the card, `pneuservo.plant.single_axis`.
(
    TEMPERATURE_A,
    TEMPERATURE_B,
    WALL_A,
    WALL_B,
    RESERVOIR,
    LAGGED_VELOCITY,
    LAGGED_DISPLACEMENT,
    MODE,
    MODE_RATE,
    JOINT,
    JOINT_RATE,
    HOSE_FLOW_A,
    HOSE_FLOW_B,
    PORT_PRESSURE_A,
    PORT_PRESSURE_B,
    CUSHION_A,
    CUSHION_B,
) = range(STATES_WITH_CARD, STATES_WITH_CARD + 17)
SERVO_STATES = STATES_WITH_CARD + 17

# What changes only from step to step. The jets follow the order of the flow paths in `valve`.
(
    SLEWED,
    SLEWED_WHEN,
    PLAY,
    SPOOL_STUCK,
    SPOOL_REST,
    LAST_SPOOL_RATE,
    PISTON_REST,
    BRISTLE,
    BRISTLE_PLACE,
    NEWEST,
    EXHAUST,
    FIRST_JET,
) = range(12)
MEMORY = FIRST_JET + 4

# Columns of the past that delays look up.
WHEN, COMMANDED, FLOWED_A, FLOWED_B = range(4)
PAST_ROWS, PAST_COLUMNS = 1024, 4

# What drives the chain: columns of the inputs. Command and external force are the baseline's.
COMMAND, EXTERNAL_FORCE, SUPPLY, DISPLACEMENT_NOISE, TIME = range(5)
INPUTS = 5

OUTPUTS = (
    *BASELINE_OUTPUTS,
    "supply_pressure",
    "temperature_a",
    "temperature_b",
    "mass_flow_a",
    "mass_flow_b",
)
(
    SUPPLY_OUT,
    TEMPERATURE_A_OUT,
    TEMPERATURE_B_OUT,
    FLOW_A_OUT,
    FLOW_B_OUT,
) = range(len(BASELINE_OUTPUTS), len(OUTPUTS))


class Servo(NamedTuple):
    """The numbers of a servo with effects."""

    plant: SingleAxis
    effects: ServoEffects
    law: ControlLaw
    displacement_range: tuple[float, float] = (-math.inf, math.inf)
    """Least and largest reading of the displacement transducer [m]."""
