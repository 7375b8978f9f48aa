"""Exact derivatives of functions of coordinates, for couplings given as a function.

Forward differentiation (A. Griewank, A. Walther, *Evaluating Derivatives*, SIAM 2008, chapter 13):
the function is evaluated with truncated Taylor polynomials in place of numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Jet:
    """Polynomial in s and t, truncated after s and t^2: ``sum c[i, j] s^i t^j``.

    NumPy calls the method `sin` of each entry of an array of jets, so that ``np.sin(q[2])`` works.

    Parameters
    ----------
    c : (2, 3, k) array
        Coefficients of k polynomials; may be complex.

    Examples
    --------
    The first three coefficients of 1/t about t = 1/2:

    >>> t = Jet(np.array([[[0.5], [1.0], [0.0]], [[0.0], [0.0], [0.0]]]))
    >>> print((1 / t).c[0, :, 0])
    [ 2. -4.  8.]
    """

    __slots__ = ("c",)

    def __init__(self, c: Array) -> None:
        self.c = c

    def _apply(self, *g: Any) -> Jet:
        """Return a function of this jet from its value and three derivatives g at c[0, 0]."""
        d = Jet(self.c.copy())
        d.c[0, 0] = 0.0
        # Taylor series up to the third power of the increment, by Horner's scheme
        third = d.__mul__(g[3] / 6).__add__(g[2] / 2)
        return third.__mul__(d).__add__(g[1]).__mul__(d).__add__(g[0])

    def __add__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.c + other.c)
        c = self.c.astype(np.result_type(self.c, other))
        c[0, 0] += other
        return Jet(c)

    def __neg__(self) -> Jet:
        return Jet(-self.c)

    def __sub__(self, other: Any) -> Jet:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Jet:
        return self.__neg__().__add__(other)

    def __mul__(self, other: Any) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.c * other)
        a, b = self.c, other.c
        return Jet(np.stack([_times(a[0], b[0]), _times(a[0], b[1]) + _times(a[1], b[0])]))

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: Any) -> Jet:
        return self.__mul__(other**-1.0)

    def __rtruediv__(self, other: Any) -> Jet:
        return self.__pow__(-1.0).__mul__(other)

    def __pow__(self, n: float) -> Jet:
        if n >= 0 and float(n).is_integer():
            power = self * 0.0 + 1.0
            for _ in range(int(n)):
                power = power * self
            return power
        x = self.c[0, 0]
        d3 = n * (n - 1) * (n - 2) * x ** (n - 3.0)
        return self._apply(x**n, n * x ** (n - 1.0), n * (n - 1) * x ** (n - 2.0), d3)

    def sin(self) -> Jet:
        """Return the sine."""
        s, c = np.sin(self.c[0, 0]), np.cos(self.c[0, 0])
        return self._apply(s, c, -s, -c)

    def cos(self) -> Jet:
        """Return the cosine."""
        s, c = np.sin(self.c[0, 0]), np.cos(self.c[0, 0])
        return self._apply(c, -s, -c, s)

    def tan(self) -> Jet:
        """Return the tangent."""
        return self.sin().__truediv__(self.cos())

    def exp(self) -> Jet:
        """Return the exponential."""
        e = np.exp(self.c[0, 0])
        return self._apply(e, e, e, e)

    def log(self) -> Jet:
        """Return the natural logarithm."""
        x = self.c[0, 0]
        return self._apply(np.log(x), 1 / x, -1 / x**2, 2 / x**3)

    def sqrt(self) -> Jet:
        """Return the square root."""
        return self.__pow__(0.5)

    def arctan(self) -> Jet:
        """Return the inverse tangent."""
        x = self.c[0, 0]
        w = 1 / (1 + x * x)
        return self._apply(np.arctan(x), w, -2 * x * w * w, (6 * x * x - 2) * w**3)


def _times(a: Array, b: Array) -> Array:
    """Return the product of two polynomials in t."""
    return np.stack(
        [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0]]
    )


def derivatives(
    f: Callable[[Array], Any], q: Array, along: Array, c1: Array, c2: Array
) -> tuple[Array, Array, Array]:
    """Return derivatives of f in given directions, as polynomials in t along paths.

    Parameters
    ----------
    f : function
        Function of coordinates (n,) that returns values (m,), written with NumPy.
    q : (n,) array
        Coordinates.
    along : (k, n) array
        Directions of the first derivative.
    c1, c2 : (k, n) array
        Path ``q + c1 t + c2 t^2`` for each direction.

    Returns
    -------
    (k, m) arrays
        Coefficients of 1, t and t^2 of the derivative of f along each direction.
    """
    k, n = along.shape
    kind = np.result_type(q, along, c1, c2, float)
    jets = np.empty(n, dtype=object)
    for i in range(n):
        c = np.zeros((2, 3, k), dtype=kind)
        c[0, 0], c[0, 1], c[0, 2], c[1, 0] = q[i], c1[:, i], c2[:, i], along[:, i]
        jets[i] = Jet(c)
    values = list(np.ravel(np.asarray(f(jets), dtype=object)))
    out = np.zeros((3, k, len(values)), dtype=kind)
    for i, value in enumerate(values):
        # values that are not jets are constants, with zero derivatives
        if isinstance(value, Jet):
            out[:, :, i] = value.c[1]
    return out[0], out[1], out[2]
