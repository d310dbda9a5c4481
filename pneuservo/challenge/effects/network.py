"""Concealed effects of supply and hoses."""

import math

from pneuservo.challenge.effects.concealed import PHYSICS, ConcealedEffect, Form
from pneuservo.challenge.truth.parameters import Truth
from pneuservo.challenge.truth.rig import changed

_SUPPLY = ("supply",)
_LINES = ("lines",)
_LARGE = ("sliding-mode", "multilevel", "stop-test", "proportional")


def _hosed(truth: Truth, length: float, bore: float, drag: float) -> Truth:
    """Return the truth with hoses, whose volume was part of the dead volumes."""
    inside = min(0.25 * math.pi * bore**2 * length, 0.7 * truth.chambers.dead_volume_a)
    truth = changed(
        truth,
        "chambers",
        dead_volume_a=truth.chambers.dead_volume_a - inside,
        dead_volume_b=truth.chambers.dead_volume_b - inside,
    )
    return changed(truth, "network", hose_length=length, hose_bore=bore, hose_drag=drag)


EFFECTS = (
    ConcealedEffect(
        "supply.sag", PHYSICS, _SUPPLY, 300.0, 1e5, "Pa at 1 g/s",
        (
            Form(
                "small reservoir behind the main",
                lambda t, s: changed(t, "network", reservoir=2e-4, feed=1e-3 / math.sqrt(s)),
            ),
            Form(
                "large reservoir behind the main",
                lambda t, s: changed(t, "network", reservoir=8e-4, feed=1e-3 / math.sqrt(s)),
            ),
        ),
        _LARGE,
        floor=0.1,
    ),
    ConcealedEffect(
        "supply.slow-drift", PHYSICS, _SUPPLY, 500.0, 6e4, "Pa",
        (
            Form("slow swing", lambda t, s: changed(t, "network", wander=s)),
            Form("steady fall", lambda t, s: changed(t, "network", drift=-0.1 * s)),
        ),
    ),
    ConcealedEffect(
        "supply.ripple", PHYSICS, _SUPPLY, 300.0, 2e4, "Pa",
        (
            Form(
                "regulator that hunts",
                lambda t, s: changed(t, "network", ripple=s, ripple_frequency=1.7),
            ),
            Form(
                "compressor",
                lambda t, s: changed(t, "network", ripple=s, ripple_frequency=14.0),
            ),
        ),
    ),
    ConcealedEffect(
        # Size: friction loss over that of a hose of two millimetres.
        "line.restriction", PHYSICS, (*_LINES, "valve.flow"), 0.2, 40.0, "",
        (
            Form(
                "short rough hose of ten cells",
                lambda t, s: _hosed(t, 0.15, 2e-3 * s**-0.2, 1.5),
            ),
            Form(
                "longer smooth hose of ten cells",
                lambda t, s: _hosed(t, 0.25, 2e-3 * s**-0.2, 0.8),
            ),
        ),
        _LARGE,
        # A wider hose would hold more than the dead volume.
        floor=0.7,
    ),
    ConcealedEffect(
        "line.delay", PHYSICS, _LINES, 0.15, 0.6, "m",
        (Form("wide hose of ten cells", lambda t, s: _hosed(t, s, 1.9e-3, 0.7)),),
        _LARGE,
        # The cells of a short hose would set very small steps.
        floor=1.0,
    ),
    ConcealedEffect(
        "line.resonance", PHYSICS, _LINES, 0.15, 0.3, "m",
        (Form("wide smooth hose of ten cells", lambda t, s: _hosed(t, s, 2.2e-3, 0.2)),),
        _LARGE,
        floor=1.0,
    ),
    ConcealedEffect(
        "line.wall-compliance", PHYSICS, (*_LINES, "chamber.a", "chamber.b"), 1e-8, 1.2e-6, "1/Pa",
        (
            Form(
                "hose volume that grows with pressure",
                lambda t, s: changed(t, "network", hose_stretch=s),
            ),
        ),
        ("stop-test", "multilevel", "sliding-mode"),
    ),
)  # fmt: skip
