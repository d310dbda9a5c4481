"""Recordings each of which is to be read in a way of its own."""

from types import SimpleNamespace

import pytest

from pneuservo.diagnosis import readings
from pneuservo.diagnosis.readings import Reading, likelier_with, ranked_readings

ALONE = ({"run": 100.0, "curve": 100.0, "held": 102.0}, {"run": 100.0, "held": 140.0})
"""How unlikely each of two recordings is in each way, whatever is made of the other."""


class Ways:
    """Two recordings, and how unlikely a pair of ways to read them is."""

    def __init__(self, deviance):
        self.deviance = deviance
        names = [sorted(alone) for alone in ALONE]
        origins = [SimpleNamespace(), SimpleNamespace()]
        self.cases = [
            {way: SimpleNamespace(origin=origin, way=way) for way in own}
            for origin, own in zip(origins, names, strict=True)
        ]

    def read(self, first, second):
        return [self.cases[0][first], self.cases[1][second]]

    def fitted(self, cases):
        return SimpleNamespace(ways=tuple(case.way for case in cases), penalty=0.0, residuals=[])

    def of_each(self, cases):
        whole = self.deviance[tuple(case.way for case in cases)]
        return {id(case.origin): whole / 2 for case in cases}

    def alone(self, ways):
        return [
            {id(c.origin): ALONE[place][c.way] for place, c in enumerate(cases)} for cases in ways
        ]


@pytest.fixture
def let_ways_know(monkeypatch):
    def patch(ways):
        as_it_is = {
            "baselines_of": lambda model, all_, near: [ways.fitted(cases) for cases in all_],
            "values_in_ways": lambda all_, fits: [None] * len(all_),
            "all_excused": lambda model, all_, values: list(all_),
            "best_excused": lambda model, cases, values: cases,
            "deviance_as_followed": lambda model, all_, values: [*map(ways.of_each, all_)],
            "at_their_best": lambda model, all_, fits: ways.alone(all_),
            "refitted": lambda model, cases, near: ways.fitted(cases),
            "fit": lambda model, cases, *near, **elsewhere: ways.fitted(cases),
            "leaves_little": lambda found: False,
            "gained_most": lambda before, after: 1000.0,
        }
        for name, stand_in in as_it_is.items():
            monkeypatch.setattr(readings, name, stand_in)

    return patch


def quiet(step):
    """Tell nobody what is being fitted."""


def names(cases):
    return tuple(case.way for case in cases)


def test_a_way_is_not_hidden_by_another_that_is_nearly_the_first(let_ways_know):
    ways = Ways(
        {
            ("run", "run"): 300.0,
            ("curve", "run"): 301.0,
            ("held", "held"): 400.0,
            ("held", "run"): 200.0,
        }
    )
    let_ways_know(ways)
    given = [ways.read("run", "run"), ways.read("curve", "run"), ways.read("held", "held")]
    ranked = ranked_readings(None, given, quiet)
    assert [names(reading.cases) for reading in ranked][:2] == [("held", "run"), ("run", "run")]


def test_with_a_name_each_recording_is_read_as_suits_it_best(let_ways_know):
    ways = Ways({("held", "held"): 300.0, ("run", "run"): 310.0, ("held", "run"): 100.0})
    with_it = ({"run": 130.0, "held": 50.0}, {"run": 50.0, "held": 140.0})
    ways.alone = lambda all_: [
        {id(c.origin): with_it[place][c.way] for place, c in enumerate(cases)} for cases in all_
    ]
    let_ways_know(ways)
    ranked = [
        Reading(ways.read("held", "held"), None, 300.0),
        Reading(ways.read("run", "run"), None, 310.0),
    ]
    named = ways.fitted(ranked[0].cases)
    named.hypothesis = None
    found = likelier_with(None, ranked, None, named, quiet)
    assert names(found.cases) == ("held", "run")
    # Where the first is the likeliest with it as well, it stays.
    ways.deviance[("held", "run")] = 500.0
    assert likelier_with(None, ranked, None, named, quiet) is None
