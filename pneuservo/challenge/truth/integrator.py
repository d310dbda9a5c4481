"""Variable steps: the embedded fifth- and fourth-order formulas of Dormand and Prince (1980)."""

import math

import numpy as np

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel
from pneuservo.challenge.truth.friction import hold_bristles
from pneuservo.challenge.truth.parameters import Array
from pneuservo.challenge.truth.servo import servo_rates
from pneuservo.challenge.truth.spool import hold_spool_in_travel

_A = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
_C = np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1])
_E = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
LARGEST_STEP = 5e-4
SMALLEST_STEP = 1e-8
MOST_STEPS = 20_000
"""Within one command; a servo that needs more cannot be run."""


def _allowed() -> Array:
    """Return the error that each state may have in one step; infinite where it does not matter."""
    allowed = np.full(at.STATES, math.inf)
    allowed[[at.POSITION, at.LOAD_POSITION, at.MODE, at.FRAME, at.LAG_1, at.LAG_2]] = 2e-9
    allowed[[at.SPEED, at.LOAD_SPEED, at.MODE_SPEED, at.FRAME_SPEED, at.FILM]] = 2e-6
    allowed[[at.SPOOL, at.AMPLIFIER]] = 1e-5
    allowed[at.SPOOL_SPEED] = 2e-2
    allowed[[at.AGE, at.SPOOL_AGE]] = 1e-2
    allowed[[at.GAS_A, at.GAS_B, at.WALL_A, at.WALL_B]] = 1e-3
    allowed[[at.PRESSURE_A, at.PRESSURE_B, at.SUPPLY, at.EXHAUST, at.LAG_A, at.LAG_B]] = 2.0
    for first in (at.HOSES, at.HOSES + 2 * at.CELLS):
        allowed[first : first + at.CELLS] = 20.0
    return allowed


_ALLOWED = _allowed()


@truth_kernel
def step_error(work, step, count):
    """Return the largest error of a state over what is allowed; infinite when undefined."""
    worst = 0.0
    for state in range(count):
        if _ALLOWED[state] == math.inf:
            continue
        error = 0.0
        for stage in range(7):
            error += _E[stage] * work[stage, state]
        share = abs(step * error) / _ALLOWED[state]
        if not share < math.inf:
            return math.inf
        worst = max(worst, share)
    return worst


@truth_kernel
def advance(start, end, share, y, kept, truth, work, trial, flows, step):
    """Advance the state from `start` to `end` [s] under one command; return the next step [s]."""
    time, tried = start, 0
    count = at.STATES if truth.network.hose_length > 0.0 else at.HOSES
    while end - time > 1e-12:
        tried += 1
        if tried > MOST_STEPS:
            y[:] = math.nan
            return LARGEST_STEP
        step = min(step, LARGEST_STEP)
        taken = min(step, end - time)
        for stage in range(7):
            for j in range(count):
                moved = 0.0
                for earlier in range(stage):
                    moved += _A[stage, earlier] * work[earlier, j]
                trial[j] = y[j] + taken * moved
            servo_rates(
                time + _C[stage] * taken, share, trial, kept, truth, work[stage, :count], flows
            )
        error = step_error(work, taken, count)
        if error == math.inf:
            if taken <= SMALLEST_STEP:
                y[:] = math.nan
                return step
            error = 1e3
        if error > 1.0 and taken > SMALLEST_STEP:
            step = max(taken * max(0.9 * error**-0.2, 0.1), SMALLEST_STEP)
            continue
        time += taken
        # The last stage stands at the end of the step.
        for j in range(count):
            y[j] = trial[j]
        hold_spool_in_travel(truth.spool, y)
        hold_bristles(y)
        grown = taken * min(0.9 * (error + 1e-6) ** -0.2, 4.0)
        # A step cut short by the end says nothing against longer ones.
        step = max(step, grown) if taken < step else grown
    return max(step, SMALLEST_STEP)
