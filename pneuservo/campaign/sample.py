"""One sample of a campaign: the loop with its values, simulated and measured."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from analog_card.behaviour import Imperfections
from analog_card.errors import AnalogCardError
from pneuservo.campaign.metrics import metrics_of
from pneuservo.campaign.parameters import CONTROLLER, ELEMENT, varied_design, varied_rig
from pneuservo.campaign.plan import Campaign
from pneuservo.controllers import AnalogueCard, card_of
from pneuservo.errors import PneuservoError
from pneuservo.loop_controller import CIRCUIT, LoopController, loop_controller
from pneuservo.simulation import Simulation, simulate


def run_samples(campaign: Campaign, indices: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yield what samples of a campaign gave.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    indices : sequence of int
        Which samples.

    Yields
    ------
    dict
        ``values`` and ``metrics`` by name in SI, and ``error``, what kept the sample from being
        simulated, or None. One impossible sample must not end a long campaign.
    """
    for index in indices:
        values = campaign.values(index)
        metrics: dict[str, float | None] = dict.fromkeys(campaign.metrics)
        error = None
        try:
            metrics = metrics_of(simulate_sample(campaign, values, index), campaign.metrics)
        except (PneuservoError, AnalogCardError) as problem:
            error = str(problem)
        yield {"values": values, "metrics": metrics, "error": error}


def simulate_sample(campaign: Campaign, values: Mapping[str, float], index: int = 0) -> Simulation:
    """Return the run of a campaign's loop with some values.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    values : mapping of str to float
        By name of the parameter, in SI.
    index : int, optional
        Of the sample; with the seed of the campaign it seeds noise.

    Raises
    ------
    InputError
        When the values make no rig, controller or card.
    SimulationError
        When ngspice failed.

    Notes
    -----
    A card is tuned with the parts of its design; only then its parts get their values, as on a
    bench whose card is tuned once.
    """
    rig = varied_rig(campaign.rig, values)
    shaped = {
        name.removeprefix(CONTROLLER): value
        for name, value in values.items()
        if name.startswith(CONTROLLER)
    }
    loop = loop_controller(campaign.controller, {**campaign.options, **shaped})
    time, demand, seed = campaign.time, campaign.demand, (campaign.seed, index)
    if loop.design is None:
        return simulate(rig, time=time, demand=demand, controller=loop.controller, seed=seed)
    design = varied_design(loop.design, values)
    elements = {
        name.removeprefix(ELEMENT): value
        for name, value in values.items()
        if name.startswith(ELEMENT)
    }
    if loop.card == CIRCUIT:
        from pneuservo.circuit_loop import simulate_circuit_loop

        return simulate_circuit_loop(
            design, rig, time=time, demand=demand, relay=loop.relay, elements=elements
        )
    card = card_of(design, _imperfections(loop), elements, loop.relay)
    return simulate(rig, time=time, demand=demand, controller=card, seed=seed)


def _imperfections(loop: LoopController) -> Imperfections:
    controller = loop.controller
    if isinstance(controller, AnalogueCard) and controller.behaviour is not None:
        return controller.behaviour.imperfections
    return Imperfections.none()
