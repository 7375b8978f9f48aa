"""Interfaces: surfaces of a part that are tied to a reference node with six motions."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Ints, read_only, skew
from jousto.base.declare import Declared
from jousto.base.errors import Problems, suggest, warn
from jousto.base.fields import Choice, Field, field
from jousto.base.numbers import OptionalValues
from jousto.mesh.area import KINDS, area_matrix
from jousto.mesh.holes import Hole, cylinder_middle
from jousto.mesh.picks import Pick
from jousto.mesh.sets import read_integers
from jousto.parts.geometry import Geometry

LOOSE, NARROW = 1e-8, 1e-3
"""Smallest allowed ratio of the weakest to the strongest of the six motions of the tied nodes."""


class Own(Field[str, str]):
    """Field of the name of an interface; names of nodes such as "node7" are reserved."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the name, or report that it cannot be used."""
        if not isinstance(value, str) or not value:
            problems.add(where, f"its name is {value!r}, must be a word")
        elif re.fullmatch(r"node\d+", value):
            problems.add(
                where, "this name is reserved for the node of that number; choose another name"
            )
        return value


class Tied(Field[Any, Any]):
    """Field of nodes given in one of several ways; the part converts them to indices."""

    form = "pick"
    noun = "str, array_like of int, Hole or pick"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the value unchanged; a hole becomes its nodes."""
        return value.nodes if isinstance(value, Hole) else value


class Interface(Declared):
    """Connection of a part to its neighbours: nodes tied to a reference node with six motions.

    Nodes of solids have translations only. A joint or a torque needs rotations, and a pin touches a
    whole bore instead of a point. The reference node with the motion q = [u, theta] is tied to the
    nodes, at ``s_i`` from the reference node, in one of two ways:

    * rigid (RBE2): the nodes follow it, ``u_i = u + theta x s_i``. This stiffens the surface; use
      it for bolted flanges, pressed pins, and neighbours much stiffer than the part.
    * average (RBE3): the reference node follows the nodes, ``q = (sum w_i R_i^T R_i)^-1 sum w_i
      R_i^T u_i`` with ``R_i = [E, -s_i~]``. This adds no stiffness, and a force becomes a traction
      with a constant and a linear part. Use it for bores with clearance, soft bushings and loads.

    Raises
    ------
    InputError
        If the name, kind, point or weights cannot be used.

    Examples
    --------
    >>> Interface("pin", "bore", kind="average", at=(0.0, 0.0, 0.1))
    <Interface 'pin': average of 'bore'>
    """

    name: Own = field("Name of the interface and of its reference node in the reduced part")
    nodes: Tied = field(
        "Name of a node set, node indices, a hole of the mesh (``mesh.holes()``), ``InBox``, "
        "``InCylinder``, ``InSphere``, ``OnPlane``, ``Nearest``, or faces as rows of node "
        "indices (nf, k), corners first, then mid-side nodes; in files a set, a list of sets, "
        "or a pick such as {hole: ...}"
    )
    kind: Choice = field(  # type: ignore[misc]
        "rigid (RBE2) for a stiff flange; average (RBE3) for a pin with clearance",
        words=("rigid", "average"),
        wanted="'rigid' (the nodes follow the reference node) or 'average' (it follows the nodes)",
        default="rigid",
    )
    at: OptionalValues = field(
        "Reference point, part frame. None for the middle of the axis if the nodes lie on a "
        "cylinder, else their centroid",
        unit="m",
        shape=(3,),
        default=None,
    )
    weights: OptionalValues = field(
        "Weights of the nodes in the order of `nodes`, for averages. None for weights by area "
        "(``int N N^T dA``) if the faces are known, else equal weights",
        shape=(None,),
        file=False,
        default=None,
    )
    together = ("kind", "weights")

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages."""
        return f"interface {self.name!r}"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report weights that cannot be used."""
        if self.weights is None:
            return
        if self.kind == "rigid":
            problems.add(where, "a rigid interface has no weights; use kind='average'")
        elif np.any(self.weights < 0.0) or not np.any(self.weights):
            problems.add(where, "weights must not be negative and not all zero", "weights")

    def __repr__(self) -> str:
        shown = repr(self.nodes)
        if not isinstance(self.nodes, str | Pick):
            shape = np.shape(self.nodes)
            shown = f"{shape[0]} {'faces' if len(shape) == 2 else 'nodes'}" if shape else shown
        word = "rigid on" if self.kind == "rigid" else "average of"
        return f"<Interface {self.name!r}: {word} {shown}>"


@dataclass(frozen=True, eq=False)
class Tie:
    """Interface of a part with the indices of its nodes and its reference point.

    Parameters
    ----------
    name : str
    kind : "rigid" or "average"
    nodes : (k,) ndarray of int
        The tied nodes, ascending.
    at : (3,) ndarray
        The reference point in m, part frame.
    following : (k, d, 6) ndarray
        Motion of each node, with d degrees of freedom, if it follows the motion ``[u, theta]`` of
        the reference node rigidly.
    averaging : (6, k d) ndarray
        Motion ``[u, theta]`` of the reference node from the nodes' displacements; exact for rigid
        motions. Its transpose gives the nodal forces of a force and a moment on the reference node.
    conditioning : float
        Weakest of the six motions of the nodes relative to the strongest: 1 for a sphere, 0 for
        nodes on a line, small for a reference point far from the nodes.
    by_area : bool
        Whether the weights of the nodes are their shares of the surface.
    """

    name: str
    kind: str
    nodes: Ints
    at: Array
    following: Array
    averaging: Array
    conditioning: float
    by_area: bool

    def __repr__(self) -> str:
        # rounded, so that a coordinate of 1e-18 is shown as zero
        at = ", ".join(f"{round(x, 12) + 0.0:.6g}" for x in self.at)
        return f"<Tie {self.name!r}: {self.kind}, {len(self.nodes)} nodes about ({at}) m>"

    @property
    def dofs(self) -> Ints:
        """Degrees of freedom of the tied nodes (k d,), ascending."""
        d = self.following.shape[1]
        return np.asarray((self.nodes[:, None] * d + np.arange(d)).ravel())


def resolve(
    problems: Problems, where: str, part: Geometry, interfaces: Sequence[Interface]
) -> tuple[Tie, ...]:
    """Return the ties of a part, or report all problems of its interfaces."""
    nodes, node_sets, d = part.nodes, part.node_sets, part.dofs_per_node
    ties: list[Tie] = []
    owner: dict[int, str] = {}
    names: set[str] = set()
    for interface in interfaces:
        label = f"{where}, interface '{interface.name}'"
        if interface.name in names:
            problems.add(where, f"two interfaces are named '{interface.name}'")
        names.add(interface.name)
        found = _nodes(problems, label, interface, part)
        if found is None:
            continue
        own = node_sets.get(interface.name)
        if own is not None and set(own) != set(found[0].tolist()):
            problems.add(label, "has the name of a node set with other nodes; choose another name")
        shared = next((int(i) for i in found[0] if int(i) in owner), None)
        if shared is not None:
            problems.add(
                label,
                f"node{shared + 1} is tied to interface '{owner[shared]}' already; make the picks "
                f"smaller, so that no node is in two interfaces",
            )
            continue
        owner |= {int(i): interface.name for i in found[0]}
        index, faces = found
        tie = _tie(problems, label, interface, index, (faces, part.faces), nodes, d)
        if tie is not None:
            ties.append(tie)
    return tuple(ties)


def _nodes(
    problems: Problems, label: str, interface: Interface, part: Geometry
) -> tuple[Ints, tuple[Ints, ...]] | None:
    """Return the nodes of an interface, and its faces if it was given by faces."""
    value, nodes, node_sets = interface.nodes, part.nodes, part.node_sets
    if isinstance(value, str):
        if value not in node_sets:
            problems.add(label, f"no node set '{value}'{suggest(value, node_sets)}")
            return None
        return np.array(node_sets[value], dtype=np.int64), tuple(part.surfaces.get(value, ()))
    if isinstance(value, Pick):
        found = np.asarray(value.of(nodes), dtype=np.int64)
        if not len(found):
            low, high = nodes.min(axis=0), nodes.max(axis=0)
            box = " to ".join("(" + ", ".join(f"{x:.4g}" for x in p) + ")" for p in (low, high))
            problems.add(
                label,
                f"the pick contains no node; the nodes lie in {box} m. Check that the pick is in "
                f"m and in the frame of the part",
            )
            return None
        return found, ()
    array = read_integers(value)
    if array is None or array.ndim not in (1, 2) or not array.size:
        problems.add(
            label,
            f"nodes is {value!r}, must be the name of a node set, node indices, faces or a pick"
            " such as InBox(low, high)",
            "nodes",
        )
        return None
    outside = array[(array < 0) | (array >= len(nodes))]
    if len(outside):
        problems.add(label, f"contains node {outside[0]}, must be an index in 0..{len(nodes) - 1}")
        return None
    if array.ndim == 1:
        if len(np.unique(array)) < len(array):
            problems.add(label, "contains a node twice; leave one out")
            return None
        return array, ()
    if array.shape[1] not in KINDS:
        known = ", ".join(f"{k} ({kind})" for k, kind in KINDS.items())
        problems.add(label, f"its faces have {array.shape[1]} nodes, must be {known}")
        return None
    return np.unique(array), (array,)


def _tie(
    problems: Problems,
    label: str,
    interface: Interface,
    found: Ints,
    faces: Sequence[Sequence[Ints]],
    nodes: Array,
    d: int,
) -> Tie | None:
    order = np.argsort(found)
    index = found[order]
    k, x = len(index), nodes[index]

    # weights: given, by area, or equal
    by_area = False
    if interface.weights is not None:
        if len(interface.weights) != k:
            problems.add(label, f"has {len(interface.weights)} weights for {k} nodes")
            return None
        weights = interface.weights[order]
    else:
        weights = np.ones(k)
    found_areas = (_area(nodes, index, some) for some in faces)
    share = next((area for area in found_areas if area is not None), None)
    if share is not None and interface.weights is None:
        by_area = True
        weights = np.asarray(share.sum(axis=1))

    # reference point
    at = interface.at
    if at is None:
        at = cylinder_middle(x)
    if at is None:
        at = weights @ x / weights.sum()
    s = x - at

    following = np.zeros((k, d, 6))
    following[:, :3, :3] = np.eye(3)
    following[:, :3, 3:] = -skew(s)
    weighted = weights[:, None, None] * following
    if by_area:
        assert share is not None
        weighted[:, :3] = (share @ following[:, :3].reshape(k, 18)).reshape(k, 3, 6)
    # scale rotations of rigid ties by the distance of the other nodes
    size = float(np.sqrt(weights @ np.einsum("ka,ka->k", s, s) / weights.sum()))
    if d == 6:
        following[:, 3:, 3:] = np.eye(3)
        if interface.kind == "rigid":
            arm = size**2 if size > 0.0 else 1.0
            weighted[:, 3:, 3:] = (weights * arm)[:, None, None] * np.eye(3)
    G = np.einsum("kda,kdb->ab", following, weighted)
    scale = np.repeat([1.0, 1.0 / size if size > 0.0 else 1.0], 3)
    values = np.linalg.eigvalsh(scale[:, None] * G * scale)
    conditioning = float(np.sqrt(max(values[0], 0.0) / values[-1]))
    if conditioning < LOOSE:
        remedy = "pick nodes of a surface, or name the node set itself among the interfaces of the"
        what = "one point" if np.ptp(x, axis=0).max() == 0.0 else "one line"
        problems.add(
            label,
            f"its {k} node{'s'[: k != 1]} lie{'s'[: k == 1]} on {what}, so that the rotation "
            f"about it is undetermined; {remedy} reduction",
        )
        return None
    if conditioning < NARROW:
        warn(
            label,
            f"the {k} tied nodes lie almost on a line or far from the reference point (least motion"
            f" {conditioning:.1e} of the largest): moments there cause very large strains; pick a "
            f"wider surface or move the reference point",
        )
    averaging = scale[:, None] * np.linalg.solve(
        scale[:, None] * G * scale, scale[:, None] * weighted.reshape(k * d, 6).T
    )
    return Tie(
        name=interface.name,
        kind=interface.kind,
        nodes=index,
        at=read_only(at),
        following=read_only(following),
        averaging=read_only(averaging),
        conditioning=conditioning,
        by_area=by_area,
    )


def _area(nodes: Array, index: Ints, faces: Sequence[Ints]) -> Any:
    """Return ``int N N^T dA`` (k, k) over the faces among the nodes; None if a node has no face."""
    inside = np.zeros(len(nodes), dtype=bool)
    inside[index] = True
    chosen = [group[np.all(inside[group], axis=1)] for group in faces if len(group)]
    covered = np.zeros(len(nodes), dtype=bool)
    for group in chosen:
        covered[group] = True
    if not np.all(covered[index]):
        return None
    local = np.zeros(len(nodes), dtype=np.int64)
    local[index] = np.arange(len(index))
    return area_matrix(nodes[index], [local[group] for group in chosen])
