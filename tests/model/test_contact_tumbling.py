"""Boxes that tumble past or into each other: instants of touch by separating axes, none missed."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.mechanism import Contact, Cuboid, PowerLaw

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

SIZES = np.array([(0.01, 0.03, 0.06), (0.02, 0.04, 0.05)])
SIGNS = np.array(list(product((-0.5, 0.5), repeat=3)))
TOGETHER, FARTHEST = 0.05, 0.02  # s, instant of the smallest distance of the centres; s after it
TOO_CLOSE = 1e-7  # m, of a gap at its smallest, that samples do not tell from a touch


def overlap(r: Any, R: Any) -> Any:
    """Largest gap (n,) along 15 axes of boxes with centres r (2, n, 3), axes R (2, n, 3, 3), m.

    Gottschalk, Lin and Manocha, Proc. SIGGRAPH 1996: two boxes are apart if a normal of a face of
    one of them or a product of two edges separates them.
    """
    a, b = (np.swapaxes(x, 1, 2) for x in R)
    across = np.cross(a[:, :, None], b[:, None]).reshape(len(a), 9, 3)
    long = np.linalg.norm(across, axis=2, keepdims=True)
    axes = np.concatenate(
        [a, b, np.where(long > 1e-6, across / np.maximum(long, 1e-6), a[:, :1])], 1
    )
    spans = sum(
        np.abs(np.einsum("nki,nij->nkj", axes, x)) @ (0.5 * size)
        for x, size in zip(R, SIZES, strict=True)
    )
    return np.max(np.abs(np.einsum("nki,ni->nk", axes, r[1] - r[0])) - spans, axis=1)


class Flight:
    """Two free boxes with spheres of inertia, so that each turns at a constant velocity.

    Their smallest gap is -`deep`: they graze each other, or just miss.
    """

    def __init__(self, rng: Any, deep: float) -> None:
        self.v = rng.normal(size=(2, 3)) * rng.choice([0.05, 2.0])
        self.w = rng.normal(size=(2, 3)) * rng.choice([0, 100, 300])
        self.turned = Rotation.random(2, random_state=rng)
        aside = rng.normal(size=3)
        near, far = 0.0, 0.1  # m, between the centres when they are together
        for _ in range(20):
            self.at = [np.zeros(3), 0.5 * (near + far) * aside / np.linalg.norm(aside)]
            inside = overlap(*self.pose(np.linspace(0, TOGETHER + FARTHEST, 701))).min() < -deep
            near, far = (0.5 * (near + far), far) if inside else (near, 0.5 * (near + far))

    def pose(self, t: Any) -> tuple[Any, Any]:
        """Centres and axes at the times t (n,)."""
        s = np.asarray(t)[:, None] - TOGETHER
        r = np.array([x + s * v for x, v in zip(self.at, self.v, strict=True)])
        R = [
            (Rotation.from_rotvec(s * w) * turned).as_matrix()
            for w, turned in zip(self.w, self.turned, strict=True)
        ]
        return r, np.array(R)

    def first_touch(self, end: float) -> float:
        """Time at which they touch first, s; infinity for never, nan if that is too close.

        An interval in which they may touch, since they move faster than the gap is wide, is
        divided until it is shorter than 1e-9 s.
        """
        if overlap(*self.pose([0.0]))[0] < 1e-3:
            return np.nan
        radii = 0.5 * np.linalg.norm(SIZES, axis=1)
        fastest = np.linalg.norm(self.v[1] - self.v[0]) + np.linalg.norm(self.w, axis=1) @ radii
        start, length, parts, least = np.zeros(1), end, 1000, np.inf
        while len(start) and length > 1e-9:
            length /= parts
            start = (start[:, None] + length * np.arange(parts)).ravel()
            gaps = np.concatenate(
                [overlap(*self.pose(x)) for x in np.array_split(start, 1 + len(start) // 20000)]
            )
            least = min(least, gaps.min())
            inside = np.flatnonzero(gaps < 0)
            last = inside[0] + 1 if len(inside) else len(start)
            may = gaps[:last] < 2 * fastest * length
            start, parts = start[:last][may], 10
        if least < 0:
            low, high = start[-1] - length, start[-1]  # of the first sample that overlaps
            for _ in range(40):
                middle = 0.5 * (low + high)
                inside = overlap(*self.pose([middle]))[0] < 0
                low, high = (low, middle) if inside else (middle, high)
            return float(high)
        return np.inf if least > TOO_CLOSE else np.nan

    def run(self, step: float, method: Any, resolve: str, end: float) -> Any:
        """The same flight by the engine."""
        (ra, rb), (Ra, Rb) = (x[:, 0] for x in self.pose([0.0]))
        bodies = [
            jo.RigidBody(
                f"b{i}", 1.0, (1e-3,) * 3, position=r, orientation=R, velocity=v, angular_velocity=w
            )
            for i, (r, R, v, w) in enumerate(zip((ra, rb), (Ra, Rb), self.v, self.w, strict=True))
        ]  # fmt: skip
        sides = [
            x for b, size in zip(bodies, SIZES, strict=True) for x in (b["origin"], Cuboid(size))
        ]
        law = PowerLaw(1e7, 1.0, restitution=0.9)
        hit = Contact("hit", *sides, law, resolve=resolve)
        model = jo.compile(jo.Mechanism(*bodies, hit))
        return jo.simulate(model, end, solver=method(step))


METHODS = [(jo.RK4, "cut"), (jo.ROS2, "impulse"), (jo.ROS2, "cut")]


# of the second box when they are together: place, then of both: velocities, turning velocities,
# rotation vectors; method, step, about the instant of touch
FOUND = [
    (
        (-0.033674, 0.035006, 0.030304),
        [(1.47884, 0.4737, 1.24889), (-3.83145, 2.35826, -3.21189)],
        [(0, 0, 0), (0, 0, 0)],
        [(-0.47572, 1.70866, 1.79703), (0.711, -0.11665, -1.74219)],
        *(2, 0.0148, 0.0493898),
    ),
    (
        (0.003056, -0.027327, -0.058017),
        [(0.73647, -0.65586, 2.87037), (-3.37424, -0.562, 0.17821)],
        [(0, 0, 0), (0, 0, 0)],
        [(1.11841, 1.64776, 0.07778), (-0.59618, 0.43645, -0.48265)],
        *(0, 0.0197, 0.0470701),
    ),
    (
        (0.028079, -0.043213, -0.025895),
        [(0.03063, -0.09888, 0.02797), (0.08122, -0.0058, -0.02719)],
        [(-20.8394, 121.5266, -22.2556), (-83.8803, -175.5923, 140.6776)],
        [(-0.02299, 2.44423, -0.50201), (-2.06945, -1.59791, -0.04707)],
        *(0, 0.0067, 0.0424668),
    ),
]


@pytest.mark.parametrize("count", [6, pytest.param(300, marks=pytest.mark.slow)])
def test_tumbling_boxes_touch_when_no_axis_separates_them(count):
    """Steps in which the boxes turn by up to half a revolution."""
    rng = np.random.default_rng(5)
    hits = flights = 0
    while flights < count:
        flight = Flight(rng, rng.choice([-1e-3, 2e-5, 1e-3]))
        touch = flight.first_touch(TOGETHER + FARTHEST)
        if np.isnan(touch):
            continue
        method, resolve = METHODS[flights % len(METHODS)]
        step = 10 ** rng.uniform(-3, -1.7)
        whole = step * np.ceil(touch / step)  # they may part again within this step
        run = flight.run(step, method, resolve, min(whole, TOGETHER + FARTHEST))
        found = [one.time for one in run.events] or [one.touch for one in run.contacts]
        if np.isfinite(touch):
            assert found and found[0] == pytest.approx(touch, abs=1e-11)
            hits += 1
        else:
            assert not found
            assert run.attributes["contacts"] == "missed: 0 (proven)"
        flights += 1
    assert count / 4 < hits < count


@pytest.mark.parametrize("flight", FOUND)
def test_touches_once_missed(flight):
    """Grazes of edges, and a second touch within the step of the first, that were once missed."""
    at, v, w, turned, method, step, touch = flight
    one = Flight.__new__(Flight)
    one.at, one.v, one.w = [np.zeros(3), np.array(at)], np.array(v), np.array(w)
    one.turned = Rotation.from_rotvec(turned)
    expected = one.first_touch(TOGETHER + FARTHEST)
    assert expected == pytest.approx(touch, abs=1e-6)
    run = one.run(step, *METHODS[method], step * np.ceil(expected / step))
    found = [e.time for e in run.events] or [e.touch for e in run.contacts]
    assert found[0] == pytest.approx(expected, abs=1e-11)
    assert run.attributes["contacts"] == "missed: 0 (proven)"


def test_edges_on_far_sides_are_no_points_of_contact():
    """An edge over the border of a face that is far from parallel to the faces beside the edge.

    Edges of the far side cross the border of this face as well; taken for a point of contact they
    were 42 mm deep at once.
    """
    at = [(-0.01334053, 0.01945361, -0.00580742), (-0.0213739, 0.0120727, 0.0297607)]
    turned = [(1.04882514, -0.42348318, 2.11240196), (2.30673912, -0.14760335, 2.02406891)]
    bodies = [
        jo.RigidBody(
            f"b{i}", 1.0, (1e-3,) * 3, position=r, orientation=Rotation.from_rotvec(u).as_matrix()
        )
        for i, (r, u) in enumerate(zip(at, turned, strict=True))
    ]
    sides = [x for b, size in zip(bodies, SIZES, strict=True) for x in (b["origin"], Cuboid(size))]
    hit = Contact("hit", *sides, PowerLaw(1e7, 1.0, restitution=0.9))
    run = jo.simulate(jo.compile(jo.Mechanism(*bodies, hit)), 1e-7, solver=jo.ROS2(1e-7))
    assert len(run.contacts) > 0
    assert all(0 < one.depth < 1e-5 for one in run.contacts)
