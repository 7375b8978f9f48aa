"""Force elements: springs, bushings, forces along coordinates, servos, modal and user loads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.described import described
from jousto.base.errors import Problems
from jousto.base.names import check_name
from jousto.base.numbers import number, set_fields
from jousto.base.rotations import Array, readonly
from jousto.mechanism.bodies.body import FlexibleBody, ground
from jousto.mechanism.bodies.marker import Marker, check_marker
from jousto.mechanism.forces.line_load import LineLoad
from jousto.mechanism.forces.moving import MovingLoad
from jousto.mechanism.joints.coordinate import Coordinate, Distance, check_coordinate
from jousto.mechanism.signals.base import Signal, check_signal
from jousto.mechanism.signals.piecewise import Table


@described
@dataclass(frozen=True, eq=False, init=False)
class Spring:
    """A spring and damper along a coordinate.

    ``f = -k (s - free) - c s' + preload + table(s) + damper_table(s')``, along +s on the body
    of marker b and against it on that of a.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    coordinate : Coordinate
        A distance or displacement (N, m) or an angle (N m, rad).
    stiffness, damping : float
        k, N/m or N m/rad, and c, N s/m or N m s/rad; not negative.
    free : float, optional
        Value without force; None for that of the initial pose.
    preload : float
        Constant force along +s.
    table, damper_table : Table, optional
        Force along +s as a function of s and of s'; held beyond its ends.
    """

    kind: ClassVar[str] = "spring"
    name: str
    coordinate: Coordinate
    stiffness: float
    damping: float
    free: float | None
    preload: float
    table: Table | None
    damper_table: Table | None

    def __init__(
        self,
        name: str,
        coordinate: Coordinate,
        stiffness: float = 0.0,
        damping: float = 0.0,
        free: float | None = None,
        preload: float = 0.0,
        table: Table | None = None,
        damper_table: Table | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        check_coordinate(problems, where, "coordinate", coordinate)
        values = {
            "stiffness": positive(problems, where, "stiffness", stiffness),
            "damping": positive(problems, where, "damping", damping),
            "free": None if free is None else number(problems, where, "free", free),
            "preload": number(problems, where, "preload", preload),
        }
        tables: tuple[tuple[str, Any], ...] = (("table", table), ("damper_table", damper_table))
        for key, value in tables:
            if not (value is None or isinstance(value, Table)):
                problems.add(where, f"{key} is {value!r}, must be a Table or None")
        problems.raise_if_any()
        set_fields(
            self, name=name, coordinate=coordinate, table=table, damper_table=damper_table, **values
        )

    @classmethod
    def between(cls, name: str, a: Marker, b: Marker, *args: Any, **kwargs: Any) -> Spring:
        """Return the spring along the line between two markers; the rest as for `Spring`."""
        return cls(name, Distance(a, b, name=f"{name}.distance"), *args, **kwargs)

    @property
    def free_value(self) -> float:
        """Value of the coordinate without force, m or rad."""
        return self.coordinate.initial if self.free is None else self.free


@described
@dataclass(frozen=True, eq=False, init=False)
class Bushing:
    """A linear support: ``[F, T] = -K [d, theta] - D [d', theta'] + preload`` on b.

    d = r_b - r_a and the rotation vector theta of b against a are resolved in a.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    a, b : Marker
        The frames.
    stiffness, damping : (6,) or (6, 6) array_like or 0
        K and D, translation then rotation; symmetric and not negative. Six numbers are the
        diagonal.
    preload : (6,) array_like, optional
        Force, N, and torque, N m, on b, resolved in a.
    """

    kind: ClassVar[str] = "bushing"
    name: str
    a: Marker
    b: Marker
    stiffness: Array
    damping: Array
    preload: Array

    def __init__(
        self,
        name: str,
        a: Marker,
        b: Marker,
        stiffness: ArrayLike,
        damping: ArrayLike = 0.0,
        preload: ArrayLike | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        check_marker(problems, where, "a", a)
        check_marker(problems, where, "b", b)
        K = matrix6(problems, where, "stiffness", stiffness)
        D = matrix6(problems, where, "damping", damping)
        P = problems.array(where, "preload", np.zeros(6) if preload is None else preload, (6,))
        problems.raise_if_any()
        set_fields(self, name=name, a=a, b=b, stiffness=K, damping=D, preload=P)


@described
@dataclass(frozen=True, eq=False, init=False)
class JointForce:
    """A force or torque along a coordinate: ``f = signal(t)``; with `Input` an actuator.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    coordinate : Coordinate
        It acts along +s on the body of marker b.
    signal : Signal or float
        N, or N m along an angle.
    """

    kind: ClassVar[str] = "joint force"
    name: str
    coordinate: Coordinate
    signal: Signal

    def __init__(self, name: str, coordinate: Coordinate, signal: Signal | float) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        check_coordinate(problems, where, "coordinate", coordinate)
        value = check_signal(problems, where, "signal", signal)
        problems.raise_if_any()
        set_fields(self, name=name, coordinate=coordinate, signal=value)


@described
@dataclass(frozen=True, eq=False, init=False)
class Servo:
    """A controlled force: ``f = clamp(kp (ref - s) + kd (ref' - s'), +-limit)``.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    coordinate : Coordinate
        What is controlled.
    reference : Signal or float
        Wanted value, m or rad.
    kp, kd : float
        Gains, N/m and N s/m or N m/rad and N m s/rad; not negative.
    limit : float, optional
        Largest force, N or N m, more than zero; None for no limit.
    """

    kind: ClassVar[str] = "servo"
    name: str
    coordinate: Coordinate
    reference: Signal
    kp: float
    kd: float
    limit: float | None

    def __init__(
        self,
        name: str,
        coordinate: Coordinate,
        reference: Signal | float,
        kp: float,
        kd: float = 0.0,
        limit: float | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        check_coordinate(problems, where, "coordinate", coordinate)
        values = {
            "reference": check_signal(problems, where, "reference", reference),
            "kp": positive(problems, where, "kp", kp),
            "kd": positive(problems, where, "kd", kd),
            "limit": None if limit is None else positive(problems, where, "limit", limit),
        }
        if values["limit"] == 0.0:
            problems.add(where, "limit is 0, must be more; None is no limit")
        problems.raise_if_any()
        set_fields(self, name=name, coordinate=coordinate, **values)


@described
@dataclass(frozen=True, eq=False, init=False)
class ModalLoad:
    """A pattern of nodal forces that follows a flexible body, such as a pressure.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    body : FlexibleBody
        The body.
    pattern : (nodes, 3) array_like
        Force on every node, N, body frame.
    signal : Signal or float, optional
        Factor as a function of time; None for 1.
    """

    kind: ClassVar[str] = "modal load"
    name: str
    body: FlexibleBody
    pattern: Array
    signal: Signal | None

    def __init__(
        self,
        name: str,
        body: FlexibleBody,
        pattern: ArrayLike,
        signal: Signal | float | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        checked: Any = body
        F = None
        if not isinstance(checked, FlexibleBody):
            problems.add(where, f"body is {checked!r}, must be a flexible body")
        else:
            F = problems.array(where, "pattern", pattern, (len(body.reduced.nodes), 3))
        factor = None if signal is None else check_signal(problems, where, "signal", signal)
        problems.raise_if_any()
        set_fields(self, name=name, body=body, pattern=F, signal=factor)

    @property
    def load(self) -> Array:
        """Generalised load (6 + n,): force, moment about the undeformed origin, modal forces."""
        nodes = np.asarray(self.body.reduced.nodes, dtype=np.float64)
        modal = np.einsum("ka,kaj->j", self.pattern, self.body.reduced.modes)
        moment = np.cross(nodes, self.pattern).sum(axis=0)
        return np.concatenate([self.pattern.sum(axis=0), moment, modal])


@described
@dataclass(frozen=True, eq=False, init=False)
class UserForce:
    """A force and torque at a marker by a function of the user.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    marker : Marker
        Where it acts, frame b of the function.
    function : callable, LowLevelCallable, numba cfunc or ctypes function
        Called as ``y = function(t, x)`` several times in a step, t in s. x is an array (18,), how
        `marker` stands and moves against `reference`, everything resolved in the axes of
        `reference`:

        ============ ============================================================ =====
        ``x[0:3]``   position of the marker, r_b - r_a                            m
        ``x[3:12]``  its orientation, ``x[3:12].reshape(3, 3)``: columns are axes
        ``x[12:15]`` its velocity as seen from the turning reference              m/s
        ``x[15:18]`` its angular velocity against the reference                   rad/s
        ============ ============================================================ =====

        It returns six numbers y: the force ``y[0:3]``, N, and torque ``y[3:6]``, N m, on the body
        of `marker`, at the marker and resolved in the axes of `reference`. The body of the
        reference gets the opposite of both. Values that are not finite and exceptions stop the
        run with their message. It must not remember earlier calls: solvers try steps and repeat
        them. Compiled functions run at the speed of C and have the signature
        ``int f(double t, const double *x, double *y, void *user)`` (``jo_callback`` in jousto.h):
        they write y and return 0, or another number for an error.
    reference : Marker
        Frame a; the world by default, then positions and forces are in world axes.

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

    kind: ClassVar[str] = "user force"
    name: str
    marker: Marker
    function: Any
    reference: Marker

    def __init__(
        self,
        name: str,
        marker: Marker,
        function: Callable[..., Any] | Any,
        reference: Marker | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        frame = ground["origin"] if reference is None else reference
        check_marker(problems, where, "marker", marker)
        check_marker(problems, where, "reference", frame)
        # a scipy.LowLevelCallable is a tuple that cannot be called
        if not (callable(function) or isinstance(function, tuple)):
            problems.add(where, f"function is {function!r}, must be callable or compiled")
        problems.raise_if_any()
        set_fields(self, name=name, marker=marker, function=function, reference=frame)


Element = Spring | Bushing | JointForce | Servo | ModalLoad | MovingLoad | UserForce | LineLoad
ELEMENTS: tuple[type[Element], ...] = (
    Spring,
    Bushing,
    JointForce,
    Servo,
    ModalLoad,
    MovingLoad,
    UserForce,
    LineLoad,
)


def positive(problems: Problems, where: str, name: str, value: Any) -> float | None:
    """Return a finite number that is not negative, or note why it is none."""
    found = number(problems, where, name, value)
    if found is not None and found < 0:
        problems.add(where, f"{name} is {found:g}, must not be negative")
    return found


def matrix6(problems: Problems, where: str, name: str, value: Any) -> Array | None:
    """Return a symmetric, positive semi-definite (6, 6) matrix, or note why it is none."""
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
        )
    elif np.linalg.eigvalsh(M)[0] < -1e-9 * scale:
        lowest = np.linalg.eigvalsh(M)[0]
        problems.add(where, f"{name} has the negative eigenvalue {lowest:g}: it would add energy")
    return readonly(M)
