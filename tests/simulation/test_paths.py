"""load_path on trusses with closed forms: limit points, snap-back, bifurcation, failures."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

import jousto as jo

HALF, RISE, K = 1.0, 0.4, 1000.0  # m, m, N/m
REST = float(np.hypot(HALF, RISE))
INERTIA = 0.01 * np.eye(3)


def truss(series: float | None = None) -> jo.Model:
    """Two springs to an apex (von Mises); in series a spring through which it is pushed."""
    apex = jo.RigidBody("apex", mass=1.0, inertia=INERTIA, position=(0.0, RISE, 0.0))
    parts = [
        apex,
        jo.Spring("left", jo.Distance(jo.ground.at((-HALF, 0, 0)), apex["origin"]), K),
        jo.Spring("right", jo.Distance(jo.ground.at((HALF, 0, 0)), apex["origin"]), K),
        jo.PositionSensor("apex", apex["origin"]),
    ]
    load = jo.Input("load")
    y = (0.0, 1.0, 0.0)
    if series is None:
        parts.append(jo.Prismatic("guide", jo.ground["origin"], apex["origin"], axis=y))
        parts.append(jo.Force("push", apex["origin"], (0, -1, 0), signal=load))
    else:
        cap = jo.RigidBody("cap", mass=1.0, inertia=INERTIA, position=(0.0, RISE + 3.0, 0.0))
        slide = jo.Prismatic("slide", jo.ground["origin"], cap["origin"], axis=y)
        parts += [
            cap,
            jo.Prismatic("guide", jo.ground["origin"], apex["origin"], axis=y),
            slide,
            jo.Spring("series", jo.Distance(apex["origin"], cap["origin"]), series),
            jo.Force("push", cap["origin"], (0, -1, 0), signal=load),
            jo.PositionSensor("cap", cap["origin"]),
        ]
    return jo.compile(jo.Mechanism(*parts, name="truss"))


def push(y: np.ndarray) -> np.ndarray:
    """Load of the truss at an apex height: 2 k (L0 - L) y / L."""
    length = np.hypot(HALF, y)
    return np.asarray(2 * K * (REST - length) * y / length)


# dP/dy = 0 where L^3 = L0 b^2
LIMIT = float(push(np.sqrt((REST * HALF**2) ** (2 / 3) - HALF**2)))


@pytest.fixture(scope="module")
def snapped() -> jo.simulation.LoadPath:
    return jo.simulation.load_path(truss(), "load", to=100.0, method="arc", steps=10)


def test_the_whole_curve_of_a_snapping_truss(snapped):
    assert snapped.complete
    assert snapped.load[-1] == 100.0
    assert np.abs(push(snapped["apex"][:, 1]) - snapped.load).max() < 1e-9 * K


def test_its_limit_loads_are_found_to_many_digits(snapped):
    assert [p.kind for p in snapped.critical] == ["limit", "limit"]
    assert snapped.limits == pytest.approx([LIMIT, -LIMIT], rel=1e-7)


def test_between_the_limits_it_is_unstable(snapped):
    y = snapped["apex"][:, 1]
    turn = np.sqrt((REST * HALF**2) ** (2 / 3) - HALF**2)
    assert np.array_equal(snapped.unstable == 1, np.abs(y) < turn)
    assert np.array_equal(snapped.squares < 0.0, np.abs(y) < turn)


def test_newton_is_quadratic(snapped):
    """Steps of a tenth of everything: from 1e-1 to 1e-10 in four or five iterations."""
    assert snapped.iterations[1:].max() <= 6


def test_a_soft_spring_in_series_snaps_back():
    """The cap's travel w = y0 - y + P / ks turns back where dw/dP does."""
    soft = 60.0
    path = jo.simulation.load_path(truss(soft), "load", to=100.0, method="arc", steps=20)
    y, w = path["apex"][:, 1], RISE + 3.0 - path["cap"][:, 1]
    assert np.abs(push(y) - path.load).max() < 1e-9 * K
    assert np.abs(RISE - y + path.load / soft - w).max() < 1e-9
    assert path.limits == pytest.approx([LIMIT, -LIMIT], rel=1e-7)
    assert (np.diff(w) < 0.0).any()  # snap-back


def test_the_cylindrical_arc_finds_the_same():
    path = jo.simulation.load_path(
        truss(), "load", to=100.0, method=jo.simulation.ArcLength(0.0), steps=10
    )
    assert path.limits == pytest.approx([LIMIT, -LIMIT], rel=1e-7)


def test_load_steps_stop_at_the_limit_and_say_so():
    with pytest.raises(
        jo.simulation.PathFailed, match=r"limit point is near.*method='arc'"
    ) as error:
        jo.simulation.load_path(truss(), "load", to=100.0)
    path = error.value.path
    assert not path.complete
    assert path.load[-1] == pytest.approx(LIMIT, rel=1e-3)
    assert path.load[-1] < LIMIT


def test_until_ends_a_path():
    path = jo.simulation.load_path(
        truss(), "load", to=100.0, method="arc", until=lambda s: s.q[1] < 0.0
    )
    assert path.states[-1].q[1] < 0.0 <= path.states[-2].q[1]
    assert not path.complete


