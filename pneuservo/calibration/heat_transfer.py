"""What a fixed polytropic index does to a calibration when the gas exchanges heat with the wall."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.calibration.experiment import CONDITIONS
from pneuservo.calibration.flow_curve import flow_curve
from pneuservo.calibration.transient import Transient
from pneuservo.plant.gas import orifice_mass_flow
from pneuservo.rigs import Rig, load_rig

# A metal bottle of the experiment's volume, as long as it is wide, and still to gently stirred air
# inside: 20 W/(m^2 K), the lower end of what is reported for pneumatic chambers.
_FILM_COEFFICIENT = 20.0
WALL_CONDUCTANCE = _FILM_COEFFICIENT * 6.0 * np.pi / 4.0 * (4.0 * 120e-6 / np.pi) ** (2.0 / 3.0)
# Steel wool: some hundred times the surface, so that the gas stays at the temperature of the wall.
STEEL_WOOL_CONDUCTANCE = 300.0 * WALL_CONDUCTANCE
_SAMPLES = 3000
_SETTLED = 1e-3


@dataclass(frozen=True)
class ApparentCoefficient:
    """What (4.34) finds when the truth exchanges heat.

    Parameters
    ----------
    path : str
        Flow path.
    opening : float
        Fraction of full opening [-].
    duration : float
        Until 99 % of the pressure change is done [s].
    pressure_ratio : (n,) array
        Downstream over upstream pressure [-].
    ratio : (n,) array
        Discharge coefficient that is found over the true one [-].
    """

    path: str
    opening: float
    duration: float
    pressure_ratio: Array
    ratio: Array

    @property
    def lowest(self) -> float:
        """Return the smallest ratio [-]."""
        return float(np.min(self.ratio))

    @property
    def choked(self) -> float:
        """Return the ratio while the flow is choked, the median over its part [-]."""
        return float(np.median(self.ratio[self.pressure_ratio < _CHOKED]))


_CHOKED = 0.528


def transient_with_heat(
    path: str,
    opening: float,
    wall_conductance: float = WALL_CONDUCTANCE,
    discharge_coefficient: float = 0.8,
    rig: Rig | None = None,
) -> Transient:
    """Return a charge or discharge in which the gas exchanges heat with the wall.

    Parameters
    ----------
    path : str
        Flow path, one of `pneuservo.plant.flow_paths.FLOW_PATHS`.
    opening : float
        Fraction of full opening, above 0 [-].
    wall_conductance : float, optional
        Film coefficient times surface; 0 is adiabatic [W/K].
    discharge_coefficient : float, optional
        The true one, the same at every pressure ratio [-].
    rig : Rig, optional
        Of kind ``dead-volume``; by default the built-in one in the conditions of the experiment.

    Returns
    -------
    Transient
        Without noise.

    Notes
    -----
    Mass and energy balance of the gas, equations (4.1) to (4.10) of the thesis, with heat flow
    (4.7) to a wall that stays at room temperature; upstream temperature of a discharge is that of
    the gas. Solved by an implicit method of variable order (LSODA).

    Examples
    --------
    >>> t = transient_with_heat("s_a", 1.0)
    >>> bool(t.pressure[0] < 1.1e5 < 7.5e5 < t.pressure[-1])
    True
    """
    rig = rig or load_rig("dead-volume").with_conditions(dict(CONDITIONS))
    charging = path.startswith("s_")
    begin = rig["ambient.pressure"] if charging else rig["supply.pressure"]
    span = rig["supply.pressure"] - rig["ambient.pressure"]
    area = opening * rig[f"valve.flow.area_{path}"] * discharge_coefficient
    balance = _Balance(rig, charging, area, wall_conductance)
    # From the choked flow at first; extended until the pressure hardly moves any more.
    rate = abs(balance(0.0, np.array([begin, rig["temperature"]]))[0])
    duration = 4.0 * span / rate
    while True:
        time = np.linspace(0.0, duration, _SAMPLES)
        pressure = balance.solve(time, begin)
        moved = abs(pressure[-1] - pressure[3 * _SAMPLES // 4])
        if moved < _SETTLED * span:
            break
        duration *= 1.5
    return Transient(
        f"{path}, opening {opening:g}",
        path,
        opening * rig["valve.full_voltage"],
        time,
        pressure,
        1e-6 * begin,
        rig,
    )


class _Balance:
    """Rates of pressure and temperature of the gas in the volume."""

    def __init__(self, rig: Rig, charging: bool, area: float, conductance: float):
        self.rig, self.charging, self.area, self.conductance = rig, charging, area, conductance

    def __call__(self, _: float, state: Array) -> Array:
        rig = self.rig
        pressure, temperature = state
        wall, volume = rig["temperature"], rig["dead-volume.volume"]
        gas_constant, exponent = rig["gas.constant"], rig["gas.isentropic_exponent"]
        upstream, downstream, warm = (
            (rig["supply.pressure"], pressure, wall)
            if self.charging
            else (pressure, rig["ambient.pressure"], temperature)
        )
        flow = orifice_mass_flow(upstream, downstream, self.area, 1.0, warm, gas_constant, exponent)
        into = flow if self.charging else -flow
        heat = self.conductance * (wall - temperature)
        rate = (exponent * gas_constant * into * warm + (exponent - 1.0) * heat) / volume
        # From p V = m R T.
        warming = temperature * (
            rate / pressure - into * gas_constant * temperature / (pressure * volume)
        )
        return np.array([rate, warming])

    def solve(self, time: Array, begin: float) -> Array:
        from scipy.integrate import solve_ivp

        found = solve_ivp(
            self,
            (0.0, time[-1]),
            [begin, self.rig["temperature"]],
            method="LSODA",
            t_eval=time,
            rtol=1e-8,
            atol=[1e-2, 1e-6],
        )
        pressure: Array = found.y[0]
        return pressure


def apparent_coefficient(
    path: str,
    opening: float,
    polytropic_index: float = 1.4,
    wall_conductance: float = WALL_CONDUCTANCE,
) -> ApparentCoefficient:
    """Return what (4.34) finds with a fixed index when the truth exchanges heat.

    Parameters
    ----------
    path, opening, wall_conductance
        As in `transient_with_heat`.
    polytropic_index : float, optional
        That is assumed: 1.4 in the thesis, 1 for a chamber filled with steel wool [-].

    Returns
    -------
    ApparentCoefficient
        Over pressure ratio.

    Examples
    --------
    A slow charge is nearly isothermal, and 1.4 then leaves 1/1.4 of the coefficient:

    >>> round(apparent_coefficient("s_a", 0.02).choked, 2)
    0.73
    """
    true = 0.8
    transient = transient_with_heat(path, opening, wall_conductance, true)
    curve = flow_curve(transient, polytropic_index)
    change = np.abs(transient.pressure - transient.pressure[0])
    done = int(np.argmax(change > 0.99 * change[-1]))
    return ApparentCoefficient(
        path,
        opening,
        float(transient.time[done]),
        curve.pressure_ratio,
        curve.coefficient / true,
    )


def heat_transfer_study(
    openings: Sequence[float] = (1.0, 0.2, 0.08, 0.02),
    paths: Sequence[str] = ("s_a", "a_e"),
    polytropic_index: float = 1.4,
    wall_conductance: float = WALL_CONDUCTANCE,
) -> list[ApparentCoefficient]:
    """Return what a fixed index does at every opening.

    Parameters
    ----------
    openings : sequence of float, optional
        Fractions of full opening [-].
    paths : sequence of str, optional
        A charging and a discharging one.
    polytropic_index, wall_conductance
        As in `apparent_coefficient`.

    Returns
    -------
    list of ApparentCoefficient
        By path and then opening.
    """
    return [
        apparent_coefficient(path, opening, polytropic_index, wall_conductance)
        for path in paths
        for opening in openings
    ]
