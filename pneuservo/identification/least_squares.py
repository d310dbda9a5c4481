"""Mass and friction by least squares on the force balance, with the thesis' four measures."""

from collections.abc import Sequence

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError
from pneuservo.identification.result import Identification, estimates
from pneuservo.identification.signals import (
    CUTOFF_FREQUENCY,
    SETTLING_PERIODS,
    ForceBalance,
    force_balance,
)
from pneuservo.identification.whiteness import whiteness
from pneuservo.noise import effective_samples
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig
from pneuservo.simulation.inputs import require_kind

PARAMETERS = ("load.mass", "piston.viscous_friction", "piston.coulomb_friction")
UNITS = {
    "load.mass": "kg",
    "piston.viscous_friction": "N*s/m",
    "piston.coulomb_friction": "N",
}
DIRECTIONS = ("both", "extending", "retracting")
FEWEST_SAMPLES = 30
# Section 4.3.2.1 of the thesis [m/s].
VELOCITY_DEAD_BAND = 0.005
# How far the filter smears a reversal, in periods of its cut-off: so near to the dead band the
# filtered sign is neither that of sliding nor of rest.
_SMEAR_PERIODS = 0.6


def rig_of(recording: Recording, rig: Rig | str | None) -> Rig:
    """Return the single-axis rig of a recording, in its conditions.

    Parameters
    ----------
    recording : Recording
        The recording.
    rig : Rig or str, optional
        By default the one the recording names.
    """
    rig = require_kind(rig or recording.rig, "single-axis", effects=True)
    return rig.with_conditions(recording.conditions)


