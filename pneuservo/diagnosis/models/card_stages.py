"""The stages of the card, each as what was measured ahead of it should make it do.

Values are those of a fit: a stage's own small errors, and the parameters of effects.
"""

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.card_feed import CardFeed, Spectrum, signal_of
from pneuservo.diagnosis.models.card_kernels import (
    limited_differentiator,
    limited_rate,
    with_hysteresis,
)
from pneuservo.diagnosis.models.model import Values

DIFFERENTIATORS = {
    "card_velocity": (1, "card_sensor"),
    "card_acceleration": (2, "card_velocity"),
}
"""Number of each differentiator and the channel it is fed with, by its tap."""
SENSITIVITY = "sensor.displacement.sensitivity"
_DEEP = 3.0
"""The output is at its level when the surface is so many times beyond the layer."""
_LINEAR = 0.8
"""Share of the level below which the output is sure to follow the surface."""
_CLEAR = 6.0
"""A change of so many times the noise is one of the signal."""
_ENOUGH = 10
"""Samples inside the layer that its gain is worked out from."""


def swing(values: Values, feed: CardFeed) -> tuple[float, float]:
    """Return the lowest and the highest output of an op-amp of the card [V]."""
    get, (low, high) = values.get, feed.nominal.swing
    drop = get("card.supply-sag:drop", 0.0)
    high = high + get("upper_error", 0.0) - drop
    low = get("lower_error", 0.0) - low - drop - get("card.supply-sag:imbalance", 0.0)
    return -max(low, 0.0), max(high, 0.0)


def differentiator_response(
    channel: str, values: Values, feed: CardFeed, frequency: Array
) -> Spectrum:
    """Return the complex gain of a differentiator over angular frequency [1/s].

    Notes
    -----
    H0 = -(s RC + leak)/((1 + s tau1)(1 + s tau2)), and with an op-amp of the gain 1/(s t)
    H = H0/(1 + s t (1 - H0)), as Zf/Zi = -H0. An error of the capacitor is one of RC and tau1
    alike, an error of the resistor one of RC and tau2, which are nominally equal.
    """
    get, (stage, _) = values.get, DIFFERENTIATORS[channel]
    figures, s = feed.nominal.figures, 1j * frequency
    first = stage == 1
    constant = figures.rc_velocity if first else figures.rc_acceleration
    breaks = figures.velocity_breaks if first else figures.acceleration_breaks
    size = (1.0 + get("gain_error", 0.0)) * (
        1.0 + get(f"card.differentiator-gain-{stage}:error", 0.0)
    )
    lag = (1.0 + get("lag_error", 0.0)) * (
        1.0 + get(f"card.differentiator-rolloff-{stage}:change", 0.0)
    )
    leak = get(f"card.capacitor-leak:{'first' if first else 'second'}", 0.0)
    tau = [1.0 / (2.0 * np.pi * frequency) for frequency in breaks]
    ideal = -(s * constant * size + leak) / ((1.0 + s * tau[0] * size) * (1.0 + s * tau[1] * lag))
    response: Spectrum = ideal / (1.0 + s * _amplifier_time(values, feed) * (1.0 - ideal))
    return response


def differentiator(
    channel: str, recorded: Array, clean: Spectrum, values: Values, feed: CardFeed
) -> Array:
    """Return the tap of a differentiator [V].

    Parameters
    ----------
    channel : str
        The tap.
    recorded : (n,) array
        The tap as the nominal stage makes it of its recorded input, noise and all [V].
    clean : (m,) array
        `spectrum` of that input without noise.
    values : mapping of str to float
        Errors and effects.
    feed : CardFeed
        The recording.

    Notes
    -----
    Errors and effects act on the input without noise: a stage that passes less of the noise
    would otherwise seem the better one.
    """
    stage, _ = DIFFERENTIATORS[channel]
    frequency = feed.frequency(feed.size)
    response = differentiator_response(channel, values, feed, frequency)
    nominal = differentiator_response(channel, {}, feed, frequency)
    shift = values.get("offset", 0.0) + values.get(f"card.offset:differentiator_{stage}", 0.0)
    tap = signal_of(response * clean, feed.size) + shift
    low, high = swing(values, feed)
    loss = values.get("card.intermediate-clipping:loss", 0.0)
    imbalance = values.get("card.intermediate-clipping:imbalance", 0.0)
    figures = feed.nominal.figures
    constant = figures.rc_velocity if stage == 1 else figures.rc_acceleration
    limited = limited_differentiator(
        tap,
        min(low + loss + imbalance, 0.0),
        max(high - loss, 0.0),
        _most_change(values, feed),
        feed.interval / constant,
    )
    changed: Array = recorded + limited - signal_of(nominal * clean, feed.size)
    return changed


