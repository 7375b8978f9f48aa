"""Bodies: the ground, rigid bodies and flexible bodies with their initial state."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only
from jousto.base.declare import maker
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import AnyField, Field, Reference, field, kept
from jousto.base.numbers import Number, Vector, set_fields
from jousto.base.rotations import Direction
from jousto.base.units import LENGTHS
from jousto.mechanism.bodies.base import (
    ZERO3,
    Inertia,
    Mass,
    OptionalMass,
    Outline,
    Points,
    Posed,
)
from jousto.mechanism.bodies.inertia import check_mass, damping_diagonal
from jousto.mechanism.bodies.marker import NO_TURN, Marker, marker_axes
from jousto.mechanism.bodies.shapes import (
    Lengths,
    LengthUnit,
    Solid,
    box,
    closed_surface,
    cylinder,
    read_surface,
    sphere,
)

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart as ReducedPart


ORIGIN = read_only(ZERO3)
UNTURNED = read_only([1.0, 0.0, 0.0, 0.0])
NO_MODES = read_only(np.zeros(0))


@dataclass(frozen=True, eq=False, repr=False)
class Ground:
    """The world frame as a body for joints and forces; `ground` is its only object.

    Examples
    --------
    >>> ground["origin"].r
    array([0., 0., 0.])
    >>> ground.at((1, 0, 0.5))
    <Marker 'ground.at(1, 0, 0.5)'>
    """

    name: ClassVar[str] = "ground"

    __iter__: ClassVar[None] = None  # points have names, so the ground is not a sequence

    def __repr__(self) -> str:
        return "<Ground 'ground'>"

    def __getitem__(self, point: str) -> Marker:
        """Return the marker at the origin, ``ground["origin"]``; use `at` for other points."""
        if point != "origin":
            raise InputError(
                Problem(
                    "ground",
                    f"no point {point!r}{suggest(point, ['origin'])}; "
                    "other points of the ground are ground.at((x, y, z))",
                )
            )
        return self.at(ZERO3, name="origin")

    @explained
    def at(self, position: ArrayLike, axes: Any = None, name: str | None = None) -> Marker:
        """Return a marker at a world position.

        Parameters
        ----------
        position : (3,) array_like
            World position, m.
        axes : orientation, optional
            Orientation of the marker in the world; None for the world axes.
        name : str, optional
            Name for messages.
        """
        return marker_at(self, position, axes, name)

    @property
    def position(self) -> Array:
        """World position of the frame origin (3,), zero."""
        return ORIGIN

    @property
    def orientation(self) -> Array:
        """Euler parameters (4,) of the world frame."""
        return UNTURNED

    @property
    def modal_coordinates(self) -> Array:
        """Modal coordinates, none: shape (0,)."""
        return NO_MODES


ground = Ground()


class Shaped(Posed):
    """Homogeneous rigid body whose mass and inertia follow from its shape."""

    mass: OptionalMass = field(
        "Mass; give either the mass or the density", unit="kg", default=None, kw_only=True
    )
    density: OptionalMass = field(
        "Density; give either the mass or the density", unit="kg/m3", default=None, kw_only=True
    )
    at: Vector = field(
        "Position of the shape's origin (of its middle for boxes, cylinders and spheres) in the "
        "body frame",
        unit="m",
        default=ZERO3,
        kw_only=True,
    )
    markers: Points = field("Named points in the body frame", unit="m", default=None, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a problem unless exactly one of mass and density is given."""
        if (self.mass is None) == (self.density is None):
            problems.add(where, "give either mass (kg) or density (kg/m3)")

    @property
    def solid(self) -> Solid:
        """Return the solid with density 1, about the origin of its own coordinates."""
        raise NotImplementedError

    @property
    def made(self) -> RigidBody:
        """Return the rigid body."""
        solid = self.solid
        rho = self.density if self.mass is None else self.mass / solid.volume
        assert rho is not None
        given = {key: getattr(self, key) for key in ("markers", *Posed.fields)}
        return RigidBody(
            **given,
            mass=rho * solid.volume,
            inertia=rho * solid.inertia,
            center=solid.center + self.at,
            outline=solid.triangles + self.at,
        )


