"""Skins of flexible bodies on shapes: closed forms of pressure, foundation and compression."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import jousto as jo
from jousto.mechanism import (
    ConvexHull,
    Cuboid,
    Cylinder,
    HalfSpace,
    Hertz,
    PowerLaw,
    SkinContact,
    Sphere,
    SpringDamper,
)

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

E, NU, RHO, L, B, G = 2e9, 0.3, 2000.0, 0.2, 0.1, 9.81
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
TURNED = jo.Rotate((1, 0, 0), degrees=180)


@cache
def block(nx: int = 2, nz: int = 1, height: float = L) -> Any:
    """Part of a block of nx x nx x nz bricks on z = 0, and its nodes."""
    side, up = np.linspace(-B / 2, B / 2, nx + 1), np.linspace(0, height, nz + 1)
    x = np.stack(np.meshgrid(side, side, up, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(x)).reshape(nx + 1, nx + 1, nz + 1)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(i, j, 1) for i, j, _ in corners]
    at = np.indices((nx, nx, nz)).reshape(3, -1).T[:, None] + np.array(corners)
    cells = jo.mesh.Cells("hexahedron", number[at[..., 0], at[..., 1], at[..., 2]])
    sets = {"bottom": np.flatnonzero(x[:, 2] == 0.0), "top": np.flatnonzero(x[:, 2] == height)}
    mesh = jo.Mesh("block", x, (cells,), node_sets=sets)
    return jo.Part.solid(mesh, jo.Material(E, NU, RHO)), x


@cache
def reduced(nx: int = 2, nz: int = 1, modes: int | None = None, height: float = L) -> Any:
    part, x = block(nx, nz, height)
    return jo.reduce(part, jo.FreeFree(modes=3 * len(x) - 6 if modes is None else modes))


def node(x: Any, at: Any) -> str:
    return f"node{np.argmin(np.linalg.norm(x - at, axis=1)) + 1}"


@pytest.mark.parametrize("law", [PowerLaw(1e14, 1.5), SpringDamper(1e11)])
def test_patch_of_a_block_between_two_plates(law):
    """Uniform stress F / A; the plates approach by F L / E A and the depths of both skins."""
    x, body, F = block()[1], jo.FlexibleBody("block", reduced()), 2000.0
    plate = jo.RigidBody("plate", 50.0, (1, 1, 1), position=(0, 0, L))
    down = plate.at((0, 0, 0), axes=TURNED)
    floor = SkinContact("floor", jo.ground["origin"], HalfSpace(), body, law, nodes="bottom")
    lid = SkinContact("lid", down, HalfSpace(), body, law, nodes=("top",))
    middle, above, beside = (node(x, at) for at in ((0, 0, 0), (0, 0, L), (B / 2, 0, 0)))
    held = [(middle, 0), (middle, 1), (above, 0), (above, 1), (beside, 1)]
    machine = jo.Mechanism(
        *(body, plate, floor, lid),
        jo.Prismatic("guide", jo.ground.at((0, 0, L)), plate["origin"], axis=(0, 0, 1)),
        *(
            jo.PointOnPlane(f"h{i}", jo.ground["origin"], body[name], np.eye(3)[axis])
            for i, (name, axis) in enumerate(held)
        ),
        jo.Force("push", plate["origin"], (0, 0, -F)),
        *(jo.ForceSensor("F floor", floor), jo.ForceSensor("F lid", lid)),
        jo.PositionSensor("plate", plate["origin"]),
    )
    model = jo.compile(machine)
    run = jo.simulate(model, 1e-5, state=jo.equilibrium(model), solver=jo.ROS2(1e-5))
    assert sum(floor.weights) == pytest.approx(B * B, rel=1e-12)
    np.testing.assert_allclose(run["F floor"][0], (0, 0, F), atol=1e-6 * F)
    np.testing.assert_allclose(run["F lid"][0], (0, 0, -F), atol=1e-6 * F)
    p = F / B**2
    depth = (p / law.stiffness) ** (1.0 / getattr(law, "exponent", 1.0))
    assert L - run["plate"][0, 2] == pytest.approx(p * L / E + 2 * depth, rel=1e-7)
    field = jo.stress_field(run, "block", reduced=body.reduced)
    stress = np.array([field.history(label)[0] for label in field.labels])
    np.testing.assert_allclose(stress, [[0, 0, -p, 0, 0, 0]] * len(stress), atol=1e-6 * p)


@pytest.mark.parametrize(
    ("shape", "at", "force"),
    [  # K times the volume of the overlap; a ball and a cylinder within d^2 / R^2 of the parabola
        (Sphere(2.0), (0, 0, -2.0), lambda K, d: K * np.pi * d * d * (2.0 - d / 3)),
        (Cylinder(4.0, 2 * B), (0, 0, -4.0), lambda K, d: K * B * 4 / 3 * np.sqrt(8.0) * d**1.5),
        (Cuboid((2 * B, 2 * B, B)), (0, 0, -B / 2), lambda K, d: K * B * B * d),
    ],
)
def test_pressure_over_the_depth_of_shapes(shape, at, force):
    """The Winkler foundation: the force of shapes with known volumes of overlap."""
    K, d = 1e8, 2e-4
    body = jo.FlexibleBody("block", reduced(24, 1, 6, 0.02))
    axes = jo.Rotate((1, 0, 0), degrees=90) if isinstance(shape, Cylinder) else None
    a = jo.ground.at(np.add(at, (0, 0, d)), axes=axes)
    touch = SkinContact("touch", a, shape, body, PowerLaw(K, 1.0), nodes="bottom")
    model = jo.compile(jo.Mechanism(body, touch, jo.ForceSensor("f", touch)))
    engine = jo.model.Engine(model)
    engine.start_states()
    engine.accelerations()
    F = engine.sensors()[:3]
    exact = force(K, d)
    np.testing.assert_allclose(F, (0, 0, exact), atol=5e-3 * exact)


def deepest(exact: bool, n: int) -> float:
    """How much deeper a force presses a long heavy beam of n elements into its foundation, m."""
    z = -WEIGHT / BED
    if exact:
        ends = [(0, 0, z), (LONG, 0, z)]
        body: Any = jo.BeamBody("beam", ends, SECTION, STEEL, elements=n)
        middle = body.node(n // 2)
    else:
        full = jo.reduce(jo.Part.beam(LONG, SECTION, n, STEEL), jo.FreeFree(modes=90))
        body = jo.FlexibleBody("beam", full.keep(full.in_plane("xz")), position=(0, 0, z))
        middle = body[f"node{n // 2 + 1}"]
    lies = SkinContact("lies", jo.ground["origin"], HalfSpace(), body, PowerLaw(BED, 1.0))
    assert sum(lies.weights) == pytest.approx(LONG)
    machine = jo.Mechanism(
        *(body, lies, jo.Gravity((0, 0, -G)), jo.Force("P", middle, (0, 0, -PRESS))),
        *(
            jo.PointOnPlane(f"h{i}", jo.ground.at((x, 0, 0)), body[end], axis)
            for i, (end, x, axis) in enumerate(
                [("start", 0, (1, 0, 0)), ("start", 0, (0, 1, 0)), ("end", LONG, (0, 1, 0))]
            )
        ),
        *(jo.PositionSensor("middle", middle), jo.ForceSensor("f", lies)),
    )
    model = jo.compile(machine)
    run = jo.simulate(model, 1e-6, state=jo.equilibrium(model), solver=jo.ROS2(1e-6))
    np.testing.assert_allclose(run["f"][0], (0, 0, PRESS + WEIGHT * LONG), atol=1e-4 * PRESS)
    return float(z - run["middle"][0, 2])


LONG, SECTION, BED, PRESS = 6.0, jo.Rectangle(0.1, 0.1), 2e7, 2000.0  # m, N/m2, N
WEIGHT = STEEL.rho * 0.01 * G  # N/m


@pytest.mark.parametrize("exact", [True, False])
def test_beam_on_an_elastic_foundation(exact):
    """Infinite beam with shear on a foundation under a force, by its Fourier integral.

    Stiffness ``EI q^4 / (1 + EI q^2 / kGA) + k`` at each wave number q (Hetenyi, Beams on Elastic
    Foundation, 1946, chapter 1, with the shear of Timoshenko).
    """
    EI, shear = STEEL.E * 0.1**4 / 12, 5 / 6 * STEEL.E / 2.6 * 0.01

    def share(q: float) -> float:
        return PRESS / np.pi / (BED + EI * q**4 / (1 + EI * q * q / shear))

    exact_depth = quad(share, 0, 10)[0] + quad(share, 10, np.inf)[0]
    assert WEIGHT / BED > 0.05 * exact_depth  # the weight keeps all of it on the foundation
    coarse, fine = deepest(exact, 24), deepest(exact, 48)
    assert abs(coarse - fine) < 0.02 * exact_depth
    assert (4 * fine - coarse) / 3 == pytest.approx(exact_depth, rel=1e-3)


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_energy_of_a_plate_that_falls_on_a_block(core):
    """Nothing is missed, and the sum of energies stays without loss."""
    body, x = jo.FlexibleBody("block", reduced(2, 1, 3)), block()[1]
    plate = jo.RigidBody("plate", 5.0, (1, 1, 1), position=(0, 0, L + 1e-3))
    law = PowerLaw(1e9, 1.5, restitution=1.0)
    down = plate.at((0, 0, 0), axes=TURNED)
    lid = SkinContact("lid", down, HalfSpace(), body, law, nodes="top")
    feet = [
        jo.Spring(f"{i} {k}", jo.Displacement(jo.ground.at(x[i]), body[f"node{i + 1}"], k), 1e6)
        for i in body.reduced.node_sets["bottom"]
        for k in "xyz"
    ]
    guide = jo.Prismatic("guide", jo.ground.at((0, 0, L)), plate["origin"], axis=(0, 0, 1))
    z = jo.PositionSensor("z", plate["origin"])
    machine = jo.Mechanism(body, plate, lid, *feet, guide, z, jo.Gravity((0, 0, -G)))
    model = jo.compile(machine, core=core)
    run = jo.simulate(model, 0.02, solver=jo.RK4(2e-5), output_step=1e-4)
    assert np.abs(run.energy.error).max() < 1e-4 * 5.0 * G * 1e-3
    assert run.energy.dissipated[-1] < 1e-4 * 5.0 * G * 1e-3
    assert len(run.contacts) >= 9
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    other = jo.simulate(
        jo.compile(machine, core="maximal"), 0.02, solver=jo.RK4(2e-5), output_step=1e-4
    )
    np.testing.assert_allclose(run["z"], other["z"], atol=1e-9)


def test_a_step_of_many_flights_misses_nothing():
    body = jo.FlexibleBody("block", reduced(2, 1, 3), position=(0, 0, 0.5), velocity=(0, 0, -200.0))
    law = PowerLaw(1e13, 1.0, restitution=1.0)
    plate = Cuboid((1, 1, 1e-3))
    touch = SkinContact("t", jo.ground["origin"], plate, body, law, nodes="bottom")
    model = jo.compile(jo.Mechanism(body, touch, jo.VelocitySensor("v", body["node1"])))
    run = jo.simulate(model, 5e-3, solver=jo.RK4(5e-3))
    assert len(run.contacts) >= 9
    assert run.attributes["contacts"] == "missed: 0 (proven)"


def test_areas_of_quadratic_faces_are_those_of_a_constant_pressure():
    """Corners of a triangle with mid-side nodes have no share."""
    x = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    nodes = np.concatenate([x, [(x[i] + x[j]) / 2 for i, j in pairs]])
    mesh = jo.Mesh("t", nodes, (jo.mesh.Cells("tetra10", np.arange(10)[None]),))
    part = jo.Part.solid(mesh, jo.Material(E, NU, RHO))
    body = jo.FlexibleBody("t", jo.reduce(part, jo.FreeFree(modes=4)))
    touch = SkinContact("t", jo.ground["origin"], HalfSpace(), body, PowerLaw(1e9))
    assert sum(touch.weights) == pytest.approx(1.5 + np.sqrt(3) / 2)
    assert {marker.node for marker in touch.markers} == set(range(4, 10))


def test_a_skin_in_a_model_file(tmp_path):
    part, _ = block()
    reduced().save(tmp_path / "block.red")
    text = """
