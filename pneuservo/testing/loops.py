"""Closed loops to assert something of: one, or one for each rig of a set."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from analog_card.errors import AnalogCardError
from analog_card.quantities import to_si
from pneuservo.campaign.parameters import CONTROLLER, varied_rig
from pneuservo.campaign.plan_file import campaign_of
from pneuservo.campaign.sample import simulate_sample
from pneuservo.campaign.summary import values_in_words
from pneuservo.controllers import Controller, Proportional, SlidingMode
from pneuservo.controllers.requirements import other_transducer
from pneuservo.errors import InputError
from pneuservo.loop_controller import UNITS, LoopController, loop_controller
from pneuservo.rigs import Rig
from pneuservo.simulation import Simulation, step_demand
from pneuservo.simulation.demand import HOLD, RATE, set_points
from pneuservo.simulation.inputs import require_kind

Value = str | float

DEMAND = "15,24,6,15 mm"
"""The steps of the thesis: up, down over most of the stroke, back."""
_SHAPED = (
    "a controller that is given as an object is shaped already: give it by its name, or leave out "
    "what would shape it"
)


def close_loop(
    controller: str | Controller,
    *,
    demand: str = DEMAND,
    rig: Rig | str = "single-axis",
    values: Mapping[str, Value] | None = None,
    hold: Value = HOLD,
    rate: Value = RATE,
    **options: Any,
) -> Simulation:
    """Simulate a closed loop.

    Parameters
    ----------
    controller : str or Controller
        One of `pneuservo.controllers`, or its name.
    demand : str, optional
        Set points, such as ``"15,24 mm"``.
    rig : Rig or str, optional
        A rig of kind ``single-axis``, its name or its file.
    values : mapping of str to str or float, optional
        Parameters of the rig that differ, such as ``{"load.mass": "6.8 kg"}``.
    hold : str or float, optional
        Time at each set point [s].
    rate : str or float, optional
        Samples per second [Hz].
    **options
        What shapes a controller given by its name, as for ``pneuservo simulate``:
        ``settling_time="70 ms"``, ``design="card.toml"``, ``card="behaviour"``.

    Returns
    -------
    Simulation
        The run.

    Raises
    ------
    InputError
        When something is unknown, or not a quantity of the right kind.

    Examples
    --------
    >>> run = close_loop("sliding-mode", demand="15,24 mm", settling_time="70 ms")
    >>> round(run.settling_time(), 3)
    0.132
    """
    _require_loop(controller, demand)
    plant = require_kind(rig, "single-axis", effects=True)
    known = {name: parameter.unit for name, parameter in plant.parameters.items()}
    plant = plant.with_values(
        # A name that is not known is refused by the rig.
        {name: to_si(value, known.get(name, ""), name) for name, value in (values or {}).items()}
    )
    time, targets = step_demand(
        set_points(demand, plant["piston.stroke"]),
        to_si(hold, "s", "hold"),
        to_si(rate, "Hz", "rate"),
    )
    loop = _loop(controller, options)
    if loop.design is not None and (problem := other_transducer(loop.design, plant)):
        warnings.warn(problem, stacklevel=2)
    return loop.run(plant, time, targets)


def closed_loops(
    controller: str | Controller,
    vary: Mapping[str, Value | Sequence[Value]],
    *,
    demand: str = DEMAND,
    rig: str = "single-axis",
    hold: Value = HOLD,
    rate: Value = RATE,
    trials: int | None = None,
    seed: int = 0,
    **options: Any,
) -> Iterator[tuple[str, Simulation]]:
    """Simulate a closed loop once for each rig of a set.

    Parameters
    ----------
    controller : str or Controller
        One of `pneuservo.controllers`, or its name.
    vary : mapping of str to str, float, or a sequence of them
        Parameters and their values as for ``pneuservo campaign``: ``"6.5, 7.7 bar"``,
        ``"normal(1.825 kg, 3 %)"``, ``"tolerance"``. Of a controller that is given as an object
        only parameters of the rig.
    demand, rig, hold, rate, **options
        As for `close_loop`; the rig by its name or its file.
    trials : int, optional
        Drawn at each point of the grid.
    seed : int, optional
        Of what is drawn, noise included: no two runs have the same.

    Yields
    ------
    str, Simulation
        What is special about each rig of the set, and its run.

    Raises
    ------
    InputError
        When something is unknown, or one rig of the set is impossible.

    Examples
    --------
    >>> for name, run in closed_loops("sliding-mode", {"load.mass": "1.8, 7 kg"}):
    ...     print(name, [round(step.settling_time, 3) for step in run.step_responses()])
    load.mass 1.8 kg [0.132, 0.152, 0.131]
    load.mass 7 kg [0.133, 0.174, 0.131]
    """
    _require_loop(controller, demand)
    own = not isinstance(controller, str)
    if own and (options or any(name.startswith(CONTROLLER) for name in vary)):
        raise InputError(_SHAPED)
    shape = {name: value for name, value in options.items() if name in UNITS}
    axes = {**{CONTROLLER + name: value for name, value in shape.items()}, **vary}
    campaign = campaign_of(
        {
            **{name: value for name, value in options.items() if name not in UNITS},
            # A controller of one's own has no numbers to vary, whatever it stands for here.
            "controller": Proportional.kind if own else controller,
            "demand": demand,
            "rig": rig,
            "hold": hold,
            "rate": rate,
            "trials": trials,
            "seed": seed,
            "vary": axes,
        },
        "vary",
        warnings.warn,
    )
    special = [axis for axis in campaign.axes if axis.name in vary]
    for index in range(len(campaign)):
        values = campaign.values(index)
        name = values_in_words(values, special)
        try:
            run = (
                simulate_sample(campaign, values, index)
                if isinstance(controller, str)
                else LoopController(controller).run(
                    varied_rig(campaign.rig, values),
                    campaign.time,
                    campaign.demand,
                    seed=(campaign.seed, index),
                )
            )
        except (InputError, AnalogCardError) as problem:
            raise InputError(f"rig with {name}: {problem}") from problem
        yield name, run


def _require_loop(controller: Any, demand: Any) -> None:
    if not isinstance(controller, str | Controller):
        raise InputError(
            f"controller is {controller!r}; give the name of one, such as {SlidingMode.kind!r}, or "
            "an object of pneuservo.controllers"
        )
    if not isinstance(demand, str):
        raise InputError(
            f"demand is {demand!r}; give a text of set points with their unit, such as {DEMAND!r}"
        )


def _loop(controller: str | Controller, options: Mapping[str, Any]) -> LoopController:
    if isinstance(controller, str):
        shape = {
            name: to_si(value, UNITS[name], name) if name in UNITS else value
            for name, value in options.items()
        }
        return loop_controller(controller, shape)
    if options:
        raise InputError(_SHAPED)
    return LoopController(controller)
