"""Parts that the tests of this folder share."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli
from jousto.parts.mass import MassPoints, PointMass
from jousto.parts.part import Part
from jousto.sections.section import GeneralSection, Rectangle

Array = NDArray[np.float64]

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def pendulum(E: float = 2.07e8, offset: float = 1e-5) -> Part:
    """The soft beam of Rantalainen 2007, chapter 5; the offset gives inertia about its axis."""
    nodes = np.zeros((5, 3))
    nodes[:, 0] = [0.0, 0.5, 1.0, 1.5, 2.0]
    nodes[4, 1] = -offset
    with warnings.catch_warnings():
        # a modulus of 2e8 Pa is not that of a metal, and says so
        warnings.simplefilter("ignore")
        material = Material(E=E, nu=0.3, rho=7850.0)
    return Part.frame(
        nodes,
        [[0, 1], [1, 2], [2, 3], [3, 4]],
        sections=Rectangle(0.1, 0.1),
        materials=material,
        lumped=True,
        rotary_inertia=False,
        theory=EulerBernoulli(),
        node_sets={"start": (0,), "end": (4,)},
        name="pendulum",
    )


def bent(
    *, lumped: bool = False, rotary: bool = True, elements: int = 3, mass: bool = True
) -> Part:
    """A bent frame in space without any symmetry."""
    corners = np.array([[0.1, -0.2, 0.3], [1.0, 0.1, 0.2], [1.2, 0.9, 0.1], [1.1, 1.0, 0.8]])
    nodes = np.concatenate(
        [
            np.linspace(a, b, elements, endpoint=False)
            for a, b in zip(corners[:-1], corners[1:], strict=True)
        ]
        + [corners[-1:]]
    )
    n = len(nodes)
    point = PointMass("node2", 0.7, inertia=(0.002, 0.003, 0.004), offset=(0.01, 0.02, -0.03))
    return Part.frame(
        nodes,
        np.column_stack([np.arange(n - 1), np.arange(1, n)]),
        sections=Rectangle(0.03, 0.02),
        materials=STEEL,
        lumped=lumped,
        rotary_inertia=rotary,
        point_masses=(point,) if mass else (),
        node_sets={"start": (0,), "end": (n - 1,), "both": (0, n - 1)},
        name="bent",
    )


def lattice(seed: int = 3, bars_of_last_node: int = 99) -> Part:
    """Nodes that only translate, a truss for stiffness and the mass matrix of a solid, Mbar x E3.

    Mbar couples nodes, as the consistent mass matrix of isoparametric elements does.
    """
    random = np.random.default_rng(seed)
    nodes = np.array([[x, y, z] for x in range(4) for y in range(2) for z in range(2)], float)
    nodes = nodes * [0.3, 0.2, 0.25] + 0.02 * random.standard_normal((len(nodes), 3))
    nn = len(nodes)
    K = np.zeros((3 * nn, 3 * nn))
    Mbar = np.zeros((nn, nn))
    bars = 0
    for i in range(nn):
        for j in range(i):
            d = nodes[i] - nodes[j]
            L = np.linalg.norm(d)
            if L > 0.65:
                continue
            bars += i == nn - 1
            if bars > bars_of_last_node:
                continue
            g = np.zeros(3 * nn)
            g[3 * i : 3 * i + 3], g[3 * j : 3 * j + 3] = d / L, -d / L
            K += 1e7 / L * np.outer(g, g)
            Mbar[np.ix_([i, j], [i, j])] += 0.2 * L * np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    return Part.from_matrices(
        sp.csr_array(np.kron(Mbar, np.eye(3))),
        sp.csr_array(K),
        nodes,
        node_sets={"foot": (0, 1, 2, 3), "line": (0, 4), "head": (12, 13, 14, 15)},
        name="lattice",
    )


def without_points(part: Part) -> Part:
    """The same part as if its mass matrix came from elsewhere."""
    return replace(part, mass_points=None)


def turned(part: Part, Q: Array, shift: Array) -> Part:
    """The same part described in a frame turned by Q and shifted."""
    assert part.dofs_per_node == 6 and part.mass_points is not None
    B = sp.csr_array(np.kron(np.eye(2 * len(part.nodes)), Q))
    k = len(part.mass_points.mass)
    C = sp.csr_array(np.kron(np.eye(k), Q))
    points = part.mass_points
    return replace(
        part,
        nodes=part.nodes @ Q.T + shift,
        M=sp.csr_array(B @ part.M @ B.T),
        K=sp.csr_array(B @ part.K @ B.T),
        mass_points=MassPoints(
            mass=points.mass,
            position=points.position @ Q.T + shift,
            second_moment=Q @ points.second_moment @ Q.T,
            N=sp.csr_array(C @ points.N @ B.T),
            N_rot=sp.csr_array(C @ points.N_rot @ B.T),
        ),
        stress=None,
    )


def dofs(reduced_modes: Array, rotations: Array | None) -> Array:
    """Modes of a reduced part as columns of degrees of freedom."""
    parts = [reduced_modes] if rotations is None else [reduced_modes, rotations]
    return np.concatenate(parts, axis=1).reshape(-1, reduced_modes.shape[2])


@dataclass
class Particles:
    """A cloud of particles: masses (k,), positions (k, 3) and modes (k, 3, n)."""

    m: Array
    u0: Array
    phi: Array


def particles(points: MassPoints, X: Array) -> Particles:
    """Replace every mass point by six particles with its mass and second moment.

    On each principal axis of G two particles of m/6 at +-sqrt(3 g / m).
    """
    k, n = len(points.mass), X.shape[1]
    phi = np.asarray(points.N @ X).reshape(k, 3, n)
    psi = np.asarray(points.N_rot @ X).reshape(k, 3, n)
    m, u0, modes = [], [], []
    for i in range(k):
        values, vectors = np.linalg.eigh(points.second_moment[i])
        for value, axis in zip(values, vectors.T, strict=True):
            s = np.sqrt(max(3.0 * value / points.mass[i], 0.0)) * axis
            for sign in (1.0, -1.0):
                m.append(points.mass[i] / 6.0)
                u0.append(points.position[i] + sign * s)
                modes.append(phi[i] + np.cross(psi[i], sign * s, axis=0))
    return Particles(np.array(m), np.array(u0), np.array(modes))


def skew(x: Array) -> Array:
    """x~ with x~ y = x cross y."""
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def general_section() -> GeneralSection:
    """A section whose two bending stiffnesses differ."""
    return GeneralSection(A=6e-4, Iy=2e-8, Iz=4.5e-8, J=4e-8, ky=0.85, kz=0.85)
