"""Errors of the transducers."""

from pneuservo.effects.effect import Effect, EffectParameter

PRESSURE_DRIFT = Effect(
    id="sensor.pressure-drift",
    block="sensor.pressure",
    rigs=("dead-volume",),
    statement="The pressure reading drifts; the model takes it as true.",
    equation="p_measured = p + rate t",
    parameters=(EffectParameter("rate", "Pa/s", 0.0, -30.0, 30.0, (-5.0, 5.0), "drift"),),
    source="transducer data sheets: thermal zero shift of 0.01 to 0.1 % of range per minute",
    experiment="log the vented transducer for as long; or fill to another pressure: a drift stays",
)
PRESSURE_GAIN = Effect(
    id="sensor.pressure-gain-a",
    block="sensor.pressure",
    rigs=("seal-tester",),
    statement="The pressure reading is off by a factor; the model takes it as true.",
    equation="p_gauge = (1 + gain) p_gauge,measured",
    parameters=(EffectParameter("gain", "", 0.0, -0.05, 0.05, (0.005,), "relative gain error"),),
    source="Doebelin, Measurement Systems",
    experiment="compare with a second pressure gauge at two pressures",
)
FORCE_GAIN = Effect(
    id="sensor.force-gain",
    block="load",  # where the cell stands
    rigs=("seal-tester",),
    statement="The load cell reads a factor off; the model takes it as true.",
    equation="F_measured = (1 + gain) F",
    parameters=(EffectParameter("gain", "", 0.0, -0.05, 0.05, (0.005,), "relative gain error"),),
    source="Doebelin, Measurement Systems",
    experiment="hang two known weights on the load cell",
)
_RIGS = ("single-axis",)
_DISPLACEMENT, _PRESSURE = "sensor.displacement", "sensor.pressure"
_DATA_SHEET = "transducer data sheets, thesis section 3.2; Doebelin, Measurement Systems"
POSITION_GAIN = Effect(
    id="sensor.position-gain",
    block=_DISPLACEMENT,
    rigs=_RIGS,
    statement="The displacement reads a factor off; the model takes it as true.",
    equation="x_read = (1 + gain) x",
    parameters=(
        EffectParameter(
            "gain", "", 0.0, -0.1, 0.1, (0.01,), "relative error", "sensor.displacement_gain"
        ),
    ),
    source=_DATA_SHEET,
    experiment="drive from stop to stop: 30.0 mm",
)
POSITION_OFFSET = Effect(
    id="sensor.position-offset",
    block=_DISPLACEMENT,
    rigs=_RIGS,
    statement="The displacement's zero is off; the model takes it as true.",
    equation="x_read = x + offset",
    parameters=(
        EffectParameter(
            "offset",
            "m",
            0.0,
            -3e-3,
            3e-3,
            (3e-4,),
            "of the reading",
            "sensor.displacement_offset",
            1e-5,
        ),
    ),
    source=_DATA_SHEET,
    experiment="drive to both stops",
)
POSITION_NONLINEARITY = Effect(
    id="sensor.position-nonlinearity",
    block=_DISPLACEMENT,
    rigs=_RIGS,
    statement="The displacement reads along a curve; the model takes it as true.",
    equation=(
        "x_read = x + bow sin(pi x/stroke) + first sin(2 pi x/stroke) + second sin(4 pi x/stroke)"
    ),
    parameters=(
        EffectParameter(
            "bow", "m", 0.0, -6e-4, 6e-4, (5e-5,), "amplitude, half a wave", "sensor.bow"
        ),
        EffectParameter(
            "first", "m", 0.0, -6e-4, 6e-4, (5e-5,), "amplitude, one wave", "sensor.first_harmonic"
        ),
        EffectParameter(
            "second", "m", 0.0, -6e-4, 6e-4, (2e-5,), "amplitude, two waves",
            "sensor.second_harmonic",
        ),
    ),
    source="linearity 0.1 to 0.5 % of the stroke, thesis section 3.2",
    experiment="calibrate against gauge blocks, or compare with an accelerometer",
)  # fmt: skip
POSITION_LAG = Effect(
    id="sensor.position-lag",
    block=_DISPLACEMENT,
    rigs=_RIGS,
    statement="The displacement reads late; the model takes it as true.",
    equation="time x_read' = x - x_read",
    parameters=(
        EffectParameter(
            "time", "s", 0.0, 0.0, 0.01, (1e-3,), "of the lag", "sensor.displacement_lag", 3e-5
        ),
    ),
    source="demodulation filter 500 Hz; thesis chapter 8: the filter slows the limit cycle",
    experiment="compare with an accelerometer",
)
POSITION_WIPER = Effect(
    id="sensor.position-wiper",
    block=_DISPLACEMENT,
    rigs=_RIGS,
    statement="The displacement transducer's wiper has play; the model takes the reading as true.",
    equation="x_read = play(x, half_width)",
    parameters=(
        EffectParameter(
            "half_width", "m", 0.0, 0.0, 3e-4, (2e-5,), "half width of the play",
            "sensor.wiper_play",
        ),
    ),
    source="thesis section 9.2: a noisier transducer; potentiometer data sheets 5 to 50 um",
    experiment="reverse slowly many times at one place",
)  # fmt: skip
QUANTISATION = Effect(
    id="sensor.quantisation",
    block=_DISPLACEMENT,
    rigs=_RIGS,
    statement="The readings come in steps; the model takes them as exact.",
    equation="x_read = displacement round(x/displacement), p_read likewise with pressure",
    parameters=(
        EffectParameter(
            "displacement", "m", 0.0, 0.0, 2e-4, (2e-5,), "step of the displacement",
            "sensor.displacement_step",
        ),
        EffectParameter(
            "pressure", "Pa", 0.0, 0.0, 2e4, (2e3,), "step of the pressures",
            "sensor.pressure_step",
        ),
    ),
    source="12-bit conversion, thesis section 3.2: 7.3 um and 0.5 kPa",
    experiment="histogram of the readings",
)  # fmt: skip
PRESSURE_OFFSET_A, PRESSURE_OFFSET_B = (
    Effect(
        id=f"sensor.pressure-offset-{chamber}",
        block=_PRESSURE,
        rigs=_RIGS,
        statement=f"The pressure of chamber {chamber} reads off zero; the model takes it as true.",
        equation="p_read = p + offset",
        parameters=(
            EffectParameter(
                "offset", "Pa", 0.0, -5e4, 5e4, (2e3,), "of the reading",
                f"sensor.pressure_{chamber}_offset",
            ),
        ),
        source=_DATA_SHEET,
        experiment="vent both chambers; swap the transducers",
    )
    for chamber in ("a", "b")
)  # fmt: skip
PRESSURE_GAIN_A, PRESSURE_GAIN_B = (
    Effect(
        id=f"sensor.pressure-gain-{chamber}",
        block=_PRESSURE,
        rigs=_RIGS,
        statement=(
            f"The pressure of chamber {chamber} reads a factor off; the model takes it as true."
        ),
        equation="p_read = (1 + gain) p",
        parameters=(
            EffectParameter(
                "gain", "", 0.0, -0.1, 0.1, (0.005,), "relative error",
                f"sensor.pressure_{chamber}_gain",
            ),
        ),
        source=_DATA_SHEET,
        experiment="repeat at 5, 7 and 9 bar; swap the transducers",
    )
    for chamber in ("a", "b")
)  # fmt: skip
PRESSURE_STATIC = Effect(
    id="sensor.pressure-static",
    block=_PRESSURE,
    rigs=_RIGS,
    statement=(
        "The pressures are read in the pipe, less the dynamic pressure of the flow; "
        "the model takes them as true."
    ),
    equation="p_read = p - share rho w^2/2, w = m/(rho A_pipe)",
    parameters=(
        EffectParameter(
            "share", "", 0.0, -2.0, 2.0, (0.5,), "of the dynamic pressure", "sensor.static_share"
        ),
    ),
    source="thesis section 3.2.1",
    experiment="lock the piston: the force seems to change with the flow",
)
PRESSURE_LAG = Effect(
    id="sensor.pressure-lag",
    block=_PRESSURE,
    rigs=_RIGS,
    statement="The pressures read late; the model takes them as true.",
    equation="time p_read' = p - p_read",
    parameters=(
        EffectParameter(
            "time", "s", 0.0, 0.0, 0.02, (2e-3, 1e-4), "of the lag", "sensor.pressure_lag", 5e-5
        ),
    ),
    source="tube to the tap and amplifier, 0.2 to 5 ms; Doebelin",
    experiment="tap both transducers with one sudden pressure",
)
CLOCK = Effect(
    id="sensor.clock",
    block=_PRESSURE,
    rigs=_RIGS,
    statement=(
        "The pressures are sampled at another moment than the displacement; "
        "the model takes all at once."
    ),
    equation="p_read(t) = p(t + skew)",
    parameters=(
        EffectParameter(
            "skew",
            "s",
            0.0,
            -0.02,
            0.02,
            (1e-3, -1e-3),
            "of the pressures",
            "sensor.pressure_skew",
            2e-5,
        ),
    ),
    source="multiplexed conversion 8 to 60 us per channel; wrong triggers",
    experiment="feed one signal to every channel",
)
NOISE_COLOUR = Effect(
    id="sensor.noise-colour",
    block=_PRESSURE,
    rigs=_RIGS,
    statement="Mains hum sits on the pressures; the model has none.",
    equation="p_read = p + amplitude sin(2 pi frequency t + phase)",
    parameters=(
        EffectParameter("amplitude", "Pa", 0.0, 0.0, 2e4, (1e3,), "of the hum", "sensor.hum"),
        EffectParameter(
            "frequency", "Hz", 50.0, 10.0, 500.0, (50.0,), "of the hum", "sensor.hum_frequency"
        ),
        EffectParameter(
            "phase", "rad", 0.0, -6.3, 6.3, (0.0, 2.1, 4.2), "at the start", "sensor.hum_phase"
        ),
    ),
    source="mains and carrier residue; Doebelin",
    experiment="record with the air off",
)
GROUND_SHIFT = Effect(
    id="sensor.ground-shift",
    block=_PRESSURE,
    rigs=_RIGS,
    statement=(
        "The valve's current shifts the ground of the pressures' readings; "
        "the model takes them as true."
    ),
    equation="p_a,read = p_a + shift_a u, p_b,read = p_b + shift_b u",
    parameters=tuple(
        EffectParameter(
            f"shift_{chamber}", "Pa/V", 0.0, -5e3, 5e3, (500.0, -500.0),
            f"of the reading of chamber {chamber}", f"sensor.ground_shift_{chamber}",
        )
        for chamber in ("a", "b")
    ),
    source="common lead of 0.1 ohm and 0.5 A at full command: 50 mV, 1 kPa/V at 10 bar to 10 V",
    experiment="step the command with the air off",
)  # fmt: skip
EFFECTS = (
    PRESSURE_DRIFT,
    PRESSURE_GAIN,
    FORCE_GAIN,
    POSITION_GAIN,
    POSITION_OFFSET,
    POSITION_NONLINEARITY,
    POSITION_LAG,
    POSITION_WIPER,
    QUANTISATION,
    PRESSURE_OFFSET_A,
    PRESSURE_OFFSET_B,
    PRESSURE_GAIN_A,
    PRESSURE_GAIN_B,
    PRESSURE_STATIC,
    PRESSURE_LAG,
    CLOCK,
    NOISE_COLOUR,
    GROUND_SHIFT,
)
