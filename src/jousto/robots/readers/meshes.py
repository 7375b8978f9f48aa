"""Shapes of links: solids of known form, and meshes from folders that may be read."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.files import special
from jousto.base.names import harmless
from jousto.mechanism.bodies import shapes
from jousto.mechanism.bodies.shapes import Solid, read_surface
from jousto.robots.readers.collisions import MeshHull, mesh_hull
from jousto.robots.readers.xml import Element, Reading

READ = (".stl", ".obj", ".ply", ".dae", ".msh")
LARGEST = 256 * 2**20  # largest size of a mesh file, bytes
MOST_PIXELS = 1 << 22  # of a picture of heights
MOST = 1e100  # largest coordinate, m, whose square does not overflow


class Folders:
    """Folders in which mesh files are allowed: that of the robot's file and those of packages.

    Parameters
    ----------
    path : Path
        File of the robot.
    packages : dict of str to path or None
        Folders of packages by their names.

    Raises
    ------
    InputError
        If the packages are not a mapping of names to folders.
    """

    def __init__(self, path: Path, packages: Any) -> None:
        self.home = path.parent.resolve()
        given = {} if packages is None else packages
        if not isinstance(given, Mapping):
            message = f"is {given!r}, must be a mapping of names to folders"
            raise InputError(Problem("packages", message))
        self.packages: dict[str, Path] = {}
        for name, folder in given.items():
            if not isinstance(folder, str | Path):
                message = f"is {folder!r}, must be a folder"
                raise InputError(Problem(f"packages[{name!r}]", message))
            self.packages[str(name)] = Path(folder).resolve()
        self.base = self.home
        self.read: dict[Path, Array] = {}
        self.hulls: dict[str, MeshHull] = {}

    def within(self, name: str) -> Folders:
        """Return the same folders, with names relative to a subfolder of the file's folder."""
        found = copy(self)
        found.base = self.base / name
        return found

    def at(self, folder: Path) -> Folders:
        """Return the same folders, with names relative to one of them."""
        found = copy(self)
        found.base = folder
        return found

    def find(self, name: str) -> tuple[Path | None, str]:
        """Return the path of a file name in a robot's file, or None and the reason."""
        head, mark, rest = name.partition("://")
        if not name.strip() or "\x00" in name:
            return None, "has no name"
        if mark and head in ("package", "model"):
            package, _, inner = rest.partition("/")
            folder = self.packages.get(package)
            if folder is None and package == self.home.name:
                folder = self.home
            if folder is None:
                known = suggest(package, self.packages) if self.packages else ""
                say = f"packages={{{package!r}: folder}}"
                return None, f"is in package {package!r}; give its folder, {say}{known}"
            path = folder / inner
        elif mark and head == "file":
            path = Path(rest)
        elif mark or ":" in head.partition("/")[0][2:]:
            return None, f"is at {head}://, must be a file or a package"
        else:
            path = self.base / name
        return self.allowed(path)

    def allowed(self, path: Path) -> tuple[Path | None, str]:
        """Return a resolved path if it is in one of the folders, or None and the reason."""
        try:
            real = path.resolve()
            inside = any(
                real.is_relative_to(folder) for folder in (self.home, *self.packages.values())
            )
            if not inside:
                return None, "lies outside the folder of the robot and of its packages"
            if not real.is_file():
                what = special(real)
                return None, f"is {what}" if what else "is not there"
            if real.stat().st_size > LARGEST:
                return None, f"has more than {LARGEST // 2**20} MB"
        except (OSError, ValueError, RuntimeError) as error:
            return None, f"cannot be found: {type(error).__name__}"
        return real, ""

    def surface(self, name: str) -> tuple[Array | None, str]:
        """Return the triangles (nt, 3, 3) of a mesh file, m, or None and the reason."""
        path, why = self.find(name)
        shown = harmless(name)
        if path is None:
            return None, f"'{shown}' {why}"
        if path.suffix.lower() not in READ:
            known = ", ".join(READ)
            return None, f"'{shown}' is a {path.suffix or 'nameless'} file, {known} are read"
        if path in self.read:
            return self.read[path], ""
        try:
            with np.errstate(
                all="ignore"
            ):  # readers recognise the kind of a file by numbers in it, which may overflow
                own = path.suffix.lower() == ".msh" and not path.read_bytes().startswith(b"$")
                triangles = mujoco_mesh(path) if own else read_surface("mesh", path, "m")
        except InputError as error:
            return None, f"'{shown}' cannot be used: {error.problems[0].message}"
        if not np.isfinite(triangles).all() or np.abs(triangles).max(initial=0.0) > MOST:
            return None, f"'{shown}' cannot be used: it has corners that are not finite"
        self.read[path] = triangles
        return triangles, ""

    def hull(self, name: str, scale: Array) -> MeshHull:
        """Return the convex hull of a scaled mesh file.

        Raises
        ------
        ValueError
            With the reason if there is none.
        """
        triangles, why = self.surface(name)
        if triangles is None:
            raise ValueError(f"mesh {why}")
        shown = harmless(name).rpartition("/")[2]
        key = f"{name} {scale.tolist()}"
        if key not in self.hulls:
            scaled = triangles * scale
            scaled = scaled[:, ::-1] if np.prod(scale) < 0.0 else scaled
            try:
                self.hulls[key] = mesh_hull(shown, scaled)
            except ValueError as error:
                raise ValueError(f"mesh '{shown}': {error}") from None
        return self.hulls[key]

    def heights(self, name: str) -> Array:
        """Return the rows of a file of heights, from the smallest y to the largest.

        It is a picture (PNG), whose grey values are the heights and whose first row is that of the
        largest y, or consists of the numbers of rows and columns, and of numbers of 4 bytes.

        Raises
        ------
        ValueError
            With the reason if it cannot be read.
        """
        path, why = self.find(name)
        shown = harmless(name)
        if path is None:
            raise ValueError(f"hfield '{shown}' {why}")
        data = path.read_bytes()
        if data.startswith(b"\x89PNG"):
            return picture(path, shown)[::-1]
        counts = np.frombuffer(data[:8], dtype="<i4").astype(np.int64)
        if len(counts) < 2 or counts.min() < 2 or len(data) != 8 + 4 * int(counts.prod()):
            raise ValueError(f"hfield '{shown}' is no file of rows, columns and heights")
        heights = np.frombuffer(data, dtype="<f4", offset=8).astype(np.float64)
        if not np.isfinite(heights).all():
            raise ValueError(f"hfield '{shown}' has heights that are not finite")
        return heights.reshape(counts)

    def mesh(self, reading: Reading, element: Element, name: str, scale: Array) -> Array | None:
        """Return the scaled triangles (nt, 3, 3) of a mesh file, m, or None with a warning."""
        found, why = self.surface(name)
        if found is None:
            reading.note(element, f"the mesh {why}; the shape is ignored")
            return None
        found = found * scale
        # reverse the order of the corners of a mirrored mesh, so that normals point outward
        return found[:, ::-1] if np.prod(scale) < 0.0 else found


