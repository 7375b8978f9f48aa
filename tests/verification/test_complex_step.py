"""Derivatives of trajectories by complex steps: the engine compiled with complex numbers.

``df/dx = Im f(x + i h) / h`` with h = 1e-30 has no truncation and no cancellation (Squire and
Trapp, SIAM Rev. 40, 1998). Against central differences, whose best possible accuracy is about
eps^(4/5) for the fourth-order formula used here, and against cases where the derivative of the
discrete solution itself is known.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jousto as jo
from verification.mechanisms import SECTION, SOFT, chain, loop, march

H = 1e-30
METHODS = [jo.RK4, jo.ROS2, jo.simulation.SSPRK3, jo.simulation.ROS3A]


def end_state(model, solver, steps, *, override=None, v0=None, complex_scalars=False):
    """Final [q, v], sensors and multipliers after some steps."""
    engine = jo.model.Engine(model, complex_scalars=complex_scalars, override=override)
    if v0 is not None:
        engine.v[:] = v0
    native = engine.native_solver(solver.method, solver.step, solver.projection)
    rows = np.zeros((1, engine.row_size), engine.dtype)
    assert engine.run(native, steps, steps, rows) == ("ok", 1)
    cut = 1 + model.nq + model.nv
    return np.concatenate([rows[0, 1:cut], rows[0, cut + model.nrow + 7 :], rows[0, cut:][:5]])


def differences(f, d):
    """Central differences of fourth order of f at zero."""
    return (8 * (f(d) - f(-d)) - (f(2 * d) - f(-2 * d))) / (12 * d)


def compare(by_complex, plain, by_difference, d, split):
    """Complex step against differences, for the state and for the outputs."""
    # the real part is the ordinary run; the two builds differ by round-off, which is also what
    # the differences suffer from, divided by d
    np.testing.assert_allclose(by_complex.real, plain, rtol=0, atol=1e-10 * np.abs(plain).max())
    for part in (slice(None, split), slice(split, None)):
        noise = np.abs(by_complex.real - plain)[part].max() + 1e-15 * np.abs(plain[part]).max()
        wanted = by_difference[part]
        scale = np.abs(wanted).max()
        assert scale > 1e4 * noise / d, "the differences are too coarse to say anything"
        np.testing.assert_allclose(
            by_complex.imag[part] / H, wanted, rtol=0, atol=1e-8 * scale + 10 * noise / d
        )


PARAMETERS = {
    # name: key of the constant, place, size of the difference
    "gravity": (("model", 0, "gravity"), 1, 1e-2),
    "modal stiffness": (("body", 0, "K"), 0, 30.0),
    "modal damping": (("body", 0, "D"), 1, 1e-1),
    "mass": (("body", 0, "mass"), 0, 1e-2),
    "frequency of a load": (("signal", 0, "data"), 2, 3e-2),
    "interface mode shape": (("marker", 1, "Phi"), (1, 0), 1e-4),
}


def constant(model, key):
    kind, i, name = key
    if kind == "model":
        return np.array(getattr(model, name))
    tables = {"body": model.bodies, "marker": model.markers, "signal": model.signals}
    return np.array(getattr(tables[kind][i], name))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("parameter", PARAMETERS)
def test_derivatives_of_the_end_state_with_respect_to_constants(parameter, method):
    model = jo.compile(chain("revolute", damping=0.01, loads=True))
    key, place, d = PARAMETERS[parameter]
    solver, steps = method(step=2.5e-4), 200
    base = constant(model, key)

    def with_change(change):
        value = base.astype(complex if isinstance(change, complex) else float)
        value[place] += change
        return end_state(
            model,
            solver,
            steps,
            override={key: value},
            complex_scalars=isinstance(change, complex),
        )

    plain = with_change(0.0)
    by_complex = with_change(1j * H)
    by_difference = differences(with_change, d)
    compare(by_complex, plain, by_difference, d, model.nq + model.nv)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("mechanism", [chain, loop], ids=["chain", "loop"])
def test_derivatives_of_the_end_state_with_respect_to_initial_velocities(mechanism, method):
    model = jo.compile(mechanism())
    solver, steps = method(step=2.5e-4), 200
    rng = np.random.default_rng(3)
    # a direction that the joints allow, else the first projection takes part of it away
    direction = rng.normal(size=model.nv)
    engine = jo.model.Engine(model)
    engine.v[:] = direction
    engine.assemble()
    direction = engine.v.copy()

    def with_change(change):
        return end_state(
            model,
            solver,
            steps,
            v0=model.v0 + change * direction,
            complex_scalars=isinstance(change, complex),
        )

    by_difference = differences(with_change, 1e-3)
    compare(with_change(1j * H), with_change(0.0), by_difference, 1e-3, model.nq + model.nv)


@pytest.mark.parametrize("size", [0.01, 0.3], ids=["slightly bent", "strongly bent"])
def test_derivatives_of_accelerations_with_respect_to_the_state(size):
    # the rotation of a marker has a series for small angles and sines for large ones (0.2 rad)
    model = jo.compile(chain("fixed", loads=True))
    rng = np.random.default_rng(11)
    q0, v0 = model.q0.copy(), model.v0 + rng.normal(size=model.nv)
    direction = np.zeros(model.nq)
    for b in model.bodies:
        q0[b.iq + 7 : b.iq + 7 + b.n] = size * rng.uniform(0.5, 1.0, b.n) / (1 + np.arange(b.n))
        direction[b.iq + 7 : b.iq + 7 + b.n] = rng.normal(size=b.n)
    angles = [np.linalg.norm(m.Psi @ q0[7:15]) for m in model.markers if m.Psi is not None]
    assert max(angles) < 0.1 if size < 0.1 else max(angles) > 1.0  # rad

    def accelerations(change):
        engine = jo.model.Engine(model, complex_scalars=isinstance(change, complex))
        engine.q[:], engine.v[:] = q0 + change * direction, v0
        return np.concatenate([x.copy() for x in engine.accelerations()])

    compare(
        accelerations(1j * H),
        accelerations(0.0),
        differences(accelerations, 1e-4),
        1e-4,
        model.nv,
    )


def oscillator(zeta):
    """A free body in mean axes with one mode, its frame at rest: ``p'' + D p' + K p = 0``."""
    one = jo.reduce(rod_part(), jo.FreeFree(modes=1))
    body = jo.FlexibleBody(
        "bar", one, damping=zeta, modal_coordinates=[0.1], modal_velocities=[-3.0]
    )
    return jo.compile(jo.Mechanism(body)), one.stiffness[0], 2 * zeta * np.sqrt(one.stiffness[0])


