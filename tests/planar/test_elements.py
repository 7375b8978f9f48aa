"""The elements of planar frames: tangents, rank, rigid motion, closed forms and published laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.planar.ancf import RULES, AncfElement, rule
from jousto.planar.corotational import CorotationalElement
from jousto.planar.element import PlanarElement
from jousto.planar.exact import ExactElement
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import PlanarBeam, PlanarLoad, PlanarMass, PlanarSupport
from jousto.planar.methods import Convergence
from jousto.planar.section import PlanarSection
from jousto.planar.statics import load_steps, planar_frequencies
from planar.frames import chain, everything

Array = NDArray[Any]
H = 1e-40
KINDS: dict[str, PlanarElement] = {
    "exact": ExactElement(),
    "corotational": CorotationalElement(),
    "arch, cubic mass": CorotationalElement(arch=True, mass="cubic"),
    "GI": AncfElement(),
    "BS": AncfElement(law="BS", axial="gauss 5"),
}
SLENDER = PlanarSection(EA=1.2e5, GA=math.inf, EI=1.0, mass=1.0)
ignore_shear = pytest.mark.filterwarnings("ignore:.*leaves out:jousto.JoustoWarning")


@ignore_shear
@pytest.mark.parametrize("name", KINDS)
def test_tangents_with_links_loads_and_damping(name: str) -> None:
    """Newton's matrix against complex steps, with all kinds of links and offsets."""
    frame = everything(element=KINDS[name])
    system, rng = frame.system, np.random.default_rng(3)
    n = system.size
    loads = system.at_time(0.3)
    q, v, a = 0.1 * rng.normal(size=(3, n)) * np.array([[1.0], [10.0], [100.0]])
    c, m = 300.0, 4e4
    J = system.tangent(system.evaluate(q, v, a, loads), loads, c, m)
    exact = np.array(
        [
            system.evaluate(q + x, v + c * x, a + m * x, loads).residual.imag / H
            for x in 1j * H * np.eye(n)
        ]
    ).T
    assert abs(J - exact).max() < 1e-12 * abs(exact).max()
    # row by row, so that small entries count
    sizes = abs(exact).max(axis=1)
    assert (abs(J - exact).max(axis=1) < 1e-10 * sizes).all()
    off = system.tangent(system.evaluate(q, v, a, loads), loads, c, m, inertia_tangents=False)
    Kacc, Cacc = system.elimination.inertia_tangents(q, v, a, system.M)
    assert abs(J - off - Kacc - c * Cacc).max() < 1e-12 * abs(J).max()


@ignore_shear
@pytest.mark.parametrize("name", KINDS)
def test_rigid_motion_strains_nothing(name: str) -> None:
    """Three turns and more, with stiffness-proportional damping: no force, no rate of strain."""
    frame = everything(element=KINDS[name])
    bare = PlanarFrame(frame.nodes, frame.beams, damping=frame.damping, element=KINDS[name])
    system = bare.system
    where = np.array(list(bare.nodes.values()))
    th, w = 2.3 + 6.0 * math.pi, 5.0
    R = np.array([[np.cos(th), -np.sin(th)], [np.sin(th), np.cos(th)]])
    now = where @ R.T + (0.3, -0.7)
    q, v = np.zeros((2, system.size))
    count = 3 * len(where)
    q[:count] = np.column_stack([now - where, np.full(len(where), th)]).ravel()
    v[:count] = np.column_stack([-w * now[:, 1], w * now[:, 0], np.full(len(where), w)]).ravel()
    p = system.evaluate(q, v, 0.0 * q, system.at_factor(0.0))
    strains, resultants = system.means(p)
    assert abs(strains).max() < 1e-13
    # strains of rounding 1e-15 times EA = 3e4 N, over the shortest arm
    assert abs(p.inner).max() < 1e-8
    assert abs(resultants).max() < 1e-8


@pytest.mark.parametrize("name", KINDS)
def test_no_motion_without_energy(name: str) -> None:
    """The stiffness of a free straight beam has the rank of its unknowns less three."""
    element = KINDS[name]
    section = SLENDER if name not in ("exact",) else PlanarSection(EA=1.2e5, GA=4e4, EI=1.0)
    for n in (1, 3):
        frame = chain(n, section=section, supports=[], element=element)
        system = frame.system
        zero = np.zeros(system.size)
        loads = system.at_factor(0.0)
        K = system.stiffness(system.evaluate(zero, zero, zero, loads), loads)
        d = np.sqrt(np.diag(K))
        assert np.linalg.matrix_rank(K / d[:, None] / d, tol=1e-10) == system.size - 3
        assert system.groups[0].free_motions() == 0


