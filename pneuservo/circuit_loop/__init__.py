"""The real circuit of the card in closed loop with the plant."""

from pneuservo.circuit_loop.loop import simulate_circuit_loop

__all__ = ["simulate_circuit_loop"]
