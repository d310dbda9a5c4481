"""The pictures of a diagnosis."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from pneuservo.diagnosis import Diagnosis
from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.models import Case
from pneuservo.diagnosis.unexplained import Unexplained, smoothed
from pneuservo.diagnosis.unknowns import values_in
from pneuservo.intervals import INTERVAL
from pneuservo.report.svg import BASELINE, GUILTY, MEASURED, REPAIRED, draw
from pneuservo.report.words import UNITS
from pneuservo.thinning import thinned

_FITS = (("baseline, re-fitted", BASELINE), ("repaired", REPAIRED))
_CLOSE = 5.0
"""Residuals within this factor of the noise are drawn on a linear axis."""
_CLEARLY = 2.0
"""Forces at rest that are off by so many times what they may be are clearly wrong."""
_CHAINS = {
    "dead-volume": ("supply", "valve.flow", "dead-volume", "sensor.pressure"),
    "seal-tester": ("chamber.a", "piston", "load"),
    "circuit": ("circuit",),
    "analogue-card": ("card.differentiator", "card.surface", "card.boundary-layer", "card.relay"),
    "single-axis": (
        "supply",
        "valve.spool",
        "valve.flow",
        "chamber.a",
        "chamber.b",
        "piston",
        "load",
    ),
}


def diagnosis_figures(diagnosis: Diagnosis, answer: dict[str, Any]) -> dict[str, Any]:
    """Return the pictures of a diagnosis as SVG text.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.
    answer : dict
        Its document.

    Returns
    -------
    dict
        ``curves``: a list of (title, svg); ``blocks``, ``rivals`` and ``table``: svg, the last two
        None when there is nothing to compare and nothing without a name.
    """
    search = diagnosis.search
    fits = (search.baseline, diagnosis.repaired)
    worst = _worst(search.cases, search.baseline)
    shown = [("used", worst, search.cases[worst], *fits)]
    if diagnosis.before_held_back and diagnosis.after_held_back:
        pair = (diagnosis.before_held_back, diagnosis.after_held_back)
        channel = search.cases[worst].channel
        judged = [case.channel for case in diagnosis.held_back]
        same = judged.index(channel) if channel in judged else 0
        shown.append(("held back", same, diagnosis.held_back[same], *pair))
    curves = [
        (
            f"{case.recording.title or case.recording.name} ({role})",
            draw(
                _curves, diagnosis, case, (before, after), index,
                size=(9.0, 5.2), shape=(2, 1), ratios=(1.2, 1.0),
            ),
        )
        for role, index, case, before, after in shown
    ]  # fmt: skip
    at_rest = _mended_at_rest(search.cases, *fits)
    if at_rest is not None:
        case = search.cases[at_rest]
        picture = draw(_forces_at_rest, diagnosis, case, fits, at_rest, size=(9.0, 3.6))
        curves.insert(0, (_at_rest_in_words(case, fits, at_rest), picture))
    alone = search.ledger[0].rms if search.ledger else {}
    rivals = None
    if alone:
        rivals = draw(_rivals, diagnosis, alone, size=(9.0, 0.9 + 0.3 * (len(alone) + 2)))
    table = None
    if diagnosis.unexplained is not None:
        table = draw(_table, diagnosis.unexplained, size=(7.0, 3.2))
    return {
        "curves": curves,
        "table": table,
        "blocks": draw(_blocks, diagnosis.rig.kind, answer, size=(9.0, 1.5)),
        "rivals": rivals,
    }


def _worst(cases: Sequence[Case], baseline: Fit) -> int:
    """Return the recorded case of which the baseline leaves most."""
    there = zip(cases, baseline.residuals, strict=True)
    return int(np.argmax([float(np.mean(r**2)) if c.recorded else 0.0 for c, r in there]))


def _mended_at_rest(cases: Sequence[Case], before: Fit, after: Fit) -> int | None:
    """Return the case of forces at rest that gained more than any that was recorded, if any."""
    there = zip(before.residuals, after.residuals, strict=True)
    gains = [float(np.sum(b**2) - np.sum(a**2)) for b, a in there]
    most = int(np.argmax(gains))
    return None if cases[most].recorded else most


def _at_rest_in_words(case: Case, fits: tuple[Fit, Fit], index: int) -> str:
    before, after = (_clearly_off(found.residuals[index]) for found in fits)
    return (
        f"{case.recording.title or case.recording.name} (used): the piston rests under a force, or "
        f"breaks away at one, that is clearly not what friction can hold at {before} of "
        f"{np.count_nonzero(case.usable)} moments in the re-fitted baseline, at {after} repaired"
    )


def _clearly_off(residual: Any) -> int:
    """Return at how many moments the force is off by more than it may be wrong by."""
    return int(np.count_nonzero(np.abs(residual) > _CLEARLY))


def _forces_at_rest(
    axes: Any, diagnosis: Diagnosis, case: Case, fits: tuple[Fit, Fit], index: int
) -> None:
    first, judged = diagnosis.search.cases[0], case.usable
    time = case.recording.time[judged]
    for found, (label, colour) in zip(fits, _FITS, strict=True):
        values = values_in(case, first, found.shared, found.own[index])
        force, holding = diagnosis.model.forces_at_rest(case, values)[:, judged]
        axes.scatter(
            time, holding, marker="_", s=90, lw=2.0, color=colour, label=f"held at most, {label}"
        )
    gone = diagnosis.model.breaks_away(case)[judged]
    for there, marker, size, label in (
        (~gone, "o", 14, "force on the piston"),
        (gone, "^", 30, "... at which it breaks away"),
    ):
        dots = time[there], np.abs(force[there])
        axes.scatter(*dots, s=size, marker=marker, color=MEASURED, zorder=3, label=label)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("force at rest [N]")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def _curves(axes: Any, diagnosis: Diagnosis, case: Case, fits: tuple[Fit, Fit], index: int) -> None:
    above, below = axes
    factor, unit = _shown(case.unit)
    scale = factor * case.scale
    name = case.channel.replace("_", " ")
    window = diagnosis.model.closeup(case)
    time = case.recording.time
    above.plot(
        *thinned(time[window], case.measured[window] * scale),
        color=MEASURED,
        lw=2.2,
        label="measured",
    )
    repaired = diagnosis.search.accepted or diagnosis.unexplained is not None
    for found, (label, colour) in zip(fits, _FITS, strict=True):
        if label == "repaired" and not repaired:
            continue
        first = diagnosis.search.cases[0]
        values = values_in(case, first, found.shared, found.own[index])
        model = diagnosis.model.predict(case, values)
        above.plot(*thinned(time[window], model[window] * scale), color=colour, label=label)
        residual = np.where(case.usable, case.measured - model, np.nan) * scale
        below.plot(*thinned(time, residual), color=colour, lw=0.8, alpha=0.8)
    noise = diagnosis.search.noise_rms * scale
    if repaired:
        # What is left after the repair has to be seen; the baseline may leave the frame.
        reach = max(6.0 * noise, 1.1 * float(np.nanquantile(np.abs(residual), 0.999)))
        below.set_ylim(-reach, reach)
    below.axhspan(-2.0 * noise, 2.0 * noise, color="#bbbbbb", alpha=0.6, label="noise, ±2 rms")
    if len(time[window]) == len(time):
        below.set_xlim(above.get_xlim())
    above.set_ylabel(f"{name} [{unit}]")
    below.set_ylabel(f"left over [{unit}]")
    below.set_xlabel("time [s]")
    above.legend(loc="best", ncols=3)
    below.legend(loc="upper right")


def _shown(unit: str) -> tuple[float, str]:
    """Return the scale and the name of a unit along an axis, where what has none is a share."""
    return (UNITS | {"": (100.0, "%")}).get(unit, (1.0, unit))


def _with_all(chain: Sequence[str], blocks: Iterable[str]) -> list[str]:
    """Return a chain with some more blocks: hoses lie behind the valve, transducers at the end."""
    found = list(chain)
    for block in blocks:
        if block not in found:
            behind_valve = block == "lines" and "valve.flow" in found
            found.insert(found.index("valve.flow") + 1 if behind_valve else len(found), block)
    return found


def _blocks(axes: Any, kind: str, answer: dict[str, Any]) -> None:
    from matplotlib.patches import FancyBboxPatch

    share = {entry["block"]: entry["share"] for entry in answer["located"]}
    chain = _with_all(_CHAINS[kind], share)
    ends = {"circuit": ("input", "output")}.get(kind, ("", ""))
    for place, block in enumerate(chain):
        guilty = share.get(block, 0.0)
        face = GUILTY if guilty >= 0.2 else "#f3d3cf" if guilty > 0.0 else "#eef1f4"
        ink = "white" if guilty >= 0.2 else "#333333"
        box = FancyBboxPatch(
            (place * 1.5, 0.0),
            1.1,
            0.6,
            boxstyle="round,pad=0.02",
            facecolor=face,
            edgecolor="#8a8f94",
        )
        axes.add_patch(box)
        share_of = "" if len(chain) > 5 else " of the mismatch"
        # The boxes of a long chain are narrow.
        name = block.replace(".", ".\n") if len(chain) > 5 else block
        label = f"{name}\n{guilty:.0%}{share_of}" if guilty else name
        axes.text(
            place * 1.5 + 0.55,
            0.3,
            label,
            ha="center",
            va="center",
            color=ink,
            fontsize=9 if len(chain) < 8 else 7,
        )
        if place:
            axes.annotate(
                "",
                (place * 1.5 - 0.02, 0.3),
                (place * 1.5 - 0.38, 0.3),
                arrowprops={"arrowstyle": "->", "color": "#8a8f94"},
            )
    right = (len(chain) - 1) * 1.5 + 1.1
    for text, x in zip(ends, (-0.1, right + 0.1), strict=True):
        axes.text(x, 0.3, text, ha="right" if x < 0 else "left", va="center", color="#333333")
    axes.set(xlim=(-0.5, right + 0.5), ylim=(-0.1, 0.7))
    axes.axis("off")


def _table(axes: Any, found: Unexplained) -> None:
    scale, unit = _shown(found.table.unit_of_quantity)
    knots = found.knots * scale
    axes.axhline(0.0, color="#8a8f94", lw=0.8)
    axes.plot(knots, smoothed(found.knots, found.values, found.spread), color=REPAIRED, lw=2.0)
    axes.errorbar(
        knots, found.values, INTERVAL * found.spread, fmt="o", color=MEASURED, ms=4, capsize=3
    )
    axes.set_xlabel(f"{found.table.quantity} [{unit or '-'}]")
    axes.set_ylabel(f"{found.table.what} [{found.table.unit or '-'}]")


def _rivals(axes: Any, diagnosis: Diagnosis, alone: Mapping[str, float]) -> None:
    search = diagnosis.search
    scale, unit = _shown(diagnosis.model.unit)
    if search.model.steady:
        # Several channels, each in units of its noise.
        scale, unit = 1.0, "noise"
    rows = [("baseline, re-fitted", search.baseline.rms, BASELINE)]
    for name, rms in sorted(alone.items(), key=lambda item: -item[1]):
        rows.append((name, rms, REPAIRED if name in search.accepted else "#aab4bd"))
    if len(search.accepted) > 1:
        rows.append((" + ".join(search.accepted), search.chosen.rms, REPAIRED))
    places = np.arange(len(rows))[::-1]
    # No bars: on an axis without zero their lengths would mean nothing.
    left, colours = [rms * scale for _, rms, _ in rows], [colour for *_, colour in rows]
    noise = search.noise_rms * scale
    axes.hlines(places, noise, left, color=colours, lw=2.0)
    axes.scatter(left, places, color=colours, s=60, zorder=3)
    axes.axvline(noise, color=MEASURED, lw=1.0, ls="--", label="noise")
    axes.set_yticks(places, [name for name, *_ in rows])
    if max(left) >= _CLOSE * noise:
        # Closer together the marks of a logarithmic axis would lie on top of each other.
        axes.set_xscale("log")
    axes.set_ylim(-0.6, places[0] + 0.6)
    axes.set_xlabel(f"left over, root mean square [{unit}]")
    axes.grid(axis="y", visible=False)
    axes.legend(loc="lower right")
