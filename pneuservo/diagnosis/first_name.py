"""The first name, in recordings that are read and followed as it allows."""

from collections.abc import Sequence

from pneuservo.diagnosis.as_found import deviance_of, followed_anew
from pneuservo.diagnosis.fit import Fit, explained, gained_most
from pneuservo.diagnosis.fitting import beyond_ridges
from pneuservo.diagnosis.followed import likeliest_followed
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import AS_GOOD, TIED
from pneuservo.diagnosis.readings import Reading, leaves_little, likelier_with, ranked_readings
from pneuservo.diagnosis.readings_by_effect import likelier_if_late, likelier_with_another
from pneuservo.diagnosis.search import Search


def with_first_name(search: Search) -> Search:
    """Return a search that has begun, in recordings as they are best read and followed.

    Parameters
    ----------
    search : Search
        In recordings as they come.

    Raises
    ------
    KeyboardInterrupt
        When not even the baseline is fitted yet.

    Notes
    -----
    With a name in it a model may be trusted so far that another is seen to be the right one, so the
    search begins again there. What that only has to confirm may be a guess at first.
    """
    model, progress = search.model, search.progress
    ranked = ranked_readings(model, model.readings(search.cases), progress)
    try:
        late = likelier_if_late(model, ranked, progress)
    except KeyboardInterrupt:
        return _stopped(search, ranked[0])
    first = _as_read(search, ranked, late, guess=True)
    if first.interrupted or not first.accepted:
        return first
    found = first
    try:
        guess = list(first.accepted) if first.guessed else None
        found = _begun_anew(first)
        if found.interrupted or guess in (None, found.accepted):
            return found
        surely = _as_read(search, ranked, late, guess=False)
        if not surely.interrupted:
            return _begun_anew(surely)
        if surely.accepted:
            return surely
    except KeyboardInterrupt:
        pass
    found.interrupted = True
    return found


def _as_read(
    search: Search, ranked: Sequence[Reading], late: Reading | None, guess: bool
) -> Search:
    """Return the search in the recordings as they are best read, begun.

    How they are read follows from their baselines and, where a name explains more than lies
    between these, or something late may do so, from the fits with that name.
    """
    first = _followed(search, late or ranked[0])
    asked = None
    if guess and not late:
        asked, turned = _turned_by_guess(first, ranked)
        if turned:
            return turned
    if not first.interrupted:
        first.begin(guess)
    if late and not first.accepted and not first.interrupted:
        late, first = None, _begun(search, ranked[0], guess)
    if first.interrupted:
        return first
    if late:
        ranked = [late, *(reading for reading in ranked if reading is not late)]
    return _turned_by_what_was_found(first, ranked, guess, asked)


def _turned_by_what_was_found(
    first: Search, ranked: Sequence[Reading], guess: bool, asked: Hypothesis | None
) -> Search:
    """Return a search begun in the reading that a name makes likelier, or the first.

    What was asked for already is not asked for again.
    """
    model, found = first.model, first.chosen
    try:
        other = None
        if first.accepted and found.hypothesis != asked:
            other = likelier_with(model, ranked, first.baseline, found, first.progress)
        if other is None:
            return _with_another(first, ranked, guess)
        second = _begun(first, other, guess)
        if second.accepted or not second.interrupted:
            return second
    except KeyboardInterrupt:
        pass
    # What the first reading has shown is more than nothing.
    first.interrupted = True
    return first


def _with_another(first: Search, ranked: Sequence[Reading], guess: bool) -> Search:
    """Return a search begun in the reading that another effect makes likelier, or the first.

    That is asked for where the first leaves more than noise, and given up where no name earns its
    place there.
    """
    model = first.model
    if len(ranked) == 1 or not model.steady or first.leaves_noise(first.chosen):
        return first
    base = first.baseline
    most = max(first.fits.values(), key=lambda found: gained_most(base, found))
    other = likelier_with_another(model, ranked, base, most, first.progress)
    if other is None:
        return first
    second = _begun(first, other, guess)
    first.interrupted |= second.interrupted
    return second if second.accepted else first


def _turned_by_guess(
    first: Search, ranked: Sequence[Reading]
) -> tuple[Hypothesis | None, Search | None]:
    """Return what was asked for, and a search begun in the reading that it makes likelier, if any.

    What explains nearly everything need not have been held against its rivals to turn them: in the
    other way it will be. Where nothing earns its place there the search goes on in the first.
    """
    if first.interrupted or len(ranked) == 1 or not first.model.steady:
        return None, None
    try:
        guess = first.first_guess()
        if guess is None or not leaves_little(guess):
            return None, None
        other = likelier_with(first.model, ranked, first.baseline, guess, first.progress)
        if other is None:
            return guess.hypothesis, None
        second = _begun(first, other, guess=True)
    except KeyboardInterrupt:
        first.interrupted = True
        return None, None
    first.interrupted = second.interrupted
    return guess.hypothesis, second if second.accepted else None


def _begun(search: Search, reading: Reading, guess: bool) -> Search:
    """Return a search in recordings as they are read and best followed, begun."""
    begun = _followed(search, reading)
    if not begun.interrupted:
        begun.begin(guess)
    return begun


def _followed(search: Search, reading: Reading) -> Search:
    """Return a search in recordings as they are read and best followed."""
    model = search.model
    try:
        cases, baseline = likeliest_followed(
            model, reading.cases, reading.baseline, search.progress
        )
    except KeyboardInterrupt:
        return _stopped(search, reading)
    found = Search(model, cases, search.progress, search.seed)
    if baseline is not None:
        found.fits[baseline.hypothesis] = baseline
        try:
            closer = beyond_ridges(model, cases, baseline)
        except KeyboardInterrupt:
            found.interrupted = True
            return found
        found.fits[closer.hypothesis] = closer
    return found


def _stopped(search: Search, reading: Reading) -> Search:
    """Return the search in recordings read in one way, interrupted with no more than a baseline.

    Raises
    ------
    KeyboardInterrupt
        When not even that was.
    """
    if reading.baseline is None:
        raise KeyboardInterrupt
    stopped = Search(search.model, reading.cases, search.progress, search.seed)
    stopped.fits[reading.baseline.hypothesis] = reading.baseline
    stopped.interrupted = True
    return stopped


def _begun_anew(search: Search) -> Search:
    """Return a search begun again in recordings followed with the first name, or to be sure of it.

    Another name than the first must not make them far unlikelier than that does there: what is
    missed slowly has few samples to be judged by, and the criterion alone may prefer what misses
    more.
    """
    begun = followed_anew(search)
    if begun is search and not search.guessed:
        return search
    first, named, told = begun.fits[search.chosen.hypothesis], [*search.accepted], [*search.ledger]
    begun.begin()
    search.interrupted |= begun.interrupted
    if not begun.accepted:
        search.accepted[:], search.ledger[:] = named, told
        return search
    if begun is not search and _is_far_unlikelier(begun, begun.chosen, first):
        begun.accepted[:], begun.ledger[:] = named, told
    return begun


def _is_far_unlikelier(search: Search, found: Fit, other: Fit) -> bool:
    """Return whether a fit misses more than another one does, and not for how forms of laws are."""
    form = AS_GOOD * explained(search.baseline, other, other.in_noise)
    return deviance_of(search, found) > deviance_of(search, other) + TIED + form
