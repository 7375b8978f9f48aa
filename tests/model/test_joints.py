"""Every joint, coupling and drive at the level of positions, velocities and accelerations."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.declare import kinds
from jousto.model.native.native import displaced
from jousto.model.rank.redundancy import constraint_matrix

EPS = 1e-30
G = (1.0, -9.81, 2.0)


def link(name: str, x: float, flexible: bool, **motion: object) -> jo.RigidBody | jo.FlexibleBody:
    part = jo.Part.beam(
        length=1.0,
        section=jo.Rectangle(0.02, 0.03),
        elements=4,
        material=jo.Material(E=2e9, nu=0.3, rho=1000.0),
        lumped=True,
    )
    if flexible:
        reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=9))
        return jo.FlexibleBody(name, reduced, position=(x, 0.0, 0.0), **motion)
    body = jo.RigidBody(
        name, 0.6, (0.01, 0.06, 0.05), center=(0.5, 0, 0), position=(x, 0, 0), **motion
    )
    return body


def ends(body: jo.RigidBody | jo.FlexibleBody) -> tuple[jo.Marker, jo.Marker]:
    if isinstance(body, jo.FlexibleBody):
        return body["start"], body["end"]
    return body["origin"], body.at((1.0, 0.0, 0.0))


AXIS = (0.3, 0.5, 1.0)
SIGNAL = jo.Harmonic(frequency=0.7, amplitude=0.4, phase=0.3)
JOINTS = {
    "Spherical": lambda a, b: jo.Spherical("j", a, b),
    "Revolute": lambda a, b: jo.Revolute("j", a, b, AXIS),
    "Fixed": lambda a, b: jo.Fixed("j", a, b),
    "Prismatic": lambda a, b: jo.Prismatic("j", a, b, AXIS),
    "Cylindrical": lambda a, b: jo.Cylindrical("j", a, b, AXIS),
    "Universal": lambda a, b: jo.Universal("j", a, b, (0, 1, 0), (0, 0, 1)),
    "Planar": lambda a, b: jo.Planar("j", a, b, AXIS),
    "PointOnLine": lambda a, b: jo.PointOnLine("j", a, b, AXIS),
    "PointOnPlane": lambda a, b: jo.PointOnPlane("j", a, b, AXIS),
    "ConstantOrientation": lambda a, b: jo.ConstantOrientation("j", a, b),
    "Screw": lambda a, b: jo.Screw("j", a, b, 0.2, AXIS),
    "ParallelAxes": lambda a, b: jo.mechanism.ParallelAxes("j", a, b, AXIS),
    "Perpendicular": lambda a, b: jo.mechanism.Perpendicular("j", a, b, (0, 1, 0), (0, 0, 1)),
}


def build(name: str, flexible: bool) -> jo.Model:
    first, second = link("first", 0.0, flexible), link("second", 1.0, flexible)
    base = jo.Revolute("base", jo.ground["origin"], ends(first)[0], (0.1, 0.2, 1.0))
    extra: list[object] = []
    if name == "Rod":
        joint: object = jo.Rod("j", ends(first)[0], ends(second)[1])
    elif name in ("Gear", "Drive"):
        joint = jo.Revolute("j", ends(first)[1], ends(second)[0], AXIS)
        if name == "Gear":
            extra = [jo.Gear("k", base.angle, joint.angle, -1.7)]
        else:
            extra = [jo.Drive("k", joint.angle, SIGNAL)]
    elif name == "Rack":
        joint = jo.Cylindrical("j", ends(first)[1], ends(second)[0], AXIS)
        extra = [jo.Rack("k", base.angle, joint.displacement, 0.3)]
    else:
        joint = JOINTS[name](ends(first)[1], ends(second)[0])
    return jo.compile(jo.Mechanism(first, second, base, joint, *extra, jo.Gravity(G)))


NAMES = (*JOINTS, "Rod", "Gear", "Drive", "Rack")


def disturbed(model: jo.Model) -> jo.model.Engine:
    """An engine somewhere on the constraints, everything moving, bodies bent."""
    engine = jo.model.Engine(model)
    rng = np.random.default_rng(3)
    move = 0.05 * rng.normal(size=model.nv)
    for body in model.bodies:
        move[body.iv + 6 : body.iv + 6 + body.n] *= 0.2
    engine.q[:] = displaced(model, model.q0, move)
    engine.v[:] = 10.0 * move
    engine.time[:] = 0.37
    engine.assemble()
    return engine


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize("name", NAMES)
def test_velocity_and_acceleration_rows_are_derivatives_of_the_position_rows(name, flexible):
    model = build(name, flexible)
    engine = disturbed(model)
    assert max(engine.residuals()) < 1e-9  # as demanded of every joint
    a, _ = engine.accelerations()
    probe = jo.model.Engine(model, complex_scalars=True)
    probe.turn[:] = engine.turn
    probe.q[:] = displaced(model, engine.q.astype(complex), 1j * EPS * engine.v)
    probe.v[:] = engine.v + 1j * EPS * a
    probe.time[:] = engine.time + 1j * EPS
    c, cdot = probe.constraints()
    # d/dt C(q, t) is the rate that the engine reports, and d/dt of that vanishes for its a
    scale = max(1.0, np.abs(engine.v).max())
    np.testing.assert_allclose(c.imag / EPS, cdot.real, atol=1e-12 * scale)
    np.testing.assert_allclose(cdot.imag / EPS, 0.0, atol=1e-11 * np.abs(a).max())


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize("name", NAMES)
def test_joint_forces_follow_from_the_virtual_work_of_the_rows(name, flexible):
    model = build(name, flexible)
    engine = disturbed(model)
    a, lam = (x.copy() for x in engine.accelerations())
    Cq = constraint_matrix(model, engine)
    # the same state without rows: the accelerations differ by M^-1 Cq^T lam
    loose = jo.model.Engine(_free(model))
    loose.q[:], loose.v[:], loose.time[:] = engine.q, engine.v, engine.time
    free = loose.accelerations()[0]
    for i, body in enumerate(model.bodies):
        rows = slice(body.iv, body.iv + 6 + body.n)
        change = (a - free)[rows]
        e0, e = engine.q[body.iq + 3], engine.q[body.iq + 4 : body.iq + 7]
        cross = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
        A = np.eye(3) + 2 * e0 * cross + 2 * cross @ cross
        change[:3] = A.T @ change[:3]
        force = engine.mass_matrix(i) @ change
        expected = -Cq[:, rows].T @ lam
        expected[:3] = A.T @ expected[:3]
        scale = np.abs(expected).max()
        np.testing.assert_allclose(force, expected, atol=1e-9 * scale)


def _free(model: jo.Model) -> jo.Model:
    from dataclasses import replace

    from jousto.model.elimination_order import eliminate

    return replace(model, joints=(), elimination=eliminate([], []))


def test_every_joint_is_tested():
    found = kinds("joints", "jousto.mechanism.joints").values()
    ours = [joint for joint in found if joint.__module__.startswith("jousto.")]
    # these have tests of their own, test_lines.py, test_rolling.py and test_rail_wheel.py
    own = {"Rod", "RollingDisc", "RollingWheel", "KnifeEdge", "RailWheel"}
    assert {joint.__name__ for joint in ours} == {*JOINTS, *own}


def fourbar(**options: object) -> list[object]:
    """A planar four-bar of four revolutes: 3 rows too many. Lengths 1, 2, 1.5 and 2 m."""
    crank = jo.RigidBody("crank", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    x, d = (4.0 - 2.25 + 5.0) / 2.0, 0.0  # rocker end on both circles, solved below
    B = np.array([1.0, 0.0])
    D = np.array([2.0, -1.0])
    along = D - B
    dist = np.linalg.norm(along)
    x = (2.0**2 - 1.5**2 + dist**2) / (2 * dist)
    d = np.sqrt(2.0**2 - x**2)
    C = B + x * along / dist + d * np.array([-along[1], along[0]]) / dist
    angle = np.degrees(np.arctan2(*(C - B)[::-1]))
    back = np.degrees(np.arctan2(*(C - D)[::-1]))
    coupler = jo.RigidBody(
        "coupler",
        2.0,
        (0.02, 0.6, 0.6),
        center=(1.0, 0, 0),
        position=(*B, 0.0),
        orientation=jo.Rotate((0, 0, 1), degrees=angle),
    )
    rocker = jo.RigidBody(
        "rocker",
        1.5,
        (0.02, 0.3, 0.3),
        center=(0.75, 0, 0),
        position=(*D, 0.0),
        orientation=jo.Rotate((0, 0, 1), degrees=back),
    )
    z = (0, 0, 1)
    joints = [
        jo.Revolute("A", jo.ground["origin"], crank["origin"], z),
        jo.Revolute("B", crank.at((1, 0, 0)), coupler["origin"], z),
        jo.Revolute("C", coupler.at((2, 0, 0)), rocker.at((1.5, 0, 0)), z),
        jo.Revolute("D", jo.ground.at((*D, 0.0)), rocker["origin"], z),
    ]
    return [crank, coupler, rocker, *joints, jo.Gravity((0, -9.81, 0))]


def test_a_planar_four_bar_of_revolutes_runs_and_says_what_repeats():
    with pytest.warns(jo.JoustoWarning, match="3 of the constraint rows of 'A', 'B', 'C', 'D'"):
        model = jo.compile(jo.Mechanism(*fourbar()))
    assert model.redundant
    run = jo.simulate(model, 1.0, solver=jo.RK4(step=1e-3))
    exchanged = np.ptp(run.energy.potential)
    assert np.abs(run.energy.error).max() < 1e-8 * exchanged  # order 4 at 1 ms
    assert run.residuals.position.max() < 1e-10
    assert run.residuals.velocity.max() < 1e-9
    assert np.abs(run.q[:, 2]).max() < 1e-12  # it stays in its plane


def test_the_remedy_makes_the_rows_independent_and_keeps_the_motion():
    from jousto.model.rank.redundancy import repeated_rows

    with pytest.warns(jo.JoustoWarning, match="are redundant"):
        model = jo.compile(jo.Mechanism(*fourbar()))
    found = repeated_rows(model)
    assert found is not None
    assert found.count == 3
    assert found.mobility == 1
    assert len(found.advice) == 2
    items = fourbar()
    spherical = jo.Spherical("A", items[3].a, items[3].b)
    universal = jo.Universal("B", items[4].a, items[4].b, (0, 0, 1), (0, 1, 0))
    other = jo.compile(jo.Mechanism(*items[:3], spherical, universal, *items[5:]))
    assert not other.redundant
    # the same initial accelerations; 1e-9: the least norm solution is refined to round-off
    np.testing.assert_allclose(
        jo.model.Engine(model).accelerations()[0],
        jo.model.Engine(other).accelerations()[0],
        atol=1e-9,
    )


@pytest.mark.filterwarnings("ignore:.*mobility:jousto.JoustoWarning")
def test_two_drives_that_disagree_are_an_error():
    items = fourbar()
    drives = [
        jo.Drive("one", items[3].angle, jo.Harmonic(frequency=1.0, amplitude=0.1)),
        jo.Drive("two", items[6].angle, jo.Harmonic(frequency=2.0, amplitude=0.1)),
    ]
    with pytest.raises(jo.InputError, match=r"(one|two)'.*contradicts"):
        jo.compile(jo.Mechanism(*items, *drives))


def test_a_flat_parallelogram_is_said_to_start_in_a_singular_position():
    def bar(name: str, x: float) -> jo.RigidBody:
        return jo.RigidBody(name, 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0), position=(x, 0, 0))

    crank, coupler, rocker = bar("crank", 0.0), bar("coupler", 1.0), bar("rocker", 1.0)
    z = (0, 0, 1)
    joints = [
        jo.Revolute("A", jo.ground["origin"], crank["origin"], z),
        jo.Universal("B", crank.at((1, 0, 0)), coupler["origin"], z, (0, 1, 0)),
        jo.Spherical("C", coupler.at((1, 0, 0)), rocker.at((1, 0, 0))),
        jo.Revolute("D", jo.ground.at((1, 0, 0)), rocker["origin"], z),
    ]
    with pytest.warns(jo.JoustoWarning, match="initial position is singular"):
        jo.compile(jo.Mechanism(crank, coupler, rocker, *joints, jo.Gravity((0, -9.81, 0))))
