"""CAD files: what Gmsh's OpenCASCADE kernel writes, meshed and held against closed forms."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from gmsh_session import opened
from jousto.base.errors import InputError
from jousto.mesh.readers.cad import step_unit
from jousto.mesh.readers.step import _eased

from .blocks import block

gmsh = pytest.importorskip("gmsh")
ARM = Path(__file__).parents[2] / "examples" / "data" / "link_arm.step"
IGES = b" " * 72 + b"S0000001\n,,31HOpen CASCADE IGES processor 7.8"
PLATE = (40 * 20 * 10 - np.pi * 25 * 10) * 1e-9  # m^3


@pytest.fixture(scope="module")
def cad(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Geometry in mm: a plate with a hole, two cubes that touch, a face, a pin."""
    folder = tmp_path_factory.mktemp("cad")
    with opened(gmsh):
        occ = gmsh.model.occ

        def write(name: str) -> None:
            occ.synchronize()
            for suffix in ("step", "brep"):
                gmsh.write(str(folder / f"{name}.{suffix}"))
            gmsh.clear()

        occ.cut(
            [(3, occ.addBox(0, 0, 0, 40, 20, 10))], [(3, occ.addCylinder(20, 10, -5, 0, 0, 20, 5))]
        )
        write("plate")
        occ.addBox(0, 0, 0, 10, 10, 10)
        occ.addBox(10, 0, 0, 10, 10, 10)
        write("cubes")
        occ.addRectangle(0, 0, 0, 10, 10)
        write("face")
        occ.addCylinder(0, 0, 0, 0, 0, 50, 10)
        write("pin")
    return folder


def test_plate_with_a_hole(cad: Path) -> None:
    mesh = jo.mesh_cad(cad / "plate.step", size=4e-3)
    assert mesh.check() == ()
    # parabolas round the hole: nearly the exact volume; the file's millimetres became metres
    assert mesh.volume == pytest.approx(PLATE, rel=1e-5)
    straight = jo.mesh_cad(cad / "plate.step", size=4e-3, curved=False)
    linear = jo.mesh_cad(cad / "plate.step", size=4e-3, order=1)
    assert linear.solids[0].kind == "tetra"
    # chords: the hole is the polygon of 12 sides or more, 12/(2 pi) sin(2 pi/12) of the circle
    hole = np.pi * 25 * 10 * 1e-9
    for coarse in (straight, linear):
        assert PLATE < coarse.volume < PLATE + hole * (1 - 6 / np.pi * np.sin(np.pi / 6)) * 1.001
    # sizes: the mean edge is near the wanted one
    a, b = mesh.solids[0].nodes[:, 0], mesh.solids[0].nodes[:, 1]
    assert 2e-3 < np.linalg.norm(mesh.nodes[a] - mesh.nodes[b], axis=1).mean() < 5e-3


def test_faces_keep_their_numbers(cad: Path) -> None:
    mesh = jo.mesh_cad(cad / "plate.step", size=6e-3)
    assert set(mesh.surfaces) == {f"face{i}" for i in range(1, 8)}
    # together they are the outer surface, each face once, corners and midside nodes of the mesh
    every = np.concatenate([np.sort(f[:, :3], axis=1) for f in mesh.surfaces.values()])
    (outer,) = mesh.faces
    np.testing.assert_array_equal(
        np.unique(every, axis=0), np.unique(np.sort(outer.corners, axis=1), axis=0)
    )
    assert len(every) == len(outer)
    by_corner = {tuple(sorted(row[:3])): row for row in outer.nodes.tolist()}
    for faces in mesh.surfaces.values():
        for row in faces.tolist():
            assert sorted(by_corner[tuple(sorted(row[:3]))][3:]) == sorted(row[3:])
    (hole,) = mesh.holes()
    np.testing.assert_array_equal(mesh.set(hole.name), hole.nodes)


