"""Energy and momentum laws of force elements between a flexible and a rigid body.

Each element acts alone between two free bodies. What it stores, takes and does must close the
balance at the order of the method (the energy error of RK4 falls with its fifth order), and since
it acts within the system the linear and angular momentum stay, whatever it does.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import body_states, march, orders, particles_of, rod
from verification.particles import rotation

CURVE = jo.Table([-1.0, 0.0, 0.5, 1.0, 2.0, 3.0], [900, 200, 0, -300, -800, -2500], "cubic")
OIL = jo.Table([-6.0, -2.0, 0.0, 2.0, 6.0], [90.0, 40.0, 0.0, -60.0, -140.0], "cubic")
STIFF = np.diag([2e3, 1e3, 3e3, 40.0, 60.0, 50.0])
STIFF[0, 4] = STIFF[4, 0] = 90.0
LOSSY = np.diag([20.0, 5.0, 30.0, 0.6, 0.2, 0.4])
WAVE = jo.Harmonic(frequency=3.0, amplitude=40.0, offset=25.0)
STEP = 1e-4
SPAN = 0.1


def swirl(t, x):
    """A force that depends on everything: position, turn, both velocities, time."""
    r, A, v, w = x[:3], x[3:12].reshape(3, 3), x[12:15], x[15:]
    force = -300.0 * r + 15.0 * np.cross(w, r) - 8.0 * v + 20.0 * np.sin(20 * t) * A[:, 0]
    return np.concatenate([force, 2.0 * A[:, 1] - 0.3 * w + np.cross(r, A[:, 2])])


ELEMENTS = {
    # name: maker of (a, b, slide) and what it does: stores, takes, works (also a spring's table)
    "spring": (lambda a, b, s: jo.Spring.between("e", a, b, stiffness=800.0, free=0.4), "s"),
    "spring, table": (lambda a, b, s: jo.Spring.between("e", a, b, table=CURVE), "w"),
    "preloaded": (lambda a, b, s: jo.Spring("e", s, stiffness=500.0, preload=-60.0), "s"),
    "damper": (lambda a, b, s: jo.Spring.between("e", a, b, 400.0, 30.0), "st"),
    "damper, table": (lambda a, b, s: jo.Spring.between("e", a, b, damper_table=OIL), "t"),
    "bushing": (lambda a, b, s: jo.Bushing("e", a, b, STIFF), "s"),
    "bushing, damped": (lambda a, b, s: jo.Bushing("e", a, b, STIFF, LOSSY), "st"),
    "joint force": (lambda a, b, s: jo.JointForce("e", s, WAVE), "w"),
    "servo": (lambda a, b, s: jo.Servo("e", s, jo.Ramp(0, 1, 0, 2), 900.0, 40.0), "w"),
    "user force": (lambda a, b, s: jo.UserForce("e", b, swirl, a), "w"),
}

# from outside: momentum does not stay
PRESSURE = np.outer(np.linspace(0, 1, len(rod().nodes)), [5.0, -8.0, 3.0])
OUTSIDE = {
    "modal load": (lambda a, b, s: jo.mechanism.ModalLoad("e", a.body, PRESSURE, WAVE), "w"),
    "follower": (lambda a, b, s: jo.Force("e", a, (5, -40, 9), follow=True, signal=WAVE), "w"),
}
ALL = {**ELEMENTS, **OUTSIDE}


def pair(name):
    """A flexible and a rigid body in space, with a slide where the element needs one."""
    beam = jo.FlexibleBody("beam", rod(), angular_velocity=(1.0, 2.0, -1.5), velocity=(0.3, 0, 0))
    a = beam["end"].turned(jo.Rotate((1, 2, 0), degrees=25.0))
    slides = name in ("preloaded", "joint force", "servo")
    # on a slide it goes with the beam
    where = a.r if slides else a.r + np.array([0.5, 0.2, -0.3])
    w = (1.0, 2.0, -1.5) if slides else (-1.0, 0.5, 2.0)
    v = np.array([0.3, 0, 0]) + np.cross((1.0, 2.0, -1.5), a.r) if slides else (0.5, -1.0, 0.4)
    stone = jo.RigidBody(
        "stone",
        4.0,
        (0.08, 0.05, 0.06),
        markers={"eye": (0.0, 0.0, 0.0) if slides else (0.1, 0.05, 0.0)},
        position=where,
        orientation=jo.Rotate((0, 1, 1), degrees=20.0),
        velocity=v,
        angular_velocity=w,
    )
    joints = [jo.Prismatic("slide", a, stone["eye"], axis=(1, 1, 0))] if slides else []
    slide = joints[0].displacement if slides else None
    element = ALL[name][0](a, stone["eye"], slide)
    bodies = (beam, stone)
    return bodies, jo.compile(jo.Mechanism(*bodies, *joints, element, name=name))


def momentum(bodies, model, q, v):
    parts = [
        particles_of(body).momentum(qb, vb)
        for body, (qb, vb) in zip(bodies, body_states(model, q, v), strict=True)
    ]
    return np.sum([p for p, _ in parts], axis=0), np.sum([h for _, h in parts], axis=0)


pytestmark = pytest.mark.filterwarnings(
    "ignore:.*has no joint to another body:jousto.JoustoWarning"
)


@pytest.mark.parametrize("name", ALL)
def test_balance_and_bins(name):
    _, model = pair(name)
    runs = [march(model, jo.RK4(step=STEP / k), SPAN, SPAN / 20) for k in (1, 2)]
    exchanged = np.ptp(runs[1].energy, axis=0).max()
    errors = [float(np.abs(run.balance).max()) for run in runs]
    assert errors[1] < 5e-6 * exchanged
    assert orders(errors)[-1] > 3.6
    _, _, _, stored, taken, friction, work = np.abs(runs[1].energy - runs[1].energy[0]).max(axis=0)
    does = ALL[name][1]
    for mark, amount in (("s", stored), ("t", taken), ("w", work)):
        assert (amount > 1e-3 * exchanged) == (mark in does), (mark, amount, exchanged)
    assert friction == 0.0
    # what dampers take never comes back
    assert (np.diff(runs[1].energy[:, 4]).min() > 0.0) == ("t" in does)


@pytest.mark.parametrize("method", [jo.ROS2, jo.GeneralizedAlpha], ids=lambda m: m.__name__)
@pytest.mark.parametrize("name", ALL)
def test_balance_of_the_methods_of_second_order(name, method):
    _, model = pair(name)
    # the end of the iteration by the error of the step is visible in balances of 1e-5
    tight = {"tolerance": 1e-10} if method is jo.GeneralizedAlpha else {}
    runs = [march(model, method(step=4 * STEP / k, **tight), SPAN, SPAN / 5) for k in (1, 4)]
    exchanged = np.ptp(runs[1].energy, axis=0).max()
    errors = [float(np.abs(run.balance).max()) for run in runs]
    assert errors[1] < 2e-3 * exchanged
    assert 0.5 * orders(errors)[0] > 1.4  # two halvings


@pytest.mark.parametrize("name", ALL)
def test_the_end_of_the_iteration_hardly_shows_in_the_balance(name):
    _, model = pair(name)
    for k in (1, 4):
        auto, tight = (
            march(
                model, jo.GeneralizedAlpha(step=4 * STEP / k, tolerance=tolerance), SPAN, SPAN / 5
            )
            for tolerance in ("auto", 1e-10)
        )
        exchanged = np.ptp(tight.energy, axis=0).max()
        drift, wanted = (float(np.abs(run.balance).max()) for run in (auto, tight))
        assert abs(drift - wanted) < 0.02 * wanted + 2e-5 * exchanged


@pytest.mark.parametrize("name", ELEMENTS)
def test_momentum_stays(name):
    bodies, model = pair(name)
    errors = []
    for k in (1, 2):
        run = march(model, jo.RK4(step=STEP / k), SPAN)
        first = momentum(bodies, model, run.q[0], run.v[0])
        last = momentum(bodies, model, run.q[-1], run.v[-1])
        scale = [np.abs(x).max() for x in first]
        errors.append(
            max(np.abs(x - y).max() / s for x, y, s in zip(first, last, scale, strict=True))
        )
    assert errors[1] < 1e-7
    assert errors[1] < 1e-11 or orders(errors)[-1] > 3.2


@pytest.mark.parametrize("name", ["spring, table", "damper, table"])
def test_tables_act_as_their_curve_says(name):
    """The work of a spring is the area under its curve; what a damper takes is that of F s' dt."""
    bodies, model = pair(name)
    run = march(model, jo.RK4(step=STEP / 2), SPAN, STEP)
    length, rate = [], []
    for q, v in zip(run.q, run.v, strict=True):
        (qa, va), (qb, vb) = body_states(model, q, v)
        beam = particle_at_end(bodies[0], qa, va)
        A = rotation(qb[3:7])
        eye = np.array([0.1, 0.05, 0.0])
        d = qb[:3] + A @ eye - beam[0]
        dd = vb[:3] + A @ np.cross(vb[3:6], eye) - beam[1]
        length.append(np.linalg.norm(d))
        rate.append(d @ dd / length[-1])
    if name == "spring, table":
        s = np.linspace(0.0, 3.0, 60001)
        area = np.concatenate([[0], np.cumsum(0.5 * (CURVE(s[1:]) + CURVE(s[:-1])) * np.diff(s))])
        found = np.interp(length[0], s, area) - np.interp(length, s, area)
        np.testing.assert_allclose(-run.energy[:, 6], found, atol=1e-6 * np.ptp(found))
    else:
        power = -OIL(rate) * rate
        taken = np.concatenate([[0], np.cumsum(0.5 * (power[1:] + power[:-1]) * STEP)])
        np.testing.assert_allclose(run.energy[:, 4], taken, atol=1e-4 * taken[-1])


def particle_at_end(body, q, v):
    """World position and velocity of the beam's end."""
    Phi = body.reduced.modes[-1]
    A = rotation(q[3:7])
    u = body.reduced.nodes[-1] + Phi @ q[7:]
    return q[:3] + A @ u, v[:3] + A @ (np.cross(v[3:6], u) + Phi @ v[6:])
