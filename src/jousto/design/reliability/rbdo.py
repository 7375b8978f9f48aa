"""Design for a target: least cost with a reliability index for each limit state."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import scipy.optimize

from jousto.base.arguments import explained
from jousto.base.arrays import Array, some
from jousto.base.described import described
from jousto.base.errors import Problems, count, suggest
from jousto.base.frozen import Frozen
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.form import FormResult, design_point, moved_by
from jousto.design.reliability.limit import Counted, LimitState, limit_state
from jousto.design.reliability.pma import METHODS as MEAN_VALUES, performance
from jousto.design.reliability.space import Space
from jousto.design.reliability.transform import Transformation, transformation

WHERE = "rbdo"
METHODS = ("sora", "pma", "ria")
FAR = 38.0  # of indices that are only told
MISSED = 1e-6  # of the size of a limit state
ACTIVE = 1e-2  # of an index above its target
FLAT = 1e-9  # of the optimum of a deterministic step, by its scale
KEPT = 200  # designs whose variables are kept
WIDTH = 1e-4  # of differences by a design variable, by its scale


@described
@dataclass(frozen=True, eq=False)
class RbdoResult:
    """A design of least cost whose limit states have their reliability indices.

    Attributes
    ----------
    design : dict of float
        Means of random variables, and values of others.
    cost : float
        Of the design.
    betas : dict of float
        Indices of the limit states by FORM; infinite where no failure was found.
    target : dict of float
        Those that were asked for.
    deterministic : dict of float
        The design without scatter, from which it started.
    deterministic_cost : float
        Of that.
    cycles : int
        Optimisations with shifts of "sora", designs tried by the others.
    calls : dict of int
        Of each limit state, with those of differences.
    gradients : dict of int
        Of their given gradients.
    method : str
        "sora", "pma" or "ria".
    history : (cycles + 1, 1 + n) array
        Cost and design after each cycle, the deterministic one first.
    forms : tuple of FormResult
        FORM at the design, of limit states that can fail.
    """

    design: Mapping[str, float]
    cost: float
    betas: Mapping[str, float]
    target: Mapping[str, float]
    deterministic: Mapping[str, float]
    deterministic_cost: float
    cycles: int
    calls: Mapping[str, int]
    gradients: Mapping[str, int]
    method: str
    history: Array
    forms: tuple[FormResult, ...]

    @property
    def active(self) -> tuple[str, ...]:
        """Limit states whose index is its target."""
        return tuple(k for k, beta in self.betas.items() if beta - self.target[k] <= ACTIVE)

    def _facts(self) -> str:
        at = ", ".join(f"{name} = {value:.6g}" for name, value in list(self.design.items())[:6])
        more = ", ..." if len(self.design) > 6 else ""
        work = count(sum(self.calls.values()), "call")
        active = some(list(self.active)) or "none"
        return f"cost {self.cost:.6g} at {at}{more}; active {active}; {self.method}, {work}"


@explained
def rbdo(
    cost: LimitState | Callable[..., Any],
    limits: Mapping[str, Any] | Sequence[Any],
    variables: Any,
    bounds: Mapping[str, tuple[float, float]],
    beta: Any,
    *,
    method: Literal["sora", "pma", "ria"] = "sora",
    start: Mapping[str, float] | None = None,
    inner: Literal["sqp", "hmv", "amv", "cmv"] = "sqp",
    tolerance: float = 1e-5,
    cycles: int = 50,
) -> RbdoResult:
    """Return the design of least cost with ``P(G_i <= 0) <= Phi(-beta_i)``: RBDO.

    "sora" takes turns (X. Du and W. Chen, *J. Mech. Des.* 126 (2004) 225-233): an optimisation
    without scatter, in which each limit state is taken at its most probable point of the last
    cycle, moved along with the design; then those points anew, by `pma`. "pma" and "ria" are
    nested: every design that the optimisation tries has its limit states on the sphere of the
    target, or its indices by `form`.

    Parameters
    ----------
    cost : callable or LimitState
        ``cost(d)`` of the design variables by name; a LimitState has a gradient.
    limits : dict or sequence of LimitState or callable
        ``G(x) <= 0`` is failure; x has the random variables and the design variables that are not
        random.
    variables : sequence of Random, Nataf, Rosenblatt or Joint
        The random variables about the start.
    bounds : dict of (float, float)
        The design variables with their least and largest value: means of random variables by their
        name, others are new values without scatter.
    beta : float or dict of float
        Targets.
    method : {"sora", "pma", "ria"}
        See above.
    start : dict of float, optional
        Where to begin; else the means of the random variables.
    inner : {"sqp", "hmv", "amv", "cmv"}
        Method of `pma`.
    tolerance : float
        Move of the design, by the width of its bounds, that is none.
    cycles : int
        At most; of nested methods iterations.

    Returns
    -------
    RbdoResult
        `check_linearisation` samples it.

    Raises
    ------
    DesignPointError
        If no design within the bounds has the targets, or the cycles do not end.
    LimitStateError
        If a limit state fails or is no number.
    InputError
        For wrong arguments: crossed bounds, a start outside of them, unknown names.
    """
    problem = _read(cost, limits, variables, bounds, beta, start, method, inner)
    problems = Problems()
    problems.positive(WHERE, "tolerance", tolerance, "")
    whole = "a whole number, at least 1"
    problems.number(WHERE, "cycles", cycles, "", whole, lambda x: x >= 1 and x == int(x))
    problems.raise_if_any()
    first = problem.optimum(problem.start, problem.shifted([None] * len(problem.names)), 200)
    rows = [(problem.cost_of(first), *first)]
    if method == "sora":
        d, points = _sora(problem, first, inner, tolerance, int(cycles), rows)
    else:
        d, points = _nested(problem, first, method, inner, int(cycles), rows)
    return _result(problem, d, first, points, method, rows)


@dataclass(eq=False)
class _Problem:
    """What is asked for, in arrays; counts the calls."""

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

    def at(self, d: Array, i: int) -> Space:
        """Return a limit state at a design."""
        key = d.tobytes()
        if key not in self.known:
            if len(self.known) > KEPT:
                self.known.clear()
            self.known[key] = self._moved(d)
        moved, fixed = self.known[key]
        return Space(self.counted[i].limit, moved, fixed, self.counted[i])

    def _moved(self, d: Array) -> tuple[Transformation, dict[str, float]]:
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
        """Return central differences within the bounds, of a step that suits smooth functions."""
        out = np.empty(len(d))
        for k, step in enumerate(WIDTH * self.scale):
            up, down = d.copy(), d.copy()
            up[k], down[k] = min(d[k] + step, self.high[k]), max(d[k] - step, self.low[k])
            out[k] = (f(up) - f(down)) / (up[k] - down[k]) if up[k] > down[k] else 0.0
        return out

    def value(self, d: Array, i: int, u: Array | None) -> float:
        """Return a limit state at a design, at a standard normal point or, of None, the means."""
        space = self.at(d, i)
        return self.counted[i].value(self._x(space, u))

    def _x(self, space: Space, u: Array | None) -> Array:
        if u is not None:
            return space.x(u)
        return np.concatenate([space.variables.means, list(space.fixed.values())])

    def slope(self, d: Array, i: int, u: Array | None) -> Array:
        """Return its derivatives by the design, the standard normal point being the same."""
        if not self.counted[i].has_gradient:
            return self._differences(lambda e: self.value(e, i, u), d)
        space = self.at(d, i)
        G_x = self.counted[i].gradient_x(self._x(space, u))
        out = np.empty(len(d))
        for k, name in enumerate(self.designs):
            if name in self.fixed:
                out[k] = G_x[space.names.index(name)]
            else:
                out[k] = float(G_x[: space.n] @ self._move(space, u, name))
        return out

    def _move(self, space: Space, u: Array | None, name: str) -> Array:
        """Return dx/dmean of one variable; a mean moves itself alone."""
        if u is None:
            return np.asarray(np.eye(space.n)[space.variables.names.index(name)])
        T = space.variables
        one = T.randoms[T.names.index(name)]
        return moved_by(T, u, T.to_x(u), one, 0, tied=True)

    def slope_at(self, d: Array, i: int, u: Array, g_u: Array) -> Array:
        """Return the derivatives where dg/du is known: calls for fixed values alone."""
        space = self.at(d, i)
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

    def optimum(self, d: Array, limits: tuple[Any, Any], iterations: int) -> Array:
        """Return the least cost with limit states that are not negative, by scipy's SLSQP."""
        values, slopes = limits
        first, g = self.cost_of(d), values(d)
        size = max(abs(first), float(np.linalg.norm(self.cost_slope(d) * self.scale)), 1e-300)
        sizes = np.maximum(np.abs(g), np.linalg.norm(slopes(d) * self.scale, axis=1))
        sizes = np.maximum(sizes, 1e-300)

        def real(z: Array) -> Array:
            return np.clip(z * self.scale, self.low, self.high)

        minimize: Any = scipy.optimize.minimize
        found = minimize(
            lambda z: self.cost_of(real(z)) / size,
            d / self.scale,
            jac=lambda z: self.cost_slope(real(z)) * self.scale / size,
            bounds=list(zip(self.low / self.scale, self.high / self.scale, strict=True)),
            constraints={
                "type": "ineq",
                "fun": lambda z: values(real(z)) / sizes,
                "jac": lambda z: slopes(real(z)) * self.scale / sizes[:, None],
            },
            method="SLSQP",
            options={"maxiter": iterations, "ftol": FLAT},
        )
        d = real(np.asarray(found.x))
        if found.status == 9:
            message = f"{WHERE}: the optimisation did not end in {iterations} steps; raise cycles="
            raise DesignPointError(message, d)
        g = values(d) / sizes
        if not np.all(g >= -10.0 * MISSED):
            bad = [f"{self.names[i]} ({g[i] * sizes[i]:.4g})" for i in np.flatnonzero(g < -MISSED)]
            at = ", ".join(f"{n} = {x:.4g}" for n, x in zip(self.designs, d, strict=True))
            message = (
                f"{WHERE}: no design was found that has what is asked for; missed at {at}: "
                f"{some(bad)}. Wider bounds, a smaller target or less scatter may help, or another "
                "start"
            )
            raise DesignPointError(message, d)
        return d


