"""Tables over what was recorded of a servo, for what no effect explains."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.models.model import Case, Table
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.effects import Effect
from pneuservo.effects.supply import SLOW_DRIFT
from pneuservo.effects.unexplained import DRIFT, FLOW_A, FLOW_B, FORCE
from pneuservo.plant.servo.drift import DRIFTING
from pneuservo.plant.servo.unexplained_effects import QUANTITIES
from pneuservo.rigs import Rig

_OUTERMOST = 0.5
"""Percentile of a quantity at the first knot, and from above at the last."""
_WANDER = 1.0
"""The zeros of the pressure transducers may wander by as much as their noise."""
_LEAST_GAIN, _LEAST_GAIN_OVER_TIME = 900.0, 300.0
"""Of a table: in 13 pairs of quiet recordings without any effect the best reached 416 by more than
four times what imitations pretend, a force over the way in one direction; over time none 45, and
205 in a pair of another simulator whose piston creeps."""
_OF_THE_PISTON = ("displacement", "velocity")
_UNITS = ("m", "m", "m", "m/s", "Pa", "Pa", "", "s", "Pa")
_LEAST_DRIFT = 2e-3
"""Share of a parameter by which it has to vary: less is within what calibrations repeat ..."""
_LEAST_DRIFT_OF_SUPPLY = 5e-4
"""... but a supply's pressure may be read beside it."""
_DRIFTS = (
    ("load", _LEAST_DRIFT, ""),
    ("piston", _LEAST_DRIFT, ""),
    ("valve.flow", _LEAST_DRIFT, ""),
    ("valve.flow", _LEAST_DRIFT, ""),
    ("sensor.displacement", _LEAST_DRIFT, ""),
    ("sensor.displacement", _LEAST_DRIFT, ""),
    ("supply", _LEAST_DRIFT_OF_SUPPLY, SLOW_DRIFT.id),
)
"""Where the parameters of `DRIFTING` belong, by what they vary at least, and which effect of the
catalogue does that, if one does."""


def tables_of(cases: Sequence[Case]) -> list[Table]:
    """Return a table per place and quantity it may depend on, and per parameter that may drift.

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
    recorded = [quantities_of(fed, rig) for fed, rig in feeds.values()]
    wander = _WANDER * max(fed.spread_of_force for fed, _ in feeds.values())
    found = []
    for over, (quantity, unit) in enumerate(zip(QUANTITIES, _UNITS, strict=True)):
        values = np.concatenate([each[over] for each in recorded])
        low, high = (float(v) for v in np.percentile(values, [_OUTERMOST, 100.0 - _OUTERMOST]))
        if not high > low:
            continue
        name = quantity.replace("_", " in chamber ")
        for effect in (FORCE, FLOW_A, FLOW_B):
            what = effect.parameters[0].meaning.partition(" at knot")[0]
            block = _block(effect, quantity)
            least = wander if effect is FORCE else 0.0
            found.append(_table(effect, block, what, name, unit, over, (low, high), least))
    longest = max(float(fed.time[-1]) for fed, _ in feeds.values())
    for which, (what, (block, least, name)) in enumerate(zip(DRIFTING, _DRIFTS, strict=True)):
        drift = _table(DRIFT, block, what, "time", "s", which, (0.0, longest), least)
        found.append(replace(drift, form_of=name))
    return found


def _table(
    effect: Effect,
    block: str,
    what: str,
    quantity: str,
    unit_of_quantity: str,
    choice: int,
    ends: tuple[float, float],
    least: float,
) -> Table:
    """Return a table; what is chosen is what it is over or, of a drift, what drifts."""
    knots = tuple(effect.key(p.name) for p in effect.parameters if p.name[0] == "v")
    size, chosen = effect.parameters[0], effect.parameters[len(knots)].name
    low, high = effect.key("low"), effect.key("high")
    values = {effect.key(chosen): float(choice), low: ends[0], high: ends[1]}
    return Table(
        effect.id,
        block,
        what,
        size.unit,
        quantity,
        unit_of_quantity,
        values,
        low,
        high,
        knots,
        size.starts[0],
        least,
        size.high,
        _LEAST_GAIN_OVER_TIME if quantity == "time" else _LEAST_GAIN,
        own=quantity == "time",
    )


def _block(effect: Effect, quantity: str) -> str:
    """Return where something acts that depends on a quantity.

    What a chamber does goes by where the piston is and how fast; a flow that goes by anything
    else comes through the valve. A force that goes by time alone is the load's.
    """
    size = effect.parameters[0]
    if size.unit == "N":
        return "load" if quantity == "time" else effect.block
    return effect.block if quantity.startswith(_OF_THE_PISTON) else "valve.flow"


def quantities_of(fed: Feed, rig: Rig) -> list[Array]:
    """Return the quantities that a table may be over, in the order of `QUANTITIES`.

    Parameters
    ----------
    fed : Feed
        The recording.
    rig : Rig
        The rig it was taken on.
    """
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
