"""What the engine could not do, as sentences."""

from __future__ import annotations

from jousto.base.errors import Problem
from jousto.model.model import Model
from jousto.model.native.callback import BadAnswer
from jousto.model.native.header import named

AT_BODY = ("not finite", "singular body", "no convergence")  # whose index is that of a body


def failure(model: Model, status: str, index: int, cause: BaseException | None = None) -> Problem:
    """Return place, cause and remedy of a status of the engine.

    Parameters
    ----------
    model : Model
        For the names.
    status : str
        Name of a jo_status.
    index : int
        The object that it is about.
    cause : exception, optional
        What a user's function raised.
    """
    if status in AT_BODY and not 0 <= index < len(model.bodies):
        index = 0
    if status == "not finite":
        return Problem("", f"body '{model.bodies[index].name}' is no longer finite")
    if status == "singular body":
        return Problem(
            f"body '{model.bodies[index].name}'",
            "its mass matrix is singular: there is no inertia about some axis (all mass on "
            "one line or at one point); give the part rotary inertia (rotary_inertia=True) "
            "or a point mass with inertia",
        )
    if status == "singular joint":
        return Problem(
            f"joint '{model.joints[index].name}'",
            "its constraints cannot be distinguished from those of other joints: a body is "
            "lighter than its neighbours by a factor of 1e12 or more; join it with one of them",
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
            "time instead of at once, and check that no element is under more tension than shear "
            "bears or is squeezed to nothing",
        )
    if status == "no convergence":
        return Problem(
            f"body '{model.bodies[index].name}'",
            "Newton's iteration did not converge, the largest residual is at this body; take a "
            "smaller step or more iterations, and look for forces that jump",
        )
    if status == "friction failed":
        friction = model.frictions[index]
        data = named("jo_friction_data", friction.data)
        return Problem(
            f"friction '{friction.name}'",
            f"no reaction of joint '{model.joints[friction.joint].name}' agrees with its own "
            f"friction: with mu_kinetic = {data.mu_kinetic.real:g} and mu_static = "
            f"{data.mu_static.real:g} it presses itself harder than it slips (it jams); lower mu "
            "or the radius, lengthen the bearing or bring the load nearer to it",
        )
    if status == "step too small":
        return Problem(
            "",
            "the tolerance asks for steps below the resolution of time: a force jumps or is very "
            "stiff here; make it smoother, switch it by an event, give a larger tolerance, or take "
            "a method with a fixed step such as ROS2",
        )
    if status == "endless" and index >= len(model.events):
        return Problem(
            f"friction '{model.frictions[index - len(model.events)].name}'",
            "sticks and slips again and again within one step; take a smaller step, or "
            "law=Regularised(velocity), which has no such instants",
        )
    if status == "endless":
        name = model.events[index].name if index < len(model.events) else ""
        return Problem(
            f"event '{name}'",
            "happens again and again within one step, each time undone at once; let it count in "
            "one direction only, keep the thresholds of opposed events apart, or take a smaller "
            "step",
        )
    if status == "bent":
        beam = model.beams[index] if 0 <= index < len(model.beams) else None
        return Problem(
            f"beam '{beam.body}', element '{beam.name}'" if beam else "a beam element",
            "it is bent or twisted by 3 rad or more, where its rotation is no longer one number; "
            "divide the beam into more elements (half a radian each is accurate), or take smaller "
            "steps if it only passes through here by too long a one",
        )
    return Problem("", f"engine status {status!r}")
