"""Readers of triangles: STL, PLY, OBJ and other formats of meshio, and Collada."""

from __future__ import annotations

import io
import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import check_input

COLLADA = ".dae"


def file_triangles(where: str, path: Path, factor: float) -> Array:
    """Return the triangles (nt, 3, 3), m, of a file.

    Parameters
    ----------
    where : str
        Beginning of messages.
    path : Path
        Path of the file.
    factor : float
        Length of one unit of the file in m; a Collada file contains its own unit.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or has no triangles.
    """
    check_input(path)
    if not path.is_file():
        raise MissingFileError(Problem(where, f"no such file '{path}'"))
    try:
        if path.suffix.lower() == COLLADA:
            return _collada(where, path)
        return factor * _meshio(where, path)
    except (InputError, ImportError, MemoryError):
        raise
    except (Exception, SystemExit) as error:  # readers raise many types of exceptions
        text = str(error).strip().splitlines()
        found = text[0] if text else "unknown kind"
        raise InputError(Problem(where, f"'{path.name}' cannot be read: {found}")) from None


def _meshio(where: str, path: Path) -> Array:
    import meshio  # slow to import and rarely needed

    try:
        with np.errstate(all="ignore"):  # the kind of an STL file is found by numbers in it
            mesh = meshio.read(path)
    except (Exception, SystemExit):
        # an OBJ file may have more or fewer normals and texture coordinates than points
        if path.suffix.lower() != ".obj":
            raise
        return _obj(where, path)
    blocks = [block.data for block in mesh.cells if block.type == "triangle"]
    blocks += [
        block.data[:, corners]
        for block in mesh.cells
        if block.type == "quad"
        for corners in ([0, 1, 2], [0, 2, 3])
    ]
    if not blocks:
        raise InputError(Problem(where, f"'{path.name}' holds no triangles"))
    points = np.asarray(mesh.points, dtype=np.float64)
    return np.asarray(points[np.concatenate(blocks)])


def _obj(where: str, path: Path) -> Array:
    """Return the triangles (nt, 3, 3) of an OBJ file with any polygons."""
    _need(where, path, "trimesh")
    import trimesh

    data = io.BytesIO(
        path.read_bytes()
    )  # as a stream, so that the reader opens no other files named in it
    options: dict[str, Any] = {"skip_materials": True, "process": False, "maintain_order": True}
    mesh: Any = trimesh.load(data, file_type="obj", force="mesh", **options)
    if not len(mesh.faces):
        raise InputError(Problem(where, f"'{path.name}' holds no triangles"))
    return np.asarray(np.array(mesh.vertices, dtype=np.float64)[np.asarray(mesh.faces)])


def _collada(where: str, path: Path) -> Array:
    """Return the triangles (nt, 3, 3) of a Collada file, m.

    Its up axis is ignored as in ROS and Gazebo.
    """
    _need(where, path, "pycollada", "collada")
    import collada

    data = path.read_bytes()
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        message = f"'{path.name}' has a DOCTYPE, which could load other files; remove it"
        raise InputError(Problem(where, message))
    found = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the reader uses matrices that numpy deprecates
        document: Any = collada.Collada(io.BytesIO(data), ignore=[collada.common.DaeError])
        for geometry in document.scene.objects("geometry") if document.scene else ():
            for primitive in geometry.primitives():
                if hasattr(primitive, "triangleset"):
                    primitive = primitive.triangleset()
                corners = getattr(primitive, "vertex_index", None)
                if corners is not None and np.ndim(corners) == 2 and corners.shape[1] == 3:
                    found.append(np.asarray(primitive.vertex, dtype=np.float64)[corners])
    if not found:
        raise InputError(Problem(where, f"'{path.name}' holds no triangles"))
    unit = document.assetInfo.unitmeter if document.assetInfo else None
    return np.concatenate(found) * (1.0 if unit is None else float(unit))


def _need(where: str, path: Path, package: str, module: str = "") -> None:
    """Raise InputError if the package that a reader needs is not installed."""
    known = {"trimesh": find_spec("trimesh"), "collada": find_spec("collada")}
    if known[module or package] is None:
        message = f"'{path.name}' needs {package}: pip install {package}"
        raise InputError(Problem(where, message))
