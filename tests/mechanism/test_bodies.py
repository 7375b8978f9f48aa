"""Bodies and markers: what is accepted, where things are, what is refused."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jousto.base.errors import InputError
from jousto.base.rotations import Rotate, rotation_matrix
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody, ground
from jousto.mechanism.bodies.inertia import rigid_mass
from jousto.reduction.damping import Rayleigh


def messages(make) -> list[str]:
    with pytest.raises(InputError) as error:
        make()
    return [str(problem) for problem in error.value.problems]


# -- ground and rigid bodies ----------------------------------------------------------------


def test_ground_has_an_origin_and_points_anywhere():
    assert ground["origin"].r.tolist() == [0, 0, 0]
    marker = ground.at((1, 2, 3), Rotate((0, 0, 1), degrees=90), name="post")
    assert marker.label == "ground.post"
    np.testing.assert_allclose(marker.A @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    assert messages(lambda: ground["orgin"]) == [
        "ground: no point 'orgin'; did you mean 'origin'?; "
        "other points of the ground are ground.at((x, y, z))"
    ]


def test_rigid_body_markers_are_where_the_pose_puts_them():
    body = RigidBody(
        "b", 2, (1, 1, 1), center=(0, 0, 1), markers={"tip": (1, 0, 0)},
        position=(10, 0, 0), orientation=Rotate((0, 0, 1), degrees=90),
    )  # fmt: skip
    np.testing.assert_allclose(body["tip"].r, [10, 1, 0], atol=1e-15)
    np.testing.assert_allclose(body["center"].r, [10, 0, 1], atol=1e-15)
    np.testing.assert_allclose(body["origin"].r, [10, 0, 0], atol=1e-15)
    np.testing.assert_allclose(body.at((0, 2, 0)).r, [8, 0, 0], atol=1e-14)
    turned = body["tip"].turned(Rotate((0, 0, 1), degrees=90))
    np.testing.assert_allclose(turned.A @ [1, 0, 0], [-1, 0, 0], atol=1e-15)


def test_inertia_of_three_numbers_is_a_diagonal_and_tensors_are_kept():
    np.testing.assert_array_equal(RigidBody("b", 1, (1, 2, 2.5)).inertia, np.diag([1, 2, 2.5]))
    J = np.array([[2, -0.1, 0], [-0.1, 2, 0], [0, 0, 2]])
    np.testing.assert_array_equal(RigidBody("b", 1, J).inertia, J)


def test_a_plate_may_reach_the_triangle_inequality():
    # a plane body has J3 = J1 + J2 exactly
    plate = RigidBody("plate", 1, (0.1, 0.2, 0.1 + 0.2))
    np.testing.assert_array_equal(plate.inertia, np.diag([0.1, 0.2, 0.1 + 0.2]))


def test_arrays_of_a_body_cannot_be_changed_and_are_copies():
    position = np.zeros(3)
    body = RigidBody("b", 1, (1, 1, 1), position=position)
    position[0] = 5
    assert body.position[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        body.position[0] = 1
    with pytest.raises(AttributeError):
        body.mass = 3
    with pytest.raises(TypeError):
        body.markers["new"] = (0, 0, 0)


BAD_RIGID = [
    ({"mass": -1}, "body 'b': mass is -1 kg, must be a positive number"),
    ({"mass": np.nan}, "body 'b': mass is nan, must be finite"),
    ({"mass": "heavy"}, "body 'b': mass is 'heavy', must be a number"),
    (
        {"inertia": (1, 1, 3)},
        "body 'b': inertia violates the triangle inequality: principal moments 1, 1, 3 kg m2, "
        "the largest must not exceed the sum of the others, 2",
    ),
    (
        {"inertia": [[1, 0.5, 0], [0.2, 1, 0], [0, 0, 1]]},
        "body 'b': inertia is not symmetric: element (1,2) is 0.5, (2,1) is 0.2 kg m2",
    ),
    (
        {"inertia": (-1, 2, 2)},
        "body 'b': inertia is not positive: principal moments -1, 2, 2 kg m2",
    ),
    (
        {"inertia": (0, 2, 2)},
        "body 'b': inertia is not positive: principal moments 0, 2, 2 kg m2; all mass on one "
        "line cannot be simulated, give it a moment about that line",
    ),
    ({"inertia": (1, 2)}, "body 'b': inertia has shape (2,), must be (3, 3)"),
    ({"inertia": (1, 2, np.inf)}, "body 'b': inertia[2] is inf, must be finite"),
    ({"position": (0, 0)}, "body 'b': position has shape (2,), must be (3)"),
    ({"velocity": (0, np.nan, 0)}, "body 'b': velocity[1] is nan, must be finite"),
    ({"center": "x"}, "body 'b': center is not an array of numbers of shape (3)"),
    ({"markers": {"tip": (0, 0)}}, "body 'b': markers['tip'] has shape (2,), must be (3)"),
    (
        {"markers": {"center": (0, 0, 0)}},
        "body 'b': marker 'center': the name is reserved for the body's own center",
    ),
    (
        {"markers": [(0, 0, 0)]},
        "body 'b': markers is [(0, 0, 0)], must be a mapping of names to positions",
    ),
    ({"outline": (0, 0, 0)}, "body 'b': outline has shape (3,), must be (any, 3)"),
    ({"name": "ground"}, "body 'ground': the name 'ground' is taken by the ground"),
    ({"name": "a.b"}, "body 'a.b': name must not contain '.'"),
    ({"name": "a/b"}, "body 'a/b': name must not contain '/'"),
    ({"name": " "}, "body ' ': name must not be empty or start or end with a blank"),
    ({"name": ""}, "body '': name must not be empty or start or end with a blank"),
    ({"name": 3}, "body 3: name must be a string"),
]


@pytest.mark.parametrize(("change", "sentence"), BAD_RIGID, ids=[str(c[0]) for c in BAD_RIGID])
def test_bad_rigid_bodies_say_why(change, sentence):
    values = {"name": "b", "mass": 1.0, "inertia": (1, 1, 1), **change}
    assert messages(lambda: RigidBody(**values)) == [sentence]


def test_all_problems_of_a_body_come_together():
    found = messages(
        lambda: RigidBody("b/", -1, (1, 1, 3), position=(0, 0), velocity=(np.inf,) * 3)
    )
    assert len(found) == 5


def test_unknown_marker_of_a_rigid_body_gets_a_suggestion():
    body = RigidBody("boom", 1, (1, 1, 1), markers={"tip": (1, 0, 0)})
    assert messages(lambda: body["tpi"]) == ["body 'boom': no marker 'tpi'; did you mean 'tip'?"]


# -- flexible bodies ------------------------------------------------------------------------


def test_flexible_marker_follows_translation_and_rotation_modes(rod):
    rng = np.random.default_rng(1)
    p = 1e-2 * rng.normal(size=rod.n)
    turn = Rotation.from_rotvec([0.3, -0.2, 0.9])
    body = FlexibleBody("arm", rod, position=(1, 2, 3), orientation=turn, modal_coordinates=p)
    node = rod.node("end")
    axes = Rotation.from_rotvec([0.1, 0.2, 0.3])
    marker = body["end"].turned(axes)
    A = turn.as_matrix()
    local = Rotation.from_rotvec(rod.rotations[node] @ p).as_matrix()
    np.testing.assert_allclose(
        marker.r, [1, 2, 3] + A @ (rod.nodes[node] + rod.modes[node] @ p), atol=1e-15
    )
    np.testing.assert_allclose(marker.A, A @ local @ axes.as_matrix(), atol=1e-14)
    assert marker.node == node
    np.testing.assert_array_equal(marker.position_local, [2, 0, 0])


@pytest.mark.parametrize("point", ["start", "end", "node3"])
def test_flexible_markers_by_interface_and_node_name(rod, point):
    assert FlexibleBody("arm", rod)[point].node == rod.node(point)


def test_unknown_node_of_a_flexible_body_gets_a_suggestion(rod):
    body = FlexibleBody("arm", rod)
    assert messages(lambda: body["strat"]) == ["body 'arm': no node 'strat'; did you mean 'start'?"]


def test_damping_is_a_ratio_ratios_or_rayleigh(rod):
    omega = 2 * np.pi * rod.frequencies
    D = FlexibleBody("arm", rod, damping=0.02).modal_damping
    np.testing.assert_allclose(D, 0.04 * omega, rtol=1e-14)
    ratios = np.linspace(0.01, 0.05, rod.n)
    D = FlexibleBody("arm", rod, damping=ratios).modal_damping
    np.testing.assert_allclose(D, 2 * ratios * omega, rtol=1e-14)
    D = FlexibleBody("arm", rod, damping=Rayleigh(3.0, 1e-5)).modal_damping
    np.testing.assert_allclose(D, 3.0 + 1e-5 * omega**2, rtol=1e-14)


BAD_FLEXIBLE = [
    ({"damping": -0.1}, "body 'arm': damping: the ratio -0.1 must be 0 or positive"),
    ({"damping": [0.1]}, "body 'arm': damping: 1 ratios for 8 modes: give one ratio"),
    ({"modal_coordinates": [1, 2]}, "body 'arm': modal_coordinates has shape (2,), must be (8)"),
    (
        {"modal_velocities": [np.nan] * 8},
        "body 'arm': modal_velocities[0] is nan, must be finite",
    ),
    (
        {"drop_invariants": ["I5", "I7"]},
        "body 'arm': drop_invariants: 'I7' cannot be dropped; known: I5, I9",
    ),
    ({"position": (1, 2, 3, 4)}, "body 'arm': position has shape (4,), must be (3)"),
]


@pytest.mark.parametrize(("change", "sentence"), BAD_FLEXIBLE)
def test_bad_flexible_bodies_say_why(rod, change, sentence):
    (found,) = messages(lambda: FlexibleBody("arm", rod, **change))
    assert sentence in found


def test_a_part_must_be_reduced_first():
    from jousto.materials.material import Material
    from jousto.parts.part import Part
    from jousto.sections.section import Rectangle

    part = Part.beam(1.0, Rectangle(0.1, 0.1), 2, Material(2e11, 0.3, 7850))
    assert messages(lambda: FlexibleBody("arm", part)) == [
        "body 'arm': reduced is a Part, must be a ReducedPart; reduce it first, "
        "reduce(part, method)"
    ]


def test_rigid_mass_agrees_with_a_sum_over_mass_points(rod):
    """Z = M_rr - M_rp M_pr with all integrals as sums over the particles of the part."""
    from jousto.materials.material import Material
    from jousto.parts.part import Part
    from jousto.sections.section import Rectangle

    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    part = Part.beam(2.0, Rectangle(0.1, 0.05), 4, steel, lumped=True, rotary_inertia=False)
    # translations only: particles are the nodes
    mass = part.mass_points.mass
    rng = np.random.default_rng(3)
    n = 4
    nodes, modes = rng.normal(size=(5, 3)), rng.normal(size=(5, 3, n))
    # mass-orthonormal modes, as M_pp = E supposes
    flat = (np.sqrt(mass)[:, None, None] * modes).reshape(15, n)
    flat = np.linalg.qr(flat)[0]
    modes = flat.reshape(5, 3, n) / np.sqrt(mass)[:, None, None]
    p = 0.1 * rng.normal(size=n)

    class Invariants:
        pass

    I = Invariants()
    I.mass = mass.sum()
    I.first_moment = np.einsum("k,ka->a", mass, nodes)
    I.second_moment = np.einsum("k,ka,kb->ab", mass, nodes, nodes)
    I.I3 = np.einsum("k,kaj->aj", mass, modes)
    I.N0 = np.einsum("k,ka,kbj->jab", mass, nodes, modes)
    I.E = np.einsum("k,kai,kbj->ijab", mass, modes, modes)

    u = nodes + modes @ p
    M = np.zeros((6 + n, 6 + n))
    for m, x, phi in zip(mass, u, modes, strict=True):
        skewed = np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
        T = np.hstack([np.eye(3), -skewed, phi])
        M += m * T.T @ T
    Z = M[:6, :6] - M[:6, 6:] @ np.linalg.solve(M[6:, 6:], M[6:, :6])
    np.testing.assert_allclose(rigid_mass(I, p), Z, rtol=0, atol=1e-12 * np.abs(M).max())


def test_mass_on_one_line_is_refused_with_the_remedy(rod):
    """A body whose particles all lie on the x axis has no inertia about it."""
    from dataclasses import replace

    I = rod.invariants
    line = np.zeros((3, 3))
    line[0, 0] = I.second_moment[0, 0]
    E = np.zeros_like(I.E)
    E[:, :, 1, 1] = np.eye(rod.n)
    thin = replace(
        rod,
        invariants=replace(
            I, second_moment=line, N0=np.zeros_like(I.N0), I3=np.zeros_like(I.I3), E=E
        ),
    )
    assert messages(lambda: FlexibleBody("wire", thin)) == [
        "body 'wire': the mass matrix is singular: no inertia about the body axis (1, 0, 0), "
        "because all mass lies on one line; use rotary_inertia=True in the part, or point "
        "masses beside the line"
    ]


def test_ground_is_one_object_and_rotation_matrix_of_a_body_is_orthonormal():
    body = RigidBody("b", 1, (1, 1, 1), orientation=(0.5, 0.5, 0.5, 0.5))
    A = rotation_matrix(body.orientation)
    np.testing.assert_allclose(A.T @ A, np.eye(3), atol=1e-15)
    assert type(copy.deepcopy(ground)) is type(pickle.loads(pickle.dumps(ground)))


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("a\0b", "name must not contain control characters"),
        ("a\nb", "name must not contain control characters"),
        ("a\x7f", "name must not contain control characters"),
        ("a\ud800", "name must not contain control characters"),
        ("/", "name must not contain '/'"),
    ],
)
def test_names_that_no_file_can_hold(name, sentence):
    expected = [f"body {name!r}: {sentence}"]
    assert messages(lambda: RigidBody(name, 1, (1, 1, 1))) == expected


def test_names_in_any_script_are_fine():
    for name in ("Stößel", "曲柄", "rod 2", "a-b_c"):
        assert RigidBody(name, 1, (1, 1, 1)).name == name


def test_numbers_that_no_float_can_hold():
    huge = 10**400
    assert messages(lambda: RigidBody("b", huge, (1, 1, huge))) == [
        f"body 'b': mass is {huge}, must be a number",
        "body 'b': inertia is not an array of numbers of shape (3)",
    ]


def test_markers_of_a_flexible_body_are_its_nodes(rod):
    arm = FlexibleBody("arm", rod)
    assert arm["end"].node == 4
    (message,) = messages(lambda: arm[0])
    assert message.startswith("body 'arm': no node '0'; ")


def test_drop_invariants_must_be_names(rod):
    assert messages(lambda: FlexibleBody("arm", rod, drop_invariants=5)) == [
        "body 'arm': drop_invariants is 5, must be names such as 'I5'"
    ]


def test_only_a_part_can_be_reduced():
    from jousto.reduction.methods import FreeFree
    from jousto.reduction.reducer import reduce

    assert messages(lambda: reduce(None, FreeFree(modes=1))) == [
        "reduce: part is None, must be a Part such as Part.beam(...)"
    ]
