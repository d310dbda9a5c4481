"""What the valve's edges do beyond tabulated orifices."""

from pneuservo.effects.effect import Effect, EffectParameter

_RIGS = ("single-axis",)
_BLOCK = "valve.flow"
_ERROR = "relative error of the area at"
_LEAST_OVERLAP = 5e-4
"""Edges are ground to about a micrometre, of half a millimetre of travel 0.2 % (0.6 % measured,
thesis section 4.3.1); far less is what laws of flow at openings of some millivolts differ by."""

OVERLAP = Effect(
    id="valve.overlap",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The spool has to travel a little before a path opens; the model opens at once.",
    equation="opening = sgn(xs) max(|xs| - lap, 0)",
    parameters=(
        EffectParameter(
            "lap", "", 0.0, 0.0, 0.08, (0.01, 0.002), "dead travel", "valve.overlap", _LEAST_OVERLAP
        ),
    ),
    source="thesis section 4.3.1: 0.6 % of the command; McCloy and Martin 1980",
    experiment="step the command up and down by 0.2 to 2 % near null: one branch with a flat",
)
NULL_LEAKAGE = Effect(
    id="valve.null-leakage",
    block=_BLOCK,
    rigs=_RIGS,
    statement="All four paths leak while the spool is near its middle; the model seals them.",
    equation=(
        "A_leak = share A exp(-|xs|/width), on every path; "
        "m = A_leak/sqrt(T) ((1 - laminar) Cm(Pd/Pu) Pu + laminar Cm(0) (Pu^2 - Pd^2)/(6 bar))"
    ),
    parameters=(
        EffectParameter(
            "share", "", 0.0, 0.0, 0.05, (0.01,), "leak at null over the full area",
            "valve.null_leakage",
        ),
        EffectParameter(
            "width", "", 0.02, 0.005, 0.1, (0.02,), "opening over which it fades",
            "valve.null_leakage_width",
        ),
        EffectParameter(
            "laminar", "", 0.0, 0.0, 1.0, (0.5,), "share of it that flows as through a gap",
            "valve.null_leakage_laminar",
        ),
    ),
    source="Eryilmaz and Wilson 2000, J. Dyn. Syst. Meas. Control; ISO 6358",
    experiment="hold near null with the piston locked and log both pressures for 60 s",
)  # fmt: skip
CRITICAL_RATIO = Effect(
    id="valve.critical-ratio",
    block=_BLOCK,
    rigs=_RIGS,
    statement=(
        "The valve chokes at another pressure ratio than an ideal nozzle; the model takes 0.528."
    ),
    equation="m = C Pu sqrt(1 - ((Pr - ratio)/(1 - ratio))^2), choked below ratio",
    parameters=(
        EffectParameter(
            "ratio", "", 0.0, 0.0, 0.52, (0.3,), "critical ratio b; 0 for the nozzle",
            "valve.critical_ratio", inverse=True,
        ),
    ),
    source="ISO 6358; Sanville 1971; thesis section 4.3.1: choking between 0.49 and 0.33",
    experiment="charge a locked chamber from the atmosphere at several openings",
)  # fmt: skip
LAMINAR_TAIL = Effect(
    id="valve.laminar-tail",
    block=_BLOCK,
    rigs=_RIGS,
    statement=(
        "Close to equal pressures the flow is laminar and linear; the model follows a root."
    ),
    equation="m = m0/(1 + (width/(1 - Pr))^(sharpness/2))^(1/sharpness)",
    parameters=(
        EffectParameter(
            "width", "", 0.0, 0.0, 0.2, (0.03, 0.005), "pressure drop below which it is laminar",
            "valve.laminar_width",
        ),
        EffectParameter(
            "sharpness", "", 2.0, 1.0, 12.0, (2.0,), "of the change", "valve.laminar_sharpness"
        ),
    ),
    source="Merritt 1967; blended as in Churchill and Usagi 1972",
    experiment="charge a locked chamber until it stands at the supply pressure",
)  # fmt: skip
PORT_ASYMMETRY = Effect(
    id="valve.port-asymmetry",
    block=_BLOCK,
    rigs=_RIGS,
    statement=(
        "Exhaust and supply edges, or the two ports, differ in area from the calibration; "
        "the model keeps the calibrated areas."
    ),
    equation="A = A0 (1 + exhaust [exhaust paths]) (1 + side [port b])",
    parameters=(
        EffectParameter(
            "exhaust", "", 0.0, -0.4, 0.4, (0.05,), "excess of the exhaust paths",
            "valve.exhaust_excess",
        ),
        EffectParameter(
            "side", "", 0.0, -0.4, 0.4, (0.05,), "excess of the paths of port b",
            "valve.side_excess",
        ),
    ),
    source="thesis table 4.1: 0.870, 0.870, 0.810, 0.795 mm^2",
    experiment="charge and vent a locked chamber through either port",
)  # fmt: skip
LINEARISER = Effect(
    id="spool.lineariser",
    block=_BLOCK,
    rigs=_RIGS,
    statement=(
        "The area does not grow in proportion to the opening; the model has it proportional."
    ),
    equation=(
        "A = A0 |xs| (1 + e(|xs|)), e through charge_low, charge_middle, charge_high or "
        "exhaust_low, exhaust_middle, exhaust_high at 5, 30 and 100 %"
    ),
    parameters=tuple(
        EffectParameter(
            f"{edge}_{place}", "", 0.0, -0.8, 0.8, (start,), f"{_ERROR} {opening}, {edge}",
            f"valve.{edge}_{place}",
        )
        for edge in ("charge", "exhaust")
        for place, opening, start in (
            ("low", "5 %", 0.1), ("middle", "30 %", 0.05), ("high", "100 %", 0.02)
        )
    ),
    source="valve data sheet: linearity 5 %; thesis section 4.3.1: up to 70 % below 20 % opening",
    experiment="charge and vent a locked chamber at ten openings, after a stop test",
)  # fmt: skip
REATTACHMENT = Effect(
    id="valve.reattachment",
    block=_BLOCK,
    rigs=_RIGS,
    statement=(
        "The jet clings to the wall at low pressure ratios and passes less or more; "
        "the model has one discharge coefficient."
    ),
    equation=(
        "Cd = Cd0 (1 - loss) while attached: from Pr < attach until Pr > detach; at_supply of the "
        "loss where the supply enters"
    ),
    parameters=(
        EffectParameter(
            "loss", "", 0.0, -0.4, 0.4, (0.1,), "discharge coefficient lost, or gained below 0",
            "valve.attached_loss",
        ),
        EffectParameter(
            "at_supply", "", 1.0, 0.0, 1.0, (1.0, 0.0), "share of it at the edges of the supply",
            "valve.attached_at_supply",
        ),
        EffectParameter(
            "attach", "", 0.4, 0.1, 0.95, (0.5, 0.3), "ratio at which it attaches",
            "valve.attach_ratio",
        ),
        EffectParameter(
            "detach", "", 0.6, 0.1, 0.99, (0.7,), "ratio at which it comes free",
            "valve.detach_ratio",
        ),
    ),
    source="Stenning 1955",
    experiment="sweep the pressure ratio slowly both ways at one opening",
)  # fmt: skip
UPSTREAM_TEMPERATURE = Effect(
    id="valve.upstream-temperature",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The supply air is warmer or colder than the room; the model has one temperature.",
    equation="m_supply = m sqrt(T/(T + difference))",
    parameters=(
        EffectParameter(
            "difference", "K", 0.0, -40.0, 40.0, (8.0,), "supply above room temperature",
            "valve.supply_warmth",
        ),
    ),
    source="thesis equation (4.15); section 4.3.3: another day's air",
    experiment="put a thermometer into the supply",
)  # fmt: skip
EXHAUST_BACK_PRESSURE = Effect(
    id="valve.exhaust-back-pressure",
    block=_BLOCK,
    rigs=_RIGS,
    statement="A silencer throttles the exhaust; the model exhausts freely.",
    equation="volume/(n R T) pe' = m_edge(p, pe) - area Cm(0) sqrt((pe^2 - p_atm^2)/T)",
    parameters=(
        EffectParameter(
            "area",
            "m**2",
            0.0,
            0.0,
            2e-5,
            (2e-6, 6e-6),
            "effective area of the silencer; 0 for none",
            "valve.exhaust_area",
            inverse=True,
        ),
        EffectParameter(
            "volume", "m**3", 2e-5, 3e-6, 3e-4, (2e-5,), "between both exhausts and the silencer",
            "valve.exhaust_volume",
        ),
    ),
    source="Beater 2007, Pneumatic Drives",
    experiment="take the silencer off, or tap the exhaust port",
)  # fmt: skip
EFFECTS = (
    OVERLAP,
    NULL_LEAKAGE,
    CRITICAL_RATIO,
    LAMINAR_TAIL,
    PORT_ASYMMETRY,
    LINEARISER,
    REATTACHMENT,
    UPSTREAM_TEMPERATURE,
    EXHAUST_BACK_PRESSURE,
)
