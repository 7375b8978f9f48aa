"""The rigid chains, slider-crank and four-bar of machines.py in EXUDYN."""

from __future__ import annotations

import contextlib
import io
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import exudyn_peer as peer
import exudyn_tree
import machines
import trees
from cases import GRAVITY, LENGTH
from exudyn_peer import TURN_Z_TO_Y, eii, exu
from machines import CENTER, INERTIA, MASS, PIVOT, RAIL, Link, RigidChain

Array = NDArray[np.float64]
# rigid bodies with rotation vectors and a Lie group integrator: no constraint on Euler parameters,
# the faster choice
NODE = exu.NodeType.RotationRotationVector


@dataclass(frozen=True)
class Run:
    """What one model cost and computed."""

    microseconds: float  # per step, the least of several runs
    newton: float  # Newton iterations per step
    tip: Array  # (nt, 3) m, world position of the sensor
    kind: str  # "modified" or, where that does not converge, "full"


def at(mbs: Any, body: Any, point: Any, turn: Array | None = None) -> Any:
    """Marker on a rigid body or ground: a point, or a frame."""
    if turn is None:
        return mbs.AddMarker(eii.MarkerBodyPosition(bodyNumber=body, localPosition=list(point)))
    return mbs.AddMarker(
        eii.MarkerBodyRigid(
            bodyNumber=body, localHT=exu.HT(rotation=turn, translation=np.array(point, float))
        )
    )


def rigid(mbs: Any, mass: float, inertia: Array, center: Any, position: Any, turn: Array) -> Any:
    """A rigid body that falls; returns its object."""
    com = np.array(center, float)
    full = exu.rigidBodyUtilities.RigidBodyInertia(
        mass=mass, inertiaTensor=np.diag(inertia), inertiaTensorAtCOM=True, com=com
    )
    created = mbs.CreateRigidBody(
        inertia=full,
        nodeType=NODE,
        referencePosition=list(position),
        referenceRotationMatrix=turn,
        gravity=list(GRAVITY),
        returnDict=True,
    )
    return created["bodyNumber"]


def modal(mbs: Any, link: Link) -> Any:
    """A flexible link that falls; returns its object."""
    reduced: Any = link.reduced
    n, inv = len(reduced.frequencies), reduced.invariants
    x, phi = peer.mesh(reduced)
    e = exu.rigidBodyUtilities.RotationMatrix2EulerParameters(link.turn)
    frame = mbs.AddNode(eii.NodeRigidBodyEP(referenceCoordinates=[*link.start, *e]))
    node = mbs.AddNode(
        eii.NodeGenericODE2(
            numberOfODE2Coordinates=n,
            referenceCoordinates=[0.0] * n,
            initialCoordinates=[0.0] * n,
            initialCoordinates_t=[0.0] * n,
        )
    )
    body = mbs.AddObject(
        eii.ObjectFFRFreducedOrder(
            nodeNumbers=[frame, node],
            massMatrixReduced=peer.sparse(np.ones(n)),
            stiffnessMatrixReduced=peer.sparse((2.0 * np.pi * reduced.frequencies) ** 2),
            modeBasis=phi,
            referencePositions=x.ravel(),
            mass=inv.mass,
            centerOfMass=inv.first_moment / inv.mass,
            **peer.integrals(reduced),
        )
    )
    weight = on_mesh(mbs, body, peer.CENTRE)
    load = inv.mass * np.array(GRAVITY)
    mbs.AddLoad(eii.LoadForceVector(markerNumber=weight, loadVector=load))
    return body


def on_mesh(mbs: Any, body: Any, node: int) -> Any:
    return mbs.AddMarker(
        eii.MarkerSuperElementPosition(
            bodyNumber=body, meshNodeNumbers=[node], weightingFactors=[1.0]
        )
    )


def hinge(mbs: Any, body: Any, turn: Array) -> Any:
    """Frame at the start of a flexible link."""
    return mbs.AddMarker(
        eii.MarkerSuperElementRigid(
            bodyNumber=body,
            localHT=exu.HT(rotation=turn, translation=np.zeros(3)),
            meshNodeNumbers=peer.START_CROSS,
            weightingFactors=[0.25] * 4,
        )
    )


def spherical(mbs: Any, a: Any, b: Any) -> None:
    mbs.AddObject(eii.ObjectJointSpherical(markerNumbers=[a, b]))


