"""Loads distributed along a beam."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, read_only
from jousto.base.complexstep import floats
from jousto.base.errors import Problems
from jousto.base.fields import Field, Flag, Reference, field
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.signals.base import OptionalSignal

EVEN = 1e-12  # relative moment below which the couples of two neighbouring elements cancel


class BeamField(Reference[BeamBody, BeamBody]):
    """Field of an exact beam; a model file contains its name."""

    section = "bodies"
    word = "beam"
    noun = "BeamBody"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the beam, or report a value of another type."""
        if not isinstance(value, BeamBody):
            problems.add(where, f"{self.label} is {value!r}, must be a BeamBody")
        return value


class Rows(Field[ArrayLike, Array]):
    """Field of three numbers, or of three numbers for every node of a beam."""

    form = "shapes"
    shapes = ((3,), (None, 3))
    noun = "(3,) or (n + 1, 3) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the numbers as an array, or report wrong ones."""
        shape = (None, 3) if np.ndim(value) == 2 else (3,)
        return problems.array(where, self.name, value, shape)


class LineLoad(ForceElement, tag="line"):
    """Force and torque per length along a beam.

    They act on the section axis and vary linearly between nodes: an element of unstressed length L
    with the values q_a and q_b at its ends gets ``L (2 q_a + q_b)/6`` at end a and ``L (q_a + 2
    q_b)/6`` at end b. Elements with `bending` also bend between their ends. In these elements the
    loads ``L (3 q_a + q_b)/8`` and ``L (q_a + 3 q_b)/8`` act at L/6 from the ends, which gives the
    moments ``q L^2/12`` of the cubic element; they turn with the beam. Gravity needs no line load,
    since it acts on the mass; the corresponding moments of gravity are included by
    ``mass="corrected"``.

    Examples
    --------
    >>> from jousto import Circle, Material
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> cable = BeamBody("cable", [(0, 0, 0), (3, 0, 0)], Circle(0.01), steel, elements=3)
    >>> wind = LineLoad("wind", cable, (0, 12.0, 0))
    >>> [float(force[1]) for marker, force, torque in wind.loads]
    [6.0, 12.0, 12.0, 6.0]
    """

    kind = "line load"
    unmeasured = "acts all along a beam; take a SectionSensor, or ForceSensors on point forces"
    together = ("beam", "force", "torque")
    beam: BeamField = field("The beam")
    force: Rows = field(
        "Force per unstressed length everywhere, or at every node: in the world frame, or in "
        "section axes if `follow`",
        unit="N/m",
        default=(0.0, 0.0, 0.0),
    )
    torque: Rows = field(
        "Torque per unstressed length, in the axes of the force",
        unit="N m/m",
        default=(0.0, 0.0, 0.0),
        kw_only=True,
    )
    follow: Flag = field(
        "Whether the load turns with the sections, as pressure does", default=False, kw_only=True
    )
    signal: OptionalSignal = field(
        "Factor on the load as a function of time; None for 1",
        unit="1",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Store a row for every node; report a wrong number of rows, or a zero load."""
        shape = (self.beam.n + 1, 3)
        for key in ("force", "torque"):
            rows = getattr(self, key)
            if rows.ndim == 2 and problems.array(where, key, rows, shape) is None:
                return
            object.__setattr__(self, key, read_only(np.broadcast_to(rows, shape)))
        if not (np.any(self.force) or np.any(self.torque)):
            problems.add(where, "force and torque are zero; give force=(x, y, z) in N/m", "force")

    def __repr__(self) -> str:
        return f"<LineLoad {self.name!r}: on {self.beam.name}>"

    @property
    def drawn_at(self) -> tuple[Marker, ...]:
        """The nodes of the beam."""
        return tuple(self.beam[f"node{k + 1}"] for k in range(self.beam.n + 1))

    @property
    def direction(self) -> tuple[Array, bool] | None:
        """Direction of the mean force, in section axes if it follows the beam."""
        mean = np.array(floats(self.force)).mean(axis=0)
        return (mean, self.follow) if mean.any() else None

    @property
    def pushes(self) -> tuple[Push, ...]:
        """Point loads at the loaded nodes."""
        return tuple(
            Push(
                "load",
                {"force": force, "torque": torque},
                b=marker,
                turns=self.follow or bool(np.any(torque)),
                follow=self.follow,
                signal=self.signal,
            )
            for marker, force, torque in self.loads
        )

    @property
    def loads(self) -> tuple[tuple[Marker, Array, Array], ...]:
        """Marker, force (3,) in N and torque (3,) in N m at every loaded node.

        Resolved in the world frame, or in the marker's axes if the load follows.
        """
        beam = self.beam
        T = self._at_nodes(self._at_ends(self.torque, 3.0))
        arms = np.concatenate([np.zeros((beam.n + 1, 1)), beam.offsets], axis=1)
        if not beam.bending:
            F = self._at_nodes(self._at_ends(self.force, 3.0))
            acting = [(i, arms[i], F[i], T[i]) for i in range(beam.n + 1)]
        else:
            acting = self._inside(arms, T)
        return tuple(
            (beam.node(i, at=at), force, torque)
            for i, at, force, torque in acting
            if np.any(force) or np.any(torque)
        )

    def _inside(self, arms: Array, T: Array) -> list[tuple[int, Array, Array, Array]]:
        """Return node, position, force and torque of loads at L/6 from the ends of the elements.

        Loads of two neighbouring elements whose moments cancel become one load at the node.
        """
        beam, zero = self.beam, np.zeros(3)
        nodes = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
        along = np.einsum("neji,nej->nei", nodes, beam.ends[..., 0])  # in the axes of the nodes
        along *= beam.lengths[:, None, None] / 6 * np.array([1.0, -1.0])[:, None]
        F = self._at_ends(self.force, 4.0)
        out = [(0, arms[0] + along[0, 0], F[0, 0], T[0])]
        for i in range(1, beam.n):
            before, after = F[i - 1, 1], F[i, 0]
            couples = np.outer(along[i - 1, 1], before) + np.outer(along[i, 0], after)
            size = np.abs(np.outer(along[i, 0], after)).max()
            if np.abs(couples).max() <= EVEN * size:
                out.append((i, arms[i], before + after, T[i]))
                continue
            out.append((i, arms[i] + along[i - 1, 1], before, T[i]))
            out.append((i, arms[i] + along[i, 0], after, zero))
        return [*out, (beam.n, arms[-1] + along[-1, 1], F[-1, 1], T[-1])]

    def _at_ends(self, q: Array, parts: float) -> Array:
        """Return loads (n, 2, 3) at element ends from a load per length (n + 1, 3) at nodes.

        The load per length at the nearer end has ``parts - 1`` times the weight of the other: parts
        = 3 for loads at the ends, 4 for loads at L/6. The loads are resolved in node axes if the
        load follows the beam.
        """
        beam = self.beam
        L = beam.lengths[:, None] / (2 * parts)
        near = parts - 1.0
        ends = np.stack([L * (near * q[:-1] + q[1:]), L * (q[:-1] + near * q[1:])], axis=1)
        if self.follow:  # at corners the section axes of the elements differ from those of the node
            nodes = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
            ends = np.einsum("neji,nejk,nek->nei", nodes, beam.ends, ends)
        return np.asarray(ends)

    def _at_nodes(self, ends: Array) -> Array:
        """Return the sums (n + 1, 3) of the loads at each node."""
        out = np.zeros((self.beam.n + 1, 3))
        out[:-1] += ends[:, 0]
        out[1:] += ends[:, 1]
        return out
