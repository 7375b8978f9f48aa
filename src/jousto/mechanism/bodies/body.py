"""Bodies: the ground, rigid bodies and flexible bodies with their initial state."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.frozen import Frozen
from jousto.base.names import check_name
from jousto.base.numbers import number, set_fields
from jousto.base.rotations import parse_orientation
from jousto.mechanism.bodies.inertia import check_inertia, check_mass, damping_diagonal
from jousto.mechanism.bodies.marker import Marker, marker_axes
from jousto.mechanism.bodies.shapes import (
    body_arguments,
    box,
    closed_surface,
    cylinder,
    read_surface,
    sphere,
)

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart

ZERO3 = (0.0, 0.0, 0.0)
DROPPABLE = ("I5", "I9")


@dataclass(frozen=True, eq=False, repr=False)
class Ground:
    """The world frame as something to fix joints to; use the one object `ground`.

    Examples
    --------
    >>> ground["origin"].r
    array([0., 0., 0.])
    >>> ground.at((1, 0, 0.5))
    <Marker 'ground.at(1, 0, 0.5)'>
    """

    name: str = field(default="ground", init=False)

    __iter__: ClassVar[None] = None  # points have names: no sequence

    def __repr__(self) -> str:
        return "<Ground 'ground'>"

    def __getitem__(self, point: str) -> Marker:
        """Return the marker at the origin; other points are made with `at`."""
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
        return read_only(ZERO3)

    @property
    def orientation(self) -> Array:
        """Euler parameters (4,) of the world frame."""
        return read_only([1.0, 0.0, 0.0, 0.0])

    @property
    def modal_coordinates(self) -> Array:
        """No modal coordinates, shape (0,)."""
        return read_only(np.zeros(0))


ground = Ground()


@dataclass(frozen=True, eq=False, init=False, repr=False)
class RigidBody:
    """A rigid body with its initial pose and velocity.

    Parameters
    ----------
    name : str
        Name, unique among the bodies.
    mass : float
        Mass, kg.
    inertia : (3, 3) or (3,) array_like
        Inertia tensor about the centre of mass in body axes, kg m2; three numbers are its
        diagonal. Products of inertia with their minus sign, as in the tensor.
    center : (3,) array_like
        Centre of mass in the body frame, m.
    markers : mapping of str to (3,) array_like
        Named points in the body frame, m. "origin" and "center" always exist.
    position, orientation : (3,) array_like, orientation
        Initial pose of the body frame in the world, m; None, Euler parameters (scalar first),
        rotation matrix, scipy Rotation or `Rotate`.
    velocity, angular_velocity : (3,) array_like
        Initial velocity of the body frame's origin, m/s, and angular velocity, rad/s, both
        resolved in the world frame.
    outline : (k, 3) or (nt, 3, 3) array_like, optional
        Polyline in the body frame, m, to draw the body with, or the triangles of its surface,
        counterclockwise seen from outside.

    Raises
    ------
    InputError
        With everything that is wrong: mass or inertia that no body can have, shapes, NaN.

    See Also
    --------
    RigidBody.box, RigidBody.cylinder, RigidBody.sphere, RigidBody.from_mesh : From a shape.

    Examples
    --------
    >>> rod = RigidBody("rod", 2.0, (0.01, 0.7, 0.7), markers={"tip": (1, 0, 0)})
    >>> rod["tip"]
    <Marker 'rod.tip'>
    """

    name: str
    mass: float
    inertia: Array
    center: Array
    markers: Mapping[str, Array]
    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array
    outline: Array | None

    def __init__(
        self,
        name: str,
        mass: float,
        inertia: ArrayLike,
        *,
        center: ArrayLike = ZERO3,
        markers: Mapping[str, ArrayLike] | None = None,
        position: ArrayLike = ZERO3,
        orientation: Any = None,
        velocity: ArrayLike = ZERO3,
        angular_velocity: ArrayLike = ZERO3,
        outline: ArrayLike | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, "body", name)
        kilograms = number(problems, where, "mass", mass)
        if kilograms is not None and kilograms <= 0:
            problems.add(where, f"mass is {kilograms:g} kg, must be a positive number")
        tensor = check_inertia(problems, where, inertia)
        named: Any = {} if markers is None else markers
        if not isinstance(named, Mapping):
            problems.add(where, f"markers is {named!r}, must be a mapping of names to positions")
            named = {}
        points = {
            str(point): problems.array(where, f"markers[{point!r}]", at, (3,))
            for point, at in named.items()
        }
        for point in points:
            if point in ("origin", "center"):
                problems.add(
                    where, f"marker {point!r}: the name is taken by the body's own {point}"
                )
        values = {
            "center": problems.array(where, "center", center, (3,)),
            **initial_pose(problems, where, position, orientation, velocity, angular_velocity),
            "outline": None
            if outline is None
            else problems.array(
                where, "outline", outline, (None, 3) if np.ndim(outline) < 3 else (None, 3, 3)
            ),
        }
        problems.raise_if_any()
        set_fields(
            self,
            name=name,
            mass=kilograms,
            inertia=tensor,
            markers=Frozen(points),
            **values,
        )

    @classmethod
    def box(
        cls,
        name: str,
        size: ArrayLike,
        *,
        mass: float | None = None,
        density: float | None = None,
        at: ArrayLike = ZERO3,
        **options: Any,
    ) -> RigidBody:
        """Return a homogeneous box with its mass, inertia and shape.

        Parameters
        ----------
        name : str
            Name, unique among the bodies.
        size : (3,) array_like
            Lengths along the axes of the body frame, m.
        mass, density : float, optional
            kg or kg/m3, one of the two.
        at : (3,) array_like
            Where its middle is in the body frame, m.
        **options
            markers, position, orientation, velocity and angular_velocity of the body.

        Examples
        --------
        >>> RigidBody.box("crate", (1.0, 0.5, 0.2), density=700)
        <RigidBody 'crate': 70 kg>
        """
        made = body_arguments(name, lambda where, p: box(where, size, p), mass, density, at)
        return cls(name, **made, **options)

    @classmethod
    def cylinder(
        cls,
        name: str,
        radius: float,
        length: float,
        *,
        axis: ArrayLike = (0.0, 0.0, 1.0),
        mass: float | None = None,
        density: float | None = None,
        at: ArrayLike = ZERO3,
        **options: Any,
    ) -> RigidBody:
        """Return a homogeneous cylinder with its mass, inertia and shape.

        Parameters
        ----------
        name : str
            Name, unique among the bodies.
        radius, length : float
            m.
        axis : (3,) array_like
            Direction of its axis in the body frame.
        mass, density : float, optional
            kg or kg/m3, one of the two.
        at : (3,) array_like
            Where its middle is in the body frame, m.
        **options
            markers, position, orientation, velocity and angular_velocity of the body.

        Examples
        --------
        >>> RigidBody.cylinder("wheel", radius=0.3, length=0.1, mass=12)
        <RigidBody 'wheel': 12 kg>
        """
        made = body_arguments(
            name, lambda where, p: cylinder(where, radius, length, axis, p), mass, density, at
        )
        return cls(name, **made, **options)

    @classmethod
    def sphere(
        cls,
        name: str,
        radius: float,
        *,
        mass: float | None = None,
        density: float | None = None,
        at: ArrayLike = ZERO3,
        **options: Any,
    ) -> RigidBody:
        """Return a homogeneous sphere with its mass, inertia and shape.

        Parameters
        ----------
        name : str
            Name, unique among the bodies.
        radius : float
            m.
        mass, density : float, optional
            kg or kg/m3, one of the two.
        at : (3,) array_like
            Where its middle is in the body frame, m.
        **options
            markers, position, orientation, velocity and angular_velocity of the body.

        Examples
        --------
        >>> RigidBody.sphere("ball", radius=0.11, mass=0.43)
        <RigidBody 'ball': 0.43 kg>
        """
        made = body_arguments(name, lambda where, p: sphere(where, radius, p), mass, density, at)
        return cls(name, **made, **options)

    @classmethod
    @explained
    def from_mesh(
        cls,
        name: str,
        surface: Any,
        *,
        unit: str = "m",
        mass: float | None = None,
        density: float | None = None,
        at: ArrayLike = ZERO3,
        **options: Any,
    ) -> RigidBody:
        """Return a homogeneous body of any shape, from its closed surface.

        Mass, centre and inertia are exact for the triangles, by the divergence theorem.

        Parameters
        ----------
        name : str
            Name, unique among the bodies.
        surface : path, Mesh or (nt, 3, 3) array_like
            A file with triangles (STL, OBJ, PLY and what else meshio reads), a `Mesh` of solids,
            or the corners of triangles.
        unit : {"m", "mm", "cm", "in", "ft"}
            Unit of a file or an array.
        mass, density : float, optional
            kg or kg/m3, one of the two.
        at : (3,) array_like
            Where the origin of the surface is in the body frame, m.
        **options
            markers, position, orientation, velocity and angular_velocity of the body.

        Raises
        ------
        InputError
            If the file cannot be read, or the surface is open or turned inside out in parts.
        """
        made = body_arguments(
            name,
            lambda where, p: closed_surface(where, read_surface(where, surface, unit)),
            *(mass, density, at),
        )
        return cls(name, **made, **options)

    __iter__: ClassVar[None] = None

    def __repr__(self) -> str:
        return f"<RigidBody {self.name!r}: {self.mass:g} kg>"

    def __getitem__(self, point: str) -> Marker:
        """Return the marker at a named point.

        Raises
        ------
        InputError
            If there is no such point; names the nearest one.
        """
        if point == "origin":
            return self.at(ZERO3, name=point)
        if point == "center":
            return self.at(self.center, name=point)
        if point not in self.markers:
            known = ["origin", "center", *self.markers]
            raise InputError(
                Problem(f"body {self.name!r}", f"no marker {point!r}{suggest(str(point), known)}")
            )
        return self.at(self.markers[point], name=point)

    @explained
    def at(self, position: ArrayLike, axes: Any = None, name: str | None = None) -> Marker:
        """Return a marker at a position in the body frame, m, with axes relative to it."""
        return marker_at(self, position, axes, name)

    @property
    def modal_coordinates(self) -> Array:
        """No modal coordinates, shape (0,)."""
        return read_only(np.zeros(0))

    @property
    def modal_velocities(self) -> Array:
        """No modal velocities, shape (0,)."""
        return read_only(np.zeros(0))


@dataclass(frozen=True, eq=False, init=False, repr=False)
class FlexibleBody:
    """A reduced part in a floating frame with its initial state.

    A particle with undeformed local position u0 and mode shapes Phi (3, n) is at
    ``r = R + A (u0 + Phi p)`` (Rantalainen 2007, section 3.2).

    Parameters
    ----------
    name : str
        Name, unique among the bodies.
    reduced : ReducedPart
        Modes, invariants and nodes; may be shared by several bodies.
    damping : float, sequence of float or Rayleigh
        Modal damping ratio for all modes, one for each mode, or Rayleigh coefficients. The ratio
        is that of the modes of the free body (``reduced.frequencies``): a vibration that joints
        lower to a frequency f has less. For a ratio zeta at f use ``Rayleigh(0, zeta/(pi f))``.
    position, orientation : (3,) array_like, orientation
        Initial pose of the floating frame (the part's frame) in the world, m.
    velocity, angular_velocity : (3,) array_like
        Initial velocity of the frame's origin, m/s, and angular velocity, rad/s, both
        resolved in the world frame.
    modal_coordinates, modal_velocities : (n,) array_like, optional
        Initial p, kg^0.5 m, and p', kg^0.5 m/s; None for zero.
    drop_invariants : iterable of {"I5", "I9"}
        Inertia invariants to leave out for speed (Rantalainen 2007, section 3.6.2); this
        makes the equations approximate.

    Attributes
    ----------
    modal_damping : (n,) array
        Diagonal of D, 1/s: the damping force on the modes is ``-D p'``.

    Raises
    ------
    InputError
        With everything that is wrong, including a mass matrix that is singular because all
        mass lies on one line.
    """

    name: str
    reduced: ReducedPart
    damping: Any
    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array
    modal_coordinates: Array
    modal_velocities: Array
    modal_damping: Array
    drop_invariants: frozenset[str]

    def __init__(
        self,
        name: str,
        reduced: ReducedPart,
        *,
        damping: Any = 0.0,
        position: ArrayLike = ZERO3,
        orientation: Any = None,
        velocity: ArrayLike = ZERO3,
        angular_velocity: ArrayLike = ZERO3,
        modal_coordinates: ArrayLike | None = None,
        modal_velocities: ArrayLike | None = None,
        drop_invariants: Iterable[str] = (),
    ) -> None:
        problems = Problems()
        where = check_name(problems, "body", name)
        values = initial_pose(problems, where, position, orientation, velocity, angular_velocity)
        names: Any = (drop_invariants,) if isinstance(drop_invariants, str) else drop_invariants
        if not isinstance(names, Iterable):
            problems.add(where, f"drop_invariants is {names!r}, must be names such as 'I5'")
            names = ()
        dropped = tuple(names)
        for invariant in dropped:
            if invariant not in DROPPABLE:
                problems.add(
                    where,
                    f"drop_invariants: {invariant!r} cannot be dropped"
                    f"{suggest(str(invariant), DROPPABLE)}",
                )
        if not all(hasattr(reduced, a) for a in ("modes", "frequencies", "invariants")):
            hint = "; reduce it first, reduce(part, method)" if hasattr(reduced, "K") else ""
            problems.add(
                where, f"reduced is a {type(reduced).__name__}, must be a ReducedPart{hint}"
            )
            problems.raise_if_any()
        n = len(reduced.frequencies)
        for key, given in (
            ("modal_coordinates", modal_coordinates),
            ("modal_velocities", modal_velocities),
        ):
            values[key] = problems.array(where, key, np.zeros(n) if given is None else given, (n,))
        damping = tuple(damping) if isinstance(damping, list | np.ndarray) else damping
        values["modal_damping"] = damping_diagonal(problems, where, damping, reduced)
        problems.raise_if_any()
        set_fields(
            self,
            name=name,
            reduced=reduced,
            damping=damping,
            drop_invariants=frozenset(dropped),
            **values,
        )
        check_mass(name, reduced.invariants, self.modal_coordinates)

    __iter__: ClassVar[None] = None

    def __repr__(self) -> str:
        return f"<FlexibleBody {self.name!r}: {self.n} modes>"

    def __getitem__(self, point: str) -> Marker:
        """Return the marker at a node: an interface, a single-node set or "node7" (from 1).

        Raises
        ------
        InputError
            If there is no such node; names the nearest one.
        """
        try:
            node = int(self.reduced.node(point))
        except InputError as error:
            raise InputError(
                [Problem(f"body {self.name!r}", p.message) for p in error.problems]
            ) from None
        return Marker(
            self, str(point), read_only(self.reduced.nodes[node]), node, read_only(np.eye(3))
        )

    def at(self, position: ArrayLike, axes: Any = None, name: str | None = None) -> Marker:
        """Raise InputError: the markers of a flexible body sit on its nodes, see above."""
        raise InputError(
            Problem(
                f"body {self.name!r}",
                'is flexible, its markers sit on nodes: use a name such as body["node7"], and '
                ".turned(axes) for other axes",
            )
        )

    @property
    def n(self) -> int:
        """Number of modes."""
        return len(self.reduced.frequencies)


Body: TypeAlias = Ground | RigidBody | FlexibleBody
MovingBody: TypeAlias = RigidBody | FlexibleBody


# -- helpers of the constructors ------------------------------------------------------------


def marker_at(body: Ground | RigidBody, position: ArrayLike, axes: Any, name: str | None) -> Marker:
    """Return a marker of the ground or a rigid body at a position in its frame."""
    problems = Problems()
    where = "ground" if isinstance(body, Ground) else f"body {body.name!r}"
    at = problems.array(where, "position of the marker", position, (3,))
    problems.raise_if_any()
    assert at is not None
    point = name or "at(" + ", ".join(f"{x:g}" for x in at) + ")"
    return Marker(body, point, at, None, marker_axes(f"{body.name}.{point}", axes))


def initial_pose(
    problems: Problems,
    where: str,
    position: ArrayLike,
    orientation: Any,
    velocity: ArrayLike,
    angular_velocity: ArrayLike,
) -> dict[str, Any]:
    """Return the checked initial pose and velocity of a body frame."""
    return {
        "position": problems.array(where, "position", position, (3,)),
        "orientation": parse_orientation(problems, where, "orientation", orientation),
        "velocity": problems.array(where, "velocity", velocity, (3,)),
        "angular_velocity": problems.array(where, "angular_velocity", angular_velocity, (3,)),
    }
