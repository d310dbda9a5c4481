"""A tolerance study of the card in open loop: netlist and behaviour over the same cards."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from analog_card.design import Design
from analog_card.design_tolerances import REFERENCE_TEMPERATURE
from analog_card.errors import InputError
from analog_card.tolerance import TEMPERATURE, draw, elements_of, quantities
from analog_card.tolerance_figures import FIGURES, behaviour_figures, netlist_figures
from analog_card.tolerance_statistics import (
    CONTENT,
    Bounds,
    Yield,
    bounds,
    corners,
    importance,
    yield_within,
)
from analog_card.tolerance_trials import fingerprint, run_trials, single_threaded

# How many quantities a report names for each figure.
MOST_IMPORTANT = 3


@dataclass(frozen=True)
class Spread:
    """What the trials say about one figure.

    Attributes
    ----------
    figure, unit : str
        What it is.
    nominal : float
        Of the card as designed [unit].
    mean, deviation : float
        Mean and standard deviation of the trials; not a number where less than two gave one [unit].
    low, high : float
        95 % of all cards lie between these, with the confidence given; as above [unit].
    confidence : float
        Of that.
    corner_low, corner_high : float or None
        Worst cases by corners [unit]; None where they were not computed.
    important : dict of str to float
        The quantities that account for most of it, and for what share.
    difference : float or None
        Largest difference of netlist and behaviour over the trials both have [unit].
    failed : int
        Trials that gave no number.
    """

    figure: str
    unit: str
    nominal: float
    mean: float
    deviation: float
    low: float
    high: float
    confidence: float
    corner_low: float | None
    corner_high: float | None
    important: dict[str, float]
    difference: float | None
    failed: int = 0


@dataclass(frozen=True)
class Study:
    """A tolerance study.

    Attributes
    ----------
    design : Design
        The card as designed.
    spreads : tuple of Spread
        One for each figure.
    trials : list of dict
        Figures of the behaviour, by trial.
    netlist_trials : list of dict
        The same of the netlist; fewer.
    cards_within : Yield or None
        Share of cards within the limits; None without limits.
    """

    design: Design
    spreads: tuple[Spread, ...]
    trials: list[dict[str, Any]]
    netlist_trials: list[dict[str, Any]]
    cards_within: Yield | None

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain values, for JSON."""
        return {
            "design": self.design.title,
            "tolerances": asdict(self.design.tolerances),
            "trials": len(self.trials),
            "netlist_trials": len(self.netlist_trials),
            "figures": [asdict(spread) for spread in self.spreads],
            "yield": asdict(self.cards_within) if self.cards_within else None,
        }


def study_card(
    design: Design,
    count: int = 1000,
    netlist_count: int = 200,
    seed: int = 0,
    limits: Mapping[str, tuple[float, float]] | None = None,
    folder: str | Path | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda what: None,
) -> Study:
    """Study what tolerances do to a card in open loop.

    Parameters
    ----------
    design : Design
        The card as designed, with its tolerances.
    count, netlist_count : int, optional
        Trials by behaviour, and how many of these cards the netlist is run with.
    seed : int, optional
        Of the study; card n of a seed is the same in every study of the design.
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
        Spread of every figure.

    Raises
    ------
    InputError
        When the folder holds another study, or a limit is of no figure.
    SimulationError
        When ngspice fails.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> study = study_card(load_design(), count=20, netlist_count=2)
    >>> all(spread.difference < 1e-3 * abs(spread.nominal) for spread in study.spreads[:5])
    True
    """
    require_limits(limits, FIGURES)
    behaviour = partial(_behaviour_trials, design, seed)
    netlist = partial(_netlist_trials, design, seed)
    place = Path(folder) if folder is not None else None
    name = fingerprint(design, seed)
    trials = run_trials(
        behaviour, count, f"behaviour {name}", place and place / "behaviour.jsonl", jobs, step
    )
    measured: list[dict[str, Any]] = []
    if netlist_count:
        measured = run_trials(
            netlist, netlist_count, f"netlist {name}", place and place / "netlist.jsonl", jobs, step
        )
    return study_of(
        design,
        seed,
        FIGURES,
        behaviour_figures(design, {}),
        trials,
        lambda cards: [behaviour_figures(design, elements_of(card, design)) for card in cards],
        limits,
        measured,
    )


