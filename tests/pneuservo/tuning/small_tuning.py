"""A small tuning that tests share: 96 settings in four rigs, some 5 ms each."""

from functools import cache

from pneuservo.tuning.problem import tuning_problem
from pneuservo.tuning.run import run_tuning
from pneuservo.tuning.search import Search

ARGUMENTS = (
    *("--vary", "supply.pressure=6.5, 7.7 bar", "--vary", "load.mass=1.825, 11.825 kg"),
    *("--demand", "15,24,6 mm", "--rate", "1 kHz", "--seed", "3"),
    *("--population", "16", "--generations", "6", "--check", "4"),
)
PLAN = Search(16, 6, 3)


@cache
def small_problem():
    """Return what these options describe."""
    vary = {"supply.pressure": "6.5, 7.7 bar", "load.mass": "1.825, 11.825 kg"}
    return tuning_problem({"vary": vary, "demand": "15,24,6 mm", "rate": "1 kHz", "seed": 3})


@cache
def small_tuning():
    """Return what it gives in one process, nothing kept."""
    return run_tuning(small_problem(), PLAN, trials=4)
