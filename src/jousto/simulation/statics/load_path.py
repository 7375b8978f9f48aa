"""load_path: static equilibria of a mechanism while a load grows, through limit points."""

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
    """Follow the static equilibrium of a mechanism while a parameter goes to a value.

    The residual of the engine at rest is brought to zero by Newton's method with the exact
    tangent, at given loads (``method="load"``) or at given distances along the path
    (``method="arc"``), which passes limit points where the load turns back (snap-through) and
    points where displacements turn back (snap-back). Steps are halved where Newton fails. Points
    where a mode of the tangent stiffness turns unstable are found by bisection. Modal bodies
    always stiffen and soften here, whether their parts were reduced with ``stiffening=True`` or
    not; a run that begins at a state of the path needs parts that were.

    Parameters
    ----------
    model : Model
        From `compile`.
    parameter : str
        Name of an `Input` that scales loads or drives; "gravity" (factor on the model's gravity,
        such as 0 to 1); "time" (s, of signals); with an axis also "speed" (rad/s).
    to : float
        Last value.
    steps : int
        Steps from start to `to`; with "arc" it sets the distance: a step never passes more than
        that part of the load, nor moves or turns the bodies (root mean square) by more than
        ``1 / steps`` sizes of the mechanism or rad.
    method : str or ArcLength
        "load", "arc" or `ArcLength(...)`.
    start : float, optional
        First value; None is the input's present value, 0 for gravity.
    state : State, optional
        Near the first equilibrium; None is the initial state.
    until : function, optional
        Of the State of each point: True ends the path.
    branch : int
        1 or -1: leave the path at the first bifurcation, along plus or minus the critical mode
        (with "arc").
    enough : int
        End after so many critical points; 0: never.
    axis, point, speed
        A steady rotation of everything with `speed` about an axis through a point, world.

    Raises
    ------
    InputError
        If the parameter does not exist, the values make no sense, or a modal body cannot stiffen:
        its part comes from matrices or from a file without stiffening.
    PathFailed
        If no equilibrium is found; it has the path so far and names the body that moves.
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