def mesh_sensor(mbs: Any, body: Any) -> Any:
    return mbs.AddSensor(
        eii.SensorSuperElement(
            bodyNumber=body,
            meshNodeNumber=peer.END,
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )


def rigid_chain(case: RigidChain) -> tuple[Any, Any]:
    """Redundant coordinates and joints; the system and the sensor of the free end."""
    mbs = exu.SystemContainer().AddSystem()
    body = mbs.AddObject(eii.ObjectGround())
    point: Any = (0.0, 0.0, 0.0)
    for k in range(case.bodies):
        new = rigid(mbs, MASS, INERTIA, CENTER, (k * LENGTH, 0.0, 0.0), np.eye(3))
        if case.joint == "spherical":
            spherical(mbs, at(mbs, body, point), at(mbs, new, (0, 0, 0)))
        else:
            turn = np.eye(3) if k % 2 == 0 else TURN_Z_TO_Y
            markers = [at(mbs, body, point, turn), at(mbs, new, (0, 0, 0), turn)]
            mbs.AddObject(eii.ObjectJointRevoluteZ(markerNumbers=markers))
        body, point = new, (LENGTH, 0.0, 0.0)
    tip = mbs.AddSensor(
        eii.SensorBody(
            bodyNumber=body,
            localPosition=list(point),
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )
    return mbs, tip


def tree(case: RigidChain) -> tuple[Any, Any]:
    """The chain with revolute joints in joint angles: EXUDYN's kinematic tree."""
    return exudyn_tree.tree(trees.chain("hinge", case.bodies))


def slider_crank() -> tuple[Any, Any]:
    """Spatial slider-crank with a flexible rod."""
    mbs = exu.SystemContainer().AddSystem()
    crank, rod = machines.slider_crank_links()
    ground = mbs.AddObject(eii.ObjectGround())
    center = (crank.length / 2.0, 0.0, 0.0)
    a = rigid(mbs, crank.mass, crank.inertia, center, crank.start, crank.turn)
    b = modal(mbs, rod)
    c = rigid(mbs, 2.0, np.full(3, 0.01), np.zeros(3), rod.end, np.eye(3))
    axes = [at(mbs, ground, (0, 0, 0), np.eye(3)), at(mbs, a, (0, 0, 0), crank.turn.T)]
    mbs.AddObject(eii.ObjectJointRevoluteZ(markerNumbers=axes))
    spherical(mbs, at(mbs, a, (crank.length, 0, 0)), on_mesh(mbs, b, peer.START))
    spherical(mbs, on_mesh(mbs, b, peer.END), at(mbs, c, (0, 0, 0)))
    rail = [at(mbs, ground, rod.end, np.eye(3)), at(mbs, c, (0, 0, 0), np.eye(3))]
    mbs.AddObject(eii.ObjectJointPrismaticX(markerNumbers=rail))
    assert rod.end[2] == RAIL
    return mbs, mesh_sensor(mbs, b)


def four_bar() -> tuple[Any, Any]:
    """Spatial four-bar of three flexible links."""
    mbs = exu.SystemContainer().AddSystem()
    links = machines.four_bar_links()
    ground = mbs.AddObject(eii.ObjectGround())
    crank, coupler, rocker = (modal(mbs, link) for link in links)
    for point, link, body in (((0, 0, 0), links[0], crank), (PIVOT, links[2], rocker)):
        axes = [at(mbs, ground, point, np.eye(3)), hinge(mbs, body, link.turn.T)]
        mbs.AddObject(eii.ObjectJointRevoluteZ(markerNumbers=axes))
    spherical(mbs, on_mesh(mbs, crank, peer.END), on_mesh(mbs, coupler, peer.START))
    spherical(mbs, on_mesh(mbs, coupler, peer.END), on_mesh(mbs, rocker, peer.END))
    return mbs, mesh_sensor(mbs, coupler)


def runner(
    mbs: Any, tip: Any, times: Array, *, dense: bool, explicit: bool = False
) -> Callable[..., Run]:
    """Return a function (h, repeats=1, tolerance=1e-8) -> Run of generalised alpha or Runge-Kutta.

    Modified Newton is the faster choice; full Newton where it fails.
    """
    mbs.Assemble()

    def run(h: float, repeats: int = 1, tolerance: float = peer.DEFAULT) -> Run:
        try:
            return attempt(h, repeats, True, tolerance)
        except exu.SolverError:
            return attempt(h, repeats, False, tolerance)

    def attempt(h: float, repeats: int, modified: bool, tolerance: float) -> Run:
        s = exu.SimulationSettings()
        s.timeIntegration.numberOfSteps = round(times[-1] / h)
        s.timeIntegration.endTime = times[-1]
        s.timeIntegration.verboseMode = 0
        s.timeIntegration.newton.useModifiedNewton = modified
        s.timeIntegration.newton.relativeTolerance = tolerance
        s.solutionSettings.writeSolutionToFile = False
        s.solutionSettings.sensorsWritePeriod = times[0]
        s.solutionSettings.solutionWritePeriod = times[-1]
        s.parallel.numberOfThreads = 1
        kinds = exu.LinearSolverType
        s.linearSolverType = kinds.EigenDense if dense else kinds.EigenSparse
        solver = exu.DynamicSolverType.RK44 if explicit else exu.DynamicSolverType.GeneralizedAlpha
        steps = s.timeIntegration.numberOfSteps

        def once() -> float:
            begin = time.process_time()  # not slowed by what else the machine does
            with contextlib.redirect_stdout(io.StringIO()):
                mbs.SolveDynamic(s, solverType=solver, storeSolver=True)
            return time.process_time() - begin

        best = min(once() for _ in range(repeats))
        newton = mbs.sys["dynamicSolver"].it.newtonStepsCount
        stored = np.asarray(mbs.GetSensorStoredData(tip))
        kind = "modified" if modified else "full"
        return Run(1e6 * best / steps, newton / steps, stored[1:, 1:4], kind)

    return run
