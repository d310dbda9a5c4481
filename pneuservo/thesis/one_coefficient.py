"""The non-linear plant with what the linear models assume: one coefficient for every path."""

import numpy as np

from pneuservo.arrays import Array
from pneuservo.linear import TABLE_5_2
from pneuservo.rigs import Rig, load_rig, plant_numbers


def rig_with_one_coefficient(
    discharge_coefficient: float, flow_area: float, coulomb_friction: float = 0.0
) -> tuple[Rig, Array]:
    """Return the rig of table 5.2, and its discharge coefficients as the kernels take them.

    Parameters
    ----------
    discharge_coefficient : float
        Of every path, at every opening and pressure ratio [-].
    flow_area : float
        Of every path at full opening [m^2].
    coulomb_friction : float, optional
        [N].

    Returns
    -------
    rig : Rig
        The rig.
    grid : (4, 51, 101) array
        See `pneuservo.plant.valve.discharge_grid`.
    """
    rig = load_rig("single-axis")
    areas = {key: flow_area for key in rig.parameters if key.startswith("valve.flow.")}
    rig = rig.with_values({**TABLE_5_2, **areas, "piston.coulomb_friction": coulomb_friction})
    return rig, np.full_like(plant_numbers.valve_grid(rig.valve), discharge_coefficient)
