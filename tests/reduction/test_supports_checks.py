"""Checks of supports: directions held twice, clamps one after another, soft springs, wrong values.

A prismatic bar on equal springs k at both ends has the rigid modes ``sqrt(2 k / m) / 2 pi``.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.parts import NodalForce, Weight
from jousto.reduction import Clamp, SpringSupport, clamp
from jousto.reduction.supports import supported
from jousto.reduction.supports.restraints import RigidSupport
from jousto.reduction.supports.softness import check_softness
from reduction.hexes import box

STEEL = jo.Material(2.1e11, 0.3, 7850.0)
WEIGHT = Weight((0, 0, -9.81))
SIX = "x y z rx ry rz"


@pytest.fixture(scope="module")
def bar() -> jo.Part:
    return jo.Part.beam(3.0, jo.Rectangle(0.04, 0.02), 30, STEEL, name="bar")


@pytest.fixture(scope="module")
def rod(bar: jo.Part) -> jo.ReducedPart:
    return jo.reduce(bar, jo.CraigBampton(("start", "node13", "end"), modes=6))


def refusal(part: object, supports: object) -> str:
    with pytest.raises(jo.InputError) as error:
        clamp(part, supports)  # type: ignore[call-overload]
    return " ".join(str(error.value).split())


@pytest.mark.parametrize(
    ("supports", "message"),
    [
        (["start", "start"], "supports 1 and 2, each Clamp on 'start', both hold start in " + SIX),
        (
            ["start", Clamp("end", "z"), Clamp("end", "z ry")],
            "supports 2 and 3, each Clamp on 'end', both hold end in z;",
        ),
        (
            ["start", SpringSupport("start", (1e5,) * 6), Clamp("start", "x")],
            "supports 1 and 3, each Clamp on 'start', both hold start in x;",
        ),
    ],
)
def test_a_direction_is_held_once(
    supports: list[Clamp], message: str, bar: jo.Part, rod: jo.ReducedPart
) -> None:
    """Each of two supports would list the full reaction."""
    for part in (bar, rod):
        assert message in refusal(part, supports)


def test_node_sets_that_share_nodes_and_all_problems_at_once(bar: jo.Part) -> None:
    text = refusal(bar, [Clamp([0, 30]), Clamp([30], "z"), Clamp([28, 29, 30], "x rx")])
    assert "support 1 (Clamp on 2 nodes) and support 2 (Clamp on 1 node) both hold end in z" in text
    assert "and support 3 (Clamp on 3 nodes) both hold end in x rx" in text
    assert "give each direction of a node to one support" in text
    text = refusal(bar, [Clamp(np.arange(31)), Clamp(np.arange(31), "z")])
    assert "both hold start, node2, node3 and 28 more nodes in z" in text
    # a node beside the set that contains it
    text = refusal(bar, ["start", Clamp("node1", "z"), SpringSupport("start", np.zeros(6) + 1e3)])
    assert "support 1 (Clamp on 'start') and support 2 (Clamp on 'node1') both hold" in text


def test_an_interface_is_held_once() -> None:
    part = box()
    face = np.flatnonzero(np.abs(part.nodes[:, 0] - part.nodes[:, 0].min()) < 1e-9)
    tied = part.with_interfaces(jo.Interface("flange", face))
    text = refusal(tied, ["flange", Clamp("flange", "rx")])
    assert "both hold flange in rx" in text


def test_a_support_object_is_listed_once(bar: jo.Part) -> None:
    spring = SpringSupport("end", (0, 0, 1e4, 0, 0, 0))
    same = "supports 2 and 3 are the same SpringSupport on 'end'; leave one out"
    assert same in refusal(bar, ["start", spring, spring])
    held = Clamp("start")
    text = refusal(bar, [held, held])
    assert "supports 1 and 2 are the same Clamp on 'start'; leave one out" in text
    assert "both hold" not in text


def test_supports_share_a_node_by_direction_and_springs_add(bar: jo.Part) -> None:
    state = clamp(bar, ["start", Clamp("end", "z"), Clamp("end", "x y")]).statics(WEIGHT)
    one = clamp(bar, ["start", Clamp("end", "x y z")]).statics(WEIGHT)
    np.testing.assert_allclose(state.reaction("end"), one.reaction("end"), atol=1e-9)
    # k1 + k2 beside one spring of the sum; force and balance of all reported reactions
    springs = [SpringSupport("end", (0, 0, k, 0, 0, 0)) for k in (1e4, 2e4, 3e4)]
    two, sum_of_two = (
        clamp(bar, ["start", *some]).statics(WEIGHT) for some in (springs[:2], springs[2:])
    )
    assert two.reaction("end")[2] == pytest.approx(sum_of_two.reaction("end")[2], rel=1e-10)
    for some in (state, one, two):
        total = sum(x.force[2] for x in some.reactions)
        assert total == pytest.approx(9.81 * bar.mass, rel=1e-10)


def test_the_balance_is_that_of_the_reported_reactions(
    bar: jo.Part, rod: jo.ReducedPart, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a reaction listed twice it is (2 W - W) / (2 W + W), the force, or that moment."""
    monkeypatch.setattr(supported, "check_overlaps", lambda *_: None)
    for part in (bar, rod):
        with pytest.warns(jo.JoustoWarning, match="balance only to"):
            twice = clamp(part, ["start", "start"]).statics(WEIGHT)
        assert twice.balance > 0.3
        assert clamp(part, ["start"]).statics(WEIGHT).balance < 1e-9


