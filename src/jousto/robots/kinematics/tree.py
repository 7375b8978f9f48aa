"""Tree: kinematics and dynamics of rigid machines in joint coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only, skew
from jousto.base.errors import InputError, Problem, Problems, UnknownNameError, suggest
from jousto.base.rotations import euler_parameters, exp_rotation, rotation_matrix
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.mechanism import Mechanism
from jousto.robots.description import Frame, Robot
from jousto.robots.kinematics.jacobians import cross, in_motion, unit
from jousto.robots.kinematics.joint_chain import build_steps, free_coordinates
from jousto.robots.kinematics.loop_joints import Bound, Measured
from jousto.robots.kinematics.loops import Loops, View
from jousto.robots.kinematics.topology import Parts, of_mechanism, of_robot

FEW = 3  # maximum number of names in a message


class Tree:
    """Rigid machine in joint coordinates.

    ``M(q) v' + b(q, v) = tau`` with the bias forces b of motion and gravity. Joints that close
    loops, of each loop the joint with the fewest rows, are not in the tree: `constraints` returns
    their equations ``C(q) = 0``, and `inverse_kinematics` finds positions that satisfy them. M and
    b are available for machines without loops only.

    The order of positions q (nq,) and velocities v (nv,) is: bodies without a joint to the ground,
    in the order of declaration, then joints in the order of declaration (in a robot each joint
    follows its parent).

    ===================== ================================= =======================================
    coordinate            in q                              in v
    ===================== ================================= =======================================
    angle, displacement   rad, m                            rad/s, m/s
    ball                  4 Euler parameters of b in a      3: angular velocity of b against a, in
                                                            the axes of b, rad/s
    free body             position in the world, m, and     velocity in the axes of the world, m/s,
                          4 Euler parameters                and 3: angular velocity in the axes of
                                                            the body, rad/s
    ===================== ================================= =======================================

    A planar joint has x, y and the angle, a cylindrical one displacement and angle, a universal
    one both angles. Couplings, gears, racks and mimic relations eliminate one coordinate each.
    Drives do not eliminate theirs: `inverse_dynamics` returns their force. The unit of tau is that
    of power over v.

    Parameters
    ----------
    machine : Mechanism, Robot or Model
        Machine with bodies, joints and couplings of any kind. Flexible bodies are rigid here, in
        their undeformed shape. Joints of the tree are revolute, prismatic, cylindrical, screw,
        universal, planar, spherical and fixed; all others are cut.
    gravity : (3,) array_like, optional
        Gravitational acceleration, m/s2; None: that of the machine.
    limits : dict of str to (float, float), optional
        Lower and upper limits of coordinates by name, also of cut joints, in addition to those of
        a robot.

    Attributes
    ----------
    nq, nv : int
        Numbers of positions and velocities.
    positions, velocities : tuple of str
        Names of the components of q and v.
    initial : (nq,) array
        Positions at the initial pose of the machine.
    lower, upper : (nv,) arrays
        Limits of the coordinates; infinite without limits.
    cut : tuple of str
        Names of the joints and couplings that close loops.
    lengths : (nv,) array of bool
        Whether a velocity is in m/s; otherwise it is in rad/s.
    gravity : (3,) array
        Gravitational acceleration, m/s2.

    Raises
    ------
    InputError
        If the machine has exact beams, or couplings contradict each other.

    Examples
    --------
    Two rods of a double pendulum, straight down:

    >>> import jousto as jo
    >>> rod = (1.0, (1e-3, 1 / 12, 1 / 12))
    >>> upper = jo.RigidBody("upper", *rod, center=(0.5, 0, 0), markers={"end": (1, 0, 0)})
    >>> lower = jo.RigidBody("lower", *rod, center=(0.5, 0, 0), position=(1, 0, 0))
    >>> one = jo.Revolute("one", jo.ground["origin"], upper["origin"])
    >>> two = jo.Revolute("two", upper["end"], lower["origin"])
    >>> tree = jo.robots.Tree(jo.Mechanism(upper, lower, one, two, jo.Gravity((9.81, 0, 0))))
    >>> tree.velocities
    ('one.angle', 'two.angle')
    >>> tree.mass_matrix([0.0, 0.0]).round(6)
    array([[2.666667, 0.833333],
           [0.833333, 0.333333]])
    """

    nq: int
    nv: int
    positions: tuple[str, ...]
    velocities: tuple[str, ...]
    initial: Array
    lower: Array
    upper: Array
    gravity: Array
    cut: tuple[str, ...]
    lengths: NDArray[np.bool_]

    @explained
    def __init__(
        self,
        machine: Any,
        *,
        gravity: ArrayLike | None = None,
        limits: Mapping[str, tuple[float, float]] | None = None,
    ) -> None:
        machine = getattr(machine, "mechanism", machine)
        problems = Problems()
        g = None if gravity is None else problems.array("Tree", "gravity", gravity, (3,))
        problems.raise_if_any()
        if isinstance(machine, Robot):
            parts = of_robot(machine, machine.gravity if g is None else g)
        elif isinstance(machine, Mechanism):
            parts = of_mechanism(machine)
        else:
            message = f"machine is {machine!r}, must be a Mechanism, a Robot or a Model"
            raise InputError(Problem("Tree", message))
        self._parts: Parts = parts
        self._steps, self._at, names = build_steps(parts)
        self.gravity = read_only(parts.gravity if g is None else g)
        kept, self._G, self._c = free_coordinates(parts, names)
        self._scalar = names.scalar
        self._all = (len(names.positions), len(names.velocities))
        self._arrange(names.positions, names.velocities, kept)
        self._Gv = np.zeros((self._all[1], self.nv))
        for i, name in enumerate(names.velocities):
            if name not in names.scalar:
                self._Gv[i, self.velocities.index(name)] = 1.0
        for i, name in enumerate(names.scalar):
            for j, other in enumerate(kept):
                self._Gv[names.scalar[name][1], self.velocities.index(other)] = self._G[i, j]
        self._kept = kept
        start = np.array(names.initial)
        self.initial = read_only([start[names.positions.index(name)] for name in self.positions])
        self.loops = Loops(parts.closures, parts.size)
        self.cut = self.loops.names
        self._view: tuple[bytes, View] | None = None
        slides = {step.v: 1 for step in self._steps if step.kind == "slide"}
        slides |= {step.v: 3 for step in self._steps if step.kind == "free"}
        first = {names.velocities[i + k] for i, n in slides.items() for k in range(n)}
        self.lengths = np.array([name in first for name in self.velocities], dtype=bool)
        self._limit(parts.limits | dict(limits or {}))
        self._armature = np.zeros(self._all[1])
        for name, inertia in parts.armature.items():
            for i, other in enumerate(names.velocities):
                if other == name or other.startswith(f"{name}.w"):
                    self._armature[i] = inertia

    def _arrange(self, positions: list[str], velocities: list[str], kept: list[str]) -> None:
        """Set the names of free coordinates and the indices of all coordinates."""
        gone = set(self._scalar) - set(kept)
        self.positions = tuple(name for name in positions if name not in gone)
        self.velocities = tuple(name for name in velocities if name not in gone)
        self.nq, self.nv = len(self.positions), len(self.velocities)
        self._where = [
            (positions.index(name), self.positions.index(name))
            for name in self.positions
            if name not in self._scalar
        ]
        places = [self.positions.index(name) for name in kept]
        self._places = np.array(places, dtype=np.intp)
        # balls and free bodies: first index of the Euler parameters in q and of their rates in v
        self._turns = [
            (self.positions.index(f"{name}.e0"), self.velocities.index(f"{name}.wx"))
            for name in dict.fromkeys(x[:-3] for x in self.positions if x not in self._scalar)
            if f"{name}.e0" in self.positions
        ]
        self._free = [
            (self.positions.index(f"{v[:-3]}.{v[-1]}"), self.velocities.index(v))
            for v in self.velocities
            if v not in self._scalar and v[-2] == "v"
        ]

    def _limit(self, limits: Mapping[str, Any]) -> None:
        """Set the limits; limits of eliminated coordinates become limits of the free ones."""
        lower, upper = np.full(self.nv, -np.inf), np.full(self.nv, np.inf)
        rows = {name: i for i, name in enumerate(self._scalar)}
        problems = Problems()
        for name, given in limits.items():
            where = f"limits[{name!r}]"
            if name not in rows and name not in self._parts.measured:
                known = [*rows, *self._parts.measured]
                problems.add(where, f"no such coordinate{suggest(name, known)}")
                continue
            try:
                low, high = (float(x) for x in given)
            except (TypeError, ValueError):
                problems.add(where, f"is {given!r}, must be a lower and an upper limit")
                continue
            if np.isnan(low) or np.isnan(high):
                problems.add(where, f"is {given!r}, must be numbers; inf for no limit")
                continue
            if not low <= high:
                problems.add(where, f"lower limit {low:g} is above the upper limit {high:g}")
                continue
            if name not in rows:
                self.loops.bounds.append(Bound(self._parts.measured[name], low, high))
                continue
            factors = self._G[rows[name]]
            lead = np.flatnonzero(factors)
            if len(lead) != 1:
                continue
            k, c = factors[lead[0]], self._c[rows[name]]
            ends = sorted(((low - c) / k, (high - c) / k))
            j = self.velocities.index(self._kept[int(lead[0])])
            lower[j], upper[j] = max(lower[j], ends[0]), min(upper[j], ends[1])
        problems.raise_if_any()
        self.lower, self.upper = read_only(lower), read_only(upper)

    def __repr__(self) -> str:
        loops = f", {len(self.cut)} joints cut" if self.cut else ""
        return f"<Tree: {len(self._parts.bodies)} bodies, {self.nv} degrees of freedom{loops}>"

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of the frames: bodies, and points of bodies."""
        return tuple(self._parts.frames)

    # -- positions --------------------------------------------------------------------------

    def forward_kinematics(self, q: ArrayLike) -> dict[str, Frame]:
        """Return the poses of all bodies at given positions.

        Parameters
        ----------
        q : (nq,) array_like
            Positions.

        Returns
        -------
        dict of str to Frame
            Origin (3,), m, and axes (3, 3) of each body frame in the world.
        """
        motion = self.view(q).motion
        return {
            body.name: Frame(motion.r[i].copy(), motion.A[i].copy())
            for body, i in zip(self._parts.bodies, self._at, strict=True)
        }

    def pose(self, frame: str | Marker, q: ArrayLike) -> Frame:
        """Return the pose of a frame: a body, a point such as ``"hand.tip"``, or a marker."""
        at = self.view(q).spot(self._frame(frame))
        return Frame(at.r, at.A)

    def jacobian(self, frame: str | Marker, q: ArrayLike) -> Array:
        """Return the Jacobian J (6, nv) of a frame, ``[r', w] = J v``.

        The first three rows give the velocity of its origin, m/s, the others its angular velocity,
        rad/s, both in the world frame.
        """
        at = self.view(q).spot(self._frame(frame))
        return np.concatenate([at.Jr, at.Jw])

    def coordinate(self, coordinate: str | Coordinate, q: ArrayLike) -> float:
        """Return the value of a coordinate of a joint, also of a cut one, m or rad.

        Angles outside the tree are from -pi to pi.

        Parameters
        ----------
        coordinate : str or Coordinate
            ``"crank.angle"``, ``crank.angle`` or ``Distance(a, b)``.
        q : (nq,) array_like
            Positions.

        Raises
        ------
        InputError
            If there is no such coordinate.
        """
        name = str(coordinate.name if isinstance(coordinate, Coordinate) else coordinate)
        known = [*self._scalar, *self._parts.measured]
        if name in self._scalar:
            return float(self.view(q).q[self._scalar[name][0]])
        if name in self._parts.measured:
            return self.view(q).measure(self._parts.measured[name])[0]
        if not isinstance(coordinate, Coordinate):
            message = f"no coordinate {name!r}{suggest(name, known)}"
            raise UnknownNameError(Problem("coordinate", message))
        s, places = coordinate, [self._frame(marker) for marker in (coordinate.a, coordinate.b)]
        return self.view(q).measure(Measured(name, s.engine, s.column, *places))[0]

    def constraints(self, q: ArrayLike) -> Array:
        """Return the residuals C (m,) of the cut joints; zero if the loops are closed.

        The rows are those of the joints in the order of ``tree.cut``: m for coincident points, the
        cosine of the angle for perpendicular axes, and m or rad for coordinates.

        Parameters
        ----------
        q : (nq,) array_like
            Positions.
        """
        return np.array([row.value for row in self.loops.rows(self.view(q))])

    def constraint_jacobian(self, q: ArrayLike) -> Array:
        """Return the Jacobian Cq (m, nv) of `constraints`, ``C' = Cq v``."""
        rows = self.loops.rows(self.view(q))
        return np.array([row.rates for row in rows]).reshape(len(rows), self.nv)

    def moved(self, q: ArrayLike, step: ArrayLike) -> Array:
        """Return the positions (nq,) after an increment of the coordinates.

        Rotations of balls and free bodies are ``A exp(w~)``, so that Euler parameters keep their
        length.

        Parameters
        ----------
        q : (nq,) array_like
            Positions.
        step : (nv,) array_like
            Increment: constant velocity times time.
        """
        here = self._vector("q", q, self.nq).copy()
        d = self._vector("step", step, self.nv)
        for name, j in zip(self._kept, self._places, strict=True):
            here[j] += d[self.velocities.index(name)]
        for i, j in self._free:
            here[i] += d[j]
        for i, j in self._turns:
            A = rotation_matrix(unit(here[i : i + 4])) @ exp_rotation(d[j : j + 3])
            here[i : i + 4] = euler_parameters(A)
        return here

    # -- forces -----------------------------------------------------------------------------

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Return the symmetric mass matrix M (nv, nv); ``v . M v / 2`` is the kinetic energy, J."""
        self._without_loops()
        motion = self.view(q).motion
        M = np.diag(self._armature)
        M = self._Gv.T @ M @ self._Gv
        for body, i in zip(self._parts.bodies, self._at, strict=True):
            Jc = motion.Jr[i] - skew(motion.A[i] @ body.center) @ motion.Jw[i]
            Jl = motion.A[i].T @ motion.Jw[i]
            M += body.mass * Jc.T @ Jc + Jl.T @ body.inertia @ Jl
        return np.asarray(0.5 * (M + M.T))

    def bias_forces(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Return the bias forces b (nv,): the forces tau for zero acceleration, with gravity.

        Springs, dampers and other forces of the machine are not included.
        """
        return self.inverse_dynamics(q, v, np.zeros(self.nv))

    def gravity_forces(self, q: ArrayLike) -> Array:
        """Return the forces (nv,) that balance gravity at rest."""
        return self.bias_forces(q, np.zeros(self.nv))

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Return the forces tau (nv,) for given velocities and accelerations.

        By the principle of virtual power, ``tau = sum Jc^T m (c'' - g) + Jw^T (I w' + w x I w)``.

        Parameters
        ----------
        q : (nq,) array_like
            Positions.
        v, a : (nv,) array_like
            Velocities and accelerations.
        """
        self._without_loops()
        a = self._Gv @ self._vector("a", a, self.nv)
        v = self._Gv @ self._vector("v", v, self.nv)
        motion = in_motion(self._steps, self._Gv, self._full(q), v, a)
        tau = self._Gv.T @ (self._armature * a)
        for body, i in zip(self._parts.bodies, self._at, strict=True):
            c = motion.A[i] @ body.center
            I = motion.A[i] @ body.inertia @ motion.A[i].T
            w, aw = motion.w[i], motion.aw[i]
            ac = motion.ar[i] + cross(aw, c) + cross(w, cross(w, c))
            force = body.mass * (ac - self.gravity)
            torque = I @ aw + cross(w, I @ w)
            tau += motion.Jr[i].T @ force + motion.Jw[i].T @ (torque + cross(c, force))
        return np.asarray(tau)

    def forward_dynamics(self, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> Array:
        """Return the accelerations v' (nv,) under forces tau (nv,).

        Raises
        ------
        InputError
            If the mass matrix is singular because a moving body has no mass.
        """
        rhs = self._vector("tau", tau, self.nv) - self.bias_forces(q, v)
        M = self.mass_matrix(q)
        try:
            return np.asarray(np.linalg.solve(M, rhs))
        except np.linalg.LinAlgError:
            message = "the mass matrix is singular: a moving body has no mass"
            raise InputError(Problem("Tree", message)) from None

    # -- inside -----------------------------------------------------------------------------

    def view(self, q: ArrayLike) -> View:
        """Return the machine at positions q (nq,); the last view is cached."""
        given = self._vector("q", q, self.nq)
        key, last = given.tobytes(), self._view
        if last is not None and last[0] == key:
            return last[1]
        full = self._full(given)
        motion = in_motion(self._steps, self._Gv, full)
        found = View(motion, self._at, full, self._Gv, self._scalar)
        self._view = key, found
        return found

    def angles(self, q: ArrayLike) -> dict[str, float]:
        """Return the angles that may exceed a revolution, rad, by name."""
        view = self.view(q)
        own = {name: float(view.q[place]) for name, (place, _) in self._scalar.items()}
        return own | self.loops.turned(view)

    def _without_loops(self) -> None:
        """Raise InputError if the machine has loops."""
        if self.cut:
            names = ", ".join(repr(name) for name in self.cut[:FEW])
            names += f" and {len(self.cut) - FEW} more" if len(self.cut) > FEW else ""
            message = (
                f"masses and forces are for machines without loops, but {names} close loops; "
                "remove them, or use `compile` and the functions of simulation"
            )
            raise InputError(Problem("Tree", message))

    def _vector(self, name: str, value: ArrayLike, size: int) -> Array:
        problems = Problems()
        found = problems.array("Tree", name, value, (size,))
        problems.raise_if_any()
        assert found is not None
        return found

    def _full(self, q: ArrayLike) -> Array:
        """Return all positions, including the eliminated ones."""
        given = self._vector("q", q, self.nq)
        full = np.zeros(self._all[0])
        for i, j in self._where:
            full[i] = given[j]
        s = self._G @ given[self._places] + self._c
        for value, (i, _) in zip(s, self._scalar.values(), strict=True):
            full[i] = value
        return full

    def _frame(self, frame: Any) -> tuple[int, Frame]:
        """Return the index of the body of a frame, -1 for the ground, and its pose on the body."""
        if isinstance(frame, Marker):
            names = [body.name for body in self._parts.bodies]
            at = Frame(np.asarray(frame.position_local), np.asarray(frame.axes))
            if frame.body.name == "ground":
                return -1, at
            if frame.body.name in names:
                return names.index(frame.body.name), at
            raise InputError(Problem("frame", f"{frame.label} is not on a body of the tree"))
        if not isinstance(frame, str):
            message = f"is {frame!r}, must be a name such as 'hand.tip' or a marker"
            raise InputError(Problem("frame", message))
        if frame not in self._parts.frames:
            known = self._parts.frames
            raise UnknownNameError(Problem("frame", f"no frame {frame!r}{suggest(frame, known)}"))
        return self._parts.frames[frame]
