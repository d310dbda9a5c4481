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
    block="sensor.force",
    rigs=("seal-tester",),
    statement="The load cell reads a factor off; the model takes it as true.",
    equation="F_measured = (1 + gain) F",
    parameters=(EffectParameter("gain", "", 0.0, -0.05, 0.05, (0.005,), "relative gain error"),),
    source="Doebelin, Measurement Systems",
    experiment="hang two known weights on the load cell",
)
EFFECTS = (PRESSURE_DRIFT, PRESSURE_GAIN, FORCE_GAIN)
