"""Reader of MJCF files, the models of MuJoCo, for rigid bodies."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from jousto.base.arguments import explained
from jousto.robots.description import Actuator, Frame, Link, Robot, ShapePair
from jousto.robots.kinematics.tree import Tree
from jousto.robots.readers import checks
from jousto.robots.readers.meshes import Folders
from jousto.robots.readers.mjcf_bodies import Bodies, resistance_of
from jousto.robots.readers.mjcf_collected import Collected
from jousto.robots.readers.mjcf_softness import soft_words
from jousto.robots.readers.mjcf_ties import (
    SINGLE,
    Motor,
    read_actuators,
    read_ties,
    with_loop_joints,
)
from jousto.robots.readers.mjcf_words import CONTACT, SOFT_WORDS
from jousto.robots.readers.xml import Reading, parse_file


@explained
def read_mjcf(
    path: str | Path, *, merge: bool = True, repair: bool = False, meshes: bool = True
) -> Robot:
    """Return the robot of the rigid bodies in an MJCF file.

    Supported are bodies with ``pos`` and any of the five orientations; ``hinge``, ``slide``,
    ``ball`` and ``free`` joints (also several on one body) with anchor, range, reference, damping,
    stiffness, dry friction and armature; ``inertial`` or the mass of geoms; classes of defaults;
    sites as frames; gravity and gravity compensation; linear equalities of joints; ``connect`` and
    ``weld`` as rigid joints that close loops; and actuators of joints as inputs. Included files and
    attached models are read from the folder of the file. Angles are in degrees unless the file has
    ``<compiler angle="radian">``. The root is the world. Joint coordinates are those of MuJoCo, and
    their initial value is ``ref``.

    Geoms that touch are read for ``contact=True`` of `mechanism`: planes, spheres, capsules,
    cylinders and boxes with their masks, sliding friction and excluded pairs. Unsupported words
    that change the motion give an error or a warning, with line and effect; docs/robot-words.md
    lists every word. A body with several joints has links without mass between them.

    Parameters
    ----------
    path : str or Path
        MJCF file. Other files must be in its folder.
    merge : bool
        Whether bodies without joints are merged with their parents.
    repair : bool
        Whether a physically impossible inertia is replaced by the nearest possible one, with a
        warning, instead of an error.
    meshes : bool
        Whether meshes are read for pictures; those that determine the mass of a body always are.

    Raises
    ------
    InputError
        With all errors of the file.

    Warns
    -----
    JoustoWarning
        Of elements that are ignored and of implausible values.
    """
    path = Path(path)
    root = parse_file(path)
    reading = Reading(path)
    if root.tag != "mujoco":
        reading.add(root, f"an MJCF file begins with <mujoco>, not <{root.tag}>")
        reading.finish()
    found = Collected(links=[Link("world", where=reading.where(root, "world"))])
    bodies = Bodies(reading, root, Folders(path, None), found, draw=meshes, above=(path.resolve(),))
    found.paired |= {name for one in pairs_of(bodies) for name in (one.a, one.b)}
    for section in bodies.root.all("worldbody"):
        bodies.contents(section, found.links[0], Frame(), "main", moving=False)
    models = [bodies, *bodies.attached]
    ties = [tie for one in models for tie in read_ties(one)]
    motors = [motor for one in models for motor in read_actuators(one)]
    weigh(found, bodies.settings.total)
    for i, link in enumerate(found.links):
        touching = tuple(found.collisions.get(link.name, ()))
        found.links[i] = replace(link, collisions=touching)
    apart = tuple(pair for one in models for pair in excluded_bodies(one))
    pairs = tuple(pair for one in models for pair in pairs_of(one))
    note_contact(reading, models, found)
    name = root.given.get("model", path.stem)

    def complete(made: Robot) -> Robot:
        made = replace(with_springdampers(made, found), gravity=bodies.settings.weight)
        return replace(
            with_loop_joints(bodies, made, ties),
            actuators=with_damping_ratios(made, motors),
            apart=apart,
            pairs=pairs,
            untouching=tuple(sorted(set(found.untouching))),
        )

    return checks.robot(
        reading,
        name,
        found.links,
        found.joints,
        fixed_base=True,
        merge=merge,
        repair=repair,
        complete=complete,
    )


def excluded_bodies(model: Bodies) -> list[tuple[str, str]]:
    """Return the pairs of bodies in the ``<exclude>`` elements of a model."""
    elements = [x for section in model.root.all("contact") for x in section.all("exclude")]
    names = ("body1", "body2")
    found = [[model.prefix + x.given.get(key, "") for key in names] for x in elements]
    return [(a, b) for a, b in found]


def pairs_of(model: Bodies) -> list[ShapePair]:
    """Return the pairs of geoms in the ``<pair>`` elements of a model."""
    if {"contact", "constraint"} & model.settings.off:
        return []
    pairs = []
    for element in (x for section in model.root.all("contact") for x in section.all("pair")):
        a, b = (model.prefix + element.given.get(key, "") for key in ("geom1", "geom2"))
        friction, resistance = resistance_of(model.reading, element, 2)
        soft = soft_words(model.reading, element)
        unread = tuple(word for word in (*SOFT_WORDS, "solreffriction") if word in element.given)
        pairs.append(ShapePair(a, b, friction, resistance, unread, soft))
    return pairs


def weigh(found: Collected, total: float) -> None:
    """Scale the masses of all bodies to a total, kg, and set their gravity compensation."""
    mass = sum(link.mass for link in found.links)
    share = total / mass if total > 0.0 and mass > 0.0 else 1.0
    for i, link in enumerate(found.links):
        m = share * link.mass
        lifted = found.lifted.get(link.name, 0.0)
        lifts = ((lifted * m, link.center),) if lifted * m != 0.0 else ()
        found.links[i] = replace(link, mass=m, inertia=share * link.inertia, lifts=lifts)


def note_contact(reading: Reading, models: list[Bodies], found: Collected) -> None:
    """Add one warning if geoms of different bodies could touch, since contact is off by default."""
    for model in models:
        elements = [x for section in model.root.all("contact") for x in section.all("pair")]
        if elements and not {"contact", "constraint"} & model.settings.off:
            reading.effect(elements[0], "<pair>", CONTACT)
            return
    above = {joint.child: joint for joint in found.joints}

    def home(name: str) -> str:
        while name in above and above[name].kind == "fixed":
            name = above[name].parent
        return name

    masks: dict[tuple[str, int, int], None] = {}
    first = None
    for element, link, one, other in found.touching:
        masks.setdefault((home(link), one, other))
        first = first or element
    seen = list(masks)[:200]  # limits the search for one pair
    for i, (a, one, other) in enumerate(seen):
        for b, two, another in seen[:i]:
            carried = any(x in above and home(above[x].parent) == y for x, y in ((a, b), (b, a)))
            near = carried and "world" not in (a, b)
            if a != b and not near and (one & another or two & other):
                assert first is not None
                reading.effect(first, "geoms of different bodies", CONTACT)
                return


def inertias(robot: Robot) -> dict[str, float]:
    """Return the effective inertia of each joint at the initial pose, kg m2 or kg.

    It is the inverse of the mean of ``(M^-1)_ii`` over the coordinates of the joint.
    """
    free = replace(
        robot, loops=(), joints=tuple(replace(joint, mimic=None) for joint in robot.joints)
    )
    tree = Tree(free)
    inverse = np.diag(np.linalg.pinv(tree.mass_matrix(tree.initial)))
    shares: dict[str, list[float]] = {}
    for name, x in zip(tree.velocities, inverse, strict=True):
        shares.setdefault(name.rpartition(".")[0], []).append(float(x))
    return {name: len(x) / max(sum(x), 1e-15) for name, x in shares.items()}


def with_springdampers(robot: Robot, found: Collected) -> Robot:
    """Return a robot whose joints have the springs and dampers of ``springdamper``.

    ``k = m / (T z)^2`` and ``c = 2 m / T`` with the time constant T, the damping ratio z and the
    effective inertia m of the joint.
    """
    if not found.springs:
        return robot
    inertia = inertias(robot)
    springs = {checks.joint_name(name): values for name, values in found.springs.items()}
    joints = []
    for joint in robot.joints:
        if joint.name in springs and joint.name in inertia:
            time, ratio = springs[joint.name]
            m = inertia[joint.name]
            joint = replace(joint, stiffness=m / (time * ratio) ** 2, damping=2.0 * m / time)
        joints.append(joint)
    return replace(robot, joints=tuple(joints))


def with_damping_ratios(robot: Robot, motors: list[Motor]) -> tuple[Actuator, ...]:
    """Return the actuators, with ``b2 = -2 z sqrt(kp m / g^2)`` of those with a damping ratio z."""
    joints = {joint.name: joint for joint in robot.joints if joint.kind in SINGLE}
    inertia = inertias(robot) if any(motor.ratio for motor in motors) else {}
    found = []
    for motor in motors:
        made = motor.made
        if made.joint not in joints:
            continue
        if motor.ratio > 0.0:
            b0, b1, _ = made.bias
            m = inertia[made.joint] / made.gear**2
            made = replace(made, bias=(b0, b1, -2.0 * motor.ratio * math.sqrt(-b1 * m)))
        found.append(made)
    return tuple(found)
