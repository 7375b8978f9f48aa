"""Of bodies that lie over or go through one another the nearest is seen at each place."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

import jousto as jo
from jousto.output.scenes.backdrop import new_picture
from jousto.output.scenes.raster import FINE, rasterize
from jousto.output.scenes.stage import Stage, body_color, make_stage
from jousto.output.scenes.view import View
from jousto.output.style import styled

RED, BLUE = [1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]


def flat(*colors: list[float]) -> np.ndarray:
    """Return triangles of one colour each."""
    return np.repeat(np.array(colors)[:, None], 3, axis=1)


def test_a_triangle_covers_its_area_and_has_the_colours_of_its_corners() -> None:
    corners = np.array([[[2.0, 3.0, 0.0], [40.0, 5.0, 1.0], [11.0, 33.0, 2.0]]])
    shades = np.concatenate([np.eye(3), np.ones((3, 1))], axis=1)[None]
    picture = rasterize(corners, shades, 50, 40)
    area = 0.5 * abs(38.0 * 30.0 - 9.0 * 2.0)
    # samples on the edge are counted whole: half a sample on three edges of 38, 40 and 31 pixels
    assert picture[:, :, 3].sum() == pytest.approx(area, abs=0.5 * (38 + 40 + 31) / FINE)
    # barycentric coordinates of the middle of a pixel
    row, column = 12, 16
    A = np.concatenate([corners[0, :, :2].T, np.ones((1, 3))])
    share = np.linalg.solve(A, [column + 0.5, row + 0.5, 1.0])
    np.testing.assert_allclose(picture[row, column, :3], share, atol=1e-12)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_triangles_that_cross_are_both_seen(order: list[int]) -> None:
    # one rises to the right, the other to the left: they meet in the middle
    square = [[0.0, 0.0], [40.0, 0.0], [40.0, 20.0]]
    left = [[*x, 40.0 - x[0]] for x in square]
    right = [[*x, x[0]] for x in square]
    picture = rasterize(np.array([left, right])[order], flat(RED, BLUE)[order], 40, 20)
    below = picture[2]
    np.testing.assert_array_equal(below[6:20], np.tile(RED, (14, 1)))
    np.testing.assert_array_equal(below[20:38], np.tile(BLUE, (18, 1)))


def test_neighbours_leave_no_gap_and_share_no_pixel_twice() -> None:
    rng = np.random.default_rng(7)
    x = np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0], *rng.uniform(4, 16, (3, 2))])
    for middle in x[4:]:
        ring = [[x[k], x[(k + 1) % 4], middle] for k in range(4)]
        corners = np.concatenate([ring, np.zeros((4, 3, 1))], axis=2)
        picture = rasterize(corners, flat(*[RED] * 4), 30, 20)
        np.testing.assert_allclose(picture, np.broadcast_to(RED, (20, 30, 4)), atol=1e-12)


def test_what_is_no_triangle_covers_nothing() -> None:
    corners = np.array([[[1.0, 1.0, 0.0], [9.0, 9.0, 0.0], [5.0, 5.0, 0.0]], [[np.nan] * 3] * 3])
    assert not rasterize(corners, flat(RED, BLUE), 10, 10).any()
    assert not rasterize(np.zeros((0, 3, 3)), np.zeros((0, 3, 4)), 10, 10).any()
    # outside of the picture
    assert not rasterize(corners[:1] + [20.0, 0.0, 0.0], flat(RED), 10, 10).any()


def crossed() -> jo.Solution:
    """Return a bar along x through a post along z, and a wide plate on the bar."""
    bodies = (
        jo.RigidBody.box("bar", (2.0, 0.2, 0.2), mass=1.0),
        jo.RigidBody.box("post", (0.3, 0.1, 1.0), mass=1.0, position=(0.2, 0.0, 0.0)),
        jo.RigidBody.box("plate", (1.0, 0.6, 0.02), mass=1.0, position=(-0.4, 0.0, 0.2)),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return jo.simulate(jo.compile(jo.Mechanism(*bodies, name="crossed")), 1e-3)


# points on the surfaces that are turned to an eye at (1, -2, 1.5), and what is seen there
PLACES = {
    (0.2, -0.1, 0.0): 0,  # the bar's side lies before the post's
    (0.12, -0.05, 0.3): 1,  # the post above the bar
    (0.12, -0.05, -0.4): 1,  # and below it
    (0.2, 0.0, 0.5): 1,  # its top
    (0.8, -0.1, 0.0): 0,
    (0.8, 0.0, 0.1): 0,
    (-0.4, 0.0, 0.21): 2,
    (-0.8, -0.25, 0.21): 2,
    (0.03, -0.2, 0.21): 2,  # the plate goes into the post; this corner lies before both
}


def pixel(stage: Stage, place: np.ndarray, shape: tuple[int, int]) -> tuple[int, int]:
    """Return column and row of a place of the world in a picture."""
    with styled():
        figure, ax = new_picture(stage, "", "")
    x = ax.transData.transform(stage.view.project(place)[:2])
    share = figure.transFigure.inverted().transform(x)
    return int(share[0] * shape[1]), int((1.0 - share[1]) * shape[0])


@pytest.mark.parametrize("film", [False, True])
def test_each_place_shows_the_body_that_is_nearest(tmp_path: Path, film: bool) -> None:
    run, view = crossed(), View((1.0, -2.0, 1.5))
    if film:
        path = jo.animate(run, tmp_path / "a.gif", view=view)
    else:
        path = jo.still(run, tmp_path / "a.png", times=1, view=view)
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    stage = make_stage(run, run.time[:1], scale=1.0, view=view, trail=None)
    for place, body in PLACES.items():
        x, y = pixel(stage, np.array(place), pixels.shape[:2])
        seen = pixels[y, x] / np.linalg.norm(pixels[y, x])
        tints = [np.array(to_rgb(body_color(k))) for k in range(3)]
        alike = [seen @ tint / np.linalg.norm(tint) for tint in tints]
        assert int(np.argmax(alike)) == body, place


def test_postscript_has_triangles_since_it_knows_no_transparency(tmp_path: Path) -> None:
    path = jo.still(crossed(), tmp_path / "a.eps", times=2, view=View((1.0, -2.0, 1.5)))
    text = path.read_text(encoding="latin-1")
    assert "colorimage" not in text and "shfill" in text
    assert len(text) < 1_000_000
