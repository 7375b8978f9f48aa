"""Pictures of exact beams: resultants and deformed shapes, and files for ParaView."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import ArrayLike

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.mechanism.sensors.section import RESULTANTS
from jousto.output.files.paraview import Cells, save_series
from jousto.output.scenes.view import View, choose_view
from jousto.output.style import COLORS, MUTED, Picture, drawing, target
from jousto.recovery.beams.forces import UNITS, SectionForces, component_of, find_beam
from jousto.recovery.fields.criteria import evaluate
from jousto.recovery.shape import find_body, positions
from jousto.scene.make import make_scene
from jousto.scene.values_at_rows import rows_at, section_axes, stresses, vertices
from jousto.simulation.results.solution import Solution

WIDTH = 7.2  # width of a picture, inch
TIMES: LinearSegmentedColormap = LinearSegmentedColormap.from_list("times", ("#B9C4D0", COLORS[0]))
SHOWN = 9  # default number of instants of a deformed shape


@drawing
def plot_section_forces(
    forces: SectionForces,
    *,
    components: Sequence[str] | str | None = None,
    times: ArrayLike | None = None,
    at: float | str | None = None,
) -> Picture:
    """Draw resultants along a beam at some instants with their envelope, or over time.

    Parameters
    ----------
    forces : SectionForces
        Forces as in `section_forces`.
    components : sequence of str, optional
        Some of "N", "Qy", "Qz", "Mx", "My", "Mz"; by default those that are not zero.
    times : (nt,) array_like, optional
        Instants of the diagrams, s; by default the last one.
    at : float or str, optional
        Position along the beam, m, or "start" or "end", for a history instead of diagrams.
    path : path, optional
        File to write; the suffix chooses the format: png, svg, pdf, jpg, webp or eps.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        For unknown components, places or instants, or a path that cannot be written.

    Examples
    --------
    ``plot(section_forces(run, "cable"), times=[0.1, 0.2], path="forces.png")``
    """
    names = [components] if isinstance(components, str) else list(components or _present(forces))
    for name in names:
        component_of(forces.name, name)
    instants = np.atleast_1d(
        np.asarray(forces.time[-1] if times is None else times, dtype=np.float64)
    )
    layout = ConstrainedLayoutEngine(h_pad=0.06, w_pad=0.08)
    figure = Picture(figsize=(WIDTH, 0.9 + 1.7 * len(names)), layout=layout)
    axes = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for ax, name in zip(axes, names, strict=True):
        ax.set_ylabel(f"{name} ({UNITS[RESULTANTS.index(name)]})")
        if at is not None:
            ax.plot(forces.time, forces.history(name, at), color=COLORS[0])
            continue
        low, _, high, _ = forces.envelope(name)
        ax.fill_between(forces.s_nodes, low, high, color=MUTED, alpha=0.15, linewidth=0)
        for k, t in enumerate(instants):
            color = COLORS[k % len(COLORS)]
            ax.plot(*forces.diagram(name, float(t)), color=color, label=f"{t:.4g} s")
    where = "" if at is None else f" at {at}" + ("" if isinstance(at, str) else " m")
    axes[0].set_title(f"{forces.name}{where}", loc="left", fontsize=10.5, fontweight="bold")
    axes[-1].set_xlabel("time (s)" if at is not None else "length along the beam (m)")
    if at is None and len(instants) > 1:
        axes[0].legend(loc="best", fontsize=8.5, frameon=False)
    return figure


def _present(forces: SectionForces) -> list[str]:
    """Return the resultants that are not negligible beside others of the same unit."""
    size = np.abs(forces.ends).max(axis=(0, 1, 2))
    top = np.repeat([size[:3].max(), size[3:].max()], 3)
    kept = [name for name, x, y in zip(RESULTANTS, size, top, strict=True) if x > 1e-3 * y]
    return kept or ["N"]


@drawing
def plot_beam(
    run: Solution,
    *,
    beam: str | Sequence[str],
    times: ArrayLike | None = None,
    view: View | str | None = None,
) -> Picture:
    """Draw the axis of a beam at some instants, from pale to dark, with equal scales.

    Parameters
    ----------
    run : Solution
    beam : str or sequence of str
        Names of beams or of bodies made of beams.
    times : (nt,) array_like, optional
        Instants, s; by default nine over the run.
    view : View, "xy", "xz" or "yz", optional
        Direction of view; None: automatic.
    path : path, optional
        File to write: png, svg, pdf, jpg, webp or eps.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        If there is no such beam, or an instant is outside the run.

    Examples
    --------
    ``plot(run, beam="cable", times=[0, 0.5, 1.0])`` as the last line of a notebook cell shows it.
    """
    names = (beam,) if isinstance(beam, str) else tuple(beam)
    if not names:
        raise InputError(Problem("plot", "name at least one beam"))
    t = run.time
    wanted = np.linspace(float(t[0]), float(t[-1]), SHOWN) if times is None else times
    instants = np.atleast_1d(np.asarray(wanted, dtype=np.float64))
    lines = [positions(run, find_body(run, name), instants) for name in names]
    cloud = np.concatenate([x.reshape(-1, 3) for x in lines])
    eye = choose_view(view, cloud, run.attributes.get("gravity"))
    span = Normalize(float(instants[0]), float(max(instants[-1], instants[0] + 1e-300)))
    figure = Picture(figsize=(WIDTH, 0.7 * WIDTH), layout=ConstrainedLayoutEngine())
    ax = figure.subplots()
    for x in lines:
        for k, t in enumerate(instants):
            right, up = eye.project(x[k])[:, :2].T
            last = k == len(instants) - 1
            ax.plot(right, up, color=TIMES(span(t)), linewidth=2.2 if last else 1.3)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(f"{eye.plane[0]} (m)" if eye.plane else "m")
    ax.set_ylabel(f"{eye.plane[1]} (m)" if eye.plane else "m")
    ax.set_title(", ".join(names), loc="left", fontsize=10.5, fontweight="bold")
    note = f"{len(instants)} instants, {instants[0]:.4g} to {instants[-1]:.4g} s"
    ax.set_title(note, loc="right", fontsize=8.5, color=MUTED)
    return figure


@explained_as("write")
def write_beam(
    run: Solution, path: str | Path, *, beam: str, times: ArrayLike | None = None
) -> Path:
    """Write the swept surface of a beam for ParaView: stress and the axes of its sections.

    Point data: ``section x``, ``section y``, ``section z`` (unit vectors, world) and, where the
    section has stress data, ``von Mises (Pa)`` and ``s11 (Pa)``.

    Parameters
    ----------
    run : Solution
    path : path
        Ends with .vtu for one instant, or .pvd for a series that ParaView plays.
    beam : str
        Name of the beam.
    times : (nt,) array_like, optional
        Instants, s; by default the last one for .vtu and all stored ones for .pvd.

    Raises
    ------
    InputError
        If there is no such beam, for another ending, or several instants in a .vtu file.
    """
    out = target(path, ("vtu", "pvd"))
    find_beam(run, beam)
    scene = make_scene(run)
    (body,) = (one for one in scene.bodies if one.name == beam and one.rings is not None)
    rings, triangles = body.rings, body.triangles
    assert rings is not None and triangles is not None
    instants = run.time[-1:] if out.suffix == ".vtu" else run.time
    if times is not None:
        instants = np.atleast_1d(np.asarray(times, dtype=np.float64))

    def content(t: float) -> tuple[Array, Cells, dict[str, Array]]:
        row = rows_at(scene, [t])
        axes, tensors = section_axes(rings, row)[0], stresses(body, row)
        data = {f"section {c}": axes[:, :, i].copy() for i, c in enumerate("xyz")}
        if tensors is not None:
            data["von Mises (Pa)"] = evaluate(tensors, "von-mises")[0]
            data["s11 (Pa)"] = tensors[0, :, 0].copy()
        return vertices(body, row)[0], [("triangle", triangles)], data

    return save_series(out, instants, content)
