"""What joins the bodies is in the picture, where the engine says it is."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from PIL import Image

import jousto as jo
from jousto.output.scenes.backdrop import new_picture
from jousto.output.scenes.stage import make_stage
from jousto.output.scenes.symbols import SymbolPen, coil, ground_lines, make_symbols, size_of
from jousto.output.scenes.view import View
from jousto.output.style import Picture, styled
from jousto.scene.make import make_scene
from jousto.scene.values_at_rows import rows_at

G = jo.ground
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)


def machine():
    """A swinging flexible arm, a cart, and one of each kind of connection."""
    part = jo.Part.beam(length=1.0, section=jo.Rectangle(0.01, 0.02), elements=6, material=STEEL)
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "node3", "end"), modes=3))
    arm = jo.FlexibleBody("arm", reduced)
    cart = jo.RigidBody(
        "cart", 2.0, (0.02, 0.02, 0.02), markers={"hook": (0.1, -0.2, 0.05)}, position=(0, -1, 0)
    )
    ball = jo.RigidBody("ball", 1.0, (0.01, 0.01, 0.01), position=(0, -2, 0))
    return jo.Mechanism(
        arm, cart, ball,
        jo.Revolute("pivot", G["origin"], arm["start"], axis=(0, 0, 1)),
        jo.Prismatic("rail", G.at((0, -1, 0)), cart["origin"], axis=(1, 0, 0)),
        jo.Rod("rod", G.at((0, -1.5, 0)), ball["origin"]),
        jo.Spring.between("spring", cart["hook"], arm["end"], 50.0),
        jo.Spring.between("damper", G.at((-1, -2, 0)), ball["origin"], damping=1.0),
        jo.JointForce("pump", jo.Distance(cart["hook"], arm["node3"]), jo.Constant(2.0)),
        jo.Bushing("rubber", G.at((0, -2, 0)), ball["origin"], 10.0),
        jo.Gravity((0, -9.81, 0)),
        jo.PositionSensor("hook", cart["hook"]),
        jo.PositionSensor("tip", arm["end"]),
        jo.PositionSensor("third", arm["node3"]),
    )  # fmt: skip


@pytest.fixture(scope="module")
def run():
    return jo.simulate(jo.compile(machine()), 0.2, solver=jo.RK4(1e-4), output_step=0.02)


ORDER = ("pivot", "rail", "rod", "spring", "damper", "pump", "rubber")


def shown(run):
    """What of the scene pictures show, by its name."""
    scene = make_scene(run)
    names = [one.name for one in scene.symbols if one.name in ORDER]
    found = make_symbols(scene.symbols, rows_at(scene, run.time), 1.0, None)
    assert len(found.kinds) == len(names)
    return {name: (found.kinds[k], found.ends[:, k]) for k, name in enumerate(names)}


def test_every_connection_has_its_kind(run):
    assert {name: kind for name, (kind, _) in shown(run).items()} == {
        "pivot": "hinge", "rail": "slide", "rod": "rod", "spring": "spring", "damper": "damper",
        "pump": "actuator", "rubber": "bushing",
    }  # fmt: skip


@pytest.mark.parametrize("kept", ["memory", "file", "pickle"])
def test_their_ends_are_where_sensors_are(run, tmp_path, kept):
    """The engine's own positions of the markers; interpolation between instants takes no part."""
    if kept == "file":
        run.save(tmp_path / "r.h5")
        run = jo.load(tmp_path / "r.h5")
    elif kept == "pickle":
        run = pickle.loads(pickle.dumps(run))
    at = {name: ends for name, (_, ends) in shown(run).items()}
    for name, a, b in (("spring", "hook", "tip"), ("pump", "hook", "third")):
        # some hundred roundings beside 1 m
        np.testing.assert_allclose(at[name][:, 0], run[a], atol=1e-13)
        np.testing.assert_allclose(at[name][:, 1], run[b], atol=1e-13)
    assert np.ptp(at["spring"][:, 1], axis=0).max() > 0.1
    np.testing.assert_allclose(at["pivot"], 0.0, atol=1e-10)
    np.testing.assert_allclose(np.linalg.norm(at["rod"][:, 1] - at["rod"][:, 0], axis=1), 0.5)


