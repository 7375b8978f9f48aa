"""Mechanisms that several verification tests run, and a way to march them through time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jousto as jo
from verification.particles import Particles, beam_particles, rigid_particles, rotation

Array = NDArray[Any]

SECTION = jo.Rectangle(0.1, 0.06)
SOFT = jo.Material(E=1.1e9, nu=0.3, rho=7850.0)  # highest mode of `rod` at 309 Hz
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)  # 4.3 kHz
G = np.array([0.0, -9.81, 0.0])


@cache
def rod(material: jo.Material = SOFT, length: float = 1.0, modes: int = 2) -> jo.ReducedPart:
    """A beam of 1 m with an interface at both ends and 8 modes."""
    part = jo.Part.beam(length, SECTION, 6, material, theory=jo.parts.EulerBernoulli(), name="rod")
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=modes))
    # laws hold whatever the modes leave out of a load: nobody shall ask the part for that
    return replace(reduced, source=None)


def particles_of(body: jo.FlexibleBody | jo.RigidBody) -> Particles:
    """Particles of a body made of `rod`, or of a rigid body."""
    if isinstance(body, jo.RigidBody):
        return rigid_particles(body.mass, np.asarray(body.inertia), np.asarray(body.center))
    return beam_particles(body, SECTION, SOFT, lumped=False, rotary=True)


AXES = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.3, 1.0]])


def chain(
    joints: str = "revolute",
    *,
    material: jo.Material = SOFT,
    damping: float = 0.0,
    gravity: Array = G,
    extra: tuple[Any, ...] = (),
    loads: bool = False,
) -> jo.Mechanism:
    """Three flexible beams in space, hinged to the ground, spinning about non-parallel axes.

    `joints` names the connections: "revolute", "spherical", "fixed" (revolute, then fixed, then
    spherical). `loads` adds a following force, a following torque and a world force at markers.
    """
    kinds = {
        "revolute": ("revolute",) * 3,
        "spherical": ("spherical",) * 3,
        "fixed": ("revolute", "fixed", "spherical"),
    }[joints]
    bodies: list[jo.FlexibleBody] = []
    links: list[Any] = []
    at: Any = jo.ground["origin"]
    x, v, w = np.zeros(3), np.zeros(3), np.zeros(3)
    for i, kind in enumerate(kinds):
        axis = AXES[i] / np.linalg.norm(AXES[i])
        if kind == "revolute":
            w = w + (2.0 - 1.4 * i) * axis
        elif kind == "spherical":
            w = w + np.array([0.5, 1.0, -2.0])
        body = jo.FlexibleBody(
            f"rod {i + 1}",
            rod(material),
            damping=damping,
            position=x,
            orientation=jo.Rotate((0.2 * i, 1.0, 0.5), degrees=20.0 * i),
            velocity=v,
            angular_velocity=w,
        )
        name, start = f"joint {i + 1}", body["start"]
        if kind == "revolute":
            links.append(jo.Revolute(name, at, start, axis=axis))
        else:
            links.append((jo.Spherical if kind == "spherical" else jo.Fixed)(name, at, start))
        at = body["end"]
        arm = rotation(np.asarray(body.orientation)) @ [1.0, 0.0, 0.0]
        x, v = x + arm, v + np.cross(w, arm)
        bodies.append(body)
    forces: list[Any] = []
    if loads:
        wave = jo.Harmonic(frequency=2.0, amplitude=1.0, offset=0.3)
        middle = bodies[1]["node4"].turned(jo.Rotate((1, 2, 3), degrees=40.0))
        forces = [
            jo.Force("push", bodies[2]["node3"], (30.0, -20.0, 25.0), follow=True, signal=wave),
            jo.Torque("twist", middle, (6.0, 9.0, -5.0), follow=True),
            jo.Torque("turn", bodies[2]["end"], (-4.0, 6.0, 5.0)),
            jo.Force("pull", bodies[0]["end"], (15.0, 40.0, -30.0)),
        ]
    return jo.Mechanism(
        *bodies,
        *links,
        *forces,
        jo.Gravity(gravity),
        jo.PositionSensor("tip", at),
        *[jo.ReactionSensor(link.name, link) for link in links],
        *extra,
        name=f"chain of {joints} joints",
    )


def loop(material: jo.Material = SOFT) -> jo.Mechanism:
    """Four bodies in a ring, hinged to the ground: not redundant, and its factor has fill.

    The base turns about z; it carries a flexible crank on a revolute joint and a flexible rocker
    on another, and a rigid coupler closes the ring by two spherical joints and a flexible bar.
    """
    corner = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.0), "C": (1.0, 1.0, 0.2), "D": (0.0, 1.0, 0)}
    points = {k: np.array(x) for k, x in corner.items()}
    spin = 1.5 * np.array([0.2, 0.0, 1.0])  # all turn about the pivot at first

    def rigid(name: str, a: str, b: str) -> jo.RigidBody:
        arm = points[b] - points[a]
        return jo.RigidBody(
            name,
            8.0,
            (0.5, 0.7, 0.9),
            center=0.5 * arm + np.array([0.0, 0.05, 0.1]),
            markers={"start": (0.0, 0.0, 0.0), "end": arm},
            position=points[a],
            velocity=np.cross(spin, points[a]),
            angular_velocity=spin,
        )

    def flexible(name: str, a: str, b: str) -> jo.FlexibleBody:
        arm = points[b] - points[a]
        x = arm / np.linalg.norm(arm)
        y = np.cross([0.0, 0.0, 1.0], x)
        y /= np.linalg.norm(y)
        return jo.FlexibleBody(
            name,
            rod(material, float(np.linalg.norm(arm)), 0),
            position=points[a],
            orientation=np.stack([x, y, np.cross(x, y)], axis=1),
            velocity=np.cross(spin, points[a]),
            angular_velocity=spin,
        )

    base = rigid("base", "A", "B")
    crank = flexible("crank", "B", "C")
    coupler = rigid("coupler", "C", "D")
    rocker = flexible("rocker", "A", "D")
    joints = (
        jo.Revolute("pivot", jo.ground["origin"], base["start"], axis=(0.2, 0.0, 1.0)),
        jo.Revolute("base-crank", base["end"], crank["start"], axis=(0.0, 0.3, 1.0)),
        jo.Spherical("crank-coupler", crank["end"], coupler["start"]),
        jo.Spherical("coupler-rocker", coupler["end"], rocker["end"]),
        jo.Revolute("rocker-base", rocker["start"], base["start"], axis=(0.0, 0.0, 1.0)),
    )
    return jo.Mechanism(
        base,
        crank,
        coupler,
        rocker,
        *joints,
        jo.Gravity(G),
        jo.PositionSensor("tip", coupler["end"]),
        *[jo.ReactionSensor(joint.name, joint) for joint in joints],
        name="loop",
    )


def four_bar(material: jo.Material = SOFT, size: float = 1.0) -> jo.Mechanism:
    """A planar crank-rocker of three flexible bars, the crank turning at 6 rad/s.

    Revolute joints at the ground, spherical ones at the coupler: nothing is redundant. The ground
    joints are at (0, 0) and (0.9, 0) m, the crank is 0.25 m, coupler and rocker 0.8 and 0.7 m;
    all times `size`.
    """
    crank, coupler, rocker, ground = 0.25 * size, 0.8 * size, 0.7 * size, 0.9 * size
    A, D = np.zeros(3), np.array([ground, 0.0, 0.0])
    B = np.array([0.0, crank, 0.0])
    # C on both circles, above the line B D
    line = D - B
    reach = float(np.linalg.norm(line))
    along = (coupler**2 - rocker**2 + reach**2) / (2 * reach)
    x = line / reach
    C = B + along * x + np.sqrt(coupler**2 - along**2) * np.array([-x[1], x[0], 0.0])
    # the rates that keep B and C together: crank given, two equations for the others
    w = 6.0
    z = np.array([0.0, 0.0, 1.0])
    vB = np.cross(w * z, B)
    side = np.stack([np.cross(z, C - B)[:2], -np.cross(z, C - D)[:2]], axis=1)
    w2, w3 = np.linalg.solve(side, -vB[:2])

    def body(name: str, a: Array, b: Array, v: Array, rate: float) -> jo.FlexibleBody:
        x = (b - a) / np.linalg.norm(b - a)
        return jo.FlexibleBody(
            name,
            rod(material, round(float(np.linalg.norm(b - a)), 12), 0),
            position=a,
            orientation=np.stack([x, np.cross(z, x), z], axis=1),
            velocity=v,
            angular_velocity=rate * z,
        )

    bars = (
        body("crank", A, B, np.zeros(3), w),
        body("coupler", B, C, vB, float(w2)),
        body("rocker", D, C, np.zeros(3), float(w3)),
    )
    joints = (
        jo.Revolute("crank pivot", jo.ground["origin"], bars[0]["start"], axis=z),
        jo.Spherical("crank pin", bars[0]["end"], bars[1]["start"]),
        jo.Spherical("rocker pin", bars[1]["end"], bars[2]["end"]),
        jo.Revolute("rocker pivot", jo.ground.at(D), bars[2]["start"], axis=z),
    )
    sensors = jo.PositionSensor("tip", bars[1]["end"])
    return jo.Mechanism(*bars, *joints, jo.Gravity(G), sensors, name="four-bar")


@dataclass(frozen=True, eq=False)
class Rows:
    """What `march` stored: every array has the instants first."""

    time: Array
    q: Array
    v: Array
    lam: Array
    energy: Array  # kinetic, strain, potential, springs, dissipated, friction, work
    residuals: Array  # |C|, |Cq v|
    sensors: dict[str, Array]

    @property
    def balance(self) -> Array:
        total = self.energy[:, :4].sum(axis=1)
        return total - total[0] + self.energy[:, 4:6].sum(axis=1) - self.energy[:, 6]

    @property
    def state(self) -> Array:
        return np.concatenate([self.q, self.v], axis=1)


def march(model: Any, solver: Any, t_end: float, output_step: float | None = None) -> Rows:
    """Run a model in memory; rows at 0 and every `output_step` (default: only the end)."""
    steps = round(t_end / solver.step)
    every = steps if output_step is None else round(output_step / solver.step)
    assert abs(steps * solver.step - t_end) < 1e-9 * t_end
    assert steps % every == 0
    engine = jo.model.Engine(model)
    alpha, beta = 0.0, 0.0
    if solver.baumgarte:
        alpha, beta = solver.baumgarte.alpha, solver.baumgarte.beta
    native = engine.native_solver(
        solver.method, solver.step, solver.projection, alpha, beta, **solver.options
    )
    rows = np.zeros((1 + steps // every, engine.row_size))
    rows[0] = engine.row()
    status, written = engine.run(native, steps, every, rows[1:])
    assert status == "ok", f"the engine stopped with status {status}"
    assert written == steps // every
    cuts = np.cumsum([1, model.nq, model.nv, model.nrow, 7, 2, 5])
    time, q, v, lam, energy, residuals, _, out = np.split(rows, cuts, axis=1)
    sensors = {s.name: out[:, s.offset : s.offset + s.count] for s in model.sensors}
    return Rows(time[:, 0], q, v, lam, energy, residuals, sensors)


def body_states(model: Any, q: Array, v: Array) -> list[tuple[Array, Array]]:
    """Split one state into (q, v) of every body."""
    return [(q[b.iq : b.iq + 7 + b.n], v[b.iv : b.iv + 6 + b.n]) for b in model.bodies]


def orders(errors: list[float]) -> Array:
    """Observed orders of errors at steps that halve."""
    e = np.asarray(errors)
    return np.log2(e[:-1] / e[1:])
