"""The elements of an op-amp's netlist that hold the figures in which one differs from the next."""

import math
from collections.abc import Mapping

import numpy as np

from analog_card.behaviour_elements import (
    PLACES,
    SATURATION_CURRENT,
    THERMAL_VOLTAGE,
    amplifier_figures,
    figure_name,
)
from analog_card.behaviour_limiter import output_drop
from analog_card.design import AMPLIFIER_FIGURES, AMPLIFIERS, OperationalAmplifier

# The compensation capacitor in netlists/opamp/ca3140-core.lib.
_COMPENSATION = 30e-12


def netlist_elements(
    elements: Mapping[str, float], nominal: OperationalAmplifier
) -> dict[str, float]:
    """Return the values of a channel's elements with every op-amp's figures as its elements.

    Parameters
    ----------
    elements : mapping of str to float
        By the names of `analog_card.behaviour_elements.nominal_elements`; others are passed on.
    nominal : OperationalAmplifier
        With which the netlist was loaded.

    Returns
    -------
    dict of str to float
        As `analog_card.ngspice.Session.change` takes them, without the name of the channel.
    """
    values = dict(elements)
    for amplifier in AMPLIFIERS:
        named = {figure_name(amplifier, figure) for figure in AMPLIFIER_FIGURES} & elements.keys()
        if named:
            found = core_elements(amplifier_figures(amplifier, elements, nominal), nominal)
            place = f"{PLACES[amplifier]}.xamplifier.xcore"
            values |= {f"{place}.{name}": value for name, value in found.items()}
        for name in named:
            del values[name]
    return values


def core_elements(figures: OperationalAmplifier, nominal: OperationalAmplifier) -> dict[str, float]:
    """Return the elements of the op-amp's netlist for figures that differ from the nominal ones.

    Parameters
    ----------
    figures : OperationalAmplifier
        Of one op-amp; only `analog_card.design.AMPLIFIER_FIGURES` may differ.
    nominal : OperationalAmplifier
        With which the netlist was loaded; its stage current and transconductance stay.

    Returns
    -------
    dict of str to float
        Values in SI by the names in the subcircuit ``ca3140_core``.

    Notes
    -----
    A current Is tanh(g a v/Is), for a voltage v at the input, charges the capacitor C behind the
    resistor R: the slew rate is Is/C, the gain-bandwidth product a g/(2 pi C), the open-loop gain
    a g R.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from analog_card.design_file import load_design
    >>> figures = load_design().soldered.operational_amplifier
    >>> slow = replace(figures, slew_rate=figures.slew_rate / 2)
    >>> found = core_elements(slow, figures)
    >>> round(found["cgain"] * 1e12, 6), round(found["rdrive"], 6)  # twice 30 pF, driven twice
    (60.0, 2.0)
    """
    transconductance = 2 * math.pi * nominal.gain_bandwidth * _COMPENSATION
    current = nominal.slew_rate * _COMPENSATION
    capacitance = current / figures.slew_rate
    drive = 2 * math.pi * figures.gain_bandwidth * capacitance / transconductance
    # The clamps carry the whole stage current when the op-amp saturates.
    drop = THERMAL_VOLTAGE * math.log(current / SATURATION_CURRENT)
    half = figures.offset_current / 2
    swing = np.array([figures.positive_swing, -figures.negative_swing])
    inside = np.abs(swing + output_drop(swing / 2e3, figures))
    high, low = (float(figures.supply - level + drop) for level in inside)
    return {
        "ibiasplus": figures.bias_current + half,
        "ibiasminus": figures.bias_current - half,
        "cgain": capacitance,
        "rdrive": drive,
        "rgain": figures.open_loop_gain / (transconductance * drive),
        "vclamphigh": high,
        "vclamplow": low,
    }
