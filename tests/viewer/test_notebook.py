"""What things look like in notebooks: IPython's own formatter, and a kernel that runs cells."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
import session
from jousto.viewer import notebook

VOID = {"img", "br", "meta"}


class Sound(HTMLParser):
    """Fails for an element that is not closed where it should be."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def shown(thing: Any) -> str:
    """Return the HTML that IPython shows of a thing."""
    formatters = pytest.importorskip("IPython.core.formatters")
    formatter = formatters.DisplayFormatter()

    class Shell:
        display_formatter = formatter

    notebook.register(Shell())
    data, _ = formatter.format(thing, include={"text/html"})
    assert "text/html" in data
    Sound(data["text/html"])
    return str(data["text/html"])


def text_of(page: str) -> str:
    return re.sub(r"<[^>]*>", " ", page)


def test_every_type_that_is_shown_exists() -> None:
    for place in notebook.SHOWN:
        module, _, name = f"jousto.{place}".rpartition(".")
        kind = getattr(__import__(module, fromlist=[name]), name)
        assert f"{kind.__module__}.{kind.__qualname__}" == f"jousto.{place}"


def test_a_run_shows_its_sensors_and_energy() -> None:
    run = session.objects()["run"]
    text = text_of(shown(run))
    assert all(name in text for name in run.sensors)
    assert run.energy.verdict in text and "jo.view(run)" in text
    assert f"{run.nt}, 0 to {run.time[-1]:g} s" in text


def test_a_mechanism_shows_its_bodies_joints_and_gravity() -> None:
    text = text_of(shown(session.objects()["mechanism"]))
    for word in ("body arm", "joint hinge", "friction grip", "0 0 -9.81 m/s2"):
        assert word in text


def test_parts_and_meshes_show_a_picture() -> None:
    made = session.objects()
    for name in ("beam", "reduced", "solid", "reduced solid", "mesh"):
        page = shown(made[name])
        assert 'src="data:image/png;base64,' in page and "jo.view(" in page
    text = text_of(shown(made["solid"]))
    assert f"{made['solid'].mass:.6g} kg" in text


def test_a_reduced_part_shows_its_modes() -> None:
    part = session.objects()["reduced"]
    text = text_of(shown(part))
    assert all(f"{f:.6g}" in text for f in part.frequencies[:10])
    assert "certify" in text


def test_a_certificate_shows_its_checks_and_advice() -> None:
    found = session.objects()["certificate"]
    page = text_of(shown(found))
    assert all(check.topic in page for check in found.checks)
    assert found.verdict in page


def test_damage_and_a_monitor_show_their_places() -> None:
    made = session.objects()
    damage = next(x for x in made.values() if type(x).__name__ == "DamageField")
    assert damage.worst(1)[0] in text_of(shown(damage))
    monitor = next(x for x in made.values() if type(x).__name__ == "Monitor")
    text = text_of(shown(monitor))
    assert all(place in text for place in (*monitor.spots, *monitor.channels))


def test_names_of_a_user_are_no_html() -> None:
    evil = "<script>alert(1)</script>"
    run = session.objects()["run"]
    assert evil not in notebook.cell(evil, notebook.table([(evil, evil)]), evil)
    assert "<script" not in shown(run)


def test_matrices_have_no_picture() -> None:
    part = jo.Part.from_matrices(np.eye(6), np.zeros((6, 6)), [(0, 0, 0)])
    assert "<img" not in shown(part)


def test_importing_does_not_import_ipython() -> None:
    code = (
        "import sys, jousto; sys.exit('IPython' in sys.modules or 'jousto.viewer' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# -- a kernel -------------------------------------------------------------------------------

CELLS = [
    "import jousto as jo",
    """ball = jo.RigidBody("ball", 1.0, (1, 1, 1), position=(1, 0, 0))
rod = jo.Rod("rod", jo.ground["origin"], ball["origin"])
model = jo.compile(jo.Mechanism(ball, rod, jo.Gravity((0, -9.81, 0)), name="fall"))
run = jo.simulate(model, 0.5, progress=True)""",
    "run",
    'part = jo.Part.beam(1.0, jo.Circle(0.01), 4, jo.material("S355"))\npart',
    'jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2), progress=True)',
]


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Any]]:
    """The outputs of the cells, of a kernel that ran them."""
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(x) for x in CELLS])
    folder: Path = tmp_path_factory.mktemp("book")
    resources = {"metadata": {"path": str(folder)}}
    nbclient.NotebookClient(book, timeout=600, resources=resources).execute()
    yield [cell.outputs for cell in book.cells]


def html_of(outputs: list[Any]) -> list[str]:
    return [x["data"]["text/html"] for x in outputs if "text/html" in x.get("data", {})]


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_a_kernel_shows_things_and_bars(outputs: list[Any]) -> None:
    assert outputs[0] == []  # no message, no warning
    (bar,) = html_of(outputs[1])
    assert '<progress value="1.0000">' in bar and "0.500 of 0.5 s" in bar
    assert "run of fall" in html_of(outputs[2])[0]
    assert "part beam" in html_of(outputs[3])[0]
    stages, reduced = html_of(outputs[4])
    assert stages.count("<progress") >= 2
    assert "reduced part beam" in reduced
    streams = [x for cell in outputs for x in cell if x["output_type"] in ("stream", "error")]
    assert streams == []
