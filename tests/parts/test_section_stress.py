"""Stress of section points from resultants: closed forms, shifted axes, outlines."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.sections.points import section_outline, stress_points


def area(edge: np.ndarray) -> float:
    """Return the signed area of a polygon."""
    y, z = edge.T
    return 0.5 * float(np.sum(y * np.roll(z, -1) - z * np.roll(y, -1)))


def test_bending_and_torsion_of_a_round_bar() -> None:
    # 32 M / (pi d^3) and 16 T / (pi d^3)
    d = 0.02
    points = {p.name: p for p in stress_points(jo.Circle(d))}
    top, left = points["top"], points["left"]
    assert top.rows[0, 4] == pytest.approx(32.0 / (np.pi * d**3), rel=1e-12)
    assert left.rows[0, 5] == pytest.approx(-32.0 / (np.pi * d**3), rel=1e-12)
    assert abs(left.rows[5, 3]) == pytest.approx(16.0 / (np.pi * d**3), rel=1e-12)


SIDES = {"left": 0.0, "top": 90.0, "right": 180.0, "bottom": 270.0}  # degrees from y to z


@pytest.mark.parametrize("section", [jo.Circle(0.02), jo.Tube(0.02, 0.001)], ids=["circle", "tube"])
def test_a_round_section_has_points_all_around(section: jo.Section) -> None:
    """Turning load and point together changes nothing; shear at the edge runs along it."""
    points = [p for p in stress_points(section) if p.name != "centre"]
    assert len(points) == len({p.name for p in points}) == 24
    left = next(p for p in points if p.name == "left")
    load = np.array([300.0, 50.0, -80.0, 7.0, 4.0, -3.0])
    for p in points:
        angle = np.arctan2(p.z, p.y)
        assert np.hypot(p.y, p.z) == pytest.approx(0.01)
        named = SIDES[p.name] if p.name in SIDES else float(p.name.removeprefix("deg"))
        assert np.exp(1j * angle) == pytest.approx(np.exp(1j * np.deg2rad(named)), abs=1e-12)
        R = np.eye(3)
        R[1:, 1:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        turned = np.concatenate([R @ load[:3], R @ load[3:]])
        a, b = p.rows @ turned, left.rows @ load
        assert a[0] == pytest.approx(b[0])
        # s12 and s13 turn as the vector of shear on the section
        assert a[[3, 5]] == pytest.approx(R[1:, 1:] @ b[[3, 5]], abs=1e-6)
        assert a[[3, 5]] @ [p.y, p.z] == pytest.approx(0.0, abs=1e-6)


def test_axis_off_the_centroid_and_the_shear_centre() -> None:
    """Pull along the centroid is plain tension; a force through the shear centre does not twist."""
    section, c, e = jo.Rectangle(0.02, 0.04), (0.03, -0.01), (-0.02, 0.05)
    N, Qy, Qz = 1000.0, 300.0, -200.0
    moved = stress_points(section, c, e)
    plain = stress_points(section)
    pull = np.array([N, 0.0, 0.0, 0.0, c[1] * N, -c[0] * N])
    shear = np.array([0.0, Qy, Qz, e[0] * Qz - e[1] * Qy, 0.0, 0.0])
    for a, b in zip(moved, plain, strict=True):
        assert a.rows @ pull == pytest.approx([N / section.A, 0, 0, 0, 0, 0], abs=1e-6)
        assert a.rows @ shear == pytest.approx(b.rows @ [0.0, Qy, Qz, 0.0, 0.0, 0.0], abs=1e-6)
        assert (a.y - b.y, a.z - b.z) == pytest.approx(c)


@pytest.mark.parametrize(
    "section",
    [
        jo.Rectangle(0.2, 0.1),
        jo.IBeam(height=0.2, width=0.1, web=0.0056, flange=0.0085),
        jo.sections.GeneralSection(A=1e-2, Iy=1e-2 * 0.1**2 / 12, Iz=1e-2 * 0.1**2 / 12, J=1.4e-5),
    ],
    ids=lambda s: type(s).__name__,
)
def test_outline_runs_around_the_area(section: jo.Section) -> None:
    assert area(section_outline(section)) == pytest.approx(section.A, rel=1e-12)


def test_outline_of_a_round_section_is_inscribed() -> None:
    edge = section_outline(jo.Circle(0.02), (0.1, 0.0))
    assert np.hypot(edge[:, 0] - 0.1, edge[:, 1]) == pytest.approx(0.01)
    assert area(edge) > 0.0


def test_stress_point_tells_what_is_wrong() -> None:
    with pytest.raises(jo.InputError) as error:
        jo.sections.StressPoint("tip", np.nan, 0.0, np.zeros((6, 5)))
    assert "rows" in str(error.value) and "y is nan" in str(error.value)
