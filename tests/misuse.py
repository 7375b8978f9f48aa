"""Calls of the public interface that work, of which one argument at a time is then spoilt."""

from __future__ import annotations

import inspect
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import jousto as jo
from jousto.output.dispatch import implementation
from jousto.output.plot import BEAM, DRAWN
from jousto.output.write import WRITTEN
from jousto.schema.read import parse_model
from measurement.monitor import watched
from session import EXAMPLES, ROBOT, STEEL, falling, objects, turn

DRAW = {kind: implementation(place) for kind, place in DRAWN.items()}
WRITE = {
    f"{kind} {suffix}": implementation(place)
    for kind, formats in WRITTEN.items()
    for suffix, place in formats.items()
}

Call = tuple[Callable[..., Any], dict[str, Any]]
Made = dict[str, Any]

WRONG: dict[str, Any] = {
    "text": "1 s",
    "number": 5.0,
    "negative": -1.0,
    "nan": float("nan"),
    "none": None,
    "mixed list": [1.0, "a"],
    "object": object(),
    "material": STEEL,
}

NO_FILE = {"mesh_cad", "read_matrices", "reduce_superelement", "identify_payload"}
"""Calls that fail for want of a file of another program or of a moving twin."""
NOT_CALLED = {"names", "sn_curves", "strain_lives", "solvers", "live"}
"""Public functions without arguments, and one that would run on: tests/viewer/live."""
SPECIAL = {
    *("arc_length", "inertia_share", "load_steps", "planar_frequencies", "planar_rest"),
    *("planar_spinning", "simulate_planar", "equivalent_load", "external", "locate_load"),
    *("place_loads", "sample_posterior", "smooth", "stress_blocks", "tune", "drive_part"),
    "realtime",  # compiles a program each time
    "shape_distance",  # see tests/model/test_contact_pairs.py
    *("study", "read_distribution", "read_outcome"),  # see tests/design/studies
    "read_modes",  # see tests/design/identification/test_modal.py
}
"""Functions of planar frames and twins, for those who know them."""


@cache
def calls(folder: Path) -> dict[str, Call]:
    """Return calls by the name of what is called; arguments left out have defaults."""
    made = objects()
    found: dict[str, Call] = {}
    for part in (
        _machines,
        _parts,
        _analyses,
        _recovery,
        _fatigue,
        _twins,
        _states,
        _hydraulics,
        _electric,
        _studies,
        _design,
        _robots,
    ):
        for what, given in part(made, folder):
            name = what.__qualname__
            found[name] = (what, given)
    return found


def arguments(what: Callable[..., Any]) -> list[str]:
    """Return the names of the arguments that can be spoilt."""
    kinds = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return [x.name for x in inspect.signature(what).parameters.values() if x.kind not in kinds]


def value_of(what: Callable[..., Any], given: dict[str, Any], argument: str) -> Any:
    """Return what an argument is in a call: its default where it is not given."""
    return given.get(argument, inspect.signature(what).parameters[argument].default)


def unit(folder: Path) -> Path:
    """Write a unit that can be declared, not run: its binary is empty."""
    import fmpy

    out = folder / "unit.fmu"
    described = (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="u" guid="u">'
        '<CoSimulation modelIdentifier="u"/><ModelVariables><ScalarVariable name="x" '
        'valueReference="0" causality="input"><Real start="0"/></ScalarVariable>'
        "</ModelVariables><ModelStructure/></fmiModelDescription>"
    )
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("modelDescription.xml", described)
        archive.writestr(f"binaries/{fmpy.platform}/u{fmpy.sharedLibraryExtension}", b"")
    return out


