"""Whether recordings hold enough samples to be judged by."""

from collections.abc import Sequence

import numpy as np

from pneuservo.diagnosis.models import Case
from pneuservo.errors import InputError
from pneuservo.recordings import Recording

FEWEST = 8
"""Numbers of a channel, and samples of it that can be judged, below which nothing is told."""


def require_enough_numbers(recording: Recording, unread: Sequence[str]) -> None:
    """Refuse a recording with a channel that holds next to no numbers.

    Parameters
    ----------
    recording : Recording
        Or a stretch of one.
    unread : sequence of str
        Channels that do not matter.

    Raises
    ------
    InputError
        When a channel that is read holds fewer than 8.
    """
    for channel, samples in recording.channels.items():
        numbers = int(np.count_nonzero(np.isfinite(samples)))
        if channel not in unread and numbers < FEWEST:
            raise InputError(
                f"{recording.source or recording.name}: {channel} holds {numbers} numbers here; at "
                f"least {FEWEST} are needed; leave the channel out, or use another stretch"
            )


def require_enough_judged(cases: Sequence[Case]) -> None:
    """Refuse recordings of which next to nothing can be judged.

    Parameters
    ----------
    cases : sequence of Case
        Prepared for a model.

    Raises
    ------
    InputError
        When fewer than 8 samples are left of a channel, for what drives it is missing elsewhere.
    """
    for case in cases:
        judged = int(np.count_nonzero(case.usable))
        if case.recorded and judged < FEWEST:
            origin = case.origin
            channel = case.channel or "what is judged"
            raise InputError(
                f"{origin.source or origin.name}: {judged} samples of {channel} can be judged; at "
                f"least {FEWEST} are needed; record without gaps, or use another stretch"
            )
