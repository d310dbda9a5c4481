"""The real circuit of the card in closed loop with the plant, both in ngspice."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

import netlists
from analog_card.amplifier_elements import netlist_elements
from analog_card.behaviour_elements import LINK_OPEN
from analog_card.design import Design
from analog_card.design_file import load_design
from analog_card.netlist_text import Netlist, read_netlist
from analog_card.ngspice import Session, Transient
from analog_card.waveforms import Waveforms
from pneuservo.arrays import Array
from pneuservo.controllers import card_of
from pneuservo.controllers.requirements import sensitivity
from pneuservo.errors import InputError
from pneuservo.plant import single_axis as places
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation import InitialState, Simulation
from pneuservo.simulation.inputs import require_kind, require_samples, require_times
from pneuservo.simulation.readings import require_exact_transducers

CLOSED_LOOP = netlists.BENCHES / "closed-loop.cir"
# Longer steps and other methods than Gear end in "Timestep too small" when the card is a relay.
LONGEST_STEP = 20e-6
# How long a change of the demand takes in the circuit.
_EDGE = 1e-6
_VALVE = "ddv-27a1"
# Node of the netlist, and what makes a channel in SI of its voltage.
_NODES = {
    "velocity": ("xplant.speed", 0.1),
    "acceleration": ("xplant.acceleration", 0.1),
    "pressure_a": ("xplant.pressure_a", 1e5),
    "pressure_b": ("xplant.pressure_b", 1e5),
    "spool": ("xplant.spool", 1.0),
    "valve_voltage": ("control", 1.0),
    "card_sensor": ("transducer", 1.0),
    "card_velocity": ("velocity", 1.0),
    "card_acceleration": ("acceleration", 1.0),
    "card_surface": ("surface", 1.0),
    "card_output": ("control", 1.0),
}


def simulate_circuit_loop(
    design: Design | None = None,
    rig: Rig | str = "single-axis",
    *,
    time: ArrayLike,
    demand: ArrayLike,
    relay: bool = False,
    elements: Mapping[str, float] | None = None,
    initial: InitialState | None = None,
    longest_step: float = LONGEST_STEP,
    time_limit: float = 3600.0,
) -> Simulation:
    """Simulate the netlist of the card in closed loop with the netlist of the plant.

    Parameters
    ----------
    design : Design, optional
        The card, as soldered and turned; without it the recommended card.
    rig : Rig or str, optional
        A rig of kind ``single-axis``, or its name.
    time : (n,) array
        Times of the result, strictly increasing [s].
    demand : (n,) array or float
        Demanded displacement, each value held until the next time [m].
    relay : bool, optional
        Whether the feedback of the boundary-layer amplifier is opened.
    elements : mapping of str to float, optional
        Values of single elements of the channel, as `analog_card.behaviour_elements` names them,
        for faults and spreads.
    initial : InitialState, optional
        By default at rest at the first demand.
    longest_step : float, optional
        The solver's steps are never longer [s].
    time_limit : float, optional
        Longest wait for ngspice [s].

    Returns
    -------
    Simulation
        The run with every channel of the plant and of the card.

    Raises
    ------
    InputError
        When the rig is not one this can simulate, or an argument cannot be used.
    SimulationError
        When ngspice failed, in its own words.

    Notes
    -----
    The plant in the netlist has the equations of the compiled one, with Coulomb friction smoothed
    below 1 mm/s and stiff springs for the end stops and the limits of the spool (see
    ``netlists/plant/single-axis.lib``). A change of the demand takes 1 us.

    Examples
    --------
    >>> run = simulate_circuit_loop(time=[0.0, 1e-3], demand=0.016, initial=InitialState(0.015))
    >>> bool(3.0 < run["valve_voltage"][0] < 3.6)  # c1 times 1 mm is 3.3 of 5 m/s2; and offsets
    True
    """
    design = design or load_design()
    rig = require_kind(rig, "single-axis")
    require_exact_transducers(rig, "the netlist of the plant")
    times = require_times(time)
    wanted = require_samples("demand", demand, times)
    if rig.valve != _VALVE:
        raise InputError(f"rig {rig.name} has the valve {rig.valve}; the netlist has {_VALVE}")
    if not 0.0 < longest_step < math.inf:
        raise InputError(f"longest_step is {longest_step:g} s; it has to be greater than 0")
    parameters = design.netlist_parameters() | {
        name: rig[key] for name, key in rig.conditions.items()
    }
    parameters |= _start(rig, wanted[0], initial or InitialState())
    parts = dict(elements or {})
    if relay:
        # Elements of a whole card have a link of their own, closed.
        parts["xboundary.rlink"] = LINK_OPEN
    netlist = _with_demand(read_netlist(CLOSED_LOOP), times - times[0], wanted, sensitivity(rig))
    nodes = sorted({node for node, _ in _NODES.values()})
    changed = netlist_elements(parts, design.soldered.operational_amplifier)
    with Session(netlist, parameters, nodes, time_limit) as session:
        session.change({f"xcard.{name}": value for name, value in changed.items()})
        waves = session.run(Transient(float(times[-1] - times[0]), longest_step))
    channels = {"demand": wanted, **_channels(waves, times - times[0], sensitivity(rig))}
    controller = card_of(design, elements=elements, relay=relay)
    return Simulation(rig, times, channels, controller, channels["card_surface"])


def _start(rig: Rig, first_demand: float, initial: InitialState) -> dict[str, float]:
    state = initial.state(plant_numbers.single_axis(rig), first_demand, 0.0)
    return {
        "start_displacement": state[places.DISPLACEMENT],
        "start_velocity": state[places.VELOCITY],
        "start_pressure_a": state[places.PRESSURE_A],
        "start_pressure_b": state[places.PRESSURE_B],
        "start_spool": state[places.SPOOL],
        "start_spool_rate": state[places.SPOOL_RATE],
    }


def _with_demand(netlist: Netlist, time: Array, demand: Array, sensitivity: float) -> Netlist:
    """Return the netlist with its source of the demand following given values, in volts."""
    volts = sensitivity * demand
    points = [(0.0, volts[0])]
    for k in np.flatnonzero(np.diff(volts) != 0.0) + 1:
        points += [(time[k], volts[k - 1]), (time[k] + _EDGE, volts[k])]
    written = " ".join(f"{float(at)!r} {float(value)!r}" for at, value in points)
    lines = tuple(
        replace(line, text=f"Vdemand demand 0 pwl({written})")
        if line.text.lower().startswith("vdemand ")
        else line
        for line in netlist.lines
    )
    return replace(netlist, lines=lines)


def _channels(waves: Waveforms, since: Array, sensitivity: float) -> dict[str, Array]:
    channels = {"displacement": waves.at(since, "transducer") / sensitivity}
    for channel, (node, scale) in _NODES.items():
        channels[channel] = scale * waves.at(since, node)
    return channels
