"""Reader of the nested bodies of MJCF files: joints, masses, shapes and sites."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, suggest
from jousto.robots.description import Collision, Frame, Link, Resistance, RobotJoint
from jousto.robots.readers.meshes import Folders
from jousto.robots.readers.mjcf_collected import Collected, Site, turned_back
from jousto.robots.readers.mjcf_expand import (
    everything,
    find_named,
    include_files,
    replicate,
    with_affixes,
)
from jousto.robots.readers.mjcf_geoms import Geom, Geoms
from jousto.robots.readers.mjcf_settings import Places
from jousto.robots.readers.mjcf_softness import soft_words
from jousto.robots.readers.mjcf_words import LOPSIDED, MJCF, SOFT_WORDS, UNREAD
from jousto.robots.readers.words import check_words
from jousto.robots.readers.xml import DEEPEST, Element, Reading, parse_file
from jousto.robots.softness import SoftConstraint

TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "ball", "free": "floating"}
LOSSES = {"stiffness": "spring", "damping": "damper", "frictionloss": "frictionloss"}
MOST_ATTACHED = 10_000  # maximum number of attached models
OWN = {"stiffness": "stiffness", "damping": "damping", "frictionloss": "friction"}


class Bodies:
    """Reader of the nested bodies of a model.

    Parameters
    ----------
    reading : Reading
        Collector of problems.
    root : Element
        Root element of the model.
    folders : Folders
        Allowed folders of files.
    found : Collected
        Collector of links, joints and actuators.
    draw : bool
        Whether meshes for pictures alone are read.
    prefix : str
        Prefix of all names.
    above : tuple of Path
        Paths of the models that attach this one.
    """

    def __init__(
        self,
        reading: Reading,
        root: Element,
        folders: Folders,
        found: Collected,
        *,
        draw: bool,
        prefix: str = "",
        above: tuple[Path, ...] = (),
    ) -> None:
        self.reading, self.folders, self.found, self.prefix = reading, folders, found, prefix
        self.above = above
        root = include_files(reading, root, folders)
        check_words(reading, root, MJCF)
        self.places = Places(reading, root)
        self.settings = self.places.settings
        self.root, self.copies = replicate(reading, root, self.places.euler)
        self.geoms = Geoms(self.places, folders.within(self.settings.meshes), draw=draw)
        self.models: dict[str, Element] = {}
        self.attached: list[Bodies] = []
        for section in self.root.all("asset"):
            for element in section.all("mesh"):
                self.geoms.asset(element)
            for element in section.all("hfield"):
                self.geoms.ground(element)
            for element in section.all("model"):
                file = element.given.get("file", "")
                name = element.given.get("name", file.rpartition("/")[2].rpartition(".")[0])
                self.models[name] = element

    def flat(
        self, element: Element, at: Frame, inherited: str
    ) -> Iterator[tuple[Element, Frame, str]]:
        """Yield the elements of a body with pose and class, also those inside its ``<frame>``."""
        for child in element.children:
            if child.tag == "frame":
                inner = child.given.get("childclass", inherited)
                yield from self.flat(child, at @ self.places.frame(child), inner)
            else:
                yield child, at, inherited

    def contents(
        self, element: Element, link: Link, at: Frame, inherited: str, *, moving: bool
    ) -> None:
        """Add the contents of an element to a link, and read the bodies in it."""
        inner = list(self.flat(element, at, inherited))
        inertial = next((child for child, _, _ in inner if child.tag == "inertial"), None)
        from_geoms = self.settings.from_geoms
        weighed = moving and (from_geoms == "true" or (from_geoms == "auto" and inertial is None))
        parts, frames = self.filling(inner, link, weighed=weighed)
        mass, center, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
        if weighed:
            mass, center, inertia = self.geoms.total(parts)
        if inertial is not None and moving and (not weighed or mass == 0.0):
            mass, center, inertia = self.inertial(inertial)
        if not (np.isfinite(mass) and np.isfinite(inertia).all()):
            self.reading.add(element, "mass or inertia is not finite; check that sizes are in m")
            mass, inertia = 0.0, np.zeros((3, 3))
        if moving:
            mass, inertia = self.bounded(mass, inertia)
        i = next(i for i, one in enumerate(self.found.links) if one is link)
        shapes = tuple(part.triangles for part in parts)
        self.found.links[i] = replace(
            link, mass=mass, center=center, inertia=inertia, shapes=shapes, frames=frames
        )
        for child, place, kind in inner:
            if child.tag == "body":
                self.body(child, link.name, place, kind)
            elif child.tag == "attach":
                self.attach(child, link, place, kind)

    def filling(
        self, inner: list[tuple[Element, Frame, str]], link: Link, *, weighed: bool
    ) -> tuple[list[Geom], dict[str, Frame]]:
        """Return the geoms and the sites of a link."""
        frames, parts = {}, []
        for child, place, kind in inner:
            if child.tag == "geom":
                given = self.places.given(child, kind)
                self.touches(given, link.name)
                geom = self.geoms.read(given, place, weighed=weighed)
                if geom is not None:
                    parts.append(geom)
                self.collision(given, place, link.name)
            elif child.tag == "site":
                given = self.places.given(child, kind)
                if "fromto" in given.given:
                    _, frame = self.geoms.sized(
                        replace(given, given={"size": "1"} | given.given), "capsule", place
                    )
                else:
                    frame = place @ self.places.frame(given)
                if "name" in given.given:
                    name = self.prefix + given.given["name"]
                    frames[name] = frame
                    self.found.sites[name] = Site(link.name, frame)
        return parts, frames

    def touches(self, given: Element, link: str) -> None:
        """Add a geom that may touch others to the list for the warning on contact."""
        masks = [given.given.get(key, "1") for key in ("contype", "conaffinity")]
        if not {"contact", "constraint"} & self.settings.off and masks != ["0", "0"]:
            one, other = (int(x) if x.lstrip("-").isdigit() else 1 for x in masks)
            self.found.touching.append((given, link, one, other))

    def collision(self, given: Element, at: Frame, link: str) -> None:
        """Add the shape of a geom that may touch others to its link."""
        if {"contact", "constraint"} & self.settings.off:
            return
        masks = [int(self.reading.number(given, key, 1.0)) for key in ("contype", "conaffinity")]
        kind = given.given.get("type", "sphere")
        named = self.prefix + given.given.get("name", "") in self.found.paired
        if masks == [0, 0] and not named:
            return
        try:
            shape, place, source = self.geoms.touching(given, kind, at)
        except ValueError as error:
            self.found.untouching.append(str(error))
            return
        friction, resistance = resistance_of(self.reading, given, 1)
        usual = {**SOFT_WORDS, **UNREAD}
        unread = tuple(word for word in usual if given.given.get(word, usual[word]) != usual[word])
        softness = SoftConstraint(ratio=self.settings.pyramids, **soft_words(self.reading, given))
        made = Collision(
            *(self.name(given, "geom"), shape, place, link, 1.0 if friction is None else friction),
            *(resistance or Resistance(), masks[0], masks[1], unread, source),
            softness=softness,
        )
        self.found.collisions.setdefault(link, []).append(made)

    def inertial(self, element: Element) -> tuple[float, Array, Array]:
        """Return mass, centre of mass and inertia of ``<inertial>`` in the axes of the body."""
        reading = self.reading
        at, mass = self.places.frame(element), reading.number(element, "mass")
        if "fullinertia" in element.given:
            text = element.given["fullinertia"]
            xx, yy, zz, xy, xz, yz = reading.numbers(element, text, "fullinertia", 6, None)
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            tensor = np.diag(reading.vector(element, "diaginertia", (0.0, 0.0, 0.0)))
        return mass, at.r, at.A @ tensor @ at.A.T

    def bounded(self, mass: float, inertia: Array) -> tuple[float, Array]:
        """Return mass and inertia raised to the lower bounds of the compiler settings."""
        found = self.settings
        mass = max(mass, found.least_mass)
        if found.least_inertia <= 0.0 and not found.balance:
            return mass, inertia
        values, vectors = np.linalg.eigh(inertia)
        values = np.maximum(values, found.least_inertia)
        if found.balance and values[0] + values[1] < values[2]:
            values = np.full(3, values.mean())
        return mass, np.asarray((vectors * values) @ vectors.T)

    def name(self, element: Element, kind: str) -> str:
        """Return the name of an element, or a new unique one."""
        found = self.found
        found.count[kind] = found.count.get(kind, 0) + 1
        given = element.given.get("name", "").strip()
        name = f"{self.prefix}{given}" if given else f"{kind}{found.count[kind]}"
        while not given and name in found.names:
            name = f"{name}_"
        found.names.add(name)
        return name

    def body(self, element: Element, parent: str, at: Frame, inherited: str) -> None:
        """Read a body with its joints and nested bodies."""
        inherited = element.given.get("childclass", inherited)
        name = self.name(element, "body")
        place = at @ self.places.frame(element)
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
            # the pose in the file is that at the reference coordinates
            origin = (place if k == 0 else Frame()) @ turned_back(joint)
            self.found.joints.append(replace(joint, parent=parent, child=child, origin=origin))
            self.found.links.append(Link(child, where=where))
            parent = child
        if (lifted := self.reading.number(element, "gravcomp", 0.0)) != 0.0:
            self.found.lifted[name] = lifted
        self.contents(element, self.found.links[-1], Frame(), inherited, moving=True)

    def joint(self, element: Element, at: Frame, inherited: str) -> RobotJoint:
        """Return a joint without the names of its links."""
        name, reading = self.name(element, "joint"), self.reading
        where = reading.where(element)
        if element.tag == "freejoint":
            return RobotJoint(name, "floating", "", "", where=where)
        element = self.places.given(element, inherited)
        kind = element.given.get("type", "hinge")
        if kind not in TYPES:
            reading.add(element, f"type is {kind!r}, must be one of {', '.join(TYPES)}")
            kind = "hinge"
        scale = self.settings.angle if kind == "hinge" else 1.0
        values = self.losses(element, name, kind)
        if kind == "free":
            return RobotJoint(name, "floating", "", "", where=where)
        if kind != "ball":
            values["initial"] = reading.number(element, "ref", 0.0) * scale
            values["rest"] = reading.number(element, "springref", 0.0) * scale
        if self.limited(element, "limited", "range") and not {"limit", "constraint"} & (
            self.settings.off
        ):
            text = element.given.get("range")
            low, high = reading.numbers(element, text, "range", 2, None) * scale
            if kind == "ball":
                reading.note(element, "the limit of a ball joint is ignored: it turns beyond it")
            else:
                values["lower"], values["upper"] = low, high
        if self.limited(element, "actuatorfrclimited", "actuatorfrcrange"):
            text = element.given.get("actuatorfrcrange")
            force = reading.numbers(element, text, "actuatorfrcrange", 2, np.zeros(2))
            values["effort"] = float(np.abs(force).max()) or math.inf
            if force[0] != -force[1]:
                reading.effect(element, "actuatorfrcrange", LOPSIDED)
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

    def losses(self, element: Element, name: str, kind: str) -> dict[str, Any]:
        """Return spring, damping, dry friction and rotor of a joint; warn of unsupported ones."""
        reading = self.reading
        values: dict[str, Any] = {"armature": reading.number(element, "armature", 0.0)}
        for key, flag in LOSSES.items():
            text = element.given.get(key, "0")
            terms = reading.list(element, key) if key in element.given else None
            if terms is not None and len(terms) in (2, 3) and key != "frictionloss":
                if terms[1:].any():
                    message = f"{key} is {text!r}; terms of higher order are not read, write one"
                    reading.add(element, f"{message} number, or add a Spring with a table")
                text = repr(float(terms[0]))
            value = float(reading.numbers(element, text, key, 1, np.zeros(1))[0])
            off = flag in self.settings.off or "passive" in self.settings.off
            off = off or (key == "frictionloss" and "constraint" in self.settings.off)
            values[OWN[key]] = 0.0 if off else value
        if "springdamper" in element.given:
            text = element.given["springdamper"]
            time, ratio = reading.numbers(element, text, "springdamper", 2, np.zeros(2))
            if time > 0.0 and ratio > 0.0:
                self.found.springs[name] = (float(time), float(ratio))
        lost = {
            "free": ("armature", "stiffness", "damping", "friction"),
            "ball": ("friction",),
        }.get(kind, ())
        for key in lost:
            if values.pop(key, 0.0) != 0.0:
                word = "frictionloss" if key == "friction" else key
                reading.effect(element, word, f"of a {kind} joint is left out: it moves without it")
        return values if kind != "free" else {}

    def limited(self, element: Element, word: str, span: str) -> bool:
        """Return whether the range of a joint acts as a limit."""
        value = element.given.get(word, "auto")
        if value == "auto":
            return self.settings.limits and span in element.given
        return value == "true"

    # -- other models -----------------------------------------------------------------------

    def attach(self, element: Element, link: Link, at: Frame, inherited: str) -> None:
        """Read an ``<attach>`` of a link: a body or frame of this model or of another file."""
        prefix = element.given.get("prefix", "")
        model, depth = element.given.get("model"), len(self.above)
        tag = "body" if "body" in element.given else "frame"
        wanted = element.given.get(tag)
        self.found.count["attach"] = self.found.count.get("attach", 0) + 1
        if self.found.count["attach"] > MOST_ATTACHED or depth > DEEPEST:
            if self.found.count["attach"] == MOST_ATTACHED + 1:
                self.reading.add(element, f"more than {MOST_ATTACHED} models are attached")
            return
        if model is None:
            self.attach_own(element, link, at, tag, wanted or "", prefix)
            return
        root, path = self.model(element, model)
        if root is None or path is None:
            return
        other = Bodies(
            self.reading,
            root,
            self.folders.at(path.parent),
            self.found,
            draw=self.geoms.draw,
            prefix=self.prefix + prefix,
            above=(*self.above, path),
        )
        self.attached += [other, *other.attached]
        other.fill(element, link, at, tag, wanted)

    def model(self, element: Element, name: str) -> tuple[Element | None, Path | None]:
        """Return the root and the path of a model among the assets; add a problem if there is none.

        The default name of a model is that in its file.
        """
        for own, asset in self.models.items():
            path, why = self.folders.find(asset.given.get("file", ""))
            if path is None or path in self.above:
                if own == name:
                    why = why or "attaches itself in a circle"
                    self.reading.add(asset, f"the file {asset.given.get('file', '')!r} {why}")
                    return None, None
                continue
            if own != name and "name" in asset.given:
                continue
            try:
                root = parse_file(path)
            except InputError as error:
                self.reading.problems += error.problems
                return None, None
            if name in (own, root.given.get("model")):
                return root, path
        known = suggest(name, self.models)
        self.reading.add(element, f"no model {name!r} among the assets{known}")
        return None, None

    def attach_own(
        self, element: Element, link: Link, at: Frame, tag: str, wanted: str, prefix: str
    ) -> None:
        """Read a copy of a body or frame of the same model, with a prefix on its names."""
        found = find_named(self.root, tag, wanted)
        if found is None or any(x is element for x in everything(found[0])):
            why = "does not exist" if found is None else "contains this <attach> itself"
            self.reading.add(element, f"{tag} {wanted!r} {why}")
            return
        copy = with_affixes(found[0], before=prefix)
        self.inside(copy, link, at, found[1])

    def fill(self, element: Element, link: Link, at: Frame, tag: str, wanted: str | None) -> None:
        """Read a body, a frame or all bodies of this model as contents of a link."""
        if wanted is None:
            for section in self.root.all("worldbody"):
                self.inside(replace(section, tag="frame", given={}), link, at, "main")
            return
        found = next(
            (x for s in self.root.all("worldbody") if (x := find_named(s, tag, wanted))), None
        )
        if found is None:
            self.reading.add(element, f"no {tag} {wanted!r} in the attached model")
            return
        self.inside(found[0], link, at, found[1])

    def inside(self, element: Element, link: Link, at: Frame, inherited: str) -> None:
        """Read an element of the model as contents of a link that exists already."""
        inner = [(element, at, inherited)]
        if element.tag == "frame":
            own = element.given.get("childclass", inherited)
            inner = list(self.flat(element, at @ self.places.frame(element), own))
        filled = [x for x in inner if x[0].tag in ("geom", "site")]
        if filled:  # shapes and sites of a frame form a body fixed to the link
            fixed = self.name(Element("body", {}, element.line), "body")
            where = self.reading.where(element)
            self.found.links.append(Link(fixed, where=where))
            self.found.joints.append(
                RobotJoint(f"{fixed} weld", "fixed", link.name, fixed, where=where)
            )
            parts, frames = self.filling(filled, self.found.links[-1], weighed=link.name != "world")
            mass, center, inertia = self.geoms.total(parts)
            shapes = tuple(part.triangles for part in parts)
            self.found.links[-1] = Link(fixed, mass, center, inertia, shapes, frames, where)
        for child, place, kind in inner:
            if child.tag == "body":
                self.body(child, link.name, place, kind)
            elif child.tag == "attach":
                self.attach(child, link, place, kind)


def resistance_of(
    reading: Reading, given: Element, slides: int
) -> tuple[float | None, Resistance | None]:
    """Return friction and resistance of a geom or pair, whose ``friction`` begins with `slides`.

    None where the element has neither ``friction`` nor ``condim``.
    """
    listed = reading.list(given, "friction") if "friction" in given.given else None
    numbers = () if listed is None else tuple(listed)
    friction = float(numbers[0]) if len(numbers) else None
    if friction is None and "condim" not in given.given:
        return None, None
    drilling, rolling = (
        float(numbers[k]) if len(numbers) > k else usual
        for k, usual in ((slides, Resistance.drilling), (slides + 1, Resistance.rolling))
    )
    directions = int(reading.number(given, "condim", 3.0))
    return friction, Resistance(drilling, rolling, directions)
