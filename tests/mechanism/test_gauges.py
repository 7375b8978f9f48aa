"""Virtual strain gauges on beams and solids."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.sensors.bridge import Bridge, quarter_bridge_strain
from jousto.mechanism.sensors.gauge import Gauge, gauge_rows
from jousto.mechanism.sensors.rosette import Rosette
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
        Gauge("g", *args, **kwargs)
    return [str(problem) for problem in error.value.problems]


def test_a_grid_on_a_solid_is_the_elongation_over_the_length(bar):
    """Both ends at nodes: the difference of their displacements in every mode."""
    a, b = (
        int(np.argmin(np.linalg.norm(bar.nodes - (x, 0.025, 0.02), axis=1))) for x in (0.1, 0.2)
    )
    gauge = Gauge("g", bar, (0.15, 0.025, 0.0201), (1, 0, 0), length=0.1)
    np.testing.assert_allclose(gauge.position, (0.15, 0.025, 0.02), atol=1e-12)
    expected = (bar.modes[b, 0] - bar.modes[a, 0]) / 0.1
    np.testing.assert_allclose(gauge.rows[0], expected, atol=1e-9 * np.abs(expected).max())
    # a point sees the strain of the skin's stress: e = (s11 - nu (s22 + s33)) / E
    point = Gauge("p", bar, (0.15, 0.025, 0.02), (1, 0, 0))
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
    gauges = [Gauge("g", part, at, (1, 1, 0), length=0.01) for part in (bar, loaded)]
    np.testing.assert_array_equal(*(gauge.rows for gauge in gauges))


def test_transverse_sensitivity(bar, beam):
    """Under uniaxial stress at the calibration's Poisson ratio it cancels out (ASTM E251)."""
    for part, at, along, across in (
        (bar, (0.15, 0.025, 0.02), (1, 0, 0), (0, 1, 0)),
        (beam, (0.2, 0.0, 0.02), (1, 0, 0), (0, 1, 0)),
    ):
        e, t = (Gauge("g", part, at, d).rows for d in (along, across))
        shown = Gauge("g", part, at, along, transverse=0.02).rows
        np.testing.assert_allclose(shown, (e + 0.02 * t) / (1 - 0.285 * 0.02), rtol=1e-9)


def test_beams_anywhere_on_the_section(beam):
    """Strain along a beam is linear over the section: a corner is the sum of two middles."""
    at = {
        "corner": (0.3, 0.01, 0.02),
        "top": (0.3, 0, 0.02),
        "side": (0.3, 0.01, 0),
        "axis": (0.3, 0, 0),
    }
    rows = {key: Gauge(key, beam, x).rows for key, x in at.items()}
    expected = rows["top"] + rows["side"] - rows["axis"]
    np.testing.assert_allclose(rows["corner"], expected, atol=1e-9 * np.abs(expected).max())


def test_a_grid_over_the_end_of_an_element(beam):
    """Strain is linear in each element: the mean is that of both halves' middles."""
    x = 0.5 / 3
    gauge = Gauge("g", beam, (x, 0, 0.02), length=0.04).rows
    halves = [Gauge("h", beam, (x + s * 0.01, 0, 0.02)).rows for s in (-1, 1)]
    np.testing.assert_allclose(
        gauge, 0.5 * (halves[0] + halves[1]), atol=1e-9 * np.abs(gauge).max()
    )


def test_rows_of_several(bar, beam):
    gauges = [Gauge(f"g{i}", bar, (x, 0.02, 0.02), (1, 0, 0)) for i, x in enumerate((0.1, 0.3))]
    B = gauge_rows(gauges)
    assert B.shape == (2, bar.n)
    np.testing.assert_array_equal(B[1], gauges[1].rows[0])
    few = bar.keep([0, 2, 5])
    np.testing.assert_allclose(gauge_rows(gauges, few), B[:, [0, 2, 5]])
    with pytest.raises(jo.InputError, match="parts with different numbers of modes"):
        gauge_rows([*gauges, Gauge("other", beam, "e1.a.top")])
    with pytest.raises(jo.InputError, match="the list is empty"):
        gauge_rows([])
    with pytest.raises(jo.InputError, match=r"gauges\[0\]: is 'g', must be a Gauge"):
        gauge_rows(["g"])


