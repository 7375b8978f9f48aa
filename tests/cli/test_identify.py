"""jousto identify: a model file with values from a record, all mistakes at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.base.errors import InputError
from jousto.cli.group import app
from jousto.schema.file.new_values import with_values

MODEL = """\
# a load on a spring
parameters:
  stiffness: {value: 0.06 kN/m, bounds: [1 N/m, 10 kN/m]}   # from the catalogue
  mass: 2 kg
bodies: [{name: load, mass: "${mass}", inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: slide, a: ground.origin, b: load.origin, axis: [1, 0, 0]}]
forces:
- {type: spring, name: coil, coordinate: slide.displacement, stiffness: "${stiffness}"}
- type: joint-force
  name: push
  coordinate: slide.displacement
  signal: {type: input, name: force}
sensors: [{type: coordinate, name: x, coordinate: slide.displacement}]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the model and records of a step of 4 N on 50 N/m, 2 kg."""
    (tmp_path / "trolley.yaml").write_text(MODEL)
    t = np.linspace(0.0, 2.0, 81)
    x = 4.0 / 50.0 * (1.0 - np.cos(5.0 * t))
    for seed, name in enumerate(("step", "check")):
        noise = np.random.default_rng(seed).normal(0.0, 1e-4, t.size)
        rows = [f"{a:.4f},4.0,{b * 1e3:.5f}" for a, b in zip(t, x + noise, strict=True)]
        (tmp_path / f"{name}.csv").write_text(
            "\n".join(["time [s],force [N],laser [mm]", *rows]) + "\n"
        )
    return tmp_path


def jousto(*args: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    return result.exit_code, result.output


def test_the_new_model_file_keeps_everything_but_the_value(folder: Path) -> None:
    found, page = folder / "found.yaml", folder / "page.html"
    code, out = jousto(
        *("identify", folder / "trolley.yaml", "--measured", folder / "step.csv"),
        *("--pair", "laser=x", "--noise", "laser=0.1mm", "--check", folder / "check.csv"),
        *("-o", found, "--html", page),
    )
    assert code == 0, out
    assert "stiffness" in out and "check" in out and "mass" not in out
    text = found.read_text()
    assert text.startswith("# jousto identify of trolley.yaml on ")
    assert "step.csv (sha256 " in text
    body = text[text.index("# a load") :].splitlines()
    for old, new in zip(MODEL.splitlines(), body, strict=True):
        if "catalogue" in old:
            assert new.startswith("  stiffness: {value: 0.0")
            assert new.endswith(" kN/m, bounds: [1 N/m, 10 kN/m]}   # from the catalogue")
        else:
            assert new == old
    assert jo.read_model(found).parameters[0].value == pytest.approx(50.0, rel=1e-3)
    shown = page.read_text()
    assert "<h1>Identification</h1>" in shown and shown.count("data:image/png") == 1
    # once more: a file of this command is replaced
    code, out = jousto(
        *("identify", folder / "trolley.yaml", "--measured", folder / "step.csv", "-q"),
        *("--pair", "laser=x", "--free", "stiffness=10..100N/m", "-o", found),
    )
    assert code == 0, out


def test_gain_bias_and_shift_are_sought_by_channel(folder: Path) -> None:
    code, out = jousto(
        *("identify", folder / "trolley.yaml", "--measured", folder / "step.csv"),
        *("--pair", "laser=x", "--noise", "laser=0.1 mm", "--gain", "laser", "--shift", "laser"),
        *("--bias", "laser"),
    )
    assert code == 0, out
    for name in ("gain laser", "bias laser", "shift laser"):
        assert name in out


def test_all_mistakes_come_at_once(folder: Path) -> None:
    other = folder / "notes.yaml"
    other.write_text("mine: 1\n")
    code, out = jousto(
        *("identify", folder / "trolley.yaml", "--measured", folder / "step.csv"),
        *("--pair", "lazer=x", "--noise", "laser=wide", "--free", "stifness", "--free", "mass=1,2"),
        *("--gain", "y", "-o", other, "--html", folder / "page.pdf"),
    )
    assert code == 2
    for sentence in (
        "--pair: no channel 'lazer'; did you mean 'laser'?",
        "--noise laser",
        "--free: no parameter 'stifness'; did you mean 'stiffness'?",
        "--free mass: must have bounds, such as 2..8mm",
        "--gain: no channel 'y'",
        "notes.yaml: holds a file that this command has not written",
        "'.pdf' is not a format",
    ):
        assert sentence in " ".join(out.split()), (sentence, out)
    assert other.read_text() == "mine: 1\n"


def test_modes_of_a_file_are_fitted(folder: Path) -> None:
    # set 15: a node at the load; set 55: 50 N/m on 2 kg in the x direction
    mode = ["    -1", "    55", "NONE", "NONE", "NONE", "NONE", "NONE",
            "         1         2         3         8         2         6",
            "         2         4         1         1",
            f"{5 / 2 / np.pi:13.5e}  1.00000e+00  0.00000e+00  0.00000e+00", "         1",
            "  1.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00",
            "    -1"]  # fmt: skip
    node = ["    -1", "    15", "         1         0         0        11" + 3 * "  0.00000e+00",
            "    -1"]  # fmt: skip
    (folder / "hammer.uff").write_text("\n".join([*node, *mode]) + "\n")
    code, out = jousto("identify", folder / "trolley.yaml", "--modes", folder / "hammer.uff")
    assert code == 0, out
    (line,) = (line for line in out.splitlines() if "stiffness" in line)
    assert float(line.split()[3]) == pytest.approx(50.0, rel=1e-4)
    code, out = jousto("identify", folder / "trolley.yaml")
    assert code == 2 and "no record; give --measured FILE or --modes FILE" in out


def test_the_model_itself_is_not_overwritten(folder: Path) -> None:
    model = folder / "trolley.yaml"
    code, out = jousto(*("identify", model, "--measured", folder / "step.csv", "-o", model))
    assert code == 2 and model.read_text() == MODEL, out


@pytest.mark.parametrize(
    ("text", "values", "new"),
    [
        ("parameters: {k: 2}", {"k": 3.25}, "parameters: {k: 3.25}"),
        ('parameters: {k: "2 kN/m"}', {"k": 2500.0}, 'parameters: {k: "2.5 kN/m"}'),
        ("parameters:\n  c: 1 N s/m # oil\n", {"c": 0.5}, "parameters:\n  c: 0.5 N s/m # oil\n"),
        ('{"parameters": {"k": 1e3}}', {"k": 2e3}, '{"parameters": {"k": 2000}}'),
        ("parameters: {a: 90 deg}", {"a": np.pi}, "parameters: {a: 180 deg}"),
    ],
)
def test_values_are_written_in_their_own_units(
    text: str, values: dict[str, float], new: str
) -> None:
    assert with_values(text, values) == new


def test_values_that_cannot_be_written() -> None:
    with pytest.raises(InputError) as caught:
        with_values('parameters: {k: "${a}", b: 1}', {"k": 1.0, "d": 2.0})
    assert "k is '\"${a}\"', which is no number with a unit" in str(caught.value)
    assert "the text has no value of 'd'" in str(caught.value)
