"""Noise at the taps of the card: what its parts and the transducer make of themselves."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import netlists
from analog_card.analyses import Noise
from analog_card.behaviour import CardBehaviour, card_stages
from analog_card.behaviour_elements import Elements, nominal_elements, wiper_source
from analog_card.behaviour_model import stage_responses
from analog_card.design import Design, DifferentiatorParts
from analog_card.differentiator import differentiator_pair
from analog_card.errors import InputError
from analog_card.ngspice import run
from analog_card.waveforms import noise_voltage

TAPS = ("velocity", "acceleration", "surface")
ORIGINS = ("op-amps", "resistors", "transducer")
BAND = (1.0, 1e6)
# The temperature at which ngspice computes unless told otherwise [K].
TEMPERATURE = 300.15
_BOLTZMANN = 1.380649e-23
# Places of the amplifiers in `Stages.lags`.
_BUFFER, _DIFFERENCE, _INVERTER, _SURFACE = range(4)


@dataclass(frozen=True)
class CardNoise:
    """Noise densities at the taps of a card.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Increasing [Hz].
    power : mapping of str to mapping
        By tap (`TAPS`) and origin (`ORIGINS`) the squared density, shape (n,) [V2/Hz].
    """

    frequency: np.ndarray
    power: Mapping[str, Mapping[str, np.ndarray]]

    def density(self, tap: str, *origins: str) -> np.ndarray:
        """Return the noise density at a tap, of all origins unless some are named [V/sqrt(Hz)]."""
        return np.sqrt(sum(self.power[tap][name] for name in origins or ORIGINS))

    def voltage(self, tap: str, *origins: str) -> float:
        """Return the root-mean-square voltage at a tap over all frequencies [V].

        Parameters
        ----------
        tap : str
            One of `TAPS`.
        *origins : str
            Some of `ORIGINS`; all without.
        """
        density = self.density(tap, *origins)
        return noise_voltage(self.frequency, density) if np.all(density > 0) else 0.0


def opamp_noise(design: Design, frequency: np.ndarray) -> np.ndarray:
    """Return the input voltage noise of the op-amp [V/sqrt(Hz)].

    Parameters
    ----------
    design : Design
        The card.
    frequency : ndarray, shape (n,)
        [Hz].

    Notes
    -----
    White and 1/f noise through the data sheet's points at 1 and 10 kHz, as in
    ``netlists/opamp/ca3140-noisy.lib``. Where they fall faster than 1/f, as the CA3140's a little,
    1/f noise through the geometric mean of both.
    """
    amplifier = design.soldered.operational_amplifier
    low, high = amplifier.noise_1_kilohertz, amplifier.noise_10_kilohertz
    through = (low**2 - high**2) / (1 / 1e3 - 1 / 10e3)
    flicker = min(through, low * high * math.sqrt(1e3 * 10e3))
    white = max(high**2 - through / 10e3, 0.0)
    return np.sqrt(white + flicker / np.asarray(frequency, float))


def white_density(voltage: float, band: float) -> float:
    """Return the density of white noise of a given voltage up to a band limit [V/sqrt(Hz)].

    Parameters
    ----------
    voltage : float
        Root-mean-square [V].
    band : float
        [Hz].

    Raises
    ------
    InputError
        When the voltage is below 0 V or the band is not above 0 Hz.
    """
    if not (voltage >= 0 and band > 0):
        raise InputError(
            f"noise of {voltage:g} V up to {band:g} Hz; 0 V or more, above 0 Hz needed"
        )
    return voltage / math.sqrt(band)


def card_noise(
    design: Design,
    frequency: np.ndarray | None = None,
    transducer_density: float | np.ndarray = 0.0,
) -> CardNoise:
    """Return the noise at the taps of a card, from its behaviour.

    Parameters
    ----------
    design : Design
        The card.
    frequency : ndarray, shape (n,), optional
        Increasing; 1 Hz to 1 MHz by default [Hz].
    transducer_density : float or ndarray of shape (n,), optional
        Noise density at the transducer input [V/sqrt(Hz)].

    Returns
    -------
    CardNoise
        Squared densities by tap and origin.

    Notes
    -----
    Linear: every source of noise, voltage noise of each op-amp and thermal noise of each resistor,
    goes to each tap through its own transfer function with finite gain-bandwidth, and the squares
    add up. The bias resistors are bypassed by their capacitors. Left out, being small: current
    noise, tracks of the potentiometers beyond their wiper resistance, the demand's transducer.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> noise = card_noise(load_design())
    >>> round(1e3 * noise.voltage("acceleration"), 1)  # mV; an independent study: 23.9
    23.3
    """
    f = np.geomspace(*BAND, 241) if frequency is None else np.asarray(frequency, float)
    sources = _sources(design, f)
    amplifier = opamp_noise(design, f) ** 2
    thermal = 4 * _BOLTZMANN * TEMPERATURE
    from_transducer = np.asarray(transducer_density, float) ** 2
    power: dict[str, dict[str, np.ndarray]] = {}
    for index, tap in enumerate(TAPS):
        power[tap] = {
            "op-amps": amplifier * sum(abs(way[index]) ** 2 for way in sources.amplifiers),
            "resistors": thermal * sum(r * abs(way[index]) ** 2 for r, way in sources.resistors),
            "transducer": from_transducer * abs(sources.transducer[index]) ** 2,
        }
    return CardNoise(f, power)


def netlist_noise(
    design: Design, tap: str, transducer_density: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the noise that ngspice finds at a tap of one channel.

    Parameters
    ----------
    design : Design
        The card.
    tap : str
        One of `TAPS`.
    transducer_density : float, optional
        White noise at the transducer input [V/sqrt(Hz)].

    Returns
    -------
    frequency, density : ndarray, shape (n,)
        [Hz], [V/sqrt(Hz)].

    Notes
    -----
    ngspice also refers the noise to the transducer input; the ratio is the gain from there.
    """
    analysis = Noise(tap, "vtransducer", *BAND)
    waves = run(netlists.CARD_NOISE, analysis, design.netlist_parameters())
    gain = waves.noise_density / waves["inoise_spectrum"].real
    return waves.frequency, np.hypot(waves.noise_density, gain * transducer_density)


