"""Rigid bodies by their shape: closed forms of mass and inertia, and surfaces."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.bodies.shapes import Array
from jousto.schema.read import parse_model


def same(body: jo.RigidBody, mass: float, center: tuple, inertia: object, rel: float) -> None:
    assert body.mass == pytest.approx(mass, rel=rel)
    scale = float(np.abs(np.asarray(inertia)).max())
    assert np.abs(body.center - center).max() < rel * float(np.ptp(body.outline))
    assert np.abs(body.inertia - np.asarray(inertia)).max() < rel * scale


def of_surface(body: jo.RigidBody) -> jo.RigidBody:
    """The same body from the triangles that it is drawn with."""
    return jo.RigidBody.from_mesh("again", body.outline, density=1000.0)


def test_a_box() -> None:
    """m (ly^2 + lz^2) / 12 and so on."""
    body = jo.RigidBody.box("crate", (1.0, 0.5, 0.2), density=1000.0, at=(0.5, 0, 0))
    inertia = 100.0 / 12 * np.diag([0.5**2 + 0.2**2, 1 + 0.2**2, 1 + 0.5**2])
    same(body, 100.0, (0.5, 0, 0), inertia, 1e-13)
    # 12 triangles are a box: round-off of the sums
    same(of_surface(body), 100.0, (0.5, 0, 0), inertia, 1e-12)


def test_a_cylinder_along_any_axis() -> None:
    """m r^2 / 2 along and m (3 r^2 + l^2) / 12 across; a polygon of 32 corners is 0.6 % smaller."""
    axis = np.array([1.0, 2.0, 2.0]) / 3
    body = jo.RigidBody.cylinder("wheel", 0.3, 0.8, axis=3 * axis, mass=12.0)
    along, across = 12 * 0.09 / 2, 12 * (3 * 0.09 + 0.64) / 12
    inertia = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    same(body, 12.0, (0, 0, 0), inertia, 1e-12)
    drawn = of_surface(body)
    n = 32  # area of a regular polygon n/2 r^2 sin(2 pi/n); symmetric, so the axis is the same
    assert drawn.mass == pytest.approx(1000 * 0.8 * n / 2 * 0.09 * np.sin(2 * np.pi / n), rel=1e-12)
    assert np.linalg.norm(np.cross(drawn.inertia @ axis, axis)) < 1e-10 * np.abs(inertia).max()


def test_a_sphere() -> None:
    """2 m r^2 / 5."""
    body = jo.RigidBody.sphere("ball", 0.11, density=2000.0, at=(0, 0, 1))
    mass = 2000 * 4 / 3 * np.pi * 0.11**3
    same(body, mass, (0, 0, 1), 0.4 * mass * 0.11**2 * np.eye(3), 1e-13)
    # 32 x 16 facets inside the sphere: 1 to 3 % less
    assert 0.96 < of_surface(body).mass / (mass / 2) < 1.0


def tetrahedron() -> Array:
    corners = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    return corners[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]


def test_a_corner_tetrahedron_far_from_the_origin() -> None:
    """V = 1/6, centre 1/4, I_xx = 2 (1/60 - V/16) and I_xy = -(1/120 - V/16) (Tonon 2004)."""
    xx, xy = 2 * (1 / 60 - 1 / 96), -(1 / 120 - 1 / 96)
    inertia = 600 * (xx * np.eye(3) + xy * (np.ones((3, 3)) - np.eye(3)))
    for turned in (tetrahedron(), tetrahedron()[:, ::-1]):  # inside out is put right
        body = jo.RigidBody.from_mesh("corner", turned + 100.0, density=600.0)
        same(body, 100.0, (100.25, 100.25, 100.25), inertia, 1e-12)
        assert np.linalg.det(body.outline[0] - body.center) > 0


@pytest.mark.filterwarnings("ignore:.*moves freely")
def test_files_and_units(tmp_path: Path) -> None:
    path = tmp_path / "corner.stl"
    triangles = 1e3 * tetrahedron()
    cells = [("triangle", np.arange(12).reshape(4, 3))]
    meshio.Mesh(triangles.reshape(-1, 3), cells).write(path, binary=True)
    body = jo.RigidBody.from_mesh("corner", path, unit="mm", mass=3.0)
    # single precision of the file
    assert body.center == pytest.approx([0.25] * 3, rel=1e-6)
    text = """