def test_what_is_wrong_on_solids(bar):
    (far,) = sentences(bar, (0.15, 0.025, 0.03), (1, 0, 0))
    assert far.startswith("gauge 'g': at: is 10 mm off the surface of part")
    assert "more than reach 4 mm; the nearest point of the surface is (0.15, 0.025, 0.02) m" in far
    assert sentences(bar, (0.15, 0.025, 0.03))[1] == (
        "gauge 'g': direction is missing; give it, solids have no default direction"
    )
    (across,) = sentences(bar, (0.15, 0.025, 0.02), (0, 0, 1))
    assert "direction is normal to the surface, whose normal there is (0, 0, 1)" in across
    (over,) = sentences(bar, (0.15, 0.045, 0.02), (0, 1, 0), length=0.02)
    assert "grid of 20 x 0 mm leaves the surface or crosses an edge" in over
    assert sentences(bar, "n0", (1, 0, 0))[0].startswith("gauge 'g': at: part ")


# -- rosettes ---------------------------------------------------------------------------------


def test_rosette_on_a_solid(bar):
    """Grids at 0, 45, 90 degrees counterclockwise seen from above, from below the other way."""
    for z, side in ((0.02, 1.0), (0.0, -1.0)):
        at = (0.15, 0.025, z)
        rosette = Rosette("r", bar, at, (1, 0, 0), length=0.004, width=0.004)
        np.testing.assert_allclose(rosette.normal, (0, 0, side), atol=1e-9)
        c = np.sqrt(0.5)
        for rows, d in zip(rosette.rows, ((1, 0, 0), (c, c * side, 0), (0, 1, 0)), strict=True):
            single = Gauge("g", bar, at, d, length=0.004, width=0.004)
            np.testing.assert_allclose(rows, single.rows[0], atol=1e-9 * np.abs(rows).max())
    # the state does not depend on how the rosette is turned, nor on its kind; at a point
    p = 1e-6 * np.random.default_rng(5).standard_normal(bar.n)
    found = []
    for kind, turn in (("45", 0.0), ("45", 33.0), ("delta", 10.0)):
        d = (np.cos(np.radians(turn)), np.sin(np.radians(turn)), 0)
        e = Rosette("r", bar, (0.15, 0.025, 0.02), d, kind=kind).rows @ p
        state = jo.gauges.rosette_state(e, kind=kind, E=210e9, nu=0.3)
        found.append((state.s1, state.s2, np.cos(2 * (state.angle + np.radians(turn)))))
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=1e-6)


def test_rosettes_say_what_is_wrong(bar, beam):
    with pytest.raises(jo.InputError) as error:
        Rosette("r", bar, (0.15, 0.025, 0.02), (1, 0, 0), kind="30")
    assert "rosette 'r': kind is '30', must be '45', '60' (delta) or '90' (tee)" in str(error.value)
    with pytest.raises(jo.InputError, match="rosette 'r': direction is missing"):
        Rosette("r", bar, (0.15, 0.025, 0.02))
    with pytest.raises(
        jo.InputError, match="rosette 'r': measures shear, which is available at the section"
    ):
        Rosette("r", beam, (0.3, 0.005, 0.02))


def cantilever(torque=(0.0, 0, 0), force=(0, 0, 0.0), *, section=None, sensors, more=()):
    """Return the sensors of a loaded cantilever at rest."""
    part = jo.Part.beam(0.5, section or jo.Circle(0.03), 3, STEEL, theory=jo.parts.EulerBernoulli())
    body = jo.FlexibleBody("shaft", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=12)))
    clamp = jo.Fixed("clamp", jo.ground["origin"], body["start"])
    loads = (jo.Torque("t", body["end"], torque), jo.Force("f", body["end"], force))
    model = jo.compile(jo.Mechanism(body, clamp, *loads, *sensors(body), *more))
    engine = jo.model.Engine(model)
    state = jo.equilibrium(model)
    engine.q[:], engine.v[:] = state.q, 0.0
    engine.accelerations()
    values = engine.sensors().real
    return {s.name: values[s.offset : s.offset + s.count] for s in model.sensors}


