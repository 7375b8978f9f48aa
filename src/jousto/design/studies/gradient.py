"""Function `gradient`: derivatives of outcomes by complex steps, or by differences."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.complexstep import STEP
from jousto.base.errors import InputError, NotAnalytic, Problem
from jousto.design.studies.gradient_result import (
    DIFFERENCES,
    EXACT,
    MOTION,
    NONE,
    RUN,
    STEPS,
    GradientResult,
    place_of,
)
from jousto.design.studies.lost_derivatives import (
    AGREES,
    FAR,
    RELATIVE,
    ROUNDING,
    WHOLE,
    WIDE,
    find_lost,
    unresolved,
)
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.evaluator import Evaluator, reason
from jousto.design.studies.study import Study

CLOSE = 0.1 * RELATIVE
"""Step of differences beside a kink, relative to the value."""
BENDS = 0.1
"""Difference of the one-sided slopes, relative to the larger one, up to which it is curvature."""

NOISE, FLAT = 1e-10, 1e-6
"""Relative rounding error of an outcome, and the noise below which a change is no jump."""
DECIDED = 1e-6
"""Relative noise of an outcome of a run whose steps depend on contacts."""
OURS = ("jousto", "numpy", "scipy", "pydantic", "pydantic_core")
"""Modules whose lines are left out of tracebacks for the author of the model."""


@explained
def gradient(
    study: Study,
    x: ArrayLike | None = None,
    outcomes: str | Sequence[str] | None = None,
    *,
    check: bool = True,
) -> GradientResult:
    """Return the outcomes of a study at a point and their derivatives by its parameters.

    ``dy/dx = Im y(x + i h) / h``: the machine is built, compiled, run and evaluated once for each
    parameter with complex numbers (Squire and Trapp, SIAM Rev. 40, 1998), exact to rounding. Where
    a machine can be built from real numbers only (``math.sin(x)``, ``float(x)``, solids, exact
    beams), the derivative of its model comes from fourth-order differences between four models, and
    the run is complex. Central differences with two real runs per parameter are used for models
    that complex numbers cannot run (events, sticking friction, solvers with step control), and for
    results for which complex steps and differences disagree. ``how`` of the result contains the
    reason.

    The derivative of a largest value over time is taken at its instant, that of a hot spot at its
    place, and that of a damage for the cycles counted at the point.

    Parameters
    ----------
    study : Study
        Study from `study`.
    x : (np,) array, optional
        The point; by default the nominal values.
    outcomes : str or sequence of str, optional
        Names of outcomes; by default all.
    check : bool
        Whether real runs check the complex steps: two along one direction, and two along each
        parameter with a derivative that is zero or too small to count there. A function of the
        user may lose derivatives without an error (``abs(x)``, ``x.real``).

    Raises
    ------
    InputError
        If the point is invalid, or the machine cannot be built or run there.

    Examples
    --------
    >>> import jousto as jo
    >>> def block(mass):
    ...     body = jo.RigidBody("block", mass, (1.0, 1.0, 1.0))
    ...     slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    ...     push = jo.JointForce("push", slide.displacement, 6.0)
    ...     way = jo.CoordinateSensor("way", slide.displacement)
    ...     return jo.Mechanism(body, slide, push, way)
    >>> fall = jo.study(block, jo.Parameter("mass", 2.0, unit="kg"), "last(way)", t_end=1.0)
    >>> found = gradient(fall)
    >>> found.values.round(6), found.jacobian.round(6), found.how
    (array([1.5]), array([[-0.75]]), (('complex step',),))
    """
    given: Any = study
    if not isinstance(given, Study):
        message = f"is {given!r:.60}, must be a Study; jo.study(model, ...) makes one"
        raise InputError(Problem("study", message))
    names = (outcomes,) if isinstance(outcomes, str) else outcomes
    rows = list(range(len(study.outcomes)))
    if names is not None:
        rows = [place_of("outcome", name, study.outcomes) for name in names]
    if not rows:
        raise InputError(Problem("gradient", "outcomes is empty, must name some or be left out"))
    return Work(study._evaluator, study.point(x), rows).result(check)


class Slopes:
    """Derivatives of some outcomes of a study at any point, also outside its bounds.

    Differences check the derivatives at the first point.

    Parameters
    ----------
    study : Study
        Study from `study`.
    rows : list of int
        The outcomes; the rows of all others are zero.
    """

    def __init__(self, study: Study, rows: list[int]) -> None:
        self._study, self._rows, self._check = study, rows, True
        self._evaluator = study._evaluator.unbounded()

    def __call__(self, x: Array) -> Array:
        """Return the derivatives (no, np) at a point (np,)."""
        work = Work(self._evaluator, self._study.point(x), self._rows)
        found = np.zeros((len(self._study.outcomes), len(self._study.parameters)))
        found[self._rows] = work.result(self._check).jacobian
        self._check = False
        return found


class Work:
    """Computation of the derivatives of some outcomes at one point.

    Parameters
    ----------
    evaluator : Evaluator
        Evaluator that builds and runs machines and computes outcomes.
    x : (np,) array
        The point.
    rows : list of int
        The outcomes.
    """

    def __init__(self, evaluator: Evaluator, x: Array, rows: list[int]) -> None:
        self._evaluator = evaluator
        self._x = x
        self._outcomes = tuple(evaluator.outcomes[i] for i in rows)
        self._parameters = evaluator.parameters
        self._before = evaluator.memory.models.made
        self.runs = {"real": 0, "complex": 0}
        shape = (len(rows), len(x))
        self._jacobian = np.full(shape, np.nan)
        self._way = [[EXACT] * len(x) for _ in rows]
        self._why = [[""] * len(x) for _ in rows]
        self._values = np.full(len(rows), np.nan)
        self._whole = np.zeros(len(rows), dtype=bool)
        self._noise = np.full(shape, NOISE)

    def result(self, check: bool) -> GradientResult:
        """Return values and derivatives of all outcomes."""
        if outside := self._evaluator.out_of_bounds(self._x):
            raise InputError(Problem("gradient", outside))
        with np.errstate(invalid="ignore"):  # outcomes may be infinite
            return self._result(check)

    def _result(self, check: bool) -> GradientResult:
        self._values = self._outcomes_at(self._x)
        columns, whole = range(len(self._x)), self._whole
        for i, value in enumerate(self._values):
            if not np.isfinite(value):
                self._record([i], NONE, f"the outcome is {value}")
            elif whole[i]:
                for j in columns:
                    self._note_jump(i, j)
        for j in columns:
            self._step(j)
        if check:
            self._check()
            for j in columns:
                self._check_alone(j)
        for j in columns:
            if any(row[j] == DIFFERENCES for row in self._way):
                self._difference(j)
        self.runs["models"] = self._evaluator.memory.models.made - self._before
        pairs = [zip(*pair, strict=True) for pair in zip(self._way, self._why, strict=True)]
        how = tuple(tuple(f"{way}: {why}" if why else way for way, why in row) for row in pairs)
        return GradientResult(
            self._values,
            self._jacobian,
            how,
            tuple(outcome.name for outcome in self._outcomes),
            tuple(parameter.name for parameter in self._parameters),
            self._x,
            self.runs,
        )

    def _outcomes_at(self, x: Array) -> Array:
        """Return the outcomes at a point."""
        self.runs["real"] += 1
        found = self._evaluator.outcomes_at(x, self._outcomes)
        for one in found:
            if one.error is not None:
                raise one.error
        self._whole = np.array([one.whole for one in found])
        return np.array([one.value for one in found], dtype=float)

    def _outcomes_beside(self, j: int, distance: float) -> Array | None:
        """Return the outcomes at a distance along a parameter; None if the machine fails there."""
        x = self._x.copy()
        x[j] += distance
        try:
            return self._outcomes_at(x)
        except Exception:
            return None

    def _record(self, rows: Iterable[int], way: str, why: str, j: int | None = None) -> None:
        """Record the method of some outcomes' derivatives, unless one is recorded already."""
        for i in rows:
            for k in range(len(self._x)) if j is None else [j]:
                if self._way[i][k] in STEPS:
                    self._way[i][k], self._why[i][k] = way, why

    def _step(self, j: int) -> None:
        """Fill a column by a complex step, or record the reason against it."""
        x: Any = self._x.astype(np.complex128)
        x[j] += 1j * STEP
        found = self._evaluator.outcomes_at(x, self._outcomes)
        self.runs["complex"] += any(one.error is None for one in found)
        for i, one in enumerate(found):
            if one.error is not None:
                self._record([i], DIFFERENCES, needs_real(one.error), j)
                if isinstance(one.error, NotAnalytic) and one.error.noisy:
                    self._noise[i, j] = DECIDED
                continue
            if self._way[i][j] == NONE:
                continue
            slope, value = one.value.imag / STEP, self._values[i]
            scale = max(abs(value), abs(slope * self._size(j)))
            if not np.isfinite(slope) or abs(one.value.real - value) > AGREES * scale:
                why = f"its value with complex numbers differs, {one.value.real:.6g}"
                self._record([i], DIFFERENCES, why, j)
                continue
            self._way[i][j] = MOTION if one.followed else EXACT
            if one.between is not None:
                self._way[i][j], self._why[i][j] = RUN, needs_real(one.between)
            self._jacobian[i, j] = slope

    def _size(self, j: int) -> float:
        """Return a scale of the parameter over which the outcomes change."""
        parameter: Parameter = self._parameters[j]
        return parameter.reach(self._x[j])

    def _check(self) -> None:
        """Check complex-step derivatives by differences along one direction.

        A second check with a smaller step follows where the first one may have crossed a kink.
        """
        columns = [j for j in range(len(self._x)) if any(row[j] in STEPS for row in self._way)]
        # skip outcomes for which some columns contain differences
        known = [all(row[j] in STEPS for j in columns) for row in self._way]
        rows = np.flatnonzero(known).tolist() if columns else []
        # irregular weights, so that errors of several parameters do not cancel
        sizes = np.array([self._size(j) * (1.0 + 0.37 * np.sin(1.0 + j)) for j in columns])
        for share, noise in ((RELATIVE, NOISE), (CLOSE, 0.0)):
            if not rows:
                return
            step = np.zeros(len(self._x))
            step[columns] = share * sizes
            try:
                high, low = self._outcomes_at(self._x + step), self._outcomes_at(self._x - step)
            except Exception as problem:
                self._record(rows, DIFFERENCES, f"they could not be checked, {reason(problem)}")
                return
            terms = (self._jacobian[rows] * step)[:, columns]
            size, y = np.abs(terms).sum(axis=1), self._values[rows]
            error = np.abs(terms.sum(axis=1) - 0.5 * (high - low)[rows])
            bend = np.abs((high + low)[rows] - 2.0 * y)
            good = error <= AGREES * size + noise * np.abs(y)
            good &= bend <= BENDS * size + 10.0 * NOISE * np.abs(y)
            rows = np.array(rows)[~good].tolist()
        self._record(rows, DIFFERENCES, "complex steps and differences disagree")

    def _check_alone(self, j: int) -> None:
        """Check the derivatives by one parameter that the direction check may not resolve."""
        sizes = np.array([self._size(k) for k in range(len(self._x))])
        hidden = unresolved(self._jacobian, sizes, self._values)[:, j]
        rows = [i for i, way in enumerate(self._way) if way[j] in STEPS and hidden[i]]
        if not rows:
            return
        slopes = self._jacobian[:, j]
        found = find_lost(partial(self._outcomes_beside, j), self._values, slopes, rows, sizes[j])
        for i, (why, jumps) in found.items():
            self._record([i], NONE if jumps else DIFFERENCES, why, j)
            # the difference is proportional to the step, so it is a derivative and not noise
            self._noise[i, j] = ROUNDING
            if jumps:
                self._jacobian[i, j] = np.nan

    def _note_jump(self, i: int, j: int) -> None:
        """Record that a whole number has no derivative by a parameter that makes it jump."""
        ends = [self._outcomes_beside(j, side * WHOLE * self._size(j)) for side in (1.0, -1.0)]
        for end in ends:
            if end is not None and end[i] != self._values[i]:
                why = f"the outcome is a whole number, which jumps to {end[i]:g} beside the point"
                self._record([i], NONE, why, j)

    def _difference(self, j: int) -> None:
        """Fill missing derivatives of a column by differences, where the outcomes are smooth."""
        rows = [i for i, row in enumerate(self._way) if row[j] == DIFFERENCES]
        noisy = [i for i in rows if self._noise[i, j] >= DECIDED]
        self._difference_of([i for i in rows if i not in noisy], j, (RELATIVE, CLOSE, WIDE))
        self._difference_of(noisy, j, (WIDE, FAR))

    def _difference_of(self, rows: list[int], j: int, shares: tuple[float, ...]) -> None:
        """Fill some rows of a column by the first steps for which both sides agree, or by a bend.

        The second steps are smaller than the first ones: a difference of slopes that stays is a
        bend.
        """
        gaps = np.zeros(len(self._values))
        for k, share in enumerate(shares if rows else ()):
            h = share * self._size(j)
            rise, fall, message = self._one_sided_slopes(j, h)
            gap = np.abs(rise - fall)
            larger = np.maximum(np.abs(rise), np.abs(fall))
            noise = 10.0 * self._noise[:, j] * np.abs(self._values) / h
            bent = ~(gap <= BENDS * larger + noise)
            if share == WIDE:
                bent &= gap * h > FLAT * np.abs(self._values)
            for i in rows:
                self._jacobian[i, j] = 0.5 * (rise[i] + fall[i])
                self._why[i][j] += message
                if k == 1 and bent[i] and gap[i] < 3.0 * gaps[i]:
                    bent[i] = False
                    self._why[i][j] += f"; it bends here, slopes {fall[i]:.6g} and {rise[i]:.6g}"
                elif share == WIDE and not bent[i]:
                    self._why[i][j] += f"; it is noisy, steps of {h:.3g}"
            rows, gaps = [i for i in rows if bent[i]], gap
            if not rows:
                return
        for i in rows:
            self._way[i][j], self._jacobian[i, j] = NONE, np.nan
            self._why[i][j] += "; it jumps here"

    def _one_sided_slopes(self, j: int, h: float) -> tuple[Array, Array, str]:
        """Return the slopes above and below the point, and a remark on their difference.

        If the machine fails on one side, both slopes are the second-order slope of the other side.
        """
        failed: list[Exception] = []
        found: list[Array] = []
        for sign in (1.0, -1.0):
            step = np.zeros(len(self._x))
            step[j] = sign * h
            try:
                found.append((self._outcomes_at(self._x + step) - self._values) / step[j])
            except Exception as error:
                failed.append(error)
                continue
            working = step
        if len(failed) == 2:
            raise failed[0]
        if not failed:
            return found[0], found[1], ""
        far = (self._outcomes_at(self._x + 2.0 * working) - self._values) / (2.0 * working[j])
        slope = 2.0 * found[0] - far
        side = "above" if working[j] < 0.0 else "below"
        return slope, slope, f"; on one side, {side} it fails: {reason(failed[0])}"


def needs_real(error: Exception) -> str:
    """Return the reason why a machine takes no complex numbers, with a source line."""
    if isinstance(error, NotAnalytic):
        return str(error)
    chain: list[BaseException] = [error]
    while (before := chain[-1].__cause__ or chain[-1].__context__) and before not in chain:
        chain.append(before)
    for one in reversed(chain):
        for frame, line in reversed(list(traceback.walk_tb(one.__traceback__))):
            module = str(frame.f_globals.get("__name__")).partition(".")[0]
            if module not in OURS and module not in sys.stdlib_module_names:
                return f"line {line} of {Path(frame.f_code.co_filename).name} needs real numbers"
    return "something that depends on it needs real numbers"
