"""What else pulls on the rod."""

from pneuservo.effects.effect import Effect, EffectParameter

SPRING = Effect(
    id="load.spring",
    block="load",
    rigs=("seal-tester",),
    statement="Something pulls on the rod like a spring; the model has no spring.",
    equation="F = stiffness (x - x_mid)",
    parameters=(
        EffectParameter("stiffness", "N/m", 0.0, -5000.0, 5000.0, (20.0,), "spring stiffness"),
    ),
    source="hose drag and cable chains; physics of a linear spring",
    experiment="drive slowly both ways over the full stroke: a spring does not change sign with v",
)
EFFECTS = (SPRING,)
