"""Clamp and SpringSupport: supports of nodes of a part."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, count
from jousto.base.fields import Field, field
from jousto.base.numbers import OptionalValues
from jousto.mesh.picks import Pick
from jousto.parts.interface import Tied

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")

TWO = (slice(0, 3), slice(3, 6))  # translations and rotations

SYMMETRY = 1e-9  # asymmetry of a stiffness over its largest entry, above which it is refused
INDEFINITE = 1e-9  # negative eigenvalue over the largest one, above which it is refused


class Directions(Field[Any, "tuple[str, ...]"]):
    """Field of directions of a node; None for all directions that the node has."""

    form = "texts"
    noun = "str or sequence of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the directions in the order x, y, z, rx, ry, rz, or report unknown ones."""
        if value is None:
            return ()
        words = value.replace(",", " ").split() if isinstance(value, str) else value
        try:
            given = tuple(words)
        except TypeError:
            given = (value,)
        unknown = [word for word in given if word not in DIRECTIONS]
        if unknown or not given:
            found = repr(unknown[0]) if unknown else "empty"
            problems.add(
                where, f"directions: {found}, must be of {', '.join(DIRECTIONS)}", self.name
            )
        elif len(set(given)) < len(given):
            problems.add(where, "directions: one is given twice", self.name)
        return tuple(word for word in DIRECTIONS if word in given)


class NodeStiffness(Field[Any, Array]):
    """Field of the stiffness of a node: six numbers or a (6, 6) matrix."""

    form = "array"
    noun = "(6,) or (6, 6) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the matrix (6, 6), or report a matrix that is not a stiffness."""
        shape = (6, 6) if np.ndim(value) == 2 else (6,)
        given = problems.array(where, self.name, value, shape)
        if given is None:
            return None
        K = np.diag(given) if given.ndim == 1 else given
        if not K.any():
            problems.add(where, "stiffness is zero, must hold the nodes", self.name)
            return None
        if np.abs(K - K.T).max() > SYMMETRY * np.abs(K).max():
            problems.add(where, "stiffness is not symmetric", self.name)
            return None
        # unit diagonal, since N/m and N m/rad differ in size
        size = np.sqrt(np.abs(np.diag(K)))
        size[size == 0.0] = 1.0
        lowest = np.linalg.eigvalsh(K / np.outer(size, size))[0]
        if np.diag(K).min() < 0.0 or lowest < -INDEFINITE:
            message = "stiffness has a negative eigenvalue: it is unstable and pushes nodes away"
            problems.add(where, message, self.name)
        return read_only(0.5 * (K + K.T))


def marker_hint(on: Any) -> str:
    """Return a hint for messages if `on` is a marker such as ``body["end"]``; else nothing."""
    point, body = getattr(on, "point", None), getattr(on, "body", None)
    if not isinstance(point, str) or body is None:
        return ""
    name = getattr(body, "name", "")
    return f"is a marker of body {name!r}; use the name of the node, {point!r}"


class Support(Declared):
    """Base of the supports of nodes of a part."""

    on: Tied = field(
        "Nodes: a node set such as ``start`` or ``node7``, a rigid interface, indices from 0, or a "
        "pick such as ``InBox``"
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages."""
        return f"{type(self).__name__} on {self.label}"

    def __post_init__(self) -> None:
        """Check the values, and that no marker is given in place of nodes."""
        if hint := marker_hint(self.on):
            where = f"{type(self).__name__} on {self.on!r}"
            raise InputError(Problem(where, f"on {hint}", path=("on",)))
        super().__post_init__()

    @property
    def label(self) -> str:
        """Name in messages and tables."""
        if isinstance(self.on, str):
            return repr(self.on)
        if isinstance(self.on, Pick):
            return type(self.on).__name__
        return count(int(np.size(self.on)), "node")


class Clamp(Support):
    """Clamp: nodes that are held in all or some directions, or displaced by a settlement.

    Raises
    ------
    InputError
        For unknown directions, or a settlement in a direction that is not held.

    Examples
    --------
    >>> Clamp("start", "x y z", settlement=(0, 0, -1e-3, 0, 0, 0))
    <Clamp 'start': x y z>
    """

    directions: Directions = field(
        "Held directions in part axes: translations x y z, rotations rx ry rz, as in ``'x y rz'``; "
        "all that the nodes have if not given",
        default=None,
    )
    settlement: OptionalValues = field(
        "Imposed motion: displacement in m and rotation in rad, of several nodes together about "
        "their centroid; none if not given",
        shape=(6,),
        default=None,
    )

    def __repr__(self) -> str:
        return f"<Clamp {self.label}: {' '.join(self.directions or ()) or 'all directions'}>"

    @property
    def motion(self) -> Array:
        """The settlement (6,), m and rad."""
        return np.zeros(6) if self.settlement is None else np.asarray(self.settlement)


class SpringSupport(Support):
    """Nodes on springs to the ground, ``f = -K_s u`` for each node.

    Raises
    ------
    InputError
        If the stiffness is not symmetric or not positive semidefinite.

    Examples
    --------
    >>> SpringSupport("end", (0, 0, 2e5, 0, 0, 0))
    <SpringSupport 'end': up to 200000 N/m, 0 N m/rad>
    """

    stiffness: NodeStiffness = field(
        "Stiffness of each node in part axes: x y z in N/m, rx ry rz in N m/rad; six numbers or a "
        "(6, 6) matrix"
    )

    def __repr__(self) -> str:
        push, turn = (float(np.diag(self.stiffness)[part].max()) for part in TWO)
        return f"<SpringSupport {self.label}: up to {push:g} N/m, {turn:g} N m/rad>"
