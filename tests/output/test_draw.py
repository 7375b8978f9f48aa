"""Pictures of meshes and modes, and meshes written for other programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import jousto as jo
from jousto.output.scenes.draw import GHOST
from output.blocks import bar
from schema.plates import plate


def colors(path: Path) -> int:
    """Return how many colours a picture has."""
    with Image.open(path) as image:
        return len(image.convert("RGB").getcolors(1 << 24))


def test_pictures_of_a_mesh_a_part_and_a_mode(tmp_path: Path) -> None:
    mesh = plate()
    plain = jo.draw(mesh, tmp_path / "mesh.png")
    marked = jo.draw(mesh, tmp_path / "marked.png", sets=("left", "right"))
    assert 20 < colors(plain) < colors(marked)
    part = jo.Part.solid(mesh, jo.material("S355"), interfaces=(jo.Interface("root", "left"),))
    assert colors(jo.draw(part, tmp_path / "part.png")) > 20
    mode = jo.draw(bar(), tmp_path / "mode.png", mode=0)
    assert colors(mode) > colors(jo.draw(bar(), tmp_path / "still.png"))
    beam = jo.Part.beam(1.0, jo.Rectangle(0.1, 0.1), 4, jo.material("S355"))
    assert colors(jo.draw(beam, tmp_path / "beam.png")) > 20


def test_a_mode_is_drawn_over_the_undeformed_shape(tmp_path: Path) -> None:
    beam = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 6, jo.material("S355"), name="bar")
    reduced = jo.reduce(beam, jo.FreeFree(modes=2))
    with Image.open(jo.draw(reduced, tmp_path / "mode.png", mode=0)) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    # a pale straight bar, from end to end, all of one shade of the pale colour
    shade = pixels[:, :, 1:2] / (255 * GHOST[1])
    pale = np.abs(pixels - 255 * shade * GHOST).max(axis=2) < 2.5
    wide = np.flatnonzero((pale & (shade[:, :, 0] < 0.95)).sum(axis=1) > 0.4 * pixels.shape[1])
    # the bar is 0.03 of its length high, and bends by more
    assert len(wide) == pytest.approx(0.03 * 0.75 * pixels.shape[1], abs=12)
    assert np.ptp(wide) == len(wide) - 1
    text = jo.draw(reduced, tmp_path / "mode.svg", mode=0).read_text()
    assert f"bar, mode 1: {reduced.frequencies[0]:.5g} Hz" in text  # modes are counted from 1


def test_what_cannot_be_drawn_is_said_at_once(tmp_path: Path) -> None:
    with pytest.raises(jo.InputError) as caught:
        jo.draw(bar(), tmp_path / "a.png", mode=7, sets=("lefft",), scale=-1.0)
    found = [problem.message for problem in caught.value.problems]
    assert found[0] == "scale is -1, must be a positive number"
    assert found[1] == "there are modes 0..3, not 7"
    assert found[2].startswith("no set 'lefft'")
    with pytest.raises(jo.InputError, match="has no modes; reduce it first"):
        jo.draw(plate(), tmp_path / "a.png", mode=0)
    with pytest.raises(jo.InputError, match="give a Mesh, a Part or a ReducedPart"):
        jo.draw(3, tmp_path / "a.png")  # type: ignore[arg-type]


def same_shape(again: jo.Mesh, mesh: jo.Mesh) -> bool:
    """Whether a mesh is that which was written; decks keep seven digits."""
    near = np.allclose(again.nodes, mesh.nodes, rtol=0.0, atol=1e-7 * np.ptp(mesh.nodes))
    return near and again.volume == pytest.approx(mesh.volume, rel=1e-6)


@pytest.mark.parametrize("suffix", ["vtu", "vtk", "inp"])
def test_written_meshes_are_read_again_with_their_sets(suffix: str, tmp_path: Path) -> None:
    mesh, path = plate(), tmp_path / f"plate.{suffix}"
    jo.write(mesh, path, unit="mm")
    again = jo.read_mesh(path, unit="mm")
    assert same_shape(again, mesh)
    for name in ("left", "right"):
        assert np.array_equal(again.node_sets[name], mesh.node_sets[name])
    assert np.array_equal(again.element_sets["all"], mesh.element_sets["all"])


@pytest.mark.parametrize("suffix", ["msh", "med"])
def test_meshes_written_without_their_sets_are_read_again(suffix: str, tmp_path: Path) -> None:
    mesh, path = plate(), tmp_path / f"plate.{suffix}"
    with pytest.warns(jo.JoustoWarning, match="written without the sets"):
        jo.write(mesh, path, unit="mm")
    assert same_shape(jo.read_mesh(path, unit="mm"), mesh)


def test_the_surface_as_triangles(tmp_path: Path) -> None:
    text = jo.write(plate(), tmp_path / "plate.stl").read_text(encoding="utf-8")
    vertices = [line.split()[1:] for line in text.splitlines() if "vertex" in line]
    corners = np.array(vertices, dtype=float).reshape(-1, 3, 3)
    six = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    # sixteen chords around the hole
    assert six / 6 == pytest.approx(plate().volume, rel=2e-3)


def test_wrong_endings_are_named(tmp_path: Path) -> None:
    with pytest.raises(jo.InputError, match="'.stp' is not a format to write here"):
        jo.write(plate(), tmp_path / "a.stp")
    with pytest.raises(jo.InputError, match="unit is 'mmm'"):
        jo.write(plate(), tmp_path / "a.vtu", unit="mmm")
