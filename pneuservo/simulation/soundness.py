"""What a run gave, checked: a state that broke down is no result."""

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError
from pneuservo.plant.outputs import PRESSURE_A_OUT, PRESSURE_B_OUT
from pneuservo.plant.single_axis import PLANT_STATES


class BrokenRunError(InputError):
    """The state of a run is not finite, or a pressure not positive."""


def require_finite(times: Array, finite: Mask) -> None:
    """Refuse a run whose state is not finite, or a pressure not positive, at some time.

    Parameters
    ----------
    times : (n,) array
        [s].
    finite : (n,) array of bool
        Where all is well.

    Raises
    ------
    BrokenRunError
        When it is not well everywhere.
    """
    if not finite.all():
        k = int(np.argmin(finite))
        raise BrokenRunError(
            f"the simulated state stops being finite, or a pressure positive, at t = {times[k]:g} "
            "s: the parameters make the rig faster than the integration step; check them, or give "
            "a smaller largest_step"
        )


def require_sound(times: Array, outputs: Array) -> None:
    """Refuse the outputs of a run whose state is not finite, or whose pressures not positive.

    Parameters
    ----------
    times : (n,) array
        [s].
    outputs : (n, 10) array
        By `pneuservo.plant.outputs.OUTPUTS`, in SI.
    """
    pressures = outputs[:, [PRESSURE_A_OUT, PRESSURE_B_OUT]]
    states = outputs[:, :PLANT_STATES]
    require_finite(times, np.all(np.isfinite(states), axis=1) & np.all(pressures > 0.0, axis=1))
