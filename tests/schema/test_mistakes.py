"""Every mistake in a model file is reported with its file, line, field and the remedy."""

from __future__ import annotations

import warnings

import pytest

from jousto.base.errors import InputError, JoustoWarning
from jousto.schema.read import parse_model
from schema.models import PENDULUM


def problems(text: str) -> list[str]:
    with pytest.raises(InputError) as error, warnings.catch_warnings():
        warnings.simplefilter("ignore", JoustoWarning)
        parse_model(text, name="m.yaml")
    return [str(problem) for problem in error.value.problems]


def changed(*changes: tuple[str, str]) -> list[str]:
    """Return the problems of the pendulum with some text replaced."""
    text = PENDULUM
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return problems(text)


# -- mistakes -------------------------------------------------------------------------------

SINGLE = [
    # (old, new, line, rest of the sentence)
    ("name: flexible pendulum", "name: ''", 1, "name: is empty"),
    ("name: flexible pendulum", "name: 3", 1, "name: expects text, got 3; put it in quotes"),
    ("type: beam", "type: baem", 4, "parts.rod.type: no part type 'baem'; did you mean 'beam'?"),
    ("    type: beam\n", "", 3, "parts.rod: 'type' of the part is missing"),
    ("2 m\n", "210 GPa\n", 5, "parts.rod.length: expects a length (m), got 210 GPa (a pressure)"),
    ("2 m\n", ".nan\n", 5, "parts.rod.length: is nan, must be finite"),
    ("2 m\n", "-2\n", 5, "parts.rod.length: length is -2 m, must be a positive number"),
    ("    length: 2 m\n", "", 3, "parts.rod: 'length' is missing"),
    ("rectangle", "rectangl", 6,
     "parts.rod.section.type: no section type 'rectangl'; did you mean 'rectangle'?"),
    ("height: 0.1", "hight: 0.1", 6, "parts.rod.section: 'height' is missing"),
    ("height: 0.1", "height: -0.1", 6,
     "parts.rod.section.height: height is -0.1 m, must be a positive number"),
    ("section: {type: rectangle, width: 100 mm, height: 0.1}", "section: square", 6,
     "parts.rod.section: expects a mapping with a type, got 'square'"),
    ("7.85 g/cm3", "-7850", 7,
     "parts.rod.material.rho: density rho is -7850 kg/m^3, must be zero or positive"),
    ("nu: 0.3", "nu: 0.7", 7,
     "parts.rod.material.nu: Poisson's ratio nu is 0.7, must be in (-1, 0.5]"),
    ("210 GPa", "210 Gpa", 7, "parts.rod.material.E: no unit 'Gpa'; did you mean 'GPa'?"),
    ("elements: 4", "elements: 4.5", 8, "parts.rod.elements: expects a whole number, got 4.5"),
    ("elements: 4", "elements: true", 8, "parts.rod.elements: expects a whole number, got true"),
    ("lumped: true", "lumpd: true", 9,
     "parts.rod.lumpd: unknown key 'lumpd'; did you mean 'lumped'?"),
    ("lumped: true", "lumped: maybe", 9,
     "parts.rod.lumped: expects true or false, got 'maybe'"),
    ("euler-bernoulli", "euler", 10,
     "parts.rod.theory.type: no theory type 'euler'; known: timoshenko, euler-bernoulli"),
    ("craig-bampton", "craig", 11,
     "parts.rod.reduce.type: no reduction type 'craig'; known: craig-bampton, free-free, "
     "shape-functions"),
    ("[start]", "[strat]", 11,
     "parts.rod.reduce: no node set 'strat'; did you mean 'start'?"),
    ("[start]", "start", 11, "parts.rod.reduce.interfaces: expects a list, got 'start'"),
    ("modes: 4", "modes: -4", 11, "parts.rod.reduce.modes: modes is -4"),
    ("part: rod", "part: rdo", 13, "bodies.0.part: no part 'rdo'; did you mean 'rod'?"),
    ("part: rod, damping: 0.0", "prt: rod", 13,
     "bodies.0: give part: NAME for a flexible body, mass and inertia for a rigid one, or points "
     "and section for an exact beam"),
    ("damping: 0.0", "damping: -1", 13,
     "bodies.0.damping: the ratio -1 must be 0 or positive"),
    ("damping: 0.0", "damping: [0.1, x]", 13,
     "bodies.0.damping.1: expects a number, got 'x'"),
    ("position: [0, 0, 0]", "position: [0, 0]", 13,
     "bodies.0.position: expects a list of 3 numbers, got a list of 2"),
    ("position: [0, 0, 0]", "position: [0, 0, 1 kg]", 13,
     "bodies.0.position.2: expects a length (m), got 1 kg (a mass)"),
    ("position: [0, 0, 0]", "position: [0, 2 mm, 0]", 15,
     "joints.0: initial gap of 2 mm: ground.origin is at (0, 0, 0), arm.start at (0, 0.002, 0) m; "
     "move a body until the points meet"),
    ("position: [0, 0, 0]", "orientation: [1, 1, 0, 0]", 13,
     "bodies.0.orientation: orientation [1.0, 1.0, 0.0, 0.0] has length 1.41421; "
     "Euler parameters (scalar first) must have length 1"),
    ("position: [0, 0, 0]", "orientation: [1, 0]", 13,
     "bodies.0.orientation: expects {axis: [x, y, z], angle_deg: ...}, four Euler parameters "
     "(scalar first), the three rows of a rotation matrix or {euler_deg: [a, b, c], "
     "convention: ZXZ}, got a list of 2"),
    ("position: [0, 0, 0]", "orientation: {euler_deg: [1, 2, 3], convention: '313'}", 13,
     "bodies.0.orientation.convention: convention is '313', must be three axes, neighbours "
     "different: capitals such as 'ZXZ' for the axes of the rotated body (intrinsic), small "
     "letters such as 'zxz' for those of the world (extrinsic); did you mean 'ZXZ'?"),
    ("position: [0, 0, 0]", "orientation: {euler_deg: [1, 2, 3]}", 13,
     "bodies.0.orientation: 'convention' is missing"),
    ("position: [0, 0, 0]", "orientation: {axis: [0, 0, 0], angle_deg: 3}", 13,
     "bodies.0.orientation.axis: axis is (0, 0, 0), must have a direction"),
    ("position: [0, 0, 0]", "orientation: {axis: [0, 0, 1], angle_deg: 3 m}", 13,
     "bodies.0.orientation.angle_deg: expects an angle (rad), got 3 m (a length)"),
    ("position: [0, 0, 0]", "drop_invariants: [I5, I7]", 13,
     "bodies.0.drop_invariants.1: "),
    ("b: arm.start", "b: amr.start", 15, "joints.0.b: no body 'amr'; did you mean 'arm'?"),
    ("b: arm.start", "b: arm.strat", 15,
     "joints.0.b: body 'arm': no node 'strat'; did you mean 'start'?"),
    ("b: arm.start", "b: arm", 15,
     "joints.0.b: expects a marker such as arm.tip or ground.origin, got 'arm'"),
    ("b: arm.start", "b: {body: arm}", 15,
     "joints.0.b: give either point: NAME or at: [x, y, z]"),
    ("b: arm.start", "b: {body: arm, at: [0, 1, 0]}", 15,
     "joints.0.b.at: body 'arm': point (0, 1, 0) lies 1 m from the axis of the nearest beam"),
    ("b: arm.start", "b: {body: ram, point: start}", 15,
     "joints.0.b.body: no body 'ram'; did you mean 'arm'?"),
    ("b: arm.start", "b: ground.origin", 15,
     "joints.0: both markers are on the ground, ground.origin and ground.origin"),
    ("type: spherical", "type: sphericl", 15,
     "joints.0.type: no joint type 'sphericl'; did you mean 'spherical'?"),
    ("type: spherical", "type: spherical, axis: [0, 0, 1]", 15,
     "joints.0.axis: unknown key 'axis'"),
    ("[0, -9.81, 0]", "-9.81", 16, "gravity: expects a list of 3 numbers, got -9.81"),
    ("[0, -9.81, 0]", "[0, -9.81 m/s, 0]", 16,
     "gravity.1: expects an acceleration (m/s2), got -9.81 m/s (a velocity)"),
    ("type: position", "type: positon", 18,
     "sensors.0.type: no sensor type 'positon'; did you mean 'position'?"),
    ("marker: arm.node3", "marker: arm.node9", 18,
     "sensors.0.marker: body 'arm': no node 'node9'; did you mean 'node"),
    ("type: position, name: middle, marker: arm.node3", "type: reaction, name: r, joint: pivto", 18,
     "sensors.0.joint: no joint 'pivto'; did you mean 'pivot'?"),
    ("type: position, name: middle, marker: arm.node3", "type: modal, name: r, body: am", 18,
     "sensors.0.body: no body 'am'; did you mean 'arm'?"),
    ("type: position, name: middle, marker: arm.node3",
     "type: stress, name: r, body: arm, sites: [e1.a.topp]", 18,
     "sensors.0.sites: body 'arm' has no stress site 'e1.a.topp'; did you mean 'e1.a.top'?"),
    ("t_end: 10 s", "t_end: -10 s", 19, "simulation.t_end: is -10 s, must be positive"),
    ("t_end: 10 s, ", "", 19, "simulation: 't_end' is missing"),
    ("t_end: 10 s", "t_end: 10 s, start: settled", 19,
     "simulation.start: no start 'settled'; known: initial, rest, vibration-free"),
    ("RK4", "RK5", 19, "simulation.solver.type: no solver type 'RK5'; did you mean 'RK4'?"),
    ("step: 1e-3", "step: 0", 19, "simulation.solver.step: is 0 s, must be positive"),
    ("step: 1e-3", "step: 1e-3, baumgarte: {alpha: -1, beta: 1}", 19,
     "simulation.solver.baumgarte.alpha: alpha is -1.0, must be 0 or more, 1/s"),
    ("output_step: 0.01", "output_step: 1 mm", 19,
     "simulation.output_step: expects a time (s), got 1 mm (a length)"),
    ("sensors:\n", "sensor:\n", 17, "sensor: unknown key 'sensor'; did you mean 'sensors'?"),
    ("sensors:\n  - {type: position, name: middle, marker: arm.node3}", "sensors: none", 17,
     "sensors: expects a list, got 'none'"),
    ("bodies:\n  - {name: arm", "bodies: {name: arm", 12, "bodies: expects a list, got a mapping"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "sentence"), SINGLE, ids=[s[1] for s in SINGLE])