def rod_part():
    return jo.Part.beam(1.0, SECTION, 6, SOFT, theory=jo.parts.EulerBernoulli())


def by_tableau(method, h, K, D):
    """One step of the method on y' = B y as a matrix and its derivative with respect to K:

    ``(1 - g h B) k_i = B (1 + h sum_j<i (a_ij + g_ij) k_j)``, ``R = 1 + h sum_i b_i k_i``.
    """
    x, one = method().tableau, np.eye(2)
    B, dB = np.array([[0, 1], [-K, -D]]), np.array([[0.0, 0.0], [-1.0, 0.0]])
    R, dR, k, dk = one.copy(), np.zeros((2, 2)), [], []
    for i in range(x.stages):
        g = x.Gamma[i, i] * h
        W = np.linalg.inv(one - g * B)
        dW = W @ (g * dB) @ W
        weights = h * (x.A + x.Gamma)[i, :i]
        y = one + sum(w * z for w, z in zip(weights, k, strict=True))
        dy = sum((w * z for w, z in zip(weights, dk, strict=True)), np.zeros((2, 2)))
        k.append(W @ B @ y)
        dk.append(dW @ B @ y + W @ dB @ y + W @ B @ dy)
        R, dR = R + h * x.b[i] * k[-1], dR + h * x.b[i] * dk[-1]
    return R, dR


def amplification(method, h, K, D):
    """One step of the method on y' = B y as a matrix, from its published definition."""
    one = np.eye(2)
    B = np.array([[0, 1], [-K, -D]])
    if method not in (jo.RK4, jo.ROS2):
        return by_tableau(method, h, K, D)[0]
    if method is jo.RK4:
        Z = h * B
        return one + Z @ (one + Z / 2 @ (one + Z / 3 @ (one + Z / 4)))
    # ROS2, Verwer et al. 1999: (1 - g h B) k1 = B y, (1 - g h B) k2 = B (y + h k1) - 2 k1,
    # y + 3/2 h k1 + 1/2 h k2
    W = np.linalg.inv(one - (1 - np.sqrt(0.5)) * h * B)
    k1 = W @ B
    k2 = W @ (B @ (one + h * k1) - 2 * k1)
    return one + 1.5 * h * k1 + 0.5 * h * k2


