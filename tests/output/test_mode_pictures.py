"""Pictures of a machine in a mode: where its bodies are, what is written and refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import jousto as jo
from jousto.output.figures.modes import in_mode, plot_modes
from jousto.recovery.shape import positions
from jousto.scene.modes import machine_modes


def crank() -> jo.simulation.MechanismModes:
    """A short crank with a flexible rod on a fixed ball, all turned by 40 degrees about z."""
    turn = jo.Rotate((0, 0, 1), degrees=40)
    A = turn.matrix
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 6, steel)
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4))
    wheel = jo.RigidBody.box(
        "wheel", (0.2, 0.02, 0.02), mass=1.0, position=A[:, 0] * 0.1, orientation=turn
    )
    rod = jo.FlexibleBody("rod", reduced, position=A[:, 0] * 0.2, orientation=turn)
    axle, pin = wheel.at((-0.1, 0, 0)), wheel.at((0.1, 0, 0))
    return jo.modes(
        jo.compile(
            jo.Mechanism(
                wheel,
                rod,
                jo.Revolute("axle", jo.ground["origin"], axle, axis=A[:, 1]),
                jo.Revolute("pin", pin, rod["start"], axis=A[:, 1]),
                jo.Spherical("ball", jo.ground.at(A[:, 0] * 1.2), rod["end"]),
                name="crank",
            )
        )
    )


def test_the_bodies_are_where_the_mode_takes_them():
    """A small picture is the linear mode, up to the square of its size; the first instant rests."""
    found, size = crank(), 1e-4
    for mode in range(1, 6):
        run = in_mode(found, mode, size)
        moves = {body.name: np.diff(positions(run, body.name), axis=0)[0] for body in run.bodies}
        largest = max(np.abs(u).max() for u in moves.values())
        sign = np.sign(sum((u * np.real(found.shapes[k][mode])).sum() for k, u in moves.items()))
        for name, u in moves.items():
            expected = sign * np.real(found.shapes[name][mode])
            np.testing.assert_allclose(u / largest, expected, atol=100 * size)
        # the size of the machine is 1.2 m along x and a little across
        assert largest == pytest.approx(1.2 * size, rel=0.02)


def test_the_joints_stay_closed_in_a_large_picture():
    run = in_mode(crank(), 1, 0.12)
    turned, bent = (positions(run, name)[1] for name in ("wheel", "rod"))
    shape = {body.name: body.nodes for body in run.bodies}["wheel"]
    # of a rigid body the pin is an affine function of its corners
    weights = np.linalg.lstsq(
        np.column_stack([shape, np.ones(len(shape))]).T, [0.1, 0, 0, 1], rcond=None
    )[0]
    np.testing.assert_allclose(weights @ turned, bent[0], atol=1e-9)
    end = 1.2 * jo.Rotate((0, 0, 1), degrees=40).matrix[:, 0]
    np.testing.assert_allclose(bent[-1], end, atol=1e-9)


def test_a_picture_with_its_title(tmp_path: Path):
    found = crank()
    figure = jo.plot(found, 1, path=tmp_path / "mode.png")
    texts = [text.get_text() for text in figure.texts]
    assert f"crank, mode 2: {found.frequencies[1]:.5g} Hz" in texts
    with Image.open(tmp_path / "mode.png") as image:
        assert len(image.getcolors(1 << 20) or ()) > 50


def test_a_body_of_one_point_turns_on_the_spot():
    ball = jo.RigidBody("ball", 2.0, (0.01, 0.01, 0.01))
    held = jo.Spherical("held", jo.ground["origin"], ball["origin"])
    run = in_mode(jo.modes(jo.compile(jo.Mechanism(ball, held))), 0, 0.1)
    turn = 2.0 * np.arccos(run.q[1, 3])
    assert turn == pytest.approx(0.1, rel=1e-6)


def test_what_cannot_be_drawn():
    with pytest.raises(jo.InputError) as caught:
        jo.plot(crank(), 99, scale=-1.0)
    messages = [problem.message for problem in caught.value.problems]
    assert messages[0].startswith("no mode 99; they are 0 to ")
    assert messages[1].startswith("scale is -1")


def post(direction: float) -> jo.simulation.MechanismModes:
    """A body in a ball joint, its centre 0.7 m above or below, in slanting gravity."""
    pull = np.array([0.1, -9.81, 0.37])
    z = direction * pull / np.linalg.norm(pull)
    body = jo.RigidBody("body", 3.0, (0.2, 0.2, 0.2), center=0.7 * z)
    eye = jo.Spherical("eye", jo.ground["origin"], body["origin"])
    return jo.modes(jo.compile(jo.Mechanism(body, eye, jo.Gravity(tuple(pull)), name="post")))


def titles(found: jo.simulation.MechanismModes) -> list[str]:
    pictures = [plot_modes(found, k) for k in range(len(found.frequencies))]
    return [" ".join(t.get_text() for t in x.figure.texts) for x in pictures]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_free_spin_is_drawn_as_a_free_motion(direction: float):
    """Nothing holds the turn about the vertical: neither its rounding error is a rate."""
    found = post(direction)
    assert found.free.tolist() == [True, False, False]
    assert (found.eigenvalues[0], found.frequencies[0], found.damping[0]) == (0.0, 0.0, 0.0)
    free, *others = titles(found)
    assert "mode 1: free motion, 0 Hz" in free
    assert all(("unstable, grows" in x) == (direction < 0) for x in others)
    notes = [mode.note for mode in machine_modes(found).modes]
    assert notes == ["free motion", *(["grows"] * 2 if direction < 0 else [""] * 2)]


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("elements", [10, 150])
def test_the_spin_of_a_stiff_beam_is_free(elements: int, damped: bool):
    """Its fibres ring 1e7 times faster than it swings, which costs its zero 7 digits.

    The pendulum's swing, ``omega^2 = 3 g / 2 l``, is no free motion.
    """
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    ends = [(0, 0, 0), (0, -2, 0)]
    beam = jo.BeamBody("beam", ends, jo.Rectangle(0.02, 0.01), steel, elements=elements)
    eye = jo.Spherical("eye", jo.ground["origin"], beam["start"])
    model = jo.compile(jo.Mechanism(beam, eye, jo.Gravity((0, -9.81, 0)), name="beam"))
    found = jo.modes(model, jo.equilibrium(model), damped=damped, count=6)
    text = [found.describe_mode(k) for k in range(6)]
    assert text[0] == "free motion, 0 Hz"
    assert not any("grows" in x or "decays" in x for x in text)
    swing = 2 * np.pi * found.frequencies[~found.free][:2]
    np.testing.assert_allclose(swing, (3 * 9.81 / 4) ** 0.5, rtol=5e-3)
