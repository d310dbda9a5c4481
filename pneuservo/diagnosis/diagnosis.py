"""The diagnosis of a set of recordings: four questions and their answers."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pneuservo.diagnosis.as_found import as_found
from pneuservo.diagnosis.enough_samples import require_enough_judged, require_enough_numbers
from pneuservo.diagnosis.first_name import with_first_name
from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.held_back import HeldBack
from pneuservo.diagnosis.judge import SMALLEST_SHARE
from pneuservo.diagnosis.ledger import Step
from pneuservo.diagnosis.locate import Dependence, strongest_dependence
from pneuservo.diagnosis.models import Case, Model, model_of
from pneuservo.diagnosis.models.model import Misfit
from pneuservo.diagnosis.refuted import lack_of_fit, not_borne_out
from pneuservo.diagnosis.rivals import SUREST
from pneuservo.diagnosis.search import UNKNOWN_BETWEEN_SAMPLES, Search
from pneuservo.diagnosis.side_by_side import at_a_time, side_by_side
from pneuservo.diagnosis.strained import are_many_strained
from pneuservo.diagnosis.unexplained import WORTH_SAYING, Unexplained, find_unexplained
from pneuservo.errors import InputError
from pneuservo.naming import require_known
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig, load_rig

SUSPICIOUS_RATIO = 1.5
"""Residual over noise beyond which what is left may be more than noise ..."""
OBVIOUS_RATIO = 6.0
"""... and beyond which it is; coloured noise reaches 4 times its own floor."""
UNNAMED = 0.5
"""Share of what is left that has to depend on one quantity before the named effects are doubted."""
PARTS = ("stick-mask", "nuisances", "imitations", "unnamed")
"""Parts of the diagnosis of a servo that can be left out, to see what they are good for."""
COLOURED = 0.2
"""A residual worth fewer than this share of its samples is coloured."""


_MORE = "something without a name explains more"


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `document` makes the answer of it.

    Parameters
    ----------
    rig : Rig
        The rig the recordings belong to.
    model : Model
        Its model.
    search : Search
        Everything that was tried.
    held_back : sequence of Case
        Prepared recordings that were kept out of the fits.
    before_held_back, after_held_back : Fit or None
        Baseline and repaired model on them, only the recordings' own values fitted.
    unexplained : Unexplained or None
        What has no name, as a table, where the model has tables and something is left.
    misfit : Misfit or None
        What is no noise though neither a name nor a table explains it.
    jobs : int
        So many fits were done at a time, and are by `document`.
    """

    rig: Rig
    model: Model
    search: Search
    held_back: Sequence[Case]
    before_held_back: Fit | None
    after_held_back: Fit | None
    unexplained: Unexplained | None = None
    misfit: Misfit | None = None
    jobs: int = 1

    @property
    def repaired(self) -> Fit:
        """Return the model with everything that was found, named or not."""
        return self.search.chosen if self.unexplained is None else self.unexplained.fit

    @property
    def verdict(self) -> str:
        """Return consistent, parameter, missing-physics or unexplained."""
        accepted = self.search.accepted
        if self.misfit is not None and self.misfit.refutes:
            return "unexplained"
        if self.named_table or any(not member.startswith("param.") for member in accepted):
            return "missing-physics"
        if self.holds_nameless:
            return "unexplained"
        if accepted:
            return "parameter"
        # What was not searched to the end is only consistent where nothing is left to be found.
        cut_short = self.search.interrupted and not self.search.leaves_noise(self.search.chosen)
        return "unexplained" if cut_short or self.structure_remains else "consistent"

    @property
    def named_table(self) -> Unexplained | None:
        """Return the table that was found, if it is a form of an effect of the catalogue."""
        found = self.unexplained
        return found if found is not None and found.table.form_of else None

    @property
    def holds_nameless(self) -> bool:
        """Return whether something without a name was found, as a table or as a misfit."""
        return self.misfit is not None or self.unexplained is not self.named_table

    @property
    def suspects(self) -> Mapping[str, float]:
        """Return the blocks that what is left may belong to, with their shares of it."""
        if self.misfit is not None:
            return {self.misfit.block: 1.0}
        search = self.search
        return self.model.suspects(search.cases, search.chosen.residuals, search.noise)

    @cached_property
    def structure_remains(self) -> bool:
        """Return whether the repaired model leaves more than noise behind.

        Noise whose size is known, or a residual far above its floor, decides at once. Between
        them only a coloured residual counts that depends on something that was recorded: noise
        may be coloured too, but it does not know where the piston is.
        """
        ratio = self._times_noise
        if ratio < SUSPICIOUS_RATIO:
            return False
        recorded = [case for case in self.search.cases if case.recorded]
        known = all(case.channel in case.recording.noise_rms for case in recorded)
        if known or ratio > OBVIOUS_RATIO:
            return True
        left = self.repaired
        if left.all_effective > COLOURED * left.samples:
            return False
        return self.left_over.beyond_chance

    @property
    def _times_noise(self) -> float:
        """Return how many times its noise the recorded channel is left at that is farthest off."""
        search = self.search
        noise: dict[str, list[float]] = {}
        for case, level in zip(search.cases, search.unit_of_noise, strict=True):
            if case.recorded:
                noise.setdefault(case.channel, []).append(level)
        return max(
            self.repaired.rms_of(channel) / float(np.sqrt(np.mean(np.square(levels))))
            for channel, levels in noise.items()
        )

    @cached_property
    def left_over(self) -> Dependence:
        """Return what the residual of the repaired model depends on most."""
        search = self.search
        return strongest_dependence(
            search.model, search.cases, self.repaired.residuals, search.seed
        )

    @cached_property
    def unnamed_share(self) -> float:
        """Return the share of the mismatch that depends on one recorded quantity and has no name.

        Zero unless that quantity explains more than half of what the chosen model leaves.
        """
        if self.named_table is not None:
            return 0.0
        if self.unexplained is not None:
            return self.unexplained.share
        if self.misfit is not None and self.misfit.refutes:
            return SUREST
        if self.misfit is not None:
            return self.misfit.energy / (self.misfit.energy + _named(self.search))
        if not self.structure_remains or not self.left_over.beyond_chance:
            return 0.0
        if self.left_over.share < UNNAMED:
            return 0.0
        share = self.left_over.share * self.search.unexplained_share(self.search.chosen)
        return share if share > SMALLEST_SHARE else 0.0

    @property
    def only_followed(self) -> list[str]:
        """Return the names of recordings whose command is not known well enough to judge them by.

        What it did between its samples decided what the pressures did.
        """
        followed = self.search.only_followed(self.repaired)
        origins = {id(case.origin): case.recording for case in self.search.cases}
        return [recording.name for each, recording in origins.items() if each in followed]

    @property
    def cases(self) -> list[Case]:
        """Return all recordings, the ones held back last."""
        return [*self.search.cases, *self.held_back]


