"""Wrong parameters of the baseline: to be called that, and not physics."""

from pneuservo.challenge.effects.concealed import PARAMETER, ConcealedEffect, Form
from pneuservo.challenge.truth.parameters import Truth
from pneuservo.challenge.truth.rig import rig_value, with_rig_values

# Parameter of the rig: block, and by what part it is wrong at least and at most, and which way.
_WRONG = {
    "load.mass": ("load", 0.05, 0.6, 1.0),
    "valve.spool.damping": ("valve.spool", 0.1, 0.6, 1.0),
    "valve.spool.frequency": ("valve.spool", 0.1, 0.45, -1.0),
    "chamber.a.dead_volume": ("chamber.a", 0.1, 1.5, 1.0),
    "chamber.b.dead_volume": ("chamber.b", 0.1, 1.5, 1.0),
    "chamber.polytropic_index": ("chamber.a", 0.03, 0.25, -1.0),
    "piston.viscous_friction": ("piston", 0.1, 1.5, 1.0),
    "piston.coulomb_friction": ("piston", 0.5, 8.0, 1.0),
    "supply.pressure": ("supply", 0.02, 0.15, 1.0),
    "valve.flow.area_b_e": ("valve.flow", 0.03, 0.35, -1.0),
    "valve.flow.area_s_a": ("valve.flow", 0.03, 0.35, -1.0),
}


def _wrong(key: str, sign: float) -> Form:
    def apply(truth: Truth, size: float) -> Truth:
        return with_rig_values(truth, {key: rig_value(truth, key) * (1.0 + sign * size)})

    return Form("parameter off", apply, shared=True)


EFFECTS = tuple(
    ConcealedEffect(f"param.{key}", PARAMETER, (block,), low, high, "", (_wrong(key, sign),))
    for key, (block, low, high, sign) in _WRONG.items()
)
