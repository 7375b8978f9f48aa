"""The page in a real browser: pixels, keys, fingers, a page from disk, memory."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from viewer.browser import chromium, opened, until
from viewer.machines import HIGH, answers, mechanism, number_of, swing
from viewer.test_oil import lifted
from viewer.test_touches import resting

PIXEL = 1.5
SMALL = {"width": 700, "height": 400}


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def shown(browser: Any) -> Iterator[Any]:
    with jo_view(swing()) as view, opened(browser, view.address) as page:
        yield page


class jo_view:
    """A view that is closed at the end."""

    def __init__(self, *things: Any, **how: Any) -> None:
        self.view = jo.view(*things, open=False, **how)

    def __enter__(self) -> Any:
        return self.view

    def __exit__(self, *_: object) -> None:
        self.view.close()


def at(page: Any, time: float) -> None:
    """Show an instant, and wait until it is drawn."""
    page.evaluate("t => window.jousto.setTime(t)", time)
    page.evaluate("() => window.jousto.app.player.ready()")
    page.wait_for_timeout(120)
    page.evaluate("() => { window.jousto.app.view.drawNow(); }")


def camera(page: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the view-projection matrix (4, 4) and the size of the picture in CSS pixels."""
    found = page.evaluate(
        """() => { const view = window.jousto.app.view, c = view.rig.camera;
        const e = (m) => Array.from(m.elements);
        const canvas = view.canvas;
        return [e(c.projectionMatrix), e(c.matrixWorldInverse),
                [canvas.clientWidth, canvas.clientHeight]]; }"""
    )
    P, V = (np.array(m).reshape(4, 4).T for m in found[:2])
    return P @ V, np.array(found[2])


