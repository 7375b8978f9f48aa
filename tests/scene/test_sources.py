"""Scenes of everything that can be seen: from memory, files, parts and modes; read in slices."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.scene import machine
from jousto.scene.make import make_scene
from jousto.scene.values_at_rows import points
from scene.machines import STEEL, ball, corner, everything, reduced

pytestmark = pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")


def equal(one: Any, other: Any, where: str = "scene") -> None:
    """Assert that two things of a scene are equal, field by field."""
    if dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            if field.name not in ("run", "motion"):
                values = getattr(one, field.name), getattr(other, field.name)
                equal(*values, f"{where}.{field.name}")
    elif isinstance(one, tuple):
        assert len(one) == len(other), where
        for k, pair in enumerate(zip(one, other, strict=True)):
            equal(*pair, f"{where}[{k}]")
    elif isinstance(one, np.ndarray):
        # Euler parameters and frames pass through quaternions of the file
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-15, err_msg=where)
    else:
        assert one == other, where


@pytest.fixture(scope="module")
def saved(tmp_path_factory) -> Path:
    run = jo.simulate(jo.compile(everything()), 2e-3, output_step=1e-3)
    return run.save(tmp_path_factory.mktemp("scene") / "everything.h5")


def test_a_file_alone_has_all_of_the_scene(saved):
    run = jo.simulate(jo.compile(everything()), 2e-3, output_step=1e-3)
    one, other = make_scene(run), make_scene(jo.load(saved))
    equal(one, other)
    for rows in (slice(None), slice(1, 2), slice(0, 3, 2)):
        np.testing.assert_array_equal(one.motion.rows(rows), other.motion.rows(rows))
    np.testing.assert_array_equal(one.motion.times, run.time)
    kinds = {body.name: body.kind for body in other.bodies}
    assert (kinds["arm"], kinds["rope"], kinds["wheel"]) == ("frame", "beam", "rigid")
    assert other.bodies[0].stress is not None


def test_a_machine_at_its_start_is_the_first_instant_of_its_run(saved):
    scene, run = make_scene(everything()), make_scene(jo.load(saved))
    equal(scene.bodies, run.bodies)
    equal(scene.symbols, run.symbols)
    np.testing.assert_allclose(scene.still, run.still, rtol=0, atol=1e-12 * abs(run.still).max())
    assert (scene.what, scene.motion) == ("model", None)


KINDS = ("hinge", "slide", "fixed", "rod", "spring", "damper", "actuator", "bushing")


def older(new: Path, old: Path) -> Path:
    """Write a results file as older versions did: without symbols, frames and masses of bodies.

    `/connections` had what joins two points: `names` and `kinds` (k,), the body (k, 2), -1 for the
    ground, and the place in its frame (k, 2, 3) of each point, and displacements (m, 3) in the
    modes of the bodies, those of all points behind one another, with their `ends` (k, 2).
    """
    old.write_bytes(new.read_bytes())
    with h5py.File(old, "r+") as file:
        arm = file["bodies/arm"]
        nodes, phi = arm["nodes"][()], np.moveaxis(arm["mode_shapes"][()], 2, 1)
        ground, none = np.zeros(3), np.zeros((0, 3))
        found = [  # name, kind, (body, place, modes) of either point
            ("hinge", "hinge", (-1, ground + (0, 0, 1), none), (0, nodes[0], phi[0])),
            ("slide", "slide", (-1, ground + (0, 2, 0), none), (1, ground, none)),
            ("spring", "spring", (0, nodes[-1], phi[-1]), (1, ground + (0.3, 0, 0), none)),
        ]
        sides = [side for *_, a, b in found for side in (a, b)]
        group = file.create_group("connections")
        group["names"] = np.array([name.encode() for name, *_ in found])
        group["kinds"] = np.array([KINDS.index(kind) for _, kind, *_ in found])
        group["bodies"] = np.array([body for body, *_ in sides]).reshape(-1, 2)
        group["points"] = np.array([x for _, x, _ in sides]).reshape(-1, 2, 3)
        group["modes"] = np.concatenate([modes for *_, modes in sides])
        group["ends"] = np.cumsum([len(modes) for *_, modes in sides]).reshape(-1, 2)
        del file["symbols"], arm["frame"]
        for body in file["bodies"].values():
            del body.attrs["mass"]
    return old


def test_files_of_older_versions_still_have_a_scene(saved, tmp_path):
    """They know no symbols, frames and masses: lines and what joins two points."""
    with h5py.File(saved) as file:
        assert "connections" not in file
    run = jo.load(older(saved, tmp_path / "old.h5"))
    scene, new = make_scene(run), make_scene(jo.load(saved))
    arm = scene.bodies[0]
    assert (arm.kind, arm.triangles, len(arm.lines), arm.mass) == ("frame", None, 4, None)
    np.testing.assert_allclose(scene.still, new.still, rtol=0, atol=1e-15)
    symbols = {one.name: one for one in scene.symbols if one.group != "ground"}
    assert {name: (one.kind, one.group, one.axis) for name, one in symbols.items()} == {
        "hinge": ("hinge", "joint", None),
        "slide": ("slide", "joint", None),
        "spring": ("spring", "force", None),
    }
    # the points move with the bodies and their deformation: there is a sensor at this one
    rows = scene.motion.rows(slice(None))
    assert np.ptp(run.q[:, 7:10], axis=0).max() > 1e-9
    end, root = symbols["spring"].sides[0], symbols["hinge"].sides[1]
    np.testing.assert_allclose(points(end, rows), run["position"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(points(root, rows), [[0, 0, 1]] * len(rows), rtol=0, atol=1e-9)
    supports = [one.sides[0].u for one in scene.symbols if one.group == "ground"]
    np.testing.assert_array_equal(supports, [[0, 0, 1], [0, 2, 0]])
    assert jo.still(run, tmp_path / "old.png", times=1).stat().st_size > 1000


@pytest.mark.parametrize("place", ["symbols/turns", "symbols/words", "bodies/arm/frame/phi"])
def test_a_damaged_file_is_a_sentence(saved, tmp_path, place):
    broken = tmp_path / "broken.h5"
    broken.write_bytes(saved.read_bytes())
    with h5py.File(broken, "r+") as file:
        del file[place]
    with pytest.raises(InputError, match=r"broken\.h5") as error:
        make_scene(jo.load(broken))
    assert place.rpartition("/")[2] in str(error.value)


@pytest.mark.parametrize("place", ["symbols/bodies", "symbols/nodes", "symbols/ends"])
@pytest.mark.parametrize("value", [-7, 9999])
def test_symbols_of_bodies_and_nodes_that_there_are_not(saved, tmp_path, place, value):
    broken = tmp_path / "broken.h5"
    broken.write_bytes(saved.read_bytes())
    spoil(broken, place, value)


@pytest.mark.parametrize("place", ["bodies", "kinds", "ends"])
def test_connections_of_older_versions_that_are_damaged(saved, tmp_path, place):
    spoil(older(saved, tmp_path / "old.h5"), f"connections/{place}", 99)


def spoil(path, place, value):
    """Set the numbers of a file to a value, and see it refused in a sentence."""
    with h5py.File(path, "r+") as file:
        file[place][...] = value
    with pytest.raises(InputError, match=rf"{path.name}: damaged: "):
        make_scene(jo.load(path))


def test_no_instant_is_a_sentence(tmp_path):
    model = jo.compile(jo.Mechanism(ball("one")))
    run = jo.simulate(model, 1.0, output_step=0.5)
    path = run.save(tmp_path / "run.h5")
    with h5py.File(path, "r+") as file:
        file["rows"][()] = 0
    with pytest.raises(InputError, match="contains no instant"):
        make_scene(jo.load(path))


def read_bytes() -> int:
    """Return how many bytes this process has read."""
    lines = Path("/proc/self/io").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("rchar:")).split()[1])


@pytest.mark.skipif(not Path("/proc/self/io").exists(), reason="the system counts no bytes")
def test_a_slice_does_not_read_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr(machine, "SAMPLED", 4 << 20)
    bodies = [ball(f"b{k}", (0, k, 0), angular_velocity=(0, 0, 1)) for k in range(20)]
    model = jo.compile(jo.Mechanism(*bodies))
    run = jo.simulate(model, 4.0, solver=jo.RK4(1e-4), output_step=1e-4)
    path = run.save(tmp_path / "long.h5")
    whole = path.stat().st_size
    assert whole > 60e6
    before = read_bytes()
    scene = make_scene(jo.load(path))
    opened = read_bytes() - before
    # times, and 1024 rows of q for each of four instants of the extent; each twice, since rows
    # are read after their checksums
    assert opened < 2 * 8 * (run.nt + 4 * 1024 * 140) + 3e6
    assert opened < whole / 4
    before = read_bytes()
    rows = scene.motion.rows(slice(30000, 30004))
    assert read_bytes() - before < 2 * 1024 * 8 * 140 + 1e6
    np.testing.assert_array_equal(rows, run.q[30000:30004])


def test_modes_of_a_part_move_its_vertices_by_a_tenth_of_its_size():
    part = corner()
    scene = make_scene(part)
    (body,) = scene.bodies
    size = np.ptp(scene.box, axis=0).max()
    assert [mode.frequency for mode in scene.modes] == part.frequencies.tolist()
    for j, mode in enumerate(scene.modes):
        moved = mode.amplitude * np.einsum("j,jvi->vi", mode.real[7:], body.shapes)
        assert np.linalg.norm(moved, axis=1).max() == pytest.approx(0.1 * size, rel=1e-12)
        np.testing.assert_array_equal(moved, mode.amplitude * body.shapes[j])
    assert [mark.name for mark in scene.markers] == ["foot", "head"]
    assert body.mass == pytest.approx(part.invariants.mass)


def test_modes_of_a_machine_are_those_of_its_shapes():
    """The change of the row moves nodes as ``shapes`` says, which is scaled to 1."""
    arm = jo.FlexibleBody(
        "arm", reduced(), position=(0.2, 0, 1), orientation=jo.Rotate((1, 2, 3), degrees=40)
    )
    hinge = jo.Revolute("hinge", jo.ground.at(arm["start"].r), arm["start"], (0, 1, 0))
    damper = jo.Spring("damper", hinge.angle, stiffness=50.0, damping=0.3)
    found = jo.modes(jo.compile(jo.Mechanism(arm, hinge, damper, jo.Gravity((0, 0, -9.81)))))
    scene = make_scene(found)
    assert [mode.frequency for mode in scene.modes] == found.frequencies.tolist()
    from jousto.recovery.shape import rotation_matrices

    x, phi = np.asarray(reduced().nodes), np.moveaxis(np.asarray(reduced().modes), 2, 0)

    def nodes(row):
        u = x + np.einsum("j,jvi->vi", row[7:], phi)
        return row[:3] + u @ rotation_matrices(row[3:7]).T

    h = 1e-6
    for j, mode in enumerate(scene.modes):
        parts = [mode.real, np.zeros_like(mode.real) if mode.imag is None else mode.imag]
        slopes = [
            (nodes(scene.still + h * d) - nodes(scene.still - h * d)) / (2 * h) for d in parts
        ]
        moved = slopes[0] + 1j * slopes[1]
        shape = found.shapes["arm"][j]
        top = np.unravel_index(np.abs(shape).argmax(), shape.shape)
        ratio = moved[top] / shape[top]
        np.testing.assert_allclose(moved, ratio * shape, rtol=0, atol=1e-7 * np.abs(moved).max())


def test_parts_and_meshes_stand_still():
    tube = jo.Part.beam(1.0, jo.Tube(0.05, 0.002), 4, STEEL, name="tube")
    scene = make_scene(tube)
    (body,) = scene.bodies
    assert (scene.what, body.place, body.shapes, len(scene.still)) == ("part", -1, None, 0)
    radius = np.linalg.norm(body.positions[:, 1:], axis=1)
    np.testing.assert_allclose(radius, 0.025, rtol=1e-12)
    assert body.mass == pytest.approx(tube.mass)
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    mesh = jo.Mesh("wedge", corners, jo.mesh.Cells("tetra", [(0, 1, 2, 3)]))
    (wedge,) = make_scene(mesh).bodies
    assert (wedge.kind, len(wedge.triangles), len(wedge.edges)) == ("mesh", 4, 6)


def test_reduced_parts_from_files_know_their_sections(tmp_path):
    reduced().save(tmp_path / "rod.h5")
    one, other = make_scene(reduced()), make_scene(jo.ReducedPart.load(tmp_path / "rod.h5"))
    equal(one.bodies, other.bodies)
    assert one.bodies[0].triangles is not None


def test_damage_lies_over_the_nodes_of_its_body(saved):
    run = jo.load(saved)
    sn = jo.SN(100e6, 1e6, 5.0, "elementary")
    field = jo.damage_field(jo.stress_field(run, "arm"), sn, residue="repeat")
    scene = make_scene(run, damage=field)
    arm = scene.bodies[0]
    for node in range(5):
        worst = field.damage[field.nodes == node].max()
        assert set(arm.damage[arm.nodes == node + 1]) == {worst}
        shortest = field.life[field.nodes == node].min()
        assert set(arm.life[arm.nodes == node + 1]) == {shortest}
    assert "damage" in scene.measures
    other = dataclasses.replace(field, body="leg")
    with pytest.raises(InputError, match="there is no body 'leg'"):
        make_scene(run, damage=other)


def test_what_cannot_be_seen_is_a_sentence():
    with pytest.raises(InputError, match="a float cannot be shown; give a Solution, Model"):
        make_scene(3.0)
