"""Parts of the diagnosis of a servo can be left out, to see what they are good for."""

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis import PARTS, diagnose
from pneuservo.diagnosis.models import model_of
from pneuservo.errors import InputError
from pneuservo.rigs import load_rig


@pytest.fixture(scope="module")
def recording():
    return recorded(load_rig("single-axis"), Proportional(), 6)


def cases_without(recording, *parts):
    model = model_of("single-axis", frozenset(parts))
    return model, model.cases(recording, load_rig("single-axis"))


def test_without_the_mask_the_displacement_counts_while_the_piston_sticks(recording):
    counted = [
        np.count_nonzero(cases_without(recording, *parts)[1][0].usable)
        for parts in ((), ("stick-mask",))
    ]
    assert counted[1] > counted[0]


def test_without_nuisances_nothing_takes_up_what_differs_between_recordings(recording):
    for parts, expected in (((), True), (("nuisances",), False)):
        model, cases = cases_without(recording, *parts)
        assert bool(model.nuisances(cases[0], frozenset())) is expected
        assert ("valve.spool.frequency" in model.fitted(cases[0])) is expected


def test_an_unknown_part_is_refused(recording):
    with pytest.raises(InputError, match="stick-mask"):
        diagnose([recording], without=["stick"])
    assert len(PARTS) == len(set(PARTS))
