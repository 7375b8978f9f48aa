"""Films from pictures: GIF, MP4, and a self-contained web page with a player."""

from __future__ import annotations

import base64
import importlib
import io
import json
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from jousto.base.errors import InputError, Problem
from jousto.base.files import written
from jousto.base.pipes import broken_pipes_raise

Pixels = NDArray[np.uint8]

FILMS = ("gif", "mp4", "html")
MOST_FRAMES = {"gif": 400, "html": 400, "mp4": 4000}
COLORS = 128  # colours of a GIF


def frame_rate(suffix: str, fps: float) -> float:
    """Return the nearest frame rate that a format allows: GIF delays are multiples of 0.01 s."""
    return 100.0 / max(2, round(100.0 / fps)) if suffix == "gif" else fps


def write_film(path: Path, frames: Iterable[Pixels], count: int, fps: float) -> None:
    """Write frames (h, w, 3) to a film; the suffix chooses the format.

    Raises
    ------
    InputError
        If the file cannot be written, or ffmpeg is missing for an MP4.
    """
    suffix = path.suffix.lower()
    with written(path) as beside:
        if suffix == ".gif":
            _write_gif(beside, list(frames), fps)
        elif suffix == ".mp4":
            _write_mp4(path, beside, iter(frames), fps)
        else:
            page = _page(path.stem, frames, count, fps)
            beside.write_text(page, encoding="utf-8")


def _write_gif(path: Path, frames: list[Pixels], fps: float) -> None:
    # one palette from a few frames, which keeps constant areas constant and the file small
    palette = Palette([frames[i] for i in np.linspace(0, len(frames) - 1, 5).astype(int)])
    images = [palette.index(frame) for frame in frames]
    images[0].save(
        path,
        format="GIF",
        save_all=True,
        append_images=images[1:],
        duration=round(1000.0 / fps),
        loop=0,
        optimize=False,
    )


