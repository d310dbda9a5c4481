"""What was recorded and is not read is said, so that nobody takes it for a part of the answer."""

import numpy as np
import pytest

from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.recordings import Recording

TIME = np.arange(16.0)


def word_of(*channels: str) -> tuple[str, ...]:
    recording = Recording("any", TIME, dict.fromkeys(channels, TIME), warnings=("one gap",))
    return ServoModel().with_word_of_unread(recording).warnings


@pytest.mark.parametrize(
    ("channels", "said"),
    [
        (("acceleration",), "acceleration was recorded, but"),
        (("temperature_a", "velocity"), "velocity and temperature_a were recorded, but"),
    ],
)
def test_channels_that_are_not_read_are_named(channels, said):
    before, warning = word_of("displacement", "force", *channels)
    assert before == "one gap"
    assert warning.startswith(said)


def test_nothing_is_said_of_what_is_read():
    assert word_of("displacement", "force", "spool", "supply_pressure") == ("one gap",)
