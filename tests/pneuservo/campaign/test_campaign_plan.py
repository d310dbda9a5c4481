"""Campaigns: what varies, and which sample has which values."""

import math

import numpy as np
import pytest

from analog_card.design_file import load_design
from analog_card.errors import InputError as QuantityError
from pneuservo.campaign.axes import Grid, Random, read_axis
from pneuservo.campaign.parameters import Varied, varied_design, varied_rig
from pneuservo.campaign.plan_file import campaign_of, read_settings
from pneuservo.campaign.summary import shown_axis
from pneuservo.errors import InputError
from pneuservo.rigs import load_rig

SUPPLY = Varied("supply.pressure", "Pa")
MASS = Varied("load.mass", "kg", 1.825, 0.05)
LOOP = {"controller": "sliding-mode", "demand": "15,24 mm"}


def axis(text, varied=SUPPLY):
    return read_axis(varied, text, "--vary")


def test_lists_and_ranges_are_read_with_their_units():
    assert axis("6.5, 7.1,7.7 bar").values == (6.5e5, 7.1e5, 7.7e5)
    assert axis(["650 kPa", 700e3]).values == (6.5e5, 7e5)
    assert axis(650000.0).values == (6.5e5,)
    swept = axis("6.5:7.7 bar:4")
    assert swept.shown == "bar"
    np.testing.assert_allclose(swept.values, [6.5e5, 6.9e5, 7.3e5, 7.7e5], rtol=1e-12)


def test_distributions_are_read_with_their_units():
    mass = axis("normal(1.825 kg, 3%)", MASS)
    assert (mass.distribution, mass.first) == ("normal", 1.825)
    assert mass.second == pytest.approx(0.03 * 1.825)
    assert axis("normal(1.8, 0.1 kg)", MASS).second == 0.1
    assert axis("uniform(6.5, 7.7 bar)").second == 7.7e5
    assert axis("tolerance", MASS) == Random("load.mass", "kg", "kg", "normal", 1.825, 0.05)
    part = Varied("soldered.x", "F", 1e-7, 5e-9, even=True, allowed="positive")
    spread = axis("tolerance", part)
    assert (spread.distribution, spread.first) == ("uniform", pytest.approx(95e-9))
    assert (spread.unit, spread.shown) == ("F", "nF")
    assert shown_axis(spread, 1.2e-7) == pytest.approx(120.0)
    track = axis("tolerance", Varied("soldered.y", "ohm", 1e4, 2e3, even=True))
    assert shown_axis(track, 1.2e4) == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("6.5 kg", "unit of a mass"),
        ("6.5:7.7 bar", "LOW:HIGH UNIT:COUNT"),
        ("6.5:7.7 bar:1", "from 2 to"),
        ("gauss(6.5 bar, 3 %)", "'gauss' is not known"),
        ("normal(6.5 bar)", "takes two numbers"),
        ("normal(6.5 bar, 0 %)", "deviation greater than 0"),
        ("uniform(7.7, 6.5 bar)", "lower value first"),
        ("uniform(-1e308, 1e308 Pa)", "finite number between"),
        ("-1e308:1e308 Pa:3", "wider than any number"),
        ("log_uniform(-1, 1 bar)", "greater than 0"),
        ("tolerance", "no tolerance is known"),
        ("", "no value is given"),
        ("many", "cannot be read"),
        ("__import__('os')", "is not known"),
    ],
)
def test_what_is_no_axis_is_refused(text, says):
    with pytest.raises((InputError, QuantityError), match=says):
        axis(text)


def test_draws_have_the_distribution_asked_for():
    generator = np.random.default_rng(1)
    count = 4000
    bell = axis("normal(1.8, 0.1 kg)", MASS)
    normal = [bell.draw(generator) for _ in range(count)]
    # Five standard errors: of a mean s/sqrt(n), of a deviation s/sqrt(2 n).
    assert np.mean(normal) == pytest.approx(1.8, abs=5 * 0.1 / math.sqrt(count))
    assert np.std(normal) == pytest.approx(0.1, abs=5 * 0.1 / math.sqrt(2 * count))
    wide = axis("log_uniform(1, 100 kg)", MASS)
    even = [wide.draw(generator) for _ in range(count)]
    assert 1.0 <= min(even) < max(even) <= 100.0
    # The logarithm is even: half below 10, with a standard error of half over the root of n.
    assert np.mean(np.array(even) < 10.0) == pytest.approx(0.5, abs=2.5 / math.sqrt(count))


def test_a_sample_follows_from_seed_and_index_only():
    vary = {"supply.pressure": "6.5,7.7 bar", "load.mass": "normal(1.825 kg, 3 %)"}
    few = campaign_of({**LOOP, "vary": vary, "trials": 2})
    many = campaign_of({**LOOP, "vary": vary, "trials": 50})
    other = campaign_of({**LOOP, "vary": vary, "trials": 50, "seed": 1})
    assert [few.values(k) for k in range(4)] == [many.values(k) for k in range(4)]
    masses = [many.values(k)["load.mass"] for k in reversed(range(100))][::-1]
    assert len(set(masses)) == 100
    assert not set(masses) & {other.values(k)["load.mass"] for k in range(100)}
    supplies = [many.values(k)["supply.pressure"] for k in range(4)]
    assert supplies == [6.5e5, 7.7e5, 6.5e5, 7.7e5]
    sequence = np.random.SeedSequence(0, spawn_key=(7,))
    assert masses[7] == np.random.default_rng(sequence).normal(1.825, 0.03 * 1.825)


