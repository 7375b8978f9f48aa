"""A headless Chromium that looks at the viewer's page."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from jousto.viewer import bundle

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
# WebGL 2 without a graphics card
FLAGS = [
    *("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"),
    *("--enable-unsafe-swiftshader", "--enable-precise-memory-info"),
]
SIZE = {"width": 1000, "height": 700}
PATIENCE = 90.0  # s, for machines that are busy


UNBUILT = "" if (bundle.FOLDER / bundle.JS).is_file() else "the page was not built: make page"


def missing() -> str:
    """Return why the page cannot be looked at, empty if it can."""
    if UNBUILT:
        return UNBUILT
    if not any(map(shutil.which, NAMES)):
        return "there is no Chromium on the path"
    try:
        import playwright.sync_api  # noqa: F401
    except ImportError:
        return "the package playwright is not installed"
    return ""


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser; a test without one is left out."""
    if missing():
        pytest.skip(missing())
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, NAMES)))
    with sync_playwright() as tool:
        browser = tool.chromium.launch(executable_path=path, args=FLAGS)
        yield browser
        browser.close()


@contextmanager
def opened(browser: Any, address: str, **settings: Any) -> Iterator[Any]:
    """A page that is ready, in which nothing may go wrong."""
    context = browser.new_context(**({"viewport": SIZE} | settings))
    page = context.new_page()
    page.set_default_timeout(1000.0 * PATIENCE)
    said: list[str] = []
    page.on("console", lambda m: said.append(m.text) if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("requestfailed", lambda r: said.append(f"{r.url[:100]} failed: {r.failure}"))
    page.goto(address)
    page.evaluate("window.jousto.ready")
    yield page
    # what a driver without a graphics card says of reading pixels is no fault of the page
    assert [text for text in said if "GL Driver Message" not in text] == []
    context.close()


def until(page: Any, true: Callable[[], bool]) -> None:
    """Wait for what follows later, on a busy machine much later."""
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end
        page.wait_for_timeout(50)
