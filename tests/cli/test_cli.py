"""The command line: outputs, exit codes, one line per problem, files that are kept."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from cli.test_meshes import call
from hearing import hear
from jousto.base.declare import SECTIONS
from jousto.cli import commands
from jousto.cli.group import app
from jousto.schema.read import model_schema

MODEL = """\
name: pendulum
parts:
  rod:
    type: beam
    length: 2 m
    section: {type: rectangle, width: 100 mm, height: 0.1}
    material: {E: 2.1 GPa, nu: 0.3, rho: 7850}
    elements: 4
    reduce: {type: craig-bampton, interfaces: [start], modes: 4}
    in_plane: xy
bodies:
  - {name: arm, part: rod}
joints:
  - {type: spherical, name: pivot, a: ground.origin, b: arm.start}
gravity: [0, -9.81, 0]
sensors:
  - {type: position, name: middle, marker: arm.node3}
  - {type: reaction, name: force, joint: pivot}
simulation: {t_end: 0.2 s, solver: {type: ROS2, step: 1e-3}, output_step: 0.01}
"""
EXAMPLE = Path(__file__).parents[2] / "examples" / "flexible_pendulum.yaml"


class Result:
    def __init__(self, code: int, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err


def jousto(*args: object) -> Result:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return Result(result.exit_code, result.stdout, result.stderr)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "pendulum.yaml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def result(model: Path) -> Path:
    assert jousto("run", "-q", model).code == 0
    return model.with_suffix(".h5")


def replace(path: Path, old: str, new: str) -> Path:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


# -- what is logged -------------------------------------------------------------------------


def test_verbose_says_what_is_chosen_and_quiet_is_quiet(model: Path) -> None:
    found = jousto("-v", "run", "-q", model)
    assert found.code == 0
    assert re.search(r"^jousto.model.compile: pendulum: \d+ velocities, 3 constr", found.err, re.M)
    assert "jousto.simulation.running.simulate: pendulum: ROS2(" in found.err
    assert "jousto." not in jousto("run", "-q", model).err


def test_errors_of_input_are_those_of_python_too(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="mass is -1 kg"):
        jo.RigidBody("ball", -1.0, (1, 1, 1))
    missing = tmp_path / "gone.yaml"
    for read in (jo.read_model, jo.read_mesh, jo.gauges.read_record, jo.ReducedPart.load, jo.load):
        with pytest.raises(FileNotFoundError, match="gone.yaml"):
            read(missing)
        with pytest.raises(jo.InputError):
            read(missing)


# -- check ----------------------------------------------------------------------------------


def test_check_says_what_is_in_the_model(model):
    found = jousto("check", model)
    assert (found.code, found.err) == (0, "")
    lines = [line.split() for line in found.out.splitlines()]
    assert lines[0] == ["pendulum"]
    assert ["joint", "pivot", "spherical,", "ground.origin", "to", "arm.start"] in lines
    assert "flexible, 157 kg, 2 modes" in found.out
    assert "3 constraint rows leave 3 motions as a mechanism, plus 2 elastic modes" in found.out
    assert found.out.endswith("pendulum.yaml: ok\n")


def test_check_reports_every_problem_in_one_line_on_stderr(model):
    replace(model, "b: arm.start", "b: amr.start")
    replace(model, "elements: 4", "elements: 4\n    lumpd: true")
    found = jousto("check", model)
    assert (found.code, found.out) == (2, "")
    assert found.err.splitlines() == [
        "pendulum.yaml:9: parts.rod.lumpd: unknown key 'lumpd'; did you mean 'lumped'?",
        "pendulum.yaml:15: joints.0.b: no body 'amr'; did you mean 'arm'?",
    ]


def test_long_lines_are_not_wrapped(model):
    replace(model, "name: arm", "name: " + 200 * "x")
    found = jousto("check", model)
    assert len(found.err.splitlines()) == 2
    assert max(map(len, found.err.splitlines())) > 200


def test_warnings_are_one_line_each_and_no_python_warnings(model):
    replace(model, "2.1 GPa", "2.1e8")
    found = jousto("check", model)
    assert found.code == 0
    soft, sag = found.err.splitlines()
    assert soft == (
        "warning: pendulum.yaml:7: parts.rod.material.E: E = 2.1e+08 Pa is softer than most "
        "plastics; was it given in kPa?"
    )
    # so soft a rod sags, of which two modes leave out a little
    assert sag.startswith("warning: body 'arm': the 2 modes of body 'arm' leave out 0.04 % of")


def test_check_predicts_an_unstable_step(model):
    replace(model, "{type: ROS2, step: 1e-3}", "{type: RK4, step: 0.02}")
    replace(model, "output_step: 0.01", "output_step: 0.02")
    found = jousto("check", model)
    assert found.code == 0
    (line,) = found.err.splitlines()
    assert line.startswith("warning: pendulum.yaml: simulation: ")
    assert "Hz" in line and "RK4 needs a step below" in line


def test_check_judges_the_step_that_run_takes(model):
    # shortened to the output step of 0.01 s, which suits the modes
    replace(model, "{type: ROS2, step: 1e-3}", "{type: RK4, step: 0.02}")
    assert jousto("check", model).err == ""
    replace(model, "solver: {type: RK4, step: 0.02}, output_step: 0.01", "output_step: 0.02")
    assert jousto("check", model).code == 0


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("output_step: 0.01", "output_step: 0.03", "is not a multiple of output_step = 0.03 s"),
        ("t_end: 0.2 s", "t_end: 1e300", "check the units of t_end, step and output_step"),
    ],
)
def test_check_refuses_the_times_that_run_refuses(model, old, new, sentence):
    replace(model, old, new)
    checked, ran = jousto("check", model), jousto("run", model)
    assert (checked.code, ran.code) == (2, 2)
    assert sentence in checked.err
    assert checked.err == ran.err


def test_a_folder_is_no_input(model, monkeypatch):
    monkeypatch.chdir(model.parent)
    for command in ("check", "run", "info", "reduce", "plot", "animate"):
        for folder in (".", "..", model.parent):
            found = jousto(command, folder)
            assert (found.code, found.out) == (2, ""), command
            assert found.err == f"{folder}: is a folder, must be a file\n"


def test_missing_files_and_folders(tmp_path):
    for command in ("check", "run", "info", "reduce", "plot", "animate"):
        found = jousto(command, tmp_path / "no.yaml")
        assert (found.code, found.out) == (2, ""), command
        assert re.search("no such (results )?file", found.err), command
        assert len(found.err.splitlines()) == 1, command


# -- run ------------------------------------------------------------------------------------


def test_run_writes_next_to_the_model_with_its_text(model):
    found = jousto("run", model)
    assert (found.code, found.err) == (0, "")
    assert "ended                      completed" in found.out
    assert found.out.splitlines()[-1].endswith("pendulum.h5")
    with h5py.File(model.with_suffix(".h5")) as file:
        assert file.attrs["complete"] == 1
        assert file["model"][()].decode() == MODEL
        assert file["time"].shape == (21,)
        assert set(file["sensors"]) == {"middle", "force"}


def test_run_with_output_and_end_time(model, tmp_path):
    target = tmp_path / "other.h5"
    found = jousto("run", model, "-o", target, "--t-end", "50 ms", "-q")
    assert (found.code, found.out, found.err) == (0, "", "")
    with h5py.File(target) as file:
        assert file["time"][-1] == pytest.approx(0.05)
    assert not model.with_suffix(".h5").exists()


def test_run_with_another_step(model):
    assert jousto("run", "-q", model, "--step", "0.5 ms").code == 0
    solver = jo.load(model.with_suffix(".h5")).attributes["solver"]
    assert solver.startswith("ROS2(step=0.0005")
    replace(model, ", solver: {type: ROS2, step: 1e-3}", "")
    assert jousto("run", "-q", model, "--step", "2 ms").code == 0
    assert jo.load(model.with_suffix(".h5")).attributes["step"] == 2e-3
    replace(model, "t_end: 0.2 s", "t_end: 0.2 s, solver: {type: DormandPrince, tolerance: 1e-6}")
    found = jousto("run", "-q", model, "--step", "2 ms")
    assert found.code == 2
    assert "--step: DormandPrince chooses its steps itself; give --tolerance" in found.err


@pytest.mark.parametrize(
    ("args", "sentence"),
    [
        (("--t-end", "3 m"), "--t-end: expects a time (s), got 3 m (a length)"),
        (("--t-end", "0"), "--t-end: is 0 s, must be positive"),
        (("--step", "-1 ms"), "--step: is -0.001 s, must be positive"),
        (("--step", "1 ms", "--tolerance", "1e-6"), "--step: --tolerance chooses the steps"),
        (("-o", "{folder}/pendulum.yaml"), "is the input, it would be overwritten; give -o FILE"),
        (("-o", "{folder}"), "is a folder, must be a file"),
        (("-o", "{folder}/no/x.h5"), "there is no folder"),
    ],
)
def test_bad_options_of_run(model, args, sentence):
    found = jousto("run", model, *(arg.format(folder=model.parent) for arg in args))
    assert (found.code, found.out) == (2, "")
    assert sentence in found.err
    assert len(found.err.splitlines()) == 1
    assert model.read_text() == MODEL


def test_the_input_is_found_behind_a_link(model, tmp_path):
    link = tmp_path / "link.h5"
    link.symlink_to(model)
    assert "is the input" in jousto("run", model, "-o", link).err
    assert model.read_text() == MODEL


def test_run_does_not_overwrite_a_reduced_part(model):
    assert jousto("reduce", model, "rod").code == 0
    part = model.with_name("rod.h5")
    before = part.read_bytes()
    found = jousto("run", model, "-o", part)
    assert found.code == 2
    assert found.err == f"{part}: holds a reduced part; give -o FILE\n"
    assert part.read_bytes() == before


@pytest.mark.parametrize("command", ["run", "reduce"])
def test_only_files_of_the_same_kind_are_overwritten(model, tmp_path, command):
    text, foreign = tmp_path / "precious.yaml", tmp_path / "foreign.h5"
    text.write_text("years of work")
    with h5py.File(foreign, "w") as file:
        file["x"] = 1
    for path in (text, foreign):
        before = path.read_bytes()
        found = jousto(command, model, "-o", path)
        content = "results" if command == "run" else "a reduced part"
        assert (found.code, found.out) == (2, "")
        assert found.err == f"{path}: holds something other than {content}; give -o FILE\n"
        assert path.read_bytes() == before
    # its own kind, what a killed run left and an empty file
    target = tmp_path / "target.h5"
    target.touch()
    assert jousto(command, model, "-o", target).code == 0
    assert jousto(command, model, "-o", target).code == 0
    target.write_bytes(target.read_bytes()[:2000])
    assert jousto(command, model, "-o", target).code == 0


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write anywhere")
def test_unwritable_folder(model):
    model.parent.chmod(0o555)
    try:
        found = jousto("run", model)
    finally:
        model.parent.chmod(0o755)
    assert found.code == 2
    assert "must not be written to" in found.err


def test_a_model_without_a_simulation_needs_an_end_time(model):
    model.write_text("\n".join(MODEL.splitlines()[:-1]))
    found = jousto("run", model)
    assert found.code == 2
    assert found.err == (
        "pendulum.yaml: does not say how long to simulate; add simulation: {t_end: 10 s}, "
        "or give --t-end\n"
    )
    assert jousto("run", "-q", model, "--t-end", "0.01").code == 0


def test_a_run_that_diverges_fails_with_time_cause_and_kept_results(model):
    replace(model, "{type: ROS2, step: 1e-3}", "{type: RK4, step: 0.1}")
    replace(model, "t_end: 0.2 s", "t_end: 100 s")
    replace(model, "output_step: 0.01", "output_step: 0.1")
    replace(model, "2.1 GPa", "210 GPa")
    found = jousto("run", model)
    assert found.code == 1
    assert found.out == ""
    lines = found.err.splitlines()
    assert re.match(r"warning: .*the run will probably diverge", lines[0])
    assert re.match(r"the run stopped at [\d.e+-]+ s: body 'arm' diverged; likely cause", lines[1])
    assert lines[2] == f"the results up to then are in {model.with_suffix('.h5')}"
    with h5py.File(model.with_suffix(".h5")) as file:
        assert file.attrs["complete"] == 0


# -- info, plot, animate --------------------------------------------------------------------


def test_info_of_model_result_and_part(model, result):
    assert "joint pivot" in jousto("info", model).out
    found = jousto("info", result)
    assert found.code == 0
    assert "sensor middle  position of arm.node3, 3 values" in found.out
    assert jousto("reduce", model).code == 0
    found = jousto("info", model.with_name("rod.h5"))
    assert found.code == 0
    assert "reduced part rod" in found.out
    assert "interfaces   start" in found.out
    assert "named nodes  start, end\n" in found.out
    lines = [line.strip() for line in found.out.splitlines()]
    # a straight rod: mass, half of it times its length, a third of it times its length squared
    part = jo.ReducedPart.load(model.with_name("rod.h5"))
    m, L = part.invariants.mass, float(np.ptp(part.nodes[:, 0]))
    assert f"I1      mass, {m:.6g} kg" in lines
    assert f"I2      first moment, {m * L / 2:.6g}, 0, 0 kg m" in lines
    assert [x.split()[0] for x in lines if re.match(r"I\d ", x)] == [f"I{k}" for k in range(1, 10)]
    # one interface: nothing of it deforms alone
    assert sum("Hz, vibration, 0 % static" in x for x in lines) == part.n


def test_info_of_damaged_and_foreign_files(tmp_path, result):
    text = tmp_path / "text.h5"
    text.write_text("rubbish")
    assert jousto("info", text).err == f"{text}: is not an HDF5 file, or it is damaged\n"
    cut = tmp_path / "cut.h5"
    cut.write_bytes(result.read_bytes()[:3000])
    found = jousto("info", cut)
    assert found.code == 2
    assert found.err.startswith(f"{cut}: ")
    assert len(found.err.splitlines()) == 1
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["x"] = 1
    found = jousto("info", tmp_path / "foreign.h5")
    assert found.code == 2
    assert "not" in found.err


def test_plot_writes_a_picture(result, tmp_path):
    found = jousto("plot", result, "middle.y", "energy")
    assert (found.code, found.err) == (0, "")
    assert result.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    assert jousto("plot", result, "-o", tmp_path / "p.svg").code == 0
    assert "<svg" in (tmp_path / "p.svg").read_text()


def test_plot_of_an_unknown_sensor(result):
    found = jousto("plot", result, "midle")
    assert (found.code, found.out) == (2, "")
    assert found.err == f"{result}: no sensor 'midle'; did you mean 'middle'?\n"


def test_plot_and_animate_do_not_overwrite_the_result(result):
    before = result.read_bytes()
    for command in (("plot", result, "middle"), ("animate", result)):
        found = jousto(*command, "-o", result)
        assert found.code == 2
        assert "is the input" in found.err
    assert result.read_bytes() == before


def test_plot_and_animate_do_not_overwrite_models_and_data(model, result, tmp_path):
    (tmp_path / "data.json").write_text("{}")
    part = tmp_path / "part.png"
    assert jousto("reduce", model, "-o", part).code == 0
    for path in (model, tmp_path / "data.json", part):
        before = path.read_bytes()
        for command in (("plot", result, "middle"), ("animate", result)):
            found = jousto(*command, "-o", path)
            assert found.code == 2
            assert found.err == f"{path}: holds data, not a picture; give -o FILE\n"
        assert path.read_bytes() == before


def test_animate_writes_a_film_or_a_picture(result, tmp_path):
    found = jousto("animate", result, "--fps", "10", "--trail", "middle", "--view", "xy")
    assert (found.code, found.err) == (0, "")
    assert result.with_suffix(".gif").read_bytes().startswith(b"GIF")
    assert jousto("animate", result, "-o", tmp_path / "a.png").code == 0
    found = jousto("animate", result, "-o", tmp_path / "a.doc")
    assert found.code == 2
    assert "'.doc' is not a format" in found.err


# -- reduce ---------------------------------------------------------------------------------


def test_reduce_a_part_of_a_model_or_a_part_file(model, tmp_path):
    found = jousto("reduce", model, "rod")
    assert (found.code, found.err) == (0, "")
    assert "modes        2" in found.out
    alone = tmp_path / "beam.yaml"
    alone.write_text("\n".join(line[4:] for line in MODEL.splitlines()[3:10]))
    assert jousto("reduce", alone).code == 0
    assert (tmp_path / "beam.h5").exists()
    target = tmp_path / "x.h5"
    assert jousto("reduce", model, "-o", target).code == 0
    # and the model can use it
    replace(model, MODEL[MODEL.index("    type: beam") : MODEL.index("bodies")], "    file: x.h5\n")
    assert jousto("check", model).code == 0


def test_reduce_with_a_wrong_name_or_over_a_result(model, result):
    found = jousto("reduce", model, "rdo")
    assert found.code == 2
    assert found.err == "pendulum.yaml:2: parts: no part 'rdo'; did you mean 'rod'?\n"
    found = jousto("reduce", model, "-o", result)
    assert found.err == f"{result}: holds results; give -o FILE\n"


# -- schema, version, debug -----------------------------------------------------------------


def test_schema_is_json():
    found = jousto("schema")
    assert found.code == 0
    assert json.loads(found.out) == json.loads(json.dumps(model_schema()))


def test_version():
    found = jousto("--version")
    assert found.code == 0
    assert re.fullmatch(r"jousto \S+\n", found.out)


def test_no_command_shows_the_help_and_a_wrong_one_is_bad_input():
    assert "Simulate mechanisms" in jousto().out
    assert jousto("simulate").code == 2
    assert jousto("check").code == 2


def test_errors_have_no_traceback_unless_debug_asks_for_it(model, monkeypatch):
    from jousto.base.errors import InputError

    replace(model, "b: arm.start", "b: amr.start")
    assert "Traceback" not in jousto("check", model).err
    result = CliRunner().invoke(app, ["check", str(model), "--debug"])
    assert isinstance(result.exception, InputError)


def test_a_bug_is_reported_as_one(model, monkeypatch):
    def broken(file):
        raise ZeroDivisionError("oh no")

    monkeypatch.setattr(commands, "describe_model", broken)
    found = jousto("check", model)
    assert found.code == 1
    assert found.err.splitlines() == [
        "internal error, ZeroDivisionError: oh no",
        "this is a bug of jousto; run again with --debug to see where",
    ]


# -- the real thing -------------------------------------------------------------------------


def test_a_real_process_checks_runs_and_fails(model):
    def run(*args: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "jousto", *args]
        return subprocess.run(command, cwd=model.parent, capture_output=True, text=True)

    done = run("check", "pendulum.yaml")
    assert (done.returncode, done.stderr) == (0, "")
    done = run("run", "pendulum.yaml")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("results in pendulum.h5\n")
    replace(model, "arm.start", "amr.start")
    done = run("check", "pendulum.yaml")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == ("pendulum.yaml:14: joints.0.b: no body 'amr'; did you mean 'arm'?\n")


def test_check_imports_nothing_that_only_pictures_need(model):
    code = (
        "import sys; from jousto.cli.group import app\n"
        f"try: app(['check', {str(model)!r}])\n"
        "except SystemExit as end: assert end.code == 0\n"
        "heavy = {'matplotlib', 'scipy.stats', 'scipy.signal', 'rich.progress'}\n"
        "print(heavy & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "set()"


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_leaves_a_readable_file(model):
    command = [sys.executable, "-m", "jousto", "run", "-q", str(model), "--t-end", "100000"]
    process = subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=hear,
    )
    target = model.with_suffix(".h5")
    deadline = time.monotonic() + 180
    try:
        while not (target.exists() and target.stat().st_size > 20_000):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=180)
    finally:
        process.kill()
    assert process.returncode == 1
    assert re.match(r"stopped at [\d.]+ s; the results up to then are in .*pendulum.h5\n$", err)
    with h5py.File(target) as file:
        assert file.attrs["complete"] == 0
        assert file["time"][-1] > 0


@pytest.mark.parametrize("command", ["check", "info"])
def test_letters_that_a_terminal_does_not_know_are_spelled_out(command, tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8").replace("name: tip", "name: Höhe √")
    model = tmp_path / "m.yaml"
    model.write_text(text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "jousto", command, model],
        capture_output=True,
        env={
            **os.environ,
            "PYTHONIOENCODING": "ascii",
            "PYTHONPATH": os.pathsep.join(sys.path),
        },
    )
    assert done.returncode == 0, done.stderr
    assert rb"H\xf6he \u221a" in done.stdout


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("name: flexible pendulum", "name: [1, 2]", "name: expects text, got a list of 2"),
        ("[0, 1], [1, 2]", "[0, 1e30], [1, 2]", "whole number below 2^53, got 1e+30"),
        ("[0, 1], [1, 2]", f"[0, {10**30}], [1, 2]", "whole number below 2^53, got 1e+30"),
    ],
)
def test_what_is_no_text_and_no_index_gets_a_sentence(old, new, sentence, tmp_path):
    model = tmp_path / "m.yaml"
    text = EXAMPLE.read_text(encoding="utf-8")
    assert old in text
    model.write_text(text.replace(old, new, 1), encoding="utf-8")
    code, text = call("check", model)
    assert code == 2
    assert sentence in text
    assert "internal error" not in text


# -- classes of the user ---------------------------------------------------------------------------

OWN = """
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.joints.coordinate import CoordinateField


