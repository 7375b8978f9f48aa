"""Life below a rolling contact."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
CONTACT = jo.fatigue.hertz_line(10e3, length=0.03, radius=0.1, material=STEEL)


def test_shear_alone_has_a_closed_form() -> None:
    # k = 0: the orthogonal shear swings by +-p0/4 half a width deep (Johnson 1985, section 9.2);
    # Tresca's equivalent amplitude is p0/2
    curve = jo.SN(S_D=200e6, N_D=1e6, k=6.0)
    found = jo.fatigue.rolling_life(CONTACT, [10e3], jo.fatigue.Findley(0.0), curve)
    # one of the depths that are looked at
    assert found.worst == pytest.approx(0.5 * CONTACT.a, abs=0.6 * np.diff(found.depth).max())
    want = (0.5 * CONTACT.p0 / 200e6) ** 6 / 1e6
    assert found.damage.max() == pytest.approx(want, rel=0.04)
    assert found.life == pytest.approx(1 / want, rel=0.04)


@pytest.mark.parametrize("kind", [pytest.param("line", marks=pytest.mark.slow), "point"])
def test_similar_contacts(kind: str) -> None:
    # the same contact under eight times the force, worked out afresh
    def contact(F: float) -> jo.fatigue.HertzContact:
        if kind == "line":
            return jo.fatigue.hertz_line(F, length=0.03, radius=0.1, material=STEEL)
        return jo.fatigue.hertz_point(F, radii=(0.1, 0.3), material=STEEL)

    curve = jo.SN(S_D=200e6, N_D=1e6, k=6.0)
    depths = np.linspace(2e-4, 2e-3, 5)
    a = jo.fatigue.rolling_life(contact(2e3), [16e3], jo.fatigue.Findley(0.2), curve, depths=depths)
    b = jo.fatigue.rolling_life(
        contact(16e3), [16e3], jo.fatigue.Findley(0.2), curve, depths=depths
    )
    assert a.damage == pytest.approx(b.damage, rel=1e-6)


def test_classes_of_passes_add_up() -> None:
    curve = jo.SN(S_D=200e6, N_D=1e6, k=6.0)
    depths = [3e-4, 6e-4]
    many = jo.fatigue.rolling_life(
        CONTACT, [8e3, 8e3, 8e3, 12e3], jo.fatigue.Findley(), curve, depths=depths
    )
    few = jo.fatigue.rolling_life(
        CONTACT, [8e3, 12e3], jo.fatigue.Findley(), curve, counts=[3, 1], depths=depths
    )
    assert many.damage == pytest.approx(few.damage, rel=1e-12)
    assert many.passes == few.passes == 4.0
    assert "4 passes" in str(few)


def test_dang_van_is_a_limit() -> None:
    criterion = jo.fatigue.DangVan(0.3, 150e6)
    one = jo.fatigue.rolling_life(CONTACT, [10e3], criterion)
    four = jo.fatigue.rolling_life(CONTACT, [40e3], criterion)
    assert four.utilisation.max() == pytest.approx(2 * one.utilisation.max(), rel=1e-6)
    assert one.safety == pytest.approx(2 * four.safety, rel=1e-6)
    assert one.life == np.inf
    # deep below nothing happens
    assert one.utilisation[-1] < 0.5 * one.utilisation.max()


@pytest.mark.parametrize(
    "friction", [0.3, *(pytest.param(x, marks=pytest.mark.slow) for x in (0.0, 0.2, 0.4))]
)
def test_the_surface_of_a_line_counts(friction: float) -> None:
    # the same numbers from the stress history itself; under friction the surface is the worst
    criterion = jo.fatigue.Findley(0.25)
    curve = jo.SN(S_D=210e6, N_D=2e6, k=6.0)
    found = jo.fatigue.rolling_life(CONTACT, [10e3], criterion, curve, friction=friction)
    z = np.array([0.0, 0.005, 0.03, 0.4, 0.8]) * CONTACT.a
    roll = jo.fatigue.rolling_contact(CONTACT, z, friction=friction)
    direct = np.array(
        [
            float(criterion.equivalent(jo.fatigue.critical_plane(s, criterion).value))
            for s in roll.stress
        ]
    )
    assert found.depth[0] == 0.0
    assert found.utilisation.max() >= 0.99 * direct.max() / 210e6
    # without friction 0.8 a below it is worse
    assert (found.worst == 0.0) == (direct.argmax() == 0) == (friction >= 0.2)
    assert found.utilisation[0] == pytest.approx(direct[0] / 210e6, rel=1e-3, abs=1e-6)
    near = jo.fatigue.rolling_life(
        CONTACT, [10e3], criterion, curve, friction=friction, depths=z[:3]
    )
    assert near.utilisation == pytest.approx(direct[:3] / 210e6, rel=0.03)


def test_a_shallowest_depth_that_is_the_worst_is_told() -> None:
    point = jo.fatigue.hertz_point(10e3, radii=(0.1, 0.1), material=STEEL)
    with pytest.warns(jo.JoustoWarning, match="smallest depth"):
        told = jo.fatigue.rolling_life(point, [10e3], jo.fatigue.DangVan(0.3, 150e6), friction=0.4)
    assert told.worst == pytest.approx(0.04 * min(point.a, point.b))
    with pytest.warns(jo.JoustoWarning, match="nearer"):
        jo.fatigue.rolling_life(
            CONTACT, [10e3], jo.fatigue.DangVan(0.3, 150e6), friction=0.4, depths=[1e-5, 3e-4]
        )


def test_mistakes() -> None:
    with pytest.raises(jo.InputError) as told:
        jo.fatigue.rolling_life(CONTACT, [-1.0], jo.fatigue.Findley(), counts=[-1.0])
    assert len(told.value.problems) == 3
    with pytest.raises(jo.InputError, match="shape"):
        jo.fatigue.rolling_life(CONTACT, [1.0, 2.0], jo.fatigue.DangVan(0.3, 1e8), counts=[1.0])
