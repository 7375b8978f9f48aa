"""Beam bodies: geometry, inertia, flattening and messages."""

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import rotation_matrix

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
BAR = jo.Rectangle(0.02, 0.01)


def arc(radius, angle, n):
    t = np.linspace(0.0, angle, n + 1)
    return np.stack([radius * np.sin(t), radius * (1 - np.cos(t)), 0 * t], axis=1)


def rigid_inertia(bodies):
    """Mass, centre (3,) and inertia (3, 3) about the world origin of rigid bodies."""
    mass, first, J = 0.0, np.zeros(3), np.zeros((3, 3))
    for body in bodies:
        A = rotation_matrix(body.orientation)
        c = body.position + A @ body.center
        mass += body.mass
        first += body.mass * c
        J += A @ body.inertia @ A.T + body.mass * (c @ c * np.eye(3) - np.outer(c, c))
    return mass, first / mass, J


def test_straight_beam_has_the_mass_of_its_length_and_lumped_inertia():
    L, n = 2.0, 8
    beam = jo.BeamBody("b", [(0, 0, 0), (L, 0, 0)], BAR, STEEL, elements=n)
    m = 7850 * 2e-4 * L
    mass, center, J = rigid_inertia(beam.bodies)
    assert mass == pytest.approx(m) and beam.mass == pytest.approx(m)
    assert center == pytest.approx([L / 2, 0, 0])
    # trapezoid rule of x^2: L^2/3 + L^2/(6 n^2); sections turn with rho I
    lumped = L**2 / 3 + L**2 / (6 * n**2)
    assert J[2, 2] == pytest.approx(m * lumped + 7850 * BAR.Iz * L)
    assert J[0, 0] == pytest.approx(7850 * (BAR.Iy + BAR.Iz) * L)
    assert beam.bodies[0].mass == pytest.approx(m / n / 2)


def test_an_arc_keeps_its_length_curvature_and_plane():
    beam = jo.BeamBody("b", arc(100.0, np.pi / 4, 8), jo.Rectangle(1, 1), STEEL)
    assert beam.length == pytest.approx(100 * np.pi / 4, rel=1e-13)
    e0 = beam.unstressed
    assert e0[:, 5] == pytest.approx(np.full(8, 0.01))
    assert np.abs(e0[:, 1:5]).max() < 1e-14
    # tangents of the arc at its ends
    s = np.sqrt(0.5)
    assert beam.frames[0] == pytest.approx(np.eye(3))
    assert beam.frames[-1] == pytest.approx(np.array([[s, -s, 0], [s, s, 0], [0, 0, 1]]))


def test_twist_and_up_turn_the_sections():
    beam = jo.BeamBody("b", [(0, 0, 0), (0, 0, 3)], BAR, STEEL, elements=6, twist=np.pi / 2)
    assert beam.frames[0][:, 2] == pytest.approx([1, 0, 0])
    # a quarter turn about the axis takes z to -y: z = cos t z0 - sin t y0
    assert beam.frames[-1][:, 2] == pytest.approx(-beam.frames[0][:, 1])
    assert beam.unstressed[:, 3] == pytest.approx(np.full(6, np.pi / 6))
    tilted = jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], BAR, STEEL, elements=1, up=(5, 1, 0))
    assert tilted.frames[0][:, 2] == pytest.approx([0, 1, 0])


def test_rings_of_nodes_transport_frames_without_twisting_them():
    t = np.linspace(0, 2 * np.pi, 25)
    helix = np.stack([np.cos(t), np.sin(t), 0.1 * t], axis=1)
    beam = jo.BeamBody("b", helix, BAR, STEEL)
    for frames in beam.frames:
        assert frames.T @ frames == pytest.approx(np.eye(3), abs=1e-14)
    # the smallest rotations turn about axes across the beam
    assert np.abs(beam.unstressed[:, 3]).max() < 2e-2
    radius = 1 / (1 + 0.01)  # curvature of the helix
    assert np.linalg.norm(beam.unstressed[2:-2, 4:], axis=1) == pytest.approx(
        np.full(20, radius), rel=5e-3
    )


