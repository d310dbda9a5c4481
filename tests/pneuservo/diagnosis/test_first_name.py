"""What the first name is, once recordings are followed with it."""

from types import SimpleNamespace

import pytest

from pneuservo.diagnosis import first_name


@pytest.mark.parametrize(
    ("unlikeliness", "kept"),
    [(-90.0, "other"), (0.0, "other"), (11.0, "other"), (13.0, "first")],
)
def test_another_first_name_stands_unless_it_makes_recordings_far_unlikelier(
    monkeypatch, unlikeliness, kept
):
    fits = {
        name: SimpleNamespace(hypothesis=name, in_noise=name) for name in ("", "first", "other")
    }
    begun, search = (
        SimpleNamespace(
            fits=fits,
            baseline=fits[""],
            accepted=[name],
            ledger=[name],
            chosen=fits[name],
            interrupted=False,
            begin=lambda: None,
        )
        for name in ("other", "first")
    )
    # The first name explains 1,000 where the recordings are followed with it: 2 and 10 are form.
    monkeypatch.setattr(first_name, "explained", lambda *fits: 1000.0)
    monkeypatch.setattr(first_name, "followed_anew", lambda search: begun)
    monkeypatch.setattr(
        first_name,
        "unlikeliness_of",
        lambda search, found: unlikeliness if found is fits["other"] else 0.0,
    )
    assert first_name._begun_anew(search).accepted == [kept]
