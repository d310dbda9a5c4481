"""Controllers of a single axis: small dataclasses that `pneuservo.simulation.simulate` takes.

A continuous one becomes a compiled law beside the plant. A sampled one, `SampledController`, is
asked for a voltage at every sampling time; any subclass of it will do.
"""

from dataclasses import asdict, is_dataclass
from typing import Any

from pneuservo.controllers.analogue_card import AnalogueCard, card_of
from pneuservo.controllers.board import DT2812A, Board
from pneuservo.controllers.digital import DigitalSlidingMode, DigitalStateFeedback
from pneuservo.controllers.discrete import DiscreteSlidingMode
from pneuservo.controllers.hybrid import HybridSlidingMode
from pneuservo.controllers.sampled import Reading, SampledController, Voltage
from pneuservo.controllers.true_states import Proportional, SlidingMode, StateFeedback

ContinuousController = SlidingMode | Proportional | StateFeedback | AnalogueCard
Controller = ContinuousController | SampledController
CONTROLLERS: dict[str, type[Controller]] = {
    controller.kind: controller
    for controller in (
        SlidingMode,
        Proportional,
        StateFeedback,
        AnalogueCard,
        DigitalSlidingMode,
        DigitalStateFeedback,
        HybridSlidingMode,
        DiscreteSlidingMode,
    )
}

__all__ = [
    "CONTROLLERS",
    "DT2812A",
    "AnalogueCard",
    "Board",
    "ContinuousController",
    "Controller",
    "DigitalSlidingMode",
    "DigitalStateFeedback",
    "DiscreteSlidingMode",
    "HybridSlidingMode",
    "Proportional",
    "Reading",
    "SampledController",
    "SlidingMode",
    "StateFeedback",
    "Voltage",
    "card_of",
    "controller_settings",
]


def controller_settings(controller: Controller) -> dict[str, Any]:
    """Return the settings of a controller as plain values, for documents.

    Parameters
    ----------
    controller : Controller
        Any; of a sampled one that is no dataclass only the sampling time is known.

    Returns
    -------
    dict of str to anything
        By the names of its parameters; of a behavioural card's design only the title.

    Examples
    --------
    >>> controller_settings(Proportional(gain=2.0))
    {'gain': 2.0, 'level': 5.0}
    """
    if not is_dataclass(controller):
        return {"sampling_time": controller.sampling_time}
    settings = asdict(controller)
    if isinstance(controller, AnalogueCard) and controller.behaviour is not None:
        settings["behaviour"]["design"] = controller.behaviour.design.title
    return settings
