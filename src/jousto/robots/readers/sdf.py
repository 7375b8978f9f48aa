"""Reader of SDF files, the models of Gazebo."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.rotations import rotation_matrix, turn_onto
from jousto.mechanism.contacts.shapes import HalfSpace
from jousto.robots.description import Collision, Frame, Link, Mimic, Robot, RobotJoint
from jousto.robots.readers import checks
from jousto.robots.readers.collisions import shape_of
from jousto.robots.readers.meshes import Folders, solid_of
from jousto.robots.readers.sdf_nested import flatten_model
from jousto.robots.readers.sdf_surface import read_surface
from jousto.robots.readers.sdf_words import CONTACT, SDF
from jousto.robots.readers.urdf import roll_pitch_yaw
from jousto.robots.readers.words import check_words
from jousto.robots.readers.xml import Element, Reading, parse_file

TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "ball": "ball",
    "fixed": "fixed",
    "universal": "universal",
    "revolute2": "universal",
    "screw": "screw",
    "gearbox": "gearbox",
}
CLOSING = ("revolute", "prismatic", "ball", "fixed")
FAR = 1e15  # magnitude of a limit above which there is no limit, rad or m


@explained
def read_sdf(
    path: str | Path,
    *,
    packages: Mapping[str, str | Path] | None = None,
    fixed_base: bool = False,
    merge: bool = True,
    repair: bool = False,
    meshes: bool = True,
) -> Robot:
    """Return the robot in an SDF file: its first model, with its nested models.

    Poses may be relative to any link, joint or frame of the model. Without ``relative_to`` the pose
    of a joint is relative to its child, other poses to the model. Joints are revolute, continuous,
    prismatic, screw, universal, revolute2, ball and fixed, also those that close loops. A gearbox
    couples the joints between its reference body and its two links. The root is the world; links
    without a joint to the world move freely, unless the model is static or `fixed_base`. Links of a
    nested model are named ``model::link``.

    Parameters
    ----------
    path : str or Path
        SDF file. Meshes must be in its folder or in a package.
    packages : dict of str to path, optional
        Folders of further packages, for ``model://name/file.stl`` and ``package://name/...``.
    fixed_base : bool
        Whether links without a joint to the world are fixed to it.
    merge : bool
        Whether links on fixed joints are merged with their parents.
    repair : bool
        Whether a physically impossible inertia is replaced by the nearest possible one, with a
        warning, instead of an error.
    meshes : bool
        Whether meshes are read for pictures.

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
    if root.tag != "sdf":
        reading.add(root, f"an SDF file begins with <sdf>, not <{root.tag}>")
        reading.finish()
    world = root.first("world") or root
    models = list(world.all("model"))
    check_words(reading, root, SDF)
    if not models:
        reading.add(root, "has no <model>")
    if reading.problems:
        reading.finish()
    for other in models[1:]:
        reading.note(other, "is ignored: only the first model is read")
    version = root.given.get("version", "1.7")
    reader = _Reader(reading, models[0], version, Folders(path, packages), draw=meshes)
    links, joints = reader.parts(fixed_base)
    name = models[0].given.get("name", path.stem)
    gravity = world.first("gravity")
    weight = np.array([0.0, 0.0, -9.81])
    if gravity is not None:
        weight = _numbers(reading, gravity, 3, weight)

    def complete(made: Robot) -> Robot:
        return replace(
            checks.with_loops(made, reader.loops),
            gravity=weight,
            untouching=tuple(sorted(set(reader.untouching))),
        )

    return checks.robot(
        reading,
        name,
        links,
        joints,
        fixed_base=True,
        merge=merge,
        repair=repair,
        complete=complete,
    )