def test_a_mistake_has_its_line_field_and_remedy(old, new, line, sentence):
    found = changed((old, new))
    assert any(text.startswith(f"m.yaml:{line}: {sentence}") for text in found), found
    # no second problem that only follows from the first
    allowed = 2 if new.startswith(("hight", "prt")) else 1
    assert len(found) <= allowed, found


def test_all_kinds_of_mistakes_are_reported_at_once_in_the_order_of_the_file():
    found = changed(
        ("elements: 4", "elements: four"),  # a value
        ("damping: 0.0", "damping: 0.0, mas: 3"),  # an unknown key
        ("b: arm.start", "b: amr.start"),  # a reference
        ("type: position, name: middle, marker: arm.node3}",
         "type: position, name: middle, marker: ground.top}\n"  # a constructor
         "  - {type: modal, name: m, body: arm}"),  # refers to a broken body: not reported
        ("gravity:", "gravty:"),
    )  # fmt: skip
    assert [text.split(": ")[:2] for text in found] == [
        ["m.yaml:8", "parts.rod.elements"],
        ["m.yaml:13", "bodies.0.mas"],
        ["m.yaml:15", "joints.0.b"],
        ["m.yaml:16", "gravty"],
        ["m.yaml:18", "sensors.0.marker"],
    ]


