"""Every effect of the servo in one place."""

from typing import NamedTuple

from pneuservo.plant.servo.chamber_effects import ChamberEffects
from pneuservo.plant.servo.friction_effects import FrictionEffects
from pneuservo.plant.servo.leakage_effects import LeakageEffects
from pneuservo.plant.servo.line_effects import LineEffects
from pneuservo.plant.servo.load_effects import LoadEffects
from pneuservo.plant.servo.sensor_effects import SensorEffects
from pneuservo.plant.servo.spool_effects import SpoolEffects
from pneuservo.plant.servo.stop_effects import StopEffects
from pneuservo.plant.servo.supply_effects import SupplyEffects
from pneuservo.plant.servo.unexplained_effects import Table
from pneuservo.plant.servo.valve_effects import ValveEffects


class ServoEffects(NamedTuple):
    """The parameters of all effects, block by block; the default is the baseline."""

    spool: SpoolEffects = SpoolEffects()
    valve: ValveEffects = ValveEffects()
    supply: SupplyEffects = SupplyEffects()
    line: LineEffects = LineEffects()
    chamber: ChamberEffects = ChamberEffects()
    leakage: LeakageEffects = LeakageEffects()
    friction: FrictionEffects = FrictionEffects()
    load: LoadEffects = LoadEffects()
    stop: StopEffects = StopEffects()
    sensor: SensorEffects = SensorEffects()
    unexplained_force: Table = Table()
    """On the piston, positive extends [N]."""
    unexplained_flow_a: Table = Table()
    """Into chamber a [kg/s]."""
    unexplained_flow_b: Table = Table()
    """Into chamber b [kg/s]."""
    unexplained_drift: Table = Table()
    """Of a parameter over time, a share of it [-]."""


NEUTRAL = ServoEffects()
