"""Beam elements in the lanes of vectors: the same numbers as one element at a time.

The complex build computes one element at a time, with the same sources.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from model.test_beam import bent, bodies, element, section, stiffness

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
KINDS = (
    {},
    {"beta": 0.07},
    {"helical": 1},
    {"polar": 0.7},
    {"polar": 0.7, "helical": 1, "beta": 0.07},
    {"share": 0.5, "alpha": 0.9},
)
WEIGHTS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def element_of_kind(rng, i, kind, plain):
    """Return an element between bodies i and i + 1; plain: no offsets, a diagonal stiffness."""
    shape = {"C": stiffness(rng, coupled=not plain)}
    if not plain:
        shape["u"] = 0.2 * rng.normal(size=(2, 3))
        shape["B"] = Rotation.from_rotvec(0.3 * rng.normal(size=(2, 3))).as_matrix()
    return element(
        i,
        i + 1,
        L=rng.uniform(0.7, 1.3),
        e0=0.1 * rng.normal(size=6),
        m=1.7,
        J=(0.5, 0.3, 0.4, 0.02, -0.03, 0.05),
        **shape,
        **kind,
    )


def chain(rng, kinds, plain):
    """Return a model of a chain with an element of each kind."""
    model = bodies(len(kinds) + 1, rng)
    links = [element_of_kind(rng, i, kind, plain[i]) for i, kind in enumerate(kinds)]
    return replace(model, beams=tuple(links))


def assert_as_one_at_a_time(engine):
    """Residual, Newton's matrix, energies and sections agree with the complex build."""
    single = jo.model.Engine(engine.model, complex_scalars=True)
    for name in ("q", "v", "a"):
        getattr(single, name)[:] = getattr(engine, name)
    pairs = [(engine.residual(), single.residual()), (engine.energy(), single.energy())]
    pairs += [(engine.newton_matrix(*w), single.newton_matrix(*w)) for w in WEIGHTS]
    for found, wanted in pairs:
        scale = np.abs(wanted).max()
        np.testing.assert_allclose(found, wanted.real, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("count", range(1, 10))
@pytest.mark.parametrize("kind", KINDS, ids=str)
@pytest.mark.parametrize("plain", [False, True])
def test_groups_with_and_without_empty_lanes(count, kind, plain):
    rng = np.random.default_rng(count)
    engine = bent(chain(rng, [kind] * count, [plain] * count), rng, 0.4)
    assert_as_one_at_a_time(engine)


@pytest.mark.parametrize("seed", range(6))
def test_elements_of_many_kinds_in_one_chain(seed):
    rng = np.random.default_rng(seed)
    kinds = [KINDS[k] for k in rng.integers(len(KINDS), size=11)]
    engine = bent(chain(rng, kinds, rng.integers(2, size=11)), rng, 0.4)
    assert_as_one_at_a_time(engine)


@pytest.mark.parametrize("helical", [0, 1])
def test_small_and_large_rotations_side_by_side(helical):
    """A lane may need closed forms, the other sign of a quaternion, or a series."""
    rng = np.random.default_rng(3)
    model = chain(rng, [{"helical": helical}] * 8, [True] * 8)
    engine = bent(model, rng, 0.01)
    turn = Rotation.identity()
    angles = (0, 2.8, 0.1, 1, 0.6, 0, 2, 0.01)
    for i, (body, angle) in enumerate(zip(model.bodies[1:], angles, strict=True)):
        axis = rng.normal(size=3)
        turn = turn * Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
        e = np.roll(turn.as_quat(), 1)
        engine.q[body.iq + 3 : body.iq + 7] = e if i % 3 else -e
    engine.q[3:7] = [1, 0, 0, 0]
    assert_as_one_at_a_time(engine)


def test_sections_of_each_lane():
    rng = np.random.default_rng(4)
    engine = bent(chain(rng, [KINDS[4]] * 6, [False] * 6), rng, 0.4)
    for i in range(6):
        alone = replace(engine.model, beams=engine.model.beams[i : i + 1])
        other = jo.model.Engine(alone)
        other.q[:], other.v[:] = engine.q, engine.v
        np.testing.assert_allclose(section(engine, i), section(other, 0), rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("which", [0, 2, 5, 8])
def test_the_bent_element_of_a_group_is_named(which):
    rng = np.random.default_rng(5)
    model = chain(rng, [{}] * 9, [True] * 9)
    engine = bent(model, rng, 0.01)
    for body in model.bodies[which + 1 :]:
        engine.q[body.iq + 3 : body.iq + 7] = [0.0, 0.0, 0.0, 1.0]
    for body in model.bodies[: which + 1]:
        engine.q[body.iq + 3 : body.iq + 7] = [1.0, 0.0, 0.0, 0.0]
    with pytest.raises(jo.SimulationError, match=f"element 'element {which + 1}'"):
        engine.residual()


@pytest.mark.parametrize("method", ["rk4", "ros2", "alpha"])
@pytest.mark.parametrize("count", [3, 6])
def test_steps_are_those_of_one_element_at_a_time(method, count):
    """With damping, offsets and all kinds: 20 steps end in the same state."""
    rng = np.random.default_rng(6)
    kinds = [KINDS[k % len(KINDS)] for k in range(count)]
    model = chain(rng, kinds, [k % 2 for k in range(count)])
    ends = []
    for complex_scalars in (False, True):
        engine = jo.model.Engine(model, complex_scalars=complex_scalars)
        engine.q[:] = bent(model, np.random.default_rng(7), 0.2, 0.05).q
        if method == "alpha":
            solver = jo.GeneralizedAlpha(step=1e-3, tangent="exact", tolerance=1e-13)
        else:
            solver = jo.RK4(step=1e-3) if method == "rk4" else jo.ROS2(step=1e-3)
        native = engine.native_solver(
            solver.method, solver.step, solver.projection, **solver.options
        )
        for _ in range(20):
            engine.step(native)
        ends.append(np.concatenate([engine.q, engine.v]))
    np.testing.assert_allclose(ends[0], ends[1].real, rtol=0, atol=1e-10 * np.abs(ends[1]).max())
