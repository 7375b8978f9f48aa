"""The fatigue block of model files and the files of curves and duty cycles."""

from __future__ import annotations

import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.recovery.fields.criteria import Plane
from jousto.schema.make.blocks.duty import read_duty
from jousto.schema.make.blocks.fatigue import parse_fatigue, read_curve
from jousto.schema.read import parse_model

MODEL = """\
parts:
  rod:
    type: beam
    length: 2 m
    section: {type: rectangle, width: 50 mm, height: 0.1}
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    elements: 2
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}
bodies:
  - {name: arm, part: rod}
  - {name: stone, mass: 1, inertia: [1, 1, 1], position: [2, 0, 0]}
joints:
  - {type: revolute, name: hinge, a: ground.origin, b: arm.start}
  - {type: spherical, name: hook, a: arm.end, b: stone.origin}
gravity: [0, -9.81, 0]
"""
BLOCK = """\
fatigue:
  curves:
    plate: {S_D: 80 MPa, N_D: 1e6, k: 5, rule: haibach, T_S: 1.25, factors: [0.9, 0.8]}
    toe: {fat: 71, standard: en, thickness: 50 mm, joint: butt, factors: [0.8]}
    shaft: {library: RQC-100, pivot: 1000, factors: [0.5]}
  checks:
    - {body: arm, sn: plate, residue: half}
    - name: weld of the arm
      body: arm
      sites: [e1.a.top, e1.a.bottom]
      sn: toe
      criterion: s11
      residue: repeat
      mean: {type: goodman, S_u: 500 MPa, credit: false}
      required: 10 year
      allowable: 0.5
      survival: 97.7 %
    - {body: arm, sn: fat80, residue: ignore, plane: [0, 0, 2], sites: tip}
"""


def test_everything_in_the_block():
    file = parse_model(MODEL + BLOCK)
    assert file.fatigue is not None
    curves = file.fatigue.curves
    assert curves["plate"].S_D == pytest.approx(57.6e6)
    assert (curves["plate"].name, curves["plate"].slope2) == ("plate", 9)
    factor = 0.8 * jo.fatigue.thickness_factor(0.05, "butt")
    assert curves["toe"] == jo.fatigue.fat_class(71, "en", factor=factor)
    assert curves["shaft"] == jo.sn_curve("RQC-100").with_factors(0.5, pivot=1000)
    plain, weld, named = file.fatigue.checks
    assert (plain.name, plain.body, plain.residue, plain.sites) == ("arm", "arm", "half", None)
    assert plain.options == {}
    assert weld.sites == ("e1.a.top", "e1.a.bottom")
    assert weld.options == {
        "criterion": "s11",
        "mean": jo.fatigue.Goodman(500e6, credit=False),
        "required": 10 * 365.2425 * 86400,
        "allowable": 0.5,
        "survival": 0.977,
    }
    assert named.sn == jo.fatigue.fat_class(80)
    assert named.options == {"criterion": Plane((0, 0, 1))}
    assert named.sites == ("tip",)


def test_sensors_count_with_the_curves_of_the_block():
    sensors = """
sensors:
  - {type: stress, name: root, body: arm, sites: [e1.a.top]}
  - {type: damage, name: life, sensor: root, components: "e1.a.top:s11", sn: plate, residue: half}
"""
    file = parse_model(MODEL + BLOCK + sensors)
    assert file.fatigue is not None
    life = next(s for s in file.mechanism.sensors if s.name == "life")
    assert life.sn == file.fatigue.curves["plate"]


def test_the_block_alone_says_the_same():
    """Results are read with their text only, whatever the parts need."""
    found = parse_fatigue(BLOCK + "parts: {arm: {type: nonsense}}\n")
    assert found is not None
    assert [check.name for check in found.checks] == ["arm", "weld of the arm", "arm"]
    assert parse_fatigue(MODEL) is None


