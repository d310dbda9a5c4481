"""Names that leave far more than noise only stand in for something."""

from types import SimpleNamespace

import pytest

from pneuservo.diagnosis.refuted import lack_of_fit


def search_that_left(before, after, accepted=("friction.stribeck",), tabulates=True):
    """Return what stands for a search, and what its baseline and its answer leave."""
    channels = ("displacement", "pressure_a")

    def left(*sizes):
        return SimpleNamespace(rms_of=dict(zip(channels, sizes, strict=True)).__getitem__)

    return SimpleNamespace(
        model=SimpleNamespace(tabulates=tabulates),
        cases=[SimpleNamespace(channel=name, recorded=True) for name in channels]
        # What follows from what friction held has no noise of its own.
        + [SimpleNamespace(channel="friction at rest", recorded=False)],
        accepted=list(accepted),
        baseline=left(*before),
        chosen=left(*after),
        block_of=lambda name: name.partition(".")[0],
    )


@pytest.mark.parametrize(
    ("before", "after", "refuted"),
    [
        ((2.9, 1.5), (4.0, 1.3), True),  # a loop that chatters, sampled at 200 Hz
        ((2.9, 1.5), (2.4, 1.3), True),  # less than half of what showed
        ((9.0, 9.0), (1.0, 3.0), False),  # a law of another form, or a second effect
        ((2.9, 1.5), (1.6, 1.3), False),  # as much as right names have left
        ((1.0, 1.0), (1.0, 1.0), False),
    ],
)
def test_names_that_explain_little_of_a_channel_are_refuted(before, after, refuted):
    found = lack_of_fit(search_that_left(before, after))
    assert (found is not None) == refuted
    if found is not None:
        assert found.refutes
        assert found.block == "friction"
        assert f"leaves the displacement at {after[0]:.2g} times its noise" in found.words


@pytest.mark.parametrize("accepted", [(), ("param.load.mass",)], ids=["nothing", "a parameter"])
def test_without_a_name_there_is_none_to_refute(accepted):
    assert lack_of_fit(search_that_left((2.9, 1.5), (4.0, 1.3), accepted)) is None


def test_a_rig_whose_noise_is_not_known_is_judged_otherwise():
    assert lack_of_fit(search_that_left((2.9, 1.5), (4.0, 1.3), tabulates=False)) is None
