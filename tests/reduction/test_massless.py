"""Interface motions that carry stiffness but no mass: a beam of point masses, held and loaded."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import jousto as jo
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree, Method
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle

LENGTH, SIDE, ELEMENTS = 2.0, 0.05, 16
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
EI = STEEL.E * SIDE**4 / 12.0
# of bending (1.8751 / L)^2 sqrt(EI / rho A) / 2 pi, slender beam with a clamped end
FIRST = 1.8751040687**2 / (2.0 * np.pi * LENGTH**2) * np.sqrt(EI / (STEEL.rho * SIDE**2))
# what the inertia of the flywheel in the middle takes off, and masses at 16 stations
CLOSE = 2e-3
pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will move")


def line(elements: int = ELEMENTS, offset: float = 0.0) -> Part:
    """Point masses on a beam without rotary inertia, but of a small flywheel in its middle.

    With an offset, the last node lies beside the line instead.
    """
    nodes = np.zeros((elements + 1, 3))
    nodes[:, 0] = np.linspace(0.0, LENGTH, elements + 1)
    nodes[-1, 1] = -offset
    wheel = PointMass(f"node{elements // 2 + 1}", 0.0, inertia=(0.02, 0.01, 0.01))
    return Part.frame(
        nodes,
        np.column_stack([np.arange(elements), np.arange(1, elements + 1)]),
        sections=Rectangle(SIDE, SIDE),
        materials=STEEL,
        lumped=True,
        rotary_inertia=False,
        theory=EulerBernoulli(),
        point_masses=() if offset else (wheel,),
        node_sets={"start": (0,), "end": (elements,)},
    )


def held(reduced: ReducedPart, *more: object, ends: tuple[str, ...] = ("start",)) -> jo.Model:
    body = jo.FlexibleBody("beam", reduced)
    fixed = [
        jo.Fixed(f"weld {end}", jo.ground.at(body[end].r, body[end].A), body[end]) for end in ends
    ]
    loads = [item(body) for item in more]  # type: ignore[operator]
    return jo.compile(jo.Mechanism(body, *fixed, *loads))


def at_rest(model: jo.Model) -> np.ndarray:
    state = jo.equilibrium(model)
    return np.asarray(jo.simulate(model, 1e-6, state=state)["tip"][0])


METHODS: dict[str, Method] = {
    "one end": CraigBampton(("start",), modes=23),
    "both ends": CraigBampton(("start", "end"), modes=13),
    "attachment": FreeFree(modes=8, interfaces=("start", "end")),
}


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_a_clamped_beam_of_point_masses_is_equally_stiff_in_both_planes(method: Method) -> None:
    found = jo.modes(held(reduce(line(), method))).frequencies[:2]
    assert found == pytest.approx(FIRST, rel=CLOSE)
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_bending_of_a_line_of_mass_that_turns_its_frame_is_told() -> None:
    reduced = reduce(line(offset=1e-5), METHODS["both ends"])
    with pytest.warns(jo.JoustoWarning, match=r"lies on one line.*rotary_inertia=True"):
        model = held(reduced)
    # about the straight state itself all is well, to a part in 10 million of 656 kHz
    found = jo.modes(model).frequencies[:2]
    assert found == pytest.approx(FIRST, rel=CLOSE)
    assert found[0] == pytest.approx(found[1], rel=1e-6)


@pytest.mark.parametrize("offset", [1e-5, 1e-3])
def test_seen_from_the_node_that_holds_it_a_line_of_mass_bends_as_it_should(offset: float) -> None:
    """F L^3/3EI across the offset, at once and in vibration; by mean axes 20 to 40 % less."""
    force = np.array([0.0, 0.0, 100.0])
    loads = (
        lambda body: jo.Force("tip force", body["end"], force),
        lambda body: jo.PositionSensor("tip", body["end"]),
    )
    size = 100.0 * LENGTH**3 / (3.0 * EI)
    mean = reduce(line(offset=offset), CraigBampton(("start", "end"), modes=4))
    with pytest.warns(jo.JoustoWarning, match=r"jo\.reduction\.clamp\(reduced, 'node1'\)"):
        model = held(mean, *loads)
    assert at_rest(model)[2] < 0.9 * size
    good = held(jo.reduction.clamp(mean, "start"), *loads)
    assert at_rest(good)[2] == pytest.approx(size, rel=(size / LENGTH) ** 2 + 1e-5)
    # where the offset is, nothing turns the frame: the same vibration of both planes
    force = np.array([0.0, 100.0, 0.0])
    other = held(jo.reduction.clamp(mean, "start"), *loads)
    period = 1.0 / FIRST
    solver = jo.GeneralizedAlpha(step=period / 200)
    z = jo.simulate(good, period, solver=solver)["tip"][:, 2]
    y = jo.simulate(other, period, solver=solver)["tip"][:, 1] + offset
    assert z.max() == pytest.approx(2 * size, rel=0.05)
    assert z == pytest.approx(y, abs=1e-3 * size)


@pytest.mark.parametrize("axis", [1, 2])
@pytest.mark.parametrize("modes", [0, 4])
def test_its_tip_bends_as_the_closed_form(axis: int, modes: int) -> None:
    force = 100.0 * np.eye(3)[axis]
    model = held(
        reduce(line(), CraigBampton(("start", "end"), modes=modes)),
        lambda body: jo.Force("tip force", body["end"], force),
        lambda body: jo.PositionSensor("tip", body["end"]),
    )
    # F L^3 / 3 EI = 2.4 mm, whose square over the length is what linear bending leaves out
    size = 100.0 * LENGTH**3 / (3.0 * EI)
    assert at_rest(model)[axis] == pytest.approx(size, rel=(size / LENGTH) ** 2 + 1e-6)


def test_a_moment_at_the_end_turns_it_by_the_closed_form() -> None:
    model = held(
        reduce(line(), CraigBampton(("start", "end"), modes=0)),
        lambda body: jo.Torque("bending", body["end"], (0.0, 10.0, 0.0)),
        lambda body: jo.PositionSensor("tip", body["end"]),
    )
    assert at_rest(model)[2] == pytest.approx(-10.0 * LENGTH**2 / (2.0 * EI), rel=1e-6)


def test_held_at_both_ends_it_is_the_clamped_clamped_beam() -> None:
    model = held(reduce(line(), METHODS["both ends"]), ends=("start", "end"))
    # 4.73004^2 against 1.87510^2
    found = jo.modes(model).frequencies[:2]
    assert found == pytest.approx(FIRST * (4.7300407449 / 1.8751040687) ** 2, rel=5e-3)
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_the_clamped_part_has_the_same_frequencies() -> None:
    reduced = reduce(line(), METHODS["both ends"])
    found = jo.reduction.clamp(reduced, "start").frequencies[:2]
    assert found == pytest.approx(jo.modes(held(reduced)).frequencies[:2], rel=1e-6)


def test_no_interface_motion_is_lost() -> None:
    reduced = reduce(line(), CraigBampton(("start", "end"), modes=4))
    assert reduced.n == 4 + 12 - 6
    # in order; equal ones of the two planes may differ by rounding
    f = reduced.frequencies
    assert np.all(np.diff(f) >= -1e-10 * f[1:])
    # what moves no mass answers at once: four decades above the first mode
    still = np.diag(reduced.invariants.I6) < 0.5
    assert still.any()
    assert reduced.frequencies[still] == pytest.approx(1e4 * reduced.frequencies[0])


@pytest.mark.parametrize("modes", [4, 9])
@pytest.mark.parametrize("interfaces", [("start",), ("start", "end")])
def test_more_modes_do_not_stiffen_the_body(interfaces: tuple[str, ...], modes: int) -> None:
    part = line(elements=4, offset=1e-2)
    # the mesh itself, its start held: M x = mu K x
    K, M = part.K.toarray()[6:, 6:], part.M.toarray()[6:, 6:]
    mu = scipy.linalg.eigh(M, K, eigvals_only=True)[::-1]
    mesh = 1.0 / (2.0 * np.pi * np.sqrt(mu[:2]))
    found = jo.modes(held(reduce(part, CraigBampton(interfaces, modes=modes)))).frequencies[:2]
    # few modes are 5e-5 off; without its massless motions the body was 18 % too stiff
    assert found == pytest.approx(mesh, rel=1e-4)
