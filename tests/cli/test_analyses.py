"""jousto equilibrium and jousto modes on a compound pendulum with its closed form."""

from __future__ import annotations

import math
import re

import pytest
from typer.testing import CliRunner

from jousto.cli import app

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
    assert ["sensor", "middle", "0", "-1", "0", "m"] in lines


def test_it_swings_with_its_closed_form(model):
    """omega^2 = m g l / (J + m l^2), l = 1 m."""
    out = jousto("modes", model)
    (found,) = re.findall(r"mode \d+ +(\S+) Hz, most at ball", out)
    closed = math.sqrt(2 * 9.81 / (0.01 + 2)) / (2 * math.pi)
    assert float(found) == pytest.approx(closed, rel=1e-5)


def test_upright_it_falls_away(model):
    model.write_text(MODEL.replace("[0.6, -0.8, 0]", "[0, 1, 0]"))
    (found,) = re.findall(r"falls away, (\S+) 1/s", jousto("modes", model, "--initial"))
    assert float(found) == pytest.approx(math.sqrt(2 * 9.81 / 2.01), rel=1e-5)
