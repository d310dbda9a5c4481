"""What friction cannot hold: the force on a piston at rest, and that at which it breaks away."""

import math

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.models.servo.breakaway import UNEVEN, forces_at_breakaway
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.observer import Observed, behind_the_rod
from pneuservo.diagnosis.models.servo.push import balance_at_rest
from pneuservo.diagnosis.models.servo.rests import averaged, averaged_samples
from pneuservo.diagnosis.models.servo.stops import APART, AVERAGED_AT_REST
from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.drift import drift_of, drifted_by
from pneuservo.plant.single_axis import DISPLACEMENT, PLANT_STATES, PRESSURE_A, PRESSURE_B, SPOOL

_MISSED = 3.0
"""What pressures miss by more than so many times what their noise averages to is missed."""


def beyond_friction(fed: Feed, observed: Observed) -> Array:
    """Return the force beyond what friction can hold, in how well that is known.

    Parameters
    ----------
    fed : Feed
        What the observer was fed with.
    observed : Observed
        What it made of that.

    Returns
    -------
    (n,) array
        While the piston rests the force beyond what can be held, and 0 where it can; at the last
        sample of a rest by how much it breaks away at more than that, or less [-].
    """
    force, holding = _at_rest(fed, observed)
    spread = np.maximum(np.hypot(fed.force_rms_at_rest, UNEVEN * holding), 1e-9)
    spread *= np.sqrt(fed.moments_of_rest)
    beyond = np.copysign(np.maximum(np.abs(force) - holding, 0.0), force) / spread
    force, holding, spread = _at_breakaway(fed, observed)
    beyond[fed.breaks_away] = fed.departures.side * (force - holding) / np.maximum(spread, 1e-9)
    return np.asarray(beyond)


def forces_on_resting(fed: Feed, observed: Observed) -> Array:
    """Return the force on a piston at rest, and how much of it friction can hold.

    Parameters
    ----------
    fed, observed
        As in `beyond_friction`.

    Returns
    -------
    (2, n) array
        The force positive towards extension; zeros where the piston is not known to rest [N]. At
        the last sample of a rest they are those at which it breaks away.
    """
    at_rest = _at_rest(fed, observed)
    force, holding, _ = _at_breakaway(fed, observed)
    at_rest[:, fed.breaks_away] = fed.departures.side * force, holding
    return at_rest


def _at_rest(fed: Feed, observed: Observed) -> Array:
    """Return the forces as `forces_on_resting` does, those before it breaks away among them.

    By averages of what was measured: the pressures that the observer follows are off by whatever
    flows are.
    """
    measured = np.vstack([observed.pressures, observed.force])
    *pressures, force = averaged(measured, fed.interval, AVERAGED_AT_REST)
    found: Array = _balances(
        fed.time,
        fed.held,
        fed.stuck,
        np.array(pressures),
        force - observed.path[3],
        observed.path[2],
        observed.motion,
        observed.state[:PLANT_STATES].copy(),
        observed.servo,
        drift_of(observed.servo.effects),
    )
    return found


def _at_breakaway(fed: Feed, observed: Observed) -> Array:
    """Return at which force the piston breaks away, as `forces_at_breakaway`.

    By the pressures that the observer follows: averages of what was measured begin to change before
    they do. What is wrong with a flow must not pass for friction: the force is known no better than
    by what was missed of the pressures before, beyond their noise.
    """
    left, servo = fed.departures, observed.servo
    if not left.at.size:
        return np.empty((3, 0))
    first, gone = left.first.astype(int), left.gone.astype(int)
    piston, place = servo.plant.piston, observed.motion[0]
    before = np.maximum(fed.breaks_away - round(0.5 * APART / fed.interval), 0)
    off = averaged(observed.left[:2], fed.interval, APART)[:, before]
    off = piston.area_a * off[0] - piston.area_b * off[1]
    of_noise = fed.spread_of_force / math.sqrt(averaged_samples(fed.interval, APART))
    off = np.maximum(np.abs(off) - _MISSED * of_noise, 0.0)
    known = np.hypot(fed.force_spread[fed.breaks_away], fed.force_rms)
    behind = behind_the_rod(fed.motion[0], fed.held, servo.effects.sensor.wiper_play)
    found: Array = forces_at_breakaway(
        left,
        fed.time,
        observed.path,
        averaged(observed.force, fed.interval) - observed.path[3],
        np.hypot(known, off),
        place,
        np.abs(place[gone] - place[first] + behind[gone] - behind[first]),
        observed.state[:PLANT_STATES].copy(),
        servo,
        drift_of(servo.effects),
    )
    return found


@compiled
def _balances(time, held, stuck, pressures, external_force, opening, motion, state, servo, drift):
    """Return the force on a stuck piston and how much of it friction can hold; elsewhere zeros."""
    found, rested = np.zeros((2, time.size)), 0.0
    for k in range(1, time.size):
        rested = rested + time[k] - time[k - 1] if held[k] else 0.0
        if stuck[k]:
            state[DISPLACEMENT], state[SPOOL] = motion[0, k], opening[k]
            state[PRESSURE_A], state[PRESSURE_B] = pressures[0, k], pressures[1, k]
            now = drifted_by(servo, drift, time[k])
            found[0, k], found[1, k] = balance_at_rest(
                time[k], state, motion[1, k], rested, external_force[k], now
            )
    return found
