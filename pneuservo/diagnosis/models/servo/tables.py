"""Tables over what was recorded of a servo, for what no effect explains."""

from collections.abc import Sequence

import numpy as np

from pneuservo.diagnosis.models.model import Case, Table
from pneuservo.diagnosis.models.servo.feed import Array, Feed
from pneuservo.effects import Effect
from pneuservo.effects.unexplained import EFFECTS
from pneuservo.plant.servo.unexplained_effects import QUANTITIES
from pneuservo.rigs import Rig

_OUTERMOST = 0.5
"""Percentile of a quantity at the first knot, and from above at the last."""
_WANDER = 1.0
"""The zeros of the pressure transducers may wander by as much as their noise."""
_OF_THE_PISTON = ("displacement", "velocity")
_UNITS = ("m", "m", "m", "m/s", "Pa", "Pa", "", "s", "Pa")


def tables_of(cases: Sequence[Case]) -> list[Table]:
    """Return a table per place where something may act and per quantity it may depend on.

    Parameters
    ----------
    cases : sequence of Case
        Recordings of one servo.

    Returns
    -------
    list of Table
        Between what was nearly the lowest and the highest of each quantity.
    """
    feeds: dict[int, tuple[Feed, Rig]] = {id(c.recording): (c.inputs["feed"], c.rig) for c in cases}
    recorded = [_quantities(fed, rig) for fed, rig in feeds.values()]
    wander = _WANDER * max(fed.spread_of_force for fed, _ in feeds.values())
    found = []
    for over, (quantity, unit) in enumerate(zip(QUANTITIES, _UNITS, strict=True)):
        values = np.concatenate([each[over] for each in recorded])
        low, high = (float(v) for v in np.percentile(values, [_OUTERMOST, 100.0 - _OUTERMOST]))
        if not high > low:
            continue
        for effect in EFFECTS:
            knots = tuple(effect.key(p.name) for p in effect.parameters if p.name[0] == "v")
            size = effect.parameters[0]
            found.append(
                Table(
                    effect.id,
                    _block(effect, quantity),
                    size.meaning.partition(" at knot")[0],
                    size.unit,
                    quantity.replace("_", " in chamber "),
                    unit,
                    {
                        effect.key("over"): float(over),
                        effect.key("low"): low,
                        effect.key("high"): high,
                    },
                    effect.key("low"),
                    effect.key("high"),
                    knots,
                    size.starts[0],
                    wander if size.unit == "N" else 0.0,
                )
            )
    return found


def _block(effect: Effect, quantity: str) -> str:
    """Return where something acts that depends on a quantity.

    What a chamber does goes by where the piston is and how fast; a flow that goes by anything
    else comes through the valve. A force that goes by time alone is the load's.
    """
    size = effect.parameters[0]
    if size.unit == "N":
        return "load" if quantity == "time" else effect.block
    return effect.block if quantity.startswith(_OF_THE_PISTON) else "valve.flow"


def _quantities(fed: Feed, rig: Rig) -> list[Array]:
    """Return the quantities that a table may be over, in their order."""
    displacement, velocity, _ = fed.motion
    pressure_a, pressure_b = fed.pressures
    opening = np.clip(fed.voltage / rig["valve.full_voltage"], -1.0, 1.0)
    return [
        displacement,
        displacement,
        displacement,
        velocity,
        pressure_a,
        pressure_b,
        opening,
        fed.time,
        pressure_a - pressure_b,
    ]
