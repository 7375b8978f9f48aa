"""Functions along an axis: beam eigenfunctions in closed form and B-splines."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import brentq

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Choice, field
from jousto.base.numbers import Whole
from jousto.reduction.shapes.functions import Columns, Family

if TYPE_CHECKING:
    from jousto.parts.part import Part

ENDS = (
    "clamped-free",
    "free-clamped",
    "pinned-pinned",
    "free-free",
    "clamped-pinned",
    "pinned-clamped",
    "clamped-clamped",
)
# orders of the derivatives that vanish at an end
CONDITIONS = {"clamped": (0, 1), "pinned": (0, 2), "free": (2, 3)}
MOST = 60
"""Largest number of eigenfunctions of a beam; beyond it beam theory does not apply."""

MOST_DEGREE = 9
"""Largest degree of splines."""

Curve = Callable[[Array, int], Array]


def characteristic(ends: str) -> Callable[[float], float]:
    """Return the characteristic function of beta L for the ends of a beam; its zeros are the roots.

    It is divided by cosh if it grows, so that zeros of high order are accurate.
    """
    return {
        "clamped-free": lambda x: float(np.cos(x) + 1.0 / np.cosh(x)),
        "free-free": lambda x: float(np.cos(x) - 1.0 / np.cosh(x)),
        "clamped-clamped": lambda x: float(np.cos(x) - 1.0 / np.cosh(x)),
        "clamped-pinned": lambda x: float(np.sin(x) - np.tanh(x) * np.cos(x)),
        "pinned-pinned": lambda x: float(np.sin(x)),
    }[ends]


@cache
def root(ends: str, k: int) -> float:
    """Return beta L of the k-th elastic eigenfunction of a beam, with k counted from 1.

    Examples
    --------
    >>> [round(root("clamped-free", k), 4) for k in (1, 2, 3)]
    [1.8751, 4.6941, 7.8548]
    """
    if ends == "pinned-pinned":
        return k * np.pi
    plain = {"free-clamped": "clamped-free", "pinned-clamped": "clamped-pinned"}.get(ends, ends)
    first = (k - 1) * np.pi if plain == "clamped-free" else k * np.pi
    return float(brentq(characteristic(plain), first, first + np.pi, xtol=1e-15, rtol=1e-15))


@cache
def _coefficients(ends: str, k: int) -> Array:
    """Return coefficients of ``exp(b (x - 1)), exp(-b x), cos b x, sin b x``; unit mean square."""
    b = root(ends, k)
    rows = []
    for end, at in zip(ends.split("-"), (0.0, 1.0), strict=True):
        rows += [_terms(b, np.array([at]), order)[:, 0] / b**order for order in CONDITIONS[end]]
    c = np.linalg.svd(np.array(rows))[2][-1]
    x, w = np.polynomial.legendre.leggauss(4 * k + 16)
    values = c @ _terms(b, 0.5 * (1.0 + x), 0)
    c = c / np.sqrt(0.5 * w @ values**2)
    # positive sign at the first maximum
    return np.asarray(c * np.sign((c @ _terms(b, np.linspace(0.0, 0.9 / k, 9), 0)).sum()))


def _terms(b: float, x: Array, order: int) -> Array:
    turn = b * x + 0.5 * np.pi * order
    return np.asarray(
        b**order
        * np.stack(
            [np.exp(b * (x - 1.0)), (-1.0) ** order * np.exp(-b * x), np.cos(turn), np.sin(turn)]
        )
    )


def eigenfunction(ends: str, k: int, x: Array, order: int = 0) -> Array:
    """Return a derivative of an eigenfunction of an Euler-Bernoulli beam.

    ``w'''' = (beta L)^4 w`` for ``x`` from 0 to 1, with ``int w^2 dx = 1``.

    Parameters
    ----------
    ends : str
        Ends, such as ``"clamped-free"``.
    k : int
        Number, from 1.
    x : array
        Position / length.
    order : int
        Order of the derivative.
    """
    return np.asarray(_coefficients(ends, k) @ _terms(root(ends, k), np.atleast_1d(x), order))


class LineFamily(Family):
    """Functions of the position along an axis of the part, for bending, stretch and twist."""

    axis: Choice = field(
        "Axis along which the functions vary", words=("x", "y", "z"), default="x", kw_only=True
    )
    across: Choice = field(
        "Direction of bending; None for both directions across the axis",
        words=("both", "x", "y", "z"),
        default="both",
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report bending along the axis itself, and a family without functions."""
        if self.across == self.axis:
            problems.add(
                where,
                f"across is '{self.across}', the same as axis; give another direction",
                "across",
            )
        if not any(self.counts):
            problems.add(where, "has no function: give a number for bending, stretch or twist")

    if TYPE_CHECKING:

        @property
        def counts(self) -> tuple[int, int, int]: ...  # noqa: D102
        def curves(self, kind: str) -> list[Curve]: ...  # noqa: D102

    def columns(self, part: Part) -> Columns:
        """Return the functions at the nodes of a part."""
        names: list[str] = []
        found: list[Array] = []
        a, tag = "xyz".index(self.axis), type(self).tag
        across = [d for d in range(3) if d != a and self.across in ("both", "xyz"[d])]
        for kind in ("bending", "stretch", "twist"):
            for d in across if kind == "bending" else (a,):
                for k, curve in enumerate(self.curves(kind), start=1):
                    names.append(f"{tag} {kind} {k} along {'xyz'[d]}")
                    found.append(self._moved(part, curve, kind, d))
        return Columns(tuple(names), np.stack(found, axis=2))

    def _moved(self, part: Part, curve: Curve, kind: str, d: int) -> Array:
        """Return displacements (nn, dofs); sections stay plane and, in bending, rotate by w'."""
        a = "xyz".index(self.axis)
        x = part.nodes[:, a]
        length = float(np.ptp(x))
        if not length > 0.0:
            message = (
                f"has no extent along {self.axis}, the axis of the shape functions; choose "
                f"another axis"
            )
            raise InputError(Problem(f"part '{part.name}'", message))
        s = (x - x.min()) / length
        w = curve(s, 0)[:, None] * np.eye(3)[d]
        moved, turn = (np.zeros(w.shape), w / length) if kind == "twist" else (w, np.zeros(w.shape))
        if kind == "bending":
            turn = np.cross(np.eye(3)[a], np.eye(3)[d]) * (curve(s, 1) / length)[:, None]
        arm = part.nodes - part.center
        arm[:, a] = 0.0
        moved = moved + np.cross(turn, arm)
        return np.concatenate([moved, turn], axis=1) if part.dofs_per_node == 6 else moved


class BeamFunctions(LineFamily, tag="beam"):
    """Eigenfunctions of an Euler-Bernoulli beam, in closed form.

    ``w(x) = A cosh bx + B sinh bx + C cos bx + D sin bx`` where b are the zeros of the
    characteristic function, such as ``cos bL cosh bL + 1`` for a clamped and a free end. Sections
    stay plane: a point off the axis through the centre of mass moves along the axis by ``-y w'``.
    Stretch and twist are described by sines and cosines of a rod with the same ends; a pinned end
    is fixed for both.

    Rigid motions are described by the body frame, for any ends. With functions clamped at both
    ends, one end cannot rotate relative to the other; at a pinned or free end the bending moment is
    zero. Choose ends of the functions that correspond to the joints, or free ends.

    Raises
    ------
    InputError
        If the ends are unknown, or there is no function, or more than 60.

    Examples
    --------
    >>> BeamFunctions("free-free", 4, axis="x", across="y").ends
    'free-free'
    """

    ends: Choice = field("Ends at the lower and the upper end of the axis", words=ENDS)
    bending: Whole = field("Number of functions per direction of bending", least=0)
    stretch: Whole = field("Number of functions of stretch along the axis", least=0, default=0)
    twist: Whole = field("Number of functions of twist about the axis", least=0, default=0)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report numbers of functions out of range."""
        super().consistent(problems, where)
        if max(self.counts) > MOST:
            problems.add(where, f"has {max(self.counts)} functions of a kind, at most {MOST}")

    @property
    def counts(self) -> tuple[int, int, int]:
        """Numbers of functions in bending, stretch and twist."""
        return self.bending, self.stretch, self.twist

    def curves(self, kind: str) -> list[Curve]:
        """Return functions of (position / length, order of the derivative) for a kind of motion."""
        if kind == "bending":
            return [partial(eigenfunction, self.ends, k + 1) for k in range(self.bending)]
        count = self.stretch if kind == "stretch" else self.twist
        held = tuple(end != "free" for end in self.ends.split("-"))
        return [partial(_rod, held, k + 1) for k in range(count)]


def _rod(held: tuple[bool, ...], k: int, x: Array, order: int = 0) -> Array:
    """Return an eigenfunction of a rod: a sine if the first end is fixed, else a cosine."""
    b = np.pi * (k if held[0] == held[1] else k - 0.5)
    turn = b * x + 0.5 * np.pi * (order - 1 if held[0] else order)
    return np.asarray(b**order * np.cos(turn))


class Splines(LineFamily, tag="splines"):
    """B-splines over the length of the part (de Boor), with uniform knots.

    They span all polynomials up to the degree, rigid motions included. Sections stay
    plane, as with `BeamFunctions`.

    Raises
    ------
    InputError
        If there are no functions, or fewer than degree + 1.

    Examples
    --------
    >>> Splines(8, degree=4).degree
    4
    """

    whole: ClassVar[bool] = True
    bending: Whole = field("Number of functions per direction of bending", least=0)
    stretch: Whole = field("Number of functions of stretch along the axis", least=0, default=0)
    twist: Whole = field("Number of functions of twist about the axis", least=0, default=0)
    degree: Whole = field("Degree of the polynomials between two knots", least=2, default=3)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report numbers of functions and degrees out of range."""
        super().consistent(problems, where)
        for count in self.counts:
            if 0 < count <= self.degree:
                message = (
                    f"has {count} functions of degree {self.degree}, at least {self.degree + 1}"
                )
                problems.add(where, message)
                break
        if max(self.counts) > MOST or self.degree > MOST_DEGREE:
            problems.add(
                where,
                f"has {max(self.counts)} functions of a kind and degree {self.degree}, at most "
                f"{MOST} and {MOST_DEGREE}",
            )

    @property
    def counts(self) -> tuple[int, int, int]:
        """Numbers of functions in bending, stretch and twist."""
        return self.bending, self.stretch, self.twist

    def curves(self, kind: str) -> list[Curve]:
        """Return functions of (position / length, order of the derivative) for a kind of motion."""
        count = dict(zip(("bending", "stretch", "twist"), self.counts, strict=True))[kind]
        if not count:
            return []
        inner = np.linspace(0.0, 1.0, count - self.degree + 1)
        knots = np.concatenate([np.zeros(self.degree), inner, np.ones(self.degree)])
        return [partial(_spline, knots, self.degree, row) for row in np.eye(count)]


def _spline(knots: Array, degree: int, row: Array, x: Array, order: int = 0) -> Array:
    return np.asarray(BSpline(knots, row, degree)(x, nu=order))