def _sora(
    problem: _Problem,
    d: Array,
    inner: str,
    tolerance: float,
    cycles: int,
    rows: list[tuple[float, ...]],
) -> tuple[Array, list[Array | None]]:
    """Return the design of turns of most probable points and optimisations with shifts."""
    points: list[Array | None] = [None] * len(problem.names)
    for _ in range(cycles):
        points = [_worst(problem, d, i, inner, points[i])[0] for i in range(len(points))]
        new = problem.optimum(d, problem.shifted(points), 200)
        rows.append((problem.cost_of(new), *new))
        moved = float(np.max(np.abs(new - d) / problem.scale))
        d = new
        if moved <= tolerance:
            return d, points
    message = f"{WHERE}: the design still moves by {moved:.2g} after {count(cycles, 'cycle')}"
    raise DesignPointError(message, d, rows)


def _worst(
    problem: _Problem, d: Array, i: int, inner: str, near: Array | None
) -> tuple[Array, float, Array]:
    """Return the most probable point of a limit state on its sphere, its value and gradient."""
    space = problem.at(d, i)
    u = np.zeros(space.n) if near is None else near
    found = performance(space, u, float(problem.beta[i]), inner, 1e-6, 100)
    return found.u, found.value, found.gradient


def _nested(
    problem: _Problem,
    d: Array,
    method: str,
    inner: str,
    cycles: int,
    rows: list[tuple[float, ...]],
) -> tuple[Array, list[Array | None]]:
    """Return the design of one optimisation with an analysis in each step."""
    points: list[Array | None] = [None] * len(problem.names)
    known: dict[bytes, tuple[Array, Array]] = {}

    def both(e: Array) -> tuple[Array, Array]:
        key = e.tobytes()
        if key not in known:
            g, J = np.empty(len(points)), np.empty((len(points), len(e)))
            for i in range(len(points)):
                if method == "pma":
                    points[i], g[i], slope = _worst(problem, e, i, inner, points[i])
                    J[i] = problem.slope_at(e, i, np.asarray(points[i]), slope)
                else:
                    g[i], J[i], points[i] = _index(problem, e, i, points[i])
            known.clear()
            known[key] = g, J
            rows.append((problem.cost_of(e), *e))
        return known[key]

    d = problem.optimum(d, (lambda e: both(e)[0], lambda e: both(e)[1]), cycles)
    return d, points


