"""The machines of the examples, and those of terms that they hardly excite, with how long they are
verified. As a script: the table of the docs.

cd tests; ../.venv/bin/python -m natural.gallery
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.natural.comparison import Compared
from jousto.natural.verification import Verification
from jousto.natural.verify import verify
from natural.terms import TERMS

FOLDER = Path(__file__).parents[2] / "examples"
Begin = Callable[[jo.Model], Any]


@dataclass(frozen=True)
class Shown:
    """A machine, the length and longer step of its runs (s), where they start, and the solver."""

    machine: Callable[[], jo.Mechanism]
    t_end: float
    step: float
    begin: Begin | None = None
    solver: Any = None

    def verified(self) -> Verification:
        """Compare both formulations; an engine that warns of steps is no news here."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", jo.JoustoWarning)
            mechanism = self.machine()
            return verify(
                mechanism, self.t_end, step=self.step, begin=self.begin, solver=self.solver
            )


class Taken(Exception):
    """Carries the mechanism that an example was about to compile."""


def compiled(script: str, run: Callable[[Any], Any]) -> Callable[[], jo.Mechanism]:
    """Return what finds the mechanism that a function of a script compiles."""

    def machine() -> jo.Mechanism:
        def take(mechanism: jo.Mechanism) -> None:
            raise Taken(mechanism)

        with pytest.MonkeyPatch.context() as patch:
            module = example(script)
            patch.setattr(jo, "compile", take)
            with pytest.raises(Taken) as taken:
                run(module)
        found = taken.value.args[0]
        assert isinstance(found, jo.Mechanism)
        return found

    return machine


