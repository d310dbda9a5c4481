"""Friction of the piston: elements that slip one after the other, and drag."""

import math

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel

DWELL_REFERENCE = 0.1  # contact age from which strengthening counts [s]
PRESSURE_UNIT = 1e5  # in which powers of a pressure are taken [Pa]


@truth_kernel
def sliding_level(y, time, friction, network):
    """Return how large dry friction is when everything slips [N]."""
    x, v = y[at.POSITION], y[at.SPEED]
    level = friction.coulomb
    gauge_a = max(y[at.PRESSURE_A] - network.ambient_pressure, 0.0)
    gauge_b = max(y[at.PRESSURE_B] - network.ambient_pressure, 0.0)
    if friction.pressure_sum > 0.0:
        both = (gauge_a + gauge_b) / PRESSURE_UNIT
        level += friction.pressure_sum * PRESSURE_UNIT * both**friction.pressure_power
    level += friction.pressure_lips * max(gauge_a, gauge_b)
    level += friction.bump * math.exp(-(((x - friction.bump_at) / friction.bump_width) ** 2))
    level += 0.5 * friction.waviness * (1.0 + math.cos(friction.wave_number * x))
    level += friction.side_load * x
    if friction.static_rise != 0.0:
        fall = (abs(v) / friction.static_speed) ** friction.static_shape
        level += friction.static_rise / (1.0 + fall)
    if friction.dwell_rise > 0.0:
        level += friction.dwell_rise * math.log1p(max(y[at.AGE], 0.0) / DWELL_REFERENCE)
    wear = friction.wear * (1.0 - math.exp(-time / friction.wear_time))
    return max(level * (1.0 - wear), 0.0)


@truth_kernel
def friction_force(y, time, friction, network, rates):
    """Return the force of friction against positive motion [N]; set the rates of its states.

    Elements in parallel, each an elastic deflection that slips at its own limit (Maxwell slip;
    Lampaert, Al-Bender and Swevers 2003), under a common level that depends on speed, pressure,
    place and age.
    """
    v = y[at.SPEED]
    engaged = 0.0
    for j in range(at.BRISTLE_COUNT):
        part = j / (at.BRISTLE_COUNT - 1.0)
        slip = friction.slip_short * (friction.slip_long / friction.slip_short) ** part
        z = y[at.BRISTLES + j]
        rates[at.BRISTLES + j] = v / slip if abs(z) < 1.0 or z * v < 0.0 else 0.0
        engaged += min(max(z, -1.0), 1.0) / at.BRISTLE_COUNT
    level = sliding_level(y, time, friction, network)
    force = (level + friction.asymmetry * engaged) * engaged
    wear = friction.wear * (1.0 - math.exp(-time / friction.wear_time))
    force += (friction.viscous * v + friction.viscous_asymmetry * abs(v)) * (1.0 - wear)
    if friction.drag != 0.0:
        force += math.copysign(friction.drag * abs(v) ** friction.drag_power, v)
    if friction.lag > 0.0:
        rates[at.FILM] = (v - y[at.FILM]) / friction.lag
        force += friction.film * y[at.FILM]
    if friction.dwell_rise > 0.0:
        rates[at.AGE] = 1.0 - abs(v) * y[at.AGE] / friction.dwell_length
    return force


@truth_kernel
def hold_bristles(y):
    """Put elements that slipped back on their limit."""
    for j in range(at.BRISTLE_COUNT):
        y[at.BRISTLES + j] = min(max(y[at.BRISTLES + j], -1.0), 1.0)
