"""Trees: kinematics and dynamics of rigid machines in the coordinates of their joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only, skew
from jousto.base.errors import InputError, Problem, Problems, UnknownNameError, suggest
from jousto.base.rotations import euler_parameters, exp_rotation, rotation_matrix
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.mechanism import Mechanism
from jousto.robots.chain import grown, independent
from jousto.robots.description import Frame, Robot
from jousto.robots.parts import Parts, of_mechanism, of_robot


class _Motion(NamedTuple):
    """Steps in the world: axes and origins, Jacobians of origins and turns, and at v: biases."""

    A: Array
    r: Array
    Jr: Array
    Jw: Array
    w: Array
    ar: Array
    aw: Array


class Tree:
    """A rigid machine without loops, seen from the coordinates of its joints.

    ``M(q) v' + b(q, v) = tau``, b being the forces of motion and gravity. Positions q (nq,) and
    velocities v (nv,) stand in this order: bodies that no joint ties to the ground, as declared,
    then joints, as declared (in a robot: every one after that which carries it).

    ===================== ================================= =======================================
    coordinate            in q                              in v
    ===================== ================================= =======================================
    turn, slide           rad, m                            rad/s, m/s
    ball                  4 Euler parameters of b in a      3: angular velocity of b against a, in
                                                            the axes of b, rad/s
    free body             its place in the world, m, and    its velocity in the axes of the world,
                          4 Euler parameters                m/s, and 3: its angular velocity in its
                                                            own axes, rad/s
    ===================== ================================= =======================================

    A planar joint has x, y and the angle, a cylindrical one displacement and angle, a universal
    one both angles. Couplings, gears, racks and the mimic of robots leave one coordinate out,
    which follows. Drives leave theirs: `inverse_dynamics` has their force. tau has the units of
    power over v.

    Parameters
    ----------
    machine : Mechanism, Robot or Model
        Rigid bodies; revolute, prismatic, cylindrical, screw, universal, planar, spherical and
        fixed joints.
    gravity : (3,) array_like, optional
        Acceleration of free fall, m/s2; None for that of the machine.
    limits : dict of str to (float, float), optional
        Lower and upper limits of coordinates by name, beside those of a robot.

    Attributes
    ----------
    nq, nv : int
        How many positions and velocities.
    positions, velocities : tuple of str
        What each of them is.
    initial : (nq,) array
        Positions at the pose in which the machine was declared.
    lower, upper : (nv,) arrays
        Limits of the coordinates, infinite where there are none.
    gravity : (3,) array
        m/s2.

    Raises
    ------
    InputError
        If a body is flexible, a joint closes a loop or is of another kind.

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
        self._steps, self._at, names = grown(parts)
        self.gravity = read_only(parts.gravity if g is None else g)
        kept, self._G, self._c = independent(parts, names)
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
        self._limit(parts.limits | dict(limits or {}))
        self._armature = np.zeros(self._all[1])
        for name, inertia in parts.armature.items():
            for i, other in enumerate(names.velocities):
                if other == name or other.startswith(f"{name}.w"):
                    self._armature[i] = inertia

    def _arrange(self, positions: list[str], velocities: list[str], kept: list[str]) -> None:
        """Keep names of what is free, and where the coordinates stand."""
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
        # positions of balls and free bodies: first place of the parameters, and of the velocities
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
        """Keep limits; those of coordinates that follow become limits of the leading one."""
        lower, upper = np.full(self.nv, -np.inf), np.full(self.nv, np.inf)
        rows = {name: i for i, name in enumerate(self._scalar)}
        problems = Problems()
        for name, given in limits.items():
            where = f"limits[{name!r}]"
            if name not in rows:
                problems.add(where, f"no such coordinate{suggest(name, rows)}")
                continue
            try:
                low, high = (float(x) for x in given)
            except (TypeError, ValueError):
                problems.add(where, f"is {given!r}, must be a lower and an upper limit")
                continue
            if not low <= high:
                problems.add(where, f"lower limit {low:g} lies above the upper one, {high:g}")
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
        return f"<Tree: {len(self._parts.bodies)} bodies, {self.nv} degrees of freedom>"

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of the frames that the functions take: bodies, and points of bodies."""
        return tuple(self._parts.frames)

    # -- positions --------------------------------------------------------------------------

    def forward_kinematics(self, q: ArrayLike) -> dict[str, Frame]:
        """Return where every body is.

        Parameters
        ----------
        q : (nq,) array_like
            Positions.

        Returns
        -------
        dict of str to Frame
            Origin (3,), m, and axes (3, 3) of each body frame in the world.
        """
        A, r = self._places_of(self._full(q))
        return {
            body.name: Frame(r[i], A[i])
            for body, i in zip(self._parts.bodies, self._at, strict=True)
        }

    def pose(self, frame: str | Marker, q: ArrayLike) -> Frame:
        """Return where a frame is: a body, a point such as ``"hand.tip"``, or a marker."""
        body, at = self._frame(frame)
        A, r = self._places_of(self._full(q))
        i = self._at[body] if body >= 0 else -1
        base = Frame() if i < 0 else Frame(r[i], A[i])
        return base @ at

    def jacobian(self, frame: str | Marker, q: ArrayLike) -> Array:
        """Return J (6, nv), by which a frame moves: ``[r', w] = J v``.

        The first three rows are the velocity of its origin, m/s, the others its angular velocity,
        rad/s, both in the axes of the world.
        """
        body, at = self._frame(frame)
        if body < 0:
            return np.zeros((6, self.nv))
        motion = self._moved(self._full(q))
        i = self._at[body]
        arm = motion.A[i] @ at.r
        return np.concatenate([motion.Jr[i] - skew(arm) @ motion.Jw[i], motion.Jw[i]])

    def moved(self, q: ArrayLike, step: ArrayLike) -> Array:
        """Return the positions (nq,) after a motion with constant velocity for a second.

        Turns of balls and free bodies are multiplied on, ``A exp(w~)``, so that Euler parameters
        keep their length.

        Parameters
        ----------
        q : (nq,) array_like
            Positions.
        step : (nv,) array_like
            Velocity times time.
        """
        here = self._vector("q", q, self.nq).copy()
        d = self._vector("step", step, self.nv)
        for name, j in zip(self._kept, self._places, strict=True):
            here[j] += d[self.velocities.index(name)]
        for i, j in self._free:
            here[i] += d[j]
        for i, j in self._turns:
            A = rotation_matrix(_unit(here[i : i + 4])) @ exp_rotation(d[j : j + 3])
            here[i : i + 4] = euler_parameters(A)
        return here

    # -- forces -----------------------------------------------------------------------------

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Return M (nv, nv), symmetric: ``v . M v / 2`` is the kinetic energy, J."""
        motion = self._moved(self._full(q))
        M = np.diag(self._armature)
        M = self._Gv.T @ M @ self._Gv
        for body, i in zip(self._parts.bodies, self._at, strict=True):
            Jc = motion.Jr[i] - skew(motion.A[i] @ body.center) @ motion.Jw[i]
            Jl = motion.A[i].T @ motion.Jw[i]
            M += body.mass * Jc.T @ Jc + Jl.T @ body.inertia @ Jl
        return np.asarray(0.5 * (M + M.T))

    def bias_forces(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Return b (nv,): what holds the motion v without acceleration, against gravity too.

        Springs, dampers and other forces of the machine are not part of it.
        """
        return self.inverse_dynamics(q, v, np.zeros(self.nv))

    def gravity_forces(self, q: ArrayLike) -> Array:
        """Return the forces (nv,) that hold the machine at rest against gravity."""
        return self.bias_forces(q, np.zeros(self.nv))

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Return the forces tau (nv,) that move the machine with an acceleration.

        By the principle of virtual power, ``tau = sum Jc^T m (c'' - g) + Jw^T (I w' + w x I w)``.

        Parameters
        ----------
        q : (nq,) array_like
            Positions.
        v, a : (nv,) array_like
            Velocities, and their rates.
        """
        a = self._Gv @ self._vector("a", a, self.nv)
        motion = self._moved(self._full(q), self._Gv @ self._vector("v", v, self.nv), a)
        tau = self._Gv.T @ (self._armature * a)
        for body, i in zip(self._parts.bodies, self._at, strict=True):
            c = motion.A[i] @ body.center
            I = motion.A[i] @ body.inertia @ motion.A[i].T
            w, aw = motion.w[i], motion.aw[i]
            ac = motion.ar[i] + _cross(aw, c) + _cross(w, _cross(w, c))
            force = body.mass * (ac - self.gravity)
            torque = I @ aw + _cross(w, I @ w)
            tau += motion.Jr[i].T @ force + motion.Jw[i].T @ (torque + _cross(c, force))
        return np.asarray(tau)

    def forward_dynamics(self, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> Array:
        """Return the accelerations v' (nv,) under forces tau (nv,).

        Raises
        ------
        InputError
            If something moves that has no mass.
        """
        rhs = self._vector("tau", tau, self.nv) - self.bias_forces(q, v)
        M = self.mass_matrix(q)
        try:
            return np.asarray(np.linalg.solve(M, rhs))
        except np.linalg.LinAlgError:
            message = "the mass matrix is singular: something moves that has no mass"
            raise InputError(Problem("Tree", message)) from None

    # -- inside -----------------------------------------------------------------------------

    def _vector(self, name: str, value: ArrayLike, size: int) -> Array:
        problems = Problems()
        found = problems.array("Tree", name, value, (size,))
        problems.raise_if_any()
        assert found is not None
        return found

    def _full(self, q: ArrayLike) -> Array:
        """Return all positions, those that follow too."""
        given = self._vector("q", q, self.nq)
        full = np.zeros(self._all[0])
        for i, j in self._where:
            full[i] = given[j]
        s = self._G @ given[self._places] + self._c
        for value, (i, _) in zip(s, self._scalar.values(), strict=True):
            full[i] = value
        return full

    def _frame(self, frame: Any) -> tuple[int, Frame]:
        """Return the number of the body of a frame, -1 for the ground, and where on it."""
        if isinstance(frame, Marker):
            names = [body.name for body in self._parts.bodies]
            at = Frame(np.asarray(frame.position_local), np.asarray(frame.axes))
            if frame.body.name == "ground":
                return -1, at
            if frame.body.name in names:
                return names.index(frame.body.name), at
            raise InputError(Problem("frame", f"{frame.label} is on no body of the tree"))
        if not isinstance(frame, str):
            message = f"is {frame!r}, must be a name such as 'hand.tip' or a marker"
            raise InputError(Problem("frame", message))
        if frame not in self._parts.frames:
            known = self._parts.frames
            raise UnknownNameError(Problem("frame", f"no frame {frame!r}{suggest(frame, known)}"))
        return self._parts.frames[frame]

    def _places_of(self, q: Array) -> tuple[Array, Array]:
        motion = self._moved(q, jacobians=False)
        return motion.A, motion.r

    def _moved(
        self, q: Array, v: Array | None = None, a: Array | None = None, *, jacobians: bool = True
    ) -> _Motion:
        """Return the steps in the world, with accelerations if v and a are given."""
        n, nv = len(self._steps), self._all[1]
        A, r = np.zeros((n, 3, 3)), np.zeros((n, 3))
        Jr, Jw = np.zeros((n, 3, nv)), np.zeros((n, 3, nv))
        w, vr, ar, aw = (np.zeros((n, 3)) for _ in range(4))
        for i, step in enumerate(self._steps):
            p = step.parent
            base = Frame() if p < 0 else Frame(r[p], A[p])
            joint = base @ step.before
            moved, turn, slide = _motion(step.kind, step.sign, joint, q[step.q :])
            end = moved @ step.after
            A[i], r[i] = end.A, end.r
            size = turn.shape[1]
            out = end.r - moved.r  # from the moved point of the joint
            if jacobians:
                if p >= 0:
                    Jw[i] = Jw[p]
                    Jr[i] = Jr[p] - skew(end.r - r[p]) @ Jw[p]
                columns = slice(step.v, step.v + size)
                Jw[i][:, columns] += turn
                Jr[i][:, columns] += slide - skew(out) @ turn
            if v is None or a is None:
                continue
            wp = w[p] if p >= 0 else np.zeros(3)
            dv, da = v[step.v : step.v + size], a[step.v : step.v + size]
            wj, sv = turn @ dv, slide @ dv
            w[i] = wp + wj
            aw[i] = (aw[p] if p >= 0 else 0.0) + turn @ da + _cross(wp, wj)
            arm = moved.r - (r[p] if p >= 0 else np.zeros(3))
            if step.kind != "free":
                lead = (ar[p], aw[p]) if p >= 0 else (np.zeros(3), np.zeros(3))
                ar[i] = lead[0] + _cross(lead[1], arm) + _cross(wp, _cross(wp, arm))
                ar[i] += slide @ da + 2.0 * _cross(wp, sv)
                ar[i] += _cross(aw[i], out) + _cross(w[i], _cross(w[i], out))
            else:
                ar[i] = slide @ da
        Jr, Jw = Jr @ self._Gv, Jw @ self._Gv
        return _Motion(A, r, Jr, Jw, w, ar, aw)


def _motion(kind: str, sign: int, joint: Frame, q: Array) -> tuple[Frame, Array, Array]:
    """Return a frame after its motion, and how it turns and slides in the world (3, size)."""
    none = np.zeros((3, 1))
    z = joint.A[:, 2:]
    if kind == "turn":
        angle = sign * q[0]
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return Frame(joint.r, joint.A @ R), sign * z, none
    if kind == "slide":
        return Frame(joint.r + sign * q[0] * z[:, 0], joint.A), none, sign * z
    if kind == "ball":
        R = rotation_matrix(_unit(q[:4]))
        zero = np.zeros((3, 3))
        if sign > 0:
            moved = Frame(joint.r, joint.A @ R)
            return moved, moved.A, zero
        # b carries a: its angular velocity against b is turned round, in the axes of b
        return Frame(joint.r, joint.A @ R.T), -joint.A, zero
    if kind == "free":
        R = rotation_matrix(_unit(q[3:7]))
        zero = np.zeros((3, 3))
        return Frame(q[:3].copy(), R), np.hstack([zero, R]), np.hstack([np.eye(3), zero])
    return joint, np.zeros((3, 0)), np.zeros((3, 0))


def _cross(a: Array, b: Array) -> Array:
    """Return a x b; numpy's takes ten times as long for two vectors."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def _unit(e: Array) -> Array:
    """Return Euler parameters of length 1."""
    length = float(np.linalg.norm(e))
    if not length > 1e-6:
        message = "Euler parameters in q are zero; (1, 0, 0, 0) is no turn"
        raise InputError(Problem("Tree", message))
    return np.asarray(e / length)
