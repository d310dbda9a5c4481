"""Whether what a fit leaves over is white, as noise would be."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.intervals import INTERVAL

_LAGS = 20
_DOUBT = 0.01


@dataclass(frozen=True)
class Whiteness:
    """The autocorrelation of a residual, judged.

    Parameters
    ----------
    autocorrelation : (lags,) array
        At lags 1, 2, ... [-].
    band : float
        95 % of the values of white noise lie within plus or minus this [-].
    probability : float
        Of correlations as large as these in white noise [-].
    """

    autocorrelation: Array
    band: float
    probability: float

    @property
    def white(self) -> bool:
        """Return whether white noise explains the residual, at 1 %."""
        return self.probability >= _DOUBT

    def sentence(self) -> str:
        """Return the judgement in words."""
        outside = float(np.mean(np.abs(self.autocorrelation) > self.band))
        if self.white:
            return (
                f"white: {outside:.0%} of {len(self.autocorrelation)} autocorrelations lie "
                "outside the 95 % band of noise"
            )
        return (
            f"not white: {outside:.0%} of {len(self.autocorrelation)} autocorrelations lie outside "
            "the 95 % band of noise, so that the model leaves something out; the intervals are "
            "widened for it"
        )


def whiteness(residual: Array, lags: int = _LAGS) -> Whiteness:
    """Judge whether a residual is white.

    Parameters
    ----------
    residual : (n,) array
        Evenly sampled; NaN are passed over [any unit].
    lags : int, optional
        How many autocorrelations to look at.

    Returns
    -------
    Whiteness
        The judgement.

    Notes
    -----
    Portmanteau test Q = n (n + 2) sum r_k^2/(n - k) against chi-squared with as many degrees of
    freedom as lags (Ljung and Box, Biometrika 65, 1978).

    Examples
    --------
    >>> noise = np.random.default_rng(1).standard_normal(2000)
    >>> whiteness(noise).white, whiteness(np.cumsum(noise)).white
    (True, False)
    """
    from scipy.stats import chi2

    residual = residual[np.isfinite(residual)]
    n = len(residual)
    lags = max(1, min(lags, n // 4))
    spread = residual - np.mean(residual)
    power = float(np.dot(spread, spread))
    if power == 0.0:
        return Whiteness(np.zeros(lags), INTERVAL / np.sqrt(n), 1.0)
    correlation = np.array([np.dot(spread[k:], spread[:-k]) for k in range(1, lags + 1)]) / power
    statistic = n * (n + 2) * np.sum(correlation**2 / (n - np.arange(1, lags + 1)))
    return Whiteness(correlation, INTERVAL / float(np.sqrt(n)), float(chi2.sf(statistic, lags)))
