"""Trees of rigid bodies beside MuJoCo, Pinocchio and EXUDYN: microseconds and errors, side by side.

    .venv/bin/python benchmarks/trees.py [quick | short] [former=PYTHON]

Each case is a list of equal links: parent, kind of joint, axis, place of the joint on the parent.
It starts at rest, straight, and falls; what hangs nowhere turns as a whole. Measured, in processor
time, least of several runs:

* ours: one step of classical Runge-Kutta and one of ROS2 in joint coordinates, and of Runge-Kutta
  with `core="maximal"`, the method of version 0.1.0 as it is today; in loops of the engine. An
  evaluation is a quarter of a Runge-Kutta step, which contains four and little else.
* version 0.1.0 itself, where PYTHON is an interpreter that has it (`former.py`).
* MuJoCo: one step of its Runge-Kutta, without contacts and constraints; a loop of its own in C.
* Pinocchio has no integrator: four evaluations of `aba` at bent, moving poses, by
  `abaInParallel` on one thread, a loop of its own in C++. A step of ours with these would cost at
  least that and have the same error.
* EXUDYN: one step of its RK44 on an ObjectKinematicTree, which has no ball joints; the
  difference of two runs of different length, so that what surrounds the loop does not count.

Errors: how far the origin of the last link is, after SPAN with STEP, from where ours in joint
coordinates takes it in steps of a sixteenth. "At equal error" scales the ratio of two times by
(their error / our error)^(1/4), the order of all these steps, where both errors lie above what
rounding leaves. Programs that are not installed are left out, and so are runs of minutes, each with
a sentence below the tables.
Both tables are printed as they stand in docs/benchmarks-trees.md.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jousto as jo
from cases import GRAVITY, LENGTH
from machines import CENTER, INERTIA, MASS

STEP, SPAN, FINER = 2e-3, 0.2, 16  # s, s: of the errors
TIMED, STEPS = 1e-4, 50  # s: the step of the timed runs, small enough for a thousand links
SPIN = np.array([1.0, 2.0, 3.0])  # rad/s, of what hangs nowhere, as one rigid body
ROUNDING = 1e-12  # m, error of a link from rounding, for each m of its distance from the ground
MORE = ("maximal", "0.1.0")  # what else of ours is measured
Array = NDArray[np.float64]
Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


class LeftOut(Exception):
    """Why a program is not measured for a machine."""


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


def mechanism(links: list[Link], *, tip: bool = False) -> jo.Mechanism:
    """The tree under gravity; with a sensor "tip" at the end of the last link if wished."""
    bodies: list[Any] = []
    joints: list[Any] = []
    for k, link in enumerate(links):
        before = jo.ground if link.parent < 0 else bodies[link.parent]
        place = np.asarray(link.at) + np.asarray(before.position)
        w = SPIN if links[0].kind == "free" else np.zeros(3)
        body = jo.RigidBody(
            f"link{k}",
            MASS,
            INERTIA,
            center=CENTER,
            position=place,
            velocity=np.cross(w, place),
            angular_velocity=w,
        )
        bodies.append(body)
        a, b = before.at(link.at), body.at((0, 0, 0))
        if link.kind == "ball":
            joints.append(jo.Spherical(f"joint{k}", a, b))
        elif link.kind == "hinge":
            joints.append(jo.Revolute(f"joint{k}", a, b, link.axis))
    sensors = [jo.PositionSensor("tip", bodies[-1].at((LENGTH, 0.0, 0.0)))] if tip else []
    return jo.Mechanism(*bodies, *joints, jo.Gravity(GRAVITY), *sensors)


def ours(model: jo.Model, method: str, repeats: int, make: Any = None) -> float:
    """Microseconds of a step."""
    engine = (make or jo.model.Engine)(model)
    solver = engine.native_solver(method, TIMED, True)
    rows = np.zeros((2, engine.row_size))
    engine.run(solver, STEPS, STEPS, rows)
    best = np.inf
    for _ in range(repeats):
        count = max(STEPS, 20_000 // len(model.bodies))
        engine.steps_done = 0
        begin = time.process_time()
        engine.run(solver, count, count, rows)
        best = min(best, (time.process_time() - begin) / count)
    return 1e6 * best


def our_place(model: jo.Model, method: str, finer: int = 1, make: Any = None) -> Array:
    """Return where the end of the last link is after SPAN, m."""
    engine = (make or jo.model.Engine)(model)
    steps = finer * round(SPAN / STEP)
    solver = engine.native_solver(method, SPAN / steps, True)
    status, _ = engine.run(solver, steps, steps, np.zeros((2, engine.row_size)))
    r, e = engine.q[-7:-4], engine.q[-4:]
    end = r + LENGTH * np.array(
        [
            1.0 - 2.0 * (e[2] ** 2 + e[3] ** 2),
            2.0 * (e[1] * e[2] + e[0] * e[3]),
            2.0 * (e[1] * e[3] - e[0] * e[2]),
        ]
    )
    return end if status in ("ok", 0) else np.full(3, np.nan)


def mujoco_text(links: list[Link]) -> str:
    children: dict[int, list[int]] = {}
    for k, link in enumerate(links):
        children.setdefault(link.parent, []).append(k)

    def numbers(x: Any) -> str:
        return " ".join(repr(float(v)) for v in x)

    parts = [
        f'<mujoco><option integrator="RK4" timestep="{TIMED}" gravity="{numbers(GRAVITY)}">'
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


def mujoco(links: list[Link], repeats: int) -> tuple[float, Array]:
    """Microseconds of a step, and where the end of the last link is after SPAN with STEP."""
    import mujoco as mj

    try:
        model = mj.MjModel.from_xml_string(mujoco_text(links))
    except ValueError as error:
        if "nesting" not in str(error):
            raise
        raise LeftOut("its reader of models takes no bodies nested so deeply") from None
    data = mj.MjData(model)
    model.opt.timestep = STEP
    if links[0].kind == "free":
        data.qvel[3:6] = SPIN
    mj.mj_step(model, data, nstep=round(SPAN / STEP))
    mj.mj_kinematics(model, data)
    place = data.xpos[-1] + LENGTH * data.xmat[-1].reshape(3, 3)[:, 0]
    mj.mj_resetData(model, data)
    model.opt.timestep = TIMED
    count = max(STEPS, 20_000 // len(links))
    best = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        mj.mj_step(model, data, nstep=count)
        best = min(best, (time.process_time() - begin) / count)
    return 1e6 * best, place


def pinocchio(links: list[Link], repeats: int) -> tuple[float, None]:
    """Microseconds of four evaluations at bent and moving poses; no place: it has no steps."""
    import pinocchio as pin

    pair = len(links) == 1  # its arrays of one row are not taken: two side by side, halved
    links = links * 2 if pair else links
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
    count = max(10, 10_000 // len(links))
    q = np.column_stack(
        [
            pin.integrate(tree, pin.neutral(tree), 0.1 * rng.normal(size=tree.nv))
            for _ in range(count)
        ]
    )
    v, tau = rng.normal(size=(tree.nv, count)), np.zeros((tree.nv, count))
    pool, best, out = pin.ModelPool(tree, 1), np.inf, np.zeros((tree.nv, count))
    for _ in range(repeats):
        begin = time.process_time()
        pin.abaInParallel(1, pool, q, v, tau, out)
        best = min(best, (time.process_time() - begin) / count)
    one = pin.aba(tree, data, q[:, 0], v[:, 0], tau[:, 0])
    if len(links) <= 30:  # mass matrices of long chains are badly conditioned
        assert np.abs(out[:, 0] - one).max() <= 1e-4 * np.abs(one).max()
    return 4e6 * best / (2 if pair else 1), None


def _hinge(pin: Any, axis: tuple[float, float, float]) -> Any:
    kinds = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)
    return kinds[int(np.argmax(axis))]()


def exudyn(links: list[Link], repeats: int) -> tuple[float, Array]:
    """Microseconds of a step, and where the end of the last link is after SPAN with STEP."""
    if any(link.kind != "hinge" for link in links):
        raise LeftOut("its ObjectKinematicTree has no ball joints and no free bodies")
    import exudyn_tree
    from exudyn_peer import exu

    mbs, sensor = exudyn_tree.tree(links)
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.explicit.useLieGroupIntegration = False
    settings.timeIntegration.explicit.computeEndOfStepAccelerations = False
    settings.parallel.numberOfThreads = 1

    def run(step: float, count: int) -> float:
        settings.timeIntegration.numberOfSteps = count
        settings.timeIntegration.endTime = step * count
        begin = time.process_time()
        mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
        return time.process_time() - begin

    run(STEP, round(SPAN / STEP))
    place = np.array(mbs.GetSensorValues(sensor))
    count, repeats = max(STEPS, 20_000 // len(links)), 2 if len(links) >= 100 else repeats
    short, long = (min(run(TIMED, k) for _ in range(repeats)) for k in (count, 3 * count))
    return 1e6 * (long - short) / (2 * count), place


def cases(quick: bool) -> dict[str, list[Link]]:
    counts = (1, 6, 10, 100) if quick else (1, 6, 10, 100, 1000)
    made = {f"revolute chain of {n}": chain("hinge", n) for n in counts}
    made |= {f"ball chain of {n}": chain("ball", n) for n in counts}
    return made | {"six-axis arm": arm(), "figure of 30": figure()}


TOO_SLOW = "steps with {size} coordinates take it minutes"
PEERS: dict[str, tuple[Callable[[list[Link], int], tuple[float, Array | None]], str]] = {
    "mujoco": (mujoco, TOO_SLOW),
    "pinocchio": (pinocchio, "its data take 64 bytes times the cube of {size} coordinates"),
    "exudyn": (exudyn, TOO_SLOW),
}
"""What is measured beside ours, and why a large machine is left out."""


@dataclass(frozen=True)
class Peer:
    """What another program needs for a step, us, and its error, m; nan where not measured."""

    time: float = np.nan
    error: float = np.nan

    def ratio(self, own: float) -> str:
        return "" if np.isnan(self.time) else f"{self.time:.3g} ({self.time / own:.1f})"


def of_then(python: str, case: str) -> tuple[float, Array]:
    """Return microseconds of a step of version 0.1.0, and where the last link is after SPAN."""
    asked = [python, str(Path(__file__).with_name("former.py")), case]
    found = subprocess.run(asked, stdout=subprocess.PIPE, check=True, text=True)
    time, *place = map(float, found.stdout.split())
    return time, np.array(place)


def measured(case: str, links: list[Link], limits: dict[str, int], former: str) -> dict[str, Any]:
    """Times, us, and errors, m, of everything for one machine."""
    made = mechanism(links)
    joint, maximal = (jo.compile(made, core=core) for core in ("joint", "maximal"))
    truth = our_place(joint, "rk4", FINER)

    def off(place: Array) -> float:
        return float(np.abs(place - truth).max())

    found: dict[str, Any] = {
        "joint": Peer(ours(joint, "rk4", 5), off(our_place(joint, "rk4"))),
        "ros2": Peer(ours(joint, "ros2", 5), off(our_place(joint, "ros2"))),
        "maximal": Peer(ours(maximal, "rk4", 3), off(our_place(maximal, "rk4"))),
        "0.1.0": Peer(),
    }
    if former:
        then, place = of_then(former, case)
        found["0.1.0"] = Peer(then, off(place))
    size = len(links) * (1 if all(link.kind == "hinge" for link in links) else 3)
    found["left out"] = []
    for name, (run, too_large) in PEERS.items():
        found[name] = Peer()
        try:
            if size > limits[name]:
                raise LeftOut(too_large.format(size=size))
            theirs, place = run(links, 5)
            # Pinocchio has no place of its own: its step would be ours
            found[name] = Peer(theirs, found["joint"].error if place is None else off(place))
        except (ImportError, LeftOut) as why:
            found["left out"].append(f"{name}: {why}")
    return found


def equal(own: Peer, other: Peer, floor: float) -> float:
    """Return how much longer another program takes for our error."""
    ratio = other.time / own.time
    if np.isfinite(other.error) and min(own.error, other.error) > floor:
        ratio *= (other.error / own.error) ** 0.25
    return ratio


def head(*names: str) -> str:
    return f"| {' | '.join(names)} |\n|{'---|' * len(names)}"


def report(results: dict[str, dict[str, Any]]) -> None:
    """Print both tables, who is left out, and the smallest ratios."""
    more = [key for key in MORE if any(np.isfinite(x[key].time) for x in results.values())]
    heads = "case", "evaluation", "RK4", "ROS2", *more, "MuJoCo", "4 x Pinocchio", "EXUDYN", "best"
    print(head(*heads))
    best, former = {}, {}
    for name, x in results.items():
        own, floor = x["joint"], ROUNDING * LENGTH * x["links"]
        ratios = {p: equal(own, x[p], floor) for p in PEERS if np.isfinite(x[p].time)}
        best[name] = min(ratios.items(), key=lambda r: r[1], default=("", np.nan))
        known = x["0.1.0"] if np.isfinite(x["0.1.0"].time) else x["maximal"]
        former[name] = known.time / own.time
        others = " | ".join(x[p].ratio(own.time) for p in (*more, *PEERS))
        line = f"| {name} | {own.time / 4:.3g} | {own.time:.3g} | {x['ros2'].time:.3g} | {others}"
        print(f"{line} | {best[name][1]:.1f}, {best[name][0]} |" if ratios else f"{line} | |")
    print("\n" + head("error, m", "RK4", "ROS2", *more, "MuJoCo", "EXUDYN"))
    for name, x in results.items():
        keys = ("joint", "ros2", *more, "mujoco", "exudyn")
        errors = ("" if np.isnan(x[k].time) else f"{x[k].error:.0e}" for k in keys)
        print(f"| {name} | {' | '.join(errors)} |")
    print()
    for name, x in results.items():
        if x["left out"]:
            print(f"* {name}: {'; '.join(x['left out'])}.")
    small = [name for name, x in results.items() if x["links"] <= 10]
    if any(np.isfinite(best[name][1]) for name in small):
        worst = min(small, key=lambda name: best[name][1])
        print(
            f"\nUp to 10 links: at least {best[worst][1]:.1f} times as fast a step as the best of "
            f"the others at equal error ({worst}, {best[worst][0]})"
        )
    worst = min(small, key=lambda name: former[name])
    asked = np.isfinite(results[worst]["0.1.0"].time)
    then = "0.1.0" if asked else 'core="maximal", the method of 0.1.0'
    print(f"and {former[worst]:.1f} times as {then} ({worst}).")


def main() -> None:
    quick, short = ("quick" in sys.argv[1:]), ("short" in sys.argv[1:])
    former = next((x.removeprefix("former=") for x in sys.argv if x.startswith("former=")), "")
    # coordinates: beyond, a step of theirs takes a good part of a second, or data more than memory
    limits = {
        "mujoco": 300 if quick else 1000,
        "exudyn": 10 if quick else 100,
        "pinocchio": 300,
    }
    results = {}
    for name, links in cases(quick or short).items():
        if short and len(links) != 6:
            continue
        results[name] = measured(name, links, limits, former) | {"links": len(links)}
    report(results)


if __name__ == "__main__":
    main()
