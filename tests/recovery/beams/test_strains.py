"""Strains and resultants of beam elements: laws, an independent energy, closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from jousto.recovery.beams.strains import (
    Elements,
    Poses,
    end_resultants,
    poses,
    rates,
    resultants,
    strains,
)

RNG = np.random.default_rng(5)
POLAR = 0.3  # Ip/A of elements that are not plain, m2


def skew(v):
    return np.array([[0 * v[0], -v[2], v[1]], [v[2], 0 * v[0], -v[0]], [-v[1], v[0], 0 * v[0]]])


def stiffness(rng) -> np.ndarray:
    X = rng.standard_normal((6, 6))
    return X @ X.T + 6.0 * np.eye(6)


def beam_of(n: int, *, L=None, helical: float = 0.0, offsets: bool = True) -> Elements:
    frames = Rotation.random(2 * n, random_state=1).as_matrix().reshape(2, n, 3, 3)
    if not offsets:
        frames[:] = np.eye(3)
    return Elements(
        L=np.full(n, 0.7) if L is None else L,
        ua=0.1 * RNG.standard_normal((n, 3)) * offsets,
        Ba=frames[0],
        ub=0.1 * RNG.standard_normal((n, 3)) * offsets,
        Bb=frames[1]
        if not offsets
        else frames[0] @ Rotation.from_rotvec([0.2, -0.4, 0.3]).as_matrix(),
        C=np.stack([stiffness(RNG) for _ in range(n)]),
        e0=0.1 * RNG.standard_normal((n, 6)),
        beta=np.full(n, 0.03),
        helical=np.full((n, 1), helical),
        polar=np.full(n, POLAR * offsets),
    )


def nodes_of(n: int, bend: float = 0.5):
    """Return positions and axes of n + 1 nodes in a crooked row."""
    turns = Rotation.from_rotvec(bend * RNG.standard_normal((n + 1, 3))).as_matrix()
    A = [turns[0]]
    for T in turns[1:]:
        A.append(A[-1] @ T)
    R = np.cumsum(RNG.standard_normal((n + 1, 3)), axis=0)
    return R, np.array(A)


def energy(L, C, e0, ra, Qa, rb, Qb, helical):
    """Return L/2 e^T C e of one element, written out for complex numbers."""
    T = Qa.T @ Qb
    angle = np.arccos(0.5 * (np.trace(T) - 1.0))
    vee = np.array([T[2, 1] - T[1, 2], T[0, 2] - T[2, 0], T[1, 0] - T[0, 1]])
    phi = angle / (2.0 * np.sin(angle)) * vee
    Qm = Qa @ expm(0.5 * skew(phi))
    d = Qm.T @ (rb - ra) / L
    if helical:
        # the chord of a screw motion: d = (integral of exp(x phi) over -1/2..1/2) Gamma
        x, w = np.polynomial.legendre.leggauss(12)
        mean = sum(0.5 * wi * expm(0.5 * xi * skew(phi)) for xi, wi in zip(x, w, strict=True))
        d = np.linalg.solve(mean, d)
    e = np.concatenate([d - [1, 0, 0], phi / L]) - e0
    e[0] += 0.5 * POLAR * ((phi[0] / L) ** 2 - e0[3] ** 2)
    return 0.5 * L * e @ C @ e


@pytest.mark.parametrize("helical", [0.0, 1.0])
def test_ends_carry_the_gradient_of_the_energy(helical: float) -> None:
    """Complex step of an energy that is written out anew, at large strains and rotations."""
    beam = beam_of(1, helical=helical)
    R, A = nodes_of(1)
    at = poses(beam, R, A)
    found = strains(beam, at)
    s = resultants(beam, found.e)
    ends = end_resultants(found, s)[0]
    ra, rb, Qa, Qb = at.ra[0], at.rb[0], at.Qa[0], at.Qb[0]

    def slope(k: int, end: int, turn: bool) -> float:
        h = 1e-30j * np.eye(3)[k]
        moved = [ra + 0j, Qa + 0j, rb + 0j, Qb + 0j]
        place = 2 * end + (1 if turn else 0)
        moved[place] = (np.eye(3) + skew(h)) @ moved[place] if turn else moved[place] + h
        return energy(0.7, beam.C[0], beam.e0[0], *moved, helical).imag / 1e-30

    for end, (Q, sign) in enumerate(((Qa, -1.0), (Qb, 1.0))):
        force = sign * Q.T @ [slope(k, end, False) for k in range(3)]
        moment = sign * Q.T @ [slope(k, end, True) for k in range(3)]
        assert ends[end, :3] == pytest.approx(force, rel=1e-10, abs=1e-10)
        assert ends[end, 3:] == pytest.approx(moment, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("helical", [0.0, 1.0])
def test_rigid_motion_changes_nothing(helical: float) -> None:
    beam = beam_of(5, helical=helical)
    R, A = nodes_of(5)
    found = strains(beam, poses(beam, R, A))
    T = Rotation.random(random_state=3).as_matrix()
    moved = strains(beam, poses(beam, R @ T.T + [3.0, -2.0, 1.0], T @ A))
    assert moved.e == pytest.approx(found.e, abs=1e-13)


@pytest.mark.parametrize("helical", [0.0, 1.0])
def test_rates_are_the_derivative_of_the_strains(helical: float) -> None:
    beam = beam_of(4, helical=helical)
    R, A = nodes_of(4)
    V, W = RNG.standard_normal((2, 5, 3))

    def at(t: float) -> Poses:
        turn = Rotation.from_rotvec(t * W).as_matrix()
        return poses(beam, R + t * V, turn @ A)

    h, here = 1e-5, at(0.0)
    found = strains(beam, here)
    slope = (strains(beam, at(h)).e - strains(beam, at(-h)).e) / (2.0 * h)
    va = V[:-1] + np.cross(W[:-1], np.einsum("nij,nj->ni", A[:-1], beam.ua))
    vb = V[1:] + np.cross(W[1:], np.einsum("nij,nj->ni", A[1:], beam.ub))
    slip = vb - va + np.cross(here.rb - here.ra, W[:-1])
    rate = rates(beam, found, here.Qa, slip, W[1:] - W[:-1])
    assert rate == pytest.approx(slope, rel=1e-7, abs=1e-7)
    damped = resultants(beam, found.e, rate)
    assert damped == pytest.approx(
        np.einsum("nij,nj->ni", beam.C, found.e + 0.03 * rate), rel=1e-12
    )


def test_circle_of_any_number_of_elements() -> None:
    """A straight beam bent to a circle by 2 pi EI / L: one curvature, no stretch of its helix."""
    for n in (3, 8, 500):
        L, EI = 2.0, 30.0
        beam = beam_of(n, L=np.full(n, L / n), helical=1.0, offsets=False)
        beam.e0[:] = 0.0
        beam.C[:] = np.diag([1e5, 1e4, 1e4, 20.0, EI, EI])
        angle = np.linspace(0.0, 2.0 * np.pi, n + 1)
        radius = L / (2.0 * np.pi)
        R = radius * np.stack([np.sin(angle), 1.0 - np.cos(angle), 0 * angle], axis=1)
        A = Rotation.from_rotvec(angle[:, None] * [0.0, 0.0, 1.0]).as_matrix()
        found = strains(beam, poses(beam, R, A))
        s = resultants(beam, found.e)
        assert s[:, 5] == pytest.approx(2.0 * np.pi * EI / L, rel=1e-11)
        assert found.e[:, :3] == pytest.approx(0.0, abs=1e-12)
        ends = end_resultants(found, s)
        assert ends[..., 5] == pytest.approx(2.0 * np.pi * EI / L, rel=1e-9)


def test_small_rotations_lose_no_digits() -> None:
    """Series and closed forms of the coefficients agree where they meet."""
    beam = beam_of(1, helical=1.0, offsets=False)
    force = RNG.standard_normal((1, 6))
    for angle in (1e-3, 0.02, 0.1):
        pair = []
        for factor in (1.0 - 1e-9, 1.0 + 1e-9):
            T = Rotation.from_rotvec(factor * angle * np.array([0.6, 0.0, 0.8])).as_matrix()
            R = np.array([[0.0, 0, 0], [0.7, 0.1, -0.2]])
            found = strains(beam, poses(beam, R, np.stack([np.eye(3), T])))
            w = np.array([[0.3, -0.2, 0.5]])
            rate = rates(beam, found, np.eye(3)[None], w, w)
            pair.append(np.concatenate([found.e, rate, end_resultants(found, force)[0]]))
        assert pair[0] == pytest.approx(pair[1], rel=1e-7, abs=1e-9)