def test_corners_weld_elements_at_an_angle():
    points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (2, 2, 0)]
    beam = jo.BeamBody("b", points, BAR, STEEL, corners=[2])
    assert np.abs(beam.unstressed).max() < 1e-14
    assert beam.lengths == pytest.approx(np.ones(4))
    assert beam.ends[1, 1][:, 0] == pytest.approx([1, 0, 0])
    assert beam.ends[2, 0][:, 0] == pytest.approx([0, 1, 0])
    u, B = beam.elements["u_b"][1], beam.elements["B_b"][1]
    assert u == pytest.approx([0, 0, 0])
    assert B[:, 0] == pytest.approx([0, -1, 0])  # world x in the node's frame, x along y


def test_offset_arms_and_mass_centres_keep_the_centre_of_mass():
    section = jo.mechanism.BeamSection(
        (1e6, 1e6, 1e6, 10, 10, 10), 2.0, (2e-3, 1e-3, 1e-3), center=(0, 0.05)
    )
    beam = jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], section, elements=4, offset=(0.1, -0.2))
    mass, center, J = rigid_inertia(beam.bodies)
    assert mass == pytest.approx(2.0)
    assert center == pytest.approx([0.5, 0.1, -0.15])
    assert J[0, 0] == pytest.approx(2e-3 + 2 * (0.1**2 + 0.15**2))
    assert beam.elements["u_a"] == pytest.approx(np.tile([0, 0.1, -0.2], (4, 1)))


def test_initial_velocities_are_those_of_a_rigid_motion():
    beam = jo.BeamBody(
        "b",
        [(1, 0, 0), (2, 0, 0)],
        BAR,
        STEEL,
        elements=2,
        position=(0, 0, 5),
        orientation=jo.Rotate((0, 0, 1), degrees=90),
        velocity=(1, 0, 0),
        angular_velocity=(0, 0, 2),
    )
    end = beam.bodies[-1]
    assert end.position == pytest.approx([0, 2, 5])
    assert end.velocity == pytest.approx([1 - 4, 0, 0])


def test_force_through_the_shear_centre_and_the_centroid_of_a_section():
    c, s = (0.01, -0.02), (-0.03, 0.015)
    section = jo.mechanism.BeamSection.of(BAR, STEEL, centroid=c, shear_center=s)
    # tension through the centroid: N and its moments about the reference axis
    N = 1e3
    e = np.linalg.solve(section.stiffness, [N, 0, 0, 0, N * c[1], -N * c[0]])
    assert e[0] == pytest.approx(N / (210e9 * 2e-4))
    assert np.abs(e[1:]).max() < 1e-15
    # a shear force through the shear centre does not twist
    Q = np.array([0, 300.0, -200.0])
    torque = s[0] * Q[2] - s[1] * Q[1]
    e = np.linalg.solve(section.stiffness, [*Q, torque, 0, 0])
    assert abs(e[3]) < 1e-15 and np.abs(e[1:3]).min() > 0


def test_bending_correction_makes_a_clamped_element_as_soft_as_the_cubic():
    section, L = jo.mechanism.BeamSection.of(BAR, STEEL), 0.7
    C = section.with_bending(L)
    F = np.linalg.inv(C)
    # end load Q on a cantilever element: rotation of the middle, shear, both ends' kinematics
    EI, GA = 210e9 * BAR.Iz, STEEL.G * BAR.A * 5 / 6
    kappa, gamma = F[5, 5] * L / 2, F[1, 1]
    tip = L * gamma + L * kappa * L / 2
    assert tip == pytest.approx(L**3 / (3 * EI) + L / GA)


def test_mechanism_holds_nodes_in_the_place_of_the_beam():
    a = jo.RigidBody("a", 1.0, (1, 1, 1))
    beam = jo.BeamBody("rope", [(0, 0, 0), (1, 0, 0)], BAR, STEEL, elements=3)
    c = jo.RigidBody("c", 1.0, (1, 1, 1), position=(1, 0, 0))
    mechanism = jo.Mechanism(
        a,
        beam,
        c,
        jo.Fixed("ja", a["origin"], beam["start"]),
        jo.Fixed("jc", c["origin"], beam["end"]),
        jo.Gravity((0, 0, -9.81)),
    )
    names = [body.name for body in mechanism.bodies]
    assert names == ["a", "rope.node1", "rope.node2", "rope.node3", "rope.node4", "c"]
    assert mechanism.beams == (beam,)
    assert "3 bodies" in repr(mechanism)
    assert mechanism.mobility == 6
    assert beam["end"].label == "rope.end" and beam["node2"].label == "rope.node2"