@pytest.mark.parametrize("supports", ["end", ["end"], ["start"], [Clamp("end", "z")]])
def test_a_clamped_part_is_not_clamped_again(supports: object, rod: jo.ReducedPart) -> None:
    """Its modes have the frame of that node, which the second clamp would forget."""
    once = clamp(rod, "start")
    text = refusal(once, supports)
    assert "already clamped at 'start'" in text
    named = "'end'" if "end" in supports else "..."  # type: ignore[operator]
    assert f"clamp(part, ['start', {named}])" in text


def test_a_clamped_part_stays_refused_from_a_file(rod: jo.ReducedPart, tmp_path: object) -> None:
    path = f"{tmp_path}/once.npz"
    clamp(rod, "start").save(path)
    assert "already clamped at 'start'" in refusal(jo.ReducedPart.load(path), ["end"])


def test_a_part_seen_from_a_node_is_not_clamped(rod: jo.ReducedPart) -> None:
    """`in_frame` chooses a frame alone, also after a clamp."""
    free = clamp(rod, ["start", "end"]).modes(3).frequencies
    for part in (rod, clamp(rod, "start")):
        seen = jo.reduction.in_frame(part, jo.reduction.NodeFrame("end"))
        found = clamp(seen, ["start", "end"]).modes(3).frequencies
        np.testing.assert_allclose(found, free, rtol=1e-8)


def test_supports_of_a_supported_part_are_listed_together(bar: jo.Part) -> None:
    text = refusal(clamp(bar, ["start"]), ["end"])
    assert "list all supports together: clamp(part, [...])" in text


def on_springs(part: jo.Part | jo.ReducedPart, k: float) -> jo.reduction.SupportedPart:
    return clamp(part, [SpringSupport(end, (k,) * 6) for end in ("start", "end")])


@pytest.mark.parametrize("k", [1e-12, 1e-6])
def test_springs_below_rounding_are_named(k: float, bar: jo.Part, rod: jo.ReducedPart) -> None:
    """Of the bar, x is the direction of the largest stiffness."""
    for part in (bar, rod):
        with pytest.raises(jo.InputError) as error:
            on_springs(part, k)
        text = " ".join(str(error.value).split())
        assert "SpringSupport on 'start' and SpringSupport on 'end' are too soft" in text
        assert f" with {2 * k:.3g} N/m, must be at least" in text
        if part is bar:
            assert f"the translation along x with {2 * k:.3g} N/m" in text


def test_the_least_stiffness_in_the_message_is_enough(bar: jo.Part) -> None:
    """Of translations along x: 1e-13 of sum K_ii = 60 EA / l."""
    least = 1e-13 * 60 * 2.1e11 * 8e-4 / 0.1
    text = refusal(bar, [SpringSupport("start", (1e-6, *(1e6,) * 5))])
    assert "SpringSupport on 'start' is too soft beside the part" in text
    assert f"along x with 1e-06 N/m, must be at least {least:.3g} N/m" in text
    clamp(bar, [SpringSupport("start", (1.01 * least, *(1e6,) * 5))])


def test_springs_above_the_limit_have_the_rigid_modes_of_the_closed_form(
    bar: jo.Part, rod: jo.ReducedPart
) -> None:
    """To 0.1 %, in statics and modes, down to the first spring that is refused."""
    for part in (bar, rod):
        k = 1.0
        while True:
            try:
                held = on_springs(part, k)
            except jo.InputError:
                break
            found = held.modes(3).frequencies
            np.testing.assert_allclose(found, np.sqrt(2 * k / bar.mass) / (2 * np.pi), rtol=1e-3)
            state = held.statics(WEIGHT)
            total = sum(x.force[2] for x in state.reactions)
            assert total == pytest.approx(9.81 * bar.mass, rel=1e-6)
            assert state.balance < 1e-6
            k *= 0.5
        assert k < 0.02


