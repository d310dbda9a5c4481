"""What differs from recording to recording though the servo is the same."""

import numpy as np

from pneuservo.diagnosis.models.model import Case, Unknown
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.measured_spool import (
    GAIN_SPREAD,
    SPOOL_GAIN,
    SPOOL_ZERO,
    ZERO_SPREAD,
)
from pneuservo.diagnosis.models.servo.noisy_command import COMMAND_BENDS
from pneuservo.diagnosis.models.servo.run_observer import (
    COMMAND_DELAY,
    REVERSAL,
    SUPPLY_LEVEL,
    ZERO_FORCE,
)

_REVERSALS = (0.2, 20.0)
"""Limits of the speed over which friction turns round, in resolutions of the velocity."""
_REVERSAL_SPREAD = 1.0
"""How well it is known."""
_CONVERSION_SPREAD = 2e-5
"""How long converters take to put out a command [s], as a rule ..."""
_LONGEST_CONVERSION = 1e-4
"""... and at the most, and no longer than half a sampling interval."""
_BEND_SPREAD = 0.1
"""What a command of noise goes on by in an interval, as a share of how it bends."""


def nuisances_of(case: Case, fitted: bool) -> list[Unknown]:
    """Return the unknowns of one recording alone.

    Parameters
    ----------
    case : Case
        One of its channels; the first has what holds for all.
    fitted : bool
        Whether what is known beforehand may be off: the force that the drifting zeros of the
        pressure transducers pretend, as large as their noise; the speed over which friction turns
        round, for the velocity is smoothed, and real friction gives way by some micrometres before
        it slips; how long a computer takes to put out its command; and what a command that is full
        of its loop's own noise does between samples.

    Notes
    -----
    The pressure of a source that was measured is fitted, and zero and gain of a spool's transducer.
    What a filter starts from is forgotten.
    """
    fed: Feed = case.inputs["feed"]
    found: list[Unknown] = []
    if fitted and case.inputs["leads"] and fed.spread_of_force:
        found.append(Unknown(ZERO_FORCE, 0.0, -np.inf, np.inf, fed.spread_of_force, "N"))
    if fitted and case.channel == "displacement":
        found.append(Unknown(REVERSAL, 1.0, *_REVERSALS, _REVERSAL_SPREAD, ""))
    if fitted and case.inputs["leads"] and fed.converted:
        longest = min(_LONGEST_CONVERSION, 0.5 * fed.interval)
        found.append(Unknown(COMMAND_DELAY, 0.0, 0.0, longest, _CONVERSION_SPREAD, "s"))
    if fitted and case.inputs["leads"] and len(fed.bends):
        for name in COMMAND_BENDS:
            found.append(Unknown(name, 0.0, -np.inf, np.inf, _BEND_SPREAD, ""))
    if case.inputs["leads"] and fed.supply is not None:
        level = float(np.mean(fed.supply))
        found.append(Unknown(SUPPLY_LEVEL, level, 0.5 * level, 2.0 * level, None, "Pa"))
    if case.inputs["leads"] and len(fed.spool_reading):
        found.append(Unknown(SPOOL_ZERO, 0.0, -np.inf, np.inf, ZERO_SPREAD))
        found.append(Unknown(SPOOL_GAIN, 1.0, 0.0, np.inf, GAIN_SPREAD))
    return found
