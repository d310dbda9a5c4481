"""Signatures: what each effect of the catalogue changes in a short run of its rig."""

import functools
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.effects import Effect
from pneuservo.recordings import CHANNELS
from pneuservo.report.signature_runs import Run, runs_of

RESOLUTION = {"m": 7.3e-6, "Pa": 500.0, "N": 0.12, "V": 4.9e-3}
"""By unit, what a conversion of 12 bit just tells apart [SI]: of 30 mm and 20 bar as in thesis
section 3.2, of a load cell of 500 N, of 20 V."""

_JUDGED: dict[str, tuple[str, ...]] = {
    "single-axis": ("displacement", "pressure_a", "pressure_b"),
    "dead-volume": ("dead_volume_pressure",),
    "seal-tester": ("force",),
    "circuit": ("circuit_output",),
    "analogue-card": ("card_velocity", "card_acceleration", "card_surface", "card_output"),
}


@dataclass(frozen=True)
class Signature:
    """One run with an effect, and the same without.

    Parameters
    ----------
    effect : Effect
        What differs.
    values : mapping of str to float
        Its size and shape, by parameter [SI].
    time : (n,) array
        [s].
    without, present : mapping of str to (n,) array
        What is read of the judged channels without it and with it [SI].
    """

    effect: Effect
    values: Mapping[str, float]
    time: Array
    without: Mapping[str, Array]
    present: Mapping[str, Array]

    def change(self, channel: str) -> Array:
        """Return what the effect changes in a channel [SI]."""
        return self.present[channel] - self.without[channel]

    @property
    def resolved(self) -> float:
        """Return the largest change of any channel, counted in its resolution."""
        return max(
            float(np.max(np.abs(self.change(channel)))) / RESOLUTION[CHANNELS[channel].unit]
            for channel in self.without
        )


def signature_of(effect: Effect, kind: str, runs: Sequence[Run] = ()) -> Signature:
    """Return the signature of an effect at the size at which a fit of it starts.

    Parameters
    ----------
    effect : Effect
        Of the catalogue.
    kind : str
        Kind of rig that shows it.
    runs : sequence of callable, optional
        From `pneuservo.report.signature_runs.runs_of`, where they have been made before.

    Returns
    -------
    Signature
        At the first of its starts, and in the first run, where it can be resolved; where it never
        can, where it is largest.

    Notes
    -----
    Both runs come from the same equations, once with the effect neutral: all that differs is due
    to it. The servo's loop is closed in both.

    Examples
    --------
    >>> from pneuservo.effects import effect_by_id
    >>> found = signature_of(effect_by_id("circuit.cubic-stiffness"), "circuit")
    >>> found.values, bool(found.resolved > 1.0)
    ({'coefficient': 1.0}, True)
    """
    found: Signature | None = None
    for signature in _signatures(effect, kind, runs or runs_of(kind)):
        if found is None or signature.resolved > found.resolved:
            found = signature
        if found.resolved > 1.0:
            break
    assert found is not None
    return found


def _signatures(effect: Effect, kind: str, runs: Sequence[Run]) -> Iterator[Signature]:
    names, judged = [p.name for p in effect.parameters], _JUDGED[kind]
    neutral = {p.name: p.neutral for p in effect.parameters}
    without_it = [functools.cache(functools.partial(run, effect, neutral)) for run in runs]
    for starts in itertools.product(*(p.starts for p in effect.parameters)):
        values = dict(zip(names, starts, strict=True))
        for run, its_baseline in zip(runs, without_it, strict=True):
            without, present = its_baseline(), run(effect, values)
            yield Signature(
                effect,
                values,
                without["time"],
                {channel: without[channel] for channel in judged},
                {channel: present[channel] for channel in judged},
            )
