"""Tables of the types of elements of other programs, and warnings where one is replaced."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import JoustoWarning
from jousto.mesh.cells import KINDS
from jousto.mesh.readers import element_types as types
from jousto.mesh.reference import FORMULATIONS

SAME = {
    "C3D4": ("tetra", "full"),
    "C3D10": ("tetra10", "full"),
    "C3D6": ("wedge", "reduced"),
    "C3D15": ("wedge15", "reduced"),
    "C3D8": ("hexahedron", "full"),
    "C3D8H": ("hexahedron", "bbar"),
    "C3D8I": ("hexahedron", "incompatible"),
    "C3D8R": ("hexahedron", "reduced"),
    "C3D8RT": ("hexahedron", "reduced"),
    "C3D20": ("hexahedron20", "full"),
    "C3D20R": ("hexahedron20", "reduced"),
    "C3D20RP": ("hexahedron20", "reduced"),
}


@pytest.mark.parametrize("name", types.ABAQUS)
def test_every_type_of_abaqus_is_an_element_of_ours(tmp_path: Path, name: str) -> None:
    found = types.ABAQUS[name]
    # the digits of solids are their nodes
    assert found.formulation in FORMULATIONS.get(found.kind, ("full",))
    if found.solid:
        digits = "".join(c for c in name.removeprefix("D").removeprefix("C3D") if c.isdigit())
        assert KINDS[found.kind] == int(digits)
    # a brick and one element of the type on its nodes: read, with a warning if it is not the same
    k = KINDS[found.kind]
    x = np.random.default_rng(1).uniform(0, 1, (max(k, 8), 3))
    brick = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    x[:8] = brick
    nodes = "".join(f"{i}, {a!r}, {b!r}, {c!r}\n" for i, (a, b, c) in enumerate(x.tolist(), 1))
    row = ",\n".join(", ".join(map(str, part)) for part in np.array_split(np.arange(1, k + 1), 2))
    text = (
        f"*NODE\n{nodes}*ELEMENT, TYPE=C3D8\n100, 1, 2, 3, 4, 5, 6, 7, 8\n"
        f"*ELEMENT, TYPE={name}\n1, {row}\n"
    )
    path = tmp_path / "deck.inp"
    path.write_text(text)
    if found.replaced and "pyramid" not in found.kind:
        with pytest.warns(JoustoWarning, match=rf"deck.inp: 1 {name}( read as|: a)") as told:
            mesh = jo.read_mesh(path)
        assert len(told) == 1
    else:
        mesh = jo.read_mesh(path)
    ways = [(block.kind, block.formulation) for block in mesh.cells]
    assert (found.kind, found.formulation) in ways


@pytest.mark.parametrize(("name", "way"), SAME.items())
def test_solids_that_are_the_same_here(name: str, way: tuple[str, str]) -> None:
    found = types.abaqus(name)
    assert found is not None
    assert (found.kind, found.formulation, found.replaced) == (*way, "")


def test_unknown_letters_are_named_and_unknown_families_are_not_read() -> None:
    found = types.abaqus("C3D8XY")
    assert found is not None and (found.kind, found.replaced) == (
        "hexahedron",
        "its letters XY are not known",
    )
    for name in ("C3D27", "COH3D8", "AC3D8", "MASS", "SPRINGA", "C3D80", ""):
        assert types.abaqus(name) is None


@pytest.mark.parametrize(("card", "nodes"), types.NASTRAN)
def test_every_card_of_nastran_is_an_element_of_ours(card: str, nodes: int) -> None:
    found = types.NASTRAN[card, nodes]
    assert KINDS[found.kind] == nodes
    assert found.formulation in FORMULATIONS.get(found.kind, ("full",))


@pytest.mark.parametrize(
    ("card", "nodes", "fields", "way"),
    [
        ("CHEXA", 8, ("", ""), ("hexahedron", "incompatible")),
        ("CHEXA", 8, ("BUBBLE", "REDUCED"), ("hexahedron", "incompatible")),
        ("CHEXA", 8, ("TWO", "FULL"), ("hexahedron", "full")),
        ("CHEXA", 8, ("2", "1"), ("hexahedron", "full")),
        ("CHEXA", 20, ("", ""), ("hexahedron20", "full")),
        ("CHEXA", 20, ("TWO", ""), ("hexahedron20", "reduced")),
        ("CPENTA", 6, ("TWO", "FULL"), ("wedge", "full")),
    ],
)
def test_integration_of_psolid(card: str, nodes: int, fields: tuple[str, str], way) -> None:
    found = types.nastran_solid(card, nodes, *fields)
    assert (found.kind, found.formulation) == way


@pytest.mark.parametrize(
    ("code", "kind", "options", "how", "same"),
    [
        (185, "hexahedron", {}, "bbar", True),
        (185, "hexahedron", {2: 1}, "reduced", True),
        (185, "hexahedron", {2: 2}, "incompatible", False),
        (185, "hexahedron", {2: 3}, "incompatible", True),
        (45, "hexahedron", {}, "incompatible", True),
        (45, "hexahedron", {1: 1}, "full", True),
        (186, "hexahedron20", {}, "reduced", True),
        (186, "hexahedron20", {2: 1}, "full", False),
        (95, "hexahedron20", {}, "full", False),
        (95, "hexahedron20", {11: 1}, "reduced", True),
        (186, "wedge15", {}, "reduced", True),
        (187, "tetra10", {}, "full", True),
        (285, "tetra", {}, "full", False),
        (186, "pyramid13", {}, "full", False),
    ],
)
def test_types_of_ansys(code: int, kind: str, options: dict[int, int], how: str, same) -> None:
    found = types.ansys_solid(code, kind, options.items())
    assert (found.kind, found.formulation, not found.replaced) == (kind, how, same)


def test_shells_beside_solids_are_named(tmp_path: Path) -> None:
    nodes = "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n"
    text = f"*NODE\n{nodes}*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n*ELEMENT, TYPE=S3\n2,1,2,3\n3,1,2,4\n"
    path = tmp_path / "deck.inp"
    path.write_text(text + "*ELEMENT, TYPE=CPS3\n4,1,3,4\n*ELEMENT, TYPE=T3D2\n5,1,2\n")
    with pytest.warns(JoustoWarning) as told:
        jo.read_mesh(path)
    assert [str(item.message) for item in told] == [
        "deck.inp: 2 S3: a shell has no stiffness and mass beside solids here; kept for names and"
        " drawing",
        "deck.inp: 1 T3D2: a truss has no stiffness and mass beside solids here; kept for names"
        " and drawing",
    ]


BULK = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
GRID,5,,0.,0.,1.
GRID,6,,1.,0.,1.
GRID,7,,1.,1.,1.
GRID,8,,0.,1.,1.
CHEXA,1,1,1,2,3,4,5,6,,,7,8
CQUAD4,2,2,1,2,3,4
CBAR,3,3,1,2,0.,0.,1.
PSOLID,1,1{integration}
{shell}
PBAR,3,1,1.
ENDDATA
"""