def test_shaft_in_torsion():
    """tau = 16 T/(pi d^3); a rosette along the shaft: +-tau/2G at 45 degrees, none along it."""
    d = 0.03
    found = cantilever(
        (20.0, 0, 0),
        section=jo.Circle(d),
        sensors=lambda body: [
            jo.gauges.Rosette("r", body, "e2.a.top"),
            jo.gauges.Rosette("delta", body, "e2.a.left", kind="delta"),
            jo.gauges.Gauge("oblique", body, "e2.a.top", (1, 1, 0), transverse=0.01),
        ],
    )
    tau = 16 * 20.0 / (np.pi * d**3)
    gamma = tau / (210e9 / 2.6)
    size = gamma / 2
    # on top, the normal is z and the grid at 45 degrees along x + y, where torsion shortens it
    np.testing.assert_allclose(found["r"], (0, -size, 0), atol=1e-6 * size)
    for name, kind in (("r", "45"), ("delta", "60")):
        state = jo.gauges.rosette_state(found[name], kind=kind, E=210e9, nu=0.3)
        assert state.txy == pytest.approx(-tau, rel=1e-6)
        assert state.s1 == pytest.approx(tau, rel=1e-6)
        assert abs(state.angle) == pytest.approx(np.pi / 4, rel=1e-6)
        assert state.von_mises == pytest.approx(np.sqrt(3) * tau, rel=1e-6)
    # e = -size, across +size
    shown = -size * (1 - 0.01) / (1 - 0.285 * 0.01)
    assert found["oblique"][0] == pytest.approx(shown, rel=1e-6)


# -- bridges and temperature ------------------------------------------------------------------


def test_bridges_of_a_bent_beam():
    """Half bridge top and bottom: k e / 2, no tension; opposite arms: tension, no bending."""
    section = jo.Rectangle(0.02, 0.04)

    def sensors(body):
        top, bottom = (
            jo.gauges.Gauge(name, body, (0.1, 0, z))
            for name, z in (("top", 0.02), ("bottom", -0.02))
        )
        return [
            jo.gauges.Bridge("quarter", top, gauge_factor=2.1),
            jo.gauges.Bridge("half", (top, bottom), gauge_factor=2.1),
            jo.gauges.Bridge("pull", (top, None, bottom), gauge_factor=2.1),
        ]

    found = cantilever(force=(400.0, 0, -50.0), section=section, sensors=sensors)
    bend = 50.0 * 0.4 * 0.02 / (210e9 * section.Iy)
    pull = 400.0 / (210e9 * section.A)
    quarter = 2.1 * (bend + pull)
    # small deflections bend the pull's line of action a little
    assert found["quarter"][0] == pytest.approx(quarter / (4 + 2 * quarter), rel=3e-3)
    assert found["half"][0] == pytest.approx(2.1 * bend / 2, rel=3e-3)
    assert found["pull"][0] == pytest.approx(2.1 * pull / 2, rel=2e-3)


def test_nonlinearity_and_shunt(beam):
    """Tables of makers: 1000 um/m of a quarter bridge read 0.1 % low at k = 2; 174.65 kOhm beside
    350 ohm is 1000 um/m in compression (k = 2)."""
    gauge = Gauge("g", beam, "e1.a.top")
    bridge = Bridge("b", gauge)
    assert bridge.kind == "quarter"
    v = bridge.output([1000e-6])
    assert v / (2.0 * 1000e-6 / 4) == pytest.approx(1 - 0.001, abs=2e-6)
    assert quarter_bridge_strain(v) == pytest.approx(1000e-6, rel=1e-12)
    shunt = bridge.shunt(174_650.0)
    assert quarter_bridge_strain(shunt) == pytest.approx(-1000e-6, rel=1e-9)
    np.testing.assert_allclose(bridge.rows, 2.0 * gauge.rows / 4)
    # an adjacent half bridge is exact: e and -e
    other = Gauge("h", beam, "e1.a.bottom")
    half = Bridge("half", (gauge, other))
    assert half.output([500e-6, -500e-6]) == pytest.approx(2.0 * 500e-6 / 2, rel=1e-12)


