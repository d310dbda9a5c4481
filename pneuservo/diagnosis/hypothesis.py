"""What a fit is allowed to change."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Hypothesis:
    """What a fit is allowed to change.

    Parameters
    ----------
    effects : frozenset of str
        Effects of the catalogue that are switched on.
    loosened : frozenset of str
        Rig parameters that may leave their tolerance.
    """

    effects: frozenset[str] = frozenset()
    loosened: frozenset[str] = frozenset()

    def adding(self, candidate: str) -> "Hypothesis":
        """Return this hypothesis and one more; ``param.X`` loosens the rig parameter X."""
        if candidate.startswith("param."):
            return Hypothesis(self.effects, self.loosened | {candidate.removeprefix("param.")})
        return Hypothesis(self.effects | {candidate}, self.loosened)

    def is_part_of(self, other: "Hypothesis") -> bool:
        """Return whether another hypothesis has all of this one."""
        return self.effects <= other.effects and self.loosened <= other.loosened

    @property
    def members(self) -> tuple[str, ...]:
        """Return what this hypothesis adds to the baseline, in a fixed order."""
        return (*sorted(self.effects), *sorted(f"param.{key}" for key in self.loosened))
