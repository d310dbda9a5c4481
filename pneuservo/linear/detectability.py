"""Up to which frequency a converter sees the chattering of the piston."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from analog_card.linear_servo import converter_step, detectable_frequency
from pneuservo.arrays import Array
from pneuservo.linear.from_rig import table_5_2
from pneuservo.linear.models import advanced_servo, without_valve
from pneuservo.linear.servo_data import ServoData

# Where tables 9.1 and 9.2 of the thesis were evaluated, as shares of the stroke [-].
_SHARES = (0.05, 0.5, 0.95)


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
    without_valve: Mapping[str, Array]
    with_valve: Mapping[str, Array]
    threshold: float


def detectable_frequencies(
    data: ServoData | None = None, threshold: float | None = None, bits: int = 12
) -> DetectableFrequencies:
    """Return the largest switching frequencies that a converter sees, over position and direction.

    Parameters
    ----------
    data : ServoData, optional
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
    data = data or table_5_2()
    seen = converter_step(data.stroke, bits) if threshold is None else threshold
    positions = tuple(share * data.stroke for share in _SHARES)
    tables: dict[bool, dict[str, Array]] = {False: {}, True: {}}
    for valve in tables:
        for name, extending in (("extend", True), ("retract", False)):
            servos = [advanced_servo(data, position, extending) for position in positions]
            if not valve:
                servos = [without_valve(servo) for servo in servos]
            tables[valve][name] = np.array(
                [detectable_frequency(servo, data.full_voltage, seen) for servo in servos]
            )
    return DetectableFrequencies(positions, tables[False], tables[True], seen)
