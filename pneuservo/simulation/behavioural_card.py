"""Running the plant under the behavioural card."""

import math
from dataclasses import dataclass

import numpy as np

from analog_card.behaviour import CardBehaviour, Stages, card_stages
from analog_card.behaviour_model import LARGEST_STEP as CARD_STEP
from analog_card.behaviour_model import kernel_numbers, state_at_rest
from analog_card.differentiator_kernel import CardNumbers
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.plant import behavioural_card
from pneuservo.plant import single_axis as places
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.single_axis import SingleAxis

# How far a time may be from equally spaced ones, as a share of the interval: stored times are
# rounded. Within it a channel is off by no more than its rate times this share of the interval.
JITTER = 0.01


@dataclass(frozen=True)
class SteppedCard:
    """A card ready to run beside a plant, both in fixed steps.

    Parameters
    ----------
    time : (n,) array
        Equally spaced [s].
    stages : Stages
        The card.
    numbers : CardNumbers
        The same for the kernels, for steps of this length.
    steps, substeps : int
        Steps of the plant from one time to the next, and of the card in each.
    sensitivity : float
        Displacement transducer [V/m].
    """

    time: Array
    stages: Stages
    numbers: CardNumbers
    steps: int
    substeps: int
    sensitivity: float

    def at_rest(self, displacement: float, demand: float) -> Array:
        """Return the state of the card that has stood still at a displacement and demand [m]."""
        return state_at_rest(
            self.stages, self.numbers, self.sensitivity * displacement, self.sensitivity * demand
        )


def stepped_card(
    time: Array, behaviour: CardBehaviour, sensitivity: float, largest_step: float
) -> SteppedCard:
    """Return a card in steps that fit the times of a run.

    Parameters
    ----------
    time : (n,) array
        Equally spaced, but for `JITTER` [s].
    behaviour : CardBehaviour
        The card.
    sensitivity : float
        Displacement transducer [V/m].
    largest_step : float
        The plant never takes a longer step [s]; the card's are shorter.

    Raises
    ------
    InputError
        When the times are not equally spaced.
    """
    time = equally_spaced(time)
    interval = time[1] - time[0]
    steps = max(math.ceil(interval / largest_step - 1e-9), 1)
    substeps = max(math.ceil(interval / steps / CARD_STEP - 1e-9), 1)
    stages = card_stages(behaviour)
    numbers = kernel_numbers(stages, interval / steps / substeps)
    return SteppedCard(time, stages, numbers, steps, substeps, sensitivity)


def run_behaviour(
    inputs: Array,
    state: Array,
    card: SteppedCard,
    plant: SingleAxis,
    grid: Array,
) -> Array:
    """Return the outputs of plant and card at every time.

    Parameters
    ----------
    inputs : (n, 2) array
        Demand [m] and external force [N].
    state : (6,) array
        Of the plant at the first time; the card has been at rest there.
    card : SteppedCard
        The card.
    plant : SingleAxis
        The numbers of the rig.
    grid : (4, 51, 101) array
        Discharge coefficients.

    Returns
    -------
    (n, 10) array
        One column per name of `pneuservo.plant.outputs.OUTPUTS`, in SI.
    """
    return np.asarray(
        behavioural_card.run_with_card(
            card.time,
            inputs,
            state,
            card.at_rest(state[places.DISPLACEMENT], inputs[0, places.COMMAND]),
            card.sensitivity,
            card.steps,
            card.substeps,
            card.numbers,
            OPEN_LOOP,
            plant,
            grid,
        )
    )


def equally_spaced(time: Array) -> Array:
    """Return equally spaced times in the place of times that are so but for their rounding.

    Parameters
    ----------
    time : (n,) array
        [s].

    Raises
    ------
    InputError
        When one is off by more than `JITTER`.
    """
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
