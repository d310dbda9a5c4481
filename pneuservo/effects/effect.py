"""What one entry of the catalogue holds."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class EffectParameter:
    """One free number of an effect.

    Parameters
    ----------
    name : str
        Name within the effect.
    unit : str
        SI unit; ``""`` for a pure number.
    neutral : float
        The value at which the effect vanishes, or, for a shape that has no say once the
        effect's size is neutral, any value of it [unit].
    low, high : float
        Plausible range; a fit stays inside it [unit].
    starts : tuple of float
        Where a fit starts; several where the fit may have several minima [unit].
    meaning : str
        What it is.
    field : str, optional
        Where the servo's kernels keep it, ``block.field`` of
        `pneuservo.plant.servo.servo_effects.ServoEffects`; ``""`` on other rigs.
    least : float, optional
        Smallest size that is known of real parts; a smaller one is not worth the name [unit].
    most : float, optional
        Largest one, where a larger is as good as none [unit].
    inverse : bool, optional
        Whether a larger one changes less, and none at all stands for none.
    """

    name: str
    unit: str
    neutral: float
    low: float
    high: float
    starts: tuple[float, ...]
    meaning: str
    field: str = ""
    least: float = 0.0
    most: float = math.inf
    inverse: bool = False


@dataclass(frozen=True)
class Effect:
    """Physics that a baseline may leave out.

    Parameters
    ----------
    id : str
        Stable name, ``group.effect``.
    block : str
        The block whose equation it changes.
    rigs : tuple of str
        Kinds of rig that have this block.
    statement : str
        One plain sentence: what it is and what the baseline does instead.
    equation : str
        Its law in SI, with the parameters' names.
    parameters : tuple of EffectParameter
        Its free numbers; the first is its size.
    source : str
        Who described it.
    experiment : str
        What to measure to tell it from its rivals.
    group : str, optional
        Effects of one group are forms of the same physics: at most one of them is present.
    """

    id: str
    block: str
    rigs: tuple[str, ...]
    statement: str
    equation: str
    parameters: tuple[EffectParameter, ...]
    source: str
    experiment: str
    group: str = ""

    def key(self, name: str) -> str:
        """Return the name under which a parameter of this effect travels."""
        return f"{self.id}:{name}"

    @property
    def neutral(self) -> dict[str, float]:
        """Return the values at which the effect vanishes."""
        return {self.key(p.name): p.neutral for p in self.parameters}
