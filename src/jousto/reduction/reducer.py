"""`reduce`: from a finite element part to a few modes."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.complexstep import floats, is_stepping, plainly, real_parts
from jousto.base.errors import InputError, NotAnalytic, Problem, Problems, warn
from jousto.base.progress import has_viewer
from jousto.parts.frames.second_order import SecondOrder
from jousto.parts.part import Part
from jousto.parts.solids.stress import SolidStress
from jousto.parts.solids.stress_jumps import place_scatter
from jousto.reduction.complex_step import stepped_modes
from jousto.reduction.fields.invariants import (
    Invariants,
    invariants_from_matrix,
    invariants_from_points,
)
from jousto.reduction.fields.residual_stress import read_loads, residual_stress as rest
from jousto.reduction.fields.stiffening import stiffening as second_order_field
from jousto.reduction.fields.stress import StressModes
from jousto.reduction.files import memory_cache
from jousto.reduction.files.cache import (
    AUTOMATIC,
    Entry,
    NotHashable,
    ReductionCache,
    choose as choose_cache,
    key as content_key,
)
from jousto.reduction.frames.clamp import in_frame, seen_from
from jousto.reduction.frames.frame import AsGiven
from jousto.reduction.methods import CraigBampton, FreeFree, Method, ShapeFunctions
from jousto.reduction.modes import eigen
from jousto.reduction.modes.partition import craig_bampton_basis, whole_part_basis
from jousto.reduction.modes.relief import free_loads, with_residuals
from jousto.reduction.modes.rigid import (
    RigidBasis,
    check_stiffness_is_free,
    length_scale,
    mass_orthonormal_rigid_modes,
)
from jousto.reduction.modes.ritz import ritz
from jousto.reduction.modes.ties import interface_names
from jousto.reduction.reduced import ReducedPart, package_versions
from jousto.reduction.sparse import factor
from jousto.reduction.sparse.memory import check_memory, memory_estimate
from jousto.reduction.stages import Report, Run, reporter

ORTHONORMALITY = 1e-10
"""Largest deviation of the modal mass matrix from the identity."""

REMEMBERED = 30_000
"""Degrees of freedom up to which a reduced part contains the part before reduction."""

STRESS_BLOCK = 8
"""Number of modes per block of the stress computation."""

CONTENT = "with the error of the mesh"
"""Content that older cached parts lack, so that they are computed again."""

HASH_BLOCK = 1 << 20
"""Count of numbers per block of the hash."""


def reduce(
    part: Part,
    method: Method,
    *,
    stiffening: bool = False,
    residual_stress: bool | Mapping[str, ArrayLike] = False,
    solver: str | None = None,
    cache: ReductionCache | Path | str | bool | None = None,
    progress: bool | Report | None = None,
) -> ReducedPart:
    """Reduce a part to its elastic modes, orthonormal and free of rigid-body motion.

    The Craig-Bampton method starts from ``T = [E 0; Phi_C Phi_N]``. The projection ``P = E - R (R^T
    M R)^-1 R^T M`` removes the rigid motions R from T, and the rest is orthonormalised (Rantalainen
    2007, eqs. 3.24-3.36, where the rigid modes are identified by their frequency instead).

    Parameters
    ----------
    part : Part
        The free part.
    method : CraigBampton, FreeFree or ShapeFunctions Choice of the modes.
    stiffening : bool
        Whether forces stiffen or soften the body (geometric stiffness): for fast rotating blades,
        shafts and arms, and members near buckling. For parts of beams or solids only. Off by
        default; the body is then linear as in other programs, and cheaper.
    residual_stress : bool or mapping of str to (ndof,) array
        Whether the stress outside of the modes is computed for `stress_field`. The mapping contains
        loads by name, ``{"tip": part.load(...)}``, in addition to inertia forces; interfaces react
        to the loads. For slowly changing loads the stress of few modes then equals that of the
        mesh, at the cost of one more factorisation.
    solver : str, optional
        Library that factorises the stiffness matrix, see `solvers`; None for the best installed
        one. With a given library, cached results of other libraries are not used.
    cache : ReductionCache, path or bool, optional
        Cache of the result and of finished stages, after which an interrupted reduction continues.
        True for the cache folder of the user, False for no cache; by default parts of 30,000
        degrees of freedom and more are cached.
    progress : bool or function, optional
        True shows a bar for each stage, False none; a function is called with the stage and its
        finished fraction from 0 to 1. By default parts of 30,000 degrees of freedom and more show
        bars on a terminal and in a notebook.

    Returns
    -------
    ReducedPart
        Modes by ascending frequency, mass-normalised, with invariants and modal stress.

    Raises
    ------
    InputError
        If the stiffness matrix has supports or further free motions, all mass lies on a line, an
        interface is unknown or does not stop all rigid motions, there are fewer modes than
        requested, the solver is unknown or missing, or stiffening is requested for a part from
        matrices.
    """
    body: object = part
    if not isinstance(body, Part):
        message = f"part is {body!r}, must be a Part such as Part.beam(...)"
        raise InputError(Problem("reduce", message))
    where = f"part '{part.name}'"
    given: object = method
    if not isinstance(given, (CraigBampton, FreeFree, ShapeFunctions)):
        message = (
            f"method is {given!r}, must be CraigBampton(...), FreeFree(...) or ShapeFunctions(...)"
        )
        raise InputError(Problem(where, message))
    if solver is not None:
        factor.choose(part.K.shape[0], where, solver)
    if is_stepping() and (plain := real_parts(part)) is not part:
        more: dict[str, Any] = {"stiffening": stiffening, "residual_stress": residual_stress}
        with plainly():
            kept = reduce(plain, method, solver=solver, cache=cache, **more)
        return _stepped(part, plain, kept, method, more)
    loads = read_loads(part, residual_stress)
    options = (stiffening, solver, *(() if loads is None else ("residual stress", loads)))

    def make() -> ReducedPart:
        return _kept(part, method, options, loads, choose_cache(cache, part.K.shape[0]), progress)

    memory = memory_cache.current()
    return make() if memory is None else memory.get((part, method, *options), make)


def _stepped(
    part: Part, plain: Part, kept: ReducedPart, method: Method, options: Mapping[str, Any]
) -> ReducedPart:
    """Return the reduction of a part with derivatives; `kept` is that of its real parts."""
    if options["residual_stress"]:
        raise NotAnalytic("the stress outside of the modes is computed")
    if method.frame is not None:
        raise NotAnalytic("the frame is not that of the mean axes")
    X, frequencies = stepped_modes(part, plain, kept, method)
    made = _assemble(part, X, frequencies, kept.interfaces, repr(method), Run())
    if options["stiffening"]:
        made = replace(made, stiffening=second_order_field(part, X))
    return made


def _kept(
    part: Part,
    method: Method,
    options: tuple[Any, ...],
    loads: dict[str, Array] | None,
    chosen: ReductionCache | None,
    progress: Any,
) -> ReducedPart:
    """Return the reduced part, from the cache if it contains the part."""
    where = f"part '{part.name}'"
    stiffening, solver = options[:2]
    if progress is None:
        progress = part.K.shape[0] >= AUTOMATIC and has_viewer()
    with reporter(progress) as report:
        entry = None if chosen is None else _entry(chosen, part, method, options)
        if entry is not None and (finished := entry.finished()) is not None:
            return remembered(finished, part)
        estimate = memory_estimate(part, method, stiffening=stiffening, solver=solver)
        logging.getLogger(__name__).info("%s: %s", where, estimate)
        check_memory(estimate, where)
        run = Run(solver, report, entry)
        reduced = _reduced(part, method, stiffening, loads, run)
        if entry is not None:
            entry.finish(reduced)
    return remembered(reduced, part)


def remembered(reduced: ReducedPart, part: Part) -> ReducedPart:
    """Return the reduced part with a reference to its unreduced part, unless that is large."""
    return replace(reduced, source=part if part.K.shape[0] <= REMEMBERED else None)


def _entry(
    cache: ReductionCache, part: Part, method: Method, options: tuple[object, ...]
) -> Entry | None:
    try:
        return cache.entry(content_key(part, method, *options, CONTENT, package_versions()))
    except NotHashable as error:
        logging.getLogger(__name__).info("the reduction is not cached: it depends on a %s", error)
        return None


def _reduced(
    part: Part, method: Method, stiffening: bool, loads: dict[str, Array] | None, run: Run
) -> ReducedPart:
    where = f"part '{part.name}'"
    M, K = sp.csr_array(part.M), sp.csr_array(part.K)
    with run.stage("checks"):
        check_stiffness_is_free(K, part.nodes, part.dofs_per_node, where)
        rigid = mass_orthonormal_rigid_modes(M, part.nodes, part.dofs_per_node, where)
    interfaces = method.interfaces
    if isinstance(method, CraigBampton):
        interfaces = interface_names(part, interfaces)
    kept = run.found("modes")
    if kept is None:
        mu, X = _modes(part, M, K, method, rigid, run)
        run.keep("modes", mu=mu, modes=X)
    else:
        mu, X = kept["mu"], kept["modes"]
    frequencies = 1.0 / (2.0 * np.pi * np.sqrt(mu))
    reduced = _assemble(part, X, frequencies, interfaces, repr(method), run)
    if loads is not None and reduced.stress is not None:
        residual = rest(part, X, 1.0 / mu, interfaces, rigid, loads, run)
        reduced = replace(reduced, stress=replace(reduced.stress, residual=residual))
    if stiffening:
        with run.stage("stiffening"):
            reduced = replace(reduced, stiffening=second_order_field(part, X))
    if isinstance(method, ShapeFunctions) and isinstance(method.frame, AsGiven):
        basis = ritz(part, K, rigid, method.functions)
        own = np.linalg.lstsq(part.rigid_modes(), rigid.R)[0]
        implied: Array = own @ basis.G @ (basis.Q.T @ np.asarray(K @ X))
        return seen_from(reduced, -implied[:3], -implied[3:], method.frame)
    return reduced if method.frame is None else in_frame(reduced, method.frame)


def _modes(
    part: Part, M: sp.csr_array, K: sp.csr_array, method: Method, rigid: RigidBasis, run: Run
) -> tuple[Array, Array]:
    """Return ``1 / omega^2`` and the elastic modes, mass-normalised."""
    where = f"part '{part.name}'"
    wanted: int | None
    limit: float | None
    if isinstance(method, ShapeFunctions):
        with run.stage("shape functions"):
            basis = _spanned(ritz(part, K, rigid, method.functions).Q)
        wanted, limit, stage = basis.size, None, "orthonormalisation"
    elif isinstance(method, CraigBampton):
        basis = craig_bampton_basis(part, M, K, method, run)
        wanted, limit, stage = basis.size, None, "orthonormalisation"
    else:
        basis = whole_part_basis(part, K, run)
        wanted, limit, stage = method.modes, method.frequency_limit, "free-free modes"
    # the basis is fixed at six degrees of freedom; remove the rigid motion that this adds
    # (P^T M P = M P, so that lower needs no projection)
    elastic = replace(basis, lift=lambda y: rigid.remove(basis.lift(y)))
    with run.stage(stage) as report:
        mu, X = np.zeros(0), np.zeros((M.shape[0], 0))
        if wanted != 0:
            mu, X = eigen.spectrum(
                elastic,
                M,
                modes=wanted,
                frequency_limit=limit,
                where=where,
                report=lambda done: report(stage, done),
                massless=not isinstance(method, FreeFree),
            )
            mu, X = _unique(part, mu, X, M)
        if not isinstance(method, CraigBampton):
            mu, X = _selected(part, mu, X, method)
            loads = free_loads(part, method)
            if loads.shape[1]:
                if isinstance(method, ShapeFunctions):
                    free = whole_part_basis(part, K, run)
                    elastic = replace(free, lift=lambda y: rigid.remove(free.lift(y)))
                Y = with_residuals(X, loads, elastic, rigid, K)
                mu, X = eigen.spectrum(
                    _spanned(Y),
                    M,
                    modes=Y.shape[1],
                    frequency_limit=None,
                    where=where,
                    massless=True,
                )
                mu, X = _unique(part, mu, X, M)
        if not len(mu):
            message = (
                "the method has no elastic mode: ask for more modes, or use a RigidBody with "
                "the mass and inertia of the part"
            )
            raise eigen.MissingModesError(Problem(where, message))
        moving = mu > 0.0
        mu = np.where(moving, mu, eigen.STAND_IN * mu[0])
        X = X / np.sqrt(mu)
        _check_orthonormal(X[:, moving], M, where)
        # static shapes without mass are inserted among the modes, whose order is kept
        after = np.sum(mu[moving] > eigen.STAND_IN * mu[0]) - 0.5
        order = np.argsort(np.where(moving, np.arange(len(mu)), after), kind="stable")
    return mu[order], X[:, order]


def _spanned(Y: Array) -> eigen.Flexibility:
    """Return the body spanned by vectors that have unit stiffness."""
    n = Y.shape[1]
    return eigen.Flexibility(n, lambda y: Y @ y, lambda f: Y.T @ f, np.eye(n), None)


def _selected(
    part: Part, mu: Array, X: Array, method: FreeFree | ShapeFunctions
) -> tuple[Array, Array]:
    """Return the modes selected by the limits of the method."""
    if method.modes is None and method.frequency_limit is None:
        return mu, X
    kind = "free-free" if isinstance(method, FreeFree) else "shape functions'"
    where = f"part '{part.name}'"
    return eigen.select(mu, X, method.modes, method.frequency_limit, kind, where)


def _unique(part: Part, mu: Array, X: Array, M: sp.csr_array) -> tuple[Array, Array]:
    """Return modes whose signs and, at equal frequencies, shapes do not depend on the solver."""
    d, length = part.dofs_per_node, length_scale(part.nodes)
    k = int(np.sum(mu > 0.0))
    moving, modes = eigen.canonical(mu[:k], X[:, :k], M, d, length)
    if k == len(mu):
        return moving, modes
    still = eigen.settled(X[:, k:], d, length)
    return np.append(moving, mu[k:]), np.concatenate([modes, still], axis=1)


def _check_orthonormal(X: Array, M: sp.csr_array, where: str) -> None:
    error = np.abs(X.T @ (M @ X) - np.eye(X.shape[1]))
    if np.all(error < ORTHONORMALITY):
        return
    # modes with almost no mass: products of large numbers cancel
    rounding = 100.0 * np.finfo(float).eps * (np.abs(X).T @ (abs(M) @ np.abs(X)))
    if not np.all(error < ORTHONORMALITY + rounding):
        message = (
            f"the modes could not be made orthonormal (error {error.max():.1e}): the matrices are "
            "too ill-conditioned; ask for fewer modes and check units and element sizes"
        )
        raise InputError(Problem(where, message))


@explained
def from_modes(part: Part, modes: ArrayLike, frequencies: ArrayLike) -> ReducedPart:
    """Return a reduced part with given mode shapes, such as mode shapes of a printed table.

    The modal mass matrix is taken as the identity, independent of the digits of the table; unknown
    degrees of freedom may be zero.

    Parameters
    ----------
    part : Part
        Part with nodes, mass and stress.
    modes : (ndof, n) array
        Mode shapes, mass-normalised, in the part's order of degrees of freedom.
    frequencies : (n,) array
        Hz.

    Raises
    ------
    InputError
        If shapes or values are wrong.

    Warns
    -----
    JoustoWarning
        If the modes are not mass-orthonormal within 1e-3.
    """
    where = f"part '{part.name}'"
    problems = Problems()
    M = sp.csr_array(part.M)
    f = problems.array(where, "frequencies", frequencies, (None,))
    n = None if f is None else len(f)
    X = problems.array(where, "modes", modes, (M.shape[0], n))
    problems.raise_if_any()
    assert X is not None and f is not None
    error = np.abs(X.T @ (M @ X) - np.eye(X.shape[1]))
    if error.max(initial=0.0) > 1e-3:
        i, j = np.unravel_index(int(error.argmax()), error.shape)
        warn(
            where,
            f"the given modes are not mass-orthonormal: mode {i}^T M mode {j} is off by "
            f"{error[i, j]:.2g} (limit 1e-3); the modal mass matrix is taken as the identity. "
            "Check units and the order of degrees of freedom",
        )
    return _assemble(part, X, f, (), "given mode shapes", Run())


def _assemble(
    part: Part,
    X: Array,
    frequencies: Array,
    interfaces: tuple[str, ...],
    method: str,
    run: Run,
) -> ReducedPart:
    nn, n = len(part.nodes), X.shape[1]
    vectors = X.reshape(nn, part.dofs_per_node, n)
    with run.stage("invariants"):
        integrals = invariants(part, X)
    nodes, modes = part.nodes, vectors[:, :3]
    rotations = vectors[:, 3:] if part.dofs_per_node == 6 else None
    turning = None
    if part.ties:
        # the reference nodes move with the nodes tied to them
        q = np.stack([tie.averaging @ X[tie.dofs] for tie in part.ties])
        nodes = np.concatenate([nodes, [tie.at for tie in part.ties]])
        modes = np.concatenate([modes, q[:, :3]])
        if rotations is None:
            rotations, turning = q[:, 3:], nn + np.arange(len(part.ties))
        else:
            rotations = np.concatenate([rotations, q[:, 3:]])
    second = part.second_order
    return ReducedPart(
        name=part.name,
        nodes=nodes,
        elements=part.elements,
        node_sets=_sets(part),
        modes=modes,
        rotations=rotations,
        rotation_nodes=turning,
        frequencies=frequencies,
        invariants=integrals,
        stress=_stress(part, X, frequencies, run),
        interfaces=interfaces,
        provenance=_provenance(part, method, run),
        faces=tuple(part.faces),
        beams=second.beams if isinstance(second, SecondOrder) else None,
        outlines=part.outlines,
    )


def _sets(part: Part) -> dict[str, tuple[int, ...]]:
    """Return the node sets, and the reference node of each tie under the name of the tie."""
    sets = dict(part.node_sets)
    for number, tie in enumerate(part.ties):
        sets.setdefault(f"{tie.name}.nodes", tuple(int(i) for i in tie.nodes))
        sets[tie.name] = (len(part.nodes) + number,)
    return sets


def invariants(part: Part, X: ArrayLike) -> Invariants:
    """Return the inertia invariants of mode shapes (ndof, n) of a part.

    The invariants are computed from the mass points of the part or, without them, from bilinear
    forms of its mass matrix; rigid masses attached to a consistent mass matrix are treated as
    points.
    """
    modes = floats(X)
    if part.mass_points is not None:
        return invariants_from_points(part.mass_points, modes)
    M = sp.csr_array(part.M)
    if part.attached is None:
        return invariants_from_matrix(M, part.nodes, part.dofs_per_node, modes)
    elements = sp.csr_array(M - part.attached.matrix())
    own = invariants_from_matrix(elements, part.nodes, part.dofs_per_node, modes)
    return own + invariants_from_points(part.attached, modes)


def _stress(part: Part, X: Array, frequencies: Array, run: Run) -> StressModes | None:
    if part.stress is None:
        return None
    s = part.stress
    modes = np.empty((len(s.sites), 6, X.shape[1]), X.dtype)
    with run.stage("stress modes") as report:
        # a few modes at a time, to limit the memory of element arrays
        for k in range(0, X.shape[1], STRESS_BLOCK):
            some = slice(k, k + STRESS_BLOCK)
            modes[:, :, some] = s.evaluate(X[:, some])
            report("stress modes", min(k + STRESS_BLOCK, X.shape[1]) / X.shape[1])
    scatter = None
    if isinstance(s, SolidStress) and not np.iscomplexobj(X):
        with run.stage("error of the mesh"):
            # modes of low frequency have the larger amplitudes, p = f / W2
            scatter = place_scatter(s, X, modes, (frequencies / frequencies.min()) ** -2.0)
    return StressModes(
        tuple(s.sites), s.positions, s.axes, modes, s.elasticity, s.compliance, scatter=scatter
    )


def _provenance(part: Part, method: str, run: Run) -> dict[str, str]:
    if is_stepping():
        return {"method": method}
    solver = {"solver": run.used} if run.used else {}
    return {"method": method, "input": content_hash(part), **solver, **package_versions()}


def content_hash(part: Part) -> str:
    """Return a hash of the input of a reduction: nodes, M, K and ties."""
    digest = hashlib.sha256()
    digest.update(f"{part.dofs_per_node}".encode())
    digest.update(np.ascontiguousarray(part.nodes, dtype="<f8").tobytes())
    for matrix in (part.M, part.K):
        csr = sp.csr_array(matrix)
        if not csr.has_canonical_format:
            csr = csr.copy()
            csr.sum_duplicates()
        # block by block, to avoid copies of large matrices
        for array, kind in ((csr.indptr, "<i8"), (csr.indices, "<i8"), (csr.data, "<f8")):
            for start in range(0, len(array), HASH_BLOCK):
                digest.update(array[start : start + HASH_BLOCK].astype(kind).data)
    for tie in part.ties:
        digest.update(f"{tie.name} {tie.kind}".encode())
        for values in (tie.nodes, tie.at, tie.averaging):
            digest.update(np.ascontiguousarray(values).tobytes())
    return "sha256:" + digest.hexdigest()
