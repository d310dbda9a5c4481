"""What a circuit that imitates a mass on a spring may have beyond linear elements.

The equation of motion is y'' + 2 damping w y' + w^2 y + w^2 s(y) + w d(y') = gain w^2 u,
so stiffness terms carry the unit of the output divided by its power.
"""

from pneuservo.effects.effect import Effect, EffectParameter
from pneuservo.plant.compilation import compiled

_RIGS = ("circuit",)
_SOURCE = "Wigren and Schoukens 2013, Three free data sets for development and benchmarking"


@compiled
def stiffness_beyond_linear(output, quadratic, cubic, quintic):
    """Return the restoring signal beyond the linear one, in units of the output [V]."""
    square = output * output
    return square * (quadratic + output * (cubic + quintic * square))


@compiled
def damping_beyond_linear(rate, dry, cubic):
    """Return the damping signal beyond the linear one, in units of the output rate [V/s].

    Dry damping is smoothed over 10 mV/s so that the integrator keeps its order.
    """
    return dry * rate / (rate * rate + 1e-4) ** 0.5 + cubic * rate * rate * rate


CUBIC_STIFFNESS = Effect(
    id="circuit.cubic-stiffness",
    block="circuit",
    rigs=_RIGS,
    statement=(
        "The restoring signal grows with the cube of the output (positive: hardening); "
        "the model holds it proportional."
    ),
    equation="y'' + 2 damping w y' + w^2 (y + coefficient y^3) = gain w^2 u",
    parameters=(
        EffectParameter("coefficient", "1/V**2", 0.0, -1e3, 1e3, (1.0,), "cubic over linear"),
    ),
    source=_SOURCE,
    experiment="drive with sines of two amplitudes: the resonance moves with the amplitude",
)
QUADRATIC_STIFFNESS = Effect(
    id="circuit.quadratic-stiffness",
    block="circuit",
    rigs=_RIGS,
    statement="The restoring signal differs between the two signs; the model holds it odd.",
    equation="y'' + 2 damping w y' + w^2 (y + coefficient y^2) = gain w^2 u",
    parameters=(
        EffectParameter("coefficient", "1/V", 0.0, -1e2, 1e2, (0.03,), "quadratic over linear"),
    ),
    source=_SOURCE,
    experiment="drive with one sine and look for its second harmonic and a shift of the mean",
)
QUINTIC_STIFFNESS = Effect(
    id="circuit.quintic-stiffness",
    block="circuit",
    rigs=_RIGS,
    statement=(
        "The restoring signal grows with the fifth power of the output; "
        "the model holds it proportional."
    ),
    equation="y'' + 2 damping w y' + w^2 (y + coefficient y^5) = gain w^2 u",
    parameters=(
        EffectParameter("coefficient", "1/V**4", 0.0, -1e4, 1e4, (1.0,), "quintic over linear"),
    ),
    source=_SOURCE,
    experiment="drive with sines of three amplitudes",
)
CUBIC_DAMPING = Effect(
    id="circuit.cubic-damping",
    block="circuit",
    rigs=_RIGS,
    statement="Damping grows with the cube of the output rate; the model holds it proportional.",
    equation="y'' + 2 damping w y' + w coefficient y'^3 + w^2 y = gain w^2 u",
    parameters=(
        EffectParameter(
            "coefficient", "s**2/V**2", 0.0, -1e-2, 1e-2, (1e-5,), "cubic damping over w"
        ),
    ),
    source="textbook non-linear damping",
    experiment="let it ring down from two amplitudes: the decay rate moves with the amplitude",
)
DRY_DAMPING = Effect(
    id="circuit.dry-damping",
    block="circuit",
    rigs=_RIGS,
    statement="Part of the damping does not depend on the rate; the model holds it proportional.",
    equation="y'' + 2 damping w y' + w level sgn(y') + w^2 y = gain w^2 u",
    parameters=(EffectParameter("level", "V/s", 0.0, -10.0, 10.0, (0.01,), "dry damping over w"),),
    source="crossover distortion of output stages; Horowitz and Hill, The Art of Electronics",
    experiment="let it ring down to rest: dry damping ends it in a straight line",
)
EFFECTS = (CUBIC_STIFFNESS, QUADRATIC_STIFFNESS, QUINTIC_STIFFNESS, CUBIC_DAMPING, DRY_DAMPING)
