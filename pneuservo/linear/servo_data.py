"""The numbers that the linear models of a servo are worked out from."""

from dataclasses import dataclass

from pneuservo.plant.gas import Gas, mass_flow_coefficient


@dataclass(frozen=True)
class FlowAreas:
    """Effective areas of the four paths of a fully open valve: discharge coefficient times area.

    Attributes
    ----------
    supply_to_a, b_to_exhaust, supply_to_b, a_to_exhaust : float
        [m^2].
    """

    supply_to_a: float
    b_to_exhaust: float
    supply_to_b: float
    a_to_exhaust: float


@dataclass(frozen=True)
class ServoData:
    """What the linear models of a double-acting pneumatic servo are worked out from.

    Attributes
    ----------
    area_a, area_b : float
        Piston areas of chambers a and b [m^2].
    stroke : float
        [m].
    dead_volume_a, dead_volume_b : float
        Volumes that remain at either end, pipes included [m^3].
    mass, viscous_friction : float
        Whole moved mass [kg], friction over velocity [N s/m].
    load : float
        Constant force on the rod that extends, such as gravity [N].
    polytropic_index : float
        Of both chambers [-].
    gas : Gas
        With its temperature.
    supply_pressure, exhaust_pressure : float
        Absolute [Pa].
    pressure_a, pressure_b : float
        Quiescent, absolute [Pa].
    flow_areas : FlowAreas
        Of the fully open valve.
    full_voltage : float
        Opens the valve fully [V].
    valve_frequency, valve_damping : float
        Of the spool [Hz], [-].
    """

    area_a: float
    area_b: float
    stroke: float
    dead_volume_a: float
    dead_volume_b: float
    mass: float
    viscous_friction: float
    load: float
    polytropic_index: float
    gas: Gas
    supply_pressure: float
    exhaust_pressure: float
    pressure_a: float
    pressure_b: float
    flow_areas: FlowAreas
    full_voltage: float
    valve_frequency: float
    valve_damping: float

    def through(self, upstream: float, downstream: float) -> float:
        """Return the mass flow for each effective area, times the root of the temperature.

        Parameters
        ----------
        upstream, downstream : float
            Absolute pressures, the upstream one the higher [Pa].
        """
        return float(mass_flow_coefficient(downstream / upstream, self.gas)) * upstream
