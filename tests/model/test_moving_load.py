"""A force that travels along a beam, against the closed form and against forces at nodes."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.native import Engine
from jousto.schema.read import parse_model

LENGTH, FORCE = 4.0, 500.0  # m, N
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.08, 0.06)
EI, MU = 210e9 * 0.08 * 0.06**3 / 12, 7850 * 0.08 * 0.06


def bridge(elements: int = 8, modes: int = 40) -> jo.FlexibleBody:
    part = jo.Part.beam(LENGTH, SECTION, elements, STEEL, theory=jo.parts.EulerBernoulli())
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=modes))
    return jo.FlexibleBody("beam", reduced.keep(reduced.in_plane("xz")))


def supported(body: jo.FlexibleBody, *items: object) -> jo.Model:
    """On a hinge and a roller."""
    y = (0, 1, 0)
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["start"], y)
    roller = jo.PointOnPlane("roller", jo.ground.at((LENGTH, 0, 0)), body["end"], (0, 0, 1))
    return jo.compile(jo.Mechanism(body, hinge, roller, *items))


def fryba(t: np.ndarray, speed: float) -> np.ndarray:
    """Deflection of the middle, L. Fryba, Vibration of Solids and Structures (1972), chapter 1.

    ``w = sum_n 2 F / (mu L) sin(n pi / 2) [sin(n w t) - n w / w_n sin(w_n t)] / (w_n^2 - n^2 w^2)``
    with w = pi v / L, undamped.
    """
    omega, w = np.pi * speed / LENGTH, 0.0
    for n in range(1, 40, 2):
        wn = (n * np.pi / LENGTH) ** 2 * np.sqrt(EI / MU)
        shape = np.sin(n * omega * t) - n * omega / wn * np.sin(wn * t)
        w = w + 2 * FORCE / (MU * LENGTH) * np.sin(n * np.pi / 2) * shape / (
            wn**2 - (n * omega) ** 2
        )
    return w


@pytest.mark.parametrize("speed", [8.0, 25.0])
def test_a_force_crosses_a_bridge_as_the_closed_form_says(speed: float):
    """The rotary inertia of the sections, which the closed form has not, slows mode 1 by 1e-4."""
    body = bridge()
    end = LENGTH / speed
    load = jo.mechanism.MovingLoad(
        "wheel", body, ("start", "end"), (0, 0, -FORCE), jo.Ramp(0, end, before=0, after=LENGTH)
    )
    model = supported(body, load, jo.PositionSensor("middle", body["node5"]))
    run = jo.simulate(model, end, solver=jo.RK4(step=5e-5), output_step=end / 50)
    closed = fryba(run.time, speed)
    assert np.abs(run["middle"][:, 2] + closed).max() < 3e-4 * np.abs(closed).max()
    assert np.abs(run.energy.error).max() < 1e-6 * np.abs(run.energy.strain).max()


# few modes: both loads bend it alike, and too little
@pytest.mark.filterwarnings("ignore:.*leave out .* of the static work")
def test_it_is_a_force_at_a_node_that_it_passes():
    body = bridge()
    here = jo.mechanism.MovingLoad("here", body, ("start", "end"), (30, 0, -FORCE), 1.5)
    model = supported(body, here)
    at = jo.Force("at", body["node4"], (30, 0, -FORCE))
    other = supported(body, at)
    a, _ = Engine(model).accelerations()
    b, _ = Engine(other).accelerations()
    assert np.abs(b).max() > 1.0
    np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * np.abs(b).max())


def test_between_nodes_it_bends_as_the_closed_form_of_statics():
    """The middle of a beam on two supports sinks by F a (3 L^2 - 4 a^2) / 48 E I."""
    body = bridge()
    a = 0.3 * LENGTH
    load = jo.mechanism.MovingLoad("load", body, ("end", "start"), (0, 0, -FORCE), LENGTH - a)
    model = supported(
        body,
        load,
        jo.ForceSensor("force", load),
        jo.PositionSensor("middle", body["node5"]),
    )
    state = jo.equilibrium(model)
    engine = Engine(model)
    engine.q[:] = state.q
    engine.assemble()
    engine.accelerations()
    sensors = engine.sensors()
    sag = FORCE * a * (3 * LENGTH**2 - 4 * a**2) / (48 * EI)
    assert sensors[5] == pytest.approx(-sag, rel=1e-4)
    np.testing.assert_allclose(sensors[:3], (0, 0, -FORCE), atol=1e-9)


@pytest.mark.parametrize("s", [-0.1, LENGTH + 0.1])
def test_beyond_the_ends_there_is_no_force(s: float):
    body = bridge()
    model = supported(
        body, jo.mechanism.MovingLoad("load", body, ("start", "end"), (0, 0, -FORCE), s)
    )
    assert np.abs(Engine(model).accelerations()[0]).max() < 1e-9


def test_it_turns_with_the_body_if_it_follows():
    body = bridge()
    turned = jo.FlexibleBody("beam", body.reduced, orientation=jo.Rotate((0, 1, 0), degrees=30.0))
    load = jo.mechanism.MovingLoad("load", turned, ("start", "end"), (0, 0, 1.0), 1.0, follow=True)
    pivot = jo.Spherical("pivot", jo.ground["origin"], turned["start"])
    model = jo.compile(jo.Mechanism(turned, pivot, load, jo.ForceSensor("force", load)))
    engine = Engine(model)
    engine.accelerations()
    np.testing.assert_allclose(
        engine.sensors(), (np.sin(np.pi / 6), 0, np.cos(np.pi / 6)), atol=1e-12
    )


@pytest.mark.filterwarnings("ignore:.*has no joint to another")
def test_on_a_rigid_body_it_is_a_force_at_the_point():
    block = jo.RigidBody("block", 3.0, (0.2, 0.3, 0.4), markers={"a": (1, 0, 0), "b": (1, 2, 0)})
    F = (5.0, 0, -7.0)
    here = jo.compile(
        jo.Mechanism(block, jo.mechanism.MovingLoad("load", block, ("a", "b"), F, 0.5))
    )
    there = jo.compile(jo.Mechanism(block, jo.Force("load", block.at((1, 0.5, 0)), F)))
    a, b = Engine(here).accelerations()[0], Engine(there).accelerations()[0]
    assert np.abs(b).max() > 1.0
    np.testing.assert_allclose(a, b, rtol=1e-13, atol=1e-13)


def test_what_is_wrong_is_said():
    body = bridge()
    with pytest.raises(jo.InputError) as caught:
        jo.mechanism.MovingLoad("load", body, ("start", "emd"), (0, 0), "x")
    text = str(caught.value)
    assert "no node 'emd'; did you mean 'end'?" in text
    assert "vector" in text
    assert "position" in text
    with pytest.raises(jo.InputError, match="two nodes or more"):
        jo.mechanism.MovingLoad("load", body, "start", (0, 0, 1), 0.0)
    with pytest.raises(jo.InputError, match="two successive corners"):
        jo.mechanism.MovingLoad("load", body, ("end", "end"), (0, 0, 1), 0.0)


def test_the_model_file_says_it():
    text = """
