"""Reduced parts for other programs: MBDyn's .fem, standard input data, VTU."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose

import jousto as jo
from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.part import Part
from jousto.sections.section import Tube

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
# point masses on nodes that do not lie on a line: integrals are sums over the nodes
FRAME = Part.frame(
    [(0, 0, 0), (0.3, 0, 0), (0.6, 0.1, 0), (0.9, 0.3, 0.1), (1.0, 0.6, 0.3)],
    [(0, 1), (1, 2), (2, 3), (3, 4)],
    sections=Tube(0.05, 0.004),
    materials=STEEL,
    lumped=True,
    rotary_inertia=False,
    node_sets={"foot": (0,), "tip": (4,)},
)
REDUCED = jo.reduce(FRAME, jo.CraigBampton(interfaces=("foot", "tip"), modes=3))
POINTS = FRAME.mass_points
assert POINTS is not None
MASS, U0, PHI = POINTS.mass, FRAME.nodes, REDUCED.modes
N = REDUCED.n


def skew(x: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


# -- MBDyn ------------------------------------------------------------------------------------


def read_fem(path: Path) -> dict[int, list[str]]:
    """Return the lines of numbers of each record."""
    records: dict[int, list[str]] = {}
    current: list[str] = []
    for line in path.read_text().splitlines():
        found = re.match(r"\*\* RECORD GROUP (\d+),", line)
        if found:
            current = records.setdefault(int(found.group(1)), [])
        elif not line.startswith("**"):
            current.append(line)
    return records


def numbers(lines: list[str]) -> np.ndarray:
    return np.array([[float(x) for x in line.split()] for line in lines])


def test_fem_file(tmp_path: Path) -> None:
    path = jo.write(REDUCED, tmp_path / "arm.fem", damping=0.02)
    records = read_fem(path)
    assert sorted(records) == [1, 2, 5, 6, 7, 8, 9, 10, 12, 13, 14, 15, 16, 17, 18]
    assert records[1][0].split() == ["REV0", "5", str(N), "0", "0", "0"]
    assert records[2] == ["foot node2 node3 node4 tip"]
    xyz = np.hstack([numbers(records[k]) for k in (5, 6, 7)])
    assert_allclose(xyz, U0, atol=1e-15)
    shapes = numbers(records[8]).reshape(N, 5, 6)
    assert REDUCED.rotations is not None
    assert_allclose(shapes[:, :, :3], PHI.transpose(2, 0, 1), rtol=1e-15)
    assert_allclose(shapes[:, :, 3:], REDUCED.rotations.transpose(2, 0, 1), rtol=1e-15)
    omega = 2.0 * np.pi * REDUCED.frequencies
    assert_allclose(numbers(records[9]), np.eye(N))
    assert_allclose(numbers(records[10]), np.diag(omega**2), rtol=1e-14)
    assert_allclose(numbers(records[13]), np.diag(0.04 * omega), rtol=1e-14)
    assert float(records[12][0]) == pytest.approx(FRAME.mass, rel=1e-14)
    assert_allclose(numbers(records[12][1:2])[0], FRAME.center, rtol=1e-12)
    assert_allclose(numbers(records[12][2:]), FRAME.inertia, rtol=1e-9, atol=1e-12)


def test_fem_invariants_are_sums_over_the_nodes(tmp_path: Path) -> None:
    # definitions of MBDyn's modal joint: its own sums over lumped masses (record 11)
    records = read_fem(jo.write(REDUCED, tmp_path / "arm.fem"))
    inv3, inv4 = np.zeros((3, N)), np.zeros((3, N))
    inv5, inv8, inv9 = np.zeros((3, N, N)), np.zeros((3, N, 3)), np.zeros((3, N, N, 3))
    for m, u, phi in zip(MASS, U0, PHI, strict=True):
        for j in range(N):
            inv3[:, j] += m * phi[:, j]
            inv4[:, j] += m * np.cross(u, phi[:, j])
            inv8[:, j] -= m * skew(u) @ skew(phi[:, j])
            for k in range(N):
                inv5[:, j, k] += m * np.cross(phi[:, j], phi[:, k])
                inv9[:, j, k] += m * skew(phi[:, j]) @ skew(phi[:, k])
    for number, expected in ((14, inv3), (15, inv4), (16, inv8), (17, inv5), (18, inv9)):
        found = numbers(records[number])
        # terms of the sums, which may cancel
        size = float(np.sum(MASS)) * max(1.0, np.abs(U0).max(), np.abs(PHI).max()) ** 2
        assert_allclose(found, expected.reshape(3, -1), atol=1e-13 * size, err_msg=str(number))
    few = read_fem(jo.write(REDUCED, tmp_path / "few.fem", invariants=False, nodes=["tip"]))
    assert max(few) == 12 and few[2] == ["tip"] and len(few[8]) == N


# -- standard input data ----------------------------------------------------------------------


def read_sid(path: Path) -> tuple[dict[str, dict[str, np.ndarray]], list[dict[str, Any]]]:
    """Return M0 and M1 of the body's matrices and those of each node."""
    body: dict[str, Any] = {}
    nodes: list[dict[str, Any]] = []
    target, block, head = body, "", {}
    for line in path.read_text().replace("D+", "E+").replace("D-", "E-").splitlines()[1:]:
        words = line.split()
        if words[:2] == ["new", "node"]:
            nodes.append({})
            target = nodes[-1]
        elif words[:2] == ["end", "frame"]:
            target = body
        elif len(words) == 1 and words[0] not in ("part", "refmod", "frame"):
            block, head = words[0], {}
        elif words[0] in ("order", "nrow", "ncol", "nq", "nqn", "structure"):
            head[words[0]] = int(words[-1])
            if words[0] == "structure":
                M0 = np.zeros((head["nrow"], head["ncol"]))
                M1 = np.zeros((head["nrow"], head["ncol"], head["nq"]))
                target[block] = {"M0": M0, "M1": M1, "head": dict(head)}
        elif words[0].startswith(("m0(", "m1(")):
            inside = line[line.index("(") + 1 : line.index(")")]
            indices = [int(x) - 1 for x in inside.split(",")]
            value = float(words[-1])
            if len(indices) == 2:
                target[block]["M0"][tuple(indices)] = value
                if head["structure"] == 2:
                    target[block]["M0"][tuple(indices[::-1])] = value
            else:
                # rows, coordinate, columns
                target[block]["M1"][indices[0], indices[2], indices[1]] = value
    return body, nodes


