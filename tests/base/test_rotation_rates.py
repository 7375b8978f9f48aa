"""Rates of rotation parameters and angular velocities: derivatives, inverses, poles."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.base.arrays import Array, skew
from jousto.base.complexstep import stepping
from jousto.base.rotations import exp_rotation, rotation_matrix

ALL = [
    "".join(x)
    for letters in ("XYZ", "xyz")
    for x in itertools.product(letters, repeat=3)
    if x[0] != x[1] != x[2]
]
velocity_matrix, rate_matrix = jo.mechanism.velocity_matrix, jo.mechanism.rate_matrix


def euler_matrix(angles: Array, convention: str) -> Array:
    """A of angles, which may be complex, by the definition in `Rotate.euler`."""
    turns = [
        exp_rotation(x * np.eye(3)["XYZ".index(axis)])
        for x, axis in zip(angles, convention.upper(), strict=True)
    ]
    a, b, c = turns if convention.isupper() else turns[::-1]
    return a @ b @ c


def test_the_derivative_of_a_by_euler_parameters(rng: np.random.Generator) -> None:
    """``A' = A skew(G e')`` with A' by a complex step, e' along the unit sphere."""
    for _ in range(20):
        e, rate = rng.normal(size=(2, 4))
        e /= np.linalg.norm(e)
        rate -= e * (e @ rate)
        A = rotation_matrix(e)
        with stepping():
            slope = rotation_matrix(e + 1e-30j * rate).imag / 1e-30
        np.testing.assert_allclose(slope, A @ skew(velocity_matrix(e) @ rate), atol=1e-14)
        np.testing.assert_allclose(rate_matrix(e) @ (velocity_matrix(e) @ rate), rate, atol=1e-14)


@pytest.mark.parametrize("convention", ALL)
def test_the_derivative_of_a_by_angles(convention: str, rng: np.random.Generator) -> None:
    """All 24 conventions; the matrix itself is scipy's."""
    for _ in range(5):
        angles, rate = rng.uniform(0.2, 1.2, 3), rng.normal(size=3)
        A = euler_matrix(angles, convention)
        np.testing.assert_allclose(
            A, Rotation.from_euler(convention, angles).as_matrix(), atol=1e-14
        )
        with stepping():
            slope = euler_matrix(angles + 1e-30j * rate, convention).imag / 1e-30
        G = velocity_matrix(angles, convention)
        np.testing.assert_allclose(slope, A @ skew(G @ rate), atol=1e-14)
        np.testing.assert_allclose(G @ rate_matrix(angles, convention), np.eye(3), atol=1e-13)


def test_rates_along_a_run(rng: np.random.Generator) -> None:
    """Arrays of parameters give arrays of matrices."""
    e = rng.normal(size=(5, 2, 4))
    e /= np.linalg.norm(e, axis=-1, keepdims=True)
    angles = rng.uniform(0.2, 1.2, (5, 2, 3))
    assert velocity_matrix(e).shape == (5, 2, 3, 4)
    assert rate_matrix(e).shape == (5, 2, 4, 3)
    for convention in ("ZXZ", "xyz"):
        G, H = velocity_matrix(angles, convention), rate_matrix(angles, convention)
        np.testing.assert_array_equal(G[3, 1], velocity_matrix(angles[3, 1], convention))
        np.testing.assert_allclose(H[3, 1], rate_matrix(angles[3, 1], convention), atol=1e-14)


def test_a_tumbling_body_turns_with_the_matrix() -> None:
    """The engine's Euler parameters: ``e' = H w'`` of a tumbling body, by differences."""
    body = jo.RigidBody("body", 1.0, (1.0, 2.0, 2.5), angular_velocity=(0.3, 2.0, 0.1))
    h = 1e-3
    ball = jo.Spherical("ball", jo.ground["origin"], body["origin"])
    run = jo.simulate(jo.compile(jo.Mechanism(body, ball)), 1.0, solver=jo.RK4(h), output_step=h)
    q, v = run.states()
    e, w = q[:, 3:7], v[:, 3:6]
    slope = (e[2:] - e[:-2]) / (2 * h)
    found = np.einsum("tij,tj->ti", rate_matrix(e), w)[1:-1]
    np.testing.assert_allclose(found, slope, atol=2 * h**2)


@pytest.mark.parametrize(
    ("convention", "b", "pole"),
    [
        ("ZXZ", 0.0, "0 deg"),
        ("zyz", np.pi - 1e-7, "180 deg"),
        ("ZYX", -np.pi / 2, "-90 deg"),
        ("xyz", np.pi / 2 + 1e-8, "90 deg"),
        ("XYZ", 7.5 * np.pi, "1350 deg"),
    ],
)
def test_the_inverse_is_refused_at_the_pole(convention: str, b: float, pole: str) -> None:
    with pytest.raises(jo.InputError) as error:
        rate_matrix([[0.1, 0.5, 0.2], [0.1, b, 0.2]], convention)
    text = str(error.value)
    assert f"middle angle of '{convention}' is {np.degrees(b):.9g} deg" in text
    assert f"the pole at {pole}," in text
    assert velocity_matrix([0.1, b, 0.2], convention).shape == (3, 3)
    # beside the pole there is an inverse
    rate_matrix([0.1, b + 1e-5, 0.2], convention)


@pytest.mark.parametrize(
    ("e", "convention", "message"),
    [
        ((1.0, 0.0, 0.0), None, "three angles need their convention"),
        ((1.0, 0.0, 0.0, 0.0), "ZXZ", "must be three angles"),
        ((2.0, 0.0, 0.0, 0.0), None, "has length 2"),
        ((0.1, np.nan, 0.0), "ZXZ", "not finite"),
        ((0.1, 0.2, 0.3), "ZZX", "neighbours different"),
        ((0.1, 0.2, 0.3), "313", "did you mean 'ZXZ'"),
        ("abc", "ZXZ", "is 'abc'"),
        (1.0, None, "must be four"),
        (None, None, "must be four"),
    ],
)
def test_wrong_parameters_are_named(e: object, convention: str | None, message: str) -> None:
    for function in (velocity_matrix, rate_matrix):
        with pytest.raises(jo.InputError, match=message):
            function(e, convention)  # type: ignore[arg-type]