class BoxBody(Shaped, tag="box"):
    """Homogeneous rigid box.

    Examples
    --------
    >>> RigidBody.box("crate", (1.0, 0.5, 0.2), density=700)
    <RigidBody 'crate': 70 kg>
    """

    size: Lengths = field("Edge lengths along the axes of the body frame", unit="m")

    @property
    def solid(self) -> Solid:
        """Return the box with density 1, about its middle."""
        return box(self.size)


class CylinderBody(Shaped, tag="cylinder"):
    """Homogeneous rigid cylinder.

    Examples
    --------
    >>> RigidBody.cylinder("wheel", radius=0.3, length=0.1, mass=12)
    <RigidBody 'wheel': 12 kg>
    """

    radius: Number = field("Its radius", unit="m", above=0)
    length: Number = field("Length along its axis", unit="m", above=0)
    axis: Direction = field(
        "Direction of its axis in the body frame", default=(0.0, 0.0, 1.0), kw_only=True
    )

    @property
    def solid(self) -> Solid:
        """Return the cylinder with density 1, about its middle."""
        return cylinder(self.radius, self.length, np.asarray(self.axis))


class SphereBody(Shaped, tag="sphere"):
    """Homogeneous rigid sphere.

    Examples
    --------
    >>> RigidBody.sphere("ball", radius=0.11, mass=0.43)
    <RigidBody 'ball': 0.43 kg>
    """

    radius: Number = field("Its radius", unit="m", above=0)

    @property
    def solid(self) -> Solid:
        """Return the sphere with density 1, about its middle."""
        return sphere(self.radius)


class SurfaceBody(Shaped, tag="surface"):
    """Homogeneous rigid body of any shape, given by its closed surface.

    Mass, centre and inertia are exact for the triangles, by the divergence theorem.

    Raises
    ------
    InputError
        If the file cannot be read, or the surface is open, or some of its triangles face inwards.
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

    @property
    def solid(self) -> Solid:
        """Return the solid with density 1, in the coordinates of the surface."""
        where = f"body {self.name!r}"
        return closed_surface(where, read_surface(where, self.surface, self.unit))


class RigidBody(Posed, tag="rigid"):
    """A rigid body with its initial pose and velocity.

    "origin" and "center" always exist among its named points.

    Raises
    ------
    InputError
        With all problems: unphysical mass or inertia, arrays of wrong shape, NaN.

    See Also
    --------
    RigidBody.box, RigidBody.cylinder, RigidBody.sphere, RigidBody.from_mesh : From a shape.

    Examples
    --------
    >>> rod = RigidBody("rod", 2.0, (0.01, 0.7, 0.7), markers={"tip": (1, 0, 0)})
    >>> rod["tip"]
    <Marker 'rod.tip'>
    """

    mass: Mass = field("Its mass", unit="kg")
    inertia: Inertia = field(
        "Tensor about the centre of mass in body axes; three numbers are its diagonal. Products "
        "of inertia with their minus sign, as in the tensor",
        unit="kg m2",
    )
    center: Vector = field(
        "Centre of mass in the body frame", unit="m", default=ZERO3, kw_only=True
    )
    markers: Points = field("Named points in the body frame", unit="m", default=None, kw_only=True)
    outline: Outline = field(
        "Drawing of the body: a polyline in the body frame, or triangles of its surface, "
        "counterclockwise seen from outside",
        unit="m",
        shape=(None, 3),
        default=None,
        kw_only=True,
    )

    box = staticmethod(maker("RigidBody.box", BoxBody))
    cylinder = staticmethod(maker("RigidBody.cylinder", CylinderBody))
    sphere = staticmethod(maker("RigidBody.sphere", SphereBody))
    from_mesh = staticmethod(maker("RigidBody.from_mesh", SurfaceBody))

    __iter__: ClassVar[None] = None

    def __repr__(self) -> str:
        return f"<RigidBody {self.name!r}: {self.mass:g} kg>"

    def __getitem__(self, point: str) -> Marker:
        """Return the marker at a named point.

        Raises
        ------
        InputError
            If there is no such point; the message suggests the most similar name.
        """
        if point == "origin":
            return Marker(self, point, ORIGIN, None, NO_TURN)
        if point == "center":
            return Marker(self, point, self.center, None, NO_TURN)
        if point not in self.markers:
            known = ["origin", "center", *self.markers]
            raise InputError(
                Problem(f"body {self.name!r}", f"no marker {point!r}{suggest(str(point), known)}")
            )
        return Marker(self, point, self.markers[point], None, NO_TURN)

    @explained
    def at(self, position: ArrayLike, axes: Any = None, name: str | None = None) -> Marker:
        """Return a marker at a position and with axes relative to the body frame, m."""
        return marker_at(self, position, axes, name)

    @property
    def modal_coordinates(self) -> Array:
        """Modal coordinates, none: shape (0,)."""
        return NO_MODES

    @property
    def modal_velocities(self) -> Array:
        """Modal velocities, none: shape (0,)."""
        return NO_MODES


class Reduced(Reference["ReducedPart", "ReducedPart"]):
    """Field of a reduced part; a model file contains its name."""

    section = "parts"
    word = "part"
    noun = "ReducedPart"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the reduced part, or report a value of another type."""
        if not all(hasattr(value, a) for a in ("modes", "frequencies", "invariants")):
            hint = "; reduce it first, reduce(part, method)" if hasattr(value, "K") else ""
            problems.add(
                where,
                f"reduced is a {type(value).__name__}, must be a ReducedPart{hint}",
                "reduced",
            )
        return value