def test_supports_stand_at_the_points_of_ground(run):
    scene = make_stage(run, run.time, scale=1.0, view="xy", trail=None)
    points = {tuple(point) for point in np.round(scene.symbols.grounds, 9).tolist()}
    assert points == {(0.0, 0.0), (0.0, -1.0), (0.0, -1.5), (-1.0, -2.0), (0.0, -2.0)}
    triangle, base, *_ = ground_lines(np.array([0.3, 0.2]), 0.1)
    assert triangle[0].tolist() == [0.3, 0.2]
    assert base[:, 1].max() < 0.2


@pytest.mark.parametrize("end", [(1.0, 0.0), (0.3, -0.4), (0.0, 0.0)])
def test_a_spring_is_drawn_between_its_ends(end):
    line = coil(np.zeros(2), np.array(end), 0.01)
    assert line[0].tolist() == [0.0, 0.0]
    assert line[-1].tolist() == list(end)
    assert np.isfinite(line).all()


@pytest.mark.parametrize("end", [(1.0, 0.0), (0.3, -0.4)])
def test_the_coil_of_a_spring_is_as_wide_as_asked(end):
    line = coil(np.zeros(2), np.array(end), 0.01)
    off = np.abs(line @ np.array([-end[1], end[0]])) / np.hypot(*end)
    assert off.max() == pytest.approx(0.01, rel=1e-12)


def test_a_cylinder_keeps_its_length_while_its_rod_moves(run):
    scene = make_stage(run, run.time, scale=1.0, view="xy", trail=None)
    pen = SymbolPen(Picture().add_subplot(), scene.symbols, size_of(scene.box))
    place = [kind for kind in scene.symbols.kinds if kind in ("damper", "actuator")].index(
        "actuator"
    )
    found = []
    for i in range(len(run.time)):
        pen.show(i)
        barrel = pen.thick.get_segments()[place]
        found.append(np.linalg.norm(barrel[1] - barrel[0]))
        np.testing.assert_array_equal(barrel[0], run["hook"][i, :2])
    lengths = np.linalg.norm((run["third"] - run["hook"])[:, :2], axis=1)
    assert np.ptp(lengths) > 0.01
    np.testing.assert_allclose(found, 0.6 * lengths.min(), rtol=1e-9)


@pytest.mark.parametrize("name", ["m.png", "m.gif"])
def test_they_change_the_picture(run, tmp_path, monkeypatch, name):
    view = View((1, 1, 1))
    with_them = jo.animate(run, tmp_path / name, view=view, stills=2, fps=5, speed=0.2).read_bytes()
    monkeypatch.setattr("jousto.output.scenes.symbols.draw_grounds", lambda *_: [])
    monkeypatch.setattr(SymbolPen, "show", lambda *_: None)
    without = jo.animate(run, tmp_path / name, view=view, stills=2, fps=5, speed=0.2).read_bytes()
    assert with_them != without


@pytest.mark.parametrize("name", ["m.png", "m.gif"])
def test_a_support_within_a_body_is_seen(tmp_path, name):
    box = jo.RigidBody.box("box", (1.0, 1.0, 1.0), mass=1.0)
    hinge = jo.Revolute("hinge", jo.ground["origin"], box["origin"], axis=(0, 0, 1))
    run = jo.simulate(jo.compile(jo.Mechanism(box, hinge, jo.Gravity((0, 0, -9.81)))), 0.1)
    path = jo.animate(run, tmp_path / name, view="xz", stills=2)
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=int)
    stage = make_stage(run, run.time[:2], scale=1.0, view="xz", trail=None)
    with styled():
        figure, ax = new_picture(stage, "", "")
    size = size_of(stage.box)
    # the middle of the triangle is paper, the box beside it has its colour
    for x, paper in ((0.0, True), (-4.0 * size, False)):
        place = ax.transData.transform((x, -1.2 * size))
        share = figure.transFigure.inverted().transform(place)
        rows, columns = pixels.shape[:2]
        seen = pixels[int((1.0 - share[1]) * rows), int(share[0] * columns)]
        assert (seen.min() > 240) == paper, (x, seen)
