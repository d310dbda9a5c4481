"""What the gas in a closed chamber does beyond the polytropic law."""

from pneuservo.effects.effect import Effect, EffectParameter

HEAT_TRANSFER = Effect(
    id="chamber.heat-transfer",
    block="dead-volume",
    rigs=("dead-volume",),
    statement=(
        "The gas warms and cools and settles to the wall temperature; "
        "the model holds its temperature constant."
    ),
    equation=(
        "V dp/dt = g R (m_in T_in - m_out T) - V (p/T) (T - T_wall)/time_constant, "
        "T(0) = T_wall + excess"
    ),
    parameters=(
        EffectParameter(
            "excess", "K", 0.0, -60.0, 60.0, (2.0, -2.0), "gas above wall temperature at first"
        ),
        EffectParameter(
            "time_constant", "s", 0.0, 0.0, 200.0, (2.0, 40.0), "thermal settling time"
        ),
    ),
    source="Carneiro and Gomes de Almeida 2006, Proc. IMechE I 220; thesis equation (4.10)",
    experiment=(
        "repeat the fill in steps and log the gas temperature: settling ends at a level, "
        "a leak goes on to the atmosphere"
    ),
)
EFFECTS = (HEAT_TRANSFER,)
