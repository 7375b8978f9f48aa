"""Choice of the default method of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from jousto.mechanism.forces.law import LAWS
from jousto.model.force_numbers import numbers_of
from jousto.model.model import ForceModel, Model
from jousto.simulation.controllers import fastest_tracking
from jousto.simulation.solvers.adaptive import DormandPrince
from jousto.simulation.solvers.base import Solver
from jousto.simulation.solvers.explicit_growth import excess
from jousto.simulation.solvers.impact_time import shortest_blow
from jousto.simulation.solvers.implicit import GeneralizedAlpha
from jousto.simulation.solvers.rosenbrock import ROS2
from jousto.simulation.solvers.schedule import schedule
from jousto.simulation.solvers.stability import damper_warning, friction_warning

SHORTEST = 1e-5  # smallest step chosen for friction, s
SHORT = 1e-4  # smallest step chosen for springs, s; below it the implicit method is cheaper
BLOW = 20  # steps in an impact on a stop, for an error of the restitution of 0.01
STEPS = (5e-4, 2e-4, SHORT)  # steps to choose from for impacts, s
SHORTER = (5e-5, 2e-5, SHORTEST)  # steps to choose from for controllers at their limits, s
UNBOUNDED = 10.0  # assumed duration of runs without a known end, as of exported machines, s
ALLOWED = 0.1  # largest growth of small motions in a run that a method may add


def choose(
    model: Model, t_end: float, output_step: float | None, start: float = 0.0
) -> tuple[Solver, str]:
    """Return a method for a model and the reason for it.

    The default is `ROS2` with a step of 1 ms, the cheapest method. Its step is shorter (at least 10
    us) for steep regularised friction or damper tables, and (at least 0.1 ms) for impacts on stops
    and for springs and bushings whose motions would grow by more than a tenth in the run. For exact
    beams, and for springs and bushings that are faster, the choice is `GeneralizedAlpha` with a
    step of 1 ms and reused factors. No step exceeds the back-calculation time of a controller,
    unless that is below 10 us.

    Parameters
    ----------
    model : Model
    t_end, output_step, start : float
        End of the run, time between outputs (None for every step) and start of the run, s.
    """
    chosen, reason = _without_tracking(model, t_end, output_step, start)
    time, name = fastest_tracking(model)
    if chosen.step <= time:
        return chosen, reason
    step = next((step for step in (*STEPS, *SHORTER) if step <= time), SHORTEST)
    shorter: Solver = replace(chosen, step=step)  # type: ignore[call-arg]
    return shorter, f"since PID '{name}' comes back from its limit in {time:.2g} s"


def _without_tracking(
    model: Model, t_end: float, output_step: float | None, start: float
) -> tuple[Solver, str]:
    def step(solver: Solver) -> float:
        return schedule(model, t_end, solver, output_step, start).step

    plain, implicit = ROS2(), GeneralizedAlpha()
    if model.beams:
        return implicit, "since it has exact beams"
    chosen = plain
    while excess(model, chosen, step(chosen)) * (t_end - start) > ALLOWED:
        if chosen.step < 2.0 * SHORT:
            reason = f"since it has {fast(model)} that are too fast for {type(plain).__name__}"
            return implicit, reason
        chosen = replace(chosen, step=0.5 * chosen.step)
    if chosen is not plain:
        reason = f"since it has {fast(model)} that are fast for a step of 1 ms"
        return _for_friction(model, _for_stops(model, chosen), step), reason
    chosen = _for_stops(model, plain)
    if chosen is not plain:
        return _for_friction(
            model, chosen, step
        ), "since blows on its stops are short for a step of 1 ms"
    chosen = _for_friction(model, plain, step)
    if chosen is not plain:
        return chosen, "since its friction or dampers are steep for a step of 1 ms"
    return plain, "the default"


def fast(model: Model) -> str:
    """Return the names of the stiff elements of a model: springs, dampers, bushings or stops."""
    words: set[str] = set()
    for force in model.forces:
        for word, causes in force.law.fast.items():
            if word not in words and (not causes or any(_has(force, one) for one in causes)):
                words.add(word)
    every = dict.fromkeys(word for name in sorted(LAWS) for word in LAWS[name].fast)
    *first, last = [word for word in every if word in words] or ["springs or bushings"]
    return f"{', '.join(first)} or {last}" if first else last


def _has(force: ForceModel, cause: str) -> bool:
    """Return whether a number of a force is not zero or its function exists."""
    if cause in ("spring", "damper"):
        return bool(getattr(force, cause) >= 0)
    return bool(getattr(numbers_of(force), cause) != 0.0)


def choose_fixed(model: Model) -> Solver:
    """Return the method with a fixed step for an exported program, as for `UNBOUNDED` seconds."""
    return choose(model, UNBOUNDED, None)[0]


def choose_adaptive(solver: Solver | None) -> Any:
    """Return the given method if it is adaptive, else the default adaptive method."""
    return solver if solver is not None and solver.adaptive else DormandPrince()


def _for_stops(model: Model, chosen: ROS2) -> ROS2:
    """Return the method with a step that resolves impacts on stops."""
    longest = shortest_blow(model) / BLOW * (1.0 + 1e-6)
    if chosen.step <= max(longest, SHORT):
        return chosen
    return replace(chosen, step=next((step for step in STEPS if step <= longest), SHORT))


def _for_friction(model: Model, chosen: ROS2, step: Callable[[Solver], float]) -> ROS2:
    """Return the method with a step that resolves regularised friction and damper tables."""
    while _steep(model, chosen, step(chosen)) and chosen.step > SHORTEST:
        chosen = replace(chosen, step=max(SHORTEST, 0.5 * chosen.step))
    return chosen


def _steep(model: Model, solver: Solver, step: float) -> bool:
    return bool(friction_warning(model, solver, step) or damper_warning(model, solver, step))