def test_what_stands_beside_a_mistake_is_checked_in_its_own_place():
    part = """\
  other:
    type: beam
    length: long
bodies:
  - {name: lost, part: other}
"""
    joint = """\
  - {type: fxied, name: weld, a: ground.origin, b: arm.start}
  - {type: spherical, name: hook, a: ground.origin, b: lost.start}
"""
    found = changed(
        ("bodies:\n", part),
        ("b: arm.start", "b: arm.strat"),
        ("joints:\n", f"joints:\n{joint}"),
    )
    assert found == [
        "m.yaml:12: parts.other: 'reduce' is missing",
        "m.yaml:12: parts.other: 'section' is missing",
        "m.yaml:12: parts.other: 'elements' is missing",
        "m.yaml:12: parts.other: 'material' is missing",
        "m.yaml:14: parts.other.length: expects a length such as 3 or '3 m', got 'long'",
        "m.yaml:19: joints.0.type: no joint type 'fxied'; did you mean 'fixed'?",
        "m.yaml:21: joints.2.b: body 'arm': no node 'strat'; did you mean 'start'?",
    ]


def test_problems_of_the_whole_mechanism_are_placed_too():
    found = changed(
        ("gravity:", "  - {type: spherical, name: pivot, a: ground.origin, b: arm.end}\ngravity:")
    )
    assert found == [
        "m.yaml:16: joints.1.name: 2 joints have this name, names must differ",
        "m.yaml:16: joints.1: initial gap of 2000 mm: ground.origin is at (0, 0, 0), arm.end at "
        "(2, 0, 0) m; move a body until the points meet",
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("name: x\n", ["m.yaml:1: 'bodies' is missing"]),
        ("bodies: []\n", ["m.yaml:1: mechanism: has no bodies"]),
        ("bodies: [3]\n", ["m.yaml:1: bodies.0: expects a mapping with a type, got 3"]),
        ("bodies:\n", ["m.yaml:1: bodies: expects a list, got nothing"]),
        (
            "bodies: [{name: a, mass: -1, inertia: [1, 1, 5]}]\n",
            [
                "m.yaml:1: bodies.0.mass: mass is -1 kg, must be a positive number",
                "m.yaml:1: bodies.0.inertia: inertia violates the triangle inequality: principal "
                "moments 1, 1, 5 kg m2, the largest must not exceed the sum of the others, 2",
            ],
        ),
        (
            "bodies: [{name: a, mass: 1, inertia: 3}]\n",
            ["m.yaml:1: bodies.0.inertia: expects a list of 3 numbers, got 3"],
        ),
        (
            "parts: {a: {file: x.h5, keep: [0], in_plane: xy}}\nbodies: [{name: a, part: a}]\n",
            ["m.yaml:1: parts.a.keep: give either keep or in_plane, not both"],
        ),
        (
            "parts: {a: {file: x.h5, in_plane: zz}}\nbodies: [{name: a, part: a}]\n",
            ["m.yaml:1: parts.a.in_plane: no in_plane 'zz'; known: xy, yz, xz"],
        ),
        (
            "parts: [a]\nbodies: [{name: a, part: a}]\n",
            ["m.yaml:1: parts: expects a mapping (key: value), got a list of 1"],
        ),
        (
            "bodies: [{name: a, mass: 1, inertia: [1, 1, 1]}]\n"
            "forces: [{type: force, name: f, marker: a.origin, vector: [1, 0, 0],\n"
            "  signal: {type: table, times: [0, 0], values: [1, 1]}}]\n",
            ["m.yaml:3: forces.0.signal.times: times must increase: times[0] = 0 s, "
             "times[1] = 0 s"],
        ),
        (
            "bodies: [{name: a.b, mass: 1, inertia: [1, 1, 1]}]\n",
            ["m.yaml:1: bodies.0.name: name must not contain '.'"],
        ),
    ],
)  # fmt: skip
def test_small_broken_models(text, expected):
    assert problems(text) == expected