def bar() -> jo.Model:
    """A rigid bar on a torsion spring c, pressed at its end: bifurcation at P = c / l."""
    rod = jo.RigidBody("rod", mass=1.0, inertia=INERTIA, position=(0, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], rod["origin"], axis=(0, 0, 1))
    return jo.compile(
        jo.Mechanism(
            rod,
            hinge,
            jo.Spring("spring", jo.Angle(jo.ground["origin"], rod["origin"]), 50.0),
            jo.Force("push", rod.at((0, 2.0, 0)), (0, -1, 0), signal=jo.Input("load")),
            jo.CoordinateSensor("angle", jo.Angle(jo.ground["origin"], rod["origin"])),
        )
    )


def test_a_pressed_bar_buckles_at_c_over_l():
    path = jo.simulation.load_path(bar(), "load", to=40.0, steps=8)
    assert path.complete
    assert path.bifurcations == pytest.approx([25.0], rel=1e-8)
    assert not path.stable[-1]


@pytest.mark.parametrize("side", [1, -1])
def test_its_other_branch_is_that_of_the_closed_form(side):
    """c a = P l sin(a), stable."""
    path = jo.simulation.load_path(bar(), "load", to=40.0, steps=8, method="arc", branch=side)
    bent = np.abs(path["angle"]) > 1e-3
    angle = path["angle"][bent]
    assert len(angle) > 3
    assert path.complete
    assert np.abs(50.0 * angle / np.sin(angle) / 2.0 - path.load[bent]).max() < 1e-7
    assert path.stable[bent].all()


def test_a_follower_load_is_no_gradient_and_converges_as_well():
    """A follower force at right angles on the bar: c a = P l, without limit, past half a turn."""
    rod = jo.RigidBody("rod", mass=1.0, inertia=INERTIA)
    hinge = jo.Revolute("hinge", jo.ground["origin"], rod["origin"], axis=(0, 0, 1))
    model = jo.compile(
        jo.Mechanism(
            rod,
            hinge,
            jo.Spring("spring", jo.Angle(jo.ground["origin"], rod["origin"]), 50.0),
            jo.Force("push", rod.at((0, 2, 0)), (-1, 0, 0), follow=True, signal=jo.Input("load")),
            jo.CoordinateSensor("angle", jo.Angle(jo.ground["origin"], rod["origin"])),
        )
    )
    path = jo.simulation.load_path(model, "load", to=200.0, steps=16)
    assert path["angle"] == pytest.approx(path.load * 2.0 / 50.0, abs=1e-9)


def test_gravity_is_a_parameter():
    ball = jo.RigidBody("ball", mass=2.0, inertia=INERTIA)
    slide = jo.Prismatic("slide", jo.ground["origin"], ball["origin"], axis=(0, 0, 1))
    mechanism = jo.Mechanism(
        ball,
        slide,
        jo.Bushing("spring", jo.ground["origin"], ball["origin"], np.diag([0, 0, 400.0, 0, 0, 0])),
        jo.Gravity((0, 0, -10.0)),
        jo.PositionSensor("ball", ball["origin"]),
    )
    path = jo.simulation.load_path(jo.compile(mechanism), "gravity", to=1.0, steps=4)
    assert path["ball"][:, 2] == pytest.approx(-0.05 * path.load, abs=1e-14)
    assert path.load == pytest.approx([0, 0.25, 0.5, 0.75, 1.0])


def test_a_free_body_is_named():
    ball = jo.RigidBody("ball", mass=2.0, inertia=INERTIA)
    slide = jo.Prismatic("slide", jo.ground["origin"], ball["origin"], axis=(0, 0, 1))
    force = jo.Force("push", ball["origin"], (0, 0, 1), signal=jo.Input("load"))
    model = jo.compile(jo.Mechanism(ball, slide, force))
    with pytest.raises(
        jo.simulation.PathFailed, match=r"body 'ball' moves freely along \(0, 0, -?1\)"
    ):
        jo.simulation.load_path(model, "load", to=1.0)


def test_a_summary_says_how_much_it_leaves_out(snapped):
    assert "more" not in repr(snapped)
    many = replace(snapped, critical=3 * snapped.critical)
    assert repr(many).endswith("and 2 more>")


def test_all_that_is_wrong_is_said_at_once():
    with pytest.raises(jo.InputError) as error:
        jo.simulation.load_path(truss(), "load", to=np.nan, steps=0, method="ark", branch=2)
    assert len(error.value.problems) == 4
    with pytest.raises(jo.InputError, match="no parameter 'lode'; did you mean 'load'"):
        jo.simulation.load_path(truss(), "lode", to=1.0)
    with pytest.raises(jo.InputError, match="no gravity to scale"):
        jo.simulation.load_path(truss(), "gravity", to=1.0)
    with pytest.raises(jo.InputError, match="load is 0 already"):
        jo.simulation.load_path(truss(), "load", to=0.0)


def test_a_path_is_drawn_and_written(snapped, tmp_path):
    assert jo.plot(snapped, "apex.y", path=tmp_path / "path.png").axes
    with pytest.raises(jo.InputError, match="say which, as 'apex.y'"):
        jo.plot(snapped, "apex")
    with pytest.raises(jo.InputError, match="no sensor 'apx'; did you mean 'apex'"):
        jo.plot(snapped, "apx.y")
    file = jo.write(snapped, tmp_path / "path.csv")
    with file.open() as text:
        rows = list(csv.reader(text))
    assert rows[0][0] == "load"
    assert rows[0][4] == "apex.y (m)"
    assert len(rows) == len(snapped) + 1
    assert float(rows[-1][0]) == 100.0
