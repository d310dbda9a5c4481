"""The behavioural card ready to run: numbers for the kernels, frequency response, runs."""

import math
from dataclasses import dataclass

import numpy as np

from analog_card import behaviour_kernel as kernel
from analog_card import differentiator_kernel as places
from analog_card.behaviour import CardBehaviour, Stages, card_stages
from analog_card.behaviour_limiter import HIGHEST, STEP
from analog_card.differentiator import circuit_equations
from analog_card.differentiator_kernel import CardNumbers
from analog_card.errors import InputError

# The card's own step: small against the filters (56 us) and the delay of the relay (60 us).
LARGEST_STEP = 5e-6


@dataclass(frozen=True)
class CardRun:
    """Voltages of a card over time.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s].
    voltages : dict of str to ndarray
        By the names of the nodes inside a channel: ``displacement``, ``first``, ``second``,
        ``deviation``, ``rate``, ``surface``, ``comparator``, ``clamped``, ``control`` [V].
    """

    time: np.ndarray
    voltages: dict[str, np.ndarray]

    def __getitem__(self, node: str) -> np.ndarray:
        """Return the voltage of a node [V]."""
        return self.voltages[node]


def kernel_numbers(stages: Stages, step: float) -> CardNumbers:
    """Return a card as its kernels take it.

    Parameters
    ----------
    stages : Stages
        The card.
    step : float
        Length of the steps it is advanced by [s].

    Returns
    -------
    CardNumbers
        With the exact solutions for this step and its divisions.
    """
    generator, taps = _extended(stages)
    durations = step / kernel.DIVISION ** np.arange(kernel.LEVELS)
    lags = stages.lags
    with np.errstate(divide="ignore"):
        decay = np.exp(-durations[:, None] / lags)
    return CardNumbers(
        duration=durations,
        solution=_solutions(generator, durations),
        demanded=np.ascontiguousarray(generator[[places.AMPLIFIER_1, places.AMPLIFIER_2]]),
        taps=taps,
        decay=decay,
        share=lags / durations[:, None],
        buffer_gain=float(stages.buffer_gains[0]),
        demand_gain=float(stages.buffer_gains[1]),
        buffer_lag=float(lags[0]),
        buffer_offset=float(stages.buffer_offsets[0]),
        demand_offset=float(stages.buffer_offsets[1]),
        difference=stages.difference,
        inverter=stages.inverter,
        surface=stages.surface,
        comparator_gain=float(stages.comparator_gain),
        comparator_offset=float(stages.comparator_offset),
        swings=stages.swings,
        rate_swing=stages.rate_swing,
        surface_swing=stages.surface_swing,
        comparator_swing=stages.comparator_swing,
        slew_rates=stages.slew_rates,
        clamped=stages.limiter.clamped,
        clamped_to=HIGHEST,
        clamped_step=STEP,
        fraction=float(stages.limiter.fraction),
        control_offset=float(stages.control_offset),
    )


def state_at_rest(
    stages: Stages, card: CardNumbers, transducer: float, demand: float
) -> np.ndarray:
    """Return the state of a card that has stood still, as its kernels take it.

    Parameters
    ----------
    stages : Stages
        The card.
    card : CardNumbers
        The same for the kernels.
    transducer, demand : float
        Voltages at its inputs [V].

    Returns
    -------
    ndarray, shape (16,)
        Places as named in `analog_card.behaviour_kernel`.
    """
    generator, _ = _extended(stages)
    state = np.zeros(kernel.STATES)
    state[: places.FRONT] = np.linalg.solve(
        generator[: places.FRONT, : places.FRONT],
        -generator[: places.FRONT, places.ONE],
    )
    kernel.rest(transducer, demand, card, state)
    return state


def rest_voltages(stages: Stages, transducer: float, demand: float) -> dict[str, float]:
    """Return the voltages of a card at rest, as long as none is limited.

    Parameters
    ----------
    stages : Stages
        The card.
    transducer, demand : float
        Voltages at its inputs [V].

    Returns
    -------
    dict of str to float
        By node: ``first``, ``second``, ``deviation``, ``rate``, ``surface``, ``comparator`` [V].
    """
    generator, taps = _extended(stages)
    front = slice(places.FRONT)
    at_rest = np.linalg.solve(generator[front, front], -generator[front, places.ONE])
    first, second = taps[:, front] @ at_rest + taps[:, places.ONE]
    inputs = stages.buffer_gains * np.array([transducer, demand]) + stages.buffer_offsets
    deviation = stages.difference[:2] @ inputs + stages.difference[2]
    rate = stages.inverter[0] * first + stages.inverter[1]
    surface = stages.surface[:3] @ [deviation, rate, second] + stages.surface[3]
    return {
        "first": float(first),
        "second": float(second),
        "deviation": float(deviation),
        "rate": float(rate),
        "surface": float(surface),
        "comparator": float(stages.comparator_gain * (surface + stages.comparator_offset)),
    }