def example(script: str) -> Any:
    """Return a script of the gallery as a module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        return import_module(script)


def returned(script: str, make: Callable[[Any], Any]) -> Callable[[], jo.Mechanism]:
    """Return what calls a function of a script that returns a mechanism."""
    return lambda: make(example(script))  # type: ignore[no-any-return]


def of_file(name: str, t_end: float, step: float, solver: Any = None) -> Shown:
    """A model file, from where it starts."""

    @cache
    def file() -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", jo.JoustoWarning)
            return jo.read_model(FOLDER / f"{name}.yaml")

    def begin(model: jo.Model) -> Any:
        start = file().simulation.begin
        return start(model) if start else None

    return Shown(lambda: file().mechanism, t_end, step, begin, solver)


def without_friction(machine: jo.Mechanism) -> jo.Mechanism:
    """The same machine on frictionless bearings."""
    return jo.Mechanism(
        *(item for item in machine.items if not isinstance(item, jo.Friction)), name=machine.name
    )


def loaded(make: Callable[[], jo.Mechanism]) -> Callable[[], jo.Mechanism]:
    """The machine with its load, an input of the example, that swells in a second."""

    def machine() -> jo.Mechanism:
        bare = make()
        (load,) = bare.forces
        assert isinstance(load, jo.Force)
        others = (item for item in bare.items if item is not load)
        swell = jo.SCurve((0, 1), (0, 1))
        return jo.Mechanism(*others, replace(load, signal=swell), name=bare.name)

    return machine


def strip(case: str) -> Callable[[], jo.Mechanism]:
    """A case of the example of shape functions, with modes of Craig and Bampton."""

    def make(m: Any) -> jo.Mechanism:
        return m.machine(case, jo.reduce(m.PART, jo.CraigBampton(("start",), modes=4)))

    return returned("shape_functions", make)


def under_weight(m: Any) -> jo.Mechanism:
    """The portal frame, on which nothing acts in the example, falling into its own weight."""
    return jo.Mechanism(*m.frame(4).items, jo.Gravity((0, 0, -9.81)), name="portal")


def rolled(m: Any) -> Any:
    return m.roll(0.012, np.linspace(0.0, m.T_END, 50), np.full((50, 2), 1e4))


def rail_frame(m: Any) -> jo.Mechanism:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return m.mechanism(jo.reduce(m.frame(), jo.CraigBampton(("feet",), modes=12)))


# a motion in which what the machine is about happens; steps that resolve what it does
MACHINES: dict[str, Shown] = {
    "belt_friction.yaml": of_file("belt_friction", 0.1, 1e-3),
    "cantilever.yaml": of_file("cantilever", 0.1, 4e-4),
    "carriage.yaml": of_file("carriage", 2.3, 4e-3, jo.GeneralizedAlpha(4e-3)),
    "crane.yaml": of_file("crane", 2.0, 4e-3),
    "crane_live.yaml": of_file("crane_live", 2.0, 4e-3),
    "flexible_pendulum.yaml": of_file("flexible_pendulum", 0.5, 2e-3),
    "four_bar.yaml": of_file("four_bar", 0.2, 5e-4),
    "link_arm.yaml": of_file("link_arm", 0.4, 2e-3),
    "monitor.yaml": of_file("monitor", 0.3, 1e-3),
    "moving_load.yaml": of_file("moving_load", 0.1, 4e-4),
    "rail_wheel.yaml": of_file("rail_wheel", 2.0, 4e-3),
    "robot.yaml": of_file("robot", 0.5, 2e-3),
    "slider_crank.yaml": of_file("slider_crank", 0.3, 5e-4),
    "spin_up.yaml": of_file("spin_up", 1.0, 4e-3),
    "steel_strip.yaml": of_file("steel_strip", 0.1, 2e-3),
    "belt_friction, smooth law": Shown(
        compiled("belt_friction", lambda m: m.smooth(0.05, 1.0)), 1.0, 2e-3
    ),
    "beam_benchmarks": Shown(
        loaded(
            compiled("beam_benchmarks", lambda m: m.follow(m.straight(1.0, 4, m.THIN), (0, 5, 0)))
        ),
        1.0,
        1e-2,
    ),
    "cantilever_stress": Shown(returned("cantilever_stress", lambda m: m.cantilever()), 0.4, 1e-3),
    "crane_boom": Shown(
        returned("crane_boom", lambda m: m.crane(hs := dict.fromkeys(m.PIECES, 0.4), m.parts(hs))),
        2.0,
        1e-2,
        jo.simulation.vibration_free_state,
    ),
    "crane_drive": Shown(returned("crane_drive", lambda m: m.as_one()), 0.5, 4e-3),
    "crane_life": Shown(
        returned("crane_life", lambda m: m.boom(6e-3, 5e3)),
        1.0,
        1e-2,
        jo.simulation.vibration_free_state,
    ),
    "crane_trolley": Shown(returned("crane_trolley", lambda m: m.crane()), 2.0, 1e-2),
    "double_pendulum_split": Shown(
        returned("double_pendulum_split", lambda m: m.pendulum(2, m.FEW)), 0.3, 1e-3
    ),
    "fatigue_cantilever": Shown(
        compiled("fatigue_cantilever", lambda m: m.bracket(m.LIFT, "lift")), 0.5, 2e-3
    ),
    "gauges": Shown(returned("gauges", lambda m: m.mechanism()), 0.05, 1e-4),
    "lcd_robot": Shown(returned("lcd_robot", lambda m: m.robot(m.parts())), 0.2, 5e-4),
    "lcd_robot, frictionless": Shown(
        returned("lcd_robot", lambda m: without_friction(m.robot(m.parts()))),
        0.4,
        4e-3,
        jo.equilibrium,
    ),
    "portal_frame": Shown(returned("portal_frame", under_weight), 0.05, 4e-4),
    "rail_frame": Shown(returned("rail_frame", rail_frame), 0.3, 2e-3, jo.equilibrium),
    "rail_wheel, the wheel": Shown(compiled("rail_wheel", rolled), 0.002, 2e-5),
    "robot_arm_life": Shown(
        returned("robot_arm_life", lambda m: m.robot(3e-3, 10.0)),
        1.0,
        4e-3,
        jo.simulation.vibration_free_state,
    ),
    "robot_hose": Shown(returned("robot_hose", lambda m: m.machine(8)), 0.5, 2e-3),
    "robot_hose, bare": Shown(
        returned("robot_hose", lambda m: m.machine(8, hose=False)), 0.8, 2e-3, jo.equilibrium
    ),
    "rod_at_speed": Shown(
        returned(
            "rod_at_speed",
            lambda m: m.slider_crank(hs := dict.fromkeys(m.PIECES, m.START), m.parts(hs)),
        ),
        0.01,
        5e-5,
        jo.simulation.vibration_free_state,
    ),
    "shape_functions, shaft": Shown(strip("swung by a shaft"), 0.1, 5e-4),
    "shape_functions, pins": Shown(strip("between two pins"), 0.1, 5e-4),
    "shape_functions, free": Shown(strip("flying freely"), 0.1, 5e-4),
    "slewing_limit": Shown(compiled("slewing_limit", lambda m: m.slew(True)), 1.0, 1e-2),
    "spatial_chain": Shown(returned("spatial_chain", lambda m: m.chain()), 0.3, 1e-3),
    "spin_up, linear": Shown(
        compiled("spin_up", lambda m: m.spin(2.0, stiffening=False)), 4.0, 2e-2
    ),
    "squeezer": Shown(
        returned("squeezer", lambda m: m.squeezer()), 0.01, 4e-5, solver=jo.RK4(2e-5)
    ),
    "study_pendulum": Shown(returned("study_pendulum", lambda m: m.pendulum(1.0, 1.0)), 0.5, 2e-3),
    "rotating slides": Shown(TERMS["rotating slides"], 0.2, 1e-3),
    "gyroscope": Shown(TERMS["gyroscope"], 0.2, 5e-4),
    "node frames": Shown(TERMS["node frames"], 0.02, 2e-5),
    "offset bushings": Shown(TERMS["offset bushings"], 0.2, 1e-3),
    "reversing friction": Shown(TERMS["reversing friction"], 0.3, 1e-3),
}


def motion(shown: Shown, found: Verification) -> list[Compared]:
    """Rows of the sensors that a machine declares, and of energies."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        names = {sensor.name for sensor in shown.machine().sensors}
    return [
        row
        for row in found.rows
        if row.unique and (row.name in names or row.name.endswith("energy"))
    ]


def line(name: str) -> str:
    """The row of a machine in the table of the docs."""
    shown = MACHINES[name]
    found = shown.verified()
    verdict = "agree" if found.agrees else "DISAGREE"
    size = f"{shown.t_end:g} s, {1e3 * shown.step:g} ms"
    ways = {way.name: way.worst for way in found.ways[1:]}
    more = " | ".join(
        "" if (row := ways.get(key)) is None else f"{row.fine:.0e}"
        for key in ("another frame", "finer basis")
    )
    second = found.ways[0].worst
    if found.unknown:
        assert second is not None
        far, same, verdict = second, "", f"two methods {verdict}"
    else:
        far = max(motion(shown, found), key=lambda row: row.fine)
        worst = (row.at_instants for row in found.rows if row.unique and row.at_instants >= 0.0)
        same = f"{max(worst):.0e}"
    other = "" if second is None else f"{second.fine:.0e}"  # none where it fails
    numbers = f"{same} | {far.fine:.0e} | {far.order:.1f} | {other} | {more}"
    return f"| {name} | {size} | {numbers} | {verdict} |"


def main(names: list[str]) -> None:
    """Print the table."""
    for name in names or MACHINES:
        begun = time.process_time()
        print(line(name), end="", flush=True)
        print(f"  {time.process_time() - begun:.1f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
