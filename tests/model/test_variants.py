"""Variants of a compiled mechanism against compiling it anew: equal to the last bit."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.numbers import find_number, number_addresses, with_numbers
from jousto.model.native import layout
from jousto.model.native.native import Engine
from jousto.model.variants import Variants
from natural.gallery import MACHINES
from natural.terms import TERMS

STEP, STEPS = 1e-5, 3
LEFT_OUT = {"symbols", "mode_loads", "shapes", "fmus"}


def same(a: Any, b: Any) -> bool:
    """Return whether two values of a model are equal to the last bit."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if is_dataclass(a) and type(a).__module__.startswith("jousto.model"):
        names = (field.name for field in fields(a))
        left_out = {"site", "tree_of", *LEFT_OUT}
        return all(same(getattr(a, x), getattr(b, x)) for x in names if x not in left_out)
    if isinstance(a, float):
        return np.float64(a).tobytes() == np.float64(b).tobytes()
    return bool(np.all(a == b)) if not callable(a) else True


def rows(model: jo.Model, method: str = "rk4") -> bytes:
    """Return some rows of a run, bytes."""
    engine = Engine(model)
    out = np.zeros((STEPS + 1, engine.row_size))
    solver = engine.native_solver(method, STEP, True)
    status, written = engine.run(solver, STEPS, 1, out)
    return status.encode() + out[:written].tobytes()


def changed(value: Any) -> Any:
    """Return another value near a value."""
    return value * 1.01 if np.any(value) else value + 1e-3


def outcome(make: Any) -> Any:
    """Return a model, or the text of the error; and the warnings on the way."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always", jo.JoustoWarning)
        try:
            found = make()
        except jo.InputError as error:
            found = str(error)
    return found, sorted(str(one.message) for one in heard)


def chosen(machine: jo.Mechanism) -> list[str]:
    """Return the addresses of one number of each field of each class of items."""
    found: dict[Any, str] = {}
    for name in number_addresses(machine):
        try:
            number = find_number(machine, name)
        except jo.InputError:  # a body and a sensor of one name
            continue
        found.setdefault((type(number.item), number.field, number.at), name)
    return list(found.values())


def check(make: Callable[[], jo.Mechanism], again: bool = True) -> dict[str, bool]:
    """Compare the numbers of a machine; return which were written without compiling.

    `again`: also machines that are declared anew.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        machine = make()
        variants = Variants(machine)
        assert same(variants.model, jo.compile(machine))
    quick = {}
    for name in chosen(machine):
        value = find_number(machine, name).value
        values = {name: changed(value)}
        if value is not None and again:  # the same value is allowed, and changes nothing
            kept, _ = outcome(lambda n=name, v=value: variants.with_numbers({n: v}))
            assert same(kept, variants.model), (name, kept)
        before = variants.compilations
        made, said = outcome(lambda v=values: variants.with_numbers(v))
        quick[name] = variants.compilations == before and not isinstance(made, str)
        new, declared = outcome(lambda v=values: with_numbers(machine, v))
        if isinstance(new, str):
            assert made == new, name
            continue
        truth, heard = outcome(lambda m=new: jo.compile(m))
        if isinstance(truth, str):
            assert made == truth, name
            continue
        assert isinstance(made, jo.Model), (name, made)
        assert same(made, truth), name
        assert set(heard) <= set(said) <= {*heard, *declared}, name
        assert rows(made) == rows(truth), name
        if again:
            new, _ = outcome(lambda v=values: with_numbers(make(), v))
        like, _ = outcome(lambda m=new: variants.like(m))
        assert like is None or (same(like, truth) and rows(like) == rows(truth)), name
        assert (like is not None) >= quick[name], name
    return quick


