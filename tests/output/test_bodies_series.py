"""All bodies of a run for ParaView: read back by meshio, and by the rules of its .pvd files."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call

G, RADIUS, LENGTH = 9.81, 0.02, 1.0
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> jo.Solution:
    """Return a falling ball, a bending arm and an exact beam that falls as it is."""
    ball = jo.RigidBody.sphere("ball", 0.1, mass=1.0, position=(3, 0, 0))
    part = jo.Part.beam(LENGTH, jo.Rectangle(0.02, 0.025), 4, STEEL)
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    ends = [(0, 1, 0), (LENGTH, 1, 0)]
    beam = jo.BeamBody("rod", ends, jo.Circle(2 * RADIUS), STEEL, elements=2)
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        mechanism = jo.Mechanism(ball, arm, pin, beam, jo.Gravity((0, 0, -G)))
    model = jo.compile(mechanism)
    path = tmp_path_factory.mktemp("series") / "run.h5"
    return jo.simulate(model, 0.02, output_step=5e-3, path=path)


def pieces(path: Path) -> list[tuple[float, meshio.Mesh]]:
    """Return the times and meshes that a .pvd file names, as ParaView reads it."""
    root = ElementTree.parse(path).getroot()
    assert (root.tag, root.get("type")) == ("VTKFile", "Collection")
    return [
        (float(str(x.get("timestep"))), meshio.read(path.parent / str(x.get("file"))))
        for x in root.iter("DataSet")
    ]


def of(mesh: meshio.Mesh, number: int) -> np.ndarray:
    return np.asarray(mesh.points[mesh.point_data["body"] == number])


def test_a_series_has_all_bodies_where_they_are(run: jo.Solution, tmp_path: Path) -> None:
    found = pieces(jo.write(run, tmp_path / "machine.pvd"))
    np.testing.assert_allclose([t for t, _ in found], run.time, rtol=1e-14, atol=0)
    for t, mesh in found:
        assert set(mesh.point_data["body"]) == {1, 2, 3}
        fallen = -0.5 * G * t**2
        moved = mesh.point_data["displacement (m)"]
        number = mesh.point_data["body"]
        for k in (1, 3):  # both fall freely, without turning or bending
            # a step of 1 ms is exact for constant acceleration, to the tolerance of the method
            np.testing.assert_allclose(moved[number == k], [(0, 0, fallen)] * sum(number == k),
                                       rtol=0, atol=1e-9)  # fmt: skip
        stress = mesh.point_data["von Mises (Pa)"]
        assert np.isnan(stress[number == 1]).all() and np.isfinite(stress[number == 2]).all()
        cells = np.unique(np.concatenate([x.data.ravel() for x in mesh.cells]))
        assert len(cells) == len(mesh.points)  # every point belongs to a cell


def test_an_exact_beam_is_a_tube_of_its_section(run: jo.Solution, tmp_path: Path) -> None:
    jo.write(run, tmp_path / "start.vtu", times=[0.0])
    x = of(meshio.read(tmp_path / "start.vtu"), 3)
    away = np.hypot(x[:, 1] - 1.0, x[:, 2])
    rim = away > 0.5 * RADIUS  # without the middles of the ends
    np.testing.assert_allclose(away[rim], RADIUS, rtol=1e-9)
    assert (x[:, 0].min(), x[:, 0].max()) == pytest.approx((0.0, LENGTH), abs=1e-12)


def test_one_instant_is_the_last_one(run: jo.Solution, tmp_path: Path) -> None:
    jo.write(run, tmp_path / "end.vtu")
    ball = of(meshio.read(tmp_path / "end.vtu"), 1)
    middle = 0.5 * (ball.min(axis=0) + ball.max(axis=0))
    np.testing.assert_allclose(middle, (3, 0, -0.5 * G * 0.02**2), atol=1e-9)
    with pytest.raises(jo.InputError, match="one instant fits into a .vtu file"):
        jo.write(run, tmp_path / "two.vtu", times=[0.0, 0.01])


def test_the_command_writes_the_same(run: jo.Solution, tmp_path: Path) -> None:
    file = Path(run.where)
    code, said = call("export", file, "-o", tmp_path / "machine.pvd")
    assert code == 0, said
    assert len(pieces(tmp_path / "machine.pvd")) == run.nt
    code, said = call("export", file, "tip", "-o", tmp_path / "machine.pvd")
    assert code == 2 and "has no sensors to name" in said
