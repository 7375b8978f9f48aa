"""The page of a running machine in a real browser: it is pulled, steered, recorded and changed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.live.drag_spring import point_position
from jousto.simulation.live.recorder import repeat
from viewer.browser import chromium, opened, until
from viewer.live.test_live import MODEL


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "swing.yaml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def live(model: Path) -> Iterator[Any]:
    made = jo.live(model, open=False)
    yield made
    made.close()


@pytest.fixture
def page(browser: Any, live: Any) -> Iterator[Any]:
    with opened(browser, live.address) as found:
        found.wait_for_function("() => window.jousto.app.store.state.time > 0")
        yield found


def vertex_in_sight(page: Any) -> tuple[int, int, np.ndarray]:
    """Return a body, a vertex that the mouse finds, and where it is in the page."""
    found = page.evaluate(
        """() => { const app = window.jousto.app, canvas = app.view.canvas;
        const box = canvas.getBoundingClientRect();
        const bodies = app.runs[0].scene.bodies, b = bodies.findIndex((x) => x.name === 'bob');
        const n = bodies[b].positions.shape[0];
        for (let v = 0; v < n; v++) {
            const p = app.view.project(0, b, v), hit = p && app.view.pick(p[0], p[1]);
            if (hit && hit.body === b) return [b, hit.vertex, p[0] + box.left, p[1] + box.top];
        }
        return null; }"""
    )
    assert found is not None, "no vertex is in sight"
    return int(found[0]), int(found[1]), np.array(found[2:])


def test_the_mouse_pulls_a_body_and_the_record_repeats_it(
    page: Any, live: Any, model: Path
) -> None:
    page.get_by_role("button", name="Record to a file").click()
    page.get_by_role("button", name="End the record").wait_for()
    page.get_by_text("Recording to swing-live.h5").wait_for()
    page.get_by_text("Pull with the mouse").click()
    line = page.locator(".pull-line")
    assert not line.is_visible()
    body, vertex, at = vertex_in_sight(page)
    still = live.now.q.copy()
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0] + 60, at[1] - 30, steps=5)
    line.wait_for()
    end = {name: float(line.locator("line").get_attribute(name)) for name in ("x2", "y2")}
    box = page.locator("canvas").first.bounding_box()
    # the cursor is the end of the line
    seen = np.array([end["x2"] + box["x"], end["y2"] + box["y"]])
    assert np.abs(seen - (at + [60, -30])).max() < 2.0
    start = [float(line.locator("line").get_attribute(name)) for name in ("x1", "y1")]
    assert np.hypot(*(np.array(start) + [box["x"], box["y"]] - seen)) > 5.0
    page.wait_for_function("t => window.jousto.app.store.state.time > t", arg=live.time + 1.0)
    page.mouse.up()
    page.wait_for_function("t => window.jousto.app.store.state.time > t", arg=live.time + 0.2)
    assert not line.is_visible()
    page.get_by_role("button", name="End the record").click()
    page.get_by_text(re.compile("s are recorded in swing-live.h5")).wait_for()
    run = jo.load("swing-live.h5")
    # the pull was recorded: body, point, target; and the body has moved
    held = run.inputs["hand body"] >= 0
    assert held.any() and not held[-1]
    points = live._desk.scene.bodies[body].positions
    assert np.isclose(
        [run.inputs[f"hand point {x}"][held][0] for x in "xyz"], points[vertex], atol=1e-9
    ).all()
    compiled = live.runner.machine.model
    path = np.array([point_position(compiled, q, 0, points[vertex]) for q in [still, *run.q[held]]])
    assert np.linalg.norm(path - path[0], axis=1).max() > 0.01
    again = repeat(run, jo.compile(jo.read_model(model).mechanism), jo.RK4(1e-3))
    assert run.q.tobytes() == again.q.tobytes()


def test_sensors_show_their_values_and_curves(page: Any, live: Any) -> None:
    page.get_by_role("button", name="Pause").click()
    page.wait_for_function("() => document.querySelectorAll('.reading output').length === 3")
    shown = page.locator(".reading", has_text="place z").locator("output")
    until(page, lambda: shown.inner_text().replace("−", "-") == f"{live.now.q[2]:.3f} m")
    page.locator(".reading button").first.click()
    page.get_by_role("button", name="Run").click()
    page.wait_for_function("() => document.querySelectorAll('.plots .chart canvas').length === 1")
    page.wait_for_function("() => window.jousto.app.store.state.time > %g" % (live.time + 0.3))
    assert page.locator(".plots .key").count() == 3


def test_a_rejected_parameter_takes_the_old_number_back(page: Any, live: Any) -> None:
    field = page.get_by_label("load")
    field.fill("9")
    field.press("Enter")
    page.get_by_text("load must be a number from 1 to 5; it stays 2.").wait_for()
    assert field.input_value() == "2"
    page.evaluate("() => document.querySelector('input[aria-label=load]').removeAttribute('min')")
    field.fill("-3")
    field.press("Enter")
    page.get_by_text(re.compile(r"mass is -3 kg.* load stays 2 kg\.", re.S)).wait_for()
    assert field.input_value() == "2"
    field.fill("4")
    field.press("Enter")
    page.wait_for_function("() => window.jousto.app.runs[0].scene.parameters[0].value === 4")
    assert live.runner.machine.model.bodies[0].mass[0] == 4.0
    assert field.input_value() == "4"


GAMEPAD = """() => { window.pad = {id: 'Mock pad', axes: [0, 0, 0, 0], buttons: [], index: 0};
    navigator.getGamepads = () => [window.pad, null, null, null];
    const event = new Event('gamepadconnected'); event.gamepad = window.pad;
    window.dispatchEvent(event); }"""


def test_a_gamepad_moves_the_first_input(page: Any, live: Any) -> None:
    page.evaluate(GAMEPAD)
    page.get_by_text("Gamepad: Mock pad").wait_for()
    page.evaluate("() => { window.pad.axes[0] = 1; }")
    (high,) = [x.high for x in live._desk._inputs]
    value = "() => Number(document.querySelector('input[aria-label=torque]').value)"
    page.wait_for_function(f"{value} > {0.99 * high}")
    until(page, lambda: live.now.inputs["torque"] == pytest.approx(high))
    page.evaluate("() => { window.pad.axes[0] = 0; }")
    page.wait_for_function(f"{value} === 0")
    until(page, lambda: live.now.inputs["torque"] == 0.0)
