"""The yardstick: the same equations as one would write them in NumPy, without a compiler.

Both chambers at once, the discharge coefficients interpolated on the same even grid. What is looked
at for events is plain Python, so that it does not make the yardstick slower than need be.
"""

import math

import numpy as np

from benchmarks.compiled_plant import CompiledPlant
from pneuservo.arrays import Array
from pneuservo.controllers import AnalogueCard


class NumpyPlant(CompiledPlant):
    """Rates and events of the closed loop in NumPy; settling at an event is the product's."""

    def __init__(self, card: AnalogueCard):
        super().__init__(card)
        valve, piston = self.plant.valve, self.plant.piston
        supply, ambient = self.plant.supply_pressure, self.plant.ambient_pressure
        self.out = (np.array([0, 1]), np.array([valve.area_s_a, valve.area_b_e]))
        self.back = (np.array([3, 2]), np.array([valve.area_a_e, valve.area_s_b]))
        self.ports = {True: np.array([supply, ambient]), False: np.array([ambient, supply])}
        self.areas = np.array([piston.area_a, -piston.area_b])
        self.volumes = np.array(
            [self.plant.dead_volume_a, self.plant.dead_volume_b + piston.area_b * piston.stroke]
        )

    def rate(self, y: Array, modes, held) -> Array:
        law, plant = self.law, self.plant
        valve, piston, gas = plant.valve, plant.piston, plant.gas
        moving = abs(modes[0]) == 1
        out = np.empty(10)
        out[0] = y[1] if moving else 0.0
        out[1] = (self.force(y) - modes[0] * piston.coulomb_friction) / piston.mass if moving else 0
        flow = self.flow_into_chambers(y[4], y[2:4])
        inflow = gas.gas_constant * gas.temperature * flow
        volume = self.volumes + self.areas * y[0]
        out[2:4] = plant.polytropic_index / volume * (inflow - y[2:4] * self.areas * out[0])
        command = self.command(y, modes, held)
        w = valve.spool_frequency
        target = max(-1.0, min(command / valve.full_voltage, 1.0))
        out[4] = y[5] if modes[1] == 0 else 0.0
        push = w * w * (target - y[4]) - 2.0 * valve.spool_damping * w * y[5]
        out[5] = push if modes[1] == 0 else 0.0
        out[6] = (law.sensitivity * y[0] - y[6]) / law.velocity_lag_1
        out[7] = (out[6] - y[7]) / law.velocity_lag_2
        out[8] = (-law.velocity_time_constant * y[7] - y[8]) / law.acceleration_lag_1
        out[9] = (out[8] - y[9]) / law.acceleration_lag_2
        return out

    def flow_into_chambers(self, opening: float, pressure: Array) -> Array:
        gas, valve = self.plant.gas, self.plant.valve
        g = gas.isentropic_exponent
        paths, areas = self.out if opening >= 0.0 else self.back
        port = self.ports[bool(opening >= 0.0)]
        higher = np.maximum(port, pressure)
        ratio = np.minimum(port, pressure) / higher
        coefficient = np.where(
            ratio <= gas.critical_pressure_ratio,
            gas.choked_coefficient,
            gas.subsonic_factor * np.sqrt(np.abs(ratio ** (2 / g) - ratio ** ((g + 1) / g))),
        )
        across = min(abs(opening) * valve.full_voltage * 10.0, 50.0)
        row = min(int(across), 49)
        along = ratio * 100.0
        column = np.minimum(along.astype(np.int64), 99)
        along -= column
        across -= row
        cells = self.grid[
            paths[:, None, None], [[row], [row + 1]], [[0, 1]] + column[:, None, None]
        ]
        between = cells[:, :, 0] + (cells[:, :, 1] - cells[:, :, 0]) * along[:, None]
        discharge = between[:, 0] + (between[:, 1] - between[:, 0]) * across
        flow = discharge * coefficient * areas * abs(opening) * higher / math.sqrt(gas.temperature)
        return np.where(port > pressure, flow, -flow)

    def force(self, y: Array) -> float:
        plant, piston = self.plant, self.plant.piston
        return (
            y[2] * piston.area_a
            - y[3] * piston.area_b
            - plant.ambient_pressure * (piston.area_a - piston.area_b)
            + piston.mass * piston.gravity
            - piston.viscous_friction * y[1]
        )

    def surface(self, y: Array, held) -> float:
        law = self.law
        sigma = -(
            law.weight_displacement * law.sensitivity * (y[0] - held[0])
            + law.weight_velocity * law.velocity_time_constant * y[7]
            - law.weight_acceleration * law.acceleration_time_constant * y[9]
        )
        return max(-law.surface_limit, min(sigma, law.surface_limit))

    def command(self, y: Array, modes, held) -> float:
        if math.isinf(self.law.gain):
            return modes[2] * self.law.level
        return max(-self.law.level, min(self.law.gain * self.surface(y, held), self.law.level))

    def margin(self, y: Array, modes, held) -> float:
        y = y.tolist()
        piston, law, motion = self.plant.piston, self.law, modes[0]
        if abs(motion) == 1:
            ahead = piston.stroke - y[0] if motion == 1 else y[0]
            least = min(motion * y[1], ahead)
        elif motion == 0:
            least = piston.coulomb_friction - abs(self.force(y))
        else:
            least = piston.coulomb_friction + 0.5 * motion * self.force(y)
        if modes[1] == 0:
            least = min(least, 1.0 - abs(y[4]))
        elif math.isinf(law.gain):
            least = min(least, 1.0 if modes[1] == modes[2] else -1.0)
        else:
            unlimited = modes[1] * law.gain * self.surface(y, held)
            least = min(least, unlimited / self.plant.valve.full_voltage - 1.0)
        if math.isinf(law.gain):
            least = min(least, modes[2] * self.surface(y, held))
        return least