def test_two_gauss_points_leave_a_motion_and_are_refused_by_rank() -> None:
    """2n + 1 axial unknowns of a cantilever, 2n strains: the lowest eigenvalue of K is zero."""
    with pytest.warns(jo.JoustoWarning, match="leaves 1 motion of a free beam without energy"):
        frame = chain(4, section=SLENDER, element=AncfElement(axial="gauss 2"))
    assert frame.system.groups[0].free_motions() == 1
    system = frame.system
    zero, loads = np.zeros(system.size), system.at_factor(0.0)
    K = system.stiffness(system.evaluate(zero, zero, zero, loads), loads)
    K = K[np.ix_(system.free, system.free)]
    values = np.linalg.eigvalsh(K)
    assert abs(values[0]) < 1e-12 * values[-1]
    with pytest.raises(jo.InputError, match="can move without force in 1 ways.*other points"):
        load_steps(frame)


@pytest.mark.parametrize("word", RULES)
def test_rules_integrate_polynomials(word: str) -> None:
    """Gauss to degree 2 n - 1, Lobatto to 2 n - 3, and not beyond."""
    x, w = rule(word)
    top = 2 * len(x) - (1 if word.startswith("gauss") else 3)
    for degree in range(top + 1):
        assert w @ x**degree == pytest.approx(1.0 / (degree + 1), abs=1e-15)
    # of the next even degree they miss 1e-3 and more
    beyond = 0.5 ** (top + 1) / (top + 2)
    assert abs(w @ (x - 0.5) ** (top + 1) - beyond) > 1e-3 * beyond


def tip(element: PlanarElement | str, n: int, load: float, section: Any = SLENDER) -> Array:
    """Displacements and rotation of the end of a cantilever of length 1 under a dead load."""
    frame = chain(n, section=section, element=element, loads=[PlanarLoad(n, force=(0.0, load))])
    path = load_steps(frame, np.linspace(0.1, 1.0, 10), convergence=Convergence(relative=1e-11))
    return np.asarray(path.displacements[-1, -1])


# cantilever, EI = L = 1, EA = 1.2e5, no shear, dead load P at the end: u, w and angle by an
# independent program (shooting of the boundary value problem of Reissner's beam); the angle and w
# of P = 1 agree with the elliptic integrals of the inextensible beam to 1e-6
REFERENCE = {
    1.0: (-0.05643119263, 0.3017224152, 0.4613531811),
    10.0: (-0.5549858925, 0.8106756249, 1.430302244),
}


