"""Resultants along beams in mechanisms: closed forms, statics of curved bars, reactions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from recovery.beams.cases import STEEL, cantilever, compiled, rest


def test_cantilever_under_an_end_load() -> None:
    """Q = -P and M = P (L - s): the moments are exact at the nodes, with any number of elements."""
    forces = jo.recovery.section_forces(cantilever((0.0, 0.0, -1.0), 3), "beam")
    assert forces.at_nodes[0, :, 4] == pytest.approx(1.0 - forces.s_nodes, abs=1e-6)
    assert forces.at_nodes[0, :, 2] == pytest.approx(-1.0, rel=1e-9)
    assert forces.at_nodes[0][:, [1, 3, 5]] == pytest.approx(0.0, abs=1e-9)
    s, M = forces.diagram("My", 0.0)
    assert M == pytest.approx(1.0 - s, abs=1e-6)
    assert forces.history("My", 0.25) == pytest.approx(0.75, abs=1e-6)
    low, _, high, at = forces.envelope("My")
    assert high[0] == pytest.approx(1.0, rel=1e-6) and low[-1] == pytest.approx(0.0, abs=1e-6)
    assert at[0] in forces.time


def test_hanging_bar() -> None:
    """N = rho A g (L - s): linear to the ends, although it is constant in every element."""
    beam = jo.BeamBody("bar", [(0, 0, 0), (0, 0, -2)], jo.Circle(0.02), STEEL, elements=5)
    run = rest(
        compiled(
            beam, jo.Fixed("clamp", jo.ground["origin"], beam["start"]), jo.Gravity((0, 0, -9.81))
        )
    )
    forces = jo.recovery.section_forces(run, "bar")
    weight = 7850.0 * np.pi * 1e-4 * 9.81
    assert forces.at_nodes[0, :, 0] == pytest.approx(weight * (2.0 - forces.s_nodes), abs=1e-6)


@pytest.mark.parametrize("s", [(0.0, 0.1, 0.7, 0.9, 2.0), (0.0, 1.4, 2.0)])
def test_unequal_elements(s: tuple[float, ...]) -> None:
    """N = rho A g (L - s) of a hanging bar, Q = q (L - s) of a lying one: linear, so exact.

    Half the weight of an element stands on each of its nodes: the force in the element is that of
    its middle, and between middles that are unequally far apart the line must be the same.
    """
    z = -np.array(s)
    # so light that it turns by 2e-4 only, and the forces change by the square of that; a strain has
    # a round-off of eps
    g, EA = 0.1, 210e9 * np.pi * 1e-4
    weight = 7850.0 * np.pi * 1e-4 * g
    limit = 4e-8 * 2.0 * weight + 4.0 * np.finfo(float).eps * EA
    for points, k, sign in (
        (np.stack([0.0 * z, 0.0 * z, z], axis=1), 0, 1.0),
        (np.stack([-z, 0.0 * z, 0.0 * z], axis=1), 2, -1.0),
    ):
        beam = jo.BeamBody("bar", points, jo.Circle(0.02), STEEL)
        clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
        forces = jo.recovery.section_forces(
            rest(compiled(beam, clamp, jo.Gravity((0, 0, -g)))), "bar"
        )
        exact = sign * weight * (2.0 - forces.s_nodes)
        assert forces.at_nodes[0, :, k] == pytest.approx(exact, abs=limit)
        assert forces.history("N" if k == 0 else "Qz", 0.8)[0] == pytest.approx(
            0.6 * exact[0], abs=limit
        )


def test_quarter_ring() -> None:
    """N = -P cos, Q = P sin, M = -P R sin of the angle from the loaded end: plain statics."""
    R, P, n = 0.5, 1.0, 8
    angle = 0.5 * np.pi * np.arange(n + 1) / n
    points = R * np.stack([np.sin(angle), 1.0 - np.cos(angle), 0.0 * angle], axis=1)
    beam = jo.BeamBody("ring", points, jo.Circle(0.03), STEEL)
    run = rest(
        compiled(
            beam,
            jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
            jo.Force("pull", beam["end"], (P, 0.0, 0.0)),
        )
    )
    found = jo.recovery.section_forces(run, "ring").ends[0]
    phi = np.stack([angle[:-1], angle[1:]], axis=1)
    # the end is at (R, R): the moment of the force about a point of the ring
    assert found[..., 0] == pytest.approx(P * np.cos(phi), abs=1e-4)
    assert found[..., 1] == pytest.approx(-P * np.sin(phi), abs=1e-4)
    assert found[..., 5] == pytest.approx(-P * R * np.cos(phi), abs=1e-4)


def test_rotating_bar() -> None:
    """N = rho A w^2 (L^2 - s^2) / 2 of the stretched bar that turns steadily."""
    w, L, n = 50.0, 1.0, 10
    x = np.linspace(0.0, L, n + 1)
    stretched = x + 0.5 * STEEL.rho * w**2 / STEEL.E * (L**2 * x - x**3 / 3.0)
    line = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    beam = jo.BeamBody(
        "bar",
        np.stack([stretched, 0.0 * x, 0.0 * x], axis=1),
        jo.Circle(0.02),
        STEEL,
        reference=line,
        angular_velocity=(0, 0, w),
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], axis=(0, 0, 1))
    model = compiled(beam, hinge)
    run = jo.simulate(model, t_end=0.002, solver=jo.GeneralizedAlpha(step=1e-5))
    forces = jo.recovery.section_forces(run, "bar")
    exact = 0.5 * STEEL.rho * np.pi * 1e-4 * w**2 * (L**2 - forces.s_nodes**2)
    N = forces.at_nodes[:, :, 0]
    # lumped masses err by h^2 / 6 L^2 of the largest force or so, and swing about that
    assert N[0] == pytest.approx(exact, abs=0.007 * exact[0])
    assert N[-1] == pytest.approx(exact, abs=0.02 * exact[0])


def test_helical_spring() -> None:
    """k = G d^4 / (8 D^3 n) and tau = 8 P D / (pi d^3), slender (Wahl, Mechanical Springs, 1963).

    Of an axial pull at the axis the wire sees the torque P D/2 cos(a) and the moment P D/2 sin(a)
    with the pitch angle a.
    """
    D, d, turns, pitch, n = 0.1, 0.005, 1, 0.01, 16
    angle = 2.0 * np.pi * turns * np.arange(n + 1) / n
    points = np.stack(
        [0.5 * D * np.cos(angle), 0.5 * D * np.sin(angle), pitch * angle / (2.0 * np.pi)], axis=1
    )
    beam = jo.BeamBody("spring", points, jo.Circle(d), STEEL)
    P = 0.01
    # rigid arms hold and pull the ends at the axis
    top = beam.frames[-1].T @ (np.array([0.0, 0.0, points[-1, 2]]) - points[-1])
    hook = beam.node(n, at=top)
    run = rest(
        compiled(
            beam,
            jo.Fixed("foot", jo.ground.at(points[0]), beam["start"]),
            jo.Force("pull", hook, (0.0, 0.0, P)),
            jo.PositionSensor("hook", hook),
        )
    )
    forces = jo.recovery.section_forces(run, "spring")
    a = np.arctan(pitch / (np.pi * D))
    assert np.abs(forces.resultants[0, :, 3]) == pytest.approx(0.5 * P * D * np.cos(a), rel=0.01)
    G = STEEL.E / 2.6
    field = jo.stress_field(run, "spring")
    tau = np.abs(field.values("max-shear", sites=[f"e{k}.a.left" for k in range(2, n)]))
    assert tau[0] == pytest.approx(8.0 * P * D / (np.pi * d**3), rel=0.05)
    # the hook, free to turn and shift, also moves by the bending of the wire: 1 % at this pitch
    stretch = run["hook"][0, 2] - points[-1, 2]
    assert P / stretch == pytest.approx(G * d**4 / (8.0 * D**3 * turns), rel=0.02)


def test_reaction_is_the_resultant_at_the_clamp() -> None:
    """To round-off while it swings with large rotations, damping in the resultants included."""
    beam = jo.BeamBody(
        "rod",
        [(0, 0, 0), (1, 0, 0)],
        jo.Rectangle(0.02, 0.04),
        STEEL,
        elements=6,
        twist=0.5,
        damping=jo.mechanism.BeamDamping(stiffness=1e-5),
    )
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    model = compiled(
        beam, clamp, jo.Gravity((300.0, 200.0, -981.0)), jo.ReactionSensor("clamp", clamp)
    )
    run = jo.simulate(model, t_end=0.04, solver=jo.GeneralizedAlpha(step=4e-4, tolerance=1e-10))
    ends = jo.recovery.section_forces(run, "rod").ends[:, 0, 0]
    half = model.bodies[model.beam_shapes[0].bodies[0]].mass[0]
    weight = half * np.array([300.0, 200.0, -981.0])
    # the joint also bears the half of the first element that is lumped at the clamp
    force = run["clamp"][:, :3] + weight
    Q = beam.frames[0]
    assert ends[5:, :3] @ Q.T == pytest.approx(-force[5:], abs=1e-7 * np.abs(force).max())
    moment = run["clamp"][:, 3:]
    assert ends[5:, 3:] @ Q.T == pytest.approx(-moment[5:], abs=1e-7 * np.abs(moment).max())


def test_instants_between_stored_ones_and_tables(tmp_path: Path) -> None:
    run = cantilever((0.0, 0.0, -1.0), 3)
    forces = jo.recovery.section_forces(run, "beam", times=[0.5e-9, 1.5e-9])
    assert forces.time.tolist() == [0.5e-9, 1.5e-9]
    assert forces.history("My", "start") == pytest.approx(1.0, rel=1e-6)
    for time in (None, 1e-9):
        lines = forces.to_csv(tmp_path / "a.csv", time).read_text().splitlines()
        assert lines[0].startswith("s (m),") and len(lines) == (5 if time is None else 7)
    assert "My" in str(forces)


def test_messages() -> None:
    run = cantilever((0.0, 0.0, -1.0), 3)
    with pytest.raises(jo.InputError, match="no beam 'bean'; did you mean 'beam'"):
        jo.recovery.section_forces(run, "bean")
    forces = jo.recovery.section_forces(run, "beam")
    with pytest.raises(jo.InputError, match="no resultant 'Mw'"):
        forces.history("Mw", 0.0)
    with pytest.raises(jo.InputError, match="outside the beam of 0 to 1 m"):
        forces.history("My", 2.0)
    with pytest.raises(jo.InputError, match="'start' or 'end'"):
        forces.history("My", "middle")
    with pytest.raises(jo.InputError, match="outside the run"):
        jo.recovery.section_forces(run, "beam", times=[5.0])
    with pytest.raises(jo.InputError, match="must end with .csv"):
        forces.to_csv("a.txt")


@pytest.mark.parametrize("bending", [False, True])
def test_engine_measures_the_same(bending: bool) -> None:
    """The section sensor of the engine: a curved, twisted, offset, damped beam in motion."""
    t = np.linspace(0.0, 1.0, 7)
    beam = jo.BeamBody(
        "cable",
        np.stack([t, 0.3 * t**2, 0.1 * np.sin(2.0 * t)], axis=1),
        jo.Rectangle(0.01, 0.02),
        STEEL,
        twist=0.3,
        bending=bending,
        damping=jo.mechanism.BeamDamping(stiffness=1e-5),
        offset=(0.01, 0.02),
    )
    model = compiled(
        beam,
        jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
        jo.mechanism.SectionSensor("forces", beam, element=3),
        jo.mechanism.SectionSensor("strains", beam, element="e4", quantity="strains"),
        jo.mechanism.SectionSensor("start", beam, "start"),
        jo.mechanism.SectionSensor("node", beam, float(beam.s[3])),
        jo.mechanism.SectionSensor("end", beam, "end"),
        jo.Gravity((0.0, 0.0, -99.81)),
    )
    run = jo.simulate(model, t_end=0.01, solver=jo.GeneralizedAlpha(step=1e-4))
    found = jo.recovery.section_forces(run, "cable")
    # positions of 1 m know strains to 1e-15 or so, and EA is 4e7 N
    assert found.resultants[:, 3] == pytest.approx(run["forces"], abs=1e-6)
    assert found.strains[:, 3] == pytest.approx(run["strains"], abs=1e-14)
    for name, element, end in (("start", 0, 0), ("node", 3, 0), ("end", -1, 1)):
        assert found.ends[:, element, end] == pytest.approx(run[name], abs=1e-6)


def test_the_sensor_at_the_start_measures_the_moment_at_the_clamp():
    """M = m g L / 2 of a short stiff cantilever under its weight, whatever its elements."""
    beam = jo.BeamBody("b", [(0, 0, 0), (1, 0, 0)], jo.Rectangle(0.05, 0.05), STEEL, elements=4)
    model = compiled(
        beam,
        jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
        jo.mechanism.SectionSensor("root", beam, "start"),
        jo.mechanism.SectionSensor("tip", beam, "end"),
        jo.mechanism.SectionSensor("first", beam, element=0),
        jo.Gravity((0.0, 0.0, -9.81)),
    )
    path = jo.simulation.load_path(model, "gravity", to=1.0, steps=1)
    moment = 7850.0 * 0.05**2 * 9.81 / 2.0
    assert abs(path["root"][-1][3:]).max() == pytest.approx(moment, rel=1e-4)
    assert abs(path["tip"][-1][3:]).max() < 1e-6 * moment
    # in the middle of the first quarter, whose force stands on its nodes, 1/8 m from the clamp
    assert abs(path["first"][-1][3:]).max() == pytest.approx(
        moment * (1.0 - 0.25 * 7 / 8), rel=1e-3
    )
