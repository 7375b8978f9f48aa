"""Virtual strain gauges on beams and solids."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto import mechanism as jm
from parts.grids import grid

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SIZE = np.array([0.4, 0.05, 0.02])


@pytest.fixture(scope="module")
def bar():
    """A bar of solids, and what pulling it at its ends does to its modes."""
    part = jo.Part.solid(grid("hexahedron20", (8, 2, 2), SIZE), STEEL)
    return jo.reduce(part, jo.FreeFree(modes=12))


@pytest.fixture(scope="module")
def beam():
    part = jo.Part.beam(0.5, jo.Rectangle(0.02, 0.04), 3, STEEL)
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))


def sentences(*args, **kwargs):
    with pytest.raises(jo.InputError) as error:
        jm.Gauge("g", *args, **kwargs)
    return [str(problem) for problem in error.value.problems]


def test_a_grid_on_a_solid_is_the_elongation_over_the_length(bar):
    """Both ends at nodes: the difference of their displacements in every mode."""
    a, b = (
        int(np.argmin(np.linalg.norm(bar.nodes - (x, 0.025, 0.02), axis=1))) for x in (0.1, 0.2)
    )
    gauge = jm.Gauge("g", bar, (0.15, 0.025, 0.0201), (1, 0, 0), length=0.1)
    np.testing.assert_allclose(gauge.position, (0.15, 0.025, 0.02), atol=1e-12)
    expected = (bar.modes[b, 0] - bar.modes[a, 0]) / 0.1
    np.testing.assert_allclose(gauge.rows[0], expected, atol=1e-9 * np.abs(expected).max())
    # a point sees the strain of the skin's stress: e = (s11 - nu (s22 + s33)) / E
    point = jm.Gauge("p", bar, (0.15, 0.025, 0.02), (1, 0, 0))
    part = jo.Part.solid(grid("hexahedron20", (8, 2, 2), SIZE), STEEL)
    skin = jo.reduce(part.with_stress(part.surface_stress()), jo.FreeFree(modes=12)).stress
    i = int(np.argmin(np.linalg.norm(skin.positions - point.position, axis=1)))
    s = skin.modes[i]
    expected = (s[0] - 0.3 * (s[1] + s[2])) / 210e9
    np.testing.assert_allclose(point.rows[0], expected, atol=1e-9 * np.abs(expected).max())


def test_reduced_files_keep_the_surface(bar, tmp_path):
    bar.save(tmp_path / "bar.h5")
    loaded = jo.ReducedPart.load(tmp_path / "bar.h5")
    at = (0.11, 0.02, 0.02)
    gauges = [jm.Gauge("g", part, at, (1, 1, 0), length=0.01) for part in (bar, loaded)]
    np.testing.assert_array_equal(*(gauge.rows for gauge in gauges))


def test_transverse_sensitivity(bar, beam):
    """Under uniaxial stress at the calibration's Poisson ratio it cancels out (ASTM E251)."""
    for part, at, along, across in (
        (bar, (0.15, 0.025, 0.02), (1, 0, 0), (0, 1, 0)),
        (beam, (0.2, 0.0, 0.02), (1, 0, 0), (0, 1, 0)),
    ):
        e, t = (jm.Gauge("g", part, at, d).rows for d in (along, across))
        shown = jm.Gauge("g", part, at, along, transverse=0.02).rows
        np.testing.assert_allclose(shown, (e + 0.02 * t) / (1 - 0.285 * 0.02), rtol=1e-9)


def test_beams_anywhere_on_the_section(beam):
    """Strain along a beam is linear over the section: a corner is the sum of two middles."""
    at = {
        "corner": (0.3, 0.01, 0.02),
        "top": (0.3, 0, 0.02),
        "side": (0.3, 0.01, 0),
        "axis": (0.3, 0, 0),
    }
    rows = {key: jm.Gauge(key, beam, x).rows for key, x in at.items()}
    expected = rows["top"] + rows["side"] - rows["axis"]
    np.testing.assert_allclose(rows["corner"], expected, atol=1e-9 * np.abs(expected).max())


def test_a_grid_over_the_end_of_an_element(beam):
    """Strain is linear in each element: the mean is that of both halves' middles."""
    x = 0.5 / 3
    gauge = jm.Gauge("g", beam, (x, 0, 0.02), length=0.04).rows
    halves = [jm.Gauge("h", beam, (x + s * 0.01, 0, 0.02)).rows for s in (-1, 1)]
    np.testing.assert_allclose(
        gauge, 0.5 * (halves[0] + halves[1]), atol=1e-9 * np.abs(gauge).max()
    )


def test_rows_of_several(bar, beam):
    gauges = [jm.Gauge(f"g{i}", bar, (x, 0.02, 0.02), (1, 0, 0)) for i, x in enumerate((0.1, 0.3))]
    B = jm.gauge_rows(gauges)
    assert B.shape == (2, bar.n)
    np.testing.assert_array_equal(B[1], gauges[1].rows[0])
    few = bar.keep([0, 2, 5])
    np.testing.assert_allclose(jm.gauge_rows(gauges, few), B[:, [0, 2, 5]])
    with pytest.raises(jo.InputError, match="parts of different numbers of modes"):
        jm.gauge_rows([*gauges, jm.Gauge("other", beam, "e1.a.top")])
    with pytest.raises(jo.InputError, match="there are none"):
        jm.gauge_rows([])
    with pytest.raises(jo.InputError, match=r"gauges\[0\]: is 'g', must be a Gauge"):
        jm.gauge_rows(["g"])


def test_what_is_wrong_on_solids(bar):
    (far,) = sentences(bar, (0.15, 0.025, 0.03), (1, 0, 0))
    assert far.startswith("gauge 'g': at: is 10 mm off the surface of part")
    assert "more than reach 4 mm; the nearest place of it is (0.15, 0.025, 0.02) m" in far
    assert sentences(bar, (0.15, 0.025, 0.03))[1] == (
        "gauge 'g': direction is missing: on solids there is no natural one"
    )
    (across,) = sentences(bar, (0.15, 0.025, 0.02), (0, 0, 1))
    assert "direction stands across the surface, whose normal there is (0, 0, 1)" in across
    (over,) = sentences(bar, (0.15, 0.045, 0.02), (0, 1, 0), length=0.02)
    assert "grid of 20 x 0 mm leaves the surface or runs over an edge" in over
    assert sentences(bar, "n0", (1, 0, 0))[0].startswith("gauge 'g': at: part ")
