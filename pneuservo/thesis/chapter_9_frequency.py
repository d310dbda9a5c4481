"""Figures 9.23 to 9.26 of the thesis: frequency responses and stick-slip."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from analog_card.linear_servo import LinearServo
from analog_card.surface_weights import state_weights
from pneuservo.arrays import Array
from pneuservo.controllers import Controller, Proportional, StateFeedback
from pneuservo.linear import advanced_servo, table_5_2
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import Simulation, simulate
from pneuservo.thesis.chapter_9_loops import SETTLING_TIME, analogue
from pneuservo.thesis.rows import Row, number_row
from pneuservo.thesis.statements import Finding, statement_row

# The thesis states neither amplitude nor gains: a fifteenth of the stroke about its middle [m], the
# state feedback of table 5.5, and a proportional gain between its well-behaved 1 and its
# oscillating 3.4 [V/V].
AMPLITUDE, CENTRE = 2e-3, 0.015
PROPORTIONAL_GAIN = 2.0
FREQUENCIES = (0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0)
_PERIODS, _LEAST_LEAD, _RATE = 4, 0.5, 4000.0
# Stick-slip: friction at rest above that in motion, of seals that have stood still [N], how fast it
# fades [m/s], and the demand [m], [Hz].
_STICTION = {"friction.stribeck": {"excess": 10.0, "speed": 5e-3}}
STICK_AMPLITUDE, STICK_FREQUENCY = 3e-3, 1.0
# At rest, far below the slowest motion that is asked for [m/s].
_STILL = 1e-5
_E22 = (
    "the open loop resonates at 21 Hz with the data of the thesis, wherever the piston is: 12 Hz "
    "would take some 5.5 kg. Amplitude, load and gains of the experiment are not stated"
)


def frequency_rows() -> list[Row]:
    """Return what section 9.3.7 of the thesis states, beside ours."""
    return [*_stick_slip(), *_peaks(), *_followed(), *_phases()]


def controllers() -> dict[str, Controller]:
    """Return the controllers of figure 9.25 by name."""
    return {
        "analogue card": analogue(),
        "state feedback": StateFeedback(),
        "proportional": Proportional(gain=PROPORTIONAL_GAIN),
    }


@cache
def frequency_response(controller: Controller, rig: Rig | None = None) -> Array:
    """Return displacement over demand at `FREQUENCIES`, by the first harmonic.

    Parameters
    ----------
    controller : Controller
        What closes the loop round the non-linear plant.
    rig : Rig, optional
        By default the single axis.
    """
    return np.array([_harmonic(controller, frequency, rig) for frequency in FREQUENCIES])


def surface_response(frequency: Array) -> Array:
    """Return the response of the sliding motion itself, the ideal one.

    Parameters
    ----------
    frequency : (n,) array
        [Hz].
    """
    c1, c2 = state_weights(SETTLING_TIME, 1.0)
    s = 2j * math.pi * np.asarray(frequency)
    return c1 / (s * s + c2 * s + c1)


def open_loop() -> LinearServo:
    """Return the servo of figure 9.26 at mid-stroke."""
    return advanced_servo(table_5_2(), CENTRE, extending=True)


def decibel(response: Array) -> Array:
    """Return magnitudes [dB]."""
    return 20.0 * np.log10(np.abs(response))


def degrees(response: Array) -> Array:
    """Return phases that do not jump, over increasing frequency [degrees]."""
    return np.degrees(np.unwrap(np.angle(response)))


@cache
def stick_slip_run(controller: Controller) -> Simulation:
    """Return two seconds of a controller at 1 Hz with friction that sticks."""
    rig = replace(load_rig("single-axis"), effects=_STICTION)
    time = np.arange(0.0, 2.0, 1.0 / _RATE)
    wave = np.sin(2.0 * math.pi * STICK_FREQUENCY * time)
    return simulate(rig, time=time, demand=CENTRE + STICK_AMPLITUDE * wave, controller=controller)


def share_at_rest(run: Simulation) -> float:
    """Return the share of the second period in which the piston rests [-]."""
    settled = run.time >= 1.0 / STICK_FREQUENCY
    return float(np.mean(np.abs(run["velocity"][settled]) < _STILL))


def _harmonic(controller: Controller, frequency: float, rig: Rig | None) -> complex:
    lead = max(_LEAST_LEAD, 2.0 / frequency)
    time = np.arange(0.0, lead + _PERIODS / frequency, 1.0 / _RATE)
    demand = CENTRE + AMPLITUDE * np.sin(2.0 * math.pi * frequency * time)
    run = simulate(rig or "single-axis", time=time, demand=demand, controller=controller)
    counted = time >= lead - 1e-9
    wave = np.exp(-2j * math.pi * frequency * time[counted])
    moved = run["displacement"][counted] - CENTRE
    return complex((moved @ wave) / ((demand[counted] - CENTRE) @ wave))


def _stick_slip() -> Iterator[Row]:
    shares = {
        name: share_at_rest(stick_slip_run(controller))
        for name, controller in controllers().items()
    }
    card, feedback = shares["analogue card"], shares["state feedback"]
    words = (
        f"{100 * feedback:.0f} % of the time at rest under state feedback, {100 * card:.0f} % "
        "under the card; a stiction 10 N above the Coulomb friction"
    )
    yield statement_row(
        "9.23-stick-slip",
        "state feedback at 1 Hz",
        "stick-slip clearly visible",
        Finding(feedback > 0.25, words),
        "Figure 9.23",
    )
    yield statement_row(
        "9.24-stick-slip",
        "analogue card at 1 Hz",
        "no stick-slip",
        Finding(card < 0.1 and card < 0.25 * feedback, words),
        "Figure 9.24",
    )


def _peaks() -> Iterator[Row]:
    peak, height = _peak(decibel(frequency_response(controllers()["proportional"])))
    yield number_row(
        "9.25-peak-proportional",
        f"peak of the amplitude above 5 Hz, proportional feedback, {PROPORTIONAL_GAIN:g} V/V",
        "Hz",
        12.0,
        peak,
        None,
        "Figure 9.25",
        _E22,
        in_kind=True,
    )
    magnitude = decibel(frequency_response(controllers()["state feedback"]))
    found, own = _peak(magnitude)
    yield number_row(
        "9.25-peak-state-feedback",
        "peak of the amplitude above 5 Hz, state feedback of table 5.5",
        "Hz",
        12.0,
        found if own > 0.5 else float("nan"),
        None,
        "Figure 9.25",
        "no peak: these gains take the resonance away. " + _E22,
    )
    card = decibel(frequency_response(controllers()["analogue card"]))
    yield statement_row(
        "9.25-card-peak",
        "peak of the amplitude above 5 Hz, analogue card",
        "significantly smaller",
        Finding(
            _peak(card)[1] < 0.5 * height,
            f"{_peak(card)[1]:.1f} dB above its surroundings, proportional feedback "
            f"{height:.1f} dB",
        ),
        "Figure 9.25",
    )
    servo = open_loop()
    yield number_row(
        "9.26-resonance",
        "resonance of the open loop at mid-stroke",
        "Hz",
        12.0,
        math.sqrt(servo.a1) / (2.0 * math.pi),
        None,
        "Figure 9.26",
        "named as the origin of the peak at 12 Hz, without a figure of its own; " + _E22,
    )


def _peak(magnitude: Array) -> tuple[float, float]:
    """Return where a response is highest above 5 Hz [Hz], and by how much it rises to it [dB]."""
    above = np.flatnonzero(np.array(FREQUENCIES) > 5.0)
    best = int(above[np.argmax(magnitude[above])])
    rise = magnitude[best] - np.min(magnitude[above[0] : best + 1])
    return FREQUENCIES[best], float(rise)


def _followed() -> Iterator[Row]:
    ideal = decibel(surface_response(np.array(FREQUENCIES)))
    off = {
        name: float(np.max(np.abs(decibel(frequency_response(controller)) - ideal)))
        for name, controller in controllers().items()
    }
    yield statement_row(
        "9.25-card-follows",
        "amplitude against that of the sliding surface, up to 25 Hz",
        "the card follows it more closely than state feedback",
        Finding(
            off["analogue card"] < 0.5 * off["state feedback"],
            ", ".join(f"{name} {value:.1f} dB off" for name, value in off.items()),
        ),
        "Figure 9.25",
    )


def _phases() -> Iterator[Row]:
    frequency = np.array(FREQUENCIES)
    ideal = degrees(surface_response(frequency))
    card, feedback = (
        degrees(frequency_response(controllers()[name]))
        for name in ("analogue card", "state feedback")
    )
    lag = ideal - card
    yield statement_row(
        "9.25-phase",
        "phase lag of card and of state feedback",
        "larger than that of the sliding surface",
        Finding(
            bool(np.all(lag > 0.0) and np.all(ideal - feedback > 0.0)),
            f"card up to {np.max(lag):.0f} degrees, state feedback up to "
            f"{np.max(ideal - feedback):.0f} degrees larger",
        ),
        "Figure 9.25",
    )
    below = frequency < 8.5
    yield statement_row(
        "9.25-phase-below",
        "phase lag of the card below 8.5 Hz",
        "larger than that of state feedback",
        Finding(
            bool(np.all(card[below] < feedback[below])),
            f"card {-card[below][-1]:.0f} degrees, state feedback {-feedback[below][-1]:.0f} "
            f"degrees at {frequency[below][-1]:g} Hz",
        ),
        "Figure 9.25",
        reason="with the gains of table 5.5, settling in 0.4 s, state feedback is the slower one "
        "everywhere; which gains were run is not stated",
    )
    yield statement_row(
        "9.25-phase-above",
        "phase of the card above 8.5 Hz",
        "closer to that of the surface than state feedback",
        Finding(
            bool(np.all(lag[~below] < np.abs(ideal - feedback)[~below])),
            f"{np.max(lag[~below]):.0f} degrees off, state feedback "
            f"{np.max(np.abs(ideal - feedback)[~below]):.0f} degrees",
        ),
        "Figure 9.25",
    )
