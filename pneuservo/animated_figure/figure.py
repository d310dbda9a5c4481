"""What an animated figure is made of: a frame, and members that pneumatic axes turn."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pneuservo.animated_figure.kernel import Coupling
from pneuservo.errors import InputError
from pneuservo.manipulator.linkage import ON_BASE, Link, linkage_of
from pneuservo.naming import require_known
from pneuservo.rigs import Rig

BUILT_IN_FIGURES = ("arm", "seven-axes", "fourteen-axes")
"""Figures that come with the package."""

FRAME = "frame"
"""What carries a member that stands on no other."""


@dataclass(frozen=True)
class Frame:
    """What the members stand on; it sways in one horizontal direction.

    Parameters
    ----------
    mass : float
        Without the members [kg].
    frequency : float
        Of its sway without the members [Hz].
    damping : float, optional
        Its damping ratio [-].

    Raises
    ------
    InputError
        When a value is one no frame can have.
    """

    mass: float
    frequency: float
    damping: float = 0.02

    def __post_init__(self) -> None:
        """Refuse what no frame can have."""
        for name in ("mass", "frequency"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(
                    f"frame: {name} is {getattr(self, name):g}; it has to be greater than 0"
                )
        if not 0.0 <= self.damping < math.inf:
            raise InputError(f"frame: damping is {self.damping:g}; it has to be 0 or more")

    @property
    def stiffness(self) -> float:
        """Return the stiffness that gives it its frequency [N/m]."""
        return self.mass * (2.0 * math.pi * self.frequency) ** 2

    @property
    def friction(self) -> float:
        """Return the force per velocity that gives it its damping [N s/m]."""
        return 2.0 * self.damping * self.mass * 2.0 * math.pi * self.frequency


@dataclass(frozen=True)
class Axis:
    """A pneumatic axis and the member it turns.

    Parameters
    ----------
    rig : Rig
        Of kind ``single-axis``; its load mass is what moves along with the rod.
    lever : float
        Displacement of the rod per angle, constant [m/rad].
    mass, inertia, centre, length : float
        Of the member: [kg], about its centre of gravity [kg m^2], from its joint to that centre
        and to the joints of what it carries [m].
    carrier : str, optional
        Name of the axis whose member it stands on.
    rest_angle : float, optional
        Of the member with the rod at mid-stroke, from its carrier's direction, on the frame from
        the upright [rad].

    Raises
    ------
    InputError
        When the rig is of another kind, or a value is one no member can have.
    """

    rig: Rig
    lever: float
    mass: float
    inertia: float
    centre: float
    length: float
    carrier: str = FRAME
    rest_angle: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no axis can have."""
        if self.rig.kind != "single-axis":
            raise InputError(
                f"rig {self.rig.name} is of kind {self.rig.kind}; an axis of a figure is of kind "
                "single-axis"
            )
        for name in ("lever", "mass", "inertia"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise InputError(f"{name} is {value:g}; it has to be greater than 0")
        for name in ("centre", "length"):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise InputError(f"{name} is {value:g} m; it has to be 0 or more")
        if not math.isfinite(self.rest_angle):
            raise InputError(f"rest_angle is {self.rest_angle}; it has to be a finite number")

    @property
    def middle(self) -> float:
        """Return mid-stroke, where the member is at its rest angle [m]."""
        return 0.5 * self.rig["piston.stroke"]


@dataclass(frozen=True)
class AnimatedFigure:
    """A figure: members on a frame, each turned by an axis, all in one vertical plane.

    Parameters
    ----------
    name : str
        Its name, or the path of its file.
    title : str
        What people call it.
    frame : Frame
        What it stands on.
    axes : mapping of str to Axis
        By name, carriers before what they carry.
    gravity : float, optional
        [m/s^2].

    Raises
    ------
    InputError
        When there is no axis, or one stands on what does not come before it.

    Examples
    --------
    >>> from pneuservo.animated_figure import load_figure
    >>> list(load_figure("arm").axes)
    ['shoulder', 'elbow']
    >>> list(load_figure("arm").without("elbow").axes)
    ['shoulder']
    """

    name: str
    title: str
    frame: Frame
    axes: Mapping[str, Axis]
    gravity: float = 9.81

    def __post_init__(self) -> None:
        """Refuse a figure whose parts do not hang together."""
        if not self.axes:
            raise InputError(f"figure {self.name}: there is no axis; a figure has one or more")
        known = {FRAME}
        for name, axis in self.axes.items():
            if axis.carrier not in known:
                raise InputError(
                    f"figure {self.name}: axis {name} stands on {axis.carrier!r}; it can stand "
                    f"on: {', '.join(sorted(known))}, which come before it"
                )
            known.add(name)

    def without(self, *names: str) -> "AnimatedFigure":
        """Return the figure without some axes, and without whatever these carry.

        Parameters
        ----------
        *names : str
            Of axes.

        Returns
        -------
        AnimatedFigure
            A new figure; this one is unchanged.

        Raises
        ------
        InputError
            When there is no such axis, or none would be left.
        """
        gone = set(names)
        for name in names:
            require_known(name, self.axes, f"figure {self.name}, axes")
        for name, axis in self.axes.items():
            if axis.carrier in gone:
                gone.add(name)
        return replace(self, axes={key: axis for key, axis in self.axes.items() if key not in gone})

    def only(self, *names: str) -> "AnimatedFigure":
        """Return the figure with some axes only, and with what these stand on.

        Parameters
        ----------
        *names : str
            Of axes.

        Returns
        -------
        AnimatedFigure
            A new figure; this one is unchanged.

        Raises
        ------
        InputError
            When there is no such axis.
        """
        kept = set(names)
        for name in names:
            require_known(name, self.axes, f"figure {self.name}, axes")
        for name, axis in reversed(list(self.axes.items())):
            if name in kept:
                kept.add(axis.carrier)
        return replace(self, axes={key: axis for key, axis in self.axes.items() if key in kept})

    @property
    def left_out(self) -> dict[str, tuple[str, ...]]:
        """Return the effects of the axes' rigs that a run of the figure leaves out, by axis."""
        return {
            name: tuple(axis.rig.effects) for name, axis in self.axes.items() if axis.rig.effects
        }

    @property
    def coupling(self) -> Coupling:
        """Return what joins the axes, as the kernels take it."""
        places = {name: place for place, name in enumerate(self.axes)}
        axes = self.axes.values()
        return Coupling(
            linkage=linkage_of(
                [
                    Link(
                        axis.mass,
                        axis.inertia,
                        axis.centre,
                        axis.length,
                        places.get(axis.carrier, ON_BASE),
                        axis.rest_angle,
                    )
                    for axis in axes
                ]
            ),
            levers=np.array([axis.lever for axis in axes]),
            middles=np.array([axis.middle for axis in axes]),
            gravity=float(self.gravity),
            frame_mass=float(self.frame.mass),
            frame_stiffness=self.frame.stiffness,
            frame_damping=self.frame.friction,
        )
