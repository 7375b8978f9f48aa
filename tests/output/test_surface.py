"""Solids are drawn as surfaces, with light and the colours of their stress."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import jousto as jo
from jousto.output.scenes.stage import make_stage
from jousto.output.scenes.surface import is_surface, lit, make_surface
from jousto.output.scenes.view import View
from jousto.recovery.fields.criteria import evaluate
from jousto.scene.make import make_scene
from jousto.scene.values_at_rows import rows_at, stresses
from output.blocks import bar, grid, swinging_bar
from output.runs import spatial, swing


def test_a_block_is_a_closed_surface_of_which_half_is_seen() -> None:
    nodes, _, triangles = grid((2, 3, 4), (0.2, 0.3, 0.4))
    surface = make_surface(nodes, triangles)
    assert surface.closed
    assert len(surface.nodes) == 60 - 1 * 2 * 3  # inner nodes are left out
    view = View((1.0, 1.0, 1.0))
    corners, shades = lit(surface, view.project(nodes[surface.nodes]), np.array([0.2, 0.4, 0.6]))
    assert len(corners) == len(triangles) / 2
    # each of the three sides has one shade: no light runs around an edge
    assert len(np.unique(shades.reshape(-1, 4).round(9), axis=0)) == 3


def test_the_seen_area_is_that_of_the_projected_block() -> None:
    nodes, _, triangles = grid((2, 3, 4), (0.2, 0.3, 0.4))
    surface = make_surface(nodes, triangles)
    direction = np.array([1.0, 2.0, 2.0]) / 3.0
    corners, _ = lit(surface, View(direction).project(nodes[surface.nodes]), np.zeros(3))
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    assert area.min() > 0.0
    # areas of the sides times the cosines to the eye
    assert area.sum() == pytest.approx(direction @ [0.3 * 0.4, 0.2 * 0.4, 0.2 * 0.3])


def test_smooth_surfaces_have_smooth_light() -> None:
    # a tube of 40 faces around: corners of neighbours share their normal
    nodes, _, triangles = grid((39, 1, 1), (2 * np.pi, 1.0, 0.1))
    angle, radius = nodes[:, 0] * 40 / 39 * 39 / 40, 1.0 + nodes[:, 2]
    x = np.stack([radius * np.cos(angle), radius * np.sin(angle), nodes[:, 1]], axis=1)
    surface = make_surface(x, triangles)
    _, shades = lit(surface, View((0, -1, 0.3)).project(x[surface.nodes]), np.ones(3) * 0.5)
    assert len(np.unique(shades.reshape(-1, 4).round(9), axis=0)) > 40


def test_fine_surfaces_are_thinned_to_nodes_of_their_own() -> None:
    nodes, _, triangles = grid((30, 30, 30), (1.0, 1.0, 1.0))
    surface = make_surface(nodes, triangles, most=1200)
    assert 300 < len(surface.triangles) <= 1200
    x = nodes[surface.nodes]
    corners = x[surface.triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    # nodes of the flat sides stay on them, and corners are kept
    assert volume == pytest.approx(1.0, rel=1e-12)


def test_open_triangles_are_seen_from_both_sides() -> None:
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    surface = make_surface(nodes, [[0, 1, 2]])
    assert not surface.closed
    for direction in ((0, 0, 1), (0, 0, -1)):
        corners, shades = lit(surface, View(direction, up=(0, 1, 0)).project(nodes), np.ones(3))
        assert len(corners) == 1
        assert shades[0, 0, 0] > 0.5
    assert not is_surface([[0, 1]])
    assert not is_surface(np.zeros((0, 3)))


def test_results_hold_the_stress_of_the_surface() -> None:
    run, reduced = swinging_bar(), bar()
    scene = make_scene(run)
    (body,) = scene.bodies
    assert np.array_equal(reduced.nodes[body.nodes - 1], reduced.stress.positions)
    values = evaluate(stresses(body, rows_at(scene, [0.05, 0.1])), "von-mises")
    p = [np.interp(t, run.time, run.q[:, 7]) for t in (0.05, 0.1)]
    expected = 1e6 * np.abs(np.outer(p, reduced.nodes[body.nodes - 1, 0]))
    assert np.allclose(values, expected, rtol=1e-6)


def test_beams_have_the_stress_of_their_sections_on_their_surface() -> None:
    """At the points of the section that lie on its edge, from their stress in each mode."""
    run = swing()
    scene = make_scene(run)
    arm = next(body for body in scene.bodies if body.name == "arm")
    found = stresses(arm, rows_at(scene, run.time[-1:]))[0]
    modes, p = run.stress_modes("arm"), run.q[-1, 7:11]
    rings = (int(arm.sections.vertex_ring.max()) + 1) // 4  # of one of four elements
    for name in ("top", "bottom"):
        site = modes.labels.index(f"e3.a.{name}")
        near = np.flatnonzero(arm.sections.vertex_ring == 2 * rings)
        away = np.linalg.norm(arm.positions[near] - modes.positions[site], axis=1)
        expected = modes.modes[site] @ p
        assert abs(expected[0]) > 1e4
        scale = np.abs(expected).max()
        np.testing.assert_allclose(found[near[away.argmin()]], expected, atol=1e-6 * scale)


def test_colours_are_those_of_the_stress() -> None:
    run = swinging_bar()
    stage = make_stage(run, run.time, scale=1.0, view=None, trail=None, stress=True)
    assert stage.limit == pytest.approx(1e6 * np.abs(run.q[:, 7]).max(), rel=1e-6)
    given = make_stage(run, run.time, scale=1.0, view=None, trail=None, stress=5e6)
    assert given.limit == 5e6


def test_pictures_and_films_of_solids(tmp_path: Path) -> None:
    run = swinging_bar()
    plain = jo.still(run, tmp_path / "a.png", times=2)
    stress = jo.still(run, tmp_path / "b.png", times=[0.2], stress=True)
    film = jo.animate(run, tmp_path / "c.gif", stress=1e6, speed=0.5)
    colors = []
    for path in (plain, stress, film):
        with Image.open(path) as image:
            colors.append(len(image.convert("RGB").getcolors(1 << 24)))
    assert min(colors) > 40
    assert colors[1] > 2 * colors[0]


def test_stress_must_be_known(tmp_path: Path) -> None:
    with pytest.raises(jo.InputError, match="'jousto hotspots RESULT BODY -o FILE.png'"):
        jo.animate(spatial(), tmp_path / "a.gif", stress=True)
    with pytest.raises(jo.InputError, match="stress is -1 Pa, must be a positive number"):
        jo.still(swinging_bar(), tmp_path / "a.png", stress=-1.0)
