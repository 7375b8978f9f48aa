"""EXUDYN's side of reduction.py: Hurty-Craig-Bampton modes and stress modes of given matrices.

Run by `reduction.py` in an interpreter that has exudyn:
``python exudyn_reduction.py FOLDER MODES``.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.sparse as sp

with contextlib.redirect_stdout(io.StringIO()):
    import exudyn
    from exudyn.FEM import FEMinterface, HCBstaticModeSelection, KirchhoffMaterial


def peak() -> float:
    """MiB at the peak since the last call."""
    lines = Path("/proc/self/status").read_text().splitlines()
    value = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    Path("/proc/self/clear_refs").write_text("5")
    return value / 1024.0


def model(K: sp.csr_matrix, M: sp.csr_matrix, nodes: np.ndarray, tets: np.ndarray) -> FEMinterface:
    """Return the matrices as EXUDYN keeps them; its stress knows tetrahedra of four nodes."""
    fem = FEMinterface()
    fem.nodes = {"Position": nodes}
    fem.massMatrix, fem.stiffnessMatrix = M, K
    fem.elements = [{"Name": "solid", "Tet4": tets}]
    return fem


def rigid(nodes: np.ndarray) -> np.ndarray:
    """Six rigid motions as columns."""
    x = nodes - nodes.mean(axis=0)
    R = np.zeros((len(x), 3, 6))
    R[:, :, :3] = np.eye(3)
    for a in range(3):
        R[:, :, 3 + a] = np.cross(np.eye(3)[a], x)
    return R.reshape(-1, 6)


def main() -> None:
    """Reduce, recover the stress modes, and stress of a given displacement of a beam."""
    folder, modes = Path(sys.argv[1]), int(sys.argv[2])
    mesh = np.load(folder / "mesh.npz")
    K, M = (sp.csr_matrix(sp.load_npz(folder / f"{name}.npz")) for name in "KM")
    E, nu, rho = mesh["material"]
    material = KirchhoffMaterial(E, nu, rho)
    fem = model(K, M, mesh["nodes"], mesh["elements"][:, :4])
    result: dict[str, object] = {"version": exudyn.__version__}
    with contextlib.redirect_stdout(io.StringIO()):
        peak()
        start = time.process_time()
        fem.ComputeHurtyCraigBamptonModes(
            boundaryNodesList=[mesh["big"].tolist(), mesh["small"].tolist()],
            nEigenModes=modes,
            useSparseSolver=True,
            computationMode=HCBstaticModeSelection.RBE2,
        )
        result["modes"] = (time.process_time() - start, peak())
        start = time.process_time()
        fem.ComputePostProcessingModes(material)
        result["stress modes"] = (time.process_time() - start, peak())
        # frequencies of its modes and the rigid motions it leaves to the frame
        T = np.hstack([rigid(mesh["nodes"]), fem.modeBasis["matrix"]])
        square = scipy.linalg.eigh(T.T @ (K @ T), T.T @ (M @ T), eigvals_only=True)
        result["frequencies"] = (np.sqrt(np.abs(square[6:])) / (2.0 * np.pi)).tolist()

        beam = np.load(folder / "beam.npz")
        fem = model(K, M, beam["nodes"], beam["elements"][:, :4])
        fem.modeBasis = {"matrix": beam["displacement"]}
        fem.ComputePostProcessingModes(material)
        result["beam"] = fem.postProcessingModes["matrix"][beam["sites"], 0].tolist()
    print(json.dumps(result))


if __name__ == "__main__":
    main()
