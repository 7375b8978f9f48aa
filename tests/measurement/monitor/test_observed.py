"""Watching bodies that vibrate and move with an observer as the twin."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la

import jousto as jo
from jousto.measurement.monitor.health import STATES
from jousto.measurement.monitor.monitor import Monitor
from jousto.measurement.monitor.watch import watch
from jousto.measurement.twin.motion.system import Accelerometer
from measurement.monitor.watched import lines, written

STEEL = jo.Material(2.1e11, 0.3, 7850.0)
PLACES = ("e1.a.top", "e2.a.top", "e4.a.top", "e6.a.top", "e8.a.top")
SPOTS = ("e1.a.bottom", "e3.a.bottom", "e5.b.top")
STEP = 2e-3
NOISE = 1e-6


def held(modes):
    """A cantilever that bends in the plane of its height, 10.4 Hz."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, STEEL)
    reduced = jo.reduction.clamp(
        jo.reduce(part, jo.CraigBampton(("start", "end"), modes=modes)), "start"
    )
    return reduced.keep(reduced.in_plane("xz"))


def rows(part, places):
    S = part.stress
    return np.array([S.modes[S.labels.index(place), 0] for place in places])


def swung(nt, modes=8):
    """Time, part and modes of a cantilever of more modes under an unknown force.

    The force is constant in a step; between its ends the modes move by the exact exponential.
    """
    part = held(modes)
    t = STEP * np.arange(nt)
    f = 2.0 * np.sin(2 * np.pi * 1.3 * t + 1.0) + 1.5 * np.sin(2 * np.pi * 3.1 * t) - 1.0
    tip = part.modes[part.node("end"), 2]
    n, w2 = part.n, part.stiffness
    A = np.zeros((2 * n + 1, 2 * n + 1))
    A[:n, n : 2 * n] = np.eye(n)
    A[n : 2 * n, :n], A[n : 2 * n, n : 2 * n] = -np.diag(w2), -np.diag(0.024 * np.sqrt(w2))
    A[n : 2 * n, -1] = tip
    F = la.expm(A * STEP)
    x = np.zeros(2 * n + 1)
    x[:n] = tip * f[0] / w2
    p = np.empty((nt, n))
    for k in range(nt):
        p[k] = x[:n]
        x[-1] = 0.5 * (f[k] + f[min(k + 1, nt - 1)])
        x = F @ x
    return t, part, p


def shaken(nt=2500, seed=0):
    """Time, strains with noise and stress of the cantilever that is `swung`."""
    rng = np.random.default_rng(seed)
    t, part, p = swung(nt)
    e = p @ rows(part, PLACES).T / STEEL.E
    return t, e + NOISE * rng.standard_normal(e.shape), p @ rows(part, SPOTS).T


def observer(**options):
    """The twin: one mode and its static shape, one force at the tip."""
    part = held(1)
    force = jo.twin.UnknownLoad("end", ("fz",), rate=30.0, size=3.0, smooth=True)
    given = {"loads": [force], "step": STEP, "noise": NOISE} | options
    B = rows(part, PLACES) / STEEL.E
    return jo.twin.Observer(part, B, **given)


def monitor(**options):
    sn = jo.SN(S_D=5e6, N_D=1e6, k=5)
    return Monitor(observer(), held(1), SPOTS, criterion="s11", sn=sn, **options)


def logged(path, t, e):
    return written(path, lines(t, e, digits=6))


def share(found, truth):
    return ((found.low <= truth) & (truth <= found.high)).mean(axis=0)


