"""Discretisation error of the stress of a part, for the certificate."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.certificate.certificate import Check, Status, Table, number, percent, vector
from jousto.certificate.interface_modes import Modes
from jousto.certificate.part_checks import FullModel
from jousto.parts.mesh_error import mesh_error

GOOD, USELESS = 0.1, 0.4
"""Relative errors in the energy norm: largest one of a good mesh, and of a usable mesh."""

MOST_LOADS = 24
"""Largest number of interface loads; of more a uniform sample is used."""

BLOCK = 8
"""Number of fields per block of the error estimate."""


def mesh_accuracy(full: FullModel, modes: Modes | None) -> tuple[Check, Table] | None:
    """Return the estimated discretisation error of the lowest modes and of interface loads.

    The errors are relative errors in the energy norm, see `mesh_error`: of the lowest free-free
    modes of the full model and, for a reduced part, of its responses to unit loads on its
    interfaces. The status follows from the loads, or from the lowest mode without loads, since the
    error of high modes is large on any mesh. None for parts that do not consist of solids.
    """
    if full.part.solids is None:
        return None
    names = [f"free mode at {number(f)} Hz" for f in full.frequencies]
    fields, judged = full.shapes, slice(0, 1)
    if modes is not None and full.rigid is not None and modes.names:
        chosen = np.arange(len(modes.names))
        if len(chosen) > MOST_LOADS:
            chosen = np.linspace(0, len(chosen) - 1, MOST_LOADS).astype(np.intp)
        F = modes.loads[:, chosen].toarray()
        F = F - full.rigid.MR @ (full.rigid.R.T @ F)
        omega2 = (2.0 * np.pi * modes.reduced.frequencies) ** 2
        fields = np.concatenate([fields, modes.X @ ((modes.X.T @ F) / omega2[:, None])], axis=1)
        judged = slice(len(names), None)
        names += [modes.names[k] for k in chosen]
    ndof = 3 * len(full.part.solids.nodes)
    rows, eta = [], np.zeros(len(names))
    places = []
    for first in range(0, len(names), BLOCK):
        found = mesh_error(full.part, fields[:ndof, first : first + BLOCK])
        for k, value in enumerate(found.eta):
            e = found.worst(k)
            eta[first + k] = value
            places.append((int(found.ids[e]), vector(1e3 * found.centers[e], 4)))
            rows.append((names[first + k], percent(value), *map(str, places[-1])))
    if not len(eta[judged]):
        return None
    table = Table(
        "estimated error of the mesh",
        ("shape", "energy norm", "most in element", "at (mm)"),
        tuple(rows),
        "Mean error of stress after Zienkiewicz and Zhu. At sharp corners it does not converge.",
    )
    return _check(eta[judged], names[judged], places[judged]), table


def _check(eta: Array, names: list[str], places: list[tuple[int, str]]) -> Check:
    worst = int(np.argmax(eta))
    element, at = places[worst]
    value = f"{percent(float(eta[worst]))} at worst"
    limit = f"at most {percent(GOOD)} of the energy norm"
    if eta[worst] <= GOOD:
        sentence = (
            f"stress under {names[worst]} has this estimated error in the mean, most of it in "
            f"element {element} at ({at}) mm"
        )
        return Check("mesh error", "ok", value, limit, sentence)
    status: Status = "warn" if eta[worst] <= USELESS else "fail"
    return Check(
        "mesh error",
        status,
        value,
        limit,
        f"stress under {names[worst]} has this estimated error in the mean, most of it in element "
        f"{element} at ({at}) mm",
        "refine the mesh there, or use quadratic elements, and compare",
    )
