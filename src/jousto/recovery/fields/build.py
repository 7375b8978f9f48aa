"""Construction of stress fields from a run, or from given modal coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem
from jousto.model.model import Model
from jousto.recovery.beams.stress import BeamStress, beam_stress
from jousto.recovery.fields.criteria import tensor, voigt
from jousto.recovery.fields.field import Frame, StressField
from jousto.recovery.fields.inertia import amplitudes
from jousto.recovery.fields.places import Sites, site_indices
from jousto.recovery.instants import bracket_instants, window
from jousto.recovery.shape import find_body, rotation_matrices
from jousto.reduction.fields.stress import StressModes
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.stress_sites import located
from jousto.simulation.results.solution import Solution


@explained
def stress_field(
    run: Solution,
    body: str,
    *,
    reduced: ReducedPart | None = None,
    sites: Sites = None,
    start: float | None = None,
    end: float | None = None,
    times: ArrayLike | None = None,
    frame: Frame = "site",
    strain: bool = False,
    residual: bool | Model = False,
    loads: Mapping[str, Any] | None = None,
) -> StressField:
    """Return the stress (or strain) field of a body over a run, computed on demand.

    ``s(x, t) = S(x) p(t)`` with the stress S of each mode (Braccesi and Cianetti, Proc. IMechE D
    219 (2005) 633-643).

    Parameters
    ----------
    run : Solution
        Results of the run, with the stress modes at the surface of solids and at all section points
        of beams.
    body : str
        Name of the body or beam.
    reduced : ReducedPart, optional
        Part of the body, for sites that are not in the results.
    sites : str, int or sequence of these, optional
        Labels, names of node sets, or numbers of nodes from 0; None takes all sites.
    start, end : float, optional
        First and last instant, s.
    times : (nt,) array_like, optional
        Instants, s, with linear interpolation; None takes all stored instants.
    frame : {"site", "body", "world"}
        Axes of components: those of each site (along the element of a beam, part axes of a
        solid), part axes, or world axes.
    strain : bool
        Whether to return strain ``[e11 e22 e33 g12 g23 g13]`` instead of stress.
    residual : bool or Model
        Whether to add the stress that the modes neglect (mode acceleration), for a part reduced
        with ``residual_stress=``. It follows from the accelerations of the run, which the engine
        computes from the model, or, for True, from differences of the stored velocities.
    loads : mapping of str to (nt,) array, number or str
        With `residual`: history of each named load over the run, or the name of its sensor.

    Raises
    ------
    InputError
        If the body, its part, a site or an instant does not exist, the body has no stress data, or
        its material is not known (strain).

    Examples
    --------
    ``stress_field(run, "arm").envelope("von-mises")`` is the largest stress everywhere.
    """
    where = f"stress of '{body}'"
    if body in {beam.name for beam in run.beams}:
        if reduced is not None or residual is not False or loads:
            message = "a beam has no reduced part; remove reduced, residual and loads"
            raise InputError(Problem(where, message))
        beam = beam_stress(run, body, where, start, end, times, frame)
        return _beam_field(body, beam, site_indices(beam.modes, sites, where), frame, strain)
    shape = find_body(run, body)
    if reduced is None:
        modes = run.stress_modes(body)
        if modes is None:
            kind = "a rigid body" if shape.kind == "rigid" else "its part has no stress data"
            raise InputError(Problem(where, f"no stress modes in {run.where}: {kind}"))
    else:
        modes = stress_of(reduced)
        check_part(run, body, reduced)
    modes = modes.select(site_indices(modes, sites, where))
    time = run.time
    rows = window(time, start, end, where)
    q, time = run.coordinates(body, rows), time[rows]
    e, p, v = q[:, 3:7], q[:, 7:], None
    if residual is False and times is None:
        v = run.rates(body, rows)[:, 6:]
    if residual is not False:
        if modes.residual is None:
            message = "has no residual stress; reduce its part with residual_stress=True"
            raise InputError(Problem(where, message))
        model = residual if isinstance(residual, Model) else None
        more = amplitudes(run, body, modes.residual, model, loads)
        p = np.concatenate([p, more[rows]], axis=1)
        whole = np.concatenate([modes.modes, modes.residual.columns], axis=2)
        modes = replace(modes, modes=whole, residual=None)
    elif loads:
        raise InputError(Problem(where, "loads= has no effect without residual=; give both"))
    if times is not None:
        wanted = np.atleast_1d(np.asarray(times, dtype=np.float64))
        before, after, share = bracket_instants(time, wanted, where)
        share = share[:, None]
        p = (1.0 - share) * p[before] + share * p[after]
        e = (1.0 - share) * e[before] + share * e[after]
        time = wanted
    A = rotation_matrices(e) if frame == "world" else None
    return field_from(modes, p, time, A=A, frame=frame, strain=strain, name=body, v=v)


@explained
def field_from(
    modes: StressModes,
    p: ArrayLike,
    time: ArrayLike,
    *,
    A: ArrayLike | None = None,
    frame: Frame | None = None,
    strain: bool = False,
    name: str = "body",
    columns: NDArray[np.intp] | None = None,
    v: ArrayLike | None = None,
) -> StressField:
    """Return the stress field of given modal coordinates, such as those of strain gauges.

    Parameters
    ----------
    modes : StressModes
        Stress of each mode.
    p : (nt, n) array_like
        Coordinates.
    time : (nt,) array_like
        Instants, s, ascending.
    A : (nt, 3, 3) array_like, optional
        Rotation matrices from body to world, for components in world axes.
    frame : {"site", "body", "world"}, optional
        As for `stress_field`; "world" if A is given, otherwise "site".
    strain : bool
        Whether to return strain instead of stress.
    name : str
        Name of the body.
    columns : (ns,) int array, optional
        Index of the first coordinate of each site, if a site depends only on some coordinates, as
        many as `modes` has.
    v : (nt, n) array_like, optional
        Rates of the coordinates, 1/s, for the bounds of `hot_spots` between the instants.

    Raises
    ------
    InputError
        If the shapes of the arrays differ, or the material is not known (strain).
    """
    where = f"stress of '{name}'"
    chosen: str = frame or ("site" if A is None else "world")
    if chosen not in ("site", "body", "world"):
        message = f"frame is {chosen!r}, must be 'site', 'body' or 'world'"
        raise InputError(Problem(where, message))
    if strain:
        modes = strain_modes(modes, where)
    if chosen != "site":
        modes = in_part_axes(modes, strain)
    rotations = None if A is None or chosen != "world" else np.asarray(A, dtype=np.float64)
    return StressField(
        name,
        modes,
        np.asarray(p, dtype=np.float64),
        np.asarray(time, dtype=np.float64),
        frame or ("site" if A is None else "world"),
        strain,
        rotations,
        columns,
        None if v is None else np.asarray(v, dtype=np.float64),
    )


def _beam_field(
    name: str, beam: BeamStress, chosen: NDArray[np.intp], frame: Frame, strain: bool
) -> StressField:
    return field_from(
        beam.modes.select(chosen),
        beam.p,
        beam.time,
        frame=frame,
        strain=strain,
        name=name,
        columns=beam.columns[chosen],
    )


def stress_of(reduced: ReducedPart) -> StressModes:
    """Return the stress modes of a part.

    Raises
    ------
    InputError
        If the part has no stress data.
    """
    modes = located(reduced)
    if modes is None:
        raise InputError(
            Problem(
                f"part '{reduced.name}'",
                "has no stress modes; its finite element part has no stress data",
            )
        )
    return modes


def check_part(run: Solution, body: str, reduced: ReducedPart) -> None:
    """Raise InputError if the modes of a body are not those of this part."""
    shape = find_body(run, body)
    if shape.n != reduced.n or shape.modes.shape != reduced.modes.shape:
        raise InputError(
            Problem(
                f"body '{body}'",
                f"has {shape.n} modes at {len(shape.nodes)} nodes, but part '{reduced.name}' has "
                f"{reduced.n} at {len(reduced.nodes)}; give the part of the body",
            )
        )
    if not np.allclose(shape.modes, reduced.modes, rtol=1e-9, atol=1e-12):
        raise InputError(
            Problem(f"body '{body}'", f"its mode shapes are not those of part '{reduced.name}'")
        )


def strain_modes(modes: StressModes, where: str = "strain") -> StressModes:
    """Return the strain of each mode, ``[e11 e22 e33 g12 g23 g13]`` in the axes of the sites.

    ``e = ((1 + nu) s - nu tr(s) 1) / E`` (Hooke), or by the compliance matrix of the sites.

    Raises
    ------
    InputError
        If the material is not known.
    """
    S = modes.modes
    if modes.compliance is not None:
        return replace(modes, modes=modes.compliance @ S, scatter=None)
    if modes.elasticity is None:
        message = "the material of its sites is not known: parts from matrices have no strain"
        raise InputError(Problem(where, message))
    E, nu = modes.elasticity[:, 0, None, None], modes.elasticity[:, 1, None, None]
    strain = np.empty_like(S)
    trace = S[:, :3].sum(axis=1, keepdims=True)
    strain[:, :3] = ((1.0 + nu) * S[:, :3] - nu * trace) / E
    strain[:, 3:] = 2.0 * (1.0 + nu) * S[:, 3:] / E
    return replace(modes, modes=strain, scatter=None)


def in_part_axes(modes: StressModes, strain: bool = False) -> StressModes:
    """Return stress (or strain) modes with all components in the axes of the part."""
    E = np.broadcast_to(np.eye(3), modes.axes.shape)
    if np.array_equal(modes.axes, E):
        return modes
    T = tensor(np.swapaxes(modes.modes, 1, 2), strain)
    T = np.einsum("sia,snab,sjb->snij", modes.axes, T, modes.axes, optimize=True)
    return replace(modes, axes=E, modes=np.swapaxes(voigt(T, strain), 1, 2), compliance=None)
