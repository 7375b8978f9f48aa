"""Cache of the meshes of CAD files, beside the cache of reductions.

A killed reduction continues only with exactly the same mesh, and another version of Gmsh makes
another mesh.
"""

from __future__ import annotations

import hashlib
import warnings
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import warn

if TYPE_CHECKING:
    from jousto.mesh.mesh import Mesh

Arrays = dict[str, NDArray[Any]]
SETS = ("node_sets", "element_sets", "surfaces")


def mesh_of_cad(path: Path, keep: bool | None, **values: Any) -> Mesh:
    """Return `mesh_cad(path, **values)`, from the cache if it was meshed before.

    Parameters
    ----------
    path : Path
        The CAD file; its content counts, not its name or date.
    keep : bool, optional
        Whether to store meshes; None: those of large parts only, as in `reduce`.
    **values
        Arguments of `mesh_cad`.

    Raises
    ------
    InputError
        As for `mesh_cad`.
    """
    from jousto.base.version import __version__
    from jousto.mesh.readers.step import mesh_cad
    from jousto.reduction.files.cache import AUTOMATIC, ReductionCache, key

    if keep is False or not path.is_file():
        return mesh_cad(path, **values)
    content = hashlib.sha256(path.read_bytes()).hexdigest()
    cache = ReductionCache()
    entry = cache.entry(f"mesh-{key(content, path.stem, values, __version__, _gmsh_version())}")
    arrays = entry.read("mesh")
    if arrays is None:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            mesh = mesh_cad(path, **values)
        arrays = _arrays(mesh, [str(item.message) for item in told])
        if keep or 3 * len(mesh.nodes) >= AUTOMATIC:
            entry.write("mesh", arrays)
            cache.prune(entry.folder)
    else:
        mesh = _mesh(arrays)
    for text in arrays["told"]:
        warn("", str(text))
    return mesh


def _gmsh_version() -> str:
    try:
        return version("gmsh")
    except PackageNotFoundError:
        return "unknown"


def _arrays(mesh: Mesh, told: list[str]) -> Arrays:
    out: Arrays = {"name": np.array(mesh.name), "nodes": mesh.nodes, "node_ids": mesh.node_ids}
    out["told"] = np.array(told, dtype=np.str_)
    if mesh.cad_volume is not None:
        out["cad_volume"] = np.array(mesh.cad_volume)
    for i, cells in enumerate(mesh.cells):
        out |= {f"cells.{i}": cells.nodes, f"ids.{i}": cells.ids}
        out[f"kind.{i}"] = np.array([cells.kind, cells.material, cells.formulation])
    for group in SETS:
        out |= {f"{group}.{name}": value for name, value in getattr(mesh, group).items()}
    return out


def _mesh(arrays: Arrays) -> Mesh:
    from jousto.mesh.cells import Cells
    from jousto.mesh.mesh import Mesh

    cells = []
    for i in range(sum(name.startswith("cells.") for name in arrays)):
        kind, *words = (str(text) for text in arrays[f"kind.{i}"])
        cells.append(Cells(kind, arrays[f"cells.{i}"], arrays[f"ids.{i}"], *words))
    sets: dict[str, Any] = {
        group: {
            name.removeprefix(f"{group}."): value
            for name, value in arrays.items()
            if name.startswith(f"{group}.")
        }
        for group in SETS
    }
    volume = float(arrays["cad_volume"]) if "cad_volume" in arrays else None
    name, nodes, ids = str(arrays["name"]), arrays["nodes"], arrays["node_ids"]
    return Mesh(name, nodes, tuple(cells), ids, **sets, cad_volume=volume)
