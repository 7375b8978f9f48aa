"""Orientations: every form means the same rotation; wrong ones say why."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from jousto.base.arrays import skew
from jousto.base.errors import InputError
from jousto.base.rotations import Rotate, euler_parameters, exp_rotation, rotation_matrix, turn_onto
from jousto.mechanism.bodies.body import RigidBody

number = st.floats(-10, 10)
vector = st.tuples(number, number, number)


def body(orientation: object) -> RigidBody:
    return RigidBody("b", 1.0, (1, 1, 1), orientation=orientation)


@given(vector)
def test_euler_parameters_and_matrix_are_inverse_and_agree_with_scipy(theta):
    expected = Rotation.from_rotvec(theta)
    e = euler_parameters(expected.as_matrix())
    assert abs(np.linalg.norm(e) - 1) < 1e-14
    assert e[0] >= 0
    np.testing.assert_allclose(rotation_matrix(e), expected.as_matrix(), atol=1e-14)


@pytest.mark.parametrize("axis", np.vstack([np.eye(3), -np.eye(3), [[1, 1, 0], [1, -2, 3]]]))
def test_half_turns_are_well_conditioned(axis):
    A = Rotation.from_rotvec(np.pi * axis / np.linalg.norm(axis)).as_matrix()
    np.testing.assert_allclose(rotation_matrix(euler_parameters(A)), A, atol=1e-15)


@given(vector, st.sampled_from([1.0, 1e-3, 1e-9, 1e-200, 0.0]))
def test_exponential_is_the_matrix_exponential(theta, scale):
    theta = scale * np.array(theta)
    np.testing.assert_allclose(exp_rotation(theta), expm(skew(theta)), atol=2e-14)


@given(vector, vector)
def test_turn_onto_is_the_smallest_rotation_onto_the_axis(theta, axis):
    if np.linalg.norm(axis) < 1e-3:
        return
    A = exp_rotation(theta)
    turned = turn_onto(A, axis)
    h = np.array(axis) / np.linalg.norm(axis)
    np.testing.assert_allclose(turned[:, 2], h, atol=1e-11)
    np.testing.assert_allclose(turned.T @ turned, np.eye(3), atol=1e-13)
    # the angle of the turn is the angle between the old and the new z axis
    cosine = (np.trace(turned @ A.T) - 1) / 2
    assert abs(cosine - A[:, 2] @ h) < 1e-12


def test_all_forms_mean_the_same():
    reference = Rotation.from_rotvec(np.radians(40) * np.array([0.6, 0.0, 0.8]))
    forms = [
        reference,
        reference.as_matrix(),
        reference.as_quat(scalar_first=True),
        Rotate((3, 0, 4), degrees=40),
        reference.as_matrix().tolist(),
    ]
    for form in forms:
        np.testing.assert_allclose(
            rotation_matrix(body(form).orientation), reference.as_matrix(), atol=1e-15
        )
    np.testing.assert_array_equal(body(None).orientation, [1, 0, 0, 0])


@pytest.mark.parametrize(
    ("orientation", "sentence"),
    [
        ([1, 0, 0], "orientation has shape (3,); must be four Euler parameters"),
        ("north", "orientation is 'north'; must be four Euler parameters"),
        ([2, 0, 0, 0], "orientation [2.0, 0.0, 0.0, 0.0] has length 2; Euler parameters"),
        ([1, 0, 0, np.nan], "orientation is [1.0, 0.0, 0.0, nan], must be finite"),
        (2 * np.eye(3), "columns are not orthonormal (largest error of A^T A is 3.0e+00)"),
        (np.diag([1, 1, -1]), "orientation is a reflection (determinant -1)"),
    ],
)
def test_wrong_orientations_say_why(orientation, sentence):
    with pytest.raises(InputError) as error:
        body(orientation)
    assert sentence in str(error.value)


def test_rotate_needs_an_axis_and_a_finite_angle():
    with pytest.raises(InputError) as error:
        Rotate((0, 0, 0), degrees=np.inf)
    assert [p.message for p in error.value.problems] == [
        "degrees is inf, must be finite",
        "axis is (0, 0, 0), must have a direction",
    ]


def test_the_length_of_an_axis_does_not_matter_however_extreme():
    for size in (1e-149, 1e-3, 1e300):
        axis = size * np.array([2.0, -1.0, 2.0])
        e = Rotate(axis, degrees=180).euler_parameters
        np.testing.assert_allclose(e, [0, 2 / 3, -1 / 3, 2 / 3], atol=1e-15)
        np.testing.assert_allclose(turn_onto(np.eye(3), axis)[:, 2], e[1:], atol=1e-15)


def test_an_axis_too_short_for_a_direction():
    with pytest.raises(InputError) as error:
        Rotate((1e-300, 0, 0), degrees=90)
    assert error.value.problems[0].message == "axis is (1e-300, 0, 0), must have a direction"


CONVENTIONS = [a + b + c for a in "XYZ" for b in "XYZ" for c in "XYZ" if a != b != c]


@pytest.mark.parametrize("convention", [*CONVENTIONS, *(c.lower() for c in CONVENTIONS)])
def test_euler_angles_agree_with_scipy(convention):
    for angles in ((0.3, -0.8, 2.9), (0, 0, 0), (np.pi, 0, np.pi), (1.0, np.pi / 2, -1.0)):
        expected = Rotation.from_euler(convention, angles).as_matrix()
        turn = Rotate.euler(convention, radians=angles)
        np.testing.assert_allclose(turn.matrix, expected, atol=1e-15 * 4)
        again = Rotate.euler(convention, degrees=np.degrees(angles))
        np.testing.assert_allclose(again.matrix, expected, atol=1e-15 * 4)


def test_wrong_euler_angles_say_all_that_is_wrong():
    with pytest.raises(InputError) as error:
        Rotate.euler("XxZ", degrees=(1, 2))
    convention, angles = (p.message for p in error.value.problems)
    assert convention.startswith("convention is 'XxZ', must be three axes, neighbours different")
    assert "did you mean" not in convention  # XXZ has equal neighbours
    assert angles == "degrees has shape (2,), must be (3)"
    for wrong, meant in (("321", "ZYX"), ("zXz", "ZXZ")):
        with pytest.raises(InputError, match=f"did you mean '{meant}'"):
            Rotate.euler(wrong, degrees=(1, 2, 3))
    for wrong in (3, None, "ZX", "ABC", ""):
        with pytest.raises(InputError, match="must be three axes"):
            Rotate.euler(wrong, degrees=(1, 2, 3))
    with pytest.raises(InputError, match="give the angles as degrees=... or radians=..., one of"):
        Rotate.euler("ZXZ")
    with pytest.raises(
        InputError, match=r"the angles \(1, 2, 3\) need the name of their unit: deg"
    ):
        Rotate.euler("ZXZ", (1, 2, 3))


def test_the_angle_of_a_turn_has_a_name():
    one, other = Rotate((0, 0, 2), degrees=30), Rotate((0, 0, 2), radians=np.pi / 6)
    np.testing.assert_allclose(one.matrix, other.matrix, atol=1e-15)
    assert (one.radians, other.degrees) == (pytest.approx(np.pi / 6), pytest.approx(30.0))
    with pytest.raises(InputError, match="30 needs the name of its unit: degrees=30 or radians=30"):
        Rotate((0, 0, 1), 30)
    with pytest.raises(InputError, match="degrees=... or radians=..., one of the two"):
        Rotate((0, 0, 1))
    with pytest.raises(InputError, match="one of the two"):
        Rotate((0, 0, 1), degrees=30, radians=0.5)
