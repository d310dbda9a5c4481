"""Which cases a trial holds: how many of each kind, drawn by a seed."""

from collections.abc import Sequence

import numpy as np

from pneuservo.challenge.effects import CONCEALED, OUTSIDE, PARAMETER, PHYSICS, SENSOR
from pneuservo.challenge.key import Wish
from pneuservo.challenge.sizes import FEWEST_CONTROLS, FULL

_SHARES = {
    "wrong-parameter": 0.09,
    "pair": 0.12,
    "outside": 0.11,
    "missing-channels": 0.09,
    "noisy": 0.05,
}
_CONTROLS = 0.22
_VISIBILITIES = ("visible", "faint", "hidden")
_MISSING = (
    ("supply_pressure",),
    ("pressure_b",),
    ("pressure_b", "supply_pressure"),
    ("pressure_a", "pressure_b"),
    ("pressure_a", "pressure_b", "supply_pressure"),
)
_CANCELLING = (
    ("valve.null-leakage", "valve.overlap"),
    ("chamber.heat-transfer", "leakage.chamber-a"),
    ("sensor.pressure-offset-a", "friction.asymmetric"),
)
_SAME_BLOCK = (
    ("friction.pressure", "friction.stribeck"),
    ("friction.position", "friction.asymmetric"),
    ("spool.hysteresis", "spool.null-bias"),
    ("leakage.chamber-a", "leakage.rod-seal"),
)


def counts(cases: int) -> dict[str, int]:
    """Return how many cases of each part of the mix there are.

    Parameters
    ----------
    cases : int
        Cases asked for.

    Returns
    -------
    dict of str to int
        They add up to `cases`; of 200 and more at least 47 conceal nothing.

    Examples
    --------
    >>> counts(200)["none"], sum(counts(200).values())
    (47, 200)
    """
    found = {name: round(share * cases) for name, share in _SHARES.items()}
    controls = round(_CONTROLS * cases)
    if cases >= FULL:
        controls = max(controls, FEWEST_CONTROLS)
    found["none"] = controls
    found["single"] = max(cases - sum(found.values()), 0)
    return found


def draw_mix(cases: int, rng: np.random.Generator) -> list[Wish]:
    """Return what every case is to hold, in random order.

    Parameters
    ----------
    cases : int
        How many.
    rng : Generator
        Draws it.

    Returns
    -------
    list of Wish
        Every effect in turn before any comes twice; visible, faint and hidden in turn.
    """
    wishes: list[Wish] = []
    for stratum, count in counts(cases).items():
        wishes += _stratum(stratum, count, rng)
    return [wishes[place] for place in rng.permutation(len(wishes))]


def _stratum(stratum: str, count: int, rng: np.random.Generator) -> list[Wish]:
    if stratum == "none":
        return [Wish(("none",), stratum=stratum) for _ in range(count)]
    if stratum == "pair":
        return [_pair(index, rng) for index in range(count)]
    kinds = {"wrong-parameter": (PARAMETER,), "outside": (OUTSIDE,)}.get(stratum, (PHYSICS, SENSOR))
    wishes = []
    for index, name in enumerate(_in_turn(_of_kind(kinds), count, rng)):
        visibility = _VISIBILITIES[index % 3]
        if stratum in ("missing-channels", "outside", "wrong-parameter"):
            visibility = "visible" if index % 3 < 2 else "faint"
        missing = _MISSING[index % len(_MISSING)] if stratum == "missing-channels" else ()
        if name == "param.supply.pressure":
            # A supply that is measured cannot be wrong.
            missing = ("supply_pressure",)
        wishes.append(
            Wish(
                (name,),
                "visible" if stratum == "noisy" else visibility,
                form=int(rng.integers(6)),
                retune=bool(rng.integers(2)),
                missing=missing,
                louder=4.0 if stratum == "noisy" else 1.0,
                stratum=stratum,
            )
        )
    return wishes


def _pair(index: int, rng: np.random.Generator) -> Wish:
    """Return two effects: cancelling, in one block, transducer and physics, or any."""
    physics, sensors = _of_kind((PHYSICS,)), _of_kind((SENSOR,))
    turn = index % 4
    if turn == 0:
        names = _CANCELLING[(index // 4) % len(_CANCELLING)]
    elif turn == 1:
        names = _SAME_BLOCK[(index // 4) % len(_SAME_BLOCK)]
    elif turn == 2:
        names = (str(rng.choice(sensors)), str(rng.choice(physics)))
    else:
        first, second = rng.choice(physics, 2, replace=False)
        names = (str(first), str(second))
    retune = bool(rng.integers(2))
    return Wish(names, "visible", form=int(rng.integers(6)), retune=retune, stratum="pair")


def _of_kind(kinds: Sequence[str]) -> list[str]:
    return [name for name, effect in CONCEALED.items() if effect.kind in kinds]


def _in_turn(names: Sequence[str], count: int, rng: np.random.Generator) -> list[str]:
    drawn: list[str] = []
    while len(drawn) < count:
        drawn += [names[place] for place in rng.permutation(len(names))]
    return drawn[:count]
