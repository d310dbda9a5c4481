"""What an effect has to explain beside others, and which candidates promise anything."""

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from pneuservo.diagnosis import hypotheses, rivals
from pneuservo.diagnosis import search as search_module
from pneuservo.diagnosis.by_gain import ByGain
from pneuservo.diagnosis.fit import orthonormal
from pneuservo.diagnosis.hypotheses import Hypotheses
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import LEAST_DISTANCE, LEAST_GAIN, SECOND_SHARE
from pneuservo.diagnosis.screen import within_reach
from pneuservo.diagnosis.search import Search
from pneuservo.diagnosis.signatures import gained_beyond
from pneuservo.diagnosis.starts import Begin
from pneuservo.effects import effect_by_id, effects_of

SAMPLES = 10_000


def left(**rms):
    """Return what stands for a fit that leaves so much of each channel."""
    return SimpleNamespace(
        rms=float(np.sqrt(np.mean(np.square(list(rms.values()))))),
        samples=SAMPLES * len(rms),
        effective=dict.fromkeys(rms, SAMPLES),
        rms_of=rms.__getitem__,
        samples_of=lambda channel: SAMPLES,
        hypothesis=SimpleNamespace(members=("first",)),
    )


def share(baseline, current, closer):
    return ByGain(current, baseline, (), lambda name, fit: 0.0, lambda fit: 0.0).share(closer)


def test_what_the_form_of_a_large_effect_leaves_earns_no_second_place():
    # The first effect explains all but 3 % of what was in the displacement, the second those 3 %.
    found = share(
        left(displacement=3.0, pressure_a=1.0),
        left(displacement=1.11, pressure_a=1.0),
        left(displacement=1.0, pressure_a=1.0),
    )
    assert found == pytest.approx(0.029, abs=0.005)
    assert found < SECOND_SHARE


def test_an_effect_in_another_channel_does_not_compete_with_it():
    found = share(
        left(displacement=3.0, pressure_a=1.02),
        left(displacement=1.0, pressure_a=1.02),
        left(displacement=1.0, pressure_a=1.0),
    )
    assert found > SECOND_SHARE
    # Noise is no channel of its own: there the gain is too small to count.
    few = np.sqrt(1.0 + 0.5 * LEAST_GAIN / SAMPLES)
    unseen = share(
        left(displacement=3.0, pressure_a=few),
        left(displacement=1.0, pressure_a=few),
        left(displacement=1.0, pressure_a=1.0),
    )
    assert unseen < SECOND_SHARE


