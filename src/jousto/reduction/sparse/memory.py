"""Memory needed by a reduction, and memory of the machine."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, warn
from jousto.reduction.methods import CraigBampton, Method
from jousto.reduction.sparse import factor

if TYPE_CHECKING:
    from jousto.parts.part import Part

MiB, GiB = 1 << 20, 1 << 30

BASE = 150 * MiB
"""Memory of Python and its libraries, bytes."""

COPIES = 2.5
"""Number of copies of K and M: of the part, of the interior, and the triangle for the library."""

BULKY = {"superlu": 300.0, "multifrontal": 250.0}
"""Bytes of a factor / ``n^(4/3)``, nested dissection of solids; 120 for other libraries."""

MANY = 200
"""Number of modes above which an interface is probably a node set."""

FIELDS = 7.0
"""Copies of the modes in the invariants: modes, three rotated copies, and M times these."""

PAIRS = 45.0
"""Numbers per pair of modes in the invariants: nine bilinear forms and temporary arrays."""

THIN = 20.0
"""Bytes of a factor / ``n log2 n``, nested dissection of plates and shells: a lower bound."""


@dataclass(frozen=True)
class MemoryEstimate:
    """Memory of a reduction, in bytes.

    Parameters
    ----------
    unknowns : int
        Degrees of freedom.
    modes : int
        Upper bound of the number of modes: interface modes, requested modes and residual vectors.
    solver : str
        Library of the factorisation, see `solvers`.
    factor : float
        Memory of the factorisation of a bulky part; a thin part needs less.
    total : float
        Largest total memory in use, including the part.
    least : float
        Total memory for a thin part, a lower bound.
    machine : float
        Memory of the machine, or limit of this process; infinite if unknown.
    """

    unknowns: int
    modes: int
    solver: str
    factor: float
    total: float
    least: float
    machine: float

    def __str__(self) -> str:
        there = f" of {self.machine / GiB:.1f} GiB" if np.isfinite(self.machine) else ""
        return (
            f"{self.unknowns:,} unknowns, {self.modes:,} modes: up to about "
            f"{_amount(self.total)}{there}, {_amount(self.factor)} of it for the "
            f"factorisation by {self.solver}"
        )


@explained
def memory_estimate(
    part: Part,
    method: Method,
    *,
    stiffening: bool = False,
    solver: str | None = None,
) -> MemoryEstimate:
    """Return an estimate of the memory of a reduction, before it starts.

    The factor of a solid of n unknowns grows with ``n^(4/3)``; the m modes need several dense ``n
    m`` and ``m^2`` arrays, which dominate if a node set is an interface.

    Parameters
    ----------
    part : Part
    method : CraigBampton, FreeFree or ShapeFunctions
    stiffening : bool
        See `reduce`.
    solver : str, optional
        See `reduce`.

    Examples
    --------
    >>> from jousto import FreeFree, Material, Part, Rectangle
    >>> beam = Part.beam(1.0, Rectangle(0.1, 0.1), 40, Material(2e11, 0.3, 7850.0))
    >>> print(memory_estimate(beam, FreeFree(modes=5)).unknowns)
    246
    """
    n = part.K.shape[0]
    name = factor.choose(n, f"part '{part.name}'", solver)
    entries = part.K.nnz + part.M.nnz
    modes = 20 if method.modes is None else method.modes
    columns = _columns(part, method)
    m = min(modes + columns, n)
    # the larger of two needs: the search for modes, and the computation of the invariants
    basis = 2 * max(2 * modes + 40, 104)
    sites = 0 if part.stress is None else len(part.stress.sites)
    body = m * max(FIELDS * n + PAIRS * m, 2.0 * n + 2.0 * 6 * sites)
    if stiffening:
        body = max(body, 3.0 * n * m**2)
    rest = BASE + COPIES * 12.0 * entries + 8.0 * max(n * (basis + 4.0 * m), body)
    bulky = BULKY.get(name, 120.0) * n ** (4.0 / 3.0)
    thin = min(THIN * n * np.log2(max(n, 2)), bulky)
    return MemoryEstimate(n, m, name, bulky, rest + bulky, rest + thin, machine_memory())


def _columns(part: Part, method: Method) -> int:
    """Return the number of interface motions (or attachment modes) plus residual vectors."""
    ties = [tie.name for tie in part.ties]
    names: Collection[str] = method.interfaces
    if isinstance(method, CraigBampton):
        names = names or ties
    # six motions per tie, and all motions of each node of a set; unknown names are reported later
    count = sum(
        6 if name in ties else part.dofs_per_node * len(part.node_sets.get(name, ()))
        for name in names
    )
    for item in method.residuals:
        count += 6 if isinstance(item, str) else item.loads.shape[1]
    return count + 6 * (isinstance(method, CraigBampton) and method.inertia_relief)


def check_memory(estimate: MemoryEstimate, where: str) -> None:
    """Raise InputError, or warn, for a reduction that does not fit into the memory.

    Raises
    ------
    InputError
        If even a thin part of this size needs more memory than available.

    Warns
    -----
    JoustoWarning
        If a bulky part of this size needs more memory than available.
    """
    remedy = (
        "use a coarser mesh (quadratic elements allow it), fewer modes, or a machine with more "
        "memory"
    )
    if estimate.modes > MANY:
        remedy += "; an Interface(name, nodes) has 6 modes, a node set has 3 or 6 per node"
    text = (
        f"the reduction of {estimate.unknowns:,} unknowns to {estimate.modes:,} modes needs {{}} "
        f"of memory, this machine has {estimate.machine / GiB:.1f} GiB; {remedy}"
    )
    if estimate.least > estimate.machine:
        raise InputError(Problem(where, text.format(f"at least {_amount(estimate.least)}")))
    if estimate.total > estimate.machine:
        warn(where, text.format(f"up to about {_amount(estimate.total)}"))


@functools.cache
def machine_memory() -> float:
    """Return the memory of this machine, or of the container in which this process runs, bytes."""
    limits = [np.inf]
    if sys.platform == "win32":
        limits.append(_windows())
    else:
        try:
            limits.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
        except (ValueError, OSError, AttributeError):
            pass
    for path in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            limits.append(float(Path(path).read_text()))
        except (OSError, ValueError):
            # no such file, or "max"
            continue
    return min(limits)


def _windows() -> float:
    import ctypes

    class Status(ctypes.Structure):
        _fields_ = [
            ("length", ctypes.c_uint32),
            ("load", ctypes.c_uint32),
            *((name, ctypes.c_uint64) for name in ("total", "free", "c", "d", "e", "f", "g")),
        ]

    status = Status(length=ctypes.sizeof(Status))
    kernel = getattr(ctypes, "windll").kernel32  # noqa: B009
    return float(status.total) if kernel.GlobalMemoryStatusEx(ctypes.byref(status)) else np.inf


def _amount(bytes_: float) -> str:
    return f"{bytes_ / GiB:.1f} GiB" if bytes_ > 0.95 * GiB else f"{bytes_ / MiB:.0f} MiB"
