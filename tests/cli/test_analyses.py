"""jousto equilibrium, modes, linearise and kinematics on cases with closed forms."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app

MODEL = """\
name: bell
bodies: [{name: ball, mass: 2 kg, inertia: [0.01, 0.01, 0.01], center: [0.6, -0.8, 0]}]
joints: [{type: revolute, name: pivot, a: ground.origin, b: ball.origin, axis: [0, 0, 1]}]
gravity: [0, -9.81, 0]
sensors: [{type: position, name: middle, marker: ball.center}]
simulation: {t_end: 1 s}
"""


def jousto(*args: object) -> str:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "bell.yaml"
    path.write_text(MODEL)
    return path


def test_it_rests_with_its_centre_below_the_pivot(model):
    lines = [line.split() for line in jousto("equilibrium", model).splitlines()]
    assert lines[0] == ["bell.yaml", "at", "rest"]
    assert "sensor middle x y z = 0 -1 0 m".split() in lines


def test_it_swings_with_its_closed_form(model):
    """omega^2 = m g l / (J + m l^2), l = 1 m."""
    out = jousto("modes", model)
    (found,) = re.findall(r"mode \d+ +(\S+) Hz, most at ball", out)
    closed = math.sqrt(2 * 9.81 / (0.01 + 2)) / (2 * math.pi)
    assert float(found) == pytest.approx(closed, rel=1e-5)


def test_upright_it_falls_away(model):
    model.write_text(MODEL.replace("[0.6, -0.8, 0]", "[0, 1, 0]"))
    (found,) = re.findall(r"unstable, grows with (\S+) 1/s", jousto("modes", model, "--initial"))
    assert float(found) == pytest.approx(math.sqrt(2 * 9.81 / 2.01), rel=1e-5)


def test_what_nothing_holds_is_free_and_does_not_fall_away(tmp_path):
    """A ball in a ball joint below its centre turns about the vertical as it likes."""
    model = tmp_path / "ball.yaml"
    model.write_text(
        "bodies: [{name: ball, mass: 3 kg, inertia: [0.2, 0.3, 0.2], center: [0, -0.7, 0]}]\n"
        "joints: [{type: spherical, name: eye, a: ground.origin, b: ball.origin}]\n"
        "gravity: [0, -9.81, 0]\n"
        "simulation: {t_end: 1}\n"
    )
    out = jousto("modes", model)
    assert "free motion, 0 Hz, most at ball" in out
    assert "grows" not in out
    assert len(re.findall(r"Hz", out)) == 3


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_the_linear_model_has_the_poles_of_the_pendulum(model, tmp_path, ending):
    target = tmp_path / f"bell.{ending}"
    assert "states   2" in jousto("linearise", model, "-o", target)
    if ending == "npz":
        with np.load(target) as found:
            A, outputs = found["A"], list(found["outputs"])
    else:
        from scipy.io import loadmat

        data = loadmat(target, simplify_cells=True)
        A, outputs = data["A"], list(data["outputs"])
    omega = math.sqrt(2 * 9.81 / (0.01 + 2))
    np.testing.assert_allclose(
        sorted(np.linalg.eigvals(A), key=lambda x: x.imag), [-1j * omega, 1j * omega], atol=1e-9
    )
    assert outputs == ["middle.x", "middle.y", "middle.z"]


def test_the_linear_model_goes_to_a_file_of_matrices(model, tmp_path):
    result = CliRunner().invoke(app, ["linearise", str(model), "-o", str(tmp_path / "a.txt")])
    assert result.exit_code == 2
    assert "must end with .npz or .mat" in result.stderr


def test_kinematics_follows_the_drive(model):
    drive = "couplings: [{type: drive, name: turn, coordinate: pivot.angle, signal: SIGNAL}]"
    signal = "{type: ramp, start: 0 s, end: 1 s, after: 90 deg}"
    model.write_text(MODEL + drive.replace("SIGNAL", signal))
    assert "instants" in jousto("kinematics", model, "-n", 3)
    middle = jo.load(model.with_suffix(".h5"))["middle"]
    # from (0.6, -0.8) by 0, 45 and 90 degrees
    turn = np.radians([0.0, 45.0, 90.0])
    np.testing.assert_allclose(middle[:, 0], 0.6 * np.cos(turn) + 0.8 * np.sin(turn), atol=1e-12)
    np.testing.assert_allclose(middle[:, 1], 0.6 * np.sin(turn) - 0.8 * np.cos(turn), atol=1e-12)


def test_kinematics_of_a_free_motion_is_refused(model):
    result = CliRunner().invoke(app, ["kinematics", str(model)])
    assert result.exit_code == 2
    assert "has 1 motion without a drive" in result.stderr


BEAM = """\
parts:
  rod:
    type: beam
    length: 1 m
    section: {type: rectangle, width: 20 mm, height: 10 mm}
    material: S355
    elements: 8
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 4}
bodies: [{name: arm, part: rod}]
joints: [{type: fixed, name: root, a: ground.origin, b: arm.start}]
forces: [{type: force, name: pull, marker: arm.end, vector: [0, 0, 1 N]}]
sensors:
  - {type: stress, name: all, body: arm}
  - {type: stress, name: few, body: arm, sites: [SITES]}
"""


def test_many_components_stand_in_rows(tmp_path):
    """The largest stress of a cantilever is F l / W = 1 N m / (20 mm (10 mm)^2 / 6) or W of y."""
    sites = "e1.a.top_right, e2.a.top_left"
    model = tmp_path / "beam.yaml"
    model.write_text(BEAM.replace("SITES", sites))
    lines = jousto("equilibrium", model).splitlines()
    few, all_of = lines.index("  sensor few"), lines.index("  sensor all")
    assert all(line.split()[0][:2] in ("e1", "e2") for line in lines[few + 1 : few + 13])
    last = [line for line in lines if "the largest 20 of" in line]
    assert len(last) == 1 and "['all'][0]" in last[0]
    rows = [line.split() for line in lines[all_of + 1 : all_of + 21]]
    assert all(len(row) == 3 and row[2] == "Pa" for row in rows)
    sizes = [abs(float(row[1])) for row in rows]
    assert sizes == sorted(sizes, reverse=True)
    moduli = 0.02 * 0.01**2 / 6, 0.01 * 0.02**2 / 6
    assert any(sizes[0] == pytest.approx(1.0 / W, rel=1e-3) for W in moduli)
