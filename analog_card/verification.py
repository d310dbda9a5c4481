"""Comparing the netlist of a channel with its behavioural equivalent, stage by stage."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import netlists
from analog_card.analyses import FrequencySweep, Transient
from analog_card.behaviour import CardBehaviour, Imperfections
from analog_card.behaviour_elements import CHANNEL, LINK_OPEN
from analog_card.behaviour_model import run_behaviour, stage_responses
from analog_card.design import Design
from analog_card.design_file import load_design
from analog_card.differentiator import differentiator_pair
from analog_card.ngspice import run
from analog_card.waveforms import Waveforms

GAIN_LIMIT = 0.1  # dB, within the band
PHASE_LIMIT = 1.0  # degrees, within the band
TRANSIENT_LIMIT = 1.0  # per cent of the range of the waveform
BAND = (1.0, 20e3)  # Hz, where the limits hold
SWEEP = FrequencySweep(1.0, 100e3, 40)
# 2 us follow the comparator (1.1 us) and the slewing taps; 0.5 us change no figure by 0.1 %.
TRANSIENT = Transient(stop=12e-3, longest_step=2e-6)
GRID_STEP = 1e-6  # s, of the common time grid
# Behind the boundary-layer amplifier both sides switch over 30 V in 3 us, 1 % of it in 30 ns, and
# the solver's steps are 2 us: an edge there that comes this much earlier or later is no
# disagreement. Steps of 0.2 us leave 0.1 to 0.4 us: second pole and the way out of saturation.
EDGE_PLAY = 1e-6  # s
_SWITCHED = ("comparator", "clamped", "control")
# The largest tap of a case without overload, as a share of the smaller swing.
_USED_SWING = 0.7
# The movement that overloads both differentiators, as a share of the transducer's full scale.
_OVERLOAD = 0.3
_NODES = ("first", "second", "deviation", "rate", "surface", "comparator", "clamped", "control")
_OUTSIDE = ("transducer", "surface", "control")
_CHANNEL_AC = netlists.BENCHES / "channel-ac.cir"
_CHANNEL_TRANSIENT = netlists.BENCHES / "channel-transient.cir"
_SURFACE = netlists.BENCHES / "surface-amplifier.cir"


@dataclass(frozen=True)
class Deviation:
    """The worst disagreement in one quantity.

    Attributes
    ----------
    stage, quantity, unit : str
        What was compared; the quantity is ``gain``, ``phase`` or the name of a transient.
    band : str
        Where.
    worst : float
        Largest disagreement, without sign [unit].
    at : float
        Frequency [Hz] or time [s] of it.
    limit : float
        Largest disagreement allowed [unit].
    play : float
        How much earlier or later an edge may come for `worst` [s]; 0 when both sides were
        compared at the same times.
    without_play : float
        Largest disagreement at the same times [unit].
    """

    stage: str
    quantity: str
    unit: str
    band: str
    worst: float
    at: float
    limit: float
    play: float
    without_play: float

    @property
    def passed(self) -> bool:
        """Whether the disagreement is within its limit."""
        return bool(self.worst <= self.limit)


@dataclass(frozen=True)
class TransientComparison:
    """Both sides of one transient.

    Attributes
    ----------
    name : str
        What the transducer did.
    time : ndarray, shape (n,)
        [s].
    transducer : ndarray, shape (n,)
        [V].
    netlist, model : dict of str to ndarray
        Voltages by node, each of shape (n,) [V].
    """

    name: str
    time: np.ndarray
    transducer: np.ndarray
    netlist: dict[str, np.ndarray]
    model: dict[str, np.ndarray]

    def play(self, node: str) -> float:
        """Return how much earlier or later an edge may come at a node [s].

        `EDGE_PLAY` at the nodes that switch, as far as it is needed to be within the limit.
        """
        if node in _SWITCHED and self.deviation(node).max() > TRANSIENT_LIMIT:
            return EDGE_PLAY
        return 0.0

    def deviation(self, node: str, play: float = 0.0) -> np.ndarray:
        """Return how far the model is from the netlist over time [% of range].

        Parameters
        ----------
        node : str
            Its name.
        play : float, optional
            The model is compared with all that the netlist does this much earlier to this much
            later [s].

        Returns
        -------
        ndarray, shape (n,)
            Without sign.
        """
        netlist, model = self.netlist[node], self.model[node]
        reach = round(play / GRID_STEP)
        padded = np.pad(netlist, reach, mode="edge")
        near = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
        above, below = model - near.max(axis=1), near.min(axis=1) - model
        return 100 * np.maximum(np.maximum(above, below), 0) / np.ptp(netlist)


@dataclass(frozen=True)
class Verification:
    """What the comparison gave.

    Attributes
    ----------
    design : Design
        The card compared.
    deviations : tuple of Deviation
        The worst of each quantity.
    frequency : ndarray, shape (n,)
        [Hz].
    netlist_response, model_response : dict of str to ndarray
        Complex gain of each stage over frequency [V/V].
    transients : tuple of TransientComparison
        The cases compared over time.
    """

    design: Design
    deviations: tuple[Deviation, ...]
    frequency: np.ndarray
    netlist_response: dict[str, np.ndarray]
    model_response: dict[str, np.ndarray]
    transients: tuple[TransientComparison, ...]

    @property
    def passed(self) -> bool:
        """Whether every quantity is within its limit."""
        return all(deviation.passed for deviation in self.deviations)

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain values, for JSON."""
        rows = [{**asdict(item), "passed": item.passed} for item in self.deviations]
        return {"design": self.design.title, "passed": self.passed, "deviations": rows}

    def plot(self, axes: Sequence[Any]) -> Sequence[Any]:
        """Draw a summary: see `analog_card.verification_plot.plot_summary`."""
        from analog_card.verification_plot import plot_summary

        return plot_summary(self, axes)


