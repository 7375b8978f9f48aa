"""Many variants of one machine: a study of its numbers beside MuJoCo's batch.

.venv/bin/python benchmarks/variants.py [variants]

Each variant has another mass, stiffness, damping and gravity. Processor time
of one thread, least of several blocks that take turns. The error is that of the place of the tip
at the end, against runs with a sixteenth of the step; MuJoCo's Euler and implicitfast are given as
well with the step that has the error of the Runge-Kutta runs, from their order 1.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray

import jousto as jo

Array = NDArray[np.float64]
SPAN, STEP, EVERY, FINER, BLOCK, ROUNDS = 0.25, 1e-3, 10, 16, 20, 8
LENGTH, MASS, INERTIA, STIFFNESS, DAMPING, WEIGHT = 0.4, 3.0, (1e-3, 0.04, 0.04), 20.0, 0.5, -9.81
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
AXES = {6: (Z, Y, Y, X, Y, X), 30: 15 * (Z, Y)}
NUMBERS = ("mass", "stiffness", "damping", "gravity")


def machine(count: int, values: Array | None = None) -> jo.Mechanism:
    """An arm or chain with a spring and a damper in each joint, declared with these numbers."""
    mass, k, c, g = (MASS, STIFFNESS, DAMPING, WEIGHT) if values is None else values
    items: list[object] = []
    before = jo.ground["origin"]
    for i, axis in enumerate(AXES[count]):
        link = jo.RigidBody(
            f"link{i + 1}",
            mass if i == 2 else MASS,
            INERTIA,
            center=(LENGTH / 2, 0, 0),
            markers={"start": (0, 0, 0), "end": (LENGTH, 0, 0)},
            position=(i * LENGTH, 0, 0),
        )
        joint = jo.Revolute(f"joint{i + 1}", before, link["start"], axis)
        own = (k, c) if i == 1 else (STIFFNESS, DAMPING)
        items += [link, joint, jo.Spring(f"spring{i + 1}", joint.angle, *own)]
        before = link["end"]
    tip = jo.PositionSensor("tip", before)
    return jo.Mechanism(*items, jo.Gravity((0, 0, g)), tip)


def points(count: int) -> Array:
    """Values of the four numbers of some variants."""
    share = np.random.default_rng(0).uniform(0.9, 1.1, (count, len(NUMBERS)))
    return share * [MASS, STIFFNESS, DAMPING, WEIGHT]


def named(count: int, step: float = STEP) -> Callable[[Array], Array]:
    """A study of the numbers of one mechanism."""
    names = ("link3.mass", "spring2.stiffness", "spring2.damping", "gravity.z")
    parameters = [jo.Parameter(name, 1.0) for name in names]
    how = {"t_end": SPAN, "solver": jo.RK4(step), "output_step": STEP * EVERY}
    study = jo.study(machine(count), parameters, [f"last(tip.{x})" for x in "xyz"], **how)
    return study


def declared(count: int) -> Callable[[Array], Array]:
    """A study of a function that declares the machine."""

    def make(mass: float, stiffness: float, damping: float, gravity: float) -> jo.Mechanism:
        return machine(count, np.array([mass, stiffness, damping, gravity]))

    parameters = [jo.Parameter(name, 1.0) for name in NUMBERS]
    how = {"t_end": SPAN, "solver": jo.RK4(STEP), "output_step": STEP * EVERY}
    return jo.study(make, parameters, [f"last(tip.{x})" for x in "xyz"], **how)


def mujoco_text(count: int) -> str:
    """The machine in the words of MuJoCo."""
    text = (
        f'<mujoco><option gravity="0 0 {WEIGHT}"><flag contact="disable" constraint="disable"/>'
        "</option><worldbody>"
    )
    for i, axis in enumerate(AXES[count]):
        place = f"{LENGTH if i else 0} 0 0"
        text += (
            f'<body pos="{place}"><joint axis="{axis[0]} {axis[1]} {axis[2]}" '
            f'stiffness="{STIFFNESS}" damping="{DAMPING}"/><inertial pos="{LENGTH / 2} 0 0" '
            f'mass="{MASS}" diaginertia="{INERTIA[0]} {INERTIA[1]} {INERTIA[2]}"/>'
        )
    text += f'<site name="tip" pos="{LENGTH} 0 0"/>' + count * "</body>"
    return text + '</worldbody><sensor><framepos objtype="site" objname="tip"/></sensor></mujoco>'


def mujoco(count: int, integrator: str, step: float = STEP) -> Callable[[Array], Array]:
    """Its batch: numbers are written into one model, `rollout` runs it."""
    import mujoco as mj
    from mujoco.rollout import rollout

    model = mj.MjModel.from_xml_string(mujoco_text(count))
    model.opt.integrator = getattr(mj.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.opt.timestep = step
    data = mj.MjData(model)
    steps = round(SPAN / step)
    size = mj.mj_stateSize(model, mj.mjtState.mjSTATE_FULLPHYSICS)

    def run(values: Array) -> Array:
        found = []
        for mass, k, c, g in values:
            model.body_mass[3], model.jnt_stiffness[1], model.dof_damping[1] = mass, k, c
            model.opt.gravity[2] = g
            state = np.zeros(size)
            rollout(model, data, state, nstep=steps)
            mj.mj_kinematics(model, data)
            found.append(data.site_xpos[0].copy())
        return np.array(found)

    return run


def main() -> None:
    """Measure and print."""
    warnings.simplefilter("ignore")
    total = int(sys.argv[1]) if len(sys.argv) > 1 else BLOCK * ROUNDS
    for count in AXES:
        X = points(total)
        truth = named(count, STEP / FINER)(X[:BLOCK])
        runs = {"numbers of a mechanism, RK4": named(count), "a function, RK4": declared(count)}
        runs |= {f"MuJoCo, {x}": mujoco(count, x) for x in ("RK4", "Euler", "implicitfast")}
        errors = {name: np.abs(run(X[:BLOCK]) - truth).max() for name, run in runs.items()}
        least = dict.fromkeys(runs, np.inf)
        for block in np.array_split(X, max(1, total // BLOCK)):
            for name, run in runs.items():
                start = time.process_time()
                run(block + 1e-9)
                least[name] = min(least[name], (time.process_time() - start) / len(block))
        print(f"{count} links, {SPAN} s in steps of {STEP} s")
        print(f"{'':30s} {'ms':>8s} {'a second':>8s} {'error':>9s}")
        for name, spent in least.items():
            line = f"{name:30s} {1e3 * spent:8.2f} {1 / spent:8.0f} {errors[name]:9.1e} m"
            ratio = errors[name] / errors["numbers of a mechanism, RK4"]
            if "Euler" in name or "implicit" in name:
                line += f"; {1e3 * spent * ratio:.3g} ms at the error of ours"
            print(line, flush=True)


if __name__ == "__main__":
    main()
