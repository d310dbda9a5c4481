"""What the spool of the servo valve does beyond a linear second-order reply."""

from pneuservo.effects.effect import Effect, EffectParameter

_RIGS = ("single-axis",)
_BLOCK = "valve.spool"

_LEAST_BIAS = 2e-4
"""A fiftieth of what data sheets allow; less is what a magnet that remembers leaves at null."""

NULL_BIAS = Effect(
    id="spool.null-bias",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The spool stands off its middle at zero command; the model centres it.",
    equation="xs = G(s) (u/5 V + bias)",
    parameters=(
        EffectParameter(
            "bias", "", 0.0, -0.03, 0.03, (0.005,), "opening at zero command",
            "spool.null_bias", least=_LEAST_BIAS,
        ),
    ),
    source="Merritt 1967, Hydraulic Control Systems; valve data sheet +-1 %",
    experiment="repeat with 5 kg added: a bias keeps its sign, a leak past the piston does not",
)  # fmt: skip
HYSTERESIS = Effect(
    id="spool.hysteresis",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The spool follows its command with play; the model has none.",
    equation="xs = G(s) play(u/5 V, half_width)",
    parameters=(
        EffectParameter(
            "half_width", "", 0.0, 0.0, 0.03, (0.006, 0.0015), "half width of the play",
            "spool.hysteresis",
        ),
    ),
    source="valve data sheet 1 %; Visintin 1994, Differential Models of Hysteresis",
    experiment="step the command up and down by 0.2 to 2 % near null: two parallel branches",
)  # fmt: skip
AMPLITUDE_BANDWIDTH = Effect(
    id="spool.amplitude-bandwidth",
    block=_BLOCK,
    rigs=_RIGS,
    statement=(
        "The spool is slower for large strokes because its motor's force is limited; "
        "the model is linear."
    ),
    equation="|xs''| <= acceleration",
    parameters=(
        EffectParameter(
            "acceleration", "1/s**2", 0.0, 0.0, 1e7, (2e5, 4e5, 8e5, 1.6e6, 3e6),
            "largest acceleration; 0 for no limit", "spool.acceleration_limit", inverse=True,
        ),
    ),
    source="valve data sheet: 500 Hz at 2.5 %, 135 Hz at full stroke; thesis section 3.1.1.2",
    experiment="frequency response of the spool at three amplitudes, without air",
)  # fmt: skip
SLEW = Effect(
    id="spool.slew",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The valve's driver cannot follow faster than a fixed rate; the model has no limit.",
    equation="xs = G(s) v; v follows u/5 V, |v'| <= rate",
    parameters=(
        EffectParameter(
            "rate", "1/s", 0.0, 0.0, 5e3, (100.0, 200.0, 400.0, 800.0, 1600.0),
            "full strokes per second; 0 for no limit", "spool.rate_limit", inverse=True,
        ),
    ),
    source="valve data sheet: 5 to 15 ms for the full stroke; Merritt 1967",
    experiment="compare small and large steps of the command",
)  # fmt: skip
DELAY = Effect(
    id="spool.delay",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The valve answers its command late; the model answers at once.",
    equation="xs(t) = G(s) u(t - time)/5 V",
    parameters=(
        EffectParameter(
            "time",
            "s",
            0.0,
            0.0,
            5e-3,
            (5e-4, 1.5e-3),
            "time before it answers",
            "spool.delay",
            least=5e-5,  # converters put out that much after they have sampled
        ),
    ),
    source="valve data sheet: below 1 ms",
    experiment="phase of the chamber pressures against the command over 20 to 200 Hz",
)
STICTION = Effect(
    id="spool.stiction",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The spool sticks after a rest until the command has moved on; the model slides.",
    equation=(
        "xs = G(s) (u/5 V - brake sgn(xs')); xs' = 0 while |u/5 V - xs| < breakaway "
        "(1 - exp(-rest/time)/2); brake is that without a rest"
    ),
    parameters=(
        EffectParameter(
            "breakaway", "", 0.0, 0.0, 0.05, (0.01, 0.003), "command error it does not follow",
            "spool.stiction",
        ),
        EffectParameter(
            "time", "s", 0.0, 0.0, 100.0, (0.3, 30.0), "rest over which it silts up",
            "spool.stiction_time",
        ),
    ),
    source="Merritt 1967, Hydraulic Control Systems",
    experiment="repeat one step after 1, 10, 100 s of rest with the piston locked",
)  # fmt: skip
FLOW_FORCE = Effect(
    id="spool.flow-force",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The flow through its edges pulls the spool shut; the model feels no flow.",
    equation="xs = G(s) (u/5 V - shift xs (drop_a + drop_b)/(2 Ps))",
    parameters=(
        EffectParameter(
            "shift", "", 0.0, 0.0, 0.1, (0.02,), "closing shift at full opening and pressure",
            "spool.flow_force",
        ),
    ),
    source="Blackburn, Reethof, Shearer 1960, Fluid Power Control",
    experiment="measure the spool with and without air",
)  # fmt: skip
TRAVEL_STOP = Effect(
    id="spool.travel-stop",
    block=_BLOCK,
    rigs=_RIGS,
    statement="The spool stops before full opening; the model opens fully both ways.",
    equation="retracting - 1 <= xs <= 1 - extending",
    parameters=(
        EffectParameter(
            "extending", "", 0.0, 0.0, 0.4, (0.1,), "travel missing on the side that extends",
            "spool.extending_stop_loss",
        ),
        EffectParameter(
            "retracting", "", 0.0, 0.0, 0.4, (0.1,), "travel missing on the side that retracts",
            "spool.retracting_stop_loss",
        ),
    ),
    source="textbook; valve assembly",
    experiment="charge a locked chamber at 80, 90 and 100 % of the command, both ways",
)  # fmt: skip
EFFECTS = (
    NULL_BIAS,
    HYSTERESIS,
    AMPLITUDE_BANDWIDTH,
    SLEW,
    DELAY,
    STICTION,
    FLOW_FORCE,
    TRAVEL_STOP,
)
