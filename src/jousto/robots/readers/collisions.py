"""Shapes of links that touch others, from the kinds, sizes, meshes and heights of robot files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError
from jousto.mechanism.contacts.ellipsoid import Ellipsoid
from jousto.mechanism.contacts.polytopes import MOST_VERTICES
from jousto.mechanism.contacts.shapes import (
    Capsule,
    ConvexHull,
    Cuboid,
    Cylinder,
    HalfSpace,
    Shape,
    Sphere,
)

FLAT = 1e-5
"""Distance from the plane of a face over the size: points of mesh files have six digits."""
FEWER: Sequence[int] = (500, 200, 100, 50)
"""Numbers of vertices of a coarser hull, where the whole one is too fine for the engine."""
CHUNK = 4096
"""Vertices whose distances from all faces are computed at a time."""
SEARCHED = 10_000
"""Vertices of a fine hull among which those of a coarser one are."""
CLOSED = 1e-6
"""Sum of the area vectors over the area, below which a surface is taken as closed."""
LARGER = 0.05
"""Volume between a hull and its mesh over that of the mesh, above which it is reported."""


def shape_of(kind: str, sizes: Array) -> Shape | None:
    """Return the shape of a kind with sizes as for `solid_of`; None for another kind.

    Parameters
    ----------
    kind : str
        "plane", "sphere", "capsule", "cylinder", "box", "ellipsoid", or a kind that cannot touch.
    sizes : (n,) array
        Radius, radius and length, lengths, or half axes, m.
    """
    if kind == "plane":
        return HalfSpace()
    if not (sizes > 0.0).all():
        return None
    if kind == "sphere":
        return Sphere(float(sizes[0]))
    if kind == "capsule":
        return Capsule(float(sizes[0]), float(sizes[1]))
    if kind == "cylinder":
        return Cylinder(float(sizes[0]), float(sizes[1]))
    if kind == "ellipsoid":
        return Ellipsoid(2.0 * sizes)
    return Cuboid(sizes) if kind == "box" else None


class MeshHull(NamedTuple):
    """Convex hull of a mesh, its description, and the share by which it is larger than it."""

    shape: ConvexHull
    text: str
    added: float


def mesh_hull(name: str, triangles: Array, points: Array | None = None, most: int = 0) -> MeshHull:
    """Return the convex hull of a mesh with a description of what it leaves out or adds.

    A hull that is too fine for the engine becomes that of fewer points, see `fewer_vertices`; the
    description contains the largest distance of the others from it.

    Parameters
    ----------
    name : str
        Name of the mesh.
    triangles : (nt, 3, 3) array
        m.
    points : (np, 3) array or None
        Points of the mesh, which may be corners of no triangle, m; None: the corners.
    most : int
        Largest number of vertices; 0: as many as contacts can have.

    Raises
    ------
    ValueError
        If the points have no hull with a volume.
    """
    from scipy.spatial import ConvexHull as Qhull, QhullError  # slow to import

    corners = triangles.reshape(-1, 3) if points is None else points
    try:
        whole = Qhull(corners)
    except (QhullError, ValueError):
        raise ValueError("its points have no convex hull with a volume") from None
    outer = corners[whole.vertices]
    text = f"hull of the mesh {name!r}"
    kept, rest, made = outer, "", None
    first = min(most, len(outer)) if most else len(outer)
    numbers = [first] if first <= MOST_VERTICES else []
    for number in (*numbers, *(n for n in FEWER if n < first)):
        if number < len(outer):
            kept, away = fewer_vertices(outer, number)
            rest = f" of {len(outer)} vertices, the others up to {away:.2g} m outside it"
        try:
            made = ConvexHull(kept, flat=FLAT)
            break
        except InputError:
            continue
    if made is None:
        raise ValueError("its convex hull is flatter or finer than contacts can have")
    more = added_volume(triangles, float(whole.volume))
    if more:
        rest += f", encloses {100.0 * more:.0f} % more than the mesh"
    found = made.polytope
    text += f", {len(found.vertices)} vertices, {len(found.faces)} faces{rest}"
    return MeshHull(made, text, more)


def fewer_vertices(x: Array, most: int) -> tuple[Array, float]:
    """Return at most n vertices of a hull, m, and the largest distance of the others outside, m.

    Each pass adds the vertices farthest outside the faces of the hull so far, of at most `SEARCHED`
    evenly chosen ones.
    """
    from scipy.spatial import ConvexHull as Qhull  # slow to import

    some = x[:: -(-len(x) // SEARCHED)]
    kept = some[Qhull(some, qhull_options="Qt TA1").vertices]
    while len(kept) < most:
        away, face = outside(Qhull(kept).equations, some)
        order = np.argsort(-away, kind="stable")
        _, first = np.unique(face[order], return_index=True)  # farthest one of each face
        added = order[np.sort(first)][: min(most - len(kept), max(len(kept) // 2, 1))]
        kept = np.concatenate([kept, some[added]])
    return kept, float(outside(Qhull(kept).equations, x)[0].max())


def outside(planes: Array, x: Array) -> tuple[Array, Any]:
    """Return how far points (n, 3) are outside the planes (nf, 4) of a hull, m, and which one."""
    away, face = np.empty(len(x)), np.empty(len(x), dtype=np.intp)
    for start in range(0, len(x), CHUNK):
        part = slice(start, start + CHUNK)
        gaps = x[part] @ planes[:, :3].T + planes[:, 3]
        face[part] = gaps.argmax(axis=1)
        away[part] = gaps.max(axis=1)
    return away, face


def added_volume(triangles: Array, volume: float) -> float:
    """Return the share by which a hull is larger than its mesh; 0 if it is small or unknown."""
    a, b, c = np.moveaxis(triangles - triangles.mean(axis=(0, 1)), 1, 0)
    vectors = np.cross(b - a, c - a)
    area = float(np.linalg.norm(vectors, axis=1).sum())
    own = float(np.einsum("ti,ti->", a, np.cross(b, c))) / 6.0
    if np.abs(vectors.sum(axis=0)).max() > CLOSED * area or not own > 0.0:
        return 0.0  # an open surface has no volume
    return volume / own - 1.0 if volume > (1.0 + LARGER) * own else 0.0
