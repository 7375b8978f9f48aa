"""Parts held at several places: closed forms of beams on pins and springs, reactions, mechanisms.

Numbers of beams: roots of ``sum (cot b l_i - coth b l_i) = 0`` and of the like determinants of
Euler-Bernoulli beams, steel 40 x 20 mm, 3 m, about the weak axis.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.parts import NodalForce, Weight
from jousto.parts.frames.element import EulerBernoulli
from jousto.reduction import Clamp, SpringSupport, SupportedPart, clamp
from reduction.hexes import box

STEEL = jo.Material(2.1e11, 0.3, 7850.0)
LENGTH = 3.0


def bar(elements: int, *, rotary_inertia: bool = False) -> jo.Part:
    return jo.Part.beam(
        LENGTH,
        jo.Rectangle(0.04, 0.02),
        elements,
        STEEL,
        theory=EulerBernoulli(),
        rotary_inertia=rotary_inertia,
        name="bar",
    )


def at(x: float, elements: int) -> str:
    k = round(x / LENGTH * elements)
    return {0: "start", elements: "end"}.get(k, f"node{k + 1}")


def on_pins(
    elements: int,
    pins: dict[float, float | None],
    *,
    fixed: tuple[float, ...] = (),
    settlement: float = 0.0,
) -> SupportedPart:
    """The bar in its plane x z, on rigid pins (None) or springs, N/m; the first pin settles."""
    supports: list[Clamp | SpringSupport] = [Clamp(np.arange(elements + 1), "x y rx rz")]
    for x, k in pins.items():
        node = at(x, elements)
        if k is None:
            supports.append(Clamp(node, "z", settlement=(0, 0, settlement, 0, 0, 0)))
            settlement = 0.0
        else:
            supports.append(SpringSupport(node, (0, 0, k, 0, 0, 0)))
    supports += [Clamp(at(x, elements), "ry") for x in fixed]
    return clamp(bar(elements), supports)


@pytest.mark.parametrize(
    ("pins", "fixed", "exact"),
    [
        ({0: None, 1.2: None, 3: None}, (), (17.65789699, 40.59557003)),
        ({0: None, 1.2: None, 2.4: None}, (), (22.43229026, 38.89108980)),
        ({0: None, 1.2: 2e5, 3: None}, (), (15.77886795, 27.58521502)),
        ({0: None, 1.2: None, 3: None}, (0, 3), (26.99190739,)),
        ({0: 1e5, 1.2: 5e4, 3: 1e5}, (), (10.95022338,)),
    ],
)
def test_frequencies_of_beams_on_pins_and_springs(
    pins: dict[float, float | None], fixed: tuple[float, ...], exact: tuple[float, ...]
) -> None:
    """Order 4 in the length of the elements; extrapolated from two meshes."""
    coarse, fine = (
        on_pins(n, pins, fixed=fixed).modes(2).frequencies[: len(exact)] for n in (50, 100)
    )
    np.testing.assert_allclose(fine, exact, rtol=1e-7)
    np.testing.assert_allclose(fine + (fine - coarse) / 15, exact, rtol=1e-9)


def test_own_weight_on_three_pins_and_a_settlement() -> None:
    """Reactions are exact with any mesh, since its load is consistent."""
    weight = Weight((0, 0, -9.81))
    pins = {1.2: None, 0: None, 3: None}
    state = on_pins(30, pins).statics(weight)
    middle, left, right = (state.reaction(at(x, 30))[2] for x in (1.2, 0, 3))
    assert middle == pytest.approx(119.363175, abs=1e-8)
    assert left == pytest.approx(20.792295, abs=1e-8)
    assert state.balance < 1e-9
    assert middle + left + right == pytest.approx(9.81 * bar(30).mass, rel=1e-12)
    # the middle pin 1 mm lower, with the weight and alone
    lowered = on_pins(30, pins, settlement=-1e-3)
    assert middle - lowered.statics(weight).reaction(at(1.2, 30))[2] == pytest.approx(
        10.80246914, abs=1e-8
    )
    alone = lowered.statics()
    assert alone.reaction(at(1.2, 30))[2] == pytest.approx(-10.80246914, abs=1e-8)
    assert alone.displacements[12, 2] == pytest.approx(-1e-3, rel=1e-12)
    assert alone.balance < 1e-9


def test_a_stiff_spring_is_a_pin_and_its_force_is_minus_k_u() -> None:
    load = NodalForce(at(2.1, 30), (0, 0, -50.0))
    pin = on_pins(30, {0: None, 1.2: None, 3: None}).statics(load)
    for k, tolerance in ((1e9, 1e-4), (2e5, None)):
        state = on_pins(30, {0: None, 1.2: k, 3: None}).statics(load)
        force = state.reaction(at(1.2, 30))[2]
        assert force == pytest.approx(-k * state.displacements[12, 2], rel=1e-12)
        assert state.balance < 1e-9
        if tolerance is not None:
            assert force == pytest.approx(pin.reaction(at(1.2, 30))[2], rel=tolerance)


THREE = ("start", "node25", "end")
MIDDLE = SpringSupport("node25", (0, 0, 5e4, 0, 0, 0))


@pytest.fixture(scope="module")
def full() -> jo.Part:
    return bar(60, rotary_inertia=True)


@pytest.fixture(scope="module")
def reduced(full: jo.Part) -> jo.ReducedPart:
    return jo.reduce(full, jo.CraigBampton(THREE, modes=20))


SETTLED = Clamp("node25", "z", settlement=(0, 0, 1e-3, 0, 0, 0))
LEFT = SpringSupport("start", (0, 0, 1e5, 0, 0, 0))
SKEW = np.diag([1e6, 1e6, 1e5, 2e3, 2e3, 2e3]) + 1e3 * np.ones((6, 6))
SETS: dict[str, list[str | Clamp | SpringSupport]] = {
    "pins": [Clamp("start", "x y z rx"), Clamp("node25", "y z"), Clamp("end", "y z")],
    "clamped": ["start", "end", SETTLED],
    "springs": [Clamp("start", "x y rx rz"), LEFT, MIDDLE],
    "skew": [SpringSupport("start", SKEW), MIDDLE],
}


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("frame", [None, jo.reduction.NodeFrame("start")])
def test_a_reduced_part_has_the_statics_of_the_full_one(
    name: str, frame: object, full: jo.Part, reduced: jo.ReducedPart
) -> None:
    part = reduced if frame is None else jo.reduction.in_frame(reduced, frame)  # type: ignore[arg-type]
    load = NodalForce("end", (10.0, 3.0, 5.0), (0.5, 1.0, 2.0))
    load_2 = NodalForce("node25", (0.0, 3.0, 5.0))
    exact, found = (clamp(p, SETS[name]).statics(load, load_2) for p in (full, part))
    size = np.abs(exact.displacements).max()
    np.testing.assert_allclose(found.displacements, exact.displacements, atol=1e-8 * size)
    assert max(exact.balance, found.balance) < 1e-9
    for a, b in zip(exact.reactions, found.reactions, strict=True):
        assert (a.support, a.node) == (b.support, b.node)
        np.testing.assert_allclose(b.force, a.force, atol=1e-6)
        np.testing.assert_allclose(b.moment, a.moment, atol=1e-6)
    exact_modes, modes = (clamp(p, SETS[name]).modes(4) for p in (full, part))
    np.testing.assert_allclose(modes.frequencies, exact_modes.frequencies, rtol=1e-4)
    for a, b in zip(exact_modes.shapes, modes.shapes, strict=True):
        assert abs(np.vdot(a, b)) == pytest.approx(np.linalg.norm(a) * np.linalg.norm(b), rel=1e-4)


def test_the_weight_of_a_reduced_part_is_that_of_its_modes(
    full: jo.Part, reduced: jo.ReducedPart
) -> None:
    """Reactions are in balance; the force at the middle pin is that of the shapes."""
    weight = Weight((0, 0, -9.81))
    exact, found = (clamp(p, SETS["pins"]).statics(weight) for p in (full, reduced))
    assert sum(x.force[2] for x in found.reactions) == pytest.approx(9.81 * full.mass, rel=1e-9)
    assert found.reaction("node25")[2] == pytest.approx(exact.reaction("node25")[2], rel=1e-3)


def test_a_machine_with_the_same_supports_has_the_same_frequencies(
    reduced: jo.ReducedPart,
) -> None:
    """Fixed joint and bushing beside `clamp`."""
    body = jo.FlexibleBody("bar", reduced)
    K = (1e5, 2e5, 5e4)
    joint = jo.Fixed("left", jo.ground["origin"], body["start"])
    mount = jo.Bushing(
        "mount", jo.ground.at((3.0, 0, 0)), body["end"], np.diag([*K, 100, 200, 300])
    )
    machine = jo.modes(jo.compile(jo.Mechanism(body, joint, mount)), count=6)
    part = clamp(reduced, [Clamp("start"), SpringSupport("end", (*K, 100.0, 200.0, 300.0))])
    np.testing.assert_allclose(part.modes(6).frequencies, machine.frequencies, rtol=1e-8)


def test_a_clamp_of_one_node_is_the_node_frame(reduced: jo.ReducedPart) -> None:
    alone = clamp(reduced, "start")
    assert isinstance(alone, jo.ReducedPart)
    several = clamp(reduced, [Clamp("start")]).modes(6)
    np.testing.assert_allclose(several.frequencies, alone.frequencies[:6], rtol=1e-8)


def test_a_solid_on_its_nodes_and_on_a_rigid_interface() -> None:
    """Clamped at all nodes of one face or at the interface on them: the same cantilever."""
    part = box()
    x = part.nodes[:, 0]
    face, tip = (np.flatnonzero(np.abs(x - end) < 1e-9) for end in (x.min(), x.max()))
    tied = part.with_interfaces(jo.Interface("flange", face))
    load = NodalForce(tip, (0, 0, 10))
    parts = [clamp(part, [Clamp(face)]), clamp(tied, [Clamp("flange")])]
    a, b = (some.statics(load) for some in parts)
    size = np.abs(a.displacements).max()
    np.testing.assert_allclose(a.displacements, b.displacements, atol=1e-9 * size)
    (flange,) = b.reactions
    assert flange.node == "flange"
    np.testing.assert_allclose(flange.force, (0, 0, -10), atol=1e-8)
    np.testing.assert_allclose(sum(r.force for r in a.reactions), (0, 0, -10), atol=1e-8)
    of_nodes, of_flange = (some.modes(3).frequencies for some in parts)
    np.testing.assert_allclose(of_nodes, of_flange, rtol=1e-9)
    with pytest.raises(jo.InputError, match="has nodes of interface 'flange'; hold that interface"):
        clamp(tied, [Clamp(face)])
    for support in (Clamp(face, "x y z rx"), SpringSupport(face, (1.0,) * 6)):
        with pytest.raises(jo.InputError, match=r"node\d+ has no rotations"):
            clamp(part, [support])
    average = part.with_interfaces(jo.Interface("pin", face, kind="average"))
    with pytest.raises(jo.InputError, match="'pin' is an average"):
        clamp(average, "pin")


@pytest.mark.parametrize(
    ("supports", "names"),
    [
        ([Clamp("start", "x y z")], ["rotation about x", "rotation about y", "rotation about z"]),
        ([Clamp("start", "x y z"), Clamp("end", "y z")], ["rotation about x"]),
        ([Clamp("start", "y z rx ry rz")], ["translation along x"]),
        ([Clamp("start", "x y z"), SpringSupport("node13", (0, 1, 1, 0, 0, 0))], ["about x"]),
        ([], ["rotation about x", "about y", "about z", "along x", "along y", "along z"]),
    ],
)
def test_rigid_motions_that_are_left_are_named(
    supports: list[Clamp | SpringSupport], names: list[str], reduced: jo.ReducedPart
) -> None:
    for part in (bar(12), reduced):
        if part is reduced and any(support.on not in THREE for support in supports):
            continue
        with pytest.raises(jo.InputError) as error:
            clamp(part, supports)
        text = str(error.value)
        assert f"leave {len(names)} rigid motion{'s' * (len(names) > 1)}: " in text
        assert all(name in text for name in names), text


def test_the_axis_of_a_mechanism_is_the_line_through_its_pins() -> None:
    """Two pins at points of a frame that lies askew."""
    nodes = np.array([[0.0, 0, 0], [1, 1, 0], [2, 0, 1]])
    part = jo.Part.frame(
        nodes, [[0, 1], [1, 2]], sections=jo.Rectangle(0.02, 0.01), materials=STEEL
    )
    pins = [Clamp("node2", "x y z"), Clamp("node3", "x y z")]
    with pytest.raises(jo.InputError) as error:
        clamp(part, pins)
    assert "1 rigid motion: rotation about (" in str(error.value)
    direction = np.array([1.0, -1.0, 1.0]) / 3**0.5
    assert "(" + ", ".join(f"{x:.4g}" for x in direction) + ")" in str(error.value)


def test_supports_that_move_together_strain_nothing() -> None:
    """A settlement of several nodes is one rigid motion about their centroid."""
    part = bar(10)
    ends = Clamp([0, 5, 10], settlement=(1e-3, 2e-3, 3e-3, 0, 0.01, 0))
    state = clamp(part, [ends]).statics()
    assert max(np.abs(x.force).max() for x in state.reactions) < 1e-4  # of EI w / L^2 = 600 N
    np.testing.assert_allclose(state.displacements[5], (1e-3, 2e-3, 3e-3), atol=1e-12)
    np.testing.assert_allclose(state.displacements[10, 2], 3e-3 - 0.01 * 1.5, atol=1e-12)


@pytest.mark.parametrize(
    ("supports", "message"),
    [
        ([Clamp("strat")], "no node set 'strat'.*start"),
        ([Clamp([99])], "names a node outside 0..12"),
        ([Clamp(jo.mesh.InSphere((9, 9, 9), 0.1))], "pick contains no node"),
        ([Clamp("start", "z", settlement=(1, 0, 0, 0, 0, 0)), "end"], "in x, which is free"),
        (["start", Clamp("start", "z", settlement=(0, 0, 1, 0, 0, 0))], "both hold start in z"),
        (["start", 3], "support 3 must be"),
        (7, "supports is 7"),
    ],
)
def test_wrong_supports_are_named(supports: object, message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        clamp(bar(12), supports)  # type: ignore[call-overload]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Clamp("start", "x q"), "'q', must be of x, y, z, rx"),
        (lambda: Clamp("start", ""), "empty"),
        (lambda: Clamp("start", "x x"), "twice"),
        (lambda: SpringSupport("start", np.zeros(6)), "is zero"),
        (lambda: SpringSupport("start", (1, 1, -1, 0, 0, 0)), "negative eigenvalue"),
        (lambda: SpringSupport("start", np.eye(6) + np.eye(6, k=1)), "not symmetric"),
        (lambda: SpringSupport("start", (1, 2, 3)), "shape"),
    ],
)
def test_wrong_values_are_named(make: object, message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        make()  # type: ignore[operator]


def test_a_reduced_part_is_held_at_its_interfaces_alone(reduced: jo.ReducedPart) -> None:
    for support in (Clamp("node7"), SpringSupport("node7", (1e5,) * 6)):
        with pytest.raises(jo.InputError, match=r"node7 is no interface \(there are: start, node"):
            clamp(reduced, [Clamp("start"), support])
    one = clamp(reduced, [Clamp("start")])
    with pytest.raises(jo.InputError, match="node7 is no interface"):
        one.statics(NodalForce("node7", (1, 0, 0)))
    part = bar(12, rotary_inertia=True)
    few = jo.reduce(part, jo.FreeFree(modes=3, interfaces=("start", "end"))).keep([0, 1])
    with pytest.raises(jo.InputError, match="do not move the 2 supported nodes independently"):
        clamp(few, [Clamp("start"), Clamp("end")])