def test_a_free_beam_is_one_warning():
    beam = jo.BeamBody("rope", [(0, 0, 0), (1, 0, 0)], BAR, STEEL, elements=30)
    with pytest.warns(jo.JoustoWarning) as seen:
        jo.Mechanism(beam, jo.Gravity((0, 0, -9.81)))
    assert [str(w.message) for w in seen] == [
        "beam 'rope': has no joint to another body, so it moves freely"
    ]


def test_a_beam_that_is_missing_is_named_as_such():
    beam = jo.BeamBody("rope", [(0, 0, 0), (1, 0, 0)], BAR, STEEL, elements=3)
    other = jo.RigidBody("a", 1.0, (1, 1, 1))
    with pytest.raises(jo.InputError, match="beam 'rope' is not in the mechanism"):
        jo.Mechanism(other, jo.Fixed("j", other["origin"], beam["start"]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": [(0, 0, 0)]}, "has 1 point"),
        ({"points": [(0, 0, 0), (0, 0, 0)]}, "coincide; leave one out"),
        ({"elements": None}, "elements is missing"),
        ({"elements": 0}, "whole number from 1"),
        ({"points": [(0, 0, 0), (1, 0, 0), (2, 0, 0)]}, "3 points make 2 elements"),
        ({"material": None}, "must be a Material"),
        (
            {"section": jo.sections.GeneralSection(A=1e-4, Iy=1e-9, Iz=1e-9, J=1e-9)},
            "ky is missing",
        ),
        ({"material": jo.Material(210e9, 0.3, 0.0)}, "needs mass"),
        ({"mass": "heavy"}, "from 0"),
        ({"mass": 1.5}, "must be from 0"),
        ({"up": (1, 0, 0)}, "parallel to the beam"),
        ({"up": (0, 0, 0)}, "must have a direction"),
        ({"corners": [9]}, "is not an inner node"),
        ({"markers": {"start": 2}}, "a node has this name already"),
        ({"markers": {"grip": 9}}, "no node 9"),
        ({"twist": [0, 1]}, "twist has shape"),
        ({"damping": 0.1}, "must be a BeamDamping"),
        ({"straight": True, "reference": np.eye(3)}, "give only one"),
        ({"name": "a.b"}, "must not contain"),
    ],
)
def test_errors_say_what_is_wrong(change, message):
    given = {
        "name": "b",
        "points": [(0, 0, 0), (1, 0, 0)],
        "section": BAR,
        "material": STEEL,
        "elements": 4,
    } | change
    with pytest.raises(jo.InputError, match=message):
        jo.BeamBody(**given)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [
        (np.diag([1, 1, 1, 1, 1, -1.0]), "stiffness of Mz is -1"),
        (np.eye(6) + np.eye(6, k=1) * 0.1, "not symmetric"),
        (np.eye(6) + 1.5 * (np.eye(6, k=1) + np.eye(6, k=-1)), "not positive definite"),
        (np.eye(5), "shape"),
    ],
)
def test_sections_must_be_stable(stiffness, message):
    with pytest.raises(jo.InputError, match=message):
        jo.mechanism.BeamSection(stiffness, 1.0, (2, 1, 1))


def test_units_that_no_solid_has_are_warned_of():
    with pytest.warns(jo.JoustoWarning, match="faster than in any solid"):
        jo.mechanism.BeamSection((1e9, 1e9, 1e9, 1, 1, 1), 1e-3, (2e-6, 1e-6, 1e-6))


def test_markers_have_names_numbers_and_arms():
    beam = jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], BAR, STEEL, elements=4, markers={"grip": 2})
    assert beam["grip"].r == pytest.approx([0.5, 0, 0])
    assert beam.node(-1, at=(0, 0, 0.1)).r == pytest.approx([1, 0, 0.1])
    with pytest.raises(jo.InputError, match="did you mean 'grip'"):
        beam["gripp"]
    with pytest.raises(jo.InputError, match="no node 5"):
        beam.node(5)
    with pytest.raises(jo.InputError, match="sit on nodes"):
        beam.at((0, 0, 0))


def test_twist_that_the_ends_of_an_element_do_not_show_is_refused():
    with pytest.raises(jo.InputError, match=r"element \d by 6\.3 rad.* use 26 elements"):
        jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.01), STEEL, elements=4, twist=25.2)
    with pytest.raises(jo.InputError, match="were degrees meant"):
        jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.01), STEEL, elements=8, twist=90)


