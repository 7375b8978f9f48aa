"""Error and iterations of the planar elements: the table of docs/which-beam.md.

    .venv/bin/python benchmarks/planar_elements.py [statics] [write]

prints the table, and with ``write`` puts it into the page; ``statics`` leaves out the motions,
which take some ten minutes, and keeps their columns of the page. The cases are those of
tests/planar/cases.py.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from jousto.planar import (
    AncfElement,
    Convergence,
    CorotationalElement,
    ExactElement,
    PlanarElement,
    PlanarLoad,
    PlanarPath,
    PlanarSection,
    load_steps,
)

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from planar import cases
from planar.frames import chain

sys.path.pop(0)

HEAD = (
    "element",
    "tip load 10 EI/L²: 2, 4, 8, 16, 32",
    "half roll-up: 4, 8, 16",
    "spin-up: 4, 8",
    "pendulum: 4, 8",
)
PAGE = Path(__file__).resolve().parents[1] / "docs" / "which-beam.md"
MARK = re.compile(r"(<!-- benchmarks/planar_elements\.py -->\n).*?(<!-- end -->)", re.S)
SLENDER = PlanarSection(EA=1.2e5, GA=math.inf, EI=1.0)
SHEARED = PlanarSection(EA=1.2e5, GA=1.2e5 * 5 / 6 / 2.6, EI=1.0)
RULE = Convergence(relative=1e-10)
TIP = (-0.5549858925, 0.8106756249)  # u/L and w/L under a load of 10 EI/L^2
MOTIONS = {"spin-up": (4, 8), "pendulum": (4, 8)}
ELEMENTS: dict[str, tuple[PlanarElement, bool]] = {  # with whether motions are measured
    "corotational": (CorotationalElement(), True),
    "corotational, cubic mass": (CorotationalElement(mass="cubic"), True),
    "exact": (ExactElement(), False),
    "ANCF GI, Lobatto 3 / Gauss 3": (AncfElement(), True),
    "ANCF GI, Gauss 4 / 3": (AncfElement(axial="gauss 4"), True),
    "ANCF GI, Gauss 5 / 3": (AncfElement(axial="gauss 5"), False),
    "ANCF BS, Gauss 5 / 3": (AncfElement(law="BS", axial="gauss 5"), False),
}


def loaded(element: PlanarElement, n: int, load: PlanarLoad, steps: int) -> PlanarPath:
    """Return the equilibria of a cantilever of length 1 in equal load steps."""
    section = SHEARED if isinstance(element, ExactElement) else SLENDER
    frame = chain(n, section=section, element=element, loads=[load])
    return load_steps(frame, np.arange(1, steps + 1) / steps, convergence=RULE)


def under_tip_load(element: PlanarElement, n: int) -> PlanarPath:
    """Return the path to a dead load of 10 EI/L^2 in ten steps."""
    return loaded(element, n, PlanarLoad(n, force=(0.0, 10.0)), 10)


def rolled_up(element: PlanarElement, n: int) -> PlanarPath:
    """Return the path to an end moment of pi EI/L in twenty steps."""
    return loaded(element, n, PlanarLoad(n, moment=math.pi), 20)


def tip_reference(element: PlanarElement) -> Any:
    """Return the tip of the exact solution, with shear for the element that has it."""
    if not isinstance(element, ExactElement):
        return np.array(TIP)
    coarse, fine = (under_tip_load(element, n).displacements[-1, -1, :2] for n in (64, 128))
    return (4.0 * fine - coarse) / 3.0


def static_cells(element: PlanarElement) -> Iterator[str]:
    """Yield the cells of the tip load and of the half roll-up."""
    exact = tip_reference(element)
    for path, reference, meshes in (
        (under_tip_load, exact, (2, 4, 8, 16, 32)),
        (rolled_up, np.array([-1.0, 2.0 / math.pi]), (4, 8, 16)),
    ):
        paths = [path(element, n) for n in meshes]
        errors = [float(np.hypot(*(p.displacements[-1, -1, :2] - reference))) for p in paths]
        yield f"{', '.join(map(short, errors))} ({int(np.median([p.solves.sum() for p in paths]))})"


def spin_up_error(element: PlanarElement, n: int) -> float:
    """Return the worst error of the blade's end across the hub's axis, over its length of 10 m."""

    def run(step: float) -> Any:
        return cases.across(cases.spin_up(element, n, step), cases.SPIN_TIMES)

    return float(abs(cases.extrapolated(run, 4e-3) - cases.SPIN).max())


def pendulum_error(element: PlanarElement, n: int) -> float:
    """Return the worst error of the pendulum's end, m."""

    def run(step: float) -> Any:
        return cases.swing(element, n, step)

    return float(abs(cases.extrapolated(run, 1e-3) - cases.SWING).max())


def motion_cells(element: PlanarElement) -> Iterator[str]:
    """Yield the cells of the spin-up and the pendulum."""
    for error, name in ((spin_up_error, "spin-up"), (pendulum_error, "pendulum")):
        yield ", ".join(short(error(element, n)) for n in MOTIONS[name])


def short(x: float) -> str:
    """Return a number with two digits."""
    return f"{x:.1e}".replace("e-0", "e-")


def table(motions: Callable[[str, PlanarElement, bool], list[str]]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield f"| {' | '.join(HEAD)} |"
    yield "|---|---|---|---|---|"
    for name, (element, measured) in ELEMENTS.items():
        cells = [*static_cells(element), *motions(name, element, measured)]
        print(name, cells, flush=True)
        yield f"| {name} | {' | '.join(cells)} |"


def kept(name: str, _: PlanarElement, __: bool) -> list[str]:
    """Return the cells of motions that the page has."""
    row = re.search(rf"^\| {re.escape(name)} \|(.*)\|$", PAGE.read_text(encoding="utf-8"), re.M)
    return [cell.strip() for cell in row[1].split("|")[2:]] if row else ["", ""]


def measured_anew(_: str, element: PlanarElement, measured: bool) -> list[str]:
    """Return the cells of motions, measured."""
    return list(motion_cells(element)) if measured else ["", ""]


if __name__ == "__main__":
    lines = list(table(kept if "statics" in sys.argv else measured_anew))
    print("\n".join(lines))
    if "write" in sys.argv:
        page = PAGE.read_text(encoding="utf-8")
        filled = MARK.sub(lambda m: f"{m[1]}\n" + "\n".join(lines) + f"\n\n{m[2]}", page)
        PAGE.write_text(filled, encoding="utf-8")
