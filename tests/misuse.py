"""Calls of the public interface that work, of which one argument at a time is then spoilt."""

from __future__ import annotations

import inspect
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
from measurement.monitor import watched
from session import EXAMPLES, STEEL, objects

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

NO_FILE = {"mesh_step", "read_matrices", "reduce_superelement", "identify_payload"}
"""Calls that fail for want of a file of another program or of a moving twin."""
NOT_CALLED = {"materials", "sn_curves", "strain_lives", "solvers"}
"""Public functions without arguments."""


@cache
def calls(folder: Path) -> dict[str, Call]:
    """Return calls by the name of what is called; arguments left out have defaults."""
    made = objects()
    found: dict[str, Call] = {}
    for part in (_machines, _parts, _analyses, _recovery, _fatigue, _twins):
        for what, given in part(made, folder):
            name = what.__qualname__
            found[name] = (what, given)
    return found


def arguments(what: Callable[..., Any]) -> list[str]:
    """Return the names of the arguments that can be spoilt."""
    kinds = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return [x.name for x in inspect.signature(what).parameters.values() if x.kind not in kinds]


def _machines(made: Made, _: Path) -> list[Call]:
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
    ]
    moved = [
        *(jo.PositionSensor, jo.VelocitySensor, jo.AccelerationSensor, jo.OrientationSensor),
        *(jo.AngularVelocitySensor, jo.AngularAccelerationSensor),
    ]
    sites = (jo.StressSensor, jo.VonMisesSensor, jo.PrincipalStressSensor)
    return [
        (jo.RigidBody, {"name": "r", "mass": 1.0, "inertia": (1.0, 1.0, 1.0)}),
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
        (jo.BeamSection, {"stiffness": np.eye(6), "mass": 1.0, "inertia": np.eye(3)}),
        (jo.BeamDamping, {}),
        (jo.ground.at, {"position": (0, 0, 0)}),
        (ball.at, {"position": (0, 0, 0)}),
        *((kind, joint) for kind in placed),
        (jo.Rod, {"name": "j", "a": a, "b": arm["end"]}),
        (jo.Screw, joint | {"pitch": 0.1}),
        *((kind, sensor) for kind in moved),
        (jo.CoordinateSensor, {"name": "s", "coordinate": angle}),
        (jo.RateSensor, {"name": "s", "coordinate": angle}),
        (jo.EnergySensor, {"name": "s", "energy": "kinetic"}),
        (jo.SignalSensor, {"name": "s", "signal": one}),
        (jo.ReactionSensor, {"name": "s", "joint": hinge}),
        (jo.ForceSensor, {"name": "s", "force": spring}),
        (jo.ModalSensor, {"name": "s", "body": arm}),
        *((kind, {"name": "s", "body": arm}) for kind in sites),
        (jo.SectionSensor, {"name": "s", "beam": arch}),
        (
            jo.DamageSensor,
            {"name": "s", "sensor": gauge, "sn": made["curve"], "residue": "half", "factor": 1.0},
        ),
        (jo.Gauge, {"name": "s", "body": arm, "at": "e1.a.top"}),
        (jo.Bridge, {"name": "s", "arms": gauge}),
        (jo.Temperature, {"signal": 20.0, "part": 1e-5}),
        (jo.Angle, {"a": a, "b": b}),
        (jo.Displacement, {"a": a, "b": b}),
        (jo.Distance, {"a": a, "b": b}),
        (jo.Force, {"name": "f", "marker": b, "vector": (1, 0, 0)}),
        (jo.Torque, {"name": "f", "marker": b, "vector": (1, 0, 0)}),
        (jo.Gravity, {"acceleration": (0, 0, -9.81)}),
        (jo.Spring, {"name": "f", "coordinate": angle, "stiffness": 1.0}),
        (jo.Bushing, {"name": "f", "a": a, "b": b, "stiffness": 1.0}),
        (jo.JointForce, {"name": "f", "coordinate": angle, "signal": one}),
        (jo.Servo, {"name": "f", "coordinate": angle, "reference": one, "kp": 1.0}),
        (jo.UserForce, {"name": "f", "marker": b, "function": lambda t, x: [0.0] * 6}),
        (jo.ModalLoad, {"name": "f", "body": arm, "pattern": np.zeros((5, 3))}),
        (jo.LineLoad, {"name": "f", "beam": arch, "force": (0, 0, 1)}),
        (jo.Friction, {"name": "f", "joint": wrist, "mu_kinetic": 0.1, "radius": 0.01}),
        (jo.Regularised, {}),
        (jo.Drive, {"name": "d", "coordinate": angle, "signal": one}),
        (jo.Coupling, {"name": "c", "coordinates": [angle, wrist.angle], "factors": [1.0, 2.0]}),
        (jo.Gear, {"name": "c", "a": angle, "b": wrist.angle, "ratio": 2.0}),
        (jo.Initial, {"coordinate": angle, "value": 0.1}),
        (jo.Event, {"name": "e", "watch": angle}),
        (jo.Switched, {"event": made["mechanism"].events[0], "before": 0.0, "after": 1.0}),
        (jo.Constant, {"value": 1.0}),
        (jo.ConstantSpeed, {"speed": 1.0}),
        (jo.Harmonic, {"frequency": 1.0}),
        (jo.Ramp, {"start": 0.0, "end": 1.0}),
        (jo.Step, {"time": 1.0}),
        (jo.SCurve, {"times": [0, 1], "values": [0, 1]}),
        (jo.Table, {"times": [0, 1], "values": [0, 1]}),
        (jo.Input, {"name": "u"}),
        (jo.Rotate, {"axis": (0, 0, 1), "degrees": 3.0}),
        (jo.DamageMeter, {"sn": made["curve"], "residue": "half"}),
        (
            jo.MovingLoad,
            {
                "name": "f",
                "body": arm,
                "path": ("start", "end"),
                "position": 0.0,
                "vector": (0, 0, 1),
            },
        ),
    ]


