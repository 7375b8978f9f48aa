"""Pictures of exact beams: swept sections with stress, resultants, shapes, files for ParaView."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import jousto as jo
from jousto.output.scenes.stage import make_stage
from jousto.recovery.beams.strains import exponential
from jousto.recovery.fields.criteria import evaluate
from jousto.scene.make import make_scene
from jousto.scene.sections import outline_rows, tube
from jousto.scene.values_at_rows import rows_at, section_axes, stresses, vertices
from recovery.beams.cases import cantilever


@pytest.fixture(scope="module")
def bent() -> jo.Solution:
    return cantilever((0.0, 3.0, -10.0), 4)


def test_skin_of_a_cantilever(bent: jo.Solution) -> None:
    """Its volume is that of the beam, its stress at the corners of the clamp that of the field."""
    scene = make_scene(bent)
    (body,), row = scene.bodies, rows_at(scene, [0.0])
    x, tensors = vertices(body, row)[0], stresses(body, row)[0]
    a, b, c = (x[body.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(0.02 * 0.04, rel=1e-4)
    exact = 6.0 * 10.0 / (0.02 * 0.04**2) + 6.0 * 3.0 / (0.04 * 0.02**2)
    assert evaluate(tensors, "von-mises").max() == pytest.approx(exact, rel=1e-4)
    corner = int(np.argmax(tensors[:, 0]))
    assert x[corner] == pytest.approx([0.0, -0.01, 0.02], abs=1e-6)
    z = section_axes(body.rings, row)[0, 0, :, 2]
    assert z == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)


def test_edge_of_a_round_section_has_its_stress() -> None:
    """Bending stress M r sin / I all around, torsion T r / J everywhere."""
    from jousto.model.beam_record import SectionShape
    from jousto.sections.points import section_outline, stress_points

    points = stress_points(jo.Circle(0.02))
    section = SectionShape(
        tuple(p.name for p in points),
        np.array([(p.y, p.z) for p in points]),
        np.array([p.rows for p in points]),
    )
    edge = section_outline(jo.Circle(0.02))
    rows = outline_rows(section, edge)
    I = np.pi * 0.02**4 / 64.0
    assert rows[:, 0, 4] == pytest.approx(edge[:, 1] / I, abs=1e-6 / I)
    assert rows[:, 0, 5] == pytest.approx(-edge[:, 0] / I, abs=1e-6 / I)


def test_tubes_are_closed() -> None:
    triangles = tube(3, 5)
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    there, back = {tuple(x) for x in pairs.tolist()}, {tuple(x[::-1]) for x in pairs.tolist()}
    assert there == back and len(there) == len(pairs)


def test_scene_shows_beams_and_no_nodes(bent: jo.Solution) -> None:
    stage = make_stage(bent, np.array([0.0]), scale=1.0, view=None, trail=None, stress=True)
    assert len(stage.bodies) == 1 and stage.limit > 0.0
    surface = stage.bodies[0].surface
    assert surface is not None and surface.closed


def test_pictures_and_films(bent: jo.Solution, tmp_path: Path) -> None:
    jo.still(bent, tmp_path / "still.png", times=[0.0], stress=True)
    jo.plot(bent, beam="beam", times=[0.0, 1e-9], path=tmp_path / "shape.png")
    forces = jo.recovery.section_forces(bent, "beam")
    figure = jo.plot(forces, times=[0.0, 1e-9], path=tmp_path / "forces.png")
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert "My (N m)" in labels and "Qz (N)" in labels and "Mx (N m)" not in labels
    line = next(ax for ax in figure.axes if ax.get_ylabel() == "My (N m)").lines[0]
    assert line.get_ydata()[0] == pytest.approx(10.0, rel=1e-4)
    jo.plot(forces, components="My", at="start", path=tmp_path / "history.png")
    jo.plot(jo.hot_spots(bent, count=2), bent, path=tmp_path / "spots.png")
    for name in ("still", "shape", "forces", "history", "spots"):
        assert (tmp_path / f"{name}.png").stat().st_size > 2000


def test_files_for_paraview(bent: jo.Solution, tmp_path: Path) -> None:
    jo.write(bent, tmp_path / "beam.vtu", beam="beam", times=[0.0])
    mesh = meshio.read(tmp_path / "beam.vtu")
    # as in the skin: both bending moments at a corner of the clamp
    assert mesh.point_data["von Mises (Pa)"].max() == pytest.approx(3.0e6, rel=1e-4)
    assert np.linalg.norm(mesh.point_data["section y"], axis=1) == pytest.approx(1.0)
    jo.write(bent, tmp_path / "film.pvd", beam="beam", times=[0.0, 1e-9])
    assert (tmp_path / "film_1.vtu").exists()
    field = jo.stress_field(bent, "beam")
    jo.write(field, tmp_path / "line.vtu", bent)
    line = meshio.read(tmp_path / "line.vtu")
    assert len(line.points) == 5 and line.cells[0].type == "line"
    jo.write(field, tmp_path / "then.vtu", bent, times=[0.0])
    assert meshio.read(tmp_path / "then.vtu").points[-1, 2] < -1e-5
    with pytest.raises(jo.InputError, match="one instant fits"):
        jo.write(bent, tmp_path / "beam.vtu", beam="beam", times=[0.0, 1e-9])


def test_unknown_beams_are_named(bent: jo.Solution, tmp_path: Path) -> None:
    with pytest.raises(jo.InputError, match="did you mean 'beam'"):
        jo.plot(bent, beam="bean")
    with pytest.raises(jo.InputError, match="did you mean 'beam'"):
        jo.write(bent, tmp_path / "a.vtu", beam="bean")
    with pytest.raises(jo.InputError, match="at least one beam"):
        jo.plot(bent, beam=[])
    assert exponential(np.zeros((1, 3)))[0] == pytest.approx(np.eye(3))