def test_temperature_of_gauges_and_bridges():
    """(alpha_part - alpha_gauge + beta/k) (T - T0) on one gauge, nothing on a half bridge."""
    warm = jo.gauges.Temperature(
        jo.Ramp(0.0, 1.0, before=30.0, after=70.0), part=12e-6, gauge=10e-6, resistance=4e-6
    )
    assert warm.per_kelvin == pytest.approx(4e-6)

    def sensors(body):
        top, bottom = (
            jo.gauges.Gauge(name, body, (0.1, 0, z), temperature=warm)
            for name, z in (("top", 0.02), ("bottom", -0.02))
        )
        rosette = jo.gauges.Rosette("rosette", body, "e2.a.top", temperature=warm)
        return [
            top,
            rosette,
            jo.gauges.Bridge("quarter", top),
            jo.gauges.Bridge("half", (top, bottom)),
        ]

    found = cantilever(section=jo.Rectangle(0.02, 0.04), sensors=sensors)
    e = 4e-6 * 10.0
    assert found["top"][0] == pytest.approx(e)
    np.testing.assert_allclose(found["rosette"], e)
    assert found["quarter"][0] == pytest.approx(2 * e / (4 + 4 * e), rel=1e-12)
    assert abs(found["half"][0]) < 1e-18
    # a material may know its alpha
    steel = jo.Material(E=210e9, nu=0.3, rho=7850, alpha=12e-6)
    assert jo.gauges.Temperature(20.0, part=steel).part == 12e-6
    with pytest.raises(jo.InputError) as error:
        jo.gauges.Temperature(20.0, part=STEEL, gauge=11.0)
    assert [str(p) for p in error.value.problems] == [
        f"temperature: part: {STEEL!r} has no alpha; give it in 1/K, as 12e-6",
        "temperature: gauge is 11 1/K; if it is in 1e-6/K, multiply by 1e-6 (12e-6 for steel)",
    ]
    with pytest.raises(jo.InputError, match="alpha is 12 1/K; was it meant in 1e-6/K"):
        jo.Material(E=210e9, nu=0.3, rho=7850, alpha=12)


def test_bridges_say_what_is_wrong(bar, beam):
    g, h = Gauge("g", beam, "e1.a.top"), Gauge("h", bar, (0.15, 0.025, 0.02), (1, 0, 0))
    with pytest.raises(jo.InputError) as error:
        Bridge("b", (g, h, g), gauge_factor=0.0, resistance=-1)
    assert [str(p) for p in error.value.problems] == [
        "bridge 'b': its gauges sit on several bodies (beam, box), must be on one",
        "bridge 'b': one gauge is in several arms; give each arm its own gauge",
        "bridge 'b': gauge_factor is 0, must be near 2 (metal) or 100 (silicon)",
        "bridge 'b': resistance is -1 ohm, must be positive",
    ]
    with pytest.raises(jo.InputError, match="has 0 arms, must have one to four"):
        Bridge("b", ())
    with pytest.raises(jo.InputError, match="arm 1 is 'g', must be a Gauge or None"):
        Bridge("b", ("g", g))
    with pytest.raises(
        jo.InputError, match=r"strains have shape \(3,\), the last dimension must be 1"
    ):
        Bridge("b", g).output([1, 2, 3])


def test_a_grid_must_fit_on_its_beam(beam):
    """A grid of 3 mm given as 3, or stuck half beyond the end, is no gauge."""
    (long,) = sentences(beam, (0.1, 0, 0.02), length=3)
    assert "its grid of 3000 mm leaves the beam of part" in long
    assert "lengths are in m: if 3 mm are meant, give 0.003" in long
    (end,) = sentences(beam, (0.499, 0, 0.02), length=0.004)
    assert "25 % of its length lie beyond an end" in end
    assert "3 mm meant" not in end
    assert "50 % of its length lie" in sentences(beam, "e1.a.top", length=0.01)[0]
    (across,) = sentences(beam, (0.1, 0, 0.02), (0, 1, 0), length=0.3)
    assert "the section is 40 mm" in across
    # up to the end, within rounding, it fits
    Gauge("g", beam, (0.498, 0, 0.02), length=0.004)
    Gauge("g", beam, (0.25, 0, 0.02), length=0.5)
