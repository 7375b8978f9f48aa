"""jousto stress: tables, histories, contours."""

from __future__ import annotations

import csv
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest
from click.testing import Result
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app

F, L, B, H = 1.0, 1.0, 0.02, 0.01


def call(*args: object) -> Result:
    return CliRunner().invoke(app, [str(arg) for arg in args])


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cantilever that a force bends."""
    part = jo.Part.beam(L, jo.Rectangle(B, H), 4, jo.Material(210e9, 0.3, 7850.0))
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2), residual_stress=True)
    body = jo.FlexibleBody("arm", reduced)
    wall = jo.Fixed("wall", jo.ground["origin"], body["start"])
    load = jo.Force("load", body["end"], (0, 0, -F))
    model = jo.compile(jo.Mechanism(body, wall, load))
    path = tmp_path_factory.mktemp("cli") / "arm.h5"
    state = jo.equilibrium(model)
    jo.simulate(model, 4e-4, state=state, solver=jo.ROS2(1e-4), output_step=1e-4, path=path)
    return path


def test_envelope(result: Path, tmp_path: Path) -> None:
    shown = call("stress", result, "-o", tmp_path / "all.csv", "--criterion", "s11")
    assert shown.exit_code == 0, shown.output
    # 6 F L / (b h^2) in MPa
    assert "largest (MPa)" in shown.output and f"{6 * F * L / (B * H**2) / 1e6:.4g}" in shown.output
    with open(tmp_path / "all.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    top = next(row for row in rows if row["site"] == "e1.a.top")
    assert float(top["largest s11 (Pa)"]) == pytest.approx(6 * F * L / (B * H**2), rel=1e-3)
    assert top["node"] == "0" and float(top["z (m)"]) == pytest.approx(H / 2)


@pytest.mark.parametrize("criterion", ["principal-3", "s11"])
def test_the_worst_places_come_first(result: Path, criterion: str) -> None:
    """Compression counts: the first row is the first hot spot, the last shown one no milder."""
    field = jo.stress_field(jo.load(result), "arm")
    worst = np.abs(field.values(criterion)).max(axis=0)
    assert field.ns > 12
    for more in ((), ("--at", "0")):
        shown = call("stress", result, "--criterion", criterion, *more)
        assert shown.exit_code == 0, shown.output
        sites = [line.split()[0] for line in shown.output.splitlines()[1:13]]
        found = [worst[field.indices(site)[0]] for site in sites]
        np.testing.assert_allclose(found, np.sort(worst)[::-1][:12], rtol=1e-2)


def test_sites(result: Path, tmp_path: Path) -> None:
    args = ["stress", result, "arm", "-s", "e1.a.top", "--site", "end", "--criterion", "s11"]
    shown = call(*args, "-o", tmp_path / "some.csv")
    assert shown.exit_code == 0, shown.output
    table = np.loadtxt(tmp_path / "some.csv", delimiter=",", skiprows=1)
    run = jo.load(result)
    np.testing.assert_allclose(table[:, 0], run.time)
    field = jo.stress_field(run, "arm", sites=["e1.a.top", "end"])
    np.testing.assert_allclose(table[:, 1:], field.values("s11"), rtol=1e-12)
    picture = call("stress", result, "-s", "e1.a.top", "-o", tmp_path / "top.png")
    assert picture.exit_code == 0 and (tmp_path / "top.png").stat().st_size > 5000


def test_strain_and_residual(result: Path) -> None:
    shown = call("stress", result, "-s", "e1.a.top", "--strain", "--criterion", "e11", "--at", "0")
    strain = 6 * F * L / (B * H**2) / 210e9
    assert shown.exit_code == 0 and f"{1e6 * strain:.6g}" in shown.output
    shown = call("stress", result, "--residual")
    assert shown.exit_code == 0 and "modes: compare with a run of more modes\n" in shown.output


def test_files_for_paraview(result: Path, tmp_path: Path) -> None:
    assert call("stress", result, "-o", tmp_path / "all.vtu").exit_code == 0
    mesh = meshio.read(tmp_path / "all.vtu")
    largest = mesh.point_data["largest von-mises (Pa)"]
    assert int(np.argmax(largest)) == 0 and len(largest) == 5
    run = jo.load(result)
    envelope = jo.stress_field(run, "arm").envelope("von-mises")
    assert largest.max() == pytest.approx(envelope.max.max())
    assert call("stress", result, "-o", tmp_path / "film.pvd").exit_code == 0
    text = (tmp_path / "film.pvd").read_text("utf-8")
    assert text.count("<DataSet") == run.nt and 'file="film_0.vtu"' in text
    frame = meshio.read(tmp_path / "film_4.vtu")
    bent = frame.points[4, 2]
    assert bent == pytest.approx(-4 * F * L**3 / (210e9 * B * H**3), rel=1e-3)
    at = call("stress", result, "--at", "0.2 ms", "-o", tmp_path / "at.vtu")
    assert at.exit_code == 0, at.output
    many = jo.stress_field(run, "arm")
    with pytest.raises(jo.InputError, match="one instant fits into a .vtu file, not 2"):
        jo.write(many, tmp_path / "two.vtu", run, times=[0, 1e-4])


def test_everything_in_a_file(result: Path, tmp_path: Path) -> None:
    assert (
        call("stress", result, "--criterion", "max-shear", "-o", tmp_path / "f.h5").exit_code == 0
    )
    with h5py.File(tmp_path / "f.h5") as file:
        found = file["values/max-shear"][()]
    np.testing.assert_allclose(found, jo.stress_field(jo.load(result), "arm").values("max-shear"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["arn"], "did you mean 'arm'"),
        (["--criterion", "mises"], "'mises' is not a criterion of stress"),
        (["--site", "e1.a.tob"], "did you mean 'e1.a.top'"),
        (["--frame", "globe"], "frame is 'globe', must be 'site', 'body' or 'world'"),
        (["--at", "9"], "outside the run"),
        (["-o", "all.png"], "histories cannot be distinguished"),
        (["-o", "all.xyz"], "is not a format"),
    ],
)
def test_bad_input(result: Path, words: list[str], message: str) -> None:
    shown = call("stress", result, *words)
    assert shown.exit_code == 2
    assert message in " ".join(shown.output.split()), shown.output
