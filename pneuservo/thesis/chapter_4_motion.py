"""The rows of chapter 4 that are about the motion: sections 4.3.2 and 4.3.3 of the thesis."""

from dataclasses import replace
from functools import cache

import numpy as np

from pneuservo.identification import (
    Identification,
    identify_each,
    identify_evolution,
    identify_least_squares,
    identify_output_error,
    simulate_excitation,
)
from pneuservo.identification.excitation import CENTRES
from pneuservo.identification.least_squares import UNITS
from pneuservo.rigs import load_rig
from pneuservo.thesis.chapter_4_stated import stated
from pneuservo.thesis.chapter_4_steps import StepRun, step_run
from pneuservo.thesis.rows import REPRODUCED_WITHIN, Row, number_row
from pneuservo.thesis.statements import Finding, statement_row

_SEEDS = 20
# Long enough for 500 samples in motion, short enough for the open loop not to drift to a stop.
_DURATION, _AMPLITUDE = 4.0, 0.004
_NAMES = {
    "load.mass": "mass",
    "piston.viscous_friction": "viscous friction",
    "piston.coulomb_friction": "Coulomb friction",
}
# A piston that swings by less than this has come to rest; the transducer's noise is 0.09 mm [m].
_AT_REST = 0.05e-3
# Speed at which the excess of the breakaway force has fallen to 37 % [m/s].
_STEEP = 0.005


@cache
def synthetic() -> dict[str, tuple[Identification, ...]]:
    """Return 7 kg, 100 N s/m and 15 N identified from 500 noisy points, many times, by method."""
    values = stated()["synthetic"]
    nominal = load_rig("single-axis")
    rig = nominal.with_values(values["parameters"])
    recordings = [
        simulate_excitation(rig, duration=_DURATION, amplitude=_AMPLITUDE, seed=seed, held=True)
        for seed in range(_SEEDS)
    ]
    return {
        "least squares": tuple(
            identify_least_squares([recording], rig, most_points=values["points"])
            for recording in recordings
        ),
        "output error": tuple(
            identify_output_error([recording.slice(0.0, values["points"] / 500.0)], nominal)
            for recording in recordings
        ),
    }


@cache
def by_position_and_direction() -> dict[tuple[str, str], Identification]:
    """Return table 4.7's values identified at three positions, extending and retracting."""
    recordings = [simulate_excitation(centre=centre, seed=k) for k, centre in enumerate(CENTRES)]
    return identify_each(recordings)


@cache
def evolved() -> Identification:
    """Return table 4.7's values found again by differential evolution."""
    return identify_evolution(
        [simulate_excitation(duration=_DURATION, amplitude=_AMPLITUDE, seed=1, held=True)]
    )


@cache
def stiction() -> Identification:
    """Return friction with a breakaway force above the sliding one, identified from displacement.

    Simulated with table 4.7's stiction as the excess of a Stribeck curve so steep that it is gone
    within the dead band of least squares; the search starts from half of it.
    """
    true = stated()["stiction"]["force"] - stated()["evolution"]["piston.coulomb_friction"]
    nominal = load_rig("single-axis")
    rigs = [
        replace(nominal, effects={"friction.stribeck": {"excess": excess, "speed": _STEEP}})
        for excess in (true, 0.5 * true)
    ]
    # Slow, so that the piston comes to rest often.
    recording = simulate_excitation(
        rigs[0],
        duration=_DURATION,
        amplitude=_AMPLITUDE,
        frequencies=(0.5, 5.0),
        seed=1,
        held=True,
    )
    return identify_output_error([recording], rigs[1], [*UNITS, "friction.stribeck:excess"])


def motion_rows() -> list[Row]:
    """Return the rows about identification and step responses."""
    return [*_synthetic_rows(), *_least_squares_rows(), *_evolution_rows(), *_step_rows()]


def _synthetic_rows() -> list[Row]:
    rows = []
    for name, true in stated()["synthetic"]["parameters"].items():
        for method, found in synthetic().items():
            values = np.array([entry.parameters[name] for entry in found])
            rows.append(
                number_row(
                    f"4.15-{method.replace(' ', '-')}-{name.split('.')[-1].replace('_', '-')}",
                    f"{_NAMES[name]} from 500 points with 0.3 % noise, {method}",
                    UNITS[name],
                    true,
                    float(np.mean(values)),
                    None,
                    "section 4.3.2.1, Figure 4.15",
                    f"mean of {len(values)} seeds, standard deviation {np.std(values):.2g}; "
                    "viscous and Coulomb friction share their error",
                    in_kind=True,
                )
            )
    return rows


