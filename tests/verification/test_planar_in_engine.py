"""Two programs, one motion: the planar frame in NumPy and the spatial beam of the engine, in plane.

The spatial element with one strain per element is in the plane the element of the source (one-point
Reissner), consistent mass is its eq. 19, and its rigid arms are the master-slave elimination: with
the same Newmark step both must agree to what the iterations leave.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.planar import (
    Convergence,
    PlanarBeam,
    PlanarDamping,
    PlanarFrame,
    PlanarLoad,
    PlanarNewmark,
    PlanarRun,
    PlanarSection,
    PlanarSupport,
    simulate_planar,
)

EA, GA, EI, M, J = 1e6, 6e5, 1e3, 2.0, 0.05
N, LENGTH, MOMENT = 4, 2.0, 300.0


def planar_frame(arm: float, section: PlanarSection, moment: float, mass: float) -> PlanarFrame:
    """All nodes beside the axis by the same arm; a pivot at the first one."""
    return PlanarFrame(
        [(LENGTH * i / N, -arm) for i in range(N + 1)],
        [PlanarBeam(i, i + 1, section, (0.0, arm), (0.0, arm)) for i in range(N)],
        supports=[PlanarSupport(0)],
        loads=[PlanarLoad(0, moment=moment)],
        damping=PlanarDamping(mass=mass, stiffness=1e-4),
    )


def in_plane(arm: float) -> jo.Mechanism:
    """The same as a beam body of the engine."""
    section = jo.BeamSection(
        stiffness=np.diag([EA, GA, GA, EI, EI, EI]), mass=M, inertia=np.diag([2 * J, J, J])
    )
    beam = jo.BeamBody(
        "boom",
        [(0.0, -arm, 0.0), (LENGTH, -arm, 0.0)],
        section,
        elements=N,
        offset=(arm, 0.0),
        mass="consistent",
        damping=jo.BeamDamping(mass=0.1, stiffness=1e-4),
    )
    pivot = jo.ground.at((0.0, -arm, 0.0))
    return jo.Mechanism(
        beam,
        jo.Revolute("pivot", pivot, beam["start"], axis=(0, 0, 1)),
        jo.Torque("motor", beam["start"], (0.0, 0.0, MOMENT)),
        *(jo.PositionSensor(f"node{i}", beam.node(i)) for i in range(N + 1)),
    )


@pytest.mark.parametrize("arm", [0.0, 0.3])
@pytest.mark.parametrize("step", [2e-3, 1e-3])
def test_same_motion_to_rounding(arm: float, step: float) -> None:
    section = PlanarSection(EA=EA, GA=GA, EI=EI, mass=M, rotary=J)
    frame = planar_frame(arm, section, MOMENT, 0.1)
    method = PlanarNewmark(step, damping=0.01)
    tight = Convergence(relative=1e-12)
    plane: PlanarRun = simulate_planar(frame, 0.2, method, convergence=tight)
    _, _, beta, gamma = method.weights
    solver = jo.Newmark(step, beta=beta, gamma=gamma, tolerance=1e-13, projection=False)
    space = jo.simulate(jo.compile(in_plane(arm)), 0.2, solver=solver, output_step=step)
    assert abs(plane.displacements[-1, 0, 2]) > 0.5
    for i in range(N + 1):
        found = space[f"node{i}"]
        assert abs(found[:, :2] - plane.positions[:, i]).max() < 1e-9
        assert abs(found[:, 2]).max() < 1e-12
