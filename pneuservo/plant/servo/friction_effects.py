"""What the piston's friction does beyond viscous and one Coulomb force."""

import math
from typing import NamedTuple

from pneuservo.plant.servo.compilation import compiled


class FrictionEffects(NamedTuple):
    """Parameters of the effects on friction."""

    stribeck_excess: float = 0.0
    """Static minus sliding friction [N]."""
    stribeck_speed: float = 0.005
    """Speed over which it fades to 1/e [m/s]."""
    dwell_excess: float = 0.0
    """Breakaway force gained by a long rest [N]."""
    dwell_time: float = 10.0
    """Time over which it is gained [s]."""
    presliding_travel: float = 0.0
    """Distance over which friction builds up after a reversal [m]; 0 for at once."""
    presliding_exponent: float = 1.0
    """Shape of the build-up: 1 exponential, above: longer tail [-]."""
    lag: float = 0.0
    """Time by which friction follows the speed [s]."""
    pressure_sum: float = 0.0
    """Friction per sum of the gauge pressures [N/Pa]."""
    pressure_difference: float = 0.0
    """Friction per magnitude of the pressure difference [N/Pa]."""
    asymmetry: float = 0.0
    """Half of what friction is higher when extending [N]."""
    viscous_asymmetry: float = 0.0
    """Half of what viscous friction is higher when extending [N s/m]."""
    wave_sine: float = 0.0
    """Amplitude of the wave along the stroke that is odd about mid-stroke [N]."""
    wave_cosine: float = 0.0
    """Amplitude of the one that is even [N]."""
    wave_length: float = 0.06
    """Of both; of twice the stroke one is nearly a slope, the other a hump [m]."""
    quadratic: float = 0.0
    """Friction per speed squared [N s^2/m^2]."""
    run_in: float = 0.0
    """Relative change of Coulomb friction per time [1/s]."""
    viscous_run_in: float = 0.0
    """Relative change of viscous friction per time [1/s]."""
    side_force: float = 0.0
    """Friction that the weight of the overhanging rod adds at full extension [N]."""


@compiled
def has_presliding(effects):
    """Return whether friction builds up over a distance instead of holding the piston.

    Parameters
    ----------
    effects : FrictionEffects
        The effects.
    """
    return effects.presliding_travel > 0.0


@compiled
def friction_levels(
    coulomb, displacement, speed, pressure_a, pressure_b, ambient, stroke, time, effects
):
    """Return the friction that does not depend on viscosity, extending and retracting [N].

    Parameters
    ----------
    coulomb : float
        Of the baseline [N].
    displacement : float
        [m].
    speed : float
        Sliding speed that friction feels; 0 at rest [m/s].
    pressure_a, pressure_b, ambient : float
        Absolute [Pa].
    stroke : float
        [m].
    time : float
        Since the start of the run [s].
    effects : FrictionEffects
        The effects.

    Returns
    -------
    float, float
        Neither negative. At rest they are the forces that friction can take either way.

    Notes
    -----
    Stribeck: Armstrong-Helouvry, Dupont, Canudas de Wit 1994. Pressure: Andrighetto and others
    2006, Belforte and others 2003. Position: (4.54), one wave of its own length. The parts add.

    Examples
    --------
    >>> friction_levels(1.0, 0.015, 0.0, 5e5, 5e5, 1e5, 0.03, 0.0, FrictionEffects(asymmetry=0.25))
    (1.25, 0.75)
    """
    level = coulomb * (1.0 + effects.run_in * time)
    if effects.wave_sine != 0.0 or effects.wave_cosine != 0.0:
        phase = 2.0 * math.pi * (displacement - 0.5 * stroke) / effects.wave_length
        level += effects.wave_sine * math.sin(phase) + effects.wave_cosine * math.cos(phase)
    if effects.stribeck_excess != 0.0:
        level += effects.stribeck_excess * math.exp(-abs(speed) / effects.stribeck_speed)
    level += effects.pressure_sum * (pressure_a + pressure_b - 2.0 * ambient)
    level += effects.pressure_difference * abs(pressure_a - pressure_b)
    level += effects.side_force * displacement / stroke
    return max(level + effects.asymmetry, 0.0), max(level - effects.asymmetry, 0.0)


@compiled
def breakaway_gain(rest, effects):
    """Return what a rest adds to the breakaway force [N].

    Parameters
    ----------
    rest : float
        How long the piston has rested [s].
    effects : FrictionEffects
        The effects.

    Notes
    -----
    excess (1 - exp(-rest/time)), Armstrong-Helouvry and others 1994; gone once it slides.
    """
    if effects.dwell_excess == 0.0:
        return 0.0
    return -effects.dwell_excess * math.expm1(-rest / effects.dwell_time)


@compiled
def viscous_excess(velocity, lagged, viscous, time, effects):
    """Return the friction that grows with speed beyond the baseline's c v, with its sign [N].

    Parameters
    ----------
    velocity, lagged : float
        Of the piston, and as friction follows it [m/s].
    viscous : float
        Coefficient of the baseline [N s/m].
    time : float
        Since the start of the run [s].
    effects : FrictionEffects
        The effects.
    """
    felt = velocity
    if effects.lag > 0.0:
        felt = lagged
    return (
        viscous * (felt * (1.0 + effects.viscous_run_in * time) - velocity)
        + effects.viscous_asymmetry * abs(felt)
        + effects.quadratic * felt * abs(felt)
    )
