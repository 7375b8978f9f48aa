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
from PIL import Image, ImageOps, ImageSequence

from jousto.output.scenes.film import Palette

HERE = Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"
DITHER = Image.Dither.FLOYDSTEINBERG
THUMB = (220, 150)  # pixels
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
    "moving_frame_order.png": 1200,
    "four_bar_still.png": 500,
    "portal_frame.png": 800,
    "squeezer.png": 1100,
    "belt_friction.png": 1100,
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


def thumbs() -> None:
    """Make the small pictures in the table of the gallery, from those that are shown below it."""
    folder = HERE / "thumbs"
    folder.mkdir(exist_ok=True)
    for name in re.findall(r"thumbs/(\w+\.png)", (HERE.parent / "gallery.md").read_text("utf-8")):
        with Image.open(HERE / name) as image:
            # of several plots side by side the first
            width = min(image.width, round(1.7 * image.height))
            first = image.convert("RGB").crop((0, 0, width, image.height))
            small = ImageOps.pad(first, THUMB, Image.Resampling.LANCZOS, color="white")
            small.quantize(64, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(
                folder / name, optimize=True
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
    sizes = {path.name: path.stat().st_size for path in HERE.iterdir() if path.name in WIDTHS}
    for name, size in sizes.items():
        print(f"{name:24}{size / 1000:8.0f} kB")
    print(f"{'together':24}{sum(sizes.values()) / 1000:8.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
