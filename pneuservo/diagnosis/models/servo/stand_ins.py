"""Taps of the analogue card that stand for channels of the servo that were not recorded."""

from dataclasses import replace

import numpy as np

from pneuservo.controllers.requirements import sensitivity
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig


def with_stand_ins(recording: Recording, rig: Rig) -> Recording:
    """Return a recording whose missing command and displacement are taken from the card's taps.

    Parameters
    ----------
    recording : Recording
        Of the servo.
    rig : Rig
        Its transducer says how far the piston is out at which voltage.

    Returns
    -------
    Recording
        With a warning for each channel that stands for another; the same recording if none does.

    Notes
    -----
    The card's output is the command of the valve's driver, which goes no farther than full opening
    asks for, and its input is the voltage of the
    displacement transducer: 0 V at the retracted stop, its range at the other (thesis section 3.5).

    Examples
    --------
    >>> import numpy as np
    >>> from pneuservo.rigs import load_rig
    >>> taps = {"card_sensor": np.array([0.0, 5.0]), "card_output": np.array([1.0, -1.0])}
    >>> found = with_stand_ins(Recording("taps", np.arange(2.0), taps), load_rig("single-axis"))
    >>> found["displacement"].round(6).tolist(), found["valve_voltage"].tolist()
    ([0.0, 0.015], [1.0, -1.0])
    """
    channels, noise = dict(recording.channels), dict(recording.noise_rms)
    warnings = list(recording.warnings)
    driver = rig["valve.full_voltage"]
    for name, tap, volts, limit in (
        ("valve_voltage", "card_output", 1.0, driver),
        ("displacement", "card_sensor", sensitivity(rig), np.inf),
    ):
        if name in channels or tap not in channels:
            continue
        channels[name] = np.clip(channels[tap] / volts, -limit, limit)
        if tap in noise:
            noise[name] = noise[tap] / volts
        warnings.append(f"{name} was not recorded: taken from {tap}")
    if len(channels) == len(recording.channels):
        return recording
    return replace(recording, channels=channels, noise_rms=noise, warnings=tuple(warnings))
