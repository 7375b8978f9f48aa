"""Force elements: springs, bushings, forces along coordinates, servos, modal and user loads."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, read_only
from jousto.base.errors import Problems
from jousto.base.fields import Field, field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.bodies.body import ground
from jousto.mechanism.bodies.body_field import FlexibleField
from jousto.mechanism.bodies.marker import Marker, MarkerField
from jousto.mechanism.forces.base import Actuator, ForceElement, Push
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.joints.coordinate import (
    DAMPING,
    FORCE,
    RATE,
    STIFFNESS,
    VALUE,
    CoordinateField,
    Distance,
)
from jousto.mechanism.signals.base import OptionalSignal, SignalField
from jousto.mechanism.signals.piecewise import Table


class CurveField(Field["Table | None", "Table | None"]):
    """Field of a table of a force over a coordinate or its rate, or None.

    Parameters
    ----------
    text, default, unit
        As for every field.
    at : Along
        Unit of the coordinate or rate on which the force depends.
    """

    form = "curve"
    noun = "Table"

    def __init__(self, text: str = "", *, at: Any, **common: Any) -> None:
        super().__init__(text, **common)
        self.at = at

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the table, or report a value of another type."""
        if not isinstance(value, Table):
            problems.add(where, f"{self.name} is {value!r}, must be a Table or None")
        return value


class _AlongLaw(EngineLaw):
    def with_numbers(self, numbers: Any) -> EngineLaw:
        """Return the law; with the factor 1 its function has the unit of the force."""
        return replace(self, signal=FORCE) if numbers.preload == 1.0 else self


_AlongLaw(
    "along",
    units={
        "stiffness": STIFFNESS,
        "damping": DAMPING,
        "free": VALUE,
        "preload": FORCE,
        "limit": FORCE,
    },
    reference=VALUE,
    between=True,
    fast={"springs": ("stiffness", "spring"), "dampers": ("damping", "damper")},
    side_by_side=True,
).declared()
EngineLaw(
    "bushing",
    units={
        "K": ("N/m",) * 3 + ("N m/rad",) * 3,
        "D": ("N s/m",) * 3 + ("N m s/rad",) * 3,
    },
    constants=("preload",),
    between=True,
    fast={"bushings": ()},
    side_by_side=True,
).declared()
EngineLaw("modal load", units={"force": "N", "torque": "N m"}, side_by_side=True).declared()
EngineLaw("user", constants=("none",)).declared()


class Spring(ForceElement, tag="spring"):
    """Spring and damper along a coordinate.

    ``f = -k (s - free) - c s' + preload + table(s) + damper_table(s')`` acts along +s on the body
    of marker b, and along -s on the body of marker a.
    """

    kind = "spring"
    usage = (
        "Spring(name, coordinate, stiffness, ...), or between two markers "
        "Spring.between(name, a, b, stiffness, ...)"
    )
    coordinate: CoordinateField = field(
        "Coordinate of the spring: a length (N, m) or an angle (N m, rad)"
    )
    stiffness: Number = field("k", unit=STIFFNESS, least=0, default=0.0)
    damping: Number = field("c", unit=DAMPING, least=0, default=0.0)
    free: OptionalNumber = field(
        "Value at which the spring has no force; None for the value at the initial pose",
        unit=VALUE,
        default=None,
    )
    preload: Number = field("Constant force along +s", unit=FORCE, default=0.0)
    table: CurveField = field(
        "Force along +s as a function of s, constant beyond the ends of the table",
        unit=FORCE,
        at=VALUE,
        default=None,
    )
    damper_table: CurveField = field(
        "Force along +s as a function of s', constant beyond the ends of the table",
        unit=FORCE,
        at=RATE,
        default=None,
    )

    @classmethod
    def between(cls, name: str, a: Marker, b: Marker, *args: Any, **kwargs: Any) -> Spring:
        """Return the spring along the line between two markers; other arguments as for `Spring`."""
        return cls(name, Distance(a, b, name=f"{name}.distance"), *args, **kwargs)

    @property
    def symbol(self) -> str:
        """Symbol of a spring, a damper or both."""
        soft = self.stiffness or self.table is not None
        slow = self.damping or self.damper_table is not None
        kind = "spring-damper" if soft and slow else "damper" if slow else "spring"
        return f"torsion-{kind}" if self.turns else kind

    @property
    def free_value(self) -> float:
        """Value of the coordinate at which the spring has no force, m or rad."""
        return self.coordinate.initial if self.free is None else self.free

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The spring as a law of the engine."""
        data = along(self.stiffness, self.damping, self.free_value, self.preload)
        s, table, damper = self.coordinate, self.table, self.damper_table
        return (Push("along", data, coordinate=s, spring=table, damper=damper),)


class Matrix6(Field[ArrayLike, Array]):
    """Field of a symmetric, positive semi-definite (6, 6) matrix, of its diagonal (6,), or 0.

    Parameters
    ----------
    text, default
        As for every field.
    units : ((str, str), (str, str))
        SI units of the blocks: rows are force and torque, columns are translation and rotation.
    """

    form = "matrix6"
    noun = "(6,) or (6, 6) array_like or 0"

    def __init__(self, text: str = "", *, units: Any, **common: Any) -> None:
        super().__init__(text, **common)
        self.units = units

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the matrix, or report what is wrong."""
        return matrix6(problems, where, self.name, value)


