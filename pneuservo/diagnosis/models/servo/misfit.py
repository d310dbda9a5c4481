"""What a servo's model leaves that is no noise, whatever it is: lines, slow swings, lost rests."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.hum import MAINS
from pneuservo.diagnosis.models.model import Case, Misfit
from pneuservo.diagnosis.models.servo.feed import AT_REST, PRESSURES, SUPPLY, Feed
from pneuservo.diagnosis.models.servo.spread import rise_per_metre
from pneuservo.rigs import Rig

_LINE = 300.0
"""A line of so many times the power beside it is taken for interference: in recordings of another
simulator without any effect none but the mains' reached 20 ..."""
_AGAIN = 30.0
"""... and so many times are enough at the same frequency in another recording: an observer follows
a slow line where the piston rests."""
_WIDE = 2
"""So many frequencies of a windowed transform to either side belong to a line ..."""
_BESIDE = 20
"""... and so many, less these, are beside it."""
_LOWEST = 0.3
"""Lines below are drift [Hz] ..."""
_HIGHEST = 0.49
"""... and above this share of the sampling rate none is looked for."""
_OFF_MAINS = 1.0
"""Lines as close to a multiple of the mains are hum [Hz]."""
_ONE_TRANSDUCER = 5.0
"""What is so many times as strong in one channel as in any other is in its reading: what really
swings shows elsewhere too."""
_NOT_COMMANDED = 15.0
"""The command has no line there: less than so many times the power beside it ..."""
_PERIODIC = 0.1
"""... nor, where its strongest line has this share of its power, a fraction of the frequency ..."""
_AS_FINE = 0.3
"""... to this part of the distance of two frequencies ..."""
_HARMONICS = 10
"""... as many times at the most: what a command bends is weak beyond."""
_LOST_REST = 2.0
"""A piston rests though it is pushed by more than friction can hold, by so many times how well that
is known (root mean square): in recordings without effect it was 0.9 at the most, and 1.6 where a
transducer read what was not there."""
_SLOW = 0.1
"""What swings in a chamber's pressure, as a share of the noise's power; in 65 pairs of another
simulator without effect 0.04 at the most, with an external force 0.13 to 4."""
_SLOW_ALONE = 0.5
"""The same of a supply pressure, which no other channel has to share: there source and line are all
that is judged."""
_FASTEST = 10.0
"""Faster swings may be the loop's own chatter [Hz]: at 50 Hz of a relay's, small errors of the
baseline left 1.2 times the noise in one pressure."""
_TOGETHER = 0.5
"""Coherence with another channel below which it may be noise that is not white."""
_SEGMENT, _FEWEST = 1.0, 5
"""Swings show in segments as long as this [s], of as many at least."""
_STANDS_OUT = 2.5
"""Of the power density of noise; with some twenty segments noise alone does not reach it."""


@dataclass(frozen=True)
class _Left:
    """What is left of one recording.

    Parameters
    ----------
    channels : dict of str to (n,) array
        Innovations in units of their noise, 0 where they are not judged.
    command : (n,) array
        [V].
    interval : float
        Of the samples [s].
    moved_by_noise : dict of str to float
        What a piston that moves by the noise of the displacement makes of each pressure, in the
        noise of that [-].
    """

    channels: dict[str, Array]
    command: Array
    interval: float
    moved_by_noise: dict[str, float]


def misfit_of(cases: Sequence[Case], residuals: Sequence[Array]) -> Misfit | None:
    """Return what some residuals show beside noise, the largest of it.

    Parameters
    ----------
    cases : sequence of Case
        Prepared recordings of one servo.
    residuals : sequence of array
        What is left of each, usable samples only [in noise].

    Returns
    -------
    Misfit or None
        None where what is left could be noise.

    Notes
    -----
    Four things that innovations of the right model never show: a line in the reading of one
    pressure that neither the command nor another channel has; a piston that stays at rest under
    more than friction can hold; swings of a pressure as strong as a tenth of its noise that
    another channel shares, beyond what a motion makes that is known no better than its noise; and
    swings of the supply. Of a displacement alone nothing is concluded:
    while a piston sticks and slips, friction that gives way by some micrometres is left in it.
    """
    lefts = _lefts(cases, residuals)
    found = [_line(lefts), _lost_rest(cases, residuals), _swing(lefts), _swing_of_supply(lefts)]
    return max((f for f in found if f is not None), key=lambda f: f.energy, default=None)


def _lefts(cases: Sequence[Case], residuals: Sequence[Array]) -> list[_Left]:
    lefts: dict[int, _Left] = {}
    for case, residual in zip(cases, residuals, strict=True):
        fed = case.inputs["feed"]
        left = lefts.get(id(fed))
        if left is None:
            moved = _moved_by_noise(fed, case.rig)
            left = lefts[id(fed)] = _Left({}, fed.voltage, fed.interval, moved)
        if case.recorded:
            whole = np.zeros(len(case.usable))
            whole[case.usable] = residual
            left.channels[case.channel] = whole
    return list(lefts.values())


