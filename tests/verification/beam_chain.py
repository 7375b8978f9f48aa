"""A plain NumPy statement of the static spatial beam element, and closed forms of elastic curves.

The chain shares no formula with the engine but the definition of the strains: it differentiates the
strain energy numerically (complex steps for forces, differences of these for the tangent). Nothing
here imports jousto.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize as opt
import scipy.sparse as sp
import scipy.sparse.linalg as spl
import scipy.special as sf
from numpy.typing import NDArray

Array = NDArray[np.float64]
E1 = np.array([1.0, 0.0, 0.0])
STEP = 1e-30  # complex step
NUDGE = 1e-6  # difference of gradients, rad and lengths of an element


def times(a: NDArray, b: NDArray) -> NDArray:
    """Product of quaternions, scalar first, over leading axes."""
    v = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    s = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    return np.concatenate([s, v], axis=-1)


def inverse(a: NDArray) -> NDArray:
    return a * np.array([1.0, -1.0, -1.0, -1.0])


def matrix(a: NDArray) -> NDArray:
    """Rotation matrices (..., 3, 3) of unit quaternions."""
    s, x, y, z = np.moveaxis(a, -1, 0)
    rows = [
        [s * s + x * x - y * y - z * z, 2 * (x * y - s * z), 2 * (x * z + s * y)],
        [2 * (x * y + s * z), s * s - x * x + y * y - z * z, 2 * (y * z - s * x)],
        [2 * (x * z - s * y), 2 * (y * z + s * x), s * s - x * x - y * y + z * z],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def exponential(v: NDArray) -> NDArray:
    """Unit quaternion of a rotation vector; analytic, also at 0."""
    x = np.sum(v * v, axis=-1, keepdims=True) / 4.0  # square of the half angle
    small = np.abs(x) < 1e-4
    root = np.sqrt(np.where(small, 1.0, x))
    cos = np.where(small, 1 - x / 2 + x * x / 24 - x**3 / 720, np.cos(root))
    sinc = np.where(small, 1 - x / 6 + x * x / 120 - x**3 / 5040, np.sin(root) / root)
    return np.concatenate([cos, v * sinc / 2.0], axis=-1)


def logarithm(a: NDArray) -> NDArray:
    """Rotation vector of a unit quaternion, below half a turn; analytic, also at 0."""
    a = a * np.where(a[..., :1].real < 0.0, -1.0, 1.0)
    s, v = a[..., :1], a[..., 1:]
    x = np.sum(v * v, axis=-1, keepdims=True) / (s * s)  # square of the tangent of the half angle
    small = np.abs(x) < 1e-4
    root = np.sqrt(np.where(small, 1.0, x))
    # the derivative by hand: the arc tangent of a complex number loses a step of 1e-30
    arc = np.arctan(root.real) + 1j * root.imag / (1.0 + root.real**2)
    ratio = np.where(small, 1 - x / 3 + x * x / 5 - x**3 / 7, arc / root)
    return 2.0 * ratio * v / s if np.iscomplexobj(a) else (2.0 * ratio * v / s).real


def strains(
    ra: NDArray, qa: NDArray, rb: NDArray, qb: NDArray, length: Array, *, helical: bool = False
) -> NDArray:
    """Strains ``[Gamma, kappa]`` of elements, without those of the unstressed shape.

    ``Gamma = d - e1``, ``d = Q_m^T (r_b - r_a)/L`` with the middle frame; of a screw motion
    between the ends d is divided across the rotation vector phi by ``sin(|phi|/2)/(|phi|/2)``.
    """
    phi = logarithm(times(inverse(qa), qb))
    middle = times(qa, exponential(phi / 2.0))
    chord = (rb - ra) / length[:, None]
    d = np.einsum("...ji,...j->...i", matrix(middle), chord)
    if helical:
        x = np.sum(phi * phi, axis=-1, keepdims=True) / 4.0
        small = np.abs(x) < 1e-3
        root = np.sqrt(np.where(small, 1.0, x))
        # (root/sin(root) - 1)/x
        c = 1 / 6 + 7 * x / 360 + 31 * x**2 / 15120 + 127 * x**3 / 604800
        c = np.where(small, c, (root / np.sin(root) - 1.0) / np.where(small, 1.0, x))
        d = d + c * (x * d - phi * np.sum(phi * d, axis=-1, keepdims=True) / 4.0)
    return np.concatenate([d - E1, phi / length[:, None]], axis=-1)


@dataclass
class Chain:
    """A cantilever of beam elements, the first node held: r (n, 3), q (n, 4), lengths, C (6, 6).

    With `helical` the strains are those of a screw motion between the ends (see `strains`), with
    `bending` the flexibility in shear gains the residual bending flexibility of an element.
    """

    r: Array
    q: Array
    length: Array
    C: Array
    helical: bool = False
    bending: bool = False

    def __post_init__(self) -> None:
        self.e0 = self.strain()
        if self.bending:
            S = np.linalg.inv(self.C)
            h = self.length[0] ** 2 / 12.0
            # the y force bends about z, the z force about y
            S[1, 1] += h * S[5, 5]
            S[2, 2] += h * S[4, 4]
            self.C = np.linalg.inv(S)

    def strain(self) -> Array:
        """Strains (ne, 6) of the present shape."""
        ends = self.r[:-1], self.q[:-1], self.r[1:], self.q[1:]
        return strains(*ends, self.length, helical=self.helical)

    def resultants(self) -> Array:
        """N, Qy, Qz, Mx, My, Mz of each element, section axes."""
        return (self.strain() - self.e0) @ self.C

    def gradient(self, d: Array) -> Array:
        """Derivative of the energies by the 12 increments of each element, at d (..., ne, 12)."""
        steps = 1j * STEP * np.eye(12)[(slice(None), *[None] * (d.ndim - 1), slice(None))]
        x = d[None] + steps
        ra, rb = self.r[:-1] + x[..., :3], self.r[1:] + x[..., 6:9]
        qa = times(self.q[:-1], exponential(x[..., 3:6]))
        qb = times(self.q[1:], exponential(x[..., 9:]))
        e = strains(ra, qa, rb, qb, self.length, helical=self.helical) - self.e0
        energy = 0.5 * self.length * np.einsum("...i,ij,...j->...", e, self.C, e)
        return np.moveaxis(energy.imag / STEP, 0, -1)

    def forces(self) -> tuple[Array, Array]:
        """Inner forces (ne, 12) and their tangents (ne, 12, 12)."""
        ne = len(self.length)
        size = np.tile([self.length.min()] * 3 + [1.0] * 3, 2) * NUDGE
        nudges = np.concatenate([np.diag(size), -np.diag(size)])
        both = self.gradient(np.repeat(nudges[:, None], ne, axis=1))  # (24, ne, 12)
        tangent = (both[:12] - both[12:]) / (2.0 * size)[:, None, None]
        return self.gradient(np.zeros((ne, 12))), np.moveaxis(tangent, 0, 1)

    def solve(
        self, force: Array, torque: Array | None = None, *, steps: int = 1, follow: bool = False
    ) -> list[float]:
        """Newton's iteration under an end load, dead or following; norms of the last step."""
        n = len(self.r)
        torque = np.zeros(3) if torque is None else torque
        norms: list[float] = []
        for factor in np.arange(1, steps + 1) / steps:
            norms = []
            for _ in range(60):
                inner, tangent = self.forces()
                residual = np.zeros(6 * n)
                for k in (0, 1):
                    np.add.at(
                        residual,
                        6 * np.arange(n - 1)[:, None] + 6 * k + np.arange(6),
                        inner[:, 6 * k : 6 * k + 6],
                    )
                Q = matrix(self.q[-1])
                f, m = factor * np.asarray(force, float), factor * np.asarray(torque, float)
                local = m if follow else Q.T @ m
                residual[-6:-3] -= Q @ f if follow else f
                residual[-3:] -= local
                rows = (6 * np.arange(n - 1)[:, None] + np.arange(12))[:, :, None]
                rows = np.broadcast_to(rows, tangent.shape)
                K = sp.coo_matrix(
                    (tangent.ravel(), (rows.ravel(), np.swapaxes(rows, 1, 2).ravel())),
                    shape=(6 * n, 6 * n),
                ).tolil()
                # in exponential coordinates: half of d(Q^T m) = (Q^T m) x dtheta is in their own
                # turn, which a following moment has alone;  d(Q f) = -Q f~ dtheta
                K[-3:, -3:] -= (-0.5 if follow else 0.5) * skew(local)
                if follow:
                    K[-6:-3, -3:] += Q @ skew(f)
                norms.append(float(np.abs(residual[6:]).max()))
                step = spl.spsolve(K.tocsc()[6:, 6:], -residual[6:]).reshape(-1, 6)
                # large turns are cut: the first iterations are far away
                cut = min(1.0, 1.0 / max(np.abs(step[:, 3:]).max(), 1e-300))
                self.r[1:] += cut * step[:, :3]
                self.q[1:] = times(self.q[1:], exponential(cut * step[:, 3:]))
                self.q[1:] /= np.linalg.norm(self.q[1:], axis=1, keepdims=True)
                if np.abs(step[:, 3:]).max() < 1e-9:
                    break
        return norms


def skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def straight(length: float, elements: int, C: Array) -> Chain:
    """A straight cantilever along x."""
    r = np.outer(np.linspace(0.0, length, elements + 1), E1)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (elements + 1, 1))
    return Chain(r, q, np.full(elements, length / elements), C)


def bend(radius: float, angle: float, elements: int, C: Array) -> Chain:
    """A cantilever on a circular arc that leaves along x and turns towards y."""
    t = np.linspace(0.0, angle, elements + 1)
    r = radius * np.stack([np.sin(t), 1.0 - np.cos(t), 0.0 * t], axis=1)
    q = np.stack([np.cos(t / 2), 0.0 * t, 0.0 * t, np.sin(t / 2)], axis=1)
    return Chain(r, q, np.full(elements, radius * angle / elements), C)


# --- closed forms ---------------------------------------------------------------------------------


def elastica(load: float) -> tuple[float, float, float]:
    """End deflection w/L, shortening u/L, slope (rad) of a cantilever under ``P L^2/(E I)`` across.

    Bisshopp and Drucker (1945), Quarterly of Applied Mathematics 3, 272-275:
    ``sqrt(P L^2/E I) = K(k) - F(phi1, k)``, ``sin phi1 = 1/(k sqrt 2)``.
    """

    def phi1(m: float) -> float:
        return float(np.arcsin(1.0 / np.sqrt(2.0 * m)))

    def miss(m: float) -> float:
        return float(sf.ellipk(m) - sf.ellipkinc(phi1(m), m) - np.sqrt(load))

    m = float(opt.brentq(miss, 0.5 + 1e-15, 1.0 - 1e-14, xtol=1e-16, rtol=1e-15))
    slope = float(np.arcsin(2.0 * m - 1.0))
    w = 1.0 - 2.0 * (sf.ellipe(m) - sf.ellipeinc(phi1(m), m)) / np.sqrt(load)
    return float(w), float(1.0 - np.sqrt(2.0 * np.sin(slope) / load)), slope


