"""What no other entry explains: a force or a flow as a table over one quantity.

A diagnosis writes these down once everything with a name has failed; they are no hypotheses of its
search. Rig files and simulations take them like any other effect.
"""

from collections.abc import Mapping

from pneuservo.effects.effect import Effect, EffectParameter
from pneuservo.errors import InputError
from pneuservo.plant.servo.unexplained_effects import INTERVALS, QUANTITIES

_KNOTS = tuple(f"v{k}" for k in range(INTERVALS + 1))
_OVER = ", ".join(f"{code} {name}" for code, name in enumerate(QUANTITIES))
_ANY = 1e9
"""No quantity of the rig, in its SI unit, is larger."""


def _tabulated(
    name: str, block: str, what: str, symbol: str, unit: str, largest: float, step: float
) -> Effect:
    """Return a tabulated effect; it starts as a straight line along the middle of the stroke."""
    field = f"unexplained_{name.replace('-', '_')}"
    knots = tuple(
        EffectParameter(
            knot,
            unit,
            0.0,
            -largest,
            largest,
            ((k + 1) * step,),
            f"{what} at knot {k}",
            f"{field}.{knot}",
        )
        for k, knot in enumerate(_KNOTS)
    )
    return Effect(
        id=f"unexplained.{name}",
        block=block,
        rigs=("single-axis",),
        statement=(
            f"Something that the catalogue has no name for adds a {what} that depends on one "
            f"quantity; the model has no such {what}."
        ),
        equation=(
            f"{symbol} = table(q) through {', '.join(_KNOTS)} at equal steps from low to high, "
            f"q by over: {_OVER}"
        ),
        parameters=(
            *knots,
            EffectParameter(
                "over", "", 0.0, 0.0, len(QUANTITIES) - 1.0, (0.0,), f"q: {_OVER}", f"{field}.over"
            ),
            EffectParameter(
                "low", "", 0.0, -_ANY, _ANY, (0.008,), "q at the first knot, in its SI unit",
                f"{field}.low",
            ),
            EffectParameter(
                "high", "", 0.0, -_ANY, _ANY, (0.027,), "q at the last knot, in its SI unit",
                f"{field}.high",
            ),
        ),
        source="what a recording shows beyond every effect with a name",
        experiment=(
            "vary the quantity it depends on and hold all others: does it follow that one alone?"
        ),
    )  # fmt: skip


FORCE = _tabulated("force", "piston", "force on the piston", "F", "N", 1e4, 1.0)
FLOW_A = _tabulated("flow-a", "chamber.a", "flow into chamber a", "m_a", "kg/s", 0.1, 2e-6)
FLOW_B = _tabulated("flow-b", "chamber.b", "flow into chamber b", "m_b", "kg/s", 0.1, 2e-6)
EFFECTS = (FORCE, FLOW_A, FLOW_B)


def require_table(values: Mapping[str, float], where: str) -> None:
    """Refuse a table that cannot be looked up.

    Parameters
    ----------
    values : mapping of str to float
        Parameters of one of `EFFECTS` by name; those not named are neutral.
    where : str
        File and effect, for the message.

    Raises
    ------
    InputError
        When ``over`` is no quantity, or values have no range of the quantity to stand in.

    Examples
    --------
    >>> require_table({"v0": 5.0, "low": 0.01, "high": 0.02}, "effect unexplained.force")
    """
    over, low, high = (values.get(name, 0.0) for name in ("over", "low", "high"))
    if over not in range(len(QUANTITIES)):
        raise InputError(f"{where}: over is {over:g}; it has to be one of: {_OVER}")
    if low >= high and any(values.values()):
        raise InputError(
            f"{where}: low is {low:g} and high is {high:g}; low has to be below high. They are the "
            f"ends of the table in the SI unit of what it is over ({QUANTITIES[int(over)]}): "
            "give both"
        )