@pytest.mark.parametrize(
    ("frequency", "is_itself"), [(150.0, False), (149.0, True)], ids=["at all ends", "inside"]
)
def test_an_effect_at_the_ends_of_all_its_ranges_is_another(frequency, is_itself):
    mode = effect_by_id("load.transverse-mode", "single-axis")
    values = {"share": 0.4, "frequency": frequency, "damping": 0.3}
    assert all(v <= p.high for p, v in zip(mode.parameters, values.values(), strict=True))
    fit = SimpleNamespace(shared={mode.key(name): value for name, value in values.items()})
    judge = ByGain(fit, fit, [mode], lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge._is_not_itself(mode.id, fit) is not is_itself


@pytest.mark.parametrize(("time", "is_itself"), [(2e-5, False), (3e-4, True)])
def test_a_hose_of_no_length_does_not_delay(time, is_itself):
    # It throttles, and is to be named by that: of a throttle that holds some air 20 us were left.
    delay = effect_by_id("line.delay", "single-axis")
    fit = SimpleNamespace(shared={delay.key("time"): time, delay.key("area"): 5e-6})
    judge = ByGain(fit, fit, [delay], lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge._is_not_itself(delay.id, fit) is not is_itself


@pytest.mark.parametrize(("stiffness", "is_itself"), [(3e7, False), (1e7, True)])
def test_a_stop_of_steel_is_no_bumper(stiffness, is_itself):
    # Of one that gave way by 3 um, as steel does, a bumper of 3 um was left.
    contact = effect_by_id("endstop.contact", "single-axis")
    values = {"stiffness": stiffness, "damping": 200.0, "length": 3e-6}
    fit = SimpleNamespace(shared={contact.key(name): value for name, value in values.items()})
    judge = ByGain(fit, fit, [contact], lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge._is_not_itself(contact.id, fit) is not is_itself


def leaves(energy, unknowns):
    """Return what stands for a fit that leaves this sum of squares."""
    return SimpleNamespace(
        residuals=np.array([np.sqrt(energy)]),
        weigh=lambda residuals: residuals,
        penalty=0.0,
        unknowns=unknowns,
        hypothesis=SimpleNamespace(effects={"first"}),
        effective={"displacement": SAMPLES},
    )


@pytest.mark.parametrize(
    ("criteria", "left_over", "unknowns", "named"),
    [
        # Three units of a criterion do not decide: the simplest.
        ((0.0, 3.0), (0.0, 20.0), (3, 1), "second"),
        # A hundred do, and the other leaves more than forms of laws leave.
        ((0.0, 100.0), (0.0, 20.0), (3, 1), "first"),
        # It leaves no more than that.
        ((0.0, 100.0), (0.0, 9.0), (3, 1), "second"),
        # As simple: the likelier, or where they are tied the catalogue's order.
        ((9.0, 0.0), (9.0, 0.0), (1, 1), "second"),
        ((1.0, 0.0), (1.0, 0.0), (1, 1), "first"),
    ],
)
def test_the_simplest_of_those_that_explain_as_much_is_named(criteria, left_over, unknowns, named):
    names = ("first", "second")
    judge = ByGain(leaves(1000.0, 0), leaves(1000.0, 0), (), lambda name, fit: 0.0, lambda fit: 0.0)
    tried = {n: leaves(e, u) for n, e, u in zip(names, left_over, unknowns, strict=True)}
    found = judge.first_choice(dict(zip(names, criteria, strict=True)), tried, names)
    assert found == named


@pytest.mark.parametrize(("group", "named"), [("leak", "first"), ("", "second")])
def test_of_forms_of_the_same_physics_the_plainest_is_named(group, named):
    effects = [SimpleNamespace(id=name, group=group, parameters=()) for name in ("first", "second")]
    judge = ByGain(
        leaves(1000.0, 0), leaves(1000.0, 0), effects, lambda name, fit: 0.0, lambda fit: 0.0
    )
    tried = {"first": leaves(9.0, 2), "second": leaves(0.0, 2)}
    assert judge.first_choice({"first": 9.0, "second": 0.0}, tried, tuple(tried)) == named


@pytest.mark.parametrize(
    ("group", "apart", "named"),
    [("leak", 9.0, "first"), ("leak", 11.0, "second"), ("", 9.0, "second")],
)
def test_of_the_same_physics_a_less_plain_form_has_to_be_decisively_better(group, apart, named):
    effects = [SimpleNamespace(id=name, group=group, parameters=()) for name in ("first", "second")]
    judge = ByGain(
        leaves(1000.0, 0), leaves(1000.0, 0), effects, lambda name, fit: 0.0, lambda fit: 0.0
    )
    # More is left than forms of laws leave of each other.
    tried = {"first": leaves(20.0, 2), "second": leaves(0.0, 2)}
    assert judge.first_choice({"first": apart, "second": 0.0}, tried, tuple(tried)) == named


@pytest.mark.parametrize(
    ("accepted", "named"),
    [
        (["leak of a", "opening of b"], ["leak of a", "leak of b"]),
        (["opening of b"], ["opening of b"]),  # chosen with nothing else in sight
        (["opening of b", "spring"], ["leak of b", "spring"]),
    ],
)
def test_forms_are_chosen_again_beside_all_that_is_named(monkeypatch, accepted, named):
    ids = ("leak of a", "leak of b", "opening of b", "spring")
    effects = [SimpleNamespace(id=name, group=name[-4:], parameters=()) for name in ids]
    monkeypatch.setattr(Search, "candidates", list(ids))
    monkeypatch.setattr(Search, "chosen", leaves(0.0, 4))
    monkeypatch.setattr(Search, "_better_than", lambda self, member: None)
    monkeypatch.setattr(Search, "_drop_needless_last", lambda self: None)
    found = Search(SimpleNamespace(steady=True, effects=effects), [], accepted=list(accepted))
    tried = {name: SimpleNamespace(information_criterion=lambda worth: 0.0) for name in ids}
    rest = SimpleNamespace(information_criterion=lambda worth: 100.0)
    found._in_place_of = lambda member: (rest, tried)
    judge = SimpleNamespace(
        earns=lambda name, closer, drop: drop > 0.0,
        first_choice=lambda criteria, tried, earning: next(iter(earning)),
    )
    found._judge = lambda current: judge
    found._revise()
    assert found.accepted == named


@pytest.mark.parametrize(("apart", "named"), [(25.0, "first"), (80.0, "second")])
def test_a_large_effect_is_not_named_by_less_than_the_simulation_is_good_for(apart, named):
    rest = leaves(5.5e6, 22)
    judge = ByGain(rest, rest, (), lambda name, fit: 0.0, lambda fit: 0.0)
    tried = {"first": leaves(apart, 24), "second": leaves(0.0, 24)}
    assert judge.first_choice({"first": apart, "second": 0.0}, tried, tuple(tried)) == named


@pytest.mark.parametrize(("found_before", "earns"), [(0.0, True), (3000.0, True), (5000.0, False)])
def test_what_the_form_of_an_effect_leaves_makes_no_parameter_wrong(found_before, earns):
    current = leaves(1000.0, 24)
    baseline = leaves(1000.0 + found_before, 23)
    judge = ByGain(current, baseline, (), lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge.earns("param.piston.stroke", leaves(960.0, 24), 40.0) == earns


@pytest.mark.parametrize(
    ("parameter", "interval", "earns"),
    [
        ("temperature", (411.0, 520.0), False),
        ("temperature", (340.0, 380.0), True),
        ("chamber.polytropic_index", (0.6, 0.9), False),
        ("load.mass", (50.0, 60.0), True),
    ],
)
def test_a_parameter_is_not_wrong_by_what_it_cannot_be(parameter, interval, earns):
    current, closer = leaves(1000.0, 24), leaves(960.0, 24)
    current.hypothesis = SimpleNamespace(effects=set())
    closer.intervals = {parameter: interval}
    judge = ByGain(current, current, (), lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge.earns(f"param.{parameter}", closer, 40.0) == earns


@pytest.mark.parametrize(
    ("before", "after", "earns"), [(290, 270, True), (290, 225, False), (225, 224, True)]
)
def test_no_name_is_taken_for_whose_sake_the_air_is_colder_than_on_any_rig(before, after, earns):
    spring = effect_by_id("load.spring", "seal-tester")
    current, closer = leaves(1000.0, 24), leaves(900.0, 25)
    current.penalty, current.hypothesis = 0.0, SimpleNamespace(effects=set(), members=())
    current.shared = {"temperature": before}
    closer.shared = {spring.key("stiffness"): 20.0, "temperature": after}
    judge = ByGain(current, current, [spring], lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge.earns(spring.id, closer, 100.0) == earns


def test_where_no_motion_is_judged_a_parameter_has_to_explain_as_much_as_an_effect():
    current, closer = leaves(1000.0, 24), leaves(960.0, 24)
    current.hypothesis = SimpleNamespace(effects=set())
    judge = ByGain(current, current, (), lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge.earns("param.chamber.a.dead_volume", closer, 40.0)
    current.effective = {"pressure_a": SAMPLES}
    assert not judge.earns("param.chamber.a.dead_volume", closer, 40.0)
    assert judge.earns("param.chamber.a.dead_volume", leaves(940.0, 24), 60.0)


@pytest.mark.parametrize(("strained", "earns"), [(10.0, True), (70.0, False)])
def test_what_only_relieves_strained_parameters_is_no_effect(strained, earns):
    delay = effect_by_id("spool.delay", "single-axis")
    current, closer = leaves(1000.0 - strained, 24), leaves(900.0, 25)
    current.penalty, current.hypothesis = strained, SimpleNamespace(effects=set(), members=())
    closer.shared = {delay.key(p.name): p.starts[0] for p in delay.parameters}
    judge = ByGain(current, current, [delay], lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge.earns(delay.id, closer, 100.0) == earns


@pytest.mark.parametrize(
    ("effects", "spring", "mass"),
    [(set(), LEAST_GAIN, LEAST_DISTANCE), ({"leakage.chamber-a"}, 100.0, 100.0)],
    ids=["first", "beside a large one"],
)
def test_what_cannot_explain_enough_is_not_fitted(monkeypatch, effects, spring, mass):
    current, baseline = leaves(1000.0, 24), leaves(11_000.0, 24)
    current.hypothesis = SimpleNamespace(effects=effects)
    judge = ByGain(current, baseline, (), lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge.least("load.spring") == pytest.approx(spring)
    assert judge.least("param.load.mass") == pytest.approx(mass)
    # No candidate gains more than three times what it promised.
    promises = {"load.spring": spring / 2.9, "load.backlash": spring / 3.1}
    search, fitted = Search(SimpleNamespace(steady=True, effects=()), []), []
    search.fits[Hypothesis()] = current
    monkeypatch.setattr(search_module, "promises_count", lambda base: True)
    monkeypatch.setattr(Search, "_judge", lambda self, fit: judge)
    monkeypatch.setattr(Search, "_promised_elsewhere", lambda self, fit: {})
    monkeypatch.setattr(Search, "compatible", lambda self, accepted: list(promises))
    monkeypatch.setattr(Search, "_promises", lambda self, base, names: promises)
    monkeypatch.setattr(
        Search, "_best_fitted", lambda self, base, names, worth, barred: fitted.extend(worth)
    )
    assert search._best_addition() is None
    assert fitted == ["load.spring"]
    # Where few independent samples are left they promise nothing, whatever they hide.
    monkeypatch.setattr(search_module, "promises_count", lambda base: False)
    assert search._best_addition() is None
    assert fitted[1:] == list(promises)


@dataclass
class Absorbing:
    """Stands in for a fit of two parameters to a thousand residuals, one with a tolerance."""

    absorbed: np.ndarray
    samples: int = 1000

    def counted(self, changes):
        return changes


@pytest.fixture
def absorbing():
    return Absorbing(orthonormal(np.random.default_rng(2).standard_normal((1001, 2))))


def test_a_signature_explains_what_it_holds_beyond_a_refit(absorbing):
    rng = np.random.default_rng(3)
    variants, left = (
        [rng.standard_normal((1000, k)) for k in (3, 1)],
        rng.standard_normal((1001, 2)),
    )
    # A column that a refit absorbs but for a tolerance, and one that is another once more.
    variants[0][:, 2] = 1e3 * absorbing.absorbed[:-1, 0]
    variants[1] = np.column_stack([variants[1], 2.0 * variants[1]])
    left -= absorbing.absorbed @ (absorbing.absorbed.T @ left)
    most = 0.0
    for columns in variants:
        whole = np.vstack([columns, np.zeros(columns.shape[1])])
        rest = whole - absorbing.absorbed @ (absorbing.absorbed.T @ whole)
        fitted = rest @ np.linalg.lstsq(rest, left, rcond=1e-9)[0]
        most = max(most, *np.sum(fitted**2, axis=0))
    assert gained_beyond(absorbing, variants, list(left.T)) == pytest.approx(most, rel=1e-9)


def test_what_a_refit_absorbs_promises_nothing():
    direction = orthonormal(np.random.default_rng(4).standard_normal((1000, 1)))
    left = np.random.default_rng(5).standard_normal(1000)
    left -= direction[:, 0] * (direction[:, 0] @ left)
    assert gained_beyond(Absorbing(direction), [7.0 * direction], [left]) == 0.0


def test_less_than_none_of_an_effect_promises_nothing():
    rng = np.random.default_rng(1)
    signature, shape = rng.standard_normal((2, 1000))
    base = Absorbing(np.zeros((1000, 0)))

    def adds(columns, left):
        assert gained_beyond(base, [columns], [left]) > 0.0
        return gained_beyond(base, [columns], [left], one_sided=True) > 0.0

    assert adds(signature[:, np.newaxis], 0.5 * signature)
    assert not adds(signature[:, np.newaxis], -0.5 * signature)
    # Of two columns together the size is what counts.
    both = np.column_stack([signature, signature + 0.1 * shape])
    assert adds(both, signature - 2.0 * both[:, 1])
    assert not adds(both, -signature)


def gained(before, after, best=None):
    """Stand in for `explained` of fits that know what they gain."""
    return after.gain - getattr(before, "gain", 0.0)


def let_fits_know_their_gains(monkeypatch):
    monkeypatch.setattr(hypotheses, "explained", gained)
    monkeypatch.setattr(hypotheses, "gained_most", gained)
    monkeypatch.setattr(
        hypotheses, "misses_more", lambda before, after: getattr(after, "misses", False)
    )


@pytest.mark.parametrize(
    ("promise", "further", "reached", "gains"),
    [
        (200.0, 180.0, 390.0, 180.0),
        (200.0, 5.0, 0.0, 20.0),
        (30.0, 180.0, 0.0, 20.0),
        (35.0, 180.0, 0.0, 20.0),
        (math.inf, 180.0, 0.0, 20.0),
        (200.0, 180.0, 410.0, 20.0),
    ],
    ids=[
        "kept in the end",
        "no further",
        "promised too little",
        "kept half of it",
        "none made",
        "others reached far more",
    ],
)
def test_a_fit_that_breaks_its_promise_is_carried_to_its_end(
    monkeypatch, promise, further, reached, gains
):
    let_fits_know_their_gains(monkeypatch)
    monkeypatch.setattr(hypotheses, "fit", lambda *args, **how: SimpleNamespace(gain=20.0))
    monkeypatch.setattr(hypotheses, "polished", lambda *args: SimpleNamespace(gain=further))
    tried = Hypotheses(SimpleNamespace(steady=True), [])
    base = SimpleNamespace(gain=0.0)
    name = Hypothesis().adding("load.spring")
    assert tried._keeping(promise, base, name, reached).gain == gains
    assert tried.fits[name].gain == gains


@pytest.mark.parametrize("best", list(Begin), ids=lambda begin: begin.name)
def test_a_fit_begins_elsewhere_only_where_it_breaks_its_promise(monkeypatch, best):
    begun = []

    def stand_in(*args, begin=Begin.ANYWHERE):
        begun.append(begin)
        return SimpleNamespace(gain=150.0 if begin is best else 20.0, misses=begin is not best)

    let_fits_know_their_gains(monkeypatch)
    monkeypatch.setattr(hypotheses, "fit", stand_in)
    monkeypatch.setattr(hypotheses, "polished", lambda model, cases, found: found)
    tried = Hypotheses(SimpleNamespace(steady=True), [])
    name = Hypothesis().adding("load.spring")
    assert tried._keeping(200.0, SimpleNamespace(gain=0.0), name, 0.0).gain == 150.0
    assert begun == list(Begin)[: list(Begin).index(best) + 1]


@pytest.mark.parametrize(
    ("gain", "misses", "begun"),
    [
        (150.0, False, [Begin.ANYWHERE]),
        (20.0, False, [Begin.ANYWHERE, Begin.ALONE, Begin.NOMINAL]),
        (150.0, True, list(Begin)),
    ],
    ids=["kept", "broken", "kept, and one channel missed for the sake of another"],
)
def test_what_is_missed_counts_in_noise_where_one_channel_is_missed_for_another(
    monkeypatch, gain, misses, begun
):
    asked = []

    def stand_in(*args, begin=Begin.ANYWHERE):
        asked.append(begin)
        return SimpleNamespace(gain=gain, misses=misses)

    let_fits_know_their_gains(monkeypatch)
    monkeypatch.setattr(hypotheses, "fit", stand_in)
    monkeypatch.setattr(hypotheses, "polished", lambda model, cases, found: found)
    tried = Hypotheses(SimpleNamespace(steady=True), [])
    base = SimpleNamespace(gain=0.0)
    tried._keeping(200.0, base, Hypothesis().adding("load.spring"), 0.0)
    assert asked == begun


@pytest.mark.parametrize("barred", [False, True])
def test_what_is_barred_shields_nothing(monkeypatch, barred):
    gains = {"param.temperature": 200.0, "param.load.mass": 1.0, "load.spring": 60.0}
    let_fits_know_their_gains(monkeypatch)
    tried = Hypotheses(SimpleNamespace(steady=False), [])
    monkeypatch.setattr(
        tried,
        "_fitted_with",
        lambda base, promises, reached=0.0, again=False: {
            name: SimpleNamespace(gain=gains[name]) for name in promises
        },
    )
    promises = dict(zip(gains, (210.0, 100.0, 60.0), strict=True))
    found = tried._best_fitted(
        SimpleNamespace(gain=0.0),
        list(gains),
        promises,
        lambda name, closer: barred and name == "param.temperature",
    )
    assert ("load.spring" in found) is barred


@pytest.mark.parametrize(
    ("reached", "whole", "tried"),
    [
        # As promised: only what may still catch up.
        (100.0, 1000.0, {"best", "near"}),
        # Far more than was promised, of which little was to be explained linearly: its rivals too.
        (1000.0, 1000.0, {"best", "near", "rival"}),
        # ... but not where what was promised was nearly everything.
        (1000.0, 110.0, {"best"}),
    ],
)
def test_rivals_of_what_gained_more_than_it_promised_are_tried(reached, whole, tried):
    base = SimpleNamespace(in_noise=SimpleNamespace(unabsorbed=np.sqrt([whole])))
    promises = {"best": 100.0, "near": 45.0, "rival": 34.0 if reached > 100.0 else 30.0, "far": 5.0}
    assert set(within_reach(base, promises, reached, "best")) == tried


def moved(**tolerances):
    """Return what a fit knows of parameters so many tolerances from nominal."""
    return {
        "tolerated": tuple(tolerances),
        "distance": np.array(list(tolerances.values())),
        "shared": tolerances,
    }


@pytest.mark.parametrize("away", [14.0, -14.0, 3.0])
def test_a_parameter_far_out_is_fitted_whatever_others_reach(monkeypatch, away):
    gains = {"friction.presliding": 795.0, "load.spring": 300.0, "param.friction": 217.0}
    base = SimpleNamespace(gain=0.0, hypothesis=Hypothesis(), **moved(friction=away))
    let_fits_know_their_gains(monkeypatch)
    monkeypatch.setattr(hypotheses, "is_strained", lambda fit: False)
    tried = Hypotheses(SimpleNamespace(steady=True, effects=()), [])
    tried.fits[Hypothesis()] = base
    for member, gain in gains.items():
        tried.fits[Hypothesis().adding(member)] = SimpleNamespace(gain=gain)
    found = tried._best_fitted(base, list(gains), gains, lambda name, closer: False)
    assert ("param.friction" in found) is (abs(away) > 5.0)


@pytest.mark.parametrize("strained", [True, False])
def test_a_parameter_let_go_does_not_hide_what_strained_it(monkeypatch, strained):
    base = SimpleNamespace(gain=0.0, strained=strained, hypothesis=Hypothesis(), **moved())
    name = "spool.amplitude-bandwidth"
    fits = {"param.load.mass": 40.0, name: 20.0}
    let_fits_know_their_gains(monkeypatch)
    monkeypatch.setattr(hypotheses, "is_strained", lambda fit: fit.strained)
    monkeypatch.setattr(hypotheses, "within_reach", lambda base, promises, reached, by: promises)
    monkeypatch.setattr(hypotheses, "promises_from_nominal", lambda *given: {name: 4000.0})
    begun = SimpleNamespace(gain=900.0, strained=False)
    monkeypatch.setattr(hypotheses, "fit", lambda *args, **how: begun)
    monkeypatch.setattr(hypotheses, "polished", lambda model, cases, found: found)
    tried = Hypotheses(SimpleNamespace(steady=True, effects=()), [])
    tried.fits[Hypothesis()] = base
    for member, gain in fits.items():
        # What was fitted beside strained parameters already is tried again.
        found = SimpleNamespace(gain=gain, strained=strained and member == name)
        tried.fits[Hypothesis().adding(member)] = found
    promises = {"param.load.mass": 40.0, name: 30.0}
    found = tried._best_fitted(base, list(fits), promises, lambda name, closer: False)
    assert found[name].gain == (900.0 if strained else 20.0)


@pytest.mark.parametrize("guess", [True, False])
@pytest.mark.parametrize("settled", [True, False])
def test_what_relieves_parameters_and_leaves_more_than_noise_is_held_against_others(
    monkeypatch, settled, guess
):
    # A slew brought back a spool that a weak motor had made seem slow, and left 1.2 of the noise.
    base = SimpleNamespace(gain=0.0, strained=True, hypothesis=Hypothesis(), **moved())
    slew, motor = "spool.slew", "spool.amplitude-bandwidth"
    let_fits_know_their_gains(monkeypatch)
    monkeypatch.setattr(hypotheses, "is_strained", lambda fit: fit.strained)
    monkeypatch.setattr(hypotheses, "leaves_noise", lambda cases, fit, noise: settled)
    monkeypatch.setattr(hypotheses, "within_reach", lambda base, promises, reached, by: promises)
    monkeypatch.setattr(hypotheses, "promises_from_nominal", lambda *given: {motor: 1300.0})
    begins = []

    def begun(*args, begin, **how):
        begins.append(begin)
        far = begin is Begin.IN_NOISE
        return SimpleNamespace(gain=1200.0 if far else 10.0, strained=False)

    monkeypatch.setattr(hypotheses, "fit", begun)
    monkeypatch.setattr(hypotheses, "polished", lambda model, cases, found: found)
    tried = Hypotheses(SimpleNamespace(steady=True, effects=()), [], may_guess=guess)
    tried.fits[Hypothesis()] = base
    for name, gain in {slew: 1000.0, motor: 0.0}.items():
        tried.fits[Hypothesis().adding(name)] = SimpleNamespace(gain=gain, strained=False)
    found = tried._best_fitted(base, [slew, motor], {slew: 1000.0}, lambda name, closer: False)
    assert not tried.guessed
    assert begins == ([] if settled else [Begin.ALONE, Begin.NOMINAL, Begin.IN_NOISE])
    assert (motor in found) is not settled
    assert settled or found[motor].gain == 1200.0


@pytest.mark.parametrize(
    ("effect", "sizes"),
    [("spool.lineariser", 6), ("sensor.position-nonlinearity", 3), ("spool.null-bias", 1)],
)
def test_a_law_with_many_sizes_has_to_earn_each_of_them(effect, sizes):
    fit = leaves(1000.0, 0)
    judge = ByGain(fit, fit, effects_of("single-axis"), lambda name, fit: 0.0, lambda fit: 0.0)
    assert judge.least(effect) == pytest.approx(sizes * LEAST_GAIN)


@pytest.mark.parametrize(
    ("more", "elsewhere", "noise", "earns"),
    [
        (300.0, 0.0, 1.0, False),
        (700.0, 165.0, 1.0, False),
        (300.0, 160.0, 1.0, True),
        (300.0, 160.0, 1.13, False),
        (140.0, 140.0, 1.0, False),
        (900.0, 0.0, 1.3, True),
    ],
    ids=[
        "where the first acts",
        "mostly there",
        "elsewhere",
        "not all of it",
        "too little",
        "more than forms leave",
    ],
)
def test_what_acts_elsewhere_has_a_place_beside_a_large_effect(
    monkeypatch, more, elsewhere, noise, earns
):
    spring = effect_by_id("load.spring", "seal-tester")
    baseline, current = leaves(18_000.0, 24), leaves(3000.0, 24)
    closer = leaves(3000.0 - more, 25)
    current.hypothesis = SimpleNamespace(effects={"first"}, members=("first",))
    closer.shared = {spring.key(p.name): p.starts[0] for p in spring.parameters}
    closer.rms_of = {"displacement": noise}.__getitem__
    judge = ByGain(current, baseline, [spring], lambda name, fit: 0.0, lambda fit: elsewhere)
    monkeypatch.setattr(ByGain, "share", lambda self, closer: more / 15_000.0)
    assert judge.earns(spring.id, closer, more) == earns


def test_a_form_that_acts_nowhere_else_is_no_plainer_rival():
    fit = SimpleNamespace(effective={"displacement": SAMPLES})
    judge = SimpleNamespace(first_choice=lambda criteria, tried, earning: next(iter(tried)))
    search = SimpleNamespace(
        accepted=["load.transverse-mode", "valve.overlap"],
        chosen=fit,
        forms_of=lambda member: ["load.base-motion", member],
        _in_place_of=lambda member: (fit, {member: fit}),
        _judge=lambda rest: judge,
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rivals, "weighed", lambda judge, rest, tried, effective: ({}, 0, tried))
        named = rivals.Rivals._plainest_form_of(search, "load.transverse-mode")
    assert named == "load.transverse-mode"
