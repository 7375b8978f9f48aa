"""One body seen from mean, node and chord frames: reference conditions, motion, stiffening."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.base.rotations import rotation_matrix
from jousto.reduction import ChordFrame, MeanFrame, NodeFrame, in_frame, same_motion
from jousto.reduction.frames.frame import Frame
from reduction.bodies import bent

Array = NDArray[np.float64]
FRAMES: list[Frame] = [NodeFrame("start"), NodeFrame("end"), ChordFrame("start", "end")]
IDS = ["start", "end", "chord"]


@cache
def body() -> jo.ReducedPart:
    return jo.reduce(bent(), jo.CraigBampton(("start", "end"), modes=6), stiffening=True)


def moved(part: jo.ReducedPart, q: Array) -> Array:
    """Nodes of a body in the world to the first order of its deformation."""
    return np.asarray(q[:3] + (part.nodes + part.modes @ q[7:]) @ rotation_matrix(q[3:7]).T)


def velocity(part: jo.ReducedPart, q: Array, v: Array) -> Array:
    local = np.cross(v[3:6], part.nodes + part.modes @ q[7:]) + part.modes @ v[6:]
    return np.asarray(v[:3] + local @ rotation_matrix(q[3:7]).T)


def states(rng: np.random.Generator, n: int, frequencies: Array) -> tuple[Array, Array]:
    """A random state; strain energies of the modes are alike."""
    e = rng.normal(size=4)
    p = 0.3 * rng.normal(size=n) / (2 * np.pi * frequencies)
    q = np.r_[rng.normal(size=3), e / np.linalg.norm(e), p]
    return q, np.r_[rng.normal(size=6), 0.3 * rng.normal(size=n)]


@pytest.mark.parametrize("frame", FRAMES, ids=IDS)
def test_conditions(frame: Frame) -> None:
    part = in_frame(body(), frame)
    size = np.abs(part.modes).max()
    start, end = part.node("start"), part.node("end")
    if isinstance(frame, NodeFrame):
        k = part.node(frame.node)
        turn = part.rotation(k)
        assert turn is not None
        assert np.abs(part.modes[k]).max() < 1e-11 * size
        assert np.abs(turn).max() < 1e-11 * size
    else:
        e = part.nodes[end] - part.nodes[start]
        across = np.cross(e, part.modes[end] - part.modes[start], axisb=0, axisc=0)
        turn = part.rotation(start)
        assert turn is not None
        assert np.abs(part.modes[start]).max() < 1e-11 * size
        assert np.abs(across).max() < 1e-11 * size
        assert np.abs(e @ turn).max() < 1e-11 * size
    np.testing.assert_allclose(part.invariants.I6, np.eye(part.n), atol=1e-9)
    assert np.all(np.diff(part.frequencies) >= 0)


@pytest.mark.parametrize("frame", FRAMES, ids=IDS)
def test_and_back(frame: Frame) -> None:
    """Back in the mean frame the frequencies, masses and second-order field are the first ones."""
    first, there = body(), in_frame(body(), frame)
    back = in_frame(there, MeanFrame())
    np.testing.assert_allclose(back.frequencies, first.frequencies, rtol=1e-9)
    assert there.invariants.I3.any()
    scale = np.sqrt(first.invariants.mass)
    np.testing.assert_allclose(back.invariants.I3, 0.0, atol=1e-9 * scale)
    np.testing.assert_allclose(back.invariants.I4, 0.0, atol=1e-9 * scale)
    signs = np.sign(np.einsum("kaj,kaj->j", back.modes, first.modes))
    np.testing.assert_allclose(back.modes * signs, first.modes, atol=1e-7)
    assert back.stiffening is not None and first.stiffening is not None
    both = signs[:, None] * signs
    for a, b in (
        (back.stiffening.translations * both, first.stiffening.translations),
        (back.stiffening.rotations * both, first.stiffening.rotations),
        (back.stiffening.second_moment * both[:, :, None, None], first.stiffening.second_moment),
    ):
        np.testing.assert_allclose(a, b, atol=1e-7 * np.abs(b).max())


@pytest.mark.parametrize("frame", FRAMES, ids=IDS)
def test_stress_of_a_deformation(frame: Frame, rng: np.random.Generator) -> None:
    old, new = body(), in_frame(body(), frame)
    assert old.stress is not None and new.stress is not None
    q, v = states(rng, old.n, old.frequencies)
    there, _ = same_motion(old, new, q, v)
    s = old.stress.modes @ q[7:]
    np.testing.assert_allclose(new.stress.modes @ there[7:], s, atol=1e-7 * np.abs(s).max())


@pytest.mark.parametrize("frame", FRAMES, ids=IDS)
def test_nodes_move_alike(frame: Frame, rng: np.random.Generator) -> None:
    """To the first order in the deformation: the difference falls with its square."""
    old, new = body(), in_frame(body(), frame)
    q, v = states(rng, old.n, old.frequencies)
    differences = []
    for size in (1.0, 0.1):
        q[7:] *= size
        v[6:] *= size
        there, rate = same_motion(old, new, q, v)
        differences.append(
            (
                np.abs(moved(old, q) - moved(new, there)).max(),
                np.abs(velocity(old, q, v) - velocity(new, there, rate)).max(),
            )
        )
    # a hundredth, but for terms of third order
    ratios = np.array(differences[0]) / differences[1]
    np.testing.assert_allclose(ratios, 100.0, rtol=0.15)


@pytest.mark.parametrize("frame", FRAMES, ids=IDS)
def test_second_order_is_that_of_the_body(frame: Frame, rng: np.random.Generator) -> None:
    """With chi the shapes of the body agree to the second order: distances to the third.

    What a frame does is rigid, so that distances of nodes are the same from all.
    """
    old, new = body(), in_frame(body(), frame)
    assert old.stiffening is not None and new.stiffening is not None
    q, v = states(rng, old.n, old.frequencies)
    there = same_motion(old, new, q, v)[0][7:]

    def distances(part: jo.ReducedPart, p: Array, second: float) -> Array:
        assert part.stiffening is not None
        chi = np.einsum("xajk,j,k->xa", part.stiffening.translations, p, p)
        x = part.nodes + part.modes @ p + 0.5 * second * chi
        return np.asarray(np.linalg.norm(x[:, None] - x[None], axis=2))

    errors = {}
    for second in (0.0, 1.0):
        errors[second] = [
            np.abs(distances(old, s * q[7:], second) - distances(new, s * there, second)).max()
            for s in (0.1, 0.01)
        ]
    assert errors[1.0][0] / errors[1.0][1] == pytest.approx(1000.0, rel=0.1)
    assert errors[0.0][0] / errors[0.0][1] == pytest.approx(100.0, rel=0.1)


def test_momentum_of_the_second_order_field() -> None:
    """The engine takes ``int u0 chi^T dm`` as symmetric and ``int chi dm`` as zero.

    Checked on a frame of many elements by the masses of its nodes.
    """
    part = jo.Part.frame(
        *_ring(),
        sections=jo.Rectangle(0.02, 0.02),
        materials=jo.Material(2e11, 0.3, 7850.0),
        lumped=True,
        rotary_inertia=False,
        node_sets={"start": (0,)},
    )
    rod = jo.reduce(part, jo.FreeFree(modes=4), stiffening=True)
    held = in_frame(rod, NodeFrame("start"))
    assert held.stiffening is not None
    chi = held.stiffening.translations
    weight = part.M.diagonal()[::6]
    linear = np.einsum("x,xajk->ajk", weight, chi)
    N = np.einsum("x,xa,xbjk->jkab", weight, part.nodes, chi)
    size = np.einsum("x,xajk->jk", weight, np.abs(chi)).max()
    assert np.abs(linear).max() < 1e-9 * size
    np.testing.assert_allclose(held.stiffening.second_moment, N, atol=1e-9 * size)


def _ring() -> tuple[Array, Array]:
    a = np.linspace(0.0, 1.5, 9)
    nodes = np.column_stack([np.cos(a), np.sin(a), 0.2 * a])
    return nodes, np.column_stack([np.arange(8), np.arange(1, 9)])


@pytest.mark.parametrize("frame", FRAMES, ids=IDS)
def test_of_a_reduction(frame: Frame) -> None:
    """Asked for at once, or changed afterwards; the certificate judges the same body."""
    part = bent()
    at_once = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6, frame=frame))
    np.testing.assert_allclose(at_once.frequencies, in_frame(body(), frame).frequencies)
    assert repr(frame) in at_once.provenance["method"]
    found = jo.certificate.certify(part, at_once)
    mean = jo.certificate.certify(part, body())
    assert [c.status for c in found.checks] == [c.status for c in mean.checks]
    free = jo.reduce(part, jo.FreeFree(modes=3, frame=frame))
    assert repr(frame) in repr(jo.FreeFree(modes=3, frame=frame))
    assert free.provenance["frame"] == repr(frame)


def test_in_model_files(tmp_path: Path) -> None:
    file = tmp_path / "rod.yaml"
    file.write_text(
        "parts:\n  rod:\n    type: beam\n    length: 1\n"
        "    section: {type: rectangle, width: 0.02, height: 0.01}\n    elements: 4\n"
        "    material: {E: 2.0e11, nu: 0.3, rho: 7850}\n"
        "    reduce: {type: free-free, modes: 3, frame: {type: chord, first: start, second: end}}\n"
        "bodies:\n  - {name: rod, part: rod}\n"
        "joints:\n  - {type: spherical, name: pin, a: ground.origin, b: rod.start}\n"
    )
    (body,) = jo.read_model(file).mechanism.bodies
    assert body.reduced.provenance["frame"] == "ChordFrame(first='start', second='end')"
    wrong = file.read_text().replace("chord, first: start, second: end", "cord")
    file.write_text(wrong)
    with pytest.raises(jo.InputError, match="cord"):
        jo.read_model(file)


def test_refusals() -> None:
    with pytest.raises(jo.InputError, match="frame is 'start', must be NodeFrame"):
        jo.FreeFree(modes=3, frame="start")  # type: ignore[arg-type]
    part = body()
    with pytest.raises(jo.InputError, match="no node 'begin'"):
        in_frame(part, ChordFrame("begin", "end"))
    with pytest.raises(jo.InputError, match="are both 'start', must be two nodes"):
        ChordFrame("start", "start")
    with pytest.raises(jo.InputError, match=r"must be MeanFrame\(\), NodeFrame"):
        in_frame(part, "start")  # type: ignore[arg-type]
    other = jo.reduce(bent(), jo.FreeFree(modes=3))
    with pytest.raises(jo.InputError, match="does not contain the modes of reduced part"):
        same_motion(part, other, np.zeros(7 + part.n), np.zeros(6 + part.n))
    kept = jo.reduce(bent(), jo.FreeFree(modes=3), residual_stress=True)
    with pytest.raises(jo.InputError, match="is that of mean axes"):
        in_frame(kept, NodeFrame("start"))
    solid = jo.reduce(_block(), jo.FreeFree(modes=3))
    with pytest.raises(jo.InputError, match="neither 'node1' nor 'node2' has rotations"):
        in_frame(solid, ChordFrame("node1", "node2"))
    with pytest.raises(jo.InputError, match="has no rotation, which the frame needs"):
        in_frame(solid, NodeFrame("node1"))


def _block() -> jo.Part:
    from parts.grids import grid

    mesh = grid("hexahedron20", (2, 1, 1), (0.2, 0.05, 0.05))
    return jo.Part.solid(mesh, jo.Material(2e11, 0.3, 7850.0))
