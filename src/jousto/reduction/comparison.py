"""Checks of a reduced part against the full model: parts of the certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.errors import count
from jousto.reduction.certificate import Check, Table, number
from jousto.reduction.inspection import FullModel
from jousto.reduction.rigid import rigid_modes

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart

Array = NDArray[np.float64]
Index = NDArray[np.intp]

CLOSE = 0.01
"""Relative error of a frequency that counts as good."""

SHARE = 0.95
"""Least share of a mode of the full model that the reduced part must hold."""

ORTHONORMAL = 1e-5
"""Largest deviation of the modal matrices from their diagonal."""

EXACT = 1e-8
"""Relative error of a static displacement that counts as exact."""

MOST_LOADS = 60
"""Interface loads that are solved; more are sampled evenly."""

MANY_DOFS = 120
"""Degrees of freedom of all interfaces above which a tie to one node is better."""

HOLD = (1e-6, 1e-3)
"""Least independent motion of an interface over the size of the body: to fail, to warn."""

MASS_SHARE = 0.8
"""Share of the mass that vibrates with the fixed modes in a direction, of a part well covered."""

LOADS = ("fx", "fy", "fz", "mx", "my", "mz")

CONDITION = (1e8, 1e12)
"""Condition number of the flexibility of the interfaces: to warn, and not to count at all."""


@dataclass(frozen=True, eq=False)
class Modes:
    """The modes of a reduced part on the degrees of freedom of the full model.

    Parameters
    ----------
    reduced : ReducedPart
    X : (ndof, n) array
        Mass-normalised modes.
    loads : (ndof, nb) sparse array
        Nodal loads of unit forces and moments on the interfaces; ``loads^T u`` is how these move.
    names : tuple of str
        A name for each load, such as ``end fy``.
    weights : (nb,) array
        1 for forces, the size of the body for moments.
    interfaces : tuple of (str, (k,) int array)
        Names of the interfaces and numbers of their loads.
    """

    reduced: ReducedPart
    X: Array
    loads: sp.csc_array
    names: tuple[str, ...]
    weights: Array
    interfaces: tuple[tuple[str, Index], ...]

    def moved(self, u: Array) -> Array:
        """Return how the interfaces move, (nb, m), rotations times the size of the body."""
        return np.asarray((self.loads.T @ u) * self.weights[:, None])


def modes_of(full: FullModel, reduced: ReducedPart) -> Modes:
    """Return the modes of a reduced part and the loads of its interfaces.

    The load on the node to which a surface is tied spreads over the surface by the transpose of
    the average that gives its motion.
    """
    part, d = full.part, full.dofs
    nn = len(part.nodes)
    blocks = [reduced.modes[:nn]]
    if d == 6 and reduced.rotations is not None:
        blocks.append(reduced.rotations[:nn])
    X = np.concatenate(blocks, axis=1).reshape(-1, reduced.n)
    ties = {tie.name: tie for tie in part.ties}
    columns: list[Any] = []
    names: list[str] = []
    kinds: list[int] = []
    interfaces = []
    for name in reduced.interfaces:
        first = len(names)
        if name in ties:
            tie = ties[name]
            rows, unit = tie.dofs, tie.averaging.T
            names += [f"{name} {load}" for load in LOADS]
            kinds += range(6)
        else:
            members = part.node_sets[name]
            rows = (d * np.array(members)[:, None] + np.arange(d)).ravel()
            unit = np.eye(len(rows))
            for node in members:
                place = name if len(members) == 1 else f"{name} (node{node + 1})"
                names += [f"{place} {load}" for load in LOADS[:d]]
                kinds += range(d)
        i, j = np.nonzero(unit)
        shape = (X.shape[0], unit.shape[1])
        columns.append(sp.coo_array((unit[i, j], (rows[i], j)), shape=shape))
        interfaces.append((name, np.arange(first, len(names))))
    loads = sp.csc_array(sp.hstack(columns)) if columns else sp.csc_array((X.shape[0], 0))
    weights = np.where(np.array(kinds) < 3, 1.0, full.length)
    return Modes(reduced, X, loads, tuple(names), weights, tuple(interfaces))


def _determinate(P: Array) -> Index | None:
    """Return six loads, rows of their work in rigid motions (nb, 6), that hold the body."""
    if len(P) < 6:
        return None
    r, pivots = scipy.linalg.qr(P.T, mode="r", pivoting=True)
    if abs(r[5, 5]) < HOLD[0] * abs(r[0, 0]):
        return None
    return np.asarray(np.sort(pivots[:6]), dtype=np.intp)


def _rigid(full: FullModel) -> Array:
    """Return rigid motions about the middle, rotations over the size of the body."""
    R = rigid_modes(full.nodes, full.dofs, full.nodes.mean(axis=0))
    R[:, 3:] /= full.length
    return R


def orthonormality(full: FullModel, modes: Modes) -> Check:
    """Return whether the modes are those of M and K: orthonormal, diagonal, without rigid part."""
    X = modes.X
    mass = np.abs(X.T @ (full.M @ X) - np.eye(X.shape[1])).max()
    omega = 2.0 * np.pi * modes.reduced.frequencies
    stiff = X.T @ (full.K @ X) / np.multiply.outer(omega, omega)
    stiff = np.abs(stiff - np.eye(len(omega))).max()
    rigid = 0.0 if full.rigid is None else np.abs(full.rigid.MR.T @ X).max()
    worst = float(max(mass, stiff, rigid))
    value = f"{number(mass, 2)} mass, {number(stiff, 2)} stiffness, {number(rigid, 2)} rigid part"
    limit = f"below {ORTHONORMAL:g}"
    if worst < ORTHONORMAL:
        sentence = "the modes are orthonormal and free of rigid motion"
        return Check("modes", "ok", value, limit, sentence)
    status: Any = "warn" if worst < 1e-3 else "fail"
    return Check(
        "modes",
        status,
        value,
        limit,
        "the modes are not the orthonormal modes of this mass and stiffness matrix",
        "reduce this part again; give printed mode shapes all the digits there are",
    )


def hold(full: FullModel, modes: Modes) -> Check:
    """Return how well each interface holds the body, and how large it is."""
    topic = "interfaces"
    if not modes.interfaces:
        return Check(
            topic,
            "note",
            "none",
            "",
            "the modes are those of a body that nothing holds: near joints they converge slowly",
            "use CraigBampton with the nodes where joints and forces act",
        )
    P = modes.moved(_rigid(full))
    nb = len(P)
    least = []
    ties = {tie.name: tie for tie in full.part.ties}
    for name, rows in modes.interfaces:
        s = np.linalg.svd(P[rows], compute_uv=False)
        # over the norm of one node, so that many nodes do not look stiffer
        norm = max(np.sqrt(len(rows) / full.dofs), 1.0)
        own = ties[name].conditioning if name in ties else 1.0
        least.append((min(float(s[5] / norm), own) if len(s) > 5 else 0.0, name))
    value = ", ".join(f"{name} {number(s, 2)}" for s, name in least)
    limit = f"hold every rigid motion by more than {HOLD[1]:g}"
    if nb > MANY_DOFS:
        return Check(
            topic,
            "warn",
            f"{count(nb, 'degree')} of freedom",
            f"at most {MANY_DOFS}",
            "each interface degree of freedom costs one mode, and most of them are of very high "
            "frequency, which makes steps small",
            "tie the nodes of the surface to one node, rigidly or on average",
        )
    if _determinate(P) is None:
        return Check(
            topic,
            "fail",
            value,
            limit,
            "the interfaces together do not hold the body",
            "add interface nodes that are not on one line",
        )
    weak = [name for s, name in least if s < HOLD[1]]
    if weak and weak[0] in ties:
        return Check(
            topic,
            "warn",
            value,
            limit,
            f"the nodes tied to '{weak[0]}' lie almost on a line or far from its reference point: "
            "moments there strain the part without bounds",
            "tie a wider surface or move the reference point",
        )
    if weak:
        if full.dofs == 3:
            reason = "its nodes do not turn and are few, on one line or very close to one another"
            remedy = "tie the surface of the joint to one node that turns"
        else:
            reason = "it has too few nodes"
            remedy = "add nodes to it"
        status: Any = "note" if full.dofs == 3 and len(modes.interfaces) > 1 else "warn"
        return Check(
            topic,
            status,
            value,
            limit,
            f"'{weak[0]}' alone cannot transmit every moment: {reason}",
            f"fine for joints that transmit forces only; otherwise {remedy}",
        )
    return Check(topic, "ok", value, limit, "every interface can transmit all forces and moments")


def conditioning(full: FullModel, modes: Modes) -> Check | None:
    """Return the condition number of the elastic flexibility of the interfaces."""
    # one interface node, or supports that are just determinate, have no flexibility of their own
    rank = len(modes.names) - 6
    if rank < 1 or len(modes.names) > 6 * MANY_DOFS:
        return None
    C = modes.moved(modes.X) / (2.0 * np.pi * modes.reduced.frequencies)
    values = np.linalg.svd(C, compute_uv=False) ** 2
    value = float(values[0] / max(values[min(rank, len(values)) - 1], np.finfo(float).tiny))
    text, limit = number(value, 2), f"below {CONDITION[0]:.0e}"
    topic = "conditioning"
    moved = int(np.sum(values > values[0] / CONDITION[1]))
    if moved < rank:
        return Check(
            topic,
            "warn",
            f"{moved} of {rank} motions",
            "all",
            "the modes do not move the interfaces in all ways they can move",
            "keep all modes of the reduction, unless a plane motion is meant; tie interface nodes "
            "that lie close together to one node",
        )
    if value > CONDITION[0]:
        return Check(
            topic,
            "warn",
            text,
            limit,
            "some motion of the interfaces is far stiffer than others, digits are lost in it",
            "tie interface nodes that lie close together to one node",
        )
    return Check(topic, "ok", text, limit, "the interfaces move in all ways without loss of digits")


def frequencies(full: FullModel, modes: Modes) -> tuple[Check, Table] | None:
    """Return the free-free frequencies of the reduced part beside those of the full model."""
    f = full.frequencies
    if not len(f):
        return None
    overlap = (modes.X.T @ (full.M @ full.shapes)) ** 2
    held = overlap.sum(axis=0)
    best = overlap.argmax(axis=0)
    error = modes.reduced.frequencies[best] / f - 1.0
    rows = tuple(
        (
            str(k + 1),
            number(f[k], 6),
            number(modes.reduced.frequencies[best[k]], 6) if held[k] > 0.3 else "-",
            _percent(error[k]) if held[k] > 0.3 else "-",
            f"{100.0 * min(held[k], 1.0):.2f} %",
        )
        for k in range(len(f))
    )
    table = Table(
        "free-free frequencies",
        ("mode", "full model (Hz)", "reduced (Hz)", "error", "held"),
        rows,
        "Held: how much of the full model's mode shape the reduced part can take on.",
    )
    good = (np.abs(error) < CLOSE) & (held > SHARE)
    first = len(f) if good.all() else int(np.argmin(good))
    topic = "frequencies"
    limit = "within 1 %"
    low = np.flatnonzero((error < -1e-5) & (held > 0.999))
    if len(low):
        return Check(
            topic,
            "fail",
            f"mode {low[0] + 1} is {_percent(error[low[0]])} too low",
            limit,
            "a reduced part can only be stiffer than its full model; this one is softer",
            "the modes belong to another mass or stiffness matrix: reduce this part again",
        ), table
    if first == 0:
        what = f"mode 1 ({number(f[0])} Hz) is missing"
        sentence = "the reduced part does not have the lowest mode of the free part"
        if held[0] > 0.8:
            what = f"mode 1 ({number(f[0])} Hz) is off by {_percent(error[0])}"
            sentence = "already the lowest mode of the free part is not within 1 %"
        return Check(
            topic,
            "warn",
            what,
            limit,
            sentence,
            "ask for more modes, unless modes were left out on purpose (in_plane, keep)",
        ), table
    value = f"first {count(first, 'mode')} good, to {number(f[first - 1])} Hz"
    sentence = f"the free body vibrates right up to {number(f[first - 1])} Hz"
    return Check(topic, "ok", value, limit, sentence), table


def static_loads(full: FullModel, modes: Modes) -> tuple[list[Check], Table] | None:
    """Return how the reduced part answers each interface load, against the full model.

    Each interface degree of freedom gets a unit force or moment. First balanced by the statically
    determinate supports of the interfaces: the modes must give the full model's displacements
    ``K^-1 F`` exactly. Then on the free body, which it accelerates (inertia relief,
    ``F - M R R^T F``): here the error tells whether there are vibration modes enough.
    """
    if full.held is None or full.held.solve is None or full.rigid is None or not modes.names:
        return None
    supports = _determinate(modes.moved(_rigid(full)))
    if supports is None:
        return None
    chosen = np.arange(len(modes.names))
    if len(chosen) > MOST_LOADS:
        chosen = np.linspace(0, len(chosen) - 1, MOST_LOADS).astype(np.intp)
    F = modes.loads[:, chosen].toarray()
    R, MR = full.rigid.R, full.rigid.MR
    balanced, trivial = _balanced(full, modes, F, chosen, supports)
    relieved = F - MR @ (R.T @ F)

    both = np.concatenate([balanced, relieved], axis=1)
    exact = elastic_response(full, both)
    omega2 = (2.0 * np.pi * modes.reduced.frequencies) ** 2
    found = modes.X @ ((modes.X.T @ both) / omega2[:, None])
    w = full.weights[:, None]
    scale = np.abs(exact * w).max(axis=0)
    error = np.abs((found - exact) * w).max(axis=0) / np.maximum(scale, np.finfo(float).tiny)
    m = len(chosen)
    static, dynamic = np.where(trivial, 0.0, error[:m]), error[m:]
    # work of load and reactions: the displacement where the load acts, as if on the supports
    own = np.einsum("ij,ij->j", balanced, exact[:, :m])
    rows = tuple(
        (
            modes.names[load],
            "support" if trivial[k] else number(own[k]),
            "-" if trivial[k] else number(static[k], 2),
            _percent(dynamic[k]),
        )
        for k, load in enumerate(chosen)
    )
    table = Table(
        "unit interface loads, reduced part against full model",
        ("load", "displacement (m/N, rad/N m)", "static error", "error when accelerating"),
        rows,
        "Static: balanced at the supports of the interfaces. Accelerating: on the free body.",
    )
    return [_static_check(modes, chosen, static, trivial), _relief_check(dynamic)], table


def _balanced(
    full: FullModel, modes: Modes, F: Array, chosen: Index, supports: Index
) -> tuple[Array, NDArray[np.bool_]]:
    """Return loads with the reactions of six supports, and which of them nothing can react to.

    A load on a support itself is balanced by six others, where there are such.
    """
    assert full.rigid is not None
    R = full.rigid.R
    P = modes.moved(_rigid(full))
    balanced = F.copy()
    trivial = np.zeros(len(chosen), dtype=bool)
    own = {int(load): k for k, load in enumerate(chosen) if load in supports}
    groups: list[tuple[Any, Index | None]] = [(~np.isin(chosen, supports), supports)]
    for load, k in own.items():
        others = np.setdiff1d(np.arange(len(P)), [load])
        found = _determinate(P[others])
        groups.append(([k], None if found is None else others[found]))
    for columns, six in groups:
        if six is None:
            trivial[columns] = True
            balanced[:, columns] = 0.0
            continue
        # reactions r with R^T (F + S r) = 0
        S = modes.loads[:, six].toarray()
        balanced[:, columns] -= S @ np.linalg.solve(R.T @ S, R.T @ F[:, columns])
    return balanced, trivial


def elastic_response(full: FullModel, F: Array) -> Array:
    """Return displacements of self-equilibrated loads (ndof, m), without rigid part."""
    assert full.held is not None and full.held.solve is not None and full.rigid is not None
    f = full.held.lower(F)
    y = full.held.solve(f)
    # the residual of fine meshes is worth one more solve
    y = y + full.held.solve(f - full.held.B @ y)
    return full.rigid.remove(full.held.lift(y))


def _static_check(modes: Modes, chosen: Index, error: Array, trivial: NDArray[np.bool_]) -> Check:
    topic = "static loads"
    limit = f"relative error below {EXACT:g}"
    loads = count(len(chosen), "interface load")
    if trivial.all():
        sentence = (
            "a single node carries every load as a rigid body; nothing bends unless it accelerates"
        )
        return Check(topic, "ok", "single support", "", sentence)
    worst = int(np.argmax(error))
    value = f"{number(error[worst], 2)} at worst"
    # what the solver itself leaves
    if error[worst] < EXACT:
        what = f"every one of {loads} bends the reduced part as the full model"
        return Check(topic, "ok", value, limit, what)
    name = modes.names[chosen[worst]]
    if error[worst] > 0.999:
        rigid = int(np.sum(error > 0.999))
        return Check(
            topic,
            "warn",
            value,
            limit,
            f"the reduced part does not bend at all under {rigid} of {loads}, such as {name}",
            "right if modes were left out on purpose (in_plane, keep); otherwise keep all modes",
        )
    # with fewer modes than static deformations of the interfaces some were left out
    left_out = modes.reduced.n < len(modes.names) - 6
    status: Any = "warn" if error[worst] < 1e-4 or left_out else "fail"
    return Check(
        topic,
        status,
        value,
        limit,
        f"under {name} the reduced part bends otherwise than the full model",
        "keep the constraint modes of all interfaces (CraigBampton with these interfaces, all "
        "modes); if it was made so, the stiffness matrix is too ill-conditioned for this accuracy",
    )


def _relief_check(error: Array) -> Check:
    worst = float(error.max())
    value, limit = f"{_percent(worst)} at worst", "below 5 %"
    topic = "accelerating loads"
    if worst < 0.05:
        sentence = "loads that accelerate the free body bend it as they bend the full model"
        return Check(topic, "ok", value, limit, sentence)
    return Check(
        topic,
        "note",
        value,
        limit,
        "a load that accelerates the free body bends it otherwise than the full model, since the "
        "modes of its own inertia are few",
        "ask for more fixed-interface modes; no matter where such loads do not occur",
    )


def effective_mass(full: FullModel, modes: Modes) -> tuple[Check, Table | None] | None:
    """Return the modal effective mass of the modes of the reduced part, interfaces held.

    In mass-orthonormal coordinates ``z = (a, p)`` of rigid motion and modes the held interface is
    ``B^T [R X] z = 0`` with the loads B; the modes of what is left have the participation
    ``L = r^T M phi`` in a unit rigid motion r, and the effective mass ``L^2``. All of them together
    weigh at most ``r^T M r`` (Wijker 2004, Mechanical Vibrations in Spacecraft Design, chapter 6).
    """
    if full.rigid is None or not 0 < len(modes.names) <= 6 * MANY_DOFS:
        return None
    R, MR = full.rigid.R, full.rigid.MR
    n = modes.reduced.n
    C = modes.moved(np.concatenate([R, modes.X], axis=1))
    size = np.maximum(np.sqrt(np.einsum("ij,ij->j", C, C)), np.finfo(float).tiny)
    Z = scipy.linalg.null_space(C / size, rcond=1e-10) / size[:, None]
    if not Z.shape[1]:
        return Check(
            "effective mass",
            "warn",
            "no mode with interfaces held",
            "",
            "the body does not vibrate at all while its interfaces are held: it is condensed "
            "statically",
            "ask for fixed-interface modes, unless only slow motion matters",
        ), None
    omega2 = (2.0 * np.pi * modes.reduced.frequencies) ** 2
    stiff = Z.T @ (np.concatenate([np.zeros(6), omega2])[:, None] * Z)
    values, Y = scipy.linalg.eigh(stiff, Z.T @ Z)
    places = [modes.reduced.nodes[list(modes.reduced.node_sets[k])] for k, _ in modes.interfaces]
    about = np.concatenate(places).mean(axis=0)
    unit = rigid_modes(full.nodes, full.dofs, about)
    coordinates = MR.T @ unit
    L = coordinates.T @ (Z @ Y)[:6]
    total = np.einsum("ij,ij->j", coordinates, coordinates)
    share = L**2 / np.maximum(total, np.finfo(float).tiny)[:, None]
    # a direction in which hardly anything can move by inertia has no share
    share[total <= 1e-9 * np.repeat([full.mass, full.mass * full.length**2], 3)] = np.nan
    f = np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)
    shown = min(len(f), 10)
    rows = [
        (str(k + 1), number(f[k], 6), *(_share(share[a, k]) for a in range(6)))
        for k in range(shown)
    ]
    if len(f) > shown:
        rest = share[:, shown:].sum(axis=1)
        rows.append((f"{shown + 1} to {len(f)}", f"to {number(f[-1])}", *map(_share, rest)))
    held = share.sum(axis=1)
    rows.append(("all", "", *map(_share, held)))
    table = Table(
        "modal effective mass, interfaces held",
        ("mode", "Hz", "x", "y", "z", "about x", "about y", "about z"),
        tuple(rows),
        "Share of the mass (moment of inertia about the middle of the interfaces) that vibrates "
        f"in each of {n} modes less what the interfaces hold.",
    )
    topic = "effective mass"
    value = " ".join(f"{x} {_share(h)}" for x, h in zip("xyz", held, strict=False))
    poor = [x for x, h in zip("xyz", held, strict=False) if not h >= MASS_SHARE]
    limit = f"at least {100 * MASS_SHARE:.0f} % in each direction"
    if not poor:
        sentence = "the modes hold the vibrating mass in every direction"
        return Check(topic, "ok", value, limit, sentence), table
    sentence = (
        f"shaken along {', '.join(poor)} much of the mass only follows its interfaces: what "
        f"vibrates above {number(f[-1])} Hz is left out"
    )
    remedy = (
        "ask for more fixed-interface modes if excitations there come near it; mass that stands on "
        "its interfaces, such as bosses, hardly vibrates"
    )
    return Check(topic, "note", value, limit, sentence, remedy), table


def _share(value: float) -> str:
    return "-" if not np.isfinite(value) else f"{100.0 * value:.1f} %"


def _percent(value: float) -> str:
    size = abs(value)
    if size < 1e-6:
        return "0 %"
    return f"{100.0 * value:.2g} %" if size < 0.1 else f"{100.0 * value:.3g} %"
