"""Pressure in a cylinder chamber."""

from pneuservo.plant.compilation import compiled


@compiled
def pressure_rate(mass_flow, pressure, volume, volume_rate, polytropic_index, gas):
    """Return the rate of the pressure in a chamber [Pa/s].

    Parameters
    ----------
    mass_flow : float
        Net mass flow into the chamber [kg/s].
    pressure : float
        Absolute pressure [Pa].
    volume : float
        Volume [m^3].
    volume_rate : float
        Rate of the volume [m^3/s].
    polytropic_index : float
        1 isothermal, the isentropic exponent when adiabatic [-].
    gas : Gas
        The gas; its temperature is that of the inflow.

    Notes
    -----
    Equation (4.12) at one constant temperature: ideal gas, uniform pressure in the chamber.

    Examples
    --------
    A sealed chamber of 10 cm^3 at 5 bar, squeezed by 1 cm^3/s, gains 0.7 bar/s:

    >>> from pneuservo.plant.gas import ideal_gas
    >>> round(pressure_rate(0.0, 5e5, 10e-6, -1e-6, 1.4, ideal_gas(293.0, 287.0, 1.4)))
    70000
    """
    inflow = gas.gas_constant * gas.temperature * mass_flow
    return polytropic_index / volume * (inflow - pressure * volume_rate)
