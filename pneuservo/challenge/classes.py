"""Which effects recordings of a servo can hardly tell apart, fixed before any diagnosis."""

_CLASSES: dict[str, frozenset[str]] = {
    name: frozenset(members.split())
    for name, members in {
        "constant force": (
            "friction.asymmetric sensor.pressure-offset-a sensor.pressure-offset-b "
            "sensor.pressure-gain-a sensor.pressure-gain-b load.gravity-angle "
            "param.ambient.pressure param.piston.area_a param.piston.area_b"
        ),
        "antisymmetric flow": "spool.null-bias leakage.cross-piston",
        "Coulomb level": "param.piston.coulomb_friction friction.pressure",
        "flow scale": (
            "valve.critical-ratio spool.lineariser param.supply.pressure valve.port-asymmetry "
            "valve.upstream-temperature valve.exhaust-back-pressure param.temperature "
            "param.valve.flow.area_s_a param.valve.flow.area_s_b "
            "param.valve.flow.area_b_e param.valve.flow.area_a_e"
        ),
        "compressibility": (
            "chamber.heat-transfer chamber.inlet-temperature chamber.wall-warming "
            "param.chamber.polytropic_index param.chamber.a.dead_volume "
            "param.chamber.b.dead_volume line.wall-compliance"
        ),
        "fast lag": (
            "spool.amplitude-bandwidth spool.slew spool.delay line.restriction line.delay "
            "line.resonance sensor.position-lag sensor.pressure-lag "
            "param.valve.spool.frequency param.valve.spool.damping"
        ),
        "curvature of friction": (
            "friction.stribeck friction.speed-curve friction.breakaway-dwell friction.lag"
        ),
        "near null": "valve.overlap spool.hysteresis spool.stiction valve.null-leakage",
        "presliding": "friction.presliding load.compliance load.backlash",
        "place": (
            "friction.position friction.side-load load.spring sensor.position-nonlinearity "
            "sensor.position-gain"
        ),
        "leak of one chamber": "leakage.chamber-a leakage.pressure-opening-a",
        "leak across": "leakage.cross-piston leakage.position leakage.velocity",
        "structure": "load.transverse-mode load.base-motion load.compliance param.load.mass",
        "supply": "supply.sag supply.slow-drift supply.ripple param.supply.pressure",
    }.items()
}


def classmates(effect: str) -> frozenset[str]:
    """Return the effects that one can be taken for, itself included.

    Parameters
    ----------
    effect : str
        Id of an effect, or ``param.`` and the id of a parameter.

    Notes
    -----
    From the projected cosines above 0.9 of an exploratory study of this servo, and from which
    terms enter the same balance in the same way.

    Examples
    --------
    >>> sorted(classmates("spool.null-bias"))
    ['leakage.cross-piston', 'spool.null-bias']
    """
    mates = {effect}
    for members in _CLASSES.values():
        if effect in members:
            mates |= members
    return frozenset(mates)


def family(effect: str) -> str:
    """Return the row or column of an effect in the confusion table: what stands before the dot."""
    return effect.split(".")[0]