def surface(values: Values, feed: CardFeed) -> Array:
    """Return the surface from what was measured at its inputs [V]."""
    get, signals, figures = values.get, feed.signals, feed.nominal.figures
    weights = [
        nominal
        * (1.0 + get(f"{state}_error", 0.0))
        * (1.0 - get(f"card.weight-loading:{state}", 0.0))
        for state, nominal in (
            ("displacement", figures.weight_displacement),
            ("velocity", figures.weight_velocity),
            ("acceleration", figures.weight_acceleration),
        )
    ]
    total = (
        weights[0] * (values[SENSITIVITY] * signals["demand"] - signals["card_sensor"])
        + weights[1] * signals["card_velocity"]
        - weights[2] * signals["card_acceleration"]
        + get("offset", 0.0)
        + get("card.offset:surface", 0.0)
    )
    total = total + _hum(values, feed)
    passed = [feed.noise[name] for name in ("card_sensor", "card_velocity", "card_acceleration")]
    noise = float(np.linalg.norm(np.multiply(weights, passed)))
    total = _late(total, _amplifier_time(values, feed) * (1.0 + sum(weights)), noise, feed)
    low, high = swing(values, feed)
    change = _most_change(values, feed)
    limited: Array = (
        np.clip(total, low, high) if np.isinf(change) else limited_rate(total, low, high, change)
    )
    return limited


def output(values: Values, feed: CardFeed) -> Array:
    """Return the output of the card from the surface that was measured [V]."""
    get, nominal = values.get, feed.nominal
    figures, share = nominal.figures, nominal.share
    gain = (
        figures.output_gain
        * (1.0 + get("gain_error", 0.0))
        * (1.0 + get("card.boundary-slope:change", 0.0))
    )
    signal = feed.signals["card_surface"] + get("offset", 0.0) + get("card.offset:output", 0.0)
    width = get("card.switch-hysteresis:width", 0.0)
    if width:
        signal = with_hysteresis(signal, width)
    lag = _amplifier_time(values, feed) * gain / share
    wanted = gain * _late(signal, lag, feed.noise["card_surface"], feed)
    low, high = swing(values, feed)
    change = _most_change(values, feed)
    if np.isfinite(change):
        wanted = limited_rate(wanted, low * share, high * share, share * change)
    level = figures.level * (1.0 + get("level_error", 0.0))
    sides = []
    for sign, name, reach in ((1.0, "positive", high), (-1.0, "negative", -low)):
        most = level * (1.0 + sign * get("asymmetry", 0.0))
        most = max(most * (1.0 + get(f"card.rail-asymmetry:{name}", 0.0)), 1e-9)
        asked = np.minimum(sign * wanted, reach * share) / most
        soft = sign * np.interp(sign * asked, nominal.overdrive, nominal.limited)
        hard = np.minimum(asked, 1.0)
        sides.append(sign * most * (hard + get("softness", 0.0) * (soft - hard)))
    voltage: Array = np.where(wanted >= 0.0, *sides) * (1.0 - get("card.output-load:loss", 0.0))
    return voltage


def levels(feed: CardFeed) -> tuple[float, float]:
    """Return the lower and the upper level of the output, as far as it was driven there [V]."""
    figures = feed.nominal.figures
    surface, voltage = feed.signals["card_surface"], feed.signals["card_output"]
    reach = _DEEP * figures.level / figures.output_gain
    found = []
    for sign in (-1.0, 1.0):
        deep = voltage[sign * surface > reach]
        found.append(float(np.median(deep)) if len(deep) else sign * figures.level)
    return found[0], found[1]


def inside_layer(feed: CardFeed) -> Mask:
    """Return at which samples the output follows the surface."""
    lower, upper = levels(feed)
    margin = 3.0 * feed.noise["card_output"]
    voltage = feed.signals["card_output"]
    return (voltage > lower + margin) & (voltage < upper - margin)


def layer_gain(feed: CardFeed) -> float:
    """Return the gain of the output as measured inside the layer, or the nominal one [V/V]."""
    inside = np.abs(feed.signals["card_output"]) < _LINEAR * min(np.abs(levels(feed)))
    if np.count_nonzero(inside) < _ENOUGH:
        return feed.nominal.figures.output_gain
    return float(
        np.polyfit(feed.signals["card_surface"][inside], feed.signals["card_output"][inside], 1)[0]
    )


def _hum(values: Values, feed: CardFeed) -> Array | float:
    get = values.get
    sizes = [get(f"card.ground-hum:{name}", 0.0) for name in ("sine", "cosine", "share")]
    if not any(sizes):
        return 0.0
    size = len(feed.signals["card_surface"])
    angle = 2.0 * np.pi * values["card.ground-hum:frequency"] * feed.interval * np.arange(size)
    drawn = feed.signals.get("card_output", np.zeros(size))
    hum: Array = sizes[0] * np.sin(angle) + sizes[1] * np.cos(angle) + sizes[2] * drawn
    return hum


def _late(signal: Array, lag: float, noise: float, feed: CardFeed) -> Array:
    """Return a signal behind a lag that is short against the sampling interval.

    Where it jumps between two samples nothing is known of the moment, and where it changes by
    no more than its noise nothing of its slope: there it is left alone.
    """
    change = np.diff(signal, prepend=signal[:1])
    following = np.append(change[1:], 0.0)
    smaller = np.where(np.abs(change) < np.abs(following), change, following)
    steady = (change * following > 0.0) & (np.abs(smaller) > _CLEAR * noise)
    late: Array = signal - min(lag / feed.interval, 1.0) * np.where(steady, smaller, 0.0)
    return late


def _amplifier_time(values: Values, feed: CardFeed) -> float:
    nominal = feed.nominal.amplifier_time
    own = nominal * (1.0 + values.get("amplifier_error", 0.0))
    return own + values.get("card.opamp-bandwidth:time", 0.0)


def _most_change(values: Values, feed: CardFeed) -> float:
    time = values.get("card.opamp-slew:time", 0.0)
    return feed.interval / time if time > 0.0 else np.inf
