"""Beams of Abaqus and CalculiX decks: sections, axes, units, instances, against closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from jousto.parts import EulerBernoulli
from jousto.parts.frames.deck import deck_frame
from jousto.parts.frames.frame import BeamOptions
from jousto.parts.matrices.units import Units
from verification.calculix import _frequencies, needed, run

L, E, NU, RHO = 2.0, 2.1e11, 0.3, 7850.0
MATERIAL = f"*MATERIAL, NAME=Steel\n*ELASTIC\n{E}, {NU}\n*DENSITY\n{RHO}\n"
STEEL = jo.Material(E, NU, RHO, name="Steel")
READ = pytest.mark.filterwarnings("ignore:.* read as beams that are exact between their nodes")


def line(direction, n: int = 8, etype: str = "B31", start=(0.0, 0.0, 0.0)) -> str:
    """Nodes 1.. on a line and elements between them; of B32 every second node is a middle one."""
    m = 2 * n if etype.startswith("B32") else n
    x = np.array(start) + np.linspace(0, L, m + 1)[:, None] * np.array(direction)
    nodes = "".join(f"{i}, {a!r}, {b!r}, {c!r}\n" for i, (a, b, c) in enumerate(x.tolist(), 1))
    if m == n:
        rows = "".join(f"{i}, {i}, {i + 1}\n" for i in range(1, n + 1))
    else:
        rows = "".join(f"{i}, {2 * i - 1}, {2 * i}, {2 * i + 1}\n" for i in range(1, n + 1))
    return f"*NODE, NSET=ALL\n{nodes}*ELEMENT, TYPE={etype}, ELSET=BEAM\n{rows}"


def section(shape: str, sizes: str, n1: str = "", keyword: str = "BEAM SECTION") -> str:
    axis = f"{n1}\n" if n1 else ""
    return f"*{keyword}, SECTION={shape}, ELSET=BEAM, MATERIAL=steel\n{sizes}\n{axis}"


def read(folder: Path, text: str, **options) -> jo.Part:
    (folder / "frame.inp").write_text(text)
    return jo.Part.from_deck(folder / "frame.inp", **options)


def cantilever_modes(part: jo.Part, count: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in Hz of the part held at its first node, and the motions of the last one."""
    K, M = part.K.toarray()[6:, 6:], part.M.toarray()[6:, 6:]
    values, modes = eigh(K, M, subset_by_index=(0, count - 1))
    tip = modes[-6:-3] / np.linalg.norm(modes[-6:-3], axis=0)
    return np.sqrt(values) / (2 * np.pi), tip


UNIT = np.array([2.0, 1.0, -2.0]) / 3.0


@READ
@pytest.mark.parametrize("etype", ["B31", "B32", "B33"])
def test_a_beam_bends_along_its_thin_side_first(tmp_path: Path, etype: str) -> None:
    # 20 mm along axis 1, 60 mm along axis 2; n1 is made normal to the beam
    n1 = np.array([0.3, 0.9, 0.1])
    text = line(UNIT, etype=etype) + section("RECT", "0.02, 0.06", "0.3, 0.9, 0.1") + MATERIAL
    part = read(tmp_path, text)
    assert part.mass == pytest.approx(RHO * 0.02 * 0.06 * L, rel=1e-12)
    f, tip = cantilever_modes(part)
    across = n1 - UNIT * (UNIT @ n1)
    across /= np.linalg.norm(across)
    for i, (side, axis) in enumerate(((0.02, across), (0.06, np.cross(UNIT, across)))):
        # 1.8751^2 / (2 pi) sqrt(E I / rho A) / L^2; shear and rotary inertia lower it by 2 (h/L)^2
        exact = 1.875104**2 / (2 * np.pi) * np.sqrt(E * side**2 / 12 / RHO) / L**2
        assert f[i] == pytest.approx(exact, rel=3 * (side / L) ** 2 + 1e-5)
        assert abs(tip[:, i] @ axis) == pytest.approx(1.0, abs=1e-9)
    assert len(part.node_sets["ALL"]) == len(part.nodes)
    assert len(part.nodes) == (17 if etype == "B32" else 9)