def test_holes(cad: Path) -> None:
    for order in (1, 2):
        (hole,) = jo.mesh_cad(cad / "plate.step", size=6e-3, order=order).holes()
        np.testing.assert_allclose(hole.point, (0.02, 0.01, 0.005), atol=1e-9)
        np.testing.assert_allclose(hole.axis, (0, 0, 1), atol=1e-9)
        assert hole.radius == pytest.approx(5e-3, rel=1e-9)
        assert hole.length == pytest.approx(10e-3, rel=1e-9)
        assert str(hole).startswith(f"{hole.name}: hole of 10 mm, 10 mm long, at (20, 10, 5) mm")
    # a pin is no hole
    assert jo.mesh_cad(cad / "pin.step", size=6e-3).holes() == ()


def test_link_arm() -> None:
    with pytest.warns(jo.JoustoWarning, match="would be folded between curved faces"):
        mesh = jo.mesh_cad(ARM, size=80e-3, per_circle=8)
    assert mesh.volume * 7850 == pytest.approx(109.9, abs=0.2)
    assert not [finding for finding in mesh.check() if finding.severity == "error"]
    holes = mesh.holes()
    assert [round(2e3 * hole.radius) for hole in holes] == [90, 80, 80, 60]
    x = sorted(round(1e3 * hole.point[0]) + 0 for hole in holes)
    assert x == [0, 400, 800, 1200]
    wide = mesh.holes(radius=(0.042, 1.0))
    assert len(wide) == 1
    # the pick by place finds the same nodes
    np.testing.assert_array_equal(mesh.cylinder((0, 0, 0), (0, 0, 1), 0.045), wide[0].nodes)
    low, high = mesh.bounds
    np.testing.assert_allclose(high - low, (1.39, 0.19, 0.15), atol=1e-6)


def test_finer_near_a_face(cad: Path) -> None:
    coarse = jo.mesh_cad(cad / "plate.step", size=6e-3)
    name = coarse.holes()[0].name
    fine = jo.mesh_cad(cad / "plate.step", size=6e-3, refine={name: 1.5e-3})
    assert len(fine.surfaces[name]) > 2 * len(coarse.surfaces[name])
    far = [np.sum(mesh.nodes[:, 0] < 4e-3) for mesh in (coarse, fine)]
    assert far[1] < 2.5 * far[0]
    with pytest.raises(InputError, match="refine: no face 'face77'; did you mean 'face7'"):
        jo.mesh_cad(cad / "plate.step", size=6e-3, refine={"face77": 1e-3})


def test_units(cad: Path, tmp_path: Path) -> None:
    assert jo.mesh_cad(cad / "plate.brep", size=6e-3, unit="mm").volume == pytest.approx(
        PLATE, rel=1e-3
    )
    with pytest.raises(InputError, match="contains no unit"):
        jo.mesh_cad(cad / "plate.brep", size=6e-3)
    # the same numbers in another unit, said by the file or over its head
    inches = 25.4**3 * PLATE
    over = jo.mesh_cad(cad / "plate.step", size=0.15, unit="in")
    assert over.volume == pytest.approx(inches, rel=1e-3)
    text = (cad / "plate.step").read_text()
    metres = tmp_path / "metres.step"
    metres.write_text(text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)"))
    assert metres.read_text() != text
    assert jo.mesh_cad(metres, size=6.0).volume == pytest.approx(1e9 * PLATE, rel=1e-3)


def test_a_file_in_inches(cad: Path, tmp_path: Path) -> None:
    text = (cad / "plate.step").read_text()
    mm = re.search(
        r"#(\d+) = \( LENGTH_UNIT\(\) NAMED_UNIT\(\*\) SI_UNIT\(\.MILLI\.,\.METRE\.\) \);", text
    )
    assert mm
    inch = (
        f"#{mm[1]} = ( CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9002) );\n"
        "#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9003);\n"
        "#9002 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
        "#9003 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"
    )
    path = tmp_path / "inches.step"
    path.write_text(text.replace(mm[0], inch))
    assert jo.mesh_cad(path, size=0.15).volume == pytest.approx(25.4**3 * PLATE, rel=1e-3)
    # a file that says inches by mistake
    assert jo.mesh_cad(path, size=6e-3, unit="mm").volume == pytest.approx(PLATE, rel=1e-3)


