"""Identification of mass and friction from recordings (thesis, section 4.3.2)."""

from pneuservo.identification.evolution import identify_evolution
from pneuservo.identification.excitation import simulate_excitation, sine_sweep
from pneuservo.identification.least_squares import (
    PARAMETERS,
    identify_each,
    identify_least_squares,
)
from pneuservo.identification.result import Estimate, Identification
from pneuservo.identification.seal_friction import identify_seal_friction
from pneuservo.identification.shooting import identify_output_error

__all__ = [
    "PARAMETERS",
    "Estimate",
    "Identification",
    "identify_each",
    "identify_evolution",
    "identify_least_squares",
    "identify_output_error",
    "identify_seal_friction",
    "simulate_excitation",
    "sine_sweep",
]
