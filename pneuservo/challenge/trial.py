"""The trial: cases made and sealed, diagnosed, unsealed and judged; taken up again after a kill."""

import hashlib
import json
import secrets
from collections.abc import Callable
from concurrent.futures import (
    Executor,
    Future,
    ThreadPoolExecutor,
    as_completed,
)
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from analog_card.files import write_whole
from analog_card.plain_json import plain_json
from analog_card.processes import processes
from pneuservo.challenge.answers import ask, keep_answer, kept_answer
from pneuservo.challenge.cases import FOLLOW_UP, HELD_BACK, USED, write_case
from pneuservo.challenge.judge import Judged, judge
from pneuservo.challenge.key import Wish
from pneuservo.challenge.mix import draw_mix
from pneuservo.challenge.score import confusion, measures, wrong
from pneuservo.challenge.seal import seal, sealed_commitment, unseal
from pneuservo.errors import InputError

_PLAN, _PUBLISHED = "plan.json", "commitments.json"
_ATTEMPTS = 5
_MAKER = Path(__file__).parent
Step = Callable[[str], None]


@dataclass(frozen=True)
class Trial:
    """A trial in a folder of its own.

    Parameters
    ----------
    folder : Path
        Everything is in it; it can be copied and taken up elsewhere.
    seed : int
        Draws the mix and every case.
    cases : int
        How many.
    code : str
        Digest of what makes the cases.
    """

    folder: Path
    seed: int
    cases: int
    code: str

    @property
    def ablations(self) -> list[str]:
        """Return the parts of the diagnosis that were left out in turn."""
        return sorted(
            path.name.removeprefix("answers-without-")
            for path in self.folder.glob("answers-without-*")
        )

    @property
    def programs(self) -> list[str]:
        """Return the digests of the programs that were asked: one, when it was frozen."""
        files = sorted(self.folder.glob("answers*/*.json"))
        kept = [kept_answer(file) for file in files]
        return sorted({answer.program for answer in kept if answer is not None})

    @property
    def names(self) -> list[str]:
        """Return the names of the cases."""
        return [f"case-{number:03d}" for number in range(1, self.cases + 1)]

    def wishes(self) -> list[Wish]:
        """Return what each case is to hold."""
        return draw_mix(self.cases, np.random.default_rng(self.seed))

    def case_folder(self, name: str) -> Path:
        """Return what the diagnosis is given."""
        return self.folder / "cases" / name

    def key_file(self, name: str) -> Path:
        """Return where the key is sealed: outside every folder the diagnosis is given."""
        return self.folder / "keys" / f"{name}.json"

    def answer_file(self, name: str, part: str = "", without: str = "") -> Path:
        """Return where an answer is kept."""
        folder = f"answers-without-{without}" if without else "answers"
        return self.folder / folder / f"{name}{part}.json"


def open_trial(folder: Path, cases: int | None, seed: int | None) -> Trial:
    """Begin a trial, or take up the one that a folder holds.

    Parameters
    ----------
    folder : Path
        Its folder.
    cases : int or None
        How many; None takes what the folder holds.
    seed : int or None
        Its seed; drawn by the operating system when None.

    Returns
    -------
    Trial
        Ready to be run.

    Raises
    ------
    InputError
        When the folder holds another trial, or nothing says how many cases there are.
    """
    file = folder / _PLAN
    if file.exists():
        try:
            plan = json.loads(file.read_text(encoding="utf-8"))
            trial = Trial(folder, int(plan["seed"]), int(plan["cases"]), str(plan["code"]))
            if trial.seed < 0 or trial.cases < 1:
                raise ValueError("seed or cases is out of range")
        except (ValueError, KeyError, TypeError) as problem:
            raise InputError(f"{file}: is not the plan of a trial: {problem}") from problem
        if cases not in (None, trial.cases) or seed not in (None, trial.seed):
            raise InputError(
                f"{folder}: holds a trial of {trial.cases} cases with seed {trial.seed}; "
                "leave out --cases and --seed to take it up, or choose another folder"
            )
        return trial
    if cases is None:
        raise InputError(f"{folder}: holds no trial yet; say how many cases it is to have")
    drawn = secrets.randbits(32) if seed is None else seed
    trial = Trial(folder, drawn, cases, code_digest(_MAKER))
    plan = {"seed": trial.seed, "cases": trial.cases, "code": trial.code}
    write_whole(file, json.dumps(plan, indent=2) + "\n")
    return trial


