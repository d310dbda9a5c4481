"""Planar links, each turning on the one that carries it, on a base that may sway."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pneuservo.plant.compilation import compiled

# Joint that stands on the base.
ON_BASE = -1


class Link(NamedTuple):
    """One rigid link."""

    mass: float
    """[kg]."""
    inertia: float
    """About its centre of gravity [kg m^2]."""
    centre: float
    """From its joint to its centre of gravity [m]."""
    length: float
    """From its joint to the joints of the links it carries [m]."""
    carrier: int = ON_BASE
    """Place of the link it turns on, before it in the list; `ON_BASE` for none."""
    rest_angle: float = 0.0
    """From its carrier at joint angle 0, on the base from the upright [rad]."""


class Linkage(NamedTuple):
    """The numbers of a linkage as the kernels take them."""

    paths: np.ndarray
    """(n, n): 1 where a joint (column) turns a link (row) [-]."""
    rest_angles: np.ndarray
    """(n,): of the links from the upright at joint angles 0 [rad]."""
    products: np.ndarray
    """(n, n): sum over all masses of mass x arm x arm, by the links the arms lie along [kg m^2]."""
    moments: np.ndarray
    """(n,): sum over all masses of mass x arm, by the link the arm lies along [kg m]."""
    inertias: np.ndarray
    """(n,): of the links about their centres [kg m^2]."""
    mass: float
    """Of all links [kg]."""


def linkage_of(links: Sequence[Link]) -> Linkage:
    """Return the linkage of links.

    Parameters
    ----------
    links : sequence of Link
        Carriers before what they carry.

    Returns
    -------
    Linkage
        In SI.

    Raises
    ------
    ValueError
        When a link comes before its carrier.

    Examples
    --------
    >>> arm = linkage_of([Link(10.0, 0.5, 0.5, 1.0), Link(10.0, 0.5, 0.5, 1.0, carrier=0)])
    >>> mass_matrix(np.zeros(2), arm).tolist()
    [[26.0, 8.0], [8.0, 3.0]]
    """
    n = len(links)
    paths, arms = np.zeros((n, n)), np.zeros((n, n))
    rest_angles = np.zeros(n)
    for k, link in enumerate(links):
        if not ON_BASE <= link.carrier < k:
            raise ValueError(f"link {k} is carried by {link.carrier}, which is not before it")
        if link.carrier != ON_BASE:
            paths[k] = paths[link.carrier]
            arms[k] = arms[link.carrier]
            arms[k, link.carrier] = links[link.carrier].length
            rest_angles[k] = rest_angles[link.carrier]
        paths[k, k], arms[k, k] = 1.0, link.centre
        rest_angles[k] += link.rest_angle
    masses = np.array([link.mass for link in links], dtype=float)
    return Linkage(
        paths=paths,
        rest_angles=rest_angles,
        products=arms.T @ (masses[:, None] * arms),
        moments=arms.T @ masses,
        inertias=np.array([link.inertia for link in links], dtype=float),
        mass=float(masses.sum()),
    )


@compiled
def link_angles(angles, linkage):
    """Return the angles of the links from the upright [rad].

    Parameters
    ----------
    angles : (n,) array
        Of the joints [rad].
    linkage : Linkage
        The numbers of the linkage.
    """
    return linkage.rest_angles + _along_paths(angles, linkage.paths)


@compiled
def _along_paths(values, paths):
    """Return what the joints add up to at each link."""
    n = values.shape[0]
    total = np.zeros(n)
    for i in range(n):
        for j in range(n):
            total[i] += paths[i, j] * values[j]
    return total


@compiled
def _onto_joints(values, paths):
    """Return what the links add up to at each joint: the transpose of `_along_paths`."""
    n = values.shape[0]
    total = np.zeros(n)
    for i in range(n):
        for j in range(n):
            total[j] += paths[i, j] * values[i]
    return total


@compiled
def mass_matrix(angles, linkage):
    """Return the mass matrix of the joint angles, the base held still.

    Parameters
    ----------
    angles, linkage
        As in `link_angles`.

    Returns
    -------
    (n, n) array
        [kg m^2].

    Notes
    -----
    In the links' own angles phi the matrix is products x cos(phi_i - phi_j) plus the inertias;
    the joints turn whole paths of links. For two links these are (A2.5) to (A2.8) of the thesis.
    """
    absolute = link_angles(angles, linkage)
    paths, n = linkage.paths, absolute.shape[0]
    sine, cosine = np.sin(absolute), np.cos(absolute)
    half, whole = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n):
        for j in range(n):
            own = linkage.products[i, j] * (cosine[i] * cosine[j] + sine[i] * sine[j])
            if i == j:
                own += linkage.inertias[i]
            for k in range(j + 1):
                half[i, k] += own * paths[j, k]
    for i in range(n):
        for j in range(i + 1):
            if paths[i, j] != 0.0:
                for k in range(n):
                    whole[j, k] += half[i, k]
    return whole


@compiled
def velocity_torque(angles, rates, linkage):
    """Return the torques that centrifugal and Coriolis forces take from the joints [N m].

    Parameters
    ----------
    angles, linkage
        As in `link_angles`.
    rates : (n,) array
        Of the joints [rad/s].

    Notes
    -----
    For two links (A2.2) of the thesis.
    """
    absolute = link_angles(angles, linkage)
    turning = _along_paths(rates, linkage.paths)
    sine, cosine = np.sin(absolute), np.cos(absolute)
    n = absolute.shape[0]
    own = np.zeros(n)
    for i in range(n):
        for j in range(n):
            across = sine[i] * cosine[j] - cosine[i] * sine[j]
            own[i] += linkage.products[i, j] * across * turning[j] * turning[j]
    return _onto_joints(own, linkage.paths)


@compiled
def gravity_torque(angles, gravity, linkage):
    """Return the torques that hold the links against gravity [N m].

    Parameters
    ----------
    angles, linkage
        As in `link_angles`.
    gravity : float
        Downwards [m/s^2].

    Notes
    -----
    For two links (A2.4) of the thesis: negative where a link leans to positive angles.
    """
    absolute = link_angles(angles, linkage)
    return _onto_joints(-gravity * linkage.moments * np.sin(absolute), linkage.paths)


@compiled
def base_coupling(angles, linkage):
    """Return what a sway of the base adds to the mass matrix: its row and column [kg m].

    Parameters
    ----------
    angles, linkage
        As in `link_angles`.

    Notes
    -----
    The base moves horizontally, positive where links at positive angles lean to.
    """
    absolute = link_angles(angles, linkage)
    return _onto_joints(linkage.moments * np.cos(absolute), linkage.paths)


@compiled
def base_force(angles, rates, linkage):
    """Return the force that the turning of the links takes from the base [N].

    Parameters
    ----------
    angles, rates, linkage
        As in `velocity_torque`.
    """
    turning, absolute = _along_paths(rates, linkage.paths), link_angles(angles, linkage)
    taken = 0.0
    for i in range(turning.shape[0]):
        taken -= linkage.moments[i] * np.sin(absolute[i]) * turning[i] * turning[i]
    return taken


@compiled
def kinetic_energy(angles, rates, base_velocity, linkage):
    """Return the kinetic energy of the links [J].

    Parameters
    ----------
    angles, rates, linkage
        As in `velocity_torque`.
    base_velocity : float
        [m/s].
    """
    turning = 0.5 * np.dot(rates, np.dot(mass_matrix(angles, linkage), rates))
    swaying = base_velocity * np.dot(base_coupling(angles, linkage), rates)
    return turning + swaying + 0.5 * linkage.mass * base_velocity * base_velocity


@compiled
def potential_energy(angles, gravity, linkage):
    """Return the potential energy of the links, 0 with every joint at the base's height [J].

    Parameters
    ----------
    angles, gravity, linkage
        As in `gravity_torque`.
    """
    return gravity * np.sum(linkage.moments * np.cos(link_angles(angles, linkage)))