def identify_least_squares(
    recordings: Sequence[Recording],
    rig: Rig | str | None = None,
    *,
    direction: str = "both",
    cutoff: float = CUTOFF_FREQUENCY,
    dead_band: float = VELOCITY_DEAD_BAND,
    most_points: int | None = None,
) -> Identification:
    """Identify mass, viscous and Coulomb friction by least squares.

    Parameters
    ----------
    recordings : sequence of Recording
        Displacement and both chamber pressures, of one rig in motion.
    rig : Rig or str, optional
        By default the one the recordings name; its areas, ambient pressure and gravity are used.
    direction : str, optional
        ``both``, or only ``extending`` or ``retracting`` motion.
    cutoff : float, optional
        Of the filter [Hz].
    dead_band : float, optional
        Samples slower than this are left out, and those so near to one that the filter mixes them
        [m/s].
    most_points : int, optional
        Only so many samples are used, evenly spread; all by default.

    Returns
    -------
    Identification
        Residual: ``force`` [N].

    Raises
    ------
    InputError
        When a channel is missing or hardly anything moves.

    Notes
    -----
    Equations (4.41) to (4.51) of the thesis with its four measures: one filter for all terms, a
    dead band of the velocity, terms scaled to equal maxima, and three passes of which the first
    fixes the mass, the second the viscous and the third the Coulomb friction. Noise of the
    displacement biases the mass low, the less the lower the cut-off; the intervals do not hold
    that bias.

    Examples
    --------
    >>> from pneuservo.identification import simulate_excitation
    >>> found = identify_least_squares([simulate_excitation(duration=8.0, noise_share=0.0)])
    >>> bool(abs(found.parameters["load.mass"] - 1.825) < 0.03)
    True
    """
    if direction not in DIRECTIONS:
        raise InputError(f"direction {direction!r} is none of: {', '.join(DIRECTIONS)}")
    if not recordings:
        raise InputError("there is no recording to identify from")
    balances = [force_balance(r, rig_of(r, rig), cutoff) for r in recordings]
    used = [_used(balance, direction, dead_band) for balance in balances]
    if most_points is not None:
        used = [_spread(mask, most_points // len(used)) for mask in used]
    columns = [_columns(balance) for balance in balances]
    terms = np.vstack([c[mask] for c, mask in zip(columns, used, strict=True)])
    force = np.concatenate([b.force[mask] for b, mask in zip(balances, used, strict=True)])
    if len(force) < FEWEST_SAMPLES:
        raise InputError(
            f"{', '.join(r.name for r in recordings)}: {len(force)} samples move faster than "
            f"{dead_band:g} m/s, {direction}; at least {FEWEST_SAMPLES} are needed. Record more "
            "motion, or lower --dead-band"
        )
    values = _in_passes(terms, force)
    residuals = [
        np.where(mask, b.force - c @ values, np.nan)
        for b, c, mask in zip(balances, columns, used, strict=True)
    ]
    residual = np.concatenate(residuals)
    found, correlation = estimates(
        dict(zip(PARAMETERS, values.tolist(), strict=True)), covariance_of(terms, residual), UNITS
    )
    notes = [f"filter at {balances[0].cutoff:g} Hz, {len(force)} samples, {direction}"]
    if balances[0].cutoff < cutoff:
        notes.append("the cut-off was lowered to a fifth of the sampling frequency")
    return Identification(
        "least-squares",
        found,
        correlation,
        {"force": residual},
        # The filter itself correlates neighbours: every so many samples it does not any more.
        {"force": whiteness(residual[:: _apart(balances[0])])},
        tuple(notes),
        {"force": np.concatenate([c @ values for c in columns])},
        np.concatenate([b.time for b in balances]),
    )


def identify_each(
    recordings: Sequence[Recording], rig: Rig | str | None = None, **options: float
) -> dict[tuple[str, str], Identification]:
    """Identify every recording and direction of motion by itself.

    Parameters
    ----------
    recordings : sequence of Recording
        Such as one for each of three piston positions.
    rig : Rig or str, optional
        As in `identify_least_squares`.
    **options
        ``cutoff`` and ``dead_band`` as in `identify_least_squares`.

    Returns
    -------
    dict of (str, str) to Identification
        By name of the recording and direction, ``extending`` or ``retracting``.

    Notes
    -----
    Section 4.3.2.1 of the thesis: friction was suspected to depend on position and direction, so
    that each was identified by itself.
    """
    return {
        (recording.name, direction): identify_least_squares(
            [recording],
            rig,
            direction=direction,
            **options,  # type: ignore[arg-type]
        )
        for recording in recordings
        for direction in DIRECTIONS[1:]
    }


def _apart(balance: ForceBalance) -> int:
    return max(1, round(1.0 / (balance.cutoff * (balance.time[1] - balance.time[0]))))


def _columns(balance: ForceBalance) -> Array:
    return np.column_stack((balance.inertia, balance.velocity, balance.direction))


def _used(balance: ForceBalance, direction: str, dead_band: float) -> Mask:
    from scipy.ndimage import binary_dilation

    velocity, time = balance.velocity, balance.time
    smear = max(1, round(_SMEAR_PERIODS / (balance.cutoff * (time[1] - time[0]))))
    used = balance.free & ~binary_dilation(np.abs(velocity) < dead_band, iterations=smear)
    if direction != "both":
        used &= velocity > 0.0 if direction == "extending" else velocity < 0.0
    margin = SETTLING_PERIODS / balance.cutoff
    used &= (time >= time[0] + margin) & (time <= time[-1] - margin)
    return used


def _spread(mask: Mask, most: int) -> Mask:
    places = np.flatnonzero(mask)
    if len(places) <= most:
        return mask
    kept = np.zeros_like(mask)
    kept[places[np.linspace(0, len(places) - 1, most).astype(int)]] = True
    return kept


def _in_passes(terms: Array, force: Array) -> Array:
    """Return mass, viscous and Coulomb friction, each fixed in a pass of its own."""
    scale = np.max(np.abs(terms), axis=0)
    scale[scale == 0.0] = 1.0
    scaled, left, values = terms / scale, force.copy(), np.zeros(terms.shape[1])
    for k in range(terms.shape[1]):
        solution = np.linalg.lstsq(scaled[:, k:], left, rcond=None)[0]
        values[k] = solution[0] / scale[k]
        left = left - values[k] * terms[:, k]
    return values


def covariance_of(terms: Array, residual: Array) -> Array:
    """Return the covariance of a least-squares fit, its samples worth what their correlation says.

    Parameters
    ----------
    terms : (n, k) array
        What the unknowns multiply, of the samples used.
    residual : (m, ) array
        What is left over; NaN where a sample was not used.
    """
    compared = residual[np.isfinite(residual)]
    # Filtered noise is correlated: the samples are worth fewer than there are.
    worth = effective_samples(compared) / len(compared)
    covariance = np.linalg.pinv(terms.T @ terms) * float(np.var(compared)) / worth
    return np.asarray(covariance, dtype=np.float64)
