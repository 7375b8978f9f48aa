"""A machine that is exported in tests, and what the engine computes of it."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import jousto as jo
from jousto.export.program import program
from jousto.export.project import flat_files, one_file
from jousto.export.toolchain import with_includes
from jousto.simulation.solvers.base import Solver

CC = shutil.which("cc")
WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror")
FLAGS = ("-O1", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off")
PLAIN = ("-O0", "-ffp-contract=off")
"""For what need not be the bits of the engine: a quarter of the time to compile."""
STEP = 1e-3


def swinging_arm() -> jo.Mechanism:
    """Return a driven flexible arm with friction that sticks, a spring, a controller, an event and
    damage."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.025), 4, steel)
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=3)))
    ball = jo.RigidBody.sphere("ball", 0.05, mass=2.0, position=(1.0, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    hold = jo.Fixed("hold", arm["end"], ball["center"])
    drive = jo.JointForce("drive", pin.angle, jo.Input("push", 1.5))
    spring = jo.Spring.between("spring", jo.ground.at((0.5, 0, 1.0)), arm["end"], stiffness=300.0)
    rub = jo.Friction(
        "rub", pin, mu_kinetic=0.2, mu_static=0.3, radius=0.02, law=jo.mechanism.StickSlip()
    )
    steady = jo.mechanism.PID("steady", pin.angle, 0.05, kp=4.0, ki=30.0, kd=0.5, limit=2.5)
    tip = jo.PositionSensor("tip", ball["center"])
    stress = jo.StressSensor("stress", arm, "e1.a.top")
    steel_curve = jo.SN(S_D=100e6, N_D=1e6, k=5)
    life = jo.mechanism.DamageSensor(
        "life", stress, steel_curve, residue="half", components="e1.a.top:s11"
    )
    low = jo.mechanism.Event("low", tip, component="z", threshold=-0.2)
    gravity = jo.Gravity((0, 0, -9.81))
    loads = [
        jo.mechanism.BodyLoadSensor(kind, arm, kind)
        for kind in ("joint", "applied", "friction", "damping")
    ]
    return jo.Mechanism(
        *(arm, ball, pin, hold, drive, spring, rub, steady, tip, stress, life, low, gravity),
        *(*loads, jo.mechanism.ModalLoadSensor("inertia", arm, "inertia")),
    )


def reaching_arm() -> jo.Mechanism:
    """Return a rigid tree with a link of every kind, all kinds of forces, an event and damage."""
    J = (0.1, 0.15, 0.2)
    ground = jo.ground
    parts = [
        jo.RigidBody(name, 1.5, J, center=(0.3, 0.05, 0), position=(0.6 * k, 0, 0))
        for k, name in enumerate(("base", "upper", "rod", "tube", "cross", "hand", "plate"))
    ]
    base, upper, rod, tube, cross, hand, plate = parts
    kite = jo.RigidBody.sphere("kite", 0.1, mass=0.8, position=(3.0, 1.0, 0.5))

    def ends(one: jo.RigidBody, other: jo.RigidBody) -> tuple[object, object]:
        return one.at((0.6, 0, 0)), other.at((0, 0, 0))

    turn = jo.Revolute("turn", ground["origin"], base["origin"], axis=(0, 0, 1))
    lift = jo.Revolute("lift", *ends(base, upper), axis=(0, 1, 0))
    slide = jo.Prismatic("slide", *ends(upper, rod)[::-1], axis=(1, 0.2, 0))
    twist = jo.Cylindrical("twist", *ends(rod, tube), axis=(0.1, 1, 0.3))
    pivot = jo.Universal("pivot", *ends(tube, cross), axis_a=(0, 1, 0), axis_b=(0, 0, 1))
    ball = jo.Spherical("ball", *ends(cross, hand))
    weld = jo.Fixed("weld", *ends(hand, plate))
    swing = jo.Harmonic(amplitude=0.4, frequency=1.0)
    tip = jo.PositionSensor("tip", plate.at((0.6, 0, 0)))
    held = jo.ReactionSensor("held", lift)
    low = jo.mechanism.Event("low", tip, component="z", threshold=-0.3)
    life = jo.mechanism.DamageSensor(
        "life", held, jo.SN(S_D=100e6, N_D=1e6, k=5), residue="half", components="Mx", factor=1e6
    )
    return jo.Mechanism(
        *(*parts, kite, turn, lift, slide, twist, pivot, ball, weld),
        jo.Drive("yaw", turn.angle, swing),
        jo.JointForce("push", lift.angle, jo.Input("push", -12.0)),
        jo.Spring("stay", slide.coordinates[0], stiffness=900.0, damping=4.0),
        jo.Servo("servo", lift.angle, jo.Harmonic(amplitude=0.2, frequency=2.0), kp=40.0, kd=2.0),
        jo.mechanism.PID(
            "steady", slide.coordinates[0], 0.004, kp=300.0, ki=900.0, kd=6.0, limit=20.0
        ),
        jo.mechanism.SpeedPID(
            "spin", twist.coordinates[1], 0.3, kp=0.4, ki=3.0, filter=0.01, kd=0.01
        ),
        jo.mechanism.Stop("end", slide.coordinates[0], -0.01, 0.01, stiffness=4e3, speed=0.5),
        jo.mechanism.RigidStop("nod", pivot.coordinates[1], -0.02, 0.05, restitution=0.6),
        jo.mechanism.Lock("catch", pivot.coordinates[0], low),
        jo.mechanism.Contact(
            *("touch", jo.ground["origin"], jo.mechanism.HollowSphere(3.64)),
            *(weld.b, jo.mechanism.Sphere(0.05), jo.mechanism.PowerLaw(1e3)),
            mu_kinetic=0.3,
        ),
        jo.mechanism.Contact(
            *("lid", jo.ground.at((3.0, 1.0, 0.0)), jo.mechanism.Cuboid((0.6, 0.6, 0.6))),
            *(kite["origin"], jo.mechanism.Capsule(0.2, 0.06), jo.mechanism.PowerLaw(1e3)),
        ),
        jo.mechanism.PlasticSpring(
            *("shear pin", lift.angle, 60.0, 1.5),
            kinematic=30.0,
            recovery=4.0,
            isotropic=5.0,
            saturation=0.5,
            rate=20.0,
        ),
        jo.mechanism.GearSpring(
            *("spindle", slide.coordinates[0], twist.coordinates[1], -40.0),
            law=None,
            stiffness=300.0,
            damping=2.0,
        ),
        jo.Spring("coil", twist.coordinates[1], stiffness=12.0, damping=0.3),
        jo.Spring.between("line", plate.at((0.6, 0, 0)), kite["origin"], 30.0, damping=0.5),
        jo.Bushing("pad", ground.at((2, 0, 0)), cross.at((0, 0, 0)), (40, 40, 40, 1, 1, 1), 0.5),
        *(tip, held, low, life, jo.AccelerationSensor("felt", hand.at((0.1, 0, 0)))),
        *(jo.ReactionSensor("yaw_torque", turn), jo.CoordinateSensor("lifted", lift.angle)),
        jo.Gravity((0, 0, -9.81)),
        name="reaching arm",
    )


def objects() -> Path:
    """Return the folder of what was compiled in this run of the tests, by all of its processes."""
    return Path(os.environ["JOUSTO_CACHE"]) / "programs"


def compiled(folder: Path, *sources: str, flags: tuple[str, ...] = FLAGS) -> Path:
    """Compile files and link a program; what was compiled before is taken as it was made."""
    out = folder / "program"
    texts = {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.[ch]")}
    parts = [f"{name}.o" for name in sources]
    for name, part in zip(sources, parts, strict=True):
        words = (*flags, name, *with_includes(texts, name))
        key = hashlib.sha256(repr(words).encode()).hexdigest()
        known = objects() / f"{key}.o"
        if not known.exists():
            run(folder, *WARNINGS, *flags, "-I.", "-c", name, "-o", part)
            known.parent.mkdir(exist_ok=True)
            beside = known.with_name(f"{key}.{os.getpid()}")
            shutil.copyfile(folder / part, beside)
            beside.replace(known)
        else:
            shutil.copyfile(known, folder / part)
    run(folder, *flags, *parts, "-o", str(out), "-lm")
    return out


def rows_of(model: jo.Model, solver: Solver | None, folder: Path, *arguments: str) -> np.ndarray:
    """Return what the program of a machine prints, not optimised, its engine compiled once."""
    made = program(model, solver, name="plant")
    files = flat_files(made, "main.c")
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = [name for name in files if name.endswith(".c")]
    found = table(compiled(folder, *sources, flags=("-DJO_NO_ALLOCATION", *PLAIN)), *arguments)
    # in one file none of its names may be one of the engine
    names = {re.sub(r"\d+", "", x) for x in re.findall(r"^static .*?(\w+)\[", made.source, re.M)}
    known = objects() / hashlib.sha256(repr(sorted(names)).encode()).hexdigest()
    if not known.exists():
        (folder / "alone.c").write_text(one_file(made, "main.c"), encoding="utf-8")
        run(folder, *WARNINGS, "-DMAIN", "-fsyntax-only", "alone.c")
        known.touch()
    return found


def run(folder: Path, *words: str) -> None:
    """Run the compiler in a folder."""
    done = subprocess.run([str(CC), *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def table(program: Path, *arguments: str) -> np.ndarray:
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=True)
    return np.array([[float(x) for x in row.split(",")] for row in done.stdout.splitlines()[1:]])


def expected(model: jo.Model, run: jo.Solution) -> np.ndarray:
    values = [run[sensor.name] for sensor in model.sensors]
    return np.concatenate([run.time[:, None], *values], axis=1)


def engine_rows(
    folder: Path,
    end: float,
    rows: int,
    machine: str = "swinging_arm",
    core: str = "auto",
    solver: str = "ROS2",
) -> np.ndarray:
    """Return time and sensors of a run in the baseline engine, in a process of its own."""
    code = (
        "import sys, numpy as np, jousto as jo\n"
        "sys.path.insert(0, sys.argv[1])\n"
        "import exported as t\n"
        "m = jo.compile(getattr(t, sys.argv[5])(), core=sys.argv[6])\n"
        "end, rows = float(sys.argv[2]), int(sys.argv[3])\n"
        "made = getattr(jo.simulation, sys.argv[7], None) or getattr(jo, sys.argv[7])\n"
        "run = jo.simulate(m, end, solver=made(step=t.STEP), output_step=end / rows)\n"
        "np.save(sys.argv[4], t.expected(m, run))\n"
    )
    out = folder / "rows.npy"
    given = [str(Path(__file__).parent), repr(end), str(rows), str(out), machine, core, solver]
    environment = {**os.environ, "JOUSTO_CPU": "baseline"}
    subprocess.run([sys.executable, "-c", code, *given], env=environment, check=True)
    found: np.ndarray = np.load(out)
    return found
