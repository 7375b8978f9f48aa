"""Tools of the page in a real browser: sections, paths, events, distances, pictures, themes."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import jousto as jo
from viewer.browser import chromium, opened, until
from viewer.machines import HIGH, LENGTH, answers, bar, number_of, swing
from viewer.test_page import at, jo_view

STORE = "change => window.jousto.app.store.set(change)"
STATE = "name => window.jousto.app.store.state[name]"
DRAWN = """() => { window.jousto.app.view.drawNow();
    return window.jousto.app.view.machines.map((m) =>
        [...m.symbols.batches.values()].reduce((n, b) => n + b.solid.count, 0)); }"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def shown(browser: Any) -> Iterator[Any]:
    with jo_view(falling()) as view, opened(browser, view.address) as page:
        yield page


@pytest.fixture(scope="module")
def two(browser: Any) -> Iterator[Any]:
    with jo_view(swing(), swing()) as view, opened(browser, view.address) as page:
        page.wait_for_selector("ol.worst li")
        yield page


@pytest.fixture(autouse=True)
def fresh(request: pytest.FixtureRequest) -> None:
    """Each test finds the page as it was opened."""
    for name in {"shown", "two"} & set(request.fixturenames):
        page = request.getfixturevalue(name)
        page.mouse.move(2, 300)
        page.evaluate(
            """() => { const app = window.jousto.app;
            app.store.set({selection: null, isolated: null, hover: null, looks: {}, traces: [],
                tool: 'select', offset: [0, 0, 0], theme: 'auto', measure: 'von-mises',
                clip: {on: false, normal: [0, 1, 0], offset: 0}});
            app.view.rig.turning = null; app.view.rig.azimuth = -Math.PI / 2 + 0.65;
            app.view.rig.elevation = 0.42; app.view.fit(); app.view.drawNow(); }"""
        )


def falling() -> jo.Solution:
    """The bar swings through an event."""
    arm = jo.FlexibleBody("bar", bar(), damping=0.02)
    hinge = jo.Revolute("hinge", jo.ground.at((0, 0.02, HIGH / 2)), arm["root"], axis=(0, 1, 0))
    angle = jo.CoordinateSensor("angle", hinge.angle)
    machine = jo.Mechanism(
        *(arm, hinge, angle, jo.Gravity((0, 0, -9.81))),
        jo.mechanism.Event("gate", angle, 0.2),
        name="falling",
    )
    return jo.simulate(jo.compile(machine), 0.4, output_step=2e-3)


def seen(page: Any, body: int, x: np.ndarray) -> list[float]:
    """Return where the vertex nearest to a point of a body is, in the page."""
    positions = np.array(
        page.evaluate(
            "b => Array.from(window.jousto.app.runs[0].scene.bodies[b].positions.data)", body
        )
    ).reshape(-1, 3)
    vertex = int(np.argmin(np.linalg.norm(positions - x, axis=1)))
    found = page.evaluate("([b, v]) => window.jousto.project(b, v)", [body, vertex])
    box = page.locator("canvas").first.bounding_box()
    return [found[0] + box["x"], found[1] + box["y"]]


def test_a_section_plane_cuts_what_lies_on_its_side(shown: Any) -> None:
    at(shown, 0.0)
    middle = "() => window.jousto.app.view.middle.toArray()"
    x0 = shown.evaluate(middle)[0]
    ends = [shown.evaluate("([b, v]) => window.jousto.project(b, v)", [0, v]) for v in sides(x0)]
    before = [shown.evaluate("([x, y]) => window.jousto.app.view.pick(x, y)", e[:2]) for e in ends]
    assert all(hit and hit["body"] == 0 for hit in before)
    shown.evaluate(STORE, {"clip": {"on": True, "normal": [1, 0, 0], "offset": 0}})
    after = [shown.evaluate("([x, y]) => window.jousto.app.view.pick(x, y)", e[:2]) for e in ends]
    assert after[0]["body"] == 0  # x below the plane stays
    assert after[1] is None or after[1]["body"] != 0
    # at once, without a picture between
    after = shown.evaluate(
        """([clip, ends]) => { window.jousto.app.store.set({clip});
            return ends.map(([x, y]) => window.jousto.app.view.pick(x, y)); }""",
        [{"on": True, "normal": [-1, 0, 0], "offset": 0}, ends],
    )
    assert after[0] is None or after[0]["body"] != 0
    assert after[1]["body"] == 0