def _parts(made: Made, folder: Path) -> list[Call]:
    beam, mesh = made["beam"], made["mesh"]
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
        (jo.GeneralSection, {"A": 1e-2, "Iy": 1e-6, "Iz": 1e-6, "J": 1e-6}),
        (jo.PointMass, {"node": 0, "mass": 1.0}),
        (jo.CraigBampton, {"modes": 2}),
        (jo.FreeFree, {"modes": 2}),
        (jo.Rayleigh, {"alpha": 0.0, "beta": 1e-3}),
        (jo.InBox, {"low": (0, 0, 0), "high": (1, 1, 1)}),
        (jo.InSphere, {"point": (0, 0, 0), "radius": 1.0}),
        (jo.InCylinder, {"point": (0, 0, 0), "axis": (0, 0, 1), "radius": 1.0}),
        (jo.Nearest, {"point": (0, 0, 0)}),
        (jo.Mesh, {"name": "m", "nodes": mesh.nodes, "cells": mesh.cells}),
        (jo.Cells, {"kind": "tetra", "nodes": [(0, 1, 2, 3)]}),
        (mesh.box, {"lo": (0, 0, 0), "hi": (1, 1, 1)}),
        (mesh.with_set, {"name": "s", "nodes": [0, 1]}),
        (mesh.nearest, {"point": (0, 0, 0)}),
        (jo.read_mesh, {"path": jo.write(mesh, folder / "m.vtu")}),
        (jo.mesh_step, {"path": "x.step", "size": 1.0}),
        (jo.read_matrices, {"K": "x.mtx"}),
        (jo.reduce, {"part": beam, "method": jo.CraigBampton(("start",), modes=2)}),
        (jo.certify, {"part": beam, "reduced": made["reduced"]}),
        (jo.advise, {"part": beam, "interfaces": ("start",), "frequency_limit": 300.0}),
        (jo.clamp, {"reduced": made["reduced"], "node": "start"}),
        (jo.inertia_relief, {"part": beam, "loads": np.ones(beam.M.shape[0])}),
        (
            jo.memory_estimate,
            {"part": beam, "method": jo.CraigBampton(("start",), modes=2)},
        ),
        (jo.mesh_error, {"part": made["solid"], "d": np.zeros(made["solid"].M.shape[0])}),
        (
            jo.place_errors,
            {"part": made["solid"], "d": np.zeros(made["solid"].M.shape[0])},
        ),
        (jo.reduce_superelement, {"matrices": None}),
        (jo.weld_stress, {"part": made["solid"], "toes": _toe()}),
        (made["reduced"].keep, {"indices": [0, 1]}),
        (made["reduced"].node, {"name": "start"}),
        (jo.ReductionCache, {"folder": "cache"}),
    ]


def _toe() -> jo.WeldToe:
    return jo.WeldToe("toe", (0.05, 0.0, 0.025), (0.0, 0.0, 1.0), 0.01)


def _member() -> jo.Member:
    return jo.Member((0, 0, 0), (1, 0, 0), jo.Circle(0.01), STEEL)


