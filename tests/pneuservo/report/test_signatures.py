"""What the pictures of the catalogue show."""

import html

import numpy as np
import pytest

from pneuservo.effects import effect_by_id, effects_of
from pneuservo.errors import InputError
from pneuservo.recordings import CHANNELS
from pneuservo.report.signature_pictures import catalogue_page, picture_name, signature_figure
from pneuservo.report.signature_runs import runs_of
from pneuservo.report.signatures import RESOLUTION, signature_of

KINDS = ("circuit", "seal-tester", "dead-volume", "analogue-card", "single-axis")
# A fit of these starts below a step of a 12-bit conversion: 5 Pa/s over 30 s, a thousandth of the
# friction over 10 s, 10 mV/s of some hundred V/s, and parts of a friction of a few newtons.
FAINT = {
    "sensor.pressure-drift",
    "friction.run-in",
    "circuit.dry-damping",
    "friction.position",
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_effect_changes_something(kind):
    runs = runs_of(kind)
    for effect in effects_of(kind, tables=True):
        signature = signature_of(effect, kind, runs)
        assert all(np.isfinite(signature.change(channel)).all() for channel in signature.without)
        # Without the effect both runs are the same to the last digit, so that a hundredth of the
        # resolution is no rounding.
        least = 0.01 if effect.id in FAINT else 1.0
        assert signature.resolved > least, (effect.id, signature.resolved)


@pytest.mark.parametrize("kind", KINDS)
def test_a_neutral_effect_changes_nothing(kind):
    effect = effects_of(kind)[0]
    run = runs_of(kind)[0]
    neutral = {p.name: p.neutral for p in effect.parameters}
    first, again = run(effect, neutral), run(effects_of(kind)[-1], {})
    for channel, samples in first.items():
        assert np.array_equal(samples, again[channel]), channel


@pytest.mark.parametrize("kind", KINDS)
def test_the_page_lists_every_effect(kind):
    page = html.unescape(catalogue_page(kind, effects_of(kind)))
    for effect in effects_of(kind):
        for shown in (effect.id, effect.statement, effect.equation, effect.block):
            assert shown in page
        assert page.count(f'src="{picture_name(effect)}"') == 1


def test_a_constant_error_of_a_transducer_is_shown_as_it_is():
    signature = signature_of(effect_by_id("sensor.pressure-offset-a"), "single-axis")
    (size,) = signature.values.values()
    # 1e-9 of 6.5 bar: rounding of the sum.
    assert signature.change("pressure_a") == pytest.approx(size, abs=1e-3)
    assert not signature.change("displacement").any()


def test_an_end_stop_is_shown_where_the_piston_reaches_it():
    signature = signature_of(effect_by_id("endstop.cushion"), "single-axis")
    stroke = 0.03
    near = np.abs(signature.without["displacement"] - 0.5 * stroke) > 0.4 * stroke
    change = np.abs(signature.change("displacement"))
    assert change[near].max() > change[~near].max()


def test_the_picture_shows_the_run_and_the_change_of_each_quantity():
    signature = signature_of(effect_by_id("load.gravity-angle"), "single-axis")
    axes = signature_figure(signature).axes
    units = [ax.get_ylabel().rpartition("[")[2].rstrip("]") for ax in axes]
    assert units == ["mm", "µm", "kPa", "N"]
    run, moved, pressures, _ = axes
    assert [line.get_label() for line in run.lines] == ["without", "with the effect"]
    drawn = moved.lines[0].get_ydata()
    assert np.max(np.abs(drawn)) == pytest.approx(
        1e6 * np.max(np.abs(signature.change("displacement"))), rel=1e-12
    )
    assert len(pressures.lines) == 2


def test_a_rig_without_effects_has_no_pictures():
    with pytest.raises(InputError, match="single-axis"):
        runs_of("figure-arm")


def test_every_judged_channel_has_a_resolution():
    for kind in KINDS:
        signature = signature_of(effects_of(kind)[0], kind)
        assert {CHANNELS[channel].unit for channel in signature.without} <= set(RESOLUTION)
