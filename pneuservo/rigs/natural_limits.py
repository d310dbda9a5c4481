"""Between which limits some quantities lie on any rig."""

NATURAL_LIMITS = {
    "temperature": (233.0, 353.0),
    "ambient.pressure": (6.0e4, 1.1e5),
    "chamber.polytropic_index": (1.0, 5.0 / 3.0),
}
"""Parameter to its lowest and highest value [SI]: air of -40 to 80 degrees Celsius, which is what
pneumatic parts are sold for; the atmosphere from 4,000 m above the sea to the highest ever read
there; from isothermal to the isentropic change of a gas of single atoms."""
