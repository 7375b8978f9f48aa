"""Shaded surfaces: visible, lit triangles with a depth buffer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from matplotlib.artist import Artist
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_rgb

from jousto.base.arrays import Array, Index
from jousto.output.scenes.raster import rasterize

MOST_TRIANGLES = 24_000  # triangles of a body in a picture; finer surfaces are coarsened
CREASE = np.cos(np.deg2rad(35.0))  # faces that meet at a larger angle form an edge
# direction to the light in the picture: right, up, to the eye
LIGHT = np.array([-0.35, 0.55, 0.76])
DARKEST, GLOSS = 0.5, 0.10
# lowest brightness of stress colours, so that they remain readable in the shade
DARKEST_STRESS = 0.75

STRESS_COLORS: Colormap = LinearSegmentedColormap.from_list(
    "stress", ("#2B4C9B", "#3E8FC6", "#63BFA8", "#B9D86B", "#F5D547", "#EE8A32", "#C7282D")
)
"""Colours of von Mises stress, low to high."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Outer triangles of a body.

    Attributes
    ----------
    nodes : (m,) int array
        The nodes of the body that the triangles use.
    triangles : (nt, 3) int array
        Corners, as places in `nodes`; counterclockwise seen from outside.
    smoothing : (3 nt, nt) sparse array
        Sums the normals of faces around each corner that meet without an edge.
    closed : bool
        Whether every edge has a face on either side: the back is then never visible.
    """

    nodes: Index
    triangles: Index
    smoothing: sp.csr_array
    closed: bool


def is_surface(elements: Any) -> bool:
    """Return whether elements are triangles: the outer surface of a solid."""
    found = np.asarray(elements)
    return bool(found.ndim == 2 and found.shape[1] == 3 and len(found))


def make_surface(nodes: Array, triangles: Any, most: int = MOST_TRIANGLES) -> Surface:
    """Return the drawn surface of triangles (nt, 3) between nodes (nn, 3), m."""
    kept = _thinned(nodes, np.asarray(triangles, dtype=np.intp), most)
    used, corners = np.unique(kept, return_inverse=True)
    corners = corners.reshape(-1, 3).astype(np.intp)
    x = nodes[used]
    normals = face_normals(x[corners])
    # pairs of faces at each corner (index of the corner, face)
    count = len(corners)
    at_node = sp.csr_array(
        (np.ones(3 * count), (np.repeat(np.arange(count), 3), corners.ravel())),
        shape=(count, len(used)),
    )
    around = sp.coo_array((at_node[:, corners.ravel()]).T)
    places, faces = around.coords
    unit = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    alike = np.einsum("ij,ij->i", unit[places // 3], unit[faces]) >= CREASE
    smoothing = sp.csr_array(
        (np.ones(int(alike.sum())), (places[alike], faces[alike])), shape=(3 * count, count)
    )
    return Surface(used.astype(np.intp), corners, smoothing, _is_closed(corners))


def face_normals(x: Array) -> Array:
    """Return normals (nt, 3) of triangles (nt, 3, 3), of length twice their area."""
    return np.asarray(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]))


def _is_closed(corners: Index) -> bool:
    """Return whether each edge occurs equally often in both directions."""
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    size = int(corners.max()) + 1
    there, back = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    return bool(np.array_equal(np.sort(there), np.sort(back)))


def _thinned(nodes: Array, triangles: Index, most: int) -> Index:
    """Return a coarser surface: the nodes in each cell of a grid are merged."""
    kept = triangles
    low, size = (
        nodes[triangles].min(axis=(0, 1)),
        float(np.ptp(nodes[triangles], axis=(0, 1)).max()),
    )
    # a surface over a grid of k cells along its longest side has about k^2 nodes
    cells = 2.0 * np.sqrt(float(most))
    while len(kept) > most and size > 0.0:
        cell = np.floor((nodes - low) / size * cells).astype(np.int64)
        key = (cell[:, 0] * 1_000_003 + cell[:, 1]) * 1_000_003 + cell[:, 2]
        used = np.unique(triangles)
        _, first, inverse = np.unique(key[used], return_index=True, return_inverse=True)
        place = np.arange(len(nodes))
        place[used] = used[first][inverse]
        kept = place[triangles]
        a, b, c = kept.T
        kept = kept[(a != b) & (b != c) & (a != c)]
        # remove duplicate faces
        _, first = np.unique(np.sort(kept, axis=1), axis=0, return_index=True)
        kept = kept[np.sort(first)]
        cells *= 0.8
    return kept


def lit(surface: Surface, x: Array, colors: Array, darkest: float = DARKEST) -> tuple[Array, Array]:
    """Return the visible triangles of a projected surface with their brightness.

    Parameters
    ----------
    surface : Surface
    x : (m, 3) array
        Right, up and nearness of its nodes, m.
    colors : (3,) or (m, 3) array
        Colour of the body or of each node, 0 to 1.
    darkest : float
        Share of the colour that is left in the shade.

    Returns
    -------
    corners : (k, 3, 3) array
        Right, up and nearness of the corners, m.
    shades : (k, 3, 4) array
        Colours of the visible corners after shading.
    """
    triangles = surface.triangles
    corners = x[triangles]
    normals = face_normals(corners)
    seen = np.flatnonzero(normals[:, 2] > 0.0) if surface.closed else np.arange(len(triangles))
    smooth = (surface.smoothing @ normals).reshape(-1, 3, 3)[seen]
    smooth /= np.maximum(np.linalg.norm(smooth, axis=2, keepdims=True), 1e-300)
    if not surface.closed:
        smooth *= np.where(smooth[:, :, 2:] < 0.0, -1.0, 1.0)
    light = LIGHT / np.linalg.norm(LIGHT)
    facing = np.clip(smooth @ light, 0.0, 1.0)
    shade = darkest + (1.0 - darkest) * facing
    gloss = GLOSS * np.clip(facing, 0.0, 1.0) ** 12
    base = np.broadcast_to(colors, (len(x), 3))[triangles[seen]]
    shades = np.ones((len(seen), 3, 4))
    shades[:, :, :3] = np.clip(base * shade[:, :, None] + gloss[:, :, None], 0.0, 1.0)
    return corners[seen], shades


class Skin(Artist):
    """Triangles with vertex colours, drawn with a depth buffer."""

    def __init__(self) -> None:
        super().__init__()
        self.corners: Array = np.zeros((0, 3, 3))
        self.shades: Array = np.zeros((0, 3, 4))

    def show(self, corners: Array, shades: Array) -> None:
        """Set triangles (k, 3, 3), right and up in data coordinates, and colours (k, 3, 4)."""
        self.corners, self.shades = corners, shades
        self.stale = True

    def draw(self, renderer: Any) -> None:
        """Draw on a canvas; in vector files as an image of their resolution.

        PostScript has no transparent images: there the triangles are drawn, farthest first.
        """
        if not self.get_visible() or not len(self.corners):
            return
        axes: Any = self.axes
        if axes.figure.canvas.get_default_filetype() == "ps":
            order = np.argsort(self.corners[:, :, 2].mean(axis=1), kind="stable")
            gc = renderer.new_gc()
            self._set_gc_clip(gc)  # type: ignore[attr-defined]
            renderer.draw_gouraud_triangles(
                gc, self.corners[order, :, :2], self.shades[order], axes.transData.frozen()
            )
            gc.restore()
            return
        corners = self.corners.copy()
        corners[:, :, :2] = axes.transData.transform(corners[:, :, :2].reshape(-1, 2)).reshape(
            -1, 3, 2
        )
        # only the part of the axes that the triangles cover
        box = axes.bbox.extents.reshape(2, 2)
        low = np.floor(np.maximum(corners[:, :, :2].min(axis=(0, 1)), box[0]))
        high = np.ceil(np.minimum(corners[:, :, :2].max(axis=(0, 1)), box[1]))
        fineness = float(renderer.get_image_magnification())
        width, height = (int(n) for n in np.ceil((high - low) * fineness))
        if width > 0 and height > 0:
            corners[:, :, :2] = (corners[:, :, :2] - low) * fineness
            picture = rasterize(corners, self.shades, width, height)
            gc = renderer.new_gc()
            self._set_gc_clip(gc)  # type: ignore[attr-defined]
            pixels = (255.0 * picture + 0.5).astype(np.uint8)
            renderer.draw_image(gc, low[0], low[1], pixels)
            gc.restore()
        self.stale = False


def plain(corners: Array, color: str) -> Array:
    """Return one colour for all corners (k, 3, 4) of triangles, as for a shadow."""
    return np.asarray(np.broadcast_to((*to_rgb(color), 1.0), (len(corners), 3, 4)))
