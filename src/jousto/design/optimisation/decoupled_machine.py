"""Decoupled problem of a machine: rigid bodies outside, each flexible part alone inside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import (
    InputError,
    JoustoError,
    JoustoWarning,
    Problem as Trouble,
    Problems,
    warn,
)
from jousto.design.optimisation import loads as esl
from jousto.design.optimisation.component import Component, component, mass_ratio, response
from jousto.design.optimisation.decoupled import Decoupled
from jousto.design.optimisation.elastic import Motion
from jousto.design.optimisation.force_stiffness import stiffness_ratio
from jousto.design.optimisation.frozen_run import (
    FrozenRun,
    PartLoads,
    flexible_state,
    frozen_run,
    loads_on_parts,
)
from jousto.design.optimisation.limits import BodyLimit, FrequencyLimit
from jousto.design.optimisation.machine import MachineProblem, shapes_of
from jousto.design.optimisation.problem import forget
from jousto.design.optimisation.rigid_machine import rigid_machine
from jousto.design.optimisation.rigid_options import RigidMachine
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.mechanism import Mechanism
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.simulation.running.simulate import simulate
from jousto.simulation.state import State

WHERE = "rigid machine"
SAME = 1e-12
"""Relative difference of the stiffness of a part below which it does not depend on the design."""


@dataclass(frozen=True, eq=False)
class Compiled:
    """Flexible machine of one load case with its model."""

    machine: Mechanism
    model: Model


@dataclass(frozen=True, eq=False)
class Frozen:
    """Rigid runs of a design by load case, and their derivatives by each parameter."""

    at: Array
    runs: Mapping[str, FrozenRun]
    slopes: tuple[Mapping[str, FrozenRun], ...] = ()


class DecoupledMachine(Decoupled):
    """A machine whose flexible parts vibrate alone under the loads of its rigid run."""

    def __init__(self, true: MachineProblem, options: RigidMachine) -> None:
        super().__init__(true, options)
        self._frozen: Frozen | None = None
        self._interface: list[Array] | None = None
        self._compiled: dict[bytes, dict[str, Compiled]] = {}
        self._part_loads: dict[tuple[bytes, str], list[PartLoads]] = {}

    def check(self) -> None:
        """Raise InputError for a machine without flexible bodies, or a part without limits."""
        problems, parts = Problems(), self.true.parts(self.start)
        for case, machine in self.true.machines(self.start).items():
            if not any(isinstance(body, FlexibleBody) for body in machine.bodies):
                where = f"{WHERE} {case!r}" if case else WHERE
                problems.add(where, "no body is flexible, so that no part can vibrate alone")
        limited = {limit.body for limit in self.limits if isinstance(limit, BodyLimit)}
        whole = any(isinstance(limit, FrequencyLimit) for limit in self.limits)
        for name in parts:
            if name not in limited and not whole and self._varies(name):
                problems.add(
                    f"part '{name}'",
                    "depends on the parameters but has no limit; add one, since no other part "
                    "bounds it when it vibrates alone",
                )
        problems.raise_if_any()
        super().check()

    def _varies(self, name: str) -> bool:
        """Return whether stiffness or mass of a part depend on the parameters near the start."""
        first = self.true.parts(self.start)[name]
        toward = np.where(self.start < 0.5 * (self.low + self.high), self.high, self.low)
        other = self.true.parts(self.start + 0.01 * (toward - self.start))[name]
        if first.K.shape != other.K.shape:
            return True
        pairs = ((first.K, other.K), (first.M, other.M))
        return any(abs(a - b).max() > SAME * abs(a).max() for a, b in pairs)

    def compiled(self, x: Array) -> dict[str, Compiled]:
        """Return the flexible machine of each load case, compiled, from a small cache."""
        key = x.tobytes()
        if key not in self._compiled:
            machines = self.true.machines(x)
            self._compiled[key] = {case: Compiled(m, compile(m)) for case, m in machines.items()}
            forget(self._compiled, len(x))
        return self._compiled[key]

    def rigid_run(self, x: Array) -> dict[str, FrozenRun]:
        """Run the rigid machine of a design in all load cases.

        Raises
        ------
        InputError
            If it cannot be compiled or does not run to the end.
        """
        found = {}
        for case, one in self.compiled(x).items():
            try:
                found[case] = self._run_rigid(one.machine)
            except JoustoError as error:
                where = f"{WHERE} {case!r}" if case else WHERE
                message = f"does not run: {error}; use machine='flexible'"
                raise InputError(Trouble(where, message)) from error
        self.rigid_runs += 1
        return found

    def _run_rigid(self, machine: Mechanism) -> FrozenRun:
        """Return the rigid run of one load case."""
        with catch_warnings():
            simplefilter("ignore", JoustoWarning)  # those of the flexible machine, and redundancy
            model = replace(compile(rigid_machine(machine)), mode_loads=())
        settings = self.true.settings_for(model)
        if isinstance(settings.get("state"), State):
            settings["state"] = rigid_state(settings["state"], compile(machine), model)
        return frozen_run(simulate(model, self.true.t_end, **settings), model)

    def freeze(self, x: Array) -> float:
        """Run the rigid machine and keep its loads; return the change of the interface loads."""
        self._clear()
        runs = self.rigid_run(x)
        if self._frozen is None:
            self._warn_redundant(x, runs)
        self._frozen = Frozen(x.copy(), runs)
        old, self._interface = self._interface, self._interfaces(x)
        return float("nan") if old is None else change(old, self._interface)

    def follow(self, size: float) -> None:
        """Let the frozen loads follow the design to first order, by two rigid runs a parameter."""
        assert self._frozen is not None
        x, runs, slopes = self._frozen.at, self._frozen.runs, []
        for i in range(len(x)):
            up, down = esl.sides(self, x, i, size)
            pair, width = (self.rigid_run(up), self.rigid_run(down)), up[i] - down[i]
            for case, one in runs.items():
                for side in pair:
                    esl.same_instants(len(side[case].time), len(one.time))
            slopes.append({case: pair[0][case].slope(pair[1][case], width) for case in runs})
        self._clear()
        self._frozen = Frozen(x, runs, tuple(slopes))

    def _clear(self) -> None:
        """Forget what depends on the frozen loads."""
        self._motions.clear()
        self._part_loads.clear()

    def _warn_redundant(self, x: Array, runs: Mapping[str, FrozenRun]) -> None:
        """Warn if the rigid machine is statically indeterminate, but the flexible one is not."""
        for case, run in runs.items():
            if run.model.redundant and not self.compiled(x)[case].model.redundant:
                warn(
                    WHERE,
                    "its joints are statically indeterminate without elasticity: their loads are "
                    "those of least norm; release directions, or use machine='flexible'",
                )

    def _interfaces(self, x: Array) -> list[Array]:
        """Return the joint loads on all parts, moments divided by the size of the part."""
        found = []
        for case in self.compiled(x):
            for part, loads in zip(self.true.parts(x).values(), self._loads(x, case), strict=True):
                size = float(np.linalg.norm(np.ptp(part.nodes, axis=0))) or 1.0
                found.append(loads.interface / np.repeat([1.0, size], 3))
        return found

    def _loads(self, x: Array, case: str) -> list[PartLoads]:
        """Return the frozen loads on all parts at a design."""
        key = (x.tobytes(), case)
        if key not in self._part_loads:
            model = self.compiled(x)[case].model
            names = [body.name for body in model.bodies]
            bodies = [names.index(name) for name in self.true.parts(x)]
            # one design at a time: its interface loads, then its motion
            self._part_loads = {k: v for k, v in self._part_loads.items() if k[0] == key[0]}
            self._part_loads[key] = loads_on_parts(model, self._at(x, case), bodies)
        return self._part_loads[key]

    def _at(self, x: Array, case: str) -> FrozenRun:
        """Return the frozen run of a load case at a design."""
        assert self._frozen is not None
        slopes = [one[case] for one in self._frozen.slopes]
        run = self._frozen.runs[case]
        return run.moved(slopes, x - self._frozen.at) if slopes else run

    def run(self, x: Array) -> tuple[Motion, ...]:
        """Return the vibration of each part alone, in all load cases."""
        found = []
        parts = self.true.parts(x)
        for case, one in self.compiled(x).items():
            frozen = self._at(x, case)
            names = [body.name for body in one.model.bodies]
            bodies = [names.index(name) for name in parts]
            every = self._loads(x, case)
            q = flexible_state(one.model, frozen, 0)[0]
            for i, (k, part, loads) in enumerate(zip(bodies, parts.values(), every, strict=True)):
                modes = component(one.model, k, q, self.options.held, self.options.beyond)
                start, rate = self._start(one, k, modes, frozen.time, loads)
                s = response(modes, frozen.time, loads.total, start, rate)
                shapes = shapes_of(one.machine.bodies[k], part)
                found.append(Motion(i, case, frozen.time, shapes, modes.shapes[6:] @ s))
        return tuple(found)

    def _start(
        self, one: Compiled, k: int, modes: Component, time: Array, loads: PartLoads
    ) -> tuple[Array, Array]:
        """Return the motion and velocity of the modes of a part at the first instant.

        Quasi-static if the machine starts at rest or without vibration; else that of the machine.
        """
        state: Any = self.true.settings.get("state")
        body = one.model.bodies[k]
        if callable(state) or (state is None and one.model.start != "initial"):
            return quasi_static(modes, time, loads.total)
        q, v = (one.model.q0, one.model.v0) if state is None else (state.q, state.v)
        p = np.real(q[body.iq + 7 : body.iq + 7 + body.n])
        dp = np.real(v[body.iv + 6 : body.iv + 6 + body.n])
        # least strain energy of the difference: w2 s = shapes^T K p
        onto = modes.shapes[6:].T * np.real(body.K) / modes.w2[:, None]
        return onto @ p, onto @ dp

    def carriers(self, x: Array) -> dict[str, float]:
        """Return ``m / (M + m0)`` of each part, the largest of the modes that the loads bend."""
        found = dict.fromkeys(self.true.parts(x), 0.0)
        for case, one in self.compiled(x).items():
            names = [body.name for body in one.model.bodies]
            q = flexible_state(one.model, self._at(x, case), 0)[0]
            for name, loads in zip(found, self._loads(x, case), strict=True):
                free, held = (
                    component(one.model, names.index(name), q, how, True)
                    for how in ("machine", "motion")
                )
                found[name] = max(found[name], mass_ratio(held, free, loads.total))
        return found

    def springs(self, x: Array) -> dict[str, float]:
        """Return the stiffness of forces on each part over its own, largest of all load cases."""
        found = dict.fromkeys(self.true.parts(x), 0.0)
        held, beyond = self.options.held, self.options.beyond
        for case, one in self.compiled(x).items():
            names = [body.name for body in one.model.bodies]
            q = flexible_state(one.model, self._at(x, case), 0)[0]
            for name, loads in zip(found, self._loads(x, case), strict=True):
                k = names.index(name)
                modes = component(one.model, k, q, held, beyond)
                ratio = stiffness_ratio(one.model, k, q, modes, loads.total)
                found[name] = max(found[name], ratio)
        return found

    def other(self) -> DecoupledMachine:
        """Return the problem with the parts held the other way, under the same loads."""
        held = "force" if self.options.held == "motion" else "motion"
        made = DecoupledMachine(self.true, replace(self.options, held=held))
        made._frozen, made._compiled = self._frozen, self._compiled
        return made


def change(old: list[Array], new: list[Array]) -> float:
    """Return ``sum |F_new - F_old| / sum |F_old|`` over instants and interfaces (S9)."""
    total = sum(float(np.linalg.norm(one, axis=-1).sum()) for one in old)
    for a, b in zip(old, new, strict=True):
        esl.same_instants(len(b), len(a))
    moved = sum(float(np.linalg.norm(b - a, axis=-1).sum()) for a, b in zip(old, new, strict=True))
    if total > 0.0:
        return moved / total
    return 0.0 if moved == 0.0 else float("inf")


def quasi_static(modes: Component, time: Array, F: Array) -> tuple[Array, Array]:
    """Return ``s = f / w2`` at the first instant with its rate, of second order in the step."""
    f = F[:3] @ modes.shapes / modes.w2
    if len(f) < 3:
        return f[0], np.zeros(len(modes.w2))
    h, g = time[1] - time[0], time[2] - time[0]
    rate = (f[1] - f[0]) * g / (h * (g - h)) - (f[2] - f[0]) * h / (g * (g - h))
    return f[0], rate


def rigid_state(state: State, flexible: Model, rigid: Model) -> State:
    """Return a state of the flexible machine with undeformed bodies, for the rigid machine."""
    q, v = np.array(rigid.q0), np.array(rigid.v0)
    for a, b in zip(flexible.bodies, rigid.bodies, strict=True):
        q[b.iq : b.iq + 7] = state.q[a.iq : a.iq + 7]
        v[b.iv : b.iv + 6] = state.v[a.iv : a.iv + 6]
    return replace(state, q=q, v=v, lam=np.zeros(rigid.nrow), joint=None, meters=None, work=None)
