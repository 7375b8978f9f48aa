"""compile: consistent starts, sentences for singular models, shared arrays."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

import jousto as jo
from jousto.model.elimination_order import eliminate
from jousto.model.native import library
from jousto.simulation.results.row_layout import columns


def rigid(name, **kwargs):
    return jo.RigidBody(name, 2.0, (0.02, 0.2, 0.2), markers={"tip": (1, 0, 0)}, **kwargs)


def test_small_gaps_are_closed_before_the_run():
    body = rigid("rod", position=(0, 3e-8, 0))
    mechanism = jo.Mechanism(body, jo.Spherical("p", jo.ground["origin"], body["origin"]))
    model = jo.compile(mechanism)
    assert jo.model.Engine(model).residuals()[0] < 1e-15
    assert not model.q0.flags.writeable


def test_contradicting_velocities_are_replaced_with_a_warning():
    body = rigid("rod", velocity=(1, 0, 0), angular_velocity=(0, 0, 2))
    mechanism = jo.Mechanism(body, jo.Spherical("p", jo.ground["origin"], body["origin"]))
    with pytest.warns(jo.JoustoWarning, match="velocities of 'rod' contradict the joints"):
        model = jo.compile(mechanism)
    np.testing.assert_allclose(model.v0[:3], 0.0, atol=1e-14)
    assert jo.model.Engine(model).residuals()[1] < 1e-14


def test_consistent_velocities_are_kept_silently():
    body = rigid("rod", angular_velocity=(0, 3, 2))
    mechanism = jo.Mechanism(body, jo.Spherical("p", jo.ground["origin"], body["origin"]))
    model = jo.compile(mechanism)
    np.testing.assert_allclose(model.v0, [0, 0, 0, 0, 3, 2], atol=1e-14)


def test_redundant_joints_are_named():
    body = rigid("door", angular_velocity=(1, 0, 0))
    upper = jo.Revolute("upper", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    lower = jo.Revolute("lower", jo.ground.at((1, 0, 0)), body["tip"], axis=(1, 0, 0))
    mechanism = jo.Mechanism(body, upper, lower)
    with pytest.warns(jo.JoustoWarning, match=r"5 of the constraint rows of 'upper', 'lower'"):
        jo.compile(mechanism)


def test_bodies_of_one_part_share_their_arrays():
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 4, jo.Material(E=2e11, nu=0.3, rho=7850))
    rod = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=2))
    a = jo.FlexibleBody("a", rod, damping=0.01)
    b = jo.FlexibleBody("b", rod, position=(1, 0, 0), damping=0.02)
    mechanism = jo.Mechanism(
        a,
        b,
        jo.Spherical("p", jo.ground["origin"], a["start"]),
        jo.Spherical("q", a["end"], b["start"]),
        jo.Gravity((0, 0, -9.81)),
    )
    first, second = jo.compile(mechanism).bodies
    assert first.ED is second.ED
    assert not np.array_equal(first.D, second.D)


def test_every_build_of_the_engine_gives_the_same_motion(monkeypatch):
    """Only instructions and therefore round-off differ between the builds."""
    body = rigid("rod", angular_velocity=(0, 3, 2))
    mechanism = jo.Mechanism(
        body,
        jo.Spherical("p", jo.ground["origin"], body["origin"]),
        jo.Gravity((0, 0, -9.81)),
    )
    model = jo.compile(mechanism)
    results = []
    for build in runnable_builds():
        monkeypatch.setattr(library, "real_library", lambda build=build: library.build(build))
        engine = jo.model.Engine(model)
        solver = engine.native_solver("rk4", 1e-3, True)
        for _ in range(200):
            engine.step(solver)
        results.append(engine.q.copy())
    for other in results[1:]:
        # some 200 steps of 100 roundings each beside coordinates of order 1
        np.testing.assert_allclose(other, results[0], atol=1e-12)


def runnable_builds() -> list[str]:
    """Builds that are here and that this processor runs; the portable one always is."""
    found = []
    for name in library.BUILDS:
        with contextlib.suppress(jo.InputError):
            library.build(name)
            found.append(name)
    assert "baseline" in found
    return found


@pytest.mark.parametrize("name", [*library.BUILDS, " baseline "])
def test_a_build_is_chosen_by_the_environment(monkeypatch, name):
    if name.strip() not in runnable_builds():
        pytest.skip(f"this processor does not run {name}")
    monkeypatch.setenv("JOUSTO_CPU", name)
    assert library.real_library.__wrapped__() is library.build(name.strip())


def test_without_a_wish_the_fastest_build_runs(monkeypatch):
    monkeypatch.delenv("JOUSTO_CPU", raising=False)
    assert library.real_library.__wrapped__() is library.build(runnable_builds()[0])


def test_unknown_and_impossible_builds_are_told(monkeypatch):
    monkeypatch.setenv("JOUSTO_CPU", "v9")
    with pytest.raises(jo.InputError, match="JOUSTO_CPU: is 'v9'; allowed: baseline, v3"):
        library.real_library.__wrapped__()
    monkeypatch.setitem(library.BUILDS, "v3", 99)
    monkeypatch.setenv("JOUSTO_CPU", "v3")
    with pytest.raises(jo.InputError, match="this processor cannot run the build v3"):
        library.real_library.__wrapped__()


def test_the_header_read_by_python_is_the_one_that_was_compiled():
    assert library.ffi().typeof("jo_model").fields
    assert library.real_library().jo_abi() == library.real_library().JO_ABI


def test_views_of_the_state_outlive_the_engine():
    body = rigid("rod", angular_velocity=(0, 3, 2))
    pivot = jo.Spherical("p", jo.ground["origin"], body["origin"])
    q = jo.model.Engine(jo.compile(jo.Mechanism(body, pivot))).q
    np.testing.assert_array_equal(q, [0, 0, 0, 1, 0, 0, 0])


def test_the_engine_refuses_what_would_overrun_its_memory():
    body = rigid("rod", angular_velocity=(0, 3, 2))
    pivot = jo.Spherical("p", jo.ground["origin"], body["origin"])
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, pivot)))
    solver = engine.native_solver("rk4", 1e-3, True)
    good = np.zeros((10, engine.row_size))
    for steps, every, rows in (
        (11, 1, good),
        (1, 0, good),
        (1, 1, good.astype("f4")),
        (1, 1, good[:, :-1]),
    ):
        with pytest.raises(ValueError, match="contiguous"):
            engine.run(solver, steps, every, rows)
    with pytest.raises(IndexError):
        engine.mass_matrix(1)
    assert engine.run(solver, 10, 1, good) == ("ok", 10)


def test_a_changed_state_is_seen_at_once():
    body = rigid("rod", angular_velocity=(0, 3, 2))
    pivot = jo.Spherical("p", jo.ground["origin"], body["origin"])
    gravity = jo.Gravity((0, 0, -9.81))
    model = jo.compile(jo.Mechanism(body, pivot, gravity))
    used, new = jo.model.Engine(model), jo.model.Engine(model)
    used.accelerations()
    for engine in (used, new):
        engine.v[3:] = (1.0, 2.0, 3.0)
    places = {column.place: column.first for column in columns(model)}
    counts = [places[f"diagnostics/{name}"] for name in ("evaluations", "iterations")]
    np.testing.assert_array_equal(*(np.delete(e.row(), counts) for e in (used, new)))
    rows = np.zeros((1, new.row_size))
    solver = new.native_solver("rk4", 1e-3, True)
    used.accelerations()
    used.v[3:] = new.v[3:] = (3.0, 1.0, 1.0)
    for engine in (used, new):
        engine.run(solver, 1, 1, rows)
    np.testing.assert_array_equal(used.v, new.v)


def test_two_hundred_joints_on_one_body_are_ordered_quickly():
    assert eliminate([3] * 200, [range(200)]).fill == 0


def test_a_run_starts_at_the_time_of_the_state():
    body = rigid("rod", angular_velocity=(0, 3, 2))
    pivot = jo.Spherical("p", jo.ground["origin"], body["origin"])
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, pivot)))
    engine.time[:] = 1.0
    rows = np.zeros((3, engine.row_size))
    engine.run(engine.native_solver("rk4", 1e-3, True), 3, 1, rows)
    np.testing.assert_allclose(rows[:, 0], [1.001, 1.002, 1.003], atol=1e-15)
