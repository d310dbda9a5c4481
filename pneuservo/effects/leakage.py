"""Leaks: of a closed chamber to the atmosphere, and of a cylinder."""

from pneuservo.effects.effect import Effect, EffectParameter

_RIGS = ("dead-volume",)
_EXPERIMENT = (
    "plug every port, fill once high and once low, and log the pressure until it is within "
    "0.1 bar of the atmosphere: the slope of log(-dp/dt) against log(gauge pressure) tells the law"
)


_AREA = EffectParameter("area", "m**2", 0.0, 0.0, 1e-6, (1e-9, 3e-8), "effective area of the leak")
_CONDUCTANCE = EffectParameter(
    "conductance", "kg/(s*Pa**2)", 0.0, 0.0, 1e-15, (1e-18, 3e-17), "flow per pressure squared"
)

ORIFICE = Effect(
    id="leakage.orifice",
    block="dead-volume",
    rigs=_RIGS,
    statement="Air leaks to the atmosphere as through a small hole; the model holds it tight.",
    equation="m_leak = area Cm(p_atm/p) p / sqrt(T)",
    parameters=(_AREA,),
    source="thesis equation (4.15); Beater 2007, Pneumatic Drives",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
LAMINAR = Effect(
    id="leakage.laminar",
    block="dead-volume",
    rigs=_RIGS,
    statement="Air leaks to the atmosphere as through a narrow gap; the model holds it tight.",
    equation="m_leak = conductance (p^2 - p_atm^2) (293 K/T)",
    parameters=(_CONDUCTANCE,),
    source="Richer and Hurmuzlu 2000, J. Dyn. Syst. Meas. Control 122",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
MIXED = Effect(
    id="leakage.mixed",
    block="dead-volume",
    rigs=_RIGS,
    statement=(
        "Air leaks to the atmosphere through a hole and a narrow gap together; "
        "the model holds it tight."
    ),
    equation="m_leak = area Cm(p_atm/p) p / sqrt(T) + conductance (p^2 - p_atm^2) (293 K/T)",
    parameters=(_AREA, _CONDUCTANCE),
    source="Richer and Hurmuzlu 2000; Beater 2007",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
PRESSURE_OPENING = Effect(
    id="leakage.pressure-opening",
    block="dead-volume",
    rigs=_RIGS,
    statement=(
        "Air leaks to the atmosphere with a power of the gauge pressure (above 1: gaps or pores "
        "that open under pressure); the model holds it tight."
    ),
    equation="m_leak = coefficient ((p - p_atm) / 1 bar)^exponent",
    parameters=(
        EffectParameter("coefficient", "kg/s", 0.0, 0.0, 1e-2, (1e-7, 3e-6), "leak at 1 bar gauge"),
        EffectParameter("exponent", "", 1.0, 0.5, 2.5, (1.2,), "power of the gauge pressure"),
    ),
    source="fit to leak-down recordings of printed chambers, Zillen 2021",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
LEAKS = (ORIFICE, LAMINAR, MIXED, PRESSURE_OPENING)

_SERVO = ("single-axis",)
_HOLD = (
    "plug or close the valve, lock the piston, and log both pressures for 60 s at several "
    "pressure differences of both signs"
)
_PAST_PISTON = "leak past the piston"
_HOLE = EffectParameter(
    "hole", "", 0.0, 0.0, 1.0, (0.3,), "share that flows as through a hole", "leakage.cross_hole"
)
_OUT_OF = "leak out of chamber {}"
CROSS_PISTON = Effect(
    id="leakage.cross-piston",
    block="chamber.a",
    rigs=_SERVO,
    statement="Air leaks past the piston seal; the model holds it tight.",
    equation=(
        "m_ab = conductance ((1 - hole) (pa^2 - pb^2) + hole (6 bar) pa Cm(pb/pa)/Cm(0)), "
        "and back_flow of that where pb > pa"
    ),
    parameters=(
        EffectParameter(
            "conductance", "kg/(s*Pa**2)", 0.0, 0.0, 2e-15, (3e-17,), "flow per pressure squared",
            "leakage.cross_conductance",
        ),
        EffectParameter(
            "back_flow", "", 1.0, 0.0, 4.0, (1.0,), "what of it a lip seal lets back from b to a",
            "leakage.cross_back_flow",
        ),
        _HOLE,
    ),
    source="Richer and Hurmuzlu 2000, J. Dyn. Syst. Meas. Control 122; Beater 2007",
    experiment=_HOLD,
    group=_PAST_PISTON,
)  # fmt: skip
CHAMBER_A = Effect(
    id="leakage.chamber-a",
    block="chamber.a",
    rigs=_SERVO,
    statement="Chamber a leaks to the outside; the model holds it tight.",
    equation=(
        "m_leak = area/sqrt(T) ((1 - laminar) Cm(p_atm/pa) pa "
        "+ laminar Cm(0) (pa^2 - p_atm^2)/(6 bar))"
    ),
    parameters=(
        EffectParameter(
            "area", "m**2", 0.0, 0.0, 5e-7, (1e-8,), "effective area", "leakage.chamber_a_area"
        ),
        EffectParameter(
            "laminar", "", 0.0, 0.0, 1.0, (0.5,), "share of it that flows as through a gap",
            "leakage.chamber_a_laminar",
        ),
    ),
    source="thesis equation (4.15); Beater 2007, Pneumatic Drives",
    experiment=_HOLD,
    group=_OUT_OF.format("a"),
)  # fmt: skip
ROD_SEAL = Effect(
    id="leakage.rod-seal",
    block="chamber.b",
    rigs=_SERVO,
    statement="Chamber b leaks to the outside past the rod; the model holds it tight.",
    equation=(
        "m_leak = area/sqrt(T) ((1 - laminar) Cm(p_atm/pb) pb "
        "+ laminar Cm(0) (pb^2 - p_atm^2)/(6 bar))"
    ),
    parameters=(
        EffectParameter(
            "area", "m**2", 0.0, 0.0, 5e-7, (1e-8,), "effective area", "leakage.rod_seal_area"
        ),
        EffectParameter(
            "laminar", "", 0.0, 0.0, 1.0, (0.5,), "share of it that flows as through a gap",
            "leakage.rod_seal_laminar",
        ),
    ),
    source="thesis equation (4.15); Richer and Hurmuzlu 2000",
    experiment=_HOLD,
    group=_OUT_OF.format("b"),
)  # fmt: skip
_OPENING = "Chamber {} leaks through a gap that opens under pressure; the model holds it tight."
PRESSURE_OPENING_A, PRESSURE_OPENING_B = (
    Effect(
        id=f"leakage.pressure-opening-{chamber}",
        block=f"chamber.{chamber}",
        rigs=_SERVO,
        statement=_OPENING.format(chamber),
        equation=f"m_leak = coefficient ((p{chamber} - p_atm) / 1 bar)^exponent",
        parameters=(
            EffectParameter(
                "coefficient", "kg/s", 0.0, 0.0, 1e-3, (1e-6,), "leak at 1 bar gauge",
                f"leakage.opening_{chamber}_coefficient",
            ),
            EffectParameter(
                "exponent", "", 1.25, 0.5, 2.5, (0.9, 1.8), "power of the gauge pressure",
                f"leakage.opening_{chamber}_exponent",
            ),
        ),
        source="fit to leak-down recordings of printed chambers, Zillen 2021",
        experiment=_EXPERIMENT,
        group=_OUT_OF.format(chamber),
    )
    for chamber in ("a", "b")
)  # fmt: skip
LEAK_BY_POSITION = Effect(
    id="leakage.position",
    block="chamber.a",
    rigs=_SERVO,
    statement=(
        "A worn zone of the bore leaks more past the piston; the model holds it tight everywhere."
    ),
    equation=(
        "m_ab = (conductance exp(-((x/stroke - centre)/width)^2) + elsewhere) (pa^2 - pb^2), "
        "hole as in leakage.cross-piston"
    ),
    parameters=(
        EffectParameter(
            "conductance", "kg/(s*Pa**2)", 0.0, 0.0, 5e-15, (1e-16,), "in the middle of the zone",
            "leakage.worn_conductance",
        ),
        EffectParameter(
            "centre", "", 0.5, 0.0, 1.0, (0.3, 0.7), "of the zone along the stroke",
            "leakage.worn_centre",
        ),
        EffectParameter(
            "width", "", 0.1, 0.02, 0.5, (0.1,), "of the zone along the stroke",
            "leakage.worn_width",
        ),
        EffectParameter(
            "elsewhere", "kg/(s*Pa**2)", 0.0, 0.0, 2e-15, (1e-18,), "in the rest of the bore",
            "leakage.unworn_conductance",
        ),
        _HOLE,
    ),
    source="scratched or worn bores; form of Richer and Hurmuzlu 2000",
    experiment="hold at several places of the stroke under a pressure difference",
    group=_PAST_PISTON,
)  # fmt: skip
LEAK_BY_VELOCITY = Effect(
    id="leakage.velocity",
    block="chamber.a",
    rigs=_SERVO,
    statement="The seal lifts and leaks more while it slides; the model holds it tight.",
    equation="m_ab = (conductance |v| + at_rest) (pa^2 - pb^2), hole as in leakage.cross-piston",
    parameters=(
        EffectParameter(
            "conductance", "kg/(m*Pa**2)", 0.0, 0.0, 2e-14, (3e-16,), "per speed",
            "leakage.moving_conductance",
        ),
        EffectParameter(
            "at_rest", "kg/(s*Pa**2)", 0.0, 0.0, 2e-15, (1e-18,), "the same of a seal at rest",
            "leakage.lifted_conductance",
        ),
        _HOLE,
    ),
    source="film lubrication of lip seals; Beater 2007",
    experiment="run at several constant speeds under one pressure difference",
    group=_PAST_PISTON,
)  # fmt: skip
EFFECTS = (
    *LEAKS,
    CROSS_PISTON,
    CHAMBER_A,
    ROD_SEAL,
    PRESSURE_OPENING_A,
    PRESSURE_OPENING_B,
    LEAK_BY_POSITION,
    LEAK_BY_VELOCITY,
)
