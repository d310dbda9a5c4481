"""Running the plant under the behavioural card."""

import math

import numpy as np
from numpy.typing import NDArray

from analog_card.behaviour import CardBehaviour, card_stages
from analog_card.behaviour_model import LARGEST_STEP as CARD_STEP
from analog_card.behaviour_model import kernel_numbers, state_at_rest
from pneuservo.errors import InputError
from pneuservo.plant import behavioural_card
from pneuservo.plant import single_axis as places
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.single_axis import SingleAxis

# How far a time may be from equally spaced ones, as a share of the interval: stored times are
# rounded. Within it a channel is off by no more than its rate times this share of the interval.
JITTER = 0.01


def run_behaviour(
    time: NDArray[np.float64],
    inputs: NDArray[np.float64],
    state: NDArray[np.float64],
    behaviour: CardBehaviour,
    sensitivity: float,
    plant: SingleAxis,
    grid: NDArray[np.float64],
    largest_step: float,
) -> NDArray[np.float64]:
    """Return the outputs of plant and card at every time.

    Parameters
    ----------
    time : (n,) array
        Equally spaced, but for `JITTER` [s].
    inputs : (n, 2) array
        Demand [m] and external force [N].
    state : (6,) array
        Of the plant at the first time; the card has been at rest there.
    behaviour : CardBehaviour
        The card.
    sensitivity : float
        Displacement transducer [V/m].
    plant : SingleAxis
        The numbers of the rig.
    grid : (4, 51, 101) array
        Discharge coefficients.
    largest_step : float
        The plant never takes a longer step [s]; the card's are shorter.

    Returns
    -------
    (n, 10) array
        One column per name of `pneuservo.plant.integrator.OUTPUTS`, in SI.

    Raises
    ------
    InputError
        When the times are not equally spaced.
    """
    time = _equally_spaced(time)
    interval = time[1] - time[0]
    steps = max(math.ceil(interval / largest_step - 1e-9), 1)
    substeps = max(math.ceil(interval / steps / CARD_STEP - 1e-9), 1)
    stages = card_stages(behaviour)
    card = kernel_numbers(stages, interval / steps / substeps)
    demand, transducer = inputs[0, places.COMMAND], state[places.DISPLACEMENT]
    card_state = state_at_rest(stages, card, sensitivity * transducer, sensitivity * demand)
    return np.asarray(
        behavioural_card.run_with_card(
            time,
            inputs,
            state,
            card_state,
            sensitivity,
            steps,
            substeps,
            card,
            OPEN_LOOP,
            plant,
            grid,
        )
    )


def _equally_spaced(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return equally spaced times in the place of times that are so but for their rounding."""
    even = np.linspace(time[0], time[-1], len(time))
    interval = float(time[-1] - time[0]) / (len(time) - 1)
    off = np.abs(time - even)
    worst = int(np.argmax(off))
    if off[worst] > JITTER * interval:
        raise InputError(
            f"the behaviour of the card needs equally spaced times: sample {worst} is at "
            f"{time[worst]:.6g} s, equally spaced it would be at {even[worst]:.6g} s (up to "
            f"{JITTER:.0%} of the interval of {interval:.3g} s is allowed). Give such times, or "
            "simulate the card by its figures or its circuit, which take any"
        )
    return even