def _analyses(made: Made, folder: Path) -> list[Call]:
    model, run, beams = made["model"], made["run"], made["beam model"]
    few = replace(made["compared"], pairs=made["compared"].pairs[:3])
    return [
        (jo.compile, {"mechanism": made["mechanism"]}),
        (jo.doctor, {"mechanism": made["mechanism"]}),
        (jo.Engine, {"model": model}),
        (jo.simulate, {"model": model, "t_end": 0.002}),
        (jo.Simulator, {"model": model}),
        (jo.load, {"path": run.save(folder / "run.h5")}),
        (jo.read_model, {"path": EXAMPLES / "flexible_pendulum.yaml"}),
        (jo.equilibrium, {"model": beams}),
        (jo.settled, {"model": model}),
        (jo.steady_rotation, {"model": beams, "axis": (0, 0, 1), "speed": 0.0}),
        (jo.modes, {"model": beams}),
        (jo.linearise, {"model": beams}),
        (jo.buckling, {"model": beams, "parameter": "load", "count": 1}),
        (jo.load_path, {"model": beams, "parameter": "load", "to": 10.0, "steps": 1}),
        (jo.kinematics, {"model": made["driven"], "times": [0.0, 0.1]}),
        (jo.inverse_dynamics, {"model": made["driven"], "times": [0.0, 0.1]}),
        (jo.campbell, {"build": lambda _: beams, "values": [1.0]}),
        *((kind, {}) for kind in (jo.RK4, jo.ROS2, jo.GeneralizedAlpha, jo.Newmark)),
        (jo.DormandPrince, {}),
        (jo.Baumgarte, {"alpha": 1.0, "beta": 1.0}),
        (jo.ArcLength, {}),
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
        (jo.stress_field, {"run": run, "body": "arm"}),
        (field.values, {"criterion": "von-mises"}),
        (field.envelope, {"criterion": "von-mises"}),
        (field.history, {"site": "e1.a.top"}),
        (
            jo.field_from,
            {"modes": made["reduced"].stress, "p": np.zeros((3, 10)), "time": [0.0, 0.1, 0.2]},
        ),
        (DRAW["StressField"], {"field": field.only("e1.a.top"), "path": "stress.png"}),
        (WRITE["StressField vtu"], {"run": run, "field": field, "path": "contour.vtu"}),
        (jo.hot_spots, {"source": field}),
        (jo.error_budget, {"found": made["spots"]}),
        (jo.friction_stress, {"with_run": run, "without_run": run, "body": "arm"}),
        (jo.section_forces, {"run": made["beam run"], "beam": "arch"}),
        (jo.without_friction, {"mechanism": made["mechanism"]}),
        (jo.Plane, {"normal": (0, 0, 1)}),
        (jo.read_record, {"path": run.to_csv(folder / "record.csv")}),
        (jo.record_of, {"run": run}),
        (jo.compare_gauges, {"run": run, "measured": made["record"], "align": False}),
        (jo.rosette_state, {"e": [1e-4, 1e-4, 1e-4], "E": 2.1e11, "nu": 0.3}),
        (jo.gauge_rows, {"gauges": [made["mechanism"].sensors[2]]}),
        (jo.bridge_output, {"r": np.zeros(4)}),
        (jo.quarter_bridge_strain, {"output": 1e-3}),
    ]