def verify(
    design: Design | None = None,
    step: Callable[[str], None] = lambda what: None,
    imperfections: Imperfections | None = None,
) -> Verification:
    """Compare the netlist of a channel with its behavioural equivalent.

    Parameters
    ----------
    design : Design, optional
        The card; without it the recommended one.
    step : callable, optional
        Told what is being done, for a progress display.
    imperfections : Imperfections, optional
        What of the real card the model has; without it all. With some left out the deviations
        show what they are worth.

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
    Frequency response of every stage as it is loaded on the card, limits from 1 Hz to 20 kHz.
    Transients of every node: sine, triangle and step of the displacement scaled to the taps' swing,
    a movement that overloads both differentiators, and the relay. Behind the boundary-layer
    amplifier an edge may come up to 1 us earlier or later where it otherwise exceeds the limit; the
    deviation says so. Both sides get the same values, so this proves the model's equations, not
    the figures.

    Examples
    --------
    >>> verify().passed
    True
    """
    design = design or load_design()
    with_ = imperfections or Imperfections()
    step("frequency response")
    frequency, responses = _netlist_responses(design)
    modelled = stage_responses(CardBehaviour(design, imperfections=with_), frequency)
    cases = []
    for name, changes in transient_cases(design).items():
        step(name)
        cases.append(_compared(name, changes, design, with_))
    deviations = (
        *_response_deviations(frequency, responses, modelled),
        *(item for case in cases for item in _transient_deviations(case)),
    )
    return Verification(design, deviations, frequency, responses, modelled, tuple(cases))


def transient_cases(design: Design) -> dict[str, dict[str, float]]:
    """Return the parameters of the transient bench for each case.

    Parameters
    ----------
    design : Design
        The card, whose swing decides the amplitudes.
    """
    quiet = {"rest": design.transducer.full_scale_voltage / 2}
    quiet |= dict.fromkeys(("sine_amplitude", "triangle_amplitude", "step_height"), 0.0)
    start, rise, frequency, period = 1e-3, 50e-6, 150.0, 10e-3
    time = np.arange(0, TRANSIENT.stop, 2 * GRID_STEP)
    since = np.maximum(time - start, 0)
    phase = (since / period) % 1
    unit = {
        "sine_amplitude": np.sin(2 * np.pi * frequency * since),
        "triangle_amplitude": 1 - 4 * np.abs(phase - 0.5),
        "step_height": np.minimum(since / rise, 1),
    }
    amplitudes = {name: _amplitude(design, time, wave) for name, wave in unit.items()}
    sine = {**quiet, "sine_amplitude": amplitudes["sine_amplitude"], "sine_frequency": frequency}
    return {
        "sine": sine,
        "triangle": {
            **quiet,
            "triangle_amplitude": amplitudes["triangle_amplitude"],
            "triangle_period": period,
        },
        "step": {**quiet, "step_height": amplitudes["step_height"], "step_rise": rise},
        "overload": {
            **quiet,
            "step_height": _OVERLOAD * design.transducer.full_scale_voltage,
            "step_rise": 1e-3,
        },
        "relay": {**sine, "boundary_layer_link": LINK_OPEN},
    }


