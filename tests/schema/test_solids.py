"""Solid parts in the model file: meshes, materials, picks, interfaces, and mistakes in them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.output.scenes.surface import is_surface
from jousto.schema.file.document import parse_document
from jousto.schema.read import build_model, parse_model, read_part, read_part_file
from schema.plates import plate

BODY = """
bodies: [{name: arm, part: arm}]
gravity: [0, 0, -9.81]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with plate.vtu (m) and plate_mm.inp (mm): 0.4 x 0.1 x 0.02 m, a hole of 50 mm."""
    here = tmp_path_factory.mktemp("plates")
    jo.write(plate(), here / "plate.vtu")
    jo.write(plate(), here / "plate_mm.inp", unit="mm")
    return here


def part_of(folder: Path, text: str, name: str = "arm") -> jo.ReducedPart:
    """Return the reduced part of a file with one part."""
    path = folder / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    return read_part(path)


def problems(folder: Path, text: str) -> list[str]:
    """Return what is wrong with a file with one part, without its name."""
    path = folder / "bad.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(jo.InputError) as caught:
        read_part(path)
    return [str(problem).removeprefix("bad.yaml:") for problem in caught.value.problems]


PLATE = """
type: solid
mesh: plate.vtu
material: {E: 210 GPa, nu: 0.3, rho: 7850}
interfaces:
  - {name: root, nodes: left, kind: rigid}
  - {name: bore, nodes: {hole: {near: [0.3, 0.05, 0]}}, kind: average}