def same(a, b):
    for name in ("time", "strain", "states", "stress", "low", "high"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    for name in ("peak", "damage", "damage_low", "damage_high"):
        np.testing.assert_array_equal(a.summary(name), b.summary(name), err_msg=name)


def test_stress_of_a_shaken_body_lies_in_its_band(tmp_path):
    t, e, truth = shaken()
    found = watch(monitor(), logged(tmp_path / "d.csv", t, e), tmp_path / "r.h5")
    assert found.channels == ("g1", "g2", "g3", "g4", "g5")
    inside = share(found, truth)
    assert np.all((inside > 0.90) & (inside < 0.99))
    # a blockwise monitor is the observer over the whole record
    whole = observer().run(t, np.round(e, 12))
    again = whole.p @ rows(held(1), SPOTS).T
    np.testing.assert_allclose(found.stress, again, rtol=1e-9, atol=1e-3)


def test_a_dead_channel_is_left_out_and_the_band_is_wider(tmp_path):
    t, e, truth = shaken()
    e[1200:, 0] = e[1200, 0]
    whole = watch(monitor(), logged(tmp_path / "a.csv", *shaken()[:2]), tmp_path / "a.h5")
    found = watch(monitor(), logged(tmp_path / "d.csv", t, e), tmp_path / "r.h5")
    assert {STATES[k] for k in found.states[1260:, 0]} == {"stuck"}
    assert not found.states[:, 1:].any()
    inside = share(found, truth)
    assert np.all((inside > 0.88) & (inside < 0.99))
    assert np.all((found.high - found.low)[-1] > 1.02 * (whole.high - whole.low)[-1])


def test_silence_widens_the_band_and_a_long_pause_does_no_harm(tmp_path):
    t, e, truth = shaken(1500)
    e[600:700] = np.nan
    t[1000:] += 600.0
    found = watch(monitor(), logged(tmp_path / "d.csv", t, e), tmp_path / "r.h5")
    width = found.high - found.low
    assert np.isfinite(found.stress).all()
    assert np.all(width[699] > 3 * width[599])
    assert np.all(share(found, truth) > 0.88)


@pytest.mark.parametrize("cut", [600, 1024])
def test_a_resumed_record_is_the_same_to_the_bit(tmp_path, cut):
    t, e, _ = shaken(1500)
    e[300:400, 2], e[900:1100, 4] = np.nan, 0.05
    text = lines(t, e, digits=6)
    whole = watch(monitor(), written(tmp_path / "d.csv", text), tmp_path / "w.h5")
    target = tmp_path / "r.h5"

    blocks = [0]

    def killed(progress):
        blocks[0] += 1
        if blocks[0] * 512 >= cut:
            raise KeyboardInterrupt

    stopped = watch(monitor(), tmp_path / "d.csv", target, show=killed)
    assert 512 <= len(stopped) < 1500
    found = watch(monitor(), tmp_path / "d.csv", target, resume=True)
    assert found.complete
    same(found, whole)


def test_a_moving_body(tmp_path):
    """An arm that a motor turns, with 3 kg at its tip that the twin does not know."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.04, 0.02), 10, STEEL, name="arm")
    arm = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))

    def mechanism(mass):
        body = jo.FlexibleBody("arm", arm, damping=jo.Rayleigh(0.0, 2e-4))
        hinge = jo.Revolute("hinge", jo.ground["origin"], body["start"], axis=(0, 1, 0))
        turn = jo.Drive("motor", hinge.angle, jo.SCurve((0.1, 0.9), (0.0, -1.2)))
        items = [body, hinge, turn, jo.Gravity((0, 0, -9.81))]
        if mass:
            ball = jo.RigidBody("ball", mass, (1e-3, 1e-3, 1e-3), position=(1, 0, 0))
            items += [ball, jo.Fixed("grip", body["end"], ball["origin"])]
        return jo.Mechanism(*items)

    model = jo.compile(mechanism(3.0))
    rest = jo.equilibrium(model)
    run = jo.simulate(model, 1.2, state=rest, solver=jo.ROS2(2e-4), output_step=STEP)
    t, shape = run.time, run.bodies[0]
    p = run.q[:, shape.q_offset + 7 : shape.q_offset + 7 + shape.n]
    reference = jo.twin.Reference.from_angles(
        mechanism(0.0),
        "arm",
        t,
        {"motor": jo.SCurve((0.1, 0.9), (0.0, -1.2))(t)},
        noise=1e-5,
        node="start",
    )
    twin_part = jo.reduction.clamp(arm, "start")
    load = jo.twin.UnknownLoad("end", ("fz",), rate=1e3, size=100.0, smooth=True)

    def watcher():
        twin = jo.twin.Observer(
            twin_part,
            rows(twin_part, PLACES) / STEEL.E,
            loads=[load],
            step=STEP,
            noise=NOISE,
            damping=jo.Rayleigh(0.0, 2e-4),
            reference=reference,
        )
        return Monitor(twin, twin_part, SPOTS, criterion="s11", sn=jo.SN(S_D=20e6, N_D=1e6, k=5))

    rng = np.random.default_rng(5)
    e = p @ rows(arm, PLACES).T / STEEL.E + NOISE * rng.standard_normal((len(t), len(PLACES)))
    truth = p @ rows(arm, SPOTS).T
    e[300:400, 1] = np.nan
    data = logged(tmp_path / "d.csv", t, e)
    found = watch(watcher(), data, tmp_path / "r.h5")
    inside = share(found, truth)
    error = np.abs(found.stress - truth).max() / np.abs(truth).max()
    assert np.all(inside > 0.90)
    assert error < 0.02

    def killed(progress):
        raise KeyboardInterrupt

    watch(watcher(), data, tmp_path / "k.h5", show=killed)
    same(watch(watcher(), data, tmp_path / "k.h5", resume=True), found)


def test_what_does_not_fit_is_told():
    with pytest.raises(jo.InputError, match=r"has accelerometers \(tip\)"):
        Monitor(observer(accelerometers=[Accelerometer("tip", "end")]), held(1), SPOTS)
    one = observer()
    one.step(0.0, np.zeros(5))
    memory = one.save()
    two = jo.twin.UnknownLoad("end", ("fz", "my"), rate=30.0, size=3.0)
    with pytest.raises(jo.InputError, match="with other loads or channels"):
        observer(loads=[two]).load(memory)
    with pytest.raises(jo.InputError, match=r"'state' has shape \(6,\), must be \(5,\)"):
        observer(loads=[jo.twin.UnknownLoad("end", "fz", rate=30.0, size=3.0)]).load(memory)
    with pytest.raises(jo.InputError, match="has no 'clock'"):
        one.load({"state": np.zeros(3)})
    assert one.time == 0.0
