"""The same compiled equations under scipy's LSODA, restarted at every event."""

from itertools import pairwise

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from pneuservo.controllers import SlidingMode
from pneuservo.plant import from_rig
from pneuservo.plant.events import margin, settle
from pneuservo.plant.integrator import runge_kutta_step
from pneuservo.plant.piston import motion_from
from pneuservo.plant.single_axis import derivative, piston_force
from pneuservo.rigs import Rig
from pneuservo.simulation import InitialState

# Displacement, velocity, both pressures, spool and its rate: what absolute tolerances refer to.
SCALES = np.array([1e-2, 0.1, 1e5, 1e5, 1.0, 1e3])
# How far beyond an event the state is carried, so that its margin is surely negative [s].
BEYOND = 1e-9


class ScipyLoop:
    """A closed loop on the single axis.

    The rig's numbers are compiled into the functions that scipy calls: handing them over in every
    call would take several times longer than the equations.
    """

    def __init__(self, rig: Rig, controller: SlidingMode, start: InitialState):
        plant, law = from_rig.single_axis(rig), controller.law(rig)
        grid = from_rig.valve_grid(rig.valve)
        self.start = start.state(plant, 0.0, 0.0)
        self.first_motion = motion_from(
            self.start[0],
            self.start[1],
            piston_force(self.start, np.zeros(2), plant),
            plant.piston,
        )

        @numba.njit
        def rate(y, modes, held):
            out = np.empty_like(y)
            derivative(y, modes, held, law, plant, grid, out)
            return out

        @numba.njit
        def event(y, modes, held):
            return margin(y, modes, held, law, plant)

        @numba.njit
        def pass_event(y, modes, held):
            out = np.empty_like(y)
            work = np.empty((3, y.shape[0]))
            runge_kutta_step(y, BEYOND, modes, held, law, plant, grid, work, out)
            return out

        @numba.njit
        def settle_modes(y, modes, held):
            settle(y, modes, held, law, plant)

        self.rate, self.event = rate, event
        self.pass_event, self.settle_modes = pass_event, settle_modes

    def displacement(
        self, time: NDArray[np.float64], demand: NDArray[np.float64], tolerance: float
    ) -> NDArray[np.float64]:
        """Return the displacement at every time [m]."""
        state, modes = self.start.copy(), np.array([self.first_motion, 0, 1])
        changes = np.flatnonzero(np.diff(demand) != 0.0) + 1
        bounds = [0, *changes, len(time) - 1]
        found = [self.start[:1]]
        for first, last in pairwise(bounds):
            held = np.array([demand[first], 0.0])
            found += self._hold(state, modes, held, time[first : last + 1], tolerance)
        return np.concatenate(found)

    def _hold(self, state, modes, held, time, tolerance):
        def crossing(_, y):
            return self.event(y, modes, held)

        crossing.terminal, crossing.direction = True, -1.0
        found, reached = [], time[0]
        while time[-1] - reached > 2.0 * BEYOND:
            self.settle_modes(state, modes, held)
            solved = solve_ivp(
                lambda _, y: self.rate(y, modes, held),
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
                state[:] = self.pass_event(solved.y_events[0][0], modes, held)
                reached = solved.t_events[0][0] + BEYOND
            else:
                state[:] = solved.y[:, -1]
                reached = time[-1]
        return found
