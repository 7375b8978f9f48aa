"""Momenta of the deformation relative to the frame: against particles, and none in mean axes."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.reduction import ChordFrame, MeanFrame, NodeFrame, in_frame, same_motion
from jousto.reduction.frames.frame import Frame

pytestmark = pytest.mark.filterwarnings("ignore:.*(moves freely|nothing will move|static work)")
WEIGHT = jo.Gravity((0.0, 0.0, -9.81))
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)


def arm() -> jo.Part:
    """An arm in space whose mass is that of its nodes alone, which therefore are particles."""
    nodes = [[0, 0, 0], [0.4, 0.1, 0], [0.8, 0, 0.1], [0.9, 0.4, 0.3], [0.7, 0.8, 0.3]]
    return jo.Part.frame(
        nodes,
        [[k, k + 1] for k in range(4)],
        sections=jo.Rectangle(0.02, 0.01),
        materials=STEEL,
        lumped=True,
        rotary_inertia=False,
        node_sets={"start": (0,), "end": (4,)},
    )


@pytest.mark.parametrize(
    "frame", [MeanFrame(), NodeFrame("start"), ChordFrame("start", "end")], ids=repr
)
@pytest.mark.parametrize("stiffening", [False, True])
def test_against_particles(frame: Frame, stiffening: bool, rng: np.random.Generator) -> None:
    part = arm()
    reduced = jo.reduce(part, jo.FreeFree(modes=5, frame=frame), stiffening=stiffening)
    p, rate = 1e-2 * rng.normal(size=5), rng.normal(size=5)
    body = jo.FlexibleBody(
        "arm", reduced, modal_coordinates=p, modal_velocities=rate, angular_velocity=(3, 1, -2)
    )
    sensor = jo.mechanism.DeformationMomentumSensor("momenta", body)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, sensor, WEIGHT)))
    engine.accelerations()
    found = engine.sensors()
    m = part.M.diagonal()[::6]
    flow = reduced.modes @ rate
    x = reduced.nodes + reduced.modes @ p
    exact = np.concatenate([m @ flow, m @ np.cross(x, flow)])
    size = np.tile(m @ np.abs(flow).sum(axis=1), 6)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-11 * size[0])
    if isinstance(frame, MeanFrame):
        # of the second order in the deformation
        assert np.abs(found[:3]).max() < 1e-11 * size[0]
        assert np.abs(found[3:]).max() < np.abs(reduced.modes @ p).max() * size[0]
    else:
        assert np.abs(found).max() > 0.1 * size[0]


def test_the_whole_momentum_is_that_of_every_frame(rng: np.random.Generator) -> None:
    """Momentum of the frame's motion and of the deformation: the sum does not depend on the frame.

    To the first order of the deformation: a tenth of it leaves a hundredth of the difference.
    """
    old = jo.reduce(arm(), jo.FreeFree(modes=5))
    new = in_frame(old, NodeFrame("start"))
    differences = []
    p, rate = 1e-3 * rng.normal(size=5), rng.normal(size=5)
    for size in (1.0, 0.1):
        q = np.r_[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, size * p]
        v = np.r_[0.1, 0.2, -0.3, 0.0, 0.0, 0.0, size * rate]
        totals = []
        for part, (x, dx) in ((old, (q, v)), (new, same_motion(old, new, q, v))):
            body = jo.FlexibleBody(
                "arm",
                part,
                position=x[:3],
                orientation=x[3:7],
                velocity=dx[:3],
                modal_coordinates=x[7:],
                modal_velocities=dx[6:],
                angular_velocity=jo.base.rotations.rotation_matrix(x[3:7]) @ dx[3:6],
            )
            sensor = jo.mechanism.DeformationMomentumSensor("momenta", body)
            engine = jo.model.Engine(jo.compile(jo.Mechanism(body, sensor, WEIGHT)))
            engine.accelerations()
            A = jo.base.rotations.rotation_matrix(engine.q[3:7])
            I = part.invariants
            S = I.first_moment + I.I3 @ engine.q[7:]
            own = I.mass * engine.v[:3] + A @ np.cross(engine.v[3:6], S)
            totals.append(own + A @ engine.sensors()[:3])
        differences.append(np.abs(totals[0] - totals[1]).max())
    assert differences[0] / differences[1] == pytest.approx(100.0, rel=0.2)


def test_the_moving_frame_reads_it(rng: np.random.Generator) -> None:
    """The second formulation, in other coordinates, has the same values at the start and after."""
    reduced = jo.reduce(arm(), jo.FreeFree(modes=3, frame=NodeFrame("start")))
    body = jo.FlexibleBody("arm", reduced, modal_velocities=1e-2 * rng.normal(size=3))
    pin = jo.Spherical("pin", jo.ground["origin"], body["start"])
    sensor = jo.mechanism.DeformationMomentumSensor("momenta", body)
    machine = jo.Mechanism(body, pin, sensor, WEIGHT)
    engine = jo.simulate(jo.compile(machine), 2e-3, output_step=1e-3)
    other = jo.natural.moving_frame(machine, 2e-3, step=1e-5, output_step=1e-3)
    scale = np.abs(engine["momenta"]).max()
    assert scale > 0
    np.testing.assert_allclose(other["momenta"][0], engine["momenta"][0], atol=1e-9 * scale)
    np.testing.assert_allclose(other["momenta"][-1], engine["momenta"][-1], atol=1e-2 * scale)
