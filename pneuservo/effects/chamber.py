"""What the gas in a chamber does beyond the polytropic law."""

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
_LEAST_CONDUCTANCE = 0.01
"""Chambers of this size have 0.04 to 0.4 W/K (Carneiro and Gomes de Almeida 2006: 20 to 200 W/m2K);
far below that there is no exchange to speak of, and the gas balances its energy alone."""
_STOP_TEST = (
    "stop test: lock the piston, open the valve for 0.1 s, close it and watch the pressure for "
    "2 s; the same for venting"
)
_TO_THE_WALLS = "heat to the walls"
SERVO_HEAT_TRANSFER = Effect(
    id="chamber.heat-transfer",
    block="chamber.a",
    rigs=("single-axis",),
    statement=(
        "The gas in the chambers exchanges heat with their walls; "
        "the model gives it one polytropic index."
    ),
    equation="V p' = g R (m_in T_in - m_out T) - g p V' + (g - 1) conductance (T_wall - T)",
    parameters=(
        EffectParameter(
            "conductance", "W/K", 0.0, 0.0, 2.0, (0.15, 0.03), "of a chamber at mid-stroke",
            "chamber.heat_conductance", least=_LEAST_CONDUCTANCE,
        ),
    ),
    source="Carneiro and Gomes de Almeida 2006, Proc. IMechE I 220; thesis equation (4.10)",
    experiment=_STOP_TEST,
    group=_TO_THE_WALLS,
)  # fmt: skip
INLET_TEMPERATURE = Effect(
    id="chamber.inlet-temperature",
    block="chamber.a",
    rigs=("single-axis",),
    statement=(
        "Expanding gas leaves a chamber cold; the model lets it leave at room temperature."
    ),
    equation="V p' = g R (m_in T0 - m_out (T0 + share (T - T0))) - g p V', T by (4.14)",
    parameters=(
        EffectParameter(
            "share", "", 0.0, 0.0, 1.5, (1.0,), "of the temperature change that leaves",
            "chamber.outflow_share",
        ),
    ),
    source="thesis equations (4.10), (4.14) without heat transfer",
    experiment=_STOP_TEST,
)  # fmt: skip
WALL_WARMING = Effect(
    id="chamber.wall-warming",
    block="chamber.a",
    rigs=("single-axis",),
    statement="The chambers' walls warm up while it works; the model has no walls.",
    equation=(
        "capacity T_wall' = conductance (T - T_wall) - (T_wall - T0)/resistance, "
        "with the heat of chamber.heat-transfer"
    ),
    parameters=(
        EffectParameter(
            "conductance", "W/K", 0.0, 0.0, 2.0, (0.1,), "between gas and wall at mid-stroke",
            "chamber.heat_conductance", least=_LEAST_CONDUCTANCE,
        ),
        EffectParameter(
            "capacity", "J/K", 0.0, 0.5, 500.0, (5.0,), "of a chamber's wall",
            "chamber.wall_capacity",
        ),
        EffectParameter(
            "resistance", "K/W", 1.0, 0.05, 100.0, (2.0,), "from wall to room",
            "chamber.wall_resistance",
        ),
    ),
    source="Carneiro and Gomes de Almeida 2006; 2 to 15 K over minutes of cycling",
    experiment="thermocouple on the wall; repeat after a rest",
    group=_TO_THE_WALLS,
)  # fmt: skip
PORT_COVERING = Effect(
    id="chamber.port-covering",
    block="chamber.a",
    rigs=("single-axis",),
    statement="The piston covers the ports near its ends; the model leaves them open.",
    equation="m = m_valve (1 - loss (1 - d/length)^1.5) within length of the end",
    parameters=(
        EffectParameter(
            "loss", "", 0.0, 0.0, 0.99, (0.1,), "flow lost right at the end", "chamber.port_loss"
        ),
        EffectParameter(
            "length", "m", 0.0, 1e-4, 0.02, (1e-3, 4e-3, 0.012), "over which it is covered",
            "chamber.port_length",
        ),
    ),
    source="Richer and Hurmuzlu 2000: inactive volume at the end of the stroke",
    experiment="drive slowly into both ends and compare pressures by place",
)  # fmt: skip
MOISTURE = Effect(
    id="gas.moisture",
    block="chamber.a",
    rigs=("single-axis",),
    statement=(
        "Moisture condenses and makes heat pass unequally when the gas cools and warms; "
        "the model has dry air of one index."
    ),
    equation="heat = conductance (T_wall - T) (1 - loss [T > T_wall])",
    parameters=(
        EffectParameter(
            "conductance", "W/K", 0.0, 0.0, 2.0, (0.1,), "between gas and wall at mid-stroke",
            "chamber.heat_conductance", least=_LEAST_CONDUCTANCE,
        ),
        EffectParameter(
            "loss", "", 0.0, 0.0, 1.0, (0.3,), "heat missing while the gas is warm",
            "chamber.cooling_loss",
        ),
    ),
    source="latent heat of condensation; thesis mentions freezing",
    experiment="stop tests of charging and venting with dried and with humid air",
    group=_TO_THE_WALLS,
)  # fmt: skip
EFFECTS = (
    HEAT_TRANSFER,
    SERVO_HEAT_TRANSFER,
    INLET_TEMPERATURE,
    WALL_WARMING,
    PORT_COVERING,
    MOISTURE,
)
