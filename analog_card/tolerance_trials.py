"""Running the trials of a study: in several processes, kept in a file, going on after a stop."""

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from analog_card.errors import InputError
from analog_card.processes import processes

Figures = dict[str, Any]
Trial = Callable[[Sequence[int]], Iterable[Figures]]

# Trials that a process takes at a time: enough to make its start cheap, few enough to lose little.
# How every file of trials begins.
_BEGINNING = b'{"study": '
_CHUNK = 10


def fingerprint(*what: Any) -> str:
    """Return a text that tells one study from another, by the values that define it."""
    return hashlib.sha256(repr(what).encode()).hexdigest()[:16]


@contextmanager
def single_threaded() -> Iterator[None]:
    """Keep linear algebra in one thread: for a card's matrices of 12 x 12 more only wait."""
    import scipy.linalg  # noqa: F401 - its library must be there to be kept to one thread
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1, user_api="blas"):
        yield


def _require_figures(where: str, figures: Any) -> None:
    if not isinstance(figures, dict):
        raise InputError(f"{where}: not a file of trials (no figures by name); name another")


def requiring(*names: str) -> Callable[[str, Any], None]:
    """Return what refuses kept figures that are not those of a trial, for `run_trials`.

    Parameters
    ----------
    *names : str
        Of all its figures.
    """

    def require(where: str, figures: Any) -> None:
        if not isinstance(figures, dict) or set(figures) != set(names):
            raise InputError(
                f"{where} is no whole trial of this study; it needs {', '.join(names)}. "
                "Delete the line, and the trial is run again"
            )

    return require


def run_trials(
    trial: Trial,
    count: int,
    study: str,
    store: str | Path | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda what: None,
    pool: Executor | None = None,
    chunk: int = _CHUNK,
    require_whole: Callable[[str, Any], None] = _require_figures,
) -> list[Figures]:
    """Return the figures of every trial of a study, in order.

    Parameters
    ----------
    trial : callable
        Takes indices and yields the figures of each; of a module, so that another process can call
        it. The figures of an index must depend on nothing but the index.
    count : int
        How many trials.
    study : str
        What the study is, from `fingerprint`: a file of another study is refused.
    store : str or Path, optional
        A file to which each trial is added as a line of JSON; trials already in it are not run
        again.
    jobs : int, optional
        Processes to run in.
    step : callable, optional
        Told about each trial done, for a progress display.
    pool : Executor, optional
        Runs the trials in place of processes of this computer.
    chunk : int, optional
        Trials that a process takes at a time.
    require_whole : callable, optional
        Takes file and line, and what was kept there; raises when these are not all the figures.

    Returns
    -------
    list of dict
        Figures by trial; the same however many processes there were.

    Raises
    ------
    InputError
        When the file is of another study or holds a damaged trial, or a number is out of range.

    Examples
    --------
    >>> run_trials(lambda indices: ({"square": i * i} for i in indices), 3, "squares")
    [{'square': 0}, {'square': 1}, {'square': 4}]
    """
    if count < 1 or jobs < 1:
        raise InputError(f"{count} trials in {jobs} processes; at least one of each is needed")
    done = _read(Path(store), study, require_whole) if store is not None else {}
    left = [index for index in range(count) if index not in done]
    chunks = [left[k : k + chunk] for k in range(0, len(left), chunk)]

    def keep(index: int, figures: Figures) -> None:
        done[index] = figures
        if store is not None:
            _append(Path(store), {"trial": index, "figures": figures})
        step(f"trial {index}")

    if store is not None and not Path(store).exists():
        _append(Path(store), {"study": study})
    if pool is not None:
        _share_out(pool, trial, chunks, keep)
    elif jobs == 1 or len(chunks) < 2:
        with single_threaded():
            for some in chunks:
                for index, figures in zip(some, trial(some), strict=True):
                    keep(index, figures)
    else:
        with processes(jobs) as own:
            _share_out(own, trial, chunks, keep)
    return [done[index] for index in range(count)]


def _share_out(
    pool: Executor,
    trial: Trial,
    chunks: Sequence[Sequence[int]],
    keep: Callable[[int, Figures], None],
) -> None:
    """Run trials in a pool and keep each as soon as it is known."""
    futures = {pool.submit(_collected, trial, chunk): chunk for chunk in chunks}
    for future in as_completed(futures):
        for index, figures in zip(futures[future], future.result(), strict=True):
            keep(index, figures)


def _collected(trial: Trial, chunk: Sequence[int]) -> list[Figures]:
    with single_threaded():
        return list(trial(chunk))


def _append(path: Path, line: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(line) + "\n")
        stream.flush()
        os.fsync(stream.fileno())


def _read(path: Path, study: str, require_whole: Callable[[str, Any], None]) -> dict[int, Figures]:
    """Return the trials in a file; a line that was cut short by a stop is taken off it."""
    if not path.exists():
        return {}
    content = path.read_bytes()
    whole = content[: content.rfind(b"\n") + 1]
    # Of a first line that was cut short nothing is lost, whichever study it was of.
    if not whole and content[: len(_BEGINNING)] != _BEGINNING[: len(content)]:
        raise InputError(f"{path}: not a file of trials (no whole line); name another")
    try:
        lines = [json.loads(line) for line in whole.decode().splitlines()]
        kept = [(int(line["trial"]), line["figures"]) for line in lines[1:]]
        of_study = lines[0]["study"] if lines else study
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as problem:
        raise InputError(f"{path}: not a file of trials ({problem}); name another") from problem
    if of_study != study:
        raise InputError(
            f"{path}: holds the trials of another study (other design, tolerances or seed); "
            "name another file, or delete it"
        )
    for number, (_, figures) in enumerate(kept, start=2):
        require_whole(f"{path}: line {number}", figures)
    if len(whole) < len(content):
        with path.open("r+b") as stream:
            stream.truncate(len(whole))
    if not lines:
        path.unlink()
    return dict(kept)