@pytest.mark.parametrize(
    ("text", "made"),
    [
        ("{type: goodman, S_u: 500 MPa}", jo.fatigue.Goodman(500e6)),
        ("{type: soderberg, S_y: 355 MPa}", jo.fatigue.Soderberg(355e6)),
        ("{type: morrow, sf: 900 MPa}", jo.fatigue.Morrow(900e6)),
        ("{type: gerber, S_u: 500 MPa}", jo.fatigue.Gerber(500e6)),
        ("{type: swt}", jo.fatigue.SWT()),
        ("{type: walker, gamma: 0.6}", jo.fatigue.Walker(0.6)),
        ("{type: fkm, M: 0.2}", jo.fatigue.FKM(0.2)),
        ("{type: fkm, kind: steel, S_u: 700 MPa}", jo.fatigue.FKM.of("steel", 700e6)),
        ("{type: weld-ratio, residual: low}", jo.fatigue.WeldRatio("low")),
        ("{type: part-compression}", jo.fatigue.PartCompression()),
    ],
)
def test_every_mean_stress_rule(text, made):
    block = f"fatigue: {{checks: [{{body: arm, sn: fat71, residue: half, mean: {text}}}]}}"
    found = parse_fatigue(block)
    assert found is not None and found.checks[0].options["mean"] == made


def test_mistakes_with_their_lines():
    bad = (
        MODEL
        + """\
fatigue:
  curves:
    a: {S_D: 80 MPa, N_D: 1e6, k: 0.5}
    b: {fat: 71e6}
    c: {S_D: 80, N_D: 1e6, k: 5}
  checks:
    - {body: arm, sn: c}
    - {body: stone, sn: c, residue: half}
    - {body: arm, sn: a, residue: half, criterion: s1}
    - {body: arm, sn: fat7q, residue: half, mean: {type: fkm, kind: steel}}
    - {body: arm, sn: c, residue: half, criterion: s11, plane: [0, 0, 1]}
"""
    )
    with pytest.warns(jo.JoustoWarning, match="given in MPa"), pytest.raises(InputError) as caught:
        parse_model(bad)
    text = str(caught.value)
    for words in (
        "model:18: fatigue.curves.a.k: ",
        "model:19: fatigue.curves.b.fat: ",
        "model:22: fatigue.checks.0: residue is missing: give the rule",
        "model:23: fatigue.checks.1.body: no flexible body 'stone'",
        "model:24: fatigue.checks.2.criterion: no criterion 's1'",
        "model:25: fatigue.checks.3.sn: no S-N curve 'fat7q'; did you mean 'fat71'?",
        "model:25: fatigue.checks.3.mean: needs M, or kind (such as steel) and S_u",
        "model:26: fatigue.checks.4.plane: give either criterion or plane",
    ):
        assert words in text
    assert text.count("\n") == 7  # nothing twice, nothing about what failed before


def test_curve_of_a_file(tmp_path):
    path = tmp_path / "weld.yaml"
    path.write_text("fat: 90\nstandard: en\nT_N: 3\n")
    assert read_curve(path) == jo.fatigue.fat_class(90, "en", T_N=3.0)
    path.write_text("S_D: 80 MPa\nN_D: 1e6\n")
    with pytest.raises(InputError, match="weld.yaml:1: 'k' is missing"):
        read_curve(path)


def test_duty_of_a_file(tmp_path):
    path = tmp_path / "duty.yaml"
    path.write_text(
        "transitions: worst\nevents:\n- {result: lift.h5, repeats: 1000, name: lift}\n"
        "- {result: stop.h5}\n"
    )
    duty = read_duty(path)
    assert duty.transitions == "worst"
    assert duty.events == (
        (tmp_path / "lift.h5", 1000.0, "lift"),
        (tmp_path / "stop.h5", 1, "stop"),
    )
    path.write_text("transitions: best\nevents: []\n")
    with pytest.raises(InputError, match="duty.yaml:1: transitions: no transitions 'best'"):
        read_duty(path)
