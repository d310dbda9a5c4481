"""Sliding mode on a computer that reads velocity and acceleration off a card's differentiators."""

from dataclasses import dataclass, field
from typing import ClassVar

from analog_card.design_file import load_design
from analog_card.figures import CardFigures, card_figures
from pneuservo.controllers.digital import SampledSlidingMode
from pneuservo.controllers.requirements import require, sensitivity
from pneuservo.controllers.sampled import Reading, Voltage
from pneuservo.rigs import Rig


def _recommended() -> CardFigures:
    return card_figures(load_design())


@dataclass(frozen=True)
class HybridSlidingMode(SampledSlidingMode):
    """Sliding mode on a computer with the card's differentiators.

    Parameters
    ----------
    differentiators : CardFigures, optional
        The card, of which only the differentiators are used; by default the recommended one.
    transducer_noise : float, optional
        Of the displacement transducer, root mean square up to 25 kHz [V].

    Notes
    -----
    Set-up of figure 9.9 of the thesis. Noise passes through the differentiators before it is
    sampled, so that all of it folds into what the computer sees. How large it was is not stated.
    """

    kind: ClassVar[str] = "hybrid-sliding-mode"
    inputs: ClassVar[tuple[str, ...]] = ("displacement", "card_velocity", "card_acceleration")  # type: ignore[misc]
    differentiators: CardFigures = field(default_factory=_recommended)
    transducer_noise: float = 1e-5

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        super().__post_init__()
        require(self.kind, "transducer_noise", self.transducer_noise, at_least=0.0)

    def start(self, rig: Rig) -> Voltage:
        """Return what gives the voltage for each reading."""
        per_velocity = -sensitivity(rig) * self.differentiators.rc_velocity
        per_acceleration = -per_velocity * self.differentiators.rc_acceleration

        def voltage(reading: Reading) -> float:
            return self.switched(
                self.switching_function(
                    (
                        reading.displacement - reading.demand,
                        reading.card_velocity / per_velocity,
                        reading.card_acceleration / per_acceleration,
                    )
                )
            )

        return voltage
