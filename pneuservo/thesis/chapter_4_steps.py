"""Step responses under proportional control, section 4.3.3 of the thesis."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from pneuservo.calibration.validation import UNCALIBRATED_VALVE
from pneuservo.controllers import Proportional
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import Simulation, simulate, step_demand
from pneuservo.thesis.chapter_4_stated import stated

# Table 4.8 gives the valve a damping ratio of 1 and samples at 1 kHz.
_DAMPING, _RATE, _HOLD = 1.0, 1000.0, 1.0
_LATE = 0.3


@dataclass(frozen=True)
class StepRun:
    """A run through the set points under proportional control.

    Parameters
    ----------
    gain : float
        [V/V].
    run : Simulation
        The run.
    """

    gain: float
    run: Simulation

    def late(self) -> list[tuple[float, float]]:
        """Return peak-to-peak and mean error at the end of every hold [m]."""
        x, demand = self.run["displacement"], self.run["demand"]
        hold, last = round(_HOLD * _RATE), round(_LATE * _RATE)
        found = []
        for end in range(hold, len(x) + 1, hold):
            part = slice(end - last, end)
            found.append((float(np.ptp(x[part])), float(np.mean(demand[part] - x[part]))))
        return found

    def frequency(self) -> float:
        """Return how often the piston crosses its mean at the end of the last hold at mid [Hz]."""
        hold, last = round(_HOLD * _RATE), round(_LATE * _RATE)
        part = self.run["displacement"][5 * hold - last : 5 * hold]
        swing = part - np.mean(part)
        return float(np.sum(np.diff(np.sign(swing)) > 0.0)) / _LATE


def step_rig(calibrated: bool = True, rig: Rig | None = None) -> Rig:
    """Return the rig of section 4.3.3: tables 4.7 and 4.8.

    Parameters
    ----------
    calibrated : bool, optional
        With tables 4.2 to 4.5, or with the nominal coefficient of 0.8.
    rig : Rig, optional
        Instead of the built-in one.
    """
    rig = (rig or load_rig("single-axis")).with_values({"valve.spool.damping": _DAMPING})
    return rig if calibrated else replace(rig, valve=UNCALIBRATED_VALVE)


@cache
def step_run(gain: float, calibrated: bool = True, viscous_friction: float = 0.0) -> StepRun:
    """Run through the set points 15, 24, 15, 6, 15 and 24 mm.

    Parameters
    ----------
    gain : float
        Of the controller [V/V].
    calibrated : bool, optional
        With tables 4.2 to 4.5, or with the nominal coefficient of 0.8.
    viscous_friction : float, optional
        Instead of table 4.7's; 0 leaves it [N s/m].
    """
    rig = step_rig(calibrated)
    if viscous_friction:
        rig = rig.with_values({"piston.viscous_friction": viscous_friction})
    time, demand = step_demand(stated()["steps"]["set_points"], _HOLD, _RATE)
    return StepRun(gain, simulate(rig, time=time, controller=Proportional(gain), demand=demand))
