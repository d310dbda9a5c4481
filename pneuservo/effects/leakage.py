"""Leaks of a closed chamber to the atmosphere."""

from pneuservo.effects.effect import Effect, EffectParameter
from pneuservo.plant.compilation import compiled
from pneuservo.plant.gas import orifice_mass_flow

_RIGS = ("dead-volume",)
_EXPERIMENT = (
    "plug every port, fill once high and once low, and log the pressure until it is within "
    "0.1 bar of the atmosphere: the slope of log(-dp/dt) against log(gauge pressure) tells the law"
)


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


_AREA = EffectParameter("area", "m**2", 0.0, 0.0, 1e-6, (1e-9, 3e-8), "effective area of the leak")
_CONDUCTANCE = EffectParameter(
    "conductance", "kg/(s*Pa**2)", 0.0, 0.0, 1e-15, (1e-18, 3e-17), "flow per pressure squared"
)

ORIFICE = Effect(
    id="leakage.orifice",
    block="dead-volume",
    rigs=_RIGS,
    statement="Air leaks to the atmosphere as through a small hole; the model holds it tight.",
    equation="m_leak = area Cm(p_atm/p) p / sqrt(T)",
    parameters=(_AREA,),
    source="thesis equation (4.15); Beater 2007, Pneumatic Drives",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
LAMINAR = Effect(
    id="leakage.laminar",
    block="dead-volume",
    rigs=_RIGS,
    statement="Air leaks to the atmosphere as through a narrow gap; the model holds it tight.",
    equation="m_leak = conductance (p^2 - p_atm^2) (293 K/T)",
    parameters=(_CONDUCTANCE,),
    source="Richer and Hurmuzlu 2000, J. Dyn. Syst. Meas. Control 122",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
MIXED = Effect(
    id="leakage.mixed",
    block="dead-volume",
    rigs=_RIGS,
    statement=(
        "Air leaks to the atmosphere through a hole and a narrow gap together; "
        "the model holds it tight."
    ),
    equation="m_leak = area Cm(p_atm/p) p / sqrt(T) + conductance (p^2 - p_atm^2) (293 K/T)",
    parameters=(_AREA, _CONDUCTANCE),
    source="Richer and Hurmuzlu 2000; Beater 2007",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
PRESSURE_OPENING = Effect(
    id="leakage.pressure-opening",
    block="dead-volume",
    rigs=_RIGS,
    statement=(
        "Air leaks to the atmosphere with a power of the gauge pressure (above 1: gaps or pores "
        "that open under pressure); the model holds it tight."
    ),
    equation="m_leak = coefficient ((p - p_atm) / 1 bar)^exponent",
    parameters=(
        EffectParameter("coefficient", "kg/s", 0.0, 0.0, 1e-2, (1e-7, 3e-6), "leak at 1 bar gauge"),
        EffectParameter("exponent", "", 1.0, 0.5, 2.5, (1.2,), "power of the gauge pressure"),
    ),
    source="fit to leak-down recordings of printed chambers, Zillen 2021",
    experiment=_EXPERIMENT,
    group="leak to the atmosphere",
)
LEAKS = EFFECTS = (ORIFICE, LAMINAR, MIXED, PRESSURE_OPENING)
