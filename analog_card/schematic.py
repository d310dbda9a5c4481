"""The circuit diagram of the card, drawn from its design file."""

from typing import Any

from analog_card.design import Design, DifferentiatorParts
from analog_card.sheet import Point, Sheet
from analog_card.tuning import weights_from_settings

# Heights of the rows of the sheet and places of the columns, in units of the drawing.
_TAPS, _DEVIATION, _RATE, _OUTPUT = 0.0, -10.0, -19.0, -28.0
_SUM = 33.5


def draw_card(design: Design, ax: Any) -> Any:
    """Draw one channel of a card and the supplies, values and settings on it.

    Parameters
    ----------
    design : Design
        The card.
    ax : matplotlib Axes
        Where to draw; a figure of 16 x 12 inch suits.

    Returns
    -------
    matplotlib Axes
        The same.
    """
    sheet = Sheet()
    _taps(sheet, design)
    _deviation(sheet, design)
    _rate(sheet, design)
    _surface(sheet, design)
    _boundary_layer(sheet, design)
    _limiter(sheet, design)
    _supply(sheet, design)
    _notes(sheet, design)
    sheet.draw(ax)
    return ax


def _taps(sheet: Sheet, design: Design) -> None:
    """Draw the transducer buffer and the two differentiators, left to right."""
    parts = design.soldered
    sheet.heading((-0.3, _TAPS + 5.4), "Double differentiator and taps")
    sheet.terminal((0, _TAPS + 0.625), "transducer")
    x = _follower(sheet, design, (0, _TAPS), "U1")
    sheet.net((x, _TAPS), "displacement", "on")
    for name, stage, tap in (
        ("U3", parts.velocity_differentiator, "velocity"),
        ("U4", parts.acceleration_differentiator, "acceleration"),
    ):
        sheet.line((x, _TAPS), (x, _TAPS + 0.625))
        minus = sheet.two(
            ("C", (x, _TAPS + 0.625), (x + 3.0, _TAPS + 0.625), "C", stage.capacitance),
            (
                "R",
                (x + 3.0, _TAPS + 0.625),
                (x + 6.0, _TAPS + 0.625),
                "Rs",
                stage.series_resistance,
            ),
        )
        out = sheet.amplifier((minus[0] + 0.8, _TAPS), name)
        sheet.line(minus, (minus[0] + 0.8, minus[1]))
        sheet.feedback(minus, out, 2.3, ("R", "R", stage.resistance))
        sheet.feedback(
            (minus[0], _TAPS + 2.3),
            (out[0], _TAPS + 2.3),
            4.0,
            ("C", "Cf", stage.feedback_capacitance),
        )
        plus = (minus[0] + 0.2, _TAPS - 0.625)
        sheet.line((plus[0] + 0.6, plus[1]), plus)
        _bias(sheet, plus, stage)
        x = out[0] + 1.6
        sheet.line(out, (x, _TAPS))
        sheet.dot((x, _TAPS))
        sheet.part("R", (x, _TAPS - 0.8), (x, _TAPS - 3.2), "Rt", parts.tap.resistance, "right")
        sheet.line((x, _TAPS), (x, _TAPS - 0.8))
        sheet.terminal((x, _TAPS - 3.2), f"{tap} tap", "down")
        if tap == "velocity":
            sheet.net((x, _TAPS), "velocity", "on")
    sheet.net((x, _TAPS), "acceleration", "on")
    sheet.line((x, _TAPS), (_SUM, _TAPS))


def _bias(sheet: Sheet, plus: Point, stage: DifferentiatorParts) -> None:
    """Draw the bias resistor of a differentiator and its bypass, from the input to ground."""
    x, y = plus[0], plus[1] - 0.8
    sheet.line(plus, (x, y), (x + 1.6, y))
    sheet.dot((x, y))
    sheet.part("R", (x, y), (x, y - 2.0), "Rp", stage.bias_resistance, "left")
    sheet.part("C", (x + 1.6, y), (x + 1.6, y - 2.0), "Cp", stage.bias_capacitance, "right")
    sheet.ground((x, y - 2.0))
    sheet.ground((x + 1.6, y - 2.0))


