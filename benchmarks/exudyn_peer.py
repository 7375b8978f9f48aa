"""The benchmark models in EXUDYN, with exactly the inertia, stiffness and joints of jousto's.

EXUDYN's modal body (ObjectFFRFreducedOrder) takes integrals over the body instead of a mesh, so
it gets jousto's own: with ``E_jk = int phi_j phi_k^T dm`` every one of its matrices is a sum of
entries of the invariants. Joint nodes, the tip and the centre of mass are its only mesh nodes.
Gravity is one force ``m g`` at the centre of mass, whose mode shape is ``int phi dm / m``: the sum
of the equivalent nodal loads, and the cheapest way to apply them. A revolute joint needs rotations,
which EXUDYN takes from the translations of at least three mesh nodes: the corners of a small rigid
cross at the joint.
"""

from __future__ import annotations

import contextlib
import io
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases import GRAVITY, LENGTH, Case

sys.exudynFast = True  # type: ignore[attr-defined]  # its build without range checks, with AVX2
with contextlib.redirect_stdout(io.StringIO()):  # it says so
    import exudyn as exu
    import exudyn.itemInterface as eii

Array = NDArray[np.float64]

# corners of the rigid cross that stands for the section at a revolute joint, m
CROSS = 0.01 * np.array([[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
# its joint turns about z of both marker frames; columns are the axes x, y, z of such a frame
TURN_Z_TO_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class Run:
    """What one model cost and computed."""

    microseconds: float  # per step, the least of several runs
    newton: float  # Newton iterations per step
    tip: Array  # (nt, 3) m, world position of the free end at the times of the case
    q: Array  # state at the end as jousto orders it: R, e, p of every body
    v: Array  # R', w_local, p' of every body


def skew(a: Array) -> Array:
    """Matrices of ``a x`` for vectors in the first axis: (3, ...) -> (3, 3, ...)."""
    zero = np.zeros_like(a[0])
    return np.array([[zero, -a[2], a[1]], [a[2], zero, -a[0]], [-a[1], a[0], zero]])


def integrals(reduced: Any) -> dict[str, Array]:
    """EXUDYN's constant matrices from ``N0_j = int u0 phi_j^T dm`` and E_jk.

    Blocks of mode j stand side by side or on top of each other in groups of three, as in
    ``exudyn.FEM.ComputeSkewMatrix``.
    """
    inv = reduced.invariants
    n = len(reduced.frequencies)
    eps = np.zeros((3, 3, 3))
    eps[0, 1, 2] = eps[1, 2, 0] = eps[2, 0, 1] = 1.0
    eps[0, 2, 1] = eps[2, 1, 0] = eps[1, 0, 2] = -1.0
    # (a~)_mi = -eps_mia a_a, so
    # (a~^T b)_i = -eps_mia a_a b_m and (a~^T b~)_il = eps_mia eps_mlb a_a b_b
    left = -eps
    both = np.einsum("mia,mlb->ilab", eps, eps)
    E, N0, I3, U0 = inv.E, inv.N0, inv.I3, inv.second_moment
    return {
        "inertia": np.einsum("ilab,ab->il", both, U0),
        "mPsiTildePsi": np.einsum("mia,jkam->jik", left, E).reshape(3 * n, n),
        "mPsiTildePsiTilde": np.einsum("ilab,jkab->jikl", both, E).reshape(3 * n, 3 * n),
        "mPhitTPsi": np.asarray(I3),
        "mPhitTPsiTilde": np.moveaxis(skew(I3), 2, 1).reshape(3, 3 * n),
        "mXRefTildePsi": np.einsum("mia,kam->ik", left, N0),
        "mXRefTildePsiTilde": np.einsum("ilab,kab->ikl", both, N0).reshape(3, 3 * n),
    }


def sparse(diagonal: Array) -> Any:
    matrix = exu.MatrixContainer()
    matrix.SetWithDenseMatrix(np.diag(diagonal), useDenseMatrix=False)
    return matrix


def mesh(reduced: Any) -> tuple[Array, Array]:
    """Mesh nodes and mode shapes: centre of mass, start, end, cross at start, cross at end.

    Returns positions (11, 3) in m and modes (33, n).
    """
    inv = reduced.invariants
    start, end = reduced.node("start"), reduced.node("end")
    x = [inv.first_moment / inv.mass, reduced.nodes[start], reduced.nodes[end]]
    phi = [inv.I3 / inv.mass, reduced.modes[start], reduced.modes[end]]
    for node in (start, end):
        for arm in CROSS:
            x.append(reduced.nodes[node] + arm)
            phi.append(reduced.modes[node] - skew(arm) @ reduced.rotations[node])
    return np.array(x), np.vstack(phi)


CENTRE, START, END = 0, 1, 2
START_CROSS, END_CROSS = [3, 4, 5, 6], [7, 8, 9, 10]


def marker(mbs: Any, case: Case, body: int, node: int, turn: Array) -> Any:
    """Marker at the start or end of a beam; with a frame whose z axis is the joint's axis."""
    if case.joint == "spherical":
        return mbs.AddMarker(
            eii.MarkerSuperElementPosition(
                bodyNumber=body, meshNodeNumbers=[node], weightingFactors=[1.0]
            )
        )
    return mbs.AddMarker(
        eii.MarkerSuperElementRigid(
            bodyNumber=body,
            localHT=exu.HT(rotation=turn, translation=np.zeros(3)),
            meshNodeNumbers=START_CROSS if node == START else END_CROSS,
            weightingFactors=[0.25] * 4,
        )
    )


def model(case: Case, reduced: Any) -> tuple[Any, int]:
    """Assembled system and the sensor of the free end."""
    mbs = exu.SystemContainer().AddSystem()
    x, phi = mesh(reduced)
    inv = reduced.invariants
    stiffness = (2.0 * np.pi * reduced.frequencies) ** 2
    constant = integrals(reduced)
    before = None
    for k in range(case.bodies):
        origin = np.array([k * LENGTH, 0.0, 0.0])
        frame = mbs.AddNode(eii.NodeRigidBodyEP(referenceCoordinates=[*origin, 1, 0, 0, 0]))
        modal = mbs.AddNode(
            eii.NodeGenericODE2(
                numberOfODE2Coordinates=case.modes,
                referenceCoordinates=[0.0] * case.modes,
                initialCoordinates=[0.0] * case.modes,
                initialCoordinates_t=[0.0] * case.modes,
            )
        )
        body = mbs.AddObject(
            eii.ObjectFFRFreducedOrder(
                nodeNumbers=[frame, modal],
                massMatrixReduced=sparse(np.ones(case.modes)),
                stiffnessMatrixReduced=sparse(stiffness),
                modeBasis=phi,
                referencePositions=x.ravel(),
                mass=inv.mass,
                centerOfMass=inv.first_moment / inv.mass,
                **constant,
            )
        )
        turn = np.eye(3) if k % 2 == 0 else TURN_Z_TO_Y
        if before is None:
            ground = mbs.AddObject(eii.ObjectGround())
            at = exu.HT(rotation=turn, translation=np.zeros(3))
            before = mbs.AddMarker(eii.MarkerBodyRigid(bodyNumber=ground, localHT=at))
        else:
            before = marker(mbs, case, before, END, turn)
        joint = eii.ObjectJointSpherical if case.joint == "spherical" else eii.ObjectJointRevoluteZ
        mbs.AddObject(joint(markerNumbers=[before, marker(mbs, case, body, START, turn)]))
        weight = mbs.AddMarker(
            eii.MarkerSuperElementPosition(
                bodyNumber=body, meshNodeNumbers=[CENTRE], weightingFactors=[1.0]
            )
        )
        mbs.AddLoad(
            eii.LoadForceVector(markerNumber=weight, loadVector=inv.mass * np.array(GRAVITY))
        )
        before = body
    tip = mbs.AddSensor(
        eii.SensorSuperElement(
            bodyNumber=before,
            meshNodeNumber=END,
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )
    mbs.Assemble()
    return mbs, tip


DEFAULT = 1e-8  # its own relative tolerance of Newton's iteration
LOOSER = (1e-4, 1e-5, 1e-6)
LIKE = 1.1  # errors within this factor are alike


def loosest(error: Callable[[float], float]) -> float:
    """Loosest tolerance whose error(tolerance) is that of the default one, to within `LIKE`."""
    allowed = LIKE * error(DEFAULT)
    for tolerance in LOOSER:
        with contextlib.suppress(exu.SolverError, RuntimeError):
            if error(tolerance) <= allowed:
                return tolerance
    return DEFAULT


def settings(
    case: Case, h: float, t_end: float, modified_newton: bool, tolerance: float = DEFAULT
) -> Any:
    """Generalised alpha, index 3, one thread, nothing written."""
    s = exu.SimulationSettings()
    s.timeIntegration.numberOfSteps = round(t_end / h)
    s.timeIntegration.endTime = t_end
    s.timeIntegration.verboseMode = 0
    s.timeIntegration.newton.useModifiedNewton = modified_newton
    s.timeIntegration.newton.relativeTolerance = tolerance
    s.solutionSettings.writeSolutionToFile = False
    s.solutionSettings.sensorsWritePeriod = case.times[0]
    s.solutionSettings.solutionWritePeriod = t_end
    s.parallel.numberOfThreads = 1
    s.linearSolverType = (
        exu.LinearSolverType.EigenDense if case.bodies == 1 else exu.LinearSolverType.EigenSparse
    )
    return s


def state(mbs: Any, case: Case) -> tuple[Array, Array]:
    """Present state in jousto's coordinates; EXUDYN stores changes from the reference and e'."""
    x = np.array(mbs.systemData.GetODE2Coordinates()).reshape(case.bodies, -1)
    x_t = np.array(mbs.systemData.GetODE2Coordinates_t()).reshape(case.bodies, -1)
    x[:, 0] += LENGTH * np.arange(case.bodies)
    x[:, 3] += 1.0
    v = []
    for (e0, e1, e2, e3), rate in zip(x[:, 3:7], x_t, strict=True):
        G = 2.0 * np.array([[-e1, e0, e3, -e2], [-e2, -e3, e0, e1], [-e3, e2, -e1, e0]])
        v.append(np.concatenate([rate[:3], G @ rate[3:7], rate[7:]]))
    return x.ravel(), np.concatenate(v)


def build(case: Case, reduced: Any, *, modified_newton: bool = False) -> Callable[..., Run]:
    """Return a function (h, t_end, repeats=1) -> Run of this case."""
    mbs, tip = model(case, reduced)

    def run(h: float, t_end: float, repeats: int = 1, tolerance: float = DEFAULT) -> Run:
        s = settings(case, h, t_end, modified_newton, tolerance)
        best, newton = np.inf, 0.0
        for _ in range(repeats):
            begin = time.process_time()  # not slowed by what else the machine does
            if not mbs.SolveDynamic(s, storeSolver=True):
                raise RuntimeError(f"EXUDYN failed: {case.name}, h = {h}")
            best = min(best, time.process_time() - begin)
            newton = mbs.sys["dynamicSolver"].it.newtonStepsCount
        steps = s.timeIntegration.numberOfSteps
        stored = np.asarray(mbs.GetSensorStoredData(tip))
        return Run(1e6 * best / steps, newton / steps, stored[1:, 1:4], *state(mbs, case))

    return run
