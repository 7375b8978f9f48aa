"""load_path: path of static equilibria over a load parameter, through limit points."""

from __future__ import annotations

from collections.abc import Callable

from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.errors import Problems
from jousto.model.model import Model
from jousto.simulation.second_order import with_second_order
from jousto.simulation.state import State
from jousto.simulation.statics.load_path_result import ArcLength, LoadPath
from jousto.simulation.statics.path_following import Walk
from jousto.simulation.statics.residual import Balance


@explained
def load_path(
    model: Model,
    parameter: str,
    *,
    to: float,
    steps: int = 20,
    method: str | ArcLength = "load",
    start: float | None = None,
    state: State | None = None,
    until: Callable[[State], bool] | None = None,
    branch: int = 0,
    enough: int = 0,
    axis: ArrayLike | None = None,
    point: ArrayLike = (0.0, 0.0, 0.0),
    speed: float = 0.0,
) -> LoadPath:
    """Return the path of static equilibria of a mechanism while a parameter goes to a value.

    Newton's method with the exact tangent solves the equations of rest, at given loads
    (``method="load"``) or at given arc lengths of the path (``method="arc"``). The arc-length
    method passes limit points of the load (snap-through) and of displacements (snap-back). Steps
    are halved where Newton's method fails. Points where a mode of the tangent stiffness becomes
    unstable are found by bisection. Modal bodies have geometric stiffness here, also if their
    parts were reduced without ``stiffening=True``; a run from a state of the path needs parts
    reduced with it.

    Parameters
    ----------
    model : Model
        From `compile`.
    parameter : str
        Name of an `Input` that scales loads or drives; "gravity" (factor on the model's gravity,
        such as 0 to 1); "time" (time of the signals, s); with an axis also "speed" (rad/s).
    to : float
        Last value of the parameter.
    steps : int
        Number of steps from `start` to `to`. With "arc" it sets the arc length: the load changes
        by at most ``(to - start) / steps`` in a step, and the bodies move (root mean square) by at
        most ``1 / steps`` sizes of the mechanism or rad.
    method : str or ArcLength
        "load", "arc" or `ArcLength(...)`.
    start : float, optional
        First value of the parameter; None: the current value of the input, 0 for gravity.
    state : State, optional
        Starting point for the first equilibrium; None: the initial state.
    until : function, optional
        Function of the State of each point; the path ends where it returns True.
    branch : int
        1 or -1: continue at the first bifurcation on the other branch, along plus or minus the
        critical mode (with "arc"). 0: stay on the path.
    enough : int
        Number of critical points after which the path ends; 0: no limit.
    axis, point, speed
        Steady rotation of the whole mechanism: direction of the axis and a point on it, m, in the
        world frame; speed, rad/s.

    Raises
    ------
    InputError
        If the parameter does not exist, a value is invalid, or a modal body has no geometric
        stiffness because its part comes from matrices or from a file without stiffening.
    PathFailed
        If no equilibrium is found; the error contains the path so far and the body that moves.
    """
    problems = Problems()
    where = "load_path"
    arc = method if isinstance(method, ArcLength) else ArcLength() if method == "arc" else None
    if arc is None and method != "load":
        problems.add(where, f"method is {method!r}, must be 'load', 'arc' or ArcLength(...)")
    problems.number(where, "to", to, "")
    problems.number(where, "steps", steps, "", "1 or more", lambda x: x >= 1)
    if start is not None:
        problems.number(where, "start", start, "")
    if branch not in (-1, 0, 1):
        problems.add(where, f"branch is {branch!r}, must be 1, -1 or 0")
    elif branch and arc is None:
        problems.add(where, "branch needs method='arc': a branch cannot be entered at a given load")
    problems.raise_if_any()
    model = with_second_order(model, where)
    balance = Balance(model, parameter, state, axis=axis, point=point, speed=speed)
    first = balance.value if start is None else float(start)
    if first == to:
        problems.add(where, f"{parameter} is {to:g} already; give another `to` or `start`")
        problems.raise_if_any()
    walk = Walk(
        balance, first, float(to), int(steps), arc=arc, until=until, branch=branch, enough=enough
    )
    return walk.run()
