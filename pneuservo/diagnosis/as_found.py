"""Recordings followed as what was found allows: what a model lacks decides how far to trust it."""

from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.fitting import refitted
from pneuservo.diagnosis.followed import likeliest_followed
from pneuservo.diagnosis.judge import AS_GOOD, TIED
from pneuservo.diagnosis.models.model import are_the_same
from pneuservo.diagnosis.search import Search
from pneuservo.diagnosis.strained import leaves_noise
from pneuservo.diagnosis.ways import Cases, values_in


def as_found(search: Search) -> Search:
    """Return a search that was begun, run to its end in recordings followed as names allow.

    Parameters
    ----------
    search : Search
        In recordings as they are best followed without any name.

    Notes
    -----
    With a name in it a model may be trusted so far that another is seen to be the right one, or
    that a second effect shows. What is still missing has an observer trust its model less, which
    then follows what is missing: so at last it is asked for by one that trusts its model.
    """
    for further in (_begun_anew, _run_anew, _trusted):
        if not search.interrupted:
            try:
                search = further(search)
            except KeyboardInterrupt:
                search.interrupted = True
    return search


def _begun_anew(search: Search) -> Search:
    """Return a search begun again in recordings followed with the first name, where they are.

    Another name than the first must not make them far unlikelier than that does there: what is
    missed slowly has few samples to be judged by, and evidence alone may prefer what misses more.
    """
    begun = _followed_anew(search)
    if begun is search:
        return search
    first = begun.fits[search.chosen.hypothesis]
    begun.begin()
    search.interrupted = begun.interrupted
    if not begun.accepted:
        return search
    if _is_far_unlikelier(begun, begun.chosen, first):
        begun.accepted[:], begun.ledger[:] = search.accepted, search.ledger
    return begun


def _is_far_unlikelier(search: Search, found: Fit, other: Fit) -> bool:
    """Return whether a fit misses more than another one does, and not for how forms of laws are."""
    form = AS_GOOD * explained(search.baseline, other, other.in_noise)
    return _unlikeliness(search, found) > _unlikeliness(search, other) + TIED + form


def _run_anew(search: Search) -> Search:
    """Return a search that was run, once more where recordings are followed with further names."""
    first = frozenset(search.accepted)
    search.run()
    if search.interrupted or frozenset(search.accepted) == first:
        return search
    return _gone_on(search, _followed_anew(search))


def _followed_anew(search: Search) -> Search:
    """Return a search in recordings that are better followed with what was found, or the same."""
    if not search.accepted:
        return search
    model, named = search.model, search.chosen
    cases, again = likeliest_followed(model, search.cases, named, search.progress)
    return search if again is None or again is named else _elsewhere(search, cases, again)


def _trusted(search: Search) -> Search:
    """Return a search that found more where the model is trusted, if recordings are likelier so."""
    model = search.model
    cases = model.trusted(search.cases)
    # Where more than noise is left, it is not hidden.
    if are_the_same(cases, search.cases) or not leaves_noise(search.cases, search.chosen):
        return search
    other = _gone_on(search, _elsewhere(search, cases, refitted(model, cases, search.chosen)))
    if frozenset(other.accepted) <= frozenset(search.accepted):
        return search
    as_it_was = refitted(model, search.cases, other.chosen)
    before = min(_unlikeliness(search, found) for found in (search.chosen, as_it_was))
    return other if _unlikeliness(other, other.chosen) < before else search


def _elsewhere(search: Search, cases: Cases, named: Fit) -> Search:
    """Return a search in the same recordings, followed otherwise, with its baseline and a fit."""
    fits = {named.hypothesis: named}
    if search.accepted:
        baseline = refitted(search.model, cases, search.baseline)
        fits[baseline.hypothesis] = baseline
    return Search(search.model, cases, search.progress, search.seed, fits)


def _gone_on(search: Search, other: Search) -> Search:
    """Return the other search with what was accepted and more, or the same where nothing was."""
    if other is search:
        return search
    other.go_on_with(search)
    search.interrupted = other.interrupted
    return other if other.accepted else search


def _unlikeliness(search: Search, found: Fit) -> float:
    return search.model.unlikeliness(search.cases, values_in([search.cases], [found])[0])
