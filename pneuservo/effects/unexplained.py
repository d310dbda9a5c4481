"""What no other entry explains: a force, a flow or a parameter as a table over one quantity.

A diagnosis writes these down once everything with a name has failed; they are no hypotheses of its
search. Rig files and simulations take them like any other effect.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from pneuservo.effects.effect import Effect, EffectParameter
from pneuservo.errors import InputError
from pneuservo.plant.servo.drift import DRIFTING
from pneuservo.plant.servo.unexplained_effects import INTERVALS, QUANTITIES

_KNOTS = tuple(f"v{k}" for k in range(INTERVALS + 1))
_ANY = 1e9
"""No quantity of the rig, in its SI unit, is larger."""


def _tabulated(
    name: str,
    block: str,
    what: str,
    symbol: str,
    unit: str,
    largest: float,
    step: float,
    code: EffectParameter,
    ends: tuple[float, float],
    law: tuple[str, str],
) -> Effect:
    """Return a tabulated effect; it starts as a straight line between two ends."""
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
    statement, experiment = law
    return Effect(
        id=f"unexplained.{name}",
        block=block,
        rigs=("single-axis",),
        statement=statement,
        equation=(
            f"{symbol} = table(q) through {', '.join(_KNOTS)} at equal steps from low to high, "
            f"{code.meaning}"
        ),
        parameters=(
            *knots,
            replace(code, field=f"{field}.over"),
            EffectParameter(
                "low", "", 0.0, -_ANY, _ANY, (ends[0],), "q at the first knot, in its SI unit",
                f"{field}.low",
            ),
            EffectParameter(
                "high", "", 0.0, -_ANY, _ANY, (ends[1],), "q at the last knot, in its SI unit",
                f"{field}.high",
            ),
        ),
        source="what a recording shows beyond every effect with a name",
        experiment=experiment,
    )  # fmt: skip


def _choice(name: str, choices: Sequence[str], meaning: str) -> EffectParameter:
    listed = ", ".join(f"{code} {choice}" for code, choice in enumerate(choices))
    return EffectParameter(name, "", 0.0, 0.0, len(choices) - 1.0, (0.0,), f"{meaning}: {listed}")


def _added(
    name: str, block: str, what: str, symbol: str, unit: str, largest: float, step: float
) -> Effect:
    """Return a force or a flow over one quantity; it starts along the middle of the stroke."""
    return _tabulated(
        name,
        block,
        what,
        symbol,
        unit,
        largest,
        step,
        _choice("over", QUANTITIES, "q by over"),
        (0.008, 0.027),
        (
            f"Something that the catalogue has no name for adds a {what} that depends on one "
            f"quantity; the model has no such {what}.",
            "vary the quantity it depends on and hold all others: does it follow that one alone?",
        ),
    )


FORCE = _added("force", "piston", "force on the piston", "F", "N", 1e4, 1.0)
FLOW_A = _added("flow-a", "chamber.a", "flow into chamber a", "m_a", "kg/s", 0.1, 2e-6)
FLOW_B = _added("flow-b", "chamber.b", "flow into chamber b", "m_b", "kg/s", 0.1, 2e-6)
DRIFT = _tabulated(
    "drift",
    "load",
    "change of a parameter",
    "parameter / nominal - 1",
    "",
    0.9,
    0.005,
    _choice("of", DRIFTING, "q the time, the parameter by of"),
    (0.05, 0.45),
    (
        "Something that the catalogue has no name for changes a parameter in the course of a "
        "recording; the model holds it constant.",
        "repeat the recording at once, and again after an hour's rest: does it begin where the "
        "last one ended, or anew?",
    ),
)
EFFECTS = (FORCE, FLOW_A, FLOW_B, DRIFT)


def require_table(table: Effect, values: Mapping[str, float], where: str) -> None:
    """Refuse a table that cannot be looked up.

    Parameters
    ----------
    table : Effect
        One of `EFFECTS`.
    values : mapping of str to float
        Its parameters by name; those not named are neutral.
    where : str
        File and effect, for the message.

    Raises
    ------
    InputError
        When what it is over, or of, is not one of the list, or values have no range to stand in.

    Examples
    --------
    >>> require_table(FORCE, {"v0": 5.0, "low": 0.01, "high": 0.02}, "effect unexplained.force")
    """
    code = table.parameters[len(_KNOTS)]
    chosen, low, high = (values.get(name, 0.0) for name in (code.name, "low", "high"))
    if chosen not in range(int(code.high) + 1):
        raise InputError(
            f"{where}: {code.name} is {chosen:g}; it has to be one of: "
            f"{code.meaning.partition(': ')[2]}"
        )
    if low >= high and any(values.values()):
        quantity = "time" if table is DRIFT else QUANTITIES[int(chosen)]
        raise InputError(
            f"{where}: low is {low:g} and high is {high:g}; low has to be below high. They are the "
            f"ends of the table in the SI unit of what it is over ({quantity}): give both"
        )
