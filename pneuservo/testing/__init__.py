"""Closed-loop verification under pytest: loops to run, and what to assert of them.

The fixture ``closed_loop`` is there as soon as the package is installed; everything else is
imported from here. Assertions take simulations and recordings alike.
"""

from pneuservo.testing.assertions import (
    assert_chatter_below,
    assert_control_effort_below,
    assert_no_sustained_oscillation,
    assert_overshoot_below,
    assert_settles_within,
    assert_steady_state_error_below,
)
from pneuservo.testing.loops import close_loop, closed_loops
from pneuservo.testing.robustness import assert_robust

__all__ = [
    "assert_chatter_below",
    "assert_control_effort_below",
    "assert_no_sustained_oscillation",
    "assert_overshoot_below",
    "assert_robust",
    "assert_settles_within",
    "assert_steady_state_error_below",
    "close_loop",
    "closed_loops",
]
