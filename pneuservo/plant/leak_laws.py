"""What flows through a leak, by its form: hole, narrow gap, or one that opens under pressure."""

from pneuservo.plant.compilation import compiled
from pneuservo.plant.gas import orifice_mass_flow


@compiled
def orifice_leak(pressure, ambient, temperature, gas_constant, isentropic_exponent, area):
    """Return the mass flow of a sharp-edged leak of an effective area [kg/s]."""
    return orifice_mass_flow(
        pressure, ambient, area, 1.0, temperature, gas_constant, isentropic_exponent
    )


@compiled
def laminar_leak(pressure, ambient, temperature, conductance):
    """Return the mass flow through a narrow gap: compressible laminar flow [kg/s].

    The reference temperature of the conductance is 293 K.
    """
    return conductance * (pressure * pressure - ambient * ambient) * 293.0 / temperature


@compiled
def power_leak(pressure, ambient, coefficient, exponent):
    """Return the mass flow of a leak that follows a power of the gauge pressure [kg/s].

    The coefficient is the flow at 1 bar gauge; below the ambient pressure the flow reverses.
    """
    gauge = (pressure - ambient) / 1e5
    if gauge >= 0.0:
        return coefficient * gauge**exponent
    return -coefficient * (-gauge) ** exponent
