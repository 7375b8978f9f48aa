"""The same body from another frame: clamped frequencies, and one truth in every frame."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la

import jousto as jo


@pytest.fixture(scope="module")
def part() -> jo.Part:
    return jo.Part.beam(
        1.0, jo.Rectangle(0.02, 0.01), 8, jo.Material(2.1e11, 0.3, 7850.0), name="rod"
    )


@pytest.fixture(scope="module")
def rod(part: jo.Part) -> jo.ReducedPart:
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=42))


def test_frequencies_are_those_of_the_clamped_mesh(part: jo.Part, rod: jo.ReducedPart) -> None:
    free = np.arange(6, part.K.shape[0])
    K, M = (X.toarray()[np.ix_(free, free)] for X in (part.K, part.M))
    exact = np.sqrt(la.eigh(K, M, eigvals_only=True)) / (2 * np.pi)
    # all 48 modes are kept, so that the basis is that of the mesh
    held = jo.reduction.clamp(rod, "start")
    np.testing.assert_allclose(held.frequencies[:20], exact[:20], rtol=1e-7)
    assert np.abs(held.modes[held.node("start")]).max() < 1e-9 * np.abs(held.modes).max()
    np.testing.assert_allclose(held.invariants.I6, np.eye(held.n), atol=1e-8)


def test_a_deformation_has_the_same_stress(rod: jo.ReducedPart, rng: np.random.Generator) -> None:
    held = jo.reduction.clamp(rod, "start")
    assert rod.stress is not None and held.stress is not None
    # displacements of the held modes are those of the free ones but for a rigid motion
    p = rng.normal(size=held.n) / (2 * np.pi * held.frequencies)
    everything = np.hstack([_motions(rod), _rigid(rod.nodes)])
    q, *_ = np.linalg.lstsq(everything, _motions(held) @ p, rcond=None)
    free, held_stress = rod.stress.modes @ q[: rod.n], held.stress.modes @ p
    np.testing.assert_allclose(free, held_stress, atol=1e-5 * np.abs(held_stress).max())


def _motions(part: jo.ReducedPart) -> np.ndarray:
    assert part.rotations is not None
    return np.vstack([part.modes.reshape(-1, part.n), part.rotations.reshape(-1, part.n)])


def _rigid(nodes: np.ndarray) -> np.ndarray:
    turns = [np.r_[np.cross(axis, nodes).ravel(), np.tile(axis, len(nodes))] for axis in np.eye(3)]
    shifts = [np.r_[np.tile(axis, len(nodes)), np.zeros(nodes.size)] for axis in np.eye(3)]
    return np.column_stack(shifts + turns)


def test_invariants_of_the_held_modes(rod: jo.ReducedPart) -> None:
    """Kinetic energy of a deforming, moving body is the same in both frames."""
    held = jo.reduction.clamp(rod, "start")
    I = held.invariants
    # the mean-axis part has no momentum; the held one carries that of its rigid share
    np.testing.assert_allclose(rod.invariants.I3, 0.0, atol=1e-9)
    assert np.abs(I.I3).max() > 0.1
    # momentum and moment of momentum by the nodes' own masses: int phi dm by the trapezoid
    weight = np.full(len(held.nodes), 1 / 8)
    weight[[0, -1]] = 1 / 16
    momentum = I.mass * np.einsum("k,kaj->aj", weight, held.modes[:, :, :2])
    np.testing.assert_allclose(I.I3[:, :2], momentum, atol=0.02 * np.abs(momentum).max())


@pytest.mark.parametrize("frame", ["mean", "held"])
def test_the_engine_bends_both_alike(part: jo.Part, frame: str) -> None:
    """A cantilever sags under a force at its tip to M = F L at the root in either frame."""
    few = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
    body = jo.FlexibleBody("rod", few if frame == "mean" else jo.reduction.clamp(few, "start"))
    wall = jo.Fixed("wall", jo.ground["origin"], body["start"])
    model = jo.compile(jo.Mechanism(body, wall, jo.Force("load", body["end"], (0.0, 0.0, -0.1))))
    state = jo.equilibrium(model)
    assert body.reduced.stress is not None
    root = body.reduced.stress.modes[body.reduced.stress.labels.index("e1.a.top")] @ state.q[7:]
    # W = b h^2 / 6
    assert root[0] == pytest.approx(0.1 * 1.0 / (0.02 * 0.01**2 / 6), rel=1e-4)


def test_refusals(rod: jo.ReducedPart) -> None:
    with pytest.raises(jo.InputError, match="no node 'begin'"):
        jo.reduction.clamp(rod, "begin")
    bare = jo.ReducedPart(
        "bare",
        rod.nodes,
        rod.elements,
        rod.node_sets,
        rod.modes,
        None,
        rod.frequencies,
        rod.invariants,
    )
    with pytest.raises(jo.InputError, match="has no rotation, which the frame needs"):
        jo.reduction.clamp(bare, "start")


@pytest.mark.parametrize("damping", [0.02, jo.Rayleigh(1.0, 1e-4)])
def test_modes_keep_their_damping_ratio(rod: jo.ReducedPart, damping: float | jo.Rayleigh) -> None:
    """Held by a joint at the node they are seen from; by mean axes the first gets less."""
    ratios = []
    for reduced in (jo.reduction.clamp(rod, "start"), rod):
        body = jo.FlexibleBody("rod", reduced, damping=damping)
        wall = jo.Fixed("wall", jo.ground["origin"], body["start"])
        found = jo.modes(jo.compile(jo.Mechanism(body, wall)), damped=True)
        w = np.abs(found.eigenvalues[:4])
        asked = damping if isinstance(damping, float) else 0.5 * (1.0 / w + 1e-4 * w)
        ratios.append(found.damping[:4] / asked)
    assert ratios[0] == pytest.approx(np.ones(4), rel=1e-6)
    assert ratios[1][0] < 0.5
