"""Rings under outer pressure: double loads of pressure that follows, the load of dead pressure.

A thin inextensible ring of radius R buckles in its plane with k waves under pressure p a length
that stays normal to it at ``(k^2 - 1) EI/R^3``, and that keeps its direction at ``k^2 EI/R^3``,
k = 2, 3 ... (Timoshenko and Gere, Theory of Elastic Stability, 7.4; Singer and Babcock, J. Appl.
Mech. 37 (1970) 1151-1153). Here EI/R^3 = 1, stretch and shear lower that by 3e-6.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import jousto as jo
from jousto.simulation.statics.buckling import _Pencil

STIFF = 1e6
SECTION = jo.mechanism.BeamSection((STIFF, STIFF, STIFF, 1e3, 1e3, 1.0), 1.0, (2e-3, 1e-3, 1e-3))


def arc(angles: np.ndarray, *, bending: bool) -> jo.BeamBody:
    points = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    up = np.tile([0.0, 0.0, 1.0], (len(angles), 1))
    return jo.BeamBody("ring", points, SECTION, up=up, bending=bending)


def under_pressure(angles: np.ndarray, *, bending: bool) -> jo.Model:
    """A ring, held at one node, which its pressure does not know of."""
    ring = arc(angles, bending=bending)
    at = jo.ground.at(ring.nodes[0], axes=ring.frames[0])
    return jo.compile(
        jo.Mechanism(
            ring,
            jo.Fixed("hold", at, ring["start"]),
            jo.Fixed("close", ring["start"], ring["end"]),
            jo.mechanism.LineLoad("pressure", ring, (0, 1, 0), follow=True, signal=jo.Input("p")),
        )
    )


def even(n: int) -> np.ndarray:
    return np.linspace(0.0, 2 * np.pi, n + 1)


def uneven(n: int, seed: int) -> np.ndarray:
    """Elements between 0.4 and 1.6 of their mean."""
    angles = even(n)
    angles[1:-1] += 0.6 * np.pi / n * np.random.default_rng(seed).uniform(-1, 1, n - 1)
    return angles


@pytest.mark.parametrize("bending", [False, True])
def test_pressure_that_follows_has_pairs_of_loads(bending):
    """Of order two, or four, in the elements; n = 60 is solved by sparse matrices."""
    errors = []
    for n in (16, 30, 60):
        loads = jo.simulation.buckling(under_pressure(even(n), bending=bending), "p", 4).loads
        assert loads[:2] == pytest.approx(loads[0], rel=1e-5)
        assert loads[2:] == pytest.approx(loads[2], rel=1e-5)
        errors.append(loads[[0, 2]] / [3.0, 8.0] - 1)
    order = 3.7 if bending else 1.9
    assert (np.abs(errors[0]) > (30 / 16) ** order * np.abs(errors[1])).all()
    assert np.abs(errors[-1]).max() < (1e-4 if bending else 0.02)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("bending", [False, True])
def test_uneven_elements_lose_no_load(seed, bending):
    """They split pairs, into real or complex ones: nearly 3 twice, then nearly 8 twice."""
    found = jo.simulation.buckling(under_pressure(uneven(24, seed), bending=bending), "p", 4)
    assert found.loads == pytest.approx([3, 3, 8, 8], rel=0.02 if bending else 0.14)
    assert not len(found.left_out)
    # the modes of a pair are two: their displacements are not the same
    shape = np.array([found.shapes[f"ring.node{i + 1}"][:, 0] for i in range(24)])
    first, second = shape[:, 0].ravel(), shape[:, 1].ravel()
    cosine = first @ second / np.linalg.norm(first) / np.linalg.norm(second)
    assert abs(cosine) < 0.95


def test_dead_pressure_on_half_a_ring():
    """Half of it, its ends sliding on the line of symmetry: waves that are symmetric to it."""
    errors = []
    for n in (8, 15, 30):
        ring = arc(np.linspace(0.0, np.pi, n + 1), bending=True)
        ends = [jo.ground.at(ring.nodes[i], axes=ring.frames[i]) for i in (0, -1)]
        inward = -np.array(ring.nodes)
        parts = [
            ring,
            jo.Fixed("right", ends[0], ring["start"]),
            jo.Prismatic("left", ends[1], ring["end"], axis=(1, 0, 0)),
            jo.mechanism.LineLoad("pressure", ring, inward, signal=jo.Input("p")),
        ]
        loads = jo.simulation.buckling(jo.compile(jo.Mechanism(*parts)), "p", 2).loads
        errors.append(loads / [4.0, 9.0] - 1)
    # linear shape functions of the load between the nodes: order two
    assert (np.abs(errors[0]) > 3.0 * np.abs(errors[1])).all()
    limit = (4 * errors[2] - errors[1]) / 3
    assert np.abs(limit).max() < 1e-3


def two_rods(share: float) -> jo.Model:
    """Two rods of length 1, springs 1 at their hinges; a share of the load P follows the last."""
    bodies = [
        jo.RigidBody(f"rod{i}", mass=1.0, inertia=0.1 * np.eye(3), position=(i + 0.5, 0, 0))
        for i in range(2)
    ]
    feet = [body.at((-0.5, 0, 0)) for body in bodies]
    heads = [body.at((0.5, 0, 0)) for body in bodies]
    hinges = [
        jo.Revolute("base", jo.ground["origin"], feet[0], axis=(0, 0, 1)),
        jo.Revolute("knee", heads[0], feet[1], axis=(0, 0, 1)),
    ]
    springs = [jo.Spring(f"spring{i}", h.angle, stiffness=1.0) for i, h in enumerate(hinges)]
    P = jo.Input("P")
    follows = jo.Force("follows", heads[1], (-share, 0, 0), follow=True, signal=P)
    dead = jo.Force("dead", heads[1], (share - 1, 0, 0), signal=P)
    return jo.compile(jo.Mechanism(*bodies, *hinges, *springs, follows, dead))


def test_complex_loads_are_left_out_and_said():
    """``(1 - a) P^2 - 3 (1 - a) P + 1 = 0``: Ziegler's rods, a share a of whose load follows.

    (Herrmann and Bungay, J. Appl. Mech. 31 (1964) 435-440): real loads up to a = 5/9, none at 1.
    """
    assert jo.simulation.buckling(two_rods(0.5), "P", 2).loads == pytest.approx(
        [1.0, 2.0], rel=1e-9
    )
    with pytest.warns(jo.JoustoWarning, match=r"left out .* 1.5 \+- 1.66i"):
        found = jo.simulation.buckling(two_rods(0.8), "P", 2)
    assert not len(found.loads)
    assert found.left_out == pytest.approx([1.5 + 1j * np.sqrt(2.75)], rel=1e-9)
    nothing = jo.simulation.buckling(two_rods(1.0), "P", 2)
    assert not len(nothing.loads)
    assert not len(nothing.left_out)


def held_softly(stiffness: tuple[float, ...]) -> jo.Model:
    """A steel ring of 60 nodes under dead radial forces, its start held by a soft bushing."""
    section, steel = jo.Rectangle(0.05, 0.05), jo.Material(E=210e9, nu=0.3, rho=7850)
    angles, radius = even(60), 0.5
    points = radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    up = np.tile([0.0, 0.0, 1.0], (61, 1))
    ring = jo.BeamBody("ring", points, section, steel, up=up)
    load = jo.Input("p")
    nodes = [ring["start"], *(ring[f"node{k + 1}"] for k in range(1, 60))]
    at = jo.ground.at(ring.nodes[0], axes=ring.frames[0])
    return jo.compile(
        jo.Mechanism(
            ring,
            jo.Fixed("close", ring["start"], ring["end"]),
            jo.Bushing("hold", at, ring["start"], stiffness=stiffness),
            *(
                jo.Force(f"press {k}", node, -points[k] / radius, signal=load)
                for k, node in enumerate(nodes)
            ),
        )
    )


# N/m and N m/rad; translations have no load, turns one of their stiffness over 60 R, if any
@pytest.mark.parametrize("stiffness", [(1e-6,) * 6, (1e-3,) * 6, (1e-3,) * 3 + (0.0,) * 3])
def test_soft_springs_add_no_load_and_lose_none(stiffness):
    """Beyond turns as a whole: 60 radial forces are a dead pressure, ``k^2 EI/R^3`` in its plane.

    Out of its plane a ring under dead pressure buckles at ``(k^2 - 1)^2 / (k^2 + EI/GJ) EI/R^3``
    (Timoshenko and Gere, 7.4, for k = 2). The lowest, wherever the search starts.
    """
    EI = 210e9 * 0.05**4 / 12.0
    GJ = 210e9 / 2.6 * 0.1406 * 0.05**4  # of a square, Timoshenko and Goodier
    unit = EI / 0.5**2 * 2.0 * np.pi / 60.0  # N per node
    wanted = 9.0 / (4.0 + EI / GJ)
    model = held_softly(stiffness)
    for start in (0.0, 0.4, 0.8):
        loads = jo.simulation.buckling(model, "p", 5, start=start * unit).loads / unit
        firm = loads[loads > 1e-3]
        # 60 elements of order two: 0.8 %, shear of a thick ring 0.3 %
        assert firm[:2] == pytest.approx([wanted, wanted], rel=0.015)
        assert (loads[loads <= 1e-3] < 1e-6).all()


def test_a_load_next_to_which_rounding_leaves_no_pivot():
    """(A + s A') x = 0 with the pivot at s (1 + 1e-9) exactly 0; and one that is 0 at any s."""
    near = sp.diags_array([-(1.0 + 1e-9), 5.0]).tocsc()
    assert _Pencil(near, sp.eye_array(2).tocsc()).knows(1.0)
    never = sp.diags_array([0.0, 5.0]).tocsc()
    assert not _Pencil(never, sp.diags_array([0.0, 1.0]).tocsc()).knows(1.0)
