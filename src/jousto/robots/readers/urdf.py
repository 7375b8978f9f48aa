"""Reader of URDF files, the robot descriptions of ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.rotations import rotation_matrix
from jousto.robots.description import Collision, Frame, Link, Mimic, Robot, RobotJoint
from jousto.robots.readers import checks
from jousto.robots.readers.collisions import shape_of
from jousto.robots.readers.meshes import Folders, solid_of
from jousto.robots.readers.urdf_surface import with_surfaces
from jousto.robots.readers.urdf_transmissions import read_transmissions
from jousto.robots.readers.urdf_words import URDF
from jousto.robots.readers.words import check_words
from jousto.robots.readers.xml import Element, Reading, parse_file

TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "floating": "floating",
    "planar": "planar",
}


@explained
def read_urdf(
    path: str | Path,
    *,
    packages: Mapping[str, str | Path] | None = None,
    fixed_base: bool = True,
    merge: bool = True,
    repair: bool = False,
    meshes: bool = True,
) -> Robot:
    """Return the robot in a URDF file.

    The frame of a link is that of its parent joint, rotated against the frame of its parent link
    by ``R = Rz(yaw) Ry(pitch) Rx(roll)``. The inertia in the file is about the centre of mass, in
    the axes of the origin of ``<inertial>``. The default axis is x. Joints without ``<limit>`` have
    no limits. Simple transmissions, also those in ``<ros2_control>``, are motors with an `Input`.

    Parameters
    ----------
    path : str or Path
        URDF file. Meshes must be in its folder or in a package.
    packages : dict of str to path, optional
        Folders of further packages, for ``package://name/file.stl``.
    fixed_base : bool
        Whether the root is fixed to the ground; otherwise it moves freely.
    merge : bool
        Whether links on fixed joints are merged with their parents, in which they become frames.
    repair : bool
        Whether a physically impossible inertia is replaced by the nearest possible one, with a
        warning, instead of an error.
    meshes : bool
        Whether meshes are read for pictures; those that touch always are.

    Returns
    -------
    Robot
        Robot with links, joints and warnings.

    Raises
    ------
    InputError
        With all errors: impossible inertia, moving links without mass, reversed limits, loops,
        unknown links, names used twice, NaN.

    Warns
    -----
    JoustoWarning
        Of missing meshes, probably wrong units and elements that are ignored.
    """
    path = Path(path)
    root = parse_file(path)
    reading = Reading(path)
    if root.tag != "robot":
        hint = "; run xacro first" if "xacro" in root.tag else ""
        reading.add(root, f"a URDF file begins with <robot>, not <{root.tag}>{hint}")
        reading.finish()
    check_words(reading, root, URDF)
    folders = Folders(path, packages)
    untouching: list[str] = []
    links = [
        read_link(reading, folders, element, untouching, draw=meshes)
        for element in root.all("link")
    ]
    links = with_surfaces(reading, root, links)
    joints = [read_joint(reading, element) for element in root.all("joint")]
    for element in root.children:
        if element.tag.startswith("xacro:"):
            reading.add(element, f"<{element.tag}> is a macro; run xacro first")
    name = root.given.get("name", path.stem)
    motors = read_transmissions(reading, root, joints)
    made = checks.robot(
        reading, name, links, joints, fixed_base=fixed_base, merge=merge, repair=repair
    )
    return replace(made, untouching=tuple(sorted(set(untouching))), actuators=motors)


def read_link(
    reading: Reading, folders: Folders, element: Element, untouching: list[str], *, draw: bool
) -> Link:
    """Return a link with mass and shapes; shapes that cannot touch are added to `untouching`."""
    where = reading.where(element)
    name = element.given.get("name", "")
    shapes = []
    for visual in element.all("visual"):
        shape = read_visual(reading, folders, visual, draw=draw)
        if shape is not None:
            shapes.append(shape)
    touching: list[Collision] = []
    for solid in element.all("collision"):
        try:
            touching += read_collision(reading, folders, solid, name)
        except ValueError as error:
            untouching.append(str(error))
    collisions = numbered(name, touching)
    inertial = element.first("inertial")
    if inertial is None:
        return Link(name, shapes=tuple(shapes), where=where, collisions=collisions)
    at = read_origin(reading, inertial)
    mass, tensor = 0.0, np.zeros((3, 3))
    found = inertial.first("mass")
    if found is None:
        reading.add(inertial, "<mass> is missing", f"link {name!r}: inertial")
    else:
        mass = reading.number(found, "value")
    found = inertial.first("inertia")
    if found is None:
        reading.add(inertial, "<inertia> is missing", f"link {name!r}: inertial")
    else:
        tensor = read_tensor(reading, found)
    return Link(
        name, mass, at.r, at.A @ tensor @ at.A.T, tuple(shapes), where=where, collisions=collisions
    )


def read_tensor(reading: Reading, element: Element) -> Array:
    """Return the symmetric tensor of six attributes."""
    xx, yy, zz = (reading.number(element, key) for key in ("ixx", "iyy", "izz"))
    missing = [key for key in ("ixy", "ixz", "iyz") if key not in element.given]
    if missing:
        reading.note(
            element, f"{', '.join(missing)} are missing, read as 0; most readers refuse it"
        )
    xy, xz, yz = (reading.number(element, key, 0.0) for key in ("ixy", "ixz", "iyz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def read_origin(reading: Reading, element: Element) -> Frame:
    """Return the pose of the child ``<origin>``; the identity if there is none."""
    origin = element.first("origin")
    if origin is None:
        return Frame()
    if "quat_xyzw" in origin.given:
        x, y, z, w = reading.numbers(
            origin, origin.given["quat_xyzw"], "quat_xyzw", 4, np.array([0.0, 0.0, 0.0, 1.0])
        )
        e = np.array([w, x, y, z])
        if not (size := float(np.linalg.norm(e))) > 0.0:
            reading.add(origin, "quat_xyzw is zero; 0 0 0 1 is no rotation")
            return Frame()
        return Frame(reading.vector(origin, "xyz", (0.0, 0.0, 0.0)), rotation_matrix(e / size))
    angles = reading.vector(origin, "rpy", (0.0, 0.0, 0.0))
    if np.abs(angles).max() > 2.0 * np.pi:
        reading.note(
            origin, f"rpy is {origin.given['rpy']!r}, read as rad; check that it is not in degrees"
        )
    return Frame(reading.vector(origin, "xyz", (0.0, 0.0, 0.0)), roll_pitch_yaw(angles))


def roll_pitch_yaw(angles: Array) -> Array:
    """Return ``R = Rz(yaw) Ry(pitch) Rx(roll)`` (3, 3) of three angles, rad.

    Examples
    --------
    >>> roll_pitch_yaw(np.array([0, 0, np.pi / 2])).round(12) @ [1, 0, 0]
    array([0., 1., 0.])
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def read_visual(reading: Reading, folders: Folders, visual: Element, *, draw: bool) -> Array | None:
    """Return the triangles (nt, 3, 3) of a ``<visual>`` in the frame of its link, m, or None."""
    at = read_origin(reading, visual)
    geometry = visual.first("geometry")
    if geometry is None or not geometry.children:
        reading.note(visual, "has no <geometry>; it is ignored")
        return None
    shape = geometry.children[0]
    solid = None
    if shape.tag == "box":
        solid = solid_of(reading, shape, "box", reading.vector(shape, "size", None))
    elif shape.tag in ("cylinder", "capsule"):
        values = np.array([reading.number(shape, key) for key in ("radius", "length")])
        solid = solid_of(reading, shape, shape.tag, values)
    elif shape.tag == "sphere":
        solid = solid_of(reading, shape, "sphere", np.array([reading.number(shape, "radius")]))
    elif shape.tag == "mesh" and not draw:
        return None
    elif shape.tag == "mesh":
        scale = reading.vector(shape, "scale", (1.0, 1.0, 1.0))
        triangles = folders.mesh(reading, shape, shape.given.get("filename", ""), scale)
        return None if triangles is None else at.r + triangles @ at.A.T
    else:
        reading.leave_out(shape, f"geometry {shape.tag}")
    return None if solid is None else at.r + solid.triangles @ at.A.T


