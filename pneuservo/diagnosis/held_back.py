"""What was found, asked of recordings that were held back: nothing shared is fitted to them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit, explained, rms
from pneuservo.diagnosis.fitting import fit, refitted
from pneuservo.diagnosis.followed import likeliest_held_back
from pneuservo.diagnosis.judge import LEAST_GAIN
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Table
from pneuservo.diagnosis.tabulated import Tabulated, of_channels, without_table

BEYOND_DOUBT = 10.0 * LEAST_GAIN
"""What explains more is there, even if its size or form does not suit what was held back: three
of 20 true effects of another simulator, of 970 to 4,200, made that worse; of less than 500 none of
14 did, and ten of 13 false ones."""
SHOWS = 3.0**2
"""Energy of what has to change in what was held back for that to have a say: three standard
deviations."""


NOT_BORNE_OUT = 1.5
"""Times its noise that a channel of what was held back is left at by a law that is not the right
one, where it leaves no more than noise of what was used: the remanence of a motor, called a
hysteresis, 1.9. (Of 37 blind cases none but one with twice the noise in what was used was above
1.15.)"""
NOT_ITS_FORM = 0.05
"""... and the share of what is there without it: forms of laws leave that at most."""
_PLACE = "displacement"
"""A piston that lies at a stop reads where that is, which what was used may not have told."""


@dataclass(frozen=True)
class HeldBack:
    """Recordings to which nothing shared is fitted.

    Parameters
    ----------
    model : Model
        Of their rig.
    cases : sequence of Case
        Prepared, as they are best read.
    used : sequence of Case
        What was fitted to.
    """

    model: Model
    cases: Sequence[Case]
    used: Sequence[Case]
    _read: dict[int, tuple[Fit, "HeldBack"]] = field(default_factory=dict, repr=False)
    _predicted: dict[int, tuple[Fit, Fit]] = field(default_factory=dict, repr=False)

    def read_with(self, found: Fit, table: Table | None = None) -> "HeldBack":
        """Return them as they are best read and followed with what was found; read once."""
        known = self._read.get(id(found))
        if known is None or known[0] is not found:
            what = _that_repeats(found, table)
            cases = likeliest_held_back(self.model, self.cases, what, self.used[0])
            read = HeldBack(self.model, self.model.told(cases, self.used), self.used)
            known = self._read[id(found)] = found, read
        return known[1]

    def predicted(self, found: Fit, table: Table | None = None) -> Fit:
        """Return a fit's prediction, with the recordings' own values alone fitted to them.

        Parameters
        ----------
        found : Fit
            Of what was used.
        table : Table, optional
            That stands in it; if every recording has one of its own, so have these.
        """
        asked = self._predicted.get(id(found))
        if asked is None or asked[0] is not found:
            asked = self._predicted[id(found)] = found, self._worked_out(found, table)
        return asked[1]

    def _worked_out(self, found: Fit, table: Table | None) -> Fit:
        known = _that_repeats(found, table)
        prediction = fit(
            self.model, self.cases, known.hypothesis, fixed=known.shared, reference=self.used[0]
        )
        if table is None or not table.own:
            return prediction
        base = of_channels(self.cases, prediction)
        tabulated = Tabulated(self.model, self.cases, table, self.used[0])
        return tabulated.fitted(base, tabulated.changes(base))[0]

    def refute(self, before: Fit, after: Fit) -> bool:
        """Return whether a name that was added to a fit is to be taken back.

        It is where it predicts worse, unless it explains far more than chance could.

        Parameters
        ----------
        before, after
            As for `are_predicted_worse`.
        """
        small = explained(before, after) < BEYOND_DOUBT
        # Without the name a wrong parameter is nearly as wrong: strained, it predicts as much.
        a_parameter = before.hypothesis.effects == after.hypothesis.effects
        return small and self.are_predicted_worse(before, after, SHOWS if a_parameter else 0.0)

    def are_predicted_worse(
        self, before: Fit, after: Fit, by: float = 0.0, table: Table | None = None
    ) -> bool:
        """Return whether they are predicted worse by what was found on top of a fit.

        Parameters
        ----------
        before, after : Fit
            Of what is used, without and with it.
        by : float, optional
            So much more of the sum of squares has to be left.
        table : Table, optional
            That stands in what was found.

        Returns
        -------
        bool
            False where nothing of it would show in them.
        """
        if not self.cases:
            return False
        read = self.read_with(after, table)
        without, with_it = read.predicted(before), read.predicted(after, table)
        if table is not None and table.own:
            without = of_channels(read.cases, without)
        # In weights of what was used: what is predicted wrongly must not pass for noise.
        known = {c: after.scale[c] for c in with_it.scale if c in after.scale}
        with_it = with_it.in_weights({**with_it.scale, **known})
        change = with_it.weighted - with_it.weigh(without.residuals)
        return float(np.sum(change**2)) > SHOWS and explained(without, with_it) < -by


def times_missed(cases: Sequence[Case], before: Sequence[Array], after: Sequence[Array]) -> float:
    """Return how many times its noise a law misses recordings, if it is refuted by that.

    Parameters
    ----------
    cases : sequence of Case
        The recordings.
    before, after : sequence of array
        What is left of each without and with what was found.

    Returns
    -------
    float
        Of the channel that is missed most, but for the displacement; 0 where all are followed, or
        as well as a law of somewhat another form would.
    """
    worst = 0.0
    for case, first, second in zip(cases, before, after, strict=True):
        left, beyond = rms([second]), max(rms([first]) ** 2 - 1.0, 0.0)
        if case.recorded and case.channel != _PLACE and left**2 - 1.0 > NOT_ITS_FORM * beyond:
            worst = max(worst, left)
    return worst if worst > NOT_BORNE_OUT else 0.0


def times_missed_at_best(
    held_back: HeldBack, baseline: Fit, found: Fit, before: Fit, after: Fit
) -> float:
    """Return how many times its noise a law misses what was held back, whatever its sizes.

    Parameters
    ----------
    held_back : HeldBack
        As it is read with what was found.
    baseline, found : Fit
        Of what was used, without and with the law.
    before, after : Fit
        Prediction of what was held back, without and with the law.

    Returns
    -------
    float
        As `times_missed` has it; 0 also where the law explains all recordings when it is fitted to
        all of them: what was used may not tell a size as well as another load or way would.
    """
    times = times_missed(held_back.cases, before.residuals, after.residuals)
    if not times:
        return 0.0
    everything = [*held_back.used, *held_back.cases]
    without = [*baseline.residuals, *before.residuals]
    together = refitted(held_back.model, everything, found)
    return times if times_missed(everything, without, together.residuals) else 0.0


def _that_repeats(found: Fit, table: Table | None) -> Fit:
    """Return what was found but for a table that is another in every recording."""
    return found if table is None or not table.own else without_table(found, table)
