"""Which bodies can move, at dead centres and in large machines."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.model.rank import motions

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

CRANK, ROD = 0.3, 1.0


def slider_crank(angle: float, *more: object, driven: bool = False) -> jo.Mechanism:
    """Crank in the x-y plane at an angle, a rod, a slider along x: one motion."""
    pin = np.array([CRANK * np.cos(angle), CRANK * np.sin(angle), 0.0])
    at = np.array([pin[0] + np.sqrt(ROD**2 - pin[1] ** 2), 0.0, 0.0])
    lean = float(np.arctan2(-pin[1], at[0] - pin[0]))
    turned = {"orientation": jo.Rotate((0, 0, 1), radians=angle)}
    crank = jo.RigidBody("crank", 1.0, (0.01,) * 3, markers={"pin": (CRANK, 0, 0)}, **turned)
    turned = {"orientation": jo.Rotate((0, 0, 1), radians=lean)}
    rod = jo.RigidBody(
        "rod", 1.0, (0.02,) * 3, position=pin, markers={"end": (ROD, 0, 0)}, **turned
    )
    slider = jo.RigidBody("slider", 1.0, (0.01,) * 3, position=at)
    shaft = jo.Revolute("shaft", jo.ground["origin"], crank["origin"], axis=(0, 0, 1))
    items = [
        *(crank, rod, slider, shaft),
        jo.Spherical("big end", crank["pin"], rod["origin"]),
        jo.Universal("small end", rod["end"], slider["origin"], axis_a=(0, 1, 0), axis_b=(0, 0, 1)),
        jo.Prismatic("guide", jo.ground["origin"], slider["origin"], axis=(1, 0, 0)),
    ]
    if driven:
        items.append(jo.Drive("motor", shaft.angle, jo.ConstantSpeed(1.0, offset=angle)))
    return jo.Mechanism(*items, *more)


@pytest.mark.parametrize("angle", [0.0, np.pi])
@pytest.mark.parametrize("driven", [False, True])
def test_a_slider_at_its_dead_centre_is_not_said_to_be_held(angle, driven):
    """x = a cos(t) + sqrt(b^2 - a^2 sin(t)^2) has dx/dt = 0 at t = 0 and pi, nowhere else near."""
    found = jo.doctor(slider_crank(angle, driven=driven))
    assert (found.still, found.dead) == ((), ("slider",))
    assert "cannot move" not in str(found)
    assert "dead centre: slider" in str(found)
    assert ("crank" in found.driven) == driven


@pytest.mark.parametrize("angle", [1e-3, 0.5, np.pi - 1e-3])
def test_beside_the_dead_centre_all_bodies_move(angle):
    found = jo.doctor(slider_crank(angle))
    assert (found.still, found.dead) == ((), ())
    assert found.moving == ("crank", "rod", "slider")


def test_what_is_held_is_held_beside_a_dead_centre_too():
    block = jo.RigidBody("block", 1.0, (0.01,) * 3, position=(0, 5, 0))
    held = jo.Fixed("bolt", jo.ground.at((0, 5, 0)), block["origin"])
    found = jo.doctor(slider_crank(0.0, block, held))
    assert (found.still, found.dead) == (("block",), ("slider",))


def test_random_motions_tell_the_same_as_all_motions(monkeypatch):
    """What large models use, on small ones: projections instead of the null space."""
    block = jo.RigidBody("block", 1.0, (0.01,) * 3, position=(0, 5, 0))
    held = jo.Fixed("bolt", jo.ground.at((0, 5, 0)), block["origin"])
    machines = [
        slider_crank(0.0, block, held),
        slider_crank(0.7),
        slider_crank(0.0, driven=True),
        slider_crank(0.7, block, held, jo.Fixed("nut", jo.ground.at((0, 5, 0)), block["origin"])),
    ]
    small = [jo.doctor(machine) for machine in machines]
    monkeypatch.setattr(motions, "SMALL", 0)
    for machine, before in zip(machines, small, strict=True):
        after = jo.doctor(machine)
        for name in ("moving", "driven", "still", "dead", "mobility", "rigid_mobility"):
            assert getattr(after, name) == getattr(before, name), name


def test_a_long_chain_is_examined_too():
    """450 links are 2700 velocities; the first is bolted to ground."""
    links = [
        jo.RigidBody(f"b{i}", 1.0, (0.1,) * 3, position=(i, 0, 0), markers={"e": (1, 0, 0)})
        for i in range(450)
    ]
    joints: list = [jo.Fixed("bolt", jo.ground["origin"], links[0]["origin"])]
    joints += [
        jo.Revolute(f"j{i}", a["e"], b["origin"], axis=(0, 0, 1))
        for i, (a, b) in enumerate(zip(links, links[1:], strict=False))
    ]
    found = jo.doctor(jo.Mechanism(*links, *joints))
    assert found.still == ("b0",) and found.dead == ()
    assert (found.mobility, found.rigid_mobility) == (449, 449)


def test_links_of_a_tree_tell_the_same_as_the_rows(monkeypatch):
    """Joint coordinates need no engine; positions of the bodies project motions."""
    names = ("bolted", "hung", "driven", "behind", "loose", "carried")
    bodies = [
        jo.RigidBody(name, 1.0, (0.1,) * 3, position=(i, 0, 0), markers={"e": (1, 0, 0)})
        for i, name in enumerate(names)
    ]
    bolted, hung, driven, behind, loose, carried = bodies
    motor = jo.Revolute("pin", bolted["origin"], driven.at((-2, 0, 0)), axis=(0, 1, 0))
    joints = [
        jo.Fixed("bolt", jo.ground["origin"], bolted["origin"]),
        jo.Universal("cross", bolted["e"], hung["origin"], axis_a=(0, 1, 0), axis_b=(0, 0, 1)),
        motor,
        jo.Drive("motor", motor.angle, jo.ConstantSpeed(1.0)),
        jo.Fixed("weld", driven["e"], behind["origin"]),
        jo.Prismatic("guide", loose["e"], carried["origin"], axis=(1, 0, 0)),
    ]
    machine = jo.Mechanism(*bodies, *joints)
    engines = []
    projected = motions.Engine
    monkeypatch.setattr(motions, "Engine", lambda *a, **k: engines.append(1) or projected(*a, **k))
    tree = motions.moving(model := jo.compile(machine, core="joint"), model.q0)
    assert not engines
    for small in (motions.SMALL, 0):
        monkeypatch.setattr(motions, "SMALL", small)
        rows = motions.moving(model := jo.compile(machine, core="maximal"), model.q0)
        assert tree == rows == {"hung", "loose", "carried"}
    assert engines


def test_motions_in_units_of_unit_mass_have_the_kinetic_energy():
    """``|L^T v|^2 = 2 T`` with the engine's energy, of turned bodies with their mass off centre."""
    turn = {"orientation": jo.Rotate((1, 2, 3), radians=0.8), "center": (0.3, 0.1, -0.2)}
    items = [jo.RigidBody(f"b{i}", 2.0 + i, (0.5, 0.6, 0.7), **turn) for i in range(3)]
    model = jo.compile(
        jo.Mechanism(*items, jo.Fixed("weld", items[0]["origin"], items[1]["origin"]))
    )
    engine = motions.Engine(model, implicit=False)
    masses = motions._MassFactors(model, engine)
    x = np.random.default_rng(5).standard_normal(model.nv)
    engine.v[:] = masses.to_velocities(x)
    assert 0.5 * x @ x == pytest.approx(engine.energy()[0], rel=1e-12)
    assert masses.to_unit_mass(engine.v) == pytest.approx(x, rel=1e-12)
