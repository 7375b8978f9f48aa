"""Master-slave elimination: every map and formula against complex steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.planar.elimination import (
    ArmCoupling,
    BlockCoupling,
    ChainCoupling,
    Elimination,
    FunctionCoupling,
    LinearCoupling,
    PlanarCoupling,
)
from planar.frames import slide

Array = NDArray[Any]
rng = np.random.default_rng(5)
H = 1e-40


def arms_function(rotation: bool) -> Callable[[Array], Array]:
    """Eq. 20 once more, as a function."""

    def f(q: Array) -> Array:
        out: list[Any] = []
        for node, (X, Y) in ((0, (0.3, -0.2)), (1, (-0.1, 0.5)), (1, (0.2, 0.7))):
            x, y, th = q[3 * node : 3 * node + 3]
            c, s = np.cos(th), np.sin(th)
            out += [x + c * X - s * Y - X, y + s * X + c * Y - Y, th][: 3 if rotation else 2]
        return np.array(out)

    return f


def wild(q: Array) -> Array:
    """Every function that a coupling may use."""
    x, y, z = q
    r = np.sqrt(1.5 + x * x + y**2)
    return np.array(
        [
            np.exp(0.3 * x) / r,
            np.log(2.0 + y) * np.tan(0.4 * z) - x,
            np.arctan(y / (2 + x)) ** 3 + 2.0 - z / r**1.5,
            np.sin(x * y) * np.cos(z) + 1 / (3 - z),
        ]
    )


def maps() -> dict[str, PlanarCoupling]:
    masters, arms = np.array([0, 1, 1]), np.array([(0.3, -0.2), (-0.1, 0.5), (0.2, 0.7)])
    offset = ArmCoupling(2, masters, arms)
    slider = FunctionCoupling(slide, 3, 7)
    return {
        "offset": offset,
        "hinges": ArmCoupling(2, masters, arms, rotation=False),
        "linear": LinearCoupling(rng.normal(size=(5, 3)), rng.normal(size=5)),
        "function": FunctionCoupling(wild, 4, 3),
        "slider": slider,
        "blocks": BlockCoupling(
            (12, 10),
            [
                (np.array([0, 3, 1, 2, 5, 4, 11, 9, 10]), np.array([1, 3, 5, 0, 2, 9]), offset),
                (np.array([8, 6, 7]), np.arange(7)[::-1], slider),
            ],
        ),
        "chain": ChainCoupling(ArmCoupling(1, np.array([0]), np.array([(0.2, 0.4)])), slider),
    }


MAPS = maps()


@pytest.mark.parametrize("name", MAPS)
def test_derivatives_of_the_map(name: str) -> None:
    m = MAPS[name]
    slaves, n = m.shape
    q, v, a = 0.3 * rng.normal(size=(3, n))
    F = rng.normal(size=slaves)
    e = np.eye(n)

    B = np.array([np.imag(m.f(q + 1j * H * x)) / H for x in e]).T
    assert abs(m.B(q) - B).max() < 1e-12
    B1 = np.imag(m.B(q + 1j * H * v)) / H
    assert abs(m.B1(q, v) - B1).max() < 1e-12
    B2 = np.imag(m.B1(q + 1j * H * v, v + 1j * H * a)) / H
    assert abs(m.B2(q, v, a) - B2).max() < 1e-12
    Kg = np.array([np.imag(m.B(q + 1j * H * x).T @ F) / H for x in e]).T
    assert abs(m.Kg(q, F) - Kg).max() < 1e-12
    assert abs(Kg - Kg.T).max() < 1e-12


@pytest.mark.parametrize("name", MAPS)
def test_forces_stiffness_and_inertia(name: str) -> None:
    elimination = Elimination(MAPS[name])
    m = elimination.map
    slaves, n = m.shape
    q, v, a = 0.3 * rng.normal(size=(3, n))
    M = rng.normal(size=(slaves, slaves))
    M, K = M @ M.T, M + M.T
    e = np.eye(n)

    def inertia(q: Array, v: Array, a: Array) -> Array:
        # eq. 9
        return elimination.mass(q, M) @ a + elimination.centrifugal(q, v, M)

    s = elimination.slaves(q, v, a)
    assert abs(inertia(q, v, a) - s.B.T @ (M @ s.a)).max() < 1e-12 * abs(inertia(q, v, a)).max()
    Kacc, Cacc = elimination.inertia_tangents(q, v, a, M)
    for tangent, d in ((Kacc, 0), (Cacc, 1), (elimination.mass(q, M), 2)):
        stepped = np.array(
            [inertia(*(z + 1j * H * x * (k == d) for k, z in enumerate((q, v, a)))) for x in e]
        )
        assert abs(tangent - np.imag(stepped).T / H).max() < 1e-11 * max(1.0, abs(tangent).max())

    def force(q: Array) -> Array:
        return elimination.force(q, K @ m.f(q) + 0.3)

    stepped = np.array([np.imag(force(q + 1j * H * x)) / H for x in e]).T
    found = elimination.stiffness(q, K @ m.f(q) + 0.3, K)
    assert abs(found - stepped).max() < 1e-11 * abs(found).max()


@pytest.mark.parametrize("rotation", [True, False])
def test_a_function_gives_what_the_offset_gives(rotation: bool) -> None:
    name = "offset" if rotation else "hinges"
    given, general = MAPS[name], FunctionCoupling(arms_function(rotation), *MAPS[name].shape)
    q, v, a = rng.normal(size=(3, 6))
    F = rng.normal(size=given.shape[0])
    assert abs(given.f(q) - general.f(q)).max() < 1e-14
    assert abs(given.B(q) - general.B(q)).max() < 1e-14
    assert abs(given.B1(q, v) - general.B1(q, v)).max() < 1e-14
    assert abs(given.B2(q, v, a) - general.B2(q, v, a)).max() < 1e-13
    assert abs(given.Kg(q, F) - general.Kg(q, F)).max() < 1e-14


def test_the_offset_as_the_paper_prints_it() -> None:
    """Eqs. 22 to 25, with the minus in B23'' that print lost."""
    X, Y, th, w, dw = 0.3, -0.2, 0.7, 1.3, -0.4
    m = ArmCoupling(1, np.array([0]), np.array([(X, Y)]))
    q, v, a = (np.array([0.1, 0.2, x]) for x in (th, w, dw))
    c, s = np.cos(th), np.sin(th)
    B13, B23 = -X * s - Y * c, X * c - Y * s
    assert m.B(q) == pytest.approx(np.array([[1, 0, B13], [0, 1, B23], [0, 0, 1]]))
    rate = np.array([w * (-X * c + Y * s), -w * (X * s + Y * c)])
    assert m.B1(q, v)[:2, 2] == pytest.approx(rate)
    A, B = Y * w**2 - X * dw, Y * dw + X * w**2
    assert m.B2(q, v, a)[:2, 2] == pytest.approx(np.array([A * c + B * s, A * s - B * c]))
    F = np.array([2.0, 3.0, 5.0])
    assert m.Kg(q, F)[2, 2] == pytest.approx(-F[0] * B23 + F[1] * B13)
