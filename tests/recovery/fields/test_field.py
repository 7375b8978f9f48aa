"""Stress fields from results alone: places, frames, blocks."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.recovery.fields.criteria import criteria, evaluate
from jousto.recovery.shape import positions
from jousto.reduction.fields.stress import StressModes

L, B, H = 1.0, 0.03, 0.045  # m
TILT = jo.Rotate((1, 2, 3), degrees=40.0)


@pytest.fixture(scope="module")
def reduced() -> jo.ReducedPart:
    part = jo.Part.beam(L, jo.Rectangle(B, H), 4, jo.Material(210e9, 0.3, 7850.0))
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))


@pytest.fixture(scope="module")
def run(reduced: jo.ReducedPart, tmp_path_factory: pytest.TempPathFactory) -> jo.Solution:
    """A tilted pendulum."""
    body = jo.FlexibleBody("beam", reduced, damping=0.02, orientation=TILT)
    model = jo.compile(
        jo.Mechanism(
            body,
            jo.Spherical("pivot", jo.ground["origin"], body["start"]),
            jo.Gravity((0, 0, -9.81)),
            jo.StressSensor("all", body),
        )
    )
    path = tmp_path_factory.mktemp("run") / "run.h5"
    return jo.simulate(model, 0.2, solver=jo.ROS2(1e-3), output_step=0.005, path=path)


def test_results_alone_give_what_the_sensor_measured(run: jo.Solution) -> None:
    field = jo.stress_field(run, "beam")
    assert (field.ns, field.nt) == (len(field.labels), run.nt)
    s = field.history(slice(None))
    scale = np.abs(s).max()
    np.testing.assert_allclose(s.reshape(run.nt, -1), run["all"], atol=1e-13 * scale)


def test_planes_that_print_alike_are_two_criteria() -> None:
    rng = np.random.default_rng(0)
    axes = np.broadcast_to(np.eye(3), (3, 3, 3))
    modes = StressModes(("a", "b", "c"), np.eye(3), axes, 1e8 * rng.normal(size=(3, 6, 2)))
    one, other = jo.recovery.Plane((1, 0.40000004, 0)), jo.recovery.Plane((1, 0.40000001, 0))
    assert str(one) == str(other)
    field = jo.recovery.field_from(modes, rng.normal(size=(5, 2)), np.arange(5.0))
    s = field.history(slice(None))
    for plane in (one, other):
        np.testing.assert_allclose(field.values(plane), evaluate(s, plane), rtol=1e-11)


def test_matrices_that_are_no_rotations_are_refused() -> None:
    axes = np.broadcast_to(np.eye(3), (3, 3, 3))
    modes = StressModes(("a", "b", "c"), np.eye(3), axes, np.ones((3, 6, 1)))
    p, time = np.ones((4, 1)), np.arange(4.0)
    for wrong, found in ((2.0 * np.eye(3), "differs from I by 3"), (-np.eye(3), "det A is -1")):
        A = np.tile(np.eye(3), (4, 1, 1))
        A[2:] = wrong
        with pytest.raises(
            jo.InputError, match=rf"not a rotation at 2 s, index 2: .*{found} \(2 of 4"
        ):
            jo.recovery.field_from(modes, p, time, A=A)


def test_places_by_label_node_and_set(run: jo.Solution, reduced: jo.ReducedPart) -> None:
    field = jo.stress_field(run, "beam")
    assert field.history("e2.a.top").shape == (run.nt, 6)
    # node 1 lies between elements 1 and 2
    at_node = [field.labels[i] for i in field.indices(1)]
    assert at_node and all(x.startswith(("e1.b.", "e2.a.")) for x in at_node)
    assert np.array_equal(field.indices("end"), field.indices(4))
    assert np.array_equal(field.indices(["start", "e2.a.top"])[-1:], field.indices("e2.a.top"))
    some = field.only(["e2.a.top", "e1.a.left"])
    assert some.labels == ("e2.a.top", "e1.a.left")
    assert jo.stress_field(run, "beam", sites=("e2.a.top", "e1.a.left")).labels == some.labels
    np.testing.assert_array_equal(
        some.history("e1.a.left", slice(3))[:, None], field.history(["e1.a.left"], slice(3))
    )
    with pytest.raises(jo.InputError) as problems:
        field.indices(["e2.a.tob", 77, 1.5])
    text = str(problems.value)
    assert (
        "did you mean 'e2.a.top'" in text and "node 77" in text and "site is 1.5, must be" in text
    )


def test_world_frame(run: jo.Solution) -> None:
    body, world = (jo.stress_field(run, "beam", frame=f) for f in ("body", "world"))
    assert world.A is not None
    # this beam lies along x with its height along z
    site = jo.stress_field(run, "beam").history(slice(None))
    np.testing.assert_allclose(body.history(slice(None)), site, atol=1e-12 * abs(site).max())
    # the rotation is that of the nodes of the body
    x = positions(run, "beam", scale=0.0)
    along = (x[:, 4] - x[:, 0]) / L
    np.testing.assert_allclose(world.A[:, :, 0], along, atol=1e-12)
    name, k = "e1.b.top", 17
    s = body.history(name)[k]
    T = np.array([[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]])
    w = world.history(name)[k]
    W = np.array([[w[0], w[3], w[5]], [w[3], w[1], w[4]], [w[5], w[4], w[2]]])
    np.testing.assert_allclose(W, world.A[k] @ T @ world.A[k].T, atol=1e-9 * abs(T).max())
    # the normal stress across the moving section is the same number in both
    axis = world.A[k, :, 0]
    across = world.values(jo.recovery.Plane(axis), name, slice(k, k + 1))[0, 0]
    assert across == pytest.approx(body.values("s11", name)[k, 0], rel=1e-10)
    # invariants know no frame
    for criterion in ("von-mises", "principal-1", "max-shear"):
        np.testing.assert_allclose(world.values(criterion), body.values(criterion), rtol=1e-7)


def test_strain_is_hookes(run: jo.Solution) -> None:
    s = jo.stress_field(run, "beam").history("e1.b.top")
    e = jo.stress_field(run, "beam", strain=True).history("e1.b.top")
    np.testing.assert_allclose(e[:, 0], s[:, 0] / 210e9, rtol=1e-9)
    np.testing.assert_allclose(e[:, 1], -0.3 * s[:, 0] / 210e9, rtol=1e-9)
    np.testing.assert_allclose(e[:, 5], s[:, 5] / (210e9 / 2.6), rtol=1e-9)


@pytest.mark.parametrize("strain", [False, True])
def test_blocks_cover_everything_once(run: jo.Solution, strain: bool) -> None:
    field = jo.stress_field(run, "beam", frame="world", strain=strain)
    s = field.history(slice(None))
    for criterion in criteria(strain):
        whole = field.values(criterion)
        expected = evaluate(s, criterion, strain)
        np.testing.assert_allclose(whole, expected, atol=1e-12 * np.abs(s).max())
    for along in ("time", "sites"):
        for memory in (8, 3000, 1 << 20):
            seen, times = np.zeros(whole.shape), []
            blocks = field.blocks("e11" if strain else "s11", memory=memory, along=along)
            for t, s, values in blocks:
                assert values.shape == seen[t, s].shape
                seen[t, s] += values
                times.append((s.start, t.start) if along == "time" else (t.start, s.start))
            assert times == sorted(times)
            np.testing.assert_allclose(seen, field.values("e11" if strain else "s11"), atol=1e-9)


def test_envelope(run: jo.Solution) -> None:
    field = jo.stress_field(run, "beam", start=0.05, end=0.15)
    assert field.time[[0, -1]] == pytest.approx([0.05, 0.15])
    values = field.values("signed-von-mises")
    found = field.envelope("signed-von-mises")
    np.testing.assert_allclose(found.max, values.max(axis=0), rtol=1e-12)
    np.testing.assert_allclose(found.min, values.min(axis=0), rtol=1e-12)
    np.testing.assert_array_equal(found.max_time, field.time[values.argmax(axis=0)])
    np.testing.assert_array_equal(found.min_time, field.time[values.argmin(axis=0)])
    assert "MPa" in str(found)


def test_values_refuse_what_does_not_fit(run: jo.Solution) -> None:
    field = jo.stress_field(run, "beam")
    with pytest.raises(jo.InputError, match=r"need .* GB, more than memory=.*blocks\(\)"):
        field.values("von-mises", memory=1000)
    with pytest.raises(jo.InputError, match="'von-mises'"):
        field.values("von-misses")
    with pytest.raises(jo.InputError, match="not a criterion of stress.*strain=True"):
        field.values("g12")
    with pytest.raises(jo.InputError, match="outside the run"):
        field.at(7.0)
    with pytest.raises(jo.InputError, match="no instant from 3 to"):
        jo.stress_field(run, "beam", start=3.0)


def test_older_results_are_read(run: jo.Solution, tmp_path: Path) -> None:
    path = tmp_path / "old.h5"
    path.write_bytes(run.path.read_bytes())
    modes = run.stress_modes("beam")
    assert modes is not None
    with h5py.File(path, "r+") as file:
        group = file["bodies/beam"]
        del group["stress"]
        group["stress_nodes"] = np.array([1, 3])
        group["stress_modes"] = modes.modes[[5, 9]].astype(np.float32)
    old = jo.stress_field(jo.load(path), "beam")
    assert old.labels == ("node2", "node4")
    now = jo.stress_field(run, "beam").history(slice(9, 10))[:, 0]
    # modes of single precision
    np.testing.assert_allclose(old.history("node4"), now, rtol=0, atol=1e-6 * np.abs(now).max())


def test_fields_from_elsewhere(reduced: jo.ReducedPart, rng: np.random.Generator) -> None:
    assert reduced.stress is not None
    p = rng.normal(size=(5, reduced.n))
    field = jo.recovery.field_from(reduced.stress, p, np.arange(5.0))
    np.testing.assert_allclose(field.at(2.5), reduced.stress.modes @ (0.5 * (p[2] + p[3])))
    with pytest.raises(jo.InputError, match="time must increase, but does not after 1 s"):
        jo.recovery.field_from(reduced.stress, p, [0, 1, 1, 2, 3])
    with pytest.raises(jo.InputError, match="material of its sites is not known"):
        bare = StressModes(
            reduced.stress.labels,
            reduced.stress.positions,
            reduced.stress.axes,
            reduced.stress.modes,
        )
        jo.recovery.field_from(bare, p, np.arange(5.0), strain=True)


def test_the_part_gives_the_same(run: jo.Solution, reduced: jo.ReducedPart) -> None:
    field = jo.stress_field(run, "beam", reduced=reduced)
    np.testing.assert_array_equal(field.S, jo.stress_field(run, "beam").S)
    known = jo.stress_field(run, "beam")
    np.testing.assert_array_equal(field.history(slice(None)), known.history(slice(None)))


def test_strain_of_an_orthotropic_solid() -> None:
    """Strain from stress by the compliance is the strain of the displacements themselves."""
    wood = jo.materials.Orthotropic(
        E1=11e9, E2=0.9e9, E3=0.5e9, nu12=0.37, nu13=0.42, nu23=0.47, G12=0.75e9, G13=0.72e9,
        G23=0.04e9, rho=450.0,
    )  # fmt: skip
    x, y, z = np.meshgrid([0, 0.1, 0.2], [0, 0.05], [0, 0.05], indexing="ij")
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    cells = [[4 * i + j for j in (0, 4, 6, 2, 1, 5, 7, 3)] for i in (0, 1)]
    part = jo.Part.solid(jo.Mesh("bar", points, jo.mesh.Cells("hexahedron", cells)), wood)
    reduced = jo.reduce(part, jo.FreeFree(modes=4))
    p = np.random.default_rng(1).normal(size=(3, 4))
    assert reduced.stress is not None and part.strain is not None
    field = jo.recovery.field_from(reduced.stress, p, np.arange(3.0), strain=True)
    u = reduced.modes.reshape(-1, 4) @ p.T
    expected = part.strain.evaluate(u)
    found = field.history(slice(None))
    np.testing.assert_allclose(
        found, np.moveaxis(expected, 2, 0), atol=1e-9 * np.abs(expected).max()
    )