def d_amplification(method, h, K, D):
    """Derivative of the same with respect to K, by the product rule."""
    one = np.eye(2)
    B, dB = np.array([[0, 1], [-K, -D]]), np.array([[0.0, 0.0], [-1.0, 0.0]])
    if method not in (jo.RK4, jo.ROS2):
        return by_tableau(method, h, K, D)[1]
    if method is jo.RK4:
        powers = [np.linalg.matrix_power(B, i) for i in range(4)]
        total = np.zeros((2, 2))
        for k, factor in ((1, 1.0), (2, 2.0), (3, 6.0), (4, 24.0)):
            total += h**k / factor * sum(powers[i] @ dB @ powers[k - 1 - i] for i in range(k))
        return total
    g = (1 - np.sqrt(0.5)) * h
    W = np.linalg.inv(one - g * B)
    dW = W @ (g * dB) @ W
    k1, dk1 = W @ B, dW @ B + W @ dB
    inner = B @ (one + h * k1) - 2 * k1
    dinner = dB @ (one + h * k1) + h * B @ dk1 - 2 * dk1
    return 1.5 * h * dk1 + 0.5 * h * (dW @ inner + W @ dinner)


@pytest.mark.filterwarnings("ignore:.*(has no joint to another|nothing will move)")
@pytest.mark.parametrize("zeta", [0.0, 0.1], ids=["undamped", "damped"])
@pytest.mark.parametrize("method", METHODS)
def test_linear_oscillator_step_by_step_and_its_derivative_to_round_off(method, zeta):
    # the discrete solution R^N y0 is known exactly, so is its derivative
    # sum R^(N-1-i) dR R^i y0: no step size enters the tolerance
    model, K, D = oscillator(zeta)
    h, steps = 2e-3, 50  # 0.29 rad of the oscillation per step
    y = np.array([0.1, -3.0])
    R, dR, dy = amplification(method, h, K, D), d_amplification(method, h, K, D), np.zeros(2)
    for _ in range(steps):
        y, dy = R @ y, R @ dy + dR @ y
    override = {("body", 0, "K"): np.array([K + 1j * H])}
    end = end_state(model, method(step=h), steps, override=override, complex_scalars=True)
    found = end[[7, model.nq + 6]]
    np.testing.assert_allclose(found.real, y, rtol=0, atol=1e-12 * np.abs(y).max())
    np.testing.assert_allclose(found.imag / H, dy, rtol=0, atol=1e-12 * np.abs(dy).max())


def test_rigid_pendulum_against_its_variational_equations():
    # theta'' = -k cos(theta); eta'' = k sin(theta) eta, eta(0) = 0, eta'(0) = 1
    mass, c, g, Jz = 3.0, 0.7, 9.81, 0.3
    body = jo.RigidBody("pendulum", mass, (0.2, 0.3, Jz), center=(c, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    model = jo.compile(jo.Mechanism(body, hinge, jo.Gravity((0, -g, 0))))
    k = mass * g * c / (Jz + mass * c**2)
    exact = solve_ivp(
        lambda t, y: [y[1], -k * np.cos(y[0]), y[3], k * np.sin(y[0]) * y[2]],
        (0.0, 1.0),
        [0.0, 0.5, 0.0, 1.0],
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
    ).y[:, -1]
    v0 = np.zeros(6, dtype=complex)
    v0[5] = 0.5 + 1j * H
    end = end_state(model, jo.RK4(step=5e-4), 2000, v0=v0, complex_scalars=True)
    e, spin = end[3:7], end[7 + 5]
    # h^4 k^2 t / 120 is 1e-13: round-off of 2000 steps is larger
    angle = 2 * np.arctan2(e[3].real, e[0].real)
    rate = 2 * (e[0].real * e[3].imag - e[3].real * e[0].imag) / H
    np.testing.assert_allclose([angle, spin.real], exact[:2], rtol=0, atol=1e-11)
    np.testing.assert_allclose([rate, spin.imag / H], exact[2:], rtol=0, atol=1e-11)


def test_the_complex_build_runs_the_same_motion():
    model = jo.compile(chain("spherical", damping=0.02, loads=True))
    solver = jo.ROS2(step=2.5e-4)
    real = march(model, solver, 0.1)
    twin = end_state(model, solver, 400, complex_scalars=True)
    state = real.state[-1]
    np.testing.assert_allclose(twin[: len(state)].real, state, rtol=0, atol=1e-10)
    assert np.abs(twin.imag).max() == 0.0
