"""Criteria of tensors against their definitions, by numpy's eigenvalues."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.model.native import recover
from jousto.recovery.fields.criteria import (
    criteria,
    evaluate,
    principal,
    principal_values,
    rotate_tensors,
    tensor,
    voigt,
)
from jousto.recovery.fields.kernels import kernel
from jousto.recovery.fields.planes import critical_plane, half_sphere, plane_weights
from jousto.reduction.fields.stress import StressModes

Array = NDArray[np.float64]


def rotations(rng: np.random.Generator, count: int) -> Array:
    return np.array([np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(count)])


def stated(s: Array, criterion: str, strain: bool) -> Array:
    """The criteria as the documentation states them."""
    T = tensor(s, strain)
    low, middle, high = np.moveaxis(np.linalg.eigvalsh(T), -1, 0)
    signed = np.where(high + low >= 0.0, high, low)
    D = T - np.trace(T, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
    mises = np.sqrt((2.0 / 3.0 if strain else 1.5) * np.sum(D * D, axis=(-2, -1)))
    return {
        "von-mises": mises,
        "signed-von-mises": np.sign(signed) * mises,
        "principal-1": high,
        "principal-2": middle,
        "principal-3": low,
        "signed-principal": signed,
        "max-shear": (high - low) * (1.0 if strain else 0.5),
    }[criterion]


@pytest.mark.parametrize("strain", [False, True])
def test_every_criterion_is_what_it_says(rng: np.random.Generator, strain: bool) -> None:
    # sites that fill no tile, instants that fill no chunk, sizes of stress and of strain
    ns, n, nt = 21, 7, 70
    S = rng.normal(size=(ns, 6, n)) * (1e-6 if strain else 1e8)
    eye = np.broadcast_to(np.eye(3), (ns, 3, 3))
    modes = StressModes(tuple(f"n{i}" for i in range(ns)), np.zeros((ns, 3)), eye, S)
    p = rng.normal(size=(nt, n))
    field = jo.recovery.StressField("body", modes, p, np.arange(nt, dtype=float), strain=strain)
    s = np.einsum("scj,tj->tsc", S, p)
    scale = np.abs(s).max()
    for criterion in criteria(strain):
        found = field.values(criterion)
        if criterion[1:].isdigit():
            names = ("11", "22", "33", "12", "23", "13")
            half = 0.5 if criterion in ("e12", "e23", "e13") else 1.0
            expected = half * s[..., names.index(criterion[1:])]
        else:
            expected = stated(s, criterion, strain)
        np.testing.assert_allclose(found, expected, atol=1e-13 * scale, err_msg=criterion)
        np.testing.assert_allclose(
            evaluate(s, criterion, strain), expected, atol=1e-13 * scale, err_msg=criterion
        )
        # some places of another order
        some = field.take([20, 3, 7]).values(criterion)
        np.testing.assert_allclose(some, expected[:, [20, 3, 7]], atol=1e-13 * scale)
        envelope = field.envelope(criterion)
        np.testing.assert_allclose(envelope.max, expected.max(axis=0), atol=1e-13 * scale)
        np.testing.assert_allclose(envelope.min, expected.min(axis=0), atol=1e-13 * scale)
    normal = np.array([1.0, -2.0, 0.5])
    along = np.einsum("i,tsij,j->ts", normal, tensor(s, strain), normal) / (normal @ normal)
    np.testing.assert_allclose(field.values(jo.recovery.Plane(normal)), along, atol=1e-13 * scale)


@pytest.mark.parametrize("strain", [False, True])
def test_the_sign_of_opposite_principal_values_is_positive(
    rng: np.random.Generator, strain: bool
) -> None:
    """Pure shear in any axes: rounding would choose the sign. A sum of 1e-6 of them decides it."""
    for share, sign in ((0.0, 1.0), (1e-6, 1.0), (-1e-6, -1.0)):
        first = 1.0 + share
        states = np.array([[first, middle, -1.0] for middle in (0.0, 0.3, -0.9, -1.0, first)])
        Q = rotations(rng, 40)
        T = np.einsum("aij,sj,akj->saik", Q, 1e8 * states, Q)
        s = voigt(0.5 * (T + np.swapaxes(T, 2, 3)), strain).reshape(-1, 6)
        for criterion in ("signed-von-mises", "signed-principal"):
            by_engine = kernel(s[:, :, None], criterion, strain).values(np.ones((1, 1)))[0]
            for found in (evaluate(s, criterion, strain), by_engine):
                np.testing.assert_array_equal(np.sign(found), sign, err_msg=criterion)


def test_principal_values_close_to_one_another(rng: np.random.Generator) -> None:
    gaps = (0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-3)
    states = [
        base
        for g in gaps
        for base in ((5, 1 + g, 1), (1, 1 - g, -5), (1 + g, 1, 1 - g), (g, 0, 0), (-3, -3, -3 - g))
    ]
    Q = rotations(rng, 10)
    T = np.array([R @ np.diag(x) @ R.T for x in states for R in Q])
    s = voigt(0.5 * (T + np.swapaxes(T, 1, 2)))
    exact = np.array([sorted(x, reverse=True) for x in states for _ in Q])
    size = np.maximum(np.abs(exact).max(axis=1, keepdims=True), 1e-300)
    values, directions = principal(s)
    # all digits, also of equal values: the plain cubic formula leaves half of them
    assert np.max(np.abs(values - exact) / size) < 4e-15
    residual = tensor(s) @ directions - directions * values[:, None, :]
    assert np.max(np.abs(residual) / size[:, :, None]) < 4e-15
    square = np.swapaxes(directions, 1, 2) @ directions
    np.testing.assert_allclose(square, np.broadcast_to(np.eye(3), square.shape), atol=4e-15)


@pytest.mark.parametrize("size", [1e-140, 1e-6, 1.0, 1e9, 1e60])
def test_principal_values_of_any_size(rng: np.random.Generator, size: float) -> None:
    s = size * rng.normal(size=(40, 6))
    expected = np.linalg.eigvalsh(tensor(s))[:, ::-1]
    np.testing.assert_allclose(principal_values(s), expected, atol=1e-14 * size)


def test_simple_states() -> None:
    for s in np.vstack([np.zeros(6), np.eye(6), -np.eye(6), [[7, 7, 7, 0, 0, 0]]]):
        values, directions = principal(s)
        np.testing.assert_allclose(values, np.linalg.eigvalsh(tensor(s))[::-1], atol=1e-15)
        np.testing.assert_allclose(tensor(s) @ directions, directions * values, atol=1e-15)


def test_turning_keeps_invariants(rng: np.random.Generator) -> None:
    s, Q = rng.normal(size=(30, 6)), rotations(rng, 30)
    for strain in (False, True):
        for criterion in criteria()[:7]:
            np.testing.assert_allclose(
                evaluate(rotate_tensors(s, Q, strain), criterion, strain),
                evaluate(s, criterion, strain),
                atol=1e-13,
            )


def test_largest_normal_stress_of_all_planes(rng: np.random.Generator) -> None:
    s, t = rng.normal(size=(60, 6)), np.linspace(0.0, 1.0, 60)
    plane = critical_plane(s, t)
    assert plane.value == pytest.approx(np.linalg.eigvalsh(tensor(s)).max(), rel=1e-13)
    over = s @ plane_weights(plane.normal)
    assert plane.value == pytest.approx(over.max(), rel=1e-12)
    assert t[over.argmax()] == plane.time and t[over.argmin()] == plane.minimum_time


@pytest.mark.parametrize("strain", [False, True])
def test_largest_range_of_all_planes(rng: np.random.Generator, strain: bool) -> None:
    """The range is the largest principal value of all differences of two instants."""
    for _ in range(20):
        s, t = rng.normal(size=(40, 6)), np.arange(40.0)
        pairs = tensor(s[:, None] - s[None, :], strain)
        truth = np.linalg.eigvalsh(pairs)[..., 2].max()
        plane = critical_plane(s, t, by="range", strain=strain)
        assert plane.value == pytest.approx(truth, rel=1e-12)
        over = s @ plane_weights(plane.normal, strain)
        assert plane.value == pytest.approx(np.ptp(over), rel=1e-12)
        assert t[over.argmax()] == plane.time


def test_half_sphere_leaves_no_gap(rng: np.random.Generator) -> None:
    x = rng.normal(size=(5000, 3))
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    nearest = np.abs(x @ half_sphere().T).max(axis=1)
    assert np.degrees(np.arccos(nearest.min())) < 8.0


def test_critical_plane_of_a_field(rng: np.random.Generator) -> None:
    modes = StressModes(
        ("a", "b"), np.zeros((2, 3)), np.array([np.eye(3)] * 2), np.zeros((2, 6, 1))
    )
    S = np.zeros((2, 6, 1))
    S[1] = np.array([[1.0], [1], [0], [1], [0], [0]])  # 2 along (1, 1, 0), nothing across
    modes = StressModes(modes.labels, modes.positions, modes.axes, S)
    field = jo.recovery.field_from(modes, [[1.0], [-3.0], [2.0]], [0.0, 1.0, 2.0])
    plane = field.critical_plane("b", by="range")
    assert plane.value == pytest.approx(10.0)
    np.testing.assert_allclose(np.abs(plane.normal), [0.5**0.5, 0.5**0.5, 0], atol=1e-9)
    assert (plane.time, plane.minimum_time) == (2.0, 1.0)
    assert field.critical_plane("b").value == pytest.approx(4.0)
    assert [p.value for p in field.critical_planes(by="range")] == pytest.approx([0.0, 10.0])
    with pytest.raises(jo.InputError, match="site has 2 sites, must be one"):
        field.critical_plane(["a", "b"])
    with pytest.raises(jo.InputError, match="by is 'damage'"):
        field.critical_plane("b", by="damage")  # type: ignore[arg-type]


def test_tiles_hold_every_row_once(rng: np.random.Generator) -> None:
    rows = rng.normal(size=(11, 3, 4))
    packed = recover.tiles(rows)
    assert packed.shape == (2, 4, 3, 8)
    for i in range(11):
        np.testing.assert_array_equal(packed[i // 8, :, :, i % 8].T, rows[i])
    assert not packed[1, :, :, 3:].any()