# A way is the complex gain from a source of noise to the three taps, shape (3, n).


@dataclass(frozen=True)
class _Sources:
    amplifiers: list[np.ndarray]
    resistors: list[tuple[float, np.ndarray]]
    transducer: np.ndarray


def _sources(design: Design, f: np.ndarray) -> _Sources:
    behaviour = CardBehaviour(design)
    stages, elements = card_stages(behaviour), nominal_elements(design)
    gain = stage_responses(behaviour, f)
    s = 2j * math.pi * f
    # Noise gain of each amplifier, closed loop: what its own noise is at its output.
    lags = stages.lags[:, None]
    own = lags * stages.speeds[:, None] / (1 + s * lags)
    nothing = np.zeros_like(s)
    deviation = np.array([nothing, nothing, gain["surface from deviation"]])
    rate = np.array([nothing, nothing, gain["surface from rate"]])
    first, second = _tap_ways(gain)
    displacement = gain["first"] * first + gain["difference from displacement"] * deviation
    wanted = gain["difference from demand"] * deviation
    surface = np.array([nothing, nothing, np.ones_like(s)])
    parts = design.soldered
    buffer_resistance = parts.input_buffer.series_resistance
    amplifiers = [
        own[_BUFFER] * displacement,
        own[_BUFFER] * wanted,
        own[_DIFFERENCE] * deviation,
        own[_INVERTER] * rate,
        own[_SURFACE] * surface,
    ]
    resistors = [
        (buffer_resistance, gain["buffer"] * displacement),
        (buffer_resistance, gain["buffer"] * wanted),
        # Four equal resistors: each makes its own noise with gain 1 at the output.
        (4 * parts.difference_amplifier.resistance, deviation),
        (2 * parts.inverter.resistance, rate),
        *_surface_resistors(elements, design, surface),
    ]
    offset_ways = _offset_ways(design, f)
    for stage, out, ways in (
        (parts.velocity_differentiator, first, offset_ways[0]),
        (parts.acceleration_differentiator, second, offset_ways[1]),
    ):
        amplifiers.append(ways[0] * out)
        resistors += _differentiator_resistors(stage, ways[0], out, s)
    return _Sources(amplifiers, resistors, gain["buffer"] * displacement)


def _tap_ways(gain: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the ways from the outputs of the first and the second differentiator."""
    one = np.ones_like(gain["first"])
    second = np.array([0 * one, one, gain["surface from acceleration"]])
    onward = gain["second"] * second
    onward[2] += gain["inverter"] * gain["surface from rate"]
    onward[0] = one
    return onward, second


def _offset_ways(design: Design, f: np.ndarray) -> list[np.ndarray]:
    """Return what a voltage at the non-inverting input of each differentiator is at its output."""
    pair = differentiator_pair(design)
    s = 2j * math.pi * f[:, None, None]
    resolvent = s * np.eye(len(pair.state)) - pair.state
    reached = np.linalg.solve(resolvent, pair.inputs.astype(complex)[None])
    ways = pair.outputs @ reached + pair.direct
    return [ways[:, [0], 1].T, ways[:, [1], 2].T]


def _differentiator_resistors(
    parts: DifferentiatorParts, noise_gain: np.ndarray, out: np.ndarray, s: np.ndarray
) -> list[tuple[float, np.ndarray]]:
    """Return resistors of a differentiator with their ways.

    The noise gain 1 + Zf/Zi splits into the ways of the series resistor, -Zf/Zi, and of the
    feedback resistor, Zf/R; the bias resistor is at the op-amp's own input, behind its capacitor.
    """
    branch = parts.series_resistance + 1 / (s * parts.capacitance)
    feedback = parts.resistance / (1 + s * parts.feedback_capacitance * parts.resistance)
    share = noise_gain / (1 + feedback / branch)
    bypass = 1 / (1 + s * parts.bias_capacitance * parts.bias_resistance)
    return [
        (parts.series_resistance, share * feedback / branch * out),
        (parts.resistance, share * feedback / parts.resistance * out),
        (parts.bias_resistance, noise_gain * bypass * out),
    ]


def _surface_resistors(
    elements: Elements, design: Design, surface: np.ndarray
) -> list[tuple[float, np.ndarray]]:
    contacts = design.soldered.potentiometer_contacts
    ends = (contacts.end_resistance, contacts.wiper_resistance)
    displacement, velocity = (wiper_source(name, elements, *ends) for name in ("P1", "P2"))
    feedback = elements["xsurface.rfeedback"]
    branches = (
        elements["xsurface.xdisplacement.rinput"] + displacement.resistance,
        elements["xsurface.xvelocity.rinput"] + velocity.resistance,
        elements["xsurface.racceleration"],
    )
    return [
        (feedback, surface),
        *((branch, feedback / branch * surface) for branch in branches),
    ]
