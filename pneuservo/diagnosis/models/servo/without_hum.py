"""A recording of the servo, and what its observer is fed with, without the hum of the mains."""

from dataclasses import replace

import numpy as np

from pneuservo.diagnosis.hum import hum_in, repeats
from pneuservo.diagnosis.models.servo.between_samples import AsGiven
from pneuservo.diagnosis.models.servo.estimate import with_observer
from pneuservo.diagnosis.models.servo.feed import CHANNELS, FOLLOWED, Feed
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.diagnosis.models.servo.run_observer import run_observer
from pneuservo.recordings import Recording
from pneuservo.recordings.converter import converter_step
from pneuservo.rigs import Rig

_PASSES = 2
_PLACE = CHANNELS.index("displacement")


def without_hum(
    recording: Recording, rig: Rig, as_given: AsGiven, begun: Feed
) -> tuple[Recording, Feed]:
    """Return a recording without mains hum, and its feed.

    Parameters
    ----------
    recording : Recording
        As it was read.
    rig : Rig
        The rig it was taken on.
    as_given : callable
        The way in which it is read.
    begun : Feed
        From `pneuservo.diagnosis.models.servo.feeding.feed`: the same in each way.

    Returns
    -------
    Recording, Feed
        The same ones where the command repeats itself: then whatever is left does, too.

    Notes
    -----
    Innovations show a line as it is read; what is taken out shows what the motion had taken up.
    """
    fed = with_observer(as_given(begun, rig), rig)
    if repeats(fed.voltage, fed.interval):
        return recording, fed
    in_steps = [name for name in begun.noise if converter_step(recording[name])]
    for _ in range(_PASSES):
        noise = fed.noise_of(CHANNELS)
        left = run_observer(fed, {}, rig)[: len(CHANNELS)] / noise[:, np.newaxis]
        shares = np.ones((len(CHANNELS), len(fed.time)))
        shares[: len(FOLLOWED)] = fed.shares.T
        if len(fed.spool_reading):
            shares[CHANNELS.index("spool")] = fed.spool_shares
        # While the piston sticks it is not judged, but there hum shows best.
        smoothed_out = np.nan_to_num(fed.reading - fed.motion[0]) / noise[_PLACE]
        left[_PLACE, fed.held] = smoothed_out[fed.held]
        shares[_PLACE, fed.held] = 1.0
        hum = hum_in(list(left), list(shares), fed.time)
        if not np.any(hum):
            break
        channels = dict(recording.channels)
        for name, waves, scale in zip(CHANNELS, hum, noise, strict=True):
            if name in channels:
                channels[name] = channels[name] - scale * waves
        # Without hum no level of a converter comes again, and its steps would be noise no more.
        stated = {name: size for name, size in begun.noise.items() if name in in_steps}
        recording = replace(
            recording, channels=channels, noise_rms={**stated, **recording.noise_rms}
        )
        fed = with_observer(as_given(feed(recording, rig), rig), rig)
    return recording, fed
