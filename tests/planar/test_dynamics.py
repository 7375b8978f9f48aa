"""Motion of planar frames: orders, conservation, links, tangents on and off, failures explained."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import jousto as jo
from jousto.planar.dynamics import simulate_planar
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import (
    PlanarBeam,
    PlanarDamping,
    PlanarLoad,
    PlanarMass,
    PlanarSupport,
    RigidLink,
)
from jousto.planar.methods import Convergence, Method, PlanarGeneralizedAlpha, PlanarNewmark
from jousto.planar.results import PlanarRun, PlanarState, planar_spinning
from jousto.planar.section import PlanarSection
from jousto.planar.statics import load_steps, planar_frequencies
from planar.frames import ROD, chain, everything

METHODS: dict[str, Callable[[float], Method]] = {
    "trapezoidal": lambda h: PlanarNewmark(h),
    "alpha": lambda h: PlanarGeneralizedAlpha(h, rho=0.6),
}


@pytest.mark.parametrize("name", [pytest.param("trapezoidal", marks=pytest.mark.slow), "alpha"])
def test_order_two(name: str) -> None:
    """With all kinds of links, loads and damping; against the finest of three runs."""
    frame = everything()
    ends = [
        simulate_planar(frame, 0.01, METHODS[name](0.0005 / n)).displacements[-1] for n in (1, 2, 4)
    ]
    coarse, fine = (float(abs(a - b).max()) for a, b in zip(ends, ends[1:], strict=False))
    assert 3.3 < coarse / fine < 4.7


def test_weights_of_the_methods() -> None:
    # Geradin and Cardona: gamma = 1/2 + a, beta = (1 + a)^2 / 4
    assert PlanarNewmark(1.0, 0.001).weights == (0.0, 0.0, 0.25 * 1.001**2, 0.501)
    am, af, beta, gamma = PlanarGeneralizedAlpha(1.0, 0.0).weights
    # asymptotic annihilation: alpha_m = -1, alpha_f = 0 of Chung and Hulbert
    assert (am, af, beta, gamma) == (-1.0, 0.0, 1.0, 1.5)


def test_damping_of_fast_oscillations_is_rho() -> None:
    """A bar whose stretching is far too fast for the step loses all but rho of it per step."""
    bar = PlanarSection(EA=1e12, GA=1e12, EI=1e12, mass=1.0, rotary=1.0)
    frame = chain(1, section=bar)
    q = np.zeros(6)
    q[3] = 1e-6
    run = simulate_planar(
        frame, 4.0, PlanarGeneralizedAlpha(0.1, rho=0.5), start=PlanarState(q, np.zeros(6))
    )
    x = run.displacements[:, 1, 0]
    # far above the step the amplification has the eigenvalue -rho three times (Chung and Hulbert
    # 1993, section 3): x obeys (E + rho)^3 x = 0, E the shift by a step; 1e-6: 1 / (w h)^2 = 1e-10
    left = x[3:] + 3 * 0.5 * x[2:-1] + 3 * 0.25 * x[1:-2] + 0.125 * x[:-3]
    assert np.abs(left).max() < 1e-6 * np.abs(x).max()
    assert np.abs(x[-1]) < 40**2 * 0.5**38 * np.abs(x).max()


def test_rigid_pendulum_of_an_offset_beam() -> None:
    """A stiff beam on a pivot beside its axis: energy of a physical pendulum (m g h)."""
    stiff = PlanarSection(EA=1e9, GA=1e9, EI=1e8, mass=3.0, rotary=0.01)
    frame = PlanarFrame(
        [(0.0, 0.0), (1.0, 0.4)],
        [PlanarBeam(0, 1, stiff, offset_a=(0.0, 0.4))],
        supports=[PlanarSupport(0)],
        gravity=(0.0, -9.81),
    )
    run = simulate_planar(frame, 0.5, PlanarNewmark(1e-3, 0.01))
    # eq. 19: rotary inertia of the section, mass along the axis at the height 0.4 of the pivot
    inertia = 3.0 * (1 / 3 + 0.4**2) + 0.01
    th = run.displacements[:, 0, 2]
    drop = 3.0 * 9.81 * ((0.5 * np.sin(th) + 0.4 * np.cos(th)) - 0.4)
    assert 0.5 * inertia * run.velocities[:, 0, 2] ** 2 == pytest.approx(-drop, abs=4e-3)
    assert run.energies[:, 0] == pytest.approx(-drop, abs=4e-3)


def flying() -> tuple[PlanarFrame, PlanarState]:
    frame = chain(5, supports=[], masses=[PlanarMass(2, 1.5, 0.3)])
    start = planar_spinning(frame, 6.0, (0.3, -0.2))
    start.v[3::6] += 1.0
    return frame, start


def test_free_flight_conserves() -> None:
    """Linear momentum to rounding; angular momentum and energy to the order of the method."""
    frame, start = flying()
    M = frame.system.M
    drifts = []
    for h in (1e-3, 5e-4):
        run = simulate_planar(frame, 0.2, PlanarNewmark(h), start=start)
        p = run.v @ M
        linear = np.stack([p[:, 0::3].sum(axis=1), p[:, 1::3].sum(axis=1)], axis=1)
        assert abs(linear - linear[0]).max() < 1e-9 * abs(linear).max()
        x = run.positions
        angular = (x[:, :, 0] * p[:, 1::3] - x[:, :, 1] * p[:, 0::3] + p[:, 2::3]).sum(axis=1)
        energy = run.energies.sum(axis=1)
        drifts.append([np.ptp(angular) / angular[0], np.ptp(energy) / energy[0]])
    assert max(drifts[0]) < 1e-3
    # the next term is of the order h^4: of some 5 % at 2 ms, a quarter of that here
    assert np.divide(*drifts) == pytest.approx(4.0, rel=0.04)


def test_a_rigid_link_is_an_offset() -> None:
    """An offset element, and a node on a rigid arm: the same motion."""
    loads = [PlanarLoad(0, moment=30.0)]
    one = PlanarFrame(
        [(0, 0), (1.2, 0.4)],
        [PlanarBeam(0, 1, ROD, offset_a=(0.2, 0.4))],
        [PlanarSupport(0)],
        loads,
    )
    two = PlanarFrame(
        [(0, 0), (1.2, 0.4), (0.2, 0.4)],
        [PlanarBeam(2, 1, ROD)],
        [PlanarSupport(0)],
        loads,
        links=[RigidLink(0, (2,))],
    )
    a, b = (simulate_planar(f, 0.1, PlanarNewmark(1e-3)) for f in (one, two))
    assert abs(a.displacements[:, 1] - b.displacements[:, 1]).max() < 1e-9
    # the arm's end is where the rotation takes it
    th = b.displacements[:, 0, 2]
    end = np.stack([0.2 * np.cos(th) - 0.4 * np.sin(th), 0.2 * np.sin(th) + 0.4 * np.cos(th)], 1)
    assert abs(b.positions[:, 2] - end).max() < 1e-14


def test_tangents_change_the_work_and_not_the_motion() -> None:
    # a pivot 0.3 m beside the axis
    section = PlanarSection(EA=1e6, GA=1e6, EI=1e3, mass=2.0, rotary=0.05)
    frame = PlanarFrame(
        [(0.0, -0.3), (0.5, 0.0), (1.0, 0.0)],
        [PlanarBeam(0, 1, section, offset_a=(0.0, 0.3)), PlanarBeam(1, 2, section)],
        supports=[PlanarSupport(0)],
        loads=[PlanarLoad(0, moment=2e3)],
        damping=PlanarDamping(mass=0.1),
    )
    tight = Convergence(relative=1e-11)
    runs = [
        simulate_planar(frame, 0.03, PlanarNewmark(1e-3), convergence=tight, inertia_tangents=on)
        for on in (True, False, "symmetric")
    ]
    for run in runs[1:]:
        assert abs(runs[0].displacements - run.displacements).max() < 1e-8
    on, off, half = (int(run.evaluations.sum()) for run in runs)
    assert on < 0.9 * off
    assert on < half
    with pytest.raises(jo.InputError, match="inertia_tangents is 'half', must be True, False"):
        simulate_planar(frame, 0.03, PlanarNewmark(1e-3), inertia_tangents="half")  # type: ignore[arg-type]
    assert np.all(runs[0].solves[1:] == runs[0].evaluations[1:] - 1)


def test_an_increment_criterion_saves_the_last_residual() -> None:
    frame = chain(2, loads=[PlanarLoad(2, force=(0.0, 100.0))])
    method = PlanarNewmark(1e-3)
    exact = simulate_planar(frame, 0.02, method, convergence=Convergence(relative=1e-12))
    run = simulate_planar(frame, 0.02, method, convergence=Convergence(increment=1e-9))
    assert np.all(run.evaluations[1:] == run.solves[1:])
    assert abs(run.displacements - exact.displacements).max() < 1e-11
    assert Convergence(increment=1e-9).relative is None
    assert Convergence().relative == 1e-9


def test_a_run_goes_on_exactly() -> None:
    frame = everything()
    method = PlanarGeneralizedAlpha(1e-3, rho=0.7)
    whole = simulate_planar(frame, 0.02, method)
    first = simulate_planar(frame, 0.01, method)
    second = simulate_planar(frame, 0.02, method, start=first.state())
    # times are counted from another start: rounding
    assert abs(second.displacements[-1] - whole.displacements[-1]).max() < 1e-10


def test_rest_in_an_equilibrium_stays() -> None:
    frame = chain(4, loads=[PlanarLoad(4, force=(0.0, 200.0), follow=True)])
    path = load_steps(frame, [0.5, 1.0])
    run = simulate_planar(frame, 0.1, PlanarNewmark(1e-2), start=path.state())
    assert abs(run.displacements - path.displacements[-1]).max() < 1e-9


def test_small_vibration_has_its_frequency() -> None:
    """Free vibration of a cantilever in its first mode, over ten periods."""
    frame = chain(6)
    f1 = float(planar_frequencies(frame)[0])
    # load that shapes about the first mode
    shape = load_steps(
        PlanarFrame(frame.nodes, frame.beams, frame.supports, [PlanarLoad(6, force=(0.0, 1e-3))]),
    ).state()
    period = 1.0 / f1
    run = simulate_planar(frame, 10 * period, PlanarNewmark(period / 200), start=shape)
    tip = run.displacements[:, -1, 1]
    # the trapezoidal rule is slow by (w h)^2 / 12
    late = 10 * (2 * math.pi / 200) ** 2 / 12
    crossings = np.flatnonzero((tip[:-1] > 0) & (tip[1:] <= 0))
    assert len(crossings) == 10
    assert crossings[-1] / 200 == pytest.approx(9.25 + late, abs=0.02)


def test_stiffness_damping_is_that_of_the_modes() -> None:
    """beta w / 2 of critical in the first mode."""
    beta = 2e-3
    frame = chain(4, damping=PlanarDamping(stiffness=beta))
    w = 2 * math.pi * float(planar_frequencies(frame)[0])
    start = load_steps(
        PlanarFrame(frame.nodes, frame.beams, frame.supports, [PlanarLoad(4, force=(0.0, 1e-3))])
    ).state()
    n = 5
    run = simulate_planar(
        frame, n * 2 * math.pi / w, PlanarNewmark(2 * math.pi / w / 400), start=start
    )
    tip = run.displacements[:, -1, 1]
    decay = math.exp(-0.5 * beta * w * n * 2 * math.pi)
    assert tip[-1] / tip[0] == pytest.approx(decay, rel=0.05)


def spun(GA: float) -> PlanarFrame:
    section = PlanarSection(EA=1e5, GA=GA, EI=100.0, mass=1.0, rotary=1e-3)
    return chain(3, section=section, supports=[PlanarSupport(0)])


def test_tension_shear_instability_is_explained() -> None:
    """N > GA / (1 - GA / EA): with time, element and remedy."""
    speed = 300.0
    # the stretched start has less than the limit, the speed takes it beyond
    soft = spun(2e4)
    with pytest.raises(jo.SimulationError) as error:
        simulate_planar(soft, 1.0, PlanarNewmark(1e-3), start=planar_spinning(soft, speed))
    text = str(error.value)
    assert "beams[0] (0 to 1): its axial force is" in text
    assert "times the limit GA / (1 - GA/EA)" in text
    assert "use GA = EA" in text
    assert error.value.time > 0.0
    assert error.value.body == "beams[0] (0 to 1)"
    # the same spin where the law is stable
    hard = spun(1e5)
    calm = simulate_planar(hard, 0.05, PlanarNewmark(1e-3), start=planar_spinning(hard, speed))
    assert calm.complete and calm.unstable is None


def test_an_instability_that_converges_warns() -> None:
    soft = spun(2e4)
    start = planar_spinning(soft, 300.0)
    with pytest.warns(jo.JoustoWarning, match=r"beams\[0\].*at t = .* s its axial force"):
        run = simulate_planar(soft, 0.006, PlanarNewmark(1e-4), start=start)
    assert isinstance(run, PlanarRun)
    assert run.unstable is not None
    time, where, ratio = run.unstable
    assert 0.0 < time <= 0.006
    assert where == "beams[0] (0 to 1)"
    assert ratio > 1.0


def test_a_criterion_below_rounding_is_explained() -> None:
    frame = chain(3, loads=[PlanarLoad(3, force=(0.0, 100.0))])
    with pytest.raises(jo.SimulationError, match="give a larger"):
        simulate_planar(frame, 0.1, PlanarNewmark(1e-3), convergence=Convergence(residual=1e-16))


def test_a_step_too_large_is_explained() -> None:
    stiff = PlanarSection(EA=1e6, GA=1e6, EI=1e3, mass=2.0, rotary=0.05)
    frame = chain(3, section=stiff, supports=[PlanarSupport(0)], loads=[PlanarLoad(0, moment=3e2)])
    with pytest.raises(jo.SimulationError, match="use a smaller step than 0.01 s"):
        simulate_planar(frame, 1.0, PlanarNewmark(0.01))


def test_the_end_must_come_after_the_start() -> None:
    with pytest.raises(jo.InputError, match="t_end is nan"):
        simulate_planar(chain(1), math.nan, PlanarNewmark(1e-3))
    with pytest.raises(jo.InputError, match="must be after the start at 1 s"):
        start = PlanarState(np.zeros(6), np.zeros(6), time=1.0)
        simulate_planar(chain(1), 0.5, PlanarNewmark(1e-3), start=start)
    run = simulate_planar(chain(1), 0.01, PlanarNewmark(1e-3))
    with pytest.raises(jo.InputError, match="there is none"):
        run.node("tip")


@pytest.mark.parametrize("t_end", [0.0104, 0.0096, 0.01])
def test_equal_steps_end_where_they_shall(t_end: float) -> None:
    run = simulate_planar(chain(1), t_end, PlanarNewmark(1e-3))
    assert run.time[-1] == pytest.approx(t_end, rel=1e-12)
    assert np.diff(run.time) == pytest.approx(t_end / (len(run.time) - 1), rel=1e-9)
    assert np.diff(run.time).max() <= 1e-3 * (1 + 1e-9)