def test_millimetres_and_degrees_are_asked_for():
    points = [(0, 0, 0), (1, 0, 0)]
    with pytest.warns(jo.JoustoWarning, match="beam 1 m long; are its dimensions in millimetres"):
        jo.BeamBody("b", points, jo.Rectangle(20, 2), STEEL, elements=8)
    with pytest.warns(jo.JoustoWarning, match="twisted by 45 rad; if degrees were meant"):
        jo.BeamBody("b", points, jo.Circle(0.01), STEEL, elements=40, twist=45)


@pytest.mark.parametrize("mass", ["consistent", 0.5])
def test_consistent_inertia_of_a_mass_centre_off_the_axis_is_refused(mass):
    section = jo.mechanism.BeamSection.of(jo.Rectangle(0.02, 0.01), STEEL, centroid=(0, 0.01))
    points = [(0, 0, 0), (1, 0, 0)]
    with pytest.raises(jo.InputError, match="10 mm off the axis.* use 'corrected'"):
        jo.BeamBody("b", points, section, elements=4, mass=mass)
    for good in ("lumped", "corrected"):
        jo.BeamBody("b", points, section, elements=4, mass=good)


@pytest.mark.parametrize("number", [1.5, True, "2"])
def test_nodes_have_whole_numbers(number):
    beam = jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.01), STEEL, elements=4)
    with pytest.raises(jo.InputError, match="no node"):
        beam.node(number)


STRIP_E, STRIP_RHO = 200e9, 8000.0


def given_strip(*, turning: float | None = None, polar: float = 0.0, dense: float = 1.0):
    """A strip of 20 by 2 mm by its numbers; `dense`: times the density beside the stiffness."""
    A, Iy, Iz = 0.04e-3, 0.02 * 0.002**3 / 12, 0.002 * 0.02**3 / 12
    rho = STRIP_RHO * dense
    stiff = (STRIP_E * A, 80e9 * A, 80e9 * A, 4.0, STRIP_E * Iy, STRIP_E * Iz)
    about = rho * (Iy + Iz) if turning is None else rho * turning
    return jo.mechanism.BeamSection(stiff, rho * A, (about, rho * Iy, rho * Iz), polar=polar)


def test_the_polar_inertia_is_the_sum_of_the_others():
    """Of a flat section; the torsion constant, b t^3/3, is often taken for it."""
    given_strip()
    with pytest.warns(jo.JoustoWarning, match=r"about x .* in a flat section it is their sum"):
        given_strip(turning=1.32e-9)  # between Iz - Iy and Iz + Iy, or no body had it


@pytest.mark.parametrize(("wrong", "dense"), [(1.347e-9, 1.0), (0.98 * 101 / 3e6, 1.0)])
def test_polar_is_that_of_the_section(wrong, dense):
    """(Iy + Iz)/A = (b^2 + t^2)/12, to 1 % where mass and stiffness are spread alike."""
    right = (0.02**2 + 0.002**2) / 12
    given_strip(polar=right)
    with pytest.warns(jo.JoustoWarning, match=r"polar is .* not Iy \+ Iz and not the torsion"):
        given_strip(polar=wrong, dense=dense)


def test_polar_of_composites_need_not_be_that_of_the_stiffness():
    """Within a factor of ten; about the shear centre wherever that is."""
    section = jo.mechanism.BeamSection(
        (8e6, 3e6, 3e6, 4.0, 2.7, 266.0), 0.4, (2e-5, 1e-5, 1e-5), polar=5e-5
    )
    assert section.polar == 5e-5
    with pytest.warns(
        jo.JoustoWarning, match="polar is 1e-09 m2, but the stiffness means 3.359e-05"
    ):
        jo.mechanism.BeamSection(
            (8e6, 3e6, 3e6, 4.0, 2.7, 266.0), 0.4, (2e-5, 1e-5, 1e-5), polar=1e-9
        )
    made = jo.mechanism.BeamSection.of(
        jo.Rectangle(0.02, 0.002), STEEL, centroid=(0.01, 0.002), shear_center=(0.03, -0.01)
    )
    again = jo.mechanism.BeamSection(
        made.stiffness, made.mass, made.inertia, center=made.center, polar=made.polar
    )
    assert again.polar == made.polar