class Wrench(Field["ArrayLike | None", Array]):
    """Field of a force and a torque, six numbers; None for zero."""

    form = "wrench"
    noun = "(6,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the six numbers as an array, or report what is wrong."""
        return problems.array(where, self.name, value, (6,))


class Bushing(ForceElement, tag="bushing"):
    """Bushing with the force and torque ``[F, T] = -K [d, theta] - D [d', omega] + preload`` on b.

    d = r_b - r_a, its rate as seen in a, the rotation vector theta of b against a and the relative
    angular velocity omega are resolved in a. An isotropic damper gives the torque ``-c omega`` at
    any attitude. The springs have a potential energy. The moments m of springs and preload do the
    work ``m . theta'``; they give the torque ``J(theta)^-T m``, where ``omega = J theta'``. For an
    isotropic spring or small angles the torque equals m.
    """

    kind = "bushing"
    a: MarkerField = field("Frame a")
    b: MarkerField = field("Frame b")
    stiffness: Matrix6 = field(
        "Stiffness K, translation then rotation: symmetric, positive semi-definite; six numbers "
        "are the diagonal",
        units=(("N/m", "N/rad"), ("N", "N m/rad")),
    )
    damping: Matrix6 = field(
        "Damping D, in the form of the stiffness",
        units=(("N s/m", "N s/rad"), ("N s", "N m s/rad")),
        default=0.0,
    )
    preload: Wrench = field(
        "Constant force, N, and torque, N m, on b, resolved in a; None for zero", default=None
    )

    def __post_init__(self) -> None:
        given: Any = self.preload
        if given is None:
            object.__setattr__(self, "preload", np.zeros(6))
        super().__post_init__()

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The bushing as a law of the engine."""
        data = {"K": self.stiffness, "D": self.damping, "preload": self.preload}
        return (Push("bushing", data, a=self.a, b=self.b),)


class JointForce(Actuator, tag="joint-force"):
    """Force or torque along a coordinate: ``f = signal(t)``; with an `Input` it is an actuator."""

    kind = "joint force"
    coordinate: CoordinateField = field(
        "Coordinate s; the force acts along +s on the body of marker b"
    )
    signal: SignalField = field("Force as a function of time", unit=FORCE)

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The force as a law of the engine."""
        s, f = self.coordinate, self.signal
        return (Push("along", along(preload=1.0), coordinate=s, active=True, signal=f),)


class Servo(Actuator, tag="servo"):
    """PD-controlled force: ``f = clamp(kp (ref - s) + kd (ref' - s'), +-limit)``."""

    kind = "servo"
    coordinate: CoordinateField = field("The controlled coordinate")
    reference: SignalField = field("Wanted value", unit=VALUE)
    kp: Number = field("Gain on the error", unit=STIFFNESS, least=0)
    kd: Number = field("Gain on the rate of the error", unit=DAMPING, least=0, default=0.0)
    limit: OptionalNumber = field(
        "Largest force; None for no limit",
        unit=FORCE,
        above=0,
        remedy="None for no limit",
        default=None,
    )

    @property
    def pushes(self) -> tuple[Push, ...]:
        """A spring and damper to the reference, as a law of the engine."""
        data = along(self.kp, self.kd, limit=self.limit or 0.0)
        s = self.coordinate
        return (Push("along", data, coordinate=s, active=True, reference=self.reference),)


class PatternField(Field[ArrayLike, Array]):
    """Field of a force on every node of a body, (nodes, 3), N."""

    form = "pattern"
    noun = "(nodes, 3) array_like"


