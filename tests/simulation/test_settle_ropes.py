"""Ropes at rest: directions without stiffness, catenary, funicular polygon, released arcs.

A rope between two spherical joints spins freely about its own axis, as every link of a chain
does; nothing pushes it there, so that it rests all the same.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

import jousto as jo

G = 9.81
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)


def curve(n: int, length: float, way: int = -2) -> np.ndarray:
    """Nodes of an arc of given length over a span of 1 m, to the side or down (axes 1, -2: z)."""
    a = brentq(lambda x: np.sin(x) / x - 1 / length, 1e-3, 3)
    R, t = length / (2 * a), np.linspace(-a, a, n + 1)
    points = np.zeros((n + 1, 3))
    points[:, 0] = 0.5 + R * np.sin(t)
    points[:, abs(way)] = (R * np.cos(t) - R * np.cos(a)) * np.sign(way)
    return points - points[0]


def rope(points: np.ndarray, diameter: float, **options: object) -> jo.BeamBody:
    return jo.BeamBody("rope", points, jo.Circle(diameter), STEEL, **options)


def hung(beam: jo.BeamBody, *more: object) -> jo.Model:
    """Between two spherical joints."""
    ends = [jo.ground.at(beam.nodes[i]) for i in (0, -1)]
    return jo.compile(
        jo.Mechanism(
            beam,
            jo.Spherical("left", ends[0], beam["start"]),
            jo.Spherical("right", ends[1], beam["end"]),
            *more,
        )
    )


def places(model: jo.Model, state: jo.simulation.State) -> np.ndarray:
    return np.array([state.q[b.iq : b.iq + 3] for b in model.bodies])


def catenary(length: float) -> float:
    """Sag over a span of 1: ``2 a sinh(1/2a)`` is the length, ``a (cosh(1/2a) - 1)`` the sag."""
    a = brentq(lambda x: 2 * x * np.sinh(0.5 / x) - length, 0.05, 50)
    return float(a * (np.cosh(0.5 / a) - 1))


@pytest.mark.parametrize("way", [1, -2])
def test_a_slack_cable_hangs_as_a_catenary(way):
    """Placed hanging or aside, of 10 um, so thin that its stiffness lifts it by less than 1e-4.

    A polygon of n links hangs deeper than the catenary by the order 1/n^2.
    """
    errors = []
    for n in (10, 20, 40):
        model = hung(rope(curve(n, 1.2, way), 1e-5, straight=True), jo.Gravity((0, 0, -G)))
        at = places(model, jo.equilibrium(model))
        assert np.abs(at[:, 1]).max() < 1e-6
        errors.append(-at[n // 2, 2] - catenary(1.2))
    limit = (4 * errors[2] - errors[1]) / 3
    assert abs(errors[0]) < 6e-3
    assert 3.0 < errors[0] / errors[1] < 5.0
    assert abs(limit) < 2e-4


def test_a_taut_rope_under_an_oblique_load_is_a_triangle():
    """``P = 2 T sin(a), T = EA (1/cos(a) - 1)`` for any direction across; order of the thickness.

    The bending stiffness EI over T l^2 is 7e-7 here: it rounds the kinks over its root of a length.
    """
    d, P = 5e-4, 1000.0
    EA = 210e9 * np.pi * d**2 / 4
    a = brentq(lambda x: 2 * EA * (1 / np.cos(x) - 1) * np.sin(x) - P, 1e-3, 1.0)
    beam = rope(np.array([(0, 0, 0), (1, 0, 0)]), d, elements=10)
    push = jo.Force("push", beam.node(5), (0, 0.6 * P, -0.8 * P))
    model = hung(beam, push)
    middle = places(model, jo.equilibrium(model))[5]
    assert middle == pytest.approx([0.5, 0.3 * np.tan(a), -0.4 * np.tan(a)], abs=3e-3 * np.tan(a))


def links(points: np.ndarray, mass: float = 1e-3) -> list[object]:
    """Rigid links between spherical joints along a line of points; nearly without weight."""
    parts: list[object] = []
    before = jo.ground.at(points[0])
    for i, (p, q) in enumerate(zip(points[:-1], points[1:], strict=True)):
        along = q - p
        h = float(np.linalg.norm(along))
        x = along / h
        y = np.cross([0.0, 0.0, 1.0], x)
        y = y / np.linalg.norm(y)
        axes = np.column_stack([x, y, np.cross(x, y)])
        link = jo.RigidBody(
            f"link{i}",
            mass=mass,
            inertia=mass * h**2 / 12 * np.diag([0.01, 1, 1]),
            position=(p + q) / 2,
            orientation=axes,
        )
        parts += [link, jo.Spherical(f"joint{i}", before, link.at((-h / 2, 0, 0)))]
        before = link.at((h / 2, 0, 0))
    return [*parts, jo.Spherical("last", jo.ground.at(points[-1]), before)]


def funicular(h: np.ndarray, loads: np.ndarray, span: float) -> np.ndarray:
    """Inner joints of links of lengths h under loads on them (k, 3): ``sum h t = span``."""

    def forces(first: np.ndarray) -> np.ndarray:
        return first - np.vstack([np.zeros(3), np.cumsum(loads, axis=0)])

    def gap(first: np.ndarray) -> np.ndarray:
        T = forces(first)
        t = T / np.linalg.norm(T, axis=1, keepdims=True)
        return (h[:, None] * t).sum(axis=0) - [span, 0.0, 0.0]

    T = forces(fsolve(gap, [5.0, 0.5 * loads[:, 1].sum(), 0.5 * loads[:, 2].sum()], xtol=1e-13))
    steps = h[:, None] * T / np.linalg.norm(T, axis=1, keepdims=True)
    return np.cumsum(steps, axis=0)[:-1]


@pytest.mark.parametrize("n", [6, 130])
def test_a_loaded_chain_is_a_funicular_polygon(n):
    """Small by dense matrices, large by sparse ones: every link spins about its own axis."""
    points = curve(n, 1.3)
    h = np.linalg.norm(np.diff(points, axis=0), axis=1)
    parts = links(points)
    chain = [part for part in parts if isinstance(part, jo.RigidBody)]
    loads = np.zeros((n - 1, 3))
    loads[n // 3] = (1.0, 4.0, -5.0)
    loads[n // 2] = (0.0, -2.0, -8.0)
    pushes = [
        jo.Force(f"push{i}", chain[i].at((h[i] / 2, 0, 0)), loads[i]) for i in (n // 3, n // 2)
    ]
    weight = np.zeros((n - 1, 3))
    weight[:, 2] = -1e-3 * G  # half of each neighbour
    model = jo.compile(jo.Mechanism(*parts, *pushes, jo.Gravity((0, 0, -G))))
    at, rest = [], jo.equilibrium(model)
    for b, half in zip(model.bodies, h / 2, strict=True):
        w, x, y, z = rest.q[b.iq + 3 : b.iq + 7]
        axis = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
        at.append(rest.q[b.iq : b.iq + 3] + half * axis)
    assert np.array(at)[:-1] == pytest.approx(funicular(h, loads + weight, points[-1, 0]), abs=1e-6)


@pytest.mark.parametrize("bending", [False, True])
@pytest.mark.parametrize("n", [4, 8, pytest.param(16, marks=pytest.mark.slow)])
@pytest.mark.parametrize("angle", [1.0, 3.0, 6.0])
def test_an_arc_released_from_its_mould_is_straight(n, angle, bending):
    t = np.linspace(0.0, angle, n + 1)
    points = np.column_stack([np.sin(t), 0 * t, 1 - np.cos(t)]) / angle
    strip = rope(points, 0.01, straight=True, bending=bending)
    clamp = jo.Fixed("clamp", jo.ground.at((0, 0, 0), axes=strip.frames[0]), strip["start"])
    model = jo.compile(jo.Mechanism(strip, clamp))
    at = places(model, jo.equilibrium(model))
    along = strip.s[:, None] * strip.frames[0][:, 0]
    assert at == pytest.approx(along, abs=1e-9)


@pytest.mark.parametrize(
    ("load", "across", "along"), [(1, 0.3017207738, 0.0564332363), (10, 0.8106090249, 0.5549955978)]
)
def test_a_cantilever_finds_the_elastica_at_once(load, across, along):
    """Elliptic integrals of Bisshopp and Drucker (1945); order four, stretch and shear 1e-7."""
    stiff = 1e8
    section = jo.mechanism.BeamSection(
        (stiff, stiff, stiff, 1.0, 1.0, 1.0), 1.0, (2e-3, 1e-3, 1e-3)
    )
    beam = jo.BeamBody("strip", [(0, 0, 0), (1, 0, 0)], section, elements=16, bending=True)
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    model = jo.compile(jo.Mechanism(beam, clamp, jo.Force("load", beam["end"], (0, 0, load))))
    tip = places(model, jo.equilibrium(model))[-1]
    assert tip == pytest.approx([1 - along, 0, across], abs=5e-6)


def test_a_path_of_a_rope_has_no_critical_points():
    """Its spin has a stiffness of round-off, of either sign."""
    beam = rope(curve(8, 1.2), 2e-3, straight=True)
    push = jo.Force("push", beam.node(4), (0, 1, -3), signal=jo.Input("load"))
    model = hung(beam, jo.Gravity((0, 0, -G)), push)
    path = jo.simulation.load_path(model, "load", to=1.0, steps=3, state=jo.equilibrium(model))
    assert path.complete
    assert not path.critical
    assert path.stable.all()


@pytest.mark.parametrize("case", ["slides", "spins"])
def test_what_is_pushed_where_nothing_holds_it_is_said(case):
    beam = rope(np.array([(0, 0, 0), (1, 0, 0)]), 0.02, elements=4)
    base = jo.ground["origin"]
    parts: dict[str, list[object]] = {
        "slides": [
            jo.PointOnLine("rail", base, beam["start"], axis=(0, 0, 1)),
            jo.Gravity((0, 0, -G)),
        ],
        "spins": [
            jo.Revolute("axle", base, beam["start"], axis=(1, 0, 0)),
            jo.Torque("turn", beam["end"], (0.1, 0, 0)),
        ],
    }
    model = jo.compile(jo.Mechanism(beam, *parts[case]))
    with pytest.raises(jo.SimulationError, match="in which nothing holds it; add a joint"):
        jo.equilibrium(model)


def test_what_never_rests_is_not_said_to_be_unheld():
    """A force that follows a hanging bar and is larger than its weight turns it for ever."""
    beam = rope(np.array([(0, 0, 0), (1, 0, 0)]), 0.02, elements=4)
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], axis=(0, 1, 0))
    push = jo.Force("push", beam["end"], (0, 0, 100.0), follow=True)
    model = jo.compile(jo.Mechanism(beam, hinge, push, jo.Gravity((0, 0, -G))))
    with pytest.raises(jo.SimulationError, match="start nearer") as error:
        jo.equilibrium(model)
    assert "nothing holds" not in str(error.value)
