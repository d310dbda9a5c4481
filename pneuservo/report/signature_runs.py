"""The short runs in which the effects of a rig are shown, one set for each kind of rig."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.models import AnalogueCardModel, model_of
from pneuservo.effects import Effect
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig, load_rig

Channels = dict[str, Array]
Run = Callable[[Effect, Mapping[str, float]], Channels]
"""From an effect and its values to what is read: channels by name, the ``time`` among them [SI]."""


@dataclass(frozen=True)
class Motion:
    """A run of the servo from set point to set point under a proportional controller.

    Parameters
    ----------
    demands : tuple of float
        Set points as shares of the stroke.
    hold : float
        Time at each [s].
    """

    demands: tuple[float, ...]
    hold: float

    def __call__(self, effect: Effect, values: Mapping[str, float]) -> Channels:
        """Return what the transducers read.

        Parameters
        ----------
        effect : Effect
            What the rig has beyond the baseline.
        values : mapping of str to float
            Its parameters by name.
        """
        from pneuservo.controllers import Proportional
        from pneuservo.simulation import simulate, step_demand

        rig = replace(load_rig("single-axis"), effects={effect.id: values})
        places = [share * rig["piston.stroke"] for share in self.demands]
        time, demand = step_demand(places, self.hold, 1e3)
        run = simulate(rig, time=time, demand=demand, controller=Proportional())
        return {"time": time, **run.channels}


STEPS = Motion((0.5, 0.8, 0.2, 0.5), 0.5)
"""15, 24, 6 and 15 mm, as in the thesis."""
STOPS = Motion((0.5, 1.2, -0.2, 0.5), 0.5)
"""From stop to stop, where pressures reach supply and ambient."""
SMALL_STEPS = Motion((0.5, 0.505, 0.495, 0.5), 1.0)
"""After a rest each, with so little opening that breaking away takes its time."""


def _modelled(recording: Recording, rig: Rig, shown: slice = slice(None)) -> Run:
    """Return a run of the diagnosis' own model on the inputs of a recording, some samples of it."""
    model = model_of(rig.kind)
    cases = model.cases(recording, rig)

    def run(effect: Effect, values: Mapping[str, float]) -> Channels:
        found = {"time": recording.time, **recording.channels}
        for case in cases:
            given = {key: rig[key] for key in model.fitted(case)}
            given |= {u.key: u.start for u in model.nuisances(case, frozenset())}
            given |= {effect.key(name): value for name, value in values.items()}
            if isinstance(model, AnalogueCardModel):
                found[case.channel] = model.channel_in_si(case, given)
            else:
                found[case.channel] = model.predict(case, given)
        return {name: samples[shown] for name, samples in found.items()}

    return run


def _closed_volume() -> Run:
    """Return a test volume that is filled, left alone, vented and left alone again."""
    from pneuservo.simulation import simulate_dead_volume

    rig, time = load_rig("dead-volume"), np.arange(0.0, 30.0, 0.02)
    voltage = 5.0 * ((time >= 1.0) & (time < 2.0)) - 5.0 * ((time >= 20.0) & (time < 20.15))
    run = simulate_dead_volume(rig, time=time, command=voltage)
    recording = run.to_recording()
    return _modelled(replace(recording, noise_rms={"dead_volume_pressure": 100.0}), rig)


def _seal_strokes() -> Run:
    """Return strokes of 30 mm by an outside drive, at 3 bar in the chamber."""
    time = np.arange(0.0, 10.0, 0.01)
    channels = {
        "displacement": 0.025 - 0.015 * np.cos(2.0 * np.pi * 0.2 * time),
        "pressure_a": np.full(len(time), 4e5),
        "force": np.zeros(len(time)),
    }
    recording = Recording("strokes", time, channels, "seal-tester", noise_rms={"force": 0.05})
    return _modelled(recording, load_rig("seal-tester"))


def _circuit_sweep() -> Run:
    """Return a sine of 0.2 V that sweeps through the circuit's resonance."""
    from scipy.signal import chirp

    time = np.arange(0.0, 2.0, 1e-3)
    channels = {
        "circuit_input": 0.2 * chirp(time, 20.0, time[-1], 80.0, phi=-90.0),
        "circuit_output": np.zeros(len(time)),
    }
    recording = Recording("sweep", time, channels, "circuit", noise_rms={"circuit_output": 1e-3})
    return _modelled(recording, load_rig("circuit"))


def _card_taps() -> Run:
    """Return the taps of the nominal card, on a transducer that swings and a switched demand."""
    from analog_card.behaviour import CardBehaviour
    from analog_card.behaviour_model import run_behaviour
    from analog_card.design_file import load_design

    rig, time = load_rig("analogue-card"), np.arange(0.0, 0.16, 1e-4)
    swing = ((2.0, 3.0), (1.0, 17.0), (0.35, 60.0))
    voltage = np.full(len(time), 5.0)
    for size, frequency in swing:
        voltage += size * np.cos(2.0 * np.pi * frequency * time)
    demand = np.where(time % 0.12 < 0.06, 4.0, 6.0)
    taps = run_behaviour(CardBehaviour(load_design()), time, voltage, demand)
    channels = {
        "card_sensor": voltage,
        "demand": demand / rig["sensor.displacement.sensitivity"],
        "card_velocity": taps["first"],
        "card_acceleration": taps["second"],
        "card_surface": taps["surface"],
        "card_output": taps["control"],
    }
    noise = {name: 2e-3 for name in channels if name != "demand"}
    recording = Recording("taps", time, channels, rig.kind, noise_rms=noise)
    # The filters' start, and their unknown future at the end, have no say in between.
    return _modelled(recording, rig, slice(200, -200))


def runs_of(kind: str) -> Sequence[Run]:
    """Return the runs in which the effects of a kind of rig are shown.

    Parameters
    ----------
    kind : str
        Kind of rig, such as ``"dead-volume"``.

    Returns
    -------
    sequence of callable
        In the order in which they are tried.

    Raises
    ------
    InputError
        When the catalogue has no effect for this kind of rig.
    """
    made: dict[str, Callable[[], Sequence[Run]]] = {
        "single-axis": lambda: (STEPS, STOPS, SMALL_STEPS),
        "dead-volume": lambda: (_closed_volume(),),
        "seal-tester": lambda: (_seal_strokes(),),
        "circuit": lambda: (_circuit_sweep(),),
        "analogue-card": lambda: (_card_taps(),),
    }
    if kind not in made:
        raise InputError(
            f"there are no pictures of the effects of a rig of kind {kind}; there are of: "
            f"{', '.join(made)}"
        )
    return made[kind]()
