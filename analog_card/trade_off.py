"""The break frequency of the differentiators against noise and switching frequency."""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from analog_card.behaviour import CardBehaviour
from analog_card.behaviour_model import stage_responses
from analog_card.design import Design, DifferentiatorParts
from analog_card.errors import InputError
from analog_card.figures import card_figures
from analog_card.linear_servo import (
    LinearServo,
    converter_step,
    detectable_frequency,
    limit_cycle,
)
from analog_card.noise import card_noise, white_density

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BREAK_FREQUENCIES = tuple(float(f) for f in np.geomspace(1e3, 10e3, 11).round(-1))
# Of the transducer: 0.1 mV is where the recommended card begins to suffer, wideband.
TRANSDUCER_NOISE, TRANSDUCER_BAND = 0.1e-3, 10e3


@dataclass(frozen=True)
class TradeOffPoint:
    """A card with one break frequency.

    Attributes
    ----------
    break_frequency : float
        Both breaks of both stages [Hz].
    own_noise, total_noise : float
        At the acceleration tap, of the card alone and with the transducer [m/s2 rms].
    switching_frequency : float
        Limit cycle with an ideal relay [Hz].
    circuit_switching_frequency : float
        The same with the op-amp as relay, which takes its time to come out of saturation [Hz].
    """

    break_frequency: float
    own_noise: float
    total_noise: float
    switching_frequency: float
    circuit_switching_frequency: float


@dataclass(frozen=True)
class TradeOff:
    """What a range of break frequencies costs and gives.

    Attributes
    ----------
    points : tuple of TradeOffPoint
        By increasing break frequency.
    nominal : TradeOffPoint
        The card as it is; its break frequency is the mean of its four.
    detectable_frequency : float
        Chattering below this frequency is seen by a 12-bit converter [Hz].
    transducer_noise, transducer_band : float
        Assumed noise of the transducer [V rms], white up to [Hz].
    """

    points: tuple[TradeOffPoint, ...]
    nominal: TradeOffPoint
    detectable_frequency: float
    transducer_noise: float
    transducer_band: float

    def to_dict(self) -> dict[str, object]:
        """Return everything as plain values in SI units, for JSON."""
        return asdict(self)

    def plot(self, axes: Sequence["Axes"]) -> Sequence["Axes"]:
        """Draw noise and switching frequency over the break frequency.

        Parameters
        ----------
        axes : sequence of matplotlib.axes.Axes
            Two, one above the other.

        Returns
        -------
        sequence of matplotlib.axes.Axes
            The same axes.
        """
        noise, switching = axes
        f = [point.break_frequency for point in self.points]
        label = f"with {1e3 * self.transducer_noise:g} mV of the transducer, "
        label += f"white to {self.transducer_band:g} Hz"
        noise.loglog(f, [point.total_noise for point in self.points], "C1-", label=label)
        noise.loglog(f, [point.own_noise for point in self.points], "C0-", label="the card alone")
        noise.set_ylabel("acceleration noise, m/s² rms")
        ideal = [point.switching_frequency for point in self.points]
        circuit = [point.circuit_switching_frequency for point in self.points]
        switching.semilogx(f, ideal, "C2-", label="ideal relay")
        switching.semilogx(f, circuit, "C3-", label="op-amp as relay")
        switching.axhline(self.detectable_frequency, color="0.5", ls=":")
        switching.annotate(
            "a 12-bit converter sees chattering below this",
            (f[0], self.detectable_frequency),
            xytext=(4, 4),
            textcoords="offset points",
            color="0.3",
            fontsize="small",
        )
        switching.set_ylabel("switching frequency, Hz")
        switching.set_xlabel("break frequency of the differentiators, Hz")
        top = max(*ideal, self.detectable_frequency)
        switching.set_ylim(min(circuit) - 10, top + 15)
        for ax in axes:
            ax.axvline(self.nominal.break_frequency, color="0.5", ls="--", label="this card")
            ax.grid(which="both", alpha=0.25)
            ax.legend(loc="best", fontsize="small")
            ax.set_xticks([1e3, 2e3, 5e3, 1e4], ["1000", "2000", "5000", "10000"])
            ax.set_xticks([], minor=True)
        return axes


