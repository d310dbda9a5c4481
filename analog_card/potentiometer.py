"""A potentiometer whose wiper feeds a resistor: what it passes on and where to turn it."""

import math


def loaded_gain(fraction: float, track: float, resistance: float, feedback: float) -> float:
    """Return the gain from the top of the track through wiper and resistor to a summing output.

    Parameters
    ----------
    fraction : float
        Wiper position, 0 at ground, 1 at the top.
    track : float
        Resistance of the whole track [ohm].
    resistance : float
        Resistor from the wiper to the summing node [ohm].
    feedback : float
        Feedback resistor of the summing amplifier [ohm].

    Returns
    -------
    float
        Magnitude of the gain [V/V].

    Notes
    -----
    The wiper is a source of the open-circuit voltage behind both parts of the track in
    parallel, fraction (1 - fraction) track; the summing node is taken to be at ground.

    Examples
    --------
    >>> round(loaded_gain(0.5, 10e3, 100e3, 100e3), 4)  # 0.5 without the load
    0.4878
    """
    return feedback * fraction / (resistance + fraction * (1 - fraction) * track)


def fraction_for_gain(gain: float, track: float, resistance: float, feedback: float) -> float:
    """Return the wiper position at which `loaded_gain` has a given value.

    Parameters
    ----------
    gain : float
        Magnitude of the gain wanted [V/V], not negative.
    track, resistance, feedback : float
        As for `loaded_gain` [ohm].

    Returns
    -------
    float
        Wiper position; above 1 when the gain is out of reach.

    Notes
    -----
    The positive root of gain track f^2 + (feedback - gain track) f - gain resistance = 0, in
    the form that stays accurate when the track is small against the resistor.

    Examples
    --------
    >>> round(fraction_for_gain(0.4878, 10e3, 100e3, 100e3), 4)
    0.5
    """
    linear = feedback - gain * track
    root = math.sqrt(linear**2 + 4 * gain**2 * track * resistance)
    return 2 * gain * resistance / (linear + root)
