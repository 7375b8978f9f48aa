"""Tables in one and two variables: slopes of piecewise cubic polynomials, and their blocks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Choice, field
from jousto.base.numbers import Values
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression
from jousto.mechanism.states.inputs import InputField

SLOPES = ("natural", "parabola", "monotone")
OUTSIDE = ("hold", "line", "stop")
MEANING = (
    "Slopes at the knots: of the natural cubic spline (twice differentiable), of the parabola "
    "through three points, or those that keep monotone data monotone (Fritsch and Carlson 1980)"
)
BEYOND = "Beyond the ends: the value there, the line with the slope there, or the run stops"


def slopes_of(at: Array, values: Array, kind: str) -> Array:
    """Return the slopes at the knots of values along their last axis.

    Parameters
    ----------
    at : (n,) ndarray
        Knots, increasing.
    values : (.., n) ndarray
        Values.
    kind : str
        "natural", "parabola" or "monotone".
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator

    if kind == "natural" or len(at) == 2:
        made = CubicSpline(at, values, axis=-1, bc_type="natural")(at, 1)
    elif kind == "monotone":
        if np.iscomplexobj(values):
            text = "has no derivative with respect to its values; take natural or parabola slopes"
            raise InputError(Problem("monotone table", text))
        made = PchipInterpolator(at, values, axis=-1)(at, 1)
    else:
        h, d = np.diff(at), np.diff(values, axis=-1) / np.diff(at)
        made = np.empty_like(values)
        made[..., 1:-1] = (h[1:] * d[..., :-1] + h[:-1] * d[..., 1:]) / (h[:-1] + h[1:])
        made[..., 0] = 2.0 * d[..., 0] - made[..., 1]
        made[..., -1] = 2.0 * d[..., -1] - made[..., -2]
    return np.asarray(made)


def _looked_up(operation: str, numbers: list[Any], *inputs: Expression) -> Expression:
    """Return the operation of the engine on the numbers of a table."""
    block = Expression("numbers", of=tuple(x for some in numbers for x in np.ravel(some).tolist()))
    return Expression(operation, (inputs[0], block, *inputs[1:]))


def surface(
    x: Expression, y: Expression, at_x: Array, at_y: Array, values: Array, *,
    slopes: str = "parabola", outside: str = "hold",
) -> Expression:  # fmt: skip
    """Return z(x, y) of values (n x m) at the knots at_x (n,) and at_y (m,)."""
    along_x = slopes_of(at_x, values.T, slopes).T
    along_y, mixed = (slopes_of(at_y, one, slopes) for one in (values, along_x))
    head = [*values.shape, OUTSIDE.index(outside)]
    return _looked_up("map", [head, at_x, at_y, values, along_x, along_y, mixed], x, y)


def check_knots(problems: Problems, where: str, key: str, at: Array, count: int) -> None:
    """Report knots that are too few or not increasing, or of another number than the values."""
    if len(at) < 2:
        problems.add(where, f"{key} has {len(at)} knots, must have 2 or more", key)
    elif not (np.diff(np.real(at)) > 0.0).all():
        k = int(np.argmin(np.diff(np.real(at)) > 0.0))
        text = f"{key} must increase, but {key}[{k + 1}] is {at[k + 1]:g} after {at[k]:g}"
        problems.add(where, text, key)
    elif len(at) != count:
        text = f"{key} has {len(at)} knots for {count} values, must have as many"
        problems.add(where, text, "values")


class Lookup(Block, tag="lookup"):
    """Table y(u): a piecewise cubic polynomial with a continuous slope.

    Examples
    --------
    >>> from jousto.mechanism import Lookup
    >>> curve = Lookup("curve", 0.5, [0.0, 1.0, 2.0], [0.0, 1.0, 4.0], interpolation="parabola")
    >>> print(curve["y"])
    curve.y
    """

    kind = "lookup"
    outputs = ("y",)
    input: InputField = field("Input u")
    at: Values = field("Knots of u, increasing", shape=(None,))
    values: Values = field("Values of y at the knots", shape=(None,))
    interpolation: Choice = field(MEANING, words=SLOPES, default="natural", kw_only=True)
    outside: Choice = field(BEYOND, words=OUTSIDE, default="hold", kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report knots that do not increase or do not fit the values."""
        check_knots(problems, where, "at", self.at, len(self.values))

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the output."""
        slopes = slopes_of(self.at, self.values, self.interpolation)
        head = [len(self.at), OUTSIDE.index(self.outside)]
        numbers = [head, self.at, self.values, slopes]
        return Equations(outputs={"y": _looked_up("table", numbers, self.input)})


class LookupMap(Block, tag="lookup-map"):
    """Table z(x, y): bicubic Hermite polynomials with continuous slopes.

    The slopes along x and y follow from the values as in one variable, the mixed derivative is the
    slope along y of the slopes along x.

    Examples
    --------
    >>> from jousto.mechanism import LookupMap
    >>> pump = LookupMap("pump", 150.0, 1e6, [100, 200], [0, 2e6], [[0.9, 0.8], [0.95, 0.85]])
    >>> print(pump["z"])
    pump.z
    """

    kind = "lookup map"
    outputs = ("z",)
    x: InputField = field("Input x")
    y: InputField = field("Input y")
    at_x: Values = field("Knots of x (n,), increasing", shape=(None,))
    at_y: Values = field("Knots of y (m,), increasing", shape=(None,))
    values: Values = field("Values of z (n x m) at the knots", shape=(None, None))
    interpolation: Choice = field(MEANING, words=SLOPES, default="parabola", kw_only=True)
    outside: Choice = field(BEYOND, words=OUTSIDE, default="hold", kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report knots that do not increase or do not fit the values."""
        check_knots(problems, where, "at_x", self.at_x, self.values.shape[0])
        check_knots(problems, where, "at_y", self.at_y, self.values.shape[1])

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the output."""
        knots, how = (self.at_x, self.at_y, self.values), self.interpolation
        z = surface(self.x, self.y, *knots, slopes=how, outside=self.outside)
        return Equations(outputs={"z": z})