def sides(x0: float) -> tuple[int, int]:
    """Return vertices of the upper face of the bar on both sides of a plane."""
    x = answers().scenes[0].bodies[number_of("bar")].positions
    return tuple(  # type: ignore[return-value]
        int(np.argmin(np.linalg.norm(x - [x0 + d, 0.02, HIGH], axis=1))) for d in (-0.2, 0.2)
    )


def test_a_path_goes_where_the_point_goes(shown: Any) -> None:
    vertex = sides(0.6)[1]
    shown.evaluate(STORE, {"traces": [{"run": 0, "body": 0, "vertex": vertex}]})
    points = """() => { const view = window.jousto.app.view;
        const path = [...view.traces.paths.values()][0];
        if (!path || !path.time.length) return null;
        const n = path.time.length, x = path.whole.geometry.getAttribute('position').array;
        return [path.time, Array.from(x.slice(0, 3 * n)), view.middle.toArray()]; }"""
    shown.wait_for_function(f"() => ({points})() !== null")
    times, x, middle = shown.evaluate(points)
    stored, exact = shown.evaluate(
        """async v => { const found = await window.jousto.app.source.history(
            0, 0, v, ['x', 'y', 'z'], 20000);
        return [Array.from(found.time.data), Array.from(found.values.data)]; }""",
        vertex,
    )
    exact = np.array(exact).reshape(3, -1).T
    along = np.stack([np.interp(times, stored, exact[:, k]) for k in range(3)], axis=1)
    # rows are floats of 32 bits
    assert np.abs(np.array(x).reshape(-1, 3) + middle - along).max() < 1e-5 * LENGTH
    assert np.ptp(along[:, 2]) > 0.1


def test_an_event_has_a_mark_that_leads_to_it(shown: Any) -> None:
    (event,) = shown.evaluate("() => window.jousto.app.runs[0].scene.events")
    assert event["name"] == "gate"
    at(shown, 0.0)
    shown.locator(".marks .event").click()
    shown.wait_for_function("t => window.jousto.app.store.state.time === t", arg=event["time"])


def test_the_time_line_zooms_into_a_window(shown: Any) -> None:
    ends = "() => [window.jousto.app.player.start, window.jousto.app.player.end]"
    at(shown, 0.2)
    shown.get_by_role("button", name="Zoom into time").click()
    shown.wait_for_function(f"() => ({ends})()[1] < 0.35")
    start, end = shown.evaluate(ends)
    assert start <= 0.2 <= end
    assert end - start == pytest.approx(0.1, abs=0.01)  # a quarter of it
    shown.get_by_label("Time line").get_by_role("button", name="Whole run").click()
    shown.wait_for_function(f"() => ({ends})()[1] > 0.39")


