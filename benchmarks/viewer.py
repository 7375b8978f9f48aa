"""What the viewer costs: bytes, seconds, frames a second, memory. Needs Chromium and playwright.

python benchmarks/viewer.py                     the numbers of docs/benchmarks-realtime.md
python benchmarks/viewer.py --minutes 10        and the memory over ten minutes of playing
python benchmarks/viewer.py --gigabytes 5       and how long a result of 5 GB takes to open
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import jousto as jo
from jousto.scene.scene import Body, Motion, Scene
from jousto.simulation.results.writer import ResultsWriter
from jousto.viewer.container import pack
from jousto.viewer.queries import Answers
from jousto.viewer.server import Server

# instead of this folder, whose name for itself is that of a folder of the tests
sys.path[0] = str(Path(__file__).parent.parent / "tests")
MODES = 20
SECONDS = 8.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=0.0)
    parser.add_argument("--gigabytes", type=float, default=0.0)
    asked = parser.parse_args()
    from viewer.browser import chromium

    with chromium() as browser:
        for triangles in (50_000, 500_000):
            print(frames_a_second(browser, triangles))
        if asked.minutes:
            print(memory(browser, asked.minutes))
        if asked.gigabytes:
            print(large(browser, asked.gigabytes))


def wave(triangles: int, instants: int = 2000) -> Scene:
    """Return a plate with modes and modal stress that are waves, and its motion."""
    n = int(np.sqrt(triangles / 2)) + 1
    x, y = np.meshgrid(np.linspace(0, 2, n), np.linspace(0, 1, n), indexing="ij")
    positions = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    k = np.arange(1, MODES + 1)
    shapes = np.zeros((MODES, n * n, 3))
    shapes[..., 2] = np.sin(k[:, None] * positions[:, 0])
    stress = np.repeat(1e8 * shapes[..., 2:], 6, axis=2)
    t = np.linspace(0.0, 10.0, instants)
    rows = np.zeros((instants, 7 + MODES))
    rows[:, 3] = 1.0
    rows[:, 7:] = 0.05 / k * np.sin(np.outer(t, 2 + k))
    body = Body("plate", "solid", 0, MODES, positions, faces, shapes=shapes, stress=stress)
    return Scene(
        what="run",
        name="wave",
        title="wave",
        still=rows[0],
        bodies=(body,),
        box=np.array([[0.0, 0.0, -0.2], [2.0, 1.0, 0.2]]),
        motion=Motion(t, lambda which: rows[which]),
        measures=("von-mises", "displacement"),
        limits={"von-mises": (0.0, 2e7)},
    )


def frames_a_second(browser: Any, triangles: int) -> str:
    """Play a plate and count."""
    from viewer.browser import opened

    answers = Answers([wave(triangles)])
    sent = len(pack(answers.answer({"id": 1, "ask": "scene"})))
    rows = pack(answers.answer({"id": 1, "ask": "rows", "first": 0, "count": 1000, "every": 1}))
    server = Server(answers)
    start = time.perf_counter()
    with opened(browser, server.address) as page:
        first = time.perf_counter() - start
        page.evaluate("() => { window.jousto.app.player.play(); }")
        page.wait_for_timeout(2000)
        before = page.evaluate("() => ({...window.jousto.counters})")
        page.wait_for_timeout(1000 * SECONDS)
        after = page.evaluate("() => ({...window.jousto.counters})")
    server.close()
    drawn = after["frames"] - before["frames"]
    return (
        f"{triangles} triangles, {MODES} modes: scene {sent / 1e6:.1f} MB, {len(rows) / 1000:.0f} "
        f"bytes a frame, first picture {first:.1f} s, {drawn / SECONDS:.1f} frames a second, "
        f"{after['drawMs']:.2f} ms of the page's thread a frame"
    )


def memory(browser: Any, minutes: float) -> str:
    """Play for some minutes; the memory after each tenth of them."""
    from viewer.browser import opened

    server, found = Server(Answers([wave(50_000)])), []
    with opened(browser, server.address) as page:
        client = page.context.new_cdp_session(page)
        page.evaluate("() => { window.jousto.app.player.play(); }")
        for _ in range(11):
            client.send("HeapProfiler.collectGarbage")
            found.append(page.evaluate("() => performance.memory.usedJSHeapSize") / 1e6)
            page.wait_for_timeout(6000 * minutes)
    server.close()
    shown = " ".join(f"{x:.2f}" for x in found)
    return f"memory of the page in {minutes:g} minutes, MB after each tenth: {shown}"


def large(browser: Any, gigabytes: float) -> str:
    """Open a result of some GB: a short run, repeated by the writer of results."""
    from viewer.browser import opened
    from viewer.machines import mechanism

    model = jo.compile(mechanism())
    short = jo.simulate(model, 0.5, output_step=2e-3)
    block = short._records.rows  # type: ignore[attr-defined]
    copies = int(gigabytes * 1e9 / block.nbytes) + 1
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.h5"
        about = {"name": "large", **short._records.about_run}  # type: ignore[attr-defined]
        writer = ResultsWriter(path, model, copies * len(block), about, "")
        for k in range(copies):
            rows = block.copy()
            rows[:, 0] += 0.502 * k
            writer.append(rows)
        writer.close(True, {"ended": "reached its end", "wall_time": 1.0})
        start = time.perf_counter()
        view = jo.view(path, open=False)
        opened_after = time.perf_counter() - start
        with opened(browser, view.address):
            first = time.perf_counter() - start
        view.close()
        size = path.stat().st_size / 1e9
    return (
        f"{size:.2f} GB, {copies * len(block)} instants: open {opened_after:.2f} s, first picture "
        f"{first:.2f} s"
    )


if __name__ == "__main__":
    main()
