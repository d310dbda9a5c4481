"""What the compressed-air supply does beyond one constant pressure."""

from pneuservo.effects.effect import Effect, EffectParameter

_RIGS = ("single-axis",)
_BLOCK = "supply"

SAG = Effect(
    id="supply.sag",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The supply pressure dips while the valve draws air; the model holds it constant.",
    equation="volume/(n R T) Ps' = m(P0, Ps, area) - m_drawn",
    parameters=(
        EffectParameter(
            "volume", "m**3", 0.0, 0.0, 5e-3, (2e-4, 1e-3), "between line and valve",
            "supply.reservoir_volume",
        ),
        EffectParameter(
            "area", "m**2", 0.0, 3e-7, 2e-5, (2e-6,), "effective area of the line",
            "supply.line_area",
        ),
    ),
    source="thesis chapter 3: 6.5 to 7.7 bar with load; Beater 2007",
    experiment="tap the supply pressure at the valve at 500 Hz or more",
)  # fmt: skip
SLOW_DRIFT = Effect(
    id="supply.slow-drift",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The supply pressure drifts during the recording; the model holds it constant.",
    equation="Ps = P0 + rate t",
    parameters=(
        EffectParameter(
            "rate", "Pa/s", 0.0, -2e4, 2e4, (1e3,), "drift of the source", "supply.drift", 30.0
        ),
    ),
    source="thesis chapter 3: 6.5 to 7.7 bar over a day",
    experiment="log the supply pressure; repeat a reference step",
)
RIPPLE = Effect(
    id="supply.ripple",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The supply pressure swings by itself; the model holds it constant.",
    equation="Ps = P0 + amplitude sin(2 pi frequency t + phase)",
    parameters=(
        EffectParameter(
            "amplitude", "Pa", 0.0, 0.0, 1e5, (1e4,), "of the swing", "supply.ripple"
        ),
        EffectParameter(
            "frequency", "Hz", 1.0, 0.05, 100.0, (1.0, 20.0), "of the swing",
            "supply.ripple_frequency",
        ),
        EffectParameter(
            "phase", "rad", 0.0, -6.3, 6.3, (0.0, 2.1, 4.2), "at the start of a recording",
            "supply.ripple_phase",
        ),
    ),
    source="regulator hunting and compressor cycles; Beater 2007",
    experiment="log the supply pressure and its coherence with the command",
)  # fmt: skip
EFFECTS = (SAG, SLOW_DRIFT, RIPPLE)
