"""Transmissions of URDF files, alone or in ``<ros2_control>``: motors of joints with a gear."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from jousto.base.errors import suggest
from jousto.robots.description import Actuator, RobotJoint
from jousto.robots.readers.checks import joint_name
from jousto.robots.readers.xml import Element, Reading

SIMPLE = "SimpleTransmission"
REDUCTIONS = ("mechanicalReduction", "mechanical_reduction")
NO_FORCE = "makes no force here; put one on its joints with efforts={joint: signal}"


def read_transmissions(
    reading: Reading, root: Element, joints: Sequence[RobotJoint]
) -> tuple[Actuator, ...]:
    """Return the motors of simple transmissions, each with the torque of its shaft as input.

    A transmission with the reduction n turns the torque u of its motor into ``n u`` on its joint.
    The offset shifts where the motor counts from, and has no effect on forces.
    """
    known = {joint.name: joint for joint in joints}
    found: dict[str, Actuator] = {}
    for element in _transmissions(root):
        made = _read(reading, element, known)
        if made is None:
            continue
        if made.name in found:
            reading.add(element, f"2 motors have the name {made.name!r}; rename one")
        found.setdefault(made.name, made)
    return tuple(found.values())


def _transmissions(root: Element) -> Iterator[Element]:
    yield from root.all("transmission")
    for control in root.all("ros2_control"):
        yield from control.all("transmission")


def _read(reading: Reading, element: Element, known: dict[str, RobotJoint]) -> Actuator | None:
    kind = _kind(element)
    joints, motors = list(element.all("joint")), list(element.all("actuator"))
    if not joints and not motors:
        reading.note(element, "a transmission without joint and actuator is left out")
        return None
    if kind and not kind.endswith(SIMPLE):
        reading.effect(element, f"a transmission of the type {kind!r}", NO_FORCE)
        return None
    if len(joints) != 1 or len(motors) != 1:
        text = f"a simple transmission has {len(joints)} joints and {len(motors)} actuators"
        reading.add(element, f"{text}, must have one of each")
        return None
    target = joints[0].given.get("name", "")
    joint = known.get(target)
    if joint is None:
        reading.add(joints[0], f"no joint {target!r}{suggest(target, known)}")
        return None
    if joint.kind not in ("revolute", "prismatic") or joint.mimic is not None:
        what = joint.kind if joint.mimic is None else "following"
        reading.effect(element, f"a transmission of a {what} joint", NO_FORCE)
        return None
    n = _reduction(reading, [element, *joints, *motors])
    name = motors[0].given.get("name") or f"{target} actuator"
    limit = joint.effort / abs(n) if n else joint.effort
    where = reading.where(element)
    return Actuator(name, joint_name(target), gear=n, limit=limit, where=where)


def _kind(element: Element) -> str:
    """Return the type of a transmission; empty if there is none."""
    texts = [child.text.strip() for child in element.all("type", "plugin")]
    return next(iter(texts), "") or element.given.get("type", "")


def _reduction(reading: Reading, ends: Sequence[Element]) -> float:
    """Return the product of the reductions of the transmission, at the joint and at the motor."""
    n = 1.0
    for end in ends:
        for one in end.all(*REDUCTIONS):
            text = one.given.get("value", one.text)
            value = float(reading.numbers(one, text, one.tag, 1, np.ones(1))[0])
            if value == 0.0:
                reading.add(one, f"{one.tag} is 0, must not be zero")
            n *= value
    return n
