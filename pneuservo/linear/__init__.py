"""Linear models of a pneumatic servo: from any rig, at any position, in either direction."""

from pneuservo.linear.from_rig import TABLE_5_2, equal_areas, servo_data, table_5_2
from pneuservo.linear.models import (
    advanced_servo,
    conventional_servo,
    state_matrices,
    state_space,
    transfer_function,
    without_valve,
)
from pneuservo.linear.quiescent import at_quiescent_pressures, quiescent_pressures
from pneuservo.linear.servo_data import FlowAreas, ServoData

__all__ = [
    "TABLE_5_2",
    "FlowAreas",
    "ServoData",
    "advanced_servo",
    "at_quiescent_pressures",
    "conventional_servo",
    "equal_areas",
    "quiescent_pressures",
    "servo_data",
    "state_matrices",
    "state_space",
    "table_5_2",
    "transfer_function",
    "without_valve",
]
