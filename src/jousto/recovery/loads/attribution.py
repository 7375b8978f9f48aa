"""Attribution of the engine's loads on a body: name, kind and place of each force and joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.model.model import ForceModel, JointModel, MarkerModel, Model

DISTRIBUTED = {"modal load": "distributed load", "moving load": "moving load"}
"""Kind of a load without a fixed place by its law; others have that of the declared force."""


@dataclass(frozen=True, eq=False)
class Source:
    """Force, friction or joint that acts on a body.

    Attributes
    ----------
    name, kind : str
    rows : tuple of int
        Indices of its rows in the loads of the engine (`Engine.body_loads`), which are added.
    markers : tuple of MarkerModel
        Different places on the body at which it acts; empty if it acts on the whole body.
    """

    name: str
    kind: str
    rows: tuple[int, ...]
    markers: tuple[MarkerModel, ...]

    @property
    def place(self) -> str:
        """Labels of the places at which it acts, ``body.point``."""
        return ", ".join(label(marker) for marker in self.markers)

    @property
    def position(self) -> Array | None:
        """Its place on the undeformed body (3,), m, if it acts at a single place."""
        one = len(self.markers) == 1
        return np.array(np.real(self.markers[0].u0)) if one else None

    @property
    def node(self) -> int | None:
        """Node of a flexible body at which it acts; None for several places or no node."""
        sites = [m.site.node for m in self.markers if m.site is not None]
        return sites[0] if len(sites) == len(self.markers) == 1 else None

    def points(self, p: Array, center: Array) -> Array:
        """Return its place in the body frame (nt, 3), m: its first marker, else the centre.

        ``u = u0 + Phi p + chi(p, p) / 2``, with the second-order displacement chi of a part with
        stiffening.

        Parameters
        ----------
        p : (nt, n) array
            Modal coordinates.
        center : (nt, 3) array
            Centre of mass, body frame, m.
        """
        if not self.markers:
            return center
        marker = self.markers[0]
        u = np.real(marker.u0) + np.zeros((len(p), 3))
        if marker.Phi is not None:
            u = u + p @ np.real(marker.Phi).T
        if marker.chi is not None:
            bend = np.real(marker.chi[:3])
            u = u + 0.5 * np.einsum("cjk,tj,tk->tc", bend, p, p, optimize=True)
        return u


def sources(model: Model, body: int) -> list[Source]:
    """Return what acts on a body: joints and couplings, then forces, then friction."""
    forces, frictions = len(model.forces), len(model.frictions)
    locks = {friction.lock for friction in model.frictions if friction.sticks}
    found = []
    for j, joint in enumerate(model.joints):
        at = on_body(model, body, joint_markers(model, joint))
        if at and j not in locks:
            kind = "joint" if joint.coincident or joint.perpendicular else coupling_kind(joint)
            found.append(Source(joint.name, kind, (forces + frictions + j,), at))
    for i, force in enumerate(model.forces):
        at = on_body(model, body, force_markers(model, force))
        if at or force.body == body:
            kind = DISTRIBUTED.get(force.kind, force.element or force.kind)
            rows = tuple(range(i, i + 1 + force.slots))
            found.append(Source(force.name, kind, rows, at))
    for i, friction in enumerate(model.frictions):
        slides = [s for s in (friction.coordinate, friction.other) if s >= 0]
        markers = [m for s in slides for m in coordinate_markers(model, s)]
        at = on_body(model, body, markers)
        if at:
            rows = (forces + i, *([forces + frictions + friction.lock] if friction.sticks else []))
            found.append(Source(friction.name, "friction", rows, at))
    return found


def coupling_kind(joint: JointModel) -> str:
    """Return "drive" for a row with a signal of time, else "coupling"; a joint of lines alone too.

    Gears, racks and couplings relate coordinates to each other.
    """
    return "drive" if any(line.signal >= 0 for line in joint.lines) else "coupling"


def coordinate_markers(model: Model, coordinate: int) -> tuple[int, int]:
    """Return the markers a and b of a coordinate."""
    return model.coordinates[coordinate].a, model.coordinates[coordinate].b


def joint_markers(model: Model, joint: JointModel) -> list[int]:
    """Return the markers at which a joint or coupling acts."""
    along = [
        m for line in joint.lines for s in line.coordinates for m in coordinate_markers(model, s)
    ]
    return [*joint.sides, *along]


def force_markers(model: Model, force: ForceModel) -> list[int]:
    """Return the markers at which a force acts."""
    along = [m for place in force.coordinates for m in coordinate_markers(model, place)]
    return [m for m in (force.a, force.b, *force.touches, *along) if m >= 0]


def on_body(model: Model, body: int, markers: list[int]) -> tuple[MarkerModel, ...]:
    """Return the markers of a body at different places."""
    found: dict[bytes, MarkerModel] = {}
    for marker in (model.markers[m] for m in markers):
        if marker.body == body:
            found.setdefault(np.asarray(np.real(marker.u0)).tobytes(), marker)
    return tuple(found.values())


def label(marker: MarkerModel) -> str:
    """Return the label of a marker, ``body.point``, or its position if it was not declared."""
    if marker.site is not None:
        return marker.site.label
    return "({:g}, {:g}, {:g}) m".format(*np.real(marker.u0))
