"""What happens at the ends of the stroke."""

from pneuservo.effects.effect import Effect, EffectParameter

_RIGS = ("single-axis",)

CONTACT = Effect(
    id="endstop.contact",
    block="piston",
    rigs=_RIGS,
    statement="A bumper catches the piston in front of the stop; the model stops it dead.",
    equation="F = stiffness d + damping d' over the last length",
    parameters=(
        EffectParameter(
            "stiffness", "N/m", 0.0, 1e5, 3e7, (1e6, 1e7), "of the bumper", "stop.stiffness",
            inverse=True,
            most=2.5e7,  # a stop of steel, of 1e8 N/m, gives way by some micrometres, too
        ),
        EffectParameter(
            "damping", "N*s/m", 0.0, 0.0, 2e3, (200.0,), "of the bumper", "stop.damping"
        ),
        EffectParameter(
            "length", "m", 2e-4, 0.0, 2e-3, (2e-4, 0.0), "of the bumper", "stop.length"
        ),
    ),
    source="textbook contact law; restitution 0.2 to 0.6",
    experiment="drive into both stops at three speeds with an accelerometer",
)  # fmt: skip
CUSHION = Effect(
    id="endstop.cushion",
    block="piston",
    rigs=_RIGS,
    statement="Trapped air brakes the piston near its ends; the model has no cushions.",
    equation="Pc' = n/V (R T m(P, Pc, area) + Pc A v) over the last length",
    parameters=(
        EffectParameter(
            "length", "m", 0.0, 0.0, 0.015, (0.006, 0.003, 0.009, 0.012), "of the cushion",
            "stop.cushion_length",
        ),
        EffectParameter(
            "area", "m**2", 1e-7, 5e-9, 1e-6, (1e-7,), "of the needle", "stop.needle_area"
        ),
    ),
    source="Beater 2007, Pneumatic Drives",
    experiment="repeat with the needles open and closed",
)  # fmt: skip
EFFECTS = (CONTACT, CUSHION)
