"""Concealed effects of friction."""

import math

from pneuservo.challenge.effects.concealed import PHYSICS, ConcealedEffect, Form
from pneuservo.challenge.truth.parameters import Truth
from pneuservo.challenge.truth.rig import changed
from pneuservo.errors import InputError

_BLOCK = ("piston",)
_SLOW = ("triangle", "proportional", "staircase")


def _filmed(truth: Truth, lag: float, share: float) -> Truth:
    film = share * truth.friction.viscous
    return changed(truth, "friction", lag=lag, film=film, viscous=truth.friction.viscous - film)


def _by_direction(truth: Truth, asymmetry: float, viscous: float) -> Truth:
    if asymmetry > truth.friction.coulomb:
        raise InputError("friction cannot push: it is at most twice its mean in one direction")
    return changed(truth, "friction", asymmetry=asymmetry, viscous_asymmetry=viscous)


EFFECTS = (
    ConcealedEffect(
        "friction.stribeck", PHYSICS, _BLOCK, 0.2, 15.0, "N",
        (
            Form(
                "slip level that falls as a rational function of speed",
                lambda t, s: changed(t, "friction", static_rise=s, static_speed=0.008),
            ),
            Form(
                "slip level that falls slowly with speed",
                lambda t, s: changed(
                    t, "friction", static_rise=s, static_speed=0.015, static_shape=1.2
                ),
            ),
        ),
        _SLOW,
    ),
    ConcealedEffect(
        "friction.breakaway-dwell", PHYSICS, _BLOCK, 0.2, 6.0, "N",
        (
            Form(
                "contact that ages (rate and state)",
                lambda t, s: changed(t, "friction", dwell_rise=s),
            ),
        ),
        ("proportional", "hold", "staircase"),
    ),
    ConcealedEffect(
        "friction.presliding", PHYSICS, _BLOCK, 5e-6, 2e-4, "m",
        (
            Form(
                "elements that slip one after the other",
                lambda t, s: changed(t, "friction", slip_short=0.15 * s, slip_long=1.5 * s),
            ),
            Form(
                "two kinds of elements",
                lambda t, s: changed(t, "friction", slip_short=0.02 * s, slip_long=2.0 * s),
            ),
        ),
        ("hold", "staircase", "triangle"),
    ),
    ConcealedEffect(
        "friction.lag", PHYSICS, _BLOCK, 2e-3, 0.06, "s",
        (Form("film that follows the speed", lambda t, s: _filmed(t, s, 0.9)),),
        ("sliding-mode", "multilevel", "proportional"),
    ),
    ConcealedEffect(
        "friction.pressure", PHYSICS, _BLOCK, 3e-7, 2e-5, "N/Pa",
        (
            Form(
                "both lips, a power below one",
                lambda t, s: changed(t, "friction", pressure_sum=s, pressure_power=0.92),
            ),
            Form(
                "the lip that is pressed harder",
                lambda t, s: changed(t, "friction", pressure_lips=1.8 * s),
            ),
        ),
    ),
    ConcealedEffect(
        "friction.asymmetric", PHYSICS, (*_BLOCK, "load"), 0.2, 1.0, "N",
        (
            Form("slip level by direction", lambda t, s: _by_direction(t, s, 0.0)),
            Form(
                "slip level and drag by direction",
                lambda t, s: _by_direction(t, 0.6 * s, 3.0 * s),
            ),
        ),
        ("triangle", "proportional", "sliding-mode"),
    ),
    ConcealedEffect(
        "friction.position", PHYSICS, _BLOCK, 0.3, 10.0, "N",
        (
            Form("one tight spot", lambda t, s: changed(t, "friction", bump=s)),
            Form(
                "waves along the bore",
                lambda t, s: changed(
                    t, "friction", waviness=s, wave_number=2.0 * math.pi / 0.011
                ),
            ),
        ),
        ("triangle", "proportional", "sliding-mode"),
    ),
    ConcealedEffect(
        "friction.speed-curve", PHYSICS, _BLOCK, 10.0, 1500.0, "N s^2/m^2",
        (
            Form(
                "drag with the speed to the power 1.8",
                lambda t, s: changed(t, "friction", drag=s, drag_power=1.8),
            ),
            Form(
                "drag that thins: power one half",
                lambda t, s: changed(t, "friction", drag=0.03 * s, drag_power=0.5),
            ),
        ),
        ("multilevel", "sliding-mode"),
    ),
    ConcealedEffect(
        "friction.run-in", PHYSICS, _BLOCK, 0.03, 0.6, "",
        (
            Form(
                "exponential run-in of dry friction and drag",
                lambda t, s: changed(t, "friction", wear=s),
            ),
        ),
        ("triangle", "proportional", "sliding-mode"),
    ),
    ConcealedEffect(
        "friction.side-load", PHYSICS, _BLOCK, 20.0, 500.0, "N/m",
        (
            Form(
                "normal force of a lever that grows with the stroke",
                lambda t, s: changed(t, "friction", side_load=s),
            ),
        ),
        ("triangle", "proportional"),
    ),
)  # fmt: skip
