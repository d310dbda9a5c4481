"""The single axis with every effect of the catalogue: the baseline is all of them at neutral.

One module per phenomenon holds an effect's parameters and its equations: `spool_effects`,
`valve_effects`, `supply_effects`, `line_effects`, `chamber_effects`, `leakage_effects`,
`friction_effects`, `load_effects`, `stop_effects`, `sensor_effects`, `unexplained_effects`.
`pneumatics` and `mechanics` put the two halves together, `chain` the whole; `events`, `memory` and
`run` integrate it, `drift` lets one of its parameters change on the way, and `behavioural_card`
closes the loop with the card. A diagnosis drives one half with what was measured round it, by the
same functions.
"""