def _machines(made: Made, folder: Path) -> list[Call]:
    arm, ball = made["mechanism"].bodies
    hinge, wrist = made["mechanism"].joints
    a, b = jo.ground["origin"], ball["origin"]
    one, angle, arch = jo.Constant(1.0), hinge.angle, made["arch"]
    joint = {"name": "j", "a": a, "b": b}
    sensor = {"name": "s", "marker": b}
    gauge = made["mechanism"].sensors[2]
    spring = made["mechanism"].forces[0]
    placed = [
        *(jo.Revolute, jo.Spherical, jo.Fixed, jo.Prismatic, jo.Cylindrical, jo.Universal),
        *(jo.Planar, jo.PointOnLine, jo.PointOnPlane, jo.ConstantOrientation),
        *(jo.mechanism.ParallelAxes, jo.mechanism.Perpendicular),
    ]
    moved = [
        *(jo.PositionSensor, jo.VelocitySensor, jo.AccelerationSensor, jo.OrientationSensor),
        *(jo.AngularVelocitySensor, jo.mechanism.AngularAccelerationSensor),
        jo.mechanism.AccelerationPartsSensor,
    ]
    sites = (jo.StressSensor, jo.VonMisesSensor, jo.mechanism.PrincipalStressSensor)
    return [
        (jo.RigidBody, {"name": "r", "mass": 1.0, "inertia": (1.0, 1.0, 1.0)}),
        (jo.mechanism.velocity_matrix, {"e": (1.0, 0.0, 0.0, 0.0)}),
        (jo.mechanism.rate_matrix, {"e": (1.0, 0.0, 0.0, 0.0)}),
        (jo.RigidBody.box, {"name": "r", "size": (1.0, 1.0, 1.0), "mass": 1.0}),
        (jo.RigidBody.cylinder, {"name": "r", "radius": 1.0, "length": 1.0, "mass": 1.0}),
        (jo.RigidBody.sphere, {"name": "r", "radius": 1.0, "mass": 1.0}),
        (jo.RigidBody.from_mesh, {"name": "r", "surface": made["mesh"], "mass": 1.0}),
        (jo.FlexibleBody, {"name": "f", "reduced": made["reduced"]}),
        (
            jo.BeamBody,
            {
                "name": "b",
                "points": [(0, 0, 0), (1, 0, 0)],
                "section": jo.Circle(0.01),
                "material": STEEL,
                "elements": 2,
            },
        ),
        (jo.mechanism.BeamSection, {"stiffness": np.eye(6), "mass": 1.0, "inertia": np.eye(3)}),
        (jo.mechanism.BeamDamping, {}),
        (jo.ground.at, {"position": (0, 0, 0)}),
        (ball.at, {"position": (0, 0, 0)}),
        *((kind, joint) for kind in placed),
        (jo.Rod, {"name": "j", "a": a, "b": arm["end"]}),
        (jo.Screw, joint | {"pitch": 0.1}),
        *((kind, sensor) for kind in moved),
        (jo.CoordinateSensor, {"name": "s", "coordinate": angle}),
        (jo.RateSensor, {"name": "s", "coordinate": angle}),
        (jo.mechanism.EnergySensor, {"name": "s", "energy": "kinetic"}),
        (jo.SignalSensor, {"name": "s", "signal": one}),
        (jo.ReactionSensor, {"name": "s", "joint": hinge}),
        (jo.ForceSensor, {"name": "s", "force": spring}),
        (
            jo.mechanism.ForceStateSensor,
            {"name": "s", "force": jo.mechanism.PlasticSpring("p", angle, 1.0, 1.0)},
        ),
        (jo.mechanism.ModalSensor, {"name": "s", "body": arm}),
        (jo.mechanism.DeformationMomentumSensor, {"name": "s", "body": arm}),
        (jo.mechanism.BodyLoadSensor, {"name": "s", "body": arm, "load": "joint"}),
        (jo.mechanism.ModalLoadSensor, {"name": "s", "body": arm, "load": "joint"}),
        *((kind, {"name": "s", "body": arm}) for kind in sites),
        (jo.mechanism.SectionSensor, {"name": "s", "beam": arch}),
        (
            jo.mechanism.DamageSensor,
            {"name": "s", "sensor": gauge, "sn": made["curve"], "residue": "half", "factor": 1.0},
        ),
        (jo.gauges.Gauge, {"name": "s", "body": arm, "at": "e1.a.top"}),
        (jo.gauges.Bridge, {"name": "s", "arms": gauge}),
        (jo.gauges.Temperature, {"signal": 20.0, "part": 1e-5}),
        (jo.Angle, {"a": a, "b": b}),
        (jo.Displacement, {"a": a, "b": b}),
        (jo.Distance, {"a": a, "b": b}),
        (jo.Force, {"name": "f", "marker": b, "vector": (1, 0, 0)}),
        (jo.Torque, {"name": "f", "marker": b, "vector": (1, 0, 0)}),
        (jo.Gravity, {"acceleration": (0, 0, -9.81)}),
        (jo.Spring, {"name": "f", "coordinate": angle, "stiffness": 1.0}),
        (jo.Bushing, {"name": "f", "a": a, "b": b, "stiffness": 1.0}),
        (jo.JointForce, {"name": "f", "coordinate": angle, "signal": one}),
        (jo.mechanism.Stop, {"name": "f", "coordinate": angle, "lower": 0.0, "stiffness": 1.0}),
        (
            jo.mechanism.GearSpring,
            {
                "name": "f",
                "coordinate": angle,
                "motor": wrist.angle,
                "ratio": 9.0,
                "stiffness": 1.0,
            },
        ),
        (
            jo.mechanism.PlasticSpring,
            {"name": "f", "coordinate": angle, "stiffness": 1.0, "strength": 1.0},
        ),
        (
            jo.mechanism.Contact,
            {
                "name": "f",
                "a": jo.ground["origin"],
                "shape_a": jo.mechanism.HalfSpace(),
                "b": b,
                "shape_b": jo.mechanism.Sphere(0.1),
                "law": jo.mechanism.PowerLaw(1e6),
            },
        ),
        (
            jo.mechanism.SkinContact,
            {
                "name": "f",
                "a": jo.ground["origin"],
                "shape": jo.mechanism.HalfSpace(),
                "body": arm,
                "law": jo.mechanism.PowerLaw(1e6),
            },
        ),
        (jo.Servo, {"name": "f", "coordinate": angle, "reference": one, "kp": 1.0}),
        (jo.UserForce, {"name": "f", "marker": b, "function": lambda t, x: [0.0] * 6}),
        (jo.mechanism.ModalLoad, {"name": "f", "body": arm, "pattern": np.zeros((5, 3))}),
        (jo.mechanism.LineLoad, {"name": "f", "beam": arch, "force": (0, 0, 1)}),
        (jo.Friction, {"name": "f", "joint": wrist, "mu_kinetic": 0.1, "radius": 0.01}),
        (jo.mechanism.Regularised, {}),
        (jo.Drive, {"name": "d", "coordinate": angle, "signal": one}),
        (jo.Coupling, {"name": "c", "coordinates": [angle, wrist.angle], "factors": [1.0, 2.0]}),
        (jo.Gear, {"name": "c", "a": angle, "b": wrist.angle, "ratio": 2.0}),
        (jo.Initial, {"coordinate": angle, "value": 0.1}),
        (jo.Fmu, {"file": unit(folder), "inputs": {"x": 1.0}}),
        (jo.mechanism.Event, {"name": "e", "watch": angle}),
        (
            jo.mechanism.Switched,
            {"event": made["mechanism"].events[0], "before": 0.0, "after": 1.0},
        ),
        (jo.Constant, {"value": 1.0}),
        (jo.ConstantSpeed, {"speed": 1.0}),
        (jo.Harmonic, {"frequency": 1.0}),
        (jo.Ramp, {"start": 0.0, "end": 1.0}),
        (jo.Step, {"time": 1.0}),
        (jo.SCurve, {"times": [0, 1], "values": [0, 1]}),
        (jo.Table, {"times": [0, 1], "values": [0, 1]}),
        (jo.Input, {"name": "u"}),
        (jo.Rotate, {"axis": (0, 0, 1), "degrees": 3.0}),
        (jo.Rotate.euler, {"convention": "ZXZ", "degrees": (1.0, 2.0, 3.0)}),
        (jo.model.DamageMeter, {"sn": made["curve"], "residue": "half"}),
        (
            jo.mechanism.BrushTyre,
            {"mu": 1.0, "load": 4e3, "stiffness_x": 8e4, "stiffness_y": 6e4, "half_length": 0.06},
        ),
        (jo.mechanism.MagicFormula, {"nominal": 4e3}),
        (
            jo.mechanism.MovingLoad,
            {
                "name": "f",
                "body": arm,
                "path": ("start", "end"),
                "position": 0.0,
                "vector": (0, 0, 1),
            },
        ),
    ]


