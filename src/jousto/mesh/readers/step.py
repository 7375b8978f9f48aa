"""STEP and BREP files, meshed with curved tetrahedra by Gmsh (extra ``cad``)."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem, Problems, count, suggest, warn
from jousto.mesh.cells import Cells, edges
from jousto.mesh.mesh import Mesh
from jousto.mesh.readers.cad import cad_scale
from jousto.mesh.readers.msh import vtk_order
from jousto.mesh.readers.subprocess_reader import apart

log = logging.getLogger(__name__)

# smallest size on curved faces / size of the elements
FINEST = 0.25
FACETS = 24  # facets of a full turn of a curved surface, for drawing
SHARE = 0.2  # element size / length of a part, if only its surface is needed
# scaled Jacobian below which edges are straightened; slightly above that of a flat element
POOR = 0.06
# growth of the element size per distance from a refined face
GROWTH = 0.4
# largest number of tetrahedra: 10 million degrees of freedom
TOO_MANY = 2_000_000
# number of tetrahedra in a cube of their size
_PER_CUBE = 8.0


@explained
def mesh_cad(
    path: str | os.PathLike[str],
    *,
    size: float,
    order: int = 2,
    unit: str | None = None,
    curved: bool = True,
    refine: Mapping[str, float] | None = None,
    per_circle: int = 12,
    name: str | None = None,
) -> Mesh:
    """Return a mesh of tetrahedra of a CAD file (STEP or BREP), by Gmsh.

    Every face of the geometry becomes a surface and a node set ``face1``, ``face2`` and so on;
    ``mesh.holes()`` returns the bores. Touching solids share the nodes of their common faces. The
    solids become the element sets ``solid1``, ``solid2`` and so on, in addition to sets by product
    name.

    Parameters
    ----------
    path : path
        A ``.step``, ``.stp`` or ``.brep`` file.
    size : float
        Desired edge length of the elements, m.
    order : {2, 1}
        2 for tetrahedra of 10 nodes; those of 4 nodes (1) are far too stiff in bending.
    unit : {"m", "mm", "cm", "in", "ft", "um"}, optional
        Unit of the numbers in the file. A STEP file contains its unit (mostly mm) and is converted
        to m; a given unit overrides that of the file. A BREP file contains no unit, so the unit
        must be given.
    curved : bool
        Whether mid-side nodes lie on curved faces; straight edges shift frequencies by up to 0.5 %.
    refine : mapping of str to float, optional
        Smaller sizes in m on named faces, such as ``{"face12": 2e-3}``; the size grows away from
        these faces.
    per_circle : int
        Smallest number of elements along a full turn of a curved face.
    name : str, optional
        Name of the mesh; None for the name of the file.

    Raises
    ------
    InputError
        If Gmsh is not installed, the file is missing, damaged or without a solid, a face is
        unknown, or the size does not fit the part.

    Warns
    -----
    JoustoWarning
        If curved elements were straightened because they would be folded.

    Examples
    --------
    >>> mesh = mesh_cad("arm.step", size=8e-3)  # doctest: +SKIP
    """
    path, problems = Path(path), Problems()
    where = path.name
    problems.positive(where, "size", size, "m")
    if order not in (1, 2):
        problems.add(where, f"order is {order}, must be 1 or 2", "order")
    if per_circle < 4:
        problems.add(where, f"per_circle is {per_circle}, must be 4 or more", "per_circle")
    for face, length in (refine or {}).items():
        problems.positive(where, f"size at '{face}'", length, "m")
    problems.raise_if_any()
    scale = cad_scale(path, unit)
    if find_spec("gmsh") is None:
        raise InputError(Problem(where, "meshing CAD files needs Gmsh: pip install gmsh"))
    found = apart(
        path,
        "jousto.mesh.readers.step:meshed",
        "the file is probably damaged: export it again, or try another size",
        size=float(size),
        order=order,
        curved=bool(curved),
        refine={str(face): float(length) for face, length in (refine or {}).items()},
        per_circle=per_circle,
        scale=scale,
    )
    mesh = Mesh(
        name or path.stem,
        found["nodes"],
        (Cells(found["kind"], found["cells"]),),
        element_sets=found["element_sets"],
        surfaces=found["surfaces"],
        cad_volume=found["volume"],
    )
    if order == 2 and curved:
        mesh = _eased(mesh, where)
    mesh = _labelled(mesh, found["labels"])
    log.info("%s: %s, %.4g m^3; %s", where, mesh, mesh.volume, mesh.quality())
    return mesh


def cad_surface(path: Path, unit: str | None) -> Array:
    """Return the triangles (nt, 3, 3), m, of the surface of a CAD file, with outward normals.

    Flat faces have few triangles; a full turn of a curved face has `FACETS`.

    Parameters
    ----------
    path : Path
        A ``.step``, ``.stp`` or ``.brep`` file.
    unit : str or None
        See `mesh_cad`.

    Raises
    ------
    InputError
        If Gmsh is not installed, or the file is missing, damaged or without a solid.
    """
    scale = cad_scale(path, unit)
    if find_spec("gmsh") is None:
        raise InputError(
            Problem(path.name, "reading CAD files needs Gmsh: pip install gmsh", path=("reading",))
        )
    found = apart(
        path,
        "jousto.mesh.readers.step:meshed",
        "the file is probably damaged: export it again",
        size=0.0,
        order=1,
        curved=False,
        refine={},
        per_circle=FACETS,
        scale=scale,
    )
    mesh = Mesh(path.stem, found["nodes"], (Cells(found["kind"], found["cells"]),))
    return np.asarray(mesh.nodes[mesh.triangles])


# ---- gmsh ----------------------------------------------------------------------------------------


def meshed(
    path: Path,
    *,
    size: float,
    order: int,
    curved: bool,
    refine: dict[str, float],
    per_circle: int,
    scale: float,
) -> dict[str, Any]:
    """Return nodes (m), tetrahedra, sets, faces and products; runs in a separate process."""
    where = path.name
    gmsh = _gmsh(where)
    with _session(gmsh, where):
        labels = _load(gmsh, path)
        names = _names(gmsh)
        _sizes(gmsh, where, size, refine, names, scale)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", per_circle)
        gmsh.option.setNumber("Mesh.SecondOrderLinear", 0 if curved else 1)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.optimize("Netgen")
        if order == 2:
            gmsh.model.mesh.setOrder(2)
        found = _collect(gmsh, order, names, scale)
        return {**found, "labels": labels, "volume": _volume(gmsh, scale)}


def _gmsh(where: str) -> Any:
    try:
        import gmsh
    except (ImportError, OSError) as error:  # installed, but a library of the system is missing
        message = f"Gmsh cannot be loaded: {error}; install that library of the system"
        raise InputError(Problem(where, message)) from None
    return gmsh


@contextmanager
def _session(gmsh: Any, where: str) -> Iterator[None]:
    """Start Gmsh, and convert its errors into one message."""
    gmsh.initialize(["gmsh"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.ElementOrder", 1)
        gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
        gmsh.model.add("jousto")
        yield
    except Exception as error:
        if type(error) is not Exception:  # Gmsh raises plain exceptions with a message
            raise
        message = " ".join(str(error).split())[:200]
        raise InputError(
            Problem(
                where, f"Gmsh cannot mesh this geometry ({message}); repair it or try another size"
            )
        ) from None


def _load(gmsh: Any, path: Path) -> dict[str, list[int]]:
    """Import the shapes; return the tags of the solids of each named product."""
    occ = gmsh.model.occ
    step = path.read_bytes().lstrip()[:12] == b"ISO-10303-21"
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM" if step else "")
    try:
        shapes = occ.importShapes(str(path), format="step" if step else "brep")
    except Exception as error:
        message = " ".join(str(error).split())[:160]
        raise InputError(
            Problem(path.name, f"cannot be read; it may be damaged (Gmsh: {message})")
        ) from None
    solids = [shape for shape in shapes if shape[0] == 3]
    if not solids:
        faces = sum(1 for shape in shapes if shape[0] == 2)
        raise InputError(
            Problem(
                path.name,
                f"contains no solid, only {count(faces, 'face')}; sew the faces to a solid in the "
                f"CAD"
                " program and export that",
            )
        )
    occ.synchronize()
    titles = [gmsh.model.getEntityName(*solid).rpartition("/")[2].strip() for solid in solids]
    labels: dict[str, list[int]] = {}
    if len(solids) > 1:  # touching solids must share nodes
        _, made = occ.fragment(solids, [])
        occ.synchronize()
        for title, parts in zip(titles, made, strict=True):
            # name of a product without a name in OpenCASCADE
            if title and not title.startswith("Open CASCADE STEP translator"):
                labels.setdefault(title, []).extend(tag for dim, tag in parts if dim == 3)
    return labels


def _names(gmsh: Any) -> dict[str, tuple[int, int]]:
    """Return the names of faces and solids by (dimension, tag)."""
    out: dict[str, tuple[int, int]] = {}
    solids = gmsh.model.getEntities(3)
    for dim, kind in ((3, "solid"), (2, "face")):
        for _, tag in gmsh.model.getEntities(dim):
            if dim == 2 or len(solids) > 1:
                out[f"{kind}{tag}"] = dim, tag
    return out


def _volume(gmsh: Any, scale: float) -> float:
    """Return the volume of the solids of the geometry in m^3."""
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    return scale**3 * sum(float(gmsh.model.occ.getMass(3, tag)) for tag in tags)


def _sizes(
    gmsh: Any,
    where: str,
    size: float,
    refine: Mapping[str, float],
    names: Mapping[str, tuple[int, int]],
    scale: float,
) -> None:
    """Set the element size in m, smaller near refined faces; the model's unit is `scale` m.

    The size 0 stands for `SHARE` times the size of the part.
    """
    problems = Problems()
    box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3) * scale
    long = float(np.linalg.norm(box[1] - box[0]))
    size = size or SHARE * long
    volume = _volume(gmsh, scale)
    wanted = _PER_CUBE * volume / size**3
    if size >= long:
        problems.add(
            where,
            f"size is {size:g} m and the part {long:.3g} m across; sizes are in m, was"
            f" {1e-3 * size:g} meant?",
            "size",
        )
    elif wanted > TOO_MANY:
        least = (_PER_CUBE * volume / TOO_MANY) ** (1 / 3)
        problems.add(
            where,
            f"size {size:g} m would lead to about {wanted:.0e} elements in a part {long:.3g} m "
            f"across, the limit is {TOO_MANY:.0e}: use {least:.2g} m or more",
            "size",
        )
    for face, length in refine.items():
        if length > size:
            problems.add(
                where,
                f"{length:g} m at '{face}' is no smaller than the size, {size:g} m; sizes are in m",
                "refine",
                named=False,
            )
        if names.get(face, (0, 0))[0] != 2:
            known = [title for title, (dim, _) in names.items() if dim == 2]
            problems.add(where, f"no face '{face}'{suggest(face, known)}", "refine", named=False)
    problems.raise_if_any()
    gmsh.option.setNumber("Mesh.MeshSizeMax", size / scale)
    gmsh.option.setNumber("Mesh.MeshSizeMin", FINEST * min([size, *refine.values()]) / scale)
    fields = []
    for face, length in refine.items():
        distance = gmsh.model.mesh.field.add("Distance")
        gmsh.model.mesh.field.setNumbers(distance, "SurfacesList", [names[face][1]])
        gmsh.model.mesh.field.setNumber(distance, "Sampling", 60)
        grown = gmsh.model.mesh.field.add("Threshold")
        for key, value in (
            ("InField", distance),
            ("SizeMin", length / scale),
            ("SizeMax", size / scale),
            ("DistMin", length / scale),
            ("DistMax", (length + max(size - length, 0.0) / GROWTH) / scale),
        ):
            gmsh.model.mesh.field.setNumber(grown, key, value)
        fields.append(grown)
    if fields:
        least = gmsh.model.mesh.field.add("Min")
        gmsh.model.mesh.field.setNumbers(least, "FieldsList", fields)
        gmsh.model.mesh.field.setAsBackgroundMesh(least)


def _collect(
    gmsh: Any, order: int, names: Mapping[str, tuple[int, int]], scale: float
) -> dict[str, Any]:
    """Return the tetrahedra and the names of their faces; nodes are numbered from 1."""
    solid, face = ("tetra", "triangle") if order == 1 else ("tetra10", "triangle6")
    code, wide = (4, 4) if order == 1 else (11, 10)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1, -1)
    found: dict[int, Ints] = {}
    for _, tag in gmsh.model.getEntities(3):
        _, nodes = gmsh.model.mesh.getElementsByType(code, tag)
        found[tag] = vtk_order(solid, nodes.astype(np.int64).reshape(-1, wide))
    cells = np.concatenate(list(found.values()))
    used = np.unique(cells)
    index[used] = np.arange(len(used))
    at = np.full(len(index), -1)
    at[tags] = np.arange(len(tags))
    nodes_m: Array = scale * xyz.reshape(-1, 3)[at[used]]

    surfaces, elements = {}, {}
    starts = dict(zip(found, np.cumsum([0, *(len(x) for x in found.values())]), strict=False))
    for title, (dim, tag) in names.items():
        if dim == 3:
            elements[title] = np.arange(starts[tag], starts[tag] + len(found[tag]))
            continue
        _, nodes = gmsh.model.mesh.getElementsByType(2 if order == 1 else 9, tag)
        faces = index[nodes.astype(np.int64).reshape(-1, 3 if order == 1 else 6)]
        surfaces[title] = vtk_order(face, faces)
    return {
        "nodes": nodes_m,
        "kind": solid,
        "cells": index[cells],
        "element_sets": elements,
        "surfaces": surfaces,
    }


def _labelled(mesh: Mesh, labels: Mapping[str, list[int]]) -> Mesh:
    """Return the mesh with element sets for the products of its solids."""
    sets = dict(mesh.element_sets)
    for title, tags in labels.items():
        members = [mesh.element_sets[f"solid{tag}"] for tag in tags]
        if members and title not in sets:
            sets[title] = np.unique(np.concatenate(members))
    return replace(mesh, element_sets=sets)


def _eased(mesh: Mesh, where: str) -> Mesh:
    """Return the mesh with mid-side nodes of poor elements moved towards straight edges.

    The curved edges of a flat element between curved faces may fold it. Their curvature is reduced
    until the quality of the element is sufficient, or equals the quality with straight edges. (The
    optimisation of Gmsh gives another result in every run and may abort the process.)
    """
    ends = edges("tetra10")
    cells = mesh.solids[0].nodes
    middle = mesh.nodes.copy()
    middle[cells[:, 4:]] = mesh.nodes[cells[:, ends]].mean(axis=2)
    bow = mesh.nodes - middle
    best = replace(mesh, nodes=middle).quality().scaled_jacobian
    quality = mesh.quality()
    folded = quality.negative
    share = np.ones(len(mesh.nodes))
    for step in range(9):  # a straighter edge may worsen the neighbour
        now = quality.scaled_jacobian
        poor = np.flatnonzero((now < POOR) & (now < best - 0.01))
        if not len(poor):
            break
        share[np.unique(cells[poor, 4:])] *= 0.7 if step < 7 else 0.0
        mesh = replace(mesh, nodes=middle + share[:, None] * bow)
        quality = mesh.quality()
    if len(folded):
        warn(
            where,
            f"{count(len(folded), 'element')} (element {mesh.element_ids[folded[0]]}) would be "
            f"folded between curved faces; their edges were straightened. Use a smaller size "
            f"there to follow the faces",
        )
    eased = int(np.sum(np.any(share[cells] < 1.0, axis=1)))
    if eased:
        log.info(
            "%s: the edges of %s are straighter than its faces", where, count(eased, "element")
        )
    return mesh
