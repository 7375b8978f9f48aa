"""Programs of expressions: values and derivatives against complex steps of the same formulas."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import States, StateSensor, rate, value
from jousto.mechanism.states.expression import Expression
from jousto.mechanism.states.formula import FormulaError, formula
from jousto.model.packing.program import Program

STEP = 1e-30
FORMULAS = [
    "x*y - y/x + x**3 - 2*y**2 + (-x)",
    "sqrt(x*x + y*y) + exp(-x) + log(2 + x)",
    "sin(x*y)*cos(y) + atan(x/y) + tanh(x - y)",
    "minimum(x, y)*maximum(2*x, y) + clip(x, -1, 0.5)",
    "where(x - y, x*x, y*y) + absolute(y - x)",
    "smooth_step(0.3*x + 0.1)*y + smooth_step(x - 5) + smooth_step(x + 5)",
    "(1 + x*x)**1.5 + (2 + x)**y",
]


def plain(name: str, *items: complex) -> complex:
    """The functions of formulas on complex numbers, by the branches of their real parts."""
    a = items[0]
    low, high = (items[1].real, items[2].real) if name == "clip" else (0.0, 1.0)
    inside = high if a.real > high else low if a.real < low else a
    found: dict[str, Any] = {
        "minimum": lambda: a if a.real < items[1].real else items[1],
        "maximum": lambda: a if a.real > items[1].real else items[1],
        "clip": lambda: inside,
        "where": lambda: items[1] if a.real > 0 else items[2],
        "absolute": lambda: a if a.real > 0 else -a,
        "smooth_step": lambda: inside * inside * (3 - 2 * inside),
    }
    return complex(found[name]())


NAMES = ("minimum", "maximum", "clip", "where", "absolute", "smooth_step")
KNOWN: dict[str, Any] = {
    **{name: getattr(cmath, name) for name in ("sqrt", "exp", "log", "sin", "cos", "atan", "tanh")},
    **{name: lambda *items, name=name: plain(name, *map(complex, items)) for name in NAMES},
}


def edge_slope(a: float, b: float) -> float:
    """Derivative of a/(a^2 + b^2)^(1/4)."""
    return (0.5 * a * a + b * b) / (a * a + b * b) ** 1.25


def run(program: Program, x: float, y: float) -> list[float]:
    """Values of all entries for the states x and y."""
    do = {**{k: getattr(math, k) for k in ("sqrt", "exp", "log", "sin", "cos", "atan", "tanh")}}
    do |= {
        "add": lambda a, b: a + b,
        "subtract": lambda a, b: a - b,
        "multiply": lambda a, b: a * b,
        "divide": lambda a, b: a / b,
        "power": lambda a, b: a**b,
        "minimum": min,
        "maximum": max,
        "select": lambda a, b, c: b if a > 0 else c,
        "edge": lambda a, b: a / (a * a + b * b) ** 0.25,
        "edge slope": edge_slope,
    }
    out: list[float] = []
    for kind, of in program.nodes:
        if kind == "number":
            out.append(float(np.real(of)))  # type: ignore[arg-type]
        elif kind == "state":
            out.append((x, y)[of])  # type: ignore[index]
        else:
            out.append(do[kind](*(out[part] for part in of)))  # type: ignore[union-attr]
    return out


@pytest.mark.parametrize("text", FORMULAS)
@pytest.mark.parametrize(("x", "y"), [(0.7, 1.3), (1.4, 0.4), (2.2, 3.1)])
def test_derivatives_of_formulas_are_those_of_complex_steps(text: str, x: float, y: float) -> None:
    x, y = x, y
    names = {"x": Expression("state", of=0), "y": Expression("state", of=1)}
    made = formula(text, names, lambda *_: None)
    program, known = Program(), {}

    def enter(one: Expression) -> int:
        if id(one) not in known:
            parts = [enter(part) for part in one.operands]
            leaf = program.number(one.of) if one.operation == "number" else None
            if one.operation == "state":
                leaf = program.leaf("state", one.of)
            known[id(one)] = program.add(one.operation, *parts) if leaf is None else leaf
        return known[id(one)]

    node = enter(made)
    slopes = program.derivatives(node)
    values = run(program, x, y)
    exact = eval(text, KNOWN, {"x": complex(x), "y": complex(y)})
    assert values[node] == pytest.approx(complex(exact).real, rel=1e-14)
    for i, at in enumerate([(x + 1j * STEP, y), (x, y + 1j * STEP)]):
        found = complex(eval(text, KNOWN, dict(zip("xy", map(complex, at), strict=True))))
        slope = values[slopes["state", i]] if ("state", i) in slopes else 0.0
        assert slope == pytest.approx(found.imag / STEP, rel=1e-13, abs=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("__import__('os').system('x')", "is not allowed"),
        ("x.__class__", "is not allowed|__class__"),
        ("[x for x in y]", "is not allowed"),
        ("x if y else 1", "is not allowed"),
        ("f'{x}'", "is not allowed"),
        ("lambda: 1", "is not allowed"),
        ("x +", "is no formula"),
        ("z + 1", "nothing is called 'z'"),
        ("sinus(x)", "did you mean 'sin'"),
        ("sin(x, y)", "sin has 2 arguments"),
        ("1/0", "divides by 0"),
        ("(" * 4000 + "x" + ")" * 4000, "brackets|no formula"),
        ("x" * 20000, "characters"),
        ("True", "is not allowed"),
    ],
)
def test_formulas_that_are_refused(text: str, message: str) -> None:
    def refer(name: str, part: str) -> Any:
        raise FormulaError(f"{name}.{part} is not allowed")

    names = {"x": Expression("state", of=0), "y": Expression("state", of=1)}
    with pytest.raises(FormulaError, match=message):
        formula(text, names, refer)


def machine(*items: Any) -> jo.Mechanism:
    """A cart on a rail, with blocks; items are functions of the displacement."""
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    return jo.Mechanism(cart, rail, *(item(rail.displacement) for item in items))


def test_an_algebraic_loop_is_named() -> None:
    a = States("a", {}, {}, inputs={"u": "b.y"}, outputs={"y": "2*u"})
    b = States("b", {}, {}, inputs={"u": "a.y"}, outputs={"y": "u + 1"})
    with pytest.raises(InputError, match=r"algebraic loop: .*y needs .*y needs"):
        jo.compile(machine(lambda s: a, lambda s: b))


@pytest.mark.parametrize(
    ("block", "message"),
    [
        (lambda s: States("m", {"x": 0.0}, {}), "no rate of 'x'"),
        (lambda s: States("m", {"x": 0.0}, {"x": 1.0, "z": 2.0}), "rate of 'z'"),
        (lambda s: States("m", {"x": 0.0}, {"x": "u"}), "nothing is called 'u'"),
        (lambda s: States("m", {"x": 0.0}, {"x": 1.0}, inputs={"x": 1.0}), "state and an input"),
        (lambda s: States("m", {"x y": 0.0}, {"x y": 1.0}), "is no name of a state"),
        (lambda s: States("m", {"x": math.nan}, {"x": 1.0}), "nan"),
        (lambda s: States("m", {"x": 0.0}, {"x": object()}), "must be an expression"),
        (lambda s: States("m", {"x": 0.0}, {"x": 1.0}, forces={"s": 1.0}), "must have coordinates"),
        (lambda s: States("m", {"x": 0.0}, {"x": "u"}, inputs={"u": "n.y"}), "no block 'n'"),
        (lambda s: States("m", {"x": 0.0}, {"x": "u"}, inputs={"u": "m.y"}), "needs 'y' of block"),
        (lambda s: States.from_rule("m", lambda x, u: x["z"], {"x": 0.0}), "asks for 'z'"),
        (lambda s: States.from_rule("m", lambda x, u: 3, {"x": 0.0}), "must return dicts"),
    ],
)
def test_blocks_that_are_refused(block: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        jo.compile(machine(block))


def test_live_values_are_refused_where_only_functions_of_time_act() -> None:
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    push = jo.Force("push", cart["origin"], (1, 0, 0), signal=value(rail.displacement) * 2.0)
    with pytest.raises(InputError, match="depends on the motion"):
        jo.compile(jo.Mechanism(cart, rail, push))


def test_a_coordinate_of_another_machine_is_refused() -> None:
    stray = jo.RigidBody("stray", 2.0, (1, 1, 1))
    other = jo.Prismatic("other", jo.ground["origin"], stray["origin"], axis=(1, 0, 0))
    block = States("m", {"x": 0.0}, {"x": "v"}, inputs={"v": rate(other.displacement)})
    with pytest.raises(InputError, match="stray"):
        machine(lambda s: block)


def test_a_sensor_of_an_expression_needs_no_block() -> None:
    model = jo.compile(
        machine(
            lambda s: jo.Spring("spring", s, 200.0, free=0.5),
            lambda s: StateSensor("energy", 100.0 * (value(s) - 0.5) ** 2, unit="J"),
            lambda s: jo.CoordinateSensor("s", s),
        )
    )
    run = jo.simulate(model, 0.3, solver=jo.RK4(1e-3))
    assert run["energy"] == pytest.approx(100.0 * (run["s"] - 0.5) ** 2, rel=1e-13)
    assert run["energy"][-1, 0] != run["energy"][0, 0]


@pytest.mark.parametrize("count", [3, 30])
def test_compiling_blocks_is_linear_in_their_number(count: int) -> None:
    """Chain of lags: as many instructions for each block, however many there are."""
    blocks = [States("b0", {"x": 0.0}, {"x": "(1 - x)/0.1"})]
    for i in range(1, count):
        blocks.append(
            States(f"b{i}", {"x": 0.0}, {"x": "(u - x)/0.1"}, inputs={"u": f"b{i - 1}.x"})
        )
    model = jo.compile(machine(*((lambda s, b=b: b) for b in blocks)))
    (system,) = model.forces
    instructions = jo.model.native.header.named("jo_network_data", system.data).instructions
    assert float(instructions) <= 4 * count


@pytest.mark.parametrize("x", [-3.0, -0.2, 0.0, 0.5, 7.0])
def test_first_and_second_derivative_of_an_edge(x: float) -> None:
    """(x^2 + t^2)^(-1/4) x against complex steps."""
    program, t = Program(), 0.7
    edge = program.add("edge", program.leaf("state"), program.number(t))
    (first,) = program.derivatives(edge).values()
    (second,) = program.derivatives(first).values()
    values = run(program, x, 0.0)
    z = complex(x, STEP)
    assert values[first] == pytest.approx((z / (z * z + t * t) ** 0.25).imag / STEP, rel=1e-14)
    slope = (0.5 * z * z + t * t) / (z * z + t * t) ** 1.25
    assert values[second] == pytest.approx(slope.imag / STEP, rel=1e-13, abs=1e-15)


def test_what_rows_share_is_differentiated_once() -> None:
    """Rows x' = f(x, y) g + 3 y and y' = 2 f(x, y): derivatives as of each row alone, less work."""
    together, alone = Program(), Program()
    found = []
    for program in (together, alone):
        x, y = program.leaf("state", 0), program.leaf("state", 1)
        drop = program.add("maximum", program.add("subtract", x, y), program.number(0.1))
        f = program.add("multiply", program.add("edge", drop, program.number(0.3)), x)
        g = program.add("add", x, program.number(2.0))
        rows = [
            program.add("add", program.add("multiply", f, g), program.add("add", y, y)),
            program.add("multiply", f, program.number(2.0)),
        ]
        slopes = (
            program.jacobian(rows)
            if program is together
            else [program.derivatives(row) for row in rows]
        )
        values = run(program, 1.3, 0.4)
        found.append([{leaf: values[at] for leaf, at in one.items()} for one in slopes])
    for one, other in zip(*found, strict=True):
        assert one == pytest.approx(other, rel=1e-14)
    assert len(together.nodes) < len(alone.nodes)
