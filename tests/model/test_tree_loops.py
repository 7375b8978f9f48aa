"""Loops of trees in joint coordinates against the rows of all joints between bodies."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.model.loop_joints import loops_of
from jousto.model.native.native import Engine
from model.test_tree import assert_rewinds, compared, joint, marker, moved, tree

Array = NDArray[np.float64]
Z = (0.0, 0.0, 1.0)
CLOSING = ("spherical", "universal", "rod", "on-line", "revolute")
pytestmark = [
    pytest.mark.filterwarnings("ignore:.*redundant"),
    pytest.mark.filterwarnings("ignore:.*has no joint to another"),
]


def closed(seed: int, drives: bool = False) -> Any:
    """A random tree of eight bodies and two further joints, of kinds that trees know or not."""
    rng = np.random.default_rng(100 + seed)
    kinds = ("spherical", "universal", "cylindrical", "revolute")
    start = tree(seed, kinds=kinds, drives=drives)
    items: list[Any] = [*start.items]
    bodies = [item for item in items if isinstance(item, jo.RigidBody)]
    for i in range(2):
        a, b = (bodies[k] for k in rng.choice(len(bodies), 2, replace=False))
        kind, name = CLOSING[(seed + 2 * i) % len(CLOSING)], f"closing{i}"
        points = rng.normal(size=(2, 3))
        if kind == "rod":
            items.append(jo.Rod(name, marker(a, points[0]), marker(b, points[1])))
        elif kind == "on-line":
            ends = marker(a, points[0]), marker(b, points[0])
            items.append(jo.PointOnLine(name, *ends, axis=points[1]))
        else:
            items.append(joint(kind, name, a, b, rng))
    return jo.Mechanism(*items, name="loops")


def body(name: str, at: Any = (0.0, 0.0, 0.0)) -> Any:
    return jo.RigidBody(name, 1.0, (0.02, 0.03, 0.04), center=(0.1, 0.0, 0.0), position=at)


def four_bar() -> Any:
    """In a plane: three rows repeat others."""
    a, b, c = (body(name) for name in "abc")
    points = [(0, 0, 0), (0, 1, 0), (2, 1.5, 0), (2, 0, 0)]
    pairs = [(jo.ground, a), (a, b), (b, c), (c, jo.ground)]
    pins = [
        jo.Revolute(f"pin{i}", one.at(at), other.at(at), axis=Z)
        for i, ((one, other), at) in enumerate(zip(pairs, points, strict=True))
    ]
    return jo.Mechanism(a, b, c, *pins, jo.Gravity((0, -9.81, 0)), name="four-bar")


def slider_crank(*more: Any) -> Any:
    """Crank of 1 m at the origin, rod of sqrt(5) m, slider along x; no row repeats others."""
    crank, rod, slider = body("crank"), body("rod"), body("slider", (2, 0, 0))
    pin = jo.Revolute("pin", jo.ground.at((0, 0, 0)), crank.at((0, 0, 0)), axis=Z)
    joints = [
        pin,
        jo.Spherical("big end", crank.at((0, 1, 0)), rod.at((0, 1, 0))),
        jo.Universal(
            "small end", rod.at((2, 0, 0)), slider.at((0, 0, 0)), axis_a=(0, 1, 0), axis_b=Z
        ),
        jo.Prismatic("guide", jo.ground.at((2, 0, 0)), slider.at((0, 0, 0)), axis=(1, 0, 0)),
    ]
    drive = [make(pin) for make in more]
    return jo.Mechanism(crank, rod, slider, *joints, *drive, jo.Gravity((0, -9.81, 0)))


def stewart() -> Any:
    """A plate on six legs of a universal, a prismatic and a spherical joint."""
    plate = body("plate", (0, 0, 1))
    items: list[Any] = [plate]
    for i in range(6):
        angle, over = np.pi / 3 * (i // 2 * 2) + 0.3 * (-1) ** i, np.pi / 3 * ((i + 1) // 2 * 2 - 1)
        over += 0.2 * (-1) ** i
        foot = np.array([1.2 * np.cos(angle), 1.2 * np.sin(angle), 0.0])
        head = np.array([0.7 * np.cos(over), 0.7 * np.sin(over), 1.0])
        along = head - foot
        across = np.cross(along, (0.3, 0.2, 1.0))
        lower, upper = body(f"lower{i}", foot), body(f"upper{i}", head)
        items += [
            lower,
            upper,
            jo.Universal(
                f"foot{i}",
                jo.ground.at(foot),
                lower.at((0, 0, 0)),
                axis_a=across,
                axis_b=np.cross(along, across),
            ),
            jo.Prismatic(f"leg{i}", lower.at(along), upper.at((0, 0, 0)), axis=along),
            jo.Spherical(f"head{i}", upper.at((0, 0, 0)), plate.at(head - (0, 0, 1))),
        ]
    return jo.Mechanism(*items, jo.Gravity((0, 0, -9.81)), name="stewart")


# positions closed to 1e-12; loops leave directions in which bodies move far less easily
@pytest.mark.parametrize("seed", range(8))
def test_random_loops(seed: int) -> None:
    made = closed(seed, drives=seed in (1, 5))
    a, lam = compared(made, seed)
    assert a < 1e-10
    # where rows repeat others the multipliers of least norm are regularised by 1e-9
    assert lam < (1e-6 if jo.compile(made).redundant else 1e-10)


# of rows that repeat one another both cores give the multipliers of least norm, regularised by 1e-9
@pytest.mark.parametrize(
    ("make", "bound"), [(four_bar, 1e-8), (slider_crank, 1e-10), (stewart, 1e-10)]
)
def test_machines(make: Any, bound: float) -> None:
    a, lam = compared(make(), 3)
    assert a < 1e-11
    assert lam < bound


def test_the_complex_build_agrees() -> None:
    a, lam = compared(slider_crank(), 3, complex_scalars=True)
    assert a < 1e-11
    assert lam < 1e-10


def test_the_joints_with_the_fewest_rows_are_cut() -> None:
    model = jo.compile(stewart(), core="joint")
    plan = loops_of(model)
    assert [model.joints[loop[0]].name for loop in plan.loops] == [f"head{i}" for i in range(1, 6)]
    assert [loop[2] for loop in plan.loops] == [0, 3, 6, 9, 12]
    assert "15 rows beside it" in jo.doctor(model).core


def test_loops_with_no_link_in_common_are_solved_apart() -> None:
    one, other = slider_crank(), four_bar()
    items = [item for item in one.items if not isinstance(item, jo.Gravity)]
    plan = loops_of(jo.compile(jo.Mechanism(*items, *other.items), core="joint"))
    assert sorted(loop[1] for loop in plan.loops) == [0, 1]


def final(model: Any, solver: Any, time: float = 0.2) -> Any:
    return jo.simulate(model, time, solver=solver, output_step=time)


# the difference of two methods of one order falls with its power of the step
@pytest.mark.parametrize(("solver", "least"), [(jo.RK4, 12.0), (jo.ROS2, 3.4)], ids=["RK4", "ROS2"])
def test_runs_agree_at_the_order_of_the_method(solver: Any, least: float) -> None:
    models = [jo.compile(closed(2), core=core) for core in ("joint", "maximal")]
    apart = []
    for step in (4e-3, 2e-3):
        one, other = (final(model, solver(step=step)).q[-1] for model in models)
        apart.append(np.abs(one - other).max())
    assert apart[0] < 1e-3
    assert apart[0] > least * apart[1]


def test_error_control_agrees() -> None:
    models = [jo.compile(slider_crank(), core=core) for core in ("joint", "maximal")]
    solver = jo.simulation.DormandPrince(tolerance=1e-9)
    one, other = (jo.simulate(model, 1.0, solver=solver, output_step=0.1) for model in models)
    np.testing.assert_allclose(one.q, other.q, atol=1e-7)


def test_a_driven_slider_crank_is_where_geometry_says() -> None:
    """x = cos t + sqrt(5 - sin^2 t) of a crank of 1 m that turns with w."""
    speed, time = 7.0, 1.3
    made = slider_crank(
        lambda pin: jo.Drive("motor", pin.angle, jo.ConstantSpeed(speed, offset=pin.angle.initial))
    )
    model = jo.compile(made, core="joint")
    run = jo.simulate(model, time, solver=jo.RK4(step=1e-3), output_step=0.1)
    angle = 0.5 * np.pi + speed * run.time
    place = np.cos(angle) + np.sqrt(5.0 - np.sin(angle) ** 2)
    # closed to 1e-12 of the size of the mechanism, some metres
    np.testing.assert_allclose(run.q[:, 14], place, atol=1e-11)


@pytest.mark.filterwarnings("ignore:.*energy balance")  # of the shock, in both cores
def test_a_drive_whose_speed_jumps_is_a_row() -> None:
    made = slider_crank(
        lambda pin: jo.Drive("motor", pin.angle, jo.Ramp(0.1, 1.0, 0.0, 2.0)),
    )
    model = jo.compile(made, core="joint")
    assert [loop[0] for loop in loops_of(model).loops][-1] == 4
    runs = [final(m, jo.RK4(step=1e-3), 0.5) for m in (model, jo.compile(made, core="maximal"))]
    # closed to 1e-12 in both; what the kink at 0.1 s leaves is projected away at once
    np.testing.assert_allclose(runs[0].q[-1], runs[1].q[-1], atol=1e-9)


def test_energy_is_kept_at_the_order_of_the_method() -> None:
    model = jo.compile(slider_crank(), core="joint")
    apart = []
    for step in (1e-2, 5e-3):
        engine = Engine(model)
        start = engine.energy().sum()
        solver = engine.native_solver("rk4", step, True)
        for _ in range(round(1.0 / step)):
            engine.step(solver)
        apart.append(abs(engine.energy().sum() - start))
    assert apart[0] < 1e-3
    assert apart[0] > 12.0 * apart[1]


@pytest.mark.parametrize("make", [four_bar, stewart])
def test_loops_stay_closed(make: Any) -> None:
    engine = Engine(jo.compile(make(), core="joint"))
    engine.run(engine.native_solver("rk4", 1e-3, True), 3000, 3000, np.zeros((2, engine.row_size)))
    position, velocity = engine.residuals()
    assert position < 1e-11
    assert velocity < 1e-9


def test_baumgarte_holds_loops_too() -> None:
    solver = jo.RK4(step=1e-3, projection=False, baumgarte=jo.simulation.Baumgarte(50.0, 50.0))
    runs = [
        final(jo.compile(slider_crank(), core=core), solver, 1.0) for core in ("joint", "maximal")
    ]
    # each closes its own rows: the remainders differ, both of the order of the method
    np.testing.assert_allclose(runs[0].q[-1], runs[1].q[-1], atol=1e-7)


def parallelogram() -> Any:
    """A four-bar with sides of 1 m and 2 m that may lie flat; no row repeats others."""
    a, b, c = (body(name) for name in "abc")
    at = [(0, 0, 0), (0, 1, 0), (2, 1, 0), (2, 0, 0)]
    return jo.Mechanism(
        *(a, b, c),
        jo.Spherical("one", jo.ground.at(at[0]), a.at(at[0])),
        jo.Universal("two", a.at(at[1]), b.at(at[1]), axis_a=(1, 0, 0), axis_b=Z),
        jo.Revolute("three", b.at(at[2]), c.at(at[2]), axis=Z),
        jo.Revolute("four", c.at(at[3]), jo.ground.at(at[3]), axis=Z),
    )


def test_a_singular_position_is_passed_and_counted_as_in_the_other_core() -> None:
    model = jo.compile(parallelogram(), core="joint")
    half = np.sqrt(0.5)
    flat = np.array(model.q0)
    flat[:7] = 0, 0, 0, half, 0, 0, -half  # the sides turned by -90 degrees
    flat[7:14] = 1, -1, 0, 1, 0, 0, 0
    flat[14:] = 2, 2, 0, half, 0, 0, -half
    found = []
    for own in (False, True):
        engine = Engine(model)
        engine.q[:], engine.v[:] = flat, 0.0
        assert max(engine.residuals()) < 1e-14
        a, _ = engine.tree_accelerations() if own else engine.accelerations()
        found.append(a.copy())
        assert engine.counts.singular == 1
    np.testing.assert_allclose(found[0], found[1], atol=1e-6)
    strict = Engine(model, strict=True)
    strict.q[:] = flat
    with pytest.raises(jo.JoustoError):
        strict.tree_accelerations()


def test_repeated_rows_get_the_same_sentence() -> None:
    said = []
    for core in ("joint", "maximal"):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            jo.compile(four_bar(), core=core)
        said.append([str(w.message) for w in caught])
    assert said[0] == said[1]
    assert "are redundant" in said[0][0]


def test_a_gear_between_joints_is_a_row() -> None:
    a, b = body("a"), body("b", (1, 0, 0))
    pins = [
        jo.Revolute("one", jo.ground.at((0, 0, 0)), a.at((0, 0, 0)), axis=Z),
        jo.Revolute("other", jo.ground.at((1, 0, 0)), b.at((0, 0, 0)), axis=Z),
    ]
    gear = jo.Gear("gear", pins[0].angle, pins[1].angle, ratio=-2.0)
    made = jo.Mechanism(a, b, *pins, gear, jo.Gravity((0, -9.81, 0)))
    assert loops_of(jo.compile(made, core="joint")).loops
    a_apart, lam_apart = compared(made, 1)
    assert max(a_apart, lam_apart) < 1e-11


def test_a_run_continues_to_the_last_digit() -> None:
    model = jo.compile(slider_crank(), core="joint")
    solver = jo.RK4(step=1e-3)
    whole = jo.simulate(model, 0.2, solver=solver, output_step=0.05)
    first = jo.simulate(model, 0.1, solver=solver, output_step=0.05)
    rest = jo.simulate(model, 0.2, solver=solver, output_step=0.05, state=first.state())
    np.testing.assert_array_equal(rest.q[-1], whole.q[-1])


def test_a_rewound_engine_runs_the_same_again() -> None:
    assert_rewinds(jo.compile(slider_crank(), core="joint"), "rk4")


def test_an_event_is_located() -> None:
    stops = []
    for core in ("joint", "maximal"):
        stop = [
            lambda pin: jo.mechanism.Event("there", pin.angle, pin.angle.initial - 0.5, stop=True)
        ]
        run = final(jo.compile(slider_crank(*stop), core=core), jo.RK4(step=1e-3), 5.0)
        stops.append(run.time[-1])
    assert stops[0] < 5.0
    assert stops[0] == pytest.approx(stops[1], abs=1e-8)


def test_moved_states_are_those_of_closed_loops() -> None:
    model = jo.compile(closed(1), core="joint")
    engine = Engine(model)
    engine.q[:], engine.v[:] = moved(model, 1)
    assert max(engine.residuals()) < 1e-9


def held_chain(count: int) -> Any:
    """A chain of bars on the ground, a rod from each to it: all loops have bars in common."""
    bars = [body(f"bar{i}", (float(i), 0, 0)) for i in range(count)]
    before = [jo.ground, *bars]
    items: list[Any] = [*bars]
    for i, bar in enumerate(bars):
        at = (float(i), 0.0, 0.0)
        items.append(
            jo.Spherical(f"ball{i}", before[i].at(at if not i else (1, 0, 0)), bar.at((0, 0, 0)))
        )
        items.append(jo.Rod(f"rod{i}", jo.ground.at((i + 0.5, 2, 1)), bar.at((0.5, 0, 0))))
    return jo.Mechanism(*items, jo.Gravity((0, -9.81, 0)), name="held chain")


@pytest.mark.chooses
def test_auto_takes_the_loops_that_have_few_bodies_in_common() -> None:
    assert jo.compile(four_bar()).links
    assert jo.compile(stewart()).links
    assert jo.compile(held_chain(4)).links
    many = jo.compile(held_chain(20))
    assert not many.links
    assert jo.doctor(many).core == "positions of the bodies: its loops have many common bodies"
    assert jo.compile(held_chain(20), core="joint").links
    loose = jo.compile(jo.Mechanism(body("loose")))
    assert not loose.links
    assert jo.doctor(loose).core == "positions of the bodies: no joint connects a body"


@pytest.mark.parametrize("ends", [(-0.3, -1.0), (0.1, 0.7), (1e-3, 2.0)])
def test_a_smooth_drive_is_known_whatever_its_digits(ends: tuple[float, float]) -> None:
    """Rates at the ends of an SCurve are differences of large terms."""
    made = slider_crank(lambda pin: jo.Drive("motor", pin.angle, jo.SCurve((0, 1), ends) - ends[0]))
    links = jo.compile(made, core="joint").links
    assert [link.driven for link in links].count(-1) < len(links)


def three_cranks() -> Any:
    """A parallelogram of three equal cranks: when they lie flat all rows but one are singular."""
    names = ("left", "middle", "right")
    cranks = [
        jo.RigidBody(name, 1.0, (0.1,) * 3, center=(0, 0.5, 0), position=(x, 0, 0))
        for name, x in zip(names, (0.0, 0.5, 1.0), strict=True)
    ]
    bar = jo.RigidBody("bar", 1.0, (0.1,) * 3, center=(0.5, 0, 0), position=(0, 1, 0))
    left, middle, right = cranks
    ends = (
        *((jo.ground, (0, 0, 0), left, (0, 0, 0)), (left, (0, 1, 0), bar, (0, 0, 0))),
        *((bar, (1, 0, 0), right, (0, 1, 0)), (jo.ground, (1, 0, 0), right, (0, 0, 0))),
        *((jo.ground, (0.5, 0, 0), middle, (0, 0, 0)), (bar, (0.5, 0, 0), middle, (0, 1, 0))),
    )
    pins = [
        jo.Revolute(f"pin{k}", one.at(a), other.at(b), axis=Z)
        for k, (one, a, other, b) in enumerate(ends)
    ]
    push = jo.JointForce("push", pins[0].angle, jo.Constant(3.0))
    return jo.Mechanism(*cranks, bar, *pins, push, jo.Gravity((0, -9.81, 0)))


def test_rows_between_steps_are_closed_near_singular_positions() -> None:
    run = jo.simulate(
        jo.compile(three_cranks(), core="joint"),
        1.0,
        solver=jo.simulation.DormandPrince(tolerance=1e-8, output=0.01),
    )
    # of some 20 J; errors of the steps add up to ten times the tolerance, and more
    assert np.abs(run.energy.error).max() < 1e-5
