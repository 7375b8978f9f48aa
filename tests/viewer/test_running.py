"""A page in which a machine runs: its module against the engine, the page in a real browser."""

from __future__ import annotations

import base64
import gzip
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from exported import STEP, swinging_arm
from jousto.export import toolchain
from jousto.viewer import bundle
from jousto.viewer.container import unpack
from viewer.browser import chromium, opened

pytest.importorskip("ziglang")

STEPS = 400
PUSH = 4.0  # N m, from a tenth of the way on
# round-off of 1e-16 in each of some 100 operations a step, and a swing that does not amplify it
SAME = 1e-9


@pytest.fixture(scope="module")
def model() -> jo.Model:
    return jo.compile(swinging_arm())


@pytest.fixture(scope="module")
def page(model: jo.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("running") / "arm.html"
    with pytest.MonkeyPatch.context() as patch:
        if not (bundle.FOLDER / bundle.JS).is_file():  # of a page that was not built its data count
            patch.setattr(bundle, "read_bundle", lambda: {bundle.JS: b"", bundle.CSS: b""})
        return jo.write(model, out, solver=jo.ROS2(step=STEP), ranges={"push": (-9.0, 9.0)})


@pytest.fixture(scope="module")
def stored(page: Path) -> dict[str, Any]:
    text = re.search(rf'id="{bundle.DATA}">([^<]*)<', page.read_text())
    assert text is not None
    return unpack(gzip.decompress(base64.b64decode(text[1])))


@pytest.fixture(scope="module")
def native(model: jo.Model) -> tuple[np.ndarray, np.ndarray]:
    """Positions and sensor values of each step by the engine, pushed from a tenth of the way on."""
    run = jo.simulate(
        model,
        STEPS * STEP,
        solver=jo.ROS2(step=STEP),
        inputs={"push": lambda t: PUSH if t > (STEPS // 10 - 0.5) * STEP else 1.5},
        output_step=STEP,
    )
    sensors = np.column_stack([run[s.name].reshape(run.nt, -1) for s in model.sensors])
    return run.q, sensors


def difference(found: np.ndarray, wanted: np.ndarray) -> float:
    """Return the largest difference of the columns over their largest values."""
    scale = np.maximum(np.abs(wanted).max(axis=0), 1e-6 * np.abs(wanted).max())
    return float((np.abs(found - wanted) / scale).max())


def test_the_module_in_another_host_computes_what_the_engine_does(
    stored: dict[str, Any], native: tuple[np.ndarray, np.ndarray]
) -> None:
    wasmtime = pytest.importorskip("wasmtime")
    store = wasmtime.Store()
    module = wasmtime.Module(store.engine, stored["code"].tobytes())
    assert not list(module.imports), "nothing of the host"
    exports = wasmtime.Instance(store, module, []).exports(store)

    def call(name: str, *given: float) -> Any:
        return exports[name](store, *given)

    def numbers(name: str, count: int) -> np.ndarray:
        at = call(name)
        return np.frombuffer(exports["memory"].read(store, at, at + 8 * count), dtype="<f8")

    call("_initialize")
    assert call("start") == 0
    rows, sensors = [], []
    for k in range(STEPS + 1):
        if k == STEPS // 10:
            assert call("set_input", 0, PUSH) == 0
        rows.append(numbers("positions", stored["nq"]))
        sensors.append(numbers("outputs", stored["nout"]))
        assert call("advance", 1) == 0
    off = difference(np.array(rows), native[0]), difference(np.array(sensors), native[1])
    print("wasmtime against the engine:", off)
    assert max(off) < SAME
    assert call("set_input", 0, float("nan")) == call("set_input", 7, 1.0) == 3  # refused


# -- in a browser ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture
def shown(browser: Any, page: Path) -> Iterator[Any]:
    """The page from disk; it may ask for nothing else, and no error is logged."""
    asked: list[str] = []
    with opened(browser, page.as_uri()) as found:
        found.on("request", lambda request: asked.append(request.url))
        yield found
    assert not asked


def test_the_page_computes_what_the_engine_does(
    shown: Any, native: tuple[np.ndarray, np.ndarray]
) -> None:
    found = shown.evaluate(
        """([steps, push]) => { const machine = window.jousto.app.source.machine, rows = [];
        for (let k = 0; k <= steps; k++) {
            if (k === Math.floor(steps / 10)) machine.input(0, push);
            rows.push([Array.from(machine.positions()), Array.from(machine.outputs())]);
            machine.advance(1);
        } return rows; }""",
        [STEPS, PUSH],
    )
    rows, sensors = (np.array([row[k] for row in found]) for k in (0, 1))
    off = difference(rows, native[0]), difference(sensors, native[1])
    print("Chromium against the engine:", off)
    assert max(off) < SAME


def angle(page: Any) -> float:
    return float(page.evaluate("Array.from(window.jousto.app.source.machine.positions())[5]"))


def now(page: Any) -> float:
    return float(page.evaluate("window.jousto.app.source.machine.time"))


def test_buttons_and_sliders_steer_it(shown: Any) -> None:
    step = shown.get_by_label("One step")
    for _ in range(5):
        step.click()
    assert np.isclose(now(shown), 0.05)  # intervals of ten steps
    free = angle(shown)
    shown.get_by_label("Back to the start").click()
    assert now(shown) == 0.0
    slider = shown.locator("input[type=range]").first
    slider.evaluate(
        "s => { s.value = s.max; s.dispatchEvent(new Event('input', { bubbles: true })); }"
    )
    for _ in range(5):
        step.click()
    assert abs(angle(shown) - free) > 1e-3, "the slider moves it"
    # it stays where it is until it runs, then stops when it is told to
    at = now(shown)
    shown.get_by_label("Run", exact=True).click()
    for _ in range(200):
        if now(shown) > at + 0.02:
            break
        shown.wait_for_timeout(50)
    assert now(shown) > at + 0.02
    shown.get_by_label("Pause", exact=True).click()
    at = now(shown)
    shown.wait_for_timeout(100)
    assert now(shown) == at
    assert shown.evaluate("window.jousto.app.runs[0].track.end") == at, "what is seen is this"


def test_stress_follows_the_motion(shown: Any) -> None:
    measured = "window.jousto.app.source.extent(0, 'von-mises')"
    shown.evaluate("() => window.jousto.app.store.set({ measure: 'von-mises' })")
    before = shown.evaluate(measured)[1]
    for _ in range(8):
        shown.get_by_label("One step").click()
    after = shown.evaluate(measured)[1]
    assert before != after > 1e6
    # there is no server: nothing is pulled or recorded
    assert shown.get_by_text("Pull with the mouse").count() == 0
    assert shown.get_by_label("Record to a file").count() == 0


def test_a_parameter_changes_it_and_reset_keeps_it(shown: Any) -> None:
    found = shown.evaluate(
        """async () => { const { source } = window.jousto.app, ends = [];
        for (const g of [-9.81, 0]) {
            await source.order({ do: 'parameter', name: 'gravity.z', value: g });
            await source.order({ do: 'reset' });
            source.machine.advance(100);
            ends.push(Array.from(source.machine.positions()).slice(3, 7));
        } return ends; }"""
    )
    assert np.abs(np.subtract(*found)).max() > 1e-3


# -- what is refused ------------------------------------------------------------------------


def test_without_the_compiler_it_is_a_sentence(
    model: jo.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(toolchain, "find_spec", lambda name: None)
    toolchain.compiler.cache_clear()
    try:
        with pytest.raises(jo.InputError, match="ziglang, which is not installed; pip"):
            jo.write(model, tmp_path / "arm.html")
    finally:
        toolchain.compiler.cache_clear()
    assert not (tmp_path / "arm.html").exists()


def test_wrong_ranges_and_methods_are_sentences(model: jo.Model, tmp_path: Path) -> None:
    with pytest.raises(jo.InputError, match="no input 'pull'"):
        jo.write(model, tmp_path / "arm.html", ranges={"pull": (0.0, 1.0)})
    with pytest.raises(jo.InputError, match="DormandPrince chooses its steps itself"):
        jo.write(model, tmp_path / "arm.html", solver=jo.simulation.DormandPrince())


def test_other_files_have_no_ranges(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from jousto.cli.group import app

    model = Path(__file__).parents[2] / "examples" / "crane.yaml"
    words = ["export", str(model), "-o", str(tmp_path / "crane.c"), "--input", "a=0..1"]
    found = CliRunner().invoke(app, words)
    assert found.exit_code and "--input applies to .html files only" in found.output
