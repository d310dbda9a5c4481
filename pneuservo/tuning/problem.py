"""What is tuned: a card, the set of rigs that it has to do for, and what it must not do there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from analog_card.design import Design, Turned
from analog_card.design_file import load_design
from analog_card.figures import card_figures
from analog_card.quantities import as_text
from analog_card.tolerance_trials import fingerprint
from pneuservo.bench_tuning import LARGEST_OVERSHOOT
from pneuservo.campaign.parameters import varied_design, varied_rig
from pneuservo.campaign.plan import Campaign
from pneuservo.campaign.plan_file import campaign_of
from pneuservo.campaign.run import identity
from pneuservo.controllers import AnalogueCard
from pneuservo.errors import InputError
from pneuservo.loop_controller import FIGURES
from pneuservo.rigs import Rig
from pneuservo.simulation.demand import names_recording

OBJECTIVES = ("settling_time", "chatter", "control_effort")
"""What is made small, each in the worst rig of the set; metrics of a campaign."""
LIMITED = ("overshoot", "steady_state_error")
"""What must stay below a limit in every rig of the set."""
POTENTIOMETERS = ("P1", "P2", "P3", "P4")
"""In the order of `analog_card.design.Turned`."""

# A wider error is no answer to the step: half of what the offsets of a card leave.
LARGEST_ERROR = 0.1e-3
_DEMAND, _RATE = "15,24,6,15 mm", 2000.0
# The air main of the thesis' laboratory, and its lightest and heaviest load (Figure 9.19).
_STATED = {"supply.pressure": "6.5, 7.7 bar", "load.mass": "1.825, 11.825 kg"}
# What sets the gains of the taps, and is least exact.
_CAPACITORS = ("velocity_differentiator", "acceleration_differentiator")
# What the settings are, or are derived from, cannot be part of the set.
_TUNED = ("turned.", "controller.")
_NO_EFFECTS = (
    "rigs with effects cannot be tuned for, many runs side by side being of the baseline; vary "
    "parameters of the rig and parts of the card, and judge the outcome with effects by pneuservo "
    "campaign"
)
# To which part of its travel a potentiometer is turned by hand: a hundredth of one of ten turns.
_SETTING_STEP = 1e-3


@dataclass(frozen=True)
class TuningProblem:
    """A card to be tuned for a set of rigs.

    Attributes
    ----------
    campaign : Campaign
        Its samples are the rigs of the set; its design is the card, its demand what is followed.
    largest_overshoot : float
        Allowed in every rig, as a share of the step [-].
    largest_error : float
        Steady-state error allowed in every rig [m].
    left_out : tuple of str
        Effects of the rig that was given: many runs side by side are of the baseline.
    """

    campaign: Campaign
    largest_overshoot: float = LARGEST_OVERSHOOT
    largest_error: float = LARGEST_ERROR
    left_out: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what makes no problem."""
        for axis in self.campaign.axes:
            if axis.name.startswith(_TUNED):
                raise InputError(
                    f"--vary {axis.name}: the settings are what is looked for; vary the rig or "
                    "the parts of the card (soldered.…)"
                )
            if ":" in axis.name:
                raise InputError(f"--vary {axis.name}: {_NO_EFFECTS}")
        if not np.any(np.diff(self.campaign.demand)):
            raise InputError(
                "the demand never changes, so that there is no step to settle after; "
                "give it two set points and more"
            )
        for name in ("largest_overshoot", "largest_error"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name} is {getattr(self, name):g}; it has to be greater than 0")

    @property
    def design(self) -> Design:
        """Return the card as it is soldered, and turned now."""
        design: Design = self.campaign.options["design"]
        return design

    @cached_property
    def members(self) -> tuple[dict[str, float], ...]:
        """Return what is special about each rig of the set, in SI by name."""
        return tuple(self.campaign.values(index) for index in range(len(self.campaign)))

    @cached_property
    def rigs(self) -> tuple[Rig, ...]:
        """Return the rigs of the set."""
        return tuple(varied_rig(self.campaign.rig, values) for values in self.members)

    def turned(self, settings: Sequence[float]) -> Design:
        """Return the card with its potentiometers at P1 to P4, fractions of travel."""
        names = [item.name for item in fields(Turned)]
        return replace(self.design, turned=Turned(**dict(zip(names, settings, strict=True))))

    def controllers(self, settings: Sequence[float]) -> list[AnalogueCard]:
        """Return the card of each rig of the set, by its figures.

        The card of each has parts of its own and the same settings.
        """
        design = self.turned(settings)
        return [AnalogueCard(card_figures(varied_design(design, each))) for each in self.members]

    @property
    def now(self) -> tuple[float, ...]:
        """Return where the potentiometers stand now."""
        return tuple(float(value) for value in vars(self.design.turned).values())

    def identity(self) -> str:
        """Return a text that differs between problems with different answers."""
        limits = (self.largest_overshoot, self.largest_error)
        return fingerprint(identity(self.campaign), len(self.campaign), limits)


