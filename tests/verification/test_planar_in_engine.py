"""Two programs, one motion: the planar frame in NumPy and the spatial beam of the engine, in plane.

The spatial element with one strain per element is in the plane the element of the source (one-point
Reissner), consistent mass is its eq. 19, and its rigid arms are the master-slave elimination: with
the same Newmark step both must agree to what the iterations leave.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.planar.dynamics import simulate_planar
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import PlanarBeam, PlanarDamping, PlanarLoad, PlanarSupport
from jousto.planar.methods import Convergence, PlanarGeneralizedAlpha, PlanarNewmark
from jousto.planar.results import PlanarRun
from jousto.planar.section import PlanarSection

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


def in_plane(arm: float, moment: float = MOMENT) -> jo.Mechanism:
    """The same as a beam body of the engine."""
    section = jo.mechanism.BeamSection(
        stiffness=np.diag([EA, GA, GA, EI, EI, EI]), mass=M, inertia=np.diag([2 * J, J, J])
    )
    beam = jo.BeamBody(
        "boom",
        [(0.0, -arm, 0.0), (LENGTH, -arm, 0.0)],
        section,
        elements=N,
        offset=(arm, 0.0),
        mass="consistent",
        damping=jo.mechanism.BeamDamping(mass=0.1, stiffness=1e-4),
    )
    pivot = jo.ground.at((0.0, -arm, 0.0))
    return jo.Mechanism(
        beam,
        jo.Revolute("pivot", pivot, beam["start"], axis=(0, 0, 1)),
        jo.Torque("motor", beam["start"], (0.0, 0.0, moment)),
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
    solver = jo.simulation.Newmark(step, beta=beta, gamma=gamma, tolerance=1e-13, projection=False)
    space = jo.simulate(jo.compile(in_plane(arm)), 0.2, solver=solver, output_step=step)
    assert abs(plane.displacements[-1, 0, 2]) > 0.5
    for i in range(N + 1):
        found = space[f"node{i}"]
        assert abs(found[:, :2] - plane.positions[:, i]).max() < 1e-9
        assert abs(found[:, 2]).max() < 1e-12


def paper_boom(step: float, t_end: float) -> tuple[jo.Solution, PlanarRun]:
    """The boom of the third source: a joint beside the axis here, an offset in the plane."""
    A, I, E, rho = 1900e-6, 3.756e-6, 207e9, 7850.0
    section = jo.mechanism.BeamSection(
        stiffness=np.diag([E * A] * 3 + [E * I] * 3),
        mass=rho * A,
        inertia=rho * I * np.diag([2.0, 1.0, 1.0]),
    )
    beam = jo.BeamBody(
        "boom",
        [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0)],
        section,
        elements=4,
        mass="consistent",
        damping=jo.mechanism.BeamDamping(mass=0.1),
    )
    pivot = beam.node(0, at=(0.0, -0.5, 0.0))
    mechanism = jo.Mechanism(
        beam,
        jo.Revolute("pivot", jo.ground.at((0.0, -0.5, 0.0)), pivot, axis=(0, 0, 1)),
        jo.Torque("motor", beam["start"], (0, 0, 2e6), signal=jo.Table([0.0, 1.0], [0.0, 1.0])),
        jo.AngularVelocitySensor("speed", beam["start"]),
    )
    solver = jo.GeneralizedAlpha(step, rho=0.8, tangent="exact")
    space = jo.simulate(jo.compile(mechanism), t_end, solver=solver, output_step=step)
    plane_section = PlanarSection(EA=E * A, GA=E * A, EI=E * I, mass=rho * A, rotary=rho * I)
    frame = PlanarFrame(
        [(0.0, -0.5), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0)],
        [
            PlanarBeam(i, i + 1, plane_section, offset_a=(0.0, 0.5 if i == 0 else 0.0))
            for i in range(4)
        ],
        supports=[PlanarSupport(0)],
        loads=[PlanarLoad(0, moment=2e6, signal=lambda t: t)],
        damping=PlanarDamping(mass=0.1),
    )
    return space, simulate_planar(frame, t_end, PlanarGeneralizedAlpha(step, rho=0.8))


def test_the_boom_of_the_paper_on_a_joint() -> None:
    """Constraint and elimination converge to one motion, with order 2."""
    apart = []
    for step in (4e-4, 2e-4):
        space, plane = paper_boom(step, 0.2)
        speed = space["speed"][:, 2]
        apart.append(float(abs(speed - plane.velocities[:, 0, 2]).max()))
    assert apart[1] < 5e-3 * float(abs(speed).max())
    assert 3.0 < apart[0] / apart[1] < 5.0


class WithoutTangents(jo.simulation.Newmark):
    """Newton's matrix without the velocity-dependent tangents of inertia."""

    @property
    def options(self) -> dict[str, float | int]:
        return {**super().options, "plain_inertia": 1}


@pytest.mark.filterwarnings("ignore:.*which is coarse")
def test_the_tangents_save_as_much_in_both_programs() -> None:
    """Offset nodes spun to 60 rad/s in 60 steps: half the iterations, here and there."""
    arm, step, t_end, moment = 0.5, 1e-3, 0.06, 3e3
    frame = planar_frame(
        arm, PlanarSection(EA=EA, GA=GA, EI=EI, mass=M, rotary=J), moment, mass=0.1
    )
    method = PlanarNewmark(step, damping=0.01)
    rule = Convergence(relative=1e-10)
    plane = [
        int(
            simulate_planar(
                frame, t_end, method, convergence=rule, inertia_tangents=on
            ).solves.sum()
        )
        for on in (True, False)
    ]
    _, _, beta, gamma = method.weights
    model = jo.compile(in_plane(arm, moment))
    kinds = (jo.simulation.Newmark, WithoutTangents)
    options = {"beta": beta, "gamma": gamma, "max_iterations": 30, "projection": False}
    options["tangent"] = "exact"
    runs = [jo.simulate(model, t_end, solver=kind(step, **options)) for kind in kinds]
    space = [int(run.work.iterations[-1]) for run in runs]
    assert abs(runs[0]["node4"][-1] - runs[1]["node4"][-1]).max() < 1e-6
    assert space[0] < 0.6 * space[1]
    assert space[0] / space[1] == pytest.approx(plane[0] / plane[1], abs=0.05)
