"""Pressures in the chambers of a piston in steady motion, from area ratio and load."""

from dataclasses import replace

from scipy.optimize import brentq

from pneuservo.errors import InputError
from pneuservo.linear.servo_data import ServoData
from pneuservo.plant.gas import mass_flow_coefficient


def quiescent_pressures(data: ServoData, extending: bool) -> tuple[float, float]:
    """Return the pressures in chambers a and b of a piston in slow steady motion.

    Parameters
    ----------
    data : ServoData
        The servo; its own quiescent pressures are not used.
    extending : bool
        Direction of the motion.

    Returns
    -------
    pressure_a, pressure_b : float
        Absolute [Pa].

    Raises
    ------
    InputError
        When the load asks for a pressure below that of the exhaust.

    Notes
    -----
    Equations (5.35) to (5.41) of the thesis: choked discharge, one temperature, forces of friction
    neglected. What flows into the charged chamber and out of the other belongs to one velocity,
    Cm(p)/Cm* = p (charged area/discharged area)(discharge/charge) with p = pressure/supply
    pressure, where the charge may also be choked; the other pressure balances the load, with the
    atmosphere on the rod. For equal effective areas this is the closed form (5.37). Printed for
    an atmosphere of 1.013 bar: 4.85 and 6.00 bar.

    Examples
    --------
    >>> from pneuservo.linear import table_5_2
    >>> [round(p / 1e5, 2) for p in quiescent_pressures(table_5_2(), extending=True)]
    [4.85, 6.02]
    """
    flow, net = data.flow_areas, data.load - data.exhaust_pressure * (data.area_a - data.area_b)
    if extending:
        charged, other = data.area_a, data.area_b
        ratio = charged / other * flow.b_to_exhaust / flow.supply_to_a
    else:
        charged, other = data.area_b, data.area_a
        ratio = charged / other * flow.a_to_exhaust / flow.supply_to_b
        net = -net
    driving = _charged_pressure_ratio(ratio, data) * data.supply_pressure
    opposing = (driving * charged + net) / other
    if opposing < data.exhaust_pressure:
        raise InputError(
            f"the load leaves {opposing:.4g} Pa in the chamber that is discharged, less than the "
            f"{data.exhaust_pressure:.4g} Pa of the exhaust; there is no steady motion. Give a "
            "smaller load or a higher supply pressure"
        )
    return (driving, opposing) if extending else (opposing, driving)


def at_quiescent_pressures(data: ServoData, extending: bool) -> ServoData:
    """Return the same servo at the quiescent pressures of one direction of motion.

    Parameters
    ----------
    data : ServoData
        The servo.
    extending : bool
        The direction.

    Examples
    --------
    >>> from pneuservo.linear import table_5_2
    >>> round(at_quiescent_pressures(table_5_2(), extending=True).pressure_a / 1e5, 2)
    4.85
    """
    pressure_a, pressure_b = quiescent_pressures(data, extending)
    return replace(data, pressure_a=pressure_a, pressure_b=pressure_b)


def _charged_pressure_ratio(ratio: float, data: ServoData) -> float:
    """Return where Cm(p)/Cm* = ratio p; the left side falls from 1 to 0 as p goes to 1."""

    def excess(p: float) -> float:
        return float(mass_flow_coefficient(p, data.gas)) / data.gas.choked_coefficient - ratio * p

    return float(brentq(excess, 1e-6, 1.0, xtol=1e-14))
