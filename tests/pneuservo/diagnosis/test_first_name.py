"""What the first name is, once recordings are followed with it."""

from types import SimpleNamespace

import numpy as np
import pytest

from pneuservo.diagnosis import first_name
from pneuservo.diagnosis.search import Search


@pytest.mark.parametrize(
    ("deviance", "kept"),
    [(-90.0, "other"), (0.0, "other"), (11.0, "other"), (13.0, "first")],
)
def test_another_first_name_stands_unless_it_makes_recordings_far_unlikelier(
    monkeypatch, deviance, kept
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
            guessed=False,
            begin=lambda: None,
        )
        for name in ("other", "first")
    )
    # The first name explains 1,000 where the recordings are followed with it: 2 and 10 are form.
    monkeypatch.setattr(first_name, "explained", lambda *fits: 1000.0)
    monkeypatch.setattr(first_name, "followed_anew", lambda search: begun)
    monkeypatch.setattr(
        first_name,
        "deviance_of",
        lambda search, found: deviance if found is fits["other"] else 0.0,
    )
    assert first_name._begun_anew(search).accepted == [kept]


class Begun(SimpleNamespace):
    """A search that has a guess, and finds another name, or nothing, where it is sure."""

    @property
    def chosen(self):
        return SimpleNamespace(hypothesis="a guess")

    def begin(self):
        self.interrupted = self.sure == "interrupted"
        self.accepted[:] = [] if self.interrupted else [self.sure]
        self.guessed = False


def as_they_come(monkeypatch):
    """Return a search in recordings whose ways to be read are worked out elsewhere."""
    monkeypatch.setattr(first_name, "ranked_readings", lambda *given: ["first", "second"])
    monkeypatch.setattr(first_name, "likelier_if_late", lambda *given: None)
    model = SimpleNamespace(readings=lambda cases: None, steady=True)
    return SimpleNamespace(model=model, cases=None, progress=None)


@pytest.mark.parametrize(
    ("sure", "searched", "named"),
    [
        ("a guess", 1, ["a guess"]),
        ("another", 2, ["searched without guessing"]),
        ("interrupted", 1, ["a guess"]),
    ],
)
def test_a_guess_is_the_first_name_where_a_search_that_is_sure_says_so(
    monkeypatch, sure, searched, named
):
    asked = []

    def read(search, ranked, late, guess):
        asked.append(guess)
        name = "a guess" if guess else "searched without guessing"
        return Begun(
            accepted=[name],
            ledger=[],
            fits={"a guess": None},
            guessed=guess,
            sure=sure,
            interrupted=False,
        )

    monkeypatch.setattr(first_name, "_as_read", read)
    monkeypatch.setattr(first_name, "followed_anew", lambda search: search)
    assert first_name.with_first_name(as_they_come(monkeypatch)).accepted == named
    assert asked == [True, False][:searched]


def test_interrupted_while_it_makes_sure_it_keeps_what_it_was_sure_of(monkeypatch):
    def read(search, ranked, late, guess):
        if not guess:
            return SimpleNamespace(accepted=[], interrupted=True)
        return Begun(accepted=["a guess"], guessed=True, interrupted=False)

    sure = SimpleNamespace(accepted=["another"], interrupted=False)
    monkeypatch.setattr(first_name, "_as_read", read)
    monkeypatch.setattr(first_name, "_begun_anew", lambda search: sure)
    found = first_name.with_first_name(as_they_come(monkeypatch))
    assert (found.accepted, found.interrupted) == (["another"], True)


class Read(SimpleNamespace):
    """A search in recordings that are read in one of two ways."""

    def first_guess(self):
        if self.guess == "interrupted":
            raise KeyboardInterrupt
        left = (np.full(10, self.leaves),)
        return self.guess and SimpleNamespace(hypothesis=self.guess, residuals=left)

    def begin(self, guess):
        self.accepted[:] = self.finds

    @property
    def chosen(self):
        return SimpleNamespace(hypothesis=" + ".join(self.accepted))

    def leaves_noise(self, found):
        return self.leaves < 1.15

    @property
    def fits(self):
        return {name: name for name in self.accepted}


@pytest.mark.parametrize(
    ("guess", "leaves", "there", "named", "read", "times_asked"),
    [
        ("a leak", 1.0, [["a leak"]], ["a leak"], "second", 1),
        # Where nothing earns its place it goes on in the first, and does not ask again.
        ("a leak", 1.0, [[]], ["a leak"], "first", 1),
        # Another name than was guessed asks for itself.
        ("a delay", 1.0, [[], ["a leak"]], ["a leak"], "second", 2),
        # What explains little is no guess, nor what leaves far more than noise.
        (None, 1.0, [["a leak"]], ["a leak"], "second", 1),
        ("a delay", 3.0, [["a leak"]], ["a leak"], "second", 1),
        ("interrupted", 1.0, [], [], "first", 0),
    ],
)
def test_a_guess_turns_the_reading_where_a_name_earns_its_place(
    monkeypatch, guess, leaves, there, named, read, times_asked
):
    model, asked = SimpleNamespace(steady=True), []
    search = SimpleNamespace(model=model, cases=None, progress=None)

    def followed(search, reading):
        finds = ["a leak"] if reading == "first" else there[len(asked) - 1]
        return Read(
            model=model,
            progress=None,
            baseline=None,
            way=reading,
            guess=guess,
            leaves=leaves,
            finds=finds,
            accepted=[],
            interrupted=False,
        )

    def likelier(model, ranked, baseline, found, progress):
        asked.append(found.hypothesis)
        return "second"

    monkeypatch.setattr(first_name, "likelier_with", likelier)
    monkeypatch.setattr(first_name, "_followed", followed)
    found = first_name._as_read(search, ["first", "second"], None, guess=True)
    assert (found.accepted, found.way, len(asked)) == (named, read, times_asked)
    assert found.interrupted is (guess == "interrupted")


@pytest.mark.parametrize(
    ("leaves", "finds", "read"),
    [
        (1.3, ["a shift"], "second"),
        (1.3, [], "first"),
        # Where noise is all that is left, nothing else is asked for.
        (1.0, ["a shift"], "first"),
    ],
)
def test_another_effect_turns_the_reading_where_more_than_noise_is_left(
    monkeypatch, leaves, finds, read
):
    model = SimpleNamespace(steady=True)

    def search(way, accepted):
        return Read(
            model=model,
            progress=None,
            baseline=None,
            way=way,
            guess=None,
            leaves=leaves,
            finds=finds,
            accepted=accepted,
            interrupted=False,
        )

    monkeypatch.setattr(first_name, "gained_most", lambda before, after: 100.0)
    monkeypatch.setattr(first_name, "likelier_with_another", lambda *given: "second")
    monkeypatch.setattr(first_name, "_followed", lambda first, reading: search(reading, []))
    first = search("first", ["a lag"])
    assert first_name._with_another(first, ["first", "second"], guess=True).way == read
    assert first_name._with_another(first, ["first"], guess=True) is first


class Guessing(Search):
    """A search whose parameters stay strained with whatever it finds."""

    def _add(self, most):
        self.guessed = self.may_guess
        self.asked = [*getattr(self, "asked", []), self.may_guess]
        self.accepted.extend(self.found)


@pytest.mark.parametrize(
    ("found", "asked", "guessed"), [(["a guess"], [True], True), ([], [True, False], False)]
)
def test_only_the_first_name_may_be_a_guess(found, asked, guessed):
    search = Guessing(None, [])
    search.found = found
    search.begin(guess=True)
    assert search.asked == asked
    assert search.guessed is guessed
    assert not search.may_guess
