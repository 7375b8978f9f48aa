"""What a file says of a part: the part, how it is reduced, and its modes."""

from __future__ import annotations

import pytest

from jousto.base.errors import InputError
from jousto.reduction.methods import CraigBampton
from jousto.schema.read import read_part_file

PART = """\
type: beam
length: 2 m
section: {type: rectangle, width: 8 mm, height: 40 mm}
elements: 8
material: {E: 210 GPa, nu: 0.3, rho: 7850}
reduce: {type: craig-bampton, interfaces: [start], modes: 4}
"""


def test_a_file_gives_the_part_its_method_and_its_modes(tmp_path):
    path = tmp_path / "rod.yml"
    path.write_text(PART)
    file = read_part_file(path)
    assert (file.name, file.reduced.n, file.part.mass) == ("rod", 4, pytest.approx(5.024))
    assert file.method == CraigBampton(("start",), modes=4)
    assert read_part_file(path, reduce=False).reduced is None


def test_a_part_reduced_before_has_no_mesh(tmp_path):
    path = tmp_path / "rod.yml"
    path.write_text(PART)
    read_part_file(path).reduced.save(tmp_path / "rod.h5")
    path.write_text("file: rod.h5\n")
    file = read_part_file(path)
    assert (file.part, file.method, file.reduced.n) == (None, None, 4)


def test_modes_chosen_twice(tmp_path):
    path = tmp_path / "rod.yml"
    path.write_text(PART + "keep: [0]\nin_plane: xy\n")
    for reduce in (True, False):
        with pytest.raises(InputError, match="rod.yml:7: keep: give either keep or in_plane"):
            read_part_file(path, reduce=reduce)
