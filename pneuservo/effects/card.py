"""What the analogue card may do beyond its nominal figures, stage by stage.

V1 and V2 are the differentiators' outputs, S the surface, u the output of the card. A relative
error e makes of a figure f the figure (1 + e) f.
"""

from pneuservo.effects.effect import Effect, EffectParameter

KIND = "analogue-card"
_RIGS = (KIND,)
_CIRCUIT = "circuit analysis of the stage; thesis chapter 9"
_SHEET = "data sheet CA3140, Intersil FN957; circuit analysis of the stage"

_LOSSES = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 7.0, 8.0, 9.0, 10.0)
"""Close to each other: a limit that no sample reaches has no slope to start from [V]."""

_STAGES = {1: ("first", "velocity"), 2: ("second", "acceleration")}


def _gain(stage: int) -> Effect:
    name, tap = _STAGES[stage]
    return Effect(
        id=f"card.differentiator-gain-{stage}",
        block="card.differentiator",
        rigs=_RIGS,
        statement=(
            f"The {tap} tap is too large or too small: capacitor or resistor of the {name} "
            "differentiator is off by more than its tolerance; the model has the nominal one."
        ),
        equation=f"RC{stage} = (1 + error) RC{stage}_nominal, and one of its breaks with it",
        parameters=(EffectParameter("error", "", 0.0, -0.95, 5.0, (-0.1, 0.1), "relative, of RC"),),
        source=_CIRCUIT,
        experiment=f"measure capacitor and resistor of the {name} differentiator",
    )


def _rolloff(stage: int) -> Effect:
    name, tap = _STAGES[stage]
    return Effect(
        id=f"card.differentiator-rolloff-{stage}",
        block="card.differentiator",
        rigs=_RIGS,
        statement=(
            f"A break of the {name} differentiator is off, so that the {tap} tap lags more or "
            "less at high frequency; the model has both breaks at the nominal frequency."
        ),
        equation=f"V{stage} = -s RC{stage} / ((1 + s/w0) (1 + s (1 + change)/w0)) of its input",
        parameters=(
            EffectParameter(
                "change", "", 0.0, -0.99, 20.0, (-0.5, 1.0), "relative, of one time constant"
            ),
        ),
        source=_CIRCUIT,
        experiment=f"sweep a sine from 0.1 to 5 kHz through the {name} differentiator",
    )


