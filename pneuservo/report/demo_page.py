"""The page of the main job."""

from typing import Any

import numpy as np

from analog_card.verification import decibel
from pneuservo.demo import Demo
from pneuservo.report.page import diagnosis_content, render
from pneuservo.report.svg import BASELINE, MEASURED, REPAIRED, draw
from pneuservo.thinning import thinned


def demo_page(demo: Demo, answer: dict[str, Any]) -> str:
    """Return the report of the main job as one HTML page.

    Parameters
    ----------
    demo : Demo
        Its results.
    answer : dict
        The document of its diagnosis.

    Returns
    -------
    str
        HTML with inline pictures; it needs no network.
    """
    return render(
        "demo_page.html",
        demo=demo,
        steps=demo.loop.step_responses(),
        netlist_rows=_worst_of_each(demo.verification),
        sweep=_differentiators_over_the_sweep(demo.verification),
        netlist_figure=draw(_netlist, demo.verification, size=(9.0, 6.0), shape=(2, 2)),
        loop_figure=loop_picture(demo),
        **diagnosis_content(demo.diagnosis, answer),
    )


def loop_picture(demo: Demo) -> str:
    """Return the picture of the closed loop as SVG text.

    Parameters
    ----------
    demo : Demo
        Results of the main job.

    Returns
    -------
    str
        Displacement, valve voltage and pressures over time.
    """
    return draw(_loop, demo.loop, size=(9.0, 5.6), shape=(3, 1), ratios=(2.0, 1.0, 1.0))


def _worst_of_each(verification: Any) -> list[Any]:
    """Return the worst deviation of each quantity, whatever the stage."""
    worst: dict[str, Any] = {}
    for deviation in verification.deviations:
        if deviation.worst > getattr(worst.get(deviation.quantity), "worst", -1.0):
            worst[deviation.quantity] = deviation
    return list(worst.values())


def _differentiators_over_the_sweep(verification: Any) -> dict[str, float]:
    """Return the worst deviation of both differentiators over all frequencies [dB], [degree]."""
    ratios = np.concatenate(
        [
            verification.netlist_response[stage] / verification.model_response[stage]
            for stage in ("first", "second")
        ]
    )
    return {
        "gain": float(np.max(np.abs(decibel(ratios)))),
        "phase": float(np.max(np.abs(np.angle(ratios, deg=True)))),
        "from": float(verification.frequency[0]),
        "to": float(verification.frequency[-1]),
    }


def _netlist(axes: Any, verification: Any) -> None:
    verification.plot(axes)


def _loop(axes: Any, loop: Any) -> None:
    displacement, voltage, pressure = axes
    time = loop.time
    displacement.plot(time, loop["demand"] * 1e3, color=MEASURED, ls="--", lw=1.0, label="demand")
    displacement.plot(
        *thinned(time, loop["displacement"] * 1e3), color=REPAIRED, label="displacement"
    )
    displacement.set_ylabel("displacement [mm]")
    displacement.legend(loc="upper right", ncols=2)
    voltage.plot(*thinned(time, loop["valve_voltage"]), color=REPAIRED, lw=0.8)
    voltage.set_ylabel("valve [V]")
    for name, colour in (("pressure_a", REPAIRED), ("pressure_b", BASELINE)):
        pressure.plot(*thinned(time, loop[name] * 1e-5), color=colour, label=name.replace("_", " "))
    pressure.set_ylabel("pressure [bar]")
    pressure.set_xlabel("time [s]")
    pressure.legend(loc="upper right", ncols=2)
