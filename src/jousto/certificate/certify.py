"""certify: the full model, the checks and the table of facts of a certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.certificate import (
    comparison,
    interface_loads,
    interface_modes,
    part_checks as inspection,
    vibration,
)
from jousto.certificate.certificate import (
    Certificate,
    Check,
    Silhouette,
    Table,
    number,
    vector,
)
from jousto.certificate.mesh_accuracy import mesh_accuracy
from jousto.certificate.mesh_checks import mesh_checks, mesh_facts
from jousto.certificate.part_checks import FullModel, fault_of
from jousto.reduction.frames.clamp import by_mean_axes
from jousto.reduction.modes import eigen
from jousto.reduction.modes.partition import whole_part_basis
from jousto.reduction.modes.rigid import (
    RigidBasis,
    length_scale,
    mass_orthonormal_rigid_modes,
    mass_properties,
)
from jousto.reduction.stages import Report, Run, reporter

if TYPE_CHECKING:
    from jousto.parts.interface import Tie
    from jousto.parts.part import Part
    from jousto.reduction.reduced import ReducedPart


FREE_MODES = 10
"""Number of compared free-free frequencies."""


def certify(
    part: Part,
    reduced: ReducedPart | None = None,
    *,
    solver: str | None = None,
    progress: bool | Report | None = None,
) -> Certificate:
    """Return the certificate of a part and its modes: passed checks, doubtful points, remedies.

    The certificate contains mass, centre, inertia and size; the strain energy of the six rigid
    motions; plausibility of SI units; missing data (rotary inertia, loose nodes, mechanisms,
    stress); and checks of the mesh. For the reduced part it also contains: whether it belongs to
    this part, how well its interfaces fix it, its free-free frequencies and its response to all
    interface loads in comparison with the full model, and its modal effective mass.

    Parameters
    ----------
    part : Part
        The free part.
    reduced : ReducedPart, optional
        Its modes, from `reduce`; None to check the part only.
    solver : str, optional
        Library of the factorisation, see `solvers`.
    progress : bool or function, optional
        True shows a bar for each stage; a function is called with (stage, finished fraction of it,
        0 to 1).

    Returns
    -------
    Certificate

    Raises
    ------
    InputError
        If the arguments are no part and reduced part, or have different nodes.

    Examples
    --------
    >>> import jousto as jo
    >>> steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    >>> rod = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 10, steel, name="rod")
    >>> certificate = certify(rod, jo.reduce(rod, jo.CraigBampton(("start", "end"), modes=6)))
    >>> certificate.passed
    True
    >>> print(certificate["static loads"].sentence)
    each of 12 interface loads deforms the reduced part like the full model
    """
    _check_arguments(part, reduced)
    if reduced is not None:
        reduced = by_mean_axes(reduced)
    with reporter(progress) as report:
        return _examine(part, reduced, Run(solver, report))


def _examine(part: Part, reduced: ReducedPart | None, run: Run) -> Certificate:
    checks: list[Check] = []
    tables: list[Table] = []
    full, faults = full_model(part, run=run)
    if full is None:
        checks.append(
            Check("mass", "fail", "not positive", "", faults["mass"], "write the whole mass matrix")
        )
        return Certificate(part.name, _facts(part, None, reduced), tuple(checks), (), _shape(part))

    check, table = inspection.rigid_motions(full)
    checks.append(check)
    tables.append(table)
    checks.append(inspection.units(full))
    checks.append(inspection.rotary_inertia(full))
    checks.append(inspection.loose_nodes(full))
    checks.append(inspection.mechanisms(full, faults.get("held", "")))
    about_mesh, worst = mesh_checks(part)
    checks += about_mesh
    tables += worst
    checks.append(inspection.content(full))
    modes = None
    if reduced is not None:
        modes = interface_modes.modes_of(full, reduced)
        checks.append(_same_part(part, reduced))
        checks.append(comparison.orthonormality(full, modes))
        checks.append(comparison.hold(full, modes))
        condition = comparison.conditioning(full, modes)
        if condition is not None:
            checks.append(condition)
        for found in (vibration.frequencies(full, modes), vibration.effective_mass(full, modes)):
            if found is not None:
                checks.append(found[0])
                tables += [found[1]] if found[1] is not None else []
        with run.stage("static loads"):
            static = interface_loads.static_loads(full, modes)
        if static is not None:
            checks += static[0]
            tables.append(static[1])
    with run.stage("mesh error"):
        accuracy = mesh_accuracy(full, modes)
    if accuracy is not None:
        checks.append(accuracy[0])
        tables.append(accuracy[1])
    facts = _facts(part, full, reduced)
    return Certificate(part.name, facts, tuple(checks), tuple(tables), _shape(part, reduced))


def _check_arguments(part: object, reduced: object) -> None:
    from jousto.parts.part import Part
    from jousto.reduction.reduced import ReducedPart

    if not isinstance(part, Part):
        message = f"part is {part!r}, must be a Part such as Part.beam(...)"
        raise InputError(Problem("certify", message))
    if reduced is not None and not isinstance(reduced, ReducedPart):
        message = f"reduced is {reduced!r}, must be a ReducedPart, the result of reduce(part, ...)"
        raise InputError(Problem("certify", message))
    if reduced is None:
        return
    nn = len(part.nodes)
    known = len(reduced.nodes) in (nn, nn + len(part.ties))
    if not known or (part.dofs_per_node == 6 and reduced.rotations is None):
        raise InputError(
            Problem(
                "certify",
                f"reduced part '{reduced.name}' has {len(reduced.nodes)} nodes, part "
                f"'{part.name}' has {nn}: give the part that was reduced",
            )
        )


def full_model(
    part: Part, modes: int = FREE_MODES, run: Run | None = None
) -> tuple[FullModel | None, dict[str, str]]:
    """Return the full model (None without mass), and messages about impossible steps."""
    where, run = f"part '{part.name}'", run or Run()
    faults: dict[str, str] = {}
    M, K = sp.csr_array(part.M), sp.csr_array(part.K)
    d = part.dofs_per_node
    try:
        mass, centre, J = mass_properties(M, part.nodes, d, where)
    except InputError as error:
        return None, {"mass": fault_of(error)}
    rigid, held = None, None
    f, shapes = np.zeros(0), np.zeros((K.shape[0], 0))
    try:
        rigid = mass_orthonormal_rigid_modes(M, part.nodes, d, where)
    except InputError as error:
        faults["inertia"] = fault_of(error)
    try:
        held = whole_part_basis(part, K, run)
    except InputError as error:
        faults["held"] = fault_of(error)
    if modes and rigid is not None and held is not None:
        with run.stage("full model's modes") as report:
            f, shapes = _free_modes(M, rigid, held, modes, where, report)
    return FullModel(
        part, M, K, part.nodes, d, length_scale(part.nodes), mass, centre, J, rigid, held, f, shapes
    ), faults


def _free_modes(
    M: sp.csr_array,
    rigid: RigidBasis,
    held: eigen.Flexibility,
    modes: int,
    where: str,
    report: Report,
) -> tuple[Array, Array]:
    from dataclasses import replace

    elastic = replace(held, lift=lambda y: rigid.remove(held.lift(y)))
    try:
        mu, X = eigen.spectrum(
            elastic,
            M,
            modes=modes,
            frequency_limit=None,
            where=where,
            report=lambda done: report("full model's modes", done),
        )
    except InputError:
        return np.zeros(0), np.zeros((M.shape[0], 0))
    mu, X = mu[:modes], X[:, :modes]
    return 1.0 / (2.0 * np.pi * np.sqrt(mu)), X / np.sqrt(mu)


def _same_part(part: Part, reduced: ReducedPart) -> Check:
    from jousto.reduction.reducer import content_hash

    recorded = reduced.provenance.get("input", "")
    own = content_hash(part)
    value = own.removeprefix("sha256:")[:12]
    if recorded == own:
        return Check(
            "input", "ok", value, "", "the modes were computed from exactly these matrices"
        )
    return Check(
        "input",
        "fail" if recorded else "note",
        value,
        f"recorded {recorded.removeprefix('sha256:')[:12] or 'nothing'}",
        "the modes were computed from other nodes or matrices",
        "reduce this part again",
    )


def _facts(
    part: Part, full: FullModel | None, reduced: ReducedPart | None
) -> tuple[tuple[str, str], ...]:
    extent = 1e3 * np.ptp(part.nodes, axis=0)
    facts = [("bounding size", f"{' x '.join(number(x, 6) for x in extent)} mm (of the nodes)")]
    if full is not None:
        J = full.inertia
        moments = np.linalg.eigvalsh(J)
        facts = [
            ("mass", f"{number(full.mass, 6)} kg"),
            ("centre", f"{vector(1e3 * full.centre, size=1e4 * full.length)} mm"),
            ("inertia about it", f"xx yy zz {vector(np.diag(J))} kg m2"),
            ("", f"xy yz zx {vector(_products(J, float(moments[-1])))} kg m2"),
            ("principal moments", f"{vector(moments)} kg m2"),
            *facts,
        ]
    facts += mesh_facts(part)
    ndof = part.K.shape[0]
    facts.append(
        (
            "finite element model",
            f"{len(part.nodes)} nodes, {_elements(part)} elements, {ndof} degrees of freedom",
        )
    )
    if reduced is not None:
        f = reduced.frequencies
        facts.append(("reduced to", f"{reduced.n} modes, {number(f[0])} to {number(f[-1])} Hz"))
        ties = {tie.name: tie for tie in part.ties}
        texts = [
            _interface(name, ties.get(name), length_scale(part.nodes))
            for name in reduced.interfaces
        ]
        facts.append(("interfaces", "; ".join(texts) or "none"))
        if "method" in reduced.provenance:
            held = f"interfaces={reduced.interfaces}"
            text = str(reduced.provenance["method"]).replace("interfaces=()", held)
            facts.append(("method", text))
    return tuple(facts)


def _interface(name: str, tie: Tie | None, length: float) -> str:
    if tie is None:
        return name
    at = vector(1e3 * tie.at, size=1e3 * length)
    return f"{name} ({tie.kind} tie of {len(tie.nodes)} nodes about {at} mm)"


def _elements(part: Part) -> int:
    """Return the number of elements; for solids, `elements` contains the surface only."""
    if part.solids is not None:
        return sum(len(group.nodes) for group in part.solids.groups)
    return len(part.elements)


def _products(J: Array, largest: float) -> Array:
    products = np.array([J[0, 1], J[1, 2], J[2, 0]])
    return np.where(np.abs(products) <= 1e-12 * largest, 0.0, products)


def _shape(part: Part, reduced: ReducedPart | None = None) -> Silhouette:
    """Return the drawing of a part: its surface, or the edges of its elements."""
    elements = np.asarray(part.elements, dtype=np.int64)
    empty = np.zeros((0, 3), dtype=np.int64)
    columns = elements.shape[1] if elements.size else 0
    lines = elements if columns == 2 else empty[:, :2]
    triangles = elements if columns == 3 else empty
    ties = {tie.name: tuple(int(i) for i in tie.nodes) for tie in part.ties}
    known = {**part.node_sets, **ties}
    names = tuple(ties) if reduced is None else reduced.interfaces
    sets = tuple((name, tuple(known[name])) for name in names if name in known)
    return Silhouette(part.nodes, lines, triangles, sets)
