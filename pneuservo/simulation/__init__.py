"""Simulating a rig: one run, its result, and what is read off it."""

from pneuservo.simulation.batch import Batch, simulate_batch
from pneuservo.simulation.dead_volume import simulate_dead_volume
from pneuservo.simulation.demand import step_demand
from pneuservo.simulation.gradient import Gradient, simulate_gradient
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.metrics import LimitCycle, StepResponse, limit_cycle, step_responses
from pneuservo.simulation.replay import replay
from pneuservo.simulation.result import Simulation
from pneuservo.simulation.run import simulate

__all__ = [
    "Batch",
    "Gradient",
    "InitialState",
    "LimitCycle",
    "Simulation",
    "StepResponse",
    "limit_cycle",
    "replay",
    "simulate",
    "simulate_batch",
    "simulate_dead_volume",
    "simulate_gradient",
    "step_demand",
    "step_responses",
]
