"""Loads distributed along a beam."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.errors import Problems
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.base.rotations import Array, readonly
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.signals.base import Signal, check_signal

EVEN = 1e-12  # of a couple: those of two neighbours cancel


@dataclass(frozen=True, eq=False, init=False, repr=False)
class LineLoad:
    """A force and a torque per length along a beam.

    They act on the section axis between its nodes with linear shape functions: on an element of
    unstressed length L, which ends with q_a and q_b, ``L (2 q_a + q_b)/6`` acts at end a and
    ``L (q_a + 2 q_b)/6`` at end b. On beams with `bending` the element bends between its ends, and
    ``L (3 q_a + q_b)/8``, ``L (q_a + 3 q_b)/8`` act a sixth of L inside them: the moments
    ``q L^2/12`` of the cubic, which turn with the beam. Gravity needs no load, it acts on the mass
    by itself; such moments of weight come with ``mass="corrected"``.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    beam : BeamBody
        The beam.
    force : (3,) or (n + 1, 3) array_like
        Force per unstressed length, N/m, everywhere or at every node: in the world frame, or in
        section axes if `follow`.
    torque : (3,) or (n + 1, 3) array_like
        Torque per unstressed length, N m/m, in the same axes.
    follow : bool
        Whether the load turns with the sections, as pressure does.
    signal : Signal or float, optional
        Factor on the load as a function of time; None for 1.

    Raises
    ------
    InputError
        With everything that is wrong.

    Examples
    --------
    >>> from jousto import Circle, Material
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> cable = BeamBody("cable", [(0, 0, 0), (3, 0, 0)], Circle(0.01), steel, elements=3)
    >>> wind = LineLoad("wind", cable, (0, 12.0, 0))
    >>> [float(force[1]) for marker, force, torque in wind.loads]
    [6.0, 12.0, 12.0, 6.0]
    """

    kind: ClassVar[str] = "line load"
    name: str
    beam: BeamBody
    force: Array
    torque: Array
    follow: bool
    signal: Signal | None

    def __init__(
        self,
        name: str,
        beam: BeamBody,
        force: ArrayLike = (0.0, 0.0, 0.0),
        *,
        torque: ArrayLike = (0.0, 0.0, 0.0),
        follow: bool = False,
        signal: Signal | float | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        checked: Any = beam
        if not isinstance(checked, BeamBody):
            problems.add(where, f"beam is {checked!r}, must be a BeamBody")
            problems.raise_if_any()
        n = beam.n
        q, m = (
            problems.array(where, key, value, (n + 1, 3) if np.ndim(value) == 2 else (3,))
            for key, value in (("force", force), ("torque", torque))
        )
        factor = None if signal is None else check_signal(problems, where, "signal", signal)
        if q is not None and m is not None and not (np.any(q) or np.any(m)):
            problems.add(where, "force and torque are zero; give force=(x, y, z) in N/m")
        problems.raise_if_any()
        assert q is not None and m is not None
        set_fields(
            self,
            name=name,
            beam=beam,
            force=readonly(np.broadcast_to(q, (n + 1, 3))),
            torque=readonly(np.broadcast_to(m, (n + 1, 3))),
            follow=bool(follow),
            signal=factor,
        )

    def __repr__(self) -> str:
        return f"<LineLoad {self.name!r}: on {self.beam.name}>"

    @property
    def loads(self) -> tuple[tuple[Marker, Array, Array], ...]:
        """Marker, force (3,) N and torque (3,) N m at every node that is loaded.

        In the world frame, or in the marker's axes if the load follows.
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
        """Return node, place, force and torque of loads a sixth of the elements from their ends.

        Those of two neighbours whose moments cancel are one load at the node.
        """
        beam, zero = self.beam, np.zeros(3)
        nodes = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
        along = np.einsum("neji,nej->nei", nodes, beam.ends[..., 0])  # axes of nodes
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
        """Return loads (n, 2, 3) at the elements' ends of one per length (n + 1, 3).

        The nearer end's value counts ``parts - 1`` times the other: 3 for forces at the ends, 4
        for such a sixth inside. In axes of the nodes if the load follows.
        """
        beam = self.beam
        L = beam.lengths[:, None] / (2 * parts)
        near = parts - 1.0
        ends = np.stack([L * (near * q[:-1] + q[1:]), L * (q[:-1] + near * q[1:])], axis=1)
        if self.follow:  # at corners the sections of the elements are not that of the node
            nodes = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
            ends = np.einsum("neji,nejk,nek->nei", nodes, beam.ends, ends)
        return np.asarray(ends)

    def _at_nodes(self, ends: Array) -> Array:
        """Return the sums (n + 1, 3) at the nodes."""
        out = np.zeros((self.beam.n + 1, 3))
        out[:-1] += ends[:, 0]
        out[1:] += ends[:, 1]
        return out