def _moved_by_noise(fed: Feed, rig: Rig) -> dict[str, float]:
    from pneuservo.rigs.plant_numbers import single_axis

    moved = fed.noise["displacement"]
    rises = rise_per_metre(fed.pressures, fed.motion[0], single_axis(rig))
    return {
        name: float(np.sqrt(np.mean(rise**2))) * moved / fed.noise[name]
        for name, rise in zip(PRESSURES, rises, strict=True)
        if name in fed.noise
    }


def _line(lefts: Sequence[_Left]) -> Misfit | None:
    """Return a line in the reading of one pressure, in every recording at one frequency."""
    found = [
        _line_in(channel, lefts)
        for channel in PRESSURES
        if all(channel in left.channels and len(left.channels) > 1 for left in lefts)
    ]
    return max((f for f in found if f is not None), key=lambda f: f.energy, default=None)


def _line_in(channel: str, lefts: Sequence[_Left]) -> Misfit | None:
    strength, frequency = max(_strongest_line(channel, left) for left in lefts)
    if strength < _LINE or any(
        abs(frequency - k * m) < _OFF_MAINS for m in MAINS for k in range(1, 10)
    ):
        return None
    energy = 0.0
    for left in lefts:
        strength, whole = _line_at(left.channels[channel], left.interval, frequency)
        others = [
            _line_at(other, left.interval, frequency)[1]
            for name, other in left.channels.items()
            if name != channel
        ]
        if strength < _AGAIN or _commanded(left, frequency):
            return None
        if any(_ONE_TRANSDUCER * other > whole for other in others):
            return None
        energy += 2.0 * whole
    return Misfit(
        "sensor.pressure",
        f"the reading of the {channel.replace('_', ' ')} has a line at {frequency:.3g} Hz that "
        "nothing else has, as interference has, or a line from above half the sampling rate that "
        "is folded down",
        energy,
    )


def _strongest_line(channel: str, left: _Left) -> tuple[float, float]:
    """Return how often the strongest line exceeds the power beside it, and its frequency [Hz]."""
    samples = left.channels[channel]
    frequency = _strongest(samples, left.interval)
    return _line_at(samples, left.interval, frequency)[0], frequency


def _strongest(samples: Array, interval: float) -> float:
    """Return the frequency of the strongest line [Hz]; 0 where there is none."""
    powers, frequencies = _powers(samples, interval)
    peak = int(np.argmax(powers))
    about = slice(max(peak - _WIDE, 0), peak + _WIDE + 1)
    if not powers[peak] > 0.0:
        return 0.0
    # Between two frequencies of the transform a line shows at both.
    return float(np.average(frequencies[about], weights=powers[about]))


def _commanded(left: _Left, frequency: float) -> bool:
    """Return whether the command has a line there, or at a fraction: what it drives bends."""
    if _line_at(left.command, left.interval, frequency)[0] > _NOT_COMMANDED:
        return True
    ground = _strongest(left.command, left.interval)
    powers, frequencies = _powers(left.command, left.interval)
    if not ground or _line_at(left.command, left.interval, ground)[1] < _PERIODIC * np.sum(powers):
        return False
    times = round(frequency / ground)
    beside = abs(frequency - times * ground)
    return times <= _HARMONICS and beside < _AS_FINE * float(frequencies[1])


def _powers(samples: Array, interval: float) -> tuple[Array, Array]:
    """Return the power at each frequency, and the frequencies [Hz]; 1 each for white noise of 1."""
    from scipy.signal.windows import hann

    # A line between two frequencies would leak into all.
    window = hann(len(samples), sym=False)
    frequencies = np.fft.rfftfreq(len(samples), interval)
    spectrum = np.fft.rfft(window * (samples - np.mean(samples)))
    powers = np.abs(spectrum) ** 2 / np.sum(window**2) * (frequencies >= _LOWEST)
    return powers, np.asarray(frequencies)


def _line_at(samples: Array, interval: float, frequency: float) -> tuple[float, float]:
    """Return how often a line exceeds the power beside it, and its power; 0 out of reach."""
    if not 0.0 < frequency < _HIGHEST / interval:
        return 0.0, 0.0
    powers, frequencies = _powers(samples, interval)
    away = np.abs(np.round((frequencies - frequency) / frequencies[1]))
    beside = (away > _WIDE) & (away <= _BESIDE) & (frequencies >= _LOWEST)
    floor = float(np.mean(powers[beside]))
    power = float(np.sum(powers[away <= _WIDE]))
    return power / max(floor, 1e-300), power