def settable(settings: Sequence[float]) -> tuple[float, ...]:
    """Return settings as a hand can turn them, to a thousandth of the travel.

    Examples
    --------
    >>> settable([0.48194, 0.0, 1.0, 0.9996])
    (0.482, 0.0, 1.0, 1.0)
    """
    digits = round(-np.log10(_SETTING_STEP))
    return tuple(round(min(max(float(value), 0.0), 1.0), digits) for value in settings)


def tuning_problem(
    settings: Mapping[str, Any],
    largest_overshoot: float = LARGEST_OVERSHOOT,
    largest_error: float = LARGEST_ERROR,
    where: str = "--vary",
) -> TuningProblem:
    """Return the problem that settings describe.

    Parameters
    ----------
    settings : mapping of str to anything
        As a campaign file has them, with the set of rigs in ``vary``; what is left out is the
        recommended card, the thesis' steps at 2 kHz, and `standard_set`.
    largest_overshoot, largest_error : float, optional
        Allowed in every rig [-], [m].
    where : str, optional
        Where the set was given, for error messages.

    Returns
    -------
    TuningProblem
        Checked as far as can be without simulating.

    Raises
    ------
    InputError
        When something is unknown, or not a quantity of the right kind.

    Examples
    --------
    >>> problem = tuning_problem({"vary": {"load.mass": "1.8, 7 kg"}})
    >>> problem.members
    ({'load.mass': 1.8}, {'load.mass': 7.0})
    """
    controller = settings.get("controller", AnalogueCard.kind)
    if controller != AnalogueCard.kind:
        raise InputError(
            f"controller {controller!r} has no potentiometers; leave it out, or write "
            f'"{AnalogueCard.kind}"'
        )
    if settings.get("card", FIGURES) != FIGURES:
        raise InputError(
            f'card = "{settings["card"]}": the search simulates the card by its figures; leave it '
            "out. The outcome is checked by the card's behaviour anyway"
        )
    used = {"demand": _DEMAND, **settings, "controller": controller}
    if not names_recording(used["demand"]):
        used.setdefault("rate", _RATE)
    if not used.get("vary"):
        used["vary"] = standard_set(load_design(used.get("design")))
    campaign = campaign_of({**used, "metrics": [*OBJECTIVES, *LIMITED]}, where)
    left_out = tuple(campaign.rig.effects)
    campaign = replace(campaign, rig=replace(campaign.rig, effects={}))
    return TuningProblem(campaign, largest_overshoot, largest_error, left_out)


def standard_set(design: Design) -> dict[str, Any]:
    """Return the set of rigs for which a card is tuned, unless said: its sixteen corners.

    Supply pressure and load as far as the thesis had them, and both capacitors that make the
    derivatives at either end of their tolerance.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> standard_set(load_design())["soldered.velocity_differentiator.capacitance"]
    ['95 nF', '105 nF']
    """
    corners: dict[str, Any] = dict(_STATED)
    for section in _CAPACITORS:
        value = getattr(design.soldered, section).capacitance
        share = design.part_tolerance(section, "capacitance").tolerance
        ends = [as_text(value * (1 + sign * share), "F", 6) for sign in (-1, 1)]
        corners[f"soldered.{section}.capacitance"] = ends
    return corners