def pixels(matrix: np.ndarray, size: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return where world points (k, 3) are in a picture, CSS pixels (k, 2) from the upper left."""
    clip = np.column_stack([x, np.ones(len(x))]) @ matrix.T
    ndc = clip[:, :2] / clip[:, 3:]
    return np.column_stack([(1 + ndc[:, 0]) / 2, (1 - ndc[:, 1]) / 2]) * size


def test_contact_forces_are_drawn_where_bodies_touch(browser: Any) -> None:
    """Red arrows as long as their forces at the corners of a crate; hovering shows the numbers."""
    run = resting()
    near = """() => { const view = window.jousto.app.view;
        const {shown, scale} = view.machines[0].touches;
        return shown.map(({at, force}) => {
            const p = view.at(at.clone().addScaledVector(force, 0.4 * scale).toArray());
            return [p[0], p[1], view.pick(p[0], p[1])?.touch ?? -1]; }); }"""
    with jo_view(run) as view, opened(browser, view.address, viewport=SMALL) as page:
        loaded = "() => window.jousto.app.view.machines[0].touches.pieces.size"
        at(page, float(run.time[-1]))
        until(page, lambda: bool(page.evaluate(loaded)))
        at(page, float(run.time[-1]))
        feet = page.evaluate("""() => { const view = window.jousto.app.view;
            return view.machines[0].touches.shown.map(({at}) => view.at(at.toArray())); }""")
        points = run.contacts.at(float(run.time[-1]))
        drawn = pixels(*camera(page), np.array([point.point for point in points]))
        apart = np.array(feet)[:, None, :2] - drawn
        assert np.linalg.norm(apart, axis=2).min(axis=1).max() < PIXEL
        # the arrow of a corner on the near side is in front of the crate
        x, y, _ = next(one for one in page.evaluate(near) if one[2] >= 0)
        red, green, _ = page.evaluate("([x, y]) => window.jousto.pixel(x, y)", [x, y])
        assert red > 1.3 * green
        box = page.locator("canvas").bounding_box()
        page.mouse.move(box["x"] + x, box["y"] + y)
        tip = page.locator(".tip")
        tip.wait_for()
        assert re.search(r"set: floor - crate, sticks.*normal force\s*14.7", tip.inner_text(), re.S)
        page.evaluate("""() => { const app = window.jousto.app;
            app.store.set({touches: false}); app.view.drawNow(); }""")
        assert {one[2] for one in page.evaluate(near)} == {-1}


def test_pressures_colour_the_chambers_of_a_cylinder(browser: Any) -> None:
    """The piston side has the colour of its pressure, and the legend is in bar."""
    run = lifted()
    time = float(run.time[10])
    with jo_view(run) as view, opened(browser, view.address, viewport=SMALL) as page:
        loaded = "() => window.jousto.app.view.machines[0].pressures.range[1]"
        until(page, lambda: bool(page.evaluate(loaded)))
        at(page, time)
        assert page.evaluate(loaded) == run["p"].max()
        # between the foot of the barrel and the piston
        x, y = pixels(*camera(page), np.array([[0.0, 0.0, 0.08]]))[0]
        shown = page.evaluate("([x, y]) => window.jousto.pixel(x, y)", [x, y])
        share = float(run["p"][10, 0] / run["p"].max())
        ramp = page.evaluate(
            "s => window.jousto.app.view.ramp('spectrum', 1001)[s]", int(1e3 * share)
        )
        other = page.evaluate("() => window.jousto.app.view.ramp('spectrum', 1001)[100]")
        hue = [np.array(c) / np.linalg.norm(c) for c in (shown, ramp, other)]  # without the light
        assert hue[0] @ hue[1] > 0.985 > hue[0] @ hue[2]
        legend = page.locator(".legend.oil").get_attribute("aria-label")
        assert legend == f"Pressure from 0 to {1e-5 * run['p'].max():.1f} bar"


def test_the_deformed_tip_is_where_the_solution_says(shown: Any) -> None:
    run, k = swing(), 180
    at(shown, float(run.time[k]))
    # the ball's sensor and the nodes of the bar as the run has them
    from jousto.recovery.shape import positions

    where = positions(run, "bar", run.time[k : k + 1])[0]
    body = answers().scenes[0].bodies[number_of("bar")]
    matrix, size = camera(shown)
    vertices = [0, 10, len(body.positions) - 1]
    nodes = [int(body.nodes[v]) - 1 for v in vertices]
    rigid = positions(run, "bar", run.time[k : k + 1], scale=0.0)[0]
    bent = pixels(matrix, size, rigid[nodes]) - pixels(matrix, size, where[nodes])
    assert np.abs(bent).max() > 4 * PIXEL  # the test sees a deformation that is left out
    exact = pixels(matrix, size, where[nodes])
    page = [
        shown.evaluate("([b, v]) => window.jousto.project(b, v)", [number_of("bar"), v])
        for v in vertices
    ]
    assert np.abs(np.array(page)[:, :2] - exact).max() < PIXEL


def test_what_is_drawn_is_where_it_is_projected(shown: Any) -> None:
    run = swing()
    for k in (0, 100, 240):
        at(shown, float(run.time[k]))
        inside = outside = 0
        box = shown.evaluate(
            """b => { const scene = window.jousto.app.runs[0].scene.bodies[b];
            const n = scene.positions.shape[0], out = [];
            for (let v = 0; v < n; v++) out.push(window.jousto.project(b, v));
            return out; }""",
            number_of("bar"),
        )
        x = np.array([p[:2] for p in box if p])
        middle = x.mean(axis=0)
        inside = shown.evaluate("([x, y]) => window.jousto.pixel(x, y)", middle.tolist())
        away = [middle[0], max(5.0, x[:, 1].min() - 60)]
        outside = shown.evaluate("([x, y]) => window.jousto.pixel(x, y)", away)
        assert np.abs(np.subtract(inside[:3], outside[:3])).max() > 30


def test_the_worst_place_has_the_colour_at_the_top_of_the_map(shown: Any) -> None:
    worst = answers().answer({"id": 1, "ask": "worst", "measure": "von-mises", "count": 1})
    spot = worst["worst"][0]
    at(shown, spot["time"])
    look_at_vertex(shown, spot["body"], spot["vertex"])
    shown.evaluate(
        "x => { const v = window.jousto.app.view; v.focus(x); v.rig.distance *= 0.1; }",
        spot["position"],
    )
    shown.evaluate(
        """() => window.jousto.app.store.set({measure: 'von-mises', rangeMode: 'run', flat: true,
        shadows: false, edges: false,
        symbols: {joint: false, force: false, sensor: false, ground: false}})"""
    )
    shown.wait_for_timeout(600)
    shown.evaluate("() => { window.jousto.app.view.drawNow(); }")
    x, y = shown.evaluate(
        "([b, v]) => window.jousto.project(b, v)", [spot["body"], spot["vertex"]]
    )[:2]
    top = shown.evaluate(
        """() => { const app = window.jousto.app;
        return app.view.ramp(app.store.state.map, 256).at(-1); }"""
    )
    near = [
        shown.evaluate("([x, y]) => window.jousto.pixel(x, y)", [x + i, y + j])[:3]
        for i in range(-3, 4)
        for j in range(-3, 4)
    ]
    assert np.abs(np.array(near) - top).max(axis=1).min() < 25


def look_at_vertex(page: Any, body: int, vertex: int) -> None:
    """Turn the camera so that it sees a vertex from outside, near."""
    for view in ("y", "-y", "z", "-z", "x", "-x", "iso"):
        page.evaluate("v => { const x = window.jousto.app.view; x.look(v); x.fit(); }", view)
        # the camera turns from picture to picture: on a busy machine there are few
        page.wait_for_function("() => !window.jousto.app.view.rig.turning")
        hits = page.evaluate(
            """([b, v]) => { const p = window.jousto.project(b, v), app = window.jousto.app;
            return [[0, 0], [3, 0], [-3, 0], [0, 3], [0, -3]].map(([i, j]) => {
                const h = app.view.pick(p[0] + i, p[1] + j);
                return h && h.body === b ? h.position : null; }); }""",
            [body, vertex],
        )
        seen = page.evaluate("([b, v]) => window.jousto.app.view.position(0, b, v)", [body, vertex])
        # a side that is seen at a right angle, not one that is nearly edge-on
        if all(hit and np.linalg.norm(np.subtract(hit, seen)) < 0.01 for hit in hits):
            return
    pytest.fail("the vertex is seen from no side")


def test_keys_play_step_and_show_help(shown: Any) -> None:
    state = "name => window.jousto.app.store.state[name]"
    at(shown, 0.0)
    shown.mouse.click(500, 350)
    shown.keyboard.press("Space")
    assert shown.evaluate(state, "playing") is True
    shown.wait_for_function("() => window.jousto.app.store.state.time > 0")
    shown.keyboard.press("Space")
    assert shown.evaluate(state, "playing") is False
    time = shown.evaluate(state, "time")
    assert time > 0.0
    shown.keyboard.press("ArrowRight")
    after = shown.evaluate(state, "time")
    assert time < after <= time + 2.1 * 2e-3
    shown.keyboard.press("?")
    assert shown.get_by_text(re.compile("keys", re.I)).first.is_visible()
    shown.keyboard.press("Escape")


def test_a_click_shows_the_numbers_of_the_run(shown: Any) -> None:
    at(shown, float(swing().time[100]))
    bar = number_of("bar")
    x = answers().scenes[0].bodies[bar].positions
    vertex = int(np.argmin(np.linalg.norm(x - [0.35, 0.02, HIGH], axis=1)))  # on a face
    look_at_vertex(shown, bar, vertex)
    x, y = shown.evaluate("([b, v]) => window.jousto.project(b, v)", [bar, vertex])[:2]
    box = shown.locator("canvas").first.bounding_box()
    shown.mouse.click(box["x"] + x, box["y"] + y)
    shown.wait_for_function("() => window.jousto.app.store.state.selection")
    chosen = shown.evaluate("() => window.jousto.app.store.state.selection")
    assert chosen["body"] == bar
    probe = answers().answer(
        {
            "id": 1,
            "ask": "probe",
            "body": bar,
            "vertex": chosen["vertex"],
            "time": swing().time[100],
        }
    )
    # the numbers are asked from the server
    stress = probe["von-mises"] / 1e6
    numbers = [f"{stress:.{digits}f}"[:5] for digits in (2, 3, 4)]
    until(shown, lambda: any(number in shown.inner_text("body") for number in numbers))


def test_dragging_turns_and_fingers_pinch(browser: Any, shown: Any) -> None:
    before, _ = camera(shown)
    box = shown.locator("canvas").first.bounding_box()
    x, y = box["x"] + 0.4 * box["width"], box["y"] + 0.8 * box["height"]
    shown.mouse.move(x, y)
    shown.mouse.down()
    shown.mouse.move(x + 80, y + 20, steps=6)
    shown.mouse.up()
    until(shown, lambda: np.abs(camera(shown)[0] - before).max() > 1e-3)
    with jo_view(swing()) as view:
        phone = {"viewport": {"width": 390, "height": 780}, "has_touch": True, "is_mobile": True}
        with opened(browser, view.address, **phone) as page:
            wide = page.evaluate("() => document.documentElement.scrollWidth")
            assert wide <= 390  # nothing is cut off
            matrix, _ = camera(page)
            client = page.context.new_cdp_session(page)

            def touch(kind: str, *points: tuple[float, float]) -> None:
                found = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(points)]
                client.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": found})

            touch("touchStart", (150, 250), (240, 250))
            for k in range(8):
                touch("touchMove", (150 - 8 * k, 250), (240 + 8 * k, 250))
            touch("touchEnd")
            until(page, lambda: np.abs(camera(page)[0] - matrix).max() > 1e-3)


def test_a_page_from_disk_needs_nothing_else(browser: Any, tmp_path: Path) -> None:
    with jo_view(swing()) as view:
        path = view.save(tmp_path / "swing.html", frames=50)
    text = path.read_text("utf-8")
    assert not re.search(r'(?:src|href)="(?!data:)', text[: text.index("<script>")])
    policy = html.unescape(re.search(r'content="(default-src[^"]*)"', text)[1])  # type: ignore[index]
    assert policy.startswith("default-src 'none'")
    assert "connect-src" not in policy and "unsafe" not in policy
    with opened(browser, path.as_uri(), offline=True) as page:
        frames = page.evaluate("() => window.jousto.app.runs[0].scene.frames.data.length")
        assert 2 <= frames <= 50
        at(page, float(swing().time[100]))
        answer = page.evaluate(
            "([b, v, t]) => window.jousto.app.source.probe(0, b, v, t)",
            [number_of("bar"), 40, float(swing().time[100])],
        )
        # 250 instants, one in six of them: the nearest one that is in the page
        stored = page.evaluate("() => Array.from(window.jousto.app.runs[0].scene.frames.data)")
        time = min(stored, key=lambda t: abs(t - swing().time[100]))
        exact = answers().answer(
            {"id": 1, "ask": "probe", "body": number_of("bar"), "vertex": 40, "time": time}
        )
        body = answers().scenes[0].bodies[number_of("bar")]
        p = swing().coordinates("bar")[int(np.argmin(np.abs(swing().time - time))), 7:]
        # modes are rounded to 2^-17 of their largest value, coordinates to 24 bits
        for name, kind in (("shapes", "position"), ("stress", "stress")):
            largest = np.abs(getattr(body, name)).reshape(len(p), -1).max(axis=1)
            error = np.abs(np.subtract(answer[kind], exact[kind])).max()
            assert error <= (2.0**-17 + 2.0**-23) * (largest @ np.abs(p)) + 1e-7


def test_two_runs_are_compared(browser: Any) -> None:
    with jo_view(swing(), swing()) as view, opened(browser, view.address) as page:
        titles = page.evaluate("() => window.jousto.app.runs.map(r => r.scene.title)")
        assert len(titles) == 2
        assert page.evaluate("() => window.jousto.app.runs[0].scene.runs") == ["swing 1", "swing 2"]
        # curves have the colours of their runs, and the difference of equal runs is zero
        page.get_by_role("button", name="ball", exact=True).last.click()
        page.get_by_role("button", name="Difference").click()
        keys = page.locator(".key")
        shown = keys.evaluate_all(
            """all => all.map(key => [key.querySelector(".what").textContent,
            key.querySelector("output").textContent,
            getComputedStyle(key.querySelector(".dot")).backgroundColor])"""
        )
        swatch = page.locator(".run .dot").evaluate_all(
            "all => all.map(dot => getComputedStyle(dot).backgroundColor)"
        )
        assert len(set(swatch)) == 2
        assert len(shown) == 9, shown
        for label, value, colour in shown:
            assert colour == swatch[label.startswith("swing 2")]
            if label.endswith("− swing 1"):
                assert float(value) == 0
        assert not page.get_by_text("another machine").count()


def test_a_name_is_no_html(browser: Any) -> None:
    name = '<img src=x onerror="window.hit = 1">'
    with pytest.warns(jo.JoustoWarning):
        machine = jo.Mechanism(jo.RigidBody("a", 1.0, (1, 1, 1)), name=name)
        run = jo.simulate(jo.compile(machine), 0.01)
    with jo_view(run) as view, opened(browser, view.address) as page:
        assert page.evaluate("() => window.hit") is None
        assert name in page.inner_text("body")


def test_playing_does_not_fill_the_memory(shown: Any) -> None:
    """A short form; benchmarks/viewer.py plays for 10 minutes."""
    shown.evaluate("() => window.jousto.app.store.set({loop: true, speed: 1})")
    shown.evaluate("() => window.jousto.app.player.play()")
    heap = []
    client = shown.context.new_cdp_session(shown)
    for _ in range(4):
        shown.wait_for_timeout(1500)
        client.send("HeapProfiler.collectGarbage")
        heap.append(shown.evaluate("() => performance.memory.usedJSHeapSize"))
    shown.evaluate("() => window.jousto.app.player.pause()")
    assert heap[-1] < 1.05 * heap[0] + 1e6, json.dumps(heap)


def test_worst_places_of_compared_runs_are_those_of_all(browser: Any) -> None:
    """The first run ends before its stress is high: all worst places are the other's."""
    early = jo.simulate(jo.compile(mechanism()), 0.02, output_step=2e-3)
    with jo_view(early, swing()) as view, opened(browser, view.address) as page:
        page.wait_for_selector("ol.worst li")
        listed = page.eval_on_selector_all("ol.worst small", "all => all.map(x => x.textContent)")
    assert len(listed) == 6 and all(text.endswith(" in swing 2") for text in listed), listed


def test_a_page_shows_the_run_that_takes_the_place_of_its_file(
    browser: Any, tmp_path: Path
) -> None:
    path = tmp_path / "run.h5"
    swing().save(path)
    with jo_view(path) as view, opened(browser, view.address) as page:
        frames = "() => window.jousto.app.runs[0].scene.frames.data.length"
        assert page.evaluate(frames) == swing().nt
        jo.simulate(jo.compile(mechanism()), 0.02, output_step=2e-3, path=path)
        page.get_by_text(re.compile(r"run.h5: was written anew: the page shows what")).wait_for()
        assert page.evaluate(frames) == 11


def test_sliders_of_a_machine_that_stands_still_turn_its_joints(browser: Any) -> None:
    """A hinge at x = 0.3 turns 90 degrees about -y: the end at (1, 0, 0) gets to (0.3, 0, 0.7)."""
    arm = jo.RigidBody.box("arm", (0.7, 0.05, 0.05), mass=1.0, position=(0.65, 0, 0))
    pin = jo.ground.at((0.3, 0, 0))
    hinge = jo.Revolute("hinge", pin, arm.at((-0.35, 0, 0)), axis=(0, -1, 0))
    still = jo.Mechanism(arm, hinge, name="still")
    with jo_view(still) as view, opened(browser, view.address) as p:
        slider = p.get_by_label("hinge", exact=True)
        slider.fill("90")
        found = p.evaluate(
            """() => { const app = window.jousto.app, k = 0;
            app.view.drawNow();
            const x = app.runs[0].scene.bodies[k].positions.data, n = x.length / 3;
            return [...Array(n).keys()].map((v) => app.view.position(0, k, v)); }"""
        )
        # corners of the box, 32-bit numbers near 1 m
        assert np.max(found, axis=0) == pytest.approx([0.325, 0.025, 0.7], abs=1e-6)
        assert np.min(found, axis=0) == pytest.approx([0.275, -0.025, 0.0], abs=1e-6)
        p.get_by_text("Back to the pose of the model").click()
        assert slider.input_value() == "0"