def _fatigue(made: Made, _: Path) -> list[Call]:
    field, curve, notch = made["field"], made["curve"], made["notch"]
    history, cycles = [0.0, 3e8, -1e8, 2e8], made["cycles"]
    s = np.zeros((20, 6))
    s[:, 0] = 1e8 * np.sin(np.arange(20))
    frequency = np.linspace(1.0, 100.0, 10)
    psd = {"frequency": frequency, "psd": np.ones(10)}
    return [
        (jo.rainflow, {"series": history, "residue": "half"}),
        (jo.SN, {"S_D": 1e8, "N_D": 1e6, "k": 5.0}),
        (jo.sn_curve, {"name": "fat71"}),
        (jo.fat_class, {"fat": 71}),
        (jo.estimate_sn, {"strength": 5e8}),
        (jo.damage, {"cycles": cycles, "sn": curve}),
        (jo.life, {"cycles": cycles, "sn": curve}),
        (jo.assess, {"history": cycles, "sn": curve}),
        (jo.stress_safety, {"cycles": cycles, "sn": curve}),
        (jo.damage_field, {"source": field, "sn": curve, "residue": "half"}),
        (made["damage field"].at, {"site": "e1.a.top"}),
        (jo.site_cycles, {"source": field, "site": "e1.a.top", "residue": "half"}),
        (jo.DutyCycle, {"events": [(field, 2)]}),
        (jo.critical_plane, {"stress": s, "criterion": jo.Findley(0.3)}),
        (jo.multiaxial, {"stress": s, "criterion": jo.Findley(0.3)}),
        (
            jo.plane_damage,
            {"stress": s, "criterion": jo.Findley(0.3), "curve": curve, "residue": "half"},
        ),
        (jo.local_cycles, {"series": history, "material": notch, "residue": "half"}),
        (jo.local_path, {"series": history, "material": notch}),
        (jo.neuber, {"stress": history, "material": notch}),
        (jo.glinka, {"stress": history, "material": notch}),
        (
            jo.strain_damage,
            {"field": field, "material": notch, "residue": "half", "sites": "e1.a.top"},
        ),
        (jo.strain_life, {"name": "sae-1045"}),
        (jo.spectral_damage, psd | {"sn": curve}),
        (jo.spectral_moments, psd),
        (jo.synthesise, psd | {"duration": 1.0, "rate": 500.0}),
        (
            jo.random_response,
            {"reduced": made["reduced"], **psd, "base": "start", "direction": (0, 0, 1)},
        ),
        (jo.hertz_line, {"force": 1e4, "length": 0.03, "radius": 0.1, "material": STEEL}),
        (jo.hertz_point, {"force": 1e4, "radii": (0.1, 0.1), "material": STEEL}),
        (jo.rolling_contact, {"contact": made["hertz"], "depths": [3e-4]}),
        (
            jo.rolling_life,
            {
                "contact": made["hertz"],
                "forces": [8e3],
                "criterion": jo.DangVan.of(3e8, 4e8),
                "depths": [3e-4],
            },
        ),
        (jo.roughness_factor, {"Rz": 2e-5, "S_u": 5e8}),
        (jo.size_factor, {"diameter": 0.05}),
        (jo.thickness_factor, {"thickness": 0.05}),
        (jo.finish_factor, {"finish": "ground", "S_u": 5e8}),
        (jo.load_factor, {"load": "axial"}),
        (jo.reliability_factor, {"survival": 0.9}),
        (jo.shakedown_limit, {}),
        (jo.hot_spot_stress, {"stress": [1.0, 2.0]}),
        (jo.Findley, {}),
        (jo.DangVan, {"a": 0.3, "b": 1e8}),
        (jo.FatemiSocie, {"S_y": 3e8, "E": 2.1e11}),
        (jo.Goodman, {"S_u": 5e8}),
        (jo.Walker, {"gamma": 0.5}),
        (jo.FKM, {"M": 0.3}),
        (jo.StrainLife, {"E": 2.1e11, "sf": 9e8, "b": -0.09, "ef": 0.3, "c": -0.5}),
        (jo.WeldToe, {"name": "t", "at": (0, 0, 0), "away": (1, 0, 0), "thickness": 0.01}),
    ]


def _twins(made: Made, folder: Path) -> list[Call]:
    reduced, B = watched.cantilever()
    t, _p, e = watched.motion(50)
    twin, observed = made["twin"], made["observed"]
    data = watched.written(folder / "d.csv", watched.lines(t, e))
    return [
        (jo.Reconstruction, {"B": B}),
        (twin.estimate, {"e": e}),
        (jo.UnknownLoad, {"place": "end"}),
        (jo.Accelerometer, {"name": "a", "node": "end"}),
        (jo.Balance, {"force": 1.0, "moment": 1.0}),
        (
            jo.Observer,
            {"reduced": reduced, "gauges": B, "loads": [made["load"]], "step": 0.01},
        ),
        (made["observer"].run, {"time": t, "e": e}),
        (jo.stress_band, {"estimate": made["estimate"], "modes": reduced, "sites": "e1.a.top"}),
        (
            jo.damage_band,
            {
                "observed": observed,
                "modes": reduced,
                "sn": watched.curve(),
                "residue": "half",
                "sites": "e1.a.top",
                "draws": 20,
            },
        ),
        (jo.place_gauges, {"candidates": reduced, "count": 3}),
        (jo.identify_fourier, {"twin": twin, "time": t, "e": e, "part": reduced}),
        (jo.identify_payload, {"observed": observed, "place": "node11"}),
        (jo.innovation_test, {"observed": observed}),
        (jo.gauge_errors, {"gauges": [jo.Gauge("g", reduced, "e1.a.top")]}),
        (jo.identify_loads, {"observer": made["observer"], "time": t, "e": e}),
        (jo.Monitor, {"twin": twin, "modes": reduced, "spots": watched.SPOTS}),
        (jo.AlarmLimits, {}),
        (jo.ChannelRules, {}),
        (jo.watch, {"monitor": watched.monitor(), "source": data, "path": folder / "w.h5"}),
        (jo.MonitorRecord, {"path": made["watched"].path}),
    ]
