"""Running a campaign: in processes or on a cluster, kept as it comes, going on after a stop."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import NoneType
from typing import Any

import pandas as pd

from analog_card.tolerance_trials import fingerprint, run_trials
from pneuservo.campaign.plan import Campaign
from pneuservo.campaign.sample import run_samples
from pneuservo.errors import InputError
from pneuservo.rigs import plant_numbers

SAMPLES = "samples.jsonl"
"""Name of the file in which samples are kept as they come."""

# Shares of the work that each process gets: a stop loses little of a short campaign, and handing
# out costs little in a long one.
_SHARES, _LARGEST_SHARE = 50, 10


@dataclass(frozen=True)
class Outcome:
    """What a campaign gave.

    Attributes
    ----------
    campaign : Campaign
        The campaign.
    samples : list of dict
        By index, each as from `pneuservo.campaign.sample.run_samples`.
    """

    campaign: Campaign
    samples: list[dict[str, Any]]

    def table(self) -> pd.DataFrame:
        """Return one row for each sample: values and metrics by name in SI, and error."""
        rows = [
            {**each["values"], **each["metrics"], "error": each["error"]} for each in self.samples
        ]
        table = pd.DataFrame(rows)
        numbers = list(table.columns[:-1])
        # None is a metric that a run does not have.
        table[numbers] = table[numbers].astype(float)
        table.index.name = "sample"
        return table


def run_campaign(
    campaign: Campaign,
    folder: str | Path | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda what: None,
    pool: Executor | None = None,
) -> Outcome:
    """Run a campaign.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    folder : str or Path, optional
        Where samples are kept as they come, so that a stopped campaign goes on.
    jobs : int, optional
        Processes to run in, or those of the pool.
    step : callable, optional
        Told about each sample done.
    pool : Executor, optional
        Runs the samples elsewhere, such as `pneuservo.campaign.cluster.cluster`.

    Returns
    -------
    Outcome
        Every sample; the same however it was run.

    Raises
    ------
    InputError
        When the folder holds another campaign or a damaged sample, or not one sample can be
        simulated.

    Examples
    --------
    >>> from pneuservo.campaign.plan_file import campaign_of
    >>> outcome = run_campaign(campaign_of({
    ...     "controller": "sliding-mode", "demand": "15,24 mm", "vary": {"load.mass": "1.8, 7 kg"},
    ... }))
    >>> table = outcome.table()
    >>> bool(table["settling_time"][1] > table["settling_time"][0])
    True
    """
    count = len(campaign)
    samples = run_trials(
        partial(run_samples, campaign),
        count,
        f"campaign {identity(campaign)}",
        None if folder is None else Path(folder) / SAMPLES,
        jobs,
        step,
        pool,
        max(1, min(count // (max(jobs, 1) * _SHARES), _LARGEST_SHARE)),
        partial(_require_whole, campaign),
    )
    if all(sample["error"] is not None for sample in samples):
        raise InputError(
            f"not one of {count} samples could be simulated; the first: {samples[0]['error']}"
        )
    return Outcome(campaign, samples)


def _require_whole(campaign: Campaign, where: str, figures: Any) -> None:
    """Refuse a sample that was kept and is not what the campaign gives."""
    if not _whole(figures, campaign):
        raise InputError(
            f"{where} is no whole sample of this campaign; it needs values of "
            f"{', '.join(axis.name for axis in campaign.axes)}, the metrics "
            f"{', '.join(campaign.metrics)}, and error. Delete the line, and the sample is "
            "simulated again"
        )


def _whole(figures: Any, campaign: Campaign) -> bool:
    if not isinstance(figures, dict) or set(figures) != {"values", "metrics", "error"}:
        return False
    values, metrics, error = figures["values"], figures["metrics"], figures["error"]
    return (
        _numbers(values, [axis.name for axis in campaign.axes], (int, float))
        and _numbers(metrics, campaign.metrics, (int, float, NoneType))
        and isinstance(error, str | NoneType)
    )


def _numbers(table: Any, names: Sequence[str], kinds: tuple[type, ...]) -> bool:
    return (
        isinstance(table, dict)
        and set(table) == set(names)
        and all(isinstance(v, kinds) and not isinstance(v, bool) for v in table.values())
    )


def identity(campaign: Campaign) -> str:
    """Return a text that differs between campaigns whose samples differ.

    Not of it are the title and the number of trials: more of them leave those before as they are.
    """
    return fingerprint(
        *plant_numbers.all_numbers(campaign.rig),
        campaign.controller,
        campaign.options,
        campaign.time.tobytes(),
        campaign.demand.tobytes(),
        campaign.axes,
        campaign.seed,
        campaign.metrics,
    )