def trade_off(
    design: Design,
    break_frequencies: Sequence[float] = BREAK_FREQUENCIES,
    servo: LinearServo | None = None,
    transducer_noise: float = TRANSDUCER_NOISE,
    transducer_band: float = TRANSDUCER_BAND,
    step: Callable[[str], None] = lambda _: None,
) -> TradeOff:
    """Weigh the noise at the acceleration tap against the switching frequency.

    Parameters
    ----------
    design : Design
        The card. Its series resistors and feedback capacitors are changed for each break
        frequency, everything else stays.
    break_frequencies : sequence of float, optional
        For both breaks of both stages [Hz].
    servo : LinearServo, optional
        What is controlled; by default the thesis' rig at 20 mm.
    transducer_noise, transducer_band : float, optional
        Noise of the transducer [V rms], white up to [Hz].
    step : callable, optional
        Told what is computed next.

    Returns
    -------
    TradeOff
        One point for each break frequency.

    Raises
    ------
    InputError
        When a value is not greater than 0.

    Notes
    -----
    Noise from 1 Hz to 1 MHz (see `analog_card.noise.card_noise`), in m/s2 by the tap's own scale.
    Switching frequency by describing function; in the non-linear closed loop the valve is open on
    average, which adds damping: 5 to 8 % more. An op-amp as relay leaves saturation as an
    integrator, which delays it by sqrt(2 dV/(2 pi GBW slope)).

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> slow, fast = trade_off(load_design(), (1000.0, 5000.0)).points
    >>> fast.own_noise > 10 * slow.own_noise
    True
    """
    if not all(f > 0 for f in break_frequencies) or not break_frequencies:
        raise InputError(f"break frequencies {list(break_frequencies)}: all have to be above 0 Hz")
    servo = servo or LinearServo()
    points = []
    for frequency in break_frequencies:
        step(f"break frequency {frequency:g} Hz")
        changed = with_break_frequency(design, frequency)
        points.append(_point(changed, servo, transducer_noise, transducer_band))
    level, stroke = card_figures(design).level, design.transducer.full_scale_displacement
    return TradeOff(
        points=tuple(points),
        nominal=_point(design, servo, transducer_noise, transducer_band),
        detectable_frequency=detectable_frequency(servo, level, converter_step(stroke)),
        transducer_noise=transducer_noise,
        transducer_band=transducer_band,
    )


def with_break_frequency(design: Design, frequency: float) -> Design:
    """Return a card with both breaks of both differentiators at one frequency [Hz]."""

    def changed(parts: DifferentiatorParts) -> DifferentiatorParts:
        lag = 1 / (2 * math.pi * frequency)
        return replace(
            parts,
            series_resistance=lag / parts.capacitance,
            feedback_capacitance=lag / parts.resistance,
        )

    soldered = replace(
        design.soldered,
        velocity_differentiator=changed(design.soldered.velocity_differentiator),
        acceleration_differentiator=changed(design.soldered.acceleration_differentiator),
    )
    return replace(design, soldered=soldered)


def surface_response(design: Design, frequency: np.ndarray) -> np.ndarray:
    """Return the surface voltage for each volt of the transducer, its sign turned [V/V].

    Parameters
    ----------
    design : Design
        The card.
    frequency : ndarray, shape (n,)
        [Hz].
    """
    gain = stage_responses(CardBehaviour(design), frequency)
    deviation = gain["buffer"] * gain["difference from displacement"]
    rate = gain["first"] * gain["inverter"]
    second = gain["first"] * gain["second"]
    return -(
        deviation * gain["surface from deviation"]
        + rate * gain["surface from rate"]
        + second * gain["surface from acceleration"]
    )


def _point(
    design: Design, servo: LinearServo, transducer_noise: float, transducer_band: float
) -> TradeOffPoint:
    figures = card_figures(design)
    f = np.geomspace(1.0, 1e6, 241)
    density = np.where(f <= transducer_band, white_density(transducer_noise, transducer_band), 0.0)
    noise = card_noise(design, f, density)
    scale = figures.transducer_gain * figures.rc_velocity * figures.rc_acceleration
    band = np.geomspace(20.0, 1000.0, 1200)
    loop = surface_response(design, band) * figures.transducer_gain * servo.response(band)
    return TradeOffPoint(
        break_frequency=float(np.mean([*figures.velocity_breaks, *figures.acceleration_breaks])),
        own_noise=noise.voltage("acceleration", "op-amps", "resistors") / scale,
        total_noise=noise.voltage("acceleration") / scale,
        switching_frequency=limit_cycle(band, loop, figures.level)[0],
        circuit_switching_frequency=limit_cycle(
            band, loop, figures.level, _relay_delay_factor(design)
        )[0],
    )


def _relay_delay_factor(design: Design) -> float:
    """Return 2 dV/(2 pi GBW): dV is the swing, from saturation to 0 V."""
    amplifier = design.soldered.operational_amplifier
    swing = 0.5 * (amplifier.positive_swing + amplifier.negative_swing)
    return 2 * swing / (2 * math.pi * amplifier.gain_bandwidth)