@pytest.mark.parametrize(
    ("integration", "shell", "how", "told"),
    [
        (
            "",
            "PSHELL,2,1,.1",
            "incompatible",
            ["1 CHEXA read as", "1 CQUAD4: a shell", "1 CBAR: a"],
        ),
        # Gmsh names surfaces by shells without a property
        ("", "$", "incompatible", ["1 CHEXA read as", "1 CBAR: a beam"]),
        (",,TWO,,FULL", "$", "full", ["1 CBAR: a beam"]),
    ],
)
def test_bulk_data_names_what_is_replaced(
    tmp_path: Path, integration: str, shell: str, how: str, told: list[str]
) -> None:
    (tmp_path / "a.bdf").write_text(BULK.format(integration=integration, shell=shell))
    with pytest.warns(JoustoWarning) as caught:
        mesh = jo.read_mesh(tmp_path / "a.bdf")
    assert mesh.solids[0].formulation == how
    found = [str(item.message) for item in caught]
    assert len(found) == len(told)
    assert all(f"a.bdf: {start}" in said for start, said in zip(told, found, strict=True))


@pytest.mark.parametrize(("code", "shape"), [(185, 8), (45, 8), (186, 20), (95, 20), (187, 10)])
def test_every_solid_of_ansys_is_an_element_of_ours(code: int, shape: int) -> None:
    kind = {8: "hexahedron", 20: "hexahedron20", 10: "tetra10"}[shape]
    for option in range(4):
        found = types.ansys(code, kind, {2: option})
        assert found.formulation in FORMULATIONS[kind]
    for code in types.ANSYS_LINES:
        assert types.ansys(code, "line", {}).replaced in (types.BEAM, types.TRUSS)
    for code in types.ANSYS_SHELLS:
        assert types.ansys(code, "quad", {}).replaced == types.SHELL
