"""The linear model of the single axis, and what a converter still sees of its chattering."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analog_card.linear_servo import LinearServo, converter_step, detectable_frequency
from pneuservo.errors import InputError
from pneuservo.plant.gas import ideal_gas, mass_flow_coefficient
from pneuservo.rigs import Rig, load_rig

# Table 5.2 of the thesis, right column (as corrected), where it differs from the rig's own data:
# one mean discharge coefficient and area, ambient pressure 1 bar.
TABLE_5_2 = {
    "piston.viscous_friction": 100.0,
    "load.mass": 1.82,
    "ambient.pressure": 1.0e5,
    "piston.area_a": 490.9e-6,
    "piston.area_b": 412.3e-6,
}
QUIESCENT_PRESSURES = (4.49e5, 5.57e5)
DISCHARGE_COEFFICIENT, VALVE_AREA = 0.70, 0.81e-6
# Where tables 9.1 and 9.2 of the thesis were evaluated [m].
POSITIONS = (0.0015, 0.015, 0.0285)


@dataclass(frozen=True)
class DetectableFrequencies:
    """Largest detectable switching frequencies, as tables 9.1 and 9.2 of the thesis have them.

    Attributes
    ----------
    positions : (n,) tuple
        Piston positions [m].
    without_valve, with_valve : mapping of str to (n,) array
        By direction, ``extend`` and ``retract`` [Hz].
    threshold : float
        Displacement amplitude that is just seen [m].
    """

    positions: tuple[float, ...]
    without_valve: Mapping[str, NDArray[np.float64]]
    with_valve: Mapping[str, NDArray[np.float64]]
    threshold: float


def linear_servo(
    rig: Rig,
    displacement: float,
    extending: bool,
    pressures: tuple[float, float] = QUIESCENT_PRESSURES,
    discharge_coefficient: float = DISCHARGE_COEFFICIENT,
    valve_area: float = VALVE_AREA,
) -> LinearServo:
    """Return the linear model of the single axis about a position.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    displacement : float
        Piston position, 0 to the stroke [m].
    extending : bool
        Direction of motion; it decides which paths of the valve are open.
    pressures : tuple of float, optional
        Quiescent pressures in chambers a and b, absolute [Pa].
    discharge_coefficient, valve_area : float, optional
        Of all paths, the area at full opening [-], [m^2].

    Returns
    -------
    LinearServo
        With the dynamics of the valve.

    Raises
    ------
    InputError
        When the position is outside the stroke or the rig of another kind.

    Notes
    -----
    Equations (5.26) and (5.30) to (5.34) of the thesis: small movements about steady motion, one
    area and discharge coefficient for all paths, polytropic chambers.

    Examples
    --------
    >>> from pneuservo.rigs import load_rig
    >>> servo = linear_servo(load_rig("single-axis").with_values(TABLE_5_2), 0.015, extending=True)
    >>> round(servo.a1), round(servo.b0)  # the thesis' own figures: 18421 1/s2, 1077 m/(s3 V)
    (18421, 1077)
    """
    if rig.kind != "single-axis":
        raise InputError(f"rig {rig.name} is of kind {rig.kind}; single-axis is needed here")
    stroke = rig["piston.stroke"]
    if not 0.0 <= displacement <= stroke:
        raise InputError(
            f"displacement {displacement:g} m is outside the stroke, 0 to {stroke:g} m"
        )
    gas = ideal_gas(rig["temperature"], rig["gas.constant"], rig["gas.isentropic_exponent"])
    supply, exhaust = rig["supply.pressure"], rig["ambient.pressure"]
    mass, index = rig["load.mass"], rig["chamber.polytropic_index"]
    pressure_a, pressure_b = pressures
    area_a, area_b = rig["piston.area_a"], rig["piston.area_b"]
    length_a = displacement + rig["chamber.a.dead_volume"] / area_a
    length_b = stroke - displacement + rig["chamber.b.dead_volume"] / area_b

    def through(upstream: float, downstream: float) -> float:
        return float(mass_flow_coefficient(downstream / upstream, gas)) * upstream

    if extending:
        flow_a, flow_b = through(supply, pressure_a), through(pressure_b, exhaust)
    else:
        flow_a, flow_b = through(pressure_a, exhaust), through(supply, pressure_b)
    per_volt = discharge_coefficient * valve_area / rig["valve.full_voltage"]
    inflow = index * rig["gas.constant"] * np.sqrt(rig["temperature"]) * per_volt / mass
    return LinearServo(
        b0=float(inflow * (flow_a / length_a + flow_b / length_b)),
        a1=index / mass * (pressure_a * area_a / length_a + pressure_b * area_b / length_b),
        a2=rig["piston.viscous_friction"] / mass,
        valve_frequency=rig["valve.spool.frequency"],
        valve_damping=rig["valve.spool.damping"],
    )


def detectable_frequencies(
    rig: Rig | None = None, threshold: float | None = None, bits: int = 12
) -> DetectableFrequencies:
    """Return the largest switching frequencies that a converter sees, over position and direction.

    Parameters
    ----------
    rig : Rig, optional
        By default the single axis with the data of table 5.2 of the thesis.
    threshold : float, optional
        Displacement amplitude that is just seen; half a bit of the stroke by default [m].
    bits : int, optional
        Of the converter.

    Returns
    -------
    DetectableFrequencies
        Without and with the dynamics of the valve.

    Notes
    -----
    Section 9.1.1 of the thesis. With half a bit, 3.662 um, (9.1), the results are 2.4 to 3.5 %
    above tables 9.1 and 9.2; with -108 dB, 3.98 um, within 1 %: the printed values seem to be
    read off a Bode diagram there.

    Examples
    --------
    >>> detectable_frequencies(threshold=3.98e-6).with_valve["extend"].round(0).tolist()
    [206.0, 166.0, 197.0]
    """
    rig = rig or load_rig("single-axis").with_values(TABLE_5_2)
    seen = converter_step(rig["piston.stroke"], bits) if threshold is None else threshold
    level = rig["valve.full_voltage"]
    tables: dict[bool, dict[str, NDArray[np.float64]]] = {False: {}, True: {}}
    for valve in tables:
        for name, extending in (("extend", True), ("retract", False)):
            servos = [linear_servo(rig, position, extending) for position in POSITIONS]
            if not valve:
                servos = [replace(servo, valve_frequency=float("inf")) for servo in servos]
            tables[valve][name] = np.array(
                [detectable_frequency(servo, level, seen) for servo in servos]
            )
    return DetectableFrequencies(POSITIONS, tables[False], tables[True], seen)
