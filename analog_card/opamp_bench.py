"""The op-amp's netlist on the bench: each figure of the data sheet measured on the model."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import netlists
from analog_card.design import OperationalAmplifier
from analog_card.design_file import load_design
from analog_card.ngspice import (
    Analysis,
    FrequencySweep,
    Noise,
    OperatingPoint,
    Transient,
    Waveforms,
    run,
)

LIMIT = 5.0  # per cent of the data sheet's figure
# The figures hold at 25 C; the drift is measured up to here.
_COOL, _WARM = 25.0, 75.0


@dataclass(frozen=True)
class Figure:
    """One figure of the data sheet and what the model does.

    Attributes
    ----------
    name, unit, bench : str
        What it is, its SI unit, and the netlist that measures it.
    data_sheet, measured : float
        Both values [unit].
    why : str
        Why the model is allowed to fall short by more than the limit; empty when it is not.
    lowest : float
        How far it is allowed to fall short of the data sheet [%].
    """

    name: str
    unit: str
    bench: str
    data_sheet: float
    measured: float
    why: str = ""
    lowest: float = -LIMIT

    @property
    def deviation(self) -> float:
        """Measured against data sheet [%]."""
        return 100 * (self.measured / self.data_sheet - 1)

    @property
    def within(self) -> bool:
        """Whether it is within the limit."""
        return abs(self.deviation) <= LIMIT

    @property
    def passed(self) -> bool:
        """Whether it is within the limit, or falls short no further than it is known why."""
        return self.lowest <= self.deviation <= LIMIT


def measure_opamp(amplifier: OperationalAmplifier | None = None) -> tuple[Figure, ...]:
    """Measure the figures of the op-amp's netlist.

    Parameters
    ----------
    amplifier : OperationalAmplifier, optional
        The figures it is made from; without them those of the recommended card.

    Returns
    -------
    tuple of Figure
        One for each figure of the data sheet that is known.

    Raises
    ------
    SimulationError
        When ngspice fails.

    Notes
    -----
    Data sheet: CA3140, FN957.10, Intersil/Renesas (2005), typical values at +-15 V and 25 C. Input
    resistance, bias current and gain-bandwidth were read in its text; the others are the values it
    is quoted with elsewhere and should be checked against its table before they are relied on. The
    figures that are not parameters of the model (overshoot, rise and settling times, full-power
    bandwidth) are measured too: they say what follows from the others.

    Examples
    --------
    >>> all(figure.passed for figure in measure_opamp())
    True
    """
    amplifier = amplifier or load_design().soldered.operational_amplifier
    bench = _Bench(amplifier)
    measurements = (_open_loop, _input, _large_step, _small_step, _output, _noise)
    return tuple(figure for measure in measurements for figure in measure(bench))


@dataclass(frozen=True)
class _Bench:
    """The benches of the op-amp, with its figures."""

    amplifier: OperationalAmplifier

    def run(
        self, name: str, analysis: Analysis, **parameters: float
    ) -> tuple[Waveforms, Callable[..., Figure]]:
        path: Path = netlists.shipped()[name]
        result = run(path, analysis, {**self.amplifier.netlist_parameters(), **parameters})

        def figure(
            what: str, unit: str, data_sheet: float, measured: float, *excuse: Any
        ) -> Figure:
            return Figure(what, unit, path.name, float(data_sheet), float(measured), *excuse)

        return result, figure


def _open_loop(bench: _Bench) -> Iterator[Figure]:
    amplifier = bench.amplifier
    sweep, figure = bench.run("opamp-open-loop", FrequencySweep(0.1, 1e5, 10))
    gain = {
        name: np.abs(sweep[name]) for name in ("differential", "common", "positive", "negative")
    }
    flat = {name: values[0] for name, values in gain.items()}
    yield figure("open-loop gain", "", amplifier.open_loop_gain, flat["differential"])
    yield figure(
        "gain-bandwidth",
        "Hz",
        amplifier.gain_bandwidth,
        gain["differential"][-1] * sweep.frequency[-1],
    )
    rejection = flat["differential"] / flat["common"]
    yield figure("common-mode rejection", "", amplifier.common_mode_rejection, rejection)
    for supply in ("positive", "negative"):
        rejection = flat["differential"] / flat[supply]
        yield figure(f"{supply} supply rejection", "", amplifier.supply_rejection, rejection)


def _input(bench: _Bench) -> Iterator[Figure]:
    amplifier = bench.amplifier
    offset = amplifier.input_offset_voltage
    point, figure = bench.run("opamp-input", OperatingPoint(), input_offset=offset)
    plus, minus = point["vplus#branch"][0], point["vminus#branch"][0]
    if offset:
        yield figure("input offset voltage", "V", offset, point["out"][0])
    if amplifier.offset_drift:
        warm, _ = bench.run(
            "opamp-input", OperatingPoint(), input_offset=offset, card_temperature=_WARM
        )
        drift = (warm["out"][0] - point["out"][0]) / (_WARM - _COOL)
        yield figure("offset drift", "V/K", amplifier.offset_drift, drift)
    if amplifier.bias_current:
        yield figure("input bias current", "A", amplifier.bias_current, (plus + minus) / 2)
    if amplifier.offset_current:
        yield figure("input offset current", "A", amplifier.offset_current, plus - minus)
    sweep, figure = bench.run("opamp-input-impedance", FrequencySweep(1e-3, 1e6, 1))
    current = -sweep["vdrive#branch"]
    yield figure("input resistance", "ohm", amplifier.input_resistance, 1 / current[0].real)
    capacitance = current[-1].imag / (2 * np.pi * sweep.frequency[-1])
    yield figure("input capacitance", "F", amplifier.input_capacitance, capacitance)


def _large_step(bench: _Bench) -> Iterator[Figure]:
    amplifier = bench.amplifier
    # Long enough to slew over 10 V and to settle to 1 mV of it behind that.
    hold = max(10e-6, 15 / amplifier.slew_rate + _settling(amplifier))
    result, figure = bench.run("opamp-slew", Transient(2 * hold, hold / 2000), hold=hold)
    time = np.linspace(0, hold, 10_000, endpoint=False)
    up, down = result.at(time + 0.1 * hold, "out"), result.at(time + 1.1 * hold + 2e-9, "out")
    slew = min(
        8 / (_reaches(time, sign * out, 4) - _reaches(time, sign * out, -4))
        for sign, out in ((1, up), (-1, down))
    )
    yield figure("slew rate, 10 V step", "V/s", amplifier.slew_rate, slew)
    yield figure("full-power bandwidth, +-10 V", "Hz", 140e3, slew / (2 * np.pi * 10))
    for band, data_sheet, why, lowest in (
        (10e-3, 1.4e-6, "slew rate and two poles: no slow part after the slewing", -12.0),
        (
            1e-3,
            4.5e-6,
            "the slow tail of the real part (thermal, pole-zero pair) is not modelled",
            -72.0,
        ),
    ):
        outside = np.nonzero(np.abs(up - up[-1]) > band)[0]
        yield figure(
            f"settling to {band * 1e3:g} mV, 10 V step",
            "s",
            data_sheet,
            time[outside[-1]],
            why,
            lowest,
        )


def _small_step(bench: _Bench) -> Iterator[Figure]:
    hold = max(1.9e-6, 50e-3 / bench.amplifier.slew_rate + _settling(bench.amplifier))
    result, figure = bench.run("opamp-step", Transient(0.1e-6 + hold, hold / 1900))
    time = np.linspace(0, hold, 19_000, endpoint=False)
    out = result.at(time + 0.1e-6, "out") / 50e-3
    yield figure("overshoot, small step", "", 0.10, out.max() - 1)
    yield figure(
        "rise time, small step",
        "s",
        80e-9,
        _reaches(time, out, 0.9) - _reaches(time, out, 0.1),
        "with 10 % overshoot two poles at this gain-bandwidth cannot be as slow",
        -40.0,
    )


def _output(bench: _Bench) -> Iterator[Figure]:
    amplifier = bench.amplifier
    point, figure = bench.run("opamp-output", OperatingPoint())
    for name, unit, data_sheet, measured in (
        ("positive swing into 2 kohm", "V", amplifier.positive_swing, point["high"]),
        ("negative swing into 2 kohm", "V", -amplifier.negative_swing, point["low"]),
        ("source current limit", "A", amplifier.source_limit, point["vsource#branch"]),
        ("sink current limit", "A", amplifier.sink_limit, -point["vsink#branch"]),
    ):
        yield figure(name, unit, data_sheet, measured[0])
    if amplifier.supply_current:
        current = -point["vidle#branch"][0]
        yield figure("supply current", "A", amplifier.supply_current, current)
    sweep, figure = bench.run("opamp-output-resistance", FrequencySweep(1.0, 1e6, 1))
    yield figure("output resistance", "ohm", amplifier.output_resistance, abs(sweep["out"][0]))


def _noise(bench: _Bench) -> Iterator[Figure]:
    amplifier = bench.amplifier
    result, figure = bench.run("opamp-noise", Noise("out", "vdrive", 10.0, 1e5, 10))
    for name, frequency, data_sheet in (
        ("1 kHz", 1e3, amplifier.noise_1_kilohertz),
        ("10 kHz", 1e4, amplifier.noise_10_kilohertz),
    ):
        measured = np.interp(frequency, result.frequency, result.noise_density)
        yield figure(f"noise in 1 Hz at {name}", "V", data_sheet, measured)


def _settling(amplifier: OperationalAmplifier) -> float:
    """Return how long a follower takes, with room to spare, to settle to 1 part in 10^4 [s]."""
    return 20 / (2 * np.pi * amplifier.gain_bandwidth)


def _reaches(time: np.ndarray, rising: np.ndarray, level: float) -> float:
    """Return when a waveform first reaches a level; not a number when it never crosses it."""
    after = int(np.argmax(rising >= level))
    if after == 0:
        return np.nan
    return float(np.interp(level, rising[after - 1 : after + 1], time[after - 1 : after + 1]))
