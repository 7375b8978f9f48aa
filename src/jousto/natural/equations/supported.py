"""Items of a mechanism that the moving frame supports, and the error for all others."""

from __future__ import annotations

from typing import Any

from jousto.base.errors import Problems
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.checks import where
from jousto.mechanism.forces.contact import Contact
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Angle, Displacement, Distance
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Reading
from jousto.mechanism.signals.base import Input, Signal, leaves
from jousto.mechanism.signals.switched import Switched
from jousto.natural.equations.contact_law import left_out
from jousto.natural.equations.force_laws import LAWS, REFUSED

READINGS = (
    *("position", "velocity", "acceleration", "acceleration parts"),
    *("orientation", "angular velocity", "angular acceleration"),
    *("modal", "deformation momentum", "stress", "von mises", "principal", "bridge"),
    *("coordinate", "rate", "energy", "signal", "reaction", "multiplier", "element", "friction"),
)
"""Kinds of sensors that the moving frame supports."""


def check_known(mechanism: Mechanism, *, sensors: bool = True) -> None:
    """Raise InputError with all items of a mechanism that the moving frame does not support.

    Parameters
    ----------
    mechanism : Mechanism
        The mechanism.
    sensors : bool
        Whether unsupported sensors are errors.
    """
    problems = Problems()
    for beam in mechanism.beams:
        problems.add(
            where(beam), "the moving frame does not support exact beams; reduce the beam to modes"
        )
    for body in mechanism.bodies:
        if isinstance(body, FlexibleBody) and body.reduced.stiffening is not None:
            problems.add(
                where(body),
                "the moving frame does not support second-order displacements; reduce the part "
                "without stiffening",
            )
    for friction in mechanism.frictions:
        if friction.law.sticks:
            problems.add(
                where(friction), "the moving frame does not support StickSlip(); use Regularised()"
            )
    for force in mechanism.forces:
        if isinstance(force, Contact) and force.sticks:
            problems.add(
                where(force), "the moving frame does not support StickSlip(); use Regularised()"
            )
    for event in mechanism.events:
        if event.stop:
            problems.add(where(event), "the moving frame does not stop at events; remove it")
        if event.releases:
            names = ", ".join(f"{item.name!r}" for item in event.releases)
            problems.add(
                where(event),
                f"the moving frame does not release {names} during a run; remove the event, and "
                "verify the machine without the released items separately",
            )
    for row in mechanism.couplings:
        if row.optional:
            problems.add(
                where(row),
                f"the moving frame does not support a {row.kind}; use a Stop, or remove it",
            )
    _check_forces(problems, mechanism)
    for sensor in mechanism.sensors if sensors else ():
        if not is_read(sensor):
            problems.add(where(sensor), "the moving frame does not support this sensor; remove it")
    problems.raise_if_any()


def is_read(sensor: Any) -> bool:
    """Return whether the moving frame supports a sensor."""
    reading = sensor.reading
    return reading.kind in READINGS or is_sum(reading)


def is_sum(reading: Reading) -> bool:
    """Return whether a sensor measures the sum of the points of one contact."""
    return reading.kind == "contact" and getattr(reading.of, "summed", False)


def _check_forces(problems: Problems, mechanism: Mechanism) -> None:
    held: tuple[Joint | Coupler, ...] = (*mechanism.joints, *mechanism.couplings)
    for joint in held:
        for line in joint.lines:
            _check_signal(problems, joint, line.signal)
            for s in line.coordinates:
                if not isinstance(s, Angle | Displacement | Distance):
                    problems.add(
                        where(joint), f"the moving frame does not support {type(s).__name__}"
                    )
    for force in mechanism.forces:
        # points of one contact lack the same
        for why in dict.fromkeys(left_out(p) for p in force.pushes if p.kind == "contact"):
            if why:
                problems.add(where(force), why)
        for push in force.pushes:
            if push.kind not in LAWS:
                why = f": {REFUSED[push.kind]}" if push.kind in REFUSED else ""
                message = f"the moving frame does not know the law {push.kind!r}{why}"
                problems.add(where(force), message)
            elif push.kind == "user" and not callable(push.function):
                problems.add(
                    where(force),
                    "the moving frame calls Python functions only, not compiled ones",
                )
            for signal in (push.signal, push.reference):
                _check_signal(problems, force, signal)


def _check_signal(problems: Problems, item: Any, signal: Signal | None) -> None:
    for leaf in () if signal is None else leaves(signal):
        if isinstance(leaf, Input | Switched):
            kind = f"input {leaf.name!r}" if isinstance(leaf, Input) else "a switched signal"
            problems.add(
                where(item), f"follows {kind}, whose value the moving frame does not compute"
            )