def picture(path: Path, name: str) -> Array:
    """Return the grey values (rows, columns) of a PNG file, as MuJoCo reads a height field.

    Raises
    ------
    ValueError
        If it cannot be read, or is too large.
    """
    from PIL import Image  # slow to import

    try:
        with Image.open(path, formats=["PNG"]) as found:
            columns, rows = found.size
            if rows * columns > MOST_PIXELS:
                text = (
                    f"hfield '{name}' has {rows} x {columns} pixels, at most {MOST_PIXELS} are read"
                )
                raise ValueError(text)
            pixels = np.asarray(found.convert("RGB") if found.mode == "P" else found, np.float64)
    except (OSError, SyntaxError) as error:
        text = f"hfield '{name}' is no picture that can be read: {type(error).__name__}"
        raise ValueError(text) from None
    return pixels if pixels.ndim == 2 else pixels[..., 0]


def mujoco_mesh(path: Path) -> Array:
    """Return the triangles (nt, 3, 3) of a MSH file of MuJoCo.

    It consists of the numbers of vertices, normals, texture coordinates and faces, then of each of
    them: three, three and two numbers of 4 bytes, and three indices.

    Raises
    ------
    InputError
        If the numbers do not belong to the size of the file.
    """
    data = path.read_bytes()
    counts = np.frombuffer(data[:16], dtype="<i4").astype(np.int64)
    size = 4 * (4 + int(counts @ [3, 3, 2, 3])) if len(counts) == 4 else 0
    if size != len(data) or counts.min() < 0 or not counts[3]:
        raise InputError(Problem("mesh", "it is no MSH file of MuJoCo or Gmsh"))
    points = np.frombuffer(data, dtype="<f4", count=3 * counts[0], offset=16).reshape(-1, 3)
    faces = np.frombuffer(data[size - 12 * int(counts[3]) :], dtype="<i4").reshape(-1, 3)
    if faces.min() < 0 or faces.max() >= len(points):
        raise InputError(Problem("mesh", "its triangles name points that do not exist"))
    return np.asarray(points[faces], dtype=np.float64)


