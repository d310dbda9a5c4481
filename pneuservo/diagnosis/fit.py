"""What a hypothesis fitted to recordings is: its values, what they leave, and how sure they are."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models.model import Values
from pneuservo.diagnosis.problem import own_key
from pneuservo.intervals import INTERVAL

_FARTHER = 1.5
"""A channel that is left at so many times what less freedom left of it is missed far more."""


@dataclass(frozen=True)
class Fit:
    """A hypothesis fitted to recordings.

    Parameters
    ----------
    hypothesis : Hypothesis
        What was allowed to change.
    shared : mapping of str to float
        Fitted values that hold for every recording.
    intervals : mapping of str to (low, high)
        95 % intervals of the shared values.
    own : sequence of mapping
        Fitted values of each recording alone.
    channels : sequence of str
        Channel of each residual.
    residuals : sequence of array
        Measured minus modelled, usable samples only [unit of the cases].
    rms : float
        Root mean square of all residuals together [unit of the cases].
    samples : int
        Number of samples.
    effective : mapping of str to float
        What the samples of each channel are worth after serial correlation.
    finest : mapping of str to float
        Residual below which the fit of a channel is perfect [unit of its cases].
    known : frozenset of str
        Channels whose spread is known: what they leave is no measure of it.
    unknowns : int
        How many numbers were fitted.
    penalty : float
        Squared distance of tolerated parameters from their nominal values, in tolerances.
    """

    hypothesis: Hypothesis
    shared: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    own: tuple[dict[str, float], ...]
    channels: tuple[str, ...]
    residuals: tuple[Array, ...]
    rms: float
    samples: int
    effective: Mapping[str, float]
    finest: Mapping[str, float]
    known: frozenset[str]
    unknowns: int
    penalty: float
    scale: Mapping[str, float]
    """What one residual of each channel counts as one standard deviation."""
    keys: tuple[str, ...]
    """Name of each column of `sensitivity`."""
    units: Array = field(repr=False)
    """What one unit of each column is [SI]."""
    bounds: tuple[Array, Array] = field(repr=False)
    """Lowest and highest value of each column, in these units."""
    vector: Array = field(repr=False)
    """Solution, in these units."""
    owners: tuple[int, ...]
    """Case whose own values each case has."""
    tolerated: tuple[str, ...]
    """Values that are known within a tolerance."""
    distance: Array = field(repr=False)
    """How far the tolerated values are from nominal, in tolerances."""
    sensitivity: Array = field(repr=False)
    """Of all weighted residuals and then of `distance` to all values, in units of the fit."""
    covariance: Array = field(repr=False)
    """Covariance of the shared and then all own values [SI]."""

    def interval_of(
        self, quantity: Callable[[Values, Values], float]
    ) -> tuple[float, float, float]:
        """Return a quantity that follows from the fitted values, and its 95 % interval.

        Parameters
        ----------
        quantity : callable
            Takes the shared values and the own values of the first recording.

        Returns
        -------
        value, low, high : float
            From the linearised spread of the fitted values.
        """
        keys = [*((0, key) for key in self.shared), *((1, key) for key in self.own[0])]
        values = (dict(self.shared), dict(self.own[0]))
        centre, slopes = quantity(*values), []
        for i, (group, key) in enumerate(keys):
            step = 1e-3 * float(np.sqrt(max(self.covariance[i, i], 0.0))) or 1e-12
            moved = tuple(
                {**v, key: v[key] + step} if g == group else v for g, v in enumerate(values)
            )
            slopes.append((quantity(*moved) - centre) / step)
        slope, size = np.array(slopes), len(keys)
        spread = max(0.0, float(slope @ self.covariance[:size, :size] @ slope))
        half = INTERVAL * float(np.sqrt(spread))
        return centre, centre - half, centre + half

    def sensitivities(self, member: str) -> Array:
        """Return the columns of the Jacobian that belong to an effect or a ``param.`` id."""
        parameter = member.removeprefix("param.")
        columns = [
            i for i, key in enumerate(self.keys) if key == parameter or key.startswith(f"{member}:")
        ]
        return self.jacobian[:, columns]

    def moved(self, step: Array) -> tuple[dict[str, float], list[dict[str, float]]]:
        """Return the shared and own values after a step.

        Parameters
        ----------
        step : (m,) array
            In units of the fit, one number per column of `sensitivity`; it ends at the bounds.
        """
        low, high = self.bounds
        taken = np.clip(self.vector + step, low, high) - self.vector
        by_key = dict(zip(self.keys, (taken * self.units).tolist(), strict=True))
        shared = {key: value + by_key.get(key, 0.0) for key, value in self.shared.items()}
        own = [
            {key: value + by_key.get(own_key(key, place), 0.0) for key, value in values.items()}
            for place, values in zip(self.owners, self.own, strict=True)
        ]
        return shared, own

    def stepped(self, step: Array) -> "Fit":
        """Return the fit with its values after a step; what it leaves is still that of before.

        Parameters
        ----------
        step : (m,) array
            As for `moved`.
        """
        low, high = self.bounds
        vector = np.clip(self.vector + step, low, high)
        shared, own = self.moved(step)
        distance = self.distance + self.sensitivity[self.samples :] @ (vector - self.vector)
        return replace(
            self,
            shared=shared,
            own=tuple(own),
            vector=vector,
            distance=distance,
            penalty=float(np.sum(distance**2)),
        )

    @property
    def jacobian(self) -> Array:
        """Return the sensitivity of the weighted residuals alone."""
        return self.sensitivity[: self.samples]

    @property
    def weighted(self) -> Array:
        """Return all residuals, each counted in the spread of its channel."""
        return self.weigh(self.residuals)

    def weigh(self, parts: Sequence[Array]) -> Array:
        """Return residuals or changes of them, each counted in the spread of its channel."""
        return self.counted(np.concatenate(parts))

    def counted(self, changes: Array) -> Array:
        """Return changes of all residuals, each counted in the spread of its channel.

        Parameters
        ----------
        changes : (n,) or (n, k) array
            In the unit of the residuals.
        """
        return np.asarray((changes.T / self.row_scale()).T)

    def row_scale(self) -> Array:
        """Return what each residual counts as one."""
        return np.concatenate(
            [
                np.full(len(part), self.scale[c])
                for part, c in zip(self.residuals, self.channels, strict=True)
            ]
        )

    def in_weights(self, scale: Mapping[str, float]) -> "Fit":
        """Return this fit with its residuals counted in other units.

        Parameters
        ----------
        scale : mapping of str to float
            What one residual of each channel counts as one standard deviation.
        """
        if scale == self.scale:
            return self
        rows = self.row_scale()
        other = replace(self, scale=scale)
        sensitivity = self.sensitivity.copy()
        sensitivity[: self.samples] *= (rows / other.row_scale())[:, np.newaxis]
        return replace(other, sensitivity=sensitivity)

    @cached_property
    def in_noise(self) -> "Fit":
        """Return this fit with every residual counted in the noise of its channel alone."""
        return self.in_weights(dict.fromkeys(self.scale, 1.0))

    @property
    def left(self) -> Array:
        """Return weighted residuals, and below them the distances of tolerated values."""
        return np.concatenate([self.weighted, self.distance])

    @cached_property
    def unabsorbed(self) -> Array:
        """Return what is left beyond what a refit would absorb if all were linear."""
        return self.unabsorbed_of(self.left)

    @cached_property
    def absorbed(self) -> Array:
        """Return an orthonormal basis of what a refit absorbs, rows as those of `sensitivity`."""
        return orthonormal(self.sensitivity)

    def beyond_refit(self, columns: Array) -> Array:
        """Return weighted residuals, or changes of them, without what a refit would absorb.

        Parameters
        ----------
        columns : (n,) or (n, k) array
            Weighted residuals, or changes of them.

        Returns
        -------
        (n + t,) or (n + t, k) array
            Rows of the tolerated values below those of the residuals.
        """
        whole = np.concatenate([columns, np.zeros((len(self.distance), *columns.shape[1:]))])
        return self.unabsorbed_of(whole)

    def unabsorbed_of(self, whole: Array) -> Array:
        """Return what a refit would not absorb of residuals with distances below them.

        Parameters
        ----------
        whole : (n + t,) or (n + t, k) array
            Rows as those of `sensitivity`.
        """
        return np.asarray(whole - self.absorbed @ (self.absorbed.T @ whole))

    def loosened(self, parameter: str, left: Array) -> float:
        """Return what forgetting the tolerance of a parameter would gain: one row less to fit.

        Parameters
        ----------
        parameter : str
            Its id.
        left : (n + t,) array
            Weighted residuals beyond a refit; see `beyond_refit`.
        """
        if parameter not in self.tolerated:
            return 0.0
        row = self.samples + self.tolerated.index(parameter)
        return float(left[row] ** 2) / max(1.0 - self.leverage(parameter), 1e-9)

    def leverage(self, parameter: str) -> float:
        """Return the variance that is left to a parameter, as a share of its tolerance squared.

        Parameters
        ----------
        parameter : str
            Its id; one of those that are tolerated.
        """
        row = self.samples + self.tolerated.index(parameter)
        return float(np.sum(self.absorbed[row] ** 2))

    @property
    def all_effective(self) -> float:
        """Return what all samples together are worth."""
        return sum(self.effective.values())

    def samples_of(self, channel: str) -> int:
        """Return the number of samples of one channel."""
        there = zip(self.residuals, self.channels, strict=True)
        return sum(len(part) for part, c in there if c == channel)

    def rms_of(self, channel: str) -> float:
        """Return the root mean square of what one channel leaves [unit of its cases]."""
        return max(self._spread_of(channel), self.finest[channel])

    def information_criterion(self, effective: Mapping[str, float]) -> float:
        """Return the Bayesian information criterion: lower is better, 10 is decisive.

        Parameters
        ----------
        effective : mapping of str to float
            What the samples of each channel are worth; the same for all that are compared.
        """
        misfit = sum(worth * self._misfit_of(channel) for channel, worth in effective.items())
        return misfit + self.unknowns * float(np.log(sum(effective.values()))) + self.penalty

    def _misfit_of(self, channel: str) -> float:
        """Return twice the negative log-likelihood of one independent sample, but for a constant.

        The spread is what the channel leaves; where it is known that would make little of a few
        samples that are far off.
        """
        if channel in self.known:
            return (self._spread_of(channel) / self.finest[channel]) ** 2
        return float(np.log(self.rms_of(channel) ** 2))

    def _spread_of(self, channel: str) -> float:
        return rms([r for r, c in zip(self.residuals, self.channels, strict=True) if c == channel])


def orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis of some columns; those that are nothing are left out.

    Parameters
    ----------
    columns : (n, k) array
        In any scale.
    """
    sizes = np.linalg.norm(columns, axis=0)
    kept = sizes > 0.0
    basis: Array = np.linalg.qr(columns[:, kept] / sizes[kept])[0]
    return basis


