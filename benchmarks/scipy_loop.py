"""A closed loop under scipy's LSODA, stopped at every event and started again behind it."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.compiled_plant import CompiledPlant
from benchmarks.problem import course
from pneuservo.plant import integrator

# What absolute tolerances refer to: displacement, velocity, pressures, spool and its rate, card.
SCALES = np.array([1e-2, 0.1, 1e5, 1e5, 1.0, 1e3, 1.0, 1e2, 1.0, 1e3])
# How far beyond an event the state is carried, so that its margin is surely negative [s].
BEYOND = 1e-10


def scipy_displacement(
    plant: CompiledPlant, duration: float, tolerance: float
) -> NDArray[np.float64]:
    """Return the displacement at every time of the course [m]."""
    time, demand = course(duration)
    state = plant.start.copy()
    modes = integrator.initial_modes(state, np.array([demand[0], 0.0]), plant.plant)
    bounds = [0, *(np.flatnonzero(np.diff(demand) != 0.0) + 1), len(time) - 1]
    found = [state[:1].copy()]
    for first, last in pairwise(bounds):
        held = np.array([demand[first], 0.0])
        found += _hold(plant, state, modes, held, time[first : last + 1], tolerance)
    return np.concatenate(found)


def _hold(plant, state, modes, held, time, tolerance):
    def crossing(_, y):
        return plant.margin(y, modes, held)

    crossing.terminal, crossing.direction = True, -1.0
    found, reached = [], time[0]
    while time[-1] - reached > 2.0 * BEYOND:
        plant.settle(state, modes, held)
        solved = solve_ivp(
            lambda _, y: plant.rate(y, modes, held),
            (reached, time[-1]),
            state,
            method="LSODA",
            rtol=tolerance,
            atol=tolerance * SCALES,
            t_eval=time[time > reached],
            events=crossing,
        )
        if len(solved.t):
            found.append(solved.y[0])
        if solved.status == 1:
            there = solved.y_events[0][0]
            state[:] = there + BEYOND * plant.rate(there, modes, held)
            reached = solved.t_events[0][0] + BEYOND
        else:
            state[:] = solved.y[:, -1]
            reached = time[-1]
    return found
