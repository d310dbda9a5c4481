"""The controller that a closed loop is asked for by options, and what simulates it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from analog_card.behaviour import Imperfections
from analog_card.design import Design
from analog_card.design_file import load_design
from analog_card.tuning import retune
from pneuservo.controllers import CONTROLLERS, AnalogueCard, Controller, SampledController, card_of
from pneuservo.errors import InputError
from pneuservo.naming import nearest
from pneuservo.rigs import Rig
from pneuservo.simulation import InitialState, Simulation, simulate
from pneuservo.simulation.readings import Seed

FIGURES, BEHAVIOUR, CIRCUIT = CARDS = ("figures", "behaviour", "circuit")
"""What an analogue card can be simulated by."""

UNITS = {
    "settling_time": "s",
    "damping": "",
    "boundary_layer": "m/s**2",
    "level": "V",
    "gain": "",
    "velocity_gain": "s",
    "acceleration_gain": "s**2",
    "sampling_time": "s",
    "reaching_share": "",
}
"""SI unit of every option that is a number."""

_TUNING = ("settling_time", "damping", "boundary_layer", "level")
_GAINS = ("gain", "velocity_gain", "acceleration_gain", "level")
TAKEN = {
    "sliding-mode": _TUNING,
    "proportional": ("gain", "level"),
    "state-feedback": _GAINS,
    "analogue-card": (*_TUNING, "design", "card", "without"),
    "digital-sliding-mode": (*_TUNING, "sampling_time", "accelerometer"),
    "digital-state-feedback": (*_GAINS, "sampling_time", "accelerometer"),
    "hybrid-sliding-mode": (*_TUNING, "sampling_time"),
    "discrete-sliding-mode": (*_TUNING, "sampling_time", "accelerometer", "reaching_share"),
}
"""Options by the controller that they shape."""


@dataclass(frozen=True)
class LoopController:
    """A controller with what simulates it.

    Attributes
    ----------
    controller : Controller
        The controller.
    card : str or None
        What simulates an analogue card, one of `CARDS`.
    design : Design or None
        The card's.
    relay : bool
        Whether the card is a relay.
    """

    controller: Controller
    card: str | None = None
    design: Design | None = None
    relay: bool = False

    @property
    def drives_baseline_only(self) -> bool:
        """Return whether it closes the loop around rigs without effects alone."""
        return self.card == CIRCUIT or isinstance(self.controller, SampledController)

    @property
    def title(self) -> str:
        """What a recording of the loop is called."""
        kind = self.controller.kind
        if self.card is None:
            return f"simulated, {kind} controller"
        return f"simulated, {kind} controller by its {self.card}"

    def run(
        self,
        rig: Rig,
        time: np.ndarray,
        demand: np.ndarray,
        initial: InitialState | None = None,
        seed: Seed = 0,
    ) -> Simulation:
        """Close the loop.

        Parameters
        ----------
        rig : Rig
            A rig of kind ``single-axis``.
        time, demand : (n,) array
            [s], [m].
        initial : InitialState, optional
            By default at rest at the first demand.
        seed : int or sequence of int, optional
            Of noise, where rig or controller has any.

        Returns
        -------
        Simulation
            The run.

        Raises
        ------
        InputError
            When the rig or the times are not ones that this can simulate.
        SimulationError
            When ngspice failed.
        """
        if self.card != CIRCUIT:
            return simulate(
                rig,
                time=time,
                controller=self.controller,
                demand=demand,
                initial=initial,
                seed=seed,
            )
        from analog_card.console import progress
        from pneuservo.circuit_loop import simulate_circuit_loop

        with progress() as step:
            step("ngspice: card and plant")
            return simulate_circuit_loop(
                self.design, rig, time=time, demand=demand, relay=self.relay, initial=initial
            )


def loop_controller(name: str, given: Mapping[str, Any]) -> LoopController:
    """Return the controller of a name, shaped by options.

    Parameters
    ----------
    name : str
        One of `pneuservo.controllers.CONTROLLERS`.
    given : mapping of str to anything
        The options that were given, by the names of their variables; ``design`` is a file or what
        was read from it.

    Returns
    -------
    LoopController
        The controller with what simulates it.

    Raises
    ------
    InputError
        When there is no such controller, or it does not take an option.
    """
    if name not in CONTROLLERS:
        raise InputError(
            f"controller {name!r} is not known; there are: {', '.join(CONTROLLERS)}"
            f"{nearest(name, CONTROLLERS)}"
        )
    for option in given:
        if option not in TAKEN[name]:
            raise InputError(
                f"{written(option)} is not an option of the controller {name}; "
                f"it takes: {', '.join(map(written, TAKEN[name]))}"
            )
    if name == AnalogueCard.kind:
        return _card(given)
    make: Any = CONTROLLERS[name]
    return LoopController(make(**given))


def written(option: str) -> str:
    """Return an option as it is typed."""
    return "--" + option.replace("_", "-")


def _card(given: Mapping[str, Any]) -> LoopController:
    card, without = given.get("card", FIGURES), given.get("without", ())
    if without and card != BEHAVIOUR:
        raise InputError(
            f"--without leaves imperfections out of the card's behaviour; the card is simulated by "
            f"its {card} here. Add --card {BEHAVIOUR}, or leave --without out"
        )
    design = given.get("design")
    if not isinstance(design, Design):
        design = load_design(design)
    wanted = {name: given[name] for name in _TUNING if name in given}
    # The feedback of the boundary-layer amplifier is opened.
    relay = wanted.get("boundary_layer") == 0.0
    if relay:
        del wanted["boundary_layer"]
    design = retune(design, **wanted)
    imperfections = Imperfections.none() if card == FIGURES else Imperfections().without(*without)
    return LoopController(card_of(design, imperfections, relay=relay), card, design, relay)
