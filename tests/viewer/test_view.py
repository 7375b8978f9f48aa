"""jo.view and `jousto view`: things and files, pages as one file, the end by Ctrl-C."""

from __future__ import annotations

import base64
import gzip
import html
import re
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from hearing import hear
from jousto.base.errors import InputError, MissingFileError
from jousto.cli.group import app
from jousto.cli.terminal import until_ctrl_c
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.live.recorder import Recorder
from jousto.viewer import bundle
from jousto.viewer.container import unpack
from jousto.viewer.file_watch import Renewed
from jousto.viewer.standalone import FRAMES
from jousto.viewer.view import answers_of
from session import EXAMPLES
from viewer.browser import UNBUILT
from viewer.machines import bar, mechanism, swing


@pytest.fixture(autouse=True)
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page for the tests where Node did not build the real one."""
    if UNBUILT:
        (tmp_path / "page").mkdir()
        (tmp_path / "page" / "viewer.js").write_text('let x = "</script><!--";')
        (tmp_path / "page" / "viewer.css").write_text("body {}")
        monkeypatch.setattr(bundle, "FOLDER", tmp_path / "page")


def call(*words: Any) -> tuple[int, str]:
    """Return exit code and output of a command."""
    found = CliRunner().invoke(app, [str(word) for word in words], prog_name="jousto")
    return found.exit_code, found.output


def contents(path: Path) -> dict[str, Any]:
    """Return what a page that stands alone contains."""
    text = path.read_text("utf-8")
    data = re.search(r'id="jousto-data">([^<]*)<', text)
    assert data
    return unpack(gzip.decompress(base64.b64decode(data[1])))


# -- in Python ------------------------------------------------------------------------------


def test_a_view_has_an_address_until_it_is_closed() -> None:
    view = jo.view(swing(), open=False)
    with urllib.request.urlopen(view.address) as page:
        assert b"swing" in page.read()
    assert view.running and view.address in repr(view)
    view.close()
    assert not view.running and "closed" in repr(view)
    with pytest.raises(OSError):
        urllib.request.urlopen(view.address, timeout=2)


def test_the_browser_is_opened_unless_it_should_not(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: bool(opened.append(address)) or True)
    view = jo.view(swing())
    assert opened == [view.address]
    view.close()


@pytest.mark.parametrize("what", ["run", "mechanism", "model", "reduced", "part", "mesh", "modes"])
def test_all_kinds_of_things_can_be_seen(what: str) -> None:
    from session import objects

    made = objects()
    thing = {
        "run": swing(),
        "mechanism": mechanism(),
        "model": made["model"],
        "reduced": bar(),
        "part": made["solid"],
        "mesh": made["mesh"],
        "modes": jo.modes(made["model"]),
    }[what]
    view = jo.view(thing, open=False, embed=True)
    (scene,) = view._answers.scenes
    assert scene.bodies and np.all(scene.box[1] >= scene.box[0])
    page = html.unescape(view._repr_html_())
    assert page.startswith("<iframe") and "jousto-data" in page


def test_a_cell_shows_the_page_of_the_server() -> None:
    view = jo.view(swing(), open=False)
    cell = view._repr_html_()
    assert f'src="{view.address}"' in cell and "embed=True" in cell
    view.close()
    assert "iframe" not in view._repr_html_()


def test_several_runs_have_names_of_their_own(tmp_path: Path) -> None:
    view = jo.view(swing(), swing(), open=False, embed=True)
    found = contents(view.save(tmp_path / "two.html", frames=5))
    assert found["scene"]["runs"] == ["swing 1", "swing 2"] and len(found["runs"]) == 2


def test_a_page_has_rows_sensors_and_worst_places(tmp_path: Path) -> None:
    run = swing()
    found = contents(jo.view(run, open=False, embed=True).save(tmp_path / "run.html", frames=20))
    # instants of the run, those of the worst places among them
    at = np.searchsorted(run.time, found["time"])
    np.testing.assert_array_equal(found["time"], run.time[at])
    np.testing.assert_array_equal(found["scene"]["frames"], found["time"])
    every = found["scene"]["thinned"]
    assert len(run.time[::every]) <= 20 and {*run.time[::every]} <= {*found["time"]}
    assert jo.hot_spots(run, count=1)[0].time in found["time"]
    np.testing.assert_array_equal(found["rows"][:, : run.q.shape[1]], run.q[at].astype("f4"))
    sensors = found["sensors"]
    assert set(sensors["values"]) == set(run.sensors)
    assert sensors["values"]["ball"].shape == (3, len(sensors["time"]))
    assert found["worst"]["von-mises"][0]["value"] == pytest.approx(
        jo.hot_spots(run, count=1)[0].value
    )
    shapes = found["scene"]["bodies"][0]["shapes"]
    assert shapes.dtype == np.float32


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"port": -1}, "port is -1"),
        ({"port": True}, "port is True"),
        ({"open": "no"}, "open is 'no', must be True or False"),
        ({"damage": 5}, "damage"),
        ({"modes": True}, "modes: need a model file: only a machine"),
    ],
)
def test_wrong_options_are_named(how: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        jo.view(swing(), **({"open": False, "embed": True} | how))


def test_what_cannot_be_seen_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be shown"):
        jo.view(5, open=False)
    with pytest.raises(MissingFileError, match="no such file"):
        jo.view(tmp_path / "none.h5", open=False)
    (tmp_path / "text.txt").write_text("hello")
    with pytest.raises(InputError, match=r"cannot be shown; known: .*\.h5 .*\.yaml .*\.msh"):
        jo.view(tmp_path / "text.txt", open=False)
    (tmp_path / "other.h5").write_bytes(b"no HDF5")
    with pytest.raises(InputError, match="is not an HDF5 file"):
        jo.view(tmp_path / "other.h5", open=False)
    with pytest.raises(InputError, match="is a folder; name a file in it, such as other.h5"):
        jo.view(tmp_path, open=False)
    whole = swing().save(tmp_path / "run.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 3])
    with pytest.raises(InputError, match="cut.h5: is cut off or damaged"):
        jo.view(tmp_path / "cut.h5", open=False)
    with pytest.raises(InputError, match="'swing' is a run, 'bar.*' is modes: only objects of one"):
        jo.view(swing(), bar(), open=False)
    with pytest.raises(InputError, match="up to 4"):
        jo.view(*[swing()] * 5, open=False)
    with pytest.raises(InputError, match="must end with .html"):
        jo.view(swing(), open=False, embed=True).save(tmp_path / "page.pdf")


def test_compared_files_have_their_names(tmp_path: Path) -> None:
    (tmp_path / "new").mkdir()
    first, second = tmp_path / "before.h5", tmp_path / "new" / "before.h5"
    for path in (first, second, tmp_path / "after.h5"):
        swing().save(path)
    assert answers_of([first, tmp_path / "after.h5"]).titles == ["before.h5", "after.h5"]
    assert answers_of([first, second]).titles == [str(first), str(second)]
    assert answers_of([jo.load(first), swing()]).titles == ["before.h5", "swing"]
    assert answers_of([first]).titles == ["swing"]


def test_a_file_that_another_run_takes_is_shown_anew(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    swing().save(path)
    shown = answers_of([path])
    one = {"id": 1, "page": 1}
    assert len(shown.answer({**one, "ask": "scene"})["frames"]) == swing().nt
    path.touch()  # the same run
    assert shown.answer({**one, "ask": "still"}) == {"kind": "done"}
    path.write_bytes(path.read_bytes()[:5000])  # just being written
    assert shown.answer({**one, "ask": "still"}) == {"kind": "done"}
    jo.simulate(jo.compile(mechanism()), 0.02, output_step=2e-3, path=path)
    for ask in ("still", "rows"):
        with pytest.raises(Renewed, match=r"run.h5: was written anew"):
            shown.answer({**one, "ask": ask, "first": 0, "count": 5})
    # a page that begins now sees the new run, and so does the old one when it is loaded again
    for page in (2, 1):
        assert len(shown.answer({"id": 1, "page": page, "ask": "scene"})["frames"]) == 11
        assert shown.answer({"id": 1, "page": page, "ask": "still"}) == {"kind": "done"}


def test_a_model_file_that_was_edited_is_shown_anew(tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    text = (
        "name: ball\nbodies: [{name: ball, mass: 1, inertia: [1, 1, 1]}]\n"
        "joints: [{type: revolute, name: pin, a: ground.origin, b: ball.origin, axis: [0, 1, 0]}]\n"
    )
    path.write_text(text)
    shown = answers_of([path])
    shown.answer({"id": 1, "page": 1, "ask": "scene"})
    path.write_text(text + "gravity: [0, 0\n")
    with pytest.raises(InputError, match=r"model.yaml: has changed, and what it contains now"):
        shown.answer({"id": 1, "page": 1, "ask": "still"})
    path.write_text(text.replace("ball", "disc"))
    with pytest.raises(Renewed):
        shown.answer({"id": 1, "page": 1, "ask": "still"})
    assert shown.answer({"id": 1, "page": 1, "ask": "scene"})["bodies"][0]["name"] == "disc"


def test_a_run_without_an_end_is_said_to_have_none(tmp_path: Path) -> None:
    machine = LiveMachine(jo.compile(mechanism()), jo.GeneralizedAlpha(1e-3))
    recorder = Recorder(tmp_path / "killed.h5", machine)
    recorder.add(machine.step(30), machine.events())
    end = time.monotonic() + 60.0
    while jo.load(recorder.path).nt < 4:  # by a thread of the recorder
        assert time.monotonic() < end
    # as it is now a program leaves it that is killed
    scene = answers_of([recorder.path]).answer({"id": 1, "ask": "scene"})
    assert "unfinished: still running or killed; the 4 instants up to 0.03 s" in scene["note"]
    recorder.close()
    assert "note" not in answers_of([recorder.path]).answer({"id": 1, "ask": "scene"})


# -- on the command line --------------------------------------------------------------------


def test_the_command_writes_a_page_and_says_what_was_left_out(tmp_path: Path) -> None:
    file, page = tmp_path / "run.h5", tmp_path / "run.html"
    swing().save(file)
    code, text = call("view", file, "-o", page, "--frames", 50)
    assert code == 0, text
    size = page.stat().st_size / 1e6
    said = (
        f"page in {page}, {size:.1f} MB; every 6th of 251 instants is in it, --frames 251 takes all"
    )
    assert said in text
    assert 42 <= len(contents(page)["time"]) <= 50  # those of the worst places besides
    code, text = call("view", file, "-o", page)
    assert code == 0 and "instants" not in text and FRAMES >= 251


def test_the_command_colours_damage(tmp_path: Path) -> None:
    file, page = tmp_path / "run.h5", tmp_path / "run.html"
    swing().save(file)
    code, text = call("view", file, "-o", page, "--sn", "fat71", "--residue", "half")
    assert code == 0, text
    assert "damage" in contents(page)["scene"]["measures"]
    code, text = call("view", file, "-o", page, "--damage")
    assert code == 2 and "fatigue" in text


def test_the_command_names_what_is_wrong(tmp_path: Path) -> None:
    code, text = call("view", tmp_path / "none.h5", "-o", tmp_path / "x.html")
    assert code == 2 and "no such file" in text and "Traceback" not in text
    file = tmp_path / "run.h5"
    swing().save(file)
    code, text = call("view", file, "-o", file)
    assert code == 2 and "overwritten" in text
    code, text = call("view", file, "-o", tmp_path / "x.pdf")
    assert code == 2 and "must end with .html" in text


def test_models_parts_and_modes_from_files(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    code, text = call("view", EXAMPLES / "four_bar.yaml", "-o", page)
    assert code == 0, text
    assert contents(page)["scene"]["what"] == "model"
    part = tmp_path / "bar.h5"
    bar().save(part)
    code, text = call("view", part, "-o", page)
    assert code == 0, text
    modes = contents(page)["scene"]["modes"]
    frequencies = [mode["frequency"] for mode in modes]
    np.testing.assert_allclose(frequencies, bar().frequencies, rtol=1e-9)
    code, text = call("view", EXAMPLES / "flexible_pendulum.yaml", "--modes", "-o", page)
    assert code == 0, text
    assert contents(page)["scene"]["what"] == "modes"


@pytest.mark.slow
def test_the_page_of_the_link_arm_can_be_sent_by_mail(tmp_path: Path) -> None:
    """It has 7000 vertices with 18 modes of displacement and stress, and 400 instants: 5 MB."""
    pytest.importorskip("gmsh")
    results, out = tmp_path / "arm.h5", tmp_path / "arm.html"
    assert call("run", EXAMPLES / "link_arm.yaml", "-o", results, "--quiet")[0] == 0
    assert call("view", results, "-o", out)[0] == 0
    arm = next(body for body in contents(out)["scene"]["bodies"] if body["name"] == "arm")
    assert len(arm["positions"]) > 6000 and len(arm["shapes"]) == 18
    assert out.stat().st_size < 5_000_000


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.skipif(bool(UNBUILT), reason=UNBUILT)
def test_ctrl_c_ends_the_command(tmp_path: Path) -> None:
    file = tmp_path / "run.h5"
    swing().save(file)
    command = [sys.executable, "-m", "jousto", "view", str(file), "--no-open"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=hear
    ) as process:
        assert process.stdout and process.stderr
        try:
            address = process.stdout.readline().strip()
            with urllib.request.urlopen(address) as page:
                assert page.status == 200
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=120)
        finally:
            process.kill()
    assert process.returncode == 0
    assert said == "Ctrl-C ends it\n"


class Interrupted:
    """A page at whose opening Ctrl-C is pressed."""

    address, ended = "here", False

    def open(self) -> bool:
        raise KeyboardInterrupt

    def wait(self) -> None:
        raise AssertionError("was interrupted before")

    def close(self) -> None:
        self.ended = True


def test_ctrl_c_ends_the_command_once_the_address_is_out(capsys: pytest.CaptureFixture) -> None:
    page = Interrupted()
    until_ctrl_c(page, opens=True)
    assert page.ended
    assert capsys.readouterr() == ("here\n", "Ctrl-C ends it\n")


def test_ctrl_c_ends_the_command_from_its_first_words_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(*words: object, **how: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("jousto.cli.terminal.say", pressed)
    page = Interrupted()
    until_ctrl_c(page, opens=True)
    assert page.ended
