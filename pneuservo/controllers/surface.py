"""What every sliding mode controller is set by: its surface, boundary layer and level."""

from dataclasses import dataclass
from typing import ClassVar

from analog_card.surface_weights import state_weights
from pneuservo.controllers.requirements import require


@dataclass(frozen=True)
class SlidingSurface:
    """The settings that all sliding mode controllers share.

    Parameters
    ----------
    settling_time : float, optional
        4/(damping wn) of the sliding surface [s].
    damping : float, optional
        Damping ratio of the sliding surface [-].
    boundary_layer : float, optional
        Half width of the boundary layer; 0 gives an ideal relay [m/s^2].
    level : float, optional
        Largest output [V].
    """

    kind: ClassVar[str]
    settling_time: float = 0.07
    damping: float = 1.0
    boundary_layer: float = 5.0
    level: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        for name in ("settling_time", "damping", "level"):
            require(self.kind, name, getattr(self, name), above=0.0)
        require(self.kind, "boundary_layer", self.boundary_layer, at_least=0.0)

    @property
    def weights(self) -> tuple[float, float, float]:
        """Return c1 [1/s^2], c2 [1/s] and c3 [-]."""
        return (*state_weights(self.settling_time, self.damping), 1.0)
