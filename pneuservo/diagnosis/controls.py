"""How much an effect would seem to explain if there were only noise."""

from collections.abc import Sequence

import numpy as np

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.models.model import Array
from pneuservo.diagnosis.noise import surrogate

_DRAWS = 100
_QUANTILE = 0.95


def chance_gain(
    baseline: Fit, signatures: Sequence[Array], noise: Sequence[Array], seed: int = 0
) -> float:
    """Return the gain that the best of several effects reaches on noise alone.

    Parameters
    ----------
    baseline : Fit
        The fit that the effects are added to; its sensitivities are projected out, because a
        refit would absorb them.
    signatures : sequence of (n,) array
        What each effect does to the judged channel, all recordings end to end [SI].
    noise : sequence of array
        Residuals of the best fit, one array per recording; their spectrum is that of the noise.
    seed : int, optional
        Seed of the random phases.

    Returns
    -------
    float
        The 95 % point of the largest drop in the sum of squares over all effects [SI squared].

    Notes
    -----
    Each draw keeps the power of the residual at every frequency and takes random phases, so
    that serial correlation counts; the effects' shape parameters are held at their fitted
    values. A naive criterion finds an effect in nearly every recording, because it takes
    neither correlation nor the number of candidates into account.
    """
    basis = np.linalg.qr(_significant(baseline.jacobian))[0]
    directions = []
    for signature in signatures:
        rest = signature - basis @ (basis.T @ signature)
        size = float(np.linalg.norm(rest))
        if size > 1e-9 * float(np.linalg.norm(signature)):
            directions.append(rest / size)
    if not directions:
        return 0.0
    rng = np.random.default_rng(seed)
    best = [
        max(float(direction @ draw) ** 2 for direction in directions)
        for draw in (
            np.concatenate([surrogate(part, rng) for part in noise]) for _ in range(_DRAWS)
        )
    ]
    return float(np.quantile(best, _QUANTILE))


def _significant(jacobian: Array) -> Array:
    sizes = np.linalg.norm(jacobian, axis=0)
    return jacobian[:, sizes > 1e-12 * max(float(sizes.max(initial=0.0)), 1e-300)]