def read_collision(
    reading: Reading, folders: Folders, element: Element, link: str
) -> list[Collision]:
    """Return the shape of a ``<collision>``, of a mesh its hull; none without geometry.

    Raises
    ------
    ValueError
        With the kind of a shape that cannot touch, and the reason.
    """
    geometry = element.first("geometry")
    if geometry is None or not geometry.children:
        return []
    shape, at = geometry.children[0], read_origin(reading, element)
    if shape.tag == "mesh":
        scale = reading.vector(shape, "scale", (1.0, 1.0, 1.0))
        hull = folders.hull(shape.given.get("filename", ""), scale)
        return [Collision(link, hull.shape, at, link, source=hull.text, added=hull.added)]
    keys = {"cylinder": ("radius", "length"), "capsule": ("radius", "length")}
    if shape.tag == "box":
        sizes = reading.vector(shape, "size", None)
    elif shape.tag in ("sphere", *keys):
        wanted = keys.get(shape.tag, ("radius",))
        sizes = np.array([reading.number(shape, key) for key in wanted])
    else:
        raise ValueError(shape.tag)
    made = shape_of(shape.tag, sizes)
    if made is None:
        raise ValueError(f"{shape.tag} without a size")
    return [Collision(link, made, at, link)]


def numbered(link: str, collisions: list[Collision]) -> tuple[Collision, ...]:
    """Return the shapes of a link with names of their own, of several ones with their number."""
    if len(collisions) < 2:
        return tuple(collisions)
    return tuple(replace(one, name=f"{link} {i + 1}") for i, one in enumerate(collisions))


