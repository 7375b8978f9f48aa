"""Static beams in a plane: rolled up, bent by end loads, buckled, snapped through.

Closed forms are in `beam_chain`; they are checked there against tables.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from verification import beam_chain as bc
from verification.beam_statics import ZERO, arc, cantilever, rest, section, straight, thin, tip

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


@pytest.mark.parametrize("bending", [False, True])
@pytest.mark.parametrize(("elements", "turns"), [(3, 1), (5, 2), (8, 3), (7, 0.4)])
def test_roll_up_by_an_end_moment(elements: int, turns: float, bending: bool) -> None:
    # exact for any number of elements: an element as long as its chord, or as its arc
    beam = straight(1.0, elements, thin(ratio=1e3), bending=bending)
    angle = 2.0 * np.pi * turns
    end = tip(cantilever(beam, torque=(0.0, 0.0, angle)), int((32 if bending else 8) * turns))
    part = angle / elements / 2
    chord = 1.0 if bending else part / np.sin(part)
    exact = chord * np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0]) / angle
    assert np.abs(end - exact).max() < 1e-12


def test_roll_up_about_any_axis_in_space() -> None:
    turn = Rotation.from_rotvec([0.4, -1.1, 0.8])
    sec = section(1e4, 1e4, 1e4, 3.0, 2.0, 5.0)
    ends = turn.apply([[0, 0, 0], [1, 0, 0]]) + [0.3, 0.2, -0.7]
    frames = turn.as_matrix()
    for axis, EI in ((1, 2.0), (2, 5.0)):
        beam = jo.BeamBody("beam", ends, sec, elements=5, up=frames[:, 2])
        moment = 2.0 * np.pi * EI * frames[:, axis]
        assert np.abs(tip(cantilever(beam, torque=moment), 8) - ends[0]).max() < 1e-12


def test_a_ring_is_unrolled() -> None:
    # Ibrahimbegovic (1995), Computer Methods in Applied Mechanics and Engineering 122, 11-26,
    # example 1: L = 10, E I = 100; M = 10 pi opens the ring to half a ring, 20 pi to a line;
    # his ten straight elements of three nodes reach 9.663 and 0.497 of (10, 0), his curved ones
    # 9.998 and 0.017
    for moment, x, y in ((10.0, 0.0, 20.0 / np.pi), (20.0, 10.0, 0.0)):
        beam = arc(5.0 / np.pi, 2.0 * np.pi, 10, thin(100.0, 10.0, 1e4), bending=True)
        end = tip(cantilever(beam, torque=(0.0, 0.0, -moment * np.pi)), 16)
        assert np.abs(end - [x, y, 0.0]).max() < 1e-10


@pytest.mark.parametrize("load", [1.0, 2.0, 5.0, 10.0])
def test_elastica(load: float) -> None:
    w, u, slope = bc.elastica(load)
    exact = np.array([1.0 - u, w, 0.0])
    error = {}
    for bending in (False, True):
        for n in (4, 8, 16):
            # shear of ratio 1e7 moves the end by load 1e-7
            beam = straight(1.0, n, thin(ratio=1e8), bending=bending)
            model = cantilever(beam, force=(0.0, load, 0.0))
            state, _ = rest(model, int(10 * load) if bending else 4)
            iq = model.bodies[-1].iq
            error[n, bending] = float(np.linalg.norm(state.q[iq : iq + 3] - exact))
            e = state.q[iq + 3 : iq + 7]
        assert 2.0 * np.arctan2(e[3], e[0]) == pytest.approx(slope, abs=5e-6 if bending else 2e-3)
    assert np.log2(error[8, False] / error[16, False]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(error[4, True] / error[8, True]) == pytest.approx(4.0, abs=0.35)
    # of the length
    assert error[16, False] < 5e-4
    assert error[4, True] < 4e-4
    assert error[16, True] < 1.3e-6


def test_euler_column_and_what_follows() -> None:
    # dead compression of E I = 1, L = 1: the straight line is unstable from (pi/2)^2
    critical = np.pi**2 / 4.0
    for bending, error in ((False, 7e-3), (True, 2e-5)):
        beam = straight(1.0, 8, thin(ratio=1e6), bending=bending)
        found = jo.simulation.buckling(cantilever(beam, force=(-1.0, 0.0, 0.0)), "load", 2)
        assert found.loads[0] == pytest.approx(critical, rel=error)
        assert found.loads[1] == pytest.approx(critical, rel=error)  # both ways


@pytest.mark.parametrize("degrees", [20, 60, 100, 140, 176])
def test_buckled_column(degrees: int) -> None:
    load, x, y = bc.buckled(np.radians(degrees))
    load *= np.pi**2 / 4.0
    beam = straight(1.0, 16, thin(ratio=1e7), bending=True)
    side = jo.Force("side", beam["end"], (0.0, 1.0, 0.0), signal=jo.Input("side"))
    model = cantilever(beam, (-load, 0.0, 0.0), ZERO, side)
    grow = np.linspace(0.0, 1.0, 41)[1:]
    order = [model.inputs.index("load"), model.inputs.index("side")]
    # pushed aside, compressed, let go
    way = np.concatenate(
        [np.stack([0.0 * grow, 2.0 * grow], 1), np.stack([grow, 0 * grow + 2.0], 1)]
    )
    way = np.concatenate([way, np.stack([0.0 * grow + 1.0, 2.0 - 2.0 * grow], 1)])[
        :, np.argsort(order)
    ]
    end = tip(model, way)
    # near the critical load the deflection changes much with little load
    assert np.abs(end - [x, y, 0.0]).max() < (2e-4 if degrees == 20 else 2e-5)


@pytest.mark.slow
def test_deep_arch_snaps_through() -> None:
    # clamped-hinged arch of 215 degrees under a load at its crown: DaDeppo and Schmidt, Journal of
    # Applied Mechanics 42 (1975) 894-896: P R^2/E I = 8.97 (inextensible)
    t = np.radians(np.linspace(-107.5, 107.5, 21))
    points = np.stack([np.sin(t), np.cos(t), 0.0 * t], axis=1)
    # deep across its plane: it must not tip over
    sec = section(1e6, 1e6, 1e6, 1e4, 1e4, 1.0)
    beam = jo.BeamBody("arch", points, sec, up=(0, 0, 1), bending=True)
    load = jo.Input("load")
    model = jo.compile(
        jo.Mechanism(
            beam,
            jo.Fixed(
                "clamp",
                jo.ground.at(points[0], axes=beam.frames[0], name="left"),
                beam["start"],
            ),
            jo.Revolute("hinge", jo.ground.at(points[-1], name="right"), beam["end"]),
            jo.Force("load", beam.node(10), (0.0, -1.0, 0.0), signal=load),
            jo.PositionSensor("crown", beam.node(10)),
        )
    )
    path = jo.simulation.load_path(model, "load", to=12.0, steps=40, method="arc", enough=1)
    assert path.limits[0] == pytest.approx(8.97, abs=0.01)


def test_length_and_load_scale() -> None:
    # the same shape with other units: nothing depends on absolute sizes
    small = tip(cantilever(straight(1e-3, 4, thin(1e-9, 1e-3)), (0.0, 2e-3, 0.0)))
    large = tip(cantilever(straight(1e3, 4, thin(1e9, 1e3)), (0.0, 2e3, 0.0)))
    assert np.abs(small / 1e-3 - large / 1e3).max() < 1e-8
