"""Readings whose stated noise is less than what the steps of their converter make of it."""

import math
from dataclasses import replace

from pneuservo.diagnosis.models.servo.feed import CHANNELS
from pneuservo.noise import noise_level
from pneuservo.recordings import Recording
from pneuservo.recordings.converter import converter_step, noise_of_steps

_WORTH_SAYING = 1.05
"""Times its stated noise that a channel has to have: noise is known no better."""


def with_noise_of_steps(recording: Recording) -> Recording:
    """Return a recording in which no stated noise leaves out the steps of a converter.

    Parameters
    ----------
    recording : Recording
        Of the servo; what it states may be that of its transducers alone.

    Returns
    -------
    Recording
        With a warning for each channel whose noise is more; the same recording if that of none is.

    Notes
    -----
    The noise is at least that of the steps, and at most both together; within these it is what the
    recording shows. (Steps of 7.3 um and 500 Pa beside a stated noise of 1 um and 100 Pa were
    called a friction that gives way by 2.5 um.)

    Examples
    --------
    >>> import numpy as np
    >>> place = np.round(np.linspace(0.0, 1e-3, 1000) / 1e-5) * 1e-5
    >>> moved = Recording(
    ...     "run", np.arange(1000.0), {"displacement": place}, noise_rms={"displacement": 1e-6}
    ... )
    >>> round(with_noise_of_steps(moved).noise_rms["displacement"], 8)
    2.89e-06
    """
    noise, warnings = dict(recording.noise_rms), list(recording.warnings)
    for name in CHANNELS:
        stated = noise.get(name, 0.0)
        if not stated or name not in recording:
            continue
        step = converter_step(recording[name])
        of_steps = noise_of_steps(step)
        shown = noise_level(recording[name], recording.time) if step else 0.0
        has = min(max(shown, stated, of_steps), math.hypot(stated, of_steps))
        if has > _WORTH_SAYING * stated:
            noise[name] = has
            warnings.append(
                f"{name}: its noise is stated as {stated:.3g}, but read in steps of {step:.3g} it "
                f"has {has:.3g}, which is what it is judged by"
            )
    if len(warnings) == len(recording.warnings):
        return recording
    return replace(recording, noise_rms=noise, warnings=tuple(warnings))