def _robots(made: Made, folder: Path) -> list[Call]:
    tree, robot = made["tree"], made["robot"]
    path = folder / "robot.urdf"
    path.write_text(ROBOT, encoding="utf-8")
    mjcf, sdf = folder / "robot.xml", folder / "robot.sdf"
    mjcf.write_text("<mujoco/>", encoding="utf-8")
    sdf.write_text('<sdf><model name="m"><static>1</static></model></sdf>', encoding="utf-8")
    return [
        (jo.robots.read_urdf, {"path": path}),
        (jo.robots.read_robot, {"path": path}),
        (jo.robots.read_mjcf, {"path": mjcf}),
        (jo.robots.read_sdf, {"path": sdf}),
        (jo.robots.from_dh, {"rows": [(1.0, 0.0, 0.0, 0.0)], "convention": "standard"}),
        (jo.robots.DHRow, {"a": 1.0, "alpha": 0.0}),
        (jo.robots.mechanism, {"robot": robot}),
        (
            jo.robots.RobotInMechanism,
            {"name": "arm", "robot": robot, "at": {"j": 0.1}, "prefix": "arm "},
        ),
        (jo.robots.Tree, {"machine": robot}),
        (
            jo.robots.inverse_kinematics,
            {"tree": tree, "frame": "tip", "position": (0.0, 1.0, 0.0)},
        ),
        (
            jo.robots.state_at,
            {"tree": tree, "model": jo.compile(jo.robots.mechanism(robot)), "q": [0.0]},
        ),
        (tree.coordinate, {"coordinate": "j.angle", "q": [0.0]}),
        (tree.constraints, {"q": [0.0]}),
        (tree.constraint_jacobian, {"q": [0.0]}),
        (tree.forward_kinematics, {"q": [0.0]}),
        (tree.pose, {"frame": "tip", "q": [0.0]}),
        (tree.jacobian, {"frame": "tip", "q": [0.0]}),
        (tree.moved, {"q": [0.0], "step": [0.1]}),
        (tree.mass_matrix, {"q": [0.0]}),
        (tree.bias_forces, {"q": [0.0], "v": [0.0]}),
        (tree.gravity_forces, {"q": [0.0]}),
        (tree.inverse_dynamics, {"q": [0.0], "v": [0.0], "a": [0.0]}),
        (tree.forward_dynamics, {"q": [0.0], "v": [0.0], "tau": [0.0]}),
    ]


def _parts(made: Made, folder: Path) -> list[Call]:
    beam, mesh = made["beam"], made["mesh"]
    shape = np.ones((beam.M.shape[0], 1))
    line = {"length": 1.0, "section": jo.Circle(0.01), "elements": 2, "material": STEEL}
    return [
        (jo.Part.beam, line),
        (
            jo.Part.frame,
            {
                "nodes": [(0, 0, 0), (1, 0, 0)],
                "elements": [(0, 1)],
                "sections": jo.Circle(0.01),
                "materials": STEEL,
            },
        ),
        (jo.Part.from_members, {"members": [_member()]}),
        (jo.Part.solid, {"mesh": mesh, "materials": STEEL}),
        (jo.Part.from_matrices, {"M": np.eye(6), "K": np.eye(6), "nodes": [(0, 0, 0)]}),
        (beam.with_stress, {"stress": None}),
        (beam.geometric_stiffness, {"d": np.zeros(beam.M.shape[0])}),
        (jo.Member, vars(_member())),
        (jo.Interface, {"name": "i", "nodes": "bore"}),
        (jo.Material, {"E": 2.1e11, "nu": 0.3, "rho": 7850.0}),
        (jo.material, {"name": "S355"}),
        (jo.Rectangle, {"width": 0.1, "height": 0.1}),
        (jo.Tube, {"outer_diameter": 0.1, "wall": 0.01}),
        (jo.Circle, {"diameter": 0.1}),
        (jo.IBeam, {"height": 0.1, "width": 0.1, "web": 0.01, "flange": 0.01}),
        (jo.Box, {"width": 0.1, "height": 0.1, "web": 0.01}),
        (jo.sections.GeneralSection, {"A": 1e-2, "Iy": 1e-6, "Iz": 1e-6, "J": 1e-6}),
        (jo.parts.PointMass, {"node": 0, "mass": 1.0}),
        (jo.CraigBampton, {"modes": 2}),
        (jo.FreeFree, {"modes": 2}),
        (jo.Rayleigh, {"alpha": 0.0, "beta": 1e-3}),
        (jo.mesh.InBox, {"low": (0, 0, 0), "high": (1, 1, 1)}),
        (jo.mesh.InSphere, {"point": (0, 0, 0), "radius": 1.0}),
        (jo.mesh.InCylinder, {"point": (0, 0, 0), "axis": (0, 0, 1), "radius": 1.0}),
        (jo.mesh.Nearest, {"point": (0, 0, 0)}),
        (jo.Mesh, {"name": "m", "nodes": mesh.nodes, "cells": mesh.cells}),
        (jo.mesh.Cells, {"kind": "tetra", "nodes": [(0, 1, 2, 3)]}),
        (mesh.box, {"lo": (0, 0, 0), "hi": (1, 1, 1)}),
        (mesh.with_set, {"name": "s", "nodes": [0, 1]}),
        (mesh.nearest, {"point": (0, 0, 0)}),
        (jo.read_mesh, {"path": jo.write(mesh, folder / "m.vtu")}),
        (jo.mesh_cad, {"path": "x.step", "size": 1.0}),
        (jo.parts.read_matrices, {"K": "x.mtx"}),
        (jo.reduce, {"part": beam, "method": jo.CraigBampton(("start",), modes=2)}),
        (jo.certificate.certify, {"part": beam, "reduced": made["reduced"]}),
        (jo.reduction.from_modes, {"part": beam, "modes": shape, "frequencies": [1.0]}),
        (jo.certificate.advise, {"part": beam, "interfaces": ("start",), "frequency_limit": 300.0}),
        (jo.reduction.clamp, {"part": made["reduced"], "supports": "start"}),
        (
            jo.reduction.in_frame,
            {"reduced": made["reduced"], "frame": jo.reduction.NodeFrame("start")},
        ),
        (
            jo.reduction.same_motion,
            {
                "old": made["reduced"],
                "new": made["reduced"],
                "q": np.r_[0, 0, 0, 1, 0, 0, 0, np.zeros(made["reduced"].n)],
                "v": np.zeros(6 + made["reduced"].n),
            },
        ),
        (jo.reduction.inertia_relief, {"part": beam, "loads": np.ones(beam.M.shape[0])}),
        (
            jo.reduction.memory_estimate,
            {"part": beam, "method": jo.CraigBampton(("start",), modes=2)},
        ),
        (jo.parts.mesh_error, {"part": made["solid"], "d": np.zeros(made["solid"].M.shape[0])}),
        (
            jo.parts.place_errors,
            {"part": made["solid"], "d": np.zeros(made["solid"].M.shape[0])},
        ),
        (jo.reduction.reduce_superelement, {"matrices": None}),
        (jo.fatigue.weld_stress, {"part": made["solid"], "toes": _toe()}),
        (made["reduced"].keep, {"indices": [0, 1]}),
        (made["reduced"].node, {"name": "start"}),
        (jo.reduction.ReductionCache, {"folder": "cache"}),
    ]


