"""Take pictures of the viewer's page, light and dark, with a headless Chromium.

.venv/bin/python docs/pictures/viewer.py FOLDER
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent.parent
sys.path[0:1] = [str(ROOT / "tests"), str(ROOT / "examples")]
warnings.simplefilter("ignore")

import link_arm
import numpy as np
from PIL import Image

import jousto as jo
from jousto.output.scenes.film import Palette
from viewer.browser import chromium, opened

SIZE = {"width": 1280, "height": 800}


def main() -> None:
    folder = Path(sys.argv[1])
    _, arm = link_arm.reduced_arm()
    middle = arm.stress.nearest((0.5 * link_arm.LENGTH, 0.5 * link_arm.DEPTH, 0.0))
    lift = link_arm.lift(arm, middle)
    with chromium() as browser:
        for theme in ("light", "dark"):
            take(browser, lift, folder / f"viewer_{theme}.png", theme)


def take(browser: Any, thing: Any, path: Path, theme: str) -> None:
    """Save a picture of the page at the instant of the worst stress, with its history."""
    worst = jo.hot_spots(thing, count=1)[0]
    view = jo.view(thing, open=False)
    with opened(browser, view.address, viewport=SIZE, color_scheme=theme) as page:
        page.evaluate("theme => window.jousto.app.store.set({theme})", theme)
        page.evaluate("time => window.jousto.setTime(time)", worst.time)
        page.wait_for_timeout(1500)
        page.evaluate(
            """async () => { const app = window.jousto.app;
            const [spot] = await app.source.worst(0, 'von-mises', 1);
            app.store.set({selection: {run: 0, body: spot.body, vertex: spot.vertex}}); }"""
        )
        page.wait_for_timeout(2500)
        page.screenshot(path=str(path))
    view.close()
    shrink(path)


def shrink(path: Path) -> None:
    """Leave 256 colours, those of paper, ink and the ends of scales exactly."""
    with Image.open(path) as image:
        picture = image.convert("RGB")
    pixels = np.asarray(picture)
    palette = Palette([pixels], 256).index(pixels[:1, :1])
    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


if __name__ == "__main__":
    main()
