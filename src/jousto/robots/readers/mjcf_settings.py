"""Settings of MJCF files: compiler, options, flags, classes of defaults, poses of elements."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.rotations import exp_rotation, rotation_matrix, turn_onto
from jousto.robots.description import Frame
from jousto.robots.readers.xml import Element, Reading

DEGREE = np.pi / 180.0
ORIENTATIONS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")
ACTUATORS = ("general", "motor", "position", "velocity")
EXCLUSIVE = (ORIENTATIONS, ("mass", "density"), ("kv", "dampratio"))
Classes = dict[str, dict[str, dict[str, str]]]


@dataclass
class Settings:
    """Settings of ``<compiler>``, ``<option>`` and ``<flag>``; the last of several values is used.

    Attributes
    ----------
    angle : float
        Unit of angles in the file, rad.
    sequence : str
        Sequence of Euler angles.
    limits : bool
        Whether a range is a limit without the attribute `limited`.
    from_geoms : {"auto", "true", "false"}
        Whether mass and inertia are those of the geoms.
    groups : (2,) array
        First and last group of geoms with mass.
    meshes : str
        Folder of meshes.
    strip, fit_box, exact, balance : bool
        ``strippath``, ``fitaabb``, ``exactmeshinertia`` and ``balanceinertia``.
    least_mass, least_inertia, total : float
        ``boundmass`` (kg), ``boundinertia`` (kg m2) and ``settotalmass`` (kg).
    gravity : (3,) array
        Gravitational acceleration, m/s2.
    off : set of str
        Disabled flags.
    idle_groups : set of int
        Disabled groups of actuators.
    """

    angle: float = DEGREE
    sequence: str = "xyz"
    limits: bool = True
    from_geoms: str = "auto"
    groups: Array = field(default_factory=lambda: np.array([0.0, 5.0]))
    meshes: str = ""
    strip: bool = False
    fit_box: bool = False
    exact: bool = False
    balance: bool = False
    least_mass: float = 0.0
    least_inertia: float = 0.0
    total: float = -1.0
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    off: set[str] = field(default_factory=set)
    idle_groups: set[int] = field(default_factory=set)
    elliptic: bool = False
    ratio: float = 1.0

    @property
    def pyramids(self) -> float:
        """``impratio`` of pyramids of friction; 0 for elliptic cones."""
        return 0.0 if self.elliptic else self.ratio

    @property
    def weight(self) -> Array:
        """Gravitational acceleration, m/s2; zero if gravity is disabled."""
        return np.zeros(3) if "gravity" in self.off else self.gravity


def read_settings(reading: Reading, root: Element) -> Settings:
    """Return the settings of all sections of a file."""
    found = Settings()
    for element in root.all("compiler"):
        _compiler(reading, element, found)
    for element in root.all("option"):
        found.gravity = reading.vector(element, "gravity", tuple(found.gravity))
        found.elliptic = element.given.get("cone", "pyramidal") == "elliptic"
        found.ratio = reading.number(element, "impratio", 1.0)
        groups = element.given.get("actuatorgroupdisable", "").split()
        found.idle_groups |= {int(x) for x in groups if x.isdigit()}
        for flag in element.all("flag"):
            for name, value in flag.given.items():
                (found.off.add if value == "disable" else found.off.discard)(name)
    return found


def _compiler(reading: Reading, element: Element, found: Settings) -> None:
    given = element.given
    words: dict[str, tuple[str, Any]] = {
        "angle": ("angle", {"degree": DEGREE, "radian": 1.0}),
        "autolimits": ("limits", {"true": True, "false": False}),
        "inertiafromgeom": ("from_geoms", {x: x for x in ("auto", "true", "false")}),
        "strippath": ("strip", {"true": True, "false": False}),
        "fitaabb": ("fit_box", {"true": True, "false": False}),
        "exactmeshinertia": ("exact", {"true": True, "false": False}),
        "balanceinertia": ("balance", {"true": True, "false": False}),
    }
    for key, (name, values) in words.items():
        if key in given and given[key] not in values:
            known = " or ".join(values)
            reading.add(element, f"{key} is {given[key]!r}, must be {known}")
        elif key in given:
            setattr(found, name, values[given[key]])
    for key, name in (
        ("boundmass", "least_mass"),
        ("boundinertia", "least_inertia"),
        ("settotalmass", "total"),
    ):
        setattr(found, name, reading.number(element, key, getattr(found, name)))
    text = given.get("inertiagrouprange")
    found.groups = reading.numbers(element, text, "inertiagrouprange", 2, found.groups)
    sequence = given.get("eulerseq", found.sequence)
    if len(sequence) != 3 or set(sequence.lower()) - set("xyz"):
        reading.add(element, f"eulerseq is {sequence!r}, must be three axes such as xyz")
    else:
        found.sequence = sequence
    found.meshes = given.get("meshdir", given.get("assetdir", found.meshes))


def read_classes(root: Element) -> Classes:
    """Return the default attributes by class, element and attribute."""
    found: Classes = {"main": {}}
    for element in root.all("default"):
        # settings in sections at the top of the file accumulate
        _class(element, {}, "main", found)
    return found


def _class(element: Element, above: dict[str, dict[str, str]], spare: str, found: Classes) -> None:
    name = element.given.get("class", spare)
    own = {tag: dict(values) for tag, values in (found.get(name) or above).items()}
    for child in element.children:
        if child.tag != "default":
            tags = (child.tag, "actuator") if child.tag in ACTUATORS else (child.tag,)
            for tag in tags:
                own[tag] = override(own.get(tag, {}), child.given)
    found[name] = own
    for child in element.all("default"):
        _class(child, own, f"class of line {child.line}", found)


def override(given: dict[str, str], by: dict[str, str]) -> dict[str, str]:
    """Return attributes updated by others; a new attribute removes its alternatives."""
    gone = {x for words in EXCLUSIVE if any(word in by for word in words) for x in words}
    return {key: value for key, value in given.items() if key not in gone} | by


class Places:
    """Reader of poses of elements, with the defaults of their classes.

    Parameters
    ----------
    reading : Reading
        Collector of problems.
    root : Element
        Root element of the model.
    """

    def __init__(self, reading: Reading, root: Element) -> None:
        self.reading = reading
        self.settings = read_settings(reading, root)
        self.classes = read_classes(root)

    def given(self, element: Element, inherited: str, tag: str = "") -> Element:
        """Return an element with the default attributes of its class for its own or another tag."""
        name = element.given.get("class", inherited)
        if name not in self.classes:
            self.reading.add(element, f"no class {name!r} of defaults")
            name = "main"
        own = self.classes[name].get(tag or element.tag, {})
        return replace(element, given=override(own, element.given))

    def frame(self, element: Element) -> Frame:
        """Return the pose given by the attributes of an element."""
        return Frame(self.reading.vector(element, "pos", (0.0, 0.0, 0.0)), self.axes(element))

    def axes(self, element: Element) -> Array:
        """Return the orientation of an element (3, 3)."""
        given, reading = element.given, self.reading
        if "quat" in given:
            return self.quaternion(element, "quat")
        if "axisangle" in given:
            text = given["axisangle"]
            values = reading.numbers(element, text, "axisangle", 4, np.array([0.0, 0, 1, 0]))
            turn = values[3] * self.settings.angle
            return exp_rotation(self.unit(element, values[:3], "axisangle") * turn)
        if "euler" in given:
            return self.euler(reading.vector(element, "euler", (0.0, 0.0, 0.0)))
        if "xyaxes" in given:
            values = reading.numbers(element, given["xyaxes"], "xyaxes", 6, np.eye(3)[:2].ravel())
            x = self.unit(element, values[:3], "xyaxes")
            y = self.unit(element, values[3:] - x * (x @ values[3:]), "xyaxes")
            return np.stack([x, y, np.cross(x, y)], axis=1)
        if "zaxis" in given:
            z = self.unit(element, reading.vector(element, "zaxis", None), "zaxis")
            return turn_onto(np.eye(3), z)
        return np.eye(3)

    def quaternion(self, element: Element, key: str) -> Array:
        """Return the orientation (3, 3) of an attribute that is a quaternion."""
        spare = np.array([1.0, 0.0, 0.0, 0.0])
        e = self.reading.numbers(element, element.given.get(key), key, 4, spare)
        size = float(np.linalg.norm(e))
        if size == 0.0:
            self.reading.add(element, f"{key} is zero; 1 0 0 0 is no rotation")
            return np.eye(3)
        return rotation_matrix(e / size)

    def euler(self, angles: Array) -> Array:
        """Return the orientation (3, 3) of three angles in the unit and sequence of the file."""
        A = np.eye(3)
        for letter, angle in zip(self.settings.sequence, angles, strict=True):
            turn = np.eye(3)["xyz".index(letter.lower())] * angle * self.settings.angle
            R = exp_rotation(turn)
            A = A @ R if letter.islower() else R @ A
        return A

    def unit(self, element: Element, vector: Array, name: str) -> Array:
        """Return the unit vector of a vector; add a problem if the vector is zero."""
        size = float(np.linalg.norm(vector))
        if size == 0.0:
            self.reading.add(element, f"{name} is zero, must have a direction")
            return np.array([0.0, 0.0, 1.0])
        return vector / size
