"""Concealed effects of command and spool."""

from pneuservo.challenge.effects.concealed import PHYSICS, ConcealedEffect, Form
from pneuservo.challenge.truth.rig import changed

_BLOCK = ("valve.spool",)
_NEAR_NULL = ("staircase", "hold", "proportional", "multilevel", "triangle")
_LARGE = ("sliding-mode", "multilevel", "relay")

EFFECTS = (
    ConcealedEffect(
        "spool.null-bias", PHYSICS, _BLOCK, 5e-4, 0.02, "",
        (
            Form("shift before the spool", lambda t, s: changed(t, "spool", bias=s), shared=True),
            Form("shift the other way", lambda t, s: changed(t, "spool", bias=-s), shared=True),
            Form(
                "shift that warms up",
                lambda t, s: changed(t, "spool", bias=0.7 * s, bias_drift=0.05 * s),
            ),
        ),
        _NEAR_NULL,
    ),
    ConcealedEffect(
        "spool.hysteresis", PHYSICS, _BLOCK, 1e-3, 0.02, "",
        (
            Form(
                "relays, densest at null",
                lambda t, s: changed(t, "spool", hysteresis=s, hysteresis_spread=0.3),
            ),
            Form("parallel slack elements", lambda t, s: changed(t, "spool", slack=s)),
        ),
        _NEAR_NULL,
    ),
    ConcealedEffect(
        "spool.amplitude-bandwidth", PHYSICS, _BLOCK, 0.1, 40.0, "",
        (
            Form("spring force that saturates", lambda t, s: changed(t, "spool", softening=s)),
            Form(
                "torque limit",
                lambda t, s: changed(t, "spool", acceleration_limit=1.58e6 / (1.0 + s)),
            ),
        ),
        _LARGE,
    ),
    ConcealedEffect(
        "spool.slew", PHYSICS, _BLOCK, 0.002, 0.05, "s",
        (
            Form(
                "amplifier slews before the spool",
                lambda t, s: changed(t, "spool", amplifier_slew=1.0 / s),
            ),
            Form(
                "drag that grows with speed",
                lambda t, s: changed(t, "spool", speed_scale=1.0 / s),
            ),
        ),
        _LARGE,
    ),
    ConcealedEffect(
        "spool.delay", PHYSICS, _BLOCK, 1e-4, 2e-3, "s",
        (Form("dead time of the driver", lambda t, s: changed(t, "spool", delay=s), shared=True),),
        _LARGE,
    ),
    ConcealedEffect(
        "spool.stiction", PHYSICS, _BLOCK, 1e-3, 0.03, "",
        (
            Form("dry friction on the spool", lambda t, s: changed(t, "spool", friction=s)),
            Form(
                "dry friction that grows with rest",
                lambda t, s: changed(t, "spool", friction=0.6 * s, silting=0.4),
            ),
        ),
        _NEAR_NULL,
    ),
    ConcealedEffect(
        "spool.lineariser", PHYSICS, (*_BLOCK, "valve.flow"), 0.02, 0.5, "",
        (
            Form(
                "supply edges open too little, exhaust edges more so",
                lambda t, s: changed(t, "valve", gain_charge=-0.6 * s, gain_exhaust=-s),
            ),
            Form(
                "supply edges open too far, exhaust edges too little",
                lambda t, s: changed(t, "valve", gain_charge=s, gain_exhaust=-0.8 * s),
            ),
        ),
    ),
    ConcealedEffect(
        "spool.travel-stop", PHYSICS, _BLOCK, 0.03, 0.4, "",
        (
            Form(
                "stop on the extending side",
                lambda t, s: changed(t, "spool", travel_open=1.0 - s),
                shared=True,
            ),
            Form(
                "stops on both sides",
                lambda t, s: changed(t, "spool", travel_open=1.0 - 0.5 * s, travel_close=1.0 - s),
                shared=True,
            ),
        ),
        _LARGE,
    ),
)  # fmt: skip
