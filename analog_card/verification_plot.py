"""Pictures of the comparison of netlist and behavioural equivalent."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from analog_card.verification import TransientComparison, Verification

# Below these the simulator's own rounding is seen.
_LEAST_DECIBEL, _LEAST_DEGREE, _LEAST_PER_CENT = 1e-5, 1e-4, 1e-4
_SHOWN = ("first", "second", "control")
_SUMMARY_CASE = "overload"


def plot_summary(verification: "Verification", axes: Sequence[Any]) -> Sequence[Any]:
    """Draw gains, their deviations, one transient and the deviations of all.

    Parameters
    ----------
    verification : Verification
        The comparison.
    axes : sequence of four matplotlib Axes
        For gains, deviation over frequency, the overload over time, worst deviations.

    Returns
    -------
    sequence of four matplotlib Axes
        The same.
    """
    gains, deviations, waveforms, worst = axes
    plot_gains(verification, gains)
    plot_response_deviations(verification, deviations)
    case = next(item for item in verification.transients if item.name == _SUMMARY_CASE)
    plot_transient(case, waveforms)
    plot_worst(verification, worst)
    return axes


def plot_gains(verification: "Verification", axis: Any) -> Any:
    """Draw the gain of every stage over frequency, netlist and model; return the axis."""
    for stage, colour in _colours(verification).items():
        gain = verification.netlist_response[stage]
        axis.semilogx(verification.frequency, _decibel(gain), color=colour, label=stage)
        axis.semilogx(verification.frequency, _decibel(verification.model_response[stage]), "k:")
    axis.plot([], [], "k:", label="behavioural model")
    # Room for the legend above the curves.
    bottom, top = axis.get_ylim()
    axis.set_ylim(bottom, top + 0.7 * (top - bottom))
    return _labelled(axis, "frequency [Hz]", "gain of a stage [dB]", "upper left", columns=2)


def plot_response_deviations(verification: "Verification", axis: Any) -> Any:
    """Draw the deviations of every stage over frequency with their limits; return the axis."""
    from analog_card.verification import BAND, GAIN_LIMIT, PHASE_LIMIT

    for stage, colour in _colours(verification).items():
        ratio = verification.netlist_response[stage] / verification.model_response[stage]
        decibel = np.maximum(np.abs(_decibel(ratio)), _LEAST_DECIBEL)
        axis.loglog(verification.frequency, decibel, color=colour)
        phase = np.maximum(np.abs(np.angle(ratio, deg=True)), _LEAST_DEGREE)
        axis.loglog(verification.frequency, phase, color=colour, linestyle="--")
    axis.plot([], [], "k", label="gain [dB]")
    axis.plot([], [], "k--", label="phase [degree]")
    for limit, style, name in ((GAIN_LIMIT, "-", "gain"), (PHASE_LIMIT, "--", "phase")):
        axis.plot(BAND, [limit, limit], "grey", linestyle=style, linewidth=2.5)
        axis.text(BAND[0] * 1.2, limit * 1.2, f"limit, {name}", color="grey", size="small")
    axis.set_ylim(top=10)
    return _labelled(axis, "frequency [Hz]", "netlist against model", place="center left")


def _colours(verification: "Verification") -> dict[str, tuple[float, ...]]:
    """Return a colour of its own for every stage; the default cycle repeats after ten."""
    from matplotlib import colormaps

    stages = list(verification.netlist_response)
    shades = colormaps["turbo"](np.linspace(0.05, 0.95, len(stages)))
    return dict(zip(stages, map(tuple, shades), strict=True))


def plot_transient(case: "TransientComparison", axis: Any) -> Any:
    """Draw taps and control voltage of one case, netlist and model; return the axis."""
    for number, node in enumerate(_SHOWN):
        axis.plot(case.time * 1e3, case.netlist[node], f"C{number}", label=f"{node}, netlist")
        axis.plot(case.time * 1e3, case.model[node], "k:")
    axis.plot([], [], "k:", label="behavioural model")
    axis.set_title(case.name, loc="left", size="medium")
    return _labelled(axis, "time [ms]", "voltage [V]", place="lower right")


def plot_transient_deviation(case: "TransientComparison", axis: Any) -> Any:
    """Draw the deviations of all nodes in one case with their limit; return the axis."""
    from analog_card.verification import TRANSIENT_LIMIT

    for number, node in enumerate(case.netlist):
        play = case.play(node)
        deviation = np.maximum(case.deviation(node, play), _LEAST_PER_CENT)
        label = f"{node}, edges ±{play * 1e6:g} µs" if play else node
        axis.semilogy(case.time * 1e3, deviation, f"C{number}", linewidth=0.8, label=label)
    axis.axhline(TRANSIENT_LIMIT, color="grey", linewidth=2.5)
    axis.set_ylim(_LEAST_PER_CENT, 100)
    axis.set_title(case.name, loc="left", size="medium")
    return _labelled(axis, "time [ms]", "deviation [% of range]", place="upper right", columns=3)


def plot_worst(verification: "Verification", axis: Any) -> Any:
    """Draw the worst deviation of each quantity as a share of its limit; return the axis."""
    quantities = list(dict.fromkeys(item.quantity for item in verification.deviations))
    shares = [
        max(
            100 * item.worst / item.limit
            for item in verification.deviations
            if item.quantity == quantity
        )
        for quantity in quantities
    ]
    axis.barh(quantities, shares, color="C0")
    axis.axvline(100, color="grey", linewidth=2.5)
    axis.invert_yaxis()
    axis.set_xlabel("worst deviation [% of its limit]")
    axis.set_ylabel("what was compared")
    axis.grid(True, alpha=0.3)
    return axis


def picture(verification: "Verification") -> bytes:
    """Return the whole comparison as a PNG."""
    from io import BytesIO

    from matplotlib.figure import Figure

    cases = verification.transients
    figure = Figure(figsize=(12, 4 + 3.2 * len(cases)), layout="constrained")
    axes = figure.subplots(1 + len(cases), 2)
    plot_gains(verification, axes[0, 0])
    plot_response_deviations(verification, axes[0, 1])
    for case, (left, right) in zip(cases, axes[1:], strict=True):
        plot_transient(case, left)
        plot_transient_deviation(case, right)
    title = verification.design.title
    figure.suptitle(f"Netlist against behavioural model: {title}", parse_math=False)
    stream = BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()


def _decibel(ratio: np.ndarray) -> np.ndarray:
    return 20 * np.log10(np.abs(ratio))


def _labelled(
    axis: Any, horizontal: str, vertical: str, place: str = "best", columns: int = 1
) -> Any:
    axis.set_xlabel(horizontal)
    axis.set_ylabel(vertical)
    axis.grid(True, alpha=0.3)
    axis.legend(fontsize="x-small", loc=place, ncols=columns)
    return axis
