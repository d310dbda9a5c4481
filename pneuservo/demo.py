"""The main job end to end: tune the card, run its netlist, close the loop, diagnose a recording."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analog_card.tuning import Tuning, tune
from analog_card.verification import Verification, verify
from pneuservo.controllers import AnalogueCard
from pneuservo.diagnosis import Diagnosis, diagnose
from pneuservo.examples.leaking_volume import write_example
from pneuservo.recordings import Recording, read_recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import Simulation, simulate, step_demand

SETTLING_TIME, DAMPING, BOUNDARY_LAYER, LEVEL = 0.07, 1.0, 5.0, 5.0
"""What the card is tuned for: [s], [-], [m/s^2], [V]; thesis section 9.3.4."""
_SET_POINTS = (0.015, 0.024, 0.006, 0.015)
_HOLD, _RATE = 0.5, 2000.0


@dataclass(frozen=True)
class Demo:
    """What the main job found.

    Parameters
    ----------
    tuning : Tuning
        The tuned card.
    verification : Verification
        Its netlist against its behavioural equivalent.
    loop : Simulation
        The card and the baseline plant in closed loop.
    diagnosis : Diagnosis
        Of the user's recording, or of the example.
    recording : Recording, optional
        What was diagnosed, unless it was the program's own example.
    """

    tuning: Tuning
    verification: Verification
    loop: Simulation
    diagnosis: Diagnosis
    recording: Recording | None


def run_demo(
    folder: Path,
    recording: Recording | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda step: None,
    jobs: int = 1,
) -> Demo:
    """Run the main job.

    Parameters
    ----------
    folder : Path
        Where the example recording is written when none is given.
    recording : Recording, optional
        The user's own.
    seed : int, optional
        Seed of the example's noise.
    progress : callable, optional
        Told in words what is running.
    jobs : int, optional
        How many processors the diagnosis takes.

    Returns
    -------
    Demo
        All results.

    Raises
    ------
    InputError
        When the recording cannot be used.
    SimulationError
        When ngspice fails.
    """
    read = recording or read_recording(write_example(folder / "example", seed))
    progress("tuning the card")
    tuning = tune(SETTLING_TIME, DAMPING, BOUNDARY_LAYER, LEVEL)
    verification = verify(tuning.design, lambda step: progress(f"ngspice: {step}"))
    progress("closing the loop")
    time, demand = step_demand(_SET_POINTS, _HOLD, _RATE)
    loop = simulate(
        load_rig("single-axis"), time=time, demand=demand, controller=AnalogueCard(tuning.figures)
    )
    found = diagnose([read], progress=progress, jobs=jobs)
    return Demo(tuning, verification, loop, found, recording)


def summary(demo: Demo, answer: dict[str, Any]) -> dict[str, Any]:
    """Return the main figures of the demo as plain data.

    Parameters
    ----------
    demo : Demo
        The results.
    answer : dict
        The document of its diagnosis.

    Returns
    -------
    dict
        Potentiometers, worst deviations, step responses and the verdict.
    """
    return {
        "potentiometers": {
            item.name: {"fraction": item.fraction, "ohm": item.resistance}
            for item in demo.tuning.potentiometers
        },
        "netlist": demo.verification.to_dict(),
        "steps": [
            {
                "from": step.origin,
                "to": step.target,
                "settling_time": step.settling_time,
                "steady_state_error": step.steady_state_error,
            }
            for step in demo.loop.step_responses()
        ],
        "verdict": answer["verdict"],
    }
