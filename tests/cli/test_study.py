"""jousto study: variations, samples, tables, all mistakes at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app

MODEL = """\
parameters:
  mass: {value: 2 kg, bounds: [1 kg, 8 kg]}
  force: {value: 4 N, distribution: normal(sd=0.1 N)}
bodies: [{name: block, mass: "${mass}", inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: slide, a: ground.origin, b: block.origin, axis: [1, 0, 0]}]
forces: [{type: joint-force, name: push, coordinate: slide.displacement, signal: "${force}"}]
sensors: [{type: coordinate, name: way, coordinate: slide.displacement}]
simulation: {t_end: 1 s, solver: {type: RK4, step: 100 ms}}
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "block.yaml"
    path.write_text(MODEL)
    return path


def jousto(*args: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    return result.exit_code, result.output


def test_a_grid_makes_a_table(model: Path) -> None:
    code, out = jousto(
        *("study", model, "--vary", "mass=1..4kg/4", "--vary", "force=2,4"),
        *("--outcome", "last(way)", "--outcome", "m = mass"),
    )
    assert code == 0, out
    table = jo.design.read_study(model.with_name("block-study.h5"))
    assert len(table) == 8 and table.good.all()
    np.testing.assert_allclose(table["last(way)"], table["force"] / table["mass"] / 2, rtol=1e-12)
    assert (table["m"] == table["mass"]).all()
    assert "<StudyTable: 8 points of mass, force; last(way), m>" in out


def test_a_grid_goes_with_samples_of_what_scatters(model: Path, tmp_path: Path) -> None:
    target = tmp_path / "t.csv"
    code, out = jousto(
        *("study", model, "--vary", "mass=1..4/4", "--vary", "force", "--samples", 5),
        *("--outcome", "last(way)", "-o", target, "-q"),
    )
    assert (code, out) == (0, "")
    rows = np.genfromtxt(target, delimiter=",", skip_header=1)
    assert len(rows) == 20 and len(set(rows[:, 1])) == 20
    assert sorted(set(rows[:, 0])) == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize("method", ["lhs", "sobol", "random"])
def test_samples_in_bounds(model: Path, method: str) -> None:
    code, out = jousto(
        *("study", model, "--vary", "mass=1..2", "--samples", 4, "--method", method),
        *("--outcome", "last(way)"),
    )
    assert code == 0, out
    mass = jo.design.read_study(model.with_name("block-study.h5"))["mass"]
    assert len(mass) == 4 and (mass >= 1).all() and (mass <= 2).all()


def test_points_of_a_file(model: Path, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("mass (g),force\n2000,8\n4000,8\n")
    code, out = jousto("study", model, "--samples", path, "--outcome", "last(way)")
    assert code == 0, out
    table = jo.design.read_study(model.with_name("block-study.h5"))
    np.testing.assert_allclose(table["last(way)"], [2.0, 1.0], rtol=1e-12)


def test_all_mistakes_are_told_before_the_run(model: Path, tmp_path: Path) -> None:
    code, out = jousto(
        *("study", model, "--vary", "mas=1..4/4", "--vary", "force=nrmal(1)"),
        *("--vary", "mass=4..1/3", "--vary", "mass=1 m,2", "--samples", "some"),
        *("--outcome", "maxx(way)", "-o", tmp_path / "t.txt", "--method", "lsh", "--on", "dusk"),
    )
    assert code == 2
    assert [line.split(":")[0] for line in out.replace(str(tmp_path), "").splitlines()] == [
        *("/t.txt", "--samples", "--method", "--on", "--vary", "--vary force", "--vary mass"),
        *("--vary mass", "outcome 'maxx(way)'"),
    ]
    code, out = jousto("study", model, "--vary", "mass=1..2", "--outcome", "max(wy)")
    assert code == 2 and "--samples: give the number of samples" in out
    code, out = jousto("study", model, "--vary", "mass=1,2", "--outcome", "max(wy)")
    assert code == 2 and "no sensor 'wy'; did you mean 'way'?" in out
    code, out = jousto("study", model, "--outcome", "mass")
    assert code == 2 and "--vary: name the parameters to vary: mass, force" in out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--vary", "mass=1..4kg/1000000000"], "--vary mass: 1e+09 points, a study takes"),
        (["--vary", f"mass=1..4kg/{'9' * 5000}"], "--vary mass: inf points, a study takes"),
        (
            ["--vary", "mass=1..4kg/2000", "--vary", "force=1..4N/2000"],
            "grid: 4e+06 points, a study takes 1,000,000 at most",
        ),
        (["--vary", "mass", "--samples", "1000000000"], "--samples: 1e+09 points"),
        (
            ["--vary", "mass=1..4kg/2000", "--vary", "force", "--samples", "2000"],
            "--samples: 4e+06 points",
        ),
    ],
)
def test_more_points_than_a_study_holds_are_refused_before_they_are_made(
    model: Path, options: list[str], said: str
) -> None:
    import tracemalloc

    tracemalloc.start()
    try:
        code, out = jousto("study", model, *options, "--outcome", "last(way)")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert code != 0 and said in " ".join(out.split()), out
    assert peak < 100e6  # a list of 1e9 numbers has 8 GB
