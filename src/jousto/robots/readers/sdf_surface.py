"""What the shapes of SDF files contain on their surface: friction, springs and rebound."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any

from jousto.robots.description import Resistance
from jousto.robots.readers.xml import Element, Reading
from jousto.robots.softness import NO_BOUNCE, Spring

UNREAD_SPRINGS = ("soft_cfm", "soft_erp", "max_vel", "min_depth")
"""Words on springs that belong to the solver of another program."""
Value = Callable[[Element, str, float], float]


def read_surface(reading: Reading, solid: Element, value: Value) -> dict[str, Any]:
    """Return friction, resistance, softness and unread words of a ``<collision>``.

    Parameters
    ----------
    reading : Reading
        Reader that takes errors and warnings.
    solid : Element
        The ``<collision>``.
    value : callable
        Function that returns the number in a child element, or a default.
    """
    found: dict[str, Any] = {"friction": 1.0, "softness": Spring()}  # the defaults of the format
    unread: list[str] = []
    soft: dict[str, Any] = {}
    for surface in solid.all("surface"):
        unread += [one.tag for one in surface.children if one.tag == "soft_contact"]
        for friction in surface.all("friction"):
            found |= read_friction(reading, friction, value, unread)
        for bounce in surface.all("bounce"):
            soft |= read_bounce(reading, bounce, value)
        for contact in surface.all("contact"):
            soft |= read_springs(reading, contact, value, unread)
    found["softness"] = Spring(**soft)
    unread += [key for key in ("kp", "kd") if key in soft]
    unread += ["bounce"] if soft.get("restitution") else []
    found["unread"] = tuple(dict.fromkeys(unread))
    return found


def positive(reading: Reading, element: Element, value: Value, tag: str, spare: float) -> float:
    """Return a number that must not be negative; the default with an error for another one."""
    x = value(element, tag, spare)
    if x < 0.0:
        reading.add(element, f"{tag} is {x:g}, must not be negative")
        return spare
    return x


def read_friction(
    reading: Reading, friction: Element, value: Value, unread: list[str]
) -> dict[str, Any]:
    """Return coefficient of friction and resistance to drilling of ``<friction>``."""
    found: dict[str, Any] = {}
    for ode in friction.all("ode"):
        mu = found["friction"] = positive(reading, ode, value, "mu", 1.0)
        unread += [
            one.tag
            for one in ode.children
            if one.tag != "mu" and not (one.tag == "mu2" and value(ode, "mu2", 1.0) == mu)
        ]
    unread += [one.tag for one in friction.children if one.tag not in ("ode", "torsional")]
    for torsional in friction.all("torsional"):
        share = positive(reading, torsional, value, "coefficient", 1.0)
        radius = positive(reading, torsional, value, "patch_radius", 0.0)
        if torsional.first("surface_radius") is not None or not radius:
            unread.append("torsional")  # of a patch whose size is not in the file
            continue
        # of a round patch with Hertz's pressure the moment is 3 pi / 16 mu N a
        found["resistance"] = Resistance(3.0 * pi / 16.0 * share * radius, 0.0, 4)
    return found


def read_bounce(reading: Reading, bounce: Element, value: Value) -> dict[str, float]:
    """Return restitution and the speed from which a shape bounces."""
    e = positive(reading, bounce, value, "restitution_coefficient", 0.0)
    if e > 1.0:
        reading.add(bounce, f"restitution_coefficient is {e:g}, must not be above 1")
    threshold = positive(reading, bounce, value, "threshold", NO_BOUNCE)
    if e > 0.0 and threshold >= NO_BOUNCE:
        text = "has no effect without a threshold: in SDF shapes bounce from 100000 m/s on"
        reading.note(bounce, f"restitution_coefficient {text}; give <threshold>0</threshold>")
    return {"restitution": min(e, 1.0), "threshold": threshold}


def read_springs(
    reading: Reading, contact: Element, value: Value, unread: list[str]
) -> dict[str, float]:
    """Return stiffness, N/m, and damping, N s/m, of ``<contact><ode>``."""
    found: dict[str, float] = {}
    unread += [one.tag for one in contact.children if one.tag != "ode"]
    for ode in contact.all("ode"):
        for tag in ("kp", "kd"):
            if ode.first(tag) is not None:
                found[tag] = positive(reading, ode, value, tag, 0.0)
        unread += [one.tag for one in ode.children if one.tag in UNREAD_SPRINGS]
    return found
