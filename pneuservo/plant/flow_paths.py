"""The flow paths of a servo valve, and how well each lets air through."""

from dataclasses import dataclass

from pneuservo.arrays import Array

FLOW_PATHS = ("s_a", "b_e", "s_b", "a_e")
"""Supply, exhaust, chamber a, chamber b; in the order of the kernels."""


@dataclass(frozen=True)
class FlowPathTable:
    """Discharge coefficient of one flow path over command and pressure ratio.

    Parameters
    ----------
    command : (n,) array
        Magnitude of the command, increasing [V].
    pressure_ratio : (n, 5) array
        Break points of each row, downstream over upstream pressure [-].
    discharge_coefficient : (n, 5) array
        Coefficient at the break points; linear between them [-].
    """

    command: Array
    pressure_ratio: Array
    discharge_coefficient: Array