parts:
  beam:
    type: beam
    length: 4 m
    section: {type: rectangle, width: 80 mm, height: 60 mm}
    elements: 8
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 4}
bodies: [{name: beam, part: beam, damping: 1 %}]
joints: [{type: fixed, name: wall, a: ground.origin, b: beam.start}]
forces:
  - type: moving-load
    name: wheel
    body: beam
    path: [start, node3, end]
    vector: [0, 0, -2 kN]
    position: {type: ramp, start: 0, end: 2 s, before: 500 mm, after: 3 m}
"""
    (load,) = parse_model(text).mechanism.forces
    assert isinstance(load, jo.mechanism.MovingLoad)
    assert load.nodes == tuple(range(9))
    assert load.position(2.0) == 3.0
    with pytest.raises(jo.InputError, match="body: no body 'bean'; did you mean 'beam'?"):
        parse_model(text.replace("body: beam", "body: bean"))


@pytest.mark.parametrize(("node", "s"), [(1, 0.0), (3, 0.25), (5, 0.5), (9, 1.0)])
def test_a_load_that_stands_at_a_node_is_a_force_there(node: int, s: float):
    """At the ends of the path and between two of its pieces, too."""
    body, force, path = bridge(), (10.0, 0.0, -FORCE), ("start", "node3", "node5", "end")
    where = jo.Constant(s * LENGTH)
    items = (
        jo.mechanism.MovingLoad("wheel", body, path, force, where),
        jo.Force("wheel", body[f"node{node}"], force),
    )
    found = [np.concatenate(Engine(supported(body, item)).accelerations()) for item in items]
    assert np.abs(found[1]).max() > 1.0
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-9 * np.abs(found[1]).max())
