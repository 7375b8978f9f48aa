"""Builder: joints, forces, signals and coordinates in the small vocabulary of the engine."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jousto.engine.model import (
    CoordinateModel,
    EventModel,
    ForceModel,
    FrictionModel,
    JointModel,
    MarkerModel,
    SignalModel,
)
from jousto.mechanism import FlexibleBody, Force, Harmonic, Marker, Step, Table, Torque

# constraint rows after the coincidence: (axis of a) . (axis of b) = 0; z is the joint's axis
PERPENDICULAR: dict[str, tuple[tuple[int, int], ...]] = {
    "Spherical": (),
    "Revolute": ((0, 2), (1, 2)),
    "Fixed": ((0, 2), (1, 2), (0, 1)),
}


class Builder:
    """Collects the engine's objects; what is used twice is kept once.

    Parameters
    ----------
    bodies : dict of int to int
        Index of every moving body by its id.
    """

    def __init__(self, bodies: dict[int, int]) -> None:
        self._bodies = bodies
        self.markers: list[MarkerModel] = []
        self.coordinates: list[CoordinateModel] = []
        self.joints: list[JointModel] = []
        self.signals: list[SignalModel] = []
        self.forces: list[ForceModel] = []
        self.frictions: list[FrictionModel] = []
        self.events: list[EventModel] = []
        self._places: dict[Any, int] = {}

    def marker(self, marker: Marker, turns: bool, *, shared: bool = True) -> int:
        """Return the index of the frame; `turns` if its rotation matters at every evaluation.

        Frames that are `shared` are looked up first: joints at one node use one frame.
        """
        body = self._bodies.get(id(marker.body), -1)
        Phi = Psi = chi = None
        if isinstance(marker.body, FlexibleBody):
            Phi = np.array(marker.Phi, dtype=float)
            Psi = np.array(marker.Psi, dtype=float)
            if not np.any(Psi):
                Psi = None
            field = marker.body.reduced.stiffening
            if field is not None and marker.node is not None:
                at = marker.node
                chi = np.concatenate([field.translations[at], field.rotations[at]])
        u0, A0 = np.array(marker.position_local, dtype=float), np.array(marker.axes, dtype=float)
        key = ("marker", body, marker.node, u0.tobytes(), A0.tobytes())
        if shared and key in self._places:
            place = self._places[key]
            if turns:
                self.markers[place] = replace(self.markers[place], turns=True, Psi=Psi)
            return place
        self.markers.append(MarkerModel(body, turns, u0, A0, Phi, Psi if turns else None, chi))
        if shared:
            self._places[key] = len(self.markers) - 1
        return len(self.markers) - 1

    def coordinate(
        self, name: str, kind: str, a: Marker, b: Marker, axis_a: int = 2, axis_b: int = 2
    ) -> int:
        """Return the index of a coordinate: "axes", "along", "distance" or "angle"."""
        place_a = self.marker(a, kind != "distance")
        place_b = self.marker(b, kind in ("axes", "angle"))
        key = ("coordinate", kind, place_a, place_b, axis_a, axis_b)
        if key not in self._places:
            self._places[key] = len(self.coordinates)
            self.coordinates.append(CoordinateModel(name, kind, place_a, place_b, axis_a, axis_b))
        return self._places[key]

    def joint(self, joint: Any) -> int:
        """Return the index of a joint."""
        if type(joint).__name__ not in PERPENDICULAR:
            raise TypeError(f"no engine rows for {type(joint).__name__}")
        perpendicular = PERPENDICULAR[type(joint).__name__]
        sides = tuple(self.marker(marker, bool(perpendicular)) for marker in joint.frames)
        row = sum(other.rows for other in self.joints)
        self.joints.append(JointModel(joint.name, sides, True, perpendicular, row))
        return len(self.joints) - 1

    def signal(self, signal: Any) -> int:
        """Return the index of a signal, -1 for none."""
        if signal is None:
            return -1
        key = ("signal", id(signal))
        if key not in self._places:
            model = _signal(signal)
            self._places[key] = len(self.signals)
            self.signals.append(model)
        return self._places[key]

    def force(self, load: Any) -> int:
        """Return the index of what pushes."""
        if not isinstance(load, Force | Torque):
            raise TypeError(f"no engine force for {type(load).__name__}")
        zero = np.zeros(3)
        force, torque = (load.vector, zero) if isinstance(load, Force) else (zero, load.vector)
        self.forces.append(
            ForceModel(
                name=load.name,
                kind="load",
                data=np.concatenate([force, torque]),
                b=self.marker(load.marker, load.follow or not isinstance(load, Force)),
                follow=load.follow,
                signal=self.signal(load.signal),
            )
        )
        return len(self.forces) - 1


def _signal(signal: Any) -> SignalModel:
    if isinstance(signal, Harmonic):
        omega = 2 * np.pi * signal.frequency
        data = np.array([signal.offset, signal.amplitude, omega, signal.phase])
        return SignalModel("harmonic", data)
    if isinstance(signal, Step):
        return SignalModel("step", np.array([signal.time, signal.before, signal.after]))
    if isinstance(signal, Table) and signal.interpolation == "linear":
        data = np.concatenate([signal.times, signal.values])
        return SignalModel("table", data, count=len(signal.times))
    raise TypeError(f"no engine signal for {type(signal).__name__}")
