"""Comparing the netlist of the differentiators with their behavioural model."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import netlists
from analog_card.design import Design
from analog_card.design_file import load_design
from analog_card.differentiator import Taps, differentiator_pair
from analog_card.ngspice import FrequencySweep, Transient, run

GAIN_LIMIT = 0.1  # dB, within the band
PHASE_LIMIT = 1.0  # degrees, within the band
TRANSIENT_LIMIT = 1.0  # per cent of the range of the waveform
BAND = (1.0, 20e3)  # Hz, where the limits hold
SWEEP = FrequencySweep(1.0, 100e3, 40)
# 10 us resolve the filter (56 us); with 5 us the netlist changes by less than 0.05 % of range.
TRANSIENT = Transient(stop=0.1, longest_step=10e-6)
GRID_STEP = 4e-6  # s, of the common time grid


@dataclass(frozen=True)
class Deviation:
    """The worst disagreement in one quantity.

    Attributes
    ----------
    tap, quantity, unit : str
        What was compared.
    band : str
        Where.
    worst : float
        Largest disagreement, without sign [unit].
    at : float
        Frequency [Hz] or time [s] of it.
    limit : float or None
        Largest disagreement allowed [unit]; None where it is reported only.
    """

    tap: str
    quantity: str
    unit: str
    band: str
    worst: float
    at: float
    limit: float | None

    @property
    def passed(self) -> bool:
        """Whether the disagreement is within its limit."""
        return self.limit is None or bool(self.worst <= self.limit)


@dataclass(frozen=True)
class Verification:
    """What the comparison gave.

    Attributes
    ----------
    design : Design
        The card compared.
    deviations : tuple of Deviation
        The worst of each quantity.
    frequency, time : ndarray
        Common axes [Hz], [s].
    sensor : ndarray
        Transducer voltage over time [V].
    netlist_response, model_response : Taps
        Complex gains over frequency [V/V].
    netlist_taps, model_taps : Taps
        Tap voltages over time [V].
    """

    design: Design
    deviations: tuple[Deviation, ...]
    frequency: np.ndarray
    time: np.ndarray
    sensor: np.ndarray
    netlist_response: Taps
    model_response: Taps
    netlist_taps: Taps
    model_taps: Taps

    @property
    def passed(self) -> bool:
        """Whether every quantity is within its limit."""
        return all(deviation.passed for deviation in self.deviations)

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain values, for JSON."""
        rows = [{**asdict(item), "passed": item.passed} for item in self.deviations]
        return {"design": self.design.title, "passed": self.passed, "deviations": rows}

    def plot(self, axes: Sequence[Any]) -> Sequence[Any]:
        """Draw the comparison.

        Parameters
        ----------
        axes : sequence of four matplotlib Axes
            For gain, deviation over frequency, taps over time, deviation over time.

        Returns
        -------
        sequence of four matplotlib Axes
            The same.
        """
        gain, frequency_deviation, taps, time_deviation = axes
        for number, tap in enumerate(Taps._fields):
            colour = f"C{number}"
            netlist, model = self.netlist_response[number], self.model_response[number]
            gain.semilogx(self.frequency, _decibel(netlist), colour, label=f"{tap}, netlist")
            gain.semilogx(self.frequency, _decibel(model), "k:", label=None)
            ratio = netlist / model
            frequency_deviation.loglog(
                self.frequency, _floored(_decibel(ratio)), colour, label=f"{tap}, gain [dB]"
            )
            frequency_deviation.loglog(
                self.frequency,
                _floored(np.angle(ratio, deg=True)),
                colour,
                linestyle="--",
                label=f"{tap}, phase [degree]",
            )
            taps.plot(self.time * 1e3, self.netlist_taps[number], colour, label=f"{tap}, netlist")
            taps.plot(self.time * 1e3, self.model_taps[number], "k:")
            time_deviation.plot(
                self.time * 1e3,
                _per_cent_of_range(self.netlist_taps[number], self.model_taps[number]),
                colour,
                label=tap,
            )
        for axis in (gain, taps):
            axis.plot([], [], "k:", label="behavioural model")
        gain.margins(y=0.3)
        frequency_deviation.axhline(GAIN_LIMIT, color="grey", linewidth=0.8)
        frequency_deviation.text(1.2, GAIN_LIMIT * 1.15, "limit, gain", color="grey", size="small")
        frequency_deviation.axhline(PHASE_LIMIT, color="grey", linewidth=0.8, linestyle="--")
        frequency_deviation.text(
            1.2, PHASE_LIMIT * 1.15, "limit, phase", color="grey", size="small"
        )
        frequency_deviation.axvline(BAND[1], color="grey", linewidth=0.8, linestyle=":")
        _label(gain, "frequency [Hz]", "gain from transducer [dB]")
        _label(frequency_deviation, "frequency [Hz]", "netlist against model", "center left")
        taps.margins(y=0.25)
        _label(taps, "time [ms]", "tap voltage [V]")
        _label(time_deviation, "time [ms]", "netlist - model [% of range]")
        return axes


