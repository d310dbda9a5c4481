"""The discharge coefficient along a transient, straight from the rate of the pressure."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.calibration.transient import Transient, in_flow
from pneuservo.errors import InputError
from pneuservo.intervals import INTERVAL
from pneuservo.plant.gas import mass_flow_coefficient
from pneuservo.rigs.plant_numbers import dead_volume

_FEWEST = 8
_BINS = 40
# A step has to change the pressure by so many times the noise for its slope to mean something.
_CLEAR = 6.0


@dataclass(frozen=True)
class FlowCurve:
    """Discharge coefficient over pressure ratio.

    Parameters
    ----------
    pressure_ratio : (n,) array
        Downstream over upstream pressure [-].
    coefficient : (n,) array
        Discharge coefficient; of a leak the effective area [m^2].
    half_width : (n,) array
        Half width of the 95 % interval [same].
    """

    pressure_ratio: Array
    coefficient: Array
    half_width: Array


def discharge_coefficient_from_rate(
    rate: Array,
    pressure: Array,
    transient: Transient,
    polytropic_index: float,
) -> Array:
    """Return the discharge coefficient that explains a rate of the pressure [-].

    Parameters
    ----------
    rate : (n,) array
        Rate of the pressure in the dead volume; its magnitude counts [Pa/s].
    pressure : (n,) array
        Absolute pressure there [Pa].
    transient : Transient
        For volume, gas, open area and the pressures at the other end.
    polytropic_index : float
        That is assumed: 1.4 in the thesis, 1 for a chamber filled with steel wool [-].

    Notes
    -----
    Equation (4.34): Cd = V |p'| / (n R sqrt(Tu) Cm(Pr) Av k |u| pu). Constant upstream
    temperature, ideal gas, one polytropic index.
    """
    rig = transient.rig
    gas = dead_volume(rig).gas
    ratio = transient.pressure_ratio(pressure)
    per_area = np.array([mass_flow_coefficient(r, gas) for r in ratio])
    flow = (
        rig["dead-volume.volume"]
        * np.abs(rate)
        / (polytropic_index * gas.gas_constant * np.sqrt(gas.temperature))
    )
    coefficient: Array = flow / (per_area * transient.area * transient.upstream(pressure))
    return coefficient


def flow_curve(
    transient: Transient, polytropic_index: float | None = None, bins: int = _BINS
) -> FlowCurve:
    """Return the discharge coefficient along a transient.

    Parameters
    ----------
    transient : Transient
        The charge or discharge.
    polytropic_index : float, optional
        That is assumed; the rig's by default [-].
    bins : int, optional
        Into how many equal steps of pressure ratio the transient is cut; each becomes one point.

    Returns
    -------
    FlowCurve
        By falling or rising pressure ratio, as the transient goes.

    Raises
    ------
    InputError
        When too few samples flow.

    Notes
    -----
    Equation (4.34) with the rate from a parabola through each step's samples. The interval is that
    of the slope under white noise of the transducer; it does not hold what n and the constant
    temperature leave out.

    Examples
    --------
    >>> from pneuservo.calibration import simulate_transient, transient_of
    >>> curve = flow_curve(transient_of(simulate_transient("s_a", 5.0)))
    >>> bool(abs(curve.coefficient[0] - 0.80) < 3 * curve.half_width[0])
    True
    """
    if polytropic_index is None:
        polytropic_index = transient.rig["dead-volume.polytropic_index"]
    flowing = np.flatnonzero(in_flow(transient))
    if len(flowing) < 2 * _FEWEST:
        raise InputError(
            f"{transient.name}: {len(flowing)} samples flow before the pressures are equal; "
            f"at least {2 * _FEWEST} are needed. Sample faster, or state supply and ambient "
            "pressure under [conditions]"
        )
    time, pressure = transient.time[flowing], transient.pressure[flowing]
    ratio = transient.pressure_ratio(pressure)
    noise = transient.noise_rms * float(np.max(ratio / pressure))
    rows = [
        _slope(time[part], pressure[part], transient.noise_rms)
        for part in _cut(ratio, bins, _CLEAR * noise)
    ]
    at, rate, error = (np.array(column) for column in zip(*rows, strict=True))
    coefficient = discharge_coefficient_from_rate(rate, at, transient, polytropic_index)
    spread = discharge_coefficient_from_rate(error, at, transient, polytropic_index)
    forward = 1.0 if transient.charging else -1.0
    signed = np.where(np.sign(rate) == forward, coefficient, -coefficient)
    return FlowCurve(transient.pressure_ratio(at), signed, INTERVAL * spread)


def _cut(ratio: Array, bins: int, least: float) -> list[slice]:
    """Return consecutive samples of about equal change of the pressure ratio.

    None has too few samples, or a change of less than `least`.
    """
    from scipy.ndimage import uniform_filter1d

    smooth = uniform_filter1d(ratio, _FEWEST)
    travelled = np.abs(smooth - smooth[0])
    step = max(float(travelled.max()) / bins, least)
    parts, first = [], 0
    for k in range(len(ratio)):
        if k - first + 1 >= _FEWEST and travelled[k] - travelled[first] >= step:
            parts.append(slice(first, k + 1))
            first = k + 1
    # What is left is too little for a step of its own.
    last = parts.pop().start if parts else 0
    return [*parts, slice(last, len(ratio))]


def _slope(time: Array, pressure: Array, noise_rms: float) -> tuple[float, float, float]:
    """Return pressure, rate and its standard error in the middle of a few samples."""
    middle = 0.5 * (time[0] + time[-1])
    scale = max(0.5 * (time[-1] - time[0]), 1e-12)
    s = (time - middle) / scale
    columns = np.column_stack((np.ones_like(s), s, s * s))
    solution = np.linalg.lstsq(columns, pressure, rcond=None)[0]
    covariance = np.linalg.inv(columns.T @ columns)
    return (
        float(solution[0]),
        float(solution[1]) / scale,
        noise_rms * float(np.sqrt(covariance[1, 1])) / scale,
    )