def _index(
    problem: _Problem, d: Array, i: int, near: Array | None
) -> tuple[float, Array, Array | None]:
    """Return the index less its target, its derivatives and the design point."""
    target = float(problem.beta[i])
    for start in (near, None) if near is not None else (None,):
        space = problem.at(d, i)
        u = np.zeros(space.n) if start is None else start
        try:
            found = design_point(space, u, "sqp", 1e-6, 100, FAR)
        except DesignPointError:
            continue
        slope = problem.slope_at(d, i, found.u, found.gradient)
        return found.beta - target, slope / np.linalg.norm(found.gradient), found.u
    return FAR - target, np.zeros(len(d)), None  # it does not fail: far beyond any target


def _result(
    problem: _Problem,
    d: Array,
    first: Array,
    points: Sequence[Array | None],
    method: str,
    rows: list[tuple[float, ...]],
) -> RbdoResult:
    forms: list[FormResult] = []
    betas: dict[str, float] = {}
    for i, name in enumerate(problem.names):
        u = points[i]
        space = problem.at(d, i)
        try:
            found = design_point(
                space, np.zeros(space.n) if u is None else u, "sqp", 1e-6, 100, FAR
            )
        except DesignPointError:
            betas[name] = float("inf")
            continue
        betas[name] = found.beta
        forms.append(found)
    return RbdoResult(
        design=Frozen(dict(zip(problem.designs, d.tolist(), strict=True))),
        cost=problem.cost_of(d),
        betas=Frozen(betas),
        target=Frozen(dict(zip(problem.names, problem.beta.tolist(), strict=True))),
        deterministic=Frozen(dict(zip(problem.designs, first.tolist(), strict=True))),
        deterministic_cost=problem.cost_of(first),
        cycles=len(rows) - 1,
        calls=Frozen({k: c.calls for k, c in zip(problem.names, problem.counted, strict=True)}),
        gradients=Frozen(
            {k: c.gradients for k, c in zip(problem.names, problem.counted, strict=True)}
        ),
        method=method,
        history=np.array(rows),
        forms=tuple(forms),
    )


