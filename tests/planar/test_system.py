"""The planar element and the equations of motion: against complex steps and print."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.planar.frame import PlanarFrame
from jousto.planar.items import PlanarBeam
from planar.frames import ROD, chain, everything

Array = NDArray[Any]
rng = np.random.default_rng(7)
H = 1e-40


def test_internal_forces_as_printed() -> None:
    """Eqs. 14 to 17 for one element of any direction."""
    L, th0 = 1.3, 0.4
    end = (0.2 + L * np.cos(th0), -0.1 + L * np.sin(th0))
    frame = PlanarFrame([(0.2, -0.1), end], [PlanarBeam(0, 1, ROD)])
    system = frame.system
    u = 0.4 * rng.normal(size=6)
    zero = np.zeros(6)
    found = system.evaluate(u, zero, zero, system.at_factor(0.0)).residual

    x = np.array([0.2 + u[0], end[0] + u[3]])
    y = np.array([-0.1 + u[1], end[1] + u[4]])
    th = th0 + 0.5 * (u[2] + u[5])
    c, s = np.cos(th), np.sin(th)
    dN, N = np.array([-1 / L, 1 / L]), np.array([0.5, 0.5])
    eps, gam = dN @ x * c + dN @ y * s - 1, dN @ y * c - dN @ x * s
    kap = dN @ u[[2, 5]]
    B = np.zeros((3, 6))
    for i in range(2):
        B[0, 3 * i : 3 * i + 3] = c * dN[i], s * dN[i], gam * N[i]
        B[1, 3 * i : 3 * i + 3] = -s * dN[i], c * dN[i], -(1 + eps) * N[i]
        B[2, 3 * i : 3 * i + 3] = 0, 0, dN[i]
    S = np.array([ROD.EA, ROD.GA, ROD.EI]) * (eps, gam, kap)
    assert found == pytest.approx(L * B.T @ S, rel=1e-12)
    # eq. 19
    m, j = L * ROD.mass / 6, L * ROD.rotary / 6
    M = np.kron(np.array([[2, 1], [1, 2]]), np.diag([m, m, j]))
    assert pytest.approx(M, rel=1e-14) == system.M


@pytest.mark.parametrize("frame", [everything(), chain(3)], ids=["everything", "chain"])
def test_tangents_of_the_whole_frame(frame: PlanarFrame) -> None:
    """K, K_acc, C_acc, damping and follower loads: everything Newton's matrix has."""
    system = frame.system
    n = system.size
    loads = system.at_time(0.3)
    q, v, a = 0.1 * rng.normal(size=(3, n)) * np.array([[1.0], [10.0], [100.0]])
    p = system.evaluate(q, v, a, loads)
    e = np.eye(n)
    c, m = 300.0, 4e4
    J = system.tangent(p, loads, c, m)

    def along(dq: float, dv: float, da: float) -> Array:
        d = 1j * H * e
        columns = [
            system.evaluate(q + dq * x, v + dv * x, a + da * x, loads).residual.imag / H for x in d
        ]
        return np.array(columns).T

    exact = along(1.0, c, m)
    assert abs(J - exact).max() < 1e-12 * abs(exact).max()
    # each part alone, against its own size
    for weights in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        part = along(*weights)
        K = system.tangent(p, loads, 0.0, 0.0)
        mine = K if weights[0] else None
        if weights[1]:
            mine = system.tangent(p, loads, 1.0, 0.0) - K
        if weights[2]:
            mine = system.tangent(p, loads, 0.0, 1.0) - K
        assert mine is not None
        assert abs(mine - part).max() < 1e-10 * abs(K).max()

    # what is switched off is K_acc and C_acc of eq. 13 and nothing else
    off = system.tangent(p, loads, c, m, inertia_tangents=False)
    Kacc, Cacc = system.elimination.inertia_tangents(q, v, a, system.M)
    assert abs(J - off - Kacc - c * Cacc).max() < 1e-12 * abs(J).max()
    half = system.tangent(p, loads, c, m, inertia_tangents="symmetric") - off
    assert abs(half - half.T).max() < 1e-12 * abs(J).max()
    assert abs(half + half.T - (J - off) - (J - off).T).max() < 1e-12 * abs(J).max()


def test_stiffness_is_the_static_tangent() -> None:
    system = everything().system
    q = 0.1 * rng.normal(size=system.size)
    zero = np.zeros(system.size)
    loads = system.at_factor(0.7)

    def residual(q: Array) -> Array:
        return system.evaluate(q, zero, zero, loads).residual

    stepped = np.array([np.imag(residual(q + 1j * H * x)) / H for x in np.eye(system.size)]).T
    K = system.stiffness(system.evaluate(q, zero, zero, loads), loads)
    assert abs(K - stepped).max() < 1e-12 * abs(K).max()


def test_rigid_motion_strains_nothing() -> None:
    """Translation and any rotation, with stiffness-proportional damping: no force."""
    frame = everything()
    bare = PlanarFrame(frame.nodes, frame.beams, damping=frame.damping)
    system = bare.system
    where = np.array(list(bare.nodes.values()))
    th, w = 2.3, 5.0
    R = np.array([[np.cos(th), -np.sin(th)], [np.sin(th), np.cos(th)]])
    now = where @ R.T + (0.3, -0.7)
    q = np.column_stack([now - where, np.full(len(where), th)]).ravel()
    v = np.column_stack([-w * now[:, 1], w * now[:, 0], np.full(len(where), w)]).ravel()
    p = system.evaluate(q, v, np.zeros_like(q), system.at_factor(0.0))
    assert abs(system.means(p)[0]).max() < 1e-14
    assert abs(p.inner).max() < 1e-10
