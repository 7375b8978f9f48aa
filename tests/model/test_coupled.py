"""Masses that beams couple: accelerations by the block LU, ROS2 with the stiffness of beams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from jousto.model.model import BeamModel
from jousto.model.native.native import displaced

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def beam_model(name, a, b, *, C=None, share=0.0, L=0.1, m=0.0, beta=0.0):
    """Return an element between the origins of bodies a and b, which lie along x."""
    data = np.zeros(78)
    data[0] = L
    data[4:13] = data[16:25] = np.eye(3).ravel()
    data[25:61] = np.zeros(36) if C is None else np.ravel(C)
    data[67], data[69], data[70] = beta, share, m
    return BeamModel(name, "beam", a, b, data)


def cable(n=8, *, E=2e9, clamped=True, beta=0.0, share=0.0, offset=0.0):
    """Return a beam of n elements, 1 m x 10 mm x 10 mm, that falls from the horizontal.

    Its axis lies `offset` beside its nodes.
    """
    L, A, second = 1.0 / n, 1e-4, 1e-8 / 12
    nodes = [
        jo.RigidBody(
            f"node{i}",
            1000.0 * A * L * (0.5 if i in (0, n) else 1.0),
            1000.0 * L * second * np.eye(3) * (0.5 if i in (0, n) else 1.0),
            center=(0, offset, 0),
            position=(i * L, 0, 0),
        )
        for i in range(n + 1)
    ]
    root = jo.Fixed if clamped else jo.Spherical
    model = jo.compile(
        jo.Mechanism(
            *nodes,
            root("root", jo.ground["origin"], nodes[0]["origin"]),
            jo.Gravity((0, 0, -9.81)),
            jo.PositionSensor("tip", nodes[n]["origin"]),
        )
    )
    C = np.diag([E * A, 0.32 * E * A, 0.32 * E * A, 0.6 * E * second, E * second, E * second])
    kind = {"C": C, "L": L, "beta": beta, "share": share, "m": 1000.0 * A * L}
    beams = [beam_model(f"e{i}", i, i + 1, **kind) for i in range(n)]
    for beam in beams:
        beam.data[71:74] = 1000.0 * L * second
        beam.data[2] = beam.data[14] = offset
    return replace(model, beams=tuple(beams))


@pytest.mark.parametrize(("beta", "share"), [(0.0, 0.0), (1e-4, 0.0), (1e-4, 1.0)])
@pytest.mark.parametrize("clamped", [True, False])
def test_ros2_with_beams_is_of_order_two(clamped, beta, share):
    model = cable(4, clamped=clamped, beta=beta, share=share, E=2e7)
    tips = [
        jo.simulate(model, t_end=0.1, solver=jo.ROS2(step=h))["tip"][-1]
        for h in (4e-4, 2e-4, 1e-4, 5e-5)
    ]
    first, second, third = (np.linalg.norm(b - a) for a, b in zip(tips, tips[1:], strict=False))
    assert third < 2e-5
    assert 3.2 < second / third < 6.0
    assert 3.2 < first / second < 8.0


def test_ros2_agrees_with_the_implicit_method():
    model = cable(6, clamped=False)
    ros2 = jo.simulate(model, t_end=0.1, solver=jo.ROS2(step=1e-4))["tip"][-1]
    alpha = jo.simulate(model, t_end=0.1, solver=jo.GeneralizedAlpha(step=1e-4))["tip"][-1]
    assert np.linalg.norm(ros2 - alpha) < 2e-6


@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_ros2_damps_what_the_step_does_not_resolve(step):
    """Axial waves of 2e11 Pa pass an element in 9e-6 s: the step is more than 100 times longer."""
    model = cable(8, E=2e11, clamped=False)
    run = jo.simulate(model, t_end=0.4, solver=jo.ROS2(step=step))
    total = run.energy.total
    scale = float(np.ptp(run.energy.potential))
    assert total.max() - total[0] < 1e-3 * scale
    assert np.isfinite(run["tip"]).all()
    assert run.energy.strain.max() < 0.05 * scale
    length = np.linalg.norm(run["tip"], axis=1)
    assert np.abs(length - 1.0).max() < 0.05


def four_bar(joints=jo.Revolute):
    """Return a four-bar linkage whose bars stay in the plane by every joint, and its friction."""
    bar = {"a": (-0.5, 0, 0), "b": (0.5, 0, 0)}
    inertia = (0.01, 0.1, 0.1)
    turned = (np.cos(np.pi / 4), 0, 0, np.sin(np.pi / 4))
    left = jo.RigidBody("left", 1.0, inertia, position=(0, 0.5, 0), orientation=turned, markers=bar)
    top = jo.RigidBody("top", 1.0, inertia, position=(0.5, 1, 0), markers=bar)
    right = jo.RigidBody(
        "right", 1.0, inertia, position=(1, 0.5, 0), orientation=turned, markers=bar
    )
    ends = [
        (jo.ground["origin"], left["a"]),
        (left["b"], top["a"]),
        (top["b"], right["b"]),
        (jo.ground.at((1, 0, 0)), right["a"]),
    ]
    pins = [joints(f"pin{i}", a, b, axis=(0, 0, 1)) for i, (a, b) in enumerate(ends)]
    return jo.Mechanism(
        left,
        top,
        right,
        *pins,
        jo.Friction("rub", pins[0], 0.3, law=jo.mechanism.Regularised(1e-2), radius=0.05),
        jo.Gravity((0, -9.81, 0)),
    )


def test_block_lu_and_schur_complement_agree():
    """An element without stiffness and with a share of 1e-30 changes the way, not the result."""
    model = jo.compile(four_bar())
    assert model.redundant
    light = replace(model, beams=(beam_model("e", 0, 1, share=1e-30, m=1e-3),))
    found = []
    for one in (model, light):
        engine = jo.model.Engine(one)
        engine.v[:] = 0.0
        engine.assemble()
        engine.v[model.bodies[0].iv + 5] = -40.0
        engine.assemble()
        a, lam = engine.accelerations()
        found.append((np.array(a), np.array(lam)))
    (a, lam), (b, mu) = found
    assert np.abs(a).max() > 0.01
    np.testing.assert_allclose(b, a, rtol=0, atol=1e-9 * np.abs(a).max())
    np.testing.assert_allclose(mu, lam, rtol=0, atol=1e-7 * np.abs(lam).max())


@pytest.mark.parametrize("clamped", [True, False])
def test_consistent_mass_gives_accelerations_without_residual(clamped):
    model = cable(5, clamped=clamped, share=1.0, beta=1e-3, E=2e6)
    rng = np.random.default_rng(1)
    engine = jo.model.Engine(model)
    engine.v[:] = 0.5 * rng.normal(size=model.nv)
    engine.assemble()
    a, lam = engine.accelerations()
    assert np.abs(lam).max() > 0.01
    assert np.abs(engine.residual()).max() < 1e-9 * np.abs(lam).max()
    # joints: the rates stay at zero
    h = 1e-6
    rates = []
    for sign in (1.0, -1.0):
        twin = jo.model.Engine(model)
        move = sign * h * (engine.v + 0.5 * sign * h * a)
        twin.q[:] = displaced(model, engine.q, move)
        twin.v[:] = engine.v + sign * h * a
        rates.append(twin.constraints()[1])
    assert np.abs(rates[0] - rates[1]).max() / (2 * h) < 1e-6 * np.abs(a).max()


def test_consistent_and_lumped_mass_differ():
    found = [jo.model.Engine(cable(5, share=s, E=2e6)).accelerations()[0] for s in (0.0, 1.0)]
    assert np.abs(found[0] - found[1]).max() > 1e-3 * np.abs(found[0]).max()


def test_explicit_methods_and_the_implicit_one_agree_with_consistent_mass():
    model = cable(3, clamped=False, share=1.0, E=2e5)
    tips = [
        jo.simulate(model, t_end=0.05, solver=solver)["tip"][-1]
        for solver in (jo.RK4(step=2e-5), jo.ROS2(step=5e-5), jo.GeneralizedAlpha(step=5e-5))
    ]
    assert np.linalg.norm(tips[1] - tips[0]) < 1e-6
    assert np.linalg.norm(tips[2] - tips[0]) < 1e-6


def whirl(**options):
    """Return tip and iterations of a beam that turns fast about its root."""
    model = cable(4, clamped=False, E=2e11, offset=0.05)
    for body in model.bodies:
        model.v0.setflags(write=True)
        model.v0[body.iv : body.iv + 6] = (0, 40.0 * model.q0[body.iq], 0, 0, 0, 40.0)
    solver = jo.GeneralizedAlpha(step=1e-3, **{"tangent": "exact", "tolerance": 1e-10, **options})
    run = jo.simulate(model, t_end=0.05, solver=solver)
    return run["tip"], float(run.work.iterations[-1])


def test_tangents_of_the_inertia_save_iterations_and_change_nothing_else():
    tip, count = whirl()
    same, more = whirl(inertia_tangents=False)
    assert np.abs(tip - same).max() < 1e-8
    assert np.abs(tip[-1] - tip[0]).max() > 0.1
    assert more > 1.2 * count


def test_modified_newton_keeps_factors_of_either_matrix():
    tip, _ = whirl()
    for exact in (True, False):
        same, _ = whirl(tangent="modified", inertia_tangents=exact)
        assert np.abs(tip - same).max() < 1e-7


def test_a_stiff_beam_starts_with_few_iterations():
    """Accelerations a fraction of a step later, taken explicitly, once strained it out of sight."""
    model = cable(16, E=2e11)
    run = jo.simulate(model, t_end=0.02, solver=jo.GeneralizedAlpha(step=1e-3))
    assert run.work.iterations[-1] <= 4 * 20


def test_inertia_tangents_must_be_a_truth_value():
    with pytest.raises(jo.InputError, match="inertia_tangents is 'no', must be True or False"):
        jo.GeneralizedAlpha(inertia_tangents="no")


def test_the_sparse_matrix_is_the_dense_one():
    model = cable(6, clamped=False, share=1.0, offset=0.1)
    engine = jo.model.Engine(model)
    engine.accelerations()
    for weights in ((1.0, 0.0, 0.0), (0.3, 0.2, 0.1)):
        dense = engine.newton_matrix(*weights)
        sparse = engine.newton_sparse(*weights)
        np.testing.assert_array_equal(sparse.toarray(), dense)
    four = jo.model.Engine(jo.compile(four_bar()))
    four.accelerations()
    dense = four.newton_matrix(1.0, 0.1, 0.1)
    np.testing.assert_array_equal(four.newton_sparse(1.0, 0.1, 0.1).toarray(), dense)


def test_the_sparse_matrix_of_a_long_beam_grows_with_it():
    model = cable(400, clamped=True)
    matrix = jo.model.Engine(model).newton_sparse(1.0, 1e-3, 1e-6)
    assert matrix.nnz < 401 * 6 * 6 * 5


def test_block_lu_and_schur_complement_agree_in_space():
    """Both axes of each row of a hinge turn: ``2 f' . h'`` is a part of its acceleration."""
    sizes = {"inertia": (0.2, 0.3, 0.4), "center": (0.3, 0.1, 0.0)}
    one, two = (jo.RigidBody(f"b{i}", 1.0 + i, position=(i, 0, 0), **sizes) for i in range(2))
    pins = [
        jo.Spherical("ball", jo.ground["origin"], one["origin"]),
        jo.Revolute("pin", one.at((1, 0, 0)), two["origin"], axis=(1, 0, 0)),
    ]
    model = jo.compile(jo.Mechanism(one, two, *pins, jo.Gravity((0, 0, -9.81))), core="maximal")
    found = []
    for beams in ((), (beam_model("e", 0, 1, share=1e-30, m=1e-3, L=1.0),)):
        engine = jo.model.Engine(replace(model, beams=beams))
        engine.v[:] = np.random.default_rng(3).normal(size=model.nv)
        engine.assemble()
        a, lam = engine.accelerations()
        found.append((np.array(a), np.array(lam)))
    (a, lam), (b, mu) = found
    np.testing.assert_allclose(b, a, rtol=0, atol=1e-9 * np.abs(a).max())
    np.testing.assert_allclose(mu, lam, rtol=0, atol=1e-7 * np.abs(lam).max())
