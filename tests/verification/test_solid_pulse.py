"""A clamped solid hit by a pulse: the reduced body in the engine against the full mesh.

The full model is the exact sum over all modes of the clamped finite element matrices; the pulse is
a triangle, for which every mode has a closed form. The reduced body is simulated as a user would:
fixed to the ground at an interface, a force at a node.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigh

import jousto as jo
from verification import bricks
from verification.boxes import block
from verification.solids import dofs, solid

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
LENGTH = 0.3
FORCE = np.array([0.0, 10.0, 20.0])  # N: the tip moves by a few micrometres
RISE, T_END = 2e-4, 4e-3  # s
ROWS = 200
COUNTS = (2, 4, 8, 16)


def bent(x):
    """A bar that narrows and turns aside: bending and torsion are coupled."""
    t = x[:, 0] / LENGTH
    y, z = x[:, 1] * (1.0 - 0.5 * t), x[:, 2] * (1.0 + 0.3 * t)
    return np.stack([x[:, 0], y + 0.06 * t**2, z + 0.02 * t * y / 0.04], axis=1)


GRID = block("hexahedron20", (LENGTH, 0.04, 0.02), (6, 1, 1), bend=bent)
CLAMP = np.flatnonzero(GRID.nodes[:, 0] < 1e-9)
HIT = int(np.argmax(GRID.nodes @ [1.0, 1.0, 1.0]))
ROOT = int(np.argmin(np.linalg.norm(GRID.nodes - [0.1, 0.007, 0.0], axis=1)))  # stress there
MIDDLE = int(np.argmin(np.linalg.norm(GRID.nodes - GRID.nodes.mean(axis=0), axis=1)))


@cache
def full():
    """All clamped modes (ndof, k), their w (k,), from the matrices of the mesh."""
    K, M = bricks.stiffness(GRID, STEEL), bricks.mass(GRID, STEEL)
    free = np.setdiff1d(np.arange(K.shape[0]), dofs(CLAMP))
    square, shapes = eigh(K[free][:, free].toarray(), M[free][:, free].toarray())
    X = np.zeros((K.shape[0], len(free)))
    X[free] = shapes
    return X, np.sqrt(square)


@cache
def part():
    """The bar with its interface and named nodes."""
    sets = {"hit": [HIT], "middle": [MIDDLE]}
    return solid(GRID, STEEL, sets).with_interfaces(jo.Interface("clamp", CLAMP))


def coordinates(times, count=None):
    """Amplitudes (nt, k) of the first clamped modes."""
    X, w = full()
    X, w = X[:, :count], w[:count]
    load = X[3 * HIT : 3 * HIT + 3].T @ FORCE

    def ramp(t):
        # p'' + w^2 p = t from rest
        t = np.maximum(t, 0.0)[:, None]
        return (t - np.sin(w * t) / w) / w**2

    return (ramp(times) - 2.0 * ramp(times - RISE) + ramp(times - 2.0 * RISE)) / RISE * load


def history(times, count=None):
    """Displacements (nt, 2, 3) of the hit and the middle node from the first modes."""
    X = full()[0][dofs([HIT, MIDDLE]), :count]
    return (coordinates(times, count) @ X.T).reshape(-1, 2, 3)


def simulated(method):
    """Times, displacements (nt, 2, 3), stress (nt, 6) at the root, and the reduced part."""
    reduced = jo.reduce(part(), method)
    body = jo.FlexibleBody("bar", reduced)
    pulse = jo.Table([0.0, RISE, 2.0 * RISE, 3.0 * RISE], [0.0, 1.0, 0.0, 0.0])
    model = jo.compile(
        jo.Mechanism(
            body,
            jo.Fixed("clamp", jo.ground.at(part().ties[0].at), body["clamp"]),
            jo.Force("blow", body["hit"], FORCE, signal=pulse),
            jo.PositionSensor("hit", body["hit"]),
            jo.PositionSensor("middle", body["middle"]),
        )
    )
    # a whole number of steps for a row, below the stability limit of RK4
    highest = 2.0 * np.pi * reduced.frequencies[-1]
    each = int(np.ceil(T_END / ROWS * highest / 0.7))
    run = jo.simulate(
        model, T_END, solver=jo.RK4(step=T_END / ROWS / each), output_step=T_END / ROWS
    )
    moved = np.stack([run["hit"] - GRID.nodes[HIT], run["middle"] - GRID.nodes[MIDDLE]], axis=1)
    stress = jo.stress_field(run, "bar", reduced=reduced).history(f"n{ROOT + 1}")
    return run.time, moved, stress, reduced


def patterns():
    load = np.zeros((len(GRID.nodes), 3))
    load[HIT] = FORCE
    return (load.ravel(),)


def errors(found, count=None):
    """Largest deviation at the hit and the middle node and of the stress, relative, (3,)."""
    time, moved, stress, _ = found
    u = history(time, count)
    far = np.linalg.norm(moved - u, axis=2).max(axis=0)
    far /= np.linalg.norm(u, axis=2).max(axis=0)
    S = part().stress.at([ROOT]).evaluate(full()[0][:, :count])[0]
    s = coordinates(time, count) @ S.T
    return np.array([*far, np.abs(stress - s).max() / np.abs(s).max()])


@pytest.mark.filterwarnings("ignore:.*static work")
@pytest.mark.parametrize("modes", [2, 6])
def test_the_engine_sums_clamped_modes(modes):
    # with the clamp as its only interface the reduced part holds the clamped modes themselves
    found = simulated(jo.CraigBampton(modes=modes))
    assert found[3].n == modes
    # what is left is the rotation of the bar, in proportion to the force
    assert errors(found, modes).max() < 1e-4


def convergence(residuals, counts=COUNTS):
    """Errors (counts, 3) of the reduced against the full model."""
    return np.array(
        [errors(simulated(jo.CraigBampton(modes=n, residuals=residuals))) for n in counts]
    )


@pytest.mark.filterwarnings("ignore:.*static work")
def test_the_pulse_response_converges_with_modes_and_residual_vectors():
    without, better = convergence(()), convergence(patterns())
    # columns: hit node, middle node, stress
    assert np.all(np.diff(without, axis=0) < 0.0), without
    assert np.all(np.diff(better, axis=0) < 0.0), better
    assert np.all(without[-1] < [7e-3, 1e-3, 3e-2]), without
    assert np.all(better[-1] < [4e-4, 2e-4, 8e-3]), better
    # a residual vector is worth more than doubling the modes once those within reach of the pulse
    # (its spectrum ends at 1 / RISE = 5 kHz) are kept, not before
    assert np.all(better[1:-1, 0] < without[2:, 0] * 1.01), (without, better)
    assert better[0, 0] > without[0, 0]
