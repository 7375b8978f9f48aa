"""Mass: totals of solids, merged points, point masses, the matrix from the points."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli, Timoshenko
from jousto.parts.frames.members import Member
from jousto.parts.mass import MassPoints, PointMass
from jousto.parts.part import Part
from jousto.sections.section import Circle, Rectangle, Section, Tube

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
L = 0.8


def block(m: float) -> np.ndarray:
    a, b, c = L, 0.1, 0.2
    return m / 12 * np.diag([b**2 + c**2, a**2 + c**2, a**2 + b**2])


def cylinder(m: float) -> np.ndarray:
    r = 0.05
    return m * np.diag([r**2 / 2, *2 * [r**2 / 4 + L**2 / 12]])


def pipe(m: float) -> np.ndarray:
    r2 = 0.05**2 + 0.03**2
    return m * np.diag([r2 / 2, *2 * [r2 / 4 + L**2 / 12]])


SOLIDS = (
    (Rectangle(0.1, 0.2), 0.02, block),
    (Circle(0.1), np.pi * 0.05**2, cylinder),
    (Tube(0.1, 0.02), np.pi * (0.05**2 - 0.03**2), pipe),
)


@pytest.mark.parametrize("elements", [1, 3])
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("theory", [EulerBernoulli(), Timoshenko()])
@pytest.mark.parametrize(("section", "area", "inertia"), SOLIDS)
def test_solids(
    section: Section, area: float, inertia: object, theory: object, seed: int, elements: int
) -> None:
    # Goldstein's tables of solids; a rotated and moved beam, carried by offset nodes
    rng = np.random.default_rng(seed)
    A, r, arms = (
        Rotation.random(random_state=seed).as_matrix(),
        rng.normal(size=3),
        (1.0, -2.0, 0.5),
    )
    for lumped in (False, True):
        part = Part.from_members(
            [
                Member(
                    r - np.array(arms),
                    r + L * A[:, 0],
                    section,
                    STEEL,
                    elements=elements,
                    orientation=A[:, 2],
                    start_offset=arms,
                )
            ],
            theory=theory,  # type: ignore[arg-type]
            lumped=lumped,
        )
        m = STEEL.rho * area * L
        J = inertia(m)  # type: ignore[operator]
        if lumped:
            # two half masses at the ends of each element instead of the slender rod
            J = J + m * L**2 / (6 * elements**2) * np.diag([0.0, 1.0, 1.0])
        assert part.mass == pytest.approx(m, rel=1e-12)
        assert_allclose(part.center, r + 0.5 * L * A[:, 0], rtol=1e-11)
        assert_allclose(part.inertia, A @ J @ A.T, atol=1e-10 * np.trace(J))


def test_pendulum_of_five_nodes() -> None:
    # Rantalainen 2007, chapter 5: nodal masses, the last node 1e-5 m below the axis
    nodes = [(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (1.5, 0, 0), (2, -1e-5, 0)]
    part = Part.frame(
        nodes,
        [(0, 1), (1, 2), (2, 3), (3, 4)],
        sections=Rectangle(0.1, 0.1),
        materials=STEEL,
        lumped=True,
        rotary_inertia=False,
        theory=EulerBernoulli(),
    )
    points = part.mass_points
    assert points is not None
    # the last element is longer by 1e-10 m, which is 4e-9 kg at its end
    assert_allclose(points.mass, [19.625, 39.25, 39.25, 39.25, 19.625], atol=5e-9)
    assert_array_equal(points.second_moment, 0.0)
    assert_array_equal(points.position, nodes)
    assert_allclose(
        part.M.diagonal(), np.repeat(points.mass, 2).repeat(3) * np.tile([1, 1, 1, 0, 0, 0], 5)
    )


def brute_force(points: MassPoints, d: np.ndarray) -> float:
    """Twice the kinetic energy of particles whose second moments are those of the points."""
    total = 0.0
    for i in range(len(points)):
        values, axes = np.linalg.eigh(points.second_moment[i])
        m = points.mass[i]
        u, w = points.N[3 * i : 3 * i + 3] @ d, points.N_rot[3 * i : 3 * i + 3] @ d
        # six particles, a pair on each principal axis
        for value, axis in zip(values, axes.T, strict=True):
            s = np.sqrt(max(value, 0.0) / (m / 3)) * axis
            total += sum(m / 6 * np.sum((u + np.cross(w, x)) ** 2) for x in (s, -s))
    return total


@pytest.mark.parametrize("lumped", [False, True])
def test_matrix_is_the_kinetic_energy_of_the_points(lumped: bool) -> None:
    rng = np.random.default_rng(4)
    part = Part.frame(
        rng.normal(size=(4, 3)),
        [(0, 1), (1, 2), (1, 3)],
        sections=[Rectangle(0.1, 0.2), Circle(0.1), Tube(0.1, 0.02)],
        materials=STEEL,
        offsets=0.1 * rng.normal(size=(3, 2, 3)),
        lumped=lumped,
        point_masses=[PointMass("node4", 5.0, inertia=(0.1, 0.2, 0.25), offset=(0.1, 0.2, 0.3))],
    )
    points = part.mass_points
    assert points is not None
    assert points.mass.sum() == pytest.approx(part.mass, rel=1e-13)
    for _ in range(3):
        d = rng.normal(size=24)
        assert brute_force(points, d) == pytest.approx(d @ (part.M @ d), rel=1e-11)


def test_lumped_masses_of_a_node_are_one_point() -> None:
    offset = np.array([0.0, 0.3, 0.0])
    J = np.diag([0.5, 0.6, 0.7])
    part = Part.beam(
        L,
        Rectangle(0.1, 0.2),
        1,
        STEEL,
        lumped=True,
        rotary_inertia=False,
        point_masses=[PointMass("end", 40.0, inertia=J, offset=offset)],
    )
    points = part.mass_points
    assert points is not None and len(points) == 2
    half = STEEL.rho * 0.02 * L / 2
    assert points.mass[1] == pytest.approx(half + 40.0)
    c = 40.0 * 0.3 / (half + 40.0)
    assert_allclose(points.position[1], [L, c, 0.0], rtol=1e-13)
    # parallel axes, Steiner
    steiner = half * c**2 + 40.0 * (0.3 - c) ** 2
    assert_allclose(points.inertia[1], J + steiner * np.diag([1, 0, 1]), rtol=1e-12, atol=1e-14)


def test_point_mass_alone_on_a_consistent_beam() -> None:
    J = np.array([[2.0, 0.1, 0.0], [0.1, 2.5, 0.2], [0.0, 0.2, 3.0]])
    light = Material(E=210e9, nu=0.3, rho=0.0)
    part = Part.beam(L, Circle(0.1), 2, light, point_masses=[PointMass(2, 7.0, J, (0.1, 0.2, 0.3))])
    assert part.mass == pytest.approx(7.0, rel=1e-14)
    assert_allclose(part.center, [L + 0.1, 0.2, 0.3], rtol=1e-13)
    assert_allclose(part.inertia, J, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"mass": -1.0}, "mass is -1 kg"),
        ({"mass": float("nan")}, "mass is nan kg"),
        ({"mass": 1.0, "inertia": (1.0, 1.0, 3.0)}, "none may exceed the sum"),
        ({"mass": 1.0, "inertia": (-1.0, 1.0, 1.0)}, "must not be negative"),
        ({"mass": 1.0, "inertia": [[1, 1, 0], [0, 1, 0], [0, 0, 1]]}, "not symmetric"),
        ({"mass": 1.0, "inertia": (1.0, 1.0)}, "inertia has shape (2,)"),
        ({"mass": 1.0, "offset": (1.0, 0.0)}, "offset has shape (2,)"),
        ({"mass": 1.0, "offset": (1.0, 0.0, float("nan"))}, "offset[2] is nan"),
    ],
)
def test_bad_point_masses(keywords: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as caught:
        PointMass("end", **keywords)  # type: ignore[arg-type]
    assert message in str(caught.value)
    assert "point mass at node 'end'" in str(caught.value)