def _toe() -> jo.fatigue.WeldToe:
    return jo.fatigue.WeldToe("toe", (0.05, 0.0, 0.025), (0.0, 0.0, 1.0), 0.01)


def _member() -> jo.Member:
    return jo.Member((0, 0, 0), (1, 0, 0), jo.Circle(0.01), STEEL)


def _analyses(made: Made, folder: Path) -> list[Call]:
    model, run, beams = made["model"], made["run"], made["beam model"]
    few = replace(made["compared"], pairs=made["compared"].pairs[:3])
    return [
        (jo.compile, {"mechanism": made["mechanism"], "core": "auto"}),
        (jo.doctor, {"mechanism": made["mechanism"]}),
        (jo.model.Engine, {"model": model}),
        (jo.simulate, {"model": model, "t_end": 0.002}),
        (jo.verify, {"mechanism": falling(), "t_end": 0.002, "step": 0.1}),
        (jo.natural.moving_frame, {"mechanism": falling(), "t_end": 0.002, "step": 0.1}),
        (jo.simulation.Simulator, {"model": model}),
        (jo.load, {"path": run.save(folder / "run.h5")}),
        (jo.read_model, {"path": EXAMPLES / "flexible_pendulum.yaml"}),
        (jo.equilibrium, {"model": beams}),
        (jo.simulation.vibration_free_state, {"model": model}),
        (jo.simulation.steady_rotation, {"model": beams, "axis": (0, 0, 1), "speed": 0.0}),
        (jo.modes, {"model": beams}),
        (jo.simulation.linearise, {"model": beams}),
        (jo.simulation.buckling, {"model": beams, "parameter": "load", "count": 1}),
        (jo.simulation.load_path, {"model": beams, "parameter": "load", "to": 10.0, "steps": 1}),
        (jo.simulation.kinematics, {"model": made["driven"], "times": [0.0, 0.1]}),
        (jo.simulation.inverse_dynamics, {"model": made["driven"], "times": [0.0, 0.1]}),
        (jo.simulation.campbell, {"build": lambda _: beams, "values": [1.0]}),
        *((kind, {}) for kind in (jo.RK4, jo.ROS2, jo.GeneralizedAlpha, jo.simulation.Newmark)),
        (jo.simulation.DormandPrince, {}),
        (jo.simulation.Baumgarte, {"alpha": 1.0, "beta": 1.0}),
        (jo.simulation.ArcLength, {}),
        (run.__getitem__, {"name": "tip"}),
        (run.about, {"name": "tip"}),
        (run.state, {}),
        (run.save, {"path": "saved.h5"}),
        (run.to_csv, {"path": "run.csv"}),
        (run.to_pandas, {}),
        (run.stress_modes, {"body": "arm"}),
        (run.coordinates, {"body": "arm"}),
        (made["beam run"].beam_states, {"beam": "arch"}),
        (jo.plot, {"thing": run}),
        (jo.write, {"thing": run, "path": "w.csv"}),
        (DRAW["Solution"], {"run": run}),
        (DRAW["SN"], {"curves": made["curve"]}),
        (DRAW["Cycles"], {"cycles": made["cycles"]}),
        (DRAW["DamageField"], {"run": run, "field": made["damage field"], "path": "d.png"}),
        (implementation(BEAM), {"run": made["beam run"], "beam": "arch"}),
        (DRAW["SectionForces"], {"forces": made["section forces"]}),
        (DRAW["Campbell"], {"data": made["campbell"]}),
        (DRAW["LoadPath"], {"data": made["path"], "sensor": "crown.y"}),
        (DRAW["HotSpots"], {"run": run, "found": made["spots"], "path": "h.png"}),
        (DRAW["GaugeComparison"], {"comparison": few}),
        (DRAW["MonitorRecord"], {"record": made["watched"]}),
        (DRAW["Band"], {"band": made["band"]}),
        (DRAW["RandomResponse"], {"response": made["response"], "sites": "e1.a.top"}),
        (DRAW["PlanarRun"], {"run": made["planar run"]}),
        (DRAW["FrictionStress"], {"found": made["friction"]}),
        (DRAW["StrainLife"], {"series": [0.0, 3e8, -3e8], "material": made["notch"]}),
        (jo.still, {"run": run, "path": "s.png"}),
        (jo.animate, {"run": run, "path": "a.gif", "fps": 5.0}),
        (jo.draw, {"thing": made["beam"], "path": "p.png"}),
        # without a server, which would stay
        (jo.view, {"thing": run, "open": False, "embed": True}),
        (WRITE["Solution csv"], {"run": run, "path": "w.csv"}),
        (WRITE["ReducedPart vtu"], {"reduced": made["reduced"], "path": "r.vtu"}),
        (WRITE["ReducedPart fem"], {"reduced": made["reduced"], "path": "r.fem"}),
        (WRITE["ReducedPart sid"], {"reduced": made["reduced"], "path": "r.SID_FEM"}),
        (WRITE["Mesh vtu"], {"mesh": made["mesh"], "path": "m.vtu"}),
        (WRITE["HotSpots vtu"], {"run": run, "found": made["spots"], "path": "h.vtu"}),
        (WRITE["DamageField vtu"], {"run": run, "field": made["damage field"], "path": "d.vtu"}),
        (WRITE["StressField csv"], {"field": made["field"], "path": "s.csv"}),
        (WRITE["Solution vtu"], {"run": made["beam run"], "beam": "arch", "path": "b.vtu"}),
        (WRITE["LoadPath csv"], {"data": made["path"], "path": "p.csv"}),
        (WRITE["Certificate html"], {"certificate": made["certificate"], "path": "c.html"}),
    ]


