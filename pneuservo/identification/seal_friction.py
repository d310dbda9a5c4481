"""Friction of a seal by least squares: a piston driven slowly at a held chamber pressure."""

from collections.abc import Sequence

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError
from pneuservo.identification.least_squares import FEWEST_SAMPLES, covariance_of
from pneuservo.identification.result import Identification, estimates
from pneuservo.identification.signals import even, filtered
from pneuservo.identification.whiteness import whiteness
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig, load_rig

UNITS = {
    "piston.viscous_friction": "N*s/m",
    "piston.coulomb_friction": "N",
    "sensor.force.offset": "N",
}
# The drive needs seconds for a stroke: everything that matters is far below [Hz].
_CUTOFF = 5.0
# Slower than this share of the usual speed the piston turns or rests.
_DEAD_BAND = 0.3
_SETTLING_PERIODS = 2.0


def identify_seal_friction(
    recordings: Sequence[Recording], rig: Rig | str | None = None
) -> Identification:
    """Identify viscous and Coulomb friction of a seal, and the zero of the load cell.

    Parameters
    ----------
    recordings : sequence of Recording
        Force at the rod, displacement and chamber pressure.
    rig : Rig or str, optional
        Of kind ``seal-tester``; by default the one the recordings name.

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
    force = (p - p_amb) A + offset - cf v - Fc sgn(v), inertia left out. All recordings share the
    three values: friction that grows with pressure is left over when their pressures differ. With
    one speed in both directions viscous and Coulomb friction cannot be told apart, which the
    correlation then says.
    """
    if not recordings:
        raise InputError("there is no recording to identify from")
    pieces = [_balance(recording, _rig_of(recording, rig)) for recording in recordings]
    terms = np.vstack([columns[used] for _, columns, _, used in pieces])
    target = np.concatenate([friction[used] for _, _, friction, used in pieces])
    if len(target) < FEWEST_SAMPLES:
        raise InputError(
            f"{', '.join(r.name for r in recordings)}: {len(target)} samples move; at least "
            f"{FEWEST_SAMPLES} are needed. Record more strokes"
        )
    scale = np.max(np.abs(terms), axis=0)
    values = np.linalg.lstsq(terms / scale, target, rcond=None)[0] / scale
    residual = np.concatenate(
        [np.where(used, y - columns @ values, np.nan) for _, columns, y, used in pieces]
    )
    found, correlation = estimates(
        dict(zip(UNITS, values.tolist(), strict=True)), covariance_of(terms, residual), UNITS
    )
    time = np.concatenate([entry[0] for entry in pieces])
    apart = max(1, round(1.0 / (_CUTOFF * float(np.median(np.diff(time))))))
    return Identification(
        "least-squares",
        found,
        correlation,
        {"force": residual},
        {"force": whiteness(residual[::apart])},
        (f"filter at {_CUTOFF:g} Hz, {len(target)} samples, inertia left out",),
        {"force": np.concatenate([columns @ values for _, columns, _, _ in pieces])},
        time,
    )


def _rig_of(recording: Recording, rig: Rig | str | None) -> Rig:
    rig = rig if isinstance(rig, Rig) else load_rig(rig or recording.rig)
    if rig.kind != "seal-tester":
        raise InputError(f"rig {rig.name} is of kind {rig.kind}; seal-tester is needed here")
    return rig.with_conditions(recording.conditions)


def _balance(recording: Recording, rig: Rig) -> tuple[Array, Array, Array, Mask]:
    """Return times, what the unknowns multiply, the friction force, and which samples to use."""
    from scipy.ndimage import binary_dilation, median_filter

    time, samples = even(recording, ("displacement", "pressure_a", "force"))
    interval = float(time[1] - time[0])
    # A laser gives single wrong readings, which a linear filter would only smear.
    displacement = median_filter(samples["displacement"], 5, mode="nearest")
    cutoff = min(_CUTOFF, 0.2 / interval)
    velocity = filtered(np.gradient(displacement, interval), interval, cutoff)
    gauge = filtered(samples["pressure_a"], interval, cutoff) - rig["ambient.pressure"]
    area = 0.25 * np.pi * rig["piston.diameter"] ** 2
    friction = gauge * area - filtered(samples["force"], interval, cutoff)
    columns = np.column_stack(
        (velocity, filtered(np.sign(velocity), interval, cutoff), -np.ones_like(velocity))
    )
    usual = float(np.percentile(np.abs(velocity), 75.0))
    settling = max(1, round(_SETTLING_PERIODS / (cutoff * interval)))
    slow = np.abs(velocity) <= _DEAD_BAND * usual
    used = ~binary_dilation(slow, iterations=max(1, settling // 2))
    used[:settling] = used[-settling:] = False
    return time, columns, friction, used