def read_joint(reading: Reading, element: Element) -> RobotJoint:
    """Return the joint of an element."""
    kind = element.given.get("type", "")
    if kind not in TYPES:
        known = ", ".join(TYPES)
        reading.add(element, f"type is {kind!r}, must be one of {known}")
    ends = {}
    for key in ("parent", "child"):
        found = element.first(key)
        if found is None or "link" not in found.given:
            reading.add(element, f"<{key} link=...> is missing")
        ends[key] = "" if found is None else found.given.get("link", "")
    axis = np.array([1.0, 0.0, 0.0])
    found = element.first("axis")
    if found is not None:
        axis = reading.vector(found, "xyz", (1.0, 0.0, 0.0))
    return RobotJoint(
        element.given.get("name", ""),
        TYPES.get(kind, "fixed"),
        ends["parent"],
        ends["child"],
        read_origin(reading, element),
        axis,
        **read_limits(reading, element, kind),
        **read_dynamics(reading, element),
        mimic=read_mimic(reading, element),
        where=reading.where(element),
    )


def read_limits(reading: Reading, element: Element, kind: str) -> dict[str, Any]:
    """Return limits of value, rate and force."""
    limit = element.first("limit")
    if limit is None:
        if kind in ("revolute", "prismatic"):
            reading.note(element, f"a {kind} joint has no <limit>; its motion is not limited")
        return {}
    found = {
        "velocity": reading.limit(limit, "velocity", math.inf),
        "effort": reading.limit(limit, "effort", math.inf),
    }
    if kind in ("revolute", "prismatic"):
        found["lower"] = reading.limit(limit, "lower", 0.0)
        found["upper"] = reading.limit(limit, "upper", 0.0)
        if found["lower"] == found["upper"]:
            reading.note(element, f"both limits are {found['lower']:g}: it cannot move")
    return found


def read_dynamics(reading: Reading, element: Element) -> dict[str, Any]:
    """Return damping, dry friction, spring and rotor inertia of a joint."""
    dynamics = element.first("dynamics")
    if dynamics is None:
        return {}
    return {key: reading.number(dynamics, key, 0.0) for key in ("damping", "friction", "armature")}


def read_mimic(reading: Reading, element: Element) -> Mimic | None:
    """Return the relation of a joint that follows another one, or None."""
    mimic = element.first("mimic")
    if mimic is None:
        return None
    if "joint" not in mimic.given:
        reading.add(element, "<mimic> names no joint")
        return None
    return Mimic(
        mimic.given["joint"],
        reading.number(mimic, "multiplier", 1.0),
        reading.number(mimic, "offset", 0.0),
    )
