"""What the method itself pretends, seen in recordings that its own models have made."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit, explained, orthonormal, rms
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.problem import residuals_of
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.signatures import (
    Signatures,
    gained_beyond,
    signatures_of,
)
from pneuservo.diagnosis.unknowns import values_in_each

FAR = 1000.0
"""What explains more of the sum of squares has changed what others would change."""
_RUNAWAY = 1e9
"""What changes a residual by more standard deviations has run away."""
LIKE_THE_RECORDING = 1.2
"""Times what the recording leaves, or its noise, that a copy leaves at most of any channel: where a
baseline without an effect had strained itself to half a spool's frequency its copies left 1.4 to
2.1 times as much, and an overlap that gained 1,642 would have gained 17,796 of that."""
IMITATIONS = 3
"""Recordings without effect that are made to see what the method itself pretends."""


@dataclass(frozen=True)
class Visibility:
    """How an effect would show.

    Parameters
    ----------
    length : float
        Of its signature at the start's size, in standard deviations of the residuals.
    distinct : float
        Of the part that no refit of the baseline absorbs.
    """

    length: float
    distinct: float


@dataclass(frozen=True)
class _Copy:
    """Recordings that a model has made, and what its own values leave of them."""

    cases: list[Case]
    left: list[Array]


class Pretence:
    """Signatures of all effects and imitations of the recordings, each worked out once.

    Parameters
    ----------
    model, cases, baseline
        What was fitted to what.
    progress : callable
        Told what is being worked out.
    seed : int
        Seed of the noise of the imitations.

    Notes
    -----
    What smoothing and sampling make of a perfect model is no physics. It is the same, by and
    large, in every recording that the model makes on the same path, so that a few tell its size.
    """

    def __init__(
        self,
        model: Model,
        cases: Sequence[Case],
        baseline: Fit,
        progress: Callable[[str], None],
        seed: int,
    ):
        self._model, self._cases, self._baseline = model, cases, baseline
        self._progress, self._seed = progress, seed
        self._imitations: dict[Hypothesis, list[_Copy]] = {}
        self._visible: dict[Hypothesis, dict[str, Visibility]] = {}
        self._usual: dict[Hypothesis, dict[str, float]] = {}
        self._of: dict[tuple[str, Hypothesis], tuple[Fit, Fit, float]] = {}
        self._anew: dict[Hypothesis, Signatures] = {}

    @cached_property
    def signatures(self) -> Signatures:
        """Return what each effect changes in the baseline, by effect id."""
        self._progress("working out what each effect would change")
        return signatures_of(self._model, self._cases, self._baseline)

    def signatures_beside(self, found: Fit) -> Signatures:
        """Return what each effect changes beside a fit, as far as that was worked out."""
        return self._anew.get(found.hypothesis) or self.signatures

    def work_out_beside(self, found: Fit) -> None:
        """Work out what each effect changes beside a fit, where it is far from the baseline.

        Beside a piston that sticks and slips, which the baseline's does not, friction that grows
        with pressure promised 14, from there 263, and gained 393.
        """
        far = explained(self._baseline, found) > FAR
        if far and found.hypothesis not in self._anew:
            self._progress("working out what each effect would change beside what was found")
            self._anew[found.hypothesis] = signatures_of(self._model, self._cases, found)

    def forget(self, hypothesis: Hypothesis) -> None:
        """Forget what was worked out beside a fit that another one has taken the place of.

        Parameters
        ----------
        hypothesis : Hypothesis
            That was fitted.
        """
        for known in (self._imitations, self._visible, self._usual, self._anew):
            known.pop(hypothesis, None)

    def copies(self, fitted: Fit) -> list[Array]:
        """Return what a fit leaves of recordings that its own rig has made.

        Parameters
        ----------
        fitted : Fit
            Of some hypothesis.

        Returns
        -------
        list of (n + t,) array
            Weighted residuals of each copy beyond a refit; see `Fit.beyond_refit`.
        """
        if fitted.hypothesis not in self._imitations:
            self._progress("imitating the recordings with what has been found")
            values = values_in_each(self._cases, self._cases[0], fitted.shared, fitted.own)
            draws = [np.random.default_rng((self._seed, draw)) for draw in range(IMITATIONS)]
            self._imitations[fitted.hypothesis] = side_by_side(
                lambda rng: self._imitated(values, rng), draws
            )
        return [
            fitted.beyond_refit(fitted.weigh(_no_worse(copy.left, fitted.residuals)))
            for copy in self._imitations[fitted.hypothesis]
        ]

    def _imitated(self, values: list[dict[str, float]], rng: np.random.Generator) -> _Copy:
        copies = self._model.imitate(self._cases, values, rng)
        return _Copy(copies, self._left_of(copies, values))

    def _left_of(self, copies: Sequence[Case], values: Sequence[dict[str, float]]) -> list[Array]:
        return [np.nan_to_num(left) for left in residuals_of(self._model, copies, values)]

    def _gained_in_copies(self, beside: Fit, closer: Fit) -> float:
        """Return the most that the values of a closer fit gain of a copy made without them.

        What they change in the recordings has to do with the noise there, for the motion that all
        follows knows the readings to come. In a loop that chatters by less than its noise, other
        noise made 13 of an asymmetric friction that gained 97 where there was nothing; in copies,
        with the noise of each, the same values gained 123. A copy that is not like the recording
        says nothing of that.
        """
        left = self.copies(beside)
        values = values_in_each(self._cases, self._cases[0], closer.shared, closer.own)

        def gained(copy: _Copy, left: Array) -> float:
            changed = beside.weigh(copy.left) - beside.weigh(self._left_of(copy.cases, values))
            beyond = beside.beyond_refit(np.clip(changed, -_RUNAWAY, _RUNAWAY))
            return _gained(orthonormal(beyond[:, np.newaxis]), left)

        of_each = zip(self._imitations[beside.hypothesis], left, strict=True)
        faithful = [each for each in of_each if _is_like(each[0], beside)]
        return max(side_by_side(lambda one: gained(*one), faithful), default=0.0)

    def visible(self, beside: Fit) -> dict[str, Visibility]:
        """Return how each effect would show in the recordings, by effect id.

        Parameters
        ----------
        beside : Fit
            What it would be added to.
        """
        if beside.hypothesis not in self._visible:
            shown = self.signatures_beside(beside)
            found = side_by_side(lambda variants: _visibility(beside, variants), shown.values())
            self._visible[beside.hypothesis] = dict(zip(shown, found, strict=True))
        return self._visible[beside.hypothesis]

    def _by_signature(self, name: str, beside: Fit) -> float:
        """Return what the signature of an effect gains of the copies; worked out once."""
        known, shown = self._usual.setdefault(beside.hypothesis, {}), self.signatures_beside(beside)
        if name in shown and name not in known:
            imitations = self.copies(beside)
            known[name] = gained_beyond(beside, shown[name], imitations) if imitations else 0.0
        return known.get(name, 0.0)

    def of(self, name: str, beside: Fit, closer: Fit) -> float:
        """Return what a candidate seems to gain where there is nothing of the kind.

        Parameters
        ----------
        name : str
            The candidate.
        beside, closer : Fit
            Without and with it.

        Returns
        -------
        float
            The largest of what its signatures, what it does to the recordings at its fitted size
            and what it does to the copies would gain; of a parameter, what leaving its tolerance
            would.
        """
        if "imitations" in self._model.without:
            return 0.0
        known = self._of.get((name, beside.hypothesis))
        if known is None or known[0] is not beside or known[1] is not closer:
            found = self._worked_out(name, beside, closer)
            known = self._of[name, beside.hypothesis] = beside, closer, found
        return known[2]

    def _worked_out(self, name: str, beside: Fit, closer: Fit) -> float:
        if name.startswith("param."):
            parameter = name.removeprefix("param.")
            return max((beside.loosened(parameter, c) for c in self.copies(beside)), default=0.0)
        change = beside.weighted - beside.weigh(closer.residuals)
        scale = closer.row_scale() / beside.row_scale()
        columns = closer.sensitivities(name) * scale[:, np.newaxis]
        span = orthonormal(beside.beyond_refit(np.column_stack([change, columns])))
        fitted = max((_gained(span, copy) for copy in self.copies(beside)), default=0.0)
        usual = self._by_signature(name, beside)
        return max(fitted, usual, self._gained_in_copies(beside, closer))


def _gained(span: Array, left: Array) -> float:
    """Return by how much orthonormal columns lower the sum of squares of what is left."""
    return float(np.sum((span.T @ left) ** 2))


def _no_worse(left: Sequence[Array], recorded: Sequence[Array]) -> list[Array]:
    """Return what copies leave, nowhere more than the recording leaves of that channel somewhere.

    Where the recorded piston creeps that of a copy may stick and slip, which its motion does not
    tell: such moments left 27 times the noise, the recording nowhere more than 5 times, and an
    overlap that gained 1,183 had to explain 1,528 for them.
    """
    most = [float(np.max(np.abs(each), initial=0.0)) for each in recorded]
    return [np.clip(each, -limit, limit) for each, limit in zip(left, most, strict=True)]


def _is_like(copy: _Copy, beside: Fit) -> bool:
    """Return whether a copy leaves hardly more of any channel than the recording or its noise."""
    both = zip(copy.cases, copy.left, beside.residuals, strict=True)
    return all(
        rms([left]) < LIKE_THE_RECORDING * max(rms([there]), 1.0)
        for case, left, there in both
        if case.recorded
    )


def _visibility(base: Fit, variants: Sequence[Array]) -> Visibility:
    first = base.counted(variants[0][:, 0])
    rest = base.beyond_refit(first)
    return Visibility(float(np.linalg.norm(first)), float(np.linalg.norm(rest)))
