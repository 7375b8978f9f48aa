"""The hanging strip of beams.py as geometrically exact beams of EXUDYN, in space and in the plane.

EXUDYN 1.13.6 converges on meshes of 100 elements only if its relative Newton tolerance is raised
from 1e-8 to 1e-6 or more: with the default it halves the step over and over. Its nodes have Euler
parameters; Tait-Bryan angles take as long, and its Lie-group nodes do not converge here.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exudyn_peer import eii, exu

TIGHT, LOOSE = 1e-6, 1e-4  # relative tolerance of Newton; for fine solutions, and for times
INSTANTS = 10


@dataclass(frozen=True)
class Strip:
    """A straight beam along x, hinged at the origin, that falls from rest.

    Stiffness as [N, Qy, Qz, T, My, Mz] of [extension, shear, shear, twist, bending, bending], in N
    and N m2; inertia of the section about its axes, kg m.
    """

    length: float
    mass: float  # kg/m
    inertia: tuple[float, float, float]
    stiffness: tuple[float, float, float, float, float, float]
    gravity: tuple[float, float, float]


@dataclass(frozen=True)
class Run:
    """What one run cost and computed."""

    microseconds: float  # per step
    newton: float  # Newton iterations per step
    tip: NDArray[np.float64]  # (INSTANTS, 3) m


def spatial(strip: Strip, elements: int) -> tuple[Any, int]:
    """Assembled system of ObjectBeamGeometricallyExact on a spherical joint, sensor of the tip."""
    mbs = exu.SystemContainer().AddSystem()
    section = exu.BeamSection()
    section.massPerLength = strip.mass
    section.inertia = np.diag(strip.inertia)
    section.stiffnessMatrix = np.diag(strip.stiffness)
    h = strip.length / elements
    nodes = [
        mbs.AddNode(eii.NodeRigidBodyEP(referenceCoordinates=[i * h, 0, 0, 1, 0, 0, 0]))
        for i in range(elements + 1)
    ]
    for pair in zip(nodes, nodes[1:], strict=False):
        body = mbs.AddObject(
            eii.ObjectBeamGeometricallyExact(nodeNumbers=list(pair), length=h, sectionData=section)
        )
        weigh(mbs, body, strip)
    ground = mbs.AddMarker(eii.MarkerBodyPosition(bodyNumber=mbs.AddObject(eii.ObjectGround())))
    start = mbs.AddMarker(eii.MarkerNodePosition(nodeNumber=nodes[0]))
    mbs.AddObject(eii.SphericalJoint(markerNumbers=[ground, start]))
    return finish(mbs, nodes[-1])


def planar(strip: Strip, elements: int) -> tuple[Any, int]:
    """The same of ObjectBeamGeometricallyExact2D: three coordinates a node, gravity along y."""
    mbs = exu.SystemContainer().AddSystem()
    h = strip.length / elements
    nodes = [
        mbs.AddNode(eii.NodeRigidBody2D(referenceCoordinates=[i * h, 0, 0]))
        for i in range(elements + 1)
    ]
    for pair in zip(nodes, nodes[1:], strict=False):
        body = mbs.AddObject(
            eii.ObjectBeamGeometricallyExact2D(
                nodeNumbers=list(pair),
                physicsLength=h,
                physicsMassPerLength=strip.mass,
                physicsCrossSectionInertia=strip.inertia[2],
                physicsAxialStiffness=strip.stiffness[0],
                physicsShearStiffness=strip.stiffness[1],
                physicsBendingStiffness=strip.stiffness[5],
            )
        )
        weigh(mbs, body, strip)
    ground = mbs.AddMarker(eii.MarkerBodyPosition(bodyNumber=mbs.AddObject(eii.ObjectGround())))
    start = mbs.AddMarker(eii.MarkerNodePosition(nodeNumber=nodes[0]))
    mbs.AddObject(eii.RevoluteJoint2D(markerNumbers=[ground, start]))
    return finish(mbs, nodes[-1])


def weigh(mbs: Any, body: Any, strip: Strip) -> None:
    marker = mbs.AddMarker(eii.MarkerBodyMass(bodyNumber=body))
    mbs.AddLoad(eii.LoadMassProportional(markerNumber=marker, loadVector=list(strip.gravity)))


def finish(mbs: Any, node: Any) -> tuple[Any, int]:
    sensor = mbs.AddSensor(
        eii.SensorNode(
            nodeNumber=node, storeInternal=True, outputVariableType=exu.OutputVariableType.Position
        )
    )
    mbs.Assemble()
    return mbs, sensor


def run(
    build: Any,
    strip: Strip,
    elements: int,
    step: float,
    end: float,
    modified: bool,
    tries: int = 1,
    tolerance: float = LOOSE,
) -> Run:
    """Simulate from rest with generalised alpha; the least time of several tries."""
    best = np.inf
    for _ in range(tries):
        mbs, sensor = build(strip, elements)
        settings = exu.SimulationSettings()
        steps = round(end / step)
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.endTime = end
        settings.timeIntegration.newton.useModifiedNewton = modified
        settings.timeIntegration.newton.relativeTolerance = tolerance
        settings.timeIntegration.verboseMode = 0
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = end / INSTANTS
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        begin = time.process_time()
        mbs.SolveDynamic(settings)
        best = min(best, time.process_time() - begin)
        newton = mbs.sys["dynamicSolver"].it.newtonStepsCount / steps
        tip = np.array(mbs.GetSensorStoredData(sensor))[-INSTANTS:, 1:4]
    return Run(1e6 * best / steps, newton, tip)
