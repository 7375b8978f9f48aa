"""Placement of gauges against all choices, and its zones."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

import jousto as jo
from measurement.twin.cantilever import STEEL


@pytest.fixture(scope="module")
def rod() -> jo.ReducedPart:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, STEEL)
    whole = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=1))
    held = jo.reduction.clamp(whole, "start")
    return held.keep(held.in_plane("xz"))


@pytest.mark.parametrize("criterion", ["D", "I"])
def test_is_the_best_of_all_choices(criterion: str, rng: np.random.Generator) -> None:
    B, S = rng.normal(size=(11, 3)), 1e11 * rng.normal(size=(4, 3))
    G = np.diag([1e-8, 4e-8, 1e-9])

    def value(chosen: tuple[int, ...]) -> float:
        A = 1e12 * B[list(chosen)].T @ B[list(chosen)] + np.linalg.inv(G)
        if criterion == "D":
            return float(np.linalg.slogdet(A)[1])
        return -float(np.sqrt(np.trace(S @ np.linalg.inv(A) @ S.T) / len(S)))

    best = max(value(c) for c in combinations(range(11), 4))
    found = jo.twin.place_gauges(B, 4, criterion=criterion, hot=S, prior=G)
    assert value(tuple(found.index)) == pytest.approx(best, rel=1e-9)
    assert (found.value if criterion == "D" else -found.value) == pytest.approx(best, rel=1e-6)


def test_beam_gauges_avoid_zones_and_one_another(rod: jo.ReducedPart) -> None:
    free = jo.twin.place_gauges(rod, 4)
    assert rod.stress is not None
    at = rod.stress.positions[free.index]
    # bending is largest at the root
    assert at[:, 0].min() < 0.11
    zoned = jo.twin.place_gauges(
        rod,
        4,
        exclude=[jo.mesh.InBox((-1, -1, -1), (0.15, 1, 1)), ((0.5, 0, 0), 0.06)],
        separation=0.15,
    )
    at = rod.stress.positions[zoned.index]
    assert (at[:, 0] > 0.15).all() and (np.abs(at[:, 0] - 0.5) > 0.04).all()
    gaps = [np.linalg.norm(a - b) for a, b in combinations(at, 2)]
    assert min(gaps) >= 0.15 and zoned.value < free.value
    assert "4 gauges, D-optimal" in str(zoned)


def test_trajectory_weighs_the_modes_by_their_motion(rng: np.random.Generator) -> None:
    """Gauges go where the moving modes are: a mode at rest needs none."""
    B = np.vstack([np.eye(3), np.eye(3)])
    p = np.zeros((100, 3))
    p[:, 1] = 1e-3 * rng.normal(size=100)
    found = jo.twin.place_gauges(B, 2, trajectory=p)
    assert sorted(found.index) == [1, 4]
    S = np.array([[0.0, 0.0, 1e11]])
    everything = 1e-3 * rng.normal(size=(100, 3))
    spot = jo.twin.place_gauges(B, 2, criterion="I", hot=S, trajectory=everything)
    assert sorted(spot.index) == [2, 5]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count": 2}, "2 gauges cannot distinguish 3 modes"),
        ({"criterion": "A"}, "criterion is 'A', must be 'D' or 'I'"),
        ({"criterion": "I"}, "needs hot="),
        ({"separation": 0.1}, "need positions="),
        ({"count": 0}, "count is 0"),
        ({"positions": np.zeros((5, 3)), "separation": 0.1}, "only 1 of 3 gauges could be placed"),
        ({"prior": 1.0, "trajectory": np.ones((2, 3))}, "not both"),
        ({"names": ["a"]}, "1 names for 5 candidates"),
    ],
)
def test_refusals(options: dict[str, object], message: str) -> None:
    rows = np.random.default_rng(1).normal(size=(5, 3))
    given = {"count": 3} | options
    with pytest.raises(jo.InputError, match=message):
        jo.twin.place_gauges(rows, **given)  # type: ignore[arg-type]
