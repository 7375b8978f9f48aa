"""jousto optimise: a bar in bending, whose least height follows by hand."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.base.errors import InputError
from jousto.cli.group import app
from jousto.design import Cycle, Optimum

F, L, B, E, RHO = 100.0, 1.0, 0.02, 210e9, 7850.0
MODEL = """\
parameters:
  height: {value: 10 mm, bounds: [5 mm, 40 mm]}
  width: 20 mm
parts:
  rod:
    type: beam
    length: 1 m
    section: {type: rectangle, width: "${width}", height: "${height}"}
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    elements: 2
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}
bodies:
  - {name: bar, part: rod, damping: 5 %}
  - {name: load, mass: 3 kg, inertia: [1e-3, 1e-3, 1e-3], position: [0, 0, 1]}
joints:
  - {type: fixed, name: wall, a: ground.origin, b: bar.start}
  - {type: prismatic, name: shelf,
     a: {body: ground, at: [0, 0, 1]}, b: load.origin, axis: [1, 0, 0]}
forces:
  - {type: force, name: pull, marker: bar.end, vector: [0, 0, -100],
     signal: {type: s-curve, times: [0, 1], values: [0, 1]}}
fatigue:
  curves: {steel: {S_D: 100 MPa, N_D: 1e6, k: 5, rule: elementary}}
  checks: [{name: root, body: bar, sn: steel, residue: half}]
sensors: [{type: position, name: tip, marker: bar.end}]
simulation: {t_end: 1.2, solver: {type: ROS2, step: 5 ms}, output_step: 50 ms}
limits:
  - stress(bar) <= ${240 MPa / 3}
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "bar.yaml"
    path.write_text(MODEL)
    return path


