"""MJCF: the models of MuJoCo, as far as they are trees of rigid bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.rotations import exp_rotation, rotation_matrix, turn_onto
from jousto.robots import checks
from jousto.robots.description import Frame, Link, Mimic, Robot, RobotJoint
from jousto.robots.geoms import Geoms
from jousto.robots.markup import Element, Reading, parse_file
from jousto.robots.meshes import Folders

TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "ball", "free": "floating"}
IN_BODY = {"body", "joint", "freejoint", "geom", "site", "inertial", "frame", "camera", "light"}
SECTIONS = {"compiler", "option", "default", "asset", "worldbody", "equality"}
QUIET = {"visual", "statistic", "size", "keyframe", "custom", "sensor", "contact"}
REFUSED = {"include", "attach", "composite", "flexcomp", "replicate", "plugin", "deformable"}
RIGHT = np.pi / 180.0


@explained
def read_mjcf(path: str | Path, *, merge: bool = True, repair: bool = False) -> Robot:
    """Read a tree of rigid bodies from an MJCF file.

    Read are bodies with ``pos`` and any of the five orientations, ``hinge``, ``slide``, ``ball``
    and ``free`` joints (several on one body, too) with anchor, range, damping, stiffness, dry
    friction and armature, ``inertial`` or mass and inertia of the geoms (density 1000), classes
    of defaults, sites as frames, gravity, and equalities of two joints that are linear. Angles
    are in degrees unless ``<compiler angle="radian">`` says otherwise. The root is the world.

    Contact is not modelled; actuators, tendons and other equalities are left out with a
    warning. A body with several joints has links without mass between them.

    Parameters
    ----------
    path : str or Path
        The file. Meshes are looked for in its folder and nowhere else.
    merge : bool
        Whether bodies without joints are merged with those that carry them.
    repair : bool
        Whether inertia that no body has is replaced by the nearest one that a body can have, with
        a warning, instead of refused.

    Raises
    ------
    InputError
        With everything that cannot run, and elements such as ``<include>`` that would change
        what the file says.

    Warns
    -----
    JoustoWarning
        What is left out or odd.
    """
    path = Path(path)
    root = parse_file(path)
    reading = Reading(path)
    if root.tag != "mujoco":
        reading.add(root, f"an MJCF file begins with <mujoco>, not <{root.tag}>")
        reading.finish()
    world = _Reader(reading, root)
    for section in root.all("worldbody"):
        world.contents(section, world.links[0], Frame(), "main", moving=False)
    world.equalities()
    name = root.given.get("model", path.stem)
    made = checks.robot(
        reading, name, world.links, world.joints, fixed_base=True, merge=merge, repair=repair
    )
    return replace(made, gravity=world.gravity)


@dataclass
class _Settings:
    """What ``<compiler>`` says."""

    angle: float = RIGHT
    sequence: str = "xyz"
    limits: bool = True
    from_geoms: str = "auto"
    meshes: str = ""
    refs: dict[str, float] = field(default_factory=dict)


class _Reader:
    """Reads bodies one within the other."""

    def __init__(self, reading: Reading, root: Element) -> None:
        self.reading = reading
        self.settings = _Settings()
        self.gravity = np.array([0.0, 0.0, -9.81])
        self.links: list[Link] = [Link("world", where=reading.where(root, "world"))]
        self.joints: list[RobotJoint] = []
        self.classes: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        self.root = root
        self.count = {"body": 0, "joint": 0}
        self.names: set[str] = set()
        for element in root.children:
            if element.tag in REFUSED:
                self.refuse(element)
            elif element.tag not in SECTIONS | QUIET:
                reading.leave_out(element)
        for element in root.all("compiler"):
            self.compiler(element)
        for element in root.all("option"):
            self.gravity = reading.vector(element, "gravity", (0.0, 0.0, -9.81))
        for element in root.all("default"):
            self.defaults(element, {}, "main")
        folders = Folders(reading.path, None)
        folders.base = folders.home / self.settings.meshes
        self.geoms = Geoms(reading, folders, self)
        for section in root.all("asset"):
            for element in section.all("mesh"):
                self.geoms.asset(element, self.given(element, "main"))

    def refuse(self, element: Element) -> None:
        """Note an element that would change what the file says."""
        self.reading.add(
            element,
            f"<{element.tag}> is not read; write the model out in full (MuJoCo's mj_saveLastXML "
            "does) and read that",
        )

    def compiler(self, element: Element) -> None:
        """Keep the settings of ``<compiler>``."""
        given, settings = element.given, self.settings
        if "angle" in given:
            if given["angle"] not in ("degree", "radian"):
                self.reading.add(element, f"angle is {given['angle']!r}, must be degree or radian")
            settings.angle = 1.0 if given["angle"] == "radian" else RIGHT
        settings.sequence = given.get("eulerseq", settings.sequence)
        if len(settings.sequence) != 3 or set(settings.sequence.lower()) - set("xyz"):
            self.reading.add(element, f"eulerseq is {settings.sequence!r}, must be such as xyz")
            settings.sequence = "xyz"
        settings.limits = given.get("autolimits", "true") == "true"
        settings.from_geoms = given.get("inertiafromgeom", settings.from_geoms)
        settings.meshes = given.get("meshdir", given.get("assetdir", settings.meshes))
        for key in ("boundmass", "boundinertia", "settotalmass", "balanceinertia", "coordinate"):
            if given.get(key, "0") not in ("0", "-1", "false", "local"):
                self.reading.note(element, f"{key} is not read: masses stay as they are")

    # -- defaults ---------------------------------------------------------------------------

    def defaults(self, element: Element, above: dict[str, dict[str, str]], spare: str) -> None:
        """Keep the classes of a ``<default>``, which inherit from those around them."""
        name = element.given.get("class", spare)
        own = {tag: dict(values) for tag, values in above.items()}
        for child in element.children:
            if child.tag != "default":
                own.setdefault(child.tag, {}).update(child.given)
        self.classes[name] = own
        for child in element.all("default"):
            self.defaults(child, own, f"class of line {child.line}")

    def given(self, element: Element, inherited: str) -> Element:
        """Return an element with the attributes of its class."""
        name = element.given.get("class", inherited)
        if name not in self.classes:
            self.reading.add(element, f"no class {name!r} of defaults")
            name = "main"
        whole = {**self.classes[name].get(element.tag, {}), **element.given}
        return replace(element, given=whole)

    # -- places -----------------------------------------------------------------------------

    def frame(self, element: Element) -> Frame:
        """Return the place and orientation that an element gives."""
        return Frame(self.reading.vector(element, "pos", (0.0, 0.0, 0.0)), self.axes(element))

    def axes(self, element: Element) -> Array:
        """Return the orientation of an element (3, 3)."""
        given, reading = element.given, self.reading
        if "quat" in given:
            e = reading.numbers(element, given["quat"], "quat", 4, np.array([1.0, 0, 0, 0]))
            size = float(np.linalg.norm(e))
            if size < 1e-9:
                reading.add(element, "quat is zero; 1 0 0 0 is no turn")
                return np.eye(3)
            return rotation_matrix(e / size)
        if "axisangle" in given:
            text = given["axisangle"]
            values = reading.numbers(element, text, "axisangle", 4, np.array([0.0, 0, 1, 0]))
            turn = values[3] * self.settings.angle
            return exp_rotation(self.unit(element, values[:3], "axisangle") * turn)
        if "euler" in given:
            angles = reading.vector(element, "euler", (0.0, 0.0, 0.0)) * self.settings.angle
            A = np.eye(3)
            for letter, angle in zip(self.settings.sequence, angles, strict=True):
                R = exp_rotation(np.eye(3)["xyz".index(letter.lower())] * angle)
                A = A @ R if letter.islower() else R @ A
            return A
        if "xyaxes" in given:
            values = reading.numbers(element, given["xyaxes"], "xyaxes", 6, np.eye(3)[:2].ravel())
            x = self.unit(element, values[:3], "xyaxes")
            y = self.unit(element, values[3:] - x * (x @ values[3:]), "xyaxes")
            return np.stack([x, y, np.cross(x, y)], axis=1)
        if "zaxis" in given:
            z = self.unit(element, reading.vector(element, "zaxis", None), "zaxis")
            return turn_onto(np.eye(3), z)
        return np.eye(3)

    def unit(self, element: Element, vector: Array, name: str) -> Array:
        """Return a vector of length 1, or note that it has no direction."""
        size = float(np.linalg.norm(vector))
        if size < 1e-9:
            self.reading.add(element, f"{name} has no direction")
            return np.array([0.0, 0.0, 1.0])
        return vector / size

    # -- bodies -----------------------------------------------------------------------------

    def flat(
        self, element: Element, at: Frame, inherited: str
    ) -> Iterator[tuple[Element, Frame, str]]:
        """Yield what stands in a body, frames taken apart, with its frame and class."""
        for child in element.children:
            if child.tag == "frame":
                inner = child.given.get("childclass", inherited)
                yield from self.flat(child, at @ self.frame(child), inner)
            elif child.tag in REFUSED:
                self.refuse(child)
            elif child.tag not in IN_BODY:
                self.reading.leave_out(child)
            else:
                yield child, at, inherited

    def contents(
        self, element: Element, link: Link, at: Frame, inherited: str, *, moving: bool
    ) -> None:
        """Fill a link with what stands in its element, and read the bodies within it."""
        shapes, frames, parts = [], {}, []
        inner = list(self.flat(element, at, inherited))
        for child, place, kind in inner:
            if child.tag == "geom":
                geom = self.geoms.read(self.given(child, kind), place)
                if geom is not None:
                    parts.append(geom)
                    shapes.append(geom.triangles)
            elif child.tag == "site":
                site = self.given(child, kind)
                if "name" in site.given:
                    frames[site.given["name"]] = place @ self.frame(site)
        inertial = next((child for child, _, _ in inner if child.tag == "inertial"), None)
        mass, center, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
        if moving and (self.settings.from_geoms == "true" or inertial is None):
            if self.settings.from_geoms != "false":
                mass, center, inertia = self.geoms.total(parts)
        elif inertial is not None:
            mass, center, inertia = self.inertial(inertial)
        i = self.links.index(link)
        self.links[i] = replace(
            link, mass=mass, center=center, inertia=inertia, shapes=tuple(shapes), frames=frames
        )
        for child, place, kind in inner:
            if child.tag == "body":
                self.body(child, self.links[i].name, place, kind)

    def inertial(self, element: Element) -> tuple[float, Array, Array]:
        """Return mass, centre and inertia in the axes of the body."""
        at = self.frame(element)
        mass = self.reading.number(element, "mass")
        if "fullinertia" in element.given:
            text = element.given["fullinertia"]
            xx, yy, zz, xy, xz, yz = self.reading.numbers(element, text, "fullinertia", 6, None)
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            tensor = np.diag(self.reading.vector(element, "diaginertia", None))
        return mass, at.r, at.A @ tensor @ at.A.T

    def name(self, element: Element, kind: str) -> str:
        """Return the name of an element, or a new one."""
        self.count[kind] += 1
        name = element.given.get("name", "").strip()
        while not name or (name in self.names and "name" not in element.given):
            name = f"{kind}{self.count[kind]}" if not name else f"{name}_"
        self.names.add(name)
        return name

    def body(self, element: Element, parent: str, at: Frame, inherited: str) -> None:
        """Read a body with its joints and all that it carries."""
        inherited = element.given.get("childclass", inherited)
        name = self.name(element, "body")
        place = at @ self.frame(element)
        found = [
            x for x in self.flat(element, Frame(), inherited) if x[0].tag in ("joint", "freejoint")
        ]
        joints = [self.joint(child, frame, kind) for child, frame, kind in found]
        if len(joints) > 1 and any(joint.kind == "floating" for joint in joints):
            self.reading.add(element, f"body {name!r} has other joints beside its free one")
            return
        where = self.reading.where(element)
        if not joints:
            joints = [RobotJoint(f"{name} weld", "fixed", "", "", where=where)]
        for k, joint in enumerate(joints):
            last = k == len(joints) - 1
            child = name if last else f"{name} {k + 1}"
            origin = place if k == 0 else Frame()
            self.joints.append(replace(joint, parent=parent, child=child, origin=origin))
            self.links.append(Link(child, where=where))
            parent = child
        self.contents(element, self.links[-1], Frame(), inherited, moving=True)

    def joint(self, element: Element, at: Frame, inherited: str) -> RobotJoint:
        """Return a joint without its links."""
        name, reading = self.name(element, "joint"), self.reading
        where = reading.where(element)
        if element.tag == "freejoint":
            return RobotJoint(name, "floating", "", "", where=where)
        element = self.given(element, inherited)
        kind = element.given.get("type", "hinge")
        if kind not in TYPES:
            reading.add(element, f"type is {kind!r}, must be one of {', '.join(TYPES)}")
            kind = "hinge"
        if kind == "free":
            return RobotJoint(name, "floating", "", "", where=where)
        scale = self.settings.angle if kind == "hinge" else 1.0
        values: dict[str, Any] = {
            key: reading.number(element, other, 0.0)
            for key, other in (
                ("damping", "damping"),
                ("friction", "frictionloss"),
                ("armature", "armature"),
                ("stiffness", "stiffness"),
            )
        }
        ref = reading.number(element, "ref", 0.0) * scale
        values["rest"] = reading.number(element, "springref", 0.0) * scale - ref
        if ref != 0.0:
            reading.note(element, f"counts from the pose of the file, where MuJoCo says {ref:g}")
            self.settings.refs[name] = ref
        if self.limited(element):
            text = element.given.get("range")
            low, high = reading.numbers(element, text, "range", 2, None) * scale
            if kind == "ball":
                reading.note(element, "the limit of a ball is left out")
            else:
                values["lower"], values["upper"] = low - ref, high - ref
        if "actuatorfrcrange" in element.given:
            text = element.given["actuatorfrcrange"]
            force = reading.numbers(element, text, "actuatorfrcrange", 2, np.zeros(2))
            values["effort"] = float(np.abs(force).max()) or math.inf
        return RobotJoint(
            name,
            TYPES[kind],
            "",
            "",
            axis=at.A @ reading.vector(element, "axis", (0.0, 0.0, 1.0)),
            anchor=at.r + at.A @ reading.vector(element, "pos", (0.0, 0.0, 0.0)),
            where=where,
            **values,
        )

    def limited(self, element: Element) -> bool:
        """Return whether a joint has a range that counts."""
        word = element.given.get("limited", "auto")
        if word == "auto":
            return self.settings.limits and "range" in element.given
        return word == "true"

    # -- equalities -------------------------------------------------------------------------

    def equalities(self) -> None:
        """Let joints follow others; note what else is held."""
        for section in self.root.all("equality"):
            for element in section.children:
                element = self.given(element, "main")
                if element.given.get("active", "true") == "false":
                    continue
                if element.tag != "joint" or not self.follow(element):
                    self.reading.leave_out(element, f"equality {element.tag}")

    def follow(self, element: Element) -> bool:
        """Let a joint follow another one; return whether the equality is linear."""
        one, other = element.given.get("joint1", ""), element.given.get("joint2", "")
        spare = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
        text = element.given.get("polycoef")
        c = self.reading.numbers(element, text, "polycoef", 5, spare)
        index = next((i for i, joint in enumerate(self.joints) if joint.name == one), None)
        if index is None or not other or np.any(c[2:] != 0.0):
            return False
        mimic = Mimic(other, float(c[1]), float(c[0]))
        self.joints[index] = replace(self.joints[index], mimic=mimic)
        return True
