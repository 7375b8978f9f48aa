"""Exact and discrete vibrations of shear-flexible beams and rings, and a chain of rigid links.

The beam theory is Timoshenko's, ``N = EA e, Q = GA g, M = EI k`` with mass and rotary inertia per
length; in a circular arch of radius R, with u along the axis, w outward and the rotation f,

``e = u' + w/R,  g = w' - u/R - f,  k = f'``.

The references here share no formula with the engine: exact solutions of the differential equations,
and, for a simply supported chain of two-node elements with one integration point, its dispersion
relation by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh, expm
from scipy.optimize import brentq

from verification.minimal import Array


@dataclass(frozen=True)
class Line:
    """Stiffness and inertia of a section that bends alike in both directions, SI units."""

    EA: float
    GA: float
    GJ: float
    EI: float
    mass: float
    polar: float
    rotary: float

    @property
    def stiffness(self) -> Array:
        """Section stiffness (6, 6)."""
        return np.diag([self.EA, self.GA, self.GA, self.GJ, self.EI, self.EI])

    @property
    def inertia(self) -> Array:
        """Rotary inertia per length (3, 3)."""
        return np.diag([self.polar, self.rotary, self.rotary])


# -- exact frequencies by transfer matrices --------------------------------------------------------

# which of u, w, f, N, Q, M vanish at an end
ENDS = {"clamped": (0, 1, 2), "free": (3, 4, 5), "pinned": (0, 1, 5), "roller": (3, 1, 5)}


def frequencies(
    line: Line, length: float, ends: tuple[str, str], count: int, radius: float = np.inf
) -> Array:
    """First `count` angular frequencies, rad/s, in the plane, of a beam or circular arch.

    The determinant of what the starting end leaves free and the other end wants to vanish, over
    the exponential of ``y' = A(w) y``, ``y = [u, w, f, N, Q, M]``, changes its sign at each.
    """
    k = 0.0 if np.isinf(radius) else 1 / radius
    free = [i for i in range(6) if i not in ENDS[ends[0]]]
    zero = list(ENDS[ends[1]])

    def misfit(omega: float) -> float:
        A = np.zeros((6, 6))
        A[0, 3], A[0, 1] = 1 / line.EA, -k
        A[1, 4], A[1, 0], A[1, 2] = 1 / line.GA, k, 1.0
        A[2, 5] = 1 / line.EI
        A[3, 0], A[3, 4] = -(omega**2) * line.mass, -k
        A[4, 1], A[4, 3] = -(omega**2) * line.mass, k
        A[5, 2], A[5, 4] = -(omega**2) * line.rotary, -1.0
        # forces in units of EI over powers of the length, so that the numbers are alike
        unit = np.array([1, 1, 1 / length, *line.EI / length ** np.array([3.0, 3.0, 2.0])])
        T = expm(A * length * unit / unit[:, None])
        return float(np.linalg.det(T[np.ix_(zero, free)]))

    found: list[float] = []
    # the lowest bending frequency sets the pace of the search
    step = 0.05 * np.sqrt(line.EI / line.mass) / length**2 * 3.5
    a, fa = 0.3 * step, misfit(0.3 * step)
    while len(found) < count:
        b = a + step * max(1.0, np.sqrt(a / step) / 4)
        fb = misfit(b)
        if fa * fb < 0:
            found.append(float(brentq(misfit, a, b, xtol=1e-12 * b)))
        a, fa = b, fb
    return np.array(found)


def ring(line: Line, radius: float, waves: int) -> Array:
    """The three frequencies, rad/s, of a free ring in its plane with a number of waves."""
    n, r = waves, radius
    # strains of u = U sin, w = W cos, f = F sin of n s/R
    e, g, k = np.array([n / r, 1 / r, 0]), np.array([-1 / r, -n / r, -1.0]), np.array([0, 0, n / r])
    K = line.EA * np.outer(e, e) + line.GA * np.outer(g, g) + line.EI * np.outer(k, k)
    squares = eigh(K, np.diag([line.mass, line.mass, line.rotary]), eigvals_only=True)
    return np.sqrt(squares)


# -- simply supported: exact and discrete, at rest and spinning ------------------------------------


def whirls(
    line: Line,
    length: float,
    wave: int,
    spin: float = 0.0,
    *,
    elements: int | None = None,
    share: float = 0.0,
    bending: bool = False,
) -> Array:
    """Whirling frequencies (4,), rad/s, in the world; positive ones go with the spin.

    With W and F of ``w = W sin k x``, ``f = F cos k x`` (complex: both planes) the equations are

    ``GA k (k W - F) = m w^2 W``, ``EI k^2 F - GA (k W - F) + Jp W0 w F = J w^2 F``.

    A chain of n elements has ``2 sin(a)/h`` in place of k, ``F cos a`` in place of F in the shear,
    ``a = k h/2``, and, with its share s of the consistent mass, masses smaller by
    ``1 - 2/3 s sin^2 a``; the spin meets the row sums of the inertia, which are those of the
    lumped one.
    """
    k, c, f, GA = wave * np.pi / length, 1.0, 1.0, line.GA
    if elements is not None:
        h = length / elements
        a = 0.5 * k * h
        k, c, f = 2 * np.sin(a) / h, np.cos(a), 1 - 2 / 3 * share * np.sin(a) ** 2
        if bending:
            GA = 1 / (1 / GA + h**2 / (12 * line.EI))
    K = np.array([[GA * k * k, -GA * k * c], [-GA * k * c, GA * c * c + line.EI * k * k]])
    M = f * np.diag([line.mass, line.rotary])
    G = np.diag([0.0, line.polar * spin])
    # K x + w G x - w^2 M x = 0 as a pencil of twice the size
    Mi = np.linalg.inv(M)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [Mi @ K, Mi @ G]])
    return np.sort(np.linalg.eigvals(A).real)


def rods(line: Line, length: float, count: int, **chain: float) -> tuple[Array, Array]:
    """Frequencies of stretching and twisting, rad/s, one end held, the other free."""
    k = (2 * np.arange(1, count + 1) - 1) * np.pi / (2 * length)
    f: Array | float = 1.0
    if chain:
        h = length / chain["elements"]
        a = 0.5 * k * h
        k, f = 2 * np.sin(a) / h, 1 - 2 / 3 * chain["share"] * np.sin(a) ** 2
    scale = k / np.sqrt(f)
    return np.sqrt(line.EA / line.mass) * scale, np.sqrt(line.GJ / line.polar) * scale


# -- reference in the large: rigid links and springs -----------------------------------------------


@dataclass(frozen=True)
class Links:
    """Hencky's chain of n rigid links in a plane with springs EI/h, in absolute angles.

    It converges with h^2 to the inextensible beam without shear; angles are not approximated.
    """

    n: int
    length: float
    EI: float
    mass: float
    rotary: float = 0.0
    clamped: bool = True

    def tip(self, times: Array, load: Callable[[float, Array], Array], start: float = 0.0) -> Array:
        """Tip (nt, 2), from rest along the angle `start`; `load(t, f)`: generalised forces."""
        n, h = self.n, self.length / self.n
        k = np.arange(n)
        beyond = n - 1 - np.maximum.outer(k, k)
        C = self.mass * h**3 * (beyond + np.where(np.eye(n) > 0, 1 / 3, 1 / 2))
        C += np.diag(np.full(n, self.rotary * h))
        D = np.eye(n) - np.eye(n, k=-1)
        springs = np.full(n, self.EI / h)
        springs[0] *= 2.0 if self.clamped else 0.0
        K = D.T @ (springs[:, None] * D)

        def rate(t: float, y: Array) -> Array:
            f, w = y[:n], y[n:]
            d = f[:, None] - f[None, :]
            Q = load(t, f) - (C * np.sin(d)) @ w**2 - K @ (f - start)
            return np.concatenate([w, np.linalg.solve(C * np.cos(d), Q)])

        y0 = np.concatenate([np.full(n, start), np.zeros(n)])
        span = (0.0, float(times[-1]))
        done = solve_ivp(rate, span, y0, "DOP853", t_eval=times, rtol=1e-8, atol=1e-9)
        assert done.success
        f = done.y[:n].T
        return h * np.stack([np.cos(f).sum(axis=1), np.sin(f).sum(axis=1)], axis=-1)

    def weight(self, g: float) -> Callable[[float, Array], Array]:
        """Gravity along -y."""
        h = self.length / self.n
        arm = self.mass * g * h**2 * (self.n - 0.5 - np.arange(self.n))
        return lambda _t, f: -arm * np.cos(f)