def jousto(*args: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    return result.exit_code, result.output


def test_methods_side_by_side_from_a_start_that_breaks(model: Path, tmp_path: Path) -> None:
    target, picture = tmp_path / "t.csv", tmp_path / "p.png"
    code, out = jousto("optimise", model, "--compare", "-o", target, "--picture", picture)
    assert code == 0, out
    by_hand = np.sqrt(6 * F * L / B / 80e6)  # sigma = 6 F L / (b h^2)
    with target.open(newline="") as file:
        rows = list(csv.DictReader(file))
    methods = ["esl, order 1", "esl, order 0", "direct"]
    assert list(dict.fromkeys(row["method"] for row in rows)) == methods
    for method in methods:
        last = [row for row in rows if row["method"] == method][-1]
        # what is left of the load's ramp over 1 s of a bar with 16 Hz is below a thousandth
        assert float(last["height"]) == pytest.approx(by_hand, rel=2e-3)
        # the mass is that of all that moves
        mass = 3.0 + RHO * B * L * float(last["height"])
        assert float(last["cost"]) == pytest.approx(mass, rel=1e-9)
    assert picture.exists() and "active: von-mises of bar" in out
    table = {line[:16].strip(): line.split()[-3:] for line in out.splitlines() if "  " in line}
    costs = [float(cell) for cell in table["cost"]]
    assert costs == pytest.approx([costs[0]] * 3, rel=1e-3)
    assert table["converged"] == ["yes"] * 3


def test_a_page_has_all_methods_the_chosen_one_first(model: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    code, out = jousto("optimise", model, "--compare", "--method", "direct", "-o", page)
    assert code == 0, out
    assert out.index("direct: converged") < out.index("esl, order 1")
    text = page.read_text()
    head = text[text.index("<tr><th></th>") : text.index("</tr>")]
    assert re.findall("<th>([^<]+)</th>", head) == ["direct", "esl, order 1", "esl, order 0"]
    assert text.count("what bounds the design") == 3
    assert text.count("von-mises of bar") >= 3
    assert text.count("<img") == 1
    # the page of one method
    code, out = jousto("optimise", model, "--method", "esl0", "-o", page)
    assert code == 0, out
    assert page.read_text().count("what bounds the design") == 1


def test_a_comparison_says_by_how_much_a_method_misses() -> None:
    def optimum(method: str, cost: float, ratio: float) -> Optimum:
        history = (Cycle({"h": 1.0}, cost, ratio, 0.0, 0.0, 1),)
        return Optimum(method, {"h": 1.0}, cost, ratio, ratio <= 1, "", (), 0.0, 1, history)

    found = jo.design.Comparison([optimum("a", 11, 1), optimum("b", 9, 1.2), optimum("c", 10, 1)])
    table = {name: cells for name, *cells in found.table}
    # the lightest design that keeps its limits is c, not b
    assert table["excess"] == ["10.000%", "-10.000%", "0.000%"]
    assert table["converged"] == ["yes", "no", "yes"]
    with pytest.raises(InputError, match="there are no optima"):
        jo.design.Comparison([])
    with pytest.raises(InputError, match="must be an Optimum"):
        jo.design.Comparison([3.0])  # type: ignore[list-item]
    other = replace(found.optima[0], values={"b": 1.0})
    with pytest.raises(InputError, match="different parameters"):
        jo.design.Comparison([found.optima[0], other])


def scattered(model: Path) -> Path:
    """Return the bar with a load and a height that scatter."""
    text = model.read_text()
    text = text.replace("vector: [0, 0, -100]", 'vector: [0, 0, "${-load}"]')
    text = text.replace("height: {value: 10 mm", "height: {value: 25 mm")
    text = text.replace("40 mm]}", "40 mm], distribution: normal(sd=0.4 mm)}")
    text = text.replace(
        "  width: 20 mm", "  width: 20 mm\n  load: {value: 100 N, distribution: normal(sd=10 N)}"
    )
    model.write_text(text + "reliability: {target: 2.5}\n")
    return model


def height_by_hand(beta: float) -> float:
    """Return the mean height whose worst stress on the circle of an index is 80 MPa."""
    turn = np.linspace(0.0, 2.0 * np.pi, 100_001)
    load, off = F + 10.0 * beta * np.cos(turn), 4e-4 * beta * np.sin(turn)
    return float(np.max(np.sqrt(6 * load * L / (B * 80e6)) - off))


def test_a_reliable_height(model: Path, tmp_path: Path) -> None:
    target, picture = tmp_path / "t.csv", tmp_path / "p.png"
    code, out = jousto(
        *("optimise", scattered(model), "--reliable", "--minimise", "mass(bar)"),
        *("-o", target, "--picture", picture),
    )
    assert code == 0, out
    with target.open(newline="") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    # the first row is the design without scatter
    assert rows[0]["height"] == pytest.approx(np.sqrt(6 * F * L / B / 80e6), rel=2e-3)
    assert rows[-1]["height"] == pytest.approx(height_by_hand(2.5), rel=2e-3)
    assert rows[-1]["cost"] == pytest.approx(RHO * B * L * rows[-1]["height"], rel=1e-9)
    assert "beta of stress(bar)  target 2.5" in out and "2.5, active" in out
    assert picture.exists()


def test_a_reliable_height_of_options(model: Path) -> None:
    # bounds of an option leave the scatter of the file
    options = ["--reliable", "--target", "3", "--vary", "height=10..40mm", "--minimise", "height"]
    code, out = jousto("optimise", scattered(model), *options)
    assert code == 0, out
    line = next(line for line in out.splitlines() if line.split()[:1] == ["height"])
    assert float(line.split()[-1]) == pytest.approx(height_by_hand(3.0), rel=2e-3)


def test_reliable_designs_that_cannot_be(model: Path) -> None:
    code, out = jousto("optimise", model, "--reliable")
    assert code == 2
    assert "no parameter has distribution" in out
    code, out = jousto(
        *("optimise", scattered(model), "--reliable", "--compare", "--target", "-1"),
        *("-o", "page.html"),
    )
    assert code == 2
    assert "--target: is -1, must be positive" in out
    assert "--compare: is for designs without scatter" in out
    assert "page.html" in out
    code, out = jousto("optimise", model, "--target", "3")
    assert code == 2 and "add --reliable" in out
    # no height within the bounds is enough
    options = [
        "--reliable",
        "--vary",
        "height=14..15mm",
        "--vary",
        "height=normal(mean=14.9 mm, sd=0.4 mm)",
    ]
    code, out = jousto("optimise", model, *options)
    assert code == 1, out
    assert "no design reaches the targets" in out
    file = jo.read_model(model)
    with pytest.raises(InputError, match="no target index"):
        plain = replace(file, reliability=type(file.reliability)())
        jo.design.file_rbdo(plain)


def test_deflection_limits_the_height(model: Path) -> None:
    file = jo.read_model(model)
    problem = jo.design.file_problem(file, "deflection(bar, end, start) <= 8 mm", cost="2 * height")
    found = jo.design.optimise(problem, order=0, tolerance=1e-4)
    by_hand = (4 * F * L**3 / (E * B * 8e-3)) ** (1 / 3)  # d = F L^3 / (3 E I)
    assert found.values["height"] == pytest.approx(by_hand, rel=2e-3)
    assert found.cost == 2 * found.values["height"]
    outcome = jo.study(file, "height", "deflection(bar, end, start)")
    assert outcome([[found.values["height"]]])[0, 0] == pytest.approx(8e-3, rel=1e-4)


def test_frequency_limits_the_height(model: Path, tmp_path: Path) -> None:
    target = tmp_path / "t.csv"
    code, out = jousto(
        *("optimise", model, "--limit", "frequency(2) >= 12 Hz", "--minimise", "mass(bar)"),
        *("-o", target, "--method", "esl0"),
    )
    assert code == 0, out
    # f = 1.8751^2 / (2 pi L^2) sqrt(E h^2 / (12 rho)); mode 1 is the load on its slide, 0 Hz
    by_hand = 12 * 2 * np.pi * L**2 / 1.87510407**2 * np.sqrt(12 * RHO / E)
    rows = np.genfromtxt(target, delimiter=",", skip_header=1)
    assert rows[-1, 1] == pytest.approx(by_hand, rel=2e-3)  # two elements
    assert rows[-1, 2] == pytest.approx(RHO * B * L * rows[-1, 1], rel=1e-9)


def test_a_design_that_cannot_be_is_said(model: Path) -> None:
    code, out = jousto("optimise", model, "--vary", "height=5..12mm", "--method", "esl0")
    assert code == 1
    assert "a limit is exceeded, the largest ratio is" in out and "height           0.012" in out


def test_all_mistakes_are_told(model: Path) -> None:
    file = jo.read_model(model)
    limits = ["max(tip.z) <= 3 mm", "stress(bar) >= 1 MPa", "stress(bar) <= 2 GPa * height / width"]
    limits += ["life(root) >= 1000 h", "life(rot) >= 1000 h", "stress(bar) <= 3 kg"]
    with pytest.raises(InputError) as caught:
        jo.design.file_problem(file, limits, cost="stress(bar)")
    assert [problem.message for problem in caught.value.problems] == [
        "an optimisation limits stress, deflection, frequency, life and damage; max(tip.z) is none "
        "of these",
        "must be <=",
        "its bound depends on height, which the optimisation varies",
        "an optimisation supports residue repeat and a plain S-N curve only, not residue half",
        "no check 'rot' under fatigue; did you mean 'root'?",
        "3 kg (a mass) is not a bound for stress(bar), which is in Pa",
        "needs a run at every design; the cost must follow from the dimensions",
    ]
    with pytest.raises(InputError, match="is neither an outcome nor"):
        jo.design.file_problem(file, cost="hight")
    with pytest.raises(InputError, match="the same for all designs; name .* bounds: height"):
        jo.design.file_problem(file, cost="2 * 3 mm")
    with pytest.raises(InputError, match="no parameter has bounds"):
        jo.design.file_problem(file, parameters=[file.parameters[1]])
    code, out = jousto("optimise", model, "--limit", "frequency(1) >= 1 Hz")
    assert code == 2 and "mode 1 has 0 Hz: a motion without stiffness; limit another" in out
    code, out = jousto("optimise", model, "--vary", "height=40..5mm", "--method", "esl")
    assert code == 2
    assert "--vary height: 0.04 must be below 0.005" in out
    assert "--method: is 'esl'; did you mean" in out
