"""The output limiter: what the zeners and P4 leave of the boundary-layer amplifier's output."""

from dataclasses import dataclass

import numpy as np

from analog_card.behaviour_elements import (
    SATURATION_CURRENT,
    THERMAL_VOLTAGE,
    ZENERS,
    Elements,
    wiper_source,
    zener_current,
    zener_voltage,
)
from analog_card.design import Design, OperationalAmplifier

# The curve is kept at equally spaced voltages, 5 mV apart: straight lines between them are within
# 0.1 mV of it, as the knee is 0.1 V wide.
HIGHEST, STEP = 20.0, 5e-3
_CURRENTS = np.geomspace(1e-12, 0.05, 2000)


@dataclass(frozen=True)
class LimiterCurve:
    """Voltages of the output limiter over the voltage at its input.

    Attributes
    ----------
    clamped : ndarray, shape (n,)
        Voltage across zeners and P4, for inputs from -`HIGHEST` to `HIGHEST` in `STEP` [V].
    inside : ndarray, shape (n,)
        What the op-amp ahead needs inside, before its output resistance, for each input [V].
    fraction : float
        Of the clamped voltage, at the wiper of P4 [V/V].
    division : float
        Clamped voltage for each volt of a small input [V/V].
    """

    clamped: np.ndarray
    inside: np.ndarray
    fraction: float
    division: float

    def loaded(self, swing: np.ndarray) -> np.ndarray:
        """Return which outputs the op-amp reaches under this load with a swing inside it [V]."""
        return np.interp(swing, self.inside, inputs())


def inputs() -> np.ndarray:
    """Return the input voltages of a `LimiterCurve` [V]."""
    return np.linspace(-HIGHEST, HIGHEST, round(2 * HIGHEST / STEP) + 1)


def output_drop(current: np.ndarray, amplifier: OperationalAmplifier) -> np.ndarray:
    """Return what an op-amp loses inside when its output sources a current [V].

    Notes
    -----
    Of the op-amp's netlist: I = Ilim tanh(U/(Ro Ilim)), other limits for source and sink. Beyond
    a limit the drop is that just short of it, far above any supply.
    """
    limit = np.where(current < 0, amplifier.sink_limit, amplifier.source_limit)
    share = np.clip(current / limit, -1 + 1e-12, 1 - 1e-12)
    return np.asarray(amplifier.output_resistance * limit * np.arctanh(share))


def limiter_curve(
    design: Design,
    elements: Elements,
    contacts: tuple[float, float],
    amplifier: OperationalAmplifier,
    feedback: float,
    knee: bool,
) -> LimiterCurve:
    """Return the curve of a card's output limiter.

    Parameters
    ----------
    design : Design
        The card.
    elements : mapping of str to float
        Values of its elements.
    contacts : tuple of float
        End and wiper resistance of P4 [ohm].
    amplifier : OperationalAmplifier
        The op-amp ahead.
    feedback : float
        What its own feedback network loads it with, to ground [ohm].
    knee : bool
        Whether the zeners have their characteristic; without it they limit hard.

    Notes
    -----
    Two zeners in series, one in breakdown and one in forward direction:
    U(I) = Vt ln(I/Is) + Ubv + Vt ln(I/Ibv) + 2 rz I. The input is then
    U + Rclamp (I + U/Rtrack), so that the curve needs no iteration.
    """
    parts = design.soldered.output_limiter
    wiper = wiper_source("P4", elements, *contacts)
    clamp, current = elements["xlimiter.rclamp"], zener_current(design)
    division = wiper.track / (wiper.track + clamp)
    grid = inputs()
    sides = []
    # With a positive output the upper zener breaks down, with a negative one the lower.
    for zener in ZENERS:
        if knee:
            voltage = (
                THERMAL_VOLTAGE * np.log(_CURRENTS / SATURATION_CURRENT)
                + elements[zener]
                + THERMAL_VOLTAGE * np.log(_CURRENTS / current)
                + 2 * parts.zener_resistance * _CURRENTS
            )
            ahead = voltage + clamp * (_CURRENTS + voltage / wiper.track)
            below = np.abs(grid) * division
            side = np.where(np.abs(grid) < ahead[0], below, np.interp(np.abs(grid), ahead, voltage))
        else:
            level = parts.clamp_level + elements[zener] - zener_voltage(design)
            side = np.minimum(np.abs(grid) * division, level)
        sides.append(side)
    clamped = np.where(grid < 0, -sides[1], sides[0])
    load = (grid - clamped) / clamp + grid / feedback
    ahead = grid + output_drop(load, amplifier)
    return LimiterCurve(clamped, ahead, wiper.fraction, division)
