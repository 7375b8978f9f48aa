"""Geoms of MJCF: shapes with mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.base.errors import InputError
from jousto.base.rotations import turn_onto
from jousto.mechanism.bodies.shapes import Solid, closed_surface
from jousto.robots.description import Frame
from jousto.robots.markup import Element, Reading
from jousto.robots.meshes import Folders, solid_of

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
LINES = ("capsule", "cylinder", "box", "ellipsoid")


@dataclass(frozen=True, eq=False)
class Geom:
    """A shape with its mass: centre, inertia about it and triangles in the frame of its body."""

    mass: float
    center: Array
    inertia: Array
    triangles: Array


class Places(Protocol):
    """What reads places."""

    def frame(self, element: Element) -> Frame:
        """Return the place and orientation that an element gives."""


class Geoms:
    """Reads the shapes of a file.

    Parameters
    ----------
    reading : Reading
        Where problems are noted.
    folders : Folders
        Where meshes may be.
    places : Places
        What reads places and orientations.
    """

    def __init__(self, reading: Reading, folders: Folders, places: Places) -> None:
        self.reading, self.folders, self.places = reading, folders, places
        self.meshes: dict[str, Array | None] = {}

    def asset(self, element: Element, given: Element) -> None:
        """Read a mesh."""
        file = given.given.get("file", "")
        name = given.given.get("name", file.rpartition("/")[2].rpartition(".")[0])
        scale = self.reading.vector(given, "scale", (1.0, 1.0, 1.0))
        if "vertex" in given.given or not file:
            self.reading.leave_out(element, "mesh of vertices")
            self.meshes[name] = None
            return
        self.meshes[name] = self.folders.mesh(self.reading, given, file, scale)

    def read(self, element: Element, at: Frame) -> Geom | None:
        """Return a geom, or None for one without volume."""
        kind = element.given.get("type", "mesh" if "mesh" in element.given else "sphere")
        if kind in ("plane", "hfield", "sdf"):
            return None
        if kind == "mesh" or kind not in SIZES:
            solid, place = self.mesh(element, kind), at @ self.places.frame(element)
        else:
            sizes, place = self.sized(element, kind, at)
            solid = solid_of(self.reading, element, kind, sizes)
        if solid is None:
            return None
        mass = self.reading.number(element, "density", 1000.0) * solid.volume
        if "mass" in element.given:
            mass = self.reading.number(element, "mass")
        if mass < 0.0:
            self.reading.add(element, f"mass is {mass:g} kg, must not be negative")
        share = mass / solid.volume if solid.volume > 0.0 else 0.0
        return Geom(
            mass,
            place.r + place.A @ solid.center,
            share * place.A @ solid.inertia @ place.A.T,
            place.r + solid.triangles @ place.A.T,
        )

    def sized(self, element: Element, kind: str, at: Frame) -> tuple[Array, Frame]:
        """Return the sizes of a solid and where it is."""
        count = SIZES[kind]
        text = element.given.get("size", "")
        words = text.split()
        if "fromto" not in element.given or kind not in LINES:
            # sizes that a form does not need may stand there
            half = self.reading.numbers(
                element, " ".join(words[:count]) or None, "size", count, None
            )
            return _lengths(kind, half), at @ self.places.frame(element)
        ends = self.reading.numbers(element, element.given["fromto"], "fromto", 6, None)
        axis = ends[3:] - ends[:3]
        long = float(np.linalg.norm(axis))
        if long < 1e-9:
            self.reading.add(element, "fromto has no length")
            axis, long = np.array([0.0, 0.0, 1.0]), 1.0
        radius = self.reading.numbers(element, " ".join(words[:1]) or None, "size", 1, None)[0]
        half = np.array([radius, radius, 0.5 * long])
        if kind in ("capsule", "cylinder"):
            half = half[1:]
        place = Frame(0.5 * (ends[:3] + ends[3:]), turn_onto(np.eye(3), axis))
        return _lengths(kind, half), at @ place

    def mesh(self, element: Element, kind: str) -> Solid | None:
        """Return the solid of a mesh, or None with a note."""
        name = element.given.get("mesh", "")
        if kind != "mesh":
            self.reading.leave_out(element, f"geom of type {kind}")
            return None
        if name not in self.meshes:
            self.reading.add(element, f"no mesh {name!r} among the assets")
            return None
        triangles = self.meshes[name]
        if triangles is None:
            return None
        try:
            return closed_surface("mesh", triangles)
        except InputError as error:
            message = error.problems[0].message
            self.reading.note(element, f"the mesh {name!r} has no mass: {message}")
            return Solid(0.0, np.zeros(3), np.zeros((3, 3)), triangles)

    def total(self, parts: Sequence[Geom]) -> tuple[float, Array, Array]:
        """Return mass, centre and inertia about it of several geoms."""
        mass = sum(part.mass for part in parts)
        if not mass > 0.0:
            return 0.0, np.zeros(3), np.zeros((3, 3))
        center = sum(part.mass * part.center for part in parts) / mass
        inertia = np.zeros((3, 3))
        for part in parts:
            X = skew(part.center - center)
            inertia += part.inertia - part.mass * X @ X
        return mass, np.asarray(center), inertia


def _lengths(kind: str, half: Array) -> Array:
    """Return the sizes of `solid_of` from those of MJCF, which are halves."""
    if kind in ("capsule", "cylinder"):
        return half * [1.0, 2.0]
    return 2.0 * half if kind == "box" else half