class Palette:
    """Palette of a film: frequent colours exactly, others by the nearest of them.

    Parameters
    ----------
    frames : list of (h, w, 3) arrays
        Some frames of the film.
    count : int
        Colours, 256 at most.
    """

    def __init__(self, frames: list[Pixels], count: int = COLORS) -> None:
        packed = np.concatenate(frames).reshape(-1, 3).astype(np.intp) @ np.array([65536, 256, 1])
        codes, counts = np.unique(packed, return_counts=True)
        codes = codes[np.argsort(-counts, kind="stable")]
        colors = np.stack([codes >> 16, (codes >> 8) & 255, codes & 255], axis=1).astype(np.uint8)
        # most frequent colour of each cell; of these first the most frequent ones, then those most
        # distant from the chosen colours, so that thin lines keep their colour
        _, first = np.unique(self._cell(colors), return_index=True)
        colors = colors[np.sort(first)]
        chosen, wanted = list(range(min(len(colors), count // 2))), colors.astype(np.float64)
        away = np.min([((wanted - wanted[k]) ** 2).sum(axis=1) for k in chosen], axis=0)
        while len(chosen) < min(count, len(colors)):
            chosen.append(int(away.argmax()))
            away = np.minimum(away, ((wanted - wanted[chosen[-1]]) ** 2).sum(axis=1))
        self.colors = colors[chosen]
        grid = np.arange(32, dtype=np.float64) * 8.0 + 3.5
        centres = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1).reshape(-1, 3)
        kept = self.colors.astype(np.float64)
        distance = (kept**2).sum(axis=1) - 2.0 * centres @ kept.T
        self._nearest = distance.argmin(axis=1).astype(np.uint8)
        self._nearest[self._cell(self.colors)] = np.arange(len(self.colors))

    @staticmethod
    def _cell(pixels: Pixels) -> NDArray[np.intp]:
        """Return the index of each pixel's cell in a 32 x 32 x 32 grid of colours."""
        r, g, b = np.moveaxis(pixels.astype(np.intp) >> 3, -1, 0)
        return np.asarray((r << 10) | (g << 5) | b)

    def index(self, frame: Pixels) -> Image.Image:
        """Return the palette indices of a frame."""
        image = Image.fromarray(self._nearest[self._cell(frame)])
        image.putpalette(self.colors.tobytes())
        return image


def find_ffmpeg(path: Path) -> str:
    """Return the path of the ffmpeg program.

    Raises
    ------
    InputError
        If ffmpeg is missing.
    """
    found = shutil.which("ffmpeg")
    if found is None:
        try:  # a Python package with an ffmpeg binary
            found = str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
        except (ImportError, RuntimeError):
            raise InputError(
                Problem(
                    str(path),
                    "an MP4 needs the program ffmpeg, which is not installed; write a .gif or "
                    ".html instead, or pip install imageio-ffmpeg",
                )
            ) from None
    return found


def _write_mp4(path: Path, beside: Path, frames: Iterator[Pixels], fps: float) -> None:
    first = next(frames)
    height, width = (2 * (n // 2) for n in first.shape[:2])  # the codec requires even sizes
    command = [find_ffmpeg(path), "-y", "-loglevel", "error", "-f", "rawvideo"]
    command += ["-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-"]
    command += ["-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", str(beside)]
    with (
        broken_pipes_raise(),
        subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process,
    ):
        assert process.stdin is not None and process.stderr is not None
        try:
            process.stdin.write(first[:height, :width].tobytes())
            for frame in frames:
                process.stdin.write(frame[:height, :width].tobytes())
            process.stdin.close()
        except BrokenPipeError:
            pass  # the exit code and stderr of ffmpeg are checked below
        message = process.stderr.read().decode(errors="replace").strip()
        if process.wait() != 0:
            raise InputError(Problem(str(path), f"ffmpeg failed: {message}"))


def _page(title: str, frames: Iterable[Pixels], count: int, fps: float) -> str:
    pictures: list[str] = []
    shape = (0, 0)
    for frame in frames:
        data = io.BytesIO()
        Image.fromarray(frame).save(data, format="WEBP", quality=85, method=2)
        pictures.append(base64.b64encode(data.getvalue()).decode())
        shape = frame.shape[:2]
    page = PAGE.replace("TITLE", title.replace("<", "&lt;")).replace("COUNT", str(count - 1))
    page = page.replace("WIDTH", str(shape[1])).replace("FPS", f"{fps:g}")
    return page.replace("FRAMES", json.dumps(pictures))


PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>TITLE</title>
<style>
  body { margin: 2rem auto; max-width: WIDTHpx; padding: 0 1rem; background: #fff; color: #22272e;
         font: 15px system-ui, sans-serif; }
  img { width: 100%; display: block; }
  div { display: flex; gap: .8rem; align-items: center; margin-top: .6rem; }
  input { flex: 1; accent-color: #1c5fa8; }
  button, select { font: inherit; padding: .25rem .7rem; border: 1px solid #c9ced6;
                   border-radius: 6px; background: #fff; color: inherit; }
  button { min-width: 5.2rem; }
</style>
<img id="picture" alt="TITLE">
<div>
  <button id="play">pause</button>
  <input id="at" type="range" min="0" max="COUNT" value="0" aria-label="frame">
  <select id="speed" aria-label="speed">
    <option value="0.25">¼ ×</option><option value="0.5">½ ×</option>
    <option value="1" selected>1 ×</option><option value="2">2 ×</option>
  </select>
</div>
<script>
  const frames = FRAMES;
  const find = id => document.getElementById(id);
  const picture = find("picture"), at = find("at"), play = find("play"), speed = find("speed");
  let playing = true, place = 0, before = null;
  const show = () => {
    const k = Math.floor(place);
    picture.src = "data:image/webp;base64," + frames[k];
    at.value = k;
  };
  const toggle = () => { playing = !playing; play.textContent = playing ? "pause" : "play"; };
  play.onclick = toggle;
  at.oninput = () => { place = Number(at.value); if (playing) toggle(); show(); };
  document.onkeydown = event => {
    if (event.target === speed) return;
    if (event.key === " ") { event.preventDefault(); toggle(); }
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (step && event.target !== at) {
      if (playing) toggle();
      place = (Math.floor(place) + step + frames.length) % frames.length;
      show();
    }
  };
  const tick = now => {
    if (before !== null && playing) {
      place = (place + (now - before) / 1000 * FPS * Number(speed.value)) % frames.length;
      show();
    }
    before = now;
    requestAnimationFrame(tick);
  };
  show();
  requestAnimationFrame(tick);
</script>
</html>
"""
