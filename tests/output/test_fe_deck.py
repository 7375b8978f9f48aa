"""Decks of other programs with the loads on a body: mesh, supports, load steps, errors."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from verification.boxes import block
from verification.solids import mesh, solid

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
KINDS = ("tetra", "tetra10", "wedge15", "hexahedron", "hexahedron20")
G = (0.0, 0.0, -9.81)

pytestmark = pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")


def part(kind: str = "hexahedron", interface: str = "rigid") -> jo.Part:
    """Return a block with numbers of its own and an interface at x = 0."""
    grid = mesh(block(kind, (0.4, 0.1, 0.06), (3, 1, 1)))
    numbered = replace(grid, node_ids=np.arange(len(grid.nodes)) * 2 + 11)
    made = jo.Part.solid(numbered, STEEL, name="block")
    root = np.flatnonzero(made.nodes[:, 0] < 1e-9)
    return made.with_interfaces(jo.Interface("root", root, kind=interface))


def hung(one: jo.Part, *more: object) -> jo.Solution:
    """Return a run of the part that hangs on its interface, and falls."""
    body = jo.FlexibleBody("arm", jo.reduce(one, jo.CraigBampton(("root",), modes=3)))
    pin = jo.Revolute("pin", jo.ground.at((0, 0.05, 0.03)), body["root"], axis=(0, 1, 0))
    things = [thing(body) if callable(thing) else thing for thing in more]
    model = jo.compile(jo.Mechanism(body, pin, jo.Gravity(G), *things))
    return jo.simulate(model, 1e-3, output_step=5e-4)


def forces_in(path: Path) -> list[dict[int, np.ndarray]]:
    """Return the nodal forces of each step of a deck for CalculiX or Nastran."""
    steps: list[dict[int, np.ndarray]] = []
    lines = path.read_text(encoding="utf-8").splitlines()
    if path.suffix == ".inp":
        inside = False
        for line in lines:
            if line == "*STEP":
                steps.append({})
            inside = line.startswith("*CLOAD") or (inside and not line.startswith("*"))
            if inside and not line.startswith("*"):
                node, axis, value = line.split(",")
                steps[-1].setdefault(int(node), np.zeros(3))[int(axis) - 1] = float(value)
        return steps
    for one, two in zip(lines, lines[1:], strict=False):
        if one.startswith("FORCE*"):
            step, node, _, factor = (one[8 + 16 * i : 24 + 16 * i] for i in range(4))
            while len(steps) < int(step):
                steps.append({})
            vector = np.array([float(two[8 + 16 * i : 24 + 16 * i]) for i in range(3)])
            steps[-1][int(node)] = float(factor) * vector
    return steps


@pytest.mark.parametrize("suffix", [".inp", ".bdf"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_deck_has_the_mesh_and_balanced_forces(kind: str, suffix: str, tmp_path: Path) -> None:
    one = part(kind)
    loads = jo.recovery.loads_of(hung(one), "arm")
    path = jo.write(loads, tmp_path / f"block{suffix}", one, times=[0.0, 1e-3])
    again = jo.read_mesh(path, unit="m")
    ids = np.asarray(one.solids.node_ids)
    place = {int(k): x for k, x in zip(again.node_ids, again.nodes, strict=True)}
    assert np.allclose([place[int(k)] for k in ids], one.nodes, atol=1e-9)
    (cells,) = again.solids
    assert cells.kind == kind
    # Abaqus has no wedge that is integrated in full
    assert cells.formulation == ("reduced" if (kind, suffix) == ("wedge15", ".inp") else "full")
    assert np.array_equal(again.node_ids[cells.nodes], ids[one.solids.groups[0].nodes])
    steps = forces_in(path)
    assert len(steps) == 2
    for step in steps:
        f = np.array(list(step.values()))
        x = np.array([place[k] for k in step])
        size = np.abs(f).sum()
        assert np.abs(f.sum(axis=0)).max() < 1e-7 * size
        assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-7 * size
    # the interface transmits the force of the pin, besides the inertia of its nodes
    text = path.read_text(encoding="utf-8")
    assert ("RBE2" if suffix == ".bdf" else "*RIGID BODY") in text


def test_dialects_differ_in_the_rigid_interface_and_outputs(tmp_path: Path) -> None:
    loads = jo.recovery.loads_of(hung(one := part()), "arm")
    for program, words in (
        ("calculix", ("ROT NODE=", "*EL FILE")),
        ("abaqus", ("PIN NSET=", "*OUTPUT, FIELD")),
    ):
        path = jo.write(loads, tmp_path / f"{program}.inp", one, times=[0.0], program=program)
        assert all(word in path.read_text(encoding="utf-8") for word in words)
    averaged = part(interface="average")
    path = jo.write(jo.recovery.loads_of(hung(averaged), "arm"), tmp_path / "a.inp", averaged)
    text = path.read_text(encoding="utf-8")
    assert "*RIGID BODY" not in text and text.count("*STEP") == 3


def test_wrong_requests_are_named(tmp_path: Path) -> None:
    one = part()
    loads = jo.recovery.loads_of(hung(one), "arm")
    with pytest.raises(jo.InputError, match=r"program: is 'nastran'; \.inp files are for calculix"):
        jo.write(loads, tmp_path / "a.inp", one, program="nastran")
    with pytest.raises(jo.InputError, match=r"no instant at 0\.0007 s; the nearest is 0\.0005 s"):
        jo.write(loads, tmp_path / "a.inp", one, times=[0.0007])
    with pytest.raises(jo.InputError, match="not reduced from part 'block'"):
        jo.write(loads, tmp_path / "a.inp", replace(one, nodes=one.nodes + 0.1))
    beam = jo.Part.beam(1.0, jo.Circle(0.01), 2, STEEL)
    with pytest.raises(jo.InputError, match="does not consist of solids"):
        jo.write(loads, tmp_path / "a.inp", beam)
    assert not list(tmp_path.iterdir())


def test_loads_that_have_no_node_are_named_together(tmp_path: Path) -> None:
    def tug(body: jo.FlexibleBody) -> jo.Force:
        return jo.Force("tug", body.at((0.37, 0.05, 0.03)), (1.0, 0, 0))

    def wind(body: jo.FlexibleBody) -> jo.mechanism.ModalLoad:
        return jo.mechanism.ModalLoad("wind", body, np.ones((len(body.reduced.nodes), 3)))

    one = part()
    loads = jo.recovery.loads_of(hung(one, tug, wind), "arm")
    with pytest.raises(jo.InputError) as caught:
        jo.write(loads, tmp_path / "a.inp", one)
    said = str(caught.value)
    assert (
        "force 'tug' acts at" in said and "distributed load 'wind' acts on the whole body" in said
    )


def test_a_part_of_another_mass_does_not_balance_the_loads(tmp_path: Path) -> None:
    """A rigid body of 1 kg on a part of 18.8 kg: the pin's force is not that of the part."""
    one = part()
    body = jo.RigidBody("arm", 1.0, (0.01, 0.01, 0.01), center=(0.2, 0.05, 0.03))
    at = (0.0, 0.05, 0.03)
    pin = jo.Revolute("pin", jo.ground.at(at), body.at(at), axis=(0, 1, 0))
    run = jo.simulate(jo.compile(jo.Mechanism(body, pin, jo.Gravity(G))), 1e-3, output_step=5e-4)
    with pytest.raises(jo.InputError, match="not in balance with the inertia of part 'block'"):
        jo.write(jo.recovery.loads_of(run, "arm"), tmp_path / "a.inp", one)


def test_a_material_with_directions_is_refused(tmp_path: Path) -> None:
    wood = jo.materials.Orthotropic(
        E1=1e10, E2=1e9, E3=1e9, nu12=0.3, nu13=0.3, nu23=0.3, G12=1e9, G13=1e9, G23=4e8, rho=600.0
    )
    one = solid(block("hexahedron", (0.4, 0.1, 0.06), (3, 1, 1)), wood)
    root = np.flatnonzero(one.nodes[:, 0] < 1e-9)
    one = one.with_interfaces(jo.Interface("root", root))
    loads = jo.recovery.loads_of(hung(one), "arm")
    with pytest.raises(jo.InputError, match="Orthotropic is not isotropic"):
        jo.write(loads, tmp_path / "a.inp", one)


def test_a_deck_has_at_least_one_step(tmp_path: Path) -> None:
    one = part()
    loads = jo.recovery.loads_of(hung(one), "arm")
    with pytest.raises(jo.InputError, match="times is empty: name at least one instant"):
        jo.write(loads, tmp_path / "a.inp", one, times=[])
    assert not (tmp_path / "a.inp").exists()
