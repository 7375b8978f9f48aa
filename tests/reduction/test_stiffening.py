"""Second-order displacements of reduced parts: closed forms and laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.base.errors import InputError
from jousto.parts.frames.element import EulerBernoulli
from jousto.parts.part import Part
from jousto.reduction.fields.stiffening import stiffening
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.modes.rigid import rigid_modes
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle
from reduction.bodies import STEEL, bent, lattice

Array = NDArray[np.float64]


def skew(b: Array) -> Array:
    return np.array([[0, -b[2], b[1]], [b[2], 0, -b[0]], [-b[1], b[0], 0]])


def offset_frame(lumped: bool) -> Part:
    nodes = [[0, 0, 0], [1, 0.2, 0], [1, 1.2, 0.1]]
    arms = np.zeros((2, 2, 3))
    arms[0, 1], arms[1, 0] = (0.1, 0.05, -0.1), (-0.1, 0.2, 0.1)
    return Part.frame(
        nodes,
        [[0, 1], [1, 2]],
        sections=Rectangle(0.03, 0.02),
        materials=STEEL,
        offsets=arms,
        lumped=lumped,
    )


RIGID = {
    "consistent": lambda: bent(elements=2),
    "lumped": lambda: bent(elements=2, lumped=True),
    "no rotary inertia": lambda: bent(elements=2, rotary=False),
    "offsets": lambda: offset_frame(False),
    "offsets, lumped": lambda: offset_frame(True),
}


@pytest.mark.parametrize("name", RIGID)
def test_rigid_rotation_is_one_to_second_order(name: str) -> None:
    """d = theta x u0 must become exp(theta~) u0: chi = theta x (theta x u0), for any two axes.

    Up to the rigid rotation b that leaves no angular momentum: axial(int u0 chi^T dm) = 0. This
    holds for any frame in space, with rigid arms, point masses and the inertia of sections.
    """
    part = RIGID[name]()
    x = part.nodes - part.center
    found = stiffening(part, rigid_modes(part.nodes, 6, part.center)[:, 3:])
    G = 0.5 * np.trace(part.inertia) * np.eye(3) - part.inertia  # int u0 u0^T dm
    for j in range(3):
        for k in range(3):
            T = 0.5 * (np.outer(np.eye(3)[j], np.eye(3)[k]) + np.outer(np.eye(3)[k], np.eye(3)[j]))
            T = T - (j == k) * np.eye(3)
            GT = G @ T
            axial = np.array([GT[1, 2] - GT[2, 1], GT[2, 0] - GT[0, 2], GT[0, 1] - GT[1, 0]])
            b = -np.linalg.solve(part.inertia, axial)
            N = GT + G @ skew(b).T
            assert found.second_moment[j, k] == pytest.approx(N, abs=1e-10)
            assert found.translations[:, :, j, k] == pytest.approx(x @ (T + skew(b)).T, abs=1e-10)
            assert found.rotations[:, :, j, k] == pytest.approx(np.tile(b, (len(x), 1)), abs=1e-10)


def test_foreshortening_of_a_beam() -> None:
    """chi_jk,x(x) - chi_jk,x(0) = -int_0^x v_j' v_k' + w_j' w_k' dx, nothing across.

    The integrals are of the cubic polynomials between the nodes, by a fine trapezoidal rule.
    """
    n, length = 8, 2.0
    part = Part.beam(length, Rectangle(0.02, 0.03), n, STEEL, theory=EulerBernoulli())
    r = reduce(part, CraigBampton(("start",), modes=4), stiffening=True)
    assert r.stiffening is not None and r.rotations is not None
    bending = [j for j in range(r.n) if np.abs(r.modes[:, 1:, j]).max() > 1e-6]
    assert len(bending) >= 2
    L, xi = length / n, np.linspace(0.0, 1.0, 2001)
    H = np.array(
        [(xi**2 - xi) * 6 / L, 1 - 4 * xi + 3 * xi**2, (xi - xi**2) * 6 / L, 3 * xi**2 - 2 * xi]
    )
    for j in bending:
        for k in bending:
            total = [0.0]
            for e in range(n):
                slope = []
                for m in (j, k):
                    u, t = r.modes[[e, e + 1], :, m], r.rotations[[e, e + 1], :, m]
                    v = np.array([u[0, 1], t[0, 2], u[1, 1], t[1, 2]]) @ H
                    w = np.array([u[0, 2], -t[0, 1], u[1, 2], -t[1, 1]]) @ H
                    slope.append(np.array([v, w]))
                total.append(total[-1] - np.trapezoid((slope[0] * slope[1]).sum(0), dx=L / 2000))
            chi = r.stiffening.translations[:, :, j, k]
            scale = np.abs(r.stiffening.translations).max()
            assert chi[:, 0] - chi[0, 0] == pytest.approx(total, abs=1e-6 * scale)
            assert np.abs(chi[:, 1:]).max() < 1e-9 * scale


def test_duality_with_geometric_stiffness() -> None:
    """f . chi(p, p) = -p^T Kg(f) p for any self-equilibrated load f, in a frame in space."""
    part = bent(elements=2)
    r = reduce(part, FreeFree(modes=5), stiffening=True)
    assert r.stiffening is not None and r.rotations is not None
    rng = np.random.default_rng(5)
    R = part.rigid_modes()
    f = rng.standard_normal(part.K.shape[0])
    f -= R @ np.linalg.lstsq(R, f, rcond=None)[0]
    assert np.abs(R.T @ f).max() < 1e-12
    d = np.linalg.lstsq(part.K.toarray(), f, rcond=1e-12)[0]
    X = np.concatenate([r.modes, r.rotations], axis=1).reshape(-1, r.n)
    expected = -X.T @ (part.geometric_stiffness(d) @ X)
    s = r.stiffening
    chi = np.concatenate([s.translations, s.rotations], axis=1).reshape(-1, r.n, r.n)
    work = np.einsum("d,djk->jk", f, chi)
    assert work == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())
    assert np.abs(expected).max() > 0.0


def test_saved_kept_and_off_by_default(tmp_path: Path) -> None:
    part = Part.beam(1.0, Rectangle(0.02, 0.03), 3, STEEL)
    method = CraigBampton(("start",), modes=3)
    plain, full = reduce(part, method), reduce(part, method, stiffening=True)
    assert plain.stiffening is None
    assert np.array_equal(plain.modes, full.modes)
    full.save(tmp_path / "part.h5")
    again = ReducedPart.load(tmp_path / "part.h5").stiffening
    assert again is not None and full.stiffening is not None
    kept = full.keep([2, 0]).stiffening
    assert kept is not None
    for name in ("second_moment", "translations", "rotations"):
        assert np.array_equal(getattr(again, name), getattr(full.stiffening, name))
    assert kept.second_moment[0, 1] == pytest.approx(full.stiffening.second_moment[2, 0])
    assert kept.translations[3, 0, 1, 1] == full.stiffening.translations[3, 0, 0, 0]
    assert kept.n == 2


def test_refused_without_beams() -> None:
    with pytest.raises(InputError, match="only parts of beams"):
        reduce(lattice(), FreeFree(modes=3), stiffening=True)