def solid_of(reading: Reading, element: Element, kind: str, sizes: Array) -> Solid | None:
    """Return a solid centred at the origin with axis z; None with a warning if it has no size.

    Parameters
    ----------
    reading, element
        Collector of warnings, and the element of the solid.
    kind : {"box", "cylinder", "capsule", "sphere", "ellipsoid"}
        Form of the solid.
    sizes : (n,) array
        Lengths of a box; radius and length, without the round ends of a capsule; radius;
        half axes, m.
    """
    if not (sizes > 0.0).all():
        found = ", ".join(f"{x:g}" for x in sizes)
        reading.note(element, f"the {kind} has the size ({found}), must be positive; it is ignored")
        return None
    z = np.array([0.0, 0.0, 1.0])
    if kind == "box":
        return shapes.box(sizes)
    if kind == "cylinder":
        return shapes.cylinder(float(sizes[0]), float(sizes[1]), z)
    if kind == "capsule":
        return capsule(float(sizes[0]), float(sizes[1]))
    if kind == "sphere":
        return shapes.sphere(float(sizes[0]))
    return ellipsoid(sizes)


def capsule(r: float, long: float) -> Solid:
    """Return a cylinder along z of a given length with half-spheres at its ends, density 1.

    The centre of mass of a half-sphere of mass m is 3 r / 8 above its disc, and its transverse
    inertia about that centre is ``(2/5 - 9/64) m r^2``.
    """
    m, b = np.pi * r * r * long, 2.0 / 3.0 * np.pi * r**3
    along = 0.5 * m * r * r + 2.0 * 0.4 * b * r * r
    away = 0.5 * long + 0.375 * r
    across = m * (3.0 * r * r + long * long) / 12.0
    across += 2.0 * b * ((0.4 - 9.0 / 64.0) * r * r + away * away)
    angle = np.linspace(0.0, 0.5 * np.pi, shapes.FACETS // 4 + 1)
    top = np.stack([r * np.cos(angle), 0.5 * long + r * np.sin(angle)], axis=1)
    profile = np.concatenate([top[::-1] * [1.0, -1.0], top])
    profile[[0, -1], 0] = 0.0
    inertia = np.diag([across, across, along])
    return Solid(m + 2.0 * b, np.zeros(3), inertia, shapes.revolved(profile))


def ellipsoid(half: Array) -> Solid:
    """Return an ellipsoid of three half axes, density 1: ``I_xx = m (b^2 + c^2) / 5``."""
    volume = float(4.0 / 3.0 * np.pi * np.prod(half))
    squares = half**2
    inertia = np.diag(volume * (squares.sum() - squares) / 5.0)
    return Solid(volume, np.zeros(3), inertia, shapes.sphere(1.0).triangles * half)
