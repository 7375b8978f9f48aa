"""Stress recovered from modes: clamped modes, Craig-Bampton, inertia relief, mode acceleration.

The cantilever is 1 m of steel, 20 x 10 mm, of 20 Euler-Bernoulli elements. Modal stress: Braccesi
and Cianetti, Proc. IMechE D 219 (2005) 633-643; mode acceleration: Craig, Structural Dynamics
(1981), section 15. The truncation of the clamped modes is a property of this beam and was computed
from the eigenproblem of the matrices on their own.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

import jousto as jo

L, B, H, N = 1.0, 0.02, 0.01, 20
STEEL = jo.Material(210e9, 0.3, 7850.0)
W = B * H**2 / 6  # section modulus, bending in the xz plane
TRUNCATION = {1: 1.13765, 3: 1.02094, 5: 1.00786, 10: 0.99805}
"""Clamp stress of k clamped normal modes under a static tip load, over F L h / (2 I)."""

# number of clamped modes of the beam in space of which k bend in the xz plane, by their frequencies
IN_SPACE = {1: 1, 3: 5, 5: 8}


def beam(rotary: bool = True) -> jo.Part:
    section, theory = jo.Rectangle(B, H), jo.parts.EulerBernoulli()
    return jo.Part.beam(L, section, N, STEEL, theory=theory, rotary_inertia=rotary)


def in_plane(part: jo.Part) -> np.ndarray:
    """Degrees of freedom uz, ry of all nodes but the first."""
    return np.array([6 * i + j for i in range(1, N + 1) for j in (2, 4)])


def top(part: jo.Part, u: np.ndarray) -> float:
    assert part.stress is not None
    return float(part.stress.evaluate(u)[part.stress.index("e1.a.top"), 0])


@pytest.mark.parametrize("k", TRUNCATION)
def test_clamped_normal_modes_leave_clamp_stress_out(k: int) -> None:
    part, F = beam(rotary=False), 100.0
    d = in_plane(part)
    K, M = part.K.toarray()[np.ix_(d, d)], part.M.toarray()[np.ix_(d, d)]
    w2, X = scipy.linalg.eigh(K, M, subset_by_index=(0, k - 1))
    f = part.load(jo.parts.NodalForce("end", (0, 0, -F)))[d]
    u = np.zeros(6 * (N + 1))
    u[d] = X @ ((X.T @ f) / w2)
    assert top(part, u) / (F * L / W) == pytest.approx(TRUNCATION[k], abs=5e-6)


@pytest.mark.parametrize("modes", [0, 3])
def test_craig_bampton_is_exact_at_the_clamp(modes: int) -> None:
    """The static response to loads on interfaces is in the basis, with its rigid part taken out."""
    part, F = beam(), 100.0
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=modes))
    end, start = reduced.node("end"), reduced.node("start")
    assert reduced.rotations is not None and reduced.stress is not None
    f = (
        -F * reduced.modes[end, 2]
        + F * reduced.modes[start, 2]
        - F * L * reduced.rotations[start, 1]
    )
    p = f / reduced.stiffness
    s = reduced.stress.modes[reduced.stress.labels.index("e1.a.top"), 0] @ p
    assert s / (F * L / W) == pytest.approx(1.0, abs=1e-9)


def test_inertia_relief() -> None:
    """A free beam pushed at its end: M(x) = F (x^2/L - x^3/L^2) of the rigid accelerations."""
    part, F, x = beam(), 100.0, 0.6
    load = part.load(jo.parts.NodalForce("end", (0, 0, F)))
    relief = jo.reduction.inertia_relief(part, load)
    balance = part.rigid_modes().T @ relief.loads[:, 0]
    assert np.abs(balance).max() < 1e-12 * F
    assert part.stress is not None
    # elements are exact for end loads: the moment beside x follows from what acts beyond it
    s = part.stress.evaluate(relief.displacements[:, 0])
    moment = abs(s[part.stress.index("e12.b.top"), 0]) * W
    assert moment == pytest.approx(14.43, abs=0.005)  # the mesh's own, not that of beam theory
    assert moment == pytest.approx(F * (x**2 / L - x**3 / L**2), rel=2.5e-3)
    fine = jo.Part.beam(L, jo.Rectangle(B, H), 2 * N, STEEL, theory=jo.parts.EulerBernoulli())
    u = jo.reduction.inertia_relief(
        fine, fine.load(jo.parts.NodalForce("end", (0, 0, F)))
    ).displacements[:, 0]
    assert fine.stress is not None
    near = abs(fine.stress.evaluate(u)[fine.stress.index("e24.b.top"), 0]) * W
    assert (moment - 14.4) / (near - 14.4) == pytest.approx(4.0, rel=0.03)  # second order


def static(model: jo.Model, step: float = 1e-4) -> jo.Solution:
    """A few instants at rest in equilibrium."""
    state = jo.equilibrium(model)
    return jo.simulate(model, 4 * step, state=state, solver=jo.ROS2(step), output_step=step)


@pytest.mark.filterwarnings("ignore:.*static work")
@pytest.mark.parametrize("k", IN_SPACE)
def test_mode_acceleration_of_a_load_that_no_mode_knows(k: int) -> None:
    part, F = beam(), 1e-3  # small: the clamp stress of a bent beam is another one
    tip = part.load(jo.parts.NodalForce("end", (0, 0, -1.0)))
    method = jo.CraigBampton(("start",), modes=IN_SPACE[k])
    body = jo.FlexibleBody("beam", jo.reduce(part, method, residual_stress={"tip": tip}))
    wall = jo.Fixed("wall", jo.ground["origin"], body["start"])
    model = jo.compile(jo.Mechanism(body, wall, jo.Force("tip", body["end"], (0, 0, -F))))
    run = static(model)
    modes = jo.stress_field(run, "beam").history("e1.a.top")[:, 0] / (F * L / W)
    np.testing.assert_allclose(modes, TRUNCATION[k], atol=5e-5)  # rotary inertia
    for source in (model, True):
        field = jo.stress_field(run, "beam", residual=source, loads={"tip": F})
        np.testing.assert_allclose(field.history("e1.a.top")[:, 0] / (F * L / W), 1.0, atol=1e-9)
        # and everywhere else
        for element in (5, 10, 20):
            s = field.history(f"e{element}.a.top")[:, 0]
            lever = L - L * (element - 1) / N
            np.testing.assert_allclose(s, F * lever / W, rtol=1e-8)


def test_mode_acceleration_of_weight() -> None:
    """One mode, and the stress of the weight is that of the whole mesh."""
    part, g = beam(), np.array([0.0, 1e-3, -2e-3])  # small again
    body = jo.FlexibleBody(
        "beam", jo.reduce(part, jo.CraigBampton(("start",), modes=1), residual_stress=True)
    )
    wall = jo.Fixed("wall", jo.ground["origin"], body["start"])
    model = jo.compile(jo.Mechanism(body, wall, jo.Gravity(g)))
    run = static(model)
    free = np.arange(6, 6 * (N + 1))
    u = np.zeros(6 * (N + 1))
    K = part.K.toarray()
    u[free] = np.linalg.solve(K[np.ix_(free, free)], part.load(jo.parts.Weight(g))[free])
    assert part.stress is not None
    exact = part.stress.evaluate(u)
    scale = np.abs(exact).max()
    field = jo.stress_field(run, "beam", residual=True)
    np.testing.assert_allclose(field.at(2e-4), exact, atol=1e-8 * scale)
    # the mode alone knows nothing of the sideways weight
    alone = jo.stress_field(run, "beam").at(2e-4)
    assert np.abs(alone - exact).max() > 0.25 * scale
    # beam theory: q L^2 / (2 W), less the q h^2 / 12 that the element forces leave out
    q = 7850.0 * B * H * 2e-3
    assert field.history("e1.a.top")[0, 0] == pytest.approx(q * L**2 / (2 * W), rel=1e-3)


def test_mode_acceleration_of_spin() -> None:
    """A bar spins freely; its only mode bends, so that the pull rho w^2 L^2 / 2 is residual."""
    part, spin = beam(), 1.0
    reduced = jo.reduce(part, jo.CraigBampton(("start",), modes=1), residual_stress=True)
    body = jo.FlexibleBody("bar", reduced, angular_velocity=(0, 0, spin))
    pivot = jo.Revolute("pivot", jo.ground["origin"], body["start"])
    model = jo.compile(jo.Mechanism(body, pivot))
    run = jo.simulate(model, 0.02, solver=jo.ROS2(1e-3), output_step=1e-3)
    wanted = 7850.0 * spin**2 * L**2 / 2
    for source in (model, True):
        s = jo.stress_field(run, "bar", residual=source).history("e1.a.left")[:, 0]
        t = jo.stress_field(run, "bar", residual=source).history("e1.a.right")[:, 0]
        np.testing.assert_allclose(0.5 * (s + t), wanted, rtol=2e-3)  # (h / L)^2 of the elements
    np.testing.assert_allclose(
        jo.stress_field(run, "bar").history("e1.a.left")[:, 0], 0.0, atol=1e-6 * wanted
    )


@pytest.mark.parametrize("kind", ["rigid", "average"])
def test_mode_acceleration_of_a_solid(kind: str) -> None:
    """The weight of a solid on an interface: as exact as the modes of inertia relief make it."""
    n, size = (6, 2, 2), (0.4, 0.03, 0.05)
    axes = [np.linspace(0.0, s, k + 1) for s, k in zip(size, n, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corner = np.vstack([corner, corner + [0, 0, 1]]) @ [9, 3, 1]
    first = [9 * i + 3 * j + k for i in range(n[0]) for j in range(n[1]) for k in range(n[2])]
    mesh = jo.Mesh("bar", points, jo.mesh.Cells("hexahedron", np.add.outer(first, corner)))
    end = jo.mesh.InBox((-1e-6, -1, -1), (1e-6, 1, 1))
    part = jo.Part.solid(mesh, STEEL, interfaces=[jo.Interface("hub", end, kind=kind)])

    def stress(residual: bool, relief: bool) -> np.ndarray:
        method = jo.CraigBampton(("hub",), modes=1, inertia_relief=relief)
        reduced = jo.reduce(part, method, residual_stress=residual)
        body = jo.FlexibleBody("bar", reduced, position=(0, -0.015, -0.025))
        wall = jo.Fixed("wall", jo.ground["origin"], body["hub"])
        fall = jo.Gravity((0.01, 0.02, -0.03))
        run = static(jo.compile(jo.Mechanism(body, wall, fall)), 1e-5)
        return jo.stress_field(run, "bar", residual=residual).at(2e-5)

    exact = stress(False, True)
    scale = np.abs(exact).max()
    np.testing.assert_allclose(stress(True, False), exact, atol=1e-6 * scale)
    assert np.abs(stress(False, False) - exact).max() > 0.3 * scale


def test_what_fewer_modes_leave_out_is_kept() -> None:
    part = beam()
    tip = part.load(jo.parts.NodalForce("end", (0, 0, -1.0)))
    whole = jo.reduce(part, jo.CraigBampton(("start",), modes=5), residual_stress={"tip": tip})
    assert whole.stress is not None and whole.stress.residual is not None
    few = whole.keep([0, 2])
    assert few.stress is not None and few.stress.residual is not None
    residual = few.stress.residual
    assert residual.loads == ("tip",) and residual.names[12:] == ("mode 1", "mode 2", "tip")
    # modes and residual together are the static response, whatever the modes
    for reduced in (whole, few):
        stress = reduced.stress
        assert stress is not None and stress.residual is not None
        total = stress.modes @ stress.residual.static + stress.residual.columns
        k = stress.labels.index("e1.a.top")
        assert total[k, 0, -1] == pytest.approx(L / W, rel=1e-9)
        assert abs(total[k, 0, 2]) == pytest.approx(7850 * B * H * L**2 / (2 * W), rel=1e-3)


def test_what_free_modes_leave_out() -> None:
    """Modes and residual of a free part together are the stress of inertia relief."""
    part = beam()
    tip = part.load(jo.parts.NodalForce("end", (3.0, 2.0, -1.0), (0.1, 0.2, 0.3)))
    reduced = jo.reduce(part, jo.FreeFree(modes=3), residual_stress={"tip": tip})
    assert reduced.stress is not None and part.stress is not None
    residual = reduced.stress.residual
    assert residual is not None
    total = (reduced.stress.modes @ residual.static + residual.columns)[:, :, -1]
    exact = part.stress.evaluate(jo.reduction.inertia_relief(part, tip).displacements[:, 0])
    np.testing.assert_allclose(total, exact, atol=1e-8 * np.abs(exact).max())
    assert np.abs(residual.columns[:, :, -1]).max() > 0.1 * np.abs(exact).max()
    # rigid accelerations leave nothing: inertia relief balances them
    rigid = np.abs(residual.columns[:, :, :6]).max()
    assert (
        rigid
        < 1e-7
        * np.abs(
            part.stress.evaluate(
                np.linalg.lstsq(
                    part.K.toarray(), np.asarray(part.M @ part.rigid_modes()), rcond=None
                )[0]
            )
        ).max()
    )


def test_residual_stress_is_saved(tmp_path: Path) -> None:
    part = jo.Part.beam(L, jo.Rectangle(B, H), 2, STEEL)
    tip = part.load(jo.parts.NodalForce("end", (0, 0, -1.0)))
    reduced = jo.reduce(part, jo.CraigBampton(("start",), modes=2), residual_stress={"tip": tip})
    reduced.save(tmp_path / "part.h5")
    again = jo.ReducedPart.load(tmp_path / "part.h5")
    assert reduced.stress is not None and again.stress is not None
    a, b = reduced.stress.residual, again.stress.residual
    assert a is not None and b is not None and a.names == b.names
    np.testing.assert_array_equal(a.columns, b.columns)
    np.testing.assert_array_equal(a.static, b.static)


def test_refusals() -> None:
    part = jo.Part.beam(L, jo.Rectangle(B, H), 2, STEEL)
    method = jo.CraigBampton(("start",), modes=2)
    with pytest.raises(jo.InputError, match=r"load 'tip' has shape \(3,\), must be \(18\)"):
        jo.reduce(part, method, residual_stress={"tip": [0, 0, 1]})
    with pytest.raises(jo.InputError, match="has no stress data"):
        jo.reduce(part.with_stress(None), method, residual_stress=True)
    tip, fall = part.load(jo.parts.NodalForce("end", (0, 0, -1.0))), jo.Gravity((0, 0, -9.81))
    body = jo.FlexibleBody("beam", jo.reduce(part, method, residual_stress={"tip": tip}))
    wall = jo.Fixed("wall", jo.ground["origin"], body["start"])
    run = jo.simulate(jo.compile(jo.Mechanism(body, wall, fall)), 1e-3, solver=jo.ROS2(1e-4))
    with pytest.raises(jo.InputError, match="the history of load 'tip' is missing"):
        jo.stress_field(run, "beam", residual=True)
    with pytest.raises(jo.InputError, match="no load 'top'.*did you mean 'tip'"):
        jo.stress_field(run, "beam", residual=True, loads={"tip": 1.0, "top": 2.0})
    with pytest.raises(jo.InputError, match="has no effect without residual="):
        jo.stress_field(run, "beam", loads={"tip": 1.0})
    plain = jo.FlexibleBody("beam", jo.reduce(part, method))
    wall = jo.Fixed("wall", jo.ground["origin"], plain["start"])
    model = jo.compile(jo.Mechanism(plain, wall, fall))
    with pytest.raises(jo.InputError, match="reduce its part with residual_stress=True"):
        jo.stress_field(jo.simulate(model, 1e-3, solver=jo.ROS2(1e-4)), "beam", residual=True)