bodies:
  - {type: box, name: crate, size: [1 m, 500 mm, 200 mm], mass: 70 kg}
  - {type: cylinder, name: wheel, radius: 300 mm, length: 100 mm, axis: [0, 1, 0], density: 7850}
  - {type: sphere, name: ball, radius: 110 mm, mass: 430 g, markers: {top: [0, 0, 110 mm]}}
  - {type: surface, name: hook, file: corner.stl, unit: mm, density: 7850 kg/m3}
"""
    crate, wheel, ball, hook = parse_model(text, folder=tmp_path).mechanism.bodies
    assert crate.inertia[0, 0] == pytest.approx(70 * (0.25 + 0.04) / 12)
    assert wheel.inertia[1, 1] == pytest.approx(wheel.mass * 0.09 / 2)
    assert ball["top"].r[2] == pytest.approx(0.11)
    assert hook.mass == pytest.approx(7850 / 6, rel=1e-6)


def test_mistakes_are_named(tmp_path: Path) -> None:
    make = jo.RigidBody.from_mesh
    with pytest.raises(jo.InputError, match="the surface is open: 3 edges belong to one triangle"):
        make("lid", tetrahedron()[:3], density=1.0)
    mixed = tetrahedron()
    mixed[0] = mixed[0, ::-1]
    with pytest.raises(jo.InputError, match="inconsistent orientation"):
        make("mixed", mixed, density=1.0)
    with pytest.raises(FileNotFoundError, match=r"body 'gone': no such file"):
        make("gone", tmp_path / "gone.stl", density=1.0)
    path = tmp_path / "bad.stl"
    path.write_text("nothing")
    with pytest.raises(jo.InputError, match=r"'bad.stl' (cannot be read|holds no triangles)"):
        make("bad", path, density=1.0)
    with pytest.raises(jo.InputError, match="give either mass"):
        jo.RigidBody.sphere("ball", 0.1)
    with pytest.raises(jo.InputError, match="radius is -1 m, must be positive"):
        jo.RigidBody.sphere("ball", -1, mass=1.0)
    with pytest.raises(jo.InputError, match="must be positive"):
        jo.RigidBody.box("flat", (1, 1, 0), mass=1.0)


def test_pieces_that_are_inside_out_are_hollows_or_refused() -> None:
    """A box with a hollow weighs less; of two boxes side by side none may be inside out."""
    outer = jo.RigidBody.box("outer", (1.0, 0.5, 0.4), density=1000.0, at=(3, 0, 0))
    inner = jo.RigidBody.box("inner", (0.5, 0.2, 0.2), density=1000.0, at=(3.1, 0.1, 0))
    hollow = np.concatenate([outer.outline, inner.outline[:, ::-1]])
    mass = 1000 * (1.0 * 0.5 * 0.4 - 0.5 * 0.2 * 0.2)
    center = (3 * 200 - 3.1 * 20) / 180, -0.1 * 20 / 180, 0.0
    body = jo.RigidBody.from_mesh("box", hollow, density=1000.0)
    assert body.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(body.center, center, atol=1e-12)
    # all of it inside out is the same body
    turned = jo.RigidBody.from_mesh("box", hollow[:, ::-1], density=1000.0)
    assert turned.mass == pytest.approx(mass, rel=1e-12)
    aside = np.concatenate([outer.outline, (inner.outline + [2, 0, 0])[:, ::-1]])
    with pytest.raises(jo.InputError, match="1 of 2 pieces of the surface face inwards"):
        jo.RigidBody.from_mesh("pair", aside, density=1000.0)
    alike = np.concatenate([outer.outline, inner.outline + [2, 0, 0]])
    assert jo.RigidBody.from_mesh("pair", alike, density=1000.0).mass == pytest.approx(220.0)