CAPACITOR_LEAK = Effect(
    id="card.capacitor-leak",
    block="card.differentiator",
    rigs=_RIGS,
    statement=(
        "The input capacitor of a differentiator leaks, so that its tap follows the input itself "
        "as well; the model has a capacitor without leakage."
    ),
    equation="V = -(s RC + ratio) / ((1 + s/w0)^2) of its input, ratio first = R/Rleak, or second",
    parameters=(
        EffectParameter("first", "", 0.0, -0.2, 20.0, (0.05,), "R over leakage resistance, first"),
        EffectParameter("second", "", 0.0, -0.2, 20.0, (0.0,), "the same, second differentiator"),
    ),
    source=_CIRCUIT,
    experiment="hold the transducer at two constant voltages and compare the taps",
)
OPAMP_BANDWIDTH = Effect(
    id="card.opamp-bandwidth",
    block="card.differentiator",
    rigs=_RIGS,
    statement=(
        "The op-amps have less bandwidth than their type, which adds a lag in proportion to the "
        "noise gain of a stage; the model has that of the type."
    ),
    equation="H = H0 / (1 + s (time + 1/(2 pi GBW)) (1 + abs(Zf/Zi)))",
    parameters=(
        EffectParameter(
            "time", "s", 0.0, 0.0, 1e-5, (3e-7,), "added to the op-amp's 1/(2 pi gain-bandwidth)"
        ),
    ),
    source=_SHEET,
    experiment="sweep a sine from 0.1 to 5 kHz through each stage",
)
OPAMP_SLEW = Effect(
    id="card.opamp-slew",
    block="card.boundary-layer",
    rigs=_RIGS,
    statement=(
        "The op-amps cannot change their output as fast as the signal asks: the model has no "
        "limit of the rate."
    ),
    equation="abs(dV/dt) <= 1/time, of every stage's op-amp; time = 0 is no limit",
    parameters=(
        EffectParameter(
            "time", "s/V", 0.0, 0.0, 2e-3, (5e-6, 2e-5, 1e-4, 5e-4), "one over the slew rate"
        ),
    ),
    source=_SHEET,
    experiment="step the demand and watch the outputs with an oscilloscope",
)
OFFSET = Effect(
    id="card.offset",
    block="card.surface",
    rigs=_RIGS,
    statement=(
        "A stage is shifted by a constant voltage beyond what its op-amp's data sheet allows; "
        "the model allows no more."
    ),
    equation=(
        "V1 = V1_ideal + differentiator_1, V2 = V2_ideal + differentiator_2, "
        "S = S_ideal + surface, u = gain (S + output)"
    ),
    parameters=(
        EffectParameter("surface", "V", 0.0, -5.0, 5.0, (0.1,), "at the surface"),
        EffectParameter("differentiator_1", "V", 0.0, -5.0, 5.0, (0.0,), "at the velocity tap"),
        EffectParameter("differentiator_2", "V", 0.0, -5.0, 5.0, (0.0,), "at the acceleration tap"),
        EffectParameter("output", "V", 0.0, -5.0, 5.0, (0.0,), "ahead of the gain of the output"),
    ),
    source=_SHEET,
    experiment="ground the inputs and measure every tap",
)
WEIGHT_LOADING = Effect(
    id="card.weight-loading",
    block="card.surface",
    rigs=_RIGS,
    statement=(
        "A state enters the surface with less weight than set (negative: with more): its "
        "potentiometer is loaded, or its wiper has resistance; the model has the weight set."
    ),
    equation=(
        "S = (1 - displacement) w_x (Vd - Vx) + (1 - velocity) w_v V1 - (1 - acceleration) w_a V2"
    ),
    parameters=(
        EffectParameter("displacement", "", 0.0, -2.0, 1.0, (0.1,), "lost share of w_x"),
        EffectParameter("velocity", "", 0.0, -2.0, 1.0, (0.0,), "lost share of w_v"),
        EffectParameter("acceleration", "", 0.0, -2.0, 1.0, (0.0,), "lost share of w_a"),
    ),
    source=_CIRCUIT,
    experiment="measure from wiper to summing node, the card switched off, at two settings",
)
INTERMEDIATE_CLIPPING = Effect(
    id="card.intermediate-clipping",
    block="card.differentiator",
    rigs=_RIGS,
    statement=(
        "A differentiator's output is cut off below the swing of its op-amp, and stays wrong for "
        "milliseconds; the model has the full swing."
    ),
    equation=(
        "-(swing - loss - imbalance) <= V1, V2 <= swing - loss, until the charge that was missed "
        "is made good"
    ),
    parameters=(
        EffectParameter("loss", "V", 0.0, 0.0, 15.0, _LOSSES, "of the upper swing"),
        EffectParameter("imbalance", "V", 0.0, -15.0, 15.0, (0.0,), "more of the lower swing"),
    ),
    source=_CIRCUIT,
    experiment="step the transducer input and look at both taps",
)
SUPPLY_SAG = Effect(
    id="card.supply-sag",
    block="card.differentiator",
    rigs=_RIGS,
    statement=(
        "A supply of the card is lower than it should be, which lowers what every op-amp can "
        "give; the model has the nominal supplies."
    ),
    equation="-(swing - drop - imbalance) <= V <= swing - drop at every stage's op-amp",
    parameters=(
        EffectParameter("drop", "V", 0.0, 0.0, 15.0, _LOSSES, "missing of the upper rail"),
        EffectParameter("imbalance", "V", 0.0, -15.0, 15.0, (0.0,), "more of the lower rail"),
    ),
    source=_CIRCUIT,
    experiment="measure both rails on the card while it works",
)
GROUND_HUM = Effect(
    id="card.ground-hum",
    block="card.surface",
    rigs=_RIGS,
    statement=(
        "The ground of the summer moves with the mains and with the valve's current; the model "
        "has a quiet ground."
    ),
    equation="S = S_ideal + sine sin(2 pi f t) + cosine cos(2 pi f t) + share u, f = frequency",
    parameters=(
        EffectParameter("sine", "V", 0.0, -2.0, 2.0, (0.05,), "hum in phase with t = 0"),
        EffectParameter("cosine", "V", 0.0, -2.0, 2.0, (0.0,), "hum a quarter period ahead"),
        EffectParameter("share", "", 0.0, -0.5, 0.5, (0.0,), "of the output, as ground shift"),
        EffectParameter("frequency", "Hz", 50.0, 45.0, 65.0, (50.0, 60.0), "of the mains"),
    ),
    source="Ott 2009, Electromagnetic Compatibility Engineering, common-impedance coupling",
    experiment="disconnect the valve and repeat; record with the inputs grounded",
)
BOUNDARY_SLOPE = Effect(
    id="card.boundary-slope",
    block="card.boundary-layer",
    rigs=_RIGS,
    statement=(
        "The output rises more or less steeply with the surface than it is set to; the model has "
        "the gain of the nominal boundary layer."
    ),
    equation="u = (1 + change) gain S within the level",
    parameters=(EffectParameter("change", "", 0.0, -0.99, 50.0, (-0.3, 0.5, 5.0), "of the gain"),),
    source=_CIRCUIT,
    experiment="ramp the surface slowly through zero and plot output over surface",
)
RAIL_ASYMMETRY = Effect(
    id="card.rail-asymmetry",
    block="card.relay",
    rigs=_RIGS,
    statement=(
        "The levels of the output differ between its signs, or from the level set; the model has "
        "one level for both."
    ),
    equation="-(1 + negative) level <= u <= (1 + positive) level",
    parameters=(
        EffectParameter("positive", "", 0.0, -0.95, 1.0, (-0.1, 0.1), "of the upper level"),
        EffectParameter("negative", "", 0.0, -0.95, 1.0, (0.0,), "of the lower level"),
    ),
    source=_CIRCUIT,
    experiment="drive the surface to either side and measure the output",
)
SWITCH_HYSTERESIS = Effect(
    id="card.switch-hysteresis",
    block="card.relay",
    rigs=_RIGS,
    statement=(
        "The output switches back later than it switched over, by a fixed voltage; the model "
        "switches at the same voltage both ways."
    ),
    equation="u = gain (S + width sgn(last u)) within the level",
    parameters=(EffectParameter("width", "V", 0.0, 0.0, 2.0, (0.01, 0.1), "to either side"),),
    source="Horowitz and Hill, The Art of Electronics, Schmitt trigger",
    experiment="drive the surface with triangles of two slopes: a delay grows with the slope",
)
OUTPUT_LOAD = Effect(
    id="card.output-load",
    block="card.relay",
    rigs=_RIGS,
    statement=(
        "The output is lower at the plug than at the op-amp, in the layer and at the level "
        "alike: source resistance into the load; the model has an ideal source."
    ),
    equation="u = (1 - loss) u_ideal",
    parameters=(EffectParameter("loss", "", 0.0, 0.0, 0.95, (0.05,), "share of the output"),),
    source=_CIRCUIT,
    experiment="measure the output at the op-amp and at the plug",
)
EFFECTS = (
    _gain(1), _gain(2), CAPACITOR_LEAK, OFFSET, WEIGHT_LOADING, RAIL_ASYMMETRY, OPAMP_SLEW,
    SUPPLY_SAG, INTERMEDIATE_CLIPPING, BOUNDARY_SLOPE, SWITCH_HYSTERESIS, OUTPUT_LOAD, GROUND_HUM,
    _rolloff(1), _rolloff(2), OPAMP_BANDWIDTH,
)  # fmt: skip
