"""Trees of rigid bodies: our two cores beside MuJoCo and Pinocchio, microseconds and differences.

    .venv/bin/python benchmarks/trees.py [quick]

Each case is a list of equal links: parent, kind of joint, axis, place of the joint on the parent.
It starts at rest, straight, and falls. `step` is one step of classical Runge-Kutta, whose four
evaluations are nearly all it costs, in a loop of the program itself; Pinocchio has none, so that
its column is the time of one evaluation (`aba`, called from Python). `apart` is how far the origin
of the last link is from ours after 50 steps, m. MuJoCo runs without contacts and constraints, and
up to 500 links. Programs that are not installed are left out.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jousto as jo
from cases import GRAVITY, LENGTH
from machines import CENTER, INERTIA, MASS

STEP, STEPS = 1e-4, 50
Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Link:
    """A link and how it hangs on another one (-1: on the ground); kinds "hinge", "ball", "free"."""

    parent: int
    kind: str
    axis: tuple[float, float, float]
    at: tuple[float, float, float]


def chain(kind: str, count: int) -> list[Link]:
    return [
        Link(k - 1, kind, Y if k % 2 else Z, (LENGTH if k else 0.0, 0.0, 0.0)) for k in range(count)
    ]


def arm() -> list[Link]:
    axes = (Z, Y, Y, (1.0, 0.0, 0.0), Y, (1.0, 0.0, 0.0))
    return [
        Link(k - 1, "hinge", axis, (LENGTH if k else 0.0, 0.0, 0.0)) for k, axis in enumerate(axes)
    ]


def figure() -> list[Link]:
    """A free trunk of 4 links with two arms of 6 and two legs of 7."""
    links = [Link(-1, "free", Z, (0.0, 0.0, 0.0))]
    links += [Link(k, "ball", Z, (LENGTH, 0.0, 0.0)) for k in range(3)]
    for start, count, side in ((3, 6, 0.2), (3, 6, -0.2), (0, 7, 0.1), (0, 7, -0.1)):
        parent = start
        for k in range(count):
            kind, at = ("hinge", LENGTH) if k else ("ball", 0.0)
            links.append(Link(parent, kind, Y if k % 2 else Z, (at, 0.0 if k else side, 0.0)))
            parent = len(links) - 1
    return links


def mechanism(links: list[Link]) -> jo.Mechanism:
    bodies: list[Any] = []
    joints: list[Any] = []
    for k, link in enumerate(links):
        before = jo.ground if link.parent < 0 else bodies[link.parent]
        place = np.asarray(link.at) + np.asarray(before.position)
        body = jo.RigidBody(f"link{k}", MASS, INERTIA, center=CENTER, position=place)
        bodies.append(body)
        a, b = before.at(link.at), body.at((0, 0, 0))
        if link.kind == "ball":
            joints.append(jo.Spherical(f"joint{k}", a, b))
        elif link.kind == "hinge":
            joints.append(jo.Revolute(f"joint{k}", a, b, link.axis))
    return jo.Mechanism(*bodies, *joints, jo.Gravity(GRAVITY))


def ours(model: jo.Model, repeats: int) -> tuple[float, NDArray[np.float64]]:
    """Microseconds of a step, and where the last link is after STEPS."""
    engine = jo.model.Engine(model)
    solver = engine.native_solver("rk4", STEP, True)
    rows = np.zeros((2, engine.row_size))
    engine.run(solver, STEPS, STEPS, rows)
    place = engine.q[-7:-4].copy()
    best = np.inf
    for _ in range(repeats):
        count = max(STEPS, 20_000 // len(model.bodies))
        engine.steps_done = 0
        begin = time.process_time()
        engine.run(solver, count, count, rows)
        best = min(best, (time.process_time() - begin) / count)
    return 1e6 * best, place


def mujoco_text(links: list[Link]) -> str:
    children: dict[int, list[int]] = {}
    for k, link in enumerate(links):
        children.setdefault(link.parent, []).append(k)

    def numbers(x: Any) -> str:
        return " ".join(repr(float(v)) for v in x)

    parts = [
        f'<mujoco><option integrator="RK4" timestep="{STEP}" gravity="{numbers(GRAVITY)}">'
        '<flag contact="disable" constraint="disable"/></option><worldbody>'
    ]
    waiting = [(k, False) for k in reversed(children[-1])]
    while waiting:
        k, done = waiting.pop()
        if done:
            parts.append("</body>")
            continue
        link = links[k]
        parts.append(f'<body name="link{k}" pos="{numbers(link.at)}">')
        parts.append(f'<joint type="{link.kind}" axis="{numbers(link.axis)}"/>')
        parts.append(
            f'<inertial pos="{numbers(CENTER)}" mass="{MASS!r}" diaginertia="{numbers(INERTIA)}"/>'
        )
        waiting.append((k, True))
        waiting += [(j, False) for j in reversed(children.get(k, []))]
    return "".join([*parts, "</worldbody></mujoco>"])


def mujoco(links: list[Link], repeats: int) -> tuple[float, NDArray[np.float64]]:
    import mujoco as mj

    model = mj.MjModel.from_xml_string(mujoco_text(links))
    data = mj.MjData(model)
    mj.mj_step(model, data, nstep=STEPS)
    mj.mj_kinematics(model, data)
    place = np.array(data.xpos[-1])
    count = max(STEPS, 20_000 // len(links))
    best = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        mj.mj_step(model, data, nstep=count)
        best = min(best, (time.process_time() - begin) / count)
    return 1e6 * best, place


def pinocchio(links: list[Link], repeats: int) -> float:
    """Microseconds of one evaluation at a bent and moving pose."""
    import pinocchio as pin

    tree = pin.Model()
    tree.gravity.linear = np.array(GRAVITY)
    places: list[int] = []
    for k, link in enumerate(links):
        kinds = {"ball": pin.JointModelSpherical, "free": pin.JointModelFreeFlyer}
        kind = kinds[link.kind]() if link.kind in kinds else _hinge(pin, link.axis)
        parent = 0 if link.parent < 0 else places[link.parent]
        place = pin.SE3(np.eye(3), np.array(link.at))
        joint = tree.addJoint(parent, kind, place, f"joint{k}")
        tree.appendBodyToJoint(
            joint, pin.Inertia(MASS, np.array(CENTER), np.diag(INERTIA)), pin.SE3.Identity()
        )
        places.append(joint)
    data, rng = tree.createData(), np.random.default_rng(1)
    q = pin.integrate(tree, pin.neutral(tree), 0.1 * rng.normal(size=tree.nv))
    v, tau = rng.normal(size=tree.nv), np.zeros(tree.nv)
    best, count = np.inf, max(10, 10_000 // len(links))
    for _ in range(repeats):
        begin = time.process_time()
        for _ in range(count):
            pin.aba(tree, data, q, v, tau)
        best = min(best, (time.process_time() - begin) / count)
    return 1e6 * best


def _hinge(pin: Any, axis: tuple[float, float, float]) -> Any:
    kinds = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)
    return kinds[int(np.argmax(axis))]()


def cases(quick: bool) -> dict[str, list[Link]]:
    counts = (1, 6, 10, 100) if quick else (1, 6, 10, 100, 1000)
    made = {f"revolute chain of {n}": chain("hinge", n) for n in counts}
    made |= {f"ball chain of {n}": chain("ball", n) for n in counts}
    return made | {"six-axis arm": arm(), "figure of 30": figure()}


def main() -> None:
    quick = "quick" in sys.argv[1:]
    print(
        "us: step joint, step maximal (ratio) | MuJoCo step (ratio), apart m | Pinocchio evaluation"
    )
    for name, links in cases(quick).items():
        made = mechanism(links)
        one, place = ours(jo.compile(made, core="joint"), 5)
        other, q = ours(jo.compile(made, core="maximal"), 3)
        apart = np.abs(place - q).max()
        line = f"{name:24} {one:9.2f} {other:9.2f} ({other / one:4.1f}) {apart:8.1e}"
        try:
            if len(links) > 500:  # seconds a step
                raise ImportError
            theirs, r = mujoco(links, 3)
            line += f" | {theirs:10.2f} ({theirs / one:5.1f}) {np.abs(place - r).max():8.1e}"
        except ImportError:
            line += " | -"
        try:
            theirs = pinocchio(links, 5)
            line += f" | {theirs:8.2f}, a quarter of our step {one / 4:8.2f}"
        except ImportError:
            line += " | -"
        print(line, flush=True)


if __name__ == "__main__":
    main()
