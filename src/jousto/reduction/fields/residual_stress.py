"""Residual stress: the static response to loads and inertia that the modes do not contain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.voigt import PAIRS
from jousto.parts.loads import Spin
from jousto.parts.part import Part
from jousto.reduction.modes.partition import whole_part_basis
from jousto.reduction.modes.relief import response, unit_loads
from jousto.reduction.modes.rigid import RigidBasis

if TYPE_CHECKING:
    from jousto.reduction.stages import Run


AXES = "xyz"
ACCELERATIONS = (
    *(f"acceleration {a}" for a in AXES),
    *(f"angular acceleration {a}" for a in AXES),
)
CENTRIFUGAL = tuple(f"centrifugal {AXES[a]}{AXES[b]}" for a, b in PAIRS)


@dataclass(frozen=True, eq=False)
class ResidualStress:
    """Stress outside of the modes for unit loads, by the mode acceleration method.

    ``u = Phi p + [K^+ - Phi W^-2 Phi^T] F``: F are all loads including the inertia forces of the
    motion.

    Parameters
    ----------
    names : tuple of str
        Load of each column: "acceleration x" .. "z" of the origin minus gravity, per
        m/s2, "angular acceleration x" .. "z" per rad/s2, "centrifugal xx" .. "xz" per rad2/s2 of
        ``w_x w_x`` .. ``w_x w_z``, all in the body frame; "mode 1" .. per unit of p''; then the
        named loads.
    columns : (ns, 6, m) array
        Stress, Pa per unit of each load.
    static : (n, m) array
        Part of each response that the modes contain, ``W^-2 Phi^T F``.
    """

    names: tuple[str, ...]
    columns: Array
    static: Array

    @property
    def loads(self) -> tuple[str, ...]:
        """Names of the loads that are not inertia forces."""
        return self.names[len(ACCELERATIONS) + len(CENTRIFUGAL) + len(self.static) :]

    def keep(self, modes: NDArray[np.intp], stress: Array) -> ResidualStress:
        """Return the residual stress for fewer modes.

        Parameters
        ----------
        modes : (k,) int array
            Indices of the remaining modes.
        stress : (ns, 6, n) array
            Stress of all modes.
        """
        n, first = len(self.static), len(ACCELERATIONS) + len(CENTRIFUGAL)
        gone = np.setdiff1d(np.arange(n), modes)
        columns = self.columns + stress[:, :, gone] @ self.static[gone]
        kept = np.concatenate(
            [np.arange(first), first + modes, np.arange(first + n, len(self.names))]
        )
        own = tuple(f"mode {j + 1}" for j in range(len(modes)))
        names = (*self.names[:first], *own, *self.loads)
        return ResidualStress(names, columns[:, :, kept], self.static[modes][:, kept])


def read_loads(part: Part, given: Any) -> dict[str, Array] | None:
    """Return the named loads of ``residual_stress=``; None for no residual stress.

    Raises
    ------
    InputError
        With all problems of the loads.
    """
    if given is False or given is None:
        return None
    where, problems = f"part '{part.name}'", Problems()
    if part.stress is None:
        problems.add(where, "the part has no stress data", "residual_stress", named=False)
    loads: dict[str, Array] = {}
    if given is not True:
        if not isinstance(given, Mapping):
            message = "residual_stress is True, or loads by name {'tip': part.load(...)}"
            problems.add(where, f"{message}, not {given!r}")
        else:
            for name, load in given.items():
                f = problems.array(where, f"load '{name}'", load, (part.K.shape[0],))
                if f is not None:
                    loads[str(name)] = f
    problems.raise_if_any()
    return loads


def residual_stress(
    part: Part,
    X: Array,
    stiffness: Array,
    interfaces: tuple[str, ...],
    rigid: RigidBasis,
    loads: dict[str, Array],
    run: Run,
) -> ResidualStress:
    """Return the residual stress of a reduction.

    Accelerations and named loads are balanced by loads on the interfaces, the reactions of the
    joints. In a reduction without interfaces they are balanced by inertia forces.

    Parameters
    ----------
    part : Part
    X : (ndof, n) array
        Modes, mass-normalised, free of rigid motion.
    stiffness : (n,) array
        ``omega^2``.
    interfaces : tuple of str
        Interfaces where joints support the part.
    rigid : RigidBasis
    loads : dict
        Named nodal loads (ndof,).
    run : Run

    Raises
    ------
    InputError
        If the interfaces together do not stop all rigid motions of the part.
    """
    assert part.stress is not None
    M, K, R = sp.csr_array(part.M), sp.csr_array(part.K), part.rigid_modes()
    squares = {a: part.load(Spin(np.eye(3)[a])) for a in range(3)}
    spin = [
        squares[a]
        if a == b
        else part.load(Spin(np.eye(3)[a] + np.eye(3)[b])) - squares[a] - squares[b]
        for a, b in PAIRS
    ]
    n = X.shape[1]
    inertia, elastic = np.asarray(M @ R), np.asarray(M @ X)
    F = np.column_stack([-inertia, *spin, -elastic, *loads.values()])
    if interfaces:
        L = unit_loads(part, interfaces)
        size = np.linalg.norm(R, axis=0)
        held = (R / size).T @ L
        balance, _, rank, _ = np.linalg.lstsq(held, -((R / size).T @ F), rcond=None)
        if rank < 6:
            message = (
                "its interfaces do not stop all rigid motions, which residual stress needs; use"
                " residual_stress=False"
            )
            raise InputError(Problem(f"part '{part.name}'", message))
        balance[:, 12 : 12 + n] = 0.0  # the load is balanced already
        F = F + L @ balance
    F = F - rigid.MR @ (rigid.R.T @ F)
    basis = whole_part_basis(part, K, run)
    static = (X.T @ F) / stiffness[:, None]
    columns = np.empty((len(part.stress.sites), 6, F.shape[1]))
    with run.stage("residual stress") as report:
        for k in range(0, F.shape[1], 8):
            some = slice(k, k + 8)
            u = response(F[:, some], basis, rigid) - X @ static[:, some]
            columns[:, :, some] = part.stress.evaluate(u)
            report("residual stress", min(k + 8, F.shape[1]) / F.shape[1])
    own = tuple(f"mode {j + 1}" for j in range(n))
    return ResidualStress((*ACCELERATIONS, *CENTRIFUGAL, *own, *loads), columns, static)