def _recovery(made: Made, folder: Path) -> list[Call]:
    run, field = made["run"], made["field"]
    return [
        (
            jo.mechanism.with_numbers,
            {"mechanism": made["mechanism"], "values": {"ball.mass": 2.0}},
        ),
        (jo.stress_field, {"run": run, "body": "arm"}),
        (field.values, {"criterion": "von-mises"}),
        (field.envelope, {"criterion": "von-mises"}),
        (field.history, {"site": "e1.a.top"}),
        (
            jo.recovery.field_from,
            {"modes": made["reduced"].stress, "p": np.zeros((3, 10)), "time": [0.0, 0.1, 0.2]},
        ),
        (
            jo.design.equivalent_loads,
            {
                "run": run,
                "body": made["mechanism"].bodies[0],
                "times": [0.0],
                "part": made["beam"],
            },
        ),
        (DRAW["StressField"], {"field": field.only("e1.a.top"), "path": "stress.png"}),
        (WRITE["StressField vtu"], {"run": run, "field": field, "path": "contour.vtu"}),
        (jo.hot_spots, {"source": field}),
        (jo.recovery.error_budget, {"found": made["spots"]}),
        (jo.recovery.friction_stress, {"with_run": run, "without_run": run, "body": "arm"}),
        (jo.recovery.section_forces, {"run": made["beam run"], "beam": "arch"}),
        (jo.recovery.loads_of, {"run": run, "body": "arm", "times": [0.0]}),
        (
            jo.design.advise_flexibility,
            {"machine": made["mechanism"], "t_end": 0.01, "bodies": "arm", "output_step": 1e-3},
        ),
        (
            jo.design.reading_loss,
            {"time": [0.0, 1.0], "full": [0.0, 1.0], "simple": [0.0, 1.0]},
        ),
        (jo.recovery.without_friction, {"mechanism": made["mechanism"]}),
        (jo.recovery.Plane, {"normal": (0, 0, 1)}),
        (jo.gauges.read_record, {"path": run.to_csv(folder / "record.csv")}),
        (jo.gauges.record_of, {"run": run}),
        (
            jo.gauges.align,
            {"record": made["record"], "other": run, "channel": "tip.x"},
        ),
        (jo.gauges.compare_gauges, {"run": run, "measured": made["record"], "align": False}),
        (jo.gauges.rosette_state, {"e": [1e-4, 1e-4, 1e-4], "E": 2.1e11, "nu": 0.3}),
        (jo.gauges.gauge_rows, {"gauges": [made["mechanism"].sensors[2]]}),
        (jo.gauges.bridge_output, {"r": np.zeros(4)}),
        (jo.gauges.quarter_bridge_strain, {"output": 1e-3}),
    ]


def _fatigue(made: Made, _: Path) -> list[Call]:
    field, curve, notch = made["field"], made["curve"], made["notch"]
    history, cycles = [0.0, 3e8, -1e8, 2e8], made["cycles"]
    s = np.zeros((20, 6))
    s[:, 0] = 1e8 * np.sin(np.arange(20))
    frequency = np.linspace(1.0, 100.0, 10)
    psd = {"frequency": frequency, "psd": np.ones(10)}
    return [
        (jo.fatigue.rainflow, {"series": history, "residue": "half"}),
        (jo.SN, {"S_D": 1e8, "N_D": 1e6, "k": 5.0}),
        (jo.sn_curve, {"name": "fat71"}),
        (jo.fatigue.fat_class, {"fat": 71}),
        (jo.fatigue.estimate_sn, {"strength": 5e8}),
        (jo.fatigue.damage, {"cycles": cycles, "sn": curve}),
        (jo.fatigue.life, {"cycles": cycles, "sn": curve}),
        (jo.fatigue.assess, {"history": cycles, "sn": curve}),
        (jo.fatigue.stress_safety, {"cycles": cycles, "sn": curve}),
        (jo.damage_field, {"source": field, "sn": curve, "residue": "half"}),
        (made["damage field"].at, {"site": "e1.a.top"}),
        (jo.fatigue.site_cycles, {"source": field, "site": "e1.a.top", "residue": "half"}),
        (jo.fatigue.DutyCycle, {"events": [(field, 2)]}),
        (jo.fatigue.critical_plane, {"stress": s, "criterion": jo.fatigue.Findley(0.3)}),
        (jo.fatigue.multiaxial, {"stress": s, "criterion": jo.fatigue.Findley(0.3)}),
        (
            jo.fatigue.plane_damage,
            {"stress": s, "criterion": jo.fatigue.Findley(0.3), "sn": curve, "residue": "half"},
        ),
        (jo.fatigue.local_cycles, {"series": history, "material": notch, "residue": "half"}),
        (jo.fatigue.local_path, {"series": history, "material": notch}),
        (jo.fatigue.hinge_cycles, {"moment": [0.0, 1.0, -1.0], "plastic": [0.0, 0.1, -0.1]}),
        (
            jo.fatigue.hinge_life,
            {
                "moment": [1.0, -1.0, 1.0],
                "plastic": [0.1, -0.1, 0.1],
                "material": notch,
                "length": 1.0,
                "modulus": 1.0,
                "depth": 0.1,
                "residue": "half",
            },
        ),
        (jo.fatigue.neuber, {"stress": history, "material": notch}),
        (jo.fatigue.glinka, {"stress": history, "material": notch}),
        (
            jo.fatigue.strain_damage,
            {"field": field, "material": notch, "residue": "half", "sites": "e1.a.top"},
        ),
        (jo.fatigue.strain_life, {"name": "sae-1045"}),
        (jo.fatigue.spectral_damage, psd | {"sn": curve}),
        (jo.fatigue.spectral_moments, psd),
        (jo.fatigue.synthesise, psd | {"duration": 1.0, "rate": 500.0}),
        (
            jo.fatigue.random_response,
            {"reduced": made["reduced"], **psd, "base": "start", "direction": (0, 0, 1)},
        ),
        (jo.fatigue.hertz_line, {"force": 1e4, "length": 0.03, "radius": 0.1, "material": STEEL}),
        (jo.fatigue.hertz_point, {"force": 1e4, "radii": (0.1, 0.1), "material": STEEL}),
        (jo.fatigue.rolling_contact, {"contact": made["hertz"], "depths": [3e-4]}),
        (
            jo.fatigue.rolling_life,
            {
                "contact": made["hertz"],
                "forces": [8e3],
                "criterion": jo.fatigue.DangVan.of(3e8, 4e8),
                "depths": [3e-4],
            },
        ),
        (jo.fatigue.rolling_passes, {"angle": [0.0, 4.0, 8.0], "values": [1.0, 2.0, 3.0]}),
        (jo.fatigue.roughness_factor, {"Rz": 2e-5, "S_u": 5e8}),
        (jo.fatigue.size_factor, {"diameter": 0.05}),
        (jo.fatigue.thickness_factor, {"thickness": 0.05}),
        (jo.fatigue.finish_factor, {"finish": "ground", "S_u": 5e8}),
        (jo.fatigue.load_factor, {"load": "axial"}),
        (jo.fatigue.reliability_factor, {"survival": 0.9}),
        (jo.fatigue.shakedown_limit, {}),
        (jo.fatigue.hot_spot_stress, {"stress": [1.0, 2.0]}),
        (jo.fatigue.Findley, {}),
        (jo.fatigue.DangVan, {"a": 0.3, "b": 1e8}),
        (jo.fatigue.FatemiSocie, {"S_y": 3e8, "E": 2.1e11}),
        (jo.fatigue.Goodman, {"S_u": 5e8}),
        (jo.fatigue.Walker, {"gamma": 0.5}),
        (jo.fatigue.FKM, {"M": 0.3}),
        (jo.fatigue.StrainLife, {"E": 2.1e11, "sf": 9e8, "b": -0.09, "ef": 0.3, "c": -0.5}),
        (jo.fatigue.WeldToe, {"name": "t", "at": (0, 0, 0), "away": (1, 0, 0), "thickness": 0.01}),
    ]


