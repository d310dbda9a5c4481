"""The analogue card as a controller."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from analog_card.behaviour import CardBehaviour, Imperfections
from analog_card.design import Design
from analog_card.figures import CardFigures, card_figures
from pneuservo.controllers.requirements import require, sensitivity
from pneuservo.plant.control_law import CARD_TAPS, ControlLaw
from pneuservo.rigs import Rig


@dataclass(frozen=True)
class AnalogueCard:
    """The behavioural analogue card on the rig's displacement transducer.

    Parameters
    ----------
    figures : CardFigures
        Gains, filters and limits, from `analog_card.figures.card_figures` or stated outright. The
        transducer is the rig's; an infinite output gain makes the card a relay.
    behaviour : CardBehaviour, optional
        The card with its op-amps, offsets, limits and tolerances, simulated instead of the
        figures; see `card_of`.

    Notes
    -----
    By its figures each differentiator is -s RC/((1 + s/w1)(1 + s/w2)), equation (9.3) of the
    thesis. Op-amp dynamics and offsets are left out; they lower the limit cycle of a relay card by
    2 to 5 %, and are in its behaviour.

    Examples
    --------
    >>> from analog_card.tuning import tune
    >>> card = AnalogueCard(tune(settling_time=0.07, boundary_layer=5.0).figures)
    >>> round(card.figures.output_gain * card.figures.surface_scale, 3)
    1.0
    """

    kind: ClassVar[str] = "analogue-card"
    figures: CardFigures
    behaviour: CardBehaviour | None = None

    def __post_init__(self) -> None:
        """Refuse figures that make no card."""
        figures = self.figures
        breaks = (*figures.velocity_breaks, *figures.acceleration_breaks)
        require(self.kind, "rc_velocity", figures.rc_velocity, above=0.0)
        require(self.kind, "rc_acceleration", figures.rc_acceleration, above=0.0)
        for frequency in breaks:
            require(self.kind, "break frequency", frequency, above=0.0)
        require(self.kind, "surface_limit", figures.surface_limit, at_least=0.0)
        require(self.kind, "level", figures.level, at_least=0.0)
        if figures.output_gain != math.inf:
            require(self.kind, "output_gain", figures.output_gain, at_least=0.0)

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        figures = self.figures
        velocity_lags, acceleration_lags = (
            [1.0 / (2.0 * math.pi * frequency) for frequency in breaks]
            for breaks in (figures.velocity_breaks, figures.acceleration_breaks)
        )
        return ControlLaw(
            source=CARD_TAPS,
            weight_displacement=float(figures.weight_displacement),
            weight_velocity=float(figures.weight_velocity),
            weight_acceleration=float(figures.weight_acceleration),
            surface_limit=float(figures.surface_limit),
            gain=float(figures.output_gain),
            level=float(figures.level),
            sensitivity=sensitivity(rig),
            velocity_time_constant=float(figures.rc_velocity),
            velocity_lag_1=velocity_lags[0],
            velocity_lag_2=velocity_lags[1],
            acceleration_time_constant=float(figures.rc_acceleration),
            acceleration_lag_1=acceleration_lags[0],
            acceleration_lag_2=acceleration_lags[1],
        )


def card_of(
    design: Design,
    imperfections: Imperfections | None = None,
    elements: Mapping[str, float] | None = None,
    relay: bool = False,
) -> AnalogueCard:
    """Return a card as a controller, with what is chosen of its imperfections.

    Parameters
    ----------
    design : Design
        The card.
    imperfections : Imperfections, optional
        What of the real card it has; without it all. With none it is the card by its figures.
    elements : mapping of str to float, optional
        Values of elements that differ from the design's, by their names in
        `analog_card.behaviour_elements.nominal_elements`.
    relay : bool, optional
        Whether the feedback of the boundary-layer amplifier is opened.

    Returns
    -------
    AnalogueCard
        The controller.

    Examples
    --------
    >>> from analog_card.behaviour import Imperfections
    >>> from analog_card.design_file import load_design
    >>> card_of(load_design(), Imperfections.none()) == AnalogueCard(card_figures(load_design()))
    True
    """
    figures = card_figures(design)
    if relay:
        figures = replace(figures, output_gain=math.inf)
    with_ = imperfections or Imperfections()
    if not with_.any and not elements:
        return AnalogueCard(figures)
    return AnalogueCard(figures, CardBehaviour(design, elements or {}, with_, relay))
