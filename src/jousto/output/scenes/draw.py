"""Picture of a mesh, a part or a reduced part, undeformed or in a mode."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.mesh.mesh import Mesh
from jousto.output.scenes.backdrop import color_bar
from jousto.output.scenes.stage import DrawnBody, body_color, drawn_bodies
from jousto.output.scenes.surface import (
    DARKEST,
    DARKEST_STRESS,
    LIGHT,
    STRESS_COLORS,
    Skin,
    face_normals,
    lit,
)
from jousto.output.scenes.view import View, choose_view
from jousto.output.style import INK, MUTED, PICTURES, Picture, save, styled, target
from jousto.parts.part import Part
from jousto.recovery.fields.criteria import von_mises
from jousto.reduction.reduced import ReducedPart
from jousto.scene.make import make_scene

WIDTH, LEGEND, GAP = 7.2, 1.35, 0.2  # inch: width, colour legend, gap
MOST_FACES = 40_000  # number of faces up to which their edges are drawn
AMPLITUDE = 0.08  # largest displacement of a mode in a picture, relative to the size of the part
STEEL = "#A9B7C6"
EDGE = "#44505E"
# nodes of a face in order along its boundary, by number of nodes
AROUND = {
    3: [0, 1, 2],
    4: [0, 1, 2, 3],
    6: [0, 3, 1, 4, 2, 5],
    8: [0, 4, 1, 5, 2, 6, 3, 7],
}
METAL = np.array(to_rgb(STEEL))
GHOST = 0.35 * METAL + 0.65  # colour of the undeformed shape under a mode


@dataclass(frozen=True, eq=False)
class Subject:
    """Body to draw: vertex positions, faces with edges (nf, k), named nodes.

    `nodes` (nn, 3) are the nodes of faces and names, `size` (3,) is the size of the undeformed
    body, `still` are its vertices.
    """

    title: str
    one: DrawnBody
    x: Array
    nodes: Array
    size: Array
    faces: tuple[NDArray[np.intp], ...]
    marks: dict[str, NDArray[np.intp]]
    values: Array | None = None
    unit: str = ""
    still: Array | None = None


@explained
def draw(
    thing: Mesh | Part | ReducedPart,
    path: str | Path,
    *,
    sets: tuple[str, ...] | list[str] | str | None = None,
    mode: int | None = None,
    scale: float = AMPLITUDE,
    view: View | str | None = None,
) -> Path:
    """Write a picture of a mesh or a part, or of a mode shape.

    Meshes are drawn with element edges and with dots on the nodes of their sets. A mode is drawn
    deformed, coloured by its von Mises stress if known, else by displacement.

    Parameters
    ----------
    thing : Mesh, Part or ReducedPart
    path : path
        File to write: png, svg, pdf, jpg, webp or eps.
    sets : sequence of str, optional
        Node sets that get coloured dots; None: the sets of the interfaces of a part, and no set of
        a mesh.
    mode : int, optional
        Index of the mode of a ReducedPart from 0; the title counts from 1. The undeformed shape is
        drawn pale below it.
    scale : float
        Largest displacement of the mode in the picture, by the longest side of the part.
    view : View, "xy", "xz" or "yz", optional
        Direction of view; None: from the front right and above.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For an unknown suffix, an unwritable path, an unknown set or mode, a part without elements.
    """
    out = target(path, PICTURES)
    subject = _subject(thing, sets, mode, scale)
    with styled():
        save(_picture(subject, view), out)
    return out


def _subject(thing: Any, sets: Any, mode: int | None, scale: float) -> Subject:
    """Return the body to draw of a mesh, a part or a reduced part."""
    if not isinstance(thing, (Mesh, Part, ReducedPart)):
        message = f"{thing!r} cannot be drawn; give a Mesh, a Part or a ReducedPart"
        raise InputError(Problem("draw", message))
    where, problems = f"'{thing.name}'", Problems()
    problems.positive("draw", "scale", float(scale), "")
    if mode is not None and not isinstance(thing, ReducedPart):
        problems.add(where, "has no modes; reduce it first")
    elif mode is not None and not 0 <= mode < thing.n:  # type: ignore[union-attr]
        last = thing.n - 1  # type: ignore[union-attr]
        problems.add(where, f"there are modes 0..{last}, not {mode}")
    faces: tuple[Any, ...] = ()
    if isinstance(thing, Mesh):
        elements: Any = thing.triangles
        faces = tuple(block.nodes[:, AROUND[block.nodes.shape[1]]] for block in thing.faces)
    else:
        elements = thing.elements
        if isinstance(thing, Part) and thing.mesh is not None and len(thing.mesh.used):
            new = np.full(len(thing.mesh.nodes), -1)
            new[thing.mesh.used] = np.arange(len(thing.mesh.used))
            faces = tuple(
                new[block.nodes[:, AROUND[block.nodes.shape[1]]]] for block in thing.mesh.faces
            )
    if not len(elements):
        problems.add(where, "has no elements that can be drawn")
    marks = _marks(thing, sets, where, problems)
    problems.raise_if_any()
    scene, nodes = make_scene(thing), np.asarray(thing.nodes).real
    one, size = drawn_bodies(scene)[0], np.ptp(scene.bodies[0].positions, axis=0)
    body, title = one.body, thing.name
    if mode is None or not isinstance(thing, ReducedPart):
        return Subject(title, one, body.positions, nodes, size, faces, marks)
    assert body.shapes is not None
    moved = np.linalg.norm(thing.modes[:, :, mode], axis=1)
    factor = scale * float(np.ptp(nodes, axis=0).max()) / max(float(moved.max()), 1e-300)
    title = f"{thing.name}, mode {mode + 1}: {thing.frequencies[mode]:.5g} Hz"
    if body.stress is None:
        values, unit = np.linalg.norm(body.shapes[mode], axis=1), "displacement"
    else:
        values, unit = np.array(von_mises(body.stress[mode])), "von Mises"
        if body.known is not None:
            values[~body.known] = np.nan
    return Subject(
        title,
        one,
        body.positions + factor * body.shapes[mode],
        nodes + factor * thing.modes[:, :, mode],
        size,
        faces,
        marks,
        values / max(float(np.nanmax(values)), 1e-300),
        unit,
        body.positions,
    )


def _marks(
    thing: Mesh | Part | ReducedPart, sets: Any, where: str, problems: Problems
) -> dict[str, NDArray[np.intp]]:
    """Return the indices of the nodes marked by dots."""
    if sets is None:
        ties = thing.ties if isinstance(thing, Part) else ()
        return {tie.name: np.asarray(tie.nodes) for tie in ties}
    names = (sets,) if isinstance(sets, str) else tuple(sets)
    for name in names:
        if name not in thing.node_sets:
            problems.add(where, f"no set '{name}'{suggest(name, thing.node_sets)}")
    return {
        name: np.asarray(thing.node_sets[name], dtype=np.intp)
        for name in names
        if name in thing.node_sets
    }


def _picture(subject: Subject, view: View | str | None) -> Picture:
    """Return the figure of a body."""
    chosen = choose_view(view, subject.nodes, None)
    x = chosen.project(subject.nodes)
    seen = subject.x
    if subject.still is not None:
        seen = np.concatenate([seen, subject.still])
    right_up = chosen.project(seen)[:, :2]
    low, high = right_up.min(axis=0), right_up.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    size = np.maximum(size, [size[1] / 1.2, size[0] * 0.3]) * 1.06
    side = LEGEND if subject.marks or subject.values is not None else GAP
    inner = WIDTH - GAP - side
    height = inner * size[1] / size[0]
    total = height + 0.75
    figure = Picture(figsize=(WIDTH, total))
    ax = figure.add_axes((GAP / WIDTH, 0.25 / total, inner / WIDTH, height / total))
    middle = 0.5 * (low + high)
    ax.set_xlim(middle[0] - 0.5 * size[0], middle[0] + 0.5 * size[0])
    ax.set_ylim(middle[1] - 0.5 * size[1], middle[1] + 0.5 * size[1])
    ax.axis("off")
    count = sum(len(block) for block in subject.faces)
    if subject.faces and count <= MOST_FACES and subject.values is None:
        _net(ax, subject, x)
    else:
        if subject.still is not None:
            _skin(ax, subject.one, subject.still, chosen, GHOST)
        _skin(ax, subject.one, subject.x, chosen, METAL, subject.values)
    _dots(ax, subject, x)
    left = GAP / WIDTH
    figure.text(left, 1 - 0.3 / total, subject.title, fontsize=10.5, fontweight="bold", va="center")
    dims = " × ".join(f"{1e3 * d:.4g}" for d in subject.size)
    if subject.values is None:
        figure.text(left, 0.13 / total, f"{dims} mm", color=MUTED, fontsize=8.5, va="center")
    _axes_cross(figure, chosen, total)
    if subject.values is not None:
        place = (1 - (side - 0.2) / WIDTH, 0.25 / total, height / total)
        color_bar(figure, 1.0, place, subject.unit, "of its largest")
    return figure


def _skin(
    ax: Axes, one: DrawnBody, vertices: Array, view: View, metal: Array, values: Array | None = None
) -> None:
    """Draw a body in one colour or coloured by values (nv,); without surface as lines."""
    x = view.project(vertices)
    if one.surface is None:
        color, width = (GHOST, 1.5) if metal is GHOST else (body_color(0), 3.0)
        ax.add_collection(LineCollection(list(x[one.lines, :2]), colors=[color], linewidths=width))
        return
    colors, darkest = metal, DARKEST
    if values is not None:
        colors = np.asarray(STRESS_COLORS(np.nan_to_num(values)))[:, :3]
        colors[np.isnan(values)] = METAL
        darkest = DARKEST_STRESS
    skin = Skin()
    skin.show(*lit(one.surface, x, colors, darkest))
    ax.add_artist(skin)


def _net(ax: Axes, subject: Subject, x: Array) -> None:
    """Draw the visible faces with their element edges, far ones first."""
    polygons, depths, shades = [], [], []
    light = LIGHT / np.linalg.norm(LIGHT)
    for block in subject.faces:
        corners = x[block]
        three = [0, 2, 4] if corners.shape[1] == 6 else [0, corners.shape[1] // 4, -2]
        normals = face_normals(corners[:, three if corners.shape[1] > 3 else [0, 1, 2]])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        seen = normals[:, 2] > 0.0
        polygons += list(corners[seen, :, :2])
        depths.append(corners[seen, :, 2].mean(axis=1))
        shades.append(DARKEST + (1.0 - DARKEST) * np.clip(normals[seen] @ light, 0.0, 1.0))
    order = np.argsort(np.concatenate(depths), kind="stable")
    colors = METAL * np.concatenate(shades)[order, None]
    # thinner lines with more faces
    width = float(np.clip(9.0 / np.sqrt(len(order) + 1.0), 0.08, 0.5))
    ax.add_collection(
        PolyCollection(
            [polygons[i] for i in order], facecolors=colors, edgecolors=EDGE, linewidths=width
        )
    )


def _dots(ax: Axes, subject: Subject, x: Array) -> None:
    """Draw coloured dots on marked nodes and name them."""
    keys = []
    for k, (name, nodes) in enumerate(subject.marks.items()):
        look = {"marker": "o", "color": body_color(k + 1), "linestyle": "none"}
        size = float(np.clip(40.0 / np.sqrt(len(nodes) + 1.0), 1.6, 6.0))
        ax.plot(*x[nodes, :2].T, markersize=size, **look)  # type: ignore[arg-type]
        label = f"{name}\n{len(nodes)} nodes" if len(nodes) > 1 else name
        keys.append(Line2D([], [], markersize=6, label=label, **look))  # type: ignore[arg-type]
    if keys:
        figure: Any = ax.figure
        figure.legend(handles=keys, loc="center right", handletextpad=0.2)


def _axes_cross(figure: Picture, view: View, total: float) -> None:
    """Draw the directions of x, y and z in a corner."""
    size = 0.5
    ax = figure.add_axes((1 - 0.62 / WIDTH, 1 - 0.62 / total, size / WIDTH, size / total))
    ax.set_xlim(-1.5, 1.5)
    ax.set_ylim(-1.5, 1.5)
    ax.axis("off")
    for name, axis in zip("xyz", view.axes.T, strict=True):
        if np.hypot(axis[0], axis[1]) < 0.1:
            continue
        ax.plot([0, axis[0]], [0, axis[1]], color=INK, linewidth=1.0)
        ax.text(
            1.35 * axis[0], 1.35 * axis[1], name, color=MUTED, fontsize=8, ha="center", va="center"
        )
