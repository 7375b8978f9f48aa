"""Machines that move in the pages: a line ``<!-- moves crane -->`` becomes a control.

The machine runs when the documentation is built, and a page of the viewer that stands alone is
kept in ``build/moving`` until the example or jousto changes. The control loads that page when it is
clicked, never before. Where the viewer was not built the control is left out.
"""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import re
import shutil
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

from sphinx.util.logging import getLogger

import jousto as jo
from jousto.base.errors import InputError
from jousto.viewer import bundle

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES, KEPT, STATIC = (
    ROOT / "examples",
    ROOT / "build" / "moving",
    Path(__file__).parent / "static",
)
MARK = re.compile(r"^<!-- moves (\w+) -->$", re.M)
INSTANTS = 300  # of a run
TIME = 60.0  # s for the runs of one build; machines that are left over move in the next
LARGEST = 3_000_000  # bytes of a page

log = getLogger(__name__)


def run_of(machine: jo.Mechanism, t_end: float, *, rest: bool = False, **how: Any) -> jo.Solution:
    """Return a run with a few instants, on request from the rest position."""
    model = jo.compile(machine)
    if rest:
        how["state"] = jo.equilibrium(model)
    return jo.simulate(model, t_end, output_step=t_end / INSTANTS, **how)


def run_of_file(path: Path) -> jo.Solution:
    """Return the run that a model file describes, with a few instants."""
    file = jo.read_model(path)
    assert file.simulation is not None
    model = jo.compile(file.mechanism)
    given = file.simulation.given(model)
    given["output_step"] = file.simulation.t_end / INSTANTS
    return jo.simulate(model, file.simulation.t_end, **given)


def run_of_rod(example: Any) -> jo.Solution:
    """Return two turns of the connecting rod."""
    heights = dict.fromkeys(example.PIECES, example.START)
    machine = example.slider_crank(heights, example.parts(heights))
    return run_of(machine, 2 * example.TURN, solver=jo.ROS2(step=example.TURN / 500))


def run_of_boom(example: Any) -> jo.Solution:
    """Return the move of the slewing crane with a boom of 0.4 m."""
    heights = dict.fromkeys(example.PIECES, 0.4)
    return run_of(example.crane(heights, example.parts(heights)), 5.0, rest=True)


# examples in Python that give a run within a few seconds; others have a model file of their name
RUNS: Mapping[str, Callable[[Any], jo.Solution]] = {
    "spatial_chain": lambda e: run_of(e.chain(), 4.0, solver=jo.RK4(1e-3)),
    "double_pendulum_split": lambda e: e.simulate(4, e.FEW),
    "squeezer": lambda e: run_of(e.squeezer(), e.END, solver=jo.RK4(step=1e-5)),
    "slewing_limit": lambda e: e.slew(True),
    "robot_hose": lambda e: run_of(
        e.machine(12), 1.5, rest=True, solver=jo.GeneralizedAlpha(step=1e-3)
    ),
    "lcd_robot": lambda e: run_of(e.robot(e.parts()), e.T_END, rest=True, solver=jo.ROS2(e.STEP)),
    "crane_trolley": lambda e: e.run(jo.compile(e.crane()), jo.simulation.DormandPrince()),
    "crane_boom": run_of_boom,
    "rod_at_speed": run_of_rod,
}


def source(name: str) -> Path:
    """Return the file of a machine."""
    return EXAMPLES / (f"{name}.py" if name in RUNS else f"{name}.yaml")


def run(name: str) -> jo.Solution:
    """Return a run of a machine of the examples."""
    logging.getLogger("jousto").setLevel(logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        if name not in RUNS:
            return run_of_file(source(name))
        spec = importlib.util.spec_from_file_location(f"moving_{name}", source(name))
        assert spec is not None and spec.loader is not None
        example = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = example  # where dataclasses look
        spec.loader.exec_module(example)
        return RUNS[name](example)


@cache
def package() -> bytes:
    """Return a digest of what runs and shows machines: jousto, its engine, its page, this file."""
    folder = Path(jo.__file__).parent
    files = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc"]
    return digest(Path(__file__), *sorted(files))


def digest(*files: Path) -> bytes:
    """Return a digest of the contents of files."""
    found = hashlib.sha256()
    for path in files:
        found.update(hashlib.sha256(path.read_bytes()).digest())
    return found.digest()


def kept(name: str) -> Path:
    """Return where the page of a machine is kept, made or not."""
    key = hashlib.sha256(package() + digest(source(name))).hexdigest()[:16]
    return KEPT / f"{name}-{key}.html"


def make(name: str) -> Path:
    """Return the page of a machine, which is made if it is not kept from another build."""
    path = kept(name)
    if not path.exists():
        view = jo.view(run(name), open=False, embed=True)
        KEPT.mkdir(parents=True, exist_ok=True)
        view.save(path, frames=INSTANTS)
        for other in KEPT.glob(f"{name}-*.html"):
            if other != path:
                other.unlink()
    return path


def built() -> bool:
    """Return whether there is a page of the viewer to show machines with."""
    try:
        return bool(bundle.read_bundle())
    except InputError:
        return False


def marked(folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield the pages of a folder and the machines that move in them."""
    for page in sorted(folder.rglob("*.md")):
        for name in MARK.findall(page.read_text(encoding="utf-8")):
            yield page, name


def make_pages(app: Any) -> None:
    """Make the pages of the viewer that the documentation needs."""
    app.moving = {}
    if app.builder.format != "html" or not built():
        return
    app.config.html_static_path = [*app.config.html_static_path, str(STATIC)]
    begin = perf_counter()
    for _, name in marked(Path(app.srcdir)):
        if perf_counter() - begin > TIME and not kept(name).exists():
            log.info("%s moves in the next build: %g s have passed", name, TIME)
            continue
        page = make(name)
        if page.stat().st_size < LARGEST:
            app.moving[name] = page
        else:
            log.warning("the page of %s has %.1f MB", name, page.stat().st_size / 1e6)


def read_again(app: Any, env: Any, *_: Any) -> list[str]:
    """Return the pages with controls: which there are may have changed."""
    return [name for page, _ in marked(Path(app.srcdir)) if (name := env.path2doc(page))]


def controls(app: Any, page: str, text: list[str]) -> None:
    """Replace the marks of a page by controls, or by nothing."""

    def control(match: re.Match[str]) -> str:
        name = match[1]
        address = f"{'../' * page.count('/')}moving/{name}.html"
        return (
            f'<p class="moving"><a href="{address}">move it</a></p>' if name in app.moving else ""
        )

    text[0] = MARK.sub(control, text[0])


def add_script(app: Any, page: str, *_: Any) -> None:
    """Give the pages with controls their script and style."""
    source = app.env.doc2path(page) if page in app.env.all_docs else None
    if source is not None and app.moving and MARK.search(Path(source).read_text(encoding="utf-8")):
        app.add_js_file("moving.js", loading_method="defer")
        app.add_css_file("moving.css")


def copy_pages(app: Any, error: Exception | None) -> None:
    """Put the pages of the viewer beside those of the documentation."""
    if error is None and app.moving:
        folder = Path(app.outdir) / "moving"
        folder.mkdir(exist_ok=True)
        for name, page in app.moving.items():
            shutil.copyfile(page, folder / f"{name}.html")


def setup(app: Any) -> dict[str, Any]:
    """Connect this to Sphinx."""
    app.connect("builder-inited", make_pages)
    app.connect("env-get-outdated", read_again)
    app.connect("source-read", controls)
    app.connect("html-page-context", add_script)
    app.connect("build-finished", copy_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
