"""Walk: path following with step control, critical points and branch switching."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from jousto.base.arrays import Array
from jousto.simulation.modes.linear import local, normalised_shapes
from jousto.simulation.modes.spectrum import Spectrum, blocks
from jousto.simulation.state import State
from jousto.simulation.statics.continuation import (
    NoConvergenceError,
    Point,
    Rates,
    SingularTangentError,
    at_arc_length,
    at_load,
    free_motion,
    neutral_modes,
    spectrum,
    tangent,
)
from jousto.simulation.statics.load_path_result import (
    ArcLength,
    CriticalPoint,
    LoadPath,
    PathFailed,
)
from jousto.simulation.statics.plastic_limit import name_plastic_limit
from jousto.simulation.statics.residual import Balance

WATCHED = 6  # number of lowest modes of the tangent stiffness computed at each point
# threshold on the projection of dF/dlambda on the critical mode, over its norm: above it a limit
# point, below it a bifurcation; at a bifurcation the position along the mode is accurate to 1e-5,
# the square root of the smallest increment
SLANT = 1e-3
SHORTEST = 1e-4  # smallest step length over the first one


class Walk:
    """Path of equilibria under construction: points, lowest modes, states and critical points."""

    def __init__(
        self,
        balance: Balance,
        start: float,
        to: float,
        steps: int = 20,
        *,
        arc: ArcLength | None = None,
        until: Callable[[State], bool] | None = None,
        branch: int = 0,
        enough: int = 0,
    ) -> None:
        self.balance, self.start, self.to, self.arc = balance, start, to, arc
        self.until, self.branch, self.steps, self.enough = until, branch, steps, enough
        self.weight = (arc.weight if arc else 1.0) / abs(to - start)
        self.points: list[Point] = []
        self.spectra: list[Spectrum] = []
        self.states: list[State] = []
        self.rows: list[Array] = []
        self.critical: list[CriticalPoint] = []
        self.ended = "no equilibrium found"
        self.neutral = 0  # number of modes without stiffness at the first point
        self.anchor = 0  # index of the first point of the current branch

    def run(self) -> LoadPath:
        """Return the path from the first load to the end."""
        self._add(self.begin())
        done = self._by_arc() if self.arc else self._by_load()
        return self.result(done)

    def begin(self) -> Point:
        """Return the equilibrium at the first load."""
        balance = self.balance
        size = balance.model.nrow + balance.gauge
        lam = np.concatenate([balance.engine.lam, np.zeros(int(balance.gauge))])[:size]
        guess = Point(np.array(balance.engine.q), lam, self.start)
        try:
            return at_load(balance, guess, self.start, iterations=60)
        except NoConvergenceError as error:
            raise PathFailed(
                f"no equilibrium found at {balance.parameter} = {self.start:g}, where the path "
                f"begins: {self._cause(error, guess)}",
                path=self.result(False),
                body=error.body,
            ) from error

    def _cause(self, error: NoConvergenceError, at: Point) -> str:
        if isinstance(error, SingularTangentError):
            try:
                free = free_motion(self.balance, at)
            except (RuntimeError, ValueError, np.linalg.LinAlgError):
                free = "a body moves freely"
            return (
                f"the tangent stiffness is singular, {free}; add a joint or a spring, or "
                "begin at loads that stiffen this motion (start=..., state=...)"
            )
        engine = self.balance.engine
        remedy = name_plastic_limit(engine, at.q, np.array(engine.q)) or (
            "; give a state nearer to the equilibrium (from `equilibrium`), or begin with a "
            "smaller load"
        )
        return f"{error}{remedy}"

    def _add(self, point: Point) -> bool:
        """Append a point and the critical points before it; return whether the path continues."""
        if not self.points:
            found = spectrum(self.balance, point, WATCHED)
            self.neutral = neutral_modes(self.balance, point, found)
        found = self._spectrum(point)
        self.points.append(point)
        self.spectra.append(found)
        state, sensors = self.balance.accept(point.q, point.lam, point.value)
        self.states.append(state)
        self.rows.append(sensors)
        if self.until and self.until(state):
            self.ended = "until"
            return False
        return True

    def _spectrum(self, point: Point) -> Spectrum:
        """Return the WATCHED lowest modes, after neutral modes have been stabilised."""
        return spectrum(self.balance, point, WATCHED + self.neutral, held=self.neutral > 0)

    # -- steps of the load

    def _by_load(self) -> bool:
        whole = (self.to - self.start) / self.steps
        step = whole
        while True:
            last = self.points[-1]
            left = self.to - last.value
            if abs(left) <= 1e-9 * abs(whole):
                self.ended = "reached"
                return True
            step = min(step, left, key=abs)
            value = self.to if step == left else last.value + step
            try:
                point = at_load(self.balance, last, value)
            except NoConvergenceError as error:
                step *= 0.5
                if abs(step) < SHORTEST * abs(whole):
                    raise self._stuck(error) from error
                continue
            fraction = partial(self._at_share, last, value)
            goes_on = self._step(point, fraction)
            if not goes_on:
                return abs(value - self.to) <= 1e-9 * abs(whole)
            step = step * 2.0 if point.iterations <= 6 else step
            step = min(step, whole, key=abs)

    def _at_share(self, last: Point, value: float, share: float) -> Point:
        return at_load(self.balance, last, last.value + share * (value - last.value))

    def _along_share(self, last: Point, ahead: Rates, length: float, share: float) -> Point:
        return at_arc_length(self.balance, last, ahead, share * length, self.weight)

    # -- steps of the arc

    def _by_arc(self) -> bool:
        assert self.arc is not None
        balance, sign = self.balance, float(np.sign(self.to - self.start))
        longest = 1.0 / self.steps
        length = longest
        rates = tangent(balance, self.points[-1], self.weight, None)
        ahead = Rates(sign * rates.step, sign * rates.value)
        for _ in range(self.arc.limit):
            last = self.points[-1]
            try:
                point = at_arc_length(balance, last, ahead, length, self.weight)
                if self._strays(last, point, ahead):
                    raise NoConvergenceError("the iteration left the path")
                fraction = partial(self._along_share, last, ahead, length)
                passed = sign * (point.value - self.to) >= 0.0
                if passed and point.value != self.to:
                    point = at_load(balance, point, self.to)
                    fraction = partial(self._at_share, last, point.value)
                goes_on = self._step(point, fraction)
                if passed:
                    self.ended = "reached"
                if passed or not goes_on:
                    return passed
                if self._closes(length):
                    self.ended = "the path comes back to where it began: it is a closed loop"
                    return False
                switched = self._switch(longest)
                last = self.points[-1]
                if switched is not None:
                    ahead = switched
                else:
                    before = self.points[-2]
                    came = Rates(
                        np.concatenate([balance.between(before.q, last.q), last.lam - before.lam]),
                        last.value - before.value,
                    )
                    ahead = tangent(balance, last, self.weight, came)
            except NoConvergenceError as error:
                length *= 0.5
                if length < SHORTEST * longest:
                    raise self._stuck(error) from error
                continue
            length = min(length * (1.5 if point.iterations <= 5 else 1.0), longest)
        self.ended = f"{self.arc.limit} steps; give method=ArcLength(limit=...) for more"
        return False

    def _closes(self, length: float) -> bool:
        """Return whether the path has come back to the first point of its branch."""
        first, last = self.points[self.anchor], self.points[-1]
        if len(self.points) - self.anchor < 8:
            return False
        away = self.balance.length(self.balance.between(first.q, last.q))
        return bool(np.hypot(away, self.weight * (last.value - first.value)) < 0.7 * length)

    def _strays(self, last: Point, point: Point, ahead: Rates) -> bool:
        """Return whether the iteration converged to a point behind the last point of the path."""
        x = self.balance.between(last.q, point.q)
        nv = self.balance.model.nv
        forward = float((self.balance.weights * x) @ ahead.step[:nv])
        forward += self.weight**2 * (point.value - last.value) * ahead.value
        size = np.hypot(self.balance.length(x), self.weight * (point.value - last.value))
        return bool(forward < 0.3 * size)

    def _switch(self, length: float) -> Rates | None:
        """Return the tangent of the other branch at the first bifurcation; None without one."""
        if not self.branch or not self.critical or self.critical[-1].kind != "bifurcation":
            return None
        found, balance = self.critical[-1], self.balance
        sign, self.branch = self.branch, 0
        x = found.increments
        k = int(np.argmax(np.abs(balance.weights * x)))
        x = sign * np.sign(x[k]) * x / balance.length(x)
        extra = np.zeros(balance.size - balance.model.nv)
        before = self.points[-2]
        at = self.points[-1]
        at = Point(found.state.q, before.lam + 0.5 * (at.lam - before.lam), found.load)
        at = Point(
            at.q, np.concatenate([found.state.lam, at.lam[len(found.state.lam) :]]), at.value
        )
        ahead = Rates(np.concatenate([x, extra]), 0.0)
        size = 0.5 * length
        balance.go_back(self.states[-2])
        while True:
            try:
                point = at_arc_length(balance, at, ahead, size, self.weight)
                if not self._strays(at, point, ahead):
                    break
            except NoConvergenceError:
                pass
            size *= 0.5
            if size < SHORTEST * length:
                balance.go_back(self.states[-1])
                return None
        for kept in (
            self.points,
            self.spectra,
            self.states,
            self.rows,
        ):  # remove the point beyond the bifurcation
            kept.pop()
        balance.go_back(self.states[-1])
        came = Rates(
            np.concatenate([balance.between(at.q, point.q), point.lam - at.lam]),
            point.value - at.value,
        )
        self.anchor = len(self.points)
        self._add(point)
        return tangent(balance, point, self.weight, came)

    # -- critical points

    def _step(self, point: Point, fraction: Callable[[float], Point]) -> bool:
        """Append a point and the critical points between the last point and it."""
        goes_on = self._add(point)
        before, after = self.spectra[-2].unstable, self.spectra[-1].unstable
        for place in range(min(before, after), max(before, after)):
            self.critical.append(self._crossing(fraction, place))
        if 0 < self.enough <= len(self.critical):
            self.ended = "enough critical points"
            return False
        return goes_on

    def _crossing(self, fraction: Callable[[float], Point], place: int) -> CriticalPoint:
        """Return the point where omega^2 of mode `place` (ascending order) is 0 (Illinois rule)."""
        self.balance.go_back(self.states[-2])
        left, right = 0.0, 1.0
        fl, fr = (self._ascending(self.spectra[i], place)[0] for i in (-2, -1))
        scale = max(abs(fl), abs(fr))
        nudge = 0.0
        end = -2 if abs(fl) < abs(fr) else -1
        best = (self.points[end], self._ascending(self.spectra[end], place)[1])
        for _ in range(30 if min(abs(fl), abs(fr)) > 1e-9 * scale else 0):
            x = right - fr * (right - left) / (fr - fl)
            x += nudge * (right - left)
            x = min(max(x, left + 1e-3 * (right - left)), right - 1e-3 * (right - left))
            try:
                point = fraction(x)
                value, shape = self._ascending(self._spectrum(point), place)
            except NoConvergenceError:  # singular tangent: try a point beside it
                nudge = 0.03 if nudge == 0.0 else -2.0 * nudge
                continue
            best, nudge = (point, shape), 0.0
            if abs(value) <= 1e-9 * scale or right - left < 1e-12:
                break
            if (value < 0.0) == (fl < 0.0):
                left, fl, fr = x, value, 0.5 * fr
            else:
                right, fr, fl = x, value, 0.5 * fl
        point, shape = best
        model = self.balance.model
        kind = self._kind(point, shape)
        state, _ = self.balance.accept(point.q, point.lam, point.value)
        self.balance.go_back(self.states[-1])
        drawn = normalised_shapes(model, state.q, local(model, state.q, shape[:, None]))
        return CriticalPoint(
            load=point.value,
            kind=kind,
            state=state,
            increments=shape,
            shape={name: np.real(moved[0]) for name, moved in drawn.items()},
            after=len(self.points) - 2,
        )

    def _ascending(self, found: Spectrum, place: int) -> tuple[float, Array]:
        values = np.real(found.squares)
        order = np.argsort(values)
        k = order[min(place, len(order) - 1)]
        return float(values[k]), np.real(found.shapes[:, k])

    def _kind(self, point: Point, shape: Array) -> str:
        """Return "limit" if the load changes along the critical mode, else "bifurcation"."""
        balance = self.balance
        nv = balance.model.nv
        push = balance.push(point.q, point.lam, point.value)
        A = balance.matrix(point.q, point.lam, point.value)
        M = balance.mass(point.q, point.lam, point.value)
        C = A[nv:, :nv]
        soft = 1e-14 * sp.eye(C.shape[0])
        even = spl.splu(blocks([[sp.eye(nv), C.T], [C, -soft]], format="csc"))
        pull = even.solve(np.concatenate([-(A[:nv, :nv] @ shape), np.zeros(C.shape[0])]))[nv:]
        weigh = spl.splu(blocks([[M, C.T], [C, -soft]], format="csc"))
        free = weigh.solve(np.concatenate([push[:nv], np.zeros(C.shape[0])]))[:nv]
        size = np.sqrt(abs(float(push[:nv] @ free)))
        size += float(np.linalg.norm(pull) * np.linalg.norm(push[nv:]))
        slant = abs(float(shape @ push[:nv] + pull @ push[nv:]))
        return "limit" if slant > SLANT * size else "bifurcation"

    # -- the result

    def result(self, complete: bool) -> LoadPath:
        """Return the path so far."""
        model = self.balance.model
        values = np.array(self.rows).reshape(len(self.rows), model.nout)
        sensors: dict[str, Array] = {}
        for s in model.sensors:
            columns = values[:, s.offset : s.offset + s.count]
            sensors[s.name] = columns[:, 0] if s.count == 1 else columns
        lowest: list[float] = [
            float(np.real(x.squares).min()) if len(x.squares) else np.inf for x in self.spectra
        ]
        return LoadPath(
            parameter=self.balance.parameter,
            load=np.array([p.value for p in self.points]),
            states=tuple(self.states),
            sensors=sensors,
            squares=np.array(lowest),
            unstable=np.array([x.unstable for x in self.spectra], dtype=np.int64),
            iterations=np.array([p.iterations for p in self.points], dtype=np.int64),
            critical=tuple(self.critical),
            complete=complete,
            ended=self.ended,
            units={s.name: s.unit for s in model.sensors},
        )

    def _stuck(self, error: NoConvergenceError) -> PathFailed:
        path = self.result(False)
        last = self.points[-1]
        values: Any = np.real(self.spectra[-1].squares)
        lowest = float(values.min()) if len(values) else np.inf
        first = np.real(self.spectra[0].squares)
        name = self.balance.parameter
        near = abs(lowest) < 0.2 * float(np.abs(first).min(initial=np.inf))
        plastic = name_plastic_limit(self.balance.engine, last.q)
        if plastic:
            remedy = f"{error}{plastic}"
        elif self.arc is None and near:
            remedy = (
                "the lowest mode of the tangent stiffness has fallen to "
                f"{np.sqrt(abs(lowest)) / (2 * np.pi):.3g} Hz, so a limit point is near, beyond "
                "which there is no equilibrium close by; pass it with method='arc'"
            )
        elif isinstance(error, SingularTangentError):
            remedy = self._cause(error, last)
        else:
            remedy = (
                f"{error}; take more steps, more elements where it bends, and check for forces "
                "that are discontinuous"
            )
        return PathFailed(
            f"no equilibrium found beyond {name} = {last.value:.6g} on the way to {self.to:g}: "
            + remedy,
            path=path,
            body=error.body,
        )
