"""Motion of all elements: conservation, energy balance, published spin-up, prescribed motions."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.planar.ancf import AncfElement
from jousto.planar.corotational import CorotationalElement
from jousto.planar.dynamics import simulate_planar
from jousto.planar.element import PlanarElement
from jousto.planar.items import PlanarDamping, PlanarLoad, PlanarMotion, PlanarSupport
from jousto.planar.methods import Convergence, PlanarGeneralizedAlpha, PlanarNewmark
from jousto.planar.results import PlanarRun, PlanarState, planar_spinning
from jousto.planar.section import PlanarSection
from jousto.planar.statics import arc_length, load_steps
from planar.cases import BLADE, SPIN, SPIN_TIMES, SWING, across, extrapolated, spin_up, swing
from planar.frames import chain

sys.path.insert(0, str(Path(__file__).parent.parent.parent / "examples"))
from offset_boom import A, E, boom, rpm

sys.path.pop(0)

Array = NDArray[Any]
KINDS: dict[str, PlanarElement] = {
    "linear mass": CorotationalElement(),
    "cubic mass": CorotationalElement(mass="cubic"),
    "GI": AncfElement(),
    "BS": AncfElement(law="BS"),
}
ROD = PlanarSection(EA=3e4, GA=math.inf, EI=50.0, mass=2.0)


def momenta(run: PlanarRun) -> Array:
    """Linear and angular momentum about the origin, (nt, 3), from the mass matrix of the frame."""
    system = run.frame.system
    out = []
    for q, v, x in zip(run.q, run.v, run.positions, strict=True):
        B = system.elimination.map.B(q)
        p = B.T @ system.M @ (B @ v)
        n = 3 * x.shape[0]
        # rigid motions of the unknowns: positions, rotations; stretches stay
        out.append(
            [
                p[0:n:3].sum(),
                p[1:n:3].sum(),
                x[:, 0] @ p[1:n:3] - x[:, 1] @ p[0:n:3] + p[2:n:3].sum(),
            ]
        )
    return np.array(out)


@pytest.mark.parametrize("name", KINDS)
def test_free_flight_conserves_to_order_two(name: str) -> None:
    """Momenta and energy; without the velocity terms of the mass matrix no order would remain."""
    frame = chain(4, section=ROD, supports=[], element=KINDS[name])
    start = planar_spinning(frame, 6.0, (0.3, -0.2))
    start.v[3:12:6] += 1.0
    drifts = []
    for h in (1e-3, 5e-4):
        run = simulate_planar(frame, 0.1, PlanarNewmark(h), start=start)
        p, energy = momenta(run), run.energies.sum(axis=1)
        assert abs(run.balance - energy).max() < 1e-12 * energy[0]
        drifts.append([np.ptp(p[:, 2]), np.ptp(energy), max(np.ptp(p[:, 0]), np.ptp(p[:, 1]))])
    assert drifts[0][0] < 2e-2 * abs(p[0, 2]) and drifts[0][1] < 2e-2 * energy[0]
    # order 2; terms of order 4 still show with the stiffest frames
    assert np.log2(np.divide(*drifts))[:2].min() > 1.65
    # linear momentum: exact for constant masses of positions, else of the same order
    assert drifts[1][2] < 1e-9 or math.log2(drifts[0][2] / drifts[1][2]) > 1.6


@pytest.mark.parametrize("name", KINDS)
def test_energy_balance_with_everything(name: str) -> None:
    """Loads, gravity that grows, a driven hub and damping: the balance is constant to order 2."""
    frame = chain(
        3,
        section=ROD,
        supports=[PlanarSupport(0)],
        motions=[PlanarMotion(0, rotation=lambda t: (2.0 * t**3, 6.0 * t**2, 12.0 * t))],
        loads=[PlanarLoad(3, (5.0, -30.0), 2.0, signal=lambda t: math.sin(9.0 * t) ** 2)],
        gravity=(0.0, -9.81),
        gravity_signal=lambda t: t**2,
        damping=PlanarDamping(mass=0.5, stiffness=1e-3),
        element=KINDS[name],
    )
    drifts = []
    for h in (2e-3, 1e-3):
        run = simulate_planar(frame, 0.2, PlanarNewmark(h))
        drifts.append(float(np.ptp(run.balance)))
    assert run.works[-1, 1] > 1e-3 * run.works[-1, 0] > 0.0
    assert drifts[1] < 1e-3 * run.energies[-1].sum()
    assert drifts[0] / drifts[1] == pytest.approx(4.0, rel=0.3)


def test_spin_up_of_a_hub_begins_as_published() -> None:
    """Four cubic elements, to 5 s: worst error of all instants 4.3e-4 m, here at the first."""
    found = extrapolated(lambda h: across(spin_up("ancf", 4, h, 5.0), SPIN_TIMES[:1]), 1e-2)
    assert found == pytest.approx(SPIN[:1], abs=1e-4)


@pytest.mark.parametrize(("element", "worst"), [("ancf", 2.1e-4), ("corotational", 2.3e-2)])
def test_soft_pendulum(element: str, worst: float) -> None:
    """Four elements: the errors of an independent program with the same elements."""
    found = extrapolated(lambda h: swing(element, 4, h), 2e-3)
    assert abs(found - SWING).max() == pytest.approx(worst, rel=0.1)


@pytest.mark.slow
def test_soft_pendulum_to_six_digits() -> None:
    """16 cubic elements, Richardson in the step and in the mesh: 1e-6."""
    coarse, fine = (extrapolated(lambda h, n=n: swing("ancf", n, h), 1e-3) for n in (8, 16))
    assert abs((16 * fine - coarse) / 15 - SWING).max() < 1e-6


@pytest.mark.slow
def test_spin_up_to_six_digits() -> None:
    """16 cubic elements, Richardson in the step and in the mesh: 1e-6."""
    coarse, fine = (
        extrapolated(lambda h, n=n: across(spin_up("ancf", n, h), SPIN_TIMES), 4e-3)
        for n in (8, 16)
    )
    assert abs((16 * fine - coarse) / 15 - SPIN).max() < 1e-6


@pytest.mark.slow
def test_steady_stretch_of_a_turning_blade() -> None:
    """``tan(k L)/k - L``, k = w sqrt(m/EA): a closed form."""
    w = 6.0
    frame = chain(
        2,
        10.0,
        BLADE,
        supports=[PlanarSupport(0)],
        motions=[PlanarMotion(0, rotation=lambda t: (w * t, w, 0.0))],
        damping=PlanarDamping(stiffness=0.1),
        element="ancf",
    )
    start = planar_spinning(frame, w)

    def stretch(step: float) -> Array:
        method = PlanarGeneralizedAlpha(step, rho=0.8)
        run = simulate_planar(frame, 2.0, method, start=start)
        return np.asarray(np.hypot(*run.positions[-1, -1]) - 10.0)

    k = w * math.sqrt(BLADE.mass / BLADE.EA)
    exact = math.tan(10.0 * k) / k - 10.0
    assert exact == pytest.approx(5.143174550e-4, rel=1e-9)
    # the methods shorten a circle by (w h)^2 times a constant, which the extrapolation removes
    assert extrapolated(stretch, 4e-3) == pytest.approx(exact, rel=1e-4)


def test_rotations_without_mass_follow_the_others() -> None:
    """Linear mass without rotary inertia: as with a very small one."""
    tiny = PlanarSection(EA=ROD.EA, GA=math.inf, EI=ROD.EI, mass=ROD.mass, rotary=1e-7)
    ends = []
    for section in (ROD, tiny):
        frame = chain(
            3,
            section=section,
            loads=[PlanarLoad(3, (0.0, 40.0), signal=lambda t: math.sin(20.0 * t) ** 2)],
            element="corotational",
        )
        run = simulate_planar(frame, 0.1, PlanarNewmark(1e-3))
        ends.append(run.displacements[:, -1, :2])
        assert abs(run.energies).max() < 1e3
    assert abs(ends[0]).max() > 0.02
    assert abs(ends[0] - ends[1]).max() < 1e-5 * abs(ends[0]).max()


def test_motions_are_checked() -> None:
    def turn(t: float) -> tuple[float, float, float]:
        return 2.0 * t, 2.0, 0.0

    with pytest.raises(jo.InputError) as error:
        chain(
            2,
            section=ROD,
            element="ancf",
            motions=[
                PlanarMotion(0, rotation=turn),
                PlanarMotion(1),
                PlanarMotion(2, x=3.0, y=lambda t: t),  # type: ignore[arg-type, return-value]
                PlanarMotion(2, rotation=lambda t: 1 / t),  # type: ignore[arg-type, return-value]
            ],
            gravity_signal=2.0,
        )
    text = str(error.value)
    assert "gravity_signal is 2.0, must be a function of the time" in text
    with pytest.raises(jo.InputError) as error:
        chain(
            2,
            section=ROD,
            element="ancf",
            motions=[
                PlanarMotion(0, rotation=turn),
                PlanarMotion(1),
                PlanarMotion(2, x=3.0, y=lambda t: t),  # type: ignore[arg-type, return-value]
                PlanarMotion(2, rotation=lambda t: 1 / t),  # type: ignore[arg-type, return-value]
            ],
        )
    text = str(error.value)
    assert "rotation of node 0 is supported or moved twice; keep one of both" in text
    assert "motions[1]: moves nothing; give x, y or rotation" in text
    assert "x is 3.0, must be a function of the time in s that returns value, rate" in text
    assert "y returns array(0.) at t = 0" in text
    assert "rotation fails at t = 0: " in text
    frame = chain(
        2, section=ROD, supports=[PlanarSupport(0)], element="ancf",
        motions=[PlanarMotion(0, rotation=turn)],
    )  # fmt: skip
    with pytest.raises(jo.InputError, match="prescribed motions .r of node 0.*simulate_planar"):
        load_steps(frame)
    with pytest.raises(jo.InputError, match="prescribed motions .r of node 0"):
        arc_length(frame, 0.1)
    start = PlanarState(np.zeros(frame.system.size), np.zeros(frame.system.size))
    with pytest.raises(jo.InputError, match="its motion at 0 with 2 at t = 0 s; give a start"):
        simulate_planar(frame, 0.1, PlanarNewmark(0.01), start=start)


def test_a_driven_run_goes_on_exactly() -> None:
    whole = spin_up("ancf", 3, 1e-2, 0.4)
    first = spin_up("ancf", 3, 1e-2, 0.2)
    second = simulate_planar(whole.frame, 0.4, PlanarNewmark(1e-2), start=first.state())
    # times are counted from another start: rounding
    assert abs(second.displacements[-1] - whole.displacements[-1]).max() < 1e-10


@pytest.mark.filterwarnings("ignore:.*leaves out:jousto.JoustoWarning")
@pytest.mark.slow
def test_one_boom_three_elements() -> None:
    """The paper's boom on a pivot beside its axis: one speed, to the order of each element."""
    rule = Convergence(relative=1e-10)

    def speed(element: str | PlanarElement, n: int, GA: float) -> float:
        frame = boom(GA, element, n)
        run = simulate_planar(frame, 0.15, PlanarNewmark(5e-4, 0.001), convergence=rule)
        return float(rpm(run)[-1])

    def limit(element: str | PlanarElement, GA: float) -> float:
        coarse, fine = speed(element, 8, GA), speed(element, 16, GA)
        return (4.0 * fine - coarse) / 3.0

    cubic = CorotationalElement(mass="cubic")
    exact, shear = limit("exact", E * A), limit(cubic, E * A)
    rigid, ancf = limit(cubic, math.inf), speed("ancf", 8, math.inf)
    # two elements of order 2 with shear, and two without; what is left is of order 4
    assert shear == pytest.approx(exact, rel=1.5e-3)
    assert ancf == pytest.approx(rigid, rel=1e-3)
    # shear is seen, and is small: GA = EA
    assert 5e-4 < ancf / exact - 1.0 < 3e-3
