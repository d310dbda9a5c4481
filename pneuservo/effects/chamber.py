"""What the gas in a closed chamber does beyond the polytropic law."""

import math

from pneuservo.effects.effect import Effect, EffectParameter
from pneuservo.plant.compilation import compiled


@compiled
def settling_rate(time, pressure, temperature, excess, time_constant):
    """Return the pressure rate of gas that settles to the wall temperature [Pa/s]."""
    return -pressure / temperature * excess / time_constant * math.exp(-time / time_constant)


HEAT_TRANSFER = Effect(
    id="chamber.heat-transfer",
    block="dead-volume",
    rigs=("dead-volume",),
    statement=(
        "The gas settles to the wall temperature after filling or venting; "
        "the model holds its temperature constant."
    ),
    equation="dp/dt = -(p/T) (excess/time_constant) exp(-t/time_constant)",
    parameters=(
        EffectParameter(
            "excess", "K", 0.0, -60.0, 60.0, (2.0, -2.0), "gas above wall temperature at the start"
        ),
        EffectParameter("time_constant", "s", 1.0, 0.1, 200.0, (1.0, 40.0), "thermal settling time"),
    ),
    source="Carneiro and Gomes de Almeida 2006, Proc. IMechE I 220; thesis equation (4.10)",
    experiment=(
        "repeat the fill in steps and log the gas temperature: settling ends at a level, "
        "a leak goes on to the atmosphere"
    ),
)
EFFECTS = (HEAT_TRANSFER,)
