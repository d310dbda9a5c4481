"""What the circuit in closed loop costs, beside the behavioural card on the compiled plant.

CPU seconds of the process of ngspice per simulated second: one channel, steps of 20 us, ten nodes
kept. An independent study of this circuit measured 2.5 to 4.0 on a machine of its own: that is what
the netlist may cost.
"""

import resource
import time
from collections.abc import Callable

import numpy as np
from rich.table import Table

from analog_card.design_file import load_design
from pneuservo.circuit_loop import simulate_circuit_loop
from pneuservo.controllers import AnalogueCard, card_of
from pneuservo.simulation import simulate, step_demand

DURATION = 1.0  # s
MOST = 4.0  # CPU s for each simulated second
TIME, DEMAND = step_demand([0.015, 0.024], DURATION / 2, 1e4)


def seconds(run: Callable[[], object], who: int) -> float:
    """Return the CPU time of a run [s]: of this process, or of the ones it has waited for."""
    before = resource.getrusage(who)
    run()
    after = resource.getrusage(who)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def compare() -> Table:
    table = Table(
        "card", f"netlist, CPU s/s (at most {MOST:g})", "behaviour, CPU s/s", "netlist costs"
    )
    start = seconds(
        lambda: simulate_circuit_loop(time=np.array([0.0, 1e-4]), demand=0.015),
        resource.RUSAGE_CHILDREN,
    )
    for name, relay in (("layer 5 m/s2", False), ("relay", True)):
        card = card_of(load_design(), relay=relay)

        def circuit(relay: bool = relay) -> object:
            return simulate_circuit_loop(time=TIME, demand=DEMAND, relay=relay)

        def behaviour(card: AnalogueCard = card) -> object:
            return simulate(time=TIME, demand=DEMAND, controller=card)

        behaviour()
        netlist_cost = (seconds(circuit, resource.RUSAGE_CHILDREN) - start) / DURATION
        began = time.process_time()
        behaviour()
        behaviour_cost = (time.process_time() - began) / DURATION
        table.add_row(
            name,
            f"{netlist_cost:.1f}",
            f"{behaviour_cost:.3f}",
            f"{netlist_cost / behaviour_cost:.0f} times",
        )
    return table