def shooting(load: float) -> tuple[float, float, float]:
    """Solve the boundary value problem: ``EI th'' = -P cos(th) (1 + eps)``, ``N = P sin(th)``."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    EA, EI = SLENDER.EA, SLENDER.EI

    def rates(_: float, y: Array) -> list[float]:
        th, curvature = y[:2]
        stretch = 1.0 + load * math.sin(th) / EA
        moment = -load * stretch * math.cos(th) / EI
        return [curvature, moment, stretch * math.cos(th), stretch * math.sin(th)]

    def end(curvature: float) -> Array:
        start = [0.0, curvature, 0.0, 0.0]
        run = solve_ivp(rates, (0.0, 1.0), start, rtol=1e-12, atol=1e-13, method="DOP853")
        return np.asarray(run.y[:, -1])

    root = brentq(lambda k: end(k)[1], 0.1 * load, load, xtol=1e-13)
    th, _, x, y = end(root)
    return x - 1.0, y, th


@pytest.mark.parametrize("load", REFERENCE)
def test_cantilever_to_eight_digits(load: float) -> None:
    """GI element: order 4, and Richardson meets the boundary value problem to 1e-8."""
    exact = np.array(shooting(load))
    assert exact == pytest.approx(REFERENCE[load], abs=2e-9)
    coarse, fine = (tip("ancf", n, load) for n in (16, 32))
    assert abs((16 * fine - coarse) / 15 - exact).max() < 1e-8


def test_orders_of_the_elements() -> None:
    """Order 2 of corotational and exact, order 4 of ANCF elements, in a tip load of 10."""
    exact = np.array(REFERENCE[10.0])
    for element, order, limit in (("corotational", 2, 5e-4), ("ancf", 4, 3e-6)):
        errors = [float(abs(tip(element, n, 10.0)[:2] - exact[:2]).max()) for n in (8, 16)]
        assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)
        assert errors[1] < limit


def test_shear_of_the_corotational_element_is_that_of_the_exact_one() -> None:
    """A stubby cantilever, GA = 20 EI/L^2: both converge to one deflection; without Phi not."""
    thick = PlanarSection(EA=300.0, GA=20.0, EI=1.0)
    found = {}
    for name, element in (
        ("exact", ExactElement()),
        ("corotational", CorotationalElement()),
        ("no shear", CorotationalElement(shear=False)),
    ):
        if name == "no shear":
            with pytest.warns(jo.JoustoWarning, match="leaves out shear .GA=math.inf."):
                coarse, fine = (tip(element, n, 0.1, thick) for n in (8, 16))
        else:
            coarse, fine = (tip(element, n, 0.1, thick) for n in (8, 16))
        found[name] = (4 * fine - coarse) / 3
    # the corotational shear force is across the chord, the exact one along the section: a
    # difference of the order of the square of the shear strain P/GA = 5e-3, times the deflection
    assert abs(found["exact"] - found["corotational"]).max() < 1e-4
    # small loads: w = P L^3 / 3 EI + P L / GA
    assert found["corotational"][1] == pytest.approx(0.1 / 3 + 0.1 / 20, rel=2e-3)
    assert found["no shear"][1] == pytest.approx(0.1 / 3, rel=2e-3)


@pytest.mark.parametrize("elements", [2, 3, 8])
def test_corotational_tip_of_a_roll_up_lies_on_a_polygon(elements: int) -> None:
    """Half a turn: exactly ``L/(n sin(pi/2n))`` up; a full turn closes."""
    section = PlanarSection(EA=1.2e5, GA=math.inf, EI=1.0)
    loads = [PlanarLoad(elements, moment=2.0 * math.pi)]
    frame = chain(elements, section=section, element="corotational", loads=loads)
    path = load_steps(frame, np.linspace(0.05, 1.0, 20))
    half = path.positions[9, -1]
    polygon = 1.0 / (elements * math.sin(math.pi / (2 * elements)))
    assert half == pytest.approx([0.0, polygon], abs=1e-9)
    if elements == 8:
        assert half[1] == pytest.approx(0.6407288619, abs=1e-9)
    assert abs(path.positions[-1, -1]).max() < 1e-9
    assert path.displacements[-1, -1, 2] == pytest.approx(2.0 * math.pi, abs=1e-9)


def roll(element: PlanarElement, n: int) -> Array:
    """Displacements of the end of a cantilever after an end moment of 2 pi EI/L."""
    loads = [PlanarLoad(n, moment=2.0 * math.pi)]
    frame = chain(n, section=SLENDER, element=element, loads=loads)
    return np.asarray(load_steps(frame, np.linspace(0.05, 1.0, 20)).displacements[-1, -1])


def test_pure_moment_stretches_the_law_of_berzeri_and_shabana() -> None:
    """``l^2 = 1 + 2 M^2/(EA EI)``, turns by M L l^2/EI: 6.287319477, and misses by 6.6e-4 L."""
    element = AncfElement(law="BS")
    coarse, fine = (roll(element, n) for n in (32, 64))
    end = (16 * fine - coarse) / 15
    l2 = 1.0 + 2.0 * (2.0 * math.pi) ** 2 / SLENDER.EA
    angle = 2.0 * math.pi * l2
    assert angle == pytest.approx(6.287319477, abs=1e-9)
    assert end[2] == pytest.approx(angle, abs=1e-7)
    # an arc of radius l/(angle/L) that passes the start
    radius = math.sqrt(l2) / angle
    place = radius * math.sin(angle) - 1.0, radius * (1.0 - math.cos(angle))
    assert end[:2] == pytest.approx(place, abs=1e-7)
    assert math.hypot(end[0] + 1.0, end[1]) == pytest.approx(6.6e-4, rel=0.01)
    # the law of Reissner closes
    coarse, fine = (roll(AncfElement(), n) for n in (16, 32))
    assert (16 * fine - coarse) / 15 == pytest.approx([-1.0, 0.0, 2.0 * math.pi], abs=3e-6)


def test_many_axial_points_lock_coarse_meshes() -> None:
    """Membrane locking: four elements are ten times worse with Gauss 5 than Lobatto 3."""
    exact = np.array(REFERENCE[10.0])
    errors = {
        axial: float(np.hypot(*(tip(AncfElement(axial=axial), 4, 10.0) - exact)[:2]))
        for axial in ("lobatto 3", "gauss 4", "gauss 5")
    }
    # an independent program: 5.6e-4, 1.1e-2, 1.2e-2
    assert errors["lobatto 3"] == pytest.approx(5.6e-4, rel=0.05)
    assert errors["gauss 4"] == pytest.approx(1.1e-2, rel=0.05)
    assert errors["gauss 5"] == pytest.approx(1.2e-2, rel=0.05)


def test_arch_strain_of_the_corotational_element_is_of_higher_order() -> None:
    """A clamped shallow arch strain in one element: ``(2 t1^2 - t1 t2 + 2 t2^2)/30``."""
    element = CorotationalElement(arch=True)
    frame = chain(1, section=SLENDER, element=element, supports=[PlanarSupport(0)])
    system = frame.system
    t1, t2 = 0.3, -0.2
    q = np.array([0.0, 0.0, t1, 0.0, 0.0, t2])
    zero = np.zeros(6)
    strains, resultants = system.means(system.evaluate(q, zero, zero, system.at_factor(0.0)))
    assert strains[0, 0] == pytest.approx((2 * t1**2 - t1 * t2 + 2 * t2**2) / 30, rel=1e-13)
    assert strains[0, 2] == pytest.approx(t2 - t1)
    # M1 = EI/l (4 t1 + 2 t2) and M2 with N w'^2/2 left out; Q = -(M1 + M2)/l
    assert resultants[0, 1] == pytest.approx(-6.0 * (t1 + t2), rel=1e-13)


@pytest.mark.parametrize("element", ["exact", "corotational", "ancf"])
def test_forces_of_a_cantilever(element: str) -> None:
    """N, Q and M of each beam are those of the equilibrium of the rest, in the turned section."""
    n, P = 16, np.array([-3.0, 5.0])
    section = PlanarSection(EA=1e3, GA=400.0, EI=1.0) if element == "exact" else SLENDER
    frame = chain(n, section=section, element=element, loads=[PlanarLoad(n, force=tuple(P))])
    path = load_steps(frame, np.linspace(0.1, 1.0, 10))
    x, th = path.positions[-1], path.displacements[-1, :, 2]
    k = 5
    mid, angle = 0.5 * (x[k] + x[k + 1]), 0.5 * (th[k] + th[k + 1])
    c, s = math.cos(angle), math.sin(angle)
    arm = x[-1] - mid
    expected = P @ [c, s], P @ [-s, c], arm[0] * P[1] - arm[1] * P[0]
    # means of elements of 1/16: the sagitta k L^2/8 of the axis is 2e-3
    assert path.resultants[-1, k] == pytest.approx(expected, abs=2e-2)


def corner(element: str, section: PlanarSection) -> Array:
    """An L of two legs of three beams, clamped below, pushed at its end."""
    nodes = [(0.0, i / 3) for i in range(4)] + [(i / 3, 1.0) for i in range(1, 4)]
    beams = [PlanarBeam(i, i + 1, section) for i in range(6)]
    frame = PlanarFrame(
        nodes,
        beams,
        [PlanarSupport(0, rotation=True)],
        [PlanarLoad(6, force=(0.0, -1.0))],
        element=element,
    )
    return np.asarray(load_steps(frame, np.linspace(0.25, 1.0, 4)).displacements[-1, -1])


def test_corners_share_the_rotation_and_not_the_stretch() -> None:
    """The horizontal leg carries no axial force where the vertical one is compressed."""
    soft = PlanarSection(EA=100.0, GA=math.inf, EI=1.0)
    nodes = [(0.0, 0.0), (0.0, 0.5), (0.0, 1.0), (0.5, 1.0), (1.0, 1.0)]
    frame = PlanarFrame(
        nodes,
        [PlanarBeam(i, i + 1, soft) for i in range(4)],
        [PlanarSupport(0, rotation=True)],
        element="ancf",
    )
    # one stretch at each end, one at the middle of each leg, two at the corner
    assert sum(name.startswith("stretch") for name in frame.system.names) == 6
    stiff = PlanarSection(EA=100.0, GA=math.inf, EI=2.0)
    jump = PlanarFrame(
        nodes[:3],
        [PlanarBeam(0, 1, soft), PlanarBeam(1, 2, stiff)],
        [PlanarSupport(0, rotation=True)],
        element="ancf",
    )
    assert sum(name.startswith("stretch") for name in jump.system.names) == 4
    ancf, corotational = corner("ancf", soft), corner("corotational", soft)
    assert ancf == pytest.approx(corotational, abs=2e-2)


def test_small_vibrations_of_a_cantilever() -> None:
    """(1.8751)^2 and (4.6941)^2 sqrt(EI/m)/L^2 (Blevins): order 4 of cubic, 2 of linear masses."""
    exact = np.array([1.87510407, 4.69409113]) ** 2 / (2.0 * math.pi)
    for element, order in (
        (AncfElement(), 4),
        (CorotationalElement(mass="cubic"), 4),
        (CorotationalElement(), 2),
    ):
        errors = [
            planar_frequencies(chain(n, section=SLENDER, element=element))[:2] / exact - 1
            for n in (4, 8)
        ]
        assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


@ignore_shear
@pytest.mark.parametrize("scale", [1e3, 1e6])
@pytest.mark.parametrize("element", ["exact", "corotational", "ancf"])
def test_units_of_length_change_no_result(element: str, scale: float) -> None:
    """One cantilever in m, in mm and in um: residuals of moments are forces times lengths."""
    n = 8
    found = []
    for unit in (1.0, scale):
        GA = 4.6e4 if element == "exact" else math.inf
        section = PlanarSection(EA=1.2e5, GA=GA, EI=unit**2)
        loads = [PlanarLoad(n, force=(0.0, 10.0))]
        frame = chain(n, unit, section=section, loads=loads, element=element)
        path = load_steps(frame, np.linspace(0.1, 1.0, 10))
        found.append(path.displacements[-1] / (unit, unit, 1.0))
    assert found[1] == pytest.approx(found[0], abs=1e-8)


@pytest.mark.parametrize(
    ("axial", "bending", "loose"),
    [("gauss 3", "gauss 1", 1), ("gauss 2", "gauss 1", 2), ("gauss 1", "gauss 1", 3)],
)
def test_motions_without_energy_are_counted(axial: str, bending: str, loose: int) -> None:
    """A free beam has 8 unknowns, 3 rigid motions, and a strain for each point up to 3 + 2."""
    with pytest.warns(jo.JoustoWarning, match=f"leaves {loose} motions? of a free beam"):
        frame = chain(1, section=SLENDER, element=AncfElement(axial=axial, bending=bending))
    assert frame.system.groups[0].free_motions() == loose


def test_an_unknown_element_is_told_once() -> None:
    for wrong in ("corot", PlanarElement(), AncfElement, None):
        with pytest.raises(jo.InputError) as error:
            chain(2, section=SLENDER, element=wrong)
        assert len(error.value.problems) == 1, str(error.value)
        assert "element is" in str(error.value)


def test_options_and_elements_are_checked() -> None:
    with pytest.raises(jo.InputError, match="element is 'acnf', must be .*did you mean 'ancf'"):
        chain(2, element="acnf")
    with pytest.raises(jo.InputError, match="GA is infinite, and the exact element has shear"):
        chain(2, section=SLENDER)
    with pytest.raises(jo.InputError) as error:
        AncfElement(law="SB", axial="simpson")
    assert "law is 'SB', must be 'GI' or 'BS'" in str(error.value)
    assert "axial is 'simpson', must be 'lobatto 3'" in str(error.value)
    mixed = PlanarFrame(
        [(0, 0), (1, 0), (2, 0)],
        [
            PlanarBeam(0, 1, SLENDER, element=AncfElement(law="BS")),
            PlanarBeam(1, 2, SLENDER, element="corotational"),
        ],
        [PlanarSupport(0, rotation=True)],
    )
    assert [group.element.word for group in mixed.system.groups] == ["ancf", "corotational"]


def test_what_an_element_leaves_out_is_told() -> None:
    section = PlanarSection(EA=1e5, GA=4e4, EI=10.0, mass=1.0, rotary=1e-4)
    with pytest.warns(jo.JoustoWarning, match="leaves out shear .* and rotary inertia .*slender"):
        chain(2, section=section, element="ancf")
    chain(2, section=section.slender, element="ancf")
    chain(2, section=section, element="corotational")


def test_masses_and_springs_do_not_share_a_stretch() -> None:
    """A mass between two beams: the axial force jumps there in motion."""
    frame = chain(2, section=SLENDER, element="ancf", masses=[PlanarMass(1, 1.0)])
    assert sum(name.startswith("stretch") for name in frame.system.names) == 4
