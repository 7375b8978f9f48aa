"""Denavit-Hartenberg tables: the products of the textbooks."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.robots import DHRow, Tree, from_dh, mechanism

TABLE = np.array([[0.3, 0.5, 0.2, 0.1], [0.0, -1.2, 0.4, -0.7], [0.25, np.pi / 2, -0.1, 0.3]])


def matrix(row: np.ndarray, convention: str) -> np.ndarray:
    a, al, d, th = row
    c, s, ca, sa = np.cos(th), np.sin(th), np.cos(al), np.sin(al)
    if convention == "standard":  # Spong, Hutchinson, Vidyasagar (2006), eq. 3.10
        return np.array(
            [
                [c, -s * ca, s * sa, a * c],
                [s, c * ca, -c * sa, a * s],
                [0, sa, ca, d],
                [0, 0, 0, 1],
            ]
        )
    return np.array(  # Craig, 3rd ed., eq. 3.6
        [
            [c, -s, 0, a],
            [s * ca, c * ca, -sa, -sa * d],
            [s * sa, c * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_the_product_of_the_matrices(convention: str) -> None:
    rows = [
        DHRow(a, al, d, th, kind=kind)
        for (a, al, d, th), kind in zip(TABLE, ("revolute", "prismatic", "revolute"), strict=True)
    ]
    tree = Tree(from_dh(rows, convention=convention))
    q = np.array([0.7, 0.15, -1.1])
    moved = TABLE.copy()
    moved[[0, 1, 2], [3, 2, 3]] += q
    T = np.eye(4)
    for i, row in enumerate(moved):
        T = T @ matrix(row, convention)
        at = tree.pose(f"link{i + 1}", q)
        # products of some numbers of size 1
        np.testing.assert_allclose(at.r, T[:3, 3], atol=1e-14)
        np.testing.assert_allclose(at.A, T[:3, :3], atol=1e-14)
    h = 1e-6
    J = tree.jacobian("link3", q)
    for k in range(3):
        ahead, behind = (tree.pose("link3", q + s * h * np.eye(3)[k]) for s in (1, -1))
        # the error of the difference is of the order h^2, its rounding 1e-10
        np.testing.assert_allclose((ahead.r - behind.r) / (2 * h), J[:3, k], atol=1e-9)


def test_both_conventions_describe_the_same_arm() -> None:
    m, r = 2.0, 0.5
    near = DHRow(1.0, 0.0, mass=m, center=(-r, 0, 0), inertia=(0.1, 0.2, 0.3))
    far = DHRow(0.0, 0.0, mass=m, center=(r, 0, 0), inertia=(0.1, 0.2, 0.3))
    rest = DHRow(1.0, 0.0, mass=m, center=(r, 0, 0), inertia=(0.1, 0.2, 0.3))
    one = Tree(from_dh([near, near], convention="standard"))
    two = Tree(from_dh([far, rest], convention="modified"))
    q, v = [0.3, -0.8], [1.0, 2.0]
    np.testing.assert_allclose(one.mass_matrix(q), two.mass_matrix(q), atol=1e-14)
    np.testing.assert_allclose(one.bias_forces(q, v), two.bias_forces(q, v), atol=1e-13)
    run = jo.simulate(jo.compile(mechanism(from_dh([near, near], convention="standard"))), 0.01)
    assert run.sensors == ("joint1", "joint2") or set(run.sensors) == {"joint1", "joint2"}


def test_wrong_tables_are_told() -> None:
    with pytest.raises(jo.InputError) as error:
        from_dh(
            [(1, 2, 3), DHRow(1, float("nan")), DHRow(0, 0, kind="ball", lower=1, upper=0)],
            convention="craig",
        )
    for part in (
        "convention is 'craig', must be 'standard' or 'modified'",
        "rows[0]: (a, alpha, d, theta) has shape (3,), must be (4)",
        "rows[1]: alpha is nan rad",
        "rows[2]: kind is 'ball'",
        "rows[2]: lower limit 1 is above the upper limit 0",
    ):
        assert part in str(error.value)
    with pytest.raises(jo.InputError, match="have a mass, which a mechanism needs"):
        mechanism(from_dh(TABLE, convention="standard"))
