"""One object of nearly every public kind, as a working day leaves them behind."""

from __future__ import annotations

import atexit
import shutil
import warnings
from functools import cache
from operator import attrgetter
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np

import jousto as jo
from jousto.base.lazy_exports import public_names
from jousto.planar.dynamics import simulate_planar
from jousto.planar.items import PlanarBeam, PlanarLoad, PlanarSupport
from jousto.planar.methods import PlanarGeneralizedAlpha
from jousto.planar.section import PlanarSection
from jousto.planar.statics import load_steps
from measurement.monitor import watched
from verification.boxes import ring
from verification.solids import mesh

Objects = dict[str, Any]
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
EXAMPLES = Path(__file__).parents[1] / "examples"


@cache
def objects() -> Objects:
    """Return the objects by name; made once, in some seconds."""
    found: Objects = {}
    folder = mkdtemp(prefix="jousto-session-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        for stage in (
            parts,
            machine,
            statics,
            stress,
            life,
            contact,
            twins,
            planar,
            optimisation,
            studies,
            reliability,
            robots,
        ):
            found |= stage(found, Path(folder))
    return found


def public() -> Objects:
    """Return everything public by its place, as ``jo.fatigue.rainflow``."""
    return {place: attrgetter(place.removeprefix("jo."))(jo) for place in public_names()}


def parts(_: Objects, __: Path) -> Objects:
    """Parts, meshes and what reduction says of them."""
    beam = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.04), 4, STEEL, name="bar")
    reduced = jo.reduce(beam, jo.CraigBampton(("start", "end"), modes=4))
    pipe = mesh(ring("hexahedron20", (0.04, 0.05), 0.05, (1, 24, 1)))
    bore = pipe.holes()[0]
    solid = jo.Part.solid(pipe, STEEL, name="pipe").with_interfaces(
        jo.Interface("bore", bore.nodes)
    )
    supported = jo.reduction.clamp(beam, ["start", jo.reduction.SpringSupport("end", [1e5] * 6)])
    return {
        "beam": beam,
        "reduced": reduced,
        "supported": supported,
        "supported modes": supported.modes(2),
        "supported state": supported.statics(jo.parts.Weight((0, 0, -9.81))),
        "mesh": pipe,
        "hole": bore,
        "quality": pipe.quality(),
        "solid": solid,
        "reduced solid": jo.reduce(solid, jo.CraigBampton(("bore",), modes=2)),
        "mesh error": jo.parts.mesh_error(solid, 1e-6 * np.sin(np.arange(solid.M.shape[0]))),
        "certificate": jo.certificate.certify(beam, reduced),
        "advice": jo.certificate.advise(beam, ("start", "end"), frequency_limit=500.0),
        "memory": jo.reduction.memory_estimate(beam, jo.CraigBampton(("start",), modes=4)),
        "relief": jo.reduction.inertia_relief(beam, np.ones((beam.M.shape[0], 1))),
        "solvers": jo.reduction.solvers(),
        "reading loss": jo.design.reading_loss([0.0, 1.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.9, 0.0]),
        "ground": jo.ground,
    }


