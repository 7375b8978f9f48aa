"""Buckling and prestressed vibration of geometrically exact beams against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.modes import large

E, NU, RHO = 2.1e11, 0.3, 7850.0
STEEL = jo.Material(E=E, nu=NU, rho=RHO)
B, H, L = 0.02, 0.04, 2.0  # m: sides of the section, length
EI = E * H * B**3 / 12  # weak axis
STRONG = E * B * H**3 / 12
BASE, TIP = jo.ground["origin"], jo.ground.at((L, 0, 0))


def straight(elements: int, section: object = None, material: object = STEEL) -> jo.BeamBody:
    shape = section or jo.Rectangle(B, H)
    material = None if section else material
    return jo.BeamBody(
        "beam", [(0, 0, 0), (L, 0, 0)], shape, material, elements=elements, up=(0, 0, 1)
    )


def column(ends: str, elements: int) -> jo.Model:
    """A column along x; at its end only what the case asks for is held."""
    beam = straight(elements)
    along = (1, 0, 0)
    clamp = jo.Fixed("base", BASE, beam["start"])
    pin = jo.Universal("base", BASE, beam["start"], axis_a=(0, 0, 1), axis_b=(0, 1, 0))
    joints = {
        "clamped-free": (clamp,),
        "pinned-pinned": (pin, jo.PointOnLine("tip", TIP, beam["end"], axis=along)),
        "clamped-pinned": (clamp, jo.PointOnLine("tip", TIP, beam["end"], axis=along)),
        "clamped-clamped": (clamp, jo.Prismatic("tip", TIP, beam["end"], axis=along)),
    }[ends]
    press = jo.Force("press", beam["end"], (-1, 0, 0), signal=jo.Input("P"))
    return jo.compile(jo.Mechanism(beam, *joints, press))


EULER = {  # (pi / K)^2; 4.4934 is the first root of tan x = x
    "clamped-free": np.pi**2 / 4,
    "pinned-pinned": np.pi**2,
    "clamped-pinned": 4.493409457909064**2,
    "clamped-clamped": 4 * np.pi**2,
}


@pytest.mark.parametrize("ends", EULER)
def test_euler_loads_of_all_four_ends_converge_with_order_two(ends):
    exact = EULER[ends] * EI / L**2
    # shear of the section: P = Pe / (1 + Pe / GA'), at most 1e-3 here
    shear = exact / (1 + exact / (5 / 6 * E / 2.6 * B * H))
    errors = [
        jo.simulation.buckling(column(ends, n), "P", 1).loads[0] / shear - 1 for n in (12, 24)
    ]
    assert 3.6 < errors[0] / errors[1] < 4.4
    assert (4 * errors[1] - errors[0]) / 3 == pytest.approx(0.0, abs=6e-4)  # strain: 3e-4


def test_the_second_load_is_that_of_the_strong_axis():
    found = jo.simulation.buckling(column("clamped-free", 24), "P", 2)
    assert found.loads == pytest.approx(np.pi**2 / 4 * np.array([EI, STRONG]) / L**2, rel=3e-3)
    side = np.abs(found.shapes["beam.node25"][:, 0])
    assert side[0, 1] > 100 * side[0, 2]  # the weak axis bends along y
    assert side[1, 2] > 100 * side[1, 1]


def test_on_the_path_it_is_the_same_and_a_bifurcation():
    """Axial shortening of the column changes its load by P / EA, 2e-5."""
    model = column("clamped-free", 12)
    linear, exact = (
        jo.simulation.buckling(model, "P", 1),
        jo.simulation.buckling(model, "P", 1, method="path"),
    )
    assert exact.kinds == ("bifurcation",)
    assert exact.loads == pytest.approx(linear.loads, rel=1e-4)
    assert exact.path is not None
    assert exact.path.stable[0]


def test_a_narrow_cantilever_buckles_sideways():
    """P = 4.013 sqrt(EI GJ) / L^2 (Timoshenko and Gere, Theory of Elastic Stability, 6.3)."""
    GJ = 40.0
    stiff = np.diag([1e8, 1e8, 1e8, GJ, 1e7, 60.0])  # y: the strong axis
    section = jo.mechanism.BeamSection(stiff, 1.0, 1e-4 * np.diag([2.0, 1, 1]))
    beam = straight(24, section)
    load = jo.Force("load", beam["end"], (0, 0, -1), signal=jo.Input("P"))
    model = jo.compile(jo.Mechanism(beam, jo.Fixed("base", BASE, beam["start"]), load))
    found = jo.simulation.buckling(model, "P", 1)
    assert found.loads[0] == pytest.approx(4.013 * np.sqrt(60.0 * GJ) / L**2, rel=4e-3)


def test_a_cantilever_tips_over_under_its_weight():
    """q L = 12.85 sqrt(EI GJ) / L^2 (Timoshenko and Gere, 6.3), bent as it is by then."""
    beam = straight(24, jo.mechanism.BeamSection.of(jo.Circle(0.02), STEEL))
    down = jo.Gravity((0, 0, -9.81))
    model = jo.compile(jo.Mechanism(beam, jo.Fixed("base", BASE, beam["start"]), down))
    area, inertia = np.pi * 1e-4, np.pi * 0.02**4 / 64
    closed = 12.85 * np.sqrt(E * inertia * E / (1 + NU) * inertia) / L**3
    found = jo.simulation.buckling(model, "gravity", 1).loads[0]
    assert found == pytest.approx(closed / (RHO * area * 9.81), rel=4e-3)


@pytest.mark.parametrize("weight", [0.1, 3.0])
def test_weight_across_a_column_leaves_the_load_of_linear_theory(weight):
    beam = straight(16)
    clamp = jo.Fixed("base", BASE, beam["start"])
    press = jo.Force("press", beam["end"], (-1, 0, 0), signal=jo.Input("P"))
    parts = [beam, clamp, press, jo.Gravity((0, -9.81 * weight, 0))]
    found = jo.simulation.buckling(jo.compile(jo.Mechanism(*parts)), "P", 1).loads[0]
    assert found == pytest.approx(np.pi**2 / 4 * EI / L**2, rel=6e-3)


@pytest.mark.parametrize("bending", [False, True])
def test_strains_for_buckling_are_those_of_the_elements(bending):
    from jousto.mechanism.beams.frames import strains
    from jousto.simulation.statics.beam_strains import beam_strains

    steps = np.linspace(0.0, 1.5, 6)
    points = np.column_stack([np.sin(steps), 1 - np.cos(steps), 0.2 * steps])
    beam = jo.BeamBody("beam", points, jo.Circle(0.02), STEEL, twist=0.7, bending=bending)
    clamp = jo.Fixed("base", BASE, beam["start"])
    model = jo.compile(jo.Mechanism(beam, clamp, jo.Gravity((0, 0, -9.81))))
    pairs = np.stack([beam.nodes[:-1], beam.nodes[1:]], axis=1)
    turns = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
    length = np.array([x.data[0] for x in model.beams])
    wanted = strains(pairs, turns, length, helical=bending)
    assert np.abs(beam_strains(model, model.q0) - wanted).max() < 1e-12


def test_a_beam_under_pure_moment_buckles_sideways():
    """M = pi sqrt(EI GJ) / L, ends that rotate but do not twist (Timoshenko and Gere, 6.2)."""
    GJ = 40.0
    stiff = np.diag([1e8, 1e8, 1e8, GJ, 1e7, 60.0])
    beam = straight(24, jo.mechanism.BeamSection(stiff, 1.0, 1e-4 * np.diag([2.0, 1, 1])))
    # cardan joints, first axis along z: M is about the second, which turns with the end's axis
    ends = [
        jo.Universal("left", BASE, beam["start"], axis_a=(0, 0, 1), axis_b=(0, 1, 0)),
        jo.Fixed("right", jo.ground.at((L, 0, 0)), beam["end"]),
    ]
    carriage = jo.RigidBody("carriage", mass=1.0, inertia=np.eye(3), position=(L, 0, 0))
    ends[1:] = [
        jo.Prismatic("slide", TIP, carriage["origin"], axis=(1, 0, 0)),
        jo.Universal("right", carriage["origin"], beam["end"], axis_a=(0, 0, 1), axis_b=(0, 1, 0)),
    ]
    moment = jo.Input("M")
    left = jo.Torque("left", beam["start"], (0, 1, 0), signal=moment, follow=True)
    right = jo.Torque("right", beam["end"], (0, -1, 0), signal=moment, follow=True)
    parts = [beam, carriage, *ends, left, right]
    found = jo.simulation.buckling(jo.compile(jo.Mechanism(*parts)), "M", 1)
    assert found.loads[0] == pytest.approx(np.pi * np.sqrt(60.0 * GJ) / L, rel=4e-3)


def lee(elements: int) -> jo.Model:
    """Lee's frame: two hinged legs of 120, welded at the corner, pressed at a fifth of one."""
    e, area, weak, side = 720.0, 6.0, 2.0, 120.0
    shear = 5 / 6 * e / 2.6 * area
    stiff = np.diag([e * area, shear, shear, 1e6, 1e6, e * weak])  # held in the plane
    steps = np.linspace(0.0, side, elements + 1)
    zero = np.zeros(elements)
    points = np.vstack(
        [
            np.column_stack([np.zeros(elements + 1), steps, np.zeros(elements + 1)]),
            np.column_stack([steps[1:], np.full(elements, side), zero]),
        ]
    )
    section = jo.mechanism.BeamSection(stiff, 1e-3, 1e-3 * np.diag([2.0, 1, 1]))
    beam = jo.BeamBody("frame", points, section, corners=(elements,), up=(0, 0, 1))
    hinge = (0, 0, 1)
    far = jo.ground.at((side, side, 0))
    press = beam.node(elements + elements // 5)
    return jo.compile(
        jo.Mechanism(
            beam,
            jo.Revolute("foot", BASE, beam["start"], axis=hinge),
            jo.Revolute("far", far, beam["end"], axis=hinge),
            jo.Force("press", press, (0, -1, 0), signal=jo.Input("P")),
            jo.PositionSensor("middle", press),
        )
    )


@pytest.mark.slow
def test_lees_frame_snaps_through_and_back():
    """Critical load 1.853 (Schweizerhof and Wriggers 1986: 18.532 with tenfold E), to 0.1 %.

    Order two in the elements: the limit of 10 and 20 elements a leg is taken.
    """
    coarse = jo.simulation.load_path(lee(10), "P", to=3.0, method="arc", steps=12)
    fine = jo.simulation.load_path(lee(20), "P", to=3.0, method="arc", steps=12, enough=1)
    limit = (4 * fine.limits[0] - coarse.limits[0]) / 3
    assert limit == pytest.approx(1.8532, rel=1.5e-3)
    assert coarse.limits[1] < 0.0  # the load turns round on the way through
    down = 120.0 - coarse["middle"][:, 1]
    assert (np.diff(down) < 0.0).any()  # snap-back
    assert coarse.load[-1] == 3.0


# -- vibration about loaded states --------------------------------------------------------------

# dimensionless flap frequencies of a cantilever clamped at the axis, eta = W sqrt(rA L^4 / EI)
# (Wright, Smith, Thresher and Wang, J. Appl. Mech. 49 (1982) 197-202, table 1)
WRIGHT = {
    0: (3.5160, 22.0345),
    1: (3.6817, 22.1810),
    2: (4.1373, 22.6149),
    3: (4.7973, 23.3203),
    6: (7.3604, 26.8091),
    12: (13.1702, 37.6031),
}


def blade(elements: int) -> tuple[jo.Model, float]:
    """A slender blade on a free hub, and its unit of time."""
    e, area, weak = 7e10, 2.5e-4, 5.2e-10
    stiff = np.diag([e * area, e * area / 3, e * area / 3, 100.0, e * weak, 100 * e * weak])
    mass = 2700 * area
    section = jo.mechanism.BeamSection(stiff, mass, 1e-5 * mass * np.diag([1, 0.5, 0.5]))
    beam = straight(elements, section)
    hub = jo.RigidBody("hub", mass=1.0, inertia=np.eye(3))
    parts = [
        beam,
        hub,
        jo.Revolute("axle", BASE, hub["origin"], axis=(0, 0, 1)),
        jo.Fixed("clamp", hub["origin"], beam["start"]),
        jo.Gravity((0, 0, -1e-9)),
    ]
    return jo.compile(jo.Mechanism(*parts)), float(np.sqrt(mass * L**4 / (e * weak)))


def flaps(
    model: jo.Model, state: jo.simulation.State | None, unit: float, count: int
) -> np.ndarray:
    """Dimensionless frequencies of motions out of the plane of rotation."""
    found = jo.modes(model, state, damped=True)
    tip = np.abs(found.shapes["beam.node" + str(len(model.bodies) - 1)][:, 0])
    flap = (tip[:, 2] > 10 * tip[:, 1]) & (found.frequencies * unit > 0.1)
    return np.asarray(2 * np.pi * found.frequencies[flap][:count] * unit)


@pytest.mark.parametrize("eta", [0, 2, 12])
def test_a_rotating_cantilever_has_the_frequencies_of_the_table(eta):
    model, unit = blade(20)
    state = jo.simulation.steady_rotation(model, (0, 0, 1), eta / unit) if eta else None
    assert flaps(model, state, unit, 2) == pytest.approx(WRIGHT[eta], rel=5e-3)


def test_tension_makes_a_string_of_it():
    """omega^2 = (k pi / L)^2 (T + EI (k pi / L)^2) / rA of a pinned beam under tension T."""
    beam = straight(24)
    along = (1, 0, 0)
    pull = jo.Force("pull", beam["end"], along, signal=jo.Input("T"))
    model = jo.compile(
        jo.Mechanism(
            beam,
            jo.Universal("base", BASE, beam["start"], axis_a=(0, 0, 1), axis_b=(0, 1, 0)),
            jo.PointOnLine("tip", TIP, beam["end"], axis=along),
            pull,
        )
    )
    path = jo.simulation.load_path(model, "T", to=2e5, steps=2)
    for tension, state in zip(path.load, path.states, strict=True):
        k = np.pi / L
        closed = np.sqrt(k**2 * (tension + EI * k**2) / (RHO * B * H)) / (2 * np.pi)
        assert jo.modes(model, state).frequencies[0] == pytest.approx(closed, rel=4e-3)


def test_pressed_to_its_load_it_no_longer_vibrates():
    """omega^2 = omega0^2 (1 - P / Pcr), exact for pinned ends, nearly so for others."""
    model = column("pinned-pinned", 16)
    critical = jo.simulation.buckling(model, "P", 1).loads[0]
    path = jo.simulation.load_path(model, "P", to=0.9 * critical, steps=3)
    squares = [jo.modes(model, s).frequencies[0] ** 2 for s in path.states]
    assert squares / squares[0] == pytest.approx(1 - path.load / critical, abs=1e-3)


@pytest.mark.filterwarnings("ignore:.*these are the modes at rest")
@pytest.mark.parametrize("damped", [False, True])
def test_sparse_modes_are_the_dense_ones(monkeypatch, damped):
    model, unit = blade(8)
    state = jo.simulation.steady_rotation(model, (0, 0, 1), 4.0 / unit)
    dense = jo.modes(model, state, damped=damped)
    keep = dense.frequencies > 1e-2 / unit
    monkeypatch.setattr(large, "MANY", 10)
    sparse = jo.modes(model, state, damped=damped, count=8)
    found = sparse.frequencies[sparse.frequencies > 1e-2 / unit][:5]
    assert found == pytest.approx(dense.frequencies[keep][:5], rel=1e-6)


def test_the_steady_shape_is_that_of_the_centrifugal_force():
    """u(L) = rA W^2 L^3 / (3 EA) of a rod at small strain, order two in the elements."""
    model, unit = blade(16)
    speed = 3.0 / unit
    state = jo.simulation.steady_rotation(model, (0, 0, 1), speed)
    mass, stiff = 2700 * 2.5e-4, 7e10 * 2.5e-4
    tip = model.bodies[[b.name for b in model.bodies].index("beam.node17")]
    stretch = np.linalg.norm(state.q[tip.iq : tip.iq + 3]) - L
    assert stretch == pytest.approx(mass * speed**2 * L**3 / (3 * stiff), rel=5e-3)
    w = state.v[tip.iv + 3 : tip.iv + 6]
    assert np.linalg.norm(w) == pytest.approx(speed)


def test_gravity_across_the_axis_is_refused():
    beam = straight(2)
    model = jo.compile(
        jo.Mechanism(
            beam,
            jo.Revolute("axle", BASE, beam["start"], axis=(0, 0, 1)),
            jo.Gravity((0, -9.81, 0)),
        )
    )
    with pytest.raises(jo.SimulationError, match="steady rotation|steady, and has no drive"):
        jo.simulation.steady_rotation(model, (0, 0, 1), 5.0)


def refused_rotation(many, speed, along):
    """What is said of a blade of so many elements that turns in gravity along an axis."""
    beam = straight(many)
    axle = jo.Revolute("axle", BASE, beam["start"], axis=(0, 0, 1))
    model = jo.compile(jo.Mechanism(beam, axle, jo.Gravity(9.81 * np.array(along))))
    with pytest.raises(jo.SimulationError, match="changes with the azimuth|has no drive") as error:
        jo.simulation.steady_rotation(model, (0, 0, 1), speed)
    return str(error.value)


@pytest.mark.parametrize("many", [2, 110])
@pytest.mark.parametrize("speed", [5.0, 300.0, 3000.0])
def test_gravity_across_the_blade_is_refused_with_its_torque(many, speed):
    """m g times the centre of mass of a rod stretched by its spin, x = sin(k s)/(k cos(k L))."""
    beta = speed * L * np.sqrt(RHO / E)
    needed = RHO * B * H * L * 9.81 * L * (1 - np.cos(beta)) / (beta**2 * np.cos(beta))
    said = refused_rotation(many, speed, (0, -1, 0))
    torque = float(said.split("torque of ")[1].split()[0])
    # the stretching, of the size beta^2, is of order two in the elements; four digits are printed
    assert torque == pytest.approx(needed, rel=0.25 * (beta / many) ** 2 + 2e-4)


@pytest.mark.parametrize("many", [2, 110])
@pytest.mark.parametrize("speed", [5.0, 300.0, 3000.0])
def test_gravity_along_the_blade_is_refused(many, speed):
    """It needs no torque, but is not the same after a turn."""
    assert "changes with the azimuth" in refused_rotation(many, speed, (-1, 0, 0))


def test_large_mechanisms_rest_where_small_ones_do(monkeypatch):
    """A soft cantilever under its own weight, far from straight: sparse and dense the same."""
    soft = jo.Material(E=2e9, nu=NU, rho=RHO)
    beam = straight(8, jo.mechanism.BeamSection.of(jo.Circle(0.01), soft))
    model = jo.compile(
        jo.Mechanism(beam, jo.Fixed("base", BASE, beam["start"]), jo.Gravity((0, 0, -9.81)))
    )
    dense = jo.equilibrium(model)
    monkeypatch.setattr("jousto.simulation.statics.equilibrium.MANY", 10)
    sparse = jo.equilibrium(model)
    assert dense.q[-5] < -0.5 * L  # it hangs
    assert np.abs(sparse.q - dense.q).max() < 1e-7


@pytest.mark.parametrize("many", [600, 1])
def test_on_a_turntable_springs_split_by_the_speed(monkeypatch, many):
    """Isotropic springs k = w0^2 m about the axis: w0 - W and w0 + W in the turning frame."""
    speed, w0 = 3.0, 10.0
    hub = jo.RigidBody("hub", mass=1.0, inertia=np.eye(3))
    ball = jo.RigidBody("ball", mass=1.0, inertia=np.eye(3))
    axle = jo.Revolute("axle", BASE, hub["origin"], axis=(0, 0, 1))
    turn = jo.Table([-1.0, 9.0], [-speed, 9 * speed])
    k = w0**2 * np.diag([1, 1, 4, 9, 9, 9])
    spring = jo.Bushing("spring", hub["origin"], ball["origin"], k)
    model = jo.compile(jo.Mechanism(hub, ball, axle, jo.Drive("motor", axle.angle, turn), spring))
    state = jo.simulation.steady_rotation(model, (0, 0, 1), speed)
    monkeypatch.setattr(large, "MANY", many)
    found = 2 * np.pi * jo.modes(model, state, damped=True, count=3).frequencies
    assert np.sort(found) == pytest.approx([w0 - speed, w0 + speed, 2 * w0], rel=1e-8)
    with pytest.raises(jo.SimulationError, match="'motor' does not allow a rotation"):
        jo.simulation.steady_rotation(model, (0, 0, 1), 2 * speed)
