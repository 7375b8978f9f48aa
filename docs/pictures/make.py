"""Make the pictures of the documentation from the examples, small enough to be committed.

    .venv/bin/python docs/pictures/make.py

Every example writes its pictures; those that the documentation shows are scaled down and reduced
to few colours.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageFilter, ImageOps, ImageSequence

from jousto.output.scenes.film import Palette

HERE = Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"
DITHER = Image.Dither.FLOYDSTEINBERG
THUMB = (220, 150)  # pixels
PANELS = {  # left, top, right and bottom of the panel that a thumbnail shows, shares of the picture
    "beam_benchmarks.png": (0.0, 0.0, 0.25, 1.0),
    "belt_friction.png": (0.0, 0.0, 0.5, 1.0),
    "bowl_feeder.png": (0.0, 0.0, 0.5, 1.0),
    "bucket_stop.png": (0.0, 0.0, 0.5, 1.0),
    "cantilever_stress.png": (0.0, 0.0, 0.49, 1.0),
    "carriage.png": (0.0, 0.0, 0.5, 1.0),
    "crane_life.png": (0.0, 0.0, 0.53, 1.0),
    "crane_twin.png": (0.0, 0.0, 0.34, 1.0),
    "door_latch.png": (0.0, 0.0, 0.5, 1.0),
    "gauges.png": (0.0, 0.08, 1.0, 0.5),
    "gripper.png": (0.0, 0.0, 0.5, 1.0),
    "hotspots_von_mises.png": (0.0, 0.06, 0.85, 0.6),
    "monitor.png": (0.0, 0.02, 1.0, 0.33),
    "offset_boom.png": (0.0, 0.0, 0.33, 1.0),
    "rail_frame.png": (0.05, 0.04, 0.98, 0.38),
    "rail_wheel.png": (0.0, 0.33, 1.0, 0.64),
    "rod_at_speed.png": (0.0, 0.0, 0.5, 1.0),
    "shape_functions.png": (0.0, 0.0, 0.33, 1.0),
    "slewing_limit.png": (0.0, 0.08, 0.48, 1.0),
    "slider_crank.png": (0.0, 0.0, 0.48, 1.0),
    "spin_up.png": (0.0, 0.0, 0.48, 1.0),
    "squeezer.png": (0.0, 0.0, 0.49, 1.0),
    "steel_strip.png": (0.0, 0.05, 0.5, 1.0),
    "trolley.png": (0.0, 0.04, 1.0, 0.48),
    "link_arm_still.png": (0.0, 0.08, 0.88, 1.0),
}
GREY = ("rail_frame.png",)  # machines without colour
BANNER = (1240, 330)  # pixels of the picture in front
FRONT = ("link_arm_still.png", "crane_still.png", "six_axis_arm_still.png", "robot_still.png")
WIDTHS = {  # pixels
    "pendulum.png": 1000,
    "pendulum_still.png": 700,
    "chain_still.png": 700,
    "chain_order.png": 800,
    "chain.png": 1000,
    "chain.gif": 420,
    "cantilever_stress.png": 1100,
    "fatigue_damage.png": 900,
    "fatigue_cycles.png": 900,
    "slider_crank.png": 1100,
    "slewing_limit.png": 1100,
    "offset_boom.png": 1200,
    "four_bar.png": 1200,
    "spin_up.png": 1100,
    "shape_functions.png": 1200,
    "rod_at_speed.png": 1100,
    "robot_arm_life.png": 800,
    "crane_life.png": 900,
    "crane_drive.png": 900,
    "study_lines.png": 900,
    "study_surface.png": 700,
    "beam_benchmarks.png": 1300,
    "steel_strip.png": 1100,
    "trolley.png": 800,
    "work_precision.png": 700,
    "orders.png": 1200,
    "solvers.png": 1200,
    "controllers.png": 1000,
    "solids.png": 1200,
    "statics.png": 1200,
    "beam_dynamics.png": 1000,
    "planar_element.png": 1000,
    "offset_element.png": 1000,
    "boom.png": 1000,
    "exact_element.png": 800,
    "seven_methods.png": 1000,
    "esl_process.png": 1000,
    "rbdo_process.png": 1000,
    "stress_process.png": 1000,
    "moving_frame_order.png": 1200,
    "four_bar_still.png": 500,
    "portal_frame.png": 800,
    "squeezer.png": 1100,
    "belt_friction.png": 1100,
    "bowl_feeder.png": 900,
    "bucket_stop.png": 900,
    "door_latch.png": 900,
    "gripper.png": 900,
    "crane.png": 1200,
    "crane_still.png": 700,
    "crane_twin.png": 1200,
    "robot.png": 1200,
    "robot_still.png": 700,
    "six_axis_arm.png": 1200,
    "six_axis_arm_still.png": 600,
    "robot_hose.png": 1200,
    "robot_hose_still.png": 700,
    "lcd_robot_still.png": 800,
    "rail_frame.png": 1100,
    "arch_path.png": 900,
    "importance.png": 900,
    "reliable_design.png": 900,
    "carriage.png": 1100,
    "rail_wheel.png": 800,
    "moving_load.png": 700,
    "monitor.png": 900,
    "split_still.png": 900,
    "split.png": 900,
    "link_arm.png": 1100,
    "link_arm.gif": 520,
    "link_arm_mesh.png": 800,
    "link_arm_mode.png": 800,
    "link_arm_still.png": 800,
    "hotspots_von_mises.png": 900,
}


SMOOTH = (
    "link_arm.gif",
    "link_arm_still.png",
    "link_arm_mesh.png",
    "link_arm_mode.png",
    "hotspots_von_mises.png",
)  # lit surfaces need more colours


def shrink(source: Path, target: Path, width: int) -> None:
    """Write a smaller copy of a picture or film."""
    smooth = target.name in SMOOTH
    with Image.open(source) as image:
        size = (width, round(width * image.height / image.width))
        small = [
            frame.convert("RGB").resize(size, Image.Resampling.LANCZOS)
            for frame in ImageSequence.Iterator(image)
        ]
        if smooth:
            how = Image.Quantize.MEDIANCUT
            frames = [frame.quantize(256, how, dither=DITHER) for frame in small]
        else:  # paper, ink and shadows keep their colours
            pixels = [np.asarray(frame) for frame in small]
            palette = Palette([pixels[i] for i in range(0, len(small), max(1, len(small) // 5))])
            frames = [palette.index(frame) for frame in pixels]
        if target.suffix == ".gif":
            # every second frame is enough
            settings = {"duration": 2 * image.info.get("duration", 40), "loop": 0}
            frames[0].save(target, save_all=True, append_images=frames[2::2], **settings)
        else:
            frames[0].save(target, optimize=True)


def shown(name: str) -> Image.Image:
    """Return the coloured part of a picture: curves without labels, bodies without the ground."""
    with Image.open(HERE / name) as picture:
        width, height = picture.size
        left, top, right, bottom = PANELS.get(name, (0.0, 0.0, 1.0, 1.0))
        area = (left * width, top * height, right * width, bottom * height)
        image = picture.convert("RGB").crop(tuple(map(round, area)))
    scene = name.endswith("_still.png")
    hsv = np.asarray(image.convert("HSV")).astype(int)
    # of 255: neither grey nor as dark as text; bodies of earlier instants are pale
    mask = (hsv[..., 1] > (30 if scene else 64)) & (hsv[..., 2] > 90)
    if name in GREY:
        mask = hsv[..., 2] < 200
    if scene:  # without the letters of its axes
        thick = Image.fromarray((255 * mask).astype("uint8")).filter(ImageFilter.MinFilter(3))
        mask = np.asarray(thick) > 0
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    size = max(np.ptp(rows), np.ptp(columns))
    edge = round(0.04 * size) if scene else 3
    above = edge if scene else 9  # half of a line of a legend
    return image.crop(
        (
            max(0, columns[0] - edge),
            max(0, rows[0] - above),
            min(image.width, columns[-1] + edge),
            min(image.height, rows[-1] + above),
        )
    )


def thumbs() -> None:
    """Make the small pictures in the tables of the gallery and of the first page."""
    folder = HERE / "thumbs"
    folder.mkdir(exist_ok=True)
    text = "".join((HERE.parent / page).read_text("utf-8") for page in ("gallery.md", "index.md"))
    for name in {*re.findall(r"thumbs/(\w+\.png)", text)}:
        small = ImageOps.pad(shown(name), THUMB, Image.Resampling.LANCZOS, color="white")
        small.quantize(64, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(
            folder / name, optimize=True
        )


def banner() -> None:
    """Make the picture of the first page: machines side by side that fill its frame."""
    width, height = BANNER
    bodies = [shown(name) for name in FRONT]
    # equal heights, as large as the frame allows
    share = sum(body.width / body.height for body in bodies)
    tall = min(height, int(width / share))
    gap = (width - tall * share) / (len(bodies) - 1)
    whole, at = Image.new("RGB", (width, tall), "white"), 0.0
    for body in bodies:
        size = (round(tall * body.width / body.height), tall)
        whole.paste(body.resize(size, Image.Resampling.LANCZOS), (round(at), 0))
        at += size[0] + gap
    whole.quantize(256, Image.Quantize.MEDIANCUT, dither=DITHER).save(
        HERE / "banner.png", optimize=True
    )


def main() -> int:
    """Run the examples and keep what is shown."""
    with tempfile.TemporaryDirectory() as folder:
        for script in sorted(EXAMPLES.glob("*.py")):
            more = ["--long"] if script.name == "offset_boom.py" else []
            subprocess.run([sys.executable, str(script), folder, *more], check=True)
        for name in (
            "orders.py",
            "solvers.py",
            "controllers.py",
            "solids.py",
            "statics.py",
            "beam_dynamics.py",
            "planar_element.py",
            "offset_element.py",
            "boom.py",
            "exact_element.py",
            "seven_methods.py",
            "process_charts.py",
            "moving_frame.py",
        ):
            subprocess.run([sys.executable, str(HERE / name), folder], check=True)
        # the film of the page in front, by the command line
        for words in (
            ["run", str(EXAMPLES / "link_arm.yaml"), "-o", "arm.h5"],
            ["animate", "arm.h5", "--stress", "--fps", "16", "-o", "link_arm.gif"],
        ):
            subprocess.run([sys.executable, "-m", "jousto", *words], cwd=folder, check=True)
        # the arch of the page on statics is its own first example
        block = re.search(
            r"```python\n(.*?)```", (HERE.parent / "statics.md").read_text("utf-8"), re.S
        )
        assert block is not None
        subprocess.run([sys.executable, "-c", block[1]], cwd=folder, check=True)
        (Path(folder) / "arch.png").rename(Path(folder) / "arch_path.png")
        # the pictures of the page on reliability are its own; its last block shows an error
        blocks = re.findall(
            r"```python\n(.*?)```", (HERE.parent / "reliability.md").read_text("utf-8"), re.S
        )
        subprocess.run([sys.executable, "-c", "\n".join(blocks[:-1])], cwd=folder, check=True)
        for name, width in WIDTHS.items():
            shrink(Path(folder) / name, HERE / name, width)
    thumbs()
    banner()
    sizes = {path.name: path.stat().st_size for path in HERE.iterdir() if path.name in WIDTHS}
    for name, size in sizes.items():
        print(f"{name:24}{size / 1000:8.0f} kB")
    print(f"{'together':24}{sum(sizes.values()) / 1000:8.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