def test_unit_of_step_files() -> None:
    assert step_unit(b"( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.) );") == 1.0
    assert step_unit(b"( LENGTH_UNIT()\n NAMED_UNIT(*) SI_UNIT(.CENTI.,.METRE.) );") == 0.01
    assert step_unit(b"(CONVERSION_BASED_UNIT('INCH',#7) LENGTH_UNIT() NAMED_UNIT(#9));") == 0.0254
    assert step_unit(b"nothing") == 1e-3


def test_solids_that_touch_hang_together(cad: Path, tmp_path: Path) -> None:
    text = (cad / "cubes.step").read_text()
    names = iter(["assembly", "left cube", "right cube"])
    path = tmp_path / "named.step"
    product = r"= PRODUCT\('[^']*',\s*'[^']*'"
    path.write_text(re.sub(product, lambda _: f"= PRODUCT('1','{next(names)}'", text))
    mesh = jo.mesh_cad(path, size=5e-3)
    assert mesh.check() == ()
    assert set(mesh.element_sets) == {"solid1", "solid2", "left cube", "right cube"}
    np.testing.assert_array_equal(mesh.element_sets["left cube"], mesh.element_sets["solid1"])
    low, high = mesh.nodes[mesh.set("right cube")].min(axis=0), mesh.nodes.max(axis=0)
    np.testing.assert_allclose([low[0], high[0]], [0.01, 0.02], atol=1e-9)
    joint = np.intersect1d(mesh.set("solid1"), mesh.set("solid2"))
    np.testing.assert_allclose(mesh.nodes[joint, 0], 0.01, atol=1e-9)
    assert len(joint) > 8
    count = sum(len(mesh.element_sets[f"solid{i}"]) for i in (1, 2))
    assert count == len(mesh.element_ids)
    assert mesh.volume == pytest.approx(2e-6, rel=1e-9)