def _deviation(sheet: Sheet, design: Design) -> None:
    """Draw the demand buffer, difference amplifier, P1 with R1."""
    parts = design.soldered
    value = parts.difference_amplifier.resistance
    y = _DEVIATION
    sheet.heading((-0.3, y + 4.2), "Displacement less demand, weighted by P1")
    sheet.terminal((0, y + 0.625), "demand")
    x = _follower(sheet, design, (0, y), "U2")
    sheet.line((x, y), (x, y + 0.625))
    minus = (x + 4.6, y + 0.625)
    plus = (minus[0], y - 0.625)
    sheet.part("R", (x, minus[1]), minus, "Rd", value, "top")
    sheet.part("R", (x + 0.6, plus[1]), plus, "Rd", value, "bottom")
    sheet.net((x + 0.6, plus[1]), "displacement", "below")
    out = sheet.amplifier((minus[0] + 0.8, y), "U5")
    sheet.line(minus, (minus[0] + 0.8, minus[1]))
    sheet.line(plus, (plus[0] + 0.8, plus[1]))
    sheet.dot(plus)
    sheet.part("R", plus, (plus[0], plus[1] - 2.6), "Rd", value, "right")
    sheet.ground((plus[0], plus[1] - 2.6))
    sheet.feedback(minus, out, 2.3, ("R", "Rd", value))
    _weighted(sheet, design, out, "P1")


def _rate(sheet: Sheet, design: Design) -> None:
    """Draw the inverter, P2 with R2."""
    value = design.soldered.inverter.resistance
    y = _RATE
    sheet.heading((-0.3, y + 4.2), "Velocity made positive, weighted by P2")
    start = (6.5, y + 0.625)
    sheet.net(start, "velocity", "left")
    minus = (10.5, y + 0.625)
    sheet.part("R", start, minus, "Ri", value, "top")
    out = sheet.amplifier((minus[0] + 0.8, y), "U6")
    sheet.line(minus, (minus[0] + 0.8, minus[1]))
    sheet.line((minus[0] + 0.8, y - 0.625), (minus[0], y - 0.625))
    sheet.ground((minus[0], y - 0.625))
    sheet.feedback(minus, out, 2.3, ("R", "Ri", value))
    _weighted(sheet, design, out, "P2")


def _weighted(sheet: Sheet, design: Design, out: Point, name: str) -> None:
    """Draw P1 or P2 at an output, with the resistor behind its wiper to the summing line."""
    surface, turned = design.soldered.surface_amplifier, design.turned
    track, resistance, travel, behind = {
        "P1": (
            surface.displacement_potentiometer,
            surface.displacement_resistance,
            turned.displacement_weight,
            "R1",
        ),
        "P2": (
            surface.velocity_potentiometer,
            surface.velocity_resistance,
            turned.velocity_weight,
            "R2",
        ),
    }[name]
    x = 20.5
    sheet.line(out, (x, out[1]))
    wiper = sheet.potentiometer((x, out[1]), name, track, travel)
    sheet.ground((x, out[1] - 3))
    sheet.part(
        "R", (wiper[0] + 3.2, wiper[1]), (wiper[0] + 6.0, wiper[1]), behind, resistance, "top"
    )
    sheet.line(wiper, (wiper[0] + 3.2, wiper[1]))
    sheet.line((wiper[0] + 6.0, wiper[1]), (_SUM, wiper[1]))
    sheet.dot((_SUM, wiper[1]))


def _surface(sheet: Sheet, design: Design) -> None:
    """Draw R3 and the summing amplifier."""
    surface = design.soldered.surface_amplifier
    sheet.part("R", (_SUM, -3.2), (_SUM, -6.2), "R3", surface.acceleration_resistance, "right")
    sheet.line((_SUM, _TAPS), (_SUM, -3.2))
    sheet.line((_SUM, -6.2), (_SUM, _RATE - 1.5))
    y = (_DEVIATION + _RATE) / 2 - 0.5
    minus = (_SUM + 1.6, y + 0.625)
    sheet.heading((_SUM + 1.6, y + 4.6), "Surface amplifier")
    sheet.line((_SUM, minus[1]), (minus[0] + 0.8, minus[1]))
    sheet.dot((_SUM, minus[1]))
    out = sheet.amplifier((minus[0] + 0.8, y), "U7")
    sheet.line((minus[0] + 0.8, y - 0.625), (minus[0], y - 0.625))
    sheet.ground((minus[0], y - 0.625))
    sheet.feedback(minus, out, 2.3, ("R", "Rf", surface.feedback_resistance))
    sheet.line(out, (out[0] + 1.2, y))
    sheet.net((out[0] + 1.2, y), "surface", "right")