def _twins(made: Made, folder: Path) -> list[Call]:
    reduced, B = watched.cantilever()
    t, _p, e = watched.motion(50)
    twin, observed = made["twin"], made["observed"]
    data = watched.written(folder / "d.csv", watched.lines(t, e))
    return [
        (jo.twin.Reconstruction, {"B": B}),
        (jo.twin.weigh_modes, {"B": B, "e": e, "part": reduced}),
        (twin.estimate, {"e": e}),
        (jo.twin.UnknownLoad, {"place": "end"}),
        (jo.twin.Accelerometer, {"name": "a", "node": "end"}),
        (jo.twin.Balance, {"force": 1.0, "moment": 1.0}),
        (
            jo.twin.Observer,
            {"reduced": reduced, "gauges": B, "loads": [made["load"]], "step": 0.01},
        ),
        (made["observer"].run, {"time": t, "e": e}),
        (
            jo.twin.stress_band,
            {"estimate": made["estimate"], "modes": reduced, "sites": "e1.a.top"},
        ),
        (
            jo.twin.damage_band,
            {
                "observed": observed,
                "modes": reduced,
                "sn": watched.curve(),
                "residue": "half",
                "sites": "e1.a.top",
                "draws": 20,
            },
        ),
        (jo.twin.place_gauges, {"candidates": reduced, "count": 3}),
        (jo.twin.identify_fourier, {"twin": twin, "time": t, "e": e, "part": reduced}),
        (jo.twin.identify_payload, {"observed": observed, "place": "node11"}),
        (jo.twin.innovation_test, {"observed": observed}),
        (jo.twin.gauge_errors, {"gauges": [jo.gauges.Gauge("g", reduced, "e1.a.top")]}),
        (jo.twin.identify_loads, {"observer": made["observer"], "time": t, "e": e}),
        (jo.monitor.Monitor, {"twin": twin, "modes": reduced, "spots": watched.SPOTS}),
        (jo.monitor.AlarmLimits, {}),
        (jo.monitor.ChannelRules, {}),
        (jo.monitor.watch, {"monitor": watched.monitor(), "source": data, "path": folder / "w.h5"}),
        (jo.monitor.MonitorRecord, {"path": made["watched"].path}),
    ]


def _states(made: Made, _: Path) -> list[Call]:
    words = jo.mechanism
    hinge, wrist = made["mechanism"].joints
    x = words.value(hinge.angle)
    one = [
        (getattr(words, name), {"x": x})
        for name in ("absolute", "atan", "cos", "exp", "log", "sin", "smooth_step", "sqrt", "tanh")
    ]
    return [
        *one,
        (words.minimum, {"a": x, "b": 1.0}),
        (words.maximum, {"a": x, "b": 1.0}),
        (words.where, {"x": x, "positive": 1.0, "otherwise": 2.0}),
        (words.clip, {"x": x, "low": 0.0, "high": 1.0}),
        (words.nodes_along, {"body": made["mechanism"].bodies[0], "start": "start", "end": "end"}),
        (words.value, {"coordinate": hinge.angle}),
        (words.rate, {"coordinate": hinge.angle}),
        (words.States, {"name": "s", "initial": {"x": 0.0}, "rates": {"x": 1.0}}),
        (words.Adder, {"name": "s", "inputs": [x, 1.0], "gains": [1.0, -1.0]}),
        (words.Multiplier, {"name": "s", "inputs": [x, 1.0]}),
        (words.Switch, {"name": "s", "condition": x, "positive": 1.0, "otherwise": x}),
        (words.Saturation, {"name": "s", "input": x, "lower": -1.0, "upper": 1.0}),
        (words.DeadBand, {"name": "s", "input": x, "lower": -1.0, "upper": 1.0}),
        (words.BlockForce, {"name": "s", "coordinate": hinge.angle, "force": x}),
        (words.PIDController, {"name": "s", "reference": 1.0, "measured": x, "kp": 2.0}),
        (words.RateLimit, {"name": "s", "input": x, "rising": 1.0}),
        (words.LinearSystem, {"name": "s", "inputs": x, "A": [[1.0]], "B": [[1.0]], "C": [[1.0]]}),
        (
            words.TransferFunction,
            {"name": "s", "input": x, "numerator": [1.0], "denominator": [1.0, 2.0]},
        ),
        (words.Integrator, {"name": "s", "input": x}),
        (words.Lag, {"name": "s", "input": x, "time": 0.1}),
        (words.Lookup, {"name": "s", "input": x, "at": [0.0, 1.0], "values": [0.0, 2.0]}),
        (
            words.LookupMap,
            {
                "name": "s",
                "x": x,
                "y": 1.0,
                "at_x": [0.0, 1.0],
                "at_y": [0.0, 1.0],
                "values": [[0.0, 2.0], [1.0, 3.0]],
            },
        ),
        (words.Play, {"name": "s", "input": x, "play": 0.1}),
        (words.Delay, {"name": "s", "input": x, "time": 0.1}),
        (
            words.SampledPID,
            {"name": "s", "reference": 1.0, "measured": x, "period": 0.1, "kp": 2.0},
        ),
        (
            words.SampledTransferFunction,
            {
                "name": "s",
                "input": x,
                "numerator": [1.0],
                "denominator": [1.0, 2.0],
                "period": 0.1,
            },
        ),
        (words.Relay, {"name": "s", "input": x, "lower": -1.0, "upper": 1.0}),
        (
            words.BoucWen,
            {
                "name": "s",
                "coordinate": hinge.angle,
                "stiffness": 10.0,
                "share": 0.1,
                "beta": 300.0,
                "gamma": 100.0,
            },
        ),
        (words.Sampled, {"name": "s", "period": 0.1, "initial": {"u": 0.0}, "updates": {"u": x}}),
        (words.Lead, {"name": "s", "input": x, "lead": 0.2, "lag": 0.1}),
        (words.StateSensor, {"name": "s", "of": x}),
        (
            words.Slider,
            {
                "name": "s",
                "track": (jo.ground.at((-9, 7, 0)), jo.ground.at((9, 7, 0))),
                "b": hinge.b,
                "stiffness": 1e6,
            },
        ),
        (words.RopeSpan, {"a": jo.ground.at((0, 7, 0)), "b": hinge.b}),
        (
            words.BeltDrive,
            {
                "name": "r",
                "a": hinge.b,
                "b": wrist.b,
                "radius_a": 0.01,
                "radius_b": 0.01,
                "turn_a": hinge.angle,
                "turn_b": wrist.angle,
                "stiffness": 1.0,
                "mu": 0.1,
                "preload": 0.0,
                "axis": (0, 1, 0),
            },
        ),
        (
            words.Capstan,
            {
                "name": "r",
                "path": (jo.ground.at((-1, 7, 0)), hinge.b, jo.ground.at((1, 7, 0))),
                "radii": (0, 0.1, 0),
                "stiffness": 1.0,
                "mu": 0.1,
                "axis": (0, 0, 1),
            },
        ),
        (
            words.Reeving,
            {
                "name": "r",
                "path": (jo.ground.at((0, 7, 0)), hinge.b),
                "radii": (0, 0),
                "stiffness": 1.0,
            },
        ),
    ]


