"""jousto reliability: limits of model files, against the closed form of a pushed block."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest
from scipy.stats import norm
from typer.testing import CliRunner

from jousto.cli.group import app

MODEL = """\
parameters:
  mass: {value: 2 kg, bounds: [1 kg, 8 kg], distribution: normal(sd=0.2 kg)}
  force: {value: 4 N, distribution: normal(sd=0.4 N)}
  room: {value: 1.4 m, distribution: normal(sd=1 cm)}
  reach: ${room + 10 cm}
bodies: [{name: block, mass: "${mass}", inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: slide, a: ground.origin, b: block.origin, axis: [1, 0, 0]}]
forces: [{type: joint-force, name: push, coordinate: slide.displacement, signal: "${force}"}]
sensors: [{type: coordinate, name: way, coordinate: slide.displacement}]
simulation: {t_end: 1 s, solver: {type: RK4, step: 100 ms}}
limits:
  - far = last(way) <= 1.5 m
  - last(way) <= ${reach}
reliability:
  target: 3
  correlations: [{of: [mass, force], value: 0.2}]
"""
# way = F / 2 m: 3 m - F is linear
BETA = 2.0 / math.sqrt(0.6**2 + 0.4**2 - 2 * 0.2 * 0.6 * 0.4)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "block.yaml"
    path.write_text(MODEL)
    return path


def jousto(*args: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    return result.exit_code, result.output


def table(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_limits_and_correlations_of_a_file(model: Path, tmp_path: Path) -> None:
    target, picture = tmp_path / "t.csv", tmp_path / "p.png"
    code, out = jousto("reliability", model, "-o", target, "--picture", picture)
    assert code == 0, out
    first, second = table(target)
    assert float(first["beta"]) == pytest.approx(BETA, abs=1e-4)
    at = 3 * float(first["mass at the design point"]) - float(first["force at the design point"])
    assert at == pytest.approx(0.0, abs=1e-3)
    # the bound scatters as well: a little less sure
    assert BETA - 0.05 < float(second["beta"]) < BETA - 1e-3
    assert "target 3  reached" in out and "nothing depends" not in out
    assert f"picture of last(way) in {picture}" in out and picture.exists()


def test_what_only_a_bound_depends_on_costs_no_runs(model: Path, tmp_path: Path) -> None:
    few = tmp_path / "few.csv"
    limit = ("--limit", "last(way) <= reach", "--method", "mc", "--samples", 20, "-o", few)
    text = MODEL.partition("limits:")[0].replace(", distribution: normal(sd=0.4 N)", "")
    model.write_text(text.replace(", distribution: normal(sd=0.2 kg)", ""))
    code, out = jousto("reliability", model, *limit)
    assert code == 0, out
    assert table(few)[0]["calls"] == "20" and table(few)[0]["runs"] == "1"


@pytest.mark.parametrize("method", ["sorm", "mc", "is", "subset"])
def test_methods(model: Path, tmp_path: Path, method: str) -> None:
    target = tmp_path / "t.csv"
    code, out = jousto(
        *("reliability", model, "--limit", "last(way) <= 1.15 m", "--method", method),
        *("--samples", 100, "-o", target),
    )
    assert code == 0, out
    (row,) = table(target)
    # 2.3 m - F
    deviation = math.sqrt(0.46**2 + 0.4**2 - 2 * 0.2 * 0.46 * 0.4)
    exact = norm.sf(0.6 / deviation)
    if method == "sorm":
        assert float(row["Pf"]) == pytest.approx(exact, rel=1e-2)
    else:  # intervals of 95 %, of seeds that are always the same
        assert float(row["Pf from"]) < exact < float(row["Pf to"])


def test_a_limit_out_of_reach_is_said_and_the_others_go_on(model: Path) -> None:
    code, out = jousto(
        *("reliability", model, "--limit", "last(way) >= 5 cm", "--limit", "x = last(way) <= 1.5"),
        *("--vary", "force=normal(sd=0.2 N)"),
    )
    assert code == 1
    assert "no failure found" in out and "within beta = 8" in out
    exact = 2.0 / math.sqrt(0.6**2 + 0.2**2 - 2 * 0.2 * 0.6 * 0.2)
    assert f"beta      {exact:.3g}" in out


def test_all_mistakes_are_told(model: Path, tmp_path: Path) -> None:
    code, out = jousto(
        *("reliability", model, "--limit", "last(way)", "--limit", "lost(way) <= 1"),
        *("--vary", "mass=1..2", "--method", "fom", "--on", "dusk", "--target", -1),
        *("-o", tmp_path / "t.txt"),
    )
    assert code == 2
    for text in (
        "t.txt: ",
        "--method: is 'fom'; did you mean 'form'?",
        "--on: is 'dusk'",
        "--target: is -1, must be positive",
        "limit 'last(way)': a limit is an outcome",
        "no outcome 'lost'; did you mean 'last'?",
        "--vary mass: has no distribution",
    ):
        assert text in out, text
    model.write_text(MODEL.partition("limits:")[0].replace("distribution", "#"))
    code, out = jousto("reliability", model)
    assert code == 2


def test_mistakes_of_a_file_have_lines(model: Path) -> None:
    text = MODEL.replace("last(way) <= 1.5 m", "last(way) < > 1").replace("target: 3", "target: -3")
    text = text.replace("[mass, force], value: 0.2", "[mas, force], value: 1.2")
    model.write_text(text.replace("<= ${reach}", "<= ${rich}"))
    code, out = jousto("check", model)
    assert code == 2
    lines = [line for line in out.splitlines() if not line.startswith("warning")]
    assert [line.split(": ")[0] for line in lines] == [
        *("block.yaml:12", "block.yaml:13", "block.yaml:15"),
        *("block.yaml:16", "block.yaml:16"),
    ]
    assert "no parameter 'mas' with a distribution; did you mean 'mass'?" in out
    assert "'rich'" in out


def test_a_limit_of_what_the_machine_does_not_have(model: Path) -> None:
    code, out = jousto("reliability", model, "--limit", "last(wy) <= 1 m")
    assert code == 2 and "no sensor 'wy'; did you mean 'way'?" in out
    code, out = jousto("reliability", model, "--limit", "last(way) <= 3 kg")
    assert code == 2 and "is not a bound for last(way), which is in m" in out


@pytest.mark.parametrize("method", ["form", "sorm", "mc", "is", "subset"])
def test_limits_without_an_answer(model: Path, tmp_path: Path, method: str) -> None:
    """The way at the start depends on nothing; a mass below zero ends far searches."""
    target = tmp_path / "t.csv"
    options = ("--method", method, "--samples", 20, "-o", target)
    code, out = jousto("reliability", model, "--limit", "first(way) <= 1 m", *options)
    if method == "mc":  # nothing fails, which needs no gradient; the index at the target does
        assert code == 0, out
        assert "nothing failed" in out and "no reserve at the target: limit state" in out
        assert table(target)[0]["Pf"] == "0.0" and "target 3" not in out
    else:
        assert code == 1
        said = "is 1 at all 20 points" if method == "subset" else "its gradient is zero"
        assert said in out and not target.exists()
    code, out = jousto("reliability", model, "--limit", "last(way) >= 100 m", *options)
    if method in ("mc", "subset"):
        assert code == 0 and "20 of 20" in out and "missed" in out
    else:
        assert code == 1 and "mass is -" in out and "must be a positive number" in out


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[1 kg, 8 kg]", "[8 kg, 1 kg]", "mass: bounds are 8 and 1, the first must be lower"),
        ("normal(sd=0.4 N)", "cauchy(1 N)", "force: no distribution 'cauchy'"),
        ("normal(sd=0.4 N)", "normal(sd=0 N)", "force: sd is 0, must be positive"),
        ("normal(sd=0.4 N)", "lognormal(cov=1e200)", "force: distribution has no median"),
        (
            "value: 0.2}]",
            "value: 0.9}, {of: [force, room], value: 0.9}, {of: [mass, room], value: -0.9}]",
            "mass, force, room contradict one another",
        ),
        ("value: 0.2}]", "value: 0.2}, {of: [force, mass], value: 0}]", "is given twice"),
        ("target: 3", "target: 50", "must be at most 38: smaller probabilities underflow"),
    ],
)
def test_files_that_cannot_be(model: Path, old: str, new: str, said: str) -> None:
    model.write_text(MODEL.replace(old, new))
    code, out = jousto("reliability", model)
    assert code == 2 and said in out, out
