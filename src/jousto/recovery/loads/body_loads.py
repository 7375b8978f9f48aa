"""BodyLoads: all loads on a body over time, with their balance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.files import write_table
from jousto.base.object_repr import described
from jousto.base.ranking import largest
from jousto.mechanism.sensors.loads import FORCE, MOMENT
from jousto.recovery.instants import bracket_instants

FRAMES = ("body", "world")
COMPONENTS = (*FORCE, *MOMENT)
UNITS = ("N", "N", "N", "N m", "N m", "N m")
GROUPS = ("force", "moment", "modal force")
"""Equations of a body: of its force, its moment and its modal forces."""


@described
@dataclass(frozen=True, eq=False)
class BodyLoad:
    """One load on a body over time.

    Attributes
    ----------
    name, kind : str
        Name of the joint, coupling, force or friction, or of the kind for the body's own loads.
    point : (nt, 3) array
        Point of action relative to the origin of the body frame, m; the centre of mass for
        distributed loads.
    force, moment : (nt, 3) array
        Force, N, and moment about the point, N m.
    modal : (nt, n) array
        Generalised forces on the modes, kg^0.5 m/s2.
    place : str
        Label of the marker, ``body.point``; several if it acts at several places; empty if it is
        distributed over the body.
    node : int or None
        Node of a flexible body at which it acts.
    position : (3,) array or None
        Place on the undeformed body, body frame, m; None if it acts at several places or is
        distributed.
    """

    name: str
    kind: str
    point: Array
    force: Array
    moment: Array
    modal: Array
    place: str = ""
    node: int | None = None
    position: Array | None = None

    @property
    def wrench(self) -> Array:
        """Force and moment (nt, 6) about the origin of the body frame."""
        moment = self.moment + np.cross(self.point, self.force)
        return np.concatenate([self.force, moment], axis=1)

    def turned(self, A: Array) -> BodyLoad:
        """Return the load with its vectors multiplied by matrices (nt, 3, 3)."""
        point, force, moment = (
            np.asarray(np.einsum("tab,tb->ta", A, x)) for x in (self.point, self.force, self.moment)
        )
        return replace(self, point=point, force=force, moment=moment)


@described
@dataclass(frozen=True, eq=False)
class BodyMotion:
    """Motion of a body at nt instants, resolved in its own frame.

    Attributes
    ----------
    gravity, acceleration : (nt, 3) array
        Gravity and acceleration of the origin, m/s2.
    w, dw : (nt, 3) array
        Angular velocity, rad/s, and angular acceleration, rad/s2.
    p, dp, ddp : (nt, n) array
        Modal coordinates with their first and second derivatives, kg^0.5 m, per s and per s2.
    """

    gravity: Array
    acceleration: Array
    w: Array
    dw: Array
    p: Array
    dp: Array
    ddp: Array

    def mapped(self, change: Callable[[Array], Array]) -> BodyMotion:
        """Return the motion with a function of each array."""
        return BodyMotion(*(change(getattr(self, f.name)) for f in fields(self)))


@described
@dataclass(frozen=True, eq=False)
class BodyLoads(Mapping[str, BodyLoad]):
    """All loads on a body over time; their sum vanishes at every instant.

    A mapping of the names of the loads to `BodyLoad`. A name that several loads have is followed
    by the place, ``"wind at boom.tip"``.

    Attributes
    ----------
    body : str
        Name of the body.
    time : (nt,) array
        Instants, s.
    loads : tuple of BodyLoad
        Joints and couplings, forces, friction, gravity, inertia, elastic and damping forces.
    frame : {"body", "world"}
        Axes of the vectors.
    rotation : (nt, 3, 3) array
        Rotation of the body frame, body to world.
    center : (nt, 3) array
        Centre of mass from the origin of the body frame, m, in the axes of the vectors.
    motion : BodyMotion
        Motion of the body, always in the body frame.
    nodes, modes : (nn, 3), (nn, 3, n) array
        Undeformed nodes of the body, m, and their motion in each mode, kg^-0.5.
    arm : float
        Radius of the body, m, and `reach` the largest displacement of a node in a mode, kg^-0.5:
        scales of moments and modal forces in the balance.
    floor : (2,) array
        Rounding error of forces, N, and moments, N m, in this machine.
    """

    body: str
    time: Array
    loads: tuple[BodyLoad, ...]
    frame: str
    rotation: Array
    center: Array
    motion: BodyMotion
    nodes: Array
    modes: Array
    arm: float
    reach: float
    floor: Array

    @cached_property
    def _by_name(self) -> dict[str, BodyLoad]:
        return dict(zip(load_names(self.loads), self.loads, strict=True))

    def __getitem__(self, name: str) -> BodyLoad:
        """Return the load of a name; an unknown one is an `InputError` with the nearest name."""
        if name not in self._by_name:
            where = f"loads on '{self.body}'"
            raise InputError(Problem(where, f"no load '{name}'{suggest(name, self._by_name)}"))
        return self._by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self.loads)

    def __repr__(self) -> str:
        return f"<BodyLoads {self.body!r}: {len(self.loads)} loads, {len(self.time)} instants>"

    def of_kind(self, *kinds: str) -> tuple[BodyLoad, ...]:
        """Return the loads of some kinds, such as "joint".

        Raises
        ------
        InputError
            For a kind without loads; the message contains the nearest kind.
        """
        known, problems = {load.kind: None for load in self.loads}, Problems()
        for kind in kinds:
            if kind not in known:
                where = f"loads on '{self.body}'"
                problems.add(where, f"no load of kind {kind!r}{suggest(kind, known)}")
        problems.raise_if_any()
        return tuple(load for load in self.loads if load.kind in kinds)

    @cached_property
    def sums(self) -> Array:
        """Sum of all loads (nt, 6 + n): force, moment about the mass centre, modal forces.

        ``Q_joint + Q_applied + Q_friction + Q_gravity + Q_inertia + Q_elastic = 0`` up to rounding.
        """
        return np.asarray(sum(self._about_center(load) for load in self.loads))

    @cached_property
    def balance(self) -> Array:
        """Unbalanced part (nt, 3) of force, moment and modal forces, relative to all loads.

        The norm of the sum over the sum of the norms, with the largest value of the run as its
        scale. The scale of moments contains all forces at the radius of the body, that of modal
        forces all forces at the largest displacement in a mode; values below the rounding error of
        the machine count as 0.
        """
        norms = sum(group_norms(self._about_center(load)) for load in self.loads)
        force, moment, modal = np.max(np.asarray(norms), axis=0, initial=0.0)
        scale = np.array([force, moment + self.arm * force, modal + self.reach * force])
        floor = np.array([*self.floor, self.reach * self.floor[0]])
        rest = np.maximum(group_norms(self.sums) - floor, 0.0)
        return np.asarray(rest / np.where(scale > 0.0, scale, 1.0))

    def _about_center(self, load: BodyLoad) -> Array:
        moment = load.moment + np.cross(load.point - self.center, load.force)
        return np.concatenate([load.force, moment, load.modal], axis=1)

    def resolved(self, frame: Literal["body", "world"]) -> BodyLoads:
        """Return the loads with vectors in the axes of the body or of the world.

        Points stay relative to the origin of the body frame.

        Raises
        ------
        InputError
            For an unknown frame.
        """
        if frame not in FRAMES:
            message = f"frame is {frame!r}, must be 'body' or 'world'"
            raise InputError(Problem(f"loads on '{self.body}'", message))
        if frame == self.frame:
            return self
        A = self.rotation if frame == "world" else np.swapaxes(self.rotation, 1, 2)
        center = np.einsum("tab,tb->ta", A, self.center)
        loads = tuple(load.turned(A) for load in self.loads)
        return replace(self, frame=frame, loads=loads, center=center)

    @explained
    def at(self, times: ArrayLike) -> BodyLoads:
        """Return the loads at some instants, s, between stored ones interpolated linearly.

        Loads interpolated in the body frame are in balance as well.

        Raises
        ------
        InputError
            If a time is outside of the loads.
        """
        here = self.resolved("body")
        before, after, share = bracket_instants(self.time, times, f"loads on '{self.body}'")

        def mixed(x: Array) -> Array:
            weight = share.reshape(-1, *(1,) * (x.ndim - 1))
            return np.asarray((1.0 - weight) * x[before] + weight * x[after])

        loads = []
        for load in here.loads:
            # only the moment about the origin is linear, since the place moves meanwhile
            wrench, point = mixed(load.wrench), mixed(load.point)
            moment = wrench[:, 3:] - np.cross(point, wrench[:, :3])
            force, modal = wrench[:, :3], mixed(load.modal)
            loads.append(replace(load, point=point, force=force, moment=moment, modal=modal))
        near = np.where(share > 0.5, after, before)
        found = replace(
            here,
            time=np.atleast_1d(np.asarray(times, dtype=np.float64)),
            loads=tuple(loads),
            rotation=self.rotation[near],
            center=mixed(here.center),
            motion=self.motion.mapped(mixed),
        )
        return found.resolved(self.frame)  # type: ignore[arg-type]

    def table(self, time: float | None = None) -> list[tuple[str, ...]]:
        """Return a header and a row of texts for each load.

        Parameters
        ----------
        time : float, optional
            Instant, s; None gives the largest force and moment of each load with their instants.
        """
        if time is None:
            return self._peaks()
        here = self.at([time])
        flexible = here.loads and here.loads[0].modal.shape[1]
        units = [f"{c} ({u})" for c, u in zip(COMPONENTS, UNITS, strict=True)]
        head = ("load", "kind", "place", *units, *(["modal"] if flexible else []))
        rows: list[tuple[str, ...]] = [head]
        for name, load in here.items():
            values = [*self._shown(load.force[0], 0), *self._shown(load.moment[0], 1)]
            modal = [f"{np.linalg.norm(load.modal[0]):.6g}"] if flexible else []
            rows.append((name, load.kind, load.place or "whole body", *values, *modal))
        return rows

    def _shown(self, x: Array, group: int) -> list[str]:
        """Return components as texts, rounding errors of the machine as 0."""
        scale = max((np.abs(load.force).max(initial=0.0) for load in self.loads), default=0.0)
        small = max(float(self.floor[group]), SMALL * scale * (self.arm if group else 1.0))
        return [f"{v:.6g}" if abs(v) > small else "0" for v in x]

    def _peaks(self) -> list[tuple[str, ...]]:
        rows: list[tuple[str, ...]] = [
            ("load", "kind", "place", "force (N)", "at (s)", "moment (N m)", "at (s)")
        ]
        for name, load in self.items():
            cells = []
            for group, x in enumerate((load.force, load.moment)):
                size = np.linalg.norm(x, axis=1)
                k = largest(size)
                value = self._shown(size[[k]], group)[0]
                cells += [value, f"{self.time[k]:.6g}" if value != "0" else ""]
            rows.append((name, load.kind, load.place or "whole body", *cells))
        return rows

    @property
    def verdict(self) -> str:
        """One line on the balance."""
        worst = self.balance.max(axis=0, initial=0.0)
        used = [k for k in range(3) if k < 2 or self.loads[0].modal.shape[1]]
        message = ", ".join(f"{GROUPS[k]} {worst[k]:.1e}" for k in used)
        return f"balance: sum of all loads relative to the sum of their magnitudes: {message}"

    def __str__(self) -> str:
        rows = self.table(None if len(self.time) > 1 else float(self.time[0]))
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        lines = [
            "  ".join(
                c.ljust(w) if k < 3 else c.rjust(w)
                for k, (c, w) in enumerate(zip(row, widths, strict=True))
            ).rstrip()
            for row in rows
        ]
        return "\n".join([*lines, self.verdict])

    def to_csv(self, path: str | Path, times: Sequence[float] | None = None) -> Path:
        """Write all loads as a table, one row for each instant and load.

        Columns: time, name, kind and place of the load, its point, force and moment about the
        point, and its modal forces.

        Parameters
        ----------
        path : path
            File that ends with .csv.
        times : sequence of float, optional
            Instants, s; by default all.

        Raises
        ------
        InputError
            For another ending, or a path that cannot be written.
        """
        out = Path(path)
        if out.suffix.lower() != ".csv":
            raise InputError(Problem(str(out), "must end with .csv"))
        here = self if times is None else self.at(times)
        n = here.loads[0].modal.shape[1]
        head = ["time (s)", "load", "kind", "place", *(f"{c} (m)" for c in "xyz")]
        head += [f"{c} ({u})" for c, u in zip(COMPONENTS, UNITS, strict=True)]
        head += [f"mode {j + 1} (kg^0.5 m/s2)" for j in range(n)]
        rows: list[list[Any]] = []
        for k, t in enumerate(here.time):
            for name, load in here.items():
                numbers = [load.point[k], load.force[k], load.moment[k], load.modal[k]]
                texts = [name, load.kind, load.place or "whole body"]
                rows.append([float(t), *texts, *np.concatenate(numbers).tolist()])
        return write_table(out, head, rows)


SMALL = 1e-12
"""Component shown as 0 / largest force of the run (for moments at the radius of the body)."""


def group_norms(x: Array) -> Array:
    """Return the norms (nt, 3) of force, moment and modal forces of (nt, 6 + n)."""
    groups = (x[:, :3], x[:, 3:6], x[:, 6:])
    return np.stack([np.linalg.norm(group, axis=1) for group in groups], axis=1)


def load_names(loads: Sequence[BodyLoad]) -> list[str]:
    """Return a name for each load; equal names get their place and a number."""
    own = Counter(load.name for load in loads)
    found: dict[str, None] = {}
    for load in loads:
        repeated = own[load.name] > 1 and load.place
        name = unique = f"{load.name} at {load.place}" if repeated else load.name
        number = 2
        while unique in found:
            unique, number = f"{name} ({number})", number + 1
        found[unique] = None
    return list(found)
