"""Files and numbers that ask for too much are refused at once."""

from __future__ import annotations

import gzip
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from jousto.base.units import UnitError, quantity
from jousto.measurement.gauges.units import split_label
from jousto.measurement.monitor.stream import _name_and_unit
from jousto.mechanism.signals.piecewise import read_columns
from jousto.mesh.readers.cdb import _announced
from jousto.mesh.readers.files import which
from jousto.parts.matrices.plain import read_plain
from jousto.reduction.damping import modal_damping
from jousto.schema.read import read_model

STEEL = jo.Material(2.1e11, 0.3, 7850.0)

# with work that grows by the square of the blanks this takes hours
BLANKS = r"""
import sys
from pathlib import Path
from jousto.base.errors import InputError
from jousto.mesh.readers.nastran import read_bulk
from jousto.mesh.readers.cad import step_unit
from jousto.mesh.readers.cdb import _announced
from jousto.mesh.formats import FORMATS
from jousto.measurement.gauges.units import split_label
from jousto.measurement.monitor.stream import _name_and_unit
from jousto.schema.entries.base import Orientation
from jousto.base.units import UnitError, quantity
from pydantic import TypeAdapter

n = 1_000_000
blanks, lines = n * " ", n * "\n"
try:
    quantity("1 m" + blanks + "m", "m")
except UnitError:
    pass
split_label("a" + blanks + "b")
_name_and_unit("a" + blanks + "b")
for form in FORMATS:
    form.begins((lines + "x").encode())
    form.begins((blanks + "x").encode())
step_unit(b"LENGTH_UNIT()" * 100_000)
folder = Path(sys.argv[1])
for name, text in (("a.cdb", lines + "x"), ("b.bdf", "INCLUDE" + blanks + "a'b'c\n")):
    (folder / name).write_text(text)
announced = lambda path: _announced(path, path.read_bytes())
for read, name in ((announced, "a.cdb"), (read_bulk, "b.bdf")):
    try:
        read(folder / name)
    except InputError as error:
        assert name in str(error)
try:
    TypeAdapter(Orientation).validate_python({"axis": [0, 0, 1], "angle": "1" + blanks + "x"})
except ValueError:
    pass
"""


def test_blanks_take_time_in_proportion(tmp_path: Path) -> None:
    paths = os.pathsep.join(entry for entry in sys.path if entry)
    done = subprocess.run(
        [sys.executable, "-c", BLANKS, str(tmp_path)],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("g1 [um/m]", "g1", "um/m"),
        ("g1  ( um/m )", "g1", "um/m"),
        ("a [b] [c]", "a [b]", "c"),
        ("a (b] (c", "a (b] (c", ""),
        ("plain", "plain", ""),
        ("[m]", "", "m"),
        ("a]", "a]", ""),
    ],
)
def test_names_and_units_of_columns(text: str, name: str, unit: str) -> None:
    assert _name_and_unit(text) == (name, unit)


def test_labels_and_quantities_keep_their_meaning() -> None:
    assert split_label("Gauge 1 {um/m} ") == ("Gauge 1", "um/m")
    assert split_label("[m]") == ("[m]", None)
    assert quantity("  12  mm \n", "m") == pytest.approx(0.012, rel=1e-15)
    with pytest.raises(UnitError):
        quantity("12 mm mm", "m")


def test_packed_files_are_bounded(tmp_path: Path) -> None:
    path = tmp_path / "bomb.inp.gz"
    with gzip.open(path, "wb") as file:
        for _ in range(300):
            file.write(bytes(1 << 20))
    with pytest.raises(InputError, match=r"bomb.inp.gz: unpacks to more than 100 times its size"):
        jo.read_mesh(path)


@pytest.mark.parametrize(
    ("header", "sentence"),
    [
        ("2000000000 2000000000 3", "announces 2000000000 x 2000000000 with 3 entries"),
        ("30 30 2000000000", "announces 2000000000 entries, but has"),
    ],
)
def test_a_matrix_that_claims_too_much(header: str, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "K.mtx"
    path.write_text(f"%%MatrixMarket matrix coordinate real symmetric\n%\n{header}\n1 1 1.0\n")
    with pytest.raises(InputError, match=f"K.mtx: {sentence}"):
        read_plain(path)
    path.write_text("%%MatrixMarket matrix array real general\n200000 200000\n1\n")
    with pytest.raises(InputError, match="announces 40000000000 entries, but has"):
        read_plain(path)
    path.write_text("%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 1\n2 2 3\n")
    np.testing.assert_array_equal(read_plain(path).toarray(), np.diag([1.0, 3.0]))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes are files of POSIX")
def test_pipes_and_devices_are_no_files(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    for read in (
        jo.read_mesh,
        jo.gauges.read_record,
        read_model,
        lambda path: read_columns(path, (0, 1), None),
    ):
        with pytest.raises(InputError, match="is a pipe, must be a file"):
            read(pipe)


@pytest.mark.parametrize("wrong", [10**9, 1e300, float("nan"), 0, True, "many"])
def test_elements_of_beams_are_bounded(wrong: object) -> None:
    section, number = jo.Circle(0.02), wrong
    for make in (
        lambda: jo.Part.beam(1.0, section, number, STEEL),  # type: ignore[arg-type]
        lambda: jo.Member((0, 0, 0), (1, 0, 0), section, STEEL, elements=number),  # type: ignore[arg-type]
        lambda: jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], section, STEEL, elements=number),  # type: ignore[arg-type]
    ):
        with pytest.raises(InputError, match="elements is .*must be (at most 100000|a whole)"):
            make()


def test_values_beyond_all_materials_and_damping() -> None:
    with pytest.warns(JoustoWarning, match="E = 1e.300 Pa is stiffer than diamond"):
        jo.Material(1e300, 0.3, 7850.0)
    with pytest.warns(JoustoWarning, match="stiffness is 1000 s: .* ratio 3.14e.03.*is in s"):
        jo.mechanism.BeamDamping(stiffness=1e3)
    with pytest.raises(InputError, match="ratio 1000 must be at most 100: 1 is critical"):
        modal_damping(1000.0, [1.0, 2.0])
    with pytest.warns(JoustoWarning, match="ratio 2 is above 1 .is it in per cent"):
        modal_damping([0.02, 2.0], [1.0, 2.0])


def test_files_that_begin_like_others_are_known(tmp_path: Path) -> None:
    for text, name in (
        ("\n\n   /PREP7\n", "an Ansys archive"),
        ("** c\n * NODE\n", "an Abaqus or CalculiX input file"),
    ):
        path = tmp_path / "x"
        path.write_text(text)
        assert which(path).name == name
    (tmp_path / "a.cdb").write_text("/PREP7\n  NBLOCK,6,SOLID,3,3\nEBLOCK,19,SOLID,2,2\n")
    path = tmp_path / "a.cdb"
    assert _announced(path, path.read_bytes()) == (3, 2)
