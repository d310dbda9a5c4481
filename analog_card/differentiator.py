"""The two differentiators of the card as a linear system: the behavioural model of the taps."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from analog_card.design import Design, DifferentiatorParts, OperationalAmplifier
from analog_card.errors import InputError


class Taps(NamedTuple):
    """What the two differentiators give out: one array for each tap."""

    velocity: np.ndarray
    acceleration: np.ndarray


@dataclass(frozen=True)
class DifferentiatorPair:
    """The two stages in series as x' = A x + B u, y = C x + D u.

    Attributes
    ----------
    state, inputs, outputs, direct : ndarray
        A (n, n), B (n, 3), C (2, n), D (2, 3). Inputs: transducer voltage, offset voltages of
        the first and the second op-amp [V]. Outputs: velocity tap, acceleration tap [V].
    offset : float
        Offset voltage of both op-amps [V].

    Notes
    -----
    Linear: neither slew rate nor swing. Not in it, each below 0.01 dB up to 20 kHz with the
    recommended card: input capacitance, bias current, the load of the surface amplifier.
    """

    state: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray
    direct: np.ndarray
    offset: float

    def response(self, frequency: np.ndarray) -> Taps:
        """Return the complex gain from the transducer voltage to each tap.

        Parameters
        ----------
        frequency : ndarray, shape (n,)
            Frequencies [Hz].

        Returns
        -------
        Taps
            Complex gains, each of shape (n,) [V/V].
        """
        s = 2j * math.pi * np.asarray(frequency, float)[:, None, None]
        resolvent = s * np.eye(len(self.state)) - self.state
        from_sensor = np.linalg.solve(resolvent, self.inputs[:, :1].astype(complex)[None])
        gains = (self.outputs @ from_sensor)[..., 0] + self.direct[:, 0]
        return Taps(gains[:, 0], gains[:, 1])

    def transient(self, time: np.ndarray, sensor: np.ndarray) -> Taps:
        """Return the taps over time, from rest at the first value of the transducer voltage.

        Parameters
        ----------
        time : ndarray, shape (n,)
            Equally spaced times [s].
        sensor : ndarray, shape (n,)
            Transducer voltage, taken to be straight between the times [V].

        Returns
        -------
        Taps
            Tap voltages, each of shape (n,) [V].

        Raises
        ------
        InputError
            When the times are not equally spaced.
        """
        from scipy.signal import lsim

        steps = np.diff(time)
        if len(time) < 2 or not np.allclose(steps, steps[0], rtol=1e-6) or steps[0] <= 0:
            raise InputError("times: at least two, equally spaced and increasing are needed")
        offsets = np.full((len(time), 2), self.offset)
        drive = np.column_stack([sensor, offsets])
        rest = np.linalg.solve(self.state, -self.inputs @ drive[0])
        system = (self.state, self.inputs, self.outputs, self.direct)
        _, taps, _ = lsim(system, drive, time, rest)
        return Taps(taps[:, 0], taps[:, 1])


def differentiator_pair(design: Design, finite_bandwidth: bool = True) -> DifferentiatorPair:
    """Return the behavioural model of the two differentiators of a card.

    Parameters
    ----------
    design : Design
        The card.
    finite_bandwidth : bool, optional
        Whether the op-amps have a finite gain-bandwidth product and an output resistance;
        without it they are ideal.

    Returns
    -------
    DifferentiatorPair
        The linear system.

    Notes
    -----
    Ideal op-amps: each stage is -s R C/((1 + s Cf R)(1 + s C Rs)), thesis (9.3).

    Finite ones: the exact analysis of the feedback circuit with the open-loop gain
    A(s) = A0/(1 + s A0/(2 pi GBW)). A stage alone, without output resistance, is then
    -(Zf/Zi)/(1 + (1 + Zf/Zi)/A) with Zi = Rs + 1/(s C) and Zf = R/(1 + s Cf R). The output
    resistance Ro of the first stage feeds the input branch of the second, so that both are
    solved together. States of a stage: voltage of the input capacitor vc, of the feedback
    capacitor vf, and of the amplifier ahead of its output resistance va. The currents i1, i2 of
    the input branches follow from

        (Rs1 + Ro) i1 - Ro i2 = vx - vc1 - vf1 - va1
        -Ro i1 + (Rs2 + 2 Ro) i2 = va1 - vc2 - vf2 - va2

    and then C vc' = i, Cf vf' = i - vf/R, va' = 2 pi GBW (offset - vf - vout - va/A0). A load of
    R to ground at an output makes k va and k Ro of its va and Ro there, k = 1/(1 + Ro/R).

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> pair = differentiator_pair(load_design())
    >>> abs(pair.response(np.array([10.0])).velocity).round(3)  # 2 pi 10 Hz x 12 ms
    array([0.754])
    """
    parts = design.soldered
    first, second = parts.velocity_differentiator, parts.acceleration_differentiator
    if finite_bandwidth:
        rates, taps = circuit_equations(first, second, (parts.operational_amplifier,) * 2)
    else:
        rates, taps = _ideal(first, second)
    states = len(rates)
    return DifferentiatorPair(
        state=rates[:, :states],
        inputs=rates[:, states:],
        outputs=taps[:, :states],
        direct=taps[:, states:],
        offset=design.soldered.operational_amplifier.input_offset_voltage,
    )


# Below, every voltage, current and rate is a row of factors on the states and, behind them, on
# the three inputs, so that the equations of the circuit can be written down as they are.


def _ideal(
    first: DifferentiatorParts, second: DifferentiatorParts
) -> tuple[np.ndarray, np.ndarray]:
    """Return rates of the states and taps with ideal op-amps.

    Both inputs of an op-amp are then at its offset voltage and the output is vf below that.
    """
    vc1, vf1, vc2, vf2, vx, offset1, offset2 = np.eye(7)
    v1, v2 = offset1 - vf1, offset2 - vf2
    i1 = (vx - vc1 - offset1) / first.series_resistance
    i2 = (v1 - vc2 - offset2) / second.series_resistance
    rates = [
        i1 / first.capacitance,
        (i1 - vf1 / first.resistance) / first.feedback_capacitance,
        i2 / second.capacitance,
        (i2 - vf2 / second.resistance) / second.feedback_capacitance,
    ]
    return np.array(rates), np.array([v1, v2])


def circuit_equations(
    first: DifferentiatorParts,
    second: DifferentiatorParts,
    amplifiers: tuple[OperationalAmplifier, OperationalAmplifier],
    loads: tuple[float, float] = (math.inf, math.inf),
) -> tuple[np.ndarray, np.ndarray]:
    """Return the circuit of both stages with real op-amps, as rows of factors.

    Parameters
    ----------
    first, second : DifferentiatorParts
        The two stages.
    amplifiers : tuple of OperationalAmplifier
        Their op-amps.
    loads : tuple of float, optional
        What the taps feed beside the second stage, to ground [ohm].

    Returns
    -------
    rates : ndarray, shape (6, 9)
        Rates of vc1, vf1, va1, vc2, vf2, va2 by these and, behind them, the transducer voltage
        and the two offset voltages; see `differentiator_pair`.
    taps : ndarray, shape (2, 9)
        Velocity and acceleration tap in the same terms.
    """
    speed1, speed2 = (2 * math.pi * amplifier.gain_bandwidth for amplifier in amplifiers)
    gain1, gain2 = (amplifier.open_loop_gain for amplifier in amplifiers)
    ro1, ro2 = (amplifier.output_resistance for amplifier in amplifiers)
    vc1, vf1, va1, vc2, vf2, va2, vx, offset1, offset2 = np.eye(9)
    # Each output with its load: a source of k va behind k Ro.
    k1, k2 = 1 / (1 + ro1 / loads[0]), 1 / (1 + ro2 / loads[1])
    i1, i2 = np.linalg.solve(
        [
            [first.series_resistance + k1 * ro1, -k1 * ro1],
            [-k1 * ro1, second.series_resistance + k1 * ro1 + k2 * ro2],
        ],
        [vx - vc1 - vf1 - k1 * va1, k1 * va1 - vc2 - vf2 - k2 * va2],
    )
    v1, v2 = k1 * (va1 + ro1 * (i1 - i2)), k2 * (va2 + ro2 * i2)
    rates = [
        i1 / first.capacitance,
        (i1 - vf1 / first.resistance) / first.feedback_capacitance,
        speed1 * (offset1 - vf1 - v1 - va1 / gain1),
        i2 / second.capacitance,
        (i2 - vf2 / second.resistance) / second.feedback_capacitance,
        speed2 * (offset2 - vf2 - v2 - va2 / gain2),
    ]
    return np.array(rates), np.array([v1, v2])
