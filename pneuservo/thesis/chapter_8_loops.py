"""The loops of chapter 8 and the plants behind them, with either set of parameters."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files

from analog_card.linear_servo import LinearServo
from analog_card.surface_weights import state_weights
from pneuservo.arrays import Array
from pneuservo.limit_cycle import Loop, Signals, StepCourse, simulate_nonlinear
from pneuservo.linear import conventional_servo, table_5_2, without_valve
from pneuservo.rigs import Rig, load_rig
from pneuservo.thesis.one_coefficient import rig_with_one_coefficient
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED, parameter_set

# Where the non-linear plant is controlled to, as the conventional model stands for [m].
MID_STROKE = 0.015


@dataclass(frozen=True, eq=False)
class StatedLoop:
    """One loop of the tables of chapter 8, and what they state of it.

    Attributes
    ----------
    id, title, source : str
        Its name in the rows, what it is, and where it stands.
    valve : bool
        With the valve's dynamics.
    signals : Signals
        How the states reach the switching function.
    stated : mapping of str to mapping
        Method, ``nyquist``, ``linear`` or ``nonlinear``, to ``frequency`` [Hz] and ``amplitude``
        or ``high`` and ``low`` [m/s2].
    reasons : mapping of str to str
        Method to why its figures are not simply reproduced.
    """

    id: str
    title: str
    source: str
    valve: bool
    signals: Signals
    stated: Mapping[str, Mapping[str, float]]
    reasons: Mapping[str, str] = field(default_factory=dict)


@cache
def stated_loops() -> tuple[StatedLoop, ...]:
    """Return the loops of tables 8.1 to 8.10, in their order."""
    text = (files("pneuservo.thesis") / "chapter_8.toml").read_text(encoding="utf-8")
    return tuple(
        StatedLoop(
            entry["id"],
            entry["title"],
            entry["source"],
            entry.get("valve", True),
            Signals(
                entry.get("differentiation", "measured"),
                entry.get("sampling_time", 0.0),
                entry.get("filtered", "none"),
            ),
            {key: entry[key] for key in ("nyquist", "linear", "nonlinear") if key in entry},
            entry.get("reasons", {}),
        )
        for entry in tomllib.loads(text)["loop"]
    )


def stated_loop(name: str) -> StatedLoop:
    """Return the loop of a name."""
    return next(loop for loop in stated_loops() if loop.id == name)


@dataclass(frozen=True, eq=False)
class Plants:
    """The linear and the non-linear plant of one parameter set.

    Attributes
    ----------
    servo : LinearServo
        With the valve's dynamics.
    weights : tuple of float
        Of the sliding surface.
    level : float
        Of the relay [V].
    rig : Rig
        For the non-linear simulation.
    grid : ndarray or None
        Its discharge coefficients; None for those of the rig's valve.
    """

    servo: LinearServo
    weights: tuple[float, float, float]
    level: float
    rig: Rig
    grid: Array | None

    def loop(self, stated: StatedLoop) -> Loop:
        """Return a loop of the tables round the linear plant."""
        return self.loop_with(stated.valve, stated.signals)

    def loop_with(self, valve: bool, signals: Signals | None = None) -> Loop:
        """Return a loop with or without the valve's dynamics round the linear plant."""
        servo = self.servo if valve else without_valve(self.servo)
        return Loop(servo, self.weights, self.level, signals=signals or Signals())

    def simulate(self, loop: Loop, duration: float) -> StepCourse:
        """Return the step response of the non-linear plant, 9 mm out to mid-stroke."""
        return simulate_nonlinear(self.rig, loop, MID_STROKE, duration=duration, grid=self.grid)


@cache
def plants(kind: str) -> Plants:
    """Return the plants of the printed or of the reconciled parameters.

    Parameters
    ----------
    kind : str
        ``printed`` or ``reconciled``.
    """
    return printed_plants(load_rig("single-axis")) if kind == PRINTED else _reconciled_plants()


def printed_plants(rig: Rig) -> Plants:
    """Return the plants of the printed parameters with a rig for the non-linear simulation."""
    values = parameter_set(PRINTED, 8)
    servo = replace(
        conventional_servo(table_5_2()),
        valve_frequency=values["valve_frequency"],
        valve_damping=values["valve_damping"],
    )
    c1, c2 = state_weights(values["settling_time"], values["damping"])
    return Plants(servo, (c1, c2, 1.0), values["level"], rig, None)


def _reconciled_plants() -> Plants:
    printed, values = parameter_set(PRINTED, 8), parameter_set(RECONCILED, 8)
    servo = LinearServo(
        values["b0"], values["a1"], values["a2"], values["valve_frequency"], values["valve_damping"]
    )
    c1, c2 = state_weights(printed["settling_time"], printed["damping"])
    rig, grid = rig_with_one_coefficient(
        values["discharge_coefficient"], values["flow_area"], values["coulomb_friction"]
    )
    weights = (c1, values["velocity_weight_factor"] * c2, 1.0)
    return Plants(servo, weights, printed["level"], rig, grid)
