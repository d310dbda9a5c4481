"""Concealed effects of the gas in the chambers, and leaks."""

from pneuservo.challenge.effects.concealed import PHYSICS, ConcealedEffect, Form
from pneuservo.challenge.truth.rig import changed

_BOTH = ("chamber.a", "chamber.b")
_REST = ("hold", "stop-test", "staircase", "proportional", "triangle")

EFFECTS = (
    ConcealedEffect(
        "chamber.heat-transfer", PHYSICS, _BOTH, 20.0, 200.0, "W/(m^2 K)",
        (
            Form(
                "energy balance with a wall",
                lambda t, s: changed(t, "chambers", energy_balance=1.0, wall_transfer=s),
            ),
            Form(
                "transfer that grows with density",
                lambda t, s: changed(
                    t, "chambers", energy_balance=1.0, wall_transfer=s, wall_exponent=0.8
                ),
            ),
        ),
        ("stop-test", "hold", "triangle", "multilevel"),
        # Without a wall the gas still cools and warms, which the baseline's index leaves out.
        scales=False,
    ),
    ConcealedEffect(
        "chamber.inlet-temperature", PHYSICS, _BOTH, 0.1, 3.0, "W/(m^2 K)",
        (
            Form(
                "energy balance with next to no wall",
                lambda t, s: changed(t, "chambers", energy_balance=1.0, wall_transfer=s),
            ),
        ),
        ("stop-test", "multilevel", "sliding-mode"),
        scales=False,
    ),
    ConcealedEffect(
        "chamber.wall-warming", PHYSICS, _BOTH, 2.0, 40.0, "J/K",
        (
            Form(
                "energy balance with a wall that warms",
                lambda t, s: changed(
                    t, "chambers", energy_balance=1.0, wall_transfer=120.0, wall_capacity=s
                ),
            ),
        ),
        ("stop-test", "multilevel", "sliding-mode"),
        scales=False,
    ),
    ConcealedEffect(
        "chamber.port-covering", PHYSICS, _BOTH, 0.03, 0.9, "",
        (
            Form(
                "ports narrow smoothly over the last three millimetres",
                lambda t, s: changed(t, "chambers", port_length=3e-3, port_rest=1.0 - s),
            ),
        ),
        ("stop-test",),
    ),
    ConcealedEffect(
        "leakage.cross-piston", PHYSICS, _BOTH, 3e-10, 3e-8, "m^2",
        (
            Form("half viscous", lambda t, s: changed(t, "chambers", leak_cross=s)),
            Form(
                "lip that seals one way better",
                lambda t, s: changed(
                    t, "chambers", leak_cross=s, leak_laminar=0.8, leak_return=0.45
                ),
            ),
        ),
        _REST,
    ),
    ConcealedEffect(
        "leakage.chamber-a", PHYSICS, ("chamber.a",), 3e-10, 3e-8, "m^2",
        (
            Form("half viscous", lambda t, s: changed(t, "chambers", leak_a=s)),
            Form(
                "mostly viscous",
                lambda t, s: changed(t, "chambers", leak_a=s, leak_laminar=0.85),
            ),
        ),
        _REST,
    ),
    ConcealedEffect(
        "leakage.rod-seal", PHYSICS, ("chamber.b",), 3e-10, 3e-8, "m^2",
        (
            Form("half viscous", lambda t, s: changed(t, "chambers", leak_b=s)),
            Form(
                "mostly kinetic",
                lambda t, s: changed(t, "chambers", leak_b=s, leak_laminar=0.15),
            ),
        ),
        _REST,
    ),
    ConcealedEffect(
        "leakage.pressure-opening-a", PHYSICS, ("chamber.a",), 3e-10, 3e-8, "m^2",
        (
            Form(
                "pores of chamber a, exponent 1.9",
                lambda t, s: changed(t, "chambers", leak_a=s, leak_power=1.9),
                shared=True,
            ),
        ),
        ("stop-test", "hold"),
    ),
    ConcealedEffect(
        "leakage.position", PHYSICS, _BOTH, 1e-9, 8e-8, "m^2",
        (
            Form(
                "worn zone of the bore",
                lambda t, s: changed(t, "chambers", leak_cross=0.05 * s, leak_place=20.0),
            ),
        ),
        ("triangle", "proportional"),
    ),
    ConcealedEffect(
        "leakage.velocity", PHYSICS, _BOTH, 1e-9, 5e-8, "m^2",
        (
            Form(
                "seal film that lifts with speed",
                lambda t, s: changed(t, "chambers", leak_cross=0.1 * s, leak_speed=60.0),
            ),
        ),
        ("sliding-mode", "proportional"),
    ),
)  # fmt: skip
