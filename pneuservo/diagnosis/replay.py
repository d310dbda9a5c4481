"""Simulating a rig of the diagnosis on recorded inputs, with whatever effects it has."""

from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import model_of
from pneuservo.diagnosis.problem import problems_of
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig
from pneuservo.simulation import Simulation


def replay_model(recording: Recording, rig: Rig) -> Simulation:
    """Simulate the judged channel of a rig on the inputs of a recording.

    Parameters
    ----------
    recording : Recording
        Its inputs drive the model; its first samples give the initial state.
    rig : Rig
        A rig that the diagnosis covers, with the effects of a repaired model or without.

    Returns
    -------
    Simulation
        The recording's channels, the judged ones replaced by the model's.

    Raises
    ------
    InputError
        When the diagnosis does not cover the rig, or a channel is missing.
    """
    model = model_of(rig.kind)
    model.require_channels(recording)
    cases = model.cases(recording, rig.with_conditions(recording.conditions))
    problem = problems_of(model, cases, Hypothesis())[0]
    channels = dict(recording.channels)
    for case, started in zip(cases, problem.values(problem.start / problem.units), strict=True):
        values = started | {key: case.rig[key] for key in model.fitted(case)}
        channels[case.channel] = model.channel_in_si(case, values)
    return Simulation(cases[0].rig, recording.time, channels)