def _least_squares_rows() -> list[Row]:
    rows = []
    true = stated()["evolution"]
    for name, (low, high) in stated()["least_squares"].items():
        values = [entry.parameters[name] for entry in by_position_and_direction().values()]
        middle = float(np.mean(values))
        rows.append(
            statement_row(
                f"4.6-{name.split('.')[-1].replace('_', '-')}",
                f"{_NAMES[name]} by least squares, three positions, each direction by itself",
                f"{low:g} to {high:g} {UNITS[name]}",
                Finding(
                    low * (1.0 - REPRODUCED_WITHIN) <= middle <= high * (1.0 + REPRODUCED_WITHIN),
                    f"{min(values):.3g} to {max(values):.3g} {UNITS[name]}, mean {middle:.3f}, "
                    f"from data simulated with {true[name]:g}",
                ),
                "Table 4.6",
                "identified from data simulated with table 4.7, as the rig's are lost",
            )
        )
    return rows


def _evolution_rows() -> list[Row]:
    found = stiction().parameters
    breakaway = found["piston.coulomb_friction"] + found["friction.stribeck:excess"]
    rows = [
        number_row(
            f"4.7-{name.split('.')[-1].replace('_', '-')}",
            f"{_NAMES[name]} by evolutionary search, from data simulated with it",
            UNITS[name],
            value,
            evolved().parameters[name],
            None,
            "Table 4.7",
        )
        for name, value in stated()["evolution"].items()
    ]
    return [
        *rows,
        number_row(
            "4.7-stiction",
            "stiction by output error, from data simulated with it",
            "N",
            stated()["stiction"]["force"],
            breakaway,
            None,
            "Table 4.7",
            "the text of section 4.3.2.2 says 1 N, the table 1.234 N",
        ),
    ]


def _swings(run: StepRun) -> str:
    return ", ".join(f"{1e3 * swing:.2g}" for swing, _ in run.late()[1:])


def _step_rows() -> list[Row]:
    values = stated()["steps"]
    low, high = step_run(values["gain_low"]), step_run(values["gain_high"])
    uncalibrated = step_run(values["gain_high"], calibrated=False)
    damped = step_run(values["gain_high"], False, values["viscous_friction_high"])
    errors = [abs(error) for _, error in low.late()]
    at_mid = uncalibrated.late()[4][0]
    return [
        statement_row(
            "4.16-gain-1",
            "step responses with proportional gain 1: at rest at every set point",
            "settles with small oscillations; the error at the end is small",
            Finding(
                max(swing for swing, _ in low.late()) < _AT_REST and max(errors) < _AT_REST,
                f"at rest within 0.7 s, largest error {1e3 * max(errors):.3f} mm",
            ),
            "Figures 4.16, 4.17",
        ),
        statement_row(
            "4.18-gain-3.4",
            "step responses with proportional gain 3.4",
            "sustained oscillation in the mid position",
            Finding(
                high.late()[4][0] > _AT_REST,
                "with tables 4.2 to 4.5 it dies out: at most "
                f"{1e6 * max(swing for swing, _ in high.late()):.1f} µm peak to peak before the "
                "next step",
            ),
            "Figures 4.18, 4.19",
            "the position-dependent area gain of Figure 4.8 is lost: without it the tables' low "
            "coefficients at small openings damp the oscillation. With the nominal coefficient of "
            f"0.8 it lasts, {1e3 * at_mid:.1f} mm peak to peak at "
            f"{uncalibrated.frequency():.0f} Hz at mid-stroke",
            in_kind=at_mid > _AT_REST,
        ),
        statement_row(
            "4.19-friction-109",
            "viscous friction of 109 instead of 102.53 N s/m, gain 3.4",
            "more damped in both directions",
            Finding(
                damped.late()[3][0] < uncalibrated.late()[3][0]
                and damped.late()[1][0] < uncalibrated.late()[1][0],
                f"peak to peak {_swings(damped)} mm instead of {_swings(uncalibrated)} mm, with "
                "the nominal coefficient",
            ),
            "section 4.3.3",
        ),
    ]
