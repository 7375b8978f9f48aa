"""EXUDYN's side of stress_exudyn.py: the stress of a modal body from its own output variables.

Run by `stress_exudyn.py` in an interpreter that has exudyn: ``python exudyn_stress.py FOLDER``.
The body is an ObjectFFRFreducedOrder with jousto's stress modes as its outputVariableModeBasis.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

sys.exudynFast = True  # type: ignore[attr-defined]  # its build without range checks, with AVX2
with contextlib.redirect_stdout(io.StringIO()):
    import exudyn as exu
    import exudyn.itemInterface as eii
    from exudyn.FEM import CMSObjectComputeNorm

ORDER = [0, 1, 2, 4, 5, 3]  # xx yy zz yz xz xy of it from xx yy zz xy yz xz
STRESS = exu.OutputVariableType.StressLocal


def model(
    nodes: np.ndarray, basis: np.ndarray, watched: Iterable[int], n: int
) -> tuple[Any, Any, Any]:
    """System with the body, its modal node and sensors of the watched nodes."""
    mbs = exu.SystemContainer().AddSystem()
    frame = mbs.AddNode(eii.NodeRigidBodyEP(referenceCoordinates=[0, 0, 0, 1, 0, 0, 0]))
    zero = [0.0] * n
    modal = mbs.AddNode(
        eii.NodeGenericODE2(
            numberOfODE2Coordinates=n,
            referenceCoordinates=zero,
            initialCoordinates=zero,
            initialCoordinates_t=zero,
        )
    )
    unit = exu.MatrixContainer()
    unit.SetWithDenseMatrix(np.eye(n), useDenseMatrix=False)
    body = mbs.AddObject(
        eii.ObjectFFRFreducedOrder(
            nodeNumbers=[frame, modal],
            massMatrixReduced=unit,
            stiffnessMatrixReduced=unit,
            modeBasis=np.zeros((3 * len(nodes), n)),
            referencePositions=nodes.ravel(),
            outputVariableModeBasis=basis,
            outputVariableTypeModeBasis=STRESS,
            mass=1.0,
            inertia=np.eye(3),
            centerOfMass=np.zeros(3),
            mPsiTildePsi=np.zeros((3 * n, n)),
            mPsiTildePsiTilde=np.zeros((3 * n, 3 * n)),
            mPhitTPsi=np.zeros((3, n)),
            mPhitTPsiTilde=np.zeros((3, 3 * n)),
            mXRefTildePsi=np.zeros((3, n)),
            mXRefTildePsiTilde=np.zeros((3, 3 * n)),
        )
    )
    for node in watched:
        mbs.AddSensor(
            eii.SensorSuperElement(
                bodyNumber=body, meshNodeNumber=node, storeInternal=True, outputVariableType=STRESS
            )
        )
    mbs.Assemble()
    return mbs, body, modal


def least(work: Callable[[], Any], seconds: float = 3.0) -> float:
    """Processor seconds of one call, the least of those that fit in some seconds."""
    best, begin = np.inf, time.monotonic()
    while time.monotonic() - begin < seconds:
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def solve(mbs: Any, steps: int) -> float:
    """Processor seconds of a run of so many steps."""
    s = exu.SimulationSettings()
    s.timeIntegration.numberOfSteps, s.timeIntegration.endTime = steps, 1e-3 * steps
    s.timeIntegration.verboseMode = 0
    s.timeIntegration.newton.useModifiedNewton = True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # names that it will change
        s.solutionSettings.writeSolutionToFile = False
        s.solutionSettings.sensorsWritePeriod = 1e-3
    s.parallel.numberOfThreads = 1
    start = time.process_time()
    if not mbs.SolveDynamic(s):
        raise RuntimeError("EXUDYN failed")
    return time.process_time() - start


def main() -> None:
    """Times in s: a frame of all nodes in three ways, a value, a value of a history."""
    folder = Path(sys.argv[1])
    data = np.load(folder / "body.npz")
    nodes, modes, p = data["nodes"], data["modes"], data["p"]
    ns, _, n = modes.shape
    basis = np.ascontiguousarray(modes[:, ORDER].transpose(0, 2, 1).reshape(ns, 6 * n))
    mbs, body, _ = model(nodes, basis, [], n)
    where = mbs.systemData
    state = np.array(where.GetODE2Coordinates())
    state[-n:] = p
    where.SetODE2Coordinates(state)

    def at(node: int) -> Any:
        return mbs.GetObjectOutputSuperElement(body, STRESS, node)

    checked = range(0, ns, max(1, ns // 500))
    result: dict[str, Any] = {"version": exu.__version__}
    values = np.empty((ns, 6))
    values[:, ORDER] = [at(i) for i in range(ns)]
    np.save(folder / "theirs.npy", values)
    result["frame, components"] = least(lambda: CMSObjectComputeNorm(mbs, body, STRESS, "max"))
    result["frame, von Mises"] = least(lambda: CMSObjectComputeNorm(mbs, body, STRESS, "Mises"))
    result["largest von Mises"] = float(CMSObjectComputeNorm(mbs, body, STRESS, "Mises"))
    result["value"] = least(lambda: [at(i) for i in checked]) / len(checked)

    # sensors in its C++ during a run: what they add to the same run
    bare = model(nodes, basis, [], n)[0]
    every = np.linspace(0, ns - 1, 200).astype(int).tolist()
    for name, watched, steps in (("history", every, 500), ("frame, sensors", range(ns), 20)):
        watching = model(nodes, basis, watched, n)[0]
        least_of = [solve(watching, steps) - solve(bare, steps) for _ in range(3)]
        result[name] = min(least_of) / (steps * (len(watched) if name == "history" else 1))
    print(json.dumps(result))


if __name__ == "__main__":
    main()
