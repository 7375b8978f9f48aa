"""Stress of beams: at section points of both ends of every element, from the six resultants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.model.beam_record import BeamShape
from jousto.recovery.beams.forces import find_beam, section_forces
from jousto.recovery.beams.strains import elements, poses
from jousto.reduction.fields.stress import StressModes
from jousto.simulation.results.solution import Solution


@dataclass(frozen=True, eq=False)
class BeamStress:
    """Stress of a beam for unit resultants, with the resultants over time.

    Attributes
    ----------
    modes : StressModes
        Stress (ns, 6, 6) at sites such as ``e3.a.top``: third element, end a, point "top".
    p : (nt, 12 ne) array
        ``[N Qy Qz Mx My Mz]`` at one end after the other, N and N m.
    time : (nt,) array
        Instants, s.
    columns : (ns,) int array
        Index in p of the first of the six resultants of each site.
    """

    modes: StressModes
    p: Array
    time: Array
    columns: NDArray[np.intp]


def beam_stress(
    run: Solution,
    name: str,
    where: str,
    start: float | None,
    end: float | None,
    times: ArrayLike | None,
    frame: str,
) -> BeamStress:
    """Return the stress of a beam over a run, from the resultants at the ends of its elements.

    Raises
    ------
    InputError
        If no section has stress points, or the frame is "world".
    """
    beam = find_beam(run, name)
    if not beam.stressed:
        message = (
            "its section has no stress points; use a section with points, such as "
            "Rectangle, or give BeamSection(..., points=[StressPoint(name, y, z, rows)])"
        )
        raise InputError(Problem(where, message))
    if frame == "world":
        message = (
            "frame='world' is not possible for a beam, whose sections have different rotations; "
            "use frame='site', the axes of the section"
        )
        raise InputError(Problem(where, message))
    modes, columns = section_stress(beam)
    found = section_forces(run, name, times=times, start=start, end=end)
    return BeamStress(modes, found.ends.reshape(len(found.time), -1), found.time, columns)


def section_stress(beam: BeamShape) -> tuple[StressModes, NDArray[np.intp]]:
    """Return the stress (ns, 6, 6) for unit resultants and the first resultant (ns,) of each site.

    Sites such as ``e3.a.top`` (third element, end a, section point "top"), in section axes.
    """
    at = poses(elements(beam), beam.nodes, beam.frames)
    ends = ((at.ra, at.Qa), (at.rb, at.Qb))
    labels: list[str] = []
    where, axes, rows, columns, nodes, elastic = [], [], [], [], [], []
    known = all(beam.sections[k].elasticity is not None for k in set(beam.which.tolist()))
    for i, kind in enumerate(beam.which.tolist()):
        section = beam.sections[kind]
        m = len(section.labels)
        for end, (r, Q) in enumerate(ends):
            labels += [f"e{i + 1}.{'ab'[end]}.{label}" for label in section.labels]
            where.append(r[i] + section.points @ Q[i][:, 1:].T)
            axes.append(np.broadcast_to(Q[i], (m, 3, 3)))
            rows.append(section.rows)
            columns.append(np.full(m, 12 * i + 6 * end))
            nodes.append(np.full(m, i + end))
            if known:
                elastic.append(np.broadcast_to(section.elasticity, (m, 2)))
    modes = StressModes(
        tuple(labels),
        np.concatenate(where),
        np.concatenate(axes),
        np.concatenate(rows),
        elasticity=np.concatenate(elastic) if known else None,
        nodes=np.concatenate(nodes),
    )
    return modes, np.concatenate(columns).astype(np.intp)
