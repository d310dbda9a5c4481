"""The phase plane: the surface is where it should be, and so are the trajectories."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from analog_card.design_file import load_design
from analog_card.surface_weights import weights_from_settings
from pneuservo.controllers import Proportional, SlidingMode, card_of
from pneuservo.errors import InputError
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate, step_demand
from pneuservo.simulation.phase_plane import (
    draw_edge_view,
    draw_phase_plane,
    draw_switching_function,
    sliding_surface,
)

RIG = load_rig("single-axis")
TIME, DEMAND = step_demand([0.015, 0.024], hold=0.25, rate=2000.0)
LAYER = 5.0


@pytest.fixture(scope="module")
def run():
    return simulate(time=TIME, demand=DEMAND, controller=SlidingMode(boundary_layer=LAYER))


def surface_of(ax):
    """Return the line that is the surface, and the highest and lowest edge of the layer."""
    line = next(line for line in ax.lines if line.get_label().startswith("surface"))
    return line.get_xydata(), ax.collections[0].get_paths()[0].vertices


def test_a_card_has_the_surface_of_its_settings():
    # The card's own way from its parts to the surface; here from the kernels' law.
    expected = weights_from_settings(load_design())
    for card in (card_of(load_design()), card_of(load_design(), relay=True)):
        surface = sliding_surface(card, RIG)
        assert surface.displacement == pytest.approx(expected.displacement, rel=1e-9)
        assert surface.velocity == pytest.approx(expected.velocity, rel=1e-9)
        # 333.3 V/m (12 ms)^2
        assert surface.scale == pytest.approx(0.048)
    assert surface.boundary_layer == 0.0
    assert sliding_surface(card_of(load_design()), RIG).boundary_layer == pytest.approx(
        expected.boundary_layer, rel=1e-9
    )


def test_the_line_and_the_layer_of_the_phase_plane(run):
    c1, c2, _ = run.controller.weights
    ax = draw_phase_plane(run, Figure().subplots())
    line, layer = surface_of(ax)
    assert c1 * line[:, 0] * 1e-3 + c2 * line[:, 1] == pytest.approx(0.0, abs=1e-9)
    distance = np.abs(c1 * layer[:, 0] * 1e-3 + c2 * layer[:, 1])
    assert distance == pytest.approx(LAYER)
    step = ax.lines[1].get_xydata()
    assert step[0] == pytest.approx([-9.0, 0.0], abs=0.02)  # 15 mm, demanded are 24 mm, at rest
    assert step[-1] == pytest.approx([0.0, 0.0], abs=0.2)
    assert ax.get_xlabel() == "displacement less demand [mm]"
    assert ax.get_ylabel() == "velocity [m/s]"


def test_the_view_along_the_surface_shows_true_distances(run):
    ax = draw_edge_view(run, Figure().subplots())
    line, layer = surface_of(ax)
    assert line.sum(axis=1) == pytest.approx(0.0, abs=1e-9)
    assert np.abs(layer.sum(axis=1)) == pytest.approx(LAYER)
    # What the controller says of itself is minus the distance from the edge.
    drawn = np.concatenate([line.get_xydata().sum(axis=1) for line in ax.lines[:2]])
    assert drawn == pytest.approx(-run.surface, abs=1e-9)


def test_the_switching_function_of_a_card_is_drawn_in_the_unit_of_the_layer():
    run = simulate(time=TIME, demand=DEMAND, controller=card_of(load_design()))
    ax = draw_switching_function(run, Figure().subplots())
    drawn = np.concatenate([line.get_ydata() for line in ax.lines[:2]])
    assert drawn * 0.048 == pytest.approx(run["card_surface"])
    assert np.abs(surface_of_layer(ax)[:, 1]) == pytest.approx(LAYER, rel=1e-6)


def surface_of_layer(ax):
    return ax.collections[0].get_paths()[0].vertices


def test_a_relay_has_no_layer_and_a_moving_demand_one_line():
    demand = 0.015 + 0.002 * np.sin(20 * TIME)
    run = simulate(time=TIME, demand=demand, controller=SlidingMode(boundary_layer=0.0))
    figure = run.phase_plane()
    for ax in figure.axes:
        assert not ax.collections
        assert len(ax.lines) == 2


def test_what_has_no_surface_is_refused():
    with pytest.raises(InputError, match="controller proportional has no sliding surface"):
        sliding_surface(Proportional(), RIG)
    with pytest.raises(InputError, match="replayed command has no sliding surface"):
        simulate(time=TIME, command=1.0).phase_plane()
