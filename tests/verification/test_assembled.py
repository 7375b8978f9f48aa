"""Bodies joined by fixed joints vibrate like the finite element model of the whole.

The mechanism is linearised here about rest, independently of the engine's dynamics: the mass
matrices of its bodies, their modal stiffness, and the null space of Cq (complex steps of C).
``N^T K N x = w^2 N^T M N x``. Reducing a body and joining it again is component mode synthesis
(Craig and Bampton, AIAA Journal 6, 1968): with every mode kept the eigenvalues are those of the
whole, with few they lie above it and fall as modes are added (Rayleigh-Ritz).
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.linalg

import jousto as jo
from jousto.model.native.native import displaced

# the structures are linearised, not run
pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will move")

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.06, 0.04)
TEN = 10
ALL = -1


def column(height: float, elements: int) -> jo.Part:
    return jo.Part.beam(height, SECTION, elements, STEEL, name=f"beam of {height:g} m")


def cantilever(pieces: int, modes: int) -> jo.Mechanism:
    """A beam of 2 m along x, clamped at the ground, cut into equal pieces."""
    reduced = piece(2.0 / pieces, 8 // pieces, modes)
    return chain_of([(reduced, jo.Rotate((0, 0, 1), degrees=0.0))] * pieces, last=None)


def portal(pieces: int, modes: int) -> jo.Mechanism:
    """Two columns of 1 m and a beam of 1.5 m, both feet clamped."""
    up, across = piece(1.0, 4, modes), piece(1.5, 6, modes)
    turns = [
        jo.Rotate((0, 1, 0), degrees=-90.0),
        jo.Rotate((0, 0, 1), degrees=0.0),
        jo.Rotate((0, 1, 0), degrees=90.0),
    ]
    parts = list(zip([up, across, up], turns, strict=True))
    assert pieces == len(parts)
    return chain_of(parts, last=jo.ground.at((1.5, 0.0, 0.0)))


@cache
def piece(length: float, elements: int, modes: int) -> jo.ReducedPart:
    inner = 6 * (elements - 1)
    kept = inner if modes == ALL else min(modes, inner)
    method = jo.CraigBampton(interfaces=("start", "end"), modes=kept)
    return jo.reduce(column(length, elements), method)


def chain_of(parts, last):
    bodies, joints = [], []
    at, corner = jo.ground["origin"], np.zeros(3)
    for k, (reduced, turn) in enumerate(parts):
        body = jo.FlexibleBody(f"piece {k}", reduced, position=corner, orientation=turn)
        joints.append(jo.Fixed(f"weld {k}", at, body["start"]))
        at, corner = body["end"], np.asarray(body["end"].r)
        bodies.append(body)
    if last is not None:
        joints.append(jo.Fixed("foot", at, last))
    return jo.Mechanism(*bodies, *joints, name="structure")


def whole(name: str):
    """K, M of the monolithic model without its clamped nodes."""
    if name == "cantilever":
        part = column(2.0, 8)
        clamped = {0}
    else:
        members = [
            jo.Member((0, 0, 0), (0, 0, 1), SECTION, STEEL, 4, orientation=(-1, 0, 0)),
            jo.Member((0, 0, 1), (1.5, 0, 1), SECTION, STEEL, 6, orientation=(0, 0, 1)),
            jo.Member((1.5, 0, 1), (1.5, 0, 0), SECTION, STEEL, 4, orientation=(1, 0, 0)),
        ]
        part = jo.Part.from_members(members)
        clamped = {int(i) for i in np.flatnonzero(np.abs(part.nodes[:, 2]) < 1e-9)}
    keep = [6 * i + j for i in range(len(part.nodes)) if i not in clamped for j in range(6)]
    cut = np.ix_(keep, keep)
    return part.K.toarray()[cut], part.M.toarray()[cut]


@cache
def exact(name: str):
    """First ten natural frequencies of the whole, Hz."""
    K, M = whole(name)
    return np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[:TEN]) / (2 * np.pi)


def linear_frequencies(mechanism: jo.Mechanism):
    """Natural frequencies at rest, Hz, from M, K and the null space of Cq."""
    model = jo.compile(mechanism)
    engine = jo.model.Engine(model)
    M, K = np.zeros((model.nv, model.nv)), np.zeros(model.nv)
    for k, body in enumerate(model.bodies):
        own = slice(body.iv, body.iv + 6 + body.n)
        M[own, own] = engine.mass_matrix(k)
        # its first three coordinates are resolved in the body frame, the increments are not
        A = np.asarray(mechanism.bodies[k].orientation)
        turn = np.eye(6 + body.n)
        turn[:3, :3] = rotation(A).T
        M[own, own] = turn.T @ M[own, own] @ turn
        K[body.iv + 6 : body.iv + 6 + body.n] = body.K
    steps = jo.model.Engine(model, complex_scalars=True)
    Cq = np.zeros((model.nrow, model.nv))
    for j in range(model.nv):
        increment = np.zeros(model.nv, complex)
        increment[j] = 1e-30j
        steps.q[:] = displaced(model, model.q0, increment)
        Cq[:, j] = steps.constraints()[0].imag / 1e-30
    N = scipy.linalg.null_space(Cq, rcond=1e-10)
    assert N.shape[1] == model.nv - np.linalg.matrix_rank(Cq)
    values = scipy.linalg.eigh(N.T @ (K[:, None] * N), N.T @ M @ N, eigvals_only=True)
    return np.sqrt(values[:TEN]) / (2 * np.pi)


def rotation(e):
    w = np.array([[0, -e[3], e[2]], [e[3], 0, -e[1]], [-e[2], e[1], 0]])
    return np.eye(3) + 2 * e[0] * w + 2 * w @ w


CASES = {"cantilever": (cantilever, 2), "portal": (portal, 3)}


@pytest.mark.parametrize("name", CASES)
def test_with_all_modes_the_structure_is_the_whole(name):
    build, pieces = CASES[name]
    found = linear_frequencies(build(pieces, ALL))
    np.testing.assert_allclose(found, exact(name), rtol=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_modes_of_the_mechanism_are_those_of_the_whole(name):
    build, pieces = CASES[name]
    found = jo.modes(jo.compile(build(pieces, ALL)))
    np.testing.assert_allclose(found.frequencies[:TEN], exact(name), rtol=1e-6)
    np.testing.assert_allclose(found.damping[:TEN], 0.0, atol=1e-8)


def test_the_number_of_cuts_does_not_matter():
    found = linear_frequencies(cantilever(4, ALL))
    np.testing.assert_allclose(found, exact("cantilever"), rtol=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_few_modes_converge_from_above(name):
    build, pieces = CASES[name]
    curve = [linear_frequencies(build(pieces, modes)) / exact(name) - 1 for modes in (0, 2, 4, 8)]
    errors = np.array(curve)
    assert errors.min() > -1e-8
    assert np.all(np.diff(errors, axis=0) < 1e-8)


def test_the_first_frequency_of_the_cantilever_is_the_beam_s():
    # Blevins (1979), table 8-1: (1.87510407 / L)^2 sqrt(E I / (rho A)) / (2 pi), slender beam
    I, A = 0.06 * 0.04**3 / 12, 0.06 * 0.04
    exact_hz = (1.87510407 / 2.0) ** 2 * np.sqrt(STEEL.E * I / (STEEL.rho * A)) / (2 * np.pi)
    found = linear_frequencies(cantilever(2, ALL))[0]
    # shear and rotary inertia lower it by about (h / L)^2
    assert -1e-3 < found / exact_hz - 1 < 0