def verify(
    design: Design | None = None, step: Callable[[str], None] = lambda what: None
) -> Verification:
    """Compare the netlist of the differentiators with the behavioural model.

    Parameters
    ----------
    design : Design, optional
        The card; without it the recommended one.
    step : callable, optional
        Told what is being done, for a progress display.

    Returns
    -------
    Verification
        Deviations with their limits, and the curves.

    Raises
    ------
    SimulationError
        When ngspice fails.

    Notes
    -----
    Frequency response from 1 Hz to 100 kHz, limits from 1 Hz to 20 kHz; transient with a
    minimum-jerk step of 9 mm in 50 ms and a 200 Hz ripple. Both sides get the same part values
    and op-amp figures, so this proves the model's equations, not the figures.

    Examples
    --------
    >>> verify().passed
    True
    """
    design = design or load_design()
    model = differentiator_pair(design)
    parameters = {**design.netlist_parameters(), "transducer_gain": design.transducer.gain}

    step("frequency response")
    response = run(netlists.DOUBLE_DIFFERENTIATOR_AC, SWEEP, design.netlist_parameters())
    frequency = response.frequency
    responses = Taps(*(response[tap] for tap in Taps._fields)), model.response(frequency)

    step("transient")
    movement = run(netlists.DOUBLE_DIFFERENTIATOR_TRANSIENT, TRANSIENT, parameters)
    time = np.arange(round(TRANSIENT.stop / GRID_STEP) + 1) * GRID_STEP
    sensor = movement.at(time, "sensor")
    taps = Taps(*(movement.at(time, tap) for tap in Taps._fields)), model.transient(time, sensor)

    deviations = (
        *_response_deviations(frequency, *responses),
        *_transient_deviations(time, *taps),
    )
    return Verification(design, deviations, frequency, time, sensor, *responses, *taps)


def _response_deviations(frequency: np.ndarray, netlist: Taps, model: Taps) -> list[Deviation]:
    within = (frequency >= BAND[0]) & (frequency <= BAND[1])
    found = []
    for everywhere in (False, True):
        chosen = np.ones_like(within) if everywhere else within
        band = f"{frequency[chosen][0]:g} Hz–{frequency[chosen][-1] / 1e3:.3g} kHz"
        for tap, measured, expected in zip(Taps._fields, netlist, model, strict=True):
            ratio = (measured / expected)[chosen]
            for quantity, unit, values, limit in (
                ("gain", "dB", _decibel(ratio), GAIN_LIMIT),
                ("phase", "degree", np.angle(ratio, deg=True), PHASE_LIMIT),
            ):
                allowed = None if everywhere else limit
                worst = int(np.argmax(np.abs(values)))
                found.append(
                    Deviation(
                        tap,
                        quantity,
                        unit,
                        band,
                        float(abs(values[worst])),
                        float(frequency[chosen][worst]),
                        allowed,
                    )
                )
    return found


def _transient_deviations(time: np.ndarray, netlist: Taps, model: Taps) -> list[Deviation]:
    found = []
    for tap, measured, expected in zip(Taps._fields, netlist, model, strict=True):
        values = np.abs(_per_cent_of_range(measured, expected))
        worst = int(np.argmax(values))
        found.append(
            Deviation(
                tap,
                "transient",
                "% of range",
                f"0–{time[-1] * 1e3:g} ms",
                float(values[worst]),
                float(time[worst]),
                TRANSIENT_LIMIT,
            )
        )
    return found


def _decibel(ratio: np.ndarray) -> np.ndarray:
    return 20 * np.log10(np.abs(ratio))


def _per_cent_of_range(measured: np.ndarray, expected: np.ndarray) -> np.ndarray:
    return 100 * (measured - expected) / np.ptp(measured)


def _floored(values: np.ndarray) -> np.ndarray:
    # Below this the simulator's own rounding is seen.
    return np.maximum(np.abs(values), 1e-7)


def _label(axis: Any, horizontal: str, vertical: str, legend: str = "upper right") -> None:
    axis.set_xlabel(horizontal)
    axis.set_ylabel(vertical)
    axis.grid(True, alpha=0.3)
    axis.legend(fontsize="small", loc=legend, frameon=False)