def explained(before: Fit, after: Fit, best: Fit | None = None) -> float:
    """Return by how much all that is minimised falls from one fit to a closer one.

    Parameters
    ----------
    before, after : Fit
        Of the same recordings.
    best : Fit, optional
        Whose weights count, where several are to be compared; those of `after` without it.

    Notes
    -----
    In the weights of the closer one: a misfit that it removes no longer counts as noise. What a
    parameter has to leave its tolerance for explains that much less.
    """
    first, second = ((best or after).weigh(found.residuals) for found in (before, after))
    return float(np.sum(first**2) - np.sum(second**2)) + before.penalty - after.penalty


def gained_most(before: Fit, after: Fit) -> float:
    """Return what a fit gains in the weights in which it gains most, as promises are made.

    Parameters
    ----------
    before, after : Fit
        Of the same recordings.

    Returns
    -------
    float
        In the weights of the closer fit or in those of the noise alone; see `explained`.
    """
    in_noise = replace(after, scale=dict.fromkeys(after.scale, 1.0))
    return max(explained(before, after), explained(before, after, in_noise))


def misses_more(before: Fit, after: Fit) -> bool:
    """Return whether a fit of more freedom misses a channel far more than the one before it did.

    Parameters
    ----------
    before, after : Fit
        Of the same recordings.

    Notes
    -----
    What a fit misses counts as noise, so that it may settle where it misses one channel for the
    sake of another. (A spring beside a leak brought the pressures from 2.1 to 1.2 times their noise
    and the displacement from 1.4 to 5.6; from the nominal parameters on, to 1.1.)
    """
    return any(after.rms_of(c) > _FARTHER * before.rms_of(c) for c in before.effective)


def rms(residuals: Sequence[Array]) -> float:
    """Return the root mean square of several residuals together.

    Parameters
    ----------
    residuals : sequence of array
        In one unit.
    """
    return float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)))
