"""The canonical channels: one name, one SI unit and one meaning each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Channel:
    """A canonical channel.

    Parameters
    ----------
    name : str
        The name used in files, tables and code.
    unit : str
        Its SI unit; ``""`` for a pure number.
    meaning : str
        What is measured, and its sign.
    pressure : bool, optional
        Whether gauge readings are allowed (the ambient pressure is then added).
    """

    name: str
    unit: str
    meaning: str
    pressure: bool = False


CHANNELS: dict[str, Channel] = {
    channel.name: channel
    for channel in (
        Channel("demand", "m", "set point of the piston displacement"),
        Channel("displacement", "m", "piston displacement, 0 = fully retracted"),
        Channel("velocity", "m/s", "piston velocity, measured"),
        Channel("acceleration", "m/s**2", "piston acceleration, measured"),
        Channel("pressure_a", "Pa", "absolute pressure in chamber a, the full piston area", True),
        Channel("pressure_b", "Pa", "absolute pressure in chamber b, the rod side", True),
        Channel("supply_pressure", "Pa", "absolute pressure at the valve's supply port", True),
        Channel("temperature_a", "K", "gas temperature in chamber a"),
        Channel("temperature_b", "K", "gas temperature in chamber b"),
        Channel("valve_voltage", "V", "command into the valve driver, +5 V = fully open, extends"),
        Channel("spool", "", "spool position as a fraction of full opening, -1 to 1"),
        Channel("force", "N", "external force at the rod, positive when it resists extension"),
        Channel("card_sensor", "V", "transducer input of the card"),
        Channel("card_velocity", "V", "output of the card's first differentiator"),
        Channel("card_acceleration", "V", "output of the card's second differentiator"),
        Channel("card_surface", "V", "output of the card's surface summer"),
        Channel("card_output", "V", "output of the card"),
        Channel("circuit_input", "V", "input terminals of a recorded circuit"),
        Channel("circuit_output", "V", "output terminals of a recorded circuit"),
        Channel("dead_volume_pressure", "Pa", "absolute pressure of a closed test volume", True),
    )
}