def _lost_rest(cases: Sequence[Case], residuals: Sequence[Array]) -> Misfit | None:
    squares = []
    for case, residual in zip(cases, residuals, strict=True):
        if case.channel == AT_REST:
            fed: Feed = case.inputs["feed"]
            # When it breaks away it rests no more.
            at_rest = case.usable.copy()
            at_rest[fed.breaks_away] = False
            rests = float(np.sum(1.0 / fed.moments_of_rest[at_rest]))
            square = float(np.sum(residual[at_rest[case.usable]] ** 2))
            if square > _LOST_REST**2 * rests:
                squares.append(square)
    if not squares:
        return None
    words = (
        "a force acts on the piston that no channel tells: it rests under more than its friction "
        "can hold"
    )
    return Misfit("load", words, sum(squares))


@dataclass(frozen=True)
class _Swings:
    """What is left of a channel, by frequency.

    Parameters
    ----------
    powers : (k,) array
        Density of its power.
    stands_out : (k,) array
        By how much that exceeds what noise reaches where it is slow, in that of the noise.
    """

    powers: Array
    stands_out: Array

    @property
    def share(self) -> float:
        """Return the power that stands out, in that of the noise."""
        return float(np.sum(self.stands_out)) / len(self.stands_out)

    @property
    def edge(self) -> float:
        """Return up to where something stands out [Hz]."""
        return float((np.flatnonzero(self.stands_out)[-1] + 1) / _SEGMENT)


def _swing(lefts: Sequence[_Left]) -> Misfit | None:
    """Return what swings in a pressure and in another channel at once."""
    energy, channels, highest = 0.0, set(), 0.0
    for left in lefts:
        for channel in PRESSURES:
            swings = _swings(left, channel)
            if swings is not None and swings.share > _SLOW and _is_shared(left, channel, swings):
                energy += swings.share * len(left.channels[channel])
                channels.add(channel.replace("_", " "))
                highest = max(highest, swings.edge)
    if not channels:
        return None
    words = (
        f"below {highest:.2g} Hz the {' and the '.join(sorted(channels))} "
        f"{'swings' if len(channels) == 1 else 'swing'} in a way that nothing recorded brings about"
    )
    return Misfit("load" if len(channels) > 1 else "valve.flow", words, energy)


def _swing_of_supply(lefts: Sequence[_Left]) -> Misfit | None:
    """Return what swings in the supply pressure that neither source, line nor flow brings about."""
    energy, highest = 0.0, 0.0
    for left in lefts:
        swings = _swings(left, SUPPLY)
        if swings is not None and swings.share > _SLOW_ALONE:
            energy += swings.share * len(left.channels[SUPPLY])
            highest = max(highest, swings.edge)
    if not energy:
        return None
    words = (
        f"below {highest:.2g} Hz the supply pressure swings in a way that neither its source, its "
        "line nor the flow that the valve takes brings about"
    )
    return Misfit("supply", words, energy)


def _swings(left: _Left, channel: str) -> _Swings | None:
    """Return how a channel swings; None where it is too short or was not recorded."""
    segment = round(_SEGMENT / left.interval)
    if channel not in left.channels or len(left.channels[channel]) < _FEWEST * segment:
        # Of few segments any two channels look coherent.
        return None
    powers = _density(left.channels[channel], left.channels[channel], segment)
    frequencies = np.arange(len(powers)) / _SEGMENT
    stands_out = _standing_out(powers, left.moved_by_noise.get(channel, 0.0))
    return _Swings(powers, stands_out * (frequencies < _FASTEST))


def _is_shared(left: _Left, channel: str, swings: _Swings) -> bool:
    """Return whether another channel swings together with one."""
    own, segment = left.channels[channel], round(_SEGMENT / left.interval)
    total = float(np.sum(swings.stands_out))
    for name, other in left.channels.items():
        if name == channel:
            continue
        there = _density(other, other, segment)
        stands_out = _standing_out(there, left.moved_by_noise.get(name, 0.0))
        if np.sum(stands_out) * _ONE_TRANSDUCER <= total:
            continue
        coherence = _density(own, other, segment) ** 2 / np.maximum(swings.powers * there, 1e-300)
        if float(np.sum(coherence * swings.stands_out)) >= _TOGETHER * total:
            return True
    return False


def _density(one: Array, other: Array, segment: int) -> Array:
    """Return the density of the power that two channels share, in segments of so many samples."""
    from scipy.signal import csd

    _, found = csd(one, other, nperseg=segment, detrend="constant")
    return np.abs(found)


def _standing_out(powers: Array, moved_by_noise: float) -> Array:
    """Return by how much powers exceed what noise reaches, in those of the channel's noise."""
    floor = float(np.median(powers))
    reached = _STANDS_OUT * (1.0 + moved_by_noise**2)
    return np.clip(powers / floor - reached, 0.0, None) if floor > 0.0 else 0.0 * powers
