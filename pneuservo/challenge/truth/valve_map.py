"""The valve's calibration as one map: discharge coefficient times expansion factor."""

import numpy as np

from pneuservo.challenge.truth.parameters import Array
from pneuservo.rigs import FLOW_PATHS, load_valve_tables

RATIOS = 1025
"""Pressure ratios of the map, evenly spaced from 0 to 1."""
ISENTROPIC_EXPONENT = 1.4


def expansion_factor(ratio: Array) -> Array:
    """Return the expansion factor of an ideal nozzle.

    Parameters
    ----------
    ratio : (n,) array
        Downstream over upstream pressure, 0 to 1 [-].

    Returns
    -------
    (n,) array
        Flow over that of an incompressible fluid of the upstream density [-].

    Notes
    -----
    m = Cd Y A sqrt(2 rho (pu - pd)); Y from the energy equation of a perfect gas, choked flow
    included (Blackburn, Reethof and Shearer 1960, Fluid Power Control).

    Examples
    --------
    >>> import numpy as np
    >>> expansion_factor(np.array([1.0]))
    array([1.])
    """
    g = ISENTROPIC_EXPONENT
    critical = (2.0 / (g + 1.0)) ** (g / (g - 1.0))
    throat = np.maximum(ratio, critical)
    drop = np.maximum(1.0 - ratio, 1e-12)
    squared = g / (g - 1.0) * throat ** (2.0 / g) * (1.0 - throat ** ((g - 1.0) / g)) / drop
    return np.where(ratio > 1.0 - 1e-9, 1.0, np.sqrt(squared))


def valve_map(name: str) -> tuple[Array, Array]:
    """Return the map of a built-in valve.

    Parameters
    ----------
    name : str
        Name of the valve.

    Returns
    -------
    coefficient : (4, rows, RATIOS) array
        Discharge coefficient times expansion factor; paths in the order of `FLOW_PATHS` [-].
    rows : (rows,) array
        Commands of the rows, the same for all paths [V].
    """
    ratio = np.linspace(0.0, 1.0, RATIOS)
    factor = expansion_factor(ratio)
    tables = [load_valve_tables(name)[path] for path in FLOW_PATHS]
    coefficient = [
        [
            np.interp(ratio, breaks, values) * factor
            for breaks, values in zip(
                table.pressure_ratio, table.discharge_coefficient, strict=True
            )
        ]
        for table in tables
    ]
    return np.ascontiguousarray(coefficient), tables[0].command.astype(float)
