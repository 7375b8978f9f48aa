"""Stress field: stress or strain of a body at its sites and instants, computed on demand."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.base.ranking import ranking
from jousto.base.units import shown_unit
from jousto.base.voigt import STRAIN_COMPONENTS, STRESS_COMPONENTS
from jousto.model.native.recover import LANES, Recovery
from jousto.recovery.fields.criteria import (
    Criterion,
    check_criterion,
    principal,
    rotate_tensors,
    weights,
)
from jousto.recovery.fields.kernels import kernel, world_weights
from jousto.recovery.fields.places import Sites, refuse_gaps, refuse_no_rotations, site_indices
from jousto.recovery.fields.planes import CriticalPlane, critical_plane
from jousto.recovery.fields.store import write_field
from jousto.recovery.instants import bracket_instants, window
from jousto.reduction.fields.stress import StressModes

Frame = Literal["site", "body", "world"]

BLOCK_MEMORY = 64 << 20
"""Memory of one block of values, bytes."""

WHOLE_MEMORY = 1 << 30
"""Largest result of `StressField.values`, bytes; above it an error lists the alternatives."""

FEW_SITES = 64
"""Smallest number of sites in a block along time."""

CALL = 20_000_000
"""Number of values in one call of the engine, which takes a fraction of a second."""

KEPT_KERNELS = 2
"""Number of criteria whose modes a field caches in the order of the engine."""


@described
@dataclass(frozen=True, eq=False)
class Envelope:
    """Smallest and largest value of a criterion at every site, with their instants.

    Attributes
    ----------
    criterion, unit : str
    labels : tuple of str
    min, min_time, max, max_time : (ns,) array
    """

    criterion: str
    unit: str
    labels: tuple[str, ...]
    min: Array
    min_time: Array
    max: Array
    max_time: Array

    def __str__(self) -> str:
        k, j = (int(ranking(x, self.labels)[0]) for x in (self.max, -self.min))
        unit, factor = shown_unit(self.unit)
        return (
            f"{self.criterion} over {len(self.labels)} places: "
            f"largest {factor * self.max[k]:.6g} {unit} at {self.labels[k]}, "
            f"{self.max_time[k]:.6g} s; smallest {factor * self.min[j]:.6g} {unit} at "
            f"{self.labels[j]}, {self.min_time[j]:.6g} s"
        )


@dataclass(frozen=True, eq=False)
class StressField:
    """Stress (or strain) of a body, ``s(x, t) = S(x) p(t)``, computed on demand.

    The functions `stress_field` and `field_from` return it.

    Attributes
    ----------
    name : str
        Name of the body.
    modes : StressModes
        Sites and S (ns, 6, n): Pa, or m/m, per unit coordinate, in the axes `modes.axes`.
    p : (nt, n) array
        Modal coordinates, or resultants of a beam.
    time : (nt,) array
        Instants, s.
    frame : str
        Axes of components: "site", "body" (part frame), or "world".
    strain : bool
        Whether the components are strains ``[e11 e22 e33 g12 g23 g13]``.
    A : (nt, 3, 3) array or None
        Rotation matrices from body to world of a field in world axes; `modes` are in the body
        frame.
    columns : (ns,) int array or None
        For a beam, whose sites depend on the six resultants of their section: index in p of the
        first of these. None: every site depends on all of p.
    v : (nt, n) array or None
        Rates of the coordinates, 1/s; None if they are not known.
    """

    name: str
    modes: StressModes
    p: Array
    time: Array
    frame: Frame = "site"
    strain: bool = False
    A: Array | None = None
    columns: Index | None = None
    v: Array | None = None

    def __post_init__(self) -> None:
        problems = Problems()
        where = f"stress of '{self.name}'"
        n = self.modes.modes.shape[2]
        refuse_gaps(where, self.p, self.time)
        p = problems.array(where, "p", self.p, (None, n if self.columns is None else None))
        nt = None if p is None else len(p)
        time = problems.array(where, "time", self.time, (nt,))
        if nt == 0:
            problems.add(where, "time is empty, must have one or more instants")
        if time is not None and np.any(np.diff(time) <= 0.0):
            k = int(np.argmax(np.diff(time) <= 0.0))
            problems.add(where, f"time must increase, but does not after {time[k]:g} s, index {k}")
        if self.v is not None:
            v = problems.array(where, "v", self.v, (nt, None if p is None else p.shape[1]))
            object.__setattr__(self, "v", v)
        if self.A is not None:
            A = problems.array(where, "A", self.A, (nt, 3, 3))
            object.__setattr__(self, "A", A)
            if A is not None:
                refuse_no_rotations(problems, where, A, self.time)
        if (self.A is None) == (self.frame == "world"):
            problems.add(where, "rotation matrices A and frame='world' must be given together")
        problems.raise_if_any()
        object.__setattr__(self, "p", p)
        object.__setattr__(self, "time", time)

    def __repr__(self) -> str:
        kind = "strain, " if self.strain else ""
        return (
            f"<StressField {self.name!r}: {kind}{self.ns} places, {self.nt} instants, "
            f"{self.frame} axes>"
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the sites."""
        return self.modes.labels

    @property
    def positions(self) -> Array:
        """Undeformed positions (ns, 3), part frame, m."""
        return self.modes.positions

    @property
    def S(self) -> Array:
        """Stress of each mode, (ns, 6, n)."""
        return self.modes.modes

    @property
    def ns(self) -> int:
        """Number of sites."""
        return len(self.modes.labels)

    @property
    def nt(self) -> int:
        """Number of instants."""
        return len(self.time)

    @property
    def unit(self) -> str:
        """Unit: Pa or m/m."""
        return "m/m" if self.strain else "Pa"

    @cached_property
    def _places(self) -> dict[str, int]:
        return {label: i for i, label in enumerate(self.modes.labels)}

    @cached_property
    def pieces(self) -> tuple[tuple[slice, slice], ...]:
        """Slices of sites and the slices of p on which they depend; one pair except for beams."""
        n = self.S.shape[2]
        if self.columns is None:
            return ((slice(0, self.ns), slice(0, n)),)
        cuts = np.flatnonzero(np.diff(self.columns)) + 1
        starts, stops = [0, *cuts.tolist()], [*cuts.tolist(), self.ns]
        first = [int(self.columns[k]) for k in starts]
        return tuple(
            (slice(a, b), slice(c, c + n)) for a, b, c in zip(starts, stops, first, strict=True)
        )

    def _tensors(self, p: Array) -> Array:
        """Return the components (nt, ns, 6) for coordinates (nt, n), in the axes of `modes`."""
        if self.columns is None:
            return np.asarray(np.einsum("scj,tj->tsc", self.S, p, optimize=True))
        own = p[:, self.columns[:, None] + np.arange(self.S.shape[2])]
        return np.asarray(np.einsum("scj,tsj->tsc", self.S, own))

    # -- choosing -----------------------------------------------------------------------------

    def indices(self, sites: Sites = None) -> Index:
        """Return the indices (k,) of sites.

        Parameters
        ----------
        sites : str, int, sequence of these, slice, boolean array (ns,) or None
            Labels such as ``"n12"`` or ``"e1.a.top"``; names of node sets or numbers of nodes from
            0, with all their sites; a slice or a boolean array of sites; None for all.

        Raises
        ------
        InputError
            With all sites that do not exist.
        """
        return site_indices(self.modes, sites, f"stress of '{self.name}'", self._places)

    def only(self, sites: Sites) -> StressField:
        """Return the field at the given sites, see `indices`."""
        return self.take(self.indices(sites))

    def take(self, places: ArrayLike) -> StressField:
        """Return the field at sites given by index, in this order."""
        chosen = np.asarray(places, dtype=np.intp)
        columns = None if self.columns is None else self.columns[chosen]
        return replace(self, modes=self.modes.select(chosen), columns=columns)

    def during(self, start: float | None = None, end: float | None = None) -> StressField:
        """Return the field at the instants from `start` to `end`, s.

        Raises
        ------
        InputError
            If there is no instant in this span.
        """
        rows = window(self.time, start, end, f"stress of '{self.name}'")
        A = None if self.A is None else self.A[rows]
        v = None if self.v is None else self.v[rows]
        return replace(self, p=self.p[rows], time=self.time[rows], A=A, v=v)

    def _rows(self, times: ArrayLike | slice | None) -> tuple[Array, Array | None]:
        """Return p and A at given instants, or at slices of the stored ones."""
        if times is None:
            return self.p, self.A
        if isinstance(times, slice):
            return self.p[times], None if self.A is None else self.A[times]
        before, after, share = bracket_instants(self.time, times, f"stress of '{self.name}'")
        p = (1.0 - share[:, None]) * self.p[before] + share[:, None] * self.p[after]
        if self.A is None:
            return p, None
        A = (1.0 - share[:, None, None]) * self.A[before] + share[:, None, None] * self.A[after]
        U, _, V = np.linalg.svd(A)
        return p, np.asarray(U @ V)

    # -- tensors ------------------------------------------------------------------------------

    def at(self, time: float, sites: Sites = None) -> Array:
        """Return the components (ns, 6) at one instant, s, interpolated between stored instants."""
        p, A = self._rows(np.array([time], dtype=np.float64))
        # no copy of the modes if all sites are wanted
        chosen = self if sites is None else self.only(sites)
        if self.columns is None:
            S = chosen.S
            s = (S.reshape(-1, S.shape[2]) @ p[0]).reshape(-1, 6)
        else:
            s = chosen._tensors(p)[0]
        return s if A is None else rotate_tensors(s, A[0], self.strain)

    @explained
    def history(self, site: Sites, times: ArrayLike | slice | None = None) -> Array:
        """Return the components over time: (nt, 6) of one site, (nt, k, 6) of several."""
        places = self.indices(site)
        p, A = self._rows(times)
        s = self.take(places)._tensors(p)
        if A is not None:
            s = rotate_tensors(s, A[:, None], self.strain)
        single = len(places) == 1 and isinstance(site, str | int | np.integer)
        return np.asarray(s[:, 0] if single else s)

    def principal(self, time: float | None = None, site: str | None = None) -> tuple[Array, Array]:
        """Return principal values and directions, at one instant or over time at one site.

        Parameters
        ----------
        time : float, optional
            Instant, s, for the values of all sites.
        site : str, optional
            Label of the site, for the values of all instants.

        Returns
        -------
        values : (k, 3) array
            Principal values in descending order.
        directions : (k, 3, 3) array
            Column j is the unit direction of value j, in the axes of the field.

        Raises
        ------
        InputError
            If not exactly one of time and site is given.
        """
        if (time is None) == (site is None):
            raise InputError(Problem("principal", "give either time or site"))
        s = self.history(site) if time is None else self.at(time)
        return principal(s, self.strain)

    # -- criteria -----------------------------------------------------------------------------

    @explained
    def values(
        self,
        criterion: Criterion = "von-mises",
        sites: Sites = None,
        times: ArrayLike | slice | None = None,
        *,
        memory: int = WHOLE_MEMORY,
    ) -> Array:
        """Return a criterion (nt, ns) at sites and instants.

        Parameters
        ----------
        criterion : str or Plane
            See `evaluate`.
        sites : optional
            See `indices`.
        times : (nt,) array_like or slice, optional
            Instants, s, with linear interpolation, or a slice of the stored ones.
        memory : int
            Largest memory of the result, bytes.

        Raises
        ------
        InputError
            If there is no such criterion, site or instant, or the result is too large.
        """
        check_criterion(criterion, self.strain)
        places = self.indices(sites)
        p, A = self._rows(times)
        size = 8 * len(p) * len(places)
        if size > memory:
            raise InputError(
                Problem(
                    f"stress of '{self.name}'",
                    f"{len(p)} instants x {len(places)} sites need {size / 1e9:.3g} GB, more than "
                    f"memory={memory / 1e9:.3g} GB; use blocks(), envelope() or write(), or fewer "
                    "sites",
                )
            )
        chosen = self if sites is None else self.take(places)
        w = self._weights(criterion, A)
        out = np.empty((len(p), len(places)))
        # a limited number of rows per call, since Ctrl-C takes effect between calls
        rows = max(1, CALL // max(len(places), 1))
        for k in range(0, len(p), rows):
            some = slice(k, k + rows)
            u = None if w is None else w[some]
            for at, on, recovery in chosen._kernels(criterion):
                recovery.values(p[some, on], u, out[some, at])
        return out

    @cached_property
    def _known(self) -> dict[Criterion, Any]:
        return {}

    def _kernels(self, criterion: Criterion) -> list[tuple[slice, slice, Recovery]]:
        """Return slices of sites and of p with the engine's data of a criterion (cached)."""
        if criterion not in self._known:
            if len(self._known) >= KEPT_KERNELS:
                self._known.pop(next(iter(self._known)))
            turning = self.A is not None
            self._known[criterion] = [
                (at, on, kernel(self.S[at], criterion, self.strain, turning))
                for at, on in self.pieces
            ]
        found: list[tuple[slice, slice, Recovery]] = self._known[criterion]
        return found

    def _cuts(self, width: int) -> list[tuple[int, int]]:
        """Return sites (first, last + 1) of blocks of about `width`; pieces of beams stay whole."""
        if self.columns is None:
            return [(s, min(s + width, self.ns)) for s in range(0, self.ns, width)]
        cuts, first = [], 0
        for at, _ in self.pieces:
            if at.stop - first > width and at.start > first:
                cuts.append((first, at.start))
                first = at.start
        return [*cuts, (first, self.ns)]

    def _weights(self, criterion: Criterion, A: Array | None) -> Array | None:
        """Return the weights (nt, 6) of body components for a component in world axes."""
        w = weights(criterion, self.strain)
        return None if w is None or A is None else world_weights(w, A, self.strain)

    def blocks(
        self,
        criterion: Criterion = "von-mises",
        *,
        memory: int = BLOCK_MEMORY,
        along: Literal["time", "sites"] = "time",
    ) -> Iterator[tuple[slice, slice, Array]]:
        """Yield the values of a criterion in blocks (instants, sites, values).

        Parameters
        ----------
        criterion : str or Plane
            See `evaluate`.
        memory : int
            Memory of the values of one block, bytes.
        along : str
            Order of the blocks. "time": all instants of the first sites, then of the next sites,
            for cycle counting. "sites": all sites of the first instants, then of the next
            instants, for pictures.

        Yields
        ------
        instants, places : slice
        values : (nt', ns') array

        Raises
        ------
        InputError
            If there is no such criterion.
        """
        check_criterion(criterion, self.strain)
        cells = max(1, memory // 8)
        if along == "time":
            # complete histories if FEW_SITES of them fit into the memory, otherwise pieces of
            # histories
            width = _whole_tiles(max(FEW_SITES, cells // self.nt), self.ns)
            height = min(self.nt, max(1, cells // width))
            order = [(t, s) for s in self._cuts(width) for t in range(0, self.nt, height)]
        elif along == "sites":
            height = max(1, min(self.nt, cells // self.ns))
            width = _whole_tiles(cells, self.ns)
            order = [(t, s) for t in range(0, self.nt, height) for s in self._cuts(width)]
        else:
            raise InputError(Problem("blocks", f"along is {along!r}, must be 'time' or 'sites'"))
        kernels, w = self._kernels(criterion), self._weights(criterion, self.A)
        starts = [at.start for at, _, _ in kernels]
        for t, (first, last) in order:
            instants = slice(t, min(t + height, self.nt))
            some = None if w is None else w[instants]
            out = np.empty((instants.stop - t, last - first))
            for k in range(bisect_right(starts, first) - 1, bisect_left(starts, last)):
                at, on, recovery = kernels[k]
                a, b = max(first, at.start), min(last, at.stop)
                part = recovery.slice(a - at.start, b - at.start)
                part.values(self.p[instants, on], some, out[:, a - first : b - first])
            yield instants, slice(first, last), out

    def envelope(self, criterion: Criterion = "von-mises") -> Envelope:
        """Return the smallest and largest value of a criterion at every site, and their instants.

        Memory is proportional to the number of sites, since values over time are not stored.

        Raises
        ------
        InputError
            If there is no such criterion.
        """
        check_criterion(criterion, self.strain)
        low, high = np.full(self.ns, np.inf), np.full(self.ns, -np.inf)
        low_at, high_at = np.zeros(self.ns, dtype=np.int64), np.zeros(self.ns, dtype=np.int64)
        kernels, w = self._kernels(criterion), self._weights(criterion, self.A)
        rows = max(1, CALL // self.ns)
        for k in range(0, self.nt, rows):
            some = slice(k, k + rows)
            u = None if w is None else w[some]
            for at, on, recovery in kernels:
                found = low[at], low_at[at], high[at], high_at[at]
                recovery.extremes(self.p[some, on], k, *found, u)
        t = self.time
        return Envelope(str(criterion), self.unit, self.labels, low, t[low_at], high, t[high_at])

    def write(
        self,
        path: str | Path,
        criterion: Criterion | None = "von-mises",
        *,
        memory: int = BLOCK_MEMORY,
    ) -> Path:
        """Write a criterion at all sites and instants into an HDF5 file; return the path.

        Datasets: ``time`` (nt,), ``labels``, ``positions``, ``axes``, ``nodes`` (ns,),
        ``values/CRITERION`` (nt, ns), and ``rows``, the number of instants written so far, so that
        the file of a killed program is readable.

        Parameters
        ----------
        path : path
            File that ends with .h5.
        criterion : str, Plane or None
            See `evaluate`; None writes all six components.
        memory : int
            Memory of the values computed at a time, bytes.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            If there is no such criterion, or the file cannot be written.
        """
        if criterion is not None:
            check_criterion(criterion, self.strain)
        names = STRAIN_COMPONENTS if self.strain else STRESS_COMPONENTS
        quantity = "strain" if self.strain else "stress"
        data = {
            "labels": np.array([label.encode() for label in self.labels], dtype=np.bytes_),
            "positions": self.positions,
            "axes": self.modes.axes,
            **({} if self.modes.nodes is None else {"nodes": self.modes.nodes}),
            "time": self.time,
        }
        return write_field(
            path,
            {"body": self.name, "frame": self.frame, "quantity": quantity},
            data,
            names if criterion is None else (criterion,),
            self.unit,
            lambda what: self.blocks(what, memory=memory, along="sites"),
        )

    # -- planes -------------------------------------------------------------------------------

    def critical_plane(
        self, site: Sites, by: Literal["maximum", "range"] = "maximum"
    ) -> CriticalPlane:
        """Return the plane of the largest normal stress, or of its largest range, at one site.

        Parameters
        ----------
        site : str or int
            One site, see `indices`.
        by : str
            "maximum": largest normal stress of all planes and instants; "range": largest
            difference of the normal stress of one plane between two instants.

        Returns
        -------
        CriticalPlane
            Plane, with its normal in the axes of the field.

        Raises
        ------
        InputError
            If `site` is not exactly one site.
        """
        places = self.indices(site)
        if len(places) != 1:
            message = f"site has {len(places)} sites, must be one"
            raise InputError(Problem(f"critical plane of '{self.name}'", message))
        s = self.history(slice(int(places[0]), int(places[0]) + 1))[:, 0]
        return critical_plane(s, self.time, by=by, strain=self.strain)

    def critical_planes(
        self, sites: Sites = None, by: Literal["maximum", "range"] = "maximum"
    ) -> tuple[CriticalPlane, ...]:
        """Return the critical planes of several sites, see `critical_plane`.

        Histories are computed for a few sites at a time.

        Parameters
        ----------
        sites : optional
            See `indices`; None takes all sites.
        by : str
            "maximum" or "range".
        """
        places = self.indices(sites)
        step = max(1, BLOCK_MEMORY // (48 * self.nt))
        found = []
        for k in range(0, len(places), step):
            some = self.take(places[k : k + step]).history(slice(None))
            found += [
                critical_plane(some[:, i], self.time, by=by, strain=self.strain)
                for i in range(some.shape[1])
            ]
        return tuple(found)


def _whole_tiles(width: int, ns: int) -> int:
    return ns if width >= ns else max(LANES, width // LANES * LANES)