def at(taylor: dict[str, np.ndarray], q: np.ndarray) -> np.ndarray:
    M1 = taylor["M1"]
    return np.asarray(taylor["M0"] + (M1 @ q if M1.shape[2] else 0.0))


def test_sid_gives_the_inertia_forces_of_the_particles(tmp_path: Path) -> None:
    path = jo.write(REDUCED, tmp_path / "arm.SID_FEM", damping=0.01)
    body, nodes = read_sid(path)
    rng = np.random.default_rng(3)
    q, v, w = 0.01 * rng.normal(size=N), rng.normal(size=N), rng.normal(size=3)
    u, du = U0 + PHI @ q, PHI @ v
    assert_allclose(at(body["mdCM"], q)[:, 0], MASS @ u, rtol=1e-12)
    # sums over particles of what is up to mass times size
    round_off = 1e-12 * float(np.sum(MASS)) * max(np.abs(U0).max(), np.abs(PHI).max()) ** 2
    assert_allclose(at(body["Ct"], q), np.einsum("k,kan->na", MASS, PHI), atol=round_off)
    coupling = np.einsum("k,kab,kbn->na", MASS, np.array([skew(x) for x in u]), PHI)
    assert_allclose(at(body["Cr"], q), coupling, atol=round_off)
    assert_allclose(at(body["Me"], q), np.eye(N), atol=1e-9)
    # J to first order
    full = sum(m * skew(x).T @ skew(x) for m, x in zip(MASS, u, strict=True))
    second = sum(m * skew(p @ q).T @ skew(p @ q) for m, p in zip(MASS, PHI, strict=True))
    assert_allclose(at(body["J"], q), full - second, atol=round_off)
    # forces of spin and vibration on the modes and on the body
    Omega = np.array([w[a] * w[b] for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))])
    acceleration = np.cross(w, np.cross(w, u)) + 2.0 * np.cross(w, du)
    Ge = at(body["Ge"], q).reshape(N, N, 3)
    on_modes = -at(body["Oe"], q) @ Omega - np.einsum("ija,j,a->i", Ge, v, w)
    assert_allclose(on_modes, -np.einsum("k,kan,ka->n", MASS, PHI, acceleration), atol=1e-10)
    Gr = at(body["Gr"], q).reshape(3, N, 3)
    moment = -np.einsum("k,ka->a", MASS, np.cross(u, 2.0 * np.cross(w, du)))
    assert_allclose(-np.einsum("ajb,j,b->a", Gr, v, w), moment, atol=1e-10)
    omega = 2.0 * np.pi * REDUCED.frequencies
    assert_allclose(body["Ke"]["M0"], np.diag(omega**2), rtol=1e-13)
    assert_allclose(body["De"]["M0"], np.diag(0.02 * omega), rtol=1e-13)
    # nodes: positions, shapes and turns
    assert len(nodes) == 5 and REDUCED.rotations is not None
    for i, node in enumerate(nodes):
        assert_allclose(at(node["origin"], q)[:, 0], u[i], rtol=1e-13)
        assert_allclose(node["phi"]["M0"], PHI[i], rtol=1e-13)
        assert_allclose(node["psi"]["M0"], REDUCED.rotations[i], rtol=1e-13)
        assert_allclose(at(node["AP"], q), np.eye(3) + skew(REDUCED.rotations[i] @ q), atol=1e-13)