def study_of(
    design: Design,
    seed: int,
    units: Mapping[str, str],
    nominal: Mapping[str, float | None],
    trials: list[dict[str, Any]],
    evaluate: Callable[[Sequence[Mapping[str, float]]], list[dict[str, Any]]],
    limits: Mapping[str, tuple[float, float]] | None = None,
    measured: Sequence[dict[str, Any]] = (),
) -> Study:
    """Return the study that trials make, with the worst cases by corners.

    Parameters
    ----------
    design : Design
        The card as designed, with its tolerances.
    seed : int
        Of the cards of the trials.
    units : mapping of str to str
        Unit by figure; these figures are reported.
    nominal : mapping of str to float or None
        Figures of the card as designed.
    trials : list of dict
        Figures by trial; None where there is no number.
    evaluate : callable
        Returns the figures of cards, each given by its deviations.
    limits : mapping of str to tuple of float, optional
        Lowest and highest value allowed of figures, for the yield.
    measured : sequence of dict, optional
        Figures of the first trials by the netlist.
    """
    items = quantities(design)
    drawn = [draw(items, seed, index) for index in range(len(trials))]
    extremes = {item.name: item.extreme for item in items if item.spread}
    # Drifts show at the end of the range that is further from where the values of the design hold.
    warmer = design.tolerances.temperature.middle >= REFERENCE_TEMPERATURE
    with single_threaded():
        worst = corners(evaluate, extremes, either={TEMPERATURE: 1.0 if warmer else -1.0})
    spreads = _spreads(_numbers(nominal), units, trials, drawn, worst, measured)
    within = yield_within([_numbers(trial) for trial in trials], limits) if limits else None
    return Study(design, spreads, trials, list(measured), within)


def _spreads(
    nominal: Mapping[str, float],
    units: Mapping[str, str],
    trials: Sequence[Mapping[str, Any]],
    drawn: Sequence[Mapping[str, float]],
    worst: Mapping[str, tuple[float, float]],
    measured: Sequence[Mapping[str, Any]],
) -> tuple[Spread, ...]:
    """Return what trials say about each figure; `drawn` are the deviations by trial."""
    spreads = []
    for figure, unit in units.items():
        values = np.array([trial[figure] for trial in trials], float)
        usable = values[np.isfinite(values)]
        few = len(usable) < 2
        if len(values) < 2:
            raise InputError(f"{len(values)} trials; a study needs at least two")
        # What hardly a card has is no reason to keep the other figures back.
        found = Bounds(np.nan, np.nan, CONTENT, 0.0) if few else bounds(usable.tolist())
        ranked = {} if few else importance(drawn, values.tolist())
        both = min(len(measured), len(trials))
        pairs = [(measured[k][figure], float(values[k])) for k in range(both)]
        apart = [abs(one - other) for one, other in pairs if np.isfinite(one - other)]
        low, high = worst.get(figure, (None, None))
        spreads.append(
            Spread(
                figure=figure,
                unit=unit,
                nominal=nominal[figure],
                mean=np.nan if few else float(usable.mean()),
                deviation=np.nan if few else float(usable.std(ddof=1)),
                low=found.low,
                high=found.high,
                confidence=found.confidence,
                corner_low=low,
                corner_high=high,
                important=dict(list(ranked.items())[:MOST_IMPORTANT]),
                difference=max(apart, default=None),
                failed=len(values) - len(usable),
            )
        )
    return tuple(spreads)


def require_limits(
    limits: Mapping[str, tuple[float, float]] | None, figures: Mapping[str, str]
) -> None:
    """Refuse limits of figures that there are not, and limits that nothing can meet."""
    for name, (low, high) in (limits or {}).items():
        if name not in figures:
            raise InputError(f"limit of {name!r}: the figures are {', '.join(figures)}")
        if not low <= high:
            raise InputError(f"limit of {name}: {low:g} to {high:g} lets nothing pass")


def _numbers(figures: Mapping[str, float | None]) -> dict[str, float]:
    return {name: np.nan if value is None else value for name, value in figures.items()}


def _behaviour_trials(
    design: Design, seed: int, indices: Sequence[int]
) -> Iterator[dict[str, float]]:
    for elements in _cards(design, seed, indices):
        yield behaviour_figures(design, elements)


def _netlist_trials(
    design: Design, seed: int, indices: Sequence[int]
) -> Iterator[dict[str, float]]:
    return netlist_figures(design, _cards(design, seed, indices))


def _cards(design: Design, seed: int, indices: Sequence[int]) -> list[dict[str, float]]:
    items = quantities(design)
    return [elements_of(draw(items, seed, index), design) for index in indices]
