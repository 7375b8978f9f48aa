"""Geoms of MJCF: shapes with mass."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.base.errors import InputError
from jousto.base.rotations import turn_onto
from jousto.mechanism.bodies.shapes import Solid, closed_surface
from jousto.mechanism.contacts.shapes import HalfSpace, Shape
from jousto.mechanism.contacts.surfaces import HeightField
from jousto.mechanism.contacts.triangles import MOST_TRIANGLES
from jousto.robots.description import Frame
from jousto.robots.readers.collisions import MeshHull, mesh_hull, shape_of
from jousto.robots.readers.meshes import Folders, solid_of
from jousto.robots.readers.mjcf_settings import Places
from jousto.robots.readers.shells import (
    EXACT,
    HULL,
    LEGACY,
    MESH_MASSES,
    SHELL,
    convex_hull,
    hull_mass,
    inertia_box,
    pyramid_mass,
    shell_of,
    surface_mass,
)
from jousto.robots.readers.xml import Element

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
LINES = ("capsule", "cylinder", "box", "ellipsoid")
LEAST = 1e-14  # smallest mass of a geom, kg (mjEPS of MuJoCo); lighter ones have none
MOST_HEIGHTS = MOST_TRIANGLES // 2  # largest number of heights of a height field
SAME = 1e-2  # relative difference of volumes below which there is no warning


@dataclass(frozen=True, eq=False)
class Geom:
    """Shape with mass, centre, inertia about it and triangles, in the frame of its body."""

    mass: float
    center: Array
    inertia: Array
    triangles: Array


@dataclass
class Asset:
    """Mesh of the assets, read at its first use.

    Parameters
    ----------
    load : callable
        Function that returns the triangles (nt, 3, 3), m, or None, points (np, 3) that may be
        corners of no triangle, and the reason for None.
    kind : str
        Rule for its mass: "convex", "exact", "legacy" or "shell".
    where : Element
        Element of the asset.
    most : int
        Largest number of vertices of its hull; 0: any.
    """

    load: Callable[[], tuple[Array | None, Array | None, str]]
    kind: str
    where: Element
    most: int = 0
    triangles: Array | None = None
    points: Array | None = None
    why: str = ""
    loaded: bool = False
    solid: Solid | None = None
    hull: MeshHull | None = None

    def surface(self) -> Array | None:
        """Return the triangles (nt, 3, 3), m, or None."""
        if not self.loaded:
            self.triangles, self.points, self.why = self.load()
            self.loaded = True
        return self.triangles


class Geoms:
    """Reader of the geoms of a file.

    Parameters
    ----------
    places : Places
        Reader of poses.
    folders : Folders
        Allowed folders of meshes.
    draw : bool
        Whether meshes for pictures alone are read.
    """

    def __init__(self, places: Places, folders: Folders, *, draw: bool = True) -> None:
        self.places, self.reading, self.folders = places, places.reading, folders
        self.draw = draw
        self.meshes: dict[str, Asset] = {}
        self.grounds: dict[str, Element] = {}

    def asset(self, element: Element) -> None:
        """Add a mesh to the assets; its file is read at its first use."""
        given = self.places.given(element, "main")
        file = given.given.get("file", "")
        name = given.given.get("name", file.rpartition("/")[2].rpartition(".")[0])
        kind = given.given.get("inertia", EXACT if self.places.settings.exact else LEGACY)
        if kind not in MESH_MASSES:
            known = ", ".join(MESH_MASSES)
            self.reading.add(element, f"inertia is {kind!r}, must be one of {known}")
            kind = LEGACY
        most = max(int(self.reading.number(given, "maxhullvert", -1.0)), 0)
        self.meshes[name] = Asset(lambda: self.load(given, file), kind, element, most)

    def ground(self, element: Element) -> None:
        """Add a height field to the assets."""
        file = element.given.get("file", "")
        name = element.given.get("name", file.rpartition("/")[2].rpartition(".")[0])
        self.grounds[name] = element

    def load(self, given: Element, file: str) -> tuple[Array | None, Array | None, str]:
        """Return triangles and points of a mesh in the frame of its geoms, or None and the reason.

        The frame of a geom is that of the mesh as its file has it, after ``refpos``, ``refquat``
        and ``scale``: MuJoCo moves the mesh to its inertia frame and the geom back.
        """
        reading = self.reading
        scale = reading.vector(given, "scale", (1.0, 1.0, 1.0))
        r = reading.vector(given, "refpos", (0.0, 0.0, 0.0))
        A = np.eye(3)
        if "refquat" in given.given:
            A = self.places.quaternion(given, "refquat")
        points = None
        if "vertex" in given.given:
            found, why = self.inline(given)
            points = self.reading.list(given, "vertex")
        elif not file:
            found, why = None, "it names no file"
        else:
            strip = self.places.settings.strip
            name = file.replace("\\", "/").rpartition("/")[2] if strip else file
            found, why = self.folders.surface(name)
        if found is None:
            return None, None, why
        found = (found - r) @ A * scale
        points = None if points is None else (points.reshape(-1, 3) - r) @ A * scale
        return (found[:, ::-1] if np.prod(scale) < 0.0 else found), points, ""

    def inline(self, given: Element) -> tuple[Array | None, str]:
        """Return the triangles of a mesh defined in the MJCF file, or None and the reason."""
        points = self.reading.list(given, "vertex")
        if points is None or len(points) % 3 or len(points) < 12:
            return None, "its vertex must be four or more points of three numbers"
        points = points.reshape(-1, 3)
        if "face" not in given.given:
            try:
                return convex_hull(points), ""
            except ValueError as error:
                return None, str(error)
        corners = self.reading.list(given, "face")
        if corners is None or len(corners) % 3 or not len(corners):
            return None, "its face must be numbers of points, three for a triangle"
        if (corners != np.rint(corners)).any() or corners.min() < 0 or corners.max() >= len(points):
            return None, f"its face names points that do not exist; they are 0 to {len(points) - 1}"
        return np.asarray(points[corners.astype(np.intp).reshape(-1, 3)]), ""

    def read(self, element: Element, at: Frame, *, weighed: bool) -> Geom | None:
        """Return a geom, with mass if `weighed`; None for a geom without volume."""
        kind = element.given.get("type", "sphere")
        if kind == "mesh" and "mesh" not in element.given:
            self.reading.add(element, "names no mesh")
            return None
        if kind in ("plane", "hfield"):
            if kind == "hfield" and weighed and not self.weightless(element):
                self.reading.effect(element, "a height field", "has no mass here; give <inertial>")
            return None
        if kind not in SIZES and kind != "mesh":
            self.reading.leave_out(element, f"geom of type {kind}")
            if weighed:
                self.reading.add(
                    element, f"a geom of type {kind} has no mass here; give <inertial>"
                )
            return None
        weighed = weighed and self.grouped(element) and not self.weightless(element)
        if "mesh" in element.given:
            solid, place = self.mesh(element, kind, at @ self.places.frame(element), weighed)
        else:
            sizes, place = self.sized(element, kind, at)
            solid = solid_of(self.reading, element, kind, sizes)
            if solid is not None and element.given.get("shellinertia") == "true":
                solid = shell_of(kind, sizes, solid)
        if solid is None:
            return None
        mass = self.mass(element, solid) if weighed else 0.0
        share = mass / solid.volume if solid.volume > 0.0 else 0.0
        return Geom(
            mass,
            place.r + place.A @ solid.center,
            share * place.A @ solid.inertia @ place.A.T,
            place.r + solid.triangles @ place.A.T,
        )

    def mass(self, element: Element, solid: Solid) -> float:
        """Return the mass of a geom, kg."""
        mass = self.reading.number(element, "density", 1000.0) * solid.volume
        if "mass" in element.given:
            mass = self.reading.number(element, "mass")
        if mass < 0.0:
            self.reading.add(element, f"mass is {mass:g} kg, must not be negative")
        return mass

    def grouped(self, element: Element) -> bool:
        """Return whether geoms in the group of a geom have mass."""
        low, high = self.places.settings.groups
        return bool(low <= self.reading.number(element, "group", 0.0) <= high)

    def weightless(self, element: Element) -> bool:
        """Return whether a geom has an explicit mass of zero."""
        key = "mass" if "mass" in element.given else "density"
        return self.reading.number(element, key, 1.0) == 0.0

    def sized(self, element: Element, kind: str, at: Frame) -> tuple[Array, Frame]:
        """Return the sizes and the pose of a solid."""
        count = SIZES[kind]
        text = element.given.get("size", "")
        words = text.split()
        if "fromto" not in element.given or kind not in LINES:
            # further sizes, which the form does not need, are allowed
            half = self.reading.numbers(
                element, " ".join(words[:count]) or None, "size", count, None
            )
            return _lengths(kind, half), at @ self.places.frame(element)
        ends = self.reading.numbers(element, element.given["fromto"], "fromto", 6, None)
        axis = ends[3:] - ends[:3]
        long = float(np.linalg.norm(axis))
        if long == 0.0:
            self.reading.add(element, "fromto has two equal points, must have a length")
            axis, long = np.array([0.0, 0.0, 1.0]), 1.0
        radius = self.reading.numbers(element, " ".join(words[:1]) or None, "size", 1, None)[0]
        half = np.array([radius, radius, 0.5 * long])
        if kind in ("capsule", "cylinder"):
            half = half[1:]
        place = Frame(0.5 * (ends[:3] + ends[3:]), turn_onto(np.eye(3), axis))
        return _lengths(kind, half), at @ place

    def touching(self, element: Element, kind: str, at: Frame) -> tuple[Shape, Frame, str]:
        """Return the shape of a geom that touches others, its pose, and what it was in the file.

        Raises
        ------
        ValueError
            With the kind of a geom that cannot touch, and the reason.
        """
        if kind == "plane":
            return HalfSpace(), at @ self.places.frame(element), ""
        if kind == "hfield":
            made = self.heights(element.given.get("hfield", ""))
            return made, at @ self.places.frame(element), ""
        if "mesh" in element.given and kind in (*SIZES, "mesh"):
            return self.touching_mesh(element, kind, at @ self.places.frame(element))
        if kind not in SIZES:
            raise ValueError(kind)
        sizes, place = self.sized(element, kind, at)
        shape = shape_of(kind, sizes)
        if shape is None:
            raise ValueError(f"{kind} without a size")
        return shape, place, ""

    def touching_mesh(self, element: Element, kind: str, place: Frame) -> tuple[Shape, Frame, str]:
        """Return the hull of a mesh, or the shape fitted to it, see `touching`."""
        name = element.given["mesh"]
        asset = self.meshes.get(name)
        triangles = None if asset is None else asset.surface()
        if asset is None or triangles is None:
            why = "is not among the assets" if asset is None else asset.why or "is not read"
            raise ValueError(f"mesh {name!r}: {why}")
        if kind == "mesh":
            if asset.hull is None:
                try:
                    asset.hull = mesh_hull(name, triangles, asset.points, asset.most)
                except ValueError as error:
                    raise ValueError(f"mesh {name!r}: {error}") from None
            return asset.hull.shape, place, asset.hull.text
        solid = asset.solid or {LEGACY: pyramid_mass, HULL: hull_mass, SHELL: surface_mass}.get(
            asset.kind, pyramid_mass
        )(triangles)
        sizes, inner = self.fitted_sizes(element, kind, solid)
        shape = shape_of(kind, sizes) if np.isfinite(sizes).all() else None
        if shape is None:
            raise ValueError(f"{kind} fitted to the mesh {name!r}, which has no volume")
        return shape, place @ inner, f"{kind} fitted to the mesh {name!r}"

    def heights(self, name: str) -> HeightField:
        """Return the height field of an asset.

        Heights are scaled to 0 to ``size[2]``, as in MuJoCo; the first row of ``elevation`` is that
        of the largest y.

        Raises
        ------
        ValueError
            With the reason if it is not read.
        """
        element = self.grounds.get(name)
        if element is None:
            raise ValueError(f"hfield {name!r}: is not among the assets")
        size = self.reading.numbers(element, element.given.get("size"), "size", 4, None)
        if not (size > 0.0).all():
            raise ValueError(f"hfield {name!r}: size must be four positive numbers")
        if file := element.given.get("file", ""):
            rows = self.folders.heights(file)
        else:
            shape = [int(self.reading.number(element, key, 0.0)) for key in ("nrow", "ncol")]
            if min(shape) < 2 or shape[0] * shape[1] > MOST_HEIGHTS:
                raise ValueError(
                    f"hfield {name!r}: nrow {shape[0]} and ncol {shape[1]} must be 2 or more, "
                    f"their product up to {MOST_HEIGHTS}"
                )
            rows = np.zeros(shape)
            if "elevation" in element.given:
                found = self.reading.list(element, "elevation")
                if found is None or len(found) != rows.size:
                    raise ValueError(f"hfield {name!r}: elevation must be {rows.size} numbers")
                rows = found.reshape(shape)[::-1]
        if rows.size > MOST_HEIGHTS:
            raise ValueError(
                f"hfield {name!r}: has {rows.size} heights, at most {MOST_HEIGHTS} are possible"
            )
        low, high = float(rows.min()), float(rows.max())
        share = (rows - low) / (high - low) if high > low else np.zeros_like(rows)
        try:
            return HeightField(size[2] * share.T, *(2.0 * size[:2]), base=float(size[3]))
        except InputError as error:
            raise ValueError(f"hfield {name!r}: {error.problems[0].message}") from None

    def mesh(
        self, element: Element, kind: str, place: Frame, weighed: bool
    ) -> tuple[Solid | None, Frame]:
        """Return the solid of a mesh, or of a shape fitted to it, and its frame."""
        name = element.given["mesh"]
        asset = self.meshes.get(name)
        if asset is None:
            self.reading.add(element, f"no mesh {name!r} among the assets")
            return None, place
        if not (weighed or self.draw):
            return None, place
        triangles = asset.surface()
        if triangles is None:
            if weighed:
                self.reading.add(
                    element,
                    f"the mass is that of the mesh {name!r}, which is not read: {asset.why}; give "
                    "<inertial> to the body",
                )
            elif asset.why:
                message = f"the mesh {name!r} is not read: {asset.why}; the shape is ignored"
                self.reading.note(asset.where, message)
                asset.why = ""
            return None, place
        if not weighed:
            return Solid(0.0, np.zeros(3), np.zeros((3, 3)), triangles), place
        solid = self.solid(asset, name, triangles)
        if solid is None or kind == "mesh":
            return solid, place
        return self.fitted(element, kind, solid, place)

    def solid(self, asset: Asset, name: str, triangles: Array) -> Solid | None:
        """Return the solid of a mesh by the rule of its asset, density 1; None with a problem."""
        if asset.solid is not None:
            return asset.solid
        true: Solid | None = None
        try:
            if asset.kind in (EXACT, LEGACY):
                true = closed_surface("mesh", triangles)
        except InputError as error:
            why = error.problems[0].message
            if asset.kind == EXACT:
                self.reading.add(asset.where, f"the mesh {name!r} has no mass: {why}")
                return None
        else:
            why = ""
        try:
            solid = {LEGACY: pyramid_mass, HULL: hull_mass, SHELL: surface_mass}.get(
                asset.kind, lambda _: true
            )(triangles)
        except ValueError as error:
            self.reading.add(asset.where, f"the mesh {name!r} has no mass: {error}")
            return None
        assert solid is not None
        if not (np.isfinite(solid.volume) and np.isfinite(solid.inertia).all()):
            self.reading.add(asset.where, f"the mesh {name!r} is too large; is it in m?")
            return None
        if asset.kind == LEGACY and not true:
            self.reading.note(
                asset.where,
                f"the mesh {name!r} has {solid.volume:.4g} m3, as in MuJoCo, although {why}",
            )
        elif true is not None and abs(solid.volume / true.volume - 1.0) > SAME:
            self.reading.note(
                asset.where,
                f"the mesh {name!r} has {solid.volume:.4g} m3, as in MuJoCo, but encloses "
                f"{true.volume:.4g} m3; inertia='exact' takes the enclosed volume",
            )
        asset.solid = solid
        return solid

    def fitted(
        self, element: Element, kind: str, solid: Solid, place: Frame
    ) -> tuple[Solid | None, Frame]:
        """Return a solid fitted to the inertia or to the bounding box of a mesh, and its pose."""
        sizes, inner = self.fitted_sizes(element, kind, solid)
        made = solid_of(self.reading, element, kind, sizes)
        if made is not None and element.given.get("shellinertia") == "true":
            made = shell_of(kind, sizes, made)
        return made, place @ inner

    def fitted_sizes(self, element: Element, kind: str, solid: Solid) -> tuple[Array, Frame]:
        """Return the sizes of a solid fitted to a mesh, and its pose in the frame of the mesh."""
        half, A = inertia_box(solid)
        center = solid.center
        if self.places.settings.fit_box:
            local = (solid.triangles.reshape(-1, 3) - center) @ A
            low, high = local.min(axis=0), local.max(axis=0)
            center, half = center + A @ (0.5 * (low + high)), 0.5 * (high - low)
            wide, end = max(half[0], half[1]), half[2] - max(half[0], half[1])
            radius = float(half.max())
        else:
            wide = 0.5 * (half[0] + half[1])
            end, radius = max(0.0, half[2] - 0.5 * wide), float(half.mean())
        lengths = {
            "sphere": np.array([radius]),
            "capsule": np.array([wide, end]),
            "cylinder": np.array([wide, half[2]]),
        }.get(kind, half)
        lengths = lengths * self.reading.number(element, "fitscale", 1.0)
        return _lengths(kind, lengths), Frame(center, A)

    def total(self, parts: Sequence[Geom]) -> tuple[float, Array, Array]:
        """Return mass, centre of mass and inertia about it of several geoms."""
        parts = [part for part in parts if part.mass > LEAST]
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
    """Return the sizes for `solid_of` from the half sizes of MJCF."""
    if kind in ("capsule", "cylinder"):
        return half * [1.0, 2.0]
    return 2.0 * half if kind == "box" else half
