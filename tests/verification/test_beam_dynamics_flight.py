"""A flexible beam in free flight: what Newton and Euler conserve, to round-off or the method's
order.

Simo and Vu-Quoc, Comput. Methods Appl. Mech. Eng. 66 (1988) 125-161, the free flight of a beam of
length 10 from (6, 0, 0) to (0, 8, 0), ``EA = GA = 1e4, m = 1``, rotary inertia 10: in the plane
with ``EI = 100``, in space with ``EI = GJ = 500``; a force T/10 along x and torques -T about z
(and -T/2 about y) act at its lower end, T rises to 200 at t = 2.5 and is gone at t = 5. Momenta
are sums over the nodes' lumped masses, and for the consistent mass over the integrals of linear
interpolation, not the engine's own mass matrix. Positions: EXUDYN 1.13.6, its geometrically exact
beam on SE(3).
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.particles import rotation

pytestmark = pytest.mark.filterwarnings("ignore:.*has no joint to another body")
LINE_INERTIA = np.diag([20.0, 10.0, 10.0])
LENGTH = 10.0
TORQUE = jo.Table((0, 2.5, 5.0, 6.0), (0, 200.0, 0, 0))
CENTER = np.array([3.0, 4.0, 0.0])


def flying(elements, *, space=True, loads=True, **options):
    EI = 500.0 if space else 100.0
    section = jo.mechanism.BeamSection(np.diag([1e4, 1e4, 1e4, EI, EI, EI]), 1.0, LINE_INERTIA)
    beam = jo.BeamBody(
        "beam", [(6, 0, 0), (0, 8, 0)], section, elements=elements, up=(0, 0, 1), **options
    )
    forces = []
    if loads:
        turn = (0, -0.5 if space else 0.0, -1)
        forces = [
            jo.Force("push", beam["start"], (0.1, 0, 0), signal=TORQUE),
            jo.Torque("turn", beam["start"], turn, signal=TORQUE),
        ]
    return jo.Mechanism(
        beam,
        *forces,
        jo.PositionSensor("start", beam["start"]),
        jo.PositionSensor("end", beam["end"]),
    )


def momenta(model, run, elements, share):
    """Linear and angular momentum about the origin (nt, 6) from positions and velocities."""
    h = LENGTH / elements
    out = []
    for q, v in zip(run.q, run.v, strict=True):
        q, v = q.reshape(-1, 7), v.reshape(-1, 6)
        r, dr, w = q[:, :3], v[:, :3], v[:, 3:]
        A = [rotation(e) for e in q[:, 3:]]
        P, H = np.zeros(3), np.zeros(3)
        for a, b in zip(range(elements), range(1, elements + 1), strict=True):
            for i, j in ((a, a), (a, b), (b, a), (b, b)):
                # lumped 1/2 on the diagonal, consistent 1/3 and 1/6
                c = (1 - share) / 2 + share / 3 if i == j else share / 6
                P += c * h * dr[j]
                H += c * h * np.cross(r[i], dr[j]) + A[i] @ (c * h * LINE_INERTIA @ w[j])
        out.append(np.concatenate([P, H]))
    return np.array(out)


SPIN = {"velocity": (0.5, -1.0, 2.0), "angular_velocity": (0.4, -0.7, 0.9)}


def flung(elements, share, solver, t_end=1.0, **options):
    """Free from the start, bent at once by its own spin about no principal axis."""
    model = jo.compile(flying(elements, loads=False, mass=share, **SPIN, **options))
    return model, jo.simulate(model, t_end, solver=solver)


METHODS = {
    "RK4": (lambda h: jo.RK4(step=h), (0.01, 0.005), 4),
    "ROS2": (lambda h: jo.ROS2(step=h), (0.004, 0.002), 2),
    "alpha": (lambda h: jo.GeneralizedAlpha(step=h, rho=0.8), (0.004, 0.002), 2),
    "Newmark": (lambda h: jo.simulation.Newmark(step=h), (0.004, 0.002), 2),
}


@pytest.mark.parametrize(
    ("method", "share"),
    [
        *(("RK4", 0.0), ("ROS2", 0.0), ("alpha", 0.5), ("Newmark", 1.0)),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (("alpha", 0.0), ("alpha", 1.0), ("Newmark", 0.0), ("Newmark", 0.5))
        ),
    ],
)
def test_free_flight_keeps_momenta_and_energy(method, share):
    solver, steps, order = METHODS[method]
    linear, angular, energy = [], [], []
    for h in steps:
        model, run = flung(6, share, solver(h))
        L = momenta(model, run, 6, share)
        change = np.abs(L - L[0])
        linear.append(change[:, :3].max() / np.abs(L[0, :3]).max())
        angular.append(change[:, 3:].max() / np.abs(L[0, 3:]).max())
        energy.append(np.abs(run.energy.error).max() / run.energy.total[0])
    assert max(linear) < 1e-11, linear
    for errors in (angular, energy):
        assert errors[-1] < 3e-3, errors
        assert errors[-1] < 1e-11 or np.log2(errors[0] / errors[1]) > order - 0.4, errors


def test_the_momenta_are_the_impulses_of_the_loads():
    # force 20 t/2.5 up and down: impulse 20*5/2 along x; its moment moves with the beam
    model = jo.compile(flying(8, mass=0.5))
    run = jo.simulate(model, 6.0, solver=jo.GeneralizedAlpha(step=0.01, rho=0.9))
    P = momenta(model, run, 8, 0.5)
    np.testing.assert_allclose(P[-1, :3], [50.0, 0, 0], rtol=0, atol=1e-5)
    # angular momentum: torque and r x F along the way by the trapezoidal rule
    F = TORQUE(run.time)[:, None] * [0.1, 0, 0]
    M = TORQUE(run.time)[:, None] * [0, -0.5, -1] + np.cross(run["start"], F)
    impulse = np.trapezoid(M, run.time, axis=0)
    np.testing.assert_allclose(P[-1, 3:], impulse, rtol=0, atol=2e-3 * np.abs(impulse).max())


# time, lower end, other end; 40 elements, 0.005, generalised alpha (0.9)
EXUDYN_SPACE = np.array(
    [
        (2, 4.06859, -0.49590, 0.22411, 1.64751, 8.09303, -0.28176),
        (3, 4.02360, 0.80344, -1.65380, 7.80724, 8.55781, -0.16528),
        (4, 8.51782, 3.57442, -4.50648, 12.48899, 4.40414, 4.61824),
        (5, 19.21335, 1.62228, -2.12373, 12.95025, 6.80923, 3.02759),
    ]
)
EXUDYN_PLANE = np.array(
    [
        (2, 4.29459, 2.25011, 0, 1.12153, 7.38503, 0),
        (3, 6.53566, 2.62934, 0, 4.05197, 5.99536, 0),
        (4, 11.38108, 4.51426, 0, 9.77347, 5.36381, 0),
        (5, 17.73870, 3.11806, 0, 13.23503, 3.91473, 0),
    ]
)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*which is coarse")
@pytest.mark.parametrize("space", [True, False], ids=["space", "plane"])
def test_another_program_flies_alike(space):
    table = EXUDYN_SPACE if space else EXUDYN_PLANE
    misses = []
    for n, step in ((10, 0.02), (20, 0.01), (40, 0.005)):
        model = jo.compile(flying(n, space=space, mass=0.5))
        solver = jo.GeneralizedAlpha(step=step, rho=0.9)
        run = jo.simulate(model, 5.0, solver=solver, output_step=1.0)
        found = np.hstack([run["start"], run["end"]])[table[:, 0].astype(int)]
        misses.append(np.abs(found - table[:, 1:]).max())
    # in the plane the other program still moves by 0.1 from 20 to 40 elements, in space by 0.02
    assert misses[-1] < (0.02 if space else 0.06), misses
    assert misses[0] > 2 * misses[1], misses
    # across the plane, m of a beam of 10 m
    assert (np.abs(found[:, [2, 5]]).max() < 1e-9) == (not space)
