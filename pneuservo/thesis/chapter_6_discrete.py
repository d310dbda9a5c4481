"""Section 6.13.2 of the thesis: discrete sliding mode against the continuous law, sampled."""

from collections.abc import Iterator
from dataclasses import replace

from pneuservo.controllers import DigitalSlidingMode, DiscreteSlidingMode
from pneuservo.linear import advanced_servo, servo_data
from pneuservo.rigs import load_rig
from pneuservo.thesis.chapter_9_loops import MID_STROKE, holds, mean_of, step_run
from pneuservo.thesis.rows import Row
from pneuservo.thesis.statements import Finding, statement_row

_SLOW = 2e-3
_HEAVY = 11.82


def discrete_rows() -> Iterator[Row]:
    """Yield what is said of discrete sliding mode, beside ours."""
    continuous = DigitalSlidingMode(accelerometer=True, sampling_time=_SLOW)
    discrete = DiscreteSlidingMode(sampling_time=_SLOW)
    chatter = {
        (kind, layer): 1e3 * mean_of(holds(step_run(replace(law, boundary_layer=layer))), "chatter")
        for kind, law in (("discrete", discrete), ("continuous", continuous))
        for layer in (0.0, 5.0)
    }
    yield statement_row(
        "6.13.2-better",
        "discrete sliding mode against the continuous law, both sampled every 2 ms",
        "significantly better at low sampling rates",
        Finding(
            all(
                chatter["discrete", layer] < 0.5 * chatter["continuous", layer]
                for layer in (0.0, 5.0)
            ),
            f"{chatter['discrete', 0.0]:.2f} mm against {chatter['continuous', 0.0]:.2f} mm peak "
            f"to peak as relays, {chatter['discrete', 5.0]:.2f} against "
            f"{chatter['continuous', 5.0]:.2f} mm with a boundary layer",
        ),
        "section 6.13.2",
    )
    # The model stays that of the nominal mass.
    data = servo_data(load_rig("single-axis"))
    model = advanced_servo(data, 0.5 * data.stroke, extending=True)
    heavy = {
        kind: step_run(law, _HEAVY)
        for kind, law in (("discrete", replace(discrete, servo=model)), ("continuous", continuous))
    }
    overshoot = {kind: 100.0 * run.step_responses()[-1].overshoot for kind, run in heavy.items()}
    slow = {kind: 1e3 * holds(run)[MID_STROKE].chatter for kind, run in heavy.items()}
    yield statement_row(
        "6.13.2-robust",
        f"discrete sliding mode against the continuous law, {_HEAVY:g} kg, its model of 1.82 kg",
        "not as robust to changes of parameters",
        Finding(
            overshoot["discrete"] > 2.0 * overshoot["continuous"] + 1.0,
            f"overshoot {overshoot['discrete']:.0f} % against {overshoot['continuous']:.0f} %, "
            f"{slow['discrete']:.2f} mm against {slow['continuous']:.2f} mm still moving after "
            "0.3 s",
        ),
        "section 6.13.2",
    )
