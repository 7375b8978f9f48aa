"""Checks of a part without modes: rigid motions, units, missing data; for the certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, count
from jousto.certificate.certificate import Check, Table, number
from jousto.mesh.sets import node_graph, rigid_groups, tied
from jousto.reduction.modes import eigen
from jousto.reduction.modes.partition import dof_label
from jousto.reduction.modes.rigid import RigidBasis, rigid_modes

if TYPE_CHECKING:
    from jousto.parts.part import Part


MOTIONS = ("along x", "along y", "along z", "about x", "about y", "about z")

RIGID_RATIO = (1e-3, 0.05)
"""Frequency of a rigid motion / lowest elastic one, for a warning and for a failure."""

SOUND = (300.0, 15000.0)
"""Range of the speed of sound of materials, m/s: soft foam to diamond."""

SIZE = (1e-3, 100.0)
"""Range of the size of parts, m."""

DENSITY = (5.0, 23000.0)
"""Range of the density of materials, kg/m3: foam to osmium."""

SOFT = 1e-3
"""Ratio of two neighbouring frequencies below which the lower one is a mechanism."""

# ratio of the computed speed of sound to that of metals (5000 m/s), and its usual cause
CAUSES = (
    (1e6, "the density is in t/mm3 while E is in Pa: give kg/m3"),
    (1e3, "matrices are in mm, t and s (N, MPa): give lengths in m, E in Pa and density in kg/m3"),
    (35.0, "the density is in g/cm3 (t/m3), or lengths are in inches: give kg/m3 and m"),
    (3.2e-2, "E is in kPa: give it in Pa, 210 GPa are 2.1e11"),
    (1e-3, "E is in MPa while lengths are in m, or time is in ms: give E in Pa"),
    (3.2e-5, "E is in GPa while other values are SI: give E in Pa"),
    (1e-6, "E is in TPa, or mass is in mg: give E in Pa and mass in kg"),
)


@dataclass(frozen=True, eq=False)
class FullModel:
    """Free finite element model with the data for several checks.

    Parameters
    ----------
    part : Part
    M, K : (ndof, ndof) sparse arrays
    nodes : (nn, 3) array
        Positions of the nodes of the degrees of freedom, m.
    dofs : int
        Degrees of freedom of a node.
    length : float
        Size of the body, m.
    mass : float
        kg.
    centre : (3,) array
        m.
    inertia : (3, 3) array
        Inertia about the centre, kg m2.
    rigid : RigidBasis or None
        Mass-orthonormal rigid motions; None if the inertia is singular.
    held : Flexibility or None
        The body fixed at six degrees of freedom; None if this is impossible.
    frequencies : (m,) array
        Lowest elastic frequencies of the free body, Hz.
    shapes : (ndof, m) array
        Mass-normalised modes of these frequencies.
    """

    part: Part
    M: sp.csr_array
    K: sp.csr_array
    nodes: Array
    dofs: int
    length: float
    mass: float
    centre: Array
    inertia: Array
    rigid: RigidBasis | None
    held: eigen.Flexibility | None
    frequencies: Array
    shapes: Array

    @property
    def weights(self) -> Array:
        """Weights (ndof,): 1 for translations, the size of the body for rotations."""
        kind = np.arange(self.K.shape[0]) % self.dofs
        return np.asarray(np.where(kind < 3, 1.0, self.length))


def rigid_motions(full: FullModel) -> tuple[Check, Table]:
    """Return the check that the six rigid motions have no strain energy."""
    R = rigid_modes(full.nodes, full.dofs, full.centre)
    energy = np.einsum("ij,ij->j", R, full.K @ R)
    cancelling = np.einsum("ij,ij->j", np.abs(R), abs(full.K) @ np.abs(R))
    inertia = np.einsum("ij,ij->j", R, full.M @ R)
    share = np.abs(energy) / np.maximum(cancelling, np.finfo(float).tiny)
    # rounding of the products may leave a small energy of either sign
    hertz = np.sqrt(np.abs(energy) / np.maximum(inertia, np.finfo(float).tiny)) / (2.0 * np.pi)
    rows = tuple(
        (motion, number(5e-7 * e), number(s, 2), number(f))
        for motion, e, s, f in zip(MOTIONS, energy, share, hertz, strict=True)
    )
    table = Table(
        "six rigid motions",
        (
            "motion",
            "strain energy of 1 mm or 1 mrad (J)",
            "energy / cancelling terms",
            "frequency (Hz)",
        ),
        rows,
        "In a free body this energy is zero except for rounding.",
    )
    worst = int(np.argmax(hertz))
    lowest = float(full.frequencies[0]) if len(full.frequencies) else 0.0
    value = f"{number(hertz[worst])} Hz at most"
    topic = "rigid motions"
    if not lowest:
        good = bool(share.max() < 1e-9)
        status: Any = "ok" if good else "fail"
        sentence = "all six rigid motions have no strain energy"
        if not good:
            sentence = f"moving the rigid body {MOTIONS[worst]} stores strain energy"
        remedy = "" if good else "remove supports and springs to ground"
        return Check(topic, status, value, "", sentence, remedy), table
    ratio = float(hertz[worst]) / lowest
    limit = f"first elastic mode {number(lowest)} Hz"
    if ratio < RIGID_RATIO[0]:
        sentence = "all six rigid motions have no strain energy"
        return Check(topic, "ok", value, limit, sentence), table
    status = "warn" if ratio < RIGID_RATIO[1] else "fail"
    if hertz[:3].max() >= RIGID_RATIO[0] * lowest:
        # a support resists rotations, too: report the simpler motion
        worst = int(np.argmax(hertz[:3]))
    sentence = (
        f"moving the rigid body {MOTIONS[worst]} stores strain energy as if it were a mode of "
        f"{number(hertz[worst])} Hz"
    )
    if worst < 3:
        remedy = "remove supports and springs to ground before the matrices are written"
    else:
        remedy = (
            "check that node positions are in m, in the order of the matrices, and that the "
            "file has enough digits; remove supports and springs to ground"
        )
    return Check(topic, status, value, limit, sentence, remedy), table


def speed_of_sound(full: FullModel) -> float:
    """Return ``sqrt(B / rho)`` of the material, m/s, from the matrices alone.

    The displacement ``u = x`` is a uniform extension: its energy is ``E V`` for beams, ``9 B V``
    with the bulk modulus B for solids. Divided by the mass it is ``E / rho`` or ``9 B / rho`` for
    any shape.
    """
    nn = len(full.nodes)
    u = np.zeros((nn, full.dofs))
    u[:, :3] = full.nodes - full.centre
    energy = float(u.ravel() @ (full.K @ u.ravel()))
    if full.dofs == 3:
        energy /= 9.0
    return float(np.sqrt(max(energy, 0.0) / full.mass))


def units(full: FullModel) -> Check:
    """Return the check that size, speed of sound and density are possible in SI units."""
    speed = speed_of_sound(full)
    extent = np.ptp(full.nodes, axis=0)
    faults = []
    remedies = []
    # a mass on a part lowers the speed of sound and raises the density
    alone = full.part.attached is None
    impossible = speed > SOUND[1] or (alone and speed < 0.1 * SOUND[0])
    if not SOUND[0] <= speed <= SOUND[1]:
        faults.append(
            f"sound would travel at {number(speed)} m/s in this material (steel: about 5000 m/s)"
        )
        factor = speed / 5000.0
        near = min(CAUSES, key=lambda cause: abs(np.log(max(factor, 1e-30) / cause[0])))
        if abs(np.log10(max(factor, 1e-30) / near[0])) < 0.6:
            remedies.append(f"most likely {near[1]}")
        else:
            remedies.append("check the units of E, density and lengths")
    if not SIZE[0] <= full.length <= SIZE[1]:
        faults.append(f"the part is {number(1e3 * full.length, 6)} mm long")
        hint = (
            "lengths in mm were read as m: write unit: mm beside the mesh's file in the part "
            "file, or scale the mesh by 0.001"
        )
        if full.length < SIZE[0]:
            hint = "lengths in m were read as mm: scale the mesh by 1000"
        remedies.append(f"if it is not, {hint}")
    box = float(np.prod(extent))
    if box > 1e-6 * full.length**3:
        least = full.mass / box
        if least > DENSITY[1]:
            impossible = impossible or alone
            faults.append(
                f"the part weighs {number(full.mass)} kg, more than a solid block of osmium of "
                f"its size ({number(least)} kg/m3)"
            )
            remedies.append("check the density (kg/m3), the unit of lengths and point masses")
    volume = _volume(full)
    if volume:
        density = full.mass / volume
        if not DENSITY[0] <= density <= DENSITY[1]:
            impossible = impossible or (alone and density > DENSITY[1])
            faults.append(
                f"{number(full.mass)} kg in {number(1e9 * volume)} mm3 are {number(density)} kg/m3 "
                "(steel: 7850 kg/m3)"
            )
            remedies.append("check the density (kg/m3) and the unit of the mesh")
    value = f"{number(speed)} m/s, {number(1e3 * full.length, 6)} mm, {number(full.mass, 6)} kg"
    limit = f"speed of sound {SOUND[0]:g} to {SOUND[1]:g} m/s"
    if not faults:
        sentence = "stiffness, mass and size are plausible in SI units"
        return Check("units", "ok", value, limit, sentence)
    status: Any = "fail" if impossible else "warn"
    return Check("units", status, value, limit, "; ".join(faults), "; ".join(remedies))


def _volume(full: FullModel) -> float:
    """Return the volume of the mesh, m3; 0 without one."""
    return float(getattr(full.part.mesh, "volume", 0.0) or 0.0)


def rotary_inertia(full: FullModel) -> Check:
    """Return the check of the rotary inertia of the body and of its nodes."""
    topic = "rotary inertia"
    moments = np.linalg.eigvalsh(full.inertia)
    ratio = float(moments[0] / moments[-1]) if moments[-1] > 0.0 else 0.0
    value = f"{number(max(moments[0], 0.0))} to {number(moments[-1])} kg m2"
    limit = "smallest over largest moment above 1e-9"
    if ratio < 1e-9:
        status: Any = "fail" if full.rigid is None else "warn"
        return Check(
            topic,
            status,
            value,
            limit,
            "all mass lies on a line or at a point: rotation about that line has no inertia",
            "give the section its rotary inertia (rotary_inertia=True), write the matrices with "
            "rotary inertia, or add a point mass with inertia",
        )
    if full.dofs == 6:
        diagonal = full.M.diagonal().reshape(-1, 6)
        bare = int(np.sum(np.all(diagonal[:, 3:] <= 0.0, axis=1)))
        if bare:
            return Check(
                topic,
                "note",
                f"{count(bare, 'node')} of {len(diagonal)} without",
                "",
                "rotations of these nodes have no mass, so that their modes have no frequency: "
                "those of interfaces are kept as static shapes",
                "harmless for slender parts; otherwise use consistent mass or rotary_inertia=True",
            )
    return Check(topic, "ok", value, limit, "the body has inertia about every axis")


def loose_nodes(full: FullModel) -> Check:
    """Return the check that all nodes are connected and form one piece."""
    topic = "loose nodes"
    d = full.dofs
    weight = np.asarray(abs(full.K) @ np.ones(full.K.shape[0])).reshape(-1, d)
    scale = weight[:, :3].max(axis=0, initial=0.0).max()
    bare = np.flatnonzero(weight[:, :3].max(axis=1) <= 1e-14 * scale)
    turning = np.zeros(0, dtype=np.intp)
    if d == 6:
        largest = weight[:, 3:].max(initial=0.0)
        turning = np.setdiff1d(np.flatnonzero(weight[:, 3:].min(axis=1) <= 1e-14 * largest), bare)
    if len(bare):
        return Check(
            topic,
            "fail",
            f"{count(len(bare), 'node')}: {_names(bare)}",
            "none",
            "these nodes have no stiffness: no element is connected to them",
            "remove them or connect them to the elements",
        )
    if len(turning):
        return Check(
            topic,
            "fail",
            f"{count(len(turning), 'node')}: {_names(turning)}",
            "none",
            "the rotations of these nodes have no stiffness",
            "leave out their rotations, or connect them to elements with rotational stiffness",
        )
    pieces = _pieces(full.part)
    if pieces > 1:
        return Check(
            topic,
            "fail",
            count(pieces, "piece"),
            "1 piece",
            "the part has disconnected pieces",
            "merge coinciding nodes of touching bodies, tie them by a rigid interface (an "
            "average does not connect them), or make each piece a part",
        )
    if len(full.part.elements):
        outside = np.setdiff1d(np.arange(len(full.part.nodes)), full.part.elements)
        if len(outside) and d == 6:
            return Check(
                topic,
                "note",
                f"{count(len(outside), 'node')}: {_names(outside)}",
                "",
                "these nodes have stiffness but belong to no listed element",
            )
    return Check(topic, "ok", "none", "", "every node is connected, and the part is one piece")


def mechanisms(full: FullModel, fault: str) -> Check:
    """Return the check for free or very soft motions besides the six rigid motions."""
    topic = "mechanisms"
    if full.held is None:
        sentence = "there is a motion without stiffness besides the rigid motions"
        node = swinging_node(full)
        if node is not None:
            sentence += f", most at {dof_label(node, full.dofs)}"
        return Check(topic, "fail", "stiffness matrix is singular", fault, sentence, _CONNECT)
    f = full.frequencies
    if not len(f):
        return Check(topic, "note", "not examined", "", "no elastic mode was found")
    value = f"first elastic modes {', '.join(number(x) for x in f[:3])} Hz"
    jumps = np.flatnonzero(f[:-1] < SOFT * f[1:])
    if not len(jumps):
        return Check(topic, "ok", value, "", "there is no free motion besides the rigid motions")
    k = int(jumps[-1])
    shape = np.abs(full.shapes[:, k] * full.weights)
    where = dof_label(int(np.argmax(shape)), full.dofs)
    return Check(
        topic,
        "warn",
        value,
        f"neighbours within {1 / SOFT:.0f} times",
        f"{count(k + 1, 'mode')} up to {number(f[k])} Hz are far below the next one, "
        f"{number(f[k + 1])} Hz: a component is almost loose, {where} moves most",
        _CONNECT,
    )


def swinging_node(full: FullModel) -> int | None:
    """Return the degree of freedom that moves most in a motion without stiffness.

    Computed by inverse iteration with a small stiffness to ground, without the rigid motions.
    """
    n = full.K.shape[0]
    diagonal = full.K.diagonal()
    if n > 60_000 or diagonal.min() < 0.0:
        return None
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    D = sp.diags_array(scale)
    lu = spl.splu(sp.csc_array(D @ full.K @ D + sp.eye_array(n) * 1e-9))
    rigid = np.linalg.qr(rigid_modes(full.nodes, full.dofs, full.centre) / scale[:, None])[0]
    x = np.random.default_rng(20070607).standard_normal(n)
    for _ in range(4):
        x = lu.solve(x - rigid @ (rigid.T @ x))
        x -= rigid @ (rigid.T @ x)
        x /= np.linalg.norm(x)
    return int(np.argmax(np.abs(x * scale * full.weights)))


_CONNECT = (
    "connect the component: merge nodes of touching meshes, tie rotations of beams to solids "
    "with at least three nodes, and check for hinges and missing springs"
)


def content(full: FullModel) -> Check:
    """Return the check for stress and stiffening data."""
    missing = []
    if full.part.stress is None:
        missing.append("stress (matrices contain no stress; build the part from its elements)")
    if full.part.second_order is None:
        missing.append("stiffening by centrifugal and axial forces")
    if not missing:
        return Check("content", "ok", "stress and stiffening", "", "stress can be recovered")
    value = "no stress" if full.part.stress is None else "no stiffening"
    if full.part.stress is None and full.part.second_order is None:
        value = "no stress, no stiffening"
    return Check("content", "note", value, "", f"the part has no {' and no '.join(missing)}")


def _names(nodes: NDArray[Any]) -> str:
    names = [f"node{i + 1}" for i in nodes[:4]]
    return ", ".join(names) + (", ..." if len(nodes) > 4 else "")


def hangs_together(part: Part) -> bool:
    """Return whether elements and rigid ties connect all nodes."""
    return _pieces(part) == 1


def _pieces(part: Part) -> int:
    """Return the number of disconnected pieces of a part; averages connect nothing."""
    from scipy.sparse.csgraph import connected_components  # slow to import

    graph = tied(node_graph(part.K, part.dofs_per_node), rigid_groups(part.ties))
    return int(connected_components(graph, directed=False)[0])


def fault_of(error: InputError) -> str:
    """Return the message of an error without the name of the part."""
    return error.problems[0].sentence
