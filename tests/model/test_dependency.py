"""Rank analysis body after body against one singular value decomposition, and its advice."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.native import Engine
from jousto.model.rank.dependency import dependencies, joint_fronts
from jousto.model.rank.redundancy import DENSE, RANK, repeated_rows, unit_rows
from verification.iftomm import bricard, four_bars
from verification.mechanisms import loop

Z = (0.0, 0.0, 1.0)


def windows(count: int, freed: dict[str, str] | None = None) -> jo.Mechanism:
    """Planar four-bars in a row, all of revolute joints: three rows of each repeat others.

    Joints named in `freed` become spherical or universal.
    """
    reach = np.array([0.5, 0.8, 0.0])
    items: list[object] = []

    def bar(name: str, start: np.ndarray, end: np.ndarray) -> jo.RigidBody:
        length = float(np.linalg.norm(end - start))
        x = (end - start) / length
        body = jo.RigidBody(
            name,
            length,
            (1e-3, length**3 / 12.0, length**3 / 12.0),
            center=(length / 2.0, 0, 0),
            markers={"start": (0, 0, 0), "end": (length, 0, 0)},
            position=start,
            orientation=np.column_stack([x, np.cross(Z, x), Z]),
        )
        items.append(body)
        return body

    def pin(name: str, a: jo.Marker, b: jo.Marker) -> None:
        kind = (freed or {}).get(name, "revolute")
        if kind == "spherical":
            items.append(jo.Spherical(name, a, b))
        elif kind == "universal":
            items.append(jo.Universal(name, a, b, (0, 1, 0), Z))
        else:
            items.append(jo.Revolute(name, a, b, Z))

    feet = [np.array([float(k), 0.0, 0.0]) for k in range(count + 1)]
    posts = [bar(f"post{k}", foot, foot + reach) for k, foot in enumerate(feet)]
    for k, foot in enumerate(feet):
        pin(f"foot{k}", jo.ground.at(foot), posts[k]["start"])
    for k in range(count):
        deck = bar(f"deck{k}", feet[k] + reach, feet[k + 1] + reach)
        pin(f"left{k}", posts[k]["end"], deck["start"])
        pin(f"right{k}", deck["end"], posts[k + 1]["end"])
    return jo.Mechanism(*items, jo.Gravity((0, -9.81, 0)))


def compiled(mechanism: jo.Mechanism) -> jo.Model:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return jo.compile(mechanism)


def test_windows_warn_of_too_many_rows() -> None:
    with pytest.warns(jo.JoustoWarning, match="rows"):
        jo.compile(windows(1))


CASES = {
    "windows": (lambda: windows(3), 9),
    "bricard": (bricard, 1),  # mobility 1 of 5 bodies and 6 revolute joints: 30 - 30 + 1
    "regular": (lambda: four_bars(3), 0),
    "flexible loop": (loop, 0),
}


@pytest.mark.parametrize("name", CASES)
def test_body_after_body_finds_what_one_decomposition_finds(name: str) -> None:
    build, count = CASES[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        model = jo.compile(build())
    engine = Engine(model)
    G = unit_rows(model, engine)
    Y = dependencies(joint_fronts(model, engine, model.permanent), len(model.bodies), RANK)
    assert Y.shape[1] == count == len(G) - np.linalg.matrix_rank(G, tol=RANK)
    np.testing.assert_allclose(Y.T @ G, 0.0, atol=1e-12)
    np.testing.assert_allclose(Y.T @ Y, np.eye(count), atol=1e-12)


def freed(advice: tuple[str, ...]) -> dict[str, str]:
    """Joint and new kind from sentences ``replace the revolute joint 'x' by a spherical one``."""
    out = {}
    for text in advice:
        words = text.split()
        out[words[4].strip("'")] = words[-2]
    return out


def test_advice_for_a_large_mechanism_makes_every_row_independent() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        mechanism = windows(30)
        model = jo.compile(mechanism)
        assert model.nrow == 5 * 91 > DENSE
        found = repeated_rows(model)
        assert found is not None
        assert (found.count, found.mobility, found.only_here) == (90, 1, False)
        assert len(found.joints) == 91
        kinds = freed(found.advice)
        free = {"universal": 1, "spherical": 2}
        assert sum(free[kind] for kind in kinds.values()) == 90
    # the same rows without those that the advice frees, which the engine factors as they are
    better = jo.compile(windows(30, kinds))
    assert not better.redundant
    assert better.nv - better.nrow == 1


def test_a_long_list_of_joints_is_cut() -> None:
    with pytest.warns(jo.JoustoWarning) as caught:
        jo.compile(windows(12))
    text = str(caught[-1].message)
    assert "36 of the constraint rows of 'foot0', " in text
    assert ", 13 more are redundant" in text


# -- long chains: as many free motions as hinges, at any length --------------------------------


def chain(count: int, bend: float = 0.0, closed: bool = False) -> jo.Mechanism:
    """Bars of 1 m and 1 kg on hinges along z, the first on the ground, if `closed` the last too."""
    items: list[object] = []
    end, tip = jo.ground["origin"], np.zeros(3)
    for k in range(count):
        turn = bend * np.sin(0.31 * k)
        bar = jo.RigidBody(
            f"bar{k}",
            1.0,
            (1e-2, 1e-2, 1e-2),
            markers={"start": (0, 0, 0), "end": (1, 0, 0)},
            position=tip,
            orientation=jo.Rotate(Z, radians=turn),
        )
        items += [bar, jo.Revolute(f"pin{k}", end, bar["start"], Z)]
        end, tip = bar["end"], tip + [np.cos(turn), np.sin(turn), 0.0]
    if closed:
        items.append(jo.Revolute("last", end, jo.ground.at(tip), Z))
    return jo.Mechanism(*items)


@pytest.mark.parametrize("bend", [0.0, 0.7])
@pytest.mark.parametrize("count", [1500, pytest.param(30_000, marks=pytest.mark.slow)])
def test_long_chains_are_regular_and_turn_at_every_hinge(count: int, bend: float) -> None:
    model = jo.compile(chain(count, bend))
    assert not model.redundant
    assert model.nv - model.nrow == count
    assert jo.doctor(model).moving == tuple(body.name for body in model.bodies)


@pytest.mark.parametrize("count", [40, 200])
def test_a_closed_chain_repeats_three_rows_at_any_length(count: int) -> None:
    """Its hinges are parallel: one translation and two rotations are held twice."""
    found = repeated_rows(compiled(chain(count, 0.9, closed=True)))
    assert found is not None
    assert (found.count, found.mobility, len(found.joints)) == (3, count - 2, count + 1)