def test_a_grid_is_gone_through_completely():
    campaign = campaign_of(
        {**LOOP, "vary": {"supply.pressure": "6.5:7.7 bar:3", "load.mass": "1, 2, 3, 4 kg"}}
    )
    found = {tuple(campaign.values(k).values()) for k in range(len(campaign))}
    assert len(campaign) == len(found) == 12


def test_values_reach_rig_effects_and_design():
    rig = load_rig("single-axis")
    values = {"load.mass": 7.0, "spool.null-bias:bias": 0.02, "controller.level": 3.0}
    changed = varied_rig(rig, values)
    assert changed["load.mass"] == 7.0
    assert changed.effects == {"spool.null-bias": {"bias": 0.02}}
    assert (rig["load.mass"], rig.effects) == (1.825, {})
    design = load_design()
    name = "soldered.velocity_differentiator.capacitance"
    other = varied_design(design, {name: 1.1e-7, "load.mass": 7.0})
    assert other.netlist_parameters()["velocity_capacitance"] == pytest.approx(1.1e-7)
    assert design == load_design()


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"vary": {"load.mas": "1 kg"}}, "Did you mean 'load.mass'"),
        ({"vary": {}}, "nothing varies"),
        ({"vary": {"load.mass": "1,2 kg"}, "trials": 5}, "nothing is drawn"),
        ({"vary": {"load.mass": "tolerance"}, "trials": 0}, "at least one"),
        ({"vary": {"load.mass": "1 kg"}, "seed": -1}, "seed is -1"),
        ({"vary": {"load.mass": True}}, "neither a text nor a list"),
        ({"vary": {"load.mass": "1 kg"}, "metrics": ["speed"]}, "'speed' is not known"),
        ({"vary": {"load.mass": "1 kg"}, "metrics": [1]}, "metrics: 1 is no text.*settling_time"),
        ({"vary": {"load.mass": "1 kg"}, "metrics": [[1]]}, r"metrics: \[1\] is no text"),
        ({"vary": {"load.mass": "1 kg"}, "metrics": [{"a": 1}]}, "is no text"),
        ({"vary": {"load.mass": "1 kg"}, "hold": "-1 s", "rate": "-1 kHz"}, "hold is -1 s"),
        ({"vary": {"load.mass": "1 kg"}, "rate": "-1 kHz"}, "rate is -1000 Hz"),
        ({"vary": {"load.mass": "1 kg"}, "demand": "15,40 mm"}, "outside the stroke"),
        ({"vary": {"controller.gain": "1"}}, "'controller.gain' is not known"),
        ({"vary": {"turned.level": "0.5"}}, "'turned.level' is not known"),
        ({"vary": {"load.mass": "1 kg"}, "card": "circuit"}, "not an option of the controller"),
        ({"vary": {"load.mass": "1 kg"}, "rig": "circuit"}, "single-axis is needed"),
        (
            {"vary": {"load.mass": "tolerance", "supply.pressure": "6:7 bar:2000"}, "trials": 999},
            "more than 1000000 samples",
        ),
        (
            {"vary": {"turned.level": "1.5"}, "controller": "analogue-card"},
            "a fraction of travel",
        ),
        (
            {"vary": {"load.mass": "1 kg"}, "controller": "analogue-card", "card": "behaviour",
             "without": ["gravity"]},
            "'gravity' is not known",
        ),
    ],
)  # fmt: skip
def test_what_is_no_campaign_is_refused(settings, says):
    with pytest.raises((InputError, QuantityError), match=says):
        campaign_of({**LOOP, **settings})


def test_a_file_says_what_options_say(tmp_path):
    path = tmp_path / "wide.toml"
    path.write_text(
        'controller = "sliding-mode"\ndemand = "15,24 mm"\nhold = "0.3 s"\ntrials = 7\n'
        'rig = "heavy.toml"\n[vary]\n"load.mass" = "tolerance"\nsupply.pressure = ["6.5 bar"]\n'
    )
    (tmp_path / "heavy.toml").write_text(
        '[rig]\nkind = "single-axis"\n'
        '[parameters]\n"load.mass" = { value = "7 kg", tolerance = "1 kg" }\n'
    )
    campaign = campaign_of(read_settings(path))
    assert campaign.axes[0] == Random("load.mass", "kg", "kg", "normal", 7.0, 1.0)
    assert campaign.axes[1] == Grid("supply.pressure", "Pa", "bar", (650000.0,))
    assert (len(campaign), len(campaign.time)) == (7, 600)


def test_a_name_with_more_parts_than_any_is_refused(tmp_path):
    path = tmp_path / "deep.toml"
    path.write_text(f"vary.{'a.' * 1500}b = 1\n")
    with pytest.raises(InputError, match="more parts than any name"):
        campaign_of({**LOOP, **read_settings(path)})


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("trial = 5", "Did you mean 'trials'"),
        ('trials = "5"', "int is needed"),
        ("vary = 3", "dict is needed"),
        ("[vary", "not valid TOML"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, says):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=says):
        read_settings(path)
    with pytest.raises(InputError, match="campaign file is needed"):
        read_settings(tmp_path / "none.toml")
