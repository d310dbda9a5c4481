"""The behavioural card closes the loop round a rig with effects."""

import dataclasses

import numpy as np
import pytest

from analog_card.behaviour import Imperfections
from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.controllers import AnalogueCard, card_of
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

RIG = load_rig("single-axis")
DESIGN = load_design()
TIME = np.arange(0.0, 0.3, 1e-4)
LOOP = {"time": TIME, "demand": np.where(TIME < 0.5e-4, 0.015, 0.024)}
# Something of every half of the servo: hoses, friction, spool, transducer with its own state.
EFFECTS = {
    "line.delay": {"time": 1e-3},
    "friction.presliding": {"travel": 20e-6},
    "valve.overlap": {"lap": 0.01},
    "sensor.position-lag": {"time": 1e-3},
    "supply.sag": {"volume": 1e-3, "area": 5e-6},
}


def perfect_card():
    """A card with nothing but a common mode that is taken to nothing: the stepping itself."""
    amplifier = dataclasses.replace(
        DESIGN.soldered.operational_amplifier, common_mode_rejection=1e12
    )
    soldered = dataclasses.replace(DESIGN.soldered, operational_amplifier=amplifier)
    perfect = dataclasses.replace(DESIGN, soldered=soldered)
    return card_of(perfect, Imperfections.only("common_mode"))


@pytest.mark.parametrize("relay", [False, True], ids=["boundary layer", "relay"])
def test_neutral_effects_are_none(relay):
    neutral = {"supply_pressure": RIG["supply.pressure"]}
    card = card_of(DESIGN, relay=relay)
    plain = simulate(RIG, controller=card, **LOOP)
    found = simulate(RIG, controller=card, **LOOP, **neutral)
    for channel in ("displacement", "pressure_a", "card_surface", "valve_voltage"):
        one, other = plain[channel], found[channel]
        # The same steps of the same methods: rounding, 1e-10, which a relay's cycle lets grow.
        assert np.abs(one - other).max() < 1e-6 * np.ptp(one), channel


def test_with_effects_it_tends_to_the_card_by_its_figures():
    rig = dataclasses.replace(RIG, effects=EFFECTS)
    stepped = simulate(rig, controller=perfect_card(), **LOOP)
    figures = simulate(rig, controller=AnalogueCard(card_figures(DESIGN)), **LOOP)
    plain = simulate(controller=perfect_card(), **LOOP)
    # As without effects: the mean voltage of each 20 us step instead of its course.
    assert np.abs(stepped["displacement"] - figures["displacement"]).max() < 1e-6
    # Far below what the effects do.
    assert np.abs(stepped["displacement"] - plain["displacement"]).max() > 1e-4


def test_results_do_not_depend_on_the_step():
    rig = dataclasses.replace(RIG, effects=EFFECTS)
    coarse, fine = (
        simulate(rig, controller=card_of(DESIGN), largest_step=step, **LOOP)["displacement"]
        for step in (20e-6, 5e-6)
    )
    assert np.abs(coarse - fine).max() < 1e-6


def test_the_card_settles_on_what_the_transducer_reads():
    rig = dataclasses.replace(RIG, effects={"sensor.position-offset": {"offset": 5e-4}})
    card = card_of(DESIGN, Imperfections().without("offset_voltage"))
    start = InitialState(0.0145)
    run = simulate(rig, time=TIME[:1000], controller=card, demand=0.015, initial=start)
    # At rest on the demand as it is read, and held there; the card knows no other displacement.
    assert run["displacement"] == pytest.approx(0.015, abs=2e-6)
    assert run["card_sensor"][0] == pytest.approx(0.015 * 10.0 / 0.03)
