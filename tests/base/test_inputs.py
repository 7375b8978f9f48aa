"""What is read: pointers of Git LFS in the place of files are told by every reader."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.parameters.samples import read_samples
from jousto.measurement.gauges.read import read_record
from jousto.measurement.monitor.stream import Stream
from jousto.mechanism.bodies.shapes import read_surface
from jousto.mesh.cells import Cells
from jousto.mesh.formats import CAD, MESHES
from jousto.parts.matrices.read import read_matrices
from jousto.robots.readers.xml import parse_file
from jousto.schema.file.files import read_points
from jousto.schema.read import read_model
from jousto.viewer.viewable import read

POINTER = """version https://git-lfs.github.com/spec/v1
oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393
size 132735
"""

READERS: list[tuple[str, Callable[[Path], Any]]] = [
    *((f"mesh{suffix}", jo.read_mesh) for suffix in MESHES),
    *((f"solid{suffix}", lambda path: jo.mesh_cad(path, size=1e-2, unit="mm")) for suffix in CAD),
    *(
        (f"shape{suffix}", lambda path: read_surface("s", path, "mm"))
        for suffix in (".stl", ".obj")
    ),
    *((f"matrices{s}", read_matrices) for s in (".mtx", ".sti", ".op4", ".pch", ".npz", ".full")),
    *((f"record{s}", read_record) for s in (".csv", ".txt", ".uff", ".h5", ".lvm")),
    *((f"seen{s}", read) for s in (".h5", ".yaml", ".msh", ".step")),
    ("part.h5", jo.ReducedPart.load),
    ("part.sid", jo.ReducedPart.load),
    ("run.h5", jo.load),
    ("model.yaml", read_model),
    ("robot.urdf", parse_file),
    ("points.csv", read_points),
    ("table.csv", jo.Table.from_csv),
    ("samples.csv", lambda path: read_samples(path, [Parameter("a", 0.5, (0.0, 1.0))])),
]


@pytest.mark.parametrize(("name", "reader"), READERS, ids=[name for name, _ in READERS])
def test_pointers_of_git_lfs(name: str, reader: Callable[[Path], Any], tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(POINTER)
    with pytest.raises(InputError, match=r"is a pointer of Git LFS, .* git lfs pull"):
        reader(path)


def test_included_files(tmp_path: Path) -> None:
    (tmp_path / "inner.bdf").write_text(POINTER)
    (tmp_path / "outer.bdf").write_text("BEGIN BULK\nINCLUDE 'inner.bdf'\nENDDATA\n")
    (tmp_path / "outer.inp").write_text("*NODE\n1,0.,0.,0.\n*INCLUDE, INPUT=inner.bdf\n")
    for name in ("outer.bdf", "outer.inp"):
        with pytest.raises(InputError, match=r"inner.bdf: is a pointer of Git LFS"):
            jo.read_mesh(tmp_path / name)


def test_pointers_may_be_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "mesh.vtu"
    path.write_text(POINTER)
    nodes = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    jo.write(jo.Mesh("m", nodes, Cells("tetra", [[0, 1, 2, 3]])), path)
    assert jo.read_mesh(path).volume == pytest.approx(1 / 6)


TEXTS: list[tuple[str, Callable[[Path], Any]]] = [
    ("record.csv", read_record),
    ("model.yaml", read_model),
    ("table.csv", jo.Table.from_csv),
    ("samples.csv", lambda path: read_samples(path, [Parameter("a", 0.5, (0.0, 1.0))])),
    ("matrices.pch", read_matrices),
]


@pytest.mark.parametrize(("name", "reader"), TEXTS, ids=[name for name, _ in TEXTS])
def test_lines_without_end(name: str, reader: Callable[[Path], Any], tmp_path: Path) -> None:
    path = tmp_path / name
    with path.open("wb") as file:  # sparse: takes no place on the disk
        file.truncate(1 << 40)
    with pytest.raises(InputError, match=r"a line of more than 64 MB, which is not text"):
        reader(path)


def test_streams_without_end() -> None:
    class Zeros(io.RawIOBase):
        def read(self, size: int = -1) -> bytes:
            return bytes(size)

    for head in (b"", b"time [s],g1 [um/m]\n0,1\n"):
        source = Zeros()
        first = [head] if head else []
        source.read1 = lambda size, first=first: first.pop() if first else bytes(size)  # type: ignore[attr-defined]
        with pytest.raises(InputError, match=r"zeros: a line of more than 64 MB"):
            for _ in Stream(source, "zeros").blocks():  # type: ignore[arg-type]
                pass


@pytest.mark.parametrize(
    "face", ["f 1 2 100000000000000000000", "f 1 2 9", "f 1 2 -9", "f 1 2 1e20", "f 1 2"]
)
def test_corners_that_are_not_there(face: str, tmp_path: Path) -> None:
    path = tmp_path / "shape.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}\n")
    with pytest.raises(InputError, match=r"shape.obj'? "):
        read_surface("body 's'", path, "mm")
