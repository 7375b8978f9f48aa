"""Fill in the parts of README.md and docs/ that are figures of the benchmarks, from one stored run.

    python benchmarks/page.py

They stand between a line ``<!-- benchmarks/page.py WHAT -->`` and a line ``<!-- end -->``; WHAT is
a name of `MAKERS` with its words. All of them come from results/run.json, which `make bench` writes
as a whole (run.py), so that no two pages can disagree. tests/test_benchmarks.py checks this.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from instructions import table
from precision_fronts import at_step, fastest, front, levels, methods, programs, time_at

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "run.json"
PART = re.compile(
    r"(?<=^<!-- benchmarks/page\.py )([\w-]+)((?: \w+)*)( -->\n).*?(?=^<!-- end -->$)", re.M | re.S
)
STEP = 1e-3  # s, of the table of steps
LIKE = {  # methods of the table of steps where it is not ROS2 beside EXUDYN's generalised alpha
    "exact beam of 100 elements": ("GeneralizedAlpha", "EXUDYN", "generalised alpha"),
    "six-axis arm": ("RK4", "EXUDYN tree", "RK44"),
}
Results = dict[str, Any]


def pages() -> list[Path]:
    """Return the pages that have such parts."""
    found = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [path for path in found if PART.search(path.read_text(encoding="utf-8"))]


def filled(text: str, results: Results) -> str:
    """Return the text of a page with each of its parts as the stored run gives it.

    The output of a program that the run does not have stays as it is, with its conditions.
    """

    def part(match: re.Match[str]) -> str:
        words = match[2].split()
        if words and words[0] not in results["outputs"]:
            return match[0]
        made = "\n".join(MAKERS[match[1]](results, *words))
        return f"{match[1]}{match[2]}{match[3]}\n{made}\n\n"

    return PART.sub(part, text)


def conditions(results: Results, _: str = "") -> Iterator[str]:
    """Yield a sentence on the machine, the compiler and the versions."""
    c = results["conditions"]
    named = {"exudyn": "EXUDYN", "mujoco": "MuJoCo", "pin": "Pinocchio", "numpy": "NumPy"}
    others = [f"{named.get(k, k)} {v}" for k, v in c["versions"].items() if k != "scipy"]
    yield (
        f"Measured on {c['date']}: {c['processor']}, one of {c['cores']} cores, load at the start "
        f"{c['load']}; {c['compiler']}, `{c['flags']}` (build {c['build']}); {', '.join(others)}, "
        f"Python {c['python']}. Processor time, least of several runs that take turns."
    )


def speed(results: Results) -> Iterator[str]:
    """Yield the table of a step of 1 ms, and of the same error."""
    heads = "jousto, us a step", "EXUDYN, us a step", "ratio", "error, m: jousto, EXUDYN"
    yield f"| machine | {' | '.join(heads)} | closest program at equal error |"
    yield "|---|---|---|---|---|---|"
    for name, found in results["precision"].items():
        method, program, other = LIKE.get(name, ("ROS2", "EXUDYN", "generalised alpha"))
        own = at_step(found["points"], "jousto", method, STEP)
        peer = at_step(found["points"], program, other, STEP)
        if own is None or peer is None:
            continue
        times = [1e6 * STEP * p["seconds"] for p in (own, peer)]
        cells = [
            name,
            f"{times[0]:.3g} ({method})",
            number(times[1]) + (", joint angles" if program == "EXUDYN tree" else ""),
            number(times[1] / times[0]),
            f"{own['error']:.1e}, {peer['error']:.1e}",
            closest(found["points"]),
        ]
        yield f"| {' | '.join(cells)} |"


def closest(points: list[Any]) -> str:
    """Return the other program that is closest at equal error, and the range of its ratio."""
    ranges = {}
    for program in programs(points)[1:]:
        ratios = [ratio for error in levels(points) if (ratio := of(points, program, error)) > 0]
        if ratios:
            ranges[program] = (min(ratios), max(ratios))
    if not ranges:
        return ""
    program = min(ranges, key=lambda name: ranges[name][0])
    low, high = (number(x) for x in ranges[program])
    return f"{program} {low if low == high else f'{low} to {high}'}"


def of(points: list[Any], program: str, error: float) -> float:
    """Time of a program over that of jousto at an error; nan where one has not that error."""
    return time_at(front(points, program), error) / time_at(front(points, "jousto"), error)


def number(x: float) -> str:
    """Return a number with two or three digits."""
    return f"{x:.1f}" if x < 10 else f"{x:.0f}"


def equal(results: Results) -> Iterator[str]:
    """Yield the table of ratios at equal error."""
    machines = results["precision"].values()
    names = list(dict.fromkeys(name for x in machines for name in programs(x["points"])))
    heads = ("machine", "error, m", "jousto, ms for 1 s", *(f"{name}, ratio" for name in names[1:]))
    yield f"| {' | '.join(heads)} |"
    yield f"|---|---|---|{'---|' * (len(names) - 1)}"
    for name, found in results["precision"].items():
        points = found["points"]
        for error in levels(points):
            own = 1e3 * time_at(front(points, "jousto"), error)
            cells = [name, f"{error:.0e}", f"{own:.3g}, {fastest(points, 'jousto', error)}"]
            for program in names[1:]:
                ratio = of(points, program, error)
                by = fastest(points, program, error) if len(methods(points, program)) > 1 else ""
                cells.append(f"{number(ratio)} {by}".strip() if np.isfinite(ratio) else "")
            yield f"| {' | '.join(cells)} |"


def apart(results: Results) -> Iterator[str]:
    """Yield how far the motions are apart to which the programs converge."""
    names = list(dict.fromkeys(n for x in results["precision"].values() for n in x["apart"]))
    yield f"| distance from jousto's converged motion, m | {' | '.join(names)} |"
    yield f"|---|{'---|' * len(names)}"
    for name, found in results["precision"].items():
        cells = (f"{found['apart'][n]:.0e}" if n in found["apart"] else "" for n in names)
        yield f"| {name} | {' | '.join(cells)} |"


def newton(results: Results) -> Iterator[str]:
    """Yield what EXUDYN's tolerance of Newton's iteration changes at 1 ms."""
    tolerances = (1e-4, 1e-5, 1e-6, 1e-8)
    yield f"| us a step of 1 ms (error, m) | {' | '.join(f'{x:.0e}' for x in tolerances)} |"
    yield f"|---|{'---|' * len(tolerances)}"
    for name, found in results["precision"].items():
        cells = []
        for x in tolerances:
            own = [
                f"{1e6 * STEP * p['seconds']:.3g} ({p['error']:.1e})"
                for p in found["points"]
                if p["setting"].get("tolerance") == x
                and p["setting"].get("step") == STEP
                and p["error"] is not None
            ]
            cells += own or [""]
        if any(cells):
            yield f"| {name} | {' | '.join(cells)} |"


def left_out(results: Results) -> Iterator[str]:
    """Yield which runs failed, by program and method."""
    for name, found in results["precision"].items():
        if found["left out"]:
            yield f"* {name}: {'; '.join(found['left out'])}"


def instructions(results: Results) -> Iterator[str]:
    """Yield the table of the instructions of a step."""
    yield from table(results["instructions"])


def output(results: Results, program: str) -> Iterator[str]:
    """Yield what a program printed, as a block of text."""
    yield from ["```text", results["outputs"][program].rstrip(), "```"]


def markdown(results: Results, program: str, part: str = "") -> Iterator[str]:
    """Yield what a program printed, which is Markdown; or one of the parts between empty lines."""
    text = results["outputs"][program].strip()
    yield text.split("\n\n")[int(part) - 1] if part else text


def fast(results: Results) -> Iterator[str]:
    """Yield the sentences of the README on speed."""
    machines = {
        "slider-crank, flexible rod": "a slider-crank with a flexible rod",
        "chain of 100 flexible links, revolute": "a chain of 100 flexible bodies",
    }
    costs, ratios = [], []
    for name, words in machines.items():
        points = results["precision"].get(name, {"points": []})["points"]
        own = at_step(points, "jousto", "ROS2", STEP)
        peer = at_step(points, "EXUDYN", "generalised alpha", STEP)
        if own and peer:
            costs.append(f"{number(1e6 * STEP * own['seconds'])} µs for {words}")
            ratios.append(number(peer["seconds"] / own["seconds"]))
    yield f"* **Fast.** A step costs {' and '.join(costs)},"
    yield f"  {' and '.join(ratios)} times less than in EXUDYN; see [work and"
    yield "  precision](docs/work-precision.md). The work of a fixed step is bounded, so that real"
    yield "  time is possible."


MAKERS: dict[str, Callable[..., Iterator[str]]] = {
    "conditions": conditions,
    "speed": speed,
    "equal": equal,
    "apart": apart,
    "newton": newton,
    "left-out": left_out,
    "instructions": instructions,
    "fast": fast,
    "output": output,
    "markdown": markdown,
}


def stored() -> Results:
    """Return the stored run."""
    found: Results = json.loads(RESULTS.read_text(encoding="utf-8"))
    return found


def main() -> None:
    """Fill in all pages."""
    results = stored()
    texts = {path: path.read_text(encoding="utf-8") for path in pages()}
    made = {
        path: filled(text, results) for path, text in texts.items()
    }  # all before one is written
    for path, text in texts.items():
        if made[path] != text:
            path.write_text(made[path], encoding="utf-8")
            print(f"filled in {path.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