def _hydraulics(made: Made, _: Path) -> list[Call]:
    h = jo.hydraulics
    body = made["mechanism"].bodies[0]
    flow = {"name": "s", "a": "A", "b": "B", "flow": 1e-3}
    ends = {"name": "s", "a": jo.ground.at((-1.0, 0, 0)), "b": body["start"]}
    line = [h.Tank("T"), h.Node("A", 1e-3), h.Leak("leak", "A", "T", 1e-12)]
    return [
        (h.HydraulicNetwork, {"name": "s", "elements": line}),
        (h.Oil, {}),
        (h.Node, {"name": "s"}),
        (h.Tank, {"name": "s"}),
        (h.Supply, {"name": "s", "pressure": 1e6}),
        (h.FlowSource, {"name": "s", "port": "A", "flow": 1e-3}),
        (h.Orifice, flow),
        (h.Leak, {"name": "s", "a": "A", "b": "B", "conductance": 1e-12}),
        (h.CheckValve, flow),
        (h.ReliefValve, flow | {"setting": 1e6}),
        (h.ReducingValve, flow | {"setting": 1e6}),
        (h.SequenceValve, flow | {"setting": 1e6}),
        (h.ShuttleValve, flow | {"outlet": "C"}),
        (h.FlowControlValve, flow),
        (h.PilotCheckValve, flow | {"pilot": "C"}),
        (
            h.EfficiencyMap,
            {
                "speeds": [100.0, 200.0],
                "pressures": [1e6, 2e6],
                "volumetric": [[0.9, 0.9], [0.9, 0.9]],
                "mechanical": [[0.9, 0.9], [0.9, 0.9]],
            },
        ),
        (
            h.CounterbalanceValve,
            {"name": "s", "load": "A", "line": "B", "setting": 1e6, "flow": 1e-3},
        ),
        (
            h.DirectionalValve,
            {"name": "s", "supply": "P", "tank": "T", "a": "A", "flow": 1e-3, "command": 1.0},
        ),
        (h.Cushion, {"length": 0.1, "flow": 1e-3}),
        (
            h.HydraulicCylinder,
            ends | {"piston": "A", "bore": 0.05, "stroke": 9.0, "closed": 0.1},
        ),
        (h.Pump, {"name": "s", "a": "T", "b": "A", "displacement": 1e-6, "speed": 1.0}),
        (h.HydraulicMotor, {"name": "s", "a": "T", "b": "A", "displacement": 1e-6, "speed": 1.0}),
        (h.Accumulator, {"name": "s", "port": "A", "volume": 1e-3, "precharge": 1e6}),
        (h.Hose, {"name": "s", "a": "A", "b": "B", "length": 1.0, "diameter": 0.01}),
    ]


def _electric(made: Made, _: Path) -> list[Call]:
    e = jo.electric
    hinge = made["mechanism"].joints[0]
    rotor = jo.RigidBody("rotor", 1.0, (1, 1, 1))
    axle = jo.Revolute("axle", jo.ground["origin"], rotor["origin"])
    shaft: dict[str, Any] = {"name": "s", "shaft": hinge.angle, "resistance": 0.5}
    plate = {"inductance_d": 2e-3, "inductance_q": 3e-3, "flux": 0.08, "pole_pairs": 4}
    control = {"current": 1.0, "bandwidth": 1e3}
    gear = {"motor": axle.angle, "coordinate": hinge.angle, "ratio": 20.0, "stiffness": 1e5}
    brake = {"coordinate": hinge.angle, "torque": 12.0, "stiffness": 1e5}
    return [
        (e.DCMotor, shaft | {"voltage": 12.0, "inductance": 1e-3, "constant": 0.1}),
        (e.SynchronousMotor, shaft | plate | control),
        (e.Gearbox, {"name": "s"} | gear),
        (e.Brake, {"name": "s"} | brake),
        (e.ThermalLoad, {"name": "s", "current": 1.0, "rated": 4.0, "time": 60.0}),
    ]


