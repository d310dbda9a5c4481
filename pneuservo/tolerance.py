"""A tolerance study of the card in closed loop with the plant."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from analog_card.design import Design
from analog_card.figures import card_figures
from analog_card.tolerance import draw, elements_of, quantities
from analog_card.tolerance_figures import FIGURES as OPEN_LOOP_FIGURES
from analog_card.tolerance_figures import behaviour_figures
from analog_card.tolerance_study import Study, require_limits, study_of
from analog_card.tolerance_trials import fingerprint, run_trials
from pneuservo.controllers import card_of
from pneuservo.controllers.requirements import sensitivity
from pneuservo.rigs import Rig, load_rig, plant_numbers
from pneuservo.simulation import simulate
from pneuservo.simulation.metrics import limit_cycle

# Unit of each figure of the closed loop: of the step with the boundary layer, then of the relay.
FIGURES = {
    "rise_time": "s",
    "settling_time": "s",
    "steady_state_error": "m",
    "chatter": "m/s2",
    "limit_cycle_frequency": "Hz",
    "limit_cycle_amplitude": "m/s2",
    "relay_error": "m",
}
ALL_FIGURES = {**FIGURES, **OPEN_LOOP_FIGURES}
# The step of the recommended card's limits, as shares of the stroke: 15 to 24 mm of 30 mm.
_FROM, _TO = 0.5, 0.8
# Metrics of the error need 0.45 s after a step; the limit cycle is counted in the last part.
_RATE, _DURATION, _COUNTED = 10e3, 0.6, 0.25


def closed_loop_figures(
    design: Design, elements: Mapping[str, float], rig: Rig
) -> dict[str, float | None]:
    """Return the figures of one card in closed loop.

    Parameters
    ----------
    design : Design
        The card as designed.
    elements : mapping of str to float
        Values of its elements.
    rig : Rig
        A rig of kind ``single-axis``.

    Returns
    -------
    dict of str to float or None
        By the names of `FIGURES`, in SI; None where there is no number, such as the settling time
        of a loop that does not settle.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> found = closed_loop_figures(load_design(), {}, load_rig("single-axis"))
    >>> 150 < found["limit_cycle_frequency"] < 190
    True
    """
    time = np.arange(round(_DURATION * _RATE) + 1) / _RATE
    demand = np.where(time < 0.5 / _RATE, _FROM, _TO) * rig["piston.stroke"]
    # The taps are volts of the rig's transducer, whatever the design has.
    scale = card_figures(design).surface_scale * sensitivity(rig) / design.transducer.gain
    # Each run has its own link in the feedback of the boundary-layer amplifier.
    parts = {name: value for name, value in elements.items() if name != "xboundary.rlink"}
    late = time >= _DURATION - _COUNTED
    runs = {}
    for relay in (False, True):
        card = card_of(design, elements=parts, relay=relay)
        runs[relay] = simulate(rig, time=time, demand=demand, controller=card)
    layer, switching = (runs[relay].step_responses()[0] for relay in (False, True))
    swings = {relay: runs[relay]["card_surface"][late] / scale for relay in runs}
    cycle = limit_cycle(time[late], swings[True])
    found = {
        "rise_time": layer.rise_time,
        "settling_time": layer.settling_time,
        "steady_state_error": layer.steady_state_error,
        "chatter": float(np.ptp(swings[False])) / 2,
        "limit_cycle_frequency": cycle.frequency if cycle else np.nan,
        "limit_cycle_amplitude": (cycle.high - cycle.low) / 2 if cycle else np.nan,
        "relay_error": switching.steady_state_error,
    }
    return {name: float(value) if np.isfinite(value) else None for name, value in found.items()}


def study_loop(
    design: Design,
    rig: Rig | None = None,
    count: int = 1000,
    seed: int = 0,
    limits: Mapping[str, tuple[float, float]] | None = None,
    folder: str | Path | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda what: None,
) -> Study:
    """Study what tolerances of the card do to the closed loop.

    Parameters
    ----------
    design : Design
        The card as designed, with its tolerances.
    rig : Rig, optional
        The plant, without tolerances; by default ``single-axis``.
    count : int, optional
        Trials; the cards are those of `analog_card.tolerance_study.study_card` with this seed.
    seed : int, optional
        Of the study.
    limits : mapping of str to tuple of float, optional
        Lowest and highest value allowed of figures, for the yield.
    folder : str or Path, optional
        Where trials are kept, so that a stopped study goes on.
    jobs : int, optional
        Processes to run in.
    step : callable, optional
        Told about each trial done.

    Returns
    -------
    Study
        Spread of every figure, of the loop and of the card.

    Raises
    ------
    InputError
        When the folder holds another study, or a limit is of no figure.
    """
    rig = rig or load_rig("single-axis")
    require_limits(limits, ALL_FIGURES)
    place = Path(folder) if folder is not None else None
    name = fingerprint(design, seed, *plant_numbers.all_numbers(rig))
    loop = partial(_trials, design, rig, seed)
    trials = run_trials(loop, count, f"loop {name}", place and place / "loop.jsonl", jobs, step)

    def evaluated(cards: Sequence[Mapping[str, float]]) -> list[dict[str, Any]]:
        figures = partial(_cards, design, rig, list(cards))
        corner = fingerprint(cards)
        store = place and place / f"corners-{corner}.jsonl"
        return run_trials(figures, len(cards), f"corners {name}", store, jobs, step)

    nominal = {**closed_loop_figures(design, {}, rig), **behaviour_figures(design, {})}
    return study_of(design, seed, ALL_FIGURES, nominal, trials, evaluated, limits)


def _trials(
    design: Design, rig: Rig, seed: int, indices: Sequence[int]
) -> Iterator[dict[str, Any]]:
    items = quantities(design)
    cards = [draw(items, seed, index) for index in indices]
    return _cards(design, rig, cards, range(len(cards)))


def _cards(
    design: Design,
    rig: Rig,
    cards: Sequence[Mapping[str, float]],
    indices: Sequence[int],
) -> Iterator[dict[str, Any]]:
    for index in indices:
        elements = elements_of(cards[index], design)
        yield {**closed_loop_figures(design, elements, rig), **behaviour_figures(design, elements)}