def bench() -> jo.Mechanism:
    """Two carts on rails and a wheel with each force, friction and signal whose numbers matter."""
    cart = jo.RigidBody("cart", 2.0, (0.1, 0.2, 0.3), center=(0.1, 0, 0), velocity=(0.3, 0, 0))
    mass = jo.RigidBody("mass", 1.0, (0.1, 0.1, 0.1), position=(1, 0, 0))
    wheel = jo.RigidBody("wheel", 3.0, (0.2, 0.2, 0.3), position=(0, 1, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], (1, 0, 0))
    axle = jo.Revolute("axle", jo.ground.at((0, 1, 0)), wheel["origin"])
    x, phi = rail.displacement, axle.angle
    way = jo.CoordinateSensor("way", x)
    table = jo.Table([-1.0, 0.0, 1.0], [2.0, 0.0, -3.0])
    swell = 2.0 * jo.Ramp(0.0, 1.0) * jo.Harmonic(frequency=3.0) + 5.0
    crossed = jo.mechanism.Event("crossed", x, threshold=0.2)
    return jo.Mechanism(
        *(cart, mass, wheel, rail, axle, way, crossed, jo.Gravity((0.5, -9.81, 1.0))),
        jo.Spring("tabled", x, 20.0, 0.5, free=0.1, preload=0.3, table=table),
        jo.Spring.between("line", cart["origin"], mass.at((0, 0.2, 0)), 30.0, 0.1),
        jo.Bushing("bushing", cart.at((0, 0, 0.1)), mass["origin"], np.arange(1.0, 7.0), 0.2),
        jo.JointForce("motor", phi, swell),
        jo.Servo("servo", phi, jo.Harmonic(frequency=2.0), kp=5.0, kd=0.2, limit=3.0),
        jo.mechanism.PID("pid", x, 0.25, kp=20.0, ki=10.0, kd=3.0, limit=20.0),
        jo.mechanism.Stop("stop", x, -0.5, 0.5, stiffness=1e4, restitution=0.6),
        jo.mechanism.PlasticSpring("plastic", phi, stiffness=40.0, strength=0.3),
        jo.Force("push", cart.at((0, 0.1, 0)), (1.0, 2.0, 3.0), signal=jo.Ramp(0.0, 0.5)),
        jo.Torque("twist", mass["origin"], (0.1, 0.2, 0.3)),
        jo.Friction("rub", axle, 0.2, 0.3, radius=0.05, preload=4.0),
        jo.Friction("slip", rail, 0.1, preload=2.0, law=jo.mechanism.Regularised(0.02)),
        jo.Initial(phi, rate=2.0),
    )


def test_each_force_friction_event_and_start() -> None:
    """All numbers of this machine are written into its memory, but for places and axes."""
    quick = check(bench)
    assert {name for name, local in quick.items() if not local} == {
        *(f"cart.position.{x}" for x in "xyz"),
        *(f"rail.axis.{x}" for x in "xyz"),
        "cart.orientation",
        # refused: an impossible tensor, and numbers that go with others
        *(f"cart.inertia.{xx}" for xx in ("zz", "yz", "xz")),
        *(f"plastic.{x}" for x in ("recovery", "saturation", "rate")),
    }
    assert len(quick) > 60


@pytest.mark.parametrize("name", TERMS)
def test_terms(name: str) -> None:
    check(TERMS[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", MACHINES)
def test_gallery(name: str) -> None:
    check(MACHINES[name].machine, again=False)


def test_signals_of_forces_are_numbers() -> None:
    """A function declares the machine anew: amplitude, table and coefficients of its signals."""

    def make(amplitude: float, height: float, times: float = 1.0) -> jo.Mechanism:
        cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
        rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], (1, 0, 0))
        wave = amplitude * jo.Harmonic(frequency=3.0) + jo.Ramp(0.0, 1.0)
        table = jo.Table([0.0, times, 2.0], [1.0, height, 0.0])
        a = jo.JointForce("a", rail.displacement, wave)
        b = jo.JointForce("b", rail.displacement, wave + table)
        return jo.Mechanism(cart, rail, a, b)

    variants = Variants(make(1.0, 2.0))
    for args in ((3.0, 2.0), (1.0, -1.0), (-2.0, 0.5)):
        made, truth = variants.like(make(*args)), jo.compile(make(*args))
        assert made is not None and same(made, truth) and rows(made) == rows(truth)
    assert variants.like(make(1.0, 2.0, 1.5)) is None  # another time at which the force has a kink


