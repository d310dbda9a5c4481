"""Checks on the samples of a channel: missing, clipped and coarsely quantised ones."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.recordings.channels import Channel
from pneuservo.recordings.converter import converter_step

LONGEST_FILLED = 3  # samples
# Commands and outputs that have a limit by design: to stay at it is not a fault of the recording.
LIMITED_BY_DESIGN = ("demand", "valve_voltage", "spool", "card_surface", "card_output")

_SHORTEST_CLIP = 5  # samples
_FEWEST_LEVELS = 20  # a channel with fewer values is switched, not measured finely
_CLIP_TO_NEAR = 8  # a rounded peak holds its top level at most 4.8 times as long as the next
_NEAR_LEVELS = 5
_EDGE_STEPS = 3  # looked at on either side of a stretch, and twice as many beyond them
_CLIP_SPEED = 0.15  # of the root-mean-square step: a clipped channel meets its limit at speed
_CLIP_LOSS = 0.5  # of the speed shortly before; whatever slows down evenly to a rest has 0.4
_FEWEST_BITS = 10.0
_REPEATS = 0.3


@dataclass(frozen=True)
class _Run:
    start: int
    stop: int


def fill_short_gaps(time: Array, values: Array, channel: str) -> tuple[Array, list[str]]:
    """Return samples with short runs of missing ones interpolated.

    Parameters
    ----------
    time : (n,) array
        Time [s].
    values : (n,) array
        Samples; NaN where missing, at least one of them present.
    channel : str
        Its name, for the warnings.

    Returns
    -------
    values : (n,) array
        Runs of at most 3 missing samples between present ones are interpolated linearly;
        longer runs, and runs at either end, stay NaN.
    warnings : list of str
        How many were interpolated, and how many stay missing.

    Examples
    --------
    >>> import numpy as np
    >>> fill_short_gaps(np.arange(4.0), np.array([0.0, np.nan, 2.0, np.nan]), "force")
    (array([ 0.,  1.,  2., nan]),
     ['force: 1 missing sample was interpolated', 'force: 1 sample is missing'])
    """
    missing = np.isnan(values)
    if not missing.any():
        return values, []
    fill = np.zeros(len(values), dtype=bool)
    for run in _runs(missing):
        inside = run.start > 0 and run.stop < len(values)
        if inside and run.stop - run.start <= LONGEST_FILLED:
            fill[run.start : run.stop] = True
    filled = values.copy()
    filled[fill] = np.interp(time[fill], time[~missing], values[~missing])
    warnings = []
    count, left = np.count_nonzero(fill), np.count_nonzero(missing & ~fill)
    if count:
        what = "1 missing sample was" if count == 1 else f"{count} missing samples were"
        warnings.append(f"{channel}: {what} interpolated")
    if left:
        what = "1 sample is" if left == 1 else f"{left} samples are"
        warnings.append(f"{channel}: {what} missing")
    return filled, warnings


def check_samples(values: Array, channel: Channel) -> list[str]:
    """Return warnings about clipped and coarsely quantised samples, and impossible pressures.

    Parameters
    ----------
    values : (n,) array
        Samples in SI, before anything was interpolated; NaN where missing.
    channel : Channel
        Which channel it is.

    Returns
    -------
    list of str
        What was found, in plain words.

    Notes
    -----
    Clipping is five or more consecutive samples at exactly the lowest or highest value, met and
    left abruptly. That tells it from a rest, before which the channel slows down, and from the
    rounded peak of a quantised channel. An end stop cannot be told from it.
    """
    present = values[np.isfinite(values)]
    levels = np.unique(present)
    warnings: list[str] = []
    if channel.pressure and levels[0] <= 0.0:
        warnings.append(
            f"{channel.name}: falls to {levels[0]:.4g} Pa absolute, which cannot be; "
            "if it is a gauge pressure, say gauge = true"
        )
    if channel.name not in LIMITED_BY_DESIGN and len(levels) >= _FEWEST_LEVELS:
        for which, extreme, near in (
            ("lowest", levels[0], levels[1 : 1 + _NEAR_LEVELS]),
            ("highest", levels[-1], levels[-1 - _NEAR_LEVELS : -1]),
        ):
            runs = _clipped(present, extreme, near)
            if runs:
                count = sum(run.stop - run.start for run in runs)
                stretches = "1 stretch" if len(runs) == 1 else f"{len(runs)} stretches"
                unit = f" {channel.unit}" if channel.unit else ""
                clipped = "clipped" if channel.name != "displacement" else "clipped or at a stop"
                warnings.append(
                    f"{channel.name}: {count} samples in {stretches} are {clipped} at its {which} "
                    f"value, {extreme:.4g}{unit}"
                )
    return warnings + _quantisation(present, levels, channel)


def _runs(mask: Mask) -> list[_Run]:
    """Return the stretches in which a mask is true."""
    edges = np.diff(np.concatenate(([False], mask, [False])).astype(np.int8))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [_Run(int(a), int(b)) for a, b in zip(starts, stops, strict=True)]


def _clipped(values: Array, extreme: float, near: Array) -> list[_Run]:
    """Return the stretches at an extreme value, if they are clipped."""
    longest = max(run.stop - run.start for level in near for run in _runs(values == level))
    enough = _SHORTEST_CLIP if longest == 1 else _CLIP_TO_NEAR * longest
    # A recording may begin at rest at its lowest value; that says nothing.
    runs = [
        run
        for run in _runs(values == extreme)
        if run.stop - run.start >= enough and run.start > _EDGE_STEPS
    ]
    steps = np.diff(values)
    usual = float(np.sqrt(np.mean(steps**2)))

    def abrupt(outward: Array) -> bool:
        near = outward[: 3 * _EDGE_STEPS]
        if near.min(initial=0.0) < 0.0 < near.max(initial=0.0):
            return True  # a noisy channel does not come to rest
        speed = np.abs(near)
        fastest = speed[:_EDGE_STEPS].max(initial=0.0)
        before = speed[_EDGE_STEPS:].max(initial=0.0)
        return bool(fastest >= _CLIP_SPEED * usual and fastest >= _CLIP_LOSS * before)

    for run in runs:
        # The steps onto the limit and off it are cut short by it and do not count.
        before, after = steps[: run.start - 1][::-1], steps[run.stop :]
        if abrupt(before) and (len(after) < _EDGE_STEPS or abrupt(after)):
            return runs
    return []


def _quantisation(values: Array, levels: Array, channel: Channel) -> list[str]:
    switched = channel.name in LIMITED_BY_DESIGN and len(levels) < _FEWEST_LEVELS
    step = 0.0 if switched or channel.name == "demand" else converter_step(values)
    if not step:
        return []
    bits = float(np.log2((levels[-1] - levels[0]) / step + 1.0))
    repeats = float(np.mean(np.diff(values) == 0.0))
    if bits >= _FEWEST_BITS and repeats < _REPEATS:
        return []
    unit = f" {channel.unit}" if channel.unit else ""
    return [
        f"{channel.name}: quantised in steps of {step:.3g}{unit}, {bits:.1f} bits over its range; "
        f"{100 * repeats:.0f} % of the samples repeat the one before"
    ]
