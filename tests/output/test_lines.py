"""Bodies as lines: chains, corners, closed rings and smooth curves."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.output.scenes.lines import FINE, outline
from jousto.simulation.results.records import BodyShape


def shape(nodes: object, elements: object, kind: str = "flexible") -> BodyShape:
    xyz = np.array(nodes, dtype=float)
    return BodyShape("b", kind, 0, 0, 0, xyz, np.array(elements), np.zeros((len(xyz), 3, 0)))


def test_a_straight_beam_is_one_smooth_line_whatever_the_order_of_its_elements() -> None:
    nodes = [(x, 0, 0) for x in (0.0, 1.0, 2.0, 3.0)]
    (chain,) = outline(shape(nodes, [(2, 3), (1, 0), (1, 2)])).chains
    assert sorted(chain.nodes.tolist()) == [0, 1, 2, 3]
    assert np.all(np.abs(np.diff(chain.nodes)) == 1)
    assert chain.weights.shape == (3 * FINE + 1, 4)
    # a spline through the nodes draws a cubic exactly
    x = np.array(nodes)[chain.nodes, 0]
    fine = chain.weights @ x
    np.testing.assert_allclose(chain.weights @ x**3, fine**3, atol=1e-12)


def test_corners_and_forks_end_a_line() -> None:
    nodes = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (2, 2, 0), (1, -1, 0)]
    found = outline(shape(nodes, [(0, 1), (1, 2), (2, 3), (3, 4), (1, 5)]))
    chains = sorted(sorted(c.nodes.tolist()) for c in found.chains)
    assert chains == [[0, 1], [1, 2], [1, 5], [2, 3, 4]]
    assert found.dots.tolist() == [0, 4, 5]


def test_a_ring_is_drawn_once_and_closed() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    nodes = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    (chain,) = outline(shape(nodes, [(k, (k + 1) % 120) for k in range(120)])).chains
    assert chain.nodes[0] == chain.nodes[-1]
    assert len(chain.nodes) == 121


@pytest.mark.parametrize(("nodes", "edges"), [(3, 3), (4, 4)])
def test_faces_are_drawn_by_their_edges(nodes: int, edges: int) -> None:
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)][:nodes]
    assert len(outline(shape(corners, [tuple(range(nodes))])).chains) == edges


def test_rigid_bodies_and_lonely_nodes() -> None:
    star = outline(shape([(0, 0, 0), (1, 0, 0), (-1, 0, 0)], [(0, 1), (0, 2)], "rigid"))
    assert all(len(chain.weights) == len(chain.nodes) for chain in star.chains)
    cloud = outline(shape([(0, 0, 0), (1, 0, 0)], np.zeros((0, 2), dtype=int)))
    assert cloud.chains == ()
    assert cloud.dots.tolist() == [0, 1]
