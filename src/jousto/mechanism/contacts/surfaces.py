"""Shapes that are surfaces of triangles: meshes from files and arrays, and height fields."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problems
from jousto.base.fields import AnyField, field
from jousto.base.numbers import Number, Values
from jousto.base.object_repr import described
from jousto.base.units import LENGTHS
from jousto.mechanism.bodies.shapes import LengthUnit, read_surface
from jousto.mechanism.contacts.polytopes import Polytope, hull
from jousto.mechanism.contacts.shapes import Shape
from jousto.mechanism.contacts.triangles import Triangles


class TriangleSurface(Shape):
    """Base of the shapes that are surfaces of triangles."""

    code = -1

    @property
    def mesh(self) -> Triangles:
        """The surface."""
        raise NotImplementedError

    @property
    def size(self) -> tuple[float, ...]:
        """Largest distance of a vertex from the marker."""
        return (float(np.linalg.norm(self.mesh.vertices, axis=1).max()) + self.mesh.radius,)

    @cached_property
    def polytope(self) -> Polytope:
        """Its hull, which a half-space touches."""
        return hull(self.mesh.vertices, self.mesh.radius)

    @property
    def triangles(self) -> Array:
        """The triangles."""
        return np.asarray(self.mesh.vertices[self.mesh.corners])


@described
class TriangleMesh(TriangleSurface, tag="triangle-mesh"):
    """Surface of triangles, of any form.

    A closed surface is a solid; its triangles are counterclockwise seen from outside. An open one
    is a shell, which is touched from both sides and remembers on which side the other shape was.

    Examples
    --------
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    >>> TriangleMesh.of(corners, faces).mesh.closed
    True
    """

    surface: AnyField = field(
        "A file of triangles (STL, OBJ, PLY or another format of meshio), a CAD file (STEP or "
        "BREP; needs Gmsh; a STEP file contains its unit), a `Mesh` of solids, or the corners of "
        "triangles",
        form="file",
        noun="path, Mesh or (nt, 3, 3) array_like",
        key="file",
    )
    unit: LengthUnit = field(
        "Length unit of the coordinates in the file or array",
        words=tuple(LENGTHS),
        default="m",
        kw_only=True,
    )
    thickness: Number = field(
        "Thickness of a shell, half of it on each side of the triangles; 0 for a solid",
        unit="m",
        least=0,
        default=0.0,
        kw_only=True,
    )

    @classmethod
    def of(cls, points: ArrayLike, triangles: ArrayLike, *, thickness: float = 0.0) -> TriangleMesh:
        """Return the surface with these points (np, 3), m, and triangles (nt, 3) of their indices.

        Raises
        ------
        InputError
            If a triangle refers to a point that there is not, or the surface cannot be used.
        """
        problems = Problems()
        x = problems.array("triangle-mesh", "points", points, (None, 3))
        corners = problems.array("triangle-mesh", "triangles", triangles, (None, 3))
        problems.raise_if_any()
        assert x is not None and corners is not None
        index = corners.astype(int)
        wrong = ((index != corners) | (index < 0) | (index >= len(x))).any(axis=1)
        if wrong.any():
            first = int(np.argmax(wrong))
            problems.add(
                "triangle-mesh",
                f"triangle {first} is {corners[first].tolist()}, must be whole numbers from 0 to "
                f"{len(x) - 1}, the indices of points",
                "triangles",
            )
        problems.raise_if_any()
        return cls(x[index], thickness=thickness)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a surface that cannot be read or used."""
        try:
            surface = self.mesh
        except InputError as error:
            problems.found.extend(error.problems)
            return
        for fault in surface.faults or surface.crossings:
            problems.add(where, fault, "file")
        if self.thickness and not surface.faults and surface.closed:
            problems.add(
                where,
                f"thickness is {self.thickness:g} m, but the surface is closed; leave it out: the "
                "solid inside of it is as thick as it is",
                "thickness",
            )

    @cached_property
    def mesh(self) -> Triangles:
        """The surface."""
        corners = read_surface("triangle-mesh", self.surface, self.unit)
        return Triangles.of(corners, 0.5 * self.thickness)

    def _facts(self) -> str:
        kind = "closed" if self.mesh.closed else "open"
        return f"{len(self.mesh.corners)} triangles, {kind}"


@described
class HeightField(TriangleSurface, tag="height-field"):
    """Ground of a grid of heights over a rectangle about the marker, with a flat base below.

    Between the heights it consists of triangles, two in each cell.

    Examples
    --------
    >>> ground = HeightField([[0, 0, 0], [0, 0.2, 0], [0, 0, 0]], 4.0, 4.0)
    >>> len(ground.mesh.corners)
    32
    """

    heights: Values = field(
        "Heights z at equal distances, along x in the first index and along y in the second",
        unit="m",
        shape=(None, None),
    )
    length: Number = field("Length along x", unit="m", above=0)
    width: Number = field("Length along y", unit="m", above=0)
    base: Number = field(
        "Depth of the base below the lowest place", unit="m", above=0, default=1.0, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report grids without a cell and those that are too large."""
        if min(self.heights.shape) < 2:
            rows, columns = self.heights.shape
            problems.add(where, f"heights are {rows} x {columns}, need 2 x 2 or more", "heights")
            return
        for fault in self.mesh.faults:
            problems.add(where, fault, "heights")

    @cached_property
    def mesh(self) -> Triangles:
        """The surface with its sides and its base."""
        rows, columns = self.heights.shape
        x = np.linspace(-0.5 * self.length, 0.5 * self.length, rows)
        y = np.linspace(-0.5 * self.width, 0.5 * self.width, columns)
        X, Y = np.meshgrid(x, y, indexing="ij")
        top = np.stack([X, Y, self.heights], axis=2).reshape(-1, 3)
        index = np.arange(rows * columns).reshape(rows, columns)
        a, b, c, d = (
            part.ravel()
            for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
        )
        cells = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        rim = np.concatenate(  # counterclockwise from above
            [index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]]
        )
        foot = len(top) + np.arange(len(rim))
        low = top[rim]
        low[:, 2] = self.heights.min() - self.base
        middle = len(top) + len(rim)
        points = np.concatenate([top, low, [[0.0, 0.0, low[0, 2]]]])
        after, below = np.roll(rim, -1), np.roll(foot, -1)
        centre = np.full(len(rim), middle)
        sides = [[rim, foot, below], [rim, below, after], [foot, centre, below]]
        corners = [cells, *(np.stack(one, axis=1) for one in sides)]
        return Triangles(points, np.concatenate(corners))