def diagnose(
    recordings: Sequence[Recording],
    validate: Sequence[Recording] = (),
    rig: str | Path | Rig | None = None,
    progress: Callable[[str], None] = lambda step: None,
    seed: int = 0,
    without: Sequence[str] = (),
    jobs: int = 1,
) -> Diagnosis:
    """Compare recordings of one rig with its baseline and say what the baseline lacks.

    Parameters
    ----------
    recordings : sequence of Recording
        Recordings to learn from, at least one.
    validate : sequence of Recording, optional
        Recordings to be held back: nothing shared is fitted to them, and what little explains the
        others is only named where it explains these as well.
    rig : str, Path or Rig, optional
        The rig, where it is not the one the recordings name; also a repaired ``model.toml``.
    progress : callable, optional
        Told in words what is running.
    seed : int, optional
        Seed of the noise that chance is judged by.
    without : sequence of str, optional
        Parts of the diagnosis of a servo that are left out, of `PARTS`.
    jobs : int, optional
        So many fits at a time; the answer does not depend on it.

    Returns
    -------
    Diagnosis
        What was found.

    Raises
    ------
    InputError
        When the recordings belong to different rigs, lack a channel, or the diagnosis does not
        cover the rig.
    FitError
        When the baseline cannot be fitted at all.
    KeyboardInterrupt
        When it is interrupted before the baseline is fitted; later, and once more while it
        predicts what was held back, the answer is made of what has been fitted until then.
    """
    if not recordings:
        raise InputError("no recording was given; name at least one file")
    chosen_rig = _common_rig([*recordings, *validate], rig)
    for part in without:
        require_known(part, PARTS, "part of the diagnosis")
    model = model_of(chosen_rig.kind, frozenset(without))
    # Models other than those run by kernels share what they simulate with, and would only wait.
    jobs = jobs if model.steady else 1
    with at_a_time(jobs):
        prepared = side_by_side(
            lambda recording: _prepare(model, recording, chosen_rig), [*recordings, *validate]
        )
        cases, held_back = (
            [case for own in group for case in own]
            for group in (prepared[: len(recordings)], prepared[len(recordings) :])
        )
        before = after = None
        search = as_found(with_first_name(Search(model, cases, progress, seed)))
        kept_out = HeldBack(model, held_back, search.cases)
        unexplained = misfit = None
        if not search.interrupted:
            with search.kept_when_interrupted():
                search.name_what_relieves(kept_out)
                search.name_wrong_parameters()
                search.drop_what_was_only_followed()
                search.drop_refuted(kept_out)
                search.profile()
                unexplained, misfit = _unexplained(search, kept_out)
                if unexplained is None and misfit is None:
                    misfit = lack_of_fit(search)
        repaired = search.chosen if unexplained is None else unexplained.fit
        if held_back:
            table = None if unexplained is None else unexplained.table
            with search.kept_when_interrupted():
                progress("predicting what was held back")
                kept_out = kept_out.read_with(repaired, table)
                before, after = (
                    kept_out.predicted(search.baseline),
                    kept_out.predicted(repaired, table),
                )
                if unexplained is None and misfit is None:
                    misfit = not_borne_out(search, kept_out, before, after)
    return Diagnosis(
        chosen_rig, model, search, kept_out.cases, before, after, unexplained, misfit, jobs
    )