def _amplitude(design: Design, time: np.ndarray, wave: np.ndarray) -> float:
    taps = differentiator_pair(design).transient(time, wave)
    amplifier = design.soldered.operational_amplifier
    swing = min(amplifier.positive_swing, amplifier.negative_swing)
    return float(_USED_SWING * swing / max(np.abs(tap).max() for tap in taps))


def _netlist_responses(design: Design) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    parameters = design.netlist_parameters()
    rest = {"rest": design.transducer.full_scale_voltage / 2}
    channel = run(_CHANNEL_AC, SWEEP, parameters | rest)
    demand = run(
        _CHANNEL_AC, SWEEP, parameters | rest | {"from_transducer": 0.0, "from_demand": 1.0}
    )
    surface = run(_SURFACE, SWEEP, parameters)

    def inside(name: str, source: Waveforms = channel) -> np.ndarray:
        return source[name if name in _OUTSIDE else f"{CHANNEL}.{name}"]

    return channel.frequency, {
        "buffer": inside("displacement") / inside("transducer"),
        "first": inside("first") / inside("displacement"),
        "second": inside("second") / inside("first"),
        "difference from displacement": inside("deviation") / inside("displacement"),
        "difference from demand": inside("deviation", demand) / inside("wanted", demand),
        "inverter": inside("rate") / inside("first"),
        "surface from deviation": surface["deviation"],
        "surface from rate": surface["velocity"],
        "surface from acceleration": surface["acceleration"],
        "boundary layer": inside("comparator") / inside("surface"),
        "limiter": inside("clamped") / inside("comparator"),
        "control": inside("control") / inside("clamped"),
    }


def _compared(
    name: str, changes: Mapping[str, float], design: Design, with_: Imperfections
) -> TransientComparison:
    places = {node: node if node in _OUTSIDE else f"{CHANNEL}.{node}" for node in _NODES}
    found = run(
        _CHANNEL_TRANSIENT,
        TRANSIENT,
        {**design.netlist_parameters(), **changes},
        save=["transducer", *places.values()],
    )
    time = np.arange(round(TRANSIENT.stop / GRID_STEP) + 1) * GRID_STEP
    transducer = found.at(time, "transducer")
    relay = "boundary_layer_link" in changes
    model = run_behaviour(
        CardBehaviour(design, imperfections=with_, relay=relay),
        time,
        transducer,
        np.full(len(time), changes["rest"]),
    )
    return TransientComparison(
        name,
        time,
        transducer,
        {node: found.at(time, place) for node, place in places.items()},
        {node: model[node] for node in _NODES},
    )


def _response_deviations(
    frequency: np.ndarray, netlist: Mapping[str, np.ndarray], model: Mapping[str, np.ndarray]
) -> list[Deviation]:
    # Whichever way the last point of the band was rounded, it is in it.
    within = (frequency >= BAND[0] * (1 - 1e-9)) & (frequency <= BAND[1] * (1 + 1e-9))
    band = f"{BAND[0]:g} Hz–{BAND[1] / 1e3:g} kHz"
    found = []
    for stage in netlist:
        ratio = (netlist[stage] / model[stage])[within]
        for quantity, unit, values, limit in (
            ("gain", "dB", decibel(ratio), GAIN_LIMIT),
            ("phase", "degree", np.angle(ratio, deg=True), PHASE_LIMIT),
        ):
            worst, place = _worst(values)
            at = float(frequency[within][place])
            found.append(Deviation(stage, quantity, unit, band, worst, at, limit, 0.0, worst))
    return found


def _transient_deviations(case: TransientComparison) -> list[Deviation]:
    band = f"0–{case.time[-1] * 1e3:g} ms"
    found = []
    for node in _NODES:
        play = case.play(node)
        worst, place = _worst(case.deviation(node, play))
        without, _ = _worst(case.deviation(node))
        at = float(case.time[place])
        found.append(
            Deviation(
                node, case.name, "% of range", band, worst, at, TRANSIENT_LIMIT, play, without
            )
        )
    return found


def _worst(values: np.ndarray) -> tuple[float, int]:
    place = int(np.argmax(np.abs(values)))
    return float(abs(values[place])), place


def decibel(ratio: np.ndarray) -> np.ndarray:
    """Return a ratio of voltages in decibel."""
    return 20 * np.log10(np.abs(ratio))