class _Reader:
    """Reader of one SDF model."""

    def __init__(
        self, reading: Reading, model: Element, version: str, folders: Folders, *, draw: bool
    ) -> None:
        self.old = version in ("1.0", "1.2", "1.3", "1.4")  # axes are in the frame of the model
        model = flatten_model(model, self.old)
        self.reading, self.model, self.folders, self.draw = reading, model, folders, draw
        self.loops: list[RobotJoint] = []
        self.untouching: list[str] = []
        self.named: dict[str, Element] = {}
        self.placed: dict[str, Frame] = {"__model__": Frame()}
        touching = [one for one in model.all("link") if one.first("collision") is not None]
        if len(touching) > 1:
            reading.effect(touching[0], "<collision>", CONTACT)
        for element in model.children:
            if element.tag in ("link", "joint", "frame"):
                self.named.setdefault(element.given.get("name", ""), element)

    def parts(self, fixed_base: bool) -> tuple[list[Link], list[RobotJoint]]:
        """Return links and joints, with the world as the first link."""
        static = _text(self.model, "static") in ("true", "1")
        links = [Link("world", where=self.reading.where(self.model, "world"))]
        links += [self.link(element) for element in self.model.all("link")]
        joints: list[RobotJoint] = []
        gearboxes = []
        for element in self.model.all("joint"):
            if element.given.get("type") == "gearbox":
                gearboxes.append(element)
            else:
                joints += self.joint(element, links)
        joints, self.loops = checks.split_loops(joints, CLOSING)
        for element in gearboxes:
            self.gearbox(element, joints)
        at = self.pose(self.model, Frame())
        held = {joint.child for joint in joints}
        bases = [link for link in links[1:] if link.name not in held]
        kind = "fixed" if static or fixed_base else "floating"
        taken = {joint.name for joint in joints}
        for link in bases:
            name = "base" if len(bases) == 1 else f"base of {link.name}"
            name = f"{name} joint" if name in taken else name
            origin = at @ self.place(link.name, None)
            joints.append(RobotJoint(name, kind, "world", link.name, origin, where=link.where))
        return links, joints

    def gearbox(self, element: Element, joints: list[RobotJoint]) -> None:
        """Set the joint of a gearbox's parent in `joints` to follow ``q1 = -ratio q2``.

        q1 and q2 are the angles of parent and child relative to the reference body about ``axis``
        and ``axis2``.
        """
        body = _text(element, "gearbox_reference_body")
        found = []
        for tag, axis in (("parent", "axis"), ("child", "axis2")):
            link = _text(element, tag)
            ends = {body, link}
            places = [i for i, x in enumerate(joints) if {x.parent, x.child} == ends]
            if len(places) != 1 or joints[places[0]].kind != "revolute" or link not in self.named:
                self.reading.add(
                    element,
                    f"a gearbox needs a revolute joint between its reference body {body!r} and its "
                    f"{tag} {link!r}",
                )
                return
            joint = joints[places[0]]
            below = self.place(joint.child, element)
            own = self.axis(element, element.first(axis), below)["axis"]
            forward = 1.0 if joint.child == link else -1.0
            found.append((places[0], forward * float(np.sign(own @ joint.axis) or 1.0)))
        (i, one), (j, other) = found
        ratio = self.value(element, "gearbox_ratio", 1.0)
        joints[i] = replace(joints[i], mimic=Mimic(joints[j].name, -ratio * one * other, 0.0))

    # -- places -----------------------------------------------------------------------------

    def pose(self, element: Element, spare: Frame) -> Frame:
        """Return the ``<pose>`` of an element, relative to its own reference frame."""
        pose = element.first("pose")
        if pose is None or not pose.text.strip():
            return spare
        if pose.given.get("rotation_format") == "quat_xyzw":
            x = _numbers(self.reading, pose, 7, np.array([0.0, 0, 0, 0, 0, 0, 1]))
            e = x[[6, 3, 4, 5]]
            size = float(np.linalg.norm(e))
            if size < 1e-9:
                self.reading.add(pose, "the quaternion is zero")
                return spare
            return Frame(x[:3], rotation_matrix(e / size))
        x = _numbers(self.reading, pose, 6, np.zeros(6))
        turn = np.pi / 180.0 if pose.given.get("degrees") in ("true", "1") else 1.0
        return Frame(x[:3], roll_pitch_yaw(x[3:] * turn))

    def place(self, name: str, asking: Element | None, depth: int = 0) -> Frame:
        """Return the pose of a link, joint or frame in the model."""
        if name in self.placed:
            return self.placed[name]
        element = self.named.get(name)
        if element is None or depth > len(self.named):
            message = f"no link, joint or frame {name!r}" if element is None else "goes in a circle"
            self.reading.add(asking, message)
            return Frame()
        pose = element.first("pose")
        above = "" if pose is None else pose.given.get("relative_to", "")
        if not above and element.tag == "joint":
            above = _text(element, "child")
        elif not above and element.tag == "frame":
            above = element.given.get("attached_to", "")
        at = self.place(above or "__model__", element, depth + 1) @ self.pose(element, Frame())
        self.placed[name] = at
        return at

    # -- links ------------------------------------------------------------------------------

    def link(self, element: Element) -> Link:
        """Return a link."""
        name, reading = element.given.get("name", ""), self.reading
        shapes = [
            shape for visual in element.all("visual") if (shape := self.visual(visual)) is not None
        ]
        frames = {}
        for frame in self.model.all("frame"):
            if frame.given.get("attached_to") == name and "name" in frame.given:
                here = self.place(name, element).inverted()
                frames[frame.given["name"]] = here @ self.place(frame.given["name"], frame)
        inertial = element.first("inertial")
        mass, at, tensor = 1.0, Frame(), np.eye(3)  # defaults of the format
        if inertial is None:
            reading.note(element, "has no <inertial>; the format gives it 1 kg and 1 kg m2")
        else:
            at = self.pose(inertial, Frame())
            mass = self.value(inertial, "mass", 1.0)
            found = inertial.first("inertia")
            if found is not None:
                xx, yy, zz = (self.value(found, key, 1.0) for key in ("ixx", "iyy", "izz"))
                xy, xz, yz = (self.value(found, key, 0.0) for key in ("ixy", "ixz", "iyz"))
                tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        where, inertia = reading.where(element), at.A @ tensor @ at.A.T
        # <gravity>false</gravity>: full gravity compensation of the link
        weightless = _text(element, "gravity") in ("false", "0") and mass != 0.0
        lifts = ((mass, at.r),) if weightless else ()
        touching = self.collisions(element)
        return Link(name, mass, at.r, inertia, tuple(shapes), frames, where, lifts, touching)

    def visual(self, visual: Element) -> Array | None:
        """Return the triangles (nt, 3, 3), m, of a ``<visual>`` in the link frame, or None."""
        geometry = visual.first("geometry")
        if geometry is None or not geometry.children:
            return None
        shape, at = geometry.children[0], self.pose(visual, Frame())
        if shape.tag == "mesh" and not self.draw:
            return None
        if shape.tag == "mesh":
            found = self.folders.mesh(self.reading, shape, _text(shape, "uri"), self.scale(shape))
            return None if found is None else at.r + found @ at.A.T
        sizes = self.sizes(shape)
        if sizes is None:
            return None
        solid = solid_of(self.reading, shape, shape.tag, sizes)
        return None if solid is None else at.r + solid.triangles @ at.A.T

    def sizes(self, shape: Element) -> Array | None:
        """Return the sizes of a shape for `solid_of`; None for another kind."""
        keys = {"sphere": ("radius",), "cylinder": ("radius", "length")}
        keys["capsule"] = keys["cylinder"]
        if shape.tag in keys:
            return np.array([self.value(shape, key, 0.0) for key in keys[shape.tag]])
        if shape.tag not in ("box", "ellipsoid"):
            return None
        inner = shape.first("size" if shape.tag == "box" else "radii")
        return np.zeros(3) if inner is None else _numbers(self.reading, inner, 3, np.zeros(3))

    def scale(self, shape: Element) -> Array:
        """Return the three factors of a mesh."""
        scale = shape.first("scale")
        return np.ones(3) if scale is None else _numbers(self.reading, scale, 3, np.ones(3))

    def collisions(self, element: Element) -> tuple[Collision, ...]:
        """Return the shapes of a link that touch others; list those that cannot."""
        link, found = element.given.get("name", ""), []
        own = _text(element, "self_collide") or _text(self.model, "self_collide")
        for solid in element.all("collision"):
            geometry = solid.first("geometry")
            if geometry is None or not geometry.children or geometry.first("empty") is not None:
                continue
            name = solid.given.get("name", "collision")
            try:
                made = self.collision(geometry.children[0], self.pose(solid, Frame()))
            except ValueError as error:
                self.untouching.append(str(error))
                continue
            made = replace(made, name=f"{link} {name}", body=link, **self.surface(solid))
            # links of a model touch if one of both asks for it
            found.append(replace(made, affinity=int(own in ("true", "1"))))
        return tuple(found)

    def collision(self, shape: Element, at: Frame) -> Collision:
        """Return a shape that touches others, without name.

        Raises
        ------
        ValueError
            With the kind of a shape that cannot touch, and the reason.
        """
        if shape.tag == "plane":
            normal = shape.first("normal")
            up = np.array([0.0, 0.0, 1.0])
            n = up if normal is None else _numbers(self.reading, normal, 3, up)
            if not np.linalg.norm(n) > 0.0:
                raise ValueError("plane without a normal")
            return Collision("", HalfSpace(), at @ Frame(np.zeros(3), turn_onto(np.eye(3), n)))
        if shape.tag == "mesh":
            if shape.first("submesh") is not None:
                raise ValueError(
                    f"submesh of {_text(shape, 'uri')!r}; put it into a file of its own"
                )
            hull = self.folders.hull(_text(shape, "uri"), self.scale(shape))
            return Collision("", hull.shape, at, source=hull.text, added=hull.added)
        sizes = self.sizes(shape)
        made = None if sizes is None else shape_of(shape.tag, sizes)
        if made is None:
            raise ValueError(shape.tag if sizes is None else f"{shape.tag} without a size")
        return Collision("", made, at)

    def surface(self, solid: Element) -> dict[str, Any]:
        """Return friction, resistance, softness and unread words of a shape, fields of it."""
        return read_surface(self.reading, solid, self.value)

    def value(self, element: Element, tag: str, spare: float) -> float:
        """Return the number in a child element, or a default."""
        child = element.first(tag)
        if child is None:
            return spare
        return float(_numbers(self.reading, child, 1, np.array([spare]))[0])

    # -- joints -----------------------------------------------------------------------------

    def joint(self, element: Element, links: list[Link]) -> list[RobotJoint]:
        """Return the joint of an element; two joints for a universal one."""
        name, reading = element.given.get("name", ""), self.reading
        where, kind = reading.where(element), element.given.get("type", "")
        if kind not in TYPES:
            reading.add(element, f"type is {kind!r}, must be one of {', '.join(TYPES)}")
            return []
        parent, child = _text(element, "parent"), _text(element, "child")
        if child not in self.named or self.named[child].tag != "link":
            reading.add(element, f"child: no link {child!r}")
            return []
        above = Frame() if parent == "world" else self.place(parent, element)
        if parent == "world":
            above = self.pose(self.model, Frame()).inverted()
        elif self.named.get(parent, element).tag != "link":
            reading.add(element, f"parent: no link {parent!r}")
            return []
        below, at = self.place(child, element), self.place(name, element)
        origin, inside = above.inverted() @ below, below.inverted() @ at
        common: dict[str, Any] = {"anchor": inside.r, "where": where}
        axes = [
            self.axis(element, axis, below)
            for axis in (element.first("axis"), element.first("axis2"))
        ]
        if kind in ("ball", "fixed"):
            return [RobotJoint(name, kind, parent, child, origin, **common)]
        if kind == "screw":
            common["pitch"] = self.pitch(element)
        if TYPES[kind] != "universal":
            return [RobotJoint(name, TYPES[kind], parent, child, origin, **axes[0], **common)]
        cross = f"{name} cross"
        links.append(Link(cross, where=where))
        first = RobotJoint(f"{name} 1", "revolute", parent, cross, origin, **axes[0], **common)
        return [
            first,
            RobotJoint(f"{name} 2", "revolute", cross, child, Frame(), **axes[1], **common),
        ]

    def pitch(self, element: Element) -> float:
        """Return the displacement of a screw per revolution, m.

        ``thread_pitch`` (Gazebo Classic) is in rad/m of a left-hand thread.
        """
        if element.first("screw_thread_pitch") is None and element.first("thread_pitch"):
            found = -self.value(element, "thread_pitch", 1.0)
            pitch = 2.0 * math.pi / found if found != 0.0 else 0.0
        else:
            pitch = self.value(element, "screw_thread_pitch", 1.0)
        if pitch == 0.0 or not math.isfinite(pitch):
            self.reading.add(element, "the pitch of the screw is 0; use a revolute joint")
            return 1.0
        return pitch

    def axis(self, element: Element, axis: Element | None, below: Frame) -> dict[str, Any]:
        """Return direction (in the child frame), limits and losses of an ``<axis>``."""
        name = element.given.get("name", "")
        if axis is None:
            z = below.A.T @ self.place(name, element).A[:, 2]
            return {"axis": z}
        inner, reading = axis.first("xyz"), self.reading
        xyz = np.array([0.0, 0.0, 1.0])
        frame = name
        if inner is not None:
            xyz = _numbers(reading, inner, 3, xyz)
            frame = inner.given.get("expressed_in", "") or name
        if self.old or _text(axis, "use_parent_model_frame") in ("true", "1"):
            frame = "__model__"
        found: dict[str, Any] = {"axis": below.A.T @ self.place(frame, axis).A @ xyz}
        limit, dynamics = axis.first("limit"), axis.first("dynamics")
        if limit is not None and element.given.get("type") != "continuous":
            low, high = self.value(limit, "lower", -FAR), self.value(limit, "upper", FAR)
            found["lower"] = -math.inf if low <= -FAR else low
            found["upper"] = math.inf if high >= FAR else high
        for key in ("effort", "velocity"):
            if limit is not None and self.value(limit, key, -1.0) >= 0.0:
                found[key] = self.value(limit, key, -1.0)
        if dynamics is not None:
            found["damping"] = self.value(dynamics, "damping", 0.0)
            found["friction"] = self.value(dynamics, "friction", 0.0)
            found["stiffness"] = self.value(dynamics, "spring_stiffness", 0.0)
            found["rest"] = self.value(dynamics, "spring_reference", 0.0)
        mimic = axis.first("mimic")
        if mimic is not None:
            k = self.value(mimic, "multiplier", 1.0)
            offset = self.value(mimic, "offset", 0.0) - k * self.value(mimic, "reference", 0.0)
            found["mimic"] = Mimic(mimic.given.get("joint", ""), k, offset)
        return found


def _text(element: Element, tag: str) -> str:
    """Return the text of a child element; empty if there is none."""
    child = element.first(tag)
    return "" if child is None else child.text.strip()


def _numbers(reading: Reading, element: Element, count: int, spare: Array | None) -> Array:
    """Return the numbers in the text of an element."""
    return reading.numbers(element, element.text, element.tag, count, spare)
