"""Concealed effects of flow through the valve."""

import math

from pneuservo.challenge.effects.concealed import PHYSICS, ConcealedEffect, Form
from pneuservo.challenge.truth.rig import changed

_BLOCK = ("valve.flow",)
_NEAR_NULL = ("staircase", "hold", "proportional", "multilevel", "triangle")

EFFECTS = (
    ConcealedEffect(
        "valve.overlap", PHYSICS, (*_BLOCK, "valve.spool"), 1e-3, 0.04, "",
        (
            Form(
                "sharp corners",
                lambda t, s: changed(t, "valve", overlap=s, overlap_rounding=0.1),
            ),
            Form(
                "worn corners",
                lambda t, s: changed(t, "valve", overlap=s, overlap_rounding=0.6),
            ),
        ),
        _NEAR_NULL,
    ),
    ConcealedEffect(
        "valve.null-leakage", PHYSICS, _BLOCK, 3e-4, 0.02, "",
        (
            Form(
                "clearance, half laminar",
                lambda t, s: changed(t, "valve", clearance=s, clearance_laminar=0.5),
            ),
            Form(
                "narrow clearance, laminar",
                lambda t, s: changed(
                    t, "valve", clearance=s, clearance_laminar=0.95, clearance_reach=0.015
                ),
            ),
        ),
        _NEAR_NULL,
    ),
    ConcealedEffect(
        "valve.critical-ratio", PHYSICS, _BLOCK, 0.02, 0.38, "",
        (
            Form(
                "ellipse of ISO 6358",
                lambda t, s: changed(t, "valve", critical_ratio=0.528 - s),
            ),
            Form(
                "ellipse with another subsonic index",
                lambda t, s: changed(
                    t, "valve", critical_ratio=0.528 - s, subsonic_index=0.5 + 0.3 * s
                ),
            ),
        ),
    ),
    ConcealedEffect(
        "valve.laminar-tail", PHYSICS, _BLOCK, 500.0, 5e4, "Pa",
        (
            Form(
                "discharge coefficient by the flow number",
                lambda t, s: changed(t, "valve", laminar_pressure=s),
            ),
            Form(
                "viscous and kinetic losses in series",
                lambda t, s: changed(t, "valve", laminar_pressure=s, laminar_series=1.0),
            ),
        ),
        ("stop-test", "hold", "multilevel"),
    ),
    ConcealedEffect(
        "valve.reattachment", PHYSICS, _BLOCK, 0.02, 0.25, "",
        (
            Form(
                "exhaust jets attach and detach",
                lambda t, s: changed(t, "valve", attached_gain=s),
            ),
        ),
        ("stop-test", "multilevel", "sliding-mode"),
    ),
    ConcealedEffect(
        "valve.upstream-temperature", PHYSICS, (*_BLOCK, "supply"), 3.0, 60.0, "K",
        (
            Form(
                "warm gas from the compressor",
                lambda t, s: changed(t, "valve", warm_supply=s),
                shared=True,
            ),
        ),
    ),
    ConcealedEffect(
        "valve.exhaust-back-pressure", PHYSICS, (*_BLOCK, "lines"), 300.0, 5e4, "Pa at 1 g/s",
        (
            Form(
                "silencer behind a small volume",
                lambda t, s: changed(t, "network", silencer=1e-3 / math.sqrt(s)),
            ),
        ),
        floor=0.1,
    ),
)  # fmt: skip