parts: {block: {file: block.red}}
bodies: [{type: flexible, name: block, part: block, position: [0, 0, 1 mm]}]
forces:
  - type: skin-contact
    name: floor
    a: ground.origin
    shape: {type: half-space}
    body: block
    law: {type: power-law, stiffness: 1e11, exponent: 1}
    nodes: [bottom]
    mu_kinetic: 0.3
sensors: [{type: force, name: f, force: floor}]
gravity: [0, 0, -9.81]
"""
    path = tmp_path / "machine.yaml"
    path.write_text(text, encoding="utf-8")
    (touch,) = jo.read_model(path).mechanism.forces
    assert touch.nodes == ("bottom",)
    assert sum(touch.weights) == pytest.approx(B * B)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": Hertz(1e11)}, "law of the pressure"),
        ({"nodes": ("botom",)}, "no node set 'botom'; did you mean 'bottom'"),
        ({"nodes": ("node1",)}, "no face has all its nodes in nodes"),
        ({"shape": ConvexHull(np.eye(3).tolist() + [[0, 0, 0]])}, "cannot touch in this version"),
        ({"body": jo.RigidBody("r", 1.0, (1, 1, 1))}, "must be a FlexibleBody or a BeamBody"),
        ({"mu_kinetic": 0.3, "mu_static": 0.2}, "mu_static 0.2 is below"),
        ({"law": SpringDamper(1e9), "resolve": "impulse"}, "law with a restitution"),
        ({"nodes": 7}, "must be a list of names"),
        ({"radius": -1.0}, "radius"),
    ],
)
def test_skins_that_are_refused(change, message):
    body = jo.FlexibleBody("block", reduced())
    given = {"a": jo.ground["origin"], "shape": HalfSpace(), "body": body, "law": PowerLaw(1e9)}
    with pytest.raises(jo.InputError, match=message):
        SkinContact("skin", **(given | change))
    with pytest.raises(jo.InputError, match="both on 'block'"):
        SkinContact("skin", **(given | {"a": body["node1"]}))