def test_a_hundred_variants_are_compiled_and_laid_out_once(monkeypatch) -> None:
    calls = []
    original = layout.Layout._laid_out
    monkeypatch.setattr(
        layout.Layout, "_laid_out", lambda self: (calls.append(1), original(self))[1]
    )
    X = np.linspace(1.0, 2.0, 100)[:, None]
    parameter = jo.Parameter("cart.mass", 1.5, unit="kg")
    items = [item for item in bench().items if not isinstance(item, jo.Initial)]
    machine = jo.Mechanism(*items)
    study = jo.study(machine, parameter, "last(way)", t_end=1e-4, solver=jo.RK4(1e-5))
    calls.clear()
    table = study.run(X)
    assert not table.failed and study.counts["runs"] == 100
    assert study.counts["compilations"] == 1 and len(calls) <= 1


def test_one_compiled_model_is_laid_out_once(monkeypatch) -> None:
    calls = []
    original = layout.Layout._laid_out
    monkeypatch.setattr(
        layout.Layout, "_laid_out", lambda self: (calls.append(1), original(self))[1]
    )
    rod = jo.RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], rod["origin"])
    for core in ("joint", "maximal"):
        calls.clear()
        model = jo.compile(jo.Mechanism(rod, pivot, jo.Gravity((0, -9.81, 0))), core=core)
        for solver in (jo.RK4(1e-3), jo.ROS2(1e-3)):
            jo.simulate(model, 0.01, solver=solver)
        assert len(calls) == 1, core


def rod(length: float = 0.5) -> jo.Mechanism:
    body = jo.RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(length, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], body["origin"])
    center = body["center"]
    pull, place = jo.Force("pull", center, (0, 1.0, 0)), jo.PositionSensor("rod", center)
    return jo.Mechanism(body, pivot, pull, place)


def test_a_marker_at_the_centre_follows_it() -> None:
    made = Variants(rod()).with_numbers({"rod.center.x": 0.7})
    assert same(made, jo.compile(rod(0.7)))
    assert rows(made) == rows(jo.compile(rod(0.7)))


def test_a_variant_leaves_the_others_alone() -> None:
    """Engines of earlier variants keep their numbers."""
    variants = Variants(rod())
    first = variants.with_numbers({"rod.mass": 2.0})
    before, engine = rows(first), Engine(first)
    for mass in (3.0, 4.0):
        rows(variants.with_numbers({"rod.mass": mass}))
    assert rows(first) == before and rows(variants.model) == rows(jo.compile(rod()))
    assert engine.mass_matrix(0)[0, 0] == 2.0
    stepped = Engine(first, complex_scalars=True)  # for derivatives
    np.testing.assert_array_equal(stepped.mass_matrix(0), engine.mass_matrix(0))


def test_mistakes_are_explained() -> None:
    variants = Variants(rod())
    with pytest.raises(jo.InputError, match="'rod.mas': is not in .*did you mean 'rod.mass'"):
        variants.with_numbers({"rod.mas": 2.0})
    with pytest.raises(jo.InputError, match="body 'rod': mass is -2 kg, must be a positive number"):
        variants.with_numbers({"rod.mass": -2.0})
    with pytest.raises(jo.InputError, match="inertia"):
        variants.with_numbers({"rod.inertia.xx": 9.0})


def test_a_study_names_numbers_and_inputs() -> None:
    """Numbers of a mechanism beside an input; the gradient by a complex step agrees."""
    body = jo.RigidBody("block", 2.0, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], (1, 0, 0))
    push = jo.JointForce("push", slide.displacement, jo.Input("force"))
    way = jo.CoordinateSensor("way", slide.displacement)
    study = jo.study(
        jo.Mechanism(body, slide, push, way),
        [jo.Parameter("block.mass", 2.0, unit="kg"), jo.Parameter("force", 4.0, unit="N")],
        ["last(way)", "mass"],
        t_end=1.0,
        solver=jo.RK4(0.1),
    )
    m, f = np.array([1.0, 2.0, 4.0]), np.array([3.0, 4.0, 5.0])
    found = study(np.column_stack([m, f]))
    np.testing.assert_allclose(found, np.column_stack([f / m / 2.0, m]), rtol=1e-12)
    slope = jo.design.gradient(study).jacobian
    np.testing.assert_allclose(slope, [[-0.5, 0.25], [1.0, 0.0]], rtol=1e-9)
