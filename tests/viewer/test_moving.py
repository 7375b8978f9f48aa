"""The control of the documentation that loads a machine, see docs/moving.py."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

import pytest

from viewer.browser import UNBUILT, chromium

pytest.importorskip("sphinx")
pytest.importorskip("myst_parser")

ROOT = Path(__file__).parent.parent.parent
PAGE = "# Machines\n\n<!-- moves crane_trolley -->\n"


@pytest.fixture
def moving(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(ROOT / "docs")
    module = importlib.import_module("moving")
    monkeypatch.setattr(module, "KEPT", tmp_path / "kept")
    return module


def build(folder: Path, text: str = PAGE) -> Path:
    """Build a documentation of one page and return the folder of its HTML."""
    from sphinx.application import Sphinx
    from sphinx.util.docutils import docutils_namespace

    source, out = folder / "source", folder / "html"
    source.mkdir(exist_ok=True)
    (source / "conf.py").write_text('extensions = ["myst_parser", "moving"]\n', encoding="utf-8")
    (source / "index.md").write_text(text, encoding="utf-8")
    with docutils_namespace():
        app = Sphinx(
            source, source, out, folder / "trees", "html", status=None, warningiserror=True
        )
        app.build()
        assert app.statuscode == 0
    return out


def test_a_click_moves_a_machine(moving: Any, tmp_path: Path) -> None:
    with chromium() as browser:
        out = build(tmp_path)
        page = browser.new_page(viewport={"width": 1000, "height": 700})
        said: list[str] = []
        asked: list[str] = []
        page.on("console", lambda m: said.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto((out / "index.html").as_uri())
        link = page.locator(".moving a")
        assert link.count() == 1
        # nothing is loaded before
        assert not any("moving/" in address for address in asked)
        assert page.locator("iframe").count() == 0
        link.click()
        frame = page.frame_locator("iframe")
        frame.locator("canvas").first.wait_for()
        (inner,) = (frame for frame in page.frames if "crane_trolley" in frame.url)
        inner.evaluate("window.jousto.ready")
        before = inner.evaluate("window.jousto.app.store.state.time")
        where = inner.evaluate("window.jousto.project(0, 0)")
        inner.wait_for_function(
            "t => Math.abs(window.jousto.app.store.state.time - t) > 0.3", arg=before
        )
        after = inner.evaluate("window.jousto.project(0, 0)")
        assert max(abs(a - b) for a, b in zip(where, after, strict=True)) > 2  # pixels
        assert said == []
        assert all(address.startswith(("file:", "data:", "blob:")) for address in asked)
        # another click removes it
        link.click()
        assert page.locator("iframe").count() == 0
        page.close()


@pytest.mark.skipif(bool(UNBUILT), reason=UNBUILT)
def test_pages_are_kept_until_something_changes(
    moving: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = moving.make("crane_trolley")
    with monkeypatch.context() as changed:
        changed.setattr(moving, "run", lambda name: pytest.fail("it runs again"))
        assert moving.make("crane_trolley") == made
    monkeypatch.setattr(moving, "package", lambda: b"another version of jousto")
    other = moving.make("crane_trolley")
    assert other != made and other.exists() and not made.exists()


def test_without_the_viewer_there_is_no_control(
    moving: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(moving.bundle, "FOLDER", tmp_path / "nowhere")
    out = build(tmp_path)
    text = (out / "index.html").read_text(encoding="utf-8")
    assert "move it" not in text and "moving.js" not in text
    assert not (out / "moving").exists()


def test_machines_of_the_gallery_exist(moving: Any) -> None:
    pages = sorted((ROOT / "docs").glob("gallery*.md"))
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    names = moving.MARK.findall(text)
    assert len(names) > 20 and len({*names}) == len(names)
    assert all(moving.source(name).is_file() for name in names)
    assert {*moving.RUNS} <= {*names}
    # each stands in the section that names its file
    for section in re.split(r"^## ", text, flags=re.M):
        for name in moving.MARK.findall(section):
            assert f"`{name}.py`" in section or f"`{name}.yaml`" in section or name in section