class Dropped(Field[Iterable[str], frozenset[str]]):
    """Field of the names of inertia invariants to leave out."""

    form = "choices"
    noun = 'iterable of {"I5", "I9"}'
    words = ("I5", "I9")

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the names as a set, or report unknown ones."""
        names: Any = (value,) if isinstance(value, str) else value
        if not isinstance(names, Iterable):
            problems.add(where, f"{self.name} is {names!r}, must be names such as 'I5'")
            return None
        dropped = tuple(names)
        for name in dropped:
            if name not in self.words:
                hint = suggest(str(name), self.words)
                problems.add(where, f"{self.name}: {name!r} cannot be dropped{hint}")
        return frozenset(dropped)


class Modal(Field["ArrayLike | None", Array]):
    """Field of one number per mode of the body; None for zeros."""

    form = "array"
    noun = "(n,) array_like"
    shape = (None,)


class FlexibleBody(Posed, tag="flexible"):
    """A reduced part in a floating frame with its initial state.

    A particle with undeformed local position u0 and mode shapes Phi (3, n) is at
    ``r = R + A (u0 + Phi p)`` (Rantalainen 2007, section 3.2).

    Attributes
    ----------
    modal_damping : (n,) array
        Diagonal of D, 1/s: the damping force on the modes is ``-D p'``.

    Raises
    ------
    InputError
        With all problems, including a singular mass matrix of a body whose mass lies on one line.
    """

    together = ("reduced",)
    modal_damping: Array = kept()
    reduced: Reduced = field(
        "Modes, invariants and nodes; may be shared by several bodies", key="part"
    )
    damping: AnyField = field(
        "One modal damping ratio for all modes, one per mode, or Rayleigh coefficients. The ratio "
        "refers to the modes of the free body (``reduced.frequencies``): where joints lower a "
        "frequency to f, the damping ratio at f is lower too. For a ratio zeta at f use "
        "``Rayleigh(0, zeta/(pi f))``",
        form="damping",
        noun="float, sequence of float or Rayleigh",
        default=0.0,
        kw_only=True,
    )
    modal_coordinates: Modal = field(
        "Initial modal coordinates p, one per mode; None for zeros",
        unit="kg^0.5 m",
        default=None,
        kw_only=True,
    )
    modal_velocities: Modal = field(
        "Initial modal velocities p', one per mode; None for zeros",
        unit="kg^0.5 m/s",
        default=None,
        kw_only=True,
    )
    drop_invariants: Dropped = field(
        "Inertia invariants to leave out for speed (Rantalainen 2007, section 3.6.2); the "
        "equations are then approximate",
        default=(),
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Store damping and initial values per mode.

        Report values whose number differs from the number of modes.
        """
        damping = self.damping
        damping = tuple(damping) if isinstance(damping, list | np.ndarray) else damping
        set_fields(self, damping=damping)
        for key in ("modal_coordinates", "modal_velocities"):
            given = np.zeros(self.n) if vars(self)[key] is None else vars(self)[key]
            set_fields(self, **{key: problems.array(where, key, given, (self.n,))})
        diagonal = damping_diagonal(problems, where, damping, self.reduced)
        set_fields(self, modal_damping=diagonal)
        if not problems.found:
            check_mass(self.name, self.reduced.invariants, self.modal_coordinates)

    __iter__: ClassVar[None] = None

    def __repr__(self) -> str:
        return f"<FlexibleBody {self.name!r}: {self.n} modes>"

    def __getitem__(self, point: str) -> Marker:
        """Return the marker at a node: an interface, a single-node set, or "node7" (from 1).

        Raises
        ------
        InputError
            If there is no such node; the message suggests the most similar name.
        """
        try:
            node = int(self.reduced.node(point))
        except InputError as error:
            raise InputError(
                [replace(p, where=f"body {self.name!r}") for p in error.problems]
            ) from None
        return Marker(
            self, str(point), read_only(self.reduced.nodes[node]), node, read_only(np.eye(3))
        )

    def at(self, position: ArrayLike, axes: Any = None, name: str | None = None) -> Marker:
        """Return a marker at a point of the undeformed body that need not be a node.

        In beam parts the marker follows the shape functions of the nearest element; off the axis it
        is at the end of a rigid arm, whose length is at most a tenth of the size of the part. In
        other parts it follows a polynomial of second degree fitted to the motion of the surrounding
        nodes. The modes represent the local deformation under a force at the point only if its
        shape is among them. For a joint with a large load, make the point an interface node of the
        part.

        Parameters
        ----------
        position : (3,) array_like
            In the frame of the part, m.
        axes : orientation, optional
            Orientation of the marker in the undeformed body frame; None for the axes of that frame.
        name : str, optional
            Name for messages.

        Raises
        ------
        InputError
            If the point is outside of the part.

        Examples
        --------
        >>> import jousto as jo
        >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
        >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 8, steel)
        >>> rod = FlexibleBody("rod", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)))
        >>> rod.at((0.3, 0, 0))
        <Marker 'rod.at(0.3, 0, 0)'>
        """
        from jousto.reduction.interpolated_points import followed

        made = marker_at(self, position, axes, name)
        try:
            nodes = followed(self.reduced, made.position_local)
        except InputError as error:
            problems = [replace(p, where=f"body {self.name!r}") for p in error.problems]
            raise InputError(problems) from None
        return replace(made, followed=nodes)

    @property
    def n(self) -> int:
        """Number of modes."""
        return len(self.reduced.frequencies)


Body: TypeAlias = Ground | RigidBody | FlexibleBody
MovingBody: TypeAlias = RigidBody | FlexibleBody


# -- helpers of the constructors ------------------------------------------------------------


def marker_at(body: Body, position: ArrayLike, axes: Any, name: str | None) -> Marker:
    """Return a marker at a position in the frame of the ground or a body."""
    problems = Problems()
    where = "ground" if isinstance(body, Ground) else f"body {body.name!r}"
    at = problems.array(where, "position of the marker", position, (3,))
    problems.raise_if_any()
    assert at is not None
    point = name or "at(" + ", ".join(f"{x:g}" for x in at) + ")"
    return Marker(body, point, at, None, marker_axes(f"{body.name}.{point}", axes))
