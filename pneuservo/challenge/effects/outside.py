"""Causes that no catalogue has: the right answer is that they are not explained."""

from pneuservo.challenge.effects.concealed import OUTSIDE, ConcealedEffect, Form
from pneuservo.challenge.truth.rig import changed

EFFECTS = (
    ConcealedEffect(
        "outside.reference-drift", OUTSIDE, ("sensor.displacement",), 2e-4, 8e-3, "1/s",
        (
            Form(
                "reference voltage of the transducer drifts",
                lambda t, s: changed(t, "sensors", reference_drift=s),
            ),
        ),
    ),
    ConcealedEffect(
        "outside.icing", OUTSIDE, ("valve.flow", "lines"), 10.0, 2000.0, "1/kg",
        (
            Form(
                "exhaust edges ice up with what they pass",
                lambda t, s: changed(t, "valve", icing=s),
            ),
        ),
        ("sliding-mode", "multilevel", "relay", "stop-test"),
    ),
    ConcealedEffect(
        "outside.loose-mount", OUTSIDE, ("load", "piston"), 0.02, 0.3, "",
        (
            Form(
                "cylinder on a mount with play",
                lambda t, s: changed(
                    t, "load", frame_mass=t.load.mass / s, frame_frequency=250.0, frame_gap=2e-4
                ),
            ),
        ),
        ("sliding-mode", "multilevel", "relay"),
    ),
    ConcealedEffect(
        "outside.changing-mass", OUTSIDE, ("load", "piston"), 0.005, 0.25, "kg/s",
        (Form("a load that fills up", lambda t, s: changed(t, "load", mass_rate=s)),),
        ("sliding-mode", "multilevel", "proportional"),
    ),
    ConcealedEffect(
        "outside.external-force", OUTSIDE, ("load", "piston"), 0.3, 15.0, "N",
        (Form("another axis pushes", lambda t, s: changed(t, "load", push=s)),),
    ),
    ConcealedEffect(
        "outside.aliasing", OUTSIDE, ("sensor.pressure",), 100.0, 1e4, "Pa",
        (
            Form(
                "a line near the sampling rate folds down",
                lambda t, s: changed(t, "sensors", folded=s),
            ),
        ),
    ),
    ConcealedEffect(
        "outside.torque-motor-remanence", OUTSIDE, ("valve.spool",), 2e-3, 0.04, "",
        (
            Form(
                "wide relays and dry friction of the spool together",
                lambda t, s: changed(
                    t, "spool", hysteresis=s, hysteresis_spread=1.0, friction=0.3 * s
                ),
            ),
        ),
        ("staircase", "hold", "proportional", "multilevel"),
    ),
    ConcealedEffect(
        "outside.check-valve", OUTSIDE, ("supply",), 2e-9, 2e-7, "kg/(s Pa)",
        (
            Form(
                "check valve of the supply leaks back",
                lambda t, s: changed(t, "network", reservoir=4e-4, feed=1.2e-5, check_leak=s),
            ),
        ),
    ),
)  # fmt: skip