def _read(
    cost: Any,
    limits: Any,
    variables: Any,
    bounds: Any,
    beta: Any,
    start: Any,
    method: Any,
    inner: Any,
) -> _Problem:
    """Return the problem or say all that is wrong with it.

    Raises
    ------
    InputError
        With all of that.
    """
    problems = Problems()
    if method not in METHODS:
        problems.add(WHERE, f"method is {method!r}, must be one of {', '.join(METHODS)}")
    if inner not in MEAN_VALUES:
        problems.add(WHERE, f"inner is {inner!r}, must be one of {', '.join(MEAN_VALUES)}")
    T = transformation(variables)
    named = _limits(problems, limits)
    boxes = _bounds(problems, bounds, T)
    given = _start(problems, start, boxes, T)
    targets = _targets(problems, beta, list(named))
    problems.raise_if_any()
    designs = list(boxes)
    low, high = (np.array([box[k] for box in boxes.values()]) for k in (0, 1))
    names = (*T.names, *(name for name in designs if name not in T.names))
    about = cost if isinstance(cost, LimitState) else limit_state(cost, "cost")
    width = np.where(np.isfinite(high - low), high - low, np.maximum(np.abs(given), 1.0))
    return _Problem(
        cost=Counted(about, designs),
        counted=[Counted(one, names) for one in named.values()],
        names=list(named),
        variables=T,
        designs=designs,
        low=low,
        high=high,
        start=given,
        scale=np.where(width > 0.0, width, 1.0),
        beta=targets,
    )


