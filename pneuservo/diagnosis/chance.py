"""How much an effect would seem to explain if there were only noise."""

from collections.abc import Sequence

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import orthonormal
from pneuservo.noise import surrogate

_DRAWS = 100
_QUANTILE = 0.95


def chance_gain(
    absorbing: Array, candidates: Sequence[Array], noise: Sequence[Array], seed: int = 0
) -> float:
    """Return the gain that the best of several candidates reaches on noise alone.

    Parameters
    ----------
    absorbing : (n, k) array
        Sensitivities of what is fitted anyway; a refit absorbs what lies in their span.
    candidates : sequence of (n, m) array
        Sensitivities of each candidate's own parameters, in any scale.
    noise : sequence of array
        What the best model leaves, one array per recording, n samples in all; its spectrum is
        that of the noise [of its spread].
    seed : int, optional
        Seed of the random phases.

    Returns
    -------
    float
        The 95 % point of the largest drop in the sum of squares over all candidates
        [of the noise's variance].

    Notes
    -----
    Each draw keeps the power of the residual at every frequency and takes random phases, so
    that serial correlation counts; candidates are linearised where they were fitted. A naive
    criterion finds an effect in nearly every recording, because it takes neither correlation
    nor the number of candidates into account.
    """
    basis = _span(absorbing)
    spans = [_span(columns - basis @ (basis.T @ columns), columns) for columns in candidates]
    rng = np.random.default_rng(seed)
    best = []
    for _ in range(_DRAWS):
        draw = np.concatenate([surrogate(part, rng) for part in noise])
        best.append(max((float(np.sum((span.T @ draw) ** 2)) for span in spans), default=0.0))
    return float(np.quantile(best, _QUANTILE))


def _span(columns: Array, whole: Array | None = None) -> Array:
    """Return an orthonormal basis of columns that are not just rounding of the whole ones."""
    sizes = np.linalg.norm(columns, axis=0)
    before = sizes if whole is None else np.linalg.norm(whole, axis=0)
    return orthonormal(columns[:, sizes > 1e-6 * before])
