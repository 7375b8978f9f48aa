"""Second-order displacements of parts with interfaces: rigid arms, rotations, reference nodes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.mesh.picks import InBox
from jousto.parts.frames.element import EulerBernoulli
from jousto.parts.interface import Interface
from jousto.parts.part import Part
from jousto.reduction.fields.stiffening import stiffening
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.modes.rigid import rigid_modes
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle
from parts.grids import grid
from reduction.bodies import STEEL

Array = NDArray[np.float64]

POINTS = np.array([[0.0, 0, 0], [0.5, 0.1, 0.0], [0.6, 0.5, 0.1], [0.1, 0.6, 0.2]])
HUB = np.array([0.1, 0.3, 0.05])
OPTIONS: dict[str, Any] = {
    "sections": Rectangle(0.03, 0.02),
    "materials": STEEL,
    "theory": EulerBernoulli(),
    "lumped": True,
}


def loop_with_tie() -> Part:
    """Three beams whose open ends are tied to one node."""
    part = Part.frame(POINTS, [(0, 1), (1, 2), (2, 3)], **OPTIONS)
    return part.with_interfaces(Interface("hub", (0, 3), at=HUB))


def loop_with_arms() -> Part:
    """The same with rigid arms from a node to the open ends."""
    arms = np.zeros((3, 2, 3))
    arms[0, 0], arms[2, 1] = POINTS[0] - HUB, POINTS[3] - HUB
    nodes = np.array([HUB, *POINTS[1:3]])
    return Part.frame(nodes, [(0, 1), (1, 2), (2, 0)], offsets=arms, **OPTIONS)


def test_rigid_tie_is_rigid_arms() -> None:
    tied, armed = loop_with_tie(), loop_with_arms()
    a = reduce(tied, FreeFree(modes=5), stiffening=True)
    b = reduce(armed, FreeFree(modes=5), stiffening=True)
    np.testing.assert_allclose(a.frequencies, b.frequencies, rtol=1e-10)
    sign = np.sign(np.einsum("kaj,kaj->j", a.modes[[1, 2]], b.modes[[1, 2]]))
    pair = sign[:, None] * sign
    assert a.stiffening is not None and b.stiffening is not None
    for own, other, tolerance in (
        (a.stiffening.second_moment, b.stiffening.second_moment * pair[:, :, None, None], 1e-9),
        (a.stiffening.translations[[4, 1, 2]], b.stiffening.translations * pair, 1e-9),
        (a.stiffening.rotations[[4, 1, 2]], b.stiffening.rotations * pair, 1e-9),
    ):
        np.testing.assert_allclose(own, other, atol=tolerance * np.abs(other).max())
    # tied nodes turn about the hub to the second order
    s = POINTS[[0, 3]] - HUB
    assert a.rotations is not None
    theta = a.rotations[4]
    jk = np.einsum("abc,bj,cde,dk,ne->najk", EPS, theta, EPS, theta, s)
    jk = 0.5 * (jk + jk.swapaxes(2, 3))
    rho = np.einsum("abc,bjk,nc->najk", EPS, a.stiffening.rotations[4], s)
    chi = a.stiffening.translations
    np.testing.assert_allclose(chi[[0, 3]], chi[4] + rho + jk, atol=1e-9 * np.abs(chi).max())


EPS = np.zeros((3, 3, 3))
EPS[0, 1, 2] = EPS[1, 2, 0] = EPS[2, 0, 1] = 1.0
EPS[0, 2, 1] = EPS[2, 1, 0] = EPS[1, 0, 2] = -1.0


@pytest.mark.parametrize("kind", ["rigid", "average"])
def test_reference_of_a_turned_solid(kind: Any) -> None:
    """d = theta x u0 becomes exp(theta~) u0, at the reference node, too."""
    part = Part.solid(grid("tetra10", (2, 1, 1), (0.4, 0.2, 0.1)), STEEL).with_interfaces(
        Interface("end", InBox((0.4, -1, -1), (0.4, 1, 1)), kind=kind, at=(0.5, 0.1, 0.2))
    )
    x = np.concatenate([part.nodes, [part.ties[0].at]]) - part.center
    found = stiffening(part, rigid_modes(part.nodes, 3, part.center)[:, 3:])
    G = 0.5 * np.trace(part.inertia) * np.eye(3) - part.inertia
    for j in range(3):
        for k in range(3):
            a, c = np.eye(3)[[j, k]]
            turn = 0.5 * (skew(a) @ skew(c) + skew(c) @ skew(a))
            # the rigid rotation b without which angular momentum would be left
            A = G @ turn.T
            axial = np.array([A[1, 2] - A[2, 1], A[2, 0] - A[0, 2], A[0, 1] - A[1, 0]])
            b = np.linalg.solve(part.inertia, -axial)
            exact = x @ turn.T + np.cross(b, x)
            chi = found.translations[:, :, j, k]
            np.testing.assert_allclose(chi, exact, atol=1e-9 * np.abs(exact).max())
            np.testing.assert_allclose(found.rotations[-1, :, j, k], b, atol=1e-9)


def skew(b: Array) -> Array:
    return np.array([[0, -b[2], b[1]], [b[2], 0, -b[0]], [-b[1], b[0], 0]])


def test_stiffened_part_with_interfaces_is_kept_whole() -> None:
    part = Part.solid(grid("hexahedron20", (3, 1, 1), (0.4, 0.05, 0.05)), STEEL).with_interfaces(
        Interface("a", InBox((0, -1, -1), (0, 1, 1)), kind="average"),
        Interface("b", InBox((0.4, -1, -1), (0.4, 1, 1)), kind="rigid"),
    )
    reduced = reduce(part, CraigBampton(modes=0), stiffening=True)
    assert reduced.stiffening is not None
    assert reduced.stiffening.translations.shape == (len(part.nodes) + 2, 3, 6, 6)
