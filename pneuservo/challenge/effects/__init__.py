"""Every effect a case may conceal, in the truth's own forms."""

from pneuservo.challenge.effects.concealed import (
    NONE,
    OUTSIDE,
    PARAMETER,
    PHYSICS,
    SENSOR,
    ConcealedEffect,
    Form,
)
from pneuservo.challenge.effects.registry import CONCEALED, concealed

__all__ = [
    "CONCEALED", "NONE", "OUTSIDE", "PARAMETER", "PHYSICS", "SENSOR",
    "ConcealedEffect", "Form", "concealed",
]  # fmt: skip