def machine(found: Objects, folder: Path) -> Objects:
    """A swinging bar with sensors of many kinds, its run and what is known of its model."""
    arm = jo.FlexibleBody("arm", found["reduced"], damping=0.02)
    ball = jo.RigidBody.sphere("ball", 0.1, mass=1.0, position=(1.0, 0.0, 0.0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    wrist = jo.Revolute("wrist", arm["end"], ball["origin"], axis=(0, 1, 0))
    tip = jo.PositionSensor("tip", ball["origin"])
    grip = jo.Friction("grip", wrist, 0.1, radius=0.02)
    low = jo.mechanism.Event("low", hinge.angle, 0.3)
    mechanism = jo.Mechanism(
        *(arm, ball, hinge, wrist, grip, low, tip),
        jo.Gravity((0.0, 0.0, -9.81)),
        jo.Spring("spring", hinge.angle, 10.0),
        jo.Force("push", arm["end"], (0.0, 0.0, 1.0), signal=jo.Input("push")),
        jo.ReactionSensor("pin", hinge),
        jo.gauges.Gauge("top", arm, "e1.a.top"),
        jo.StressSensor("stress", arm, ("e1.a.top", "e1.a.bottom")),
        name="swing",
    )
    model = jo.compile(mechanism)
    return {
        "mechanism": mechanism,
        "expression": jo.mechanism.rate(hinge.angle),
        "model": model,
        "engine": jo.model.Engine(model),
        "doctor": jo.doctor(model),
        "run": jo.simulate(model, 0.3, output_step=1e-3),
        "filed": jo.simulate(model, 0.1, output_step=1e-3, path=folder / "run.h5"),
        "simulator": jo.simulation.Simulator(model),
        "vibration free": jo.simulation.vibration_free_state(model),
        "fallen": jo.natural.moving_frame(falling(), 2e-3),
        "step times": jo.export.StepTimes(
            "machine", 1e-3, 1000, 2e-6, 9e-6, np.array([2e-6, 9e-6]), np.array([990, 10]), 4096
        ),
        "verification": jo.verify(falling(), 2e-3),
        "driven": jo.compile(jo.read_model(EXAMPLES / "four_bar.yaml", rigid=True).mechanism),
        "file": jo.read_model(EXAMPLES / "flexible_pendulum.yaml"),
        "flexibility": jo.design.advise_flexibility(mechanism, 0.02, output_step=1e-3),
    }


def falling() -> jo.Mechanism:
    """A ball on a rod."""
    ball = jo.RigidBody("ball", 1.0, (1, 1, 1), position=(1, 0, 0))
    rod = jo.Rod("rod", jo.ground["origin"], ball["origin"])
    sensor = jo.PositionSensor("place", ball["origin"])
    return jo.Mechanism(ball, rod, jo.Gravity((0, -9.81, 0)), sensor, name="fall")


def statics(_: Objects, __: Path) -> Objects:
    """A shallow arch of exact beams: equilibria, modes, buckling, paths, section forces."""
    angles = np.linspace(0.18, -0.18, 7)
    points = np.column_stack([np.sin(-angles), np.cos(angles) - np.cos(0.18), 0.0 * angles])
    arch = jo.BeamBody("arch", points, jo.Rectangle(0.01, 0.03), STEEL, up=(0, 0, 1))
    left, right = (jo.ground.at(points[k]) for k in (0, -1))
    model = jo.compile(
        jo.Mechanism(
            arch,
            jo.Revolute("left", left, arch["start"], axis=(0, 0, 1)),
            jo.Revolute("right", right, arch["end"], axis=(0, 0, 1)),
            jo.Force("press", arch["node4"], (0, -1, 0), signal=jo.Input("load")),
            jo.PositionSensor("crown", arch["node4"]),
        )
    )
    rest = jo.equilibrium(model)
    run = jo.simulate(model, 0.01, state=rest, inputs={"load": 100.0})
    return {
        "arch": arch,
        "beam model": model,
        "rest": rest,
        "linear": jo.simulation.linearise(model, rest),
        "modes": jo.modes(model, rest),
        "buckling": jo.simulation.buckling(model, "load", 1),
        "path": jo.simulation.load_path(model, "load", to=1e4, steps=5),
        "campbell": jo.simulation.campbell(lambda _: model, [1.0, 2.0]),
        "beam run": run,
        "section forces": jo.recovery.section_forces(run, "arch"),
        "beam field": jo.stress_field(run, "arch"),
    }


def stress(found: Objects, _: Path) -> Objects:
    """Fields, hot spots, their error, comparison with what was measured."""
    run = found["run"]
    field = jo.stress_field(run, "arm")
    spots = jo.hot_spots(run)
    return {
        "field": field,
        "envelope": field.envelope("von-mises"),
        "spots": spots,
        "spot": spots[0],
        "budget": jo.recovery.error_budget(spots),
        "record": jo.gauges.record_of(run),
        "alignment": jo.gauges.align(jo.gauges.record_of(run), run, "tip.x"),
        "compared": jo.gauges.compare_gauges(run, jo.gauges.record_of(run), align=False),
        "rosette": jo.gauges.rosette_state([200e-6, 80e-6, -50e-6], E=210e9, nu=0.3),
        "friction": jo.recovery.friction_stress(run, run, "arm"),
        "loads": (found := jo.recovery.loads_of(run, "arm")),
        "load": found.loads[0],
        "body motion": found.motion,
    }


def life(found: Objects, _: Path) -> Objects:
    """Cycles, damage and life by every method."""
    field, curve = found["field"], jo.sn_curve("fat71")
    notch, cycles = (
        jo.fatigue.strain_life("sae-1045"),
        jo.fatigue.rainflow([0.0, 3e8, -1e8, 2e8], residue="half"),
    )
    duty = jo.fatigue.DutyCycle([(field, 100, "swing")])
    frequency = np.linspace(1.0, 300.0, 40)
    response = jo.fatigue.random_response(
        found["reduced"], frequency, np.ones(40), base="start", direction=(0, 0, 1)
    )
    s = np.zeros((50, 6))
    s[:, 0] = 1e8 * np.sin(np.arange(50))
    return {
        "curve": curve,
        "notch": notch,
        "cycles": cycles,
        "matrix": cycles.matrix(8),
        "duty": duty,
        "damage field": jo.damage_field(field, curve, residue="half", required=1e6),
        "assessment": jo.fatigue.assess(cycles, curve),
        "critical plane": jo.fatigue.critical_plane(s, jo.fatigue.Findley(0.3)),
        "multiaxial": jo.fatigue.multiaxial(
            field, jo.fatigue.DangVan.of(1e8, 1.5e8), sites=field.labels[:3]
        ),
        "plane damage": jo.fatigue.plane_damage(s, jo.fatigue.Findley(0.3), curve, residue="half"),
        "local cycles": jo.fatigue.local_cycles(s[:, 0], notch, residue="half"),
        "hinge cycles": jo.fatigue.hinge_cycles([0.0, 1.0, -1.0, 1.0], [0.0, 0.1, -0.1, 0.1]),
        "local path": jo.fatigue.local_path(s[:, 0], notch),
        "strain damage": jo.fatigue.strain_damage(
            field, notch, residue="half", sites=field.labels[:2]
        ),
        "response": response,
        "spectral life": response.damage(curve),
        "spectral": jo.fatigue.spectral_damage(frequency, np.full(40, 1e12), curve),
    }


def contact(_: Objects, __: Path) -> Objects:
    """A wheel that rolls."""
    hertz = jo.fatigue.hertz_line(10e3, length=0.03, radius=0.1, material=STEEL)
    depths = [3e-4, 6e-4]
    return {
        "hertz": hertz,
        "rolling": jo.fatigue.rolling_contact(hertz, depths),
        "rolling life": jo.fatigue.rolling_life(
            hertz, [8e3], jo.fatigue.DangVan.of(3e8, 4e8), depths=depths
        ),
    }


def twins(_: Objects, folder: Path) -> Objects:
    """Estimates from gauges, observer, monitor and its record."""
    reduced, B = watched.cantilever()
    t, _p, e = watched.motion(300)
    twin = jo.twin.Reconstruction(B, noise=1e-6)
    load = jo.twin.UnknownLoad("node11", "fz", rate=100.0, size=10.0, smooth=True)
    observer = jo.twin.Observer(reduced, B, loads=[load], step=1e-2, noise=1e-6, damping=0.01)
    observed = observer.run(t, e)
    estimate = twin.estimate(e)
    monitor = watched.monitor(sn=watched.curve())
    data = watched.written(folder / "d.csv", watched.lines(t, e))
    return {
        "twin": twin,
        "estimate": estimate,
        "weighed": jo.twin.weigh_modes(B, e, reduced),
        "band": jo.twin.stress_band(estimate, reduced, "s11", sites=watched.SPOTS),
        "placement": jo.twin.place_gauges(reduced, 3),
        "load": load,
        "observer": observer,
        "observed": observed,
        "innovation": jo.twin.innovation_test(observed),
        "step": observer.step(0.0, e[0]),
        "damage band": jo.twin.damage_band(
            observed, reduced, watched.curve(), residue="half", sites=watched.SPOTS[:1], draws=20
        ),
        "monitor": monitor,
        "watched": jo.monitor.watch(monitor, data, folder / "watched.h5"),
    }


def optimisation(_: Objects, __: Path) -> Objects:
    """A mass on a spring whose stiffness is sought."""
    problem = jo.design.StructureProblem(
        [jo.Parameter("k", 20.0, bounds=(5.0, 50.0))],
        lambda v: (np.eye(1), np.array([[v["k"]]])),
        lambda t: np.ones((1, len(t))),
        np.linspace(0, 1, 21),
        lambda v: v["k"],
        [jo.design.DisplacementLimit("structure", 0.1, "1")],
    )
    found = jo.design.optimise(problem)
    return {"problem": problem, "optimum": found, "place": found.active[0][0]}


def turn(mass: float) -> jo.Mechanism:
    """A pendulum; a function of the module, so that processes can call it."""
    bob = jo.RigidBody("bob", mass, (0.01, 0.01, 0.01), position=(1.0, 0.0, 0.0))
    return jo.Mechanism(
        bob,
        jo.Revolute("pivot", jo.ground["origin"], bob.at((-1.0, 0.0, 0.0)), axis=(0, 0, 1)),
        jo.Gravity((0.0, -9.81, 0.0)),
        jo.PositionSensor("place", bob["origin"]),
    )


def studies(_: Objects, __: Path) -> Objects:
    """A study of three points, what is wanted of it and one of its points."""
    cases: list[object] = []

    def seen(case: object) -> float:
        cases.append(case)
        return 1.0

    wanted = jo.design.Function("seen", seen, of="case")
    made = jo.study(
        turn,
        jo.Parameter("mass", 2.0, bounds=(1.0, 3.0), unit="kg"),
        ["min(place.y)", wanted],
        samples=3,
        t_end=0.05,
    )
    return {
        "study": made,
        "study table": made.table,
        "gradient": jo.design.gradient(made, outcomes="min(place.y)"),
        "outcome": jo.design.read_outcome("min(place.y)"),
        "case": cases[0],
        "values": (weighed := jo.design.Values({"mass": (2.1, 0.1)})),
        "modal": jo.design.Modal([1.0]),
        "experiment": jo.design.Experiment(
            jo.gauges.Record([0.0, 0.1], {"y": [0.0, 0.1]}, {"y": "m"}, "record")
        ),
        "identified": jo.design.identify(turn, jo.Parameter("mass", 2.0, unit="kg"), weighed),
    }


def reliability(_: Objects, __: Path) -> Objects:
    """A strength against a load: indices, samples and a reliable design."""
    design = jo.design
    pair = [
        design.Random(name, design.distribution_from_moments("normal", 5.0, 1.0)) for name in "ab"
    ]

    def safe(x: Any) -> Any:
        return x["a"] + x["b"] - 6.0

    found = design.form(safe, pair)
    return {
        "variable": pair[0],
        "form": found,
        "sorm": design.sorm(safe, pair),
        "pma": design.pma(safe, pair, 2.0),
        "ria": design.ria(safe, pair, 2.0),
        "sampled": design.monte_carlo(safe, pair, samples=200, seed=1),
        "linearisation": design.check_linearisation(found, samples=200),
        "limit state": design.LimitState(safe, name="safe"),
        "system": design.system([safe, lambda x: x["a"] - 2.0], pair, samples=200),
        "reliable": design.rbdo(
            lambda d: d["a"], [safe], pair, {"a": (1.0, 20.0)}, 2.0, start={"a": 10.0}
        ),
    }


def planar(_: Objects, __: Path) -> Objects:
    """A planar frame, its path and run."""
    strip = PlanarSection.of(jo.Rectangle(0.002, 0.02), STEEL)
    frame = jo.planar.PlanarFrame(
        [(0.25 * i, 0.0) for i in range(5)],
        [PlanarBeam(i, i + 1, strip) for i in range(4)],
        supports=[PlanarSupport(0, rotation=True)],
        loads=[PlanarLoad(4, moment=strip.EI)],
    )
    path = load_steps(frame, np.linspace(0, 1, 4))
    return {
        "frame": frame,
        "planar path": path,
        "planar run": simulate_planar(
            frame, 0.01, PlanarGeneralizedAlpha(1e-3, rho=0.8), start=path.state()
        ),
    }


def robots(_: Objects, folder: Path) -> Objects:
    """A robot of one link, its tree and where its tip comes to."""
    path = folder / "robot.urdf"
    path.write_text(ROBOT, encoding="utf-8")
    robot = jo.robots.read_urdf(path)
    tree = jo.robots.Tree(robot)
    return {
        "robot": robot,
        "link": robot.links[1],
        "robot joint": robot.joints[0],
        "row": jo.robots.DHRow(1.0, 0.0),
        "mimic": jo.robots.Mimic("j"),
        "tree": tree,
        "mounted": jo.robots.RobotInMechanism("arm", robot),
        "frame": tree.pose("arm", [0.0]),
        "state_at": jo.robots.state_at(tree, jo.compile(jo.robots.mechanism(robot)), [0.1]),
        "reached": jo.robots.inverse_kinematics(tree, "tip", (0.0, 1.0, 0.0)),
    }


ROBOT = """<robot name="r"><link name="base"/><link name="arm"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><link name="tip"/>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
</joint>
<joint name="k" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="1 0 0"/></joint>
</robot>"""
