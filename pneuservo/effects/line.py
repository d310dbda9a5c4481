"""What the hoses between valve and cylinder do beyond adding to the dead volume."""

from pneuservo.effects.effect import Effect, EffectParameter

_RIGS = ("single-axis",)
_BLOCK = "lines"
_HOSE = "throttle of the hoses"

RESTRICTION = Effect(
    id="line.restriction",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The hoses throttle the flow; the model has no pressure drop in them.",
    equation=(
        "charging: m_edge(p_s, ph) = area Cm(0) sqrt((ph^2 - p^2)/T); "
        "exhausting: 1/A^2 = 1/A_edge^2 + 1/area^2"
    ),
    parameters=(
        EffectParameter(
            "area", "m**2", 0.0, 0.0, 1e-5, (2e-6, 5e-6), "effective area of a hose; 0 for none",
            "line.area", inverse=True,
        ),
    ),
    source="Richer and Hurmuzlu 2000; thesis chapter 3: below 0.3 bar on 1 m",
    experiment="tap the pressure at both ends of a hose; charge at several openings",
    group=_HOSE,
)  # fmt: skip
DELAY = Effect(
    id="line.delay",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The flow reaches the chambers late and weakened; the model has no hose to travel.",
    equation="m_chamber(t) = m_valve(t - time), throttled by area as in line.restriction",
    parameters=(
        EffectParameter(
            "time", "s", 0.0, 0.0, 1e-2, (1e-3, 3e-3), "time on the way", "line.delay",
            least=1e-4,  # 35 mm of hose: one that throttles and delays by less is a restriction
        ),
        EffectParameter(
            "area", "m**2", 0.0, 2e-7, 2e-5, (5e-6,), "effective area of a hose; 0 for none",
            "line.attenuating_area",
        ),
    ),
    source="Richer and Hurmuzlu 2000; Schuder and Binder 1959: 2.9 ms per metre",
    experiment="swap the hoses for longer ones; tap the pressure at both ends",
    group=_HOSE,
)  # fmt: skip
RESONANCE = Effect(
    id="line.resonance",
    block=_BLOCK,
    rigs=_RIGS,
    statement=(
        "The air in the hoses swings against the chambers; the model's hoses have no inertia."
    ),
    equation=(
        "m'' = w^2 V_mid ((m_valve - m)/V_hose - m/V) - 2 damping w m', w = 2 pi frequency, "
        "V_hose half the dead volume"
    ),
    parameters=(
        EffectParameter(
            "frequency", "Hz", 0.0, 0.0, 400.0, (32.0, 90.0, 200.0),
            "at mid-stroke with the valve's end open; 0 for none", "line.frequency",
            inverse=True,
        ),
        EffectParameter("damping", "", 0.2, 0.01, 1.5, (0.2,), "damping ratio", "line.damping"),
    ),
    source="Helmholtz; Richer and Hurmuzlu 2000: 32 Hz at 1 m, 94 Hz at 0.1 m",
    experiment=(
        "ring it with the piston locked at two places and the valve wide open: the frequency moves "
        "with the volume (shut, it rings higher, on the air of the hose)"
    ),
)  # fmt: skip
WALL_COMPLIANCE = Effect(
    id="line.wall-compliance",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The hoses widen under pressure; the model's are rigid.",
    equation="V = V0 + growth p V_dead",
    parameters=(
        EffectParameter(
            "growth", "1/Pa", 0.0, 0.0, 1e-6, (1e-7,), "relative growth per pressure",
            "line.compliance",
        ),
    ),
    source="soft tubing 0.5 to 3 % per bar; Beater 2007",
    experiment="stop test and small swings at two pressure levels",
)  # fmt: skip
EFFECTS = (RESTRICTION, DELAY, RESONANCE, WALL_COMPLIANCE)
