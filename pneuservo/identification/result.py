"""What an identification found: values, intervals, and what cannot be told apart."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pneuservo.arrays import Array
from pneuservo.identification.whiteness import Whiteness
from pneuservo.intervals import INTERVAL

_ALIKE = 0.9
"""Correlation from which two values count as not told apart."""


@dataclass(frozen=True)
class Estimate:
    """One identified value.

    Parameters
    ----------
    value, low, high : float
        With its 95 % interval [unit]; the ends are NaN where a method has none.
    unit : str
        SI unit.
    """

    value: float
    low: float
    high: float
    unit: str

    @property
    def half_width(self) -> float:
        """Return half the width of the interval [unit]."""
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True)
class Identification:
    """What an identification found.

    Parameters
    ----------
    method : str
        ``least-squares``, ``evolution`` or ``output-error``.
    values : mapping of str to Estimate
        By rig parameter.
    correlation : (n, n) array
        Of the estimates, in the order of `values`; NaN where a method has none [-].
    residual : mapping of str to array
        Measured less modelled, by channel, evenly sampled; NaN where nothing was compared [SI].
    whiteness : mapping of str to Whiteness
        Of each residual.
    notes : tuple of str, optional
        Anything that was assumed.
    modelled : mapping of str to array, optional
        Model of each channel [SI].
    time : (k,) array, optional
        Of residual and model [s].
    """

    method: str
    values: Mapping[str, Estimate]
    correlation: Array
    residual: Mapping[str, Array] = field(repr=False)
    whiteness: Mapping[str, Whiteness] = field(repr=False)
    notes: tuple[str, ...] = ()
    modelled: Mapping[str, Array] = field(default_factory=dict, repr=False)
    time: Array = field(default_factory=lambda: np.empty(0), repr=False)

    @property
    def parameters(self) -> dict[str, float]:
        """Return the values alone, as `pneuservo.rigs.Rig.with_values` takes them [SI]."""
        return {name: estimate.value for name, estimate in self.values.items()}

    def rms(self, channel: str) -> float:
        """Return the root mean square of a residual [SI].

        Parameters
        ----------
        channel : str
            One of `residual`.
        """
        return float(np.sqrt(np.nanmean(self.residual[channel] ** 2)))

    def cannot_tell_apart(self) -> list[str]:
        """Return which values the recordings leave undecided, in sentences."""
        names = list(self.values)
        sentences = []
        for i, first in enumerate(names):
            for j, second in enumerate(names[:i]):
                correlation = float(self.correlation[i, j])
                if abs(correlation) >= _ALIKE:
                    sentences.append(self._alike(second, first, correlation))
        for name, estimate in self.values.items():
            if estimate.half_width >= abs(estimate.value):
                sentences.append(
                    f"{name} is not decided: anything from {estimate.low:.3g} to "
                    f"{estimate.high:.3g} {estimate.unit} fits as well. A recording in which it "
                    "matters more is needed, or a value measured by itself."
                )
        if not sentences and np.isfinite(self.correlation).all():
            strongest = float(np.max(np.abs(self.correlation - np.eye(len(names))), initial=0.0))
            sentences.append(
                "All of these can be told apart: the largest correlation between two is "
                f"{strongest:.2f}."
            )
        return sentences

    def _alike(self, first: str, second: str, correlation: float) -> str:
        one, other = self.values[first], self.values[second]
        direction = "up" if correlation > 0.0 else "down"
        return (
            f"{first} and {second} cannot be told apart by these recordings (correlation "
            f"{correlation:.2f}): {first} up by {one.half_width:.2g} {one.unit} with {second} "
            f"{direction} by {other.half_width:.2g} {other.unit} fits about as well. Measure one "
            "of them by itself, or record a motion that treats them differently."
        )


def estimates(
    values: Mapping[str, float], covariance: Array, units: Mapping[str, str]
) -> tuple[dict[str, Estimate], Array]:
    """Return values with their intervals, and the correlations between them.

    Parameters
    ----------
    values : mapping of str to float
        [SI].
    covariance : (n, n) array
        In the order of the values [SI].
    units : mapping of str to str
        SI unit by name.

    Returns
    -------
    estimates : dict of str to Estimate
        By name.
    correlation : (n, n) array
        [-].

    Examples
    --------
    >>> found, correlation = estimates({"m": 2.0}, np.array([[0.01]]), {"m": "kg"})
    >>> round(found["m"].low, 3), correlation.round(3).tolist()
    (1.804, [[1.0]])
    """
    spread = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    scale = np.where(spread > 0.0, spread, 1.0)
    correlation = np.clip(covariance / np.outer(scale, scale), -1.0, 1.0)
    found = {
        name: Estimate(value, value - INTERVAL * s, value + INTERVAL * s, units[name])
        for (name, value), s in zip(values.items(), (float(entry) for entry in spread), strict=True)
    }
    return found, correlation