reduce: {type: craig-bampton, modes: 4}
"""


def test_a_plate_from_a_file_is_that_of_python(folder: Path) -> None:
    reduced = part_of(folder, PLATE)
    mesh = jo.read_mesh(folder / "plate.vtu")
    hole = mesh.holes()[0]
    part = jo.Part.solid(
        mesh,
        jo.Material(210e9, 0.3, 7850.0),
        interfaces=(
            jo.Interface("root", "left"),
            jo.Interface("bore", hole.nodes, kind="average"),
        ),
    )
    same = jo.reduce(part, jo.CraigBampton(modes=4))
    assert np.allclose(reduced.frequencies, same.frequencies, rtol=1e-12)
    assert reduced.interfaces == ("root", "bore")
    assert np.allclose(reduced.nodes[reduced.node("bore")], [0.3, 0.05, 0.01], atol=1e-4)


def test_units_sets_and_materials_by_name(folder: Path) -> None:
    text = PLATE.replace("mesh: plate.vtu", "mesh: {file: plate_mm.inp, unit: mm}")
    text = text.replace("material: {E: 210 GPa, nu: 0.3, rho: 7850}", "materials: {all: S355}")
    steel = jo.material("S355")
    reduced = part_of(folder, text)
    mesh = jo.read_mesh(folder / "plate.vtu")
    assert reduced.invariants.mass == pytest.approx(steel.rho * mesh.volume, rel=1e-9)


def test_orthotropic_material_with_turned_axes(folder: Path) -> None:
    ply = "{E1: 40 GPa, E2: 10 GPa, E3: 10 GPa, nu12: 0.3, nu13: 0.3, nu23: 0.4, G12: 4 GPa, "
    ply += "G13: 4 GPa, G23: 3 GPa, rho: 1900"
    plain = PLATE.replace("{E: 210 GPa, nu: 0.3, rho: 7850}", ply + "}")
    turned = PLATE.replace(
        "{E: 210 GPa, nu: 0.3, rho: 7850}", ply + ", axes: {axis: [0, 0, 1], angle_deg: 90}}"
    )
    along, across = part_of(folder, plain), part_of(folder, turned)
    # fibres across: the plate is softer in bending
    assert across.frequencies[0] < 0.8 * along.frequencies[0]


TOE = "welds: [{name: toe, at: [0.1, 20 mm, 20 mm], away: [1, 0, 0], thickness: 20 mm}]\n"


@pytest.mark.parametrize("stress", ["surface", "skin", "left"])
def test_toes_of_welds_are_stress_sites(folder: Path, stress: str) -> None:
    before = part_of(folder, PLATE + f"stress: {stress}\n").stress
    after = part_of(folder, PLATE + f"stress: {stress}\n{TOE}").stress
    assert len(before.labels) > 0
    assert after.labels == ("toe", *before.labels)
    size = np.abs(before.modes).max()
    assert np.allclose(after.modes[1:], before.modes, rtol=0.0, atol=1e-9 * size)


def test_toes_of_welds_may_be_the_only_stress_sites(folder: Path) -> None:
    assert part_of(folder, PLATE + "stress: none\n").stress is None
    toe = part_of(folder, PLATE + f"stress: none\n{TOE}").stress
    assert toe.labels == ("toe",)
    assert np.allclose(toe.axes[0], np.eye(3))


def test_stress_is_kept_where_it_is_asked_for(folder: Path) -> None:
    whole = part_of(folder, PLATE)
    surface = np.unique(whole.elements)
    assert len(whole.stress.labels) == len(surface)
    few = part_of(folder, PLATE + "stress: left\n")
    assert np.allclose(few.stress.positions[:, 0], 0.0)
    assert 0 < len(few.stress.labels) < len(surface)
    near = part_of(folder, PLATE + "stress: {sphere: {point: [0.1, 0, 0], radius: 30 mm}}\n")
    away = np.linalg.norm(near.stress.positions - [0.1, 0, 0], axis=1)
    assert away.max() <= 0.030 + 1e-9
    assert part_of(folder, PLATE + "stress: none\n").stress is None
    skin = part_of(folder, PLATE + "stress: skin\n").stress
    assert set(skin.labels) <= set(whole.stress.labels)
    on_top = np.flatnonzero(np.ptp(skin.positions, axis=0)[2] - skin.positions[:, 2] < 1e-9)
    inner = [i for i in on_top if 0.05 < skin.positions[i, 0] < 0.35]
    inner = [i for i in inner if 0.01 < skin.positions[i, 1] < 0.09]
    # no stress across a free face: s33, s23 and s13 of its inner nodes
    assert inner
    assert np.abs(skin.modes[inner][:, [2, 4, 5]]).max() < 1e-9 * np.abs(skin.modes).max()


def test_point_masses_and_weighed_mass(folder: Path) -> None:
    more = "point_masses: [{node: tip, mass: 0.5 kg}]\nsets: {tip: {box: {low: [0.4, 0, 0], "
    more += "high: [0.4, 0.1, 0.02]}}}\n"
    light, heavy = part_of(folder, PLATE), part_of(folder, PLATE + more)
    assert heavy.invariants.mass == pytest.approx(light.invariants.mass + 0.5)
    mass = 1.05 * light.invariants.mass
    weighed = part_of(folder, PLATE + f"weighed_mass: {mass!r}\n")
    assert weighed.invariants.mass == pytest.approx(mass)


def test_residuals_make_a_load_exact(folder: Path) -> None:
    sets = "sets: {edge: {box: {low: [0.2, 0.1, 0], high: [0.3, 0.1, 0.02]}}}\n"
    more = "modes: 0, residuals: [{force: [0, 0, 1], nodes: edge}]"
    reduced = part_of(folder, sets + PLATE.replace("modes: 4", more))
    without = part_of(folder, sets + PLATE.replace("modes: 4", "modes: 0"))
    assert reduced.n == without.n + 1
    top = "sets: {top: {plane: {point: [0, 0, 0.02], normal: [0, 0, 1]}}}\n"
    more = "modes: 0, residuals: [{pressure: top}]"
    pressed = part_of(folder, top + PLATE.replace("modes: 4", more))
    assert pressed.n == without.n + 1


def test_attachment_modes_of_free_parts(folder: Path) -> None:
    sets = "sets: {edge: {box: {low: [0.2, 0.1, 0], high: [0.3, 0.1, 0.02]}}}\n"
    free = PLATE.replace("craig-bampton, modes: 4", "free-free, modes: 3, %s")
    plain = part_of(folder, sets + free % "residuals: [{force: [0, 0, 1], nodes: edge}]")
    assert plain.n == 4
    assert part_of(folder, sets + free % "interfaces: [root, bore]").n == 3 + 12


def test_a_mechanism_with_a_solid_runs(folder: Path) -> None:
    model = "parts:\n  arm:\n" + "".join(f"    {line}\n" for line in PLATE.strip().splitlines())
    model += (
        BODY
        + "joints: [{type: revolute, name: wall, a: ground.origin, b: arm.root, axis: [0, 1, 0]}]\n"
    )
    model += "sensors:\n  - {type: position, name: bore, marker: arm.bore}\n"
    model += "  - {type: stress, name: top, body: arm, sites: [[0.1, 0.05, 0.02]]}\n"
    model = model.replace("part: arm}", "part: arm, position: [0, -0.05, -0.01]}")
    file = parse_model(model, folder=folder)
    run = jo.simulate(jo.compile(file.mechanism), 1e-3, solver=jo.ROS2(1e-5))
    assert np.allclose(run["bore"][0], [0.3, 0.0, 0.0], atol=1e-4)
    # the nearest of the sites
    stress = file.mechanism.bodies[0].reduced.stress
    (site,) = file.mechanism.sensors[1].sites
    chosen = stress.positions[stress.labels.index(site)]
    away = np.linalg.norm(stress.positions - [0.1, 0.05, 0.02], axis=1)
    assert np.linalg.norm(chosen - [0.1, 0.05, 0.02]) == away.min() < 0.02
    # the rigid twin has the same mass and surface
    rigid = build_model(parse_document(model, folder=folder), rigid=True)
    assert rigid.mechanism.bodies[0].mass == pytest.approx(
        file.mechanism.bodies[0].reduced.invariants.mass
    )
    still = jo.simulate(jo.compile(rigid.mechanism), 1e-3, solver=jo.ROS2(1e-4))
    (shape,) = still.bodies
    assert is_surface(shape.elements)
    assert shape.nodes.max(axis=0) == pytest.approx([0.4, 0.1, 0.02])


def test_wrong_fields_are_named(folder: Path) -> None:
    text = PLATE.replace("mesh: plate.vtu", "mesh: {file: plate.vtu, units: mm}")
    text = text.replace("kind: rigid", "kind: rigd")
    text = text.replace("hole: {near: [0.3, 0.05, 0]}", "hole: {near: [0, 0, 0]}, nearest: {}")
    found = problems(folder, text)
    assert found[0] == "3: mesh.units: unknown key 'units'; did you mean 'unit'?"
    assert found[1] == "6: interfaces.0.kind: no kind 'rigd'; did you mean 'rigid'?"
    assert found[2].startswith("7: interfaces.1.nodes")


def test_exactly_one_pick_and_one_material(folder: Path) -> None:
    text = PLATE.replace("{hole: {near: [0.3, 0.05, 0]}}", "{inside: true}")
    text = text.replace("material: {E: 210 GPa, nu: 0.3, rho: 7850}\n", "")
    found = "\n".join(problems(folder, text))
    assert "give one of box, cylinder, sphere, plane, nearest, hole; found none" in found
    other = problems(folder, PLATE + "materials: {all: S355}\n")
    assert "give either material: for the whole part or materials: by element set" in other[0]


def test_what_the_mesh_does_not_have_is_said_at_once(folder: Path) -> None:
    text = PLATE.replace("{E: 210 GPa, nu: 0.3, rho: 7850}", "S3555")
    text = text.replace("nodes: left", "nodes: lefft")
    text = text.replace("near: [0.3, 0.05, 0]", "near: [0.3, 0.05, 0], diameter: 60 mm")
    text += "sets: {far: {box: {low: [5, 5, 5], high: [6, 6, 6]}}, left: right}\nstress: surfac\n"
    found = problems(folder, text)
    assert [item.partition(":")[0] for item in found] == ["4", "6", "7", "9", "9", "10"]
    assert found[0] == (
        "4: material: the library has no 'S3555'; did you mean 'S355'?; jo.materials.names() lists "
        "all of them"
    )
    assert found[1] == "6: interfaces.0.nodes: the mesh has no set 'lefft'; did you mean 'left'?"
    assert found[2].startswith("7: interfaces.1.nodes.hole: no hole of 60 mm; the mesh has 1 hole")
    assert "holds no node of the mesh, which spans (0, 0, 0) to (400, 100, 20) mm" in found[3]
    assert found[4] == "9: sets.left: the mesh has a set 'left' already; take another name"
    assert found[5].endswith("the mesh has no set 'surfac'; did you mean 'surface'?")


def test_a_missing_or_wrong_file_is_said_at_its_line(folder: Path) -> None:
    (found,) = problems(folder, PLATE.replace("plate.vtu", "plate.vtk"))
    assert found.startswith("3: mesh: ")
    assert "no such file" in found
    (folder / "text.inp").write_text("hello\n", encoding="utf-8")
    (found,) = problems(folder, PLATE.replace("plate.vtu", "text.inp"))
    assert found.startswith("3: mesh: ")


def test_residual_loads_need_a_set(folder: Path) -> None:
    more = "modes: 0, residuals: [{force: [0, 0, 1], nodes: lfet}]"
    (found,) = problems(folder, PLATE.replace("modes: 4", more))
    assert found == "8: reduce.residuals.0.nodes: no set 'lfet'; did you mean 'left'?"
    more = "modes: 0, residuals: [{pressure: lfet}]"
    (found,) = problems(folder, PLATE.replace("modes: 4", more))
    assert found.startswith("8: reduce.residuals.0.pressure: ")
    assert "did you mean 'left'?" in found


def test_options_of_the_caller_go_before_those_of_the_file(folder: Path) -> None:
    path = folder / "solver.yaml"
    path.write_text(PLATE + "solver: nonsense\n", encoding="utf-8")
    with pytest.raises(jo.InputError, match="nonsense"):
        read_part_file(path)
    stages: list[str] = []
    file = read_part_file(path, solver="superlu", progress=lambda stage, done: stages.append(stage))
    assert file.reduced.n > 0
    assert "factorisation" in stages


def test_beams_take_materials_of_the_library() -> None:
    beam = "type: beam, length: 1 m, section: {type: circle, diameter: 20 mm}, elements: 2"
    text = "parts: {rod: {%s, material: %s, reduce: {type: free-free, modes: 2}}}\n"
    text += "bodies: [{name: rod, part: rod}]\ngravity: [0, -9.81, 0]\n"
    text += "joints: [{type: revolute, name: a, a: ground.origin, b: rod.start, axis: [0, 0, 1]}]"
    by_name = parse_model(text % (beam, "S355")).mechanism.bodies[0].reduced
    steel = jo.material("S355")
    given = f"{{E: {steel.E}, nu: {steel.nu}, rho: {steel.rho}}}"
    by_value = parse_model(text % (beam, given)).mechanism.bodies[0].reduced
    assert np.array_equal(by_name.frequencies, by_value.frequencies)
    with pytest.raises(jo.InputError, match=r"material: the library has no 'S35'"):
        parse_model(text % (beam, "S35"))


def test_picks_take_the_surface_unless_the_inside_is_asked_for(folder: Path) -> None:
    box = "box: {low: [0, 0, 0], high: [0.4, 0.1, 0.02]}"
    path = folder / "picks.yaml"
    path.write_text(
        PLATE + f"sets: {{skin: {{{box}}}, every: {{{box}, inside: true}}}}\n", encoding="utf-8"
    )
    part = read_part_file(path, reduce=False).part
    assert set(part.node_sets["every"]) == set(range(len(part.nodes)))
    assert set(part.node_sets["skin"]) == set(np.unique(part.elements).tolist())
    assert len(part.node_sets["skin"]) < len(part.nodes)


@pytest.mark.parametrize("pick", ["hole: {near: [300, 50, 0]}", "nearest: {point: [300, 50, 0]}"])
def test_a_point_meant_in_millimetres_is_refused(folder: Path, pick: str) -> None:
    text = PLATE.replace("hole: {near: [0.3, 0.05, 0]}", pick)
    found = problems(folder, text)
    assert len(found) == 1
    assert "the mesh is 400 mm long" in found[0]
    assert "was [300 mm, 50 mm, 0] meant?" in found[0]
    assert ("the mesh has 1 hole: hole1, 50 mm" in found[0]) == pick.startswith("hole")