def _limits(problems: Problems, limits: Any) -> dict[str, LimitState]:
    if callable(limits) or isinstance(limits, LimitState):
        limits = [limits]
    if isinstance(limits, Mapping):
        pairs = list(limits.items())
    elif isinstance(limits, list | tuple):
        # functions without a name of their own are numbered
        own = [
            limit_state(one).name if callable(one) else getattr(one, "name", "G") for one in limits
        ]
        pairs = [
            (f"G{i + 1}" if name == "G" else name, one)
            for i, (name, one) in enumerate(zip(own, limits, strict=True))
        ]
    else:
        pairs = []
    if not pairs:
        problems.add(WHERE, f"limits is {limits!r:.60}, must be a dictionary of limit states")
    found: dict[str, LimitState] = {}
    for name, one in pairs:
        if not (isinstance(one, LimitState) or callable(one)):
            problems.add(
                WHERE, f"limits[{name!r}] is {one!r:.60}, must be a function or LimitState"
            )
        elif name in found:
            problems.add(WHERE, f"two limit states have the name {name!r}")
        else:
            state = limit_state(one, str(name))
            found[str(name)] = replace(state, name=str(name))
    return found


def _bounds(problems: Problems, bounds: Any, T: Transformation) -> dict[str, tuple[float, float]]:
    if not isinstance(bounds, Mapping) or not bounds:
        problems.add(WHERE, f"bounds is {bounds!r:.60}, must be a dictionary of two numbers each")
        return {}
    movable = {one.name for one in T.randoms}
    found = {}
    for name, pair in bounds.items():
        try:
            low, high = (float(x) for x in pair)
        except (TypeError, ValueError):
            problems.add(WHERE, f"bounds of {name!r} are {pair!r:.40}, must be two numbers")
            continue
        if not low < high:
            message = f"bounds of '{name}' are {low:g} to {high:g}, they are crossed"
            problems.add(WHERE, message if low > high else message.replace("crossed", "equal"))
            continue
        if name in T.names and name not in movable:
            message = f"the mean of '{name}' is no parameter of such variables"
            problems.add(WHERE, message + "; those of Nataf have means")
            continue
        found[str(name)] = (low, high)
    return found


def _start(problems: Problems, start: Any, boxes: Any, T: Transformation) -> Array:
    means = {one.name: one.mean for one in T.randoms}
    if start is not None and not isinstance(start, Mapping):
        problems.add(WHERE, f"start is {start!r:.60}, must be a dictionary of numbers")
        start = None
    given = dict(start or {})
    for name in given:
        if name not in boxes:
            problems.add(WHERE, f"start has {name!r}, which has no bounds{suggest(name, boxes)}")
    out = []
    for name, (low, high) in boxes.items():
        value = given.get(name, means.get(name))
        if value is None:
            problems.add(WHERE, f"start needs a value for '{name}', which is not random")
            continue
        if not problems.number(WHERE, f"start of '{name}'", value, ""):
            continue
        if not low <= value <= high:
            whose = "start" if name in given else "mean"
            message = f"{whose} of '{name}' is {value:g}, outside of its bounds {low:g} to {high:g}"
            problems.add(WHERE, message)
        out.append(float(value))
    return np.array(out)


def _targets(problems: Problems, beta: Any, names: list[str]) -> Array:
    if isinstance(beta, Mapping):
        for name in beta:
            if name not in names:
                problems.add(WHERE, f"beta has {name!r}{suggest(name, names)}")
        for name in names:
            if name not in beta:
                problems.add(WHERE, f"beta has no target for '{name}'")
        values = [beta.get(name, 1.0) for name in names]
    else:
        values = [beta] * len(names)
    out = []
    for value in values:
        before = len(problems.found)
        problems.positive(WHERE, "beta", value, "")
        if len(problems.found) > before:
            return np.ones(len(names))
        if value > FAR:
            problems.add(WHERE, f"beta is {value:g}, beyond {FAR:g} no probability is a double")
        out.append(float(value))
    return np.array(out)
