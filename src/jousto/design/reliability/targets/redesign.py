"""Reliability-based design problem: limit states, their derivatives and the cost, as arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jousto.base.arrays import Array, some
from jousto.base.errors import count
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.form import moment_derivative
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.inputs.transform import Transformation
from jousto.design.reliability.limit import Counted
from jousto.design.reliability.targets.search import Search

WHERE = "rbdo"
FAR = 38.0  # largest beta that is reported as a number
MISSED = 1e-6  # tolerance of a limit state, relative to its size
# maximum number of short optimisations; their longest step, as a share of the scale
ROUNDS, SHORT = 50, 0.1
ENDLESS = 1e9  # multiple of the scale at which an unbounded design counts as divergent
STEPS = 200  # maximum iterations of a deterministic optimisation
KEPT = 200  # cache size: number of designs whose random variables are stored
WIDTH = 1e-4  # step of differences by a design variable, relative to its scale


@dataclass(eq=False)
class Redesign:
    """Design problem as arrays, with a count of the calls."""

    cost: Counted
    counted: list[Counted]
    names: list[str]
    variables: Transformation
    designs: list[str]
    low: Array
    high: Array
    start: Array
    scale: Array
    beta: Array
    known: dict[bytes, tuple[Transformation, dict[str, float]]] = field(default_factory=dict)

    @property
    def fixed(self) -> list[str]:
        """Design variables that are not random."""
        return [name for name in self.designs if name not in self.variables.names]

    def space_at(self, d: Array, i: int) -> Space:
        """Return the Space of a limit state at a design."""
        key = d.tobytes()
        if key not in self.known:
            if len(self.known) > KEPT:
                self.known.clear()
            self.known[key] = self._variables_at(d)
        moved, fixed = self.known[key]
        return Space(self.counted[i].limit, moved, fixed, self.counted[i])

    def _variables_at(self, d: Array) -> tuple[Transformation, dict[str, float]]:
        """Return the random variables and the fixed values of a design."""
        value = dict(zip(self.designs, d.tolist(), strict=True))
        random = {k: (v, None) for k, v in value.items() if k in self.variables.names}
        moved = self.variables.moved(random) if random else self.variables
        return moved, {k: value[k] for k in self.fixed}

    def cost_of(self, d: Array) -> float:
        """Return the cost of a design."""
        return self.cost.value(d)

    def cost_slope(self, d: Array) -> Array:
        """Return the derivatives of the cost."""
        if self.cost.has_gradient:
            return self.cost.gradient_x(d)
        return self._differences(self.cost.value, d)

    def _differences(self, f: Callable[[Array], float], d: Array) -> Array:
        """Return central differences of a smooth function within the bounds."""
        out = np.empty(len(d))
        for k, step in enumerate(WIDTH * self.scale):
            up, down = d.copy(), d.copy()
            up[k], down[k] = min(d[k] + step, self.high[k]), max(d[k] - step, self.low[k])
            out[k] = (f(up) - f(down)) / (up[k] - down[k]) if up[k] > down[k] else 0.0
        return out

    def value(self, d: Array, i: int, u: Array | None) -> float:
        """Return a limit state at a design and a standard normal point (None: the means)."""
        space = self.space_at(d, i)
        return self.counted[i].value(self._x(space, u))

    def _x(self, space: Space, u: Array | None) -> Array:
        if u is not None:
            return space.x(u)
        return np.concatenate([space.variables.means, list(space.fixed.values())])

    def slope(self, d: Array, i: int, u: Array | None) -> Array:
        """Return the derivatives of a limit state by the design at constant u (standard normal)."""
        if not self.counted[i].has_gradient:
            return self._differences(lambda e: self.value(e, i, u), d)
        space = self.space_at(d, i)
        G_x = self.counted[i].gradient_x(self._x(space, u))
        out = np.empty(len(d))
        for k, name in enumerate(self.designs):
            if name in self.fixed:
                out[k] = G_x[space.names.index(name)]
            else:
                out[k] = float(G_x[: space.n] @ self._move(space, u, name))
        return out

    def _move(self, space: Space, u: Array | None, name: str) -> Array:
        """Return dx/dmean of one variable at point u."""
        if u is None:
            return np.asarray(np.eye(space.n)[space.variables.names.index(name)])
        T = space.variables
        one = T.randoms[T.names.index(name)]
        return moment_derivative(T, u, T.to_x(u), one, 0, tied=True)

    def slope_at(self, d: Array, i: int, u: Array, g_u: Array) -> Array:
        """Return the derivatives by the design from known dg/du; only fixed values need calls."""
        space = self.space_at(d, i)
        G_x = space.gradient_x(u, g_u)
        out = np.empty(len(d))
        rest: Array | None = None
        for k, name in enumerate(self.designs):
            if name not in self.fixed:
                out[k] = float(G_x @ self._move(space, u, name))
            elif self.counted[i].has_gradient:
                rest = self.counted[i].gradient_x(space.x(u)) if rest is None else rest
                out[k] = rest[space.names.index(name)]
            else:
                step = WIDTH * self.scale[k]
                ends = []
                between = []
                for side in (1.0, -1.0):
                    e = d.copy()
                    e[k] = np.clip(d[k] + side * step, self.low[k], self.high[k])
                    between.append(e[k])
                    ends.append(self.value(e, i, u))
                out[k] = (ends[0] - ends[1]) / (between[0] - between[1])
        return out

    def shifted(self, points: Sequence[Array | None]) -> tuple[Any, Any]:
        """Return all limit states and their derivatives at given standard normal points."""

        def values(d: Array) -> Array:
            return np.array([self.value(d, i, u) for i, u in enumerate(points)])

        def slopes(d: Array) -> Array:
            return np.array([self.slope(d, i, u) for i, u in enumerate(points)])

        return values, slopes

    def _format_design(self, d: Array) -> str:
        return ", ".join(f"{n} = {x:.4g}" for n, x in zip(self.designs, d, strict=True))

    def optimum(self, d: Array, limits: tuple[Any, Any], iterations: int) -> Array:
        """Return the design of least cost with limit states >= 0, by SLSQP."""
        values, slopes = limits
        first, g = self.cost_of(d), values(d)
        size = max(abs(first), float(np.linalg.norm(self.cost_slope(d) * self.scale)), 1e-300)
        moves = np.linalg.norm(slopes(d) * self.scale, axis=1)
        fixed = [n for n, x, move in zip(self.names, g, moves, strict=True) if x < 0.0 == move]
        if fixed:
            message = f"{WHERE}: {some(fixed)} {'fails' if len(fixed) == 1 else 'fail'} at "
            message += (
                f"{self._format_design(d)}, and no design variable changes that; give another start"
            )
            raise DesignPointError(message, d)
        sizes = np.maximum(np.abs(g), moves)
        sizes = np.maximum(sizes, 1e-300)

        def real(z: Array) -> Array:
            return np.clip(z * self.scale, self.low, self.high)

        search = Search(
            cost=lambda z: self.cost_of(real(z)) / size,
            cost_slope=lambda z: self.cost_slope(real(z)) * self.scale / size,
            limits=lambda z: values(real(z)) / sizes,
            limit_slopes=lambda z: slopes(real(z)) * self.scale / sizes[:, None],
        )
        z, low, high = d / self.scale, self.low / self.scale, self.high / self.scale
        found, status = search.least(z, low, high, iterations)
        # a long step may end where limits have zero gradient: repeat with short steps
        for _ in range(ROUNDS if status not in (0, 9) else 0):
            near, far = np.maximum(low, z - SHORT), np.minimum(high, z + SHORT)
            found, status = search.least(z, near, far, iterations)
            moved, z = float(np.max(np.abs(found - z))), found
            if moved < 0.999 * SHORT:
                break
        d = real(found)
        if np.any(np.abs(d) > ENDLESS * self.scale):
            message = (
                f"{WHERE}: the cost falls without end, to {self._format_design(d)}; give "
                "finite bounds"
            )
            raise DesignPointError(message, d)
        g = values(d) / sizes
        bad = [f"{self.names[i]} ({g[i] * sizes[i]:.4g})" for i in np.flatnonzero(g < -MISSED)]
        missed = f"missed at {self._format_design(d)}: {some(bad)}" if bad else ""
        if status == 9:
            hint = "" if iterations == STEPS else ", raise cycles="
            message = (
                f"{WHERE}: the optimisation did not converge within "
                f"{count(iterations, 'step')}{hint}"
            )
            message += f"; {missed}" if bad else ""
            raise DesignPointError(message, d)
        if not np.all(g >= -10.0 * MISSED):
            message = (
                f"{WHERE}: no design reaches the targets; {missed}. Wider bounds, "
                "a smaller target or less scatter may help, or another start"
            )
            raise DesignPointError(message, d)
        return d
