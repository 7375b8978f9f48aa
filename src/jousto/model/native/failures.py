"""Messages for failures of the engine."""

from __future__ import annotations

from jousto.base.errors import Problem
from jousto.model.model import Model
from jousto.model.native.callback import BadAnswer
from jousto.model.native.header import named

AT_BODY = (
    "not finite",
    "singular body",
    "no convergence",
)  # statuses whose error index is the number of a body


def failure(model: Model, status: str, index: int, cause: BaseException | None = None) -> Problem:
    """Return place, cause and remedy of a status of the engine.

    Parameters
    ----------
    model : Model
        Model with the names.
    status : str
        Name of a jo_status.
    index : int
        Index of the object.
    cause : exception, optional
        Exception of a user's function.
    """
    if status in AT_BODY and not 0 <= index < len(model.bodies):
        index = 0
    if status == "not finite":
        return Problem("", f"body '{model.bodies[index].name}' is no longer finite")
    if status == "singular body" and model.bodies[index].n:
        return Problem(
            f"body '{model.bodies[index].name}'",
            "its mass matrix is singular: its modes together can almost turn or shift the whole "
            "body against its frame; take fewer modes or shape functions, or another frame "
            "(frame=MeanFrame()), or give the part rotary inertia if all its mass is on one line",
        )
    if status == "singular body":
        return Problem(
            f"body '{model.bodies[index].name}'",
            "its mass matrix is singular: there is no inertia about some axis (all mass on one "
            "line or at one point); give the part rotary inertia (rotary_inertia=True) or a "
            "point mass with inertia",
        )
    if status == "singular joint":
        return Problem(
            f"joint '{model.joints[index].name}'",
            "its constraints cannot be distinguished from those of other joints: a body is "
            "lighter than its neighbours by a factor of 1e12 or more; merge it with one of them",
        )
    if status == "callback failed":
        where = f"force '{model.forces[index].name}'"
        if isinstance(cause, BadAnswer):
            return Problem(
                where,
                f"its function {cause}; check it at the positions and velocities of this time",
            )
        if cause is not None:
            return Problem(where, f"its function raised {type(cause).__name__}: {cause}")
        return Problem(
            where,
            "its function reported an error or returned a value that is not finite; check it at "
            "the positions and velocities of this time",
        )
    beams = {i: beam.body for beam in model.beams for i in (beam.a, beam.b)}
    if status == "no convergence" and index in beams:
        return Problem(
            f"beam '{beams[index]}'",
            f"Newton's iteration did not converge, the largest residual is at its node "
            f"'{model.bodies[index].name}'; take a smaller step (the beam should turn by less than "
            "about half a radian a step), more iterations or more elements, apply loads over some "
            "time instead of at once, and check that no element is compressed to zero length or "
            "under so much tension that it is unstable in shear",
        )
    if status == "no convergence":
        return Problem(
            f"body '{model.bodies[index].name}'",
            "Newton's iteration did not converge, the largest residual is at this body; take a "
            "smaller step or more iterations, and check for forces that jump",
        )
    if status == "friction failed":
        friction = model.frictions[index]
        data = named("jo_friction_data", friction.data)
        return Problem(
            f"friction '{friction.name}'",
            f"no reaction of joint '{model.joints[friction.joint].name}' is in equilibrium with "
            f"its friction: with mu_kinetic = {data.mu_kinetic.real:g} and mu_static = "
            f"{data.mu_static.real:g} the joint jams (friction increases its own normal force); "
            f"lower mu or the radius, lengthen the bearing or move the load nearer to it",
        )
    if status == "step too small":
        return Problem(
            "",
            "the tolerance needs steps below the resolution of time: a force jumps or is very "
            "stiff here; make it smoother, switch it by an event, give a larger tolerance, or "
            "use a method with a fixed step such as ROS2",
        )
    rows = index - len(model.events) - len(model.frictions)
    if status == "endless" and rows >= len(model.switched) and rows >= 0:
        struck = model.forces[rows - len(model.switched)].name
        return Problem(
            f"contact '{struck}'",
            "strikes many times in one instant; take resolve='cut', or a larger `slowest` of its "
            "law, below which a touch does not rebound",
        )
    if status == "endless" and rows >= 0 and model.switched:
        return Problem(
            f"stop or lock '{model.switched[rows].name}'",
            "opens and closes many times within one step; use a smaller step, or a larger "
            "`slowest`, below which an impact does not rebound",
        )
    if status == "endless" and index >= len(model.events):
        return Problem(
            f"friction '{model.frictions[index - len(model.events)].name}'",
            "changes between stick and slip many times within one step; use a smaller step, or "
            "law=Regularised(velocity), which has no sticking",
        )
    if status == "endless":
        name = model.events[index].name if index < len(model.events) else ""
        return Problem(
            f"event '{name}'",
            "occurs many times within one step; let it count in one direction only, separate "
            "the thresholds of opposite events, or use a smaller step",
        )
    if status == "bent":
        beam = model.beams[index] if 0 <= index < len(model.beams) else None
        return Problem(
            f"beam '{beam.body}', element '{beam.name}'" if beam else "a beam element",
            "it is bent or twisted by 3 rad or more, beyond which its rotation is not unique; "
            "divide the beam into more elements (half a radian each is accurate), or use "
            "smaller steps if the motion itself is smaller",
        )
    if status == "beyond table":
        return Problem(
            f"states '{model.forces[index].name}'",
            'an input of a table with outside="stop" lies beyond its knots; give the table more '
            'knots, or outside="line" or "hold"',
        )
    if status == "delay full":
        force = model.forces[index]
        points = int(named("jo_delay_data", force.data).points.real)
        return Problem(
            f"delay '{force.state_names[0].partition('.')[0]}'",
            f"its input jumps too often within the delay for {points} points; give it more, such "
            f"as points={10 * points}",
        )
    if status == "too many contacts":
        force = model.forces[index]
        return Problem(
            f"contacts '{force.name}'",
            f"more than {force.slots} pairs of shapes are near one another, which is all that the "
            f"set has slots for; give it most={2 * force.slots} or more",
        )
    return Problem("", f"engine status {status!r}")