def test_beams_without_shear_are_those_of_euler_and_bernoulli(tmp_path: Path) -> None:
    text = line((1, 0, 0), etype="B33") + section("RECT", "0.02, 0.06", "0, 1, 0") + MATERIAL
    part = read(tmp_path, text)
    same = jo.Part.beam(L, jo.Rectangle(0.02, 0.06), 8, STEEL, theory=EulerBernoulli())
    np.testing.assert_allclose(part.K.toarray(), same.K.toarray(), rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(part.M.toarray(), same.M.toarray(), rtol=1e-12, atol=1e-15)


@READ
@pytest.mark.parametrize(
    ("shape", "sizes", "same"),
    [
        ("RECT", "0.02, 0.06", jo.Rectangle(0.02, 0.06)),
        ("CIRC", "0.03", jo.Circle(0.06)),
        ("CIRC", "0.06, 0.06", jo.Circle(0.06)),  # CalculiX: two diameters
        ("PIPE", "0.03, 0.004", jo.Tube(0.06, 0.004)),
        (
            "BOX",
            "0.04, 0.08, 0.003, 0.005, 0.003, 0.005",
            jo.Box(width=0.04, height=0.08, web=0.003, flange=0.005),
        ),
        (
            "I",
            "0.05, 0.1, 0.06, 0.06, 0.008, 0.008, 0.005",
            jo.IBeam(height=0.1, width=0.06, web=0.005, flange=0.008),
        ),
    ],
)
def test_sections(tmp_path: Path, shape: str, sizes: str, same) -> None:
    part = read(tmp_path, line((1, 0, 0)) + section(shape, sizes, "0, 1, 0") + MATERIAL)
    beam = jo.Part.beam(L, same, 8, STEEL)
    scale = np.abs(beam.K.toarray()).max()
    np.testing.assert_allclose(part.K.toarray(), beam.K.toarray(), atol=1e-13 * scale)
    assert part.mass == pytest.approx(beam.mass, rel=1e-13)
    # stress at the points of the section, in the same axes
    u = np.random.default_rng(3).normal(size=part.K.shape[0])
    mine, other = part.stress.matrix @ u, beam.stress.matrix @ u
    np.testing.assert_allclose(mine, other, atol=1e-10 * np.abs(other).max())


@READ
def test_the_origin_of_an_i_section_is_off_its_centroid(tmp_path: Path) -> None:
    sizes = "{}, 0.1, 0.06, 0.06, 0.008, 0.008, 0.005"
    low = read(tmp_path, line((1, 0, 0)) + section("I", sizes.format("0."), "0, 1, 0") + MATERIAL)
    mid = read(tmp_path, line((1, 0, 0)) + section("I", sizes.format("0.05"), "0, 1, 0") + MATERIAL)
    # nodes at its lower side: the inertia about the nodes' line grows by m (h/2)^2, Steiner
    roll = [p.rigid_modes()[:, 3] for p in (low, mid)]
    values = [r @ (p.M @ r) for r, p in zip(roll, (low, mid), strict=True)]
    assert values[0] - values[1] == pytest.approx(low.mass * 0.05**2, rel=1e-10)
    # the section stands above its nodes along axis 2, which is z
    moment = low.rigid_modes()[:, 4] @ (low.M @ low.rigid_modes()[:, 0])
    assert moment == pytest.approx(low.mass * 0.05, rel=1e-10)


@READ
def test_general_section_with_turned_principal_axes(tmp_path: Path) -> None:
    # a rectangle turned by 25 degrees within the axes 1, 2
    a, b, angle = 0.02, 0.06, np.radians(25.0)
    same = jo.Rectangle(a, b)
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    J = R @ np.diag([same.Iz, same.Iy]) @ R.T  # int x x^T dA
    sizes = ", ".join(f"{x:.17g}" for x in (same.A, J[1, 1], J[0, 1], J[0, 0], same.J))
    G = E / 2 / (1 + NU)
    general = (
        f"*BEAM GENERAL SECTION, SECTION=GENERAL, ELSET=BEAM, DENSITY={RHO}\n{sizes}\n0, 1, 0\n"
        f"{E!r}, {G!r}\n"
    )
    part = read(tmp_path, line((1, 0, 0), etype="B33") + general)
    n1 = f"0, {np.cos(angle):.17g}, {np.sin(angle):.17g}"
    turned = section("RECT", f"{a}, {b}", n1) + MATERIAL
    beam = read(tmp_path, line((1, 0, 0), etype="B33") + turned)
    scale = np.abs(beam.K.toarray()).max()
    np.testing.assert_allclose(part.K.toarray(), beam.K.toarray(), atol=1e-12 * scale)
    # rotary inertia is that of the principal axes, too
    np.testing.assert_allclose(part.M.toarray(), beam.M.toarray(), atol=1e-12 * beam.mass)


@READ
def test_a_blank_line_is_the_default_axis(tmp_path: Path) -> None:
    # Abaqus: "enter a blank line if the default values are to be used"
    head = f"*BEAM GENERAL SECTION, SECTION=RECT, ELSET=BEAM, DENSITY={RHO}\n0.02, 0.06\n"
    blank, said = (read(tmp_path, line((1, 0, 0)) + f"{head}{n1}\n{E!r}, {E / 2.6!r}, 1E-5\n\n")
                   for n1 in ("", "0, 0, -1"))  # fmt: skip
    np.testing.assert_array_equal(blank.K.toarray(), said.K.toarray())


@READ
def test_units_of_the_deck(tmp_path: Path) -> None:
    metres = read(tmp_path, line(UNIT) + section("RECT", "0.02, 0.06", "0, 1, 0") + MATERIAL)
    text = line(1e3 * UNIT) + section("RECT", "20., 60.", "0, 1, 0")
    text += "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1E5, 0.3\n*DENSITY\n7.85D-9\n"
    text += "*ELEMENT, TYPE=MASS, ELSET=LUMP\n99, 9\n*MASS, ELSET=LUMP\n0.002\n"
    mm = read(tmp_path, text, units="mm-t-s")
    np.testing.assert_allclose(mm.nodes, metres.nodes, atol=1e-14)
    scale = np.abs(metres.K.toarray()).max()
    np.testing.assert_allclose(mm.K.toarray(), metres.K.toarray(), atol=1e-12 * scale)
    # 2 kg on the last node
    assert mm.mass == pytest.approx(metres.mass + 2.0, rel=1e-12)
    difference = (mm.M - metres.M).toarray()
    np.testing.assert_allclose(np.diag(difference)[-6:-3], 2.0, rtol=1e-10)


LEG = (
    f"*PART, NAME=LEG\n{line((1, 0, 0), n=2)}"
    f"{section('RECT', '0.02, 0.06', '0, 1, 0')}*NSET, NSET=FOOT\n1,\n*END PART\n"
)


@READ
def test_instances_of_beams_turn_their_axes(tmp_path: Path) -> None:
    place = "0, 0, 0\n0, 0, 0, 1, 1, 1, 120.\n"  # x -> y -> z -> x
    text = (
        f"{LEG}*ASSEMBLY, NAME=A\n*INSTANCE, NAME=L-1, PART=LEG\n*END INSTANCE\n"
        f"*INSTANCE, NAME=L-2, PART=LEG\n{place}*END INSTANCE\n*END ASSEMBLY\n{MATERIAL}"
    )
    with pytest.raises(InputError, match="pieces"):
        read(tmp_path, text)  # they do not hang together
    moved = text.replace("L-2, PART=LEG\n0, 0, 0", "L-2, PART=LEG\n2, 0, 0")
    (tmp_path / "frame.inp").write_text(moved)
    options = {key: field.default for key, field in BeamOptions.fields.items()}
    options |= {"name": "frame", "point_masses": (), "theory": None}
    arrays = deck_frame(tmp_path / "frame.inp", Units.read("SI"), options)
    np.testing.assert_allclose(arrays.nodes[3:], [[0, 2, 0], [0, 3, 0], [0, 4, 0]], atol=1e-12)
    # x of the leg becomes y, its n1 z, and its axis 2 (z) x
    np.testing.assert_allclose(arrays.orientations[2:], [[1, 0, 0]] * 2, atol=1e-12)
    np.testing.assert_allclose(arrays.orientations[:2], [[0, 0, 1]] * 2, atol=1e-12)
    assert arrays.node_sets["L-2.FOOT"] == arrays.node_sets["n11"] == [3]


def test_what_is_replaced_or_left_out_is_named(tmp_path: Path) -> None:
    text = line((1, 0, 0)) + section("RECT", "0.02, 0.06", "0, 1, 0") + MATERIAL
    text += "*ELEMENT, TYPE=T3D2, ELSET=ROD\n50, 1, 9\n*RELEASE\n1, S1, M1\n*MPC\nBEAM, 1, 9\n"
    with pytest.warns(JoustoWarning) as told:
        read(tmp_path, text)
    assert [str(item.message) for item in told] == [
        "frame.inp: 8 B31 read as beams that are exact between their nodes, with the shear"
        " coefficients of Cowper",
        "frame.inp: 1 T3D2 left out: a frame contains beams only; give trusses a *BEAM SECTION and"
        " the type B31",
        "frame.inp: *MPC not read: the nodes are not tied; tie them by an Interface of the part",
        "frame.inp: *RELEASE not read: left out of the part",
    ]


@READ
def test_supports_and_loads_of_the_deck_are_named_with_their_lines(tmp_path: Path) -> None:
    text = line((1, 0, 0)) + section("RECT", "0.02, 0.06", "0, 1, 0") + MATERIAL
    text += "*BOUNDARY\n1, 1, 6\n*STEP\n*STATIC\n*CLOAD\n9, 2, 5.\n*NODE FILE\nU\n*END STEP\n"
    text += "*STEP\n*STATIC\n*CLOAD\n9, 3, 5.\n*DLOAD\nBEAM, GRAV, 9.81, 0, 0, -1\n*END STEP\n"
    with pytest.warns(JoustoWarning) as told:
        read(tmp_path, text)
    lines = (tmp_path / "frame.inp").read_text().splitlines()
    at = {word: [i for i, row in enumerate(lines, 1) if row == word] for word in lines}
    held, (first, second), weight = at["*BOUNDARY"][0], at["*CLOAD"], at["*DLOAD"][0]
    assert [str(item.message) for item in told][-1] == (
        f"frame.inp: *BOUNDARY (line {held}), *CLOAD (lines {first}, {second}), *DLOAD (line"
        f" {weight}) ignored: declare supports and loads as joints and forces in"
        " the model file"
    )
    assert sum("ignored: declare" in str(item.message) for item in told) == 1


GOOD = line((1, 0, 0)) + section("RECT", "0.02, 0.06", "0, 1, 0") + MATERIAL


@READ
@pytest.mark.parametrize(
    ("found", "instead", "sentence"),
    [
        ("SECTION=RECT", "SECTION=L", "SECTION=L is not supported; use RECT, CIRC, PIPE, BOX or I"),
        ("0.02, 0.06", "0.02", r"SECTION=RECT has 1 numbers, must be 2"),
        ("0.02, 0.06", "-0.02, 0.06", r"width is -0.02 m, must be a positive"),
        ("0.02, 0.06", "x, 0.06", "'x, 0.06' are not numbers"),
        ("0, 1, 0\n", "1, 0, 0\n", r"element 1, 2, .*: n1 is parallel to the beam"),
        ("0, 1, 0\n", "1, 0\n", "its axis n1 has 2 numbers, must be 3"),
        ("MATERIAL=steel", "MATERIAL=iron", r"there is no \*MATERIAL, NAME=iron; known: STEEL"),
        ("ELSET=BEAM, MATERIAL", "ELSET=REST, MATERIAL", r"element 1, 2, .* has no \*BEAM SECTION"),
        ("*ELASTIC", "*ELASTIC, TYPE=ORTHOTROPIC", "beams need an isotropic material"),
        ("*ELASTIC", "*PLASTIC", "material 'Steel' has no .ELASTIC below it"),
        ("TYPE=B31", "TYPE=T3D2", r"has no beams \(B31, B32, B33\); it has T3D2 \(8\)"),
        ("TYPE=B31", "TYPE=FRAME3D", "FRAME3D is not supported; use B31, B32 or B33"),
        ("SECTION=RECT,", "SECTION=RECT, OFFSET1=0.5,", "OFFSET1 is not supported"),
        ("SECTION=RECT", "SECTION=I", "SECTION=I has 2 numbers, must be 7"),
    ],
)
def test_wrong_decks_of_beams_are_refused(
    tmp_path: Path, found: str, instead: str, sentence: str
) -> None:
    assert found in GOOD
    with pytest.raises(InputError, match=sentence):
        read(tmp_path, GOOD.replace(found, instead))


def test_a_part_of_solids_names_what_can_be_done_with_beams_and_shells(tmp_path: Path) -> None:
    (tmp_path / "frame.inp").write_text(GOOD)
    with pytest.raises(InputError, match=r"it has line only; beams .* Part.from_deck"):
        jo.Part.solid(jo.read_mesh(tmp_path / "frame.inp"), STEEL)
    shell = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,1,1,0\n*ELEMENT, TYPE=S4R\n1,1,2,4,3\n"
    (tmp_path / "plate.inp").write_text(shell)
    with pytest.raises(InputError, match=r"it has quad only; shells .* Part.from_file"):
        jo.Part.solid(jo.read_mesh(tmp_path / "plate.inp"), STEEL)
    with pytest.raises(InputError, match=r"has no beams \(B31, B32, B33\); it has S4R \(1\)"):
        jo.Part.from_deck(tmp_path / "plate.inp")


@needed
@READ
@pytest.mark.parametrize(
    ("shape", "sizes", "least"),
    # the clamped section of ccx cannot contract; the two bending frequencies of its pipe, which are
    # one in truth, differ by 1.1 %
    [("RECT", "0.06, 0.1", 0.006), ("PIPE", "0.05, 0.01", 0.015)],
)
def test_frequencies_beside_calculix(tmp_path: Path, shape: str, sizes: str, least: float) -> None:
    # ccx expands beams to bricks of 20 nodes
    text = line(UNIT, n=16, etype="B32") + section(shape, sizes, "0, 1, 0.5") + MATERIAL
    text = text.replace("TYPE=B32,", "TYPE=B32R,") if shape == "PIPE" else text
    steps = "*BOUNDARY\n1, 1, 6\n*STEP\n*FREQUENCY\n4\n*END STEP"
    found = run([*text.splitlines(), *steps.splitlines()], ("dat",))["dat"]
    ours = cantilever_modes(read(tmp_path, text), 4)[0]
    np.testing.assert_allclose(ours, _frequencies(found)[:4], rtol=least)