def run_behaviour(
    behaviour: CardBehaviour, time: np.ndarray, transducer: np.ndarray, demand: np.ndarray
) -> CardRun:
    """Simulate a card on its own, from rest at the first values of its inputs.

    Parameters
    ----------
    behaviour : CardBehaviour
        The card.
    time : ndarray, shape (n,)
        Equally spaced times [s].
    transducer, demand : ndarray, shape (n,)
        Voltages at its inputs; the transducer is taken to be smooth between the times, the demand
        to hold [V].

    Returns
    -------
    CardRun
        Voltages of all nodes.

    Raises
    ------
    InputError
        When the times are not equally spaced.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> time = np.arange(0.0, 2e-3, 5e-6)
    >>> ramp = run_behaviour(CardBehaviour(load_design()), time, 5 + time, np.full(400, 5.0))
    >>> round(float(ramp["first"][-1] - ramp["first"][0]), 6)  # -R C times 1 V/s
    -0.012
    """
    steps = np.diff(time)
    if len(time) < 2 or steps[0] <= 0 or not np.allclose(steps, steps[0], rtol=1e-6):
        raise InputError("times: at least two, equally spaced and increasing are needed")
    step = float(time[-1] - time[0]) / (len(time) - 1)
    substeps = max(math.ceil(step / LARGEST_STEP - 1e-9), 1)
    stages = card_stages(behaviour)
    card = kernel_numbers(stages, step / substeps)
    inputs = [np.ascontiguousarray(values, float) for values in (transducer, demand)]
    state = state_at_rest(stages, card, inputs[0][0], inputs[1][0])
    table = kernel.run_card(*inputs, step, substeps, card, state)
    return CardRun(time, dict(zip(kernel.OUTPUTS, table.T, strict=True)))


def stage_responses(behaviour: CardBehaviour, frequency: np.ndarray) -> dict[str, np.ndarray]:
    """Return the complex gain of every stage.

    Parameters
    ----------
    behaviour : CardBehaviour
        The card.
    frequency : ndarray, shape (n,)
        Frequencies [Hz].

    Returns
    -------
    dict of str to ndarray
        By stage: ``buffer``, ``first`` and ``second`` differentiator, ``difference from
        displacement`` and ``from demand``, ``inverter``, ``surface from deviation``, ``from rate``
        and ``from acceleration``, ``boundary layer``, ``limiter`` (small signals), ``control``.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> gains = stage_responses(CardBehaviour(load_design()), np.array([200.0]))
    >>> round(float(abs(gains["first"][0])), 2)
    15.01
    """
    stages = card_stages(behaviour)
    s = 2j * math.pi * np.asarray(frequency, float)
    lag = 1 / (1 + s[:, None] * stages.lags)
    generator, taps = _extended(stages)
    front = slice(places.FRONT)
    resolvent = s[:, None, None] * np.eye(places.FRONT) - generator[front, front]
    column = generator[front, places.DISPLACEMENT : places.DISPLACEMENT + 1].astype(complex)
    reached = np.linalg.solve(resolvent, column[None])[..., 0]
    tap = reached @ taps[:, front].T + taps[:, places.DISPLACEMENT]
    return {
        "buffer": stages.buffer_gains[0] * lag[:, 0],
        "first": tap[:, 0],
        "second": tap[:, 1] / tap[:, 0],
        "difference from displacement": stages.difference[0] * lag[:, 1],
        "difference from demand": stages.difference[1] * lag[:, 1],
        "inverter": stages.inverter[0] * lag[:, 2],
        "surface from deviation": stages.surface[0] * lag[:, 3],
        "surface from rate": stages.surface[1] * lag[:, 3],
        "surface from acceleration": stages.surface[2] * lag[:, 3],
        "boundary layer": stages.comparator_gain * lag[:, 4],
        "limiter": np.full(len(s), stages.limiter.division, complex),
        "control": stages.limiter.fraction * lag[:, 5],
    }


def _extended(stages: Stages) -> tuple[np.ndarray, np.ndarray]:
    """Return rates of the extended front state while all is linear, and the taps."""
    rates, outputs = circuit_equations(
        stages.velocity, stages.acceleration, stages.differentiator_amplifiers, stages.loads
    )
    constant = np.concatenate([[0.0], stages.differentiator_offsets])
    generator = np.zeros((places.EXTENDED, places.EXTENDED))
    taps = np.zeros((2, places.EXTENDED))
    for table, rows in ((generator, rates), (taps, outputs)):
        table[: len(rows), : places.FRONT] = rows[:, : places.FRONT]
        table[: len(rows), places.DISPLACEMENT] = rows[:, places.FRONT]
        table[: len(rows), places.ONE] = rows[:, places.FRONT :] @ constant
    for place, parts, current in (
        (places.FEEDBACK_1, stages.velocity, stages.bias_currents[0]),
        (places.FEEDBACK_2, stages.acceleration, stages.bias_currents[1]),
    ):
        generator[place, places.ONE] -= current / parts.feedback_capacitance
    generator[places.DISPLACEMENT, places.VELOCITY] = 1.0
    generator[places.VELOCITY, places.ACCELERATION] = 1.0
    return generator, taps


def _solutions(generator: np.ndarray, durations: np.ndarray) -> np.ndarray:
    """Return the differentiators after each duration, with either op-amp linear or driven."""
    from scipy.linalg import expm

    solutions = np.empty((4, len(durations), places.FRONT, places.EXTENDED))
    for driven in range(4):
        rates = generator.copy()
        for bit, place, rate in (
            (1, places.AMPLIFIER_1, places.RATE_1),
            (2, places.AMPLIFIER_2, places.RATE_2),
        ):
            if driven & bit:
                rates[place] = 0.0
                rates[place, rate] = 1.0
        # The longer steps are the finest, taken as often as they hold it.
        step = expm(rates * durations[-1])
        for level in reversed(range(len(durations))):
            solutions[driven, level] = step[: places.FRONT]
            step = np.linalg.matrix_power(step, kernel.DIVISION)
    return solutions
