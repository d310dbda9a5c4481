"""The op-amps of a channel: what each does to its stage, with the imperfections chosen."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from analog_card.behaviour_elements import Elements, amplifier_figures, offset_name
from analog_card.behaviour_limiter import output_drop
from analog_card.design import AMPLIFIERS, Design, OperationalAmplifier
from analog_card.imperfections import Imperfections

# What an op-amp without the imperfection has: large enough to change nothing that can be measured,
# small enough for the arithmetic.
_UNLIMITED_BANDWIDTH, _UNLIMITED_GAIN = 1e11, 1e10
_NEGLIGIBLE_RESISTANCE = 1e-9


@dataclass(frozen=True)
class StageAmplifier:
    """One op-amp of a channel.

    Attributes
    ----------
    figures : OperationalAmplifier
        At their ideal values where an imperfection is left out.
    offset : float
        Its offset voltage [V].
    finite : bool
        Whether its gain-bandwidth product is.
    saturates : bool
        Whether its swing is that of the figures.
    """

    figures: OperationalAmplifier
    offset: float
    finite: bool
    saturates: bool

    @property
    def speed(self) -> float:
        """Return 2 pi times the gain-bandwidth product [1/s]."""
        return 2 * math.pi * self.figures.gain_bandwidth

    @property
    def inverting_current(self) -> float:
        """Return what flows into the inverting input [A]."""
        return self.figures.bias_current - self.figures.offset_current / 2

    @property
    def inner_swing(self) -> np.ndarray:
        """Return lowest and highest voltage ahead of the output resistance, shape (2,) [V].

        The data sheet's is into 2 kohm.
        """
        if not self.saturates:
            return np.array([-math.inf, math.inf])
        output = np.array([-self.figures.negative_swing, self.figures.positive_swing])
        return output + output_drop(output / 2e3, self.figures)

    def settled(self, noise_gain: float) -> float:
        """Return what the open-loop gain leaves of a stage with this noise gain."""
        return 1 / (1 + noise_gain / self.figures.open_loop_gain)

    def lag(self, noise_gain: float) -> float:
        """Return the time constant of a stage with this noise gain [s]."""
        return noise_gain * self.settled(noise_gain) / self.speed if self.finite else 0.0

    def offset_behind(self, resistance: float) -> float:
        """Return the offset with the drop at the non-inverting input [V]."""
        current = self.figures.bias_current + self.figures.offset_current / 2
        return self.offset - current * resistance

    def follower_offset(self, resistance: float) -> float:
        """Return the output of a follower behind this resistance at 0 V [V]."""
        return self.settled(1.0) * self.offset_behind(resistance)

    def division(self, load: float) -> float:
        """Return the voltage ahead of the output resistance for each volt on a load to ground."""
        return 1 + self.figures.output_resistance / load

    def limits(self, loaded: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return lowest and highest output, shape (2,) [V].

        Parameters
        ----------
        loaded : callable
            What the load leaves of the inner swing. Without saturation the output stops at the
            smaller figure on both sides.
        """
        if self.saturates:
            return loaded(self.inner_swing)
        smaller = min(self.figures.positive_swing, self.figures.negative_swing)
        return np.array([-smaller, smaller])


def channel_amplifiers(
    elements: Elements, design: Design, with_: Imperfections
) -> dict[str, StageAmplifier]:
    """Return the op-amps of a channel by the names of `analog_card.design.AMPLIFIERS`.

    Parameters
    ----------
    elements : mapping of str to float
        From `analog_card.behaviour_elements.nominal_elements`.
    design : Design
        The card.
    with_ : Imperfections
        What of the real op-amps they have.
    """
    nominal = design.soldered.operational_amplifier
    return {
        name: StageAmplifier(
            figures=_idealised(amplifier_figures(name, elements, nominal), with_),
            offset=elements[offset_name(name)] if with_.offset_voltage else 0.0,
            finite=with_.gain_bandwidth,
            saturates=with_.saturation,
        )
        for name in AMPLIFIERS
    }


def _idealised(amplifier: OperationalAmplifier, with_: Imperfections) -> OperationalAmplifier:
    """Return the op-amp with ideal figures for the imperfections left out."""
    ideal = {
        "gain_bandwidth": {
            "gain_bandwidth": _UNLIMITED_BANDWIDTH,
            "open_loop_gain": _UNLIMITED_GAIN,
        },
        "slew_rate": {"slew_rate": math.inf},
        "bias_current": {"bias_current": 0.0, "offset_current": 0.0},
        "output_resistance": {"output_resistance": _NEGLIGIBLE_RESISTANCE},
    }
    changes = [ideal[name] for name in ideal if not getattr(with_, name)]
    return replace(
        amplifier, **{name: value for change in changes for name, value in change.items()}
    )
