"""Structural hot-spot stress: extrapolation rules, and plates and stiffeners of solids."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from parts.grids import grid

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)


def test_linear_stress_is_met_and_a_singular_part_left_out() -> None:
    # s = a + b x: every linear reading gives a; the quadratic one also a + b x + c x^2
    a, b, c = 100.0, -30.0, 8.0
    from jousto.fatigue.welds.toes import READINGS

    for name, (places, weights) in READINGS.items():
        assert sum(weights) == pytest.approx(1.0, abs=1e-12)
        x = np.array(places)
        found = jo.fatigue.hot_spot_stress(a + b * x, name)
        assert found == pytest.approx(a, abs=0.003 * abs(b) if name == "fine" else 1e-9)
    x = np.array(READINGS["quadratic"][0])
    assert jo.fatigue.hot_spot_stress(a + b * x + c * x**2, "quadratic") == pytest.approx(
        a, abs=1e-9
    )
    # the notch of the toe, s = a + b x + q e^(-x/0.1): what is left of it 0.4 t away counts
    notch = 200.0 * np.exp(-np.array([0.4, 1.0]) / 0.1)
    found = jo.fatigue.hot_spot_stress(a + b * np.array([0.4, 1.0]) + notch, "fine")
    # IIW 2016, 2.2.3.4: 1.67 s(0.4 t) - 0.67 s(1.0 t)
    assert found == pytest.approx(a + 1.67 * notch[0] - 0.67 * notch[1], abs=0.003 * abs(b))


def plate(kind: str = "hexahedron20") -> jo.Part:
    """A plate 0.2 x 0.05 x 0.01 m along x, clamped by nobody yet."""
    mesh = grid(kind, (20, 5, 2), (0.2, 0.05, 0.01))
    return jo.Part.solid(mesh, STEEL, name="plate")


@pytest.mark.parametrize("reading", ["fine", "coarse", "quadratic"])
@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10"])
def test_bending_of_a_plate(kind: str, reading: str) -> None:
    # pure linear field u = curvature: s11 = -E k z, constant along x; and a linear one along x
    part = plate(kind)
    toe = jo.fatigue.WeldToe("toe", (0.08, 0.025, 0.01), (1.0, 0.0, 0.0), 0.01, reading)
    operator = jo.fatigue.weld_stress(part, toe)
    x, y, z = part.nodes.T
    k = 0.1
    z0 = z - 0.005
    # anticlastic bending, s11 = E k z0: a quadratic displacement
    d = np.stack([k * x * z0, -0.3 * k * y * z0, -k / 2 * x**2 + 0.15 * k * (y**2 - z0**2)], axis=1)
    s = operator.evaluate(d.ravel())
    assert s[0, 0] == pytest.approx(210e9 * k * 0.005, rel=2e-3)
    assert np.abs(s[0, 1:]).max() < 2e-3 * s[0, 0]


def test_axes_turn_with_the_toe() -> None:
    part = plate()
    x, y, z = part.nodes.T
    # uniform tension along x, a toe at 30 degrees: s11 = s cos^2
    e = 1e-3
    d = np.stack([e * x, -0.3 * e * y, -0.3 * e * z], axis=1).ravel()
    way = (np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0)
    toe = jo.fatigue.WeldToe("toe", (0.08, 0.02, 0.01), way, 0.01)
    other = jo.fatigue.WeldToe("below", (0.08, 0.02, 0.0), way, 0.01)
    s = jo.fatigue.weld_stress(part, [toe, other]).evaluate(d)
    assert s[:, 0] == pytest.approx([210e6 * 0.75] * 2, rel=1e-6)
    assert s[:, 1] == pytest.approx([210e6 * 0.25] * 2, rel=1e-6)
    assert np.abs(s[:, 3]) == pytest.approx([210e6 * 0.5 * 0.75**0.5] * 2, rel=1e-6)
    assert np.abs(s[:, [2, 4, 5]]).max() < 1.0


def stiffened(n: int) -> jo.Part:
    """A plate with a block welded on its upper side: a step in the surface at x = 0.1."""
    t = 0.01
    mesh = grid("hexahedron20", (20 * n, 1, 4 * n), (0.2, t / n, 2 * t))
    keep = [
        block.nodes[
            ~(
                (mesh.nodes[block.nodes].mean(axis=1)[:, 2] > t)
                & (mesh.nodes[block.nodes].mean(axis=1)[:, 0] < 0.1)
            )
        ]
        for block in mesh.cells
    ]
    used = np.unique(np.concatenate([k.ravel() for k in keep]))
    cells = [
        jo.mesh.Cells(block.kind, np.searchsorted(used, k))
        for block, k in zip(mesh.cells, keep, strict=True)
    ]
    return jo.Part.solid(jo.Mesh("stiffened", mesh.nodes[used], cells), STEEL)


def test_step_does_not_depend_on_the_mesh() -> None:
    # tension of the thin side: the nodal stress at the toe grows with every refinement, the
    # structural stress does not; far away the plate has F/A + M/W of the eccentric step
    import scipy.sparse.linalg as spla

    found, toes = [], []
    for n in (1, 2):
        part = stiffened(n)
        x = part.nodes[:, 0]
        held = np.flatnonzero(np.isclose(x, 0.2))
        end = np.flatnonzero(np.isclose(x, 0.0))
        free = np.setdiff1d(np.arange(len(part.nodes)), held)
        dofs = (3 * free[:, None] + np.arange(3)).ravel()
        area = np.ptp(part.nodes[end, 1]) * np.ptp(part.nodes[end, 2])
        f = part.load(jo.parts.Traction(end, (-100e6, 0.0, 0.0)))
        d = np.zeros(3 * len(part.nodes))
        K = part.K.tocsc()[dofs][:, dofs]
        d[dofs] = spla.spsolve(K, f[dofs])
        y = 0.5 * np.ptp(part.nodes[:, 1])
        toe = jo.fatigue.WeldToe("toe", (0.1, y, 0.01), (-1.0, 0.0, 0.0), 0.01, "fine")
        s = jo.fatigue.weld_stress(part, toe).evaluate(d)
        found.append(s[0, 0])
        corner = np.flatnonzero(np.isclose(x, 0.1) & np.isclose(part.nodes[:, 2], 0.01))
        nodal = part.stress.evaluate(d)
        labels = [f"n{part.solids.node_ids[i]}" for i in corner]
        toes.append(max(nodal[part.stress.index(label), 0] for label in labels))
        assert f.reshape(-1, 3)[:, 0].sum() == pytest.approx(-100e6 * area)
    assert found[1] == pytest.approx(found[0], rel=0.03)
    assert toes[1] > 1.15 * toes[0]
    assert found[1] > 100e6


def test_toes_in_a_reduction() -> None:
    mesh = grid("hexahedron20", (20, 2, 2), (0.2, 0.02, 0.01))
    part = jo.Part.solid(
        mesh,
        STEEL,
        name="plate",
        interfaces=(jo.Interface("start", jo.mesh.InBox((-1, -1, -1), (1e-6, 1, 1))),),
    )
    toe = jo.fatigue.WeldToe("toe", (0.05, 0.01, 0.01), (1.0, 0.0, 0.0), 0.01)
    part = part.with_stress(jo.fatigue.weld_stress(part, toe, add=part.surface_stress()))
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=3))
    assert reduced.stress is not None and "toe" in reduced.stress.labels
    assert reduced.stress.labels[0] == "toe"
    # bending: the stress at the toe follows that of the surface nodes there, extrapolated
    near = reduced.stress.nearest((0.054, 0.01, 0.01))
    i = reduced.stress.labels.index(near)
    assert np.abs(reduced.stress.modes[0, 0]).max() > np.abs(reduced.stress.modes[i, 0]).max() * 0.9


def test_mistakes() -> None:
    part = plate()
    with pytest.raises(jo.InputError) as told:
        jo.fatigue.WeldToe("a", (0, 0, 0), (0, 0, 0), -1.0, "fin")  # type: ignore[arg-type]
    assert len(told.value.problems) == 2 and "did you mean 'fine'" in str(told.value)
    with pytest.raises(jo.InputError, match="thickness"):
        jo.fatigue.WeldToe("a", (0, 0, 0), (1, 0, 0))
    with pytest.raises(jo.InputError, match="2 stresses"):
        jo.fatigue.hot_spot_stress([1.0, 2.0, 3.0])
    with pytest.raises(jo.InputError, match="not on the surface"):
        jo.fatigue.weld_stress(part, jo.fatigue.WeldToe("a", (0.195, 0.02, 0.01), (1, 0, 0), 0.01))
    with pytest.raises(jo.InputError, match="off"):
        jo.fatigue.weld_stress(part, jo.fatigue.WeldToe("a", (0.1, 0.02, 0.01), (1, 0, -0.3), 1e-3))
    with pytest.raises(jo.InputError, match="edge of the part"):
        jo.fatigue.weld_stress(part, jo.fatigue.WeldToe("a", (0.1, 0.0, 0.01), (1, 0, 0), 0.01))
    toe = jo.fatigue.WeldToe("a", (0.1, 0.02, 0.01), (1, 0, 0), 0.01)
    with pytest.raises(jo.InputError, match="more than once"):
        jo.fatigue.weld_stress(part, [toe, toe])
    beam = jo.Part.beam(1.0, jo.Rectangle(0.1, 0.1), 2, STEEL)
    with pytest.raises(jo.InputError, match="solids"):
        jo.fatigue.weld_stress(beam, toe)
