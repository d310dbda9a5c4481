"""The mass flow into a chamber, as its measured pressure and volume tell it."""

from pneuservo.diagnosis.models.model import Array
from pneuservo.plant.single_axis import SingleAxis


def charging_flow(
    pressure: Array,
    pressure_rate: Array,
    displacement: Array,
    velocity: Array,
    plant: SingleAxis,
    side: str,
) -> Array:
    """Return the mass flow into a chamber [kg/s].

    Parameters
    ----------
    pressure, pressure_rate : (n,) array
        [Pa], [Pa/s].
    displacement, velocity : (n,) array
        Of the piston [m], [m/s].
    plant : SingleAxis
        The numbers of the rig.
    side : str
        ``"a"`` or ``"b"``.

    Notes
    -----
    Equation (4.12) solved for the flow.
    """
    piston, gas = plant.piston, plant.gas
    area, length, direction = piston.area_a, displacement, 1.0
    dead = plant.dead_volume_a
    if side == "b":
        area, length, direction = piston.area_b, piston.stroke - displacement, -1.0
        dead = plant.dead_volume_b
    volume = area * length + dead
    stored = volume * pressure_rate / plant.polytropic_index
    flow: Array = (stored + pressure * direction * area * velocity) / (
        gas.gas_constant * gas.temperature
    )
    return flow
