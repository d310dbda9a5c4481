"""From the values of the catalogue's parameters to what the servo's kernels take."""

from collections.abc import Mapping

from pneuservo.effects.catalogue import TABLES, effects_of
from pneuservo.effects.unexplained import require_table
from pneuservo.naming import require_known
from pneuservo.plant.servo.servo_effects import NEUTRAL, ServoEffects

SERVO_FIELDS: dict[str, str] = {
    effect.key(parameter.name): parameter.field
    for effect in effects_of("single-axis", tables=True)
    for parameter in effect.parameters
}
"""``effect:parameter`` to ``block.field`` of `ServoEffects`."""


def servo_effects(values: Mapping[str, float]) -> ServoEffects:
    """Return the effects that some parameter values describe.

    Parameters
    ----------
    values : mapping of str to float
        ``effect:parameter`` to value in SI; those not named are neutral.

    Returns
    -------
    ServoEffects
        As the kernels take them. Where several parameters act on one field what each adds to
        neutral is added up.

    Raises
    ------
    InputError
        When a name is not one of a single axis, with the nearest; when a table has no range.

    Examples
    --------
    >>> servo_effects({"valve.overlap:lap": 0.01}).valve.overlap
    0.01
    """
    changed: dict[str, dict[str, float]] = {}
    for key, value in values.items():
        require_known(key, SERVO_FIELDS, "effect of a rig of kind single-axis")
        block, name = SERVO_FIELDS[key].split(".")
        base = float(getattr(getattr(NEUTRAL, block), name))
        fields = changed.setdefault(block, {})
        fields[name] = fields.get(name, base) + (float(value) - base)
    effects = NEUTRAL._replace(
        **{block: getattr(NEUTRAL, block)._replace(**fields) for block, fields in changed.items()}
    )
    for table in TABLES:
        block, _ = table.parameters[0].field.split(".")
        if block in changed:
            filled = getattr(effects, block)._asdict()
            values = {p.name: filled[p.field.partition(".")[2]] for p in table.parameters}
            require_table(table, values, f"effect {table.id}")
    return effects
