"""Recordings followed as what was found allows: what a model lacks decides how far to trust it."""

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.fitting import refitted
from pneuservo.diagnosis.followed import likeliest_followed
from pneuservo.diagnosis.models.model import are_the_same
from pneuservo.diagnosis.search import Search
from pneuservo.diagnosis.ways import Cases, values_in_ways


def as_found(search: Search) -> Search:
    """Return a search that was begun, run to its end in recordings followed as names allow.

    Parameters
    ----------
    search : Search
        From `with_first_name`.

    Notes
    -----
    With a name in it a model may be trusted so far that a second effect shows. What is still
    missing has an observer trust its model less, which then follows what is missing: so at last it
    is asked for by one that trusts its model.
    """
    for further in (_run_anew, _trusted):
        if not search.interrupted:
            try:
                search = further(search)
            except KeyboardInterrupt:
                search.interrupted = True
    return search


def _run_anew(search: Search) -> Search:
    """Return a search that was run, once more where recordings are followed with further names."""
    first = frozenset(search.accepted)
    search.run()
    if search.interrupted or frozenset(search.accepted) == first:
        return search
    return _gone_on(search, followed_anew(search))


def followed_anew(search: Search) -> Search:
    """Return a search in recordings that are better followed with what was found, or the same.

    Parameters
    ----------
    search : Search
        What it has accepted is fitted to the recordings as they are followed then.
    """
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
    if are_the_same(cases, search.cases) or not search.leaves_noise(search.chosen):
        return search
    other = _gone_on(search, _elsewhere(search, cases, refitted(model, cases, search.chosen)))
    if frozenset(other.accepted) <= frozenset(search.accepted):
        return search
    as_it_was = refitted(model, search.cases, other.chosen)
    before = min(deviance_of(search, found) for found in (search.chosen, as_it_was))
    return other if deviance_of(other, other.chosen) < before else search


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


def deviance_of(search: Search, found: Fit) -> float:
    """Return how unlikely a fit makes all recordings of a search.

    Parameters
    ----------
    search : Search
        In recordings as they are read and followed.
    found : Fit
        To them.
    """
    return search.model.deviance(search.cases, values_in_ways([search.cases], [found])[0])