def _unexplained(search: Search, held_back: HeldBack) -> tuple[Unexplained | None, Misfit | None]:
    """Return what has no name, as a table or else as what it looks like.

    Where it explains far more than the names do, or is more, they are dropped.
    """
    model, cases = search.model, search.cases
    if "unnamed" in model.without or not model.tabulates:
        return None, None
    search.progress("looking for what has no name")
    misfit = model.misfit(cases, search.chosen.residuals)
    if misfit is not None and misfit.energy < WORTH_SAYING * (misfit.energy + _named(search)):
        misfit = None
    found = find_unexplained(
        model,
        cases,
        # A table that the rig has already is one of its effects: it would be replaced, not mended.
        [table for table in model.tables(cases) if table.effect not in cases[0].rig.effects],
        search.baseline,
        search.chosen,
        search.pretence.copies,
    )
    if found is not None:
        why = _speaks_against(search, held_back, found)
        if why:
            members, what = tuple(search.accepted), f"a table of {found.table.what}"
            search.ledger.append(Step(members, "", True, what, why=why))
            found = None
    if found is not None and (misfit is None or found.gain > misfit.energy):
        if found.instead:
            search.give_up(_MORE)
        return found, None
    if misfit is not None and misfit.energy > _named(search):
        search.give_up(_MORE)
    return None, misfit


def _speaks_against(search: Search, held_back: HeldBack, found: Unexplained) -> str:
    """Return why a table is not to be believed; nothing where it is."""
    beside = search.baseline if found.instead else search.chosen
    # Whatever a table explains: it can follow what no law would.
    if held_back.are_predicted_worse(beside, found.fit, table=found.table):
        return "what was held back is predicted worse with it"
    if are_many_strained(found.fit):
        return "it strains many parameters of the rig: they make up for something else"
    judged = search.are_judged(found.fit)
    if not judged and search.gained_where_judged(beside, found.fit) < found.table.least_gain:
        return UNKNOWN_BETWEEN_SAMPLES
    return ""


def _named(search: Search) -> float:
    """Return what the names explain, in noise."""
    return max(explained(search.baseline, search.chosen, search.chosen.in_noise), 0.0)


def _prepare(model: Model, recording: Recording, rig: Rig) -> list[Case]:
    rig = rig.with_conditions(recording.conditions)
    require_enough_numbers(recording, model.unread)
    recording = model.completed(recording, rig)
    model.require_channels(recording)
    cases = model.cases(model.with_word_of_unread(recording), rig)
    require_enough_judged(cases)
    return cases


def _common_rig(recordings: Sequence[Recording], rig: str | Path | Rig | None) -> Rig:
    if isinstance(rig, Rig):
        return rig
    if rig is not None:
        return load_rig(rig)
    names = sorted({recording.rig for recording in recordings})
    if len(names) > 1:
        raise InputError(
            f"the recordings belong to different rigs ({', '.join(names)}); "
            "diagnose one rig at a time, or name the one meant with --rig"
        )
    return load_rig(names[0])