class Pull(ForceElement, tag="pull of the test"):
    \"""A constant force.\"""

    coordinate: CoordinateField = field("Along it")
    force: Number = field("How strong", unit="N")

    @property
    def pushes(self):
        return (Push("along", {"preload": self.force}, coordinate=self.coordinate),)
"""
SLED = """\
bodies: [{name: sled, mass: 2 kg, inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: rail, a: ground.origin, b: sled.origin, axis: [1, 0, 0]}]
forces: [{type: pull of the test, name: rope, coordinate: rail.displacement, force: 0.1 kN}]
sensors: [{type: acceleration, name: sled, marker: sled.origin}]
simulation: {t_end: 10 ms, solver: {type: RK4, step: 1 ms}}
"""


def test_model_files_know_the_classes_of_a_file_that_is_given(tmp_path: Path) -> None:
    sled, own = tmp_path / "sled.yaml", tmp_path / "own.py"
    sled.write_text(SLED)
    own.write_text(OWN)
    assert "forces.0.type: no force type 'pull of the test'" in jousto("check", sled).err
    try:
        found = jousto("--with", own, "run", "-q", sled)
    finally:
        SECTIONS["forces"].pop("pull of the test", None)
    assert found.code == 0, found.err
    assert jo.load(sled.with_suffix(".h5"))["sled"][-1, 0] == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (None, "own.py: no such file"),
        ("1 / 0", "own.py: cannot be imported: ZeroDivisionError: division by zero"),
        ("import jousto as jo; jo.Material(1, nu=9)", "missing 1 argument: 'rho'"),
    ],
)
def test_a_file_of_classes_that_fails(tmp_path: Path, text: str | None, sentence: str) -> None:
    own = tmp_path / "own.py"
    if text is not None:
        own.write_text(text)
    found = jousto("--with", own, "schema")
    assert found.code == 2 and sentence in found.err and found.out == ""
