"""Which method a run takes if nobody names one."""

from __future__ import annotations

from jousto.model.model import Model
from jousto.simulation.solvers.explicit import ROS2, Solver
from jousto.simulation.solvers.implicit import GeneralizedAlpha
from jousto.simulation.solvers.schedule import schedule
from jousto.simulation.solvers.stability import damper_warning, friction_warning, stability_warning

SHORTEST = 1e-5  # s, of a step chosen for friction


def choose(
    model: Model, t_end: float, output_step: float | None, start: float = 0.0
) -> tuple[Solver, str]:
    """Return a method for a model and the reason for it.

    `ROS2` with a step of 1 ms, whose steps cost least; with a shorter one, not below 10 us, for
    regularised friction or damper tables that are steep. `GeneralizedAlpha` with a step of 1 ms
    and kept factors for exact beams, and for stiffness that ROS2 does not bear at its step.

    Parameters
    ----------
    model : Model
    t_end, output_step, start : float
        End, time between outputs (None: every step) and begin of the run, s.
    """

    def step(solver: Solver) -> float:
        return schedule(model, t_end, solver, output_step, start).step

    plain, implicit = ROS2(), GeneralizedAlpha()
    usual = step(plain)
    if model.beams:
        return implicit, "it has exact beams"
    if stability_warning(model, plain, usual):
        return implicit, "it has parts that are stiff for ROS2 at a step of 1 ms"
    chosen = plain
    while _steep(model, chosen, step(chosen)) and chosen.step > SHORTEST:
        chosen = ROS2(step=max(SHORTEST, 0.5 * chosen.step))
    if chosen is not plain:
        return chosen, "its friction or dampers are steep for a step of 1 ms"
    return plain, "nothing in it asks for another one"


def _steep(model: Model, solver: Solver, step: float) -> bool:
    return bool(friction_warning(model, solver, step) or damper_warning(model, solver, step))
