"""What is said when a part is made of a doubtful mesh."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from verification.boxes import block

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
SIZE = (0.4, 0.1, 0.06)


def mesh(nodes, *cells):
    return jo.Mesh("arm", nodes, [jo.mesh.Cells(kind, array) for kind, array in cells])


def test_a_sound_mesh_is_not_commented_on():
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        jo.Part.solid(mesh(grid.nodes, ("hexahedron20", grid.cells[0].nodes)), STEEL)
    assert not said


def test_a_file_in_millimetres_read_as_metres():
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    large = mesh(1e3 * grid.nodes, ("hexahedron20", grid.cells[0].nodes))
    with pytest.warns(jo.JoustoWarning, match="416.7 m across: if the file is in mm"):
        jo.Part.solid(replace(large, source="block.msh"), STEEL)
    jo.Part.solid(large, STEEL)  # made of arrays, its unit is known


def test_two_pieces_are_a_doubt_that_a_rigid_interface_removes():
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    nn, cells = len(grid.nodes), grid.cells[0].nodes
    both = np.vstack([grid.nodes, grid.nodes + [SIZE[0] + 0.01, 0.0, 0.0]])
    with pytest.warns(jo.JoustoWarning, match="2 pieces.* 10 mm apart"):
        part = jo.Part.solid(mesh(both, ("hexahedron20", np.vstack([cells, cells + nn]))), STEEL)
    with pytest.raises(jo.InputError, match="check that all elements are connected"):
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


def test_values_of_other_kinds_are_named():
    grid = block("hexahedron20", SIZE, (2, 1, 1))
    arm = mesh(grid.nodes, ("hexahedron20", grid.cells[0].nodes))
    lump = jo.parts.PointMass(0, 2.0)

    def refused(sentence, make):
        with pytest.raises(jo.InputError) as caught:
            make()
        assert str(caught.value).endswith(sentence)

    def solid(**options):
        return jo.Part.solid(arm, STEEL, **options)

    refused("weighed_mass is '3', must be a positive number in kg", lambda: solid(weighed_mass="3"))
    refused("point_masses[0] is 'x', must be a PointMass", lambda: solid(point_masses=("x",)))
    refused("point_masses is 3, must be a sequence of PointMass", lambda: solid(point_masses=3))
    refused("interfaces is None, must be a sequence of Interface", lambda: solid(interfaces=None))
    refused("interfaces is 'ab', must be a sequence of Interface", lambda: solid(interfaces="ab"))
    refused("interfaces[0] is 'x', must be an Interface", lambda: solid(interfaces=["x"]))
    refused("mass is '3', must be zero or positive in kg", lambda: jo.parts.PointMass(0, "3"))
    part = solid(point_masses=lump)
    assert part.mass == pytest.approx(solid().mass + 2.0)
    on = jo.mesh.InBox((-1, -1, -1), (1e-9, 1, 1))
    for value, shown in ((None, "None"), ("1 MPa", "'1 MPa'"), ([1.0], "[1.0]")):
        refused(
            f"pressure is {shown}, must be a finite number in Pa",
            lambda value=value: part.load(jo.parts.Pressure(on, value)),
        )
    refused(
        "pressure is nan Pa, must be a finite number",
        lambda: part.load(jo.parts.Pressure(on, float("nan"))),
    )
    tube = jo.Tube(0.05, 0.002)
    beam = jo.Part.beam(1.0, tube, 2, STEEL, point_masses=jo.parts.PointMass("end", 2.0))
    assert beam.mass == pytest.approx(jo.Part.beam(1.0, tube, 2, STEEL).mass + 2.0)
    refused(
        "must be a sequence of PointMass", lambda: jo.Part.beam(1.0, tube, 2, STEEL, point_masses=1)
    )


def test_point_masses_of_nothing_change_nothing():
    """A mass of 0 kg, or of less than the smallest number with all its digits, is none."""
    grid = block("hexahedron20", SIZE, (4, 2, 2))
    arm = mesh(grid.nodes, ("hexahedron20", grid.cells[0].nodes))
    ends = {"tip": np.flatnonzero(grid.nodes[:, 0] == grid.nodes[:, 0].max()).tolist()}
    arm = replace(arm, node_sets=ends)
    plain = jo.reduce(jo.Part.solid(arm, STEEL), jo.FreeFree(modes=3))
    for none in (
        jo.parts.PointMass(0, 0.0),
        jo.parts.PointMass("tip", 0.0, offset=(0.1, 0, 0)),
        jo.parts.PointMass(0, 1e-320),
    ):
        part = jo.Part.solid(arm, STEEL, point_masses=[none])
        found = jo.reduce(part, jo.FreeFree(modes=3))
        np.testing.assert_array_equal(found.frequencies, plain.frequencies)
        assert found.invariants.mass == plain.invariants.mass
    rotor = jo.parts.PointMass("tip", 0.0, inertia=(1e-3, 1e-3, 1e-3))
    with pytest.raises(
        jo.InputError, match="'tip': has an inertia, but a mass of 0 kg; give a mass"
    ):
        jo.Part.solid(arm, STEEL, point_masses=[rotor])