def test_sid_with_stiffening(tmp_path: Path) -> None:
    # the slowest bending of a rotor stiffens: the centrifugal matrix takes w^2 int u0~T chi~ dm
    blade = Part.beam(1.0, Tube(0.02, 0.002), 8, STEEL)
    stiff = jo.reduce(blade, jo.CraigBampton(interfaces=("start",), modes=2), stiffening=True)
    soft = jo.reduce(blade, jo.CraigBampton(interfaces=("start",), modes=2))
    Oe, plain = (
        read_sid(jo.write(part, tmp_path / "blade.sid"))[0]["Oe"]["M1"] for part in (stiff, soft)
    )
    # spin about z: bending in the plane y gets stiffer by the second moment of chi along x
    assert stiff.stiffening is not None
    extra = -stiff.stiffening.second_moment
    assert_allclose((Oe - plain)[:, 2], extra[..., 0, 0] + extra[..., 1, 1], atol=1e-9)
    assert np.all(np.diag((Oe - plain)[:, 2]) > 0.1)


# -- VTU --------------------------------------------------------------------------------------


def test_vtu(tmp_path: Path) -> None:
    path = jo.write(REDUCED, tmp_path / "arm.vtu")
    mesh = meshio.read(path)
    assert_allclose(mesh.points, U0, rtol=1e-15)
    assert mesh.cells[0].type == "line" and len(mesh.cells[0].data) == 4
    names = list(mesh.point_data)
    assert len(names) == N and names[0] == f"mode 1, {REDUCED.frequencies[0]:.5g} Hz"
    for j, name in enumerate(names):
        assert_allclose(mesh.point_data[name], PHI[:, :, j], rtol=1e-15)


def test_vtu_with_stress_of_a_solid(tmp_path: Path) -> None:
    mesh = jo.read_mesh(Path(__file__).parent.parent / "parts" / "files" / "brick.inp")
    solid = jo.reduce(Part.solid(mesh, STEEL), jo.FreeFree(modes=1))
    assert solid.stress is not None
    found = meshio.read(jo.write(solid, tmp_path / "brick.vtu"))
    assert found.cells[0].type == "triangle"
    # xx yy zz xy yz xz at the nodes, in the order of the nodes
    stress = found.point_data["stress 1"]
    number = {f"n{number}": i for i, number in enumerate(mesh.node_ids)}
    place = [number[label] for label in solid.stress.labels]
    scale = np.abs(stress).max()
    assert_allclose(stress[place], solid.stress.modes[:, :, 0], atol=1e-12 * scale)
    # the same stress told in other axes is the same field
    R = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    s = solid.stress.modes[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]], 0]
    local = np.einsum("ia,sij,jb->sab", R, s, R)
    modes = local[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]][:, :, None]
    axes = np.broadcast_to(R, (len(s), 3, 3))
    turned = replace(solid, stress=replace(solid.stress, axes=axes, modes=modes))
    again = meshio.read(jo.write(turned, tmp_path / "turned.vtu"))
    assert_allclose(again.point_data["stress 1"], stress, atol=1e-9 * scale)
    plain = meshio.read(jo.write(solid, tmp_path / "plain.vtu", stress=False))
    assert len(plain.point_data) == 1


def test_vtu_with_stress_of_two_materials(tmp_path: Path) -> None:
    """At their border stress jumps: the file has the mean of both sides."""
    cells = jo.mesh.Cells("hexahedron", [(0, 1, 4, 3, 6, 7, 10, 9), (1, 2, 5, 4, 7, 8, 11, 10)])
    nodes = [(x, y, z) for z in (0.0, 0.07) for y in (0.0, 0.1) for x in (0.0, 0.1, 0.2)]
    mesh = jo.Mesh("bar", nodes, cells, element_sets={"a": [0], "b": [1]})
    soft = Material(E=70e9, nu=0.3, rho=2700.0)
    part = Part.solid(mesh, {"a": STEEL, "b": soft})
    reduced = jo.reduce(part, jo.FreeFree(modes=2))
    known = reduced.stress
    assert known is not None and len(known.labels) == 16
    stress = meshio.read(jo.write(reduced, tmp_path / "bar.vtu")).point_data["stress 2"]
    row = {label: known.modes[i, :, 1] for i, label in enumerate(known.labels)}
    assert_allclose(stress[0], row["n1"], rtol=1e-12)
    assert np.abs(row["n2.a"] - row["n2.b"]).max() > 0.1 * np.abs(row["n2.a"]).max()
    assert_allclose(stress[1], 0.5 * (row["n2.a"] + row["n2.b"]), rtol=1e-12)


# -- what is refused --------------------------------------------------------------------------


def test_refusals(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no node set 'tpi'; did you mean 'tip'"):
        jo.write(REDUCED, tmp_path / "a.fem", nodes=["tpi"])
    with pytest.raises(InputError, match="no node 9, must be 0..4"):
        jo.write(REDUCED, tmp_path / "a.sid", nodes=[9])
    with pytest.raises(InputError, match="damping is -0.1, must be one ratio or"):
        jo.write(REDUCED, tmp_path / "a.sid", damping=-0.1)
    with pytest.raises(
        InputError, match="not a format to write here; known: .fem, .sid, .sid_fem, .vtu"
    ):
        jo.write(REDUCED, tmp_path / "a.vtk")
    with pytest.raises(InputError, match="cannot be written: the folder .* does not exist"):
        jo.write(REDUCED, tmp_path / "none" / "a.fem")
