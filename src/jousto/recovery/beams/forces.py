"""section_forces: strains and stress resultants along a beam over a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.files import write_table
from jousto.base.ranking import largest
from jousto.mechanism.sensors.section import RESULTANTS
from jousto.model.beam_record import BeamShape
from jousto.recovery.beams.strains import (
    Elements,
    Poses,
    elements,
    end_resultants,
    poses,
    rates,
    resultants,
    strains,
)
from jousto.recovery.instants import bracket_instants, window
from jousto.recovery.shape import rotation_matrices
from jousto.simulation.results.solution import Solution

STRAINS = ("Gx", "Gy", "Gz", "kx", "ky", "kz")
"""Strains of a section: extension, shears, twist and curvatures."""

UNITS = ("N", "N", "N", "N m", "N m", "N m")
BLOCK = 1 << 20  # number of node states in memory at a time


@dataclass(frozen=True, eq=False)
class SectionForces:
    """Strains and stress resultants of the elements of a beam over time.

    Resultants ``[N Qy Qz Mx My Mz]`` act on the face whose outward normal points along the beam, at
    the axis of the beam, resolved in the axes of the section. They include stiffness-proportional
    damping.

    Attributes
    ----------
    name : str
        Name of the beam.
    time : (nt,) array
        Instants, s.
    s : (ne,) array
        Arc length of the unstressed beam to the midpoint of each element, m.
    strains : (nt, ne, 6) array
        ``[Gx Gy Gz kx ky kz]`` at the midpoints, m/m and 1/m.
    resultants : (nt, ne, 6) array
        Resultants at the midpoints, N and N m.
    ends : (nt, ne, 2, 6) array
        Resultants at both ends of each element, from its equilibrium: the force is constant in an
        element, since loads act on nodes, and the moment is exact at the nodes.
    s_nodes : (ne + 1,) array
        Arc length of the unstressed beam to the nodes, m.
    """

    name: str
    time: Array
    s: Array
    strains: Array
    resultants: Array
    ends: Array
    s_nodes: Array

    def __repr__(self) -> str:
        return f"<SectionForces {self.name!r}: {len(self.s)} elements, {len(self.time)} instants>"

    @cached_property
    def at_nodes(self) -> Array:
        """Resultants at the nodes (nt, ne + 1, 6), N and N m.

        Moments are the mean of the two adjacent elements; forces, constant in an element, are
        interpolated linearly between midpoints and extrapolated to the ends of the beam.
        """
        nt, ne = self.resultants.shape[:2]
        out = np.empty((nt, ne + 1, 6))
        out[:, 0, 3:], out[:, -1, 3:] = self.ends[:, 0, 0, 3:], self.ends[:, -1, 1, 3:]
        out[:, 1:-1, 3:] = 0.5 * (self.ends[:, :-1, 1, 3:] + self.ends[:, 1:, 0, 3:])
        a, b = self.ends[:, :, 0, :3], self.ends[:, :, 1, :3]
        if ne == 1:
            out[:, 0, :3], out[:, 1, :3] = a[:, 0], b[:, 0]
            return out
        half = 0.5 * np.diff(self.s_nodes)
        share = (half[:-1] / (half[:-1] + half[1:]))[:, None]
        out[:, 1:-1, :3] = (1.0 - share) * b[:, :-1] + share * a[:, 1:]
        first, last = half[0] / (half[0] + half[1]), half[-1] / (half[-1] + half[-2])
        out[:, 0, :3] = a[:, 0] - first * (a[:, 1, :] - b[:, 0])
        out[:, -1, :3] = b[:, -1] + last * (a[:, -1] - b[:, -2])
        return out

    def history(self, component: str, at: float | str) -> Array:
        """Return a resultant over time (nt,) at a point of the beam.

        Parameters
        ----------
        component : str
            One of "N", "Qy", "Qz", "Mx", "My", "Mz".
        at : float or str
            Arc length of the unstressed beam, m, with linear interpolation between nodes; "start"
            or "end".

        Raises
        ------
        InputError
            For an unknown component or a length outside the beam.
        """
        k, values = component_of(self.name, component), self.at_nodes
        if isinstance(at, str):
            if at not in ("start", "end"):
                message = f"at is {at!r}, must be a length in m, 'start' or 'end'"
                raise InputError(Problem(f"beam '{self.name}'", message))
            return np.asarray(values[:, 0 if at == "start" else -1, k])
        length = float(self.s_nodes[-1])
        if not -1e-9 * length <= at <= (1.0 + 1e-9) * length:
            message = f"at is {at:g} m, outside the beam of 0 to {length:g} m"
            raise InputError(Problem(f"beam '{self.name}'", message))
        j = int(np.clip(np.searchsorted(self.s_nodes, at), 1, len(self.s_nodes) - 1))
        x = (at - self.s_nodes[j - 1]) / (self.s_nodes[j] - self.s_nodes[j - 1])
        return np.asarray((1.0 - x) * values[:, j - 1, k] + x * values[:, j, k])

    def diagram(self, component: str, time: float) -> tuple[Array, Array]:
        """Return arc length (k,) in m and a resultant (k,) along the beam at one instant in s.

        The points are both ends of every element, so that jumps at loads are visible. Values
        between stored instants are interpolated linearly.

        Raises
        ------
        InputError
            For an unknown component or an instant outside the run.
        """
        k = component_of(self.name, component)
        before, after, share = bracket_instants(self.time, [time], f"beam '{self.name}'")
        x = float(share[0])
        values = (1.0 - x) * self.ends[before[0], :, :, k] + x * self.ends[after[0], :, :, k]
        s = np.stack([self.s_nodes[:-1], self.s_nodes[1:]], axis=1)
        return s.ravel(), values.ravel()

    def envelope(self, component: str) -> tuple[Array, Array, Array, Array]:
        """Return the smallest and largest resultant at every node with their instants.

        Returns
        -------
        smallest, at, largest, at : (ne + 1,) arrays
            Smallest value, N or N m, its instant, s, largest value and its instant.

        Raises
        ------
        InputError
            For an unknown component.
        """
        values = self.at_nodes[:, :, component_of(self.name, component)]
        # the first instant of equal values, up to round-off
        low, high = (np.apply_along_axis(largest, 0, x) for x in (-values, values))
        return values.min(axis=0), self.time[low], values.max(axis=0), self.time[high]

    def table(self) -> list[tuple[str, ...]]:
        """Return a header and the smallest and largest of each resultant as rows of texts."""
        rows: list[tuple[str, ...]] = [
            ("", "smallest", "at (m)", "at (s)", "largest", "at (m)", "at (s)", "")
        ]
        for name, unit in zip(RESULTANTS, UNITS, strict=True):
            low, low_at, high, high_at = self.envelope(name)
            i, j = largest(-low), largest(high)
            rows.append(
                (
                    name,
                    f"{low[i]:.6g}",
                    f"{self.s_nodes[i]:.6g}",
                    f"{low_at[i]:.6g}",
                    f"{high[j]:.6g}",
                    f"{self.s_nodes[j]:.6g}",
                    f"{high_at[j]:.6g}",
                    unit,
                )
            )
        return rows

    def __str__(self) -> str:
        rows = self.table()
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        return "\n".join(
            "  ".join(c.rjust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in rows
        )

    def to_csv(self, path: str | Path, time: float | None = None) -> Path:
        """Write a table of the resultants at an instant, or of their extremes.

        Parameters
        ----------
        path : path
            File that ends with .csv.
        time : float, optional
            Instant, s, of the resultants at both ends of every element; None writes the smallest
            and largest value at every node.

        Raises
        ------
        InputError
            For another ending or a path that cannot be written.
        """
        out = Path(path)
        if out.suffix.lower() != ".csv":
            raise InputError(Problem(str(out), "must end with .csv"))
        rows: list[list[Any]]
        if time is None:
            head = ["s (m)"]
            columns: list[Array] = [self.s_nodes]
            for name, unit in zip(RESULTANTS, UNITS, strict=True):
                low, low_at, high, high_at = self.envelope(name)
                head += [
                    f"smallest {name} ({unit})",
                    "at (s)",
                    f"largest {name} ({unit})",
                    "at (s)",
                ]
                columns += [low, low_at, high, high_at]
        else:
            head = ["s (m)", *(f"{n} ({u})" for n, u in zip(RESULTANTS, UNITS, strict=True))]
            found = [self.diagram(name, time) for name in RESULTANTS]
            columns = [found[0][0], *(values for _, values in found)]
        rows = np.stack(columns, axis=1).tolist()
        return write_table(out, head, rows)


@explained
def section_forces(
    run: Solution,
    beam: str,
    *,
    times: ArrayLike | None = None,
    start: float | None = None,
    end: float | None = None,
) -> SectionForces:
    """Return strains and stress resultants of a beam over a run, from the states of its nodes.

    Parameters
    ----------
    run : Solution
        Results of the run.
    beam : str
        Name of the beam.
    times : (nt,) array_like, optional
        Instants, s, with linear interpolation; None takes all stored instants.
    start, end : float, optional
        First and last instant, s.

    Raises
    ------
    InputError
        If there is no such beam, or an instant is outside the run.

    Examples
    --------
    ``print(section_forces(run, "cable"))``
    """
    where = f"beam '{beam}'"
    shape, time = find_beam(run, beam), run.time
    if times is not None:
        wanted = np.atleast_1d(np.asarray(times, dtype=np.float64))
        first, last, share = bracket_instants(time, wanted, where)
        span = slice(int(first.min()), int(last.max()) + 1)
        known = section_forces(run, beam, start=time[span.start], end=time[span.stop - 1])
        a, b = first - span.start, last - span.start

        def mixed(x: Array) -> Array:
            f = share.reshape(-1, *(1,) * (x.ndim - 1))
            return np.asarray((1.0 - f) * x[a] + f * x[b])

        return replace(
            known,
            time=wanted,
            strains=mixed(known.strains),
            resultants=mixed(known.resultants),
            ends=mixed(known.ends),
        )
    rows = window(time, start, end, where)
    time = time[rows]
    nt, ne = len(time), shape.n
    e, s = np.empty((nt, ne, 6)), np.empty((nt, ne, 6))
    ends = np.empty((nt, ne, 2, 6))
    for some, part in _blocks(run, shape, rows):
        e[some], s[some], ends[some] = part
    middle = 0.5 * (shape.s[:-1] + shape.s[1:])
    return SectionForces(beam, time, middle, e, s, ends, shape.s)


def _blocks(
    run: Solution, shape: BeamShape, rows: slice
) -> Iterator[tuple[slice, tuple[Array, Array, Array]]]:
    """Yield slices of the rows with strains, resultants and end resultants of the elements."""
    beam = elements(shape)
    count = max(1, BLOCK // (13 * (shape.n + 1)))
    for first in range(rows.start, rows.stop, count):
        last = min(first + count, rows.stop)
        q, v = run.beam_states(shape.name, slice(first, last))
        yield slice(first - rows.start, last - rows.start), state_forces(beam, q, v)


def state_forces(beam: Elements, q: Array, v: Array | None = None) -> tuple[Array, Array, Array]:
    """Return strains, resultants and end resultants of the elements from node states.

    Parameters
    ----------
    beam : Elements
    q : (..., n + 1, 7) array
        ``[R e]`` of the nodes.
    v : (..., n + 1, 6) array, optional
        ``[R' w_local]`` of the nodes, for damping.
    """
    A = rotation_matrices(q[..., 3:])
    at = poses(beam, q[..., :3], A)
    found = strains(beam, at)
    rate = None
    if v is not None and np.any(beam.beta):
        rate = rates(beam, found, at.Qa, *_motion(beam, at, A, v))
    s = resultants(beam, found.e, rate)
    return found.e, s, end_resultants(found, s)


def _motion(beam: Elements, at: Poses, A: Array, v: Array) -> tuple[Array, Array]:
    """Return ``rb' - ra' + r x wa``, m/s, and ``wb - wa``, rad/s, of elements, world frame."""
    w = np.einsum("...ij,...j->...i", A, v[..., 3:])
    wa, wb = w[..., :-1, :], w[..., 1:, :]
    arm_a = np.einsum("...ij,...j->...i", A[..., :-1, :, :], beam.ua)
    arm_b = np.einsum("...ij,...j->...i", A[..., 1:, :, :], beam.ub)
    va = v[..., :-1, :3] + np.cross(wa, arm_a)
    vb = v[..., 1:, :3] + np.cross(wb, arm_b)
    return vb - va + np.cross(at.rb - at.ra, wa), wb - wa


def find_beam(run: Solution, name: str) -> BeamShape:
    """Return the beam of a name.

    Raises
    ------
    InputError
        If there is no such beam; the message contains the nearest name.
    """
    beams = {beam.name: beam for beam in run.beams}
    if name not in beams:
        tail = suggest(name, beams) if beams else "; this run has no beams"
        raise InputError(Problem(run.where, f"no beam '{name}'{tail}"))
    return beams[name]


def component_of(beam: str, component: str) -> int:
    """Return the index of a resultant in RESULTANTS.

    Raises
    ------
    InputError
        If there is no such resultant.
    """
    if component not in RESULTANTS:
        message = f"no resultant '{component}'{suggest(component, RESULTANTS)}"
        raise InputError(Problem(f"beam '{beam}'", message))
    return RESULTANTS.index(component)
