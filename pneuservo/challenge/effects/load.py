"""Concealed effects of the load and the ends of the stroke."""

import math

from pneuservo.challenge.effects.concealed import PHYSICS, ConcealedEffect, Form
from pneuservo.challenge.truth.rig import changed

_BLOCK = ("load", "piston")

EFFECTS = (
    ConcealedEffect(
        "load.spring", PHYSICS, _BLOCK, 10.0, 2000.0, "N/m",
        (
            Form(
                "cable that hardens",
                lambda t, s: changed(t, "load", spring=s, spring_cubic=1200.0),
            ),
            Form(
                "hose drag from one end",
                lambda t, s: changed(t, "load", spring=s, spring_at=0.005),
                shared=True,
            ),
        ),
        ("triangle", "proportional", "sliding-mode"),
    ),
    ConcealedEffect(
        "load.gravity-angle", PHYSICS, _BLOCK, 0.02, 0.6, "",
        (
            Form(
                "rig leans: part of the weight is carried by the guide",
                lambda t, s: changed(t, "load", gravity=t.load.gravity * (1.0 - s)),
            ),
        ),
    ),
    ConcealedEffect(
        "load.transverse-mode", PHYSICS, _BLOCK, 0.01, 0.25, "",
        (
            Form(
                "bending mode at 16 Hz",
                lambda t, s: changed(
                    t, "load", mode_mass=s * t.load.mass, mode_frequency=2.0 * math.pi * 16.0
                ),
                shared=True,
            ),
            Form(
                "bending mode at 42 Hz",
                lambda t, s: changed(
                    t, "load", mode_mass=s * t.load.mass, mode_frequency=2.0 * math.pi * 42.0,
                    mode_damping=0.01,
                ),
                shared=True,
            ),
        ),
        ("multilevel", "sliding-mode", "relay"),
    ),
    ConcealedEffect(
        "load.backlash", PHYSICS, _BLOCK, 2e-5, 1e-3, "m",
        (
            Form(
                "joint with play, two masses",
                lambda t, s: changed(t, "load", joint_stiffness=2e6, joint_gap=s),
            ),
        ),
        ("multilevel", "sliding-mode", "relay"),
    ),
    ConcealedEffect(
        "load.compliance", PHYSICS, _BLOCK, 1e-6, 1e-4, "m/N",
        (
            Form(
                "elastic joint, two masses",
                lambda t, s: changed(t, "load", joint_stiffness=1.0 / s),
            ),
        ),
        ("multilevel", "sliding-mode", "relay"),
    ),
    ConcealedEffect(
        "load.base-motion", PHYSICS, _BLOCK, 0.005, 0.2, "",
        (
            Form(
                "frame on its feet, 22 Hz",
                lambda t, s: changed(
                    t, "load", frame_mass=t.load.mass / s, frame_frequency=2.0 * math.pi * 22.0
                ),
            ),
        ),
        ("multilevel", "sliding-mode", "relay"),
    ),
    ConcealedEffect(
        "endstop.contact", PHYSICS, ("piston", "load"), 1e-7, 1e-5, "m/N",
        (
            Form(
                "soft buffer",
                lambda t, s: changed(t, "load", stop_stiffness=1.0 / s, stop_damping=150.0),
            ),
        ),
        ("stop-test",),
    ),
)  # fmt: skip
