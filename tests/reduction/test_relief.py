"""Inertia relief, and stress by modes: the numbers of closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli
from jousto.parts.interface import Interface
from jousto.parts.matrices.checks import rigid_modes
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton
from jousto.reduction.modes.relief import inertia_relief
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle
from reduction.bodies import bent
from reduction.hexes import box

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def beam(elements: int = 20) -> Part:
    return Part.beam(1.0, Rectangle(0.02, 0.01), elements, STEEL, rotary_inertia=True)


def test_free_beam_with_a_force_at_its_tip() -> None:
    """A beam of 1 m, 100 N across one end: M(x) = F (x^2/L - x^3/L^2), 14.4 N m at x = 0.6 m."""
    for elements, tolerance in ((20, 3e-3), (80, 3e-4)):
        part = beam(elements)
        F = np.zeros(part.K.shape[0])
        F[-4] = 100.0
        relief = inertia_relief(part, F)
        # no force, no moment
        rest = part.rigid_modes().T @ relief.loads
        assert np.abs(rest).max() < 1e-11
        assert part.stress is not None
        start = f"e{round(0.6 * elements)}.b."
        label = next(s for s in part.stress.sites if s.startswith(start))
        site = part.stress.select([label])
        # of the beam's own bending stress: M z / Iy
        z = site.positions[0, 2]
        section = Rectangle(0.02, 0.01)
        M = abs(site.evaluate(relief.displacements)[0, 0, 0] * section.Iy / z)
        assert M == pytest.approx(14.4, rel=tolerance)


@pytest.mark.parametrize("make", [bent, box, beam])
def test_relieved_loads_are_in_balance(make: object, rng: np.random.Generator) -> None:
    part: Part = make()  # type: ignore[operator]
    loads = rng.standard_normal((part.K.shape[0], 3))
    relief = inertia_relief(part, loads)
    R = part.rigid_modes()
    size = np.abs(R.T @ loads).max()
    assert np.abs(R.T @ relief.loads).max() < 1e-11 * size
    np.testing.assert_allclose(
        relief.loads, loads - part.M @ (R @ relief.accelerations),
        atol=1e-9 * np.abs(loads).max(),
    )  # fmt: skip
    # equilibrium, and no momentum
    force = part.K @ relief.displacements
    np.testing.assert_allclose(force, relief.loads, atol=1e-7 * np.abs(loads).max())
    momentum = np.abs(R.T @ (part.M @ relief.displacements))
    assert np.all(momentum < 1e-10 * (np.abs(R).T @ (abs(part.M) @ np.abs(relief.displacements))))


def test_loads_of_another_part() -> None:
    with pytest.raises(InputError, match=r"loads has shape \(5,\), must be \(126\)"):
        inertia_relief(beam(), np.zeros(5))


def test_clamp_stress_by_modes() -> None:
    """Tip load on a clamped beam: stress at the clamp over F L h / (2 I).

    By clamped normal modes it is that of the truncated series of 20 elements; with constraint
    modes it is exact (component mode synthesis:
    Braccesi and Cianetti, Proc IMechE D 219 (2005) 633).
    """
    section, F, h, a = Rectangle(0.02, 0.01), 100.0, 0.01, 2
    analytic = F * 1.0 * h / (2.0 * section.Iy)
    part = Part.beam(1.0, section, 20, STEEL, theory=EulerBernoulli(), rotary_inertia=False)
    assert part.stress is not None
    sites = [s for s in part.stress.sites if s.startswith("e1.a.")]
    dofs = np.array([6 * i + row for i in range(1, 21) for row in (2, 4)])
    K, M = (A.toarray()[np.ix_(dofs, dofs)] for A in (part.K, part.M))
    w2, X = scipy.linalg.eigh(K, M)
    f = F * X[-2]
    for k, ratio in {1: 1.13765, 3: 1.02094, 5: 1.00786, 10: 0.99805}.items():
        u = np.zeros(part.K.shape[0])
        u[dofs] = X[:, :k] @ (f[:k] / w2[:k])
        stress = np.abs(part.stress.select(sites).evaluate(u)[:, 0]).max()
        assert stress / analytic == pytest.approx(ratio, abs=5e-6)

    # the reduced part, held where it was clamped
    part = Part.beam(1.0, section, 20, STEEL)
    reduced = reduce(part, CraigBampton(("start", "end"), modes=3))
    assert reduced.stress is not None and reduced.rotations is not None
    Y = np.concatenate([reduced.modes, reduced.rotations], axis=1)
    R = rigid_modes(reduced.nodes, 6).reshape(-1, 6, 6)
    B = np.concatenate([R[0], Y[0]], axis=1)
    A = np.block([[np.diag(np.r_[np.zeros(6), reduced.stiffness]), B.T], [B, np.zeros((6, 6))]])
    right = np.r_[np.concatenate([R[-1, a], Y[-1, a]]) * F, np.zeros(6)]
    p = np.linalg.solve(A, right)[6 : 6 + reduced.n]
    stress = np.abs(reduced.stress.modes[[reduced.stress.labels.index(s) for s in sites], 0] @ p)
    assert stress.max() / analytic == pytest.approx(1.0, abs=1e-9)


def test_gauge_site_is_exact_under_every_load(rng: np.random.Generator) -> None:
    part = bent()
    assert part.stress is not None
    site = part.stress.sites[7]
    method = CraigBampton(("start", "end"), modes=1)
    gauged = CraigBampton(("start", "end"), modes=1, residuals=(site,))
    loads = rng.standard_normal((part.K.shape[0], 4))
    loads[:6] = loads[-6:] = 0.0
    dofs = np.arange(6, part.K.shape[0] - 6)
    u = np.zeros(loads.shape)
    u[dofs] = np.linalg.solve(part.K.toarray()[np.ix_(dofs, dofs)], loads[dofs])
    truth = part.stress.select([site]).evaluate(u)[0]
    error = []
    for m in (method, gauged):
        reduced = reduce(part, m)
        assert reduced.stress is not None and reduced.rotations is not None
        X = np.concatenate([reduced.modes, reduced.rotations], axis=1).reshape(-1, reduced.n)
        R = part.rigid_modes()
        ends = np.r_[0:6, len(X) - 6 : len(X)]
        Y = np.concatenate([R, X], axis=1)
        # both ends held: a null space, then Galerkin
        Z = scipy.linalg.null_space(Y[ends] / np.abs(Y[ends]).max(axis=0))
        Z = Z / np.abs(Y[ends]).max(axis=0)[:, None]
        k = np.diag(np.r_[np.zeros(6), reduced.stiffness])
        p = Z @ np.linalg.solve(Z.T @ k @ Z, Z.T @ (Y.T @ loads))
        found = reduced.stress.modes[reduced.stress.labels.index(site)] @ p[6:]
        error.append(np.abs(found - truth).max() / np.abs(truth).max())
    assert error[0] > 1e-2
    assert error[1] < 1e-8


@pytest.mark.parametrize(
    ("residuals", "message"),
    [
        ("e99.a.top", "no site 'e99.a.top'"),
        ((np.ones(5),), r"a residual load has 5 rows, the part has 60"),
    ],
)
def test_residuals_of_another_part(residuals: object, message: str) -> None:
    part = bent()
    assert part.K.shape[0] == 60
    with pytest.raises(InputError, match=message):
        reduce(part, CraigBampton(("start",), modes=1, residuals=residuals))  # type: ignore[arg-type]


def test_a_part_without_stress_has_no_gauges() -> None:
    part = box().with_interfaces(Interface("a", "left"))
    with pytest.raises(
        InputError, match="residuals contain the stress site 'n1', but the part has no"
    ):
        reduce(part, CraigBampton(modes=1, residuals=("n1",)))


@pytest.mark.parametrize(
    ("residuals", "message"),
    [
        (3.0, "residuals is 3.0, must be load patterns"),
        ((3.0,), "residual 3.0 is neither a load pattern"),
        ((np.full(5, np.nan),), "load pattern.* is nan, must be finite"),
        ((np.zeros(5),), "load pattern 1 has no load in column 0"),
    ],
)
def test_impossible_residuals(residuals: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        CraigBampton(("a",), modes=1, residuals=residuals)  # type: ignore[arg-type]


def test_methods_compare_by_their_loads() -> None:
    one, two = (CraigBampton(("a",), modes=1, residuals=(np.arange(3.0) + k,)) for k in (0, 0))
    other = CraigBampton(("a",), modes=1, residuals=(np.arange(3.0) + 1,))
    assert one == two and hash(one) == hash(two) and repr(one) == repr(two)
    assert one != other and repr(one) != repr(other)
