"""What the transducers say, before noise and conversion."""

import math

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel

# Below this a lag is a shift in time: its own equation would only slow the integration [s].
SHORT_LAG = 1e-4


@truth_kernel
def read_position(time, y, kept, sensors, stroke):
    """Return the displacement that is read [m]; the wiper's slack is kept."""
    x = y[at.POSITION]
    if 0.0 < sensors.position_lag < SHORT_LAG:
        x -= sensors.position_lag * y[at.SPEED]
    elif sensors.position_lag > 0.0:
        x = y[at.LAG_1] if sensors.position_lag_order == 1.0 else y[at.LAG_2]
    if sensors.position_slack > 0.0:
        held = kept[at.WIPER]
        held = min(max(held, x - sensors.position_slack), x + sensors.position_slack)
        kept[at.WIPER] = held
        x = held
    part = min(max(x / stroke, 0.0), 1.0)
    error = sensors.position_bow * math.sin(math.pi * part)
    # Largest value of part (1 - part)(2 part - 1) is 0.0962.
    error += sensors.position_load * part * (1.0 - part) * (2.0 * part - 1.0) / 0.0962
    gain = sensors.position_gain * (1.0 + sensors.reference_drift * time)
    return gain * (x + error) + sensors.position_offset


@truth_kernel
def missed_pressure(flow, pressure, sensors, network):
    """Return the dynamic pressure in the pipe that a static tap does not read [Pa]."""
    area = 0.25 * math.pi * sensors.pipe_bore**2
    density = pressure / (network.gas_constant * network.temperature)
    return sensors.dynamic_pressure * 0.5 * flow * flow / (density * area * area)


@truth_kernel
def read_pressures(time, y, rates, flows, volts, sensors, network):
    """Return the two chamber pressures that are read [Pa], at a command in V."""
    p_a, p_b = y[at.PRESSURE_A], y[at.PRESSURE_B]
    if 0.0 < sensors.pressure_lag < SHORT_LAG:
        p_a -= sensors.pressure_lag * rates[at.PRESSURE_A]
        p_b -= sensors.pressure_lag * rates[at.PRESSURE_B]
    elif sensors.pressure_lag > 0.0:
        p_a, p_b = y[at.LAG_A], y[at.LAG_B]
    if sensors.dynamic_pressure > 0.0:
        p_a -= missed_pressure(flows[0], p_a, sensors, network)
        p_b -= missed_pressure(flows[1], p_b, sensors, network)
    p_a += sensors.folded * math.sin(2.0 * math.pi * sensors.folded_frequency * time)
    by_coil = sensors.shift_by_coil * y[at.SPOOL]
    return (
        sensors.pressure_gain_a * p_a + sensors.pressure_offset_a + by_coil,
        sensors.pressure_gain_b * p_b
        + sensors.pressure_offset_b
        + by_coil
        + sensors.shift_by_command * volts,
    )
