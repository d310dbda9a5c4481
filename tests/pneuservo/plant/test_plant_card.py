"""The behavioural card in closed loop with the plant."""

import math
from dataclasses import replace

import numpy as np
import pytest

from analog_card.behaviour import Imperfections
from analog_card.behaviour_elements import nominal_elements, offset_name
from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.controllers import AnalogueCard, card_of
from pneuservo.errors import InputError
from pneuservo.simulation import simulate
from pneuservo.simulation.metrics import limit_cycle

TIME = np.arange(0, 0.6, 1e-4)
DEMAND = np.where(TIME < 0.5e-4, 0.015, 0.024)
LATE = TIME >= 0.35
SCALE = 0.048  # V for each m/s2 of the surface


@pytest.fixture(scope="module")
def design():
    return load_design()


def run(card, time=TIME, demand=DEMAND, **options):
    return simulate(time=time, demand=demand, controller=card, **options)


def cycle(result):
    return limit_cycle(TIME[LATE], result["card_surface"][LATE])


def quiet(*left_out):
    return Imperfections().without("offset_voltage", *left_out)


def test_the_card_without_imperfections_is_the_card_by_its_figures(design):
    ideal = card_of(design, Imperfections.none())
    assert ideal == AnalogueCard(card_figures(design))
    assert card_of(design, Imperfections.none(), relay=True).figures.output_gain == math.inf
    for channel in ("displacement", "card_surface", "valve_voltage"):
        np.testing.assert_array_equal(
            run(ideal)[channel], run(AnalogueCard(card_figures(design)))[channel]
        )


def test_the_compiled_behaviour_tends_to_the_card_by_its_figures(design):
    # Only the common mode is left, and taken to nothing: the stepping itself is compared.
    amplifier = replace(design.soldered.operational_amplifier, common_mode_rejection=1e12)
    perfect = replace(design, soldered=replace(design.soldered, operational_amplifier=amplifier))
    stepped = run(card_of(perfect, Imperfections.only("common_mode")))
    figures = run(card_of(design, Imperfections.none()))
    # The mean voltage of each 20 us step instead of its course: measured 0.05 um, with 10 V/ms.
    np.testing.assert_allclose(stepped["displacement"], figures["displacement"], atol=5e-7)
    np.testing.assert_allclose(stepped["card_velocity"], figures["card_velocity"], atol=2e-3)


def test_results_do_not_depend_on_the_step(design):
    coarse, fine = (
        run(card_of(design), largest_step=step)["displacement"] for step in (20e-6, 4e-6)
    )
    # Far below what separates netlist and behaviour.
    np.testing.assert_allclose(coarse, fine, atol=2e-7)


def test_relay_cycles_more_slowly_for_its_delay(design):
    ideal, real = (
        cycle(run(card_of(design, with_, relay=True))) for with_ in (Imperfections.none(), quiet())
    )
    # An independent study of a like plant: 3.6 % with the recommended card, sigma 6 % larger.
    assert 1 - real.frequency / ideal.frequency == pytest.approx(0.036, abs=0.01)
    assert (real.high - real.low) / (ideal.high - ideal.low) == pytest.approx(1.06, abs=0.03)


def test_relay_delay_comes_from_the_gain_bandwidth_alone(design):
    everything = cycle(run(card_of(design, quiet(), relay=True))).frequency
    alone = cycle(run(card_of(design, Imperfections.only("gain_bandwidth"), relay=True))).frequency
    without = cycle(run(card_of(design, quiet("gain_bandwidth"), relay=True))).frequency
    assert alone == pytest.approx(everything, rel=2e-3)
    assert without > everything * 1.03


def test_offsets_leave_the_error_that_they_amount_to(design):
    off = {name: 0.0 for name in nominal_elements(design) if name.endswith("voffset")}
    error = {}
    for offset in (0.0, 5e-3):
        card = card_of(design, elements={**off, offset_name("surface"): offset})
        error[offset] = run(card).step_responses()[0].steady_state_error
    figures = card_figures(design)
    # The surface amplifier's noise gain over the weight of the displacement.
    expected = 4.86 * 5e-3 / (figures.weight_displacement * figures.transducer_gain)
    assert abs(error[0.0]) < 2e-6  # the common mode: 0.8 um
    assert abs(error[5e-3]) == pytest.approx(expected, rel=0.01)


def test_relay_offset_and_unequal_levels_shift_the_cycle(design):
    zener = nominal_elements(design)["xlimiter.dupper[bv]"]
    lower = run(card_of(design, quiet(), {"xlimiter.dupper[bv]": 0.9 * zener}, relay=True))
    even = run(card_of(design, quiet(), relay=True))
    assert lower["card_output"][LATE].max() < 0.93 * even["card_output"][LATE].max()
    assert lower["card_output"][LATE].min() == pytest.approx(even["card_output"][LATE].min())


def test_uneven_times_are_refused(design):
    with pytest.raises(InputError, match="equally spaced"):
        run(card_of(design), np.array([0.0, 1e-3, 3e-3]), np.full(3, 0.015))


def test_a_card_at_rest_stays_at_rest(design):
    result = run(card_of(design, quiet("common_mode")), TIME[:500], np.full(500, 0.015))
    # Held by friction until the voltage of the valve has moved the pressures far enough.
    np.testing.assert_allclose(result["displacement"], 0.015, atol=1e-6)