def _studies(made: Made, folder: Path) -> list[Call]:
    wall = jo.Parameter("wall", 1.0, bounds=(0.5, 2.0))
    some = {"parameters": [wall]}
    counted = [
        (what, some | {"count": 2})
        for what in (jo.design.latin_hypercube, jo.design.sobol, jo.design.random_samples)
    ]
    points = folder / "points.csv"
    points.write_text("wall\n1\n", encoding="utf-8")
    table = jo.design.StudyTable(("wall",), ("y",), np.ones((1, 1)), np.ones((1, 1)), ("",))
    kept = table.save(folder / "study.h5")
    return [
        (jo.Parameter, {"name": "wall", "value": 1.0}),
        (jo.design.grid, some),
        (jo.design.read_samples, some | {"path": points}),
        (jo.design.read_study, {"path": kept}),
        (jo.design.gradient, {"study": made["study"]}),
        *counted,
    ]


def _design(made: Made, _: Path) -> list[Call]:
    design = jo.design
    mass = jo.Parameter("mass", 2.0, bounds=(1.0, 3.0), unit="kg")
    pair = [
        design.Random(name, design.distribution_from_moments("normal", 5.0, 1.0)) for name in "ab"
    ]
    chain = {
        "parameters": [jo.Parameter("k", 20.0, bounds=(5.0, 50.0))],
        "matrices": lambda v: (np.eye(1), np.array([[v["k"]]])),
        "force": lambda t: np.ones((1, len(t))),
        "time": np.linspace(0, 1, 21),
        "cost": lambda v: v["k"],
        "limits": [design.DisplacementLimit("structure", 0.1, "1")],
        "damping": 0.01,
    }
    state = {"limit": lambda x: x["a"] + x["b"] - 6.0, "variables": pair}
    spread = jo.Parameter("mass", 2.0, unit="kg", distribution="normal(sd=0.1)")
    some = jo.study(turn, spread, "m = mass", t_end=0.01)
    bar = parse_model("""
parameters: {h: {value: 30 mm, bounds: [5 mm, 100 mm]}}
parts:
  rod: {type: beam, length: 1 m, section: {type: rectangle, width: 20 mm, height: "${h}"},
        material: S355, elements: 1, reduce: {type: craig-bampton, interfaces: [start], modes: 1}}
bodies: [{name: arm, part: rod, damping: 0.05}]
""")
    spring = parse_model("""
parameters:
  k: {value: 40 N/m, bounds: [10 N/m, 100 N/m]}
  m: {value: 1 kg, distribution: normal(sd=0.05 kg)}
bodies: [{name: block, mass: "${m}", inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: rail, a: ground.origin, b: block.origin, axis: [1, 0, 0]}]
forces: [{type: spring, name: spring, coordinate: rail.displacement, stiffness: "${k}"}]
""")
    return [
        (
            jo.export.named_constants,
            {"file": spring, "model": jo.compile(spring.mechanism)},
        ),
        (design.StressLimit, {"body": "boom", "maximum": 1e8, "criterion": "s11"}),
        (design.DisplacementLimit, {"body": "boom", "maximum": 0.1, "node": "tip"}),
        (design.FrequencyLimit, {"minimum": 3.0, "mode": 1}),
        (design.LifeLimit, {"body": "boom", "repeats": 1e6, "sn": watched.curve()}),
        (design.StructureProblem, {**chain}),
        (
            design.MachineProblem,
            {
                "parameters": chain["parameters"],
                "parts": lambda v: {},
                "build": lambda v, parts: None,
                "limits": chain["limits"],
                "t_end": 1.0,
            },
        ),
        (design.file_problem, {"file": bar, "limits": "frequency(1) >= 20 Hz", "t_end": 0.1}),
        (design.optimise, {"problem": design.StructureProblem(**chain), "order": 0, "cycles": 1}),
        (
            jo.study,
            {
                "model": turn,
                "parameters": [mass],
                "outcomes": "min(place.y)",
                "samples": 2,
                "t_end": 0.01,
                "output_step": 0.005,
            },
        ),
        (design.Function, {"name": "seen", "function": lambda run: 1.0}),
        (design.Damage, {"name": "life", "check_name": "arm"}),
        (design.read_outcome, {"text": "max(place.y)"}),
        (
            design.distribution_from_moments,
            {"kind": "normal", "mean": 1.0, "deviation": 1.0, "start": 0.0},
        ),
        (design.Random, {"name": "a", "distribution": pair[0].distribution, "keep": "cov"}),
        (design.Conditional, {"name": "a", "distribution": lambda x: x}),
        (design.Nataf, {"variables": pair, "correlation": {("a", "b"): 0.1}, "measure": "normal"}),
        (design.Rosenblatt, {"variables": pair}),
        (design.LimitState, {"function": state["limit"], "step": 1e-4, "name": "g"}),
        (design.mac, {"a": np.eye(2), "b": np.eye(2)}),
        (
            design.identify,
            {
                "model": turn,
                "parameters": jo.Parameter("mass", 2.0, unit="kg"),
                "experiments": design.Values({"mass": (2.1, 0.1)}),
            },
        ),
        (design.limit_state, {"study": some, "limit": "m <= 3 kg", "step": 1e-4}),
        (design.form, {**state, "method": "hlrf", "start": {"a": 5.0, "b": 5.0}, "far": 9.0}),
        (design.sorm, {**state, "step": 0.1}),
        (
            design.system,
            {
                "limits": [state["limit"], lambda x: x["a"] - 2.0],
                "variables": pair,
                "kind": "parallel",
                "samples": 50,
                "seed": 1,
            },
        ),
        (design.pma, {**state, "beta": 2.0, "method": "hmv", "start": {"a": 5.0, "b": 5.0}}),
        (design.ria, {**state, "beta": 2.0}),
        (design.monte_carlo, {**state, "samples": 50, "seed": 1, "confidence": 0.9}),
        (design.importance_sampling, {**state, "samples": 50, "variation": 0.5}),
        (design.subset_simulation, {**state, "samples": 50, "share": 0.2, "levels": 9}),
        (design.check_linearisation, {"found": design.form(**state), "samples": 50}),
        (
            design.file_rbdo,
            {
                "file": spring,
                "limits": "frequency(1) >= 1 Hz",
                "cost": "k",
                "parameters": spring.parameters,
                "target": 2.0,
                "t_end": 0.01,
                "cycles": 20,
            },
        ),
        (
            design.rbdo,
            {
                "cost": lambda d: d["a"],
                "limits": [lambda x: x["a"] - x["b"]],
                "variables": pair,
                "bounds": {"a": (1.0, 20.0)},
                "beta": 2.0,
                "start": {"a": 10.0},
                "inner": "hmv",
                "cycles": 20,
            },
        ),
    ]
