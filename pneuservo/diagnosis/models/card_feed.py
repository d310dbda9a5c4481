"""A recording of the card's taps, as its stages are fed with it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analog_card.behaviour import CardBehaviour, card_stages
from analog_card.behaviour_limiter import inputs as limiter_inputs
from analog_card.design import Design
from analog_card.design_file import load_design
from analog_card.errors import InputError as CardInputError
from analog_card.figures import CardFigures, card_figures
from pneuservo.arrays import Array, Mask, bridged
from pneuservo.diagnosis.models.even_samples import even_interval
from pneuservo.errors import InputError
from pneuservo.noise import noise_floor
from pneuservo.recordings import Recording

Spectrum = NDArray[np.complex128]

CHANNELS = (
    "card_sensor",
    "demand",
    "card_velocity",
    "card_acceleration",
    "card_surface",
    "card_output",
)
EDGE = 20
"""Samples at either end, and round a missing one, whose past or future was not recorded."""
_FEWEST = 200
"""Samples below which the ends would be most of a recording."""
_EXTENSION = 512
"""Samples at most by which a recording is continued, so that it can be taken as periodic."""

_SUDDEN = 10.0
"""A jump is so many times what is usual between samples round it ..."""
_LEAST_JUMP = 1e-4
"""... and no less than this [m]."""
_NEIGHBOURS = 9
"""Frequencies whose power is taken together."""
_MARGIN = 3.0
"""Noise alone reaches this many times its own power once in some thousand frequencies."""


@dataclass(frozen=True)
class CardNominal:
    """What a card is taken to be.

    Parameters
    ----------
    design : Design
        The card as designed, with the tolerances of its parts.
    figures : CardFigures
        Gains, filters and limits.
    amplifier_time : float
        1/(2 pi gain-bandwidth product) of its op-amps [s].
    share : float
        Output for each volt of the op-amp ahead of the limiter [V/V].
    swing : (float, float)
        Lowest and highest output of an op-amp [V].
    overdrive, limited : (n,) array
        The limiter's curve: what it is asked for and what it gives, over the level [-].
    """

    design: Design
    figures: CardFigures
    amplifier_time: float
    share: float
    swing: tuple[float, float]
    overdrive: Array
    limited: Array


@dataclass
class CardFeed:
    """One recording of the taps.

    Parameters
    ----------
    interval : float
        Sampling interval [s].
    signals : dict of str to (n,) array
        Recorded channels without gaps, by canonical name; the demand as it was recorded [m].
    missing : dict of str to (n,) array of bool
        Samples of each that were not recorded.
    noise : dict of str to float
        Noise of each [V].
    nominal : CardNominal
        The card.
    """

    interval: float
    signals: dict[str, Array]
    missing: dict[str, Mask]
    noise: dict[str, float]
    nominal: CardNominal

    @property
    def size(self) -> int:
        """Return the number of samples."""
        return len(self.signals["card_sensor"])

    def frequency(self, size: int) -> Array:
        """Return the angular frequencies of the `spectrum` of so many samples [1/s]."""
        hertz = np.fft.rfftfreq(_extended_size(size), self.interval)
        return np.asarray(2.0 * np.pi * hertz, np.float64)

    def unusable(self, *channels: str) -> Mask:
        """Return the samples that some channels cannot be judged at or fed from."""
        bad = np.zeros(self.size, dtype=bool)
        for channel in channels:
            bad |= self.missing[channel]
        spread = np.convolve(bad, np.ones(2 * EDGE + 1), mode="same") > 0.5
        spread[:EDGE] = spread[-EDGE:] = True
        return spread

    def jumps(self) -> Mask:
        """Return the samples next to a jump of the demand.

        Recorder and demand keep no common time: there a tap may be the one before or after.
        """
        change = np.abs(np.diff(self.signals["demand"], prepend=self.signals["demand"][:1]))
        usual = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(change, 5), 11), axis=1)
        jump = change > np.maximum(_SUDDEN * usual, _LEAST_JUMP)
        return np.convolve(jump, np.ones(3), mode="same") > 0.5


def card_feed(recording: Recording) -> CardFeed:
    """Return a recording of the taps as the stages are fed with it.

    Parameters
    ----------
    recording : Recording
        With at least the transducer input; its table ``[card]`` says which card it is.

    Raises
    ------
    InputError
        When its samples are too few or not evenly spaced, or its design file cannot be used.
    """
    time = recording.time
    if len(time) < _FEWEST:
        raise InputError(
            f"{recording.source or recording.name}: rig 'analogue-card' needs at least {_FEWEST} "
            f"samples; the recording has {len(time)}. Record longer, or at a higher rate"
        )
    interval = even_interval(recording, "analogue-card")
    signals, missing, noise = {}, {}, {}
    for channel in CHANNELS:
        if channel not in recording:
            continue
        samples = recording[channel]
        missing[channel] = ~np.isfinite(samples)
        signals[channel] = bridged(time, samples)
        stated = recording.noise_rms.get(channel)
        noise[channel] = stated or noise_floor(samples, time)
    return CardFeed(interval, signals, missing, noise, card_nominal(recording))


def card_nominal(recording: Recording) -> CardNominal:
    """Return the card that a recording was taken on: its design file, or its nominal figures.

    Figures that are not given, the type of op-amp among them, are those of the default design.
    """
    table = recording.card
    try:
        design = load_design(table["design"]) if "design" in table else load_design()
    except CardInputError as problem:
        raise InputError(str(problem)) from problem
    figures = card_figures(design)
    stages = card_stages(CardBehaviour(design))
    share = stages.limiter.division * stages.limiter.fraction
    ahead = np.clip(limiter_inputs(), *stages.comparator_swing)
    wanted = limiter_inputs()
    limited = np.interp(ahead, wanted, stages.limiter.clamped) * stages.limiter.fraction
    nominal = CardNominal(
        design,
        figures,
        1.0 / (2.0 * np.pi * design.soldered.operational_amplifier.gain_bandwidth),
        share,
        (float(stages.surface_swing[0]), float(stages.surface_swing[1])),
        wanted * share / figures.level,
        limited / figures.level,
    )
    given: dict[str, Any] = {key: float(value) for key, value in table.items() if key != "design"}
    if not given:
        return nominal
    if "break_frequency" in given:
        both = (given.pop("break_frequency"),) * 2
        figures = replace(figures, velocity_breaks=both, acceleration_breaks=both)
    figures = replace(figures, **given)
    swing = (-figures.surface_limit, figures.surface_limit)
    return replace(nominal, figures=figures, share=1.0, swing=swing)


def spectrum(signal: Array) -> Spectrum:
    """Return the Fourier transform of a signal that is continued smoothly into its own start."""
    size, n = _extended_size(len(signal)), len(signal)
    extra = size - n
    falling = 0.5 * (1.0 + np.cos(np.pi * (np.arange(extra) + 1.0) / (extra + 1.0)))
    after = 2.0 * signal[-1] - signal[-2 : -extra - 2 : -1]
    before = 2.0 * signal[0] - signal[extra:0:-1]
    return np.fft.rfft(np.concatenate([signal, after * falling + before * (1.0 - falling)]))


def without_noise(transform: Spectrum, noise: float) -> Spectrum:
    """Return a transform of `spectrum` with the frequencies faded out that hold noise alone.

    Parameters
    ----------
    transform : (m,) array
        Of a recorded signal.
    noise : float
        Its noise, white [unit of the signal].

    Notes
    -----
    Wiener's filter 1 - N/P, with some margin, as the power P is that of few neighbours.
    """
    from scipy.ndimage import uniform_filter1d

    size = 2 * (len(transform) - 1)
    power = uniform_filter1d(np.abs(transform) ** 2, _NEIGHBOURS, mode="nearest")
    kept = np.clip(1.0 - _MARGIN * size * noise**2 / np.maximum(power, 1e-300), 0.0, 1.0)
    clean: Spectrum = transform * kept
    return clean


def signal_of(transform: Spectrum, size: int) -> Array:
    """Return the signal behind a transform of `spectrum`."""
    whole: Array = np.fft.irfft(transform, _extended_size(size))
    return whole[:size]


def _extended_size(size: int) -> int:
    from scipy.fft import next_fast_len

    return int(next_fast_len(size + min(_EXTENSION, size // 2), real=True))
