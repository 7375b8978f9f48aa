"""Tables in one and two variables: splines of SciPy, closed forms, exact derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

import jousto as jo
from jousto.base.errors import InputError, SimulationError
from jousto.mechanism import BlockForce, Lookup, LookupMap, StateSensor, time, value

CORES = ("joint", "maximal")
X, Y = np.array([0.0, 1.0, 2.5, 4.0, 5.0]), np.array([0.0, 0.5, 1.5, 2.0])
F = np.sin(X)[:, None] * np.exp(-Y) + np.outer(X, Y) / 10


def machine(*items: Any, core: str = "joint") -> Any:
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    made = [one(rail.displacement) if callable(one) else one for one in items]
    return jo.Mechanism(cart, rail, *made, core=core)


def values(*blocks: Any, end: float = 1.0, steps: int = 64) -> Any:
    """Outputs over time of blocks that depend on time only."""
    sensors = [StateSensor(block.name, block[block.outputs[0]]) for block in blocks]
    model = jo.compile(machine(*blocks, *sensors))
    return jo.simulate(model, end, solver=jo.RK4(end / steps), output_step=end / steps)


def test_a_point_of_a_map_and_its_slope() -> None:
    """f(3.3, 0.8) by the slopes of parabolas; the slope by a difference over 2e-5."""
    near = [LookupMap(f"m{i}", 3.3 + i * 1e-5, 0.8, X, Y, F) for i in (-1, 0, 1)]
    found = values(*near, steps=1)
    z = [found[block.name][0, 0] for block in near]
    assert z[1] == pytest.approx(0.200377993847, abs=1e-12)
    assert (z[2] - z[0]) / 2e-5 == pytest.approx(-0.406277162204, abs=1e-9)


@pytest.mark.parametrize("core", CORES)
def test_the_slope_of_a_map_is_exact(core: str) -> None:
    """Stiffness of a force along s that is a table of s and 0.8: -d/dx of the map at 3.3."""

    def force(s: Any) -> Any:
        return BlockForce(
            "f", s, LookupMap("m", value(s) + 3.3, 0.8, X, Y, F).equations({}).outputs["z"]
        )

    A = jo.simulation.linearise(jo.compile(machine(force, core=core))).A
    assert A[1, 0] == pytest.approx(-0.406277162204 / 2.0, abs=1e-12)

    def across(s: Any) -> Any:
        return BlockForce(
            "f", s, LookupMap("m", 0.8, value(s) + 3.3, Y, X, F.T).equations({}).outputs["z"]
        )

    A = jo.simulation.linearise(jo.compile(machine(across, core=core))).A
    assert A[1, 0] == pytest.approx(-0.406277162204 / 2.0, abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "exact"),
    [
        ("natural", lambda x, y: CubicSpline(x, y, bc_type="natural")),
        ("monotone", PchipInterpolator),
    ],
)
@pytest.mark.parametrize("outside", ["hold", "line"])
def test_a_table_is_the_spline_of_scipy(kind: str, exact: Any, outside: str) -> None:
    rng = np.random.default_rng(5)
    x, y = np.cumsum(rng.uniform(0.1, 1.0, 9)), np.cumsum(rng.uniform(0.0, 1.0, 9))
    low, high = x[0] - 0.7, x[-1] + 0.7
    block = Lookup("t", low + (high - low) * time, x, y, interpolation=kind, outside=outside)
    found = values(block)
    u, spline = low + (high - low) * found.time, exact(x, y)
    wanted = spline(np.clip(u, x[0], x[-1]))
    if outside == "line":
        wanted += np.where(u < x[0], spline(x[0], 1) * (u - x[0]), 0.0)
        wanted += np.where(u > x[-1], spline(x[-1], 1) * (u - x[-1]), 0.0)
    assert found["t"][:, 0] == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("outside", ["line", "hold"])
def test_a_map_of_two_parabolas_is_met(outside: str) -> None:
    """Product of two parabolas inside; outside its tangents along one direction, or its edge."""

    def p(x: Any) -> Any:
        return 1 + 2 * x - 0.7 * x * x

    def q(y: Any) -> Any:
        return 3 - y + 0.4 * y * y

    def beyond(f: Any, u: Any, knots: Any) -> Any:
        end = np.clip(u, knots[0], knots[-1])
        slope = (f(end + 0.5) - f(end - 0.5)) * (outside == "line")
        return f(end) + slope * (u - end)

    block = LookupMap(
        "m", 6 * time - 0.5, 3 * time - 0.5, X, Y, np.outer(p(X), q(Y)), outside=outside
    )
    found = values(block)
    wanted = beyond(p, 6 * found.time - 0.5, X) * beyond(q, 3 * found.time - 0.5, Y)
    assert found["m"][:, 0] == pytest.approx(wanted, abs=1e-13 * np.abs(wanted).max() * 10)


def test_a_table_at_whose_ends_the_run_stops() -> None:
    block = Lookup("t", 4 * time, X, X**2, outside="stop")
    sensors = [StateSensor("t", block["y"])]
    model = jo.compile(machine(block, *sensors))
    assert jo.simulate(model, 1.25, solver=jo.RK4(1 / 64))["t"][-1, 0] == 25.0
    with pytest.raises(SimulationError, match=r"states 't': .*beyond its knots.*outside=") as error:
        jo.simulate(model, 2.0, solver=jo.RK4(1 / 64))
    assert error.value.time == pytest.approx(1.25, abs=1 / 64)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("method", ["RK4", "ROS2", "GeneralizedAlpha"])
def test_a_spring_by_a_table(core: str, method: str) -> None:
    """Force -100 x from a table: the oscillation of a mass of 2 kg."""
    knots = np.linspace(-1, 1, 9)

    def force(s: Any) -> Any:
        table = Lookup("t", s, knots, -100 * knots)
        return BlockForce("f", s, table.equations({}).outputs["y"])

    def start(s: Any) -> Any:
        return jo.Initial(s, value=0.1)

    def place(s: Any) -> Any:
        return jo.CoordinateSensor("x", s)

    model = jo.compile(machine(force, start, place, core=core))
    found = jo.simulate(model, 1.0, solver=getattr(jo, method)(1e-3))["x"][-1, 0]
    wanted = 0.1 * np.cos(np.sqrt(50.0))
    assert found == pytest.approx(wanted, abs=1e-9 if method == "RK4" else 1e-5)


def test_gradient_with_respect_to_a_value_of_a_table() -> None:
    """The output is linear in the values: its derivative is the spline of a unit value."""

    def build(top: Any) -> Any:
        block = Lookup("t", 2 * time, X, [0.0, 1.0, top, 2.0, 0.0])
        return machine(block, StateSensor("t", block["y"]))

    parameter = jo.Parameter("top", 3.0)
    study = jo.study(build, parameter, ["last(t)"], t_end=1.0, solver=jo.RK4(0.1))
    found = jo.design.gradient(study, [3.0], check=False)
    wanted = CubicSpline(X, [0, 0, 1, 0, 0], bc_type="natural")(2.0)
    assert found.jacobian[0, 0] == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Lookup("t", 0.0, [0.0], [1.0]), "at has 1 knots, must have 2 or more"),
        (lambda: Lookup("t", 0.0, [0, 2, 1], [1, 2, 3]), r"at\[2\] is 1 after 2"),
        (lambda: Lookup("t", 0.0, [0, 1, 1], [1, 2, 3]), "must increase"),
        (lambda: Lookup("t", 0.0, [0, 1], [1, 2, 3]), "2 knots for 3 values"),
        (lambda: Lookup("t", 0.0, [0, 1], [1, np.nan]), "must be finite"),
        (lambda: Lookup("t", 0.0, [0, 1], [1, 2], outside="end"), "outside"),
        (lambda: Lookup("t", 0.0, [0, 1], [1, 2], interpolation="linear"), "interpolation"),
        (lambda: LookupMap("t", 0.0, 0.0, X, Y, F.T), "at_x has 5 knots for 4 values"),
    ],
)
def test_tables_that_are_refused(build: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        build()
