"""Checks of unit interface loads on a reduced part and on its full model, for the certificate."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index
from jousto.base.errors import count
from jousto.certificate.certificate import Check, Status, Table, number, percent
from jousto.certificate.interface_modes import Modes, determinate, scaled_rigid
from jousto.certificate.part_checks import FullModel

EXACT = 1e-8
"""Relative error of a static displacement that counts as exact."""

MOST_LOADS = 60
"""Interface loads that are solved; more are sampled evenly."""


def static_loads(full: FullModel, modes: Modes) -> tuple[list[Check], Table] | None:
    """Return how the reduced part answers each interface load, against the full model.

    Each interface degree of freedom gets a unit force or moment. First balanced by the statically
    determinate supports of the interfaces: the modes must give the full model's displacements
    ``K^-1 F`` exactly. Then on the free body, which it accelerates (inertia relief,
    ``F - M R R^T F``): here the error shows whether there are enough vibration modes.
    """
    if full.held is None or full.held.solve is None or full.rigid is None or not modes.names:
        return None
    supports = determinate(modes.moved(scaled_rigid(full)))
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
            percent(dynamic[k]),
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
    P = modes.moved(scaled_rigid(full))
    balanced = F.copy()
    trivial = np.zeros(len(chosen), dtype=bool)
    own = {int(load): k for k, load in enumerate(chosen) if load in supports}
    groups: list[tuple[Any, Index | None]] = [(~np.isin(chosen, supports), supports)]
    for load, k in own.items():
        others = np.setdiff1d(np.arange(len(P)), [load])
        found = determinate(P[others])
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
    status: Status = "warn" if error[worst] < 1e-4 or left_out else "fail"
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
    value, limit = f"{percent(worst)} at worst", "below 5 %"
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
