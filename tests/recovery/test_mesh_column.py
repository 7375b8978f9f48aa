"""The error of the mesh beside every hot spot: that of the elements around it, at that instant."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from jousto.parts.solids.stress import SolidStress
from output.runs import swing
from parts.grids import grid
from verification.boxes import block
from verification.solids import solid


def bar(modes: int = 6) -> tuple[jo.Part, jo.ReducedPart]:
    """A short bar of solids, so coarse that elements disagree."""
    part = jo.Part.solid(grid("hexahedron20", (6, 2, 2), (0.3, 0.04, 0.03)), jo.material("S355"))
    return part, jo.reduce(part, jo.FreeFree(modes=modes))


@pytest.mark.parametrize("modes", [6, 16])
def test_shapes_add_up_to_the_error_of_a_field(modes: int) -> None:
    part, reduced = bar(modes)
    assert reduced.stress is not None and reduced.stress.scatter is not None
    X = reduced.modes[: len(part.nodes)].reshape(-1, modes)
    for seed in range(3):
        # as a load gives them: large where they are slow
        p = np.random.default_rng(seed).normal(size=modes) / reduced.stiffness
        exact = jo.parts.place_errors(part, X @ p)[:, 0]
        found = np.linalg.norm(reduced.stress.scatter @ p, axis=1)
        if modes <= 6:  # nothing is left out; seven digits are kept
            np.testing.assert_allclose(found, exact, rtol=1e-4, atol=1e-5 * exact.max())
        else:
            assert np.all(found <= (1.0 + 1e-4) * exact + 1e-5 * exact.max())
            assert np.all(found >= 0.7 * exact - 1e-5 * exact.max())


def test_it_follows_the_modes(tmp_path: Path) -> None:
    part, reduced = bar()
    p = np.random.default_rng(1).normal(size=6)
    place = 7
    assert reduced.stress is not None
    full = reduced.stress.mesh_error(place, p)
    assert full > 0.0
    kept = reduced.keep([4, 1]).stress
    q = np.zeros(6)
    q[[4, 1]] = p[:2]
    assert kept is not None
    assert kept.mesh_error(place, p[:2]) == pytest.approx(reduced.stress.mesh_error(place, q))
    few = reduced.stress.select(np.array([3, place]))
    assert few.mesh_error(1, p) == pytest.approx(full)
    reduced.save(tmp_path / "bar.h5")
    again = jo.ReducedPart.load(tmp_path / "bar.h5").stress
    assert again is not None and again.mesh_error(place, p) == full
    # other modes of the same motion
    V = np.random.default_rng(2).normal(size=(6, 6))
    turned = reduced.stress.combined(V)
    assert turned.mesh_error(place, np.linalg.solve(V, p)) == pytest.approx(full, rel=1e-9)


def hit(path: Path) -> tuple[jo.Part, jo.ReducedPart, jo.Solution]:
    """A bar of solids, clamped, under a load at its end that grows."""
    coarse = block("hexahedron20", (0.3, 0.04, 0.02), (6, 1, 1))
    root = np.flatnonzero(coarse.nodes[:, 0] < 1e-9)
    end = int(np.argmax(coarse.nodes @ [1.0, 1.0, 1.0]))
    part = solid(coarse, jo.material("S355"), {"end": [end]})
    part = part.with_interfaces(jo.Interface("clamp", root))
    reduced = jo.reduce(part, jo.CraigBampton(("clamp",), modes=8))
    body = jo.FlexibleBody("bar", reduced)
    load = jo.Force("load", body["end"], (0.0, 100.0, 200.0), signal=jo.SCurve([0.0, 2e-3], [0, 1]))
    fixed = jo.Fixed("root", jo.ground.at(part.ties[0].at), body["clamp"])
    model = jo.compile(jo.Mechanism(body, fixed, load))
    run = jo.simulate(model, 2e-3, solver=jo.ROS2(2e-5), output_step=1e-4, path=path)
    return part, reduced, run


def test_a_hot_spot_has_the_error_of_its_mesh(tmp_path: Path) -> None:
    part, reduced, run = hit(tmp_path / "run.h5")
    found = jo.hot_spots(jo.load(run.path), count=3)
    field = jo.stress_field(run, "bar")
    X = reduced.modes[: len(part.nodes)].reshape(-1, reduced.n)
    sites = SolidStress.everywhere(part.solids)
    for spot in found:
        p = field.p[int(np.searchsorted(field.time, spot.time))]
        exact = jo.parts.place_errors(part, X @ p)[sites.index(spot.site), 0]
        assert 0.9 * exact <= spot.mesh <= exact * (1.0 + 1e-4)
    budget = jo.recovery.error_budget(found)
    assert budget.terms["mesh"] == found[0].mesh
    by_part = jo.recovery.error_budget(found, part=(part, reduced))
    assert by_part.terms["mesh"] == pytest.approx(found[0].mesh, rel=0.1)
    assert budget.unknown == ("modes", "step")
    head, first = found.table()[:2]
    column = head.index("mesh")
    assert float(first[column].removeprefix("+-")) == pytest.approx(1e-6 * found[0].mesh, rel=0.1)
    assert "error of the mesh (+-): difference between the elements around" in str(found)
    rows = (found.to_csv(tmp_path / "spots.csv")).read_text("utf-8").splitlines()
    assert rows[0].split(",")[-1] == "mesh error (Pa)"
    assert float(rows[1].split(",")[-1]) == pytest.approx(found[0].mesh)
    # the commands print it
    code, text = call("peaks", run.path)
    assert code == 0 and "error budget of 'bar'" in text and re.search(r"[:,] mesh [\d.]+ %", text)
    code, text = call("stress", run.path, "bar")
    assert code == 0 and "error budget of 'bar'" in text and re.search(r"[:,] mesh [\d.]+ %", text)
    code, text = call("stress", run.path, "--frame", "world", "--criterion", "s11")
    assert code == 0 and "jousto hotspots gives the error budget" in text


def test_where_it_is_not_known_it_says_so() -> None:
    """Beams have no mesh of solids; strain has another unit."""
    found = jo.hot_spots(swing(), count=2)
    assert np.isnan(found[0].mesh) and found.table()[1][found.table()[0].index("mesh")] == "-"
    assert "error of the mesh: not known for 'arm': the part has no mesh" in str(found)
    assert "mesh" in jo.recovery.error_budget(found).unknown
    code, text = call("stress", swing().path)
    assert (
        code == 0 and "not known: modes, step, mesh" in text and "the part has no mesh of" in text
    )
    strain = jo.hot_spots(jo.stress_field(swing(), "arm", strain=True), count=1)
    assert np.isnan(strain[0].mesh) and "not known for strain" in str(strain)
