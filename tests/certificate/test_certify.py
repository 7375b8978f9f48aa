"""The certificate: what it says of a sound part, and each fault with its sentence and remedy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from gmsh_session import opened
from jousto.base.errors import InputError, JoustoWarning
from jousto.certificate.certificate import Check
from jousto.certificate.certify import certify, full_model
from jousto.certificate.part_checks import mechanisms, speed_of_sound
from jousto.materials.material import Material
from jousto.mesh.cells import Cells
from jousto.mesh.mesh import Mesh
from jousto.mesh.readers.step import mesh_cad
from jousto.parts.interface import Interface
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import from_modes, reduce
from jousto.sections.section import Rectangle
from mesh.blocks import block
from reduction.bodies import STEEL, bent, lattice, pendulum

SECTION = Rectangle(0.02, 0.03)


def rod(elements: int = 10, **options: object) -> Part:
    return Part.beam(1.0, SECTION, elements, STEEL, name="rod", **options)  # type: ignore[arg-type]


def both_ends(modes: int = 6) -> CraigBampton:
    return CraigBampton(("start", "end"), modes=modes)


def scaled(part: Part, K: float, M: float, length: float = 1.0) -> Part:
    """The part as another system of units would write it."""
    assert part.dofs_per_node == 6
    s = np.tile(np.repeat([1.0, length], 3), len(part.nodes)) / length
    S = sp.diags_array(s)
    return replace(
        part,
        nodes=part.nodes * length,
        K=sp.csr_array(K * (S @ part.K @ S)),
        M=sp.csr_array(M * (S @ part.M @ S)),
        mass_points=None,
        stress=None,
        second_order=None,
    )


def softened(part: Part, node: int, factor: float) -> Part:
    """The part with the elements between two of its nodes made softer."""
    K = part.K.tolil()
    a, b = slice(6 * node, 6 * node + 6), slice(6 * node + 6, 6 * node + 12)
    element = Part.frame(
        part.nodes[node : node + 2], [[0, 1]], sections=SECTION, materials=STEEL
    ).K.toarray()
    for rows, i in ((a, 0), (b, 6)):
        for columns, j in ((a, 0), (b, 6)):
            block = K[rows, columns].toarray() - (1.0 - factor) * element[i : i + 6, j : j + 6]
            K[rows, columns] = block
    return replace(part, K=sp.csr_array(K))


# -- a sound part ---------------------------------------------------------------------------


def test_a_sound_part_and_its_modes() -> None:
    part = rod()
    c = certify(part, reduce(part, both_ends(modes=10)))
    assert c.passed and c.status == "ok"
    assert {check.status for check in c.checks} <= {"ok", "note"}
    facts = dict(c.facts)
    assert facts["mass"] == "4.71 kg"
    assert facts["centre"] == "500, 0, 0 mm"
    # m L^2 / 12 and the section's own part
    J = 4.71 / 12.0 * (1.0 + 0.03**2)
    assert float(facts["inertia about it"].split()[4].rstrip(",")) == pytest.approx(J, rel=1e-5)
    assert facts["bounding size"].startswith("1000 x 0 x 0 mm")
    assert c["static loads"].status == "ok"
    with pytest.raises(KeyError, match="no check of 'statics'; the checks are: rigid motions"):
        c["statics"]


def test_the_part_alone_is_examined_without_modes() -> None:
    c = certify(rod())
    assert [check.topic for check in c.checks] == [
        "rigid motions", "units", "rotary inertia", "loose nodes", "mechanisms", "content",
    ]  # fmt: skip
    assert c.status == "ok"


def test_static_displacement_of_an_end_moment_is_the_closed_form() -> None:
    """A simply supported beam under an end moment turns by L/(3 E I) + 1/(k G A L) there."""
    part = rod()
    c = certify(part, reduce(part, both_ends()))
    table = next(t for t in c.tables if "interface loads" in t.title)
    row = next(r for r in table.rows if r[0] == "end mz")
    k = 10.0 * (1.0 + STEEL.nu) / (12.0 + 11.0 * STEEL.nu)
    exact = 1.0 / (3.0 * STEEL.E * SECTION.Iz) + 1.0 / (k * STEEL.G * SECTION.A)
    assert float(row[1]) == pytest.approx(exact, rel=2e-3)
    # every load bends something: those on supports are balanced by other ones
    assert all(float(row[2]) < 1e-8 for row in table.rows)
    axial = [float(row[1]) for row in table.rows if row[0] in ("start fx", "end fx")]
    np.testing.assert_allclose(axial, 1.0 / (STEEL.E * SECTION.A), rtol=1e-3)


def test_a_single_node_bends_nothing_but_by_inertia() -> None:
    part = rod()
    c = certify(part, reduce(part, CraigBampton(("start",), modes=6)))
    assert c["static loads"].value == "single support"
    table = next(t for t in c.tables if "interface loads" in t.title)
    assert {row[1] for row in table.rows} == {"support"}


def test_effective_mass_of_a_clamped_beam_is_the_closed_form() -> None:
    """Clamped and free: m_eff / m = (2 s / l)^2 (Blevins 1979, table 8-1: l and s)."""
    part = Part.beam(1.0, Rectangle(0.01, 0.015), 24, STEEL)
    c = certify(part, reduce(part, CraigBampton(("start",), modes=8)))
    table = next(t for t in c.tables if "effective mass" in t.title)
    share = [float(row[2].split()[0]) for row in table.rows[:-1]]
    y = sorted((float(row[3].split()[0]) for row in table.rows[:-1]), reverse=True)
    assert max(share) == 0.0
    for found, l, s in zip(y, (1.87510407, 4.69409113), (0.734095514, 1.018467319), strict=False):
        # half of the printed digit, and the elements' 0.01
        assert found == pytest.approx(100.0 * (2.0 * s / l) ** 2, abs=0.06)


def test_free_frequencies_of_the_full_model_are_those_of_all_modes() -> None:
    part = bent()
    c = certify(part, reduce(part, both_ends()))
    table = next(t for t in c.tables if t.title == "free-free frequencies")
    full = reduce(part, FreeFree(modes=10)).frequencies
    np.testing.assert_allclose([float(row[1]) for row in table.rows], full, rtol=1e-5)


def test_speed_of_sound_of_beams_is_that_of_a_thin_rod() -> None:
    for part in (rod(), bent(mass=False)):
        full, _ = full_model(part)
        assert full is not None
        assert speed_of_sound(full) == pytest.approx(np.sqrt(210e9 / 7850.0), rel=1e-9)


def test_the_page_of_text_holds_facts_checks_advice_and_tables() -> None:
    part = pendulum()
    text = str(certify(part, reduce(part, CraigBampton(("start",), modes=4))))
    assert text.startswith("certificate of part 'pendulum': 2 warnings")
    assert "  warn  units" in text and "6 rigid" not in text
    assert "six rigid motions" in text and "strain energy of 1 mm or 1 mrad (J)" in text
    assert max(map(len, text.splitlines())) < 130


def test_repeatable() -> None:
    part = bent()
    reduced = reduce(part, both_ends())
    assert str(certify(part, reduced)) == str(certify(part, reduced))


# -- each check fails once ------------------------------------------------------------------


def expect(check: Check, status: str, sentence: str, remedy: str) -> None:
    assert check.status == status, check
    assert sentence in check.sentence, check.sentence
    assert remedy in check.remedy, check.remedy


def test_support_left_in_the_stiffness_matrix() -> None:
    part = rod()
    K = part.K.tolil()
    K[1, 1] += 1e5
    c = certify(replace(part, K=sp.csr_array(K)))
    expect(c["rigid motions"], "fail", "moving the rigid body along y stores", "remove supports")
    assert not c.passed
    K[1, 1] -= 1e5 - 1.0
    soft = certify(replace(part, K=sp.csr_array(K)))
    expect(soft["rigid motions"], "warn", "as if it were a mode of", "remove supports")


def test_nodes_that_do_not_belong_to_the_matrices() -> None:
    part = bent(mass=False)
    c = certify(replace(part, nodes=1.01 * part.nodes, mass_points=None))
    check = c["rigid motions"]
    assert check.status in ("warn", "fail")
    assert "moving the rigid body about" in check.sentence
    assert "node positions are in m, in the order of the matrices" in check.remedy


@pytest.mark.parametrize(
    ("part", "speed", "remedy"),
    [
        # N/mm, t, mm from N/m, kg, m
        (scaled(rod(), 1e3, 1e3, 1e3), "5.172e+06 m/s", "matrices are in mm, t and s"),
        (scaled(rod(), 1e-6, 1.0), "5.172 m/s", "E is in MPa"),
        (scaled(rod(), 1.0, 1e-3), "1.636e+05 m/s", "density is in g/cm3"),
        (scaled(rod(), 1e-9, 1.0), "0.1636 m/s", "E is in GPa"),
        (scaled(rod(), 1.0, 1e-12), "5.172e+09 m/s", "density is in t/mm3"),
        (scaled(rod(), 1e-3, 1.0), "163.6 m/s", "E is in kPa"),
        (scaled(rod(), 3.2e-5, 1.0), "29.26 m/s", "check the units of E, density and lengths"),
    ],
)
def test_other_units(part: Part, speed: str, remedy: str) -> None:
    check = certify(part)["units"]
    # 164 m/s may be foam or rubber, the others are nothing
    status = "warn" if speed.startswith("163.6") else "fail"
    expect(check, status, f"sound would travel at {speed}", remedy)


def test_millimetres_read_as_metres() -> None:
    with pytest.warns(JoustoWarning, match="is 1000 m large"):
        part = Part.beam(1000.0, Rectangle(20.0, 30.0), 4, STEEL)
    check = certify(part)["units"]
    expect(check, "warn", "the part is 1e+06 mm long", "scale the mesh by 0.001")
    check = certify(Part.beam(1e-4, Rectangle(2e-6, 3e-6), 4, STEEL))["units"]
    expect(check, "warn", "the part is 0.1 mm long", "scale the mesh by 1000")


def test_heavier_than_a_solid_block() -> None:
    part = lattice()
    heavy = replace(part, M=sp.csr_array(1000.0 * part.M), K=sp.csr_array(1000.0 * part.K))
    check = certify(heavy)["units"]
    expect(check, "fail", "more than a solid block of osmium", "point masses")


def test_mass_on_a_line() -> None:
    part = rod(lumped=True, rotary_inertia=False)
    c = certify(part)
    expect(c["rotary inertia"], "fail", "all mass lies on a line", "rotary_inertia=True")
    assert certify(pendulum())["rotary inertia"].status == "warn"


def test_rotations_without_inertia() -> None:
    part = bent(lumped=True, rotary=False, mass=False)
    check = certify(part)["rotary inertia"]
    expect(check, "note", "rotations of these nodes have no mass", "consistent mass")
    assert check.value == "10 nodes of 10 without"
    # inertia about one axis gives a rotation a frequency
    spin = np.zeros(60)
    spin[[3, 10, 17]] = 1e-6
    check = certify(replace(part, M=sp.csr_array(part.M + sp.diags_array(spin))))["rotary inertia"]
    assert check.value == "7 nodes of 10 without"


def test_nodes_that_nothing_holds() -> None:
    part = bent()
    loose = np.r_[np.ones(54), np.zeros(6)]
    D = sp.diags_array(loose)
    c = certify(replace(part, K=sp.csr_array(D @ part.K @ D)))
    expect(c["loose nodes"], "fail", "no element is connected to them", "connect them")
    assert c["loose nodes"].value == "1 node: node10"
    assert c["mechanisms"].status == "fail"
    turning = np.ones(60)
    turning[57:] = 0.0
    D = sp.diags_array(turning)
    c = certify(replace(part, K=sp.csr_array(D @ part.K @ D)))
    expect(c["loose nodes"], "fail", "have no stiffness", "leave out their rotations")


def test_a_part_of_two_pieces() -> None:
    c = certify(softened(rod(), 4, 0.0))
    expect(c["loose nodes"], "fail", "has disconnected pieces", "merge coinciding nodes")
    assert c["loose nodes"].value == "2 pieces"
    expect(c["mechanisms"], "fail", "motion without stiffness", "merge nodes of touching meshes")


def test_a_node_that_swings() -> None:
    c = certify(lattice(bars_of_last_node=2))
    expect(c["mechanisms"], "fail", "node16 u", "connect the component")


def test_something_that_hangs_almost_loose() -> None:
    c = certify(softened(rod(), 4, 1e-9))
    expect(c["mechanisms"], "warn", "a component is almost loose", "connect the component")
    assert "modes up to" in c["mechanisms"].sentence


def test_components_almost_loose_at_two_levels() -> None:
    """All modes below the last gap are loose, and the node named moves most in the last of them."""
    full, _ = full_model(rod(), modes=0)
    assert full is not None
    f, shapes = np.array([1.0, 5e3, 2e7, 3e7]), np.zeros((66, 4))
    shapes[6 * 3, 0] = shapes[6 * 7 + 1, 1] = 1.0
    check = mechanisms(replace(full, frequencies=f, shapes=shapes), "")
    expect(check, "warn", "2 modes up to 5000 Hz are far below the next one, 2e+07 Hz", "")
    assert "node8 uy moves most" in check.sentence


def test_matrices_have_no_stress() -> None:
    check = certify(lattice())["content"]
    assert check.status == "note"
    assert "no stress" in check.sentence and "no stiffening" in check.sentence


def test_modes_of_another_part() -> None:
    c = certify(rod(), reduce(softened(rod(), 4, 0.9), both_ends()))
    expect(c["input"], "fail", "from other nodes or matrices", "reduce this part again")
    expect(c["frequencies"], "fail", "this one is softer", "reduce this part again")
    expect(c["modes"], "fail", "not the orthonormal modes", "reduce this part again")
    with pytest.raises(InputError, match="'rod' has 11 nodes, part 'rod' has 6: give the part"):
        certify(rod(5), reduce(rod(), both_ends()))
    with pytest.raises(InputError, match="part is 3, must be a Part"):
        certify(3)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="must be a ReducedPart, the result of reduce"):
        certify(rod(), rod())  # type: ignore[arg-type]


def test_printed_modes_with_few_digits() -> None:
    part = bent()
    exact = reduce(part, FreeFree(modes=3))
    assert exact.rotations is not None
    X = np.concatenate([exact.modes, exact.rotations], axis=1).reshape(-1, 3)
    short = from_modes(part, X * 1.0001, exact.frequencies)
    expect(
        certify(part, short)["modes"], "warn", "not the orthonormal modes", "all available digits"
    )


def test_no_interface() -> None:
    part = bent()
    check = certify(part, reduce(part, FreeFree(modes=5)))["interfaces"]
    expect(check, "note", "of a free body", "use CraigBampton")


def test_an_interface_that_transmits_no_moment() -> None:
    part = lattice()
    sets = dict(part.node_sets) | {"pin": (0,), "far": (4, 13, 14)}
    part = replace(part, node_sets=sets)
    c = certify(part, reduce(part, CraigBampton(("pin", "far"), modes=2)))
    expect(c["interfaces"], "note", "'pin' alone cannot transmit every moment", "tie the surface")


def test_an_interface_of_many_nodes() -> None:
    part = replace(rod(30), node_sets={"all": tuple(range(25))})
    c = certify(part, reduce(part, CraigBampton(("all",), modes=2)))
    expect(c["interfaces"], "warn", "each interface degree of freedom adds", "tie the nodes")
    assert c["static loads"].status == "ok"


def test_interface_nodes_close_together() -> None:
    nodes = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [1.00005, 0.0, 0.0]]
    part = Part.frame(
        nodes, [[0, 1], [1, 2], [2, 3]], sections=SECTION, materials=STEEL,
        node_sets={"ends": (0, 2, 3)},
    )  # fmt: skip
    c = certify(part, reduce(part, CraigBampton(("ends",), modes=2)))
    expect(c["conditioning"], "warn", "much stiffer than others", "to one node")


def test_modes_left_out() -> None:
    part = rod()
    reduced = reduce(part, both_ends())
    c = certify(part, reduced.keep(reduced.in_plane("xy")))
    expect(
        c["conditioning"],
        "warn",
        "do not contain all motions of the interfaces",
        "for plane motion",
    )
    expect(c["static loads"], "warn", "does not deform under", "in_plane")
    part = bent()
    c = certify(part, reduce(part, both_ends()).keep(range(5)))
    expect(c["static loads"], "warn", "differently from the full model", "constraint modes")


def test_static_answer_that_is_wrong_although_no_mode_is_missing() -> None:
    part = rod()
    reduced = reduce(part, both_ends())
    wrong = replace(reduced, frequencies=1.001 * reduced.frequencies)
    c = certify(part, wrong)
    expect(c["static loads"], "fail", "deforms differently from the full model", "ill-conditioned")


def test_too_few_modes() -> None:
    part = lattice()
    c = certify(part, reduce(part, CraigBampton(("foot",), modes=0)))
    expect(c["frequencies"], "warn", "lowest mode of the free part", "more modes")
    expect(
        c["effective mass"], "warn", "has no vibration mode with", "ask for fixed-interface modes"
    )
    part = bent()
    c = certify(part, reduce(part, both_ends(modes=1)))
    expect(c["effective mass"], "note", "much of the mass only follows", "more fixed-interface")
    expect(c["accelerating loads"], "note", "there are few vibration modes", "ask for more")


def test_a_plane_body_lacks_the_lowest_mode_out_of_its_plane() -> None:
    part = rod()
    reduced = reduce(part, both_ends())
    c = certify(part, reduced.keep(reduced.in_plane("xz")))
    expect(c["frequencies"], "warn", "does not have the lowest mode", "left out on purpose")
    assert "mode 1" in c["frequencies"].value and "missing" in c["frequencies"].value


def test_no_mass() -> None:
    part = rod()
    c = certify(replace(part, M=sp.csr_array(part.M.shape), mass_points=None))
    expect(c["mass"], "fail", "the mass is 0 kg, must be positive", "whole mass matrix")


def test_a_status_that_does_not_exist() -> None:
    with pytest.raises(InputError, match="status is 'fine', must be one of ok, note, warn, fail"):
        Check("units", "fine", "1")  # type: ignore[arg-type]


# -- solids, meshes and ties ----------------------------------------------------------------


def solid(
    mesh: Mesh | None = None, kinds: tuple[str, str] = ("rigid", "average"), **options: object
) -> Part:
    """A bar of quadratic hexahedra with both ends tied to nodes that turn."""
    mesh = block("hexahedron20", (6, 1, 2), (0.3, 0.03, 0.04)) if mesh is None else mesh
    low, high = mesh.bounds
    ties = tuple(
        Interface(name, mesh.box(lo, hi), kind=kind)  # type: ignore[arg-type]
        for name, kind, lo, hi in zip(
            ("left", "right"),
            kinds,
            ((-1.0, -1.0, -1.0), (high[0] - 1e-9, -1.0, -1.0)),
            ((low[0] + 1e-9, 1.0, 1.0), (1.0, 1.0, 1.0)),
            strict=True,
        )
    )
    return Part.solid(mesh, STEEL, interfaces=ties, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "kinds", [("rigid", "rigid"), ("average", "average"), ("rigid", "average")]
)
def test_a_sound_solid_with_tied_ends(kinds: tuple[str, str]) -> None:
    part = solid(kinds=kinds)
    c = certify(part, reduce(part, CraigBampton(modes=8)))
    assert c.status == "ok", str(c)
    facts = dict(c.facts)
    assert facts["bounding size"].startswith("300 x 30 x 40 mm")
    assert facts["volume"] == "360000 mm3, 7850 kg/m3 on average"
    assert facts["finite element model"].startswith(f"{len(part.nodes)} nodes, 12 elements")
    assert f"right ({kinds[1]} tie of 13 nodes about 300, 15, 20 mm)" in facts["interfaces"]
    table = next(t for t in c.tables if "interface loads" in t.title)
    assert [row[0] for row in table.rows[:6]] == [f"left f{x}" for x in "xyz"] + [
        f"left m{x}" for x in "xyz"
    ]
    assert all(float(row[2]) < 1e-8 for row in table.rows)
    # a bar: its ends move by L / (E A) from each other, and a little by the tie
    axial = next(float(row[1]) for row in table.rows if row[0] == "right fx")
    assert axial == pytest.approx(0.3 / (STEEL.E * 0.03 * 0.04), rel=0.08)


def two_blocks(kind: str) -> Part:
    """Two bars in line with a gap; one interface over the faces at it, one at the far end."""
    one = block("hexahedron20", (3, 1, 2), (0.15, 0.03, 0.04))
    n = len(one.nodes)
    mesh = Mesh(
        "two",
        np.concatenate([one.nodes, one.nodes + [0.2, 0.0, 0.0]]),
        Cells("hexahedron20", np.concatenate([one.cells[0].nodes, one.cells[0].nodes + n])),
    )
    at_gap = mesh.box((0.149, -1.0, -1.0), (0.201, 1.0, 1.0))
    ties = (
        Interface("gap", at_gap, kind=kind),  # type: ignore[arg-type]
        Interface("end", mesh.box((0.349, -1.0, -1.0), (1.0, 1.0, 1.0))),
    )
    with pytest.warns(JoustoWarning, match="pieces"):
        return Part.solid(mesh, STEEL, interfaces=ties)


def test_blocks_joined_by_a_rigid_tie_are_one_piece() -> None:
    part = two_blocks("rigid")
    c = certify(part, reduce(part, CraigBampton(modes=8)))
    assert c.passed, str(c)
    assert c["loose nodes"].status == "ok"
    expect(c["mesh: pieces"], "note", "joined by rigid interfaces", "")


def test_an_average_joins_no_blocks() -> None:
    c = certify(two_blocks("average"))
    expect(c["loose nodes"], "fail", "has disconnected pieces", "a rigid interface")
    assert c["mesh: pieces"].status == "fail"


def test_speed_of_sound_of_solids_is_that_of_their_bulk_modulus() -> None:
    full, _ = full_model(solid())
    assert full is not None
    bulk = STEEL.E / (3.0 * (1.0 - 2.0 * STEEL.nu))
    assert speed_of_sound(full) == pytest.approx(np.sqrt(bulk / STEEL.rho), rel=1e-9)


def test_linear_elements() -> None:
    part = solid(block("hexahedron", (6, 1, 2), (0.3, 0.03, 0.04)))
    expect(certify(part)["elements"], "warn", "too stiff in bending", "use hexahedron20")


def test_a_sliver() -> None:
    mesh = block("tetra10", (3, 1, 1), (0.3, 0.03, 0.04))
    nodes = mesh.nodes.copy()
    # the corner at x = 0.2 almost into the plane of its neighbours
    flat = replace(mesh, nodes=nodes * [1.0, 1.0, 0.01])
    check = certify(solid(flat))["mesh quality"]
    expect(check, "warn", "are nearly flat", "mesh there")
    assert "scaled Jacobian at least 0.05" in check.limit


def test_folded_elements() -> None:
    mesh = block("tetra10", (2, 1, 1), (0.3, 0.03, 0.04))
    part = solid(mesh)
    nodes = mesh.nodes.copy()
    middle = next(i for i in range(len(nodes)) if i not in mesh.cells[0].nodes[:, :4])
    nodes[middle] += [0.2, 0.0, 0.0]
    bad = replace(part, mesh=replace(mesh, nodes=nodes))
    expect(certify(bad)["mesh quality"], "fail", "folded or inverted", "straighten")


def test_what_the_mesh_says_of_itself() -> None:
    mesh = block("hexahedron20", (6, 1, 2), (0.3, 0.03, 0.04))
    near = mesh.nodes[:1] + 1e-9
    both = Mesh("b", np.concatenate([mesh.nodes, near]), mesh.cells, node_sets={})
    part = replace(solid(), mesh=both)
    topics = {check.topic: check for check in certify(part).checks}
    found = [check for topic, check in topics.items() if topic.startswith("mesh: ")]
    assert found and all(check.status in ("warn", "fail") for check in found)
    assert topics.get("mesh") is None


def test_bodies_that_touch_along_an_edge() -> None:
    """Two cubes with one edge in common turn about it."""
    one = block("hexahedron20", (2, 2, 1), (0.2, 0.2, 0.1))
    cells = one.cells[0].nodes[[0, 3]]
    centre = one.nodes[cells].mean(axis=1)
    assert np.abs(centre[0] - centre[1])[:2].min() > 0.05
    used = np.unique(cells)
    new = np.full(len(one.nodes), -1)
    new[used] = np.arange(len(used))
    mesh = Mesh("hinge", one.nodes[used], Cells("hexahedron20", new[cells]))
    c = certify(Part.solid(mesh, STEEL))
    expect(c["surface"], "warn", "are connected like by a hinge", "let them share faces")
    expect(c["mechanisms"], "fail", "motion without stiffness", "connect the component")


def test_an_open_surface() -> None:
    part = solid()
    check = certify(replace(part, elements=part.elements[1:]))["surface"]
    expect(check, "warn", "the surface is open at", "mesh touching bodies together")


def test_ties_of_a_narrow_surface() -> None:
    mesh = block("hexahedron20", (6, 1, 2), (0.3, 0.03, 0.04))
    with pytest.warns(JoustoWarning, match="almost on a line"):
        part = Part.solid(
            mesh, STEEL,
            interfaces=(
                Interface("left", mesh.box((-1, -1, -1), (1e-9, 1, 1)), at=(0.0, 0.015, 90.0)),
            ),
        )  # fmt: skip
    c = certify(part, reduce(part, CraigBampton(modes=6)))
    expect(c["interfaces"], "warn", "almost on a line or far from", "move the reference point")


def test_a_mesh_of_another_density() -> None:
    light = Material(E=1.0e9, nu=0.3, rho=2.0)
    mesh = block("hexahedron20", (6, 1, 2), (0.3, 0.03, 0.04))
    check = certify(Part.solid(mesh, light))["units"]
    expect(check, "fail", "are 2 kg/m3", "check the density")


def test_a_mesh_that_is_too_coarse() -> None:
    """The estimated error of stress under interface loads: where it is and what to do."""
    fine = solid(block("hexahedron20", (12, 2, 2), (0.3, 0.03, 0.04)))
    check = certify(fine, reduce(fine, CraigBampton(modes=2)))["mesh error"]
    assert check.status == "ok" and "most of it in element" in check.sentence
    for kind, status in (("hexahedron20", "warn"), ("hexahedron", "fail")):
        coarse = solid(block(kind, (3, 1, 1), (0.3, 0.03, 0.04)))
        check = certify(coarse, reduce(coarse, CraigBampton(modes=2)))["mesh error"]
        expect(check, status, "estimated error in the mean", "quadratic elements")
        assert "energy norm" in check.limit
    # without interfaces the lowest mode tells; matrices and beams have no mesh
    assert certify(fine)["mesh error"].sentence.startswith("stress under free mode")
    assert "mesh error" not in [c.topic for c in certify(rod()).checks]


@pytest.mark.filterwarnings("ignore:.*would be folded")
def test_volume_against_cad(tmp_path: Path) -> None:
    # a plate of 100 x 100 x 20 mm with four holes of 44 mm: hexagons and the like leave more
    gmsh = pytest.importorskip("gmsh")
    with opened(gmsh):
        occ = gmsh.model.occ
        holes = [(3, occ.addCylinder(x, y, -1, 0, 0, 22, 22)) for x in (25, 75) for y in (25, 75)]
        occ.cut([(3, occ.addBox(0, 0, 0, 100, 100, 20))], holes)
        occ.synchronize()
        gmsh.write(str(tmp_path / "plate.step"))
    exact = 1e-9 * 20 * (100**2 - 4 * np.pi * 22**2)
    for per_circle, curved, status in ((4, False, "fail"), (16, False, "warn"), (16, True, "ok")):
        mesh = mesh_cad(tmp_path / "plate.step", size=4e-2, per_circle=per_circle, curved=curved)
        assert mesh.cad_volume == pytest.approx(exact, rel=1e-9)
        part = Part.solid(mesh, STEEL)
        check = certify(part)["volume against CAD"]
        assert check.status == status, check
        share = 100 * (mesh.volume / exact - 1)
        assert float(check.value.partition(" %")[0]) == pytest.approx(share, rel=0.06)
        if status != "ok":
            assert "heavier than the CAD solid" in check.sentence
    assert mesh.scaled(2.0).cad_volume == pytest.approx(8 * exact, rel=1e-9)
    assert mesh.solid().cad_volume == mesh.merged().cad_volume == mesh.cad_volume