def buckled(end: float) -> tuple[float, float, float]:
    """Load over the critical one, end position x/L and y/L of a buckled cantilever column.

    Euler's elastica with end slope ``end`` (rad): Timoshenko and Gere, *Theory of Elastic
    Stability* (1961), section 2.7: ``P L^2/E I = K^2``, ``k = sin(end/2)``, ``x = 2 E/K - 1``,
    ``y = 2 k/K``.
    """
    k = np.sin(end / 2.0)
    K, E = sf.ellipk(k * k), sf.ellipe(k * k)
    return float((2.0 * K / np.pi) ** 2), float(2.0 * E / K - 1.0), float(2.0 * k / K)


def helix(moment: Array, stiffness: float, s: float) -> Array:
    """Point at arc length s of a rod bent by a dead moment alone: isotropic bending, no force.

    The tangent turns about the moment, ``t' = M x t / E I``, whatever the torsional stiffness
    (Love, *Mathematical Theory of Elasticity*, section 270): a helix about the moment, which leaves
    the origin along x.
    """
    rate = float(np.linalg.norm(moment)) / stiffness
    n = np.asarray(moment) / np.linalg.norm(moment)
    along = n * n[0]
    across = E1 - along
    return (
        along * s
        + across * np.sin(rate * s) / rate
        + np.cross(n, across) * (1.0 - np.cos(rate * s)) / rate
    )


def lateral() -> float:
    """``P L^2/sqrt(E I G J)`` at which a deep cantilever with an end load at its axis tips over.

    The first zero of ``J_{-1/4}(P L^2 / 2 sqrt(E I G J))``: Timoshenko and Gere (1961), section
    6.3, 4.013.
    """
    return 2.0 * float(opt.brentq(lambda x: sf.jv(-0.25, x), 1.5, 2.5, xtol=1e-14))
