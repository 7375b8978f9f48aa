"""Static loads: resultants, work, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.mesh.picks import InBox
from jousto.parts.loads import NodalForce, Pressure, Spin, SurfaceLoad, Traction, Weight
from jousto.parts.part import Part
from jousto.sections.section import Circle
from parts.grids import ALL, grid

Array = NDArray[np.float64]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0, name="steel")
SIZE = np.array([0.9, 0.3, 0.2])
END = InBox((0.9, 0.0, 0.0), (0.9, 1.0, 1.0))


def box(kind: str) -> Part:
    return Part.solid(grid(kind, (3, 2, 2), SIZE, distort=0.2), STEEL)


def resultants(part: Part, f: Array) -> tuple[Array, Array]:
    """Force and moment about the origin."""
    force = f.reshape(-1, 3)
    return force.sum(axis=0), np.cross(part.nodes, force).sum(axis=0)


@pytest.mark.parametrize("kind", ALL)
def test_pressure_on_a_face(kind: str) -> None:
    """Force p A inwards at the centre of the face, and the work of an affine motion."""
    part = box(kind)
    f = part.load(Pressure(END, 2e6))
    force, moment = resultants(part, f)
    np.testing.assert_allclose(force, [-2e6 * 0.06, 0, 0], atol=1e-6)
    np.testing.assert_allclose(moment, np.cross([0.9, 0.15, 0.1], force), atol=1e-6)
    g = np.random.default_rng(0).standard_normal((3, 3))
    work = f @ (part.nodes @ g.T).ravel()
    assert work == pytest.approx(-2e6 * 0.06 * g[0] @ [0.9, 0.15, 0.1], rel=1e-12)


@pytest.mark.parametrize("kind", ALL)
def test_pressure_all_around(kind: str) -> None:
    """Hydrostatic pressure has no resultants and the stress -p everywhere."""
    part = box(kind)
    f = part.load(Pressure(np.arange(len(part.nodes)), 3e6))
    for resultant in resultants(part, f):
        np.testing.assert_allclose(resultant, 0.0, atol=1e-6)
    d = np.linalg.lstsq(part.K.toarray(), f, rcond=1e-12)[0]
    assert part.stress is not None
    s = part.stress.evaluate(d)
    np.testing.assert_allclose(
        s, np.tile([-3e6] * 3 + [0.0] * 3, (len(s), 1)), rtol=0, atol=1e-9 * 3e6
    )


@pytest.mark.parametrize("kind", ALL)
def test_resultants_of_forces(kind: str) -> None:
    """A force and a moment on a face, a traction, a force on nodes."""
    part, centre = box(kind), np.array([0.9, 0.15, 0.1])
    F, T = np.array([10.0, -20.0, 30.0]), np.array([3.0, 4.0, -5.0])
    force, moment = resultants(part, part.load(SurfaceLoad(END, F, T)))
    np.testing.assert_allclose(force, F, atol=1e-10)
    np.testing.assert_allclose(moment, T + np.cross(centre, F), atol=1e-10)
    force, moment = resultants(part, part.load(Traction(END, F / 0.06)))
    np.testing.assert_allclose(force, F, atol=1e-10)
    np.testing.assert_allclose(moment, np.cross(centre, F), atol=1e-10)
    force, moment = resultants(part, part.load(NodalForce([0], F), NodalForce(0, F)))
    np.testing.assert_allclose(force, 2.0 * F)
    np.testing.assert_allclose(moment, np.cross(part.nodes[0], 2.0 * F))


@pytest.mark.parametrize("kind", ALL)
def test_weight_and_spin(kind: str) -> None:
    """m g at the centre of mass; m w^2 r away from the axis, its moment from the products of J."""
    part = box(kind)
    g, w = np.array([1.0, 2.0, -9.81]), np.array([10.0, 0.0, 30.0])
    force, moment = resultants(part, part.load(Weight(g)))
    np.testing.assert_allclose(force, part.mass * g, rtol=1e-12)
    np.testing.assert_allclose(moment, part.mass * np.cross(part.center, g), rtol=1e-12)
    force, moment = resultants(part, part.load(Spin(w, part.center)))
    np.testing.assert_allclose(force, 0.0, atol=1e-8 * part.mass * 1000.0)
    np.testing.assert_allclose(moment, -np.cross(w, part.inertia @ w), rtol=1e-9, atol=1e-6)
    force, _ = resultants(part, part.load(Spin(w)))
    np.testing.assert_allclose(
        force, -part.mass * np.cross(w, np.cross(w, part.center)), rtol=1e-10
    )


def test_pressure_in_a_bore() -> None:
    """Half a bore under pressure: the force p D L, the closed form of a cut cylinder."""

    def bend(x: Array) -> Array:
        r, angle = 0.1 + 0.1 * x[:, 1], np.pi * (1.0 - x[:, 0])
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.3 * x[:, 2]])

    mesh = grid("hexahedron20", (6, 1, 1), bend=bend)
    bore = np.flatnonzero(np.abs(np.hypot(mesh.nodes[:, 0], mesh.nodes[:, 1]) - 0.1) < 1e-9)
    part = Part.solid(mesh.with_set("bore", bore), STEEL)
    force, _ = resultants(part, part.load(Pressure("bore", 5e6)))
    # the ends of the arc lie on it, so its projection is exact
    np.testing.assert_allclose(force, [0.0, -5e6 * 0.2 * 0.3 * -1.0, 0.0], atol=1e-3)


def test_a_named_surface_is_taken_as_it_is() -> None:
    """Not faces that only have all their nodes on it; turned outwards whatever its order."""
    mesh = grid("hexahedron", (1, 1, 1))
    # two sides of a cube hold the nodes of all six
    faces = [f.nodes for f in mesh.faces][0]
    normal = [np.ptp(mesh.nodes[f], axis=0).argmin() for f in faces]
    ends = faces[[i for i, axis in enumerate(normal) if axis == 0]][:, ::-1]
    part = Part.solid(replace(mesh, surfaces={"ends": ends}), STEEL)
    f = part.load(Pressure("ends", 1e6)).reshape(-1, 3)
    assert np.all(f[:, 1:] == 0.0)
    np.testing.assert_allclose(f[:, 0], np.where(part.nodes[:, 0] > 0.5, -0.25e6, 0.25e6))


def test_beams_take_forces_and_weight() -> None:
    part = Part.beam(2.0, Circle(0.01), 4, STEEL)
    f = part.load(Weight((0, 0, -9.81)), NodalForce("end", (1.0, 0, 0), (0, 0, 7.0)))
    nodal = f.reshape(-1, 6)
    assert nodal[:, 2].sum() == pytest.approx(-9.81 * part.mass)
    assert nodal[-1, 5] == 7.0
    assert nodal[-1, 0] == 1.0


def test_refusals_all_at_once() -> None:
    part = box("hexahedron")
    with pytest.raises(InputError) as caught:
        part.load(
            Pressure("top", 1.0),
            NodalForce([0], moment=(1, 0, 0)),
            Traction([0, 1], (1, 2)),
            Pressure([0, 1], 1.0),
            Pressure(InBox((5, 5, 5), (6, 6, 6)), 1.0),
            3.0,  # type: ignore[arg-type]
        )
    message = str(caught.value)
    for sentence in (
        "load 1 (Pressure): no surface or node set 'top'",
        "load 2 (NodalForce): has a moment, but nodes of solids have no rotations",
        "load 3 (Traction): traction has shape (2,)",
        "load 4 (Pressure): the nodes picked (2 nodes) contain no complete face",
        "load 5 (Pressure): the pick contains no node",
        "load 6: is 3.0, must be one of Pressure",
    ):
        assert sentence in message
    with pytest.raises(InputError, match="only parts of solids have them"):
        Part.beam(2.0, Circle(0.01), 4, STEEL).load(Pressure("end", 1.0))