def test_a_probe_far_from_the_origin_has_all_its_digits(browser: Any) -> None:
    """At 100 km a float of 32 bits is 8 mm coarse; numbers do not come from one."""
    far = 1e5
    ball = jo.RigidBody.sphere("ball", 0.03, mass=0.3, position=(far, 0, 0))
    rail = jo.Prismatic("rail", jo.ground.at((far, 0, 0)), ball["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, 0.3)
    run = jo.simulate(jo.compile(jo.Mechanism(ball, rail, push, name="far")), 0.2, output_step=0.01)
    with jo_view(run) as view, opened(browser, view.address) as page:
        at(page, 0.2)
        found = page.evaluate("() => window.jousto.app.source.probe(0, 0, 0, 0.2)")
        x = run.coordinates("ball")[-1, 0] + page.evaluate(
            "() => window.jousto.app.runs[0].scene.bodies[0].positions.data[0]"
        )
        assert found["position"][0] == pytest.approx(x, abs=1e-7)
        # and the picture shows the ball: its middle is not the background
        box = page.locator("canvas").first.bounding_box()
        middle = page.evaluate("() => window.jousto.project(0, 0)")
        assert 0 < middle[0] < box["width"] and 0 < middle[1] < box["height"]


def saved(page: Any, options: str) -> np.ndarray:
    """Return a picture that the page would save, (h, w, 4)."""
    page.get_by_role("button", name="Picture", exact=True).click()
    clear = page.get_by_role("switch", name="Transparent background")
    clear.set_checked("transparent" in options)
    page.get_by_role("switch", name="Legend and title").first.set_checked("legend" in options)
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Save picture (PNG)").click()
    data = Path(waiting.value.path()).read_bytes()
    page.keyboard.press("Escape")
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGBA"))


def test_a_picture_has_the_legend_the_letters_and_a_clear_ground(shown: Any) -> None:
    at(shown, 0.2)
    whole, bare = saved(shown, "legend"), saved(shown, "")
    box = shown.locator("canvas").first.bounding_box()
    assert whole.shape[1] == pytest.approx(2 * box["width"], abs=2)  # 2 x
    assert (whole[..., 3] == 255).all()
    differ = np.abs(whole.astype(int) - bare).max(axis=2) > 30
    assert differ[40:600, :120].sum() > 2000  # the bar of colours
    clear = saved(shown, "transparent")
    assert clear[5, 5, 3] == 0
    assert clear[..., 3].max() == 255
    # the letters of the axes
    ends = shown.evaluate("() => window.jousto.app.view.axisEnds")
    for x, y in ends:
        row, column = clear.shape[0] - round(2 * y), round(2 * x)
        assert clear[row - 10 : row + 10, column - 10 : column + 10, 3].max() > 200


def test_without_a_recorder_a_video_is_refused_with_a_sentence(shown: Any) -> None:
    shown.evaluate(
        """() => { window.kept = [window.VideoEncoder, window.MediaRecorder];
        window.VideoEncoder = window.MediaRecorder = undefined; }"""
    )
    shown.get_by_role("button", name="Video", exact=True).click()
    shown.get_by_role("button", name="Save video (WebM)").click()
    shown.get_by_text("This browser cannot make WebM videos").wait_for()
    shown.get_by_role("button", name="Close message").click()
    shown.keyboard.press("Escape")
    shown.evaluate("() => { [window.VideoEncoder, window.MediaRecorder] = window.kept; }")


def test_every_press_of_d_changes_the_colours(shown: Any) -> None:
    theme = "() => document.documentElement.dataset.theme"
    shown.mouse.move(2, 300)
    found = [shown.evaluate(theme)]
    for _ in range(4):
        shown.keyboard.press("d")
        found.append(shown.evaluate(theme))
    assert found == ["light", "dark"] * 2 + ["light"]


def test_escape_ends_measuring(shown: Any) -> None:
    ruler = shown.get_by_role("button", name="Measure a distance")
    ruler.click()
    assert ruler.get_attribute("aria-pressed") == "true"
    shown.keyboard.press("Escape")
    assert ruler.get_attribute("aria-pressed") == "false"
    assert not shown.get_by_text("Click the first of two points.").is_visible()
    assert shown.evaluate("() => document.activeElement === document.body")


def test_a_body_shown_alone_takes_the_symbols_of_others_away(two: Any) -> None:
    both = two.evaluate(DRAWN)
    assert min(both) > 0
    two.evaluate(STORE, {"isolated": f"0:{number_of('ball')}"})
    alone = two.evaluate(DRAWN)
    assert 0 < alone[0] < both[0]  # the weld and the sensor stay, hinge and ground go
    assert alone[1] == 0
    two.evaluate(STORE, {"isolated": None})
    assert two.evaluate(DRAWN) == both


def test_runs_that_stand_apart_are_all_in_the_picture(two: Any) -> None:
    slider = two.get_by_label("Apart")
    slider.evaluate(
        "s => { s.value = s.max; s.dispatchEvent(new Event('input', {bubbles: true})); }"
    )
    two.evaluate("() => window.jousto.app.view.drawNow()")
    box = two.locator("canvas").first.bounding_box()
    for run in (0, 1):
        for vertex in (0, 100):
            x, y, _ = two.evaluate(
                "([r, v]) => window.jousto.app.view.project(r, 0, v)", [run, vertex]
            )
            assert 0 < x < box["width"] and 0 < y < box["height"]


def test_a_place_has_one_name(two: Any) -> None:
    listed = two.eval_on_selector_all("ol.worst li span", "all => all.map(x => x.textContent)")
    two.locator("ol.worst button").first.click()
    two.wait_for_selector(".plots .key")
    chosen = two.locator(".place-name").inner_text()
    curves = two.eval_on_selector_all(".plots .key .what", "all => all.map(x => x.textContent)")
    assert chosen == listed[0]
    assert all(text.endswith(f", {chosen}") for text in curves)


def test_symbols_of_the_other_run_have_their_tips(two: Any) -> None:
    """The first run is not shown: what is under the mouse belongs to the second."""
    two.evaluate(STORE, {"runs": [False, True]})
    find = """() => { const view = window.jousto.app.view; view.drawNow();
        const [w, h] = [view.canvas.clientWidth, view.canvas.clientHeight];
        for (let y = 4; y < h; y += 4) for (let x = 4; x < w; x += 4) {
            const hit = view.pick(x, y);
            if (hit && hit.symbol !== undefined) return [x, y, hit.run, hit.symbol];
        } return null; }"""
    box = two.locator("canvas").first.bounding_box()
    two.keyboard.press("m")
    place: list[Any] = []

    def told() -> bool:
        """Whether the tip names the symbol; the camera may still move, so that it is found anew."""
        place[:] = two.evaluate(find)
        assert place[2] == 1
        for away in (3, 0):
            two.mouse.move(box["x"] + place[0] + away, box["y"] + place[1])
        two.wait_for_timeout(300)
        tip = two.locator(".probe.tip:not([hidden])")
        name = answers().scenes[0].symbols[place[3]].name
        return tip.count() == 1 and name in tip.inner_text()

    until(two, told)
    two.mouse.click(box["x"] + place[0], box["y"] + place[1])
    two.keyboard.press("Escape")
    two.evaluate(STORE, {"runs": [True, True]})


def test_zero_has_no_sign(shown: Any) -> None:
    at(shown, 0.0)
    x, y = seen(shown, 0, np.array([0.5, 0.02, HIGH]))
    shown.mouse.move(x, y)
    shown.wait_for_function("() => document.querySelector('.probe dl')?.textContent.includes('x,')")
    assert not re.search(r"[-−]0\.0+\b", shown.locator(".probe").first.inner_text())


@pytest.mark.slow
def test_playing_needs_no_more_memory(shown: Any) -> None:
    """For a minute, or as many seconds as the variable JOUSTO_PLAY says."""
    share = 1000.0 * float(os.environ.get("JOUSTO_PLAY", "60")) / 6
    shown.evaluate(STORE, {"loop": True, "speed": 0.2})
    client = shown.context.new_cdp_session(shown)
    shown.evaluate("() => window.jousto.app.player.play()")
    heap = []
    for _ in range(6):
        shown.wait_for_timeout(share)
        client.send("HeapProfiler.collectGarbage")
        heap.append(shown.evaluate("() => performance.memory.usedJSHeapSize"))
    shown.evaluate("() => window.jousto.app.player.pause()")
    # after the first sixth; a leak of a row a picture would be more
    assert heap[-1] < 1.02 * heap[0] + 5e5, heap


COLOURS = """run => window.jousto.app.view.machines[run].bodies.map(body => {
    const drawn = (body.surface ?? body.lines).material.uniforms.colour.value;
    const part = x => Math.round(255 * x).toString(16).padStart(2, '0');
    return '#' + part(drawn.r) + part(drawn.g) + part(drawn.b); })"""
SWATCHES = "() => [...document.querySelectorAll('.swatch')].map(x => x.value)"


def test_the_tree_has_the_colours_in_which_bodies_are_drawn(shown: Any, two: Any) -> None:
    for page, runs in ((shown, 1), (two, 2)):
        page.evaluate(STORE, {"measure": None})
        page.evaluate("() => window.jousto.app.view.drawNow()")
        drawn = [colour for run in range(runs) for colour in page.evaluate(COLOURS, run)]
        assert page.evaluate(SWATCHES) == drawn
        assert len(set(drawn)) >= runs
    shown.evaluate(STORE, {"looks": {"0:0": {"colour": "#102030"}}})
    shown.evaluate("() => window.jousto.app.view.drawNow()")
    assert shown.evaluate(SWATCHES)[0] == shown.evaluate(COLOURS, 0)[0] == "#102030"
