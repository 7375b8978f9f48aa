"""Rotation matrices and Euler parameters of many rotations at once."""

from __future__ import annotations

import numpy as np

from jousto.base.rotations import euler_parameters, euler_parameters_of, rotation_matrix


def test_many_euler_parameters_are_those_of_each_matrix():
    e = np.random.default_rng(1).normal(size=(200, 4))
    # half turns about each axis and about diagonals: every component is the largest once
    half = [(0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (0, 1, 1, 0), (0, 1, -1, 1), (1, 0, 0, 0)]
    e = np.concatenate([e, half]) / np.linalg.norm(np.concatenate([e, half]), axis=1)[:, None]
    A = rotation_matrix(e)
    found = euler_parameters_of(A)
    assert np.abs(found - [euler_parameters(one) for one in A]).max() < 1e-15
    assert (found[:, 0] >= 0.0).all()
    assert np.abs(rotation_matrix(found) - A).max() < 4e-15
    assert euler_parameters_of(np.zeros((0, 3, 3))).shape == (0, 4)
