"""Limit states from outcomes of a study: distance of an outcome from its bound."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.expressions import Quantity
from jousto.design.reliability.inputs.random import Random
from jousto.design.reliability.inputs.transform import Correlation, Nataf
from jousto.design.reliability.limit import LimitState, Values
from jousto.design.studies.gradient import Slopes as Exact
from jousto.design.studies.outcomes.outcomes import Damage
from jousto.design.studies.outcomes.requirement import Requirement, read_requirement
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.study import Study

FEW = 200  # points of a sampling per batch
# step of differences, standard deviations; results of runs have errors far above rounding
STEP = 1e-3
WIDTH = 1e-6  # step of differences of a bound, relative to the parameter
CEILING = 1e12  # upper limit of a ratio: a life without damage is a large, finite reserve
Slopes = Callable[[Array], Any]


class StudyLimit(LimitState):
    """Limit state that is an outcome of a study; see `limit_state`."""

    @property
    def batch(self) -> int:
        """Number of points per batch of a sampling."""
        return FEW * int(getattr(self.function, "at_once", 1))


class Reserve:
    """Distance of an outcome of a study from its bound, as a function of the random values.

    Parameters
    ----------
    study : Study
        Study that computes the outcome, each point once.
    limit : Requirement
        Outcome and bound.
    more : sequence of Parameter
        Parameters that only the bound depends on.
    slopes : callable, optional
        Derivatives of all outcomes by all parameters of the study.
    workers, how
        As in `Study.run`.
    """

    def __init__(
        self,
        study: Study,
        limit: Requirement,
        more: Sequence[Parameter] = (),
        slopes: Slopes | None = None,
        workers: Any = 1,
        how: str = "threads",
    ) -> None:
        self.study, self.limit, self.slopes = study, limit, slopes
        self.workers, self.how = workers, how
        self.at_once = workers if isinstance(workers, int) else 1
        self.parameters = {p.name: p for p in (*study.parameters, *more)}
        self.place = _place(study, limit)
        self.ratio = isinstance(study.about(self.place), Damage)
        self.sign = 1.0 if limit.below else -1.0
        self.bounding = limit.names(self.parameters)
        nominal = {name: self.parameters[name].value for name in self.bounding}
        bound = self.bound(nominal)
        if self.ratio and not bound > 0.0:
            message = f"its bound is {bound:g}, that of a life or a damage must be positive"
            raise InputError(Problem(f"limit {limit.text!r}", message))

    def bound(self, values: Mapping[str, float]) -> float:
        """Return the bound at given values of its parameters."""
        kinds = {name: self.parameters[name].exponents for name in self.bounding}
        known = {name: Quantity(float(values[name]), kinds[name]) for name in self.bounding}
        return self.limit.value(known, self.study.units[self.place])

    def points(self, x: Values) -> tuple[Array, list[dict[str, float]]]:
        """Return the study's points (n, np), and the bound's parameter values at each point."""
        for name in x.names:
            if name not in self.parameters:
                message = f"the study has no parameter {name!r}{suggest(name, self.parameters)}"
                raise InputError(Problem("limit state", message))
        plain = np.asarray(x)
        columns = plain.reshape(len(x.names), -1)
        given = dict(zip(x.names, columns, strict=True))

        def column(p: Parameter) -> Array:
            return np.asarray(given.get(p.name, np.full(columns.shape[1], p.value)))

        X = np.stack([column(p) for p in self.study.parameters], axis=1)
        bounding = {name: column(self.parameters[name]) for name in self.bounding}
        each = [{name: float(v[k]) for name, v in bounding.items()} for k in range(len(X))]
        return X, each

    def __call__(self, x: Values) -> Any:
        """Return the reserve; NaN where the outcome has no value."""
        X, each = self.points(x)
        rows = self.study.rows(X, workers=self.workers, how=self.how)
        y = np.array([row[self.place] for row, _ in rows])
        constant = None if self.bounding else self.bound({})
        b = np.array([self.bound(at) if constant is None else constant for at in each])
        if self.ratio:
            with np.errstate(all="ignore"):
                ratio = np.clip(y / b, 1.0 / CEILING, CEILING)
                g = -self.sign * np.where(b > 0.0, np.log(ratio), np.nan)
        else:
            g = self.sign * (b - y)
        return g if x.ndim > 1 else float(g[0])

    def why(self, x: Values) -> str:
        """Return the reason why the study has no value at a point."""
        X, _ = self.points(x)
        return self.study.rows(X)[0][1]

    def gradient(self, x: Values) -> dict[str, float]:
        """Return the derivatives of the reserve by the values, from given outcome derivatives."""
        assert self.slopes is not None
        X, each = self.points(x)
        dy = np.asarray(self.slopes(X[0]), dtype=np.float64)
        if dy.shape != (len(self.study.outcomes), len(self.study.parameters)):
            message = (
                f"gradient has shape {dy.shape}, must be outcomes x parameters, "
                f"({len(self.study.outcomes)}, {len(self.study.parameters)})"
            )
            raise InputError(Problem("limit state", message))
        b = self.bound(each[0])
        row = dy[self.place]
        if self.ratio:
            row = row / self.study.rows(X)[0][0][self.place]
        found = dict.fromkeys(self.parameters, 0.0)
        for p, slope in zip(self.study.parameters, row, strict=True):
            found[p.name] -= self.sign * float(slope)
        for name in self.bounding:
            h = WIDTH * (abs(each[0][name]) or 1.0)
            ends = [self.bound({**each[0], name: each[0][name] + s * h}) for s in (1.0, -1.0)]
            slope = (ends[0] - ends[1]) / (2.0 * h)
            found[name] += self.sign * (slope / b if self.ratio else slope)
        return {name: found[name] for name in x.names}


def _place(study: Study, limit: Requirement) -> int:
    """Return the index of the limited outcome in the study."""
    if limit.left in study.outcomes:
        return study.outcomes.index(limit.left)
    name = limit.outcome.name
    if name in study.outcomes:
        return study.outcomes.index(name)
    message = f"the study has no outcome {name!r}{suggest(name, study.outcomes)}"
    raise InputError(Problem(f"limit {limit.text!r}", message))


@explained
def limit_state(
    study: Study,
    limit: str | Requirement,
    *,
    parameters: Sequence[Parameter] = (),
    correlation: Correlation | None = None,
    gradient: Slopes | bool | None = None,
    step: float = STEP,
    differences: Literal["forward", "central"] = "forward",
    workers: Any = 1,
    how: str = "threads",
) -> StudyLimit:
    """Return the limit state of an outcome and its bound, with the random variables of the study.

    ``G = bound - outcome`` for ``<=``, the opposite sign for ``>=``; for a life or a damage the
    logarithm of their ratio. The random variables are the parameters with a distribution; the
    others have their nominal values. Each point is simulated once for all limit states and methods.
    Bounds of parameters apply to means, not to random values.

    Parameters
    ----------
    study : Study
        Parameters and outcomes.
    limit : str or Requirement
        ``"max(tip.y) <= 12 mm"``, ``"stress(arm) <= strength / 1.5"``: an outcome of the study and
        an expression of parameters; with a name ``"tip = max(tip.y) <= 12 mm"``.
    parameters : sequence of Parameter
        Further parameters, on which only the bound depends, such as a strength or the scatter of a
        life.
    correlation : dict, optional
        Correlation of pairs of parameters by name, as in `Nataf`.
    gradient : callable or True, optional
        Derivatives of the outcomes by the parameters (no, np) at a point (np,); True: by `gradient`
        with complex steps; None: differences.
    step : float
        Step of differences, in standard deviations.
    differences : {"forward", "central"}
        n or 2 n points for a gradient.
    workers, how
        For gradients and samples, as in `Study.run`.

    Returns
    -------
    LimitState
        For `form`, `sorm`, `pma`, `rbdo`, `monte_carlo`, `importance_sampling` and
        `subset_simulation`, which need no further arguments.

    Raises
    ------
    InputError
        If the study has no such outcome, no parameter is random, or the correlation is impossible.

    Examples
    --------
    >>> import jousto as jo
    >>> def block(mass):
    ...     body = jo.RigidBody("block", mass, (1, 1, 1))
    ...     slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    ...     push = jo.JointForce("push", slide.displacement, jo.Input("force"))
    ...     way = jo.CoordinateSensor("way", slide.displacement)
    ...     return jo.Mechanism(body, slide, push, way)
    >>> mass = jo.Parameter("mass", 2.0, unit="kg", distribution="normal(sd=0.2)")
    >>> force = jo.Parameter("force", 4.0, unit="N", distribution="normal(sd=0.4)")
    >>> study = jo.study(block, [mass, force], "last(way)", t_end=1.0, solver=jo.RK4(0.1))
    >>> found = jo.design.form(limit_state(study, "last(way) <= 1.5 m"))
    >>> print(f"{found.beta:.3f}, mass {found.x['mass']:.3f}, force {found.x['force']:.3f}")
    2.774, mass 1.538, force 4.615
    """
    wanted = read_requirement(limit) if isinstance(limit, str) else limit
    problems = Problems()
    more = problems.several("limit state", "parameters", parameters, Parameter)
    known = {p.name for p in study.parameters}
    for name in sorted({p.name for p in more} & known):
        problems.add("limit state", f"parameter '{name}' is also a parameter of the study")
    scattered = [p for p in (*study.parameters, *more) if p.distribution is not None]
    if not scattered:
        message = "no parameter has a distribution, such as 'normal(sd=0.1 mm)': no random variable"
        problems.add(f"limit {wanted.text!r}", message)
    problems.raise_if_any()
    slopes = gradient if callable(gradient) else None
    if gradient is True:
        slopes = Exact(study, [_place(study, wanted)])
    reserve = Reserve(study, wanted, more, slopes, workers, how)
    variables = Nataf([Random(p.name, p.distribution) for p in scattered], correlation)
    return StudyLimit(
        reserve,
        gradient=None if slopes is None else reserve.gradient,
        vectorised=True,
        name=wanted.name,
        step=step,
        differences=differences,
        variables=variables,
    )