def test_wrong_cad_files_are_told(cad: Path, tmp_path: Path) -> None:
    def told(name: str, content: bytes, **options: Any) -> str:
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(InputError) as caught:
            jo.mesh_cad(path, **{"size": 5e-3, **options})
        assert name in str(caught.value)
        return str(caught.value)

    plate = (cad / "plate.step").read_bytes()
    assert "the file is truncated; export it again" in told("a.step", plate[: len(plate) // 2])
    assert "is empty" in told("b.step", b"")
    assert "an IGES file, which contains faces but no solid" in told("k.igs", IGES)
    assert "is neither a STEP nor a BREP file" in told("c.step", b"hello")
    assert "read it with jo.read_mesh" in told("d.msh", b"$MeshFormat")
    assert "sew the faces to a solid" in told("e.step", (cad / "face.step").read_bytes())
    damaged = plate.replace(b"CLOSED_SHELL", b"CLOSED_SHELF")
    assert "contains no solid" in told("f.step", damaged) or "damaged" in told("f.step", damaged)
    assert "size is 5 m and the part 0.0458 m across; sizes are in m, was 0.005" in told(
        "g.step", plate, size=5.0
    )
    assert "would lead to about" in told("h.step", plate, size=1e-5)
    text = told("i.step", plate, size=-1.0, order=3, per_circle=2)
    assert "size is -1 m" in text
    assert "order is 3" in text
    assert "per_circle is 2" in text
    with pytest.raises(InputError, match=r"no such file; did you mean 'a\.step'"):
        jo.mesh_cad(tmp_path / "aa.step", size=1e-3)


def test_gmsh_is_named_when_it_is_missing(cad: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(InputError, match=r"pip install gmsh"):
        jo.mesh_cad(cad / "plate.step", size=5e-3)


def test_an_open_session_stays_as_it_was(cad: Path) -> None:
    with opened(gmsh):
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.7)
        gmsh.model.add("mine")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        jo.mesh_cad(cad / "pin.step", size=8e-3)
        assert gmsh.model.getCurrent() == "mine"
        assert len(gmsh.model.getEntities(3)) == 1
        assert gmsh.option.getNumber("Mesh.MeshSizeMax") == 0.7


def test_folded_elements_get_straighter_edges() -> None:
    mesh = block("tetra10", (2, 1, 1), (2.0, 1.0, 1.0))
    nodes = mesh.nodes.copy()
    edge = mesh.solids[0].nodes[0, [0, 1, 4]]
    nodes[edge[2]] = 0.85 * nodes[edge[0]] + 0.15 * nodes[edge[1]]
    spoilt = jo.Mesh("spoilt", nodes, mesh.cells)
    assert len(spoilt.quality().negative)
    with pytest.warns(jo.JoustoWarning, match="would be folded between curved faces"):
        eased = _eased(spoilt, "spoilt.step")
    assert eased.check() == ()
    # no more than needed: the edge keeps a part of its curve, all others stay
    left = np.linalg.norm(eased.nodes - mesh.nodes, axis=1) / np.linalg.norm(nodes - mesh.nodes)
    assert 0.1 < left[edge[2]] < 0.8
    assert np.count_nonzero(left) == 1


def test_curved_elements_are_good_and_the_same_in_every_run() -> None:
    # edges along fillets fold a few elements of a coarse mesh or make them flat
    with pytest.warns(jo.JoustoWarning, match="would be folded"):
        mesh = jo.mesh_cad(ARM, size=70e-3)
    with pytest.warns(jo.JoustoWarning, match="would be folded"):
        again = jo.mesh_cad(ARM, size=70e-3)
    np.testing.assert_array_equal(mesh.nodes, again.nodes)
    straight = jo.mesh_cad(ARM, size=70e-3, curved=False)
    least = straight.quality().scaled_jacobian.min()
    assert mesh.quality().scaled_jacobian.min() > min(0.95 * least, 0.055)


def test_a_finer_size_that_is_coarser_is_refused(cad: Path) -> None:
    with pytest.raises(InputError, match="2 m at 'face5' is no smaller than the size, 0.006 m"):
        jo.mesh_cad(cad / "plate.step", size=6e-3, refine={"face5": 2.0})


def test_what_is_written_after_a_mesh_is_in_millimetres(cad: Path, tmp_path: Path) -> None:
    jo.mesh_cad(cad / "pin.step", size=5e-3)
    with opened(gmsh):
        gmsh.model.occ.addBox(0, 0, 0, 10, 20, 30)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "later.step"))
    mesh = jo.mesh_cad(tmp_path / "later.step", size=10e-3)
    np.testing.assert_allclose(np.ptp(mesh.nodes, axis=0), (0.01, 0.02, 0.03), rtol=1e-9)


@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="no such signal here")
def test_a_broken_pipe_after_a_mesh_is_an_error_and_not_the_end(cad: Path) -> None:
    code = f"""if True:
        import os, jousto as jo
        jo.mesh_cad({str(cad / "pin.step")!r}, size=5e-3)
        out, into = os.pipe()
        os.close(out)
        try:
            os.write(into, b"x")
        except BrokenPipeError:
            print("told")
    """
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert run.stdout == "told\n", (run.returncode, run.stderr)


def test_rigid_bodies_take_their_shape_from_cad_files(cad: Path) -> None:
    """Bore and pin are polygons of 24 sides or more, 1.2 % less than a circle at most."""
    plate = jo.RigidBody.from_mesh("plate", cad / "plate.step", density=1000.0)
    assert plate.mass == pytest.approx(1000.0 * PLATE, rel=0.01)
    assert plate.center == pytest.approx((0.02, 0.01, 0.005), abs=1e-5)
    pin = jo.RigidBody.from_mesh("pin", cad / "pin.brep", density=1000.0, unit="mm")
    assert pin.mass == pytest.approx(1000.0 * np.pi * 0.01**2 * 0.05, rel=0.012)
    assert np.linalg.norm(pin.outline[..., :2], axis=-1).max() == pytest.approx(0.01, rel=1e-6)
    with pytest.raises(InputError, match="no solid"):
        jo.RigidBody.from_mesh("face", cad / "face.step", density=1000.0)