def code_digest(*roots: Path) -> str:
    """Return a digest of all sources and data in some folders, to tell a frozen program by."""
    digest = hashlib.sha256()
    for root in roots:
        for source in sorted([*root.rglob("*.py"), *root.rglob("*.toml")]):
            digest.update(source.relative_to(root.parent).as_posix().encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def make_cases(trial: Trial, jobs: int, step: Step = lambda text: None) -> dict[str, str]:
    """Make the cases that are missing and publish the commitments of all keys.

    Parameters
    ----------
    trial : Trial
        From `open_trial`.
    jobs : int
        Processes.
    step : callable, optional
        Told in words what is done.

    Returns
    -------
    dict of str to str
        Case to commitment.

    Raises
    ------
    InputError
        When keys and commitments differ, or another version of the program made the first cases.
    """
    wishes = dict(zip(trial.names, trial.wishes(), strict=True))
    missing = [name for name in trial.names if not trial.key_file(name).exists()]
    if missing and code_digest(_MAKER) != trial.code:
        raise InputError(
            f"{trial.folder}: its cases were begun by another version of this program; "
            "begin a new trial in another folder"
        )
    # Interrupted, what is being made is finished: that takes seconds.
    with processes(jobs, finish=True) as pool:
        waiting = {
            pool.submit(_make, trial, name, number, wishes[name]): name
            for number, name in enumerate(trial.names)
            if name in missing
        }
        _wait(waiting, pool, lambda name: step(f"made {name}"))
    published = {name: sealed_commitment(trial.key_file(name)) for name in trial.names}
    file = trial.folder / _PUBLISHED
    if file.exists() and _published(trial) != published:
        raise InputError(f"{file}: differs from the keys; make the trial again in a new folder")
    write_whole(file, json.dumps(published, indent=2) + "\n")
    return published


def diagnose_cases(
    trial: Trial, jobs: int, step: Step = lambda text: None, without: str = ""
) -> None:
    """Diagnose the cases that have no answer yet, and hidden ones again with what would show them.

    Parameters
    ----------
    trial : Trial
        Its cases are made.
    jobs : int
        Diagnoses at a time.
    step : callable, optional
        Told in words what is done.
    without : str, optional
        A part of the diagnosis that is left out; its answers are kept apart.
    """
    program = code_digest(_MAKER.parent, _MAKER.parent.parent / "analog_card")
    with ThreadPoolExecutor(jobs) as pool:
        waiting: dict[Future[None], str] = {}
        for name in trial.names:
            for part in ("", *([FOLLOW_UP] if _recordings(trial, name, FOLLOW_UP) else [])):
                file = trial.answer_file(name, f"-{part}" if part else "", without)
                if kept_answer(file) is None:
                    waiting[pool.submit(_diagnose, trial, name, part, without, program)] = name
        _wait(waiting, pool, lambda name: step(f"diagnosed {name}"))


def judge_cases(trial: Trial, without: str = "") -> list[Judged]:
    """Open the keys and judge every case that has an answer.

    Parameters
    ----------
    trial : Trial
        A trial, finished or not.
    without : str, optional
        The part of the diagnosis that was left out.

    Returns
    -------
    list of Judged
        In the order of the cases.

    Raises
    ------
    InputError
        When a key is not the one whose commitment was published.
    """
    published = _published(trial)
    judged = []
    for name in trial.names:
        answer = kept_answer(trial.answer_file(name, without=without))
        if answer is None:
            continue
        key = unseal(trial.key_file(name), published[name])
        further = kept_answer(trial.answer_file(name, f"-{FOLLOW_UP}", without))
        document = further.document if further is not None else None
        judged.append(judge(name, key, answer.document, answer.seconds, document))
    return judged


def _wait(waiting: dict[Future[None], str], pool: Executor, done: Step) -> None:
    """Wait for all; told which is done. What has not begun when it is interrupted never does."""
    try:
        for future in as_completed(waiting):
            future.result()
            done(waiting[future])
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise


def _published(trial: Trial) -> dict[str, str]:
    file = trial.folder / _PUBLISHED
    try:
        published: dict[str, str] = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as problem:
        raise InputError(f"{file}: cannot be read: {problem}") from problem
    if not isinstance(published, dict) or set(published) != set(trial.names):
        raise InputError(f"{file}: does not hold one commitment for each of {trial.cases} cases")
    return published


def _make(trial: Trial, name: str, number: int, wish: Wish) -> None:
    for attempt in range(_ATTEMPTS):
        try:
            key = write_case([trial.seed, number, attempt], wish, trial.case_folder(name))
            break
        except InputError:
            # Some pairs of large effects make a servo that cannot be run: drawn again.
            if attempt == _ATTEMPTS - 1:
                raise
    # The key is written last: a case without one is made again.
    seal(key.document(), trial.key_file(name))


def _diagnose(trial: Trial, name: str, part: str, without: str, program: str) -> None:
    used = _recordings(trial, name, USED)
    if part:
        used += _recordings(trial, name, part)
    held_back = _recordings(trial, name, HELD_BACK)
    scratch = trial.folder / "reports" / "-".join(filter(None, (name, part, without)))
    answer = replace(ask(used, held_back, scratch, without), program=program)
    if answer.interrupted:
        return
    keep_answer(answer, trial.answer_file(name, f"-{part}" if part else "", without))


def _recordings(trial: Trial, name: str, part: str) -> list[Path]:
    return sorted(trial.case_folder(name).glob(f"{part}-*.csv"))


def summary(trial: Trial, judged: list[Judged]) -> dict[str, Any]:
    """Return the score as JSON takes it: shares, figures, confusion, and what went wrong."""
    return {
        "seed": trial.seed,
        "cases": trial.cases,
        "judged": len(judged),
        "programs": trial.programs,
        "measures": [{**plain_json(asdict(line)), "met": line.met} for line in measures(judged)],
        "confusion": confusion(judged),
        "wrong": [plain_json(asdict(case)) for case in wrong(judged)],
    }