def test_warnings_have_their_line():
    text = PENDULUM.replace("210 GPa", "210000")
    with pytest.warns(JoustoWarning) as caught:
        parse_model(text, name="m.yaml")
    assert [str(w.message) for w in caught] == [
        "m.yaml:7: parts.rod.material.E: E = 210000 Pa is softer than most plastics; was it given "
        "in MPa?"
    ]
    text = PENDULUM.replace("damping: 0.0", "damping: 2")
    with pytest.warns(JoustoWarning) as caught:
        parse_model(text, name="m.yaml")
    assert [str(w.message) for w in caught] == [
        "m.yaml:13: bodies.0.damping: the ratio 2 is above 1 (is it in per cent?)"
    ]


def test_an_unknown_key_beside_all_known_ones_lists_them():
    text = "  - {type: position, name: middle, marker: arm.node3}"
    assert changed((text, "  - {type: modal, name: middle, body: arm, extra: 1}")) == [
        "m.yaml:18: sensors.0.extra: unknown key 'extra'; known: type, name, body"
    ]


def test_a_key_that_is_there_already_is_not_proposed():
    text = "  - {type: position, name: middle, marker: arm.node3}"
    assert changed((text, "  - {type: modal, nam: 1, name: middle}")) == [
        "m.yaml:18: sensors.0: 'body' is missing",
        "m.yaml:18: sensors.0.nam: unknown key 'nam'; known: body",
    ]


