"""What is said when a part is made of a doubtful mesh."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo
from verification.boxes import block

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
SIZE = (0.4, 0.1, 0.06)


def mesh(nodes, *cells):
    return jo.Mesh("arm", nodes, [jo.Cells(kind, array) for kind, array in cells])


def test_a_sound_mesh_is_not_commented_on():
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.Part.solid(mesh(grid.nodes, ("hexahedron20", grid.cells[0].nodes)), STEEL)


def test_a_file_in_millimetres_read_as_metres():
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    with pytest.warns(jo.JoustoWarning, match="416.7 m across: is the file in mm"):
        jo.Part.solid(mesh(1e3 * grid.nodes, ("hexahedron20", grid.cells[0].nodes)), STEEL)


def test_two_pieces_are_a_doubt_that_a_rigid_interface_removes():
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    nn, cells = len(grid.nodes), grid.cells[0].nodes
    both = np.vstack([grid.nodes, grid.nodes + [SIZE[0] + 0.01, 0.0, 0.0]])
    with pytest.warns(jo.JoustoWarning, match="2 pieces.* 10 mm apart"):
        part = jo.Part.solid(mesh(both, ("hexahedron20", np.vstack([cells, cells + nn]))), STEEL)
    with pytest.raises(jo.InputError, match="are all elements connected"):
        jo.reduce(part, jo.FreeFree(modes=3))
    gap = np.flatnonzero(np.abs(both[:, 0] - SIZE[0] - 0.005) < 0.006)
    weld = part.with_interfaces(jo.Interface("weld", gap))
    joined = jo.reduce(weld, jo.CraigBampton(modes=4))
    assert joined.frequencies[0] < 800.0


def test_linear_beside_quadratic_elements():
    fine = block("hexahedron20", SIZE, (4, 2, 2))
    coarse = block("hexahedron", SIZE, (4, 2, 2))
    # the corners are the first nodes of the quadratic grid, in the same order
    cells = fine.cells[0].nodes
    moved = coarse.cells[0].nodes
    with pytest.raises(jo.InputError, match="linear and quadratic elements share faces"):
        jo.Part.solid(
            mesh(fine.nodes, ("hexahedron20", cells[:8]), ("hexahedron", moved[8:])), STEEL
        )


def test_elements_exported_twice():
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    cells = grid.cells[0].nodes
    with pytest.raises(jo.InputError, match="overlap"):
        jo.Part.solid(mesh(grid.nodes, ("hexahedron20", np.vstack([cells, cells[:2]]))), STEEL)
