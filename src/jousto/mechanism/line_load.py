"""Loads distributed along a beam."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.errors import Problems
from jousto.mechanism.beam import BeamBody
from jousto.mechanism.fields import set_fields
from jousto.mechanism.marker import Marker
from jousto.mechanism.orientation import Array, readonly
from jousto.mechanism.signals import Signal, check_factor
from jousto.names import check_name


@dataclass(frozen=True, eq=False, init=False, repr=False)
class LineLoad:
    """A force and a torque per length along a beam.

    They act on the section axis between its nodes with linear shape functions: on an element of
    unstressed length L, which ends with q_a and q_b, ``L (2 q_a + q_b)/6`` acts at end a and
    ``L (q_a + 2 q_b)/6`` at end b. Gravity needs no load, it acts on the beam's mass by itself.

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
    signal : Signal, optional
        Factor on the load as a function of time; None for 1.

    Raises
    ------
    InputError
        With everything that is wrong.

    Examples
    --------
    >>> from jousto.parts import Circle, Material
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
        signal: Signal | None = None,
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
        factor = None if signal is None else check_factor(problems, where, "signal", signal)
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
        return f"<LineLoad {self.name!r} on {self.beam.name}>"

    @property
    def loads(self) -> tuple[tuple[Marker, Array, Array], ...]:
        """Marker, force (3,) N and torque (3,) N m at every node that is loaded.

        In the world frame, or in the marker's axes if the load follows.
        """
        beam = self.beam
        F, T = (self._at_nodes(q) for q in (self.force, self.torque))
        arms = np.concatenate([np.zeros((beam.n + 1, 1)), beam.offsets], axis=1)
        return tuple(
            (beam.node(i, at=arms[i]), F[i], T[i])
            for i in range(beam.n + 1)
            if np.any(F[i]) or np.any(T[i])
        )

    def _at_nodes(self, q: Array) -> Array:
        """Return what linear shape functions make of a load per length (n + 1, 3)."""
        beam = self.beam
        L = beam.lengths[:, None] / 6
        ends = np.stack([L * (2 * q[:-1] + q[1:]), L * (q[:-1] + 2 * q[1:])], axis=1)
        if self.follow:  # at corners the sections of the elements are not that of the node
            nodes = np.stack([beam.frames[:-1], beam.frames[1:]], axis=1)
            ends = np.einsum("neji,nejk,nek->nei", nodes, beam.ends, ends)
        out = np.zeros((beam.n + 1, 3))
        out[:-1] += ends[:, 0]
        out[1:] += ends[:, 1]
        return out
