"""Limit cycles of a sliding-mode loop: describing function, exact method, simulations."""

from pneuservo.limit_cycle.comparison import Finding, compare
from pneuservo.limit_cycle.cycle import Cycle, dominant
from pneuservo.limit_cycle.describing_function import describing_function_cycles
from pneuservo.limit_cycle.exact import exact_cycles
from pneuservo.limit_cycle.from_rig import rig_loop
from pneuservo.limit_cycle.linear_simulation import StepCourse, simulate_linear
from pneuservo.limit_cycle.loop import Loop, Signals, loop_response, loop_system
from pneuservo.limit_cycle.nonlinear_simulation import simulate_nonlinear

__all__ = [
    "Cycle",
    "Finding",
    "Loop",
    "Signals",
    "StepCourse",
    "compare",
    "describing_function_cycles",
    "dominant",
    "exact_cycles",
    "loop_response",
    "loop_system",
    "rig_loop",
    "simulate_linear",
    "simulate_nonlinear",
]