def test_a_soft_spring_beside_a_clamp_or_stiff_springs_is_good(bar: jo.Part) -> None:
    alone = clamp(bar, ["start"]).modes(3).frequencies
    soft = SpringSupport("end", (0, 0, 1e-6, 0, 0, 0))
    found = clamp(bar, ["start", soft]).modes(3).frequencies
    np.testing.assert_allclose(found, alone, rtol=1e-9)
    for k in (1e12, 1e20, 1e30):
        stiff = [SpringSupport("start", (k,) * 3 + (10.0,) * 3), Clamp("end", "y z")]
        assert clamp(bar, stiff).modes(3).frequencies[0] > 1.0
        # one direction alone is soft: rotation about the axis, 1e-9 N m/rad
        text = refusal(bar, [SpringSupport("start", (k,) * 3 + (1e-9, k, k))])
        assert "the rotation about x through (1.5, 0, 0) m with 1e-09 N m/rad" in text


def test_clamps_close_together_are_rigid(bar: jo.Part) -> None:
    """Two pins with a lever of 1e-8 of the part hold a rotation; a spring of 1e-16 does not."""
    some = clamp(bar, ["start"])
    rows = np.eye(6)
    rows[5, 2] = 1.0
    rows[5, 5] = 1e-8
    for k in (np.inf, 1e-16):
        stiffness = np.array([np.inf] * 5 + [k])
        owners = np.array([-1] * 5 + [-1 if k == np.inf else 0])
        found = RigidSupport(rows, stiffness, owners)
        spring = (SpringSupport("start", (1.0,) * 6),)
        if k == np.inf:
            check_softness(some._system, spring, found, some._rigid)
            continue
        with pytest.raises(jo.InputError, match="SpringSupport on 'start' is too soft"):
            check_softness(some._system, spring, found, some._rigid)


def test_the_limit_is_relative_to_the_part() -> None:
    """Springs of 5 mN/m hold a part of plastic, and are too soft beside the same one of steel."""
    for E in (1e9, 2e11):
        part = jo.Part.beam(1.0, jo.Rectangle(0.1, 0.1), 10, jo.Material(E, 0.3, 1000.0))
        if E > 1e9:
            assert "too soft beside" in refusal(part, [SpringSupport("start", (5e-3,) * 6)])
            continue
        found = on_springs(part, 5e-3).modes(1).frequencies[0]
        assert found == pytest.approx(np.sqrt(1e-2 / part.mass) / (2 * np.pi), rel=1e-3)


@pytest.mark.parametrize(
    ("count", "message"),
    [("3", "count is '3', a str, must be a whole number"), (0, "count is 0"), (1.5, "is 1.5")],
)
def test_a_wrong_number_of_modes_is_named(count: object, message: str, bar: jo.Part) -> None:
    with pytest.raises(jo.InputError, match=message):
        clamp(bar, ["start"]).modes(count)  # type: ignore[arg-type]


@pytest.mark.parametrize("load", ["weight", None, [WEIGHT, WEIGHT], {"a": 1}, 9.81])
def test_wrong_loads_are_named_with_what_is_accepted(
    load: object, bar: jo.Part, rod: jo.ReducedPart
) -> None:
    for part in (bar, rod):
        with pytest.raises(jo.InputError) as error:
            clamp(part, ["start"]).statics(load)
        text = " ".join(str(error.value).split())
        assert "load 1: is " in text
        assert "Weight" in text
        assert "NodalForce" in text
        assert ("array (186,) of forces" in text) == (part is bar)
    with pytest.raises(jo.InputError, match=r"shape \(3,\), must be \(186\)"):
        clamp(bar, ["start"]).statics(np.zeros(3))


def test_the_result_of_part_load_is_a_load(bar: jo.Part) -> None:
    held = clamp(bar, ["start"])
    a, b = (held.statics(f).reaction("start") for f in (WEIGHT, bar.load(WEIGHT)))
    np.testing.assert_allclose(a, b, rtol=1e-12)


def test_a_marker_is_no_node_of_a_part(bar: jo.Part, rod: jo.ReducedPart) -> None:
    marker = jo.FlexibleBody("boom", rod)["end"]
    hint = "marker of body 'boom'; use the name of the node, 'end'"
    for support in (Clamp, lambda x: SpringSupport(x, (1e5,) * 6)):
        with pytest.raises(jo.InputError) as error:
            support(marker)
        assert hint in " ".join(str(error.value).split())
    for supports in ([marker], marker, ["start", marker]):
        assert hint in refusal(bar, supports)


@pytest.mark.parametrize("on", [None, 1.5, []])
def test_what_is_no_node_is_shown(on: object, bar: jo.Part) -> None:
    assert f"on is {on!r}, must be" in refusal(bar, [Clamp(on)])


def test_loads_in_the_wrong_place_do_not_pass() -> None:
    """A mistyped load beside good ones is reported with them."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.1, 0.1), 4, STEEL)
    with pytest.raises(jo.InputError, match="load 2: is 'weight'"):
        clamp(part, ["start"]).statics(NodalForce("end", (1, 0, 0)), "weight")
