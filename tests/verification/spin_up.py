"""Spin-up of a slender beam: data, a chain of rigid links as its reference, and jousto's models.

Kane, Ryan and Banerjee, "Dynamics of a cantilever beam attached to a moving base", Journal of
Guidance 10 (1987) 139-151, and Wu and Haug, "Geometric non-linear substructuring for dynamics of
flexible mechanical systems", IJNME 26 (1988) 2211-2226, posed the problem: a linear beam in a
floating frame diverges as it is spun up, although a real one is stretched straight. The data are
those of Simo and Vu-Quoc, CMAME 66 (1988) 125-161, as given in the Ansys verification manual,
VM258: EA = 2.8e7 N, EI = 1.4e4 N m2, GA = 1e7 N, 1.2 kg/m, here with a length of 10 m, spun up in
15 s to 6 rad/s. In the end the stretch is ``rho A w^2 L^3/(3 E A)`` = 5.14e-4 m. No table of their
deflection was at hand; the chain of links below is the reference.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

import jousto as jo
from verification.minimal import Array

L, EA, EI, GA, LINE_MASS, LINE_INERTIA = 10.0, 2.8e7, 1.4e4, 1e7, 1.2, 6e-4
T, SPEED = 15.0, 6.0
E, A = 2.8e10, 1e-3  # any two with this product
MATERIAL = jo.Material(E=E, nu=0.4, rho=LINE_MASS / A)
# stiffer out of plane, so that its modes do not come in pairs
SECTION = jo.sections.GeneralSection(A=A, Iy=4 * EI / E, Iz=EI / E, J=2 * EI / E, ky=1.0, kz=1.0)
STRETCH = LINE_MASS * SPEED**2 * L**3 / (3 * EA)

# -- the turn of the root --------------------------------------------------------------------------


def turn(t: Array, speed: float = SPEED) -> tuple[Array, Array, Array]:
    """Angle, rate, acceleration: ``speed/T (t^2/2 + (T/2 pi)^2 (cos(2 pi t/T) - 1))`` until T."""
    c, x = T / (2 * np.pi), 2 * np.pi * np.minimum(t, T) / T
    u = np.minimum(t, T)
    angle = speed / T * (u**2 / 2 + c**2 * (np.cos(x) - 1)) + speed * np.maximum(t - T, 0)
    return angle, speed / T * (u - c * np.sin(x)), speed / T * (1 - np.cos(x)) * (t < T)


def signal(speed: float = SPEED) -> jo.mechanism.Sum:
    """The same angle."""
    u = jo.Ramp(0.0, T, 0.0, T)
    wave = jo.Step(T, 1.0, 0.0) * jo.Harmonic(frequency=1 / T, phase=np.pi / 2, offset=-1.0)
    rest = jo.Ramp(T, 2 * T, 0.0, speed * T)
    return speed / (2 * T) * (u * u) + speed * T / (2 * np.pi) ** 2 * wave + rest


def seen(tip: Array, angle: Array) -> Array:
    """Displacement (..., 2) of the tip along the root's axes, from its world position (..., 3)."""
    x, y = tip[..., 0], tip[..., 1]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x + s * y - L, c * y - s * x], axis=-1)


# -- reference: rigid links and springs ------------------------------------------------------------


def links(n: int, times: Array, speed: float = SPEED) -> Array:
    """Tip (nt, 2) along the root's axes of n rigid links with springs EI/h at their joints.

    Hencky's chain, without approximation of the angles; the clamp is half a link away (2 EI/h).
    It converges with h^2 to the inextensible beam without shear. In absolute angles f

    ``sum_j C_ij (cos(f_i - f_j) f_j'' + sin(f_i - f_j) f_j'^2) = -dV/df_i``.
    """
    h = L / n
    k = np.arange(n)
    beyond = n - 1 - np.maximum.outer(k, k)  # links farther out than both
    C = LINE_MASS * h**3 * (beyond + np.where(np.eye(n) > 0, 1 / 3, 1 / 2))
    C += np.diag(np.full(n, LINE_INERTIA * h))
    D = np.eye(n) - np.eye(n, k=-1)
    springs = np.full(n, EI / h)
    springs[0] *= 2
    K = D.T @ (springs[:, None] * D)

    def rate(t: float, y: Array) -> Array:
        bend, bend_rate = y[:n], y[n:]  # against the root
        _, w, alpha = turn(np.asarray(t), speed)
        difference = bend[:, None] - bend[None, :]
        M = C * np.cos(difference)
        Q = -(C * np.sin(difference)) @ (w + bend_rate) ** 2 - K @ bend
        return np.concatenate([bend_rate, np.linalg.solve(M, Q) - alpha])

    done = solve_ivp(
        rate, (0, times[-1]), np.zeros(2 * n), "DOP853", t_eval=times, rtol=1e-7, atol=1e-9
    )
    assert done.success
    f = done.y[:n].T
    return np.stack([h * np.cos(f).sum(axis=1) - L, h * np.sin(f).sum(axis=1)], axis=-1)


# -- jousto ----------------------------------------------------------------------------------------


def beam(pieces: int, modes: int, *, stiffening: bool = True, speed: float = SPEED) -> jo.Mechanism:
    """The beam as bodies fixed together, on a driven pin."""
    ends = ("start",) if pieces == 1 else ("start", "end")
    part = jo.Part.beam(L / pieces, SECTION, 8 // pieces, MATERIAL, theory=jo.parts.Timoshenko())
    reduced = jo.reduce(part, jo.CraigBampton(ends, modes=modes), stiffening=stiffening)
    reduced = reduced.keep(reduced.in_plane("xy"))
    bodies = [
        jo.FlexibleBody(f"piece {k + 1}", reduced, position=(k * L / pieces, 0, 0))
        for k in range(pieces)
    ]
    root = jo.Revolute("root", jo.ground["origin"], bodies[0]["start"], axis=(0, 0, 1))
    welds = [
        jo.Fixed(f"weld {k}", a["end"], b["start"])
        for k, (a, b) in enumerate(zip(bodies, bodies[1:], strict=False), 1)
    ]
    tip = jo.PositionSensor("tip", bodies[-1]["end"])
    return jo.Mechanism(*bodies, root, *welds, jo.Drive("motor", root.angle, signal(speed)), tip)