def test_a_force_on_the_ground_is_a_warning_with_its_line():
    force = "forces:\n  - {type: force, name: push, marker: ground.origin, vector: [1, 0, 0]}\n"
    with pytest.warns(JoustoWarning) as caught:
        parse_model(PENDULUM.replace("sensors:\n", force + "sensors:\n"), name="m.yaml")
    assert [str(item.message) for item in caught] == [
        "m.yaml:18: forces.0: acts on the ground, it has no effect"
    ]


def test_thousands_of_mistakes_are_told_once_each() -> None:
    n = 3000
    bodies = "".join(f"  - {{name: b{i}, mass: 1, inertia: [1, 1, 1]}}\n" for i in range(20))
    joints = "".join(
        f"  - {{type: spherical, name: j{i}, a: ground.origin, b: c{i}.origin}}\n" for i in range(n)
    )
    told = problems(f"bodies:\n{bodies}joints:\n{joints}")
    assert len(told) == n and all(f"no body 'c{i}'" in told[i] for i in range(n))
    # likely names are looked for while a person may still read them
    assert "known: b0" in told[0] and told[-1].endswith(f"no body 'c{n - 1}'")


NAMING = """\
bodies:
  - {name: block, mass: 1 kg, inertia: [1, 1, 1], markers: {tip: [1, 0, 0]}}
joints:
  - {type: revolute, name: hinge, a: ground.orign, b: blok.tip, axs: [0, 0, 1]}
  - {type: revolute, name: weld, a: ground, b: block.tap, axis: [0, 0]}
couplings:
  - {type: gear, name: gears, a: hing.angle, b: hinge.angle, rat: 2}
forces:
  - {type: spring, name: spring, coordinate: wedl.angle, stiffness: 1 m}
frictions:
  - {name: rub, joint: hings, mu_kinetic: -}
sensors:
  - {type: force, name: f, force: sprang, unit: N}
events:
  - {name: stop, watch: fs, threshold: 1 kg}
"""


def test_names_beside_other_mistakes_of_an_entry_are_told_in_the_same_pass():
    found = problems(NAMING)
    for line, sentence in (
        (4, "joints.0.a: ground: no point 'orign'"),
        (4, "joints.0.b: no body 'blok'; did you mean 'block'?"),
        (5, "joints.1.b: body 'block': no marker 'tap'; did you mean 'tip'?"),
        (7, "couplings.0.a: no joint 'hing'; did you mean 'hinge'?"),
        (9, "forces.0.coordinate: no joint 'wedl'; did you mean 'weld'?"),
        (11, "frictions.0.joint: no joint 'hings'; did you mean 'hinge'?"),
        (13, "sensors.0.force: no force 'sprang'; did you mean 'spring'?"),
    ):
        assert any(text.startswith(f"m.yaml:{line}: {sentence}") for text in found), (line, found)
    # what was wrong as text is told once, and broken entries are no unknown names
    assert sum("joints.1.a:" in text for text in found) == 1
    assert not any("no joint 'hinge'" in text for text in found)
