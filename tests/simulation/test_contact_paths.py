"""Load paths and buckling of machines that touch without friction, beside closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import jousto as jo
from jousto.mechanism import (
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Sphere,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")
FROM_X = np.array([(0, 0, 1.0), (0, 1, 0), (-1, 0, 0)]).T  # axes of a wall that faces -x


def wall(at: Any, axes: Any, tip: Any, K: float, n: float, mu: float = 0.0) -> Contact:
    """A wall that a point touches."""
    law = PowerLaw(K, n, restitution=1.0)
    place = jo.ground.at(at, axes=axes)
    return Contact("stop", place, HalfSpace(), tip, Sphere(0.0), law, mu_kinetic=mu)


def bar(length: float) -> tuple[Any, Any, Any]:
    """An upright rigid bar on a hinge, and its tip."""
    rod = jo.RigidBody("rod", 1.0, (0.3, 0.3, 0.01), position=(0, 0, length / 2))
    foot = jo.Revolute("foot", jo.ground["origin"], rod.at((0, 0, -length / 2)), (0, 1, 0))
    return rod, foot, rod.at((0, 0, length / 2))


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_a_rigid_column_leans_on_a_stop(n: float) -> None:
    """It falls over at ``P = dN/dd L``, the stiffness of the contact that a preload closes."""
    L, K, d = 2.0, 1e6, 1e-4
    rod, foot, tip = bar(L)
    stop = wall((-d, 0, L), FROM_X, tip, K, n)
    preload = jo.Force("preload", tip, (K * d**n, 0, 0))
    load = jo.Force("load", tip, (0, 0, -1.0), signal=jo.Input("load"))
    model = jo.compile(jo.Mechanism(rod, foot, stop, preload, load))
    found = jo.simulation.buckling(model, "load", 1)
    assert found.loads == pytest.approx([n * K * d ** (n - 1) * L], rel=1e-9)


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_euler_column_with_a_stop_in_the_middle(share: float) -> None:
    """Pinned, with a lateral contact of stiffness k in the middle.

    Half a wave up to ``k = 16 pi^2 EI / L^3`` with ``k = 2 P / (L/2 - tan(b L/2) / b)``,
    ``b^2 = P / EI``; beyond it two half waves at 4 times the load of Euler.
    """
    side, E = 0.002, 210e9  # slender: it shortens by 1e-5 of its length
    EI = E * side**4 / 12
    k = share * 16 * np.pi**2 * EI
    part = jo.Part.beam(
        *(1.0, jo.Rectangle(side, side), 20, jo.Material(E=E, nu=0.3, rho=7850.0)),
        theory=jo.parts.EulerBernoulli(),
    )
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "node11", "end"), modes=20))
    column = jo.FlexibleBody("column", reduced.keep(reduced.in_plane("xz")))
    middle, F = column["node11"], 1e-5
    up = np.array([(1.0, 0, 0), (0, 1, 0), (0, 0, 1)])
    stop = wall((0.5, 0, F / k), up, middle, k, 1.0)
    model = jo.compile(
        jo.Mechanism(
            column,
            jo.Revolute("foot", jo.ground["origin"], column["start"], (0, 1, 0)),
            jo.PointOnPlane("head", jo.ground["origin"], column["end"], (0, 0, 1)),
            stop,
            jo.Force("preload", middle, (0, 0, -F)),
            jo.Force("load", column["end"], (-1.0, 0, 0), signal=jo.Input("load")),
        )
    )

    def missing(P: float) -> float:
        b = np.sqrt(P / EI)
        return float(2 * P / (0.5 - np.tan(0.5 * b) / b) - k)

    euler = np.pi**2 * EI
    wanted = 4 * euler if share > 1 else brentq(missing, 1.01 * euler, 3.99 * euler)
    assert jo.simulation.buckling(model, "load", 1).loads == pytest.approx([wanted], rel=5e-5)


@pytest.mark.parametrize("method", ["load", "arc"])
def test_a_path_closes_and_opens_a_gap(method: str) -> None:
    """A bar on a spring is pushed against a stop: ``F cos a = k a + K (sin a - gap) cos a``."""
    spring, K, gap = 50.0, 1e4, 0.1

    def model() -> Any:
        rod, foot, tip = bar(1.0)
        push = jo.Force("push", tip, (1.0, 0, 0), signal=jo.Input("push"))
        items = (jo.Spring("spring", foot.angle, spring), push, jo.PositionSensor("tip", tip))
        return jo.compile(jo.Mechanism(rod, foot, wall((gap, 0, 0), FROM_X, tip, K, 1.0), *items))

    def leans(F: float) -> float:
        def missing(a: float) -> float:
            return float((F - K * max(np.sin(a) - gap, 0.0)) * np.cos(a) - spring * a)

        return float(np.sin(brentq(missing, -0.1, 1.5, xtol=1e-15)))

    up = jo.simulation.load_path(model(), "push", to=60.0, steps=10, method=method)
    down = jo.simulation.load_path(
        model(), "push", start=60.0, to=0.0, steps=10, method=method, state=up.states[-1]
    )
    for path in (up, down):
        wanted = [leans(F) for F in path.load]
        np.testing.assert_allclose(path["tip"][:, 0], wanted, atol=1e-9)
    assert up["tip"][-1, 0] > gap > down["tip"][-1, 0]


def test_what_depends_on_the_way_is_refused() -> None:
    """Friction, faces that touch at corners, and contacts of many bodies."""
    rod, foot, tip = bar(1.0)
    load = jo.Force("load", tip, (0, 0, -1.0), signal=jo.Input("load"))
    rubs = jo.compile(jo.Mechanism(rod, foot, wall((0, 0, 1), FROM_X, tip, 1e6, 1.0, 0.3), load))
    box, law = jo.RigidBody("box", 1.0, (0.1,) * 3, position=(0, 0, 0.3)), PowerLaw(1e6, 1.0)
    cube = Cuboid((0.2, 0.2, 0.2))
    faces = Contact("faces", rod["origin"], cube, box["origin"], cube, law)
    stack = jo.compile(jo.Mechanism(rod, foot, box, faces, load))
    shapes = [CollisionShape(x.name, x["origin"], cube) for x in (rod, box)]
    many = jo.compile(jo.Mechanism(rod, foot, box, Contacts("many", shapes, law=law), load))
    for verb in (jo.simulation.load_path, jo.simulation.buckling):
        with pytest.raises(jo.InputError, match="'stop'.*sticks and slips.*leave out its friction"):
            verb(rubs, "load", to=1.0)
        with pytest.raises(jo.InputError, match="'faces'.*corners that change"):
            verb(stack, "load", to=1.0)
        with pytest.raises(jo.InputError, match="'many'.*finds its pairs in the steps of a run"):
            verb(many, "load", to=1.0)
