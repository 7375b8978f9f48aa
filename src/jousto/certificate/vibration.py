"""Checks of frequencies and vibrating mass of a reduced part, for the certificate."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from jousto.base.errors import count
from jousto.certificate.certificate import Check, Table, number, percent
from jousto.certificate.interface_modes import Modes
from jousto.certificate.part_checks import FullModel
from jousto.reduction.modes.rigid import rigid_modes

CLOSE = 0.01
"""Relative error of a frequency that counts as good."""

SHARE = 0.95
"""Smallest part of a mode of the full model that the reduced part must contain."""

MASS_SHARE = 0.8
"""Smallest effective mass of the modes in each direction / mass of the part."""

MOST_DOFS = 720
"""Largest number of degrees of freedom of all interfaces for effective masses."""


def frequencies(full: FullModel, modes: Modes) -> tuple[Check, Table] | None:
    """Return the check of the free-free frequencies against those of the full model."""
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
            percent(error[k]) if held[k] > 0.3 else "-",
            f"{100.0 * min(held[k], 1.0):.2f} %",
        )
        for k in range(len(f))
    )
    table = Table(
        "free-free frequencies",
        ("mode", "full model (Hz)", "reduced (Hz)", "error", "held"),
        rows,
        "Held: part of the mode shape of the full model that the reduced part contains.",
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
            f"mode {low[0] + 1} is {percent(error[low[0]])} too low",
            limit,
            "a reduced part can only be stiffer than its full model; this one is softer",
            "the modes belong to another mass or stiffness matrix: reduce this part again",
        ), table
    if first == 0:
        what = f"mode 1 ({number(f[0])} Hz) is missing"
        sentence = "the reduced part does not have the lowest mode of the free part"
        if held[0] > 0.8:
            what = f"mode 1 ({number(f[0])} Hz) is off by {percent(error[0])}"
            sentence = "the error of the lowest mode of the free part exceeds 1 %"
        return Check(
            topic,
            "warn",
            what,
            limit,
            sentence,
            "ask for more modes, unless modes were left out on purpose (in_plane, keep)",
        ), table
    value = f"first {count(first, 'mode')} good, to {number(f[first - 1])} Hz"
    sentence = f"the frequencies of the free body are accurate up to {number(f[first - 1])} Hz"
    return Check(topic, "ok", value, limit, sentence), table


def effective_mass(full: FullModel, modes: Modes) -> tuple[Check, Table | None] | None:
    """Return the check of the modal effective mass with fixed interfaces.

    In mass-orthonormal coordinates ``z = (a, p)`` of rigid motion and modes, fixed interfaces mean
    ``B^T [R X] z = 0`` with the loads B; the remaining modes have the participation factor ``L =
    r^T M phi`` in a unit rigid motion r, and the effective mass ``L^2``. The sum of the effective
    masses is at most ``r^T M r`` (Wijker 2004, Mechanical Vibrations in Spacecraft Design, chapter
    6).
    """
    if full.rigid is None or not 0 < len(modes.names) <= MOST_DOFS:
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
            "no mode with fixed interfaces",
            "",
            "the body has no vibration mode with fixed interfaces: it is condensed statically",
            "ask for fixed-interface modes, except for slow motion",
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
    # skip a direction in which almost no mass can move
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
        "modal effective mass, fixed interfaces",
        ("mode", "Hz", "x", "y", "z", "about x", "about y", "about z"),
        tuple(rows),
        f"Share of the mass (moment of inertia about the middle of the interfaces) that vibrates "
        f"in each of {n} modes, without the mass fixed to the interfaces.",
    )
    topic = "effective mass"
    value = " ".join(f"{x} {_share(h)}" for x, h in zip("xyz", held, strict=False))
    poor = [x for x, h in zip("xyz", held, strict=False) if not h >= MASS_SHARE]
    limit = f"at least {100 * MASS_SHARE:.0f} % in each direction"
    if not poor:
        sentence = "the modes contain the vibrating mass in every direction"
        return Check(topic, "ok", value, limit, sentence), table
    sentence = (
        f"in vibration along {', '.join(poor)} much of the mass only follows its interfaces: "
        f"modes above {number(f[-1])} Hz are left out"
    )
    remedy = (
        "ask for more fixed-interface modes if excitations reach that frequency; mass near the "
        "interfaces, such as bosses, hardly vibrates"
    )
    return Check(topic, "note", value, limit, sentence, remedy), table


def _share(value: float) -> str:
    return "-" if not np.isfinite(value) else f"{100.0 * value:.1f} %"
