"""Bodies of scenes: places, deformation and stress of their vertices equal those of recovery."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.recovery.beams.strains import exponential, logarithm
from jousto.recovery.shape import positions, rotation_matrices
from jousto.scene.make import make_scene
from jousto.scene.scene import Body
from jousto.scene.values_at_rows import stresses as recovered, vertices as posed
from jousto.sections.points import stress_points
from recovery.beams.cases import cantilever
from scene.machines import SECTION, STEEL, corner, reduced

pytestmark = pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")

ROUND = 1e-12
"""Round-off of some hundred sums, by the largest number."""


def vertices(body: Body, rows: np.ndarray) -> np.ndarray:
    """Return where the vertices are (k, nv, 3): R + A (x + sum phi p)."""
    at = rows[:, body.place : body.place + 7 + body.modes]
    x = body.positions
    if body.shapes is not None:
        x = x + np.einsum("tj,jvi->tvi", at[:, 7:], body.shapes)
    A = rotation_matrices(at[:, 3:7])
    return at[:, None, :3] + np.einsum("tij,...vj->tvi" if x.ndim == 2 else "tij,tvj->tvi", A, x)


def stresses(body: Body, rows: np.ndarray) -> np.ndarray:
    """Return the stress (k, nv, 6): sum Sigma p."""
    p = rows[:, body.place + 7 : body.place + 7 + body.modes]
    return np.einsum("tj,jvc->tvc", p, body.stress)


def close(found: Any, expected: Any, share: float = ROUND) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=share * np.abs(expected).max())


def swinging(part: jo.ReducedPart, foot: str, name: str = "arm") -> jo.Solution:
    arm = jo.FlexibleBody(name, part, position=(0.1, 0.2, 0.3))
    pivot = jo.Spherical("pivot", jo.ground.at(arm[foot].r), arm[foot])
    wheel = jo.RigidBody.box("box", (0.3, 0.2, 0.1), mass=3, angular_velocity=(1, 2, 3))
    model = jo.compile(jo.Mechanism(arm, wheel, pivot, jo.Gravity((0, 2.0, -9.81))))
    return jo.simulate(model, 0.1, output_step=0.01)


@cache
def solid() -> jo.ReducedPart:
    x = np.array([(i, j, k) for i in range(4) for j in range(2) for k in range(2)], dtype=float)
    number = {tuple(p): n for n, p in enumerate(x.tolist())}
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(a, b, 1) for a, b, _ in corners]
    hexes = [[number[(i + a, b, c)] for a, b, c in corners] for i in range(3)]
    mesh = jo.Mesh(
        "bar",
        x * [0.3, 0.05, 0.05],
        jo.mesh.Cells("hexahedron", hexes),
        node_sets={"left": [n for n, p in enumerate(x) if p[0] == 0]},
    )
    part = jo.Part.solid(mesh, STEEL, interfaces=[jo.Interface("left", "left")])
    return jo.reduce(part, jo.CraigBampton("left", modes=3))


def test_solids_and_rigid_bodies_are_where_recovery_has_them():
    run = swinging(solid(), "left")
    scene = make_scene(run)
    rows = scene.motion.rows(slice(None))
    for body in scene.bodies:
        expected = positions(run, body.name)
        if body.kind == "solid":
            expected = expected[:, body.nodes - 1]
        close(vertices(body, rows), expected)
    bar = scene.bodies[0]
    assert (bar.kind, bar.modes, bar.known) == ("solid", run.bodies[0].n, None)
    # all corners of the bar are edges, and no other edge of its flat sides
    assert len(bar.edges) == 4 * 3 + 8


def test_stress_of_solids_is_that_of_the_field():
    run = swinging(solid(), "left")
    scene = make_scene(run)
    body = scene.bodies[0]
    field = jo.stress_field(run, "arm")
    modes = run.stress_modes("arm")
    places = [int(np.flatnonzero(modes.nodes == k - 1)[0]) for k in body.nodes]
    found = stresses(body, scene.motion.rows(slice(None)))
    assert np.abs(found).max() > 1e3
    expected = np.einsum("pcj,tj->tpc", modes.modes, run.coordinates("arm")[:, 7:])[:, places]
    close(found, expected)
    mises = np.abs(field.values("von-mises")[:, places])
    s = np.moveaxis(found, 2, 0)
    own = 0.5 * ((s[0] - s[1]) ** 2 + (s[1] - s[2]) ** 2 + (s[2] - s[0]) ** 2)
    own = np.sqrt(own + 3.0 * (s[3] ** 2 + s[4] ** 2 + s[5] ** 2))
    close(own, mises, 1e-9)  # roots of differences of squares


@pytest.mark.parametrize(("part", "foot"), [(reduced, "start"), (corner, "foot")])
def test_frames_bend_as_points_between_their_nodes(part, foot):
    """Every vertex moves as a marker on a rigid arm from its place on the axis."""
    made = part()
    run = swinging(made, foot)
    scene = make_scene(run)
    body = scene.bodies[0]
    arm = jo.FlexibleBody("arm", made)
    for v in range(0, len(body.positions), 17):
        close(body.shapes[:, v].T, arm.at(body.positions[v]).Phi, 1e-10)
    rows = scene.motion.rows(slice(None))
    axis = vertices(body, rows).reshape(len(rows), len(made.elements), -1, ring(body, made), 3)
    at_nodes = positions(run, "arm")
    # the middle of a ring at an end of an element is its node, but for rigid arms
    first = axis[:, :, 0].mean(axis=2)
    free = ~made.beams.offsets[:, 0].any(axis=1)
    close(first[:, free], at_nodes[:, made.elements[free, 0]], 1e-10)


def ring(body: Body, part: jo.ReducedPart) -> int:
    """Return the corners of a ring: those of the finest section."""
    count = {jo.Rectangle: 8, jo.Tube: 24}
    del body
    return count[jo.Tube] if part.name == "corner" else count[jo.Rectangle]


@pytest.mark.parametrize(("part", "foot"), [(reduced, "start"), (corner, "foot")])
def test_stress_of_frames_is_that_of_the_points_of_their_sections(part, foot):
    """At vertices that are points of a section; normal stress is linear on all others."""
    made = part()
    run = swinging(made, foot)
    scene = make_scene(run)
    body = scene.bodies[0]
    found = stresses(body, scene.motion.rows(slice(None)))
    modes = run.stress_modes("arm")
    expected = np.einsum("pcj,tj->tpc", modes.modes, run.coordinates("arm")[:, 7:])
    assert np.abs(expected).max() > 1e3
    seen = 0
    for place, label in enumerate(modes.labels):
        away = np.linalg.norm(body.positions - modes.positions[place], axis=1)
        same = np.flatnonzero(away < 1e-9)
        # where elements meet several vertices are at one place: that of the same element
        element, end = int(label.split(".")[0][1:]) - 1, "ab".index(label.split(".")[1])
        rings = len(body.positions) // len(made.elements)
        half = same[(same // rings == element) & ((same % rings >= rings // 2) == bool(end))]
        if len(half):
            seen += 1
            np.testing.assert_allclose(
                found[:, half[0]], expected[:, place], rtol=0, atol=1e-10 * np.abs(expected).max()
            )
    assert seen >= 8 * len(made.elements)  # all points on the outlines


def test_vertices_of_frames_know_their_place_in_the_section():
    """Where a vertex is a named point of a section, element, end and (y, z) are its own."""
    made = corner()
    run = swinging(made, "foot")
    body = make_scene(run).bodies[0]
    at = body.sections
    modes = run.stress_modes("arm")
    known = [
        {p.name: (p.y, p.z) for p in stress_points(s)}
        for s in (SECTION, SECTION, jo.Tube(0.04, 0.003))
    ]
    seen = 0
    for position, label in zip(modes.positions, modes.labels, strict=True):
        element, end, point = label[1:].split(".")
        vertices = np.flatnonzero(np.linalg.norm(body.positions - position, axis=1) < 1e-9)
        ring = at.vertex_ring[vertices]
        own = (at.element[ring] == int(element) - 1) & (at.share[ring] == "ab".index(end))
        yz = at.yz[vertices[own]]
        for found in yz:
            np.testing.assert_allclose(found, known[int(element) - 1][point], atol=1e-15)
        seen += len(yz)
    assert seen >= 8 * len(made.elements)
    assert len(at.element) == len(at.share) == at.vertex_ring.max() + 1


def test_normal_stress_between_points_of_a_section_is_linear():
    """A coarse section drawn with the corners of a finer one: s11 = N/A + My z/Iy - Mz y/Iz."""
    made = corner()
    run = swinging(made, "foot")
    scene = make_scene(run)
    body = scene.bodies[0]
    found = stresses(body, scene.motion.rows(slice(None)))[-1, :, 0]
    k = 24
    per = len(body.positions) // len(made.elements)
    for first in range(0, 2 * per, k):  # rings of the rectangle
        x = body.positions[first : first + k] - body.positions[first : first + k].mean(axis=0)
        basis = np.column_stack([np.ones(k), x @ made.beams.axes[0][:, 1:]])
        left = found[first : first + k]
        fit = basis @ np.linalg.lstsq(basis, left, rcond=None)[0]
        np.testing.assert_allclose(left, fit, rtol=0, atol=1e-9 * np.abs(found).max())


def test_exact_beams_are_swept_as_in_pictures():
    """Rings, evaluated by the formula of `Rings`, against what pictures draw."""
    run = cantilever((0.0, 30.0, -50.0), elements=5, section=SECTION)
    scene = make_scene(run)
    (body,) = scene.bodies
    rings, rows = body.rings, scene.motion.rows(slice(None))
    nodes = rows[:, rings.places[:, None] + np.arange(7)]
    R, A = nodes[..., :3], rotation_matrices(nodes[..., 3:])
    own = rotation_matrices(rings.ends[..., 3:])
    ra = R[:, :-1] + np.einsum("tnij,nj->tni", A[:, :-1], rings.ends[:, 0, :3])
    rb = R[:, 1:] + np.einsum("tnij,nj->tni", A[:, 1:], rings.ends[:, 1, :3])
    Qa, Qb = A[:, :-1] @ own[:, 0], A[:, 1:] @ own[:, 1]
    e, b = rings.element, rings.share[:, None]
    Qa, Qb, ra, rb = Qa[:, e], Qb[:, e], ra[:, e], rb[:, e]
    Q = Qa @ exponential(b * logarithm(np.swapaxes(Qa, -1, -2) @ Qb))
    size, a = np.linalg.norm(rb - ra, axis=-1, keepdims=True), 1 - b
    r = a * a * (1 + 2 * b) * ra + b * b * (1 + 2 * a) * rb
    r = r + a * a * b * size * Qa[..., 0] - a * b * b * size * Qb[..., 0]
    v = rings.vertex_ring
    x = r[:, v] + np.einsum("tvij,vj->tvi", Q[:, v][..., 1:], rings.yz)
    close(x, posed(body, rows))
    # stress: rows of the corner times the resultants, linear along the element
    ends = rows[:, rings.forces :].reshape(len(rows), -1, 2, 6)[:, e]
    p = (a[..., None] * ends[:, :, :1] + b[..., None] * ends[:, :, 1:])[:, :, 0]
    tensors = np.einsum("vcj,tvj->tvc", rings.rows[rings.corner], p[:, v])
    found = recovered(body, rows)
    assert np.abs(found).max() > 1e6
    close(tensors, found)


def test_undeformed_rings_have_the_section_around_the_axis():
    run = cantilever((0.0, 0.0, -1e-9), elements=5, section=SECTION)
    scene = make_scene(run)
    (body,) = scene.bodies
    first = scene.motion.rows(slice(0, 1))
    close(body.positions, posed(body, first)[0], 1e-9)  # what hangs by 1e-9 N


def volume(body: Body) -> float:
    x = body.positions[body.triangles]
    return float(np.einsum("ti,ti->", x[:, 0], np.cross(x[:, 1], x[:, 2])) / 6.0)


def test_a_machine_without_shapes_has_bodies_with_volume():
    """Rods to the points that joints hold, and a ball at the centre of mass."""
    link = jo.RigidBody("link", 2.0, (0.1, 0.7, 0.7), center=(0.5, 0, 0))
    lone = jo.RigidBody("lone", 1.0, (0.1, 0.1, 0.1), position=(0, 3, 0))
    bent = jo.RigidBody("bent", 1.0, (1, 1, 1), outline=[(0, 0, 0), (0.3, 0, 0), (0.3, 0.4, 0)])
    hinge = jo.Revolute("hinge", jo.ground["origin"], link["origin"], (0, 0, 1))
    pull = jo.Force("pull", link.at((1, 0, 0)), (0, 1, 0))
    scene = make_scene(jo.Mechanism(link, lone, bent, hinge, pull))
    for body in scene.bodies:
        assert body.kind == "rigid"
        assert volume(body) > 0.0
        edges = np.sort(body.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all()  # closed
    low, high = scene.bodies[0].positions.min(axis=0), scene.bodies[0].positions.max(axis=0)
    # from the joint to the force, and a ball that is thicker than the rods
    np.testing.assert_allclose((low[0], high[0]), (0, 1), atol=1e-12)
    assert high[1] > 0.02
    assert scene.bodies[1].positions.mean(axis=0) == pytest.approx((0, 0, 0), abs=1e-9)


def test_the_box_of_a_scene_is_around_the_motion():
    run = swinging(reduced(), "start")
    scene = make_scene(run)
    rows = scene.motion.rows(slice(None))
    x = np.concatenate([vertices(body, rows).reshape(-1, 3) for body in scene.bodies])
    slack = 0.02 * np.ptp(x, axis=0).max()  # bending is no part of the box
    assert (scene.box[0] <= x.min(axis=0) + slack).all()
    assert (scene.box[1] >= x.max(axis=0) - slack).all()
    assert np.ptp(scene.box, axis=0).max() < 2.0 * np.ptp(x, axis=0).max()
