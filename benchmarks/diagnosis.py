"""What one diagnosis of the servo costs, and what each of its parts does."""

import os
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.results import Row
from benchmarks.single_runs import milliseconds
from pneuservo.controllers import Controller, Proportional, SlidingMode
from pneuservo.diagnosis import Diagnosis, diagnose, document
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.run_observer import run_observer
from pneuservo.recordings import Recording
from pneuservo.report.page import diagnosis_page
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

JOBS, ASKED, AIM = 2, 60.0, 30.0  # of wall clock, on two processors [s]
_PLANTED = {"leakage.chamber-a": {"area": 3e-8}}
_NOISE = {"displacement": 1e-5, "pressure_a": 500.0, "pressure_b": 500.0}
_RATE, _HOLD = 1e3, 0.4  # Hz, s
_FIRST, _LAST = "feed and observer gains", "answer and report"
# By how a step of the diagnosis begins when it tells its progress.
_PARTS = {
    "fitting": "fits",
    "working out what each effect": "signatures of all effects",
    "imitating": "imitations",
    "looking how far": "intervals by profile",
    "looking for what has no name": "what has no name",
}


def recordings(duration: float) -> list[Recording]:
    """Return a leaking servo recorded under two controllers.

    Parameters
    ----------
    duration : float
        Of each recording [s].
    """
    return [_recorded(Proportional(), 1, duration), _recorded(SlidingMode(), 2, duration)]


def diagnosis_rows(duration: float = 10.0, rounds: int = 3) -> Iterator[Row]:
    """Yield the whole, its parts and the observer run that they are made of.

    Parameters
    ----------
    duration : float, optional
        Of each of the two recordings [s].
    rounds : int, optional
        Repetitions of the observer run; the diagnosis itself is timed once.
    """
    used = recordings(duration)
    # Loads the compiled code, or makes it.
    _timed(recordings(0.5))
    spent, elapsed, found = _timed(used)
    observer = _observer_run(found, rounds)
    whole = sum(spent.values())
    name = f"diagnosis of two recordings of {duration:g} s"
    said = document(found)
    yield Row(
        name,
        whole,
        "s",
        higher_is_better=False,
        note=f"{len(found.search.fits)} hypotheses fitted of {len(found.search.candidates)} "
        f"candidates; answer: {said['verdict']}, {', '.join(found.search.accepted) or 'nothing'}",
    )
    yield Row(
        f"{name}: wall clock on {JOBS} processors",
        elapsed,
        "s",
        ASKED,
        higher_is_better=False,
        note=f"aim {AIM:g} s, load average {os.getloadavg()[0]:.1f}",
    )
    yield Row(f"{name}: one observer run", 1e3 * observer, "ms", note="of both, with the baseline")
    yield Row(f"{name}: over one observer run", whole / observer, "x", higher_is_better=False)
    for part, seconds in spent.items():
        yield Row(
            f"{name}: {part}",
            seconds,
            "s",
            note=f"{seconds / whole:.0%}, {seconds / observer:.0f} observer runs",
        )


def _recorded(controller: Controller, seed: int, duration: float) -> Recording:
    samples, held = round(duration * _RATE), round(_HOLD * _RATE)
    moment = np.arange(samples) / _RATE
    random = np.random.default_rng(seed)
    demand = np.repeat(random.uniform(0.006, 0.024, samples // held + 1), held)[:samples]
    rig = replace(load_rig("single-axis"), effects=_PLANTED)
    run = simulate(rig, time=moment, controller=controller, demand=demand)
    channels = {n: run[n] + random.normal(0.0, size, samples) for n, size in _NOISE.items()}
    return Recording("run", moment, channels | {"valve_voltage": run["valve_voltage"]})


def _timed(used: list[Recording]) -> tuple[dict[str, float], float, Diagnosis]:
    """Return the CPU time of each part, the wall clock, both in seconds, and what was found."""
    spent = dict.fromkeys((_FIRST, *_PARTS.values(), _LAST), 0.0)
    start, clock = time.perf_counter(), _Stopwatch(spent)
    found = diagnose(used, progress=clock.step, jobs=JOBS)
    clock.part(_LAST)
    answer = document(found)
    # Rivals that had not been fitted yet are fitted for the answer.
    clock.part(_LAST)
    diagnosis_page(found, answer)
    clock.part(_LAST)
    return spent, time.perf_counter() - start, found


class _Stopwatch:
    """Adds the CPU time between steps of a diagnosis to the part that each step belongs to."""

    def __init__(self, spent: dict[str, float]) -> None:
        self.spent, self.running, self.since = spent, _FIRST, time.process_time()

    def step(self, words: str) -> None:
        self.part(next(part for begin, part in _PARTS.items() if words.startswith(begin)))

    def part(self, name: str) -> None:
        now = time.process_time()
        self.spent[self.running] += now - self.since
        self.running, self.since = name, now


def _observer_run(found: Diagnosis, rounds: int) -> float:
    """Return the CPU time of one run of the observer on all recordings [s]."""
    feeds: dict[int, Feed] = {id(case.recording): case.inputs["feed"] for case in found.cases}

    def run() -> None:
        for fed in feeds.values():
            run_observer(fed, {}, found.rig)

    return float(np.median([milliseconds(run) for _ in range(rounds)])) / 1e3