def _boundary_layer(sheet: Sheet, design: Design) -> None:
    """Draw the amplifier whose gain P3 sets, or the relay."""
    parts = design.soldered.boundary_layer_amplifier
    y = _OUTPUT
    sheet.heading((-0.3, y + 2.6), "Boundary layer, set by P3 (link open: relay)")
    sheet.net((3.0, y + 0.625), "surface", "left")
    sheet.line((3.0, y + 0.625), (4.6, y + 0.625))
    out = sheet.amplifier((4.6, y), "U8", plus_on_top=True)
    minus = (4.0, y - 0.625)
    low = y - 2.6
    sheet.line((4.6, minus[1]), minus)
    sheet.line(minus, (minus[0], low))
    sheet.dot((minus[0], low))
    sheet.part("R", (minus[0], low), (minus[0], low - 2.4), "Rg", parts.ground_resistance, "left")
    sheet.ground((minus[0], low - 2.4))
    sheet.part("R", (minus[0], low), (minus[0] + 2.6, low), "Rb", parts.feedback_resistance, "top")
    end = sheet.rheostat(
        (minus[0] + 2.6, low), "P3", parts.potentiometer, design.turned.boundary_layer
    )
    sheet.link(end, (end[0] + 1.8, low), "link")
    sheet.line((end[0] + 1.8, low), (end[0] + 1.8, y))
    sheet.line(out, (end[0] + 1.8, y))
    sheet.dot((end[0] + 1.8, y))


def _limiter(sheet: Sheet, design: Design) -> None:
    """Draw the zener clamp, P4 and the output follower."""
    limiter = design.soldered.output_limiter
    y, x = _OUTPUT, 11.9
    sheet.heading((x + 5.6, y + 2.6), "Level, set by P4")
    sheet.line((11.2, y), (x, y))
    sheet.part("R", (x, y), (x + 2.8, y), "Rc", limiter.clamp_resistance, "top")
    clamp = x + 4.0
    sheet.line((x + 2.8, y), (clamp + 3.4, y))
    sheet.dot((clamp, y))
    sheet.zeners((clamp, y), limiter.clamp_level)
    sheet.ground((clamp, y - 3.6))
    wiper = sheet.potentiometer((clamp + 3.4, y), "P4", limiter.potentiometer, design.turned.level)
    sheet.ground((clamp + 3.4, y - 3))
    sheet.line(wiper, (wiper[0] + 2.6, wiper[1]))
    end = _follower(sheet, design, (wiper[0] + 2.6, wiper[1] - 0.625), "U9")
    sheet.terminal((end, wiper[1] - 0.625), "control", "right")


def _follower(sheet: Sheet, design: Design, at: Point, name: str) -> float:
    """Draw a buffer from (x, y + 0.625) to (x of the return, y)."""
    x, y = at
    sheet.part(
        "R",
        (x, y + 0.625),
        (x + 2.8, y + 0.625),
        "Rin",
        design.soldered.input_buffer.series_resistance,
        "top",
    )
    sheet.line((x + 2.8, y + 0.625), (x + 3.2, y + 0.625))
    out = sheet.amplifier((x + 3.2, y), name, plus_on_top=True)
    sheet.line(
        out,
        (out[0] + 0.5, y),
        (out[0] + 0.5, y - 1.5),
        (x + 2.8, y - 1.5),
        (x + 2.8, y - 0.625),
        (x + 3.2, y - 0.625),
    )
    sheet.dot((out[0] + 0.5, y))
    sheet.line((out[0] + 0.5, y), (out[0] + 1.2, y))
    return out[0] + 1.2


def _supply(sheet: Sheet, design: Design) -> None:
    """Draw one rail with its decoupling, standing for both."""
    supply = design.soldered.supply
    x, y = 34.6, _OUTPUT
    sheet.heading((x - 0.2, y + 2.6), "Supplies, each rail, common to both channels")
    sheet.terminal((x, y), f"±{design.soldered.operational_amplifier.supply:g} V", "left")
    sheet.line((x, y), (x + 6.6, y))
    sheet.terminal((x + 6.6, y), "Vcc, Vee", "right")
    for at, name, value, note in (
        (x + 1.4, "Cb", supply.bulk_capacitance, ""),
        (x + 4.4, "Cd", supply.ceramic_capacitance, "\nat each\nop-amp"),
    ):
        sheet.dot((at, y))
        sheet.part("C", (at, y), (at, y - 2.4), name, value, "right", note)
        sheet.ground((at, y - 2.4))


def _notes(sheet: Sheet, design: Design) -> None:
    weights, parts = weights_from_settings(design), design.soldered
    contacts = parts.potentiometer_contacts
    lines = (
        design.title,
        "One of two equal channels. All op-amps CA3140; supply pins not drawn.",
        f"c1 = {weights.displacement:.5g} 1/s²,  c2 = {weights.velocity:.5g} 1/s,  c3 = 1,  "
        f"boundary layer {weights.boundary_layer:.3g} m/s²,  level {weights.level:.3g} V",
        f"Transducer {design.transducer.gain:.5g} V/m.  Potentiometers linear, travel shown in %; "
        f"ends {contacts.end_resistance:g} Ω, wiper {contacts.wiper_resistance:g} Ω",
    )
    sheet.notes((-0.3, _OUTPUT - 7.2), lines)
