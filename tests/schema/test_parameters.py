"""Parameters and expressions in model files."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import jousto as jo
from jousto.schema.read import parse_model

BALL = """
parameters:
  length: 800 mm
  mass: {value: 2 kg, bounds: [1 kg, 3000 g], distribution: normal(sd=100 g)}
  half: ${length / 2}
bodies: [{name: ball, mass: ${mass}, inertia: [1e-4, 1e-4, "${2 * 1e-4}"],
          center: [0, ${-length}, 0], markers: {knot: [0, ${-half}, 0]}}]
joints: [{type: spherical, name: pivot, a: ground.origin, b: ball.origin}]
sensors:
  - type: position
    name: knot
    marker: ball.knot
gravity: [0, -9.81, 0]
simulation: {t_end: ${2 * 1 s}}
"""


def problems(text: str) -> list[str]:
    with pytest.raises(jo.InputError) as error:
        parse_model(text)
    return str(error.value).splitlines()


def test_expressions_stand_for_numbers() -> None:
    file = parse_model(BALL)
    ball = file.mechanism.bodies[0]
    assert ball.mass == 2.0 and ball.center[1] == -0.8 and ball.inertia[2, 2] == 2e-4
    assert ball.markers["knot"][1] == -0.4
    assert file.simulation is not None and file.simulation.t_end == 2.0
    assert [p.name for p in file.parameters] == ["length", "mass"]
    mass = file.parameters[1]
    assert (mass.value, mass.bounds, mass.unit) == (2.0, (1.0, 3.0), "kg")
    assert mass.distribution.std() == pytest.approx(0.1, rel=1e-14)


def test_other_values_are_given(tmp_path: Path) -> None:
    path = tmp_path / "ball.yaml"
    path.write_text(BALL)
    ball = jo.read_model(path, parameters={"length": 1.5}).mechanism.bodies[0]
    assert ball.center[1] == -1.5 and ball.markers["knot"][1] == -0.75
    with pytest.raises(jo.InputError, match="no parameter 'lenght' that may be varied; did you"):
        jo.read_model(path, parameters={"lenght": 1.0})


def test_the_file_without_parameters_is_the_same() -> None:
    plain = BALL.partition("bodies")[2].replace("${2 * 1 s}", "2").replace('"${2 * 1e-4}"', "2e-4")
    for name, value in {"mass": "2 kg", "-length": "-0.8", "-half": "-0.4"}.items():
        plain = plain.replace(f"${{{name}}}", value)
    one, other = parse_model(BALL).mechanism, parse_model(f"bodies{plain}").mechanism
    runs = [jo.simulate(jo.compile(m), 0.1, solver=jo.RK4(1e-2)) for m in (one, other)]
    assert (runs[0]["knot"] == runs[1]["knot"]).all()


def test_every_mistake_is_told_at_once_with_its_line() -> None:
    found = problems(
        """
parameters:
  a: ${b}
  b: ${a}
  c: {value: 3 mm, bounds: [1, 4 mm]}
  d: 4 foo
  e: {value: 3, bounds: [4, 5]}
  f: {value: 3, distribution: normel(sd=1)}
  x y: 1
bodies:
  - name: ball
    mass: ${d}
    inertia: [1, 1, "${wal}"]
    center: [0, ${1 kg} m, 0]
"""
    )
    assert [line.split(": ", 2)[0] for line in found] == [
        *(f"model:{i}" for i in (3, 5, 6, 7, 8, 9, 13, 14))
    ]
    text = "\n".join(found)
    for part in (
        "'a' and 'b' depend on one another",
        "c.bounds.0: 1 (a number) and 0.003 m (a length) have different dimensions",
        "no unit 'foo'",
        "value is 3, must be between 4 and 5",
        "no distribution 'normel'; did you mean 'normal'?",
        "the name 'x y' must be letters",
        "inertia.2: ${wal}: no parameter 'wal'",
        "an expression stands alone, such as ${1 kg * 1 m}",
    ):
        assert part in text


def test_a_wrong_dimension_names_the_expression() -> None:
    text = BALL.replace("mass: ${mass}", "mass: ${2 * length}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (found,) = problems(text)
    assert found == (
        "model:6: bodies.0.mass: expects a mass (kg), got 1.6 m (a length); from ${2 * length}"
    )


def test_an_unused_parameter_is_warned_of() -> None:
    with pytest.warns(jo.JoustoWarning, match=r"model:3: parameters.idle: nothing depends on it"):
        parse_model(BALL.replace("parameters:\n", "parameters:\n  idle: 1\n"))


def test_json_has_expressions_too() -> None:
    text = """{"parameters": {"m": 3}, "bodies": [{"name": "b", "mass": "${m * 1 kg}",
    "inertia": [1, 1, 1]}]}"""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert parse_model(text).mechanism.bodies[0].mass == 3.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"bounds": (3, 1)}, "bounds are 3 and 1, the first must be lower"),
        ({"bounds": (3, 4)}, "value is 2, must be between 3 and 4"),
        ({"unit": "mm"}, "unit is 'mm', must be SI: 'm'"),
        ({"unit": "foo"}, "unit is 'foo', must be an SI unit"),
        ({"distribution": 3}, "distribution is 3, must be a text"),
        ({"distribution": "uniform(3, 1)"}, "low is 3, must be below high, 1"),
        ({"distribution": "lognormal(mean=-1, sd=1)"}, "mean is -1, must be positive"),
        ({"distribution": "normal(sigma=1)"}, "normal has no 'sigma'"),
        ({"distribution": "weibull(1)"}, "weibull needs shape"),
        ({"distribution": "normal(1 m, 2)"}, "mean is 1 m (a length), must be like 1"),
    ],
)
def test_a_parameter_says_what_is_wrong(given: dict[str, object], message: str) -> None:
    with pytest.raises(jo.InputError) as error:
        jo.Parameter("x", 2.0, **given)  # type: ignore[arg-type]
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("text", "mean", "deviation"),
    [
        ("normal(mean=3, sd=0.5)", 3.0, 0.5),
        ("lognormal(mean=1e3, sd=100)", 1e3, 100.0),
        ("lognormal(cov=0.2)", 2.0, 0.4),
        ("gumbel(5, 2)", 5.0, 2.0),
        ("uniform(1, 4)", 2.5, 3 / 12**0.5),
        ("triangular(0, 1, 2)", 1.0, 1 / 6**0.5),
        ("weibull(scale=2, shape=1)", 2.0, 2.0),
    ],
)
def test_distributions_have_their_moments(text: str, mean: float, deviation: float) -> None:
    found = jo.Parameter("x", 2.0, distribution=text).distribution
    assert found.mean() == pytest.approx(mean, rel=1e-12)
    assert found.std() == pytest.approx(deviation, rel=1e-12)
