"""Beams with plastic hinges under slow loads: load path of a cantilever, and a propped one.

EI 4e4 N m2, L 2 m, hinges of 3000 N m. The numbers are those of first-order theory (small
displacements), so that moments and loads are smaller by SMALL here.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import jousto as jo

EI, L, YIELD, K, H = 4e4, 2.0, 3000.0, 2e5, 2e4
SMALL = 3e-4
STIFF = 1e8
"""Stiffness of a hinge that is nearly rigid until it yields, N m/rad."""


@cache
def rod(length: float) -> jo.ReducedPart:
    """Return a beam of this bending stiffness without shear, with exact statics at its ends."""
    section = jo.Rectangle(0.05, (12.0 * EI / (2.1e11 * 0.05)) ** (1 / 3))
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    part = jo.Part.beam(length, section, 2, steel, theory=jo.parts.EulerBernoulli())
    return jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=0))


def hinge_between(name: str, a: Any, b: Any, k: float, **law: float) -> tuple[Any, ...]:
    """Return a hinge about y with its spring and the sensor of its plastic angle."""
    turn = jo.Revolute(name, a, b, axis=(0, -1, 0))
    spring = jo.mechanism.PlasticSpring(f"{name} spring", turn.angle, k, SMALL * YIELD, **law)
    sensors = (
        jo.mechanism.ForceStateSensor(f"{name} p", spring),
        jo.ForceSensor(f"{name} M", spring),
    )
    return turn, spring, *sensors


def followed(model: jo.Model, loads: list[float]) -> list[Any]:
    """Return the ends of the paths to loads, one after the other."""
    state, out = None, []
    for load in loads:
        path = jo.simulation.load_path(model, "P", to=SMALL * load, steps=4, state=state)
        state = path.states[-1]
        out.append({name: float(np.ravel(path[name][-1])[-1]) / SMALL for name in path.sensors})
    return out


@pytest.mark.parametrize("law, plastic", [
    ("kinematic", [0.05, -0.05, 0.03, 0.03]), ("isotropic", [0.05] * 4),
])  # fmt: skip
def test_cantilever(law: str, plastic: list[float]) -> None:
    """Tip loads 2000, -2000, 1800, 0 N; the tip has P L^3 / 3EI and the hinge's angle times L."""
    beam = jo.FlexibleBody("beam", rod(L))
    items = hinge_between("root", jo.ground["origin"], beam["start"], K, **{law: H})
    tip = jo.PositionSensor("tip", beam["end"])
    load = jo.Force("load", beam["end"], (0, 0, 1.0), signal=jo.Input("P"))
    model = jo.compile(jo.Mechanism(beam, *items, tip, load))
    loads = [2000.0, -2000.0, 1800.0, 0.0]
    found = followed(model, loads)
    assert [x["root p"] for x in found] == pytest.approx(plastic, rel=1e-8)
    tips = [p * L + P * (L**2 / K + L**3 / (3 * EI)) for P, p in zip(loads, plastic, strict=True)]
    if law == "kinematic":
        assert tips == pytest.approx([0.2733333333, -0.2733333333, 0.216, 0.06], rel=1e-9)
    assert [x["tip"] for x in found] == pytest.approx(tips, rel=1e-7)


def propped() -> jo.Model:
    """Return a beam with hinges at its root and its middle, held up at its far end."""
    one = jo.FlexibleBody("one", rod(L / 2))
    two = jo.FlexibleBody("two", rod(L / 2), position=(L / 2, 0, 0))
    hinges = (
        *hinge_between("root", jo.ground["origin"], one["start"], STIFF),
        *hinge_between("middle", one["end"], two["start"], STIFF),
    )
    prop = jo.PointOnPlane("prop", jo.ground.at((L, 0, 0)), two["end"], (0, 0, 1))
    load = jo.Force("load", two["start"], (0, 0, -1.0), signal=jo.Input("P"))
    place = jo.PositionSensor("place", two["start"])
    return jo.compile(jo.Mechanism(one, two, *hinges, prop, load, place))


def root_of_the_propped(P: float, k: float) -> tuple[float, float]:
    """Return the plastic angle of the root at a load beyond yielding, and its moment unloaded.

    The far end stays: ``(p + M/k) L + 5 P L^3 / 48 EI = R (L^3 / 3 EI + L^2 / 4k)`` with the
    reaction ``R = P/2 - M/L``, M = M_y under the load, P = 0 without.
    """
    soft = L**3 / (3 * EI) + L**2 / (4 * k)
    p = ((P / 2 - YIELD / L) * soft - 5 * P * L**3 / (48 * EI)) / L - YIELD / k
    return p, -p * L / (soft / L + L / k)


def test_propped_cantilever() -> None:
    """First yield 16 M_y / 3L = 8000 N; at 8550 N the root turns, and keeps a moment unloaded."""
    assert root_of_the_propped(8550.0, 1e30) == pytest.approx((0.0034375, -206.25), rel=1e-12)
    assert root_of_the_propped(8000.0, 1e30)[0] == pytest.approx(0.0, abs=1e-15)
    p, M = root_of_the_propped(8550.0, STIFF)
    found = followed(propped(), [7990.0, 8550.0, 0.0, 8550.0, 0.0])
    assert found[0]["root p"] == 0.0
    assert -found[1]["root p"] == pytest.approx(p, rel=1e-8)
    assert found[1]["root M"] == pytest.approx(YIELD, rel=1e-8)
    # of the other sign, and elastic from then on
    for unloaded in (found[2], found[4]):
        assert unloaded["root M"] == pytest.approx(M, rel=1e-7)
    for later in found[2:]:
        assert later["root p"] == pytest.approx(found[1]["root p"], rel=1e-8)
    assert all(x["middle p"] == 0.0 for x in found)


def test_collapse_of_the_propped_cantilever() -> None:
    """6 M_y / L = 9000 N: a hinge in the middle, too; beyond, a mechanism that large turns stop."""
    model = propped()
    before, after = followed(model, [8999.9, 9001.0])
    assert before["middle p"] == 0.0
    assert -before["middle M"] == pytest.approx(YIELD, rel=2e-5)
    assert abs(after["root p"]) > 1000.0 * abs(before["root p"])
    assert abs(after["middle p"]) == pytest.approx(2.0 * abs(after["root p"]), rel=0.01)
