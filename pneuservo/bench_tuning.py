"""The thesis' bench procedure: P1 and P2 against the ideal response, then P3 until all is quiet."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from analog_card.design import Design
from analog_card.settings import (
    boundary_layer_at,
    boundary_layer_setting,
    displacement_setting,
    velocity_setting,
)
from analog_card.surface_weights import weights_from_settings
from pneuservo.arrays import Array
from pneuservo.controllers import Controller, SlidingMode, card_of
from pneuservo.errors import InputError
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import InitialState, Simulation, simulate
from pneuservo.simulation.metrics import StepResponse

Respond = Callable[[Design], Array]

# P1 and P2 are looked for between these fractions of travel; further down the loop hardly moves.
_LOWEST, _HIGHEST = 0.05, 1.0
# P3 is turned from the narrowest layer by this factor until the response is satisfactory, and the
# last turn is then halved this many times: to 2 %.
_WIDENING, _HALVINGS = 1.4, 4
# A satisfactory response: no limit cycle at the end of the hold, and no more overshoot than this.
LARGEST_OVERSHOOT = 0.02


@dataclass(frozen=True)
class Match:
    """Settings of P1 and P2 that bring one response onto another.

    Attributes
    ----------
    design : Design
        The card turned to them.
    before, after : float
        Root-mean-square difference of the displacements, before and after turning, without their
        mean difference [m].
    """

    design: Design
    before: float
    after: float


@dataclass(frozen=True)
class BenchTuning:
    """What the bench procedure found.

    Attributes
    ----------
    match : Match
        P1 and P2, with the boundary layer as it was.
    design : Design
        The card with P1, P2 and P3 turned.
    boundary_layer : float
        Narrowest satisfactory layer, by the nominal values of the card [m/s2].
    response : StepResponse
        Of the card as it then is.
    tried : tuple of (float, bool)
        Every layer tried and whether it was satisfactory [m/s2].
    """

    match: Match
    design: Design
    boundary_layer: float
    response: StepResponse
    tried: tuple[tuple[float, bool], ...]


def match_response(respond: Respond, target: Array, design: Design) -> Match:
    """Find the settings of P1 and P2 that bring a card's response onto a target.

    Parameters
    ----------
    respond : callable
        Returns the displacement of the loop with a card turned as given, (n,) array [m].
    target : (n,) array
        Displacement wanted at the same times [m].
    design : Design
        The card to begin with.

    Returns
    -------
    Match
        Least squares of the difference without its mean, P1 and P2 between 5 and 100 % of travel.

    Raises
    ------
    InputError
        When response and target are not of one length.

    Notes
    -----
    A constant difference comes from offset voltages, which P1 and P2 are not there to hide: with
    it in, the search would turn both up to the end.
    """
    start = respond(design)
    if start.shape != target.shape:
        raise InputError(
            f"the response has {len(start)} samples and the target {len(target)}; "
            "both are needed at the same times"
        )

    def turned(fractions: Array) -> Design:
        p1, p2 = (float(value) for value in fractions)
        settings = replace(design.turned, displacement_weight=p1, velocity_weight=p2)
        return replace(design, turned=settings)

    first = np.array([design.turned.displacement_weight, design.turned.velocity_weight])
    found = least_squares(
        # In mm, so that the tolerances of the search mean something.
        lambda fractions: 1e3 * _deviation(respond(turned(fractions)), target),
        np.clip(first, _LOWEST, _HIGHEST),
        bounds=(_LOWEST, _HIGHEST),
        # Steps of the derivatives: well above what the fixed steps of the simulation leave.
        diff_step=1e-3,
        xtol=1e-4,
        ftol=1e-6,
    )
    best = turned(found.x)
    return Match(best, _rms(start, target), _rms(respond(best), target))


def effective_settings(recorded: Array, respond: Respond, target: Array, design: Design) -> Match:
    """Find how far to turn a real card from one recorded response.

    Parameters
    ----------
    recorded : (n,) array
        Displacement of the loop with the real card, turned as the design says [m].
    respond : callable
        Returns the displacement with an exact card turned as given, (n,) array [m].
    target : (n,) array
        Displacement wanted [m].
    design : Design
        The real card by its nominal values, with its settings.

    Returns
    -------
    Match
        The real card's new settings; `before` is that of the recording, `after` what is expected.

    Raises
    ------
    InputError
        When the settings are outside the range of the potentiometers.

    Notes
    -----
    Parts out of tolerance act as if P1 and P2 stood elsewhere. Where they seem to stand follows
    from matching the exact card to the recording; where they ought to stand from matching it to
    the target. The real card is then turned by the ratio of the weights.
    """
    seeming = match_response(respond, recorded, design)
    wanted = match_response(respond, target, design)
    nominal, seen, aim = (
        weights_from_settings(card) for card in (design, seeming.design, wanted.design)
    )
    turned = _turned_to(
        design,
        nominal.displacement * aim.displacement / seen.displacement,
        nominal.velocity * aim.velocity / seen.velocity,
    )
    return Match(turned, _rms(recorded, target), wanted.after)


def _turned_to(design: Design, c1: float, c2: float) -> Design:
    settings = replace(
        design.turned,
        displacement_weight=displacement_setting(c1, design),
        velocity_weight=velocity_setting(c2, design),
    )
    return replace(design, turned=settings)


def bench_tune(
    design: Design,
    ideal: SlidingMode,
    time: Array,
    demand: Array,
    recorded: Array | None = None,
    rig: Rig | None = None,
    initial: InitialState | None = None,
    step: Callable[[str], None] = lambda _: None,
) -> BenchTuning:
    """Tune a card as on the bench: P1 and P2 by the step response, then P3 until it is quiet.

    Parameters
    ----------
    design : Design
        The card as it is soldered and turned.
    ideal : SlidingMode
        The ideal digital controller, with the true velocity and acceleration.
    time, demand : (n,) array
        Step of the demand [s], [m].
    recorded : (n,) array, optional
        Displacement measured with the real card; without it the card is simulated by its
        behaviour, imperfections included [m].
    rig : Rig, optional
        A rig of kind ``single-axis``.
    initial : InitialState, optional
        By default at rest at the first demand.
    step : callable, optional
        Told what is done next.

    Returns
    -------
    BenchTuning
        New settings of P1, P2 and P3.

    Raises
    ------
    InputError
        When no layer within the range of P3 gives a satisfactory response, or P1 and P2 would
        have to stand outside their range.

    Notes
    -----
    Section 9.3.4 of the thesis. Satisfactory is: no limit cycle of the switching function over the
    second half of the last hold, and at most 2 % overshoot. The layer is raised from the narrowest
    that P3 gives until the response is satisfactory, and found to 2 %; a wider one would only make
    the loop slower.
    """
    if not np.any(np.diff(demand)):
        raise InputError(
            "the demand never changes, so that there is no step response to judge; "
            "give it two set points and more"
        )
    rig = rig or load_rig("single-axis")
    step_at = int(np.flatnonzero(np.diff(demand))[-1]) + 1

    def run(controller: Controller) -> Simulation:
        return simulate(rig, time=time, demand=demand, controller=controller, initial=initial)

    def respond(card: Design) -> Array:
        return run(card_of(card))["displacement"][step_at:]

    step("ideal response")
    target = run(ideal)["displacement"][step_at:]
    step("P1 and P2")
    if recorded is None:
        match = match_response(respond, target, design)
    else:
        match = effective_settings(recorded[step_at:], respond, target, design)
    tried: list[tuple[float, bool]] = []

    def judge(layer: float) -> Simulation:
        step(f"P3, {layer:.3g} m/s2")
        response = run(card_of(_with_layer(match.design, layer)))
        tried.append((layer, satisfactory(response)))
        return response

    layer, response = _narrowest(judge, tried, match.design)
    return BenchTuning(
        match,
        _with_layer(match.design, layer),
        layer,
        response.step_responses()[-1],
        tuple(tried),
    )


def _narrowest(
    judge: Callable[[float], Simulation], tried: list[tuple[float, bool]], design: Design
) -> tuple[float, Simulation]:
    """Return the narrowest satisfactory layer within the range of P3, and the response with it."""
    narrowest, widest = boundary_layer_at(1.0, design), boundary_layer_at(0.0, design)
    too_narrow, layer = narrowest, narrowest
    response = judge(layer)
    while not tried[-1][1]:
        if layer >= widest:
            raise InputError(
                f"no boundary layer from {narrowest:.3g} to {widest:.3g} m/s2, the range of P3, is "
                "free of a limit cycle with at most 2 % overshoot; ask for a longer settling "
                "time, or solder a smaller ground_resistance with a smaller feedback_resistance "
                "for wider layers"
            )
        too_narrow, layer = layer, min(layer * _WIDENING, widest)
        response = judge(layer)
    for _ in range(_HALVINGS if layer > narrowest else 0):
        middle = (too_narrow * layer) ** 0.5
        candidate = judge(middle)
        if tried[-1][1]:
            layer, response = middle, candidate
        else:
            too_narrow = middle
    return layer, response


def satisfactory(response: Simulation) -> bool:
    """Return whether a step response is satisfactory: no limit cycle, at most 2 % overshoot."""
    overshoot = response.step_responses()[-1].overshoot
    return response.limit_cycle() is None and overshoot <= LARGEST_OVERSHOOT


def _with_layer(design: Design, layer: float) -> Design:
    narrowest = boundary_layer_at(1.0, design)
    setting = 1.0 if layer <= narrowest else boundary_layer_setting(layer, design)
    return replace(design, turned=replace(design.turned, boundary_layer=setting))


def _deviation(response: Array, target: Array) -> Array:
    difference = response - target
    return difference - np.mean(difference)


def _rms(response: Array, target: Array) -> float:
    return float(np.sqrt(np.mean(_deviation(response, target) ** 2)))