class ModalLoad(ForceElement, tag="modal-load"):
    """Pattern of nodal forces that turns with a flexible body, such as a pressure."""

    kind = "modal load"
    together = ("body",)
    body: FlexibleField = field("The body")
    pattern: PatternField = field("Force on every node, body frame", unit="N")
    signal: OptionalSignal = field(
        "Factor on the pattern as a function of time; None for 1", unit="1", default=None
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Store the pattern as an array; report one that does not fit the nodes of the body."""
        shape = (len(self.body.reduced.nodes), 3)
        found = problems.array(where, "pattern", self.pattern, shape)
        object.__setattr__(self, "pattern", found)

    @property
    def load(self) -> Array:
        """Generalised load (6 + n,): force, moment about the undeformed origin, modal forces."""
        nodes = np.asarray(self.body.reduced.nodes, dtype=np.float64)
        modal = np.einsum("ka,kaj->j", self.pattern, self.body.reduced.modes)
        moment = np.cross(nodes, self.pattern).sum(axis=0)
        return np.concatenate([self.pattern.sum(axis=0), moment, modal])

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The generalised load as a law of the engine."""
        load = self.load
        data = {"force": load[:3], "torque": load[3:6]}
        return (Push("modal load", data, (load[6:],), body=self.body, signal=self.signal),)


class DefaultMarker(Field["Marker | None", Marker]):
    """Field of a marker; None for the origin of the world."""

    form = "marker"
    noun = "Marker"
    check = MarkerField.check


class FunctionField(Field[Any, Any]):
    """Field of a Python or compiled function; a model file contains ``file.py:name``."""

    form = "function"
    noun = "callable, LowLevelCallable, numba cfunc or ctypes function"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the function, or report a value of another type."""
        # a scipy.LowLevelCallable is a tuple that cannot be called
        if not (callable(value) or isinstance(value, tuple)):
            problems.add(where, f"{self.name} is {value!r}, must be callable or compiled")
        return value


class UserForce(ForceElement, tag="user-force"):
    """Force and torque at a marker, computed by a function of the user: ``y = function(t, x)``.

    The function is called several times in a step, with t in s. x (18,) is the pose and velocity of
    `marker` relative to `reference`, resolved in the axes of `reference`:

    ============ ============================================================ =====
    ``x[0:3]``   position of the marker, r_b - r_a                            m
    ``x[3:12]``  its orientation, ``x[3:12].reshape(3, 3)``: columns are axes
    ``x[12:15]`` its velocity as seen from the turning reference              m/s
    ``x[15:18]`` its angular velocity against the reference                   rad/s
    ============ ============================================================ =====

    The function returns six numbers y: the force ``y[0:3]``, N, and torque ``y[3:6]``, N m, on the
    body of `marker`, at the marker and resolved in the axes of `reference`. The opposite force and
    torque act on the body of `reference`. Values that are not finite and exceptions stop the run
    with an error message. The result must not depend on earlier calls, because solvers try steps
    and repeat them. Compiled functions run at the speed of C and have the signature ``int f(double
    t, const double *x, double *y, void *user)`` (``jo_callback`` in jousto.h): they write y and
    return 0, or another number for an error.

    Examples
    --------
    Air that brakes a ball, ``F = -c |v| v``, c in kg/m:

    >>> import numpy as np
    >>> from jousto import RigidBody
    >>> ball = RigidBody("ball", 0.43, (1e-3, 1e-3, 1e-3), velocity=(20, 0, 0))
    >>> def air(t, x):
    ...     v = x[12:15]
    ...     return [*(-0.008 * np.linalg.norm(v) * v), 0.0, 0.0, 0.0]
    >>> drag = UserForce("drag", ball["origin"], air)
    """

    kind = "user force"
    ties = False
    marker: MarkerField = field("Marker at which the force acts, frame b of the function")
    function: FunctionField = field("Function that returns force and torque")
    reference: DefaultMarker = field(
        "Reference marker, frame a; None for the world, with positions and forces in world axes",
        default=None,
    )

    def __post_init__(self) -> None:
        given: Any = self.reference
        if given is None:
            object.__setattr__(self, "reference", ground["origin"])
        super().__post_init__()

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The function as a law of the engine."""
        return (Push("user", {}, a=self.reference, b=self.marker, function=self.function),)


def along(
    stiffness: float = 0.0,
    damping: float = 0.0,
    free: float = 0.0,
    preload: float = 0.0,
    limit: float = 0.0,
) -> dict[str, float]:
    """Return the numbers of the engine's law for a force along a coordinate."""
    return {
        "stiffness": stiffness,
        "damping": damping,
        "free": free,
        "preload": preload,
        "limit": limit,
    }


def matrix6(problems: Problems, where: str, name: str, value: Any) -> Array | None:
    """Return a symmetric, positive semi-definite (6, 6) matrix, or report why it is invalid."""
    if np.ndim(value) == 0:
        value = np.full(6, value)
    if np.shape(value) == (6,):
        diagonal = problems.array(where, name, value, (6,))
        M = None if diagonal is None else np.diag(diagonal)
    else:
        M = problems.array(where, name, value, (6, 6))
    if M is None:
        return None
    scale = float(np.abs(M).max())
    if np.abs(M - M.T).max() > 1e-9 * scale:
        i, j = np.unravel_index(np.argmax(np.abs(M - M.T)), M.shape)
        problems.add(
            where,
            f"{name} is not symmetric: element ({i + 1},{j + 1}) is {M[i, j]:g}, "
            f"({j + 1},{i + 1}) is {M[j, i]:g}",
            name,
        )
    elif np.linalg.eigvalsh(M.real)[0] < -1e-9 * scale:
        lowest = np.linalg.eigvalsh(M.real)[0]
        problems.add(
            where,
            f"{name} has the negative eigenvalue {lowest:g}: the bushing would add energy",
            name,
        )
    return read_only(M)
