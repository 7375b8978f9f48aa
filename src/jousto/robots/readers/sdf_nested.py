"""Flattening of nested models of SDF files, with scoped names as in SDF."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from jousto.robots.readers.xml import Element

NAMED = ("link", "joint", "frame")


def flatten_model(model: Element, old: bool) -> Element:
    """Return a model with the elements of its nested models, named ``model::link``.

    A nested model becomes a frame of its name, and poses of its elements become relative to this
    frame. With `old`, axes without a frame are in the axes of the model.
    """
    children: list[Element] = []
    for child in model.children:
        if child.tag != "model":
            children.append(child)
            continue
        name, inner = child.given.get("name", ""), flatten_model(child, old)
        pose = [x for x in inner.children if x.tag == "pose"]
        children.append(replace(child, tag="frame", given={"name": name}, children=pose))
        for element in inner.children:
            if element.tag in NAMED:
                children.append(_scoped(element, name, old))
    return replace(model, children=children)


def _scoped(element: Element, model: str, old: bool) -> Element:
    """Return a link, joint or frame of a nested model as an element of the enclosing model."""

    def scoped(name: str) -> str:
        if name in ("", "world"):
            return name
        return model if name == "__model__" else f"{model}::{name}"

    attached = scoped(element.given.get("attached_to", ""))
    given = element.given | {"name": scoped(element.given.get("name", ""))}
    given |= {"attached_to": attached} if attached else {}
    children = [_inside(child, scoped) for child in element.children]
    placed = [child for child in children if child.tag == "pose"]
    if (
        element.tag != "joint"
        and not attached
        and not any("relative_to" in pose.given for pose in placed)
    ):
        first = placed[0] if placed else Element("pose", {}, element.line, file=element.file)
        children = [child for child in children if child is not first]
        children.insert(0, replace(first, given=first.given | {"relative_to": model}))
    if element.tag == "joint":
        children = [_axis(child, model, old) for child in children]
    return replace(element, given=given, children=children)


def _inside(element: Element, scoped: Callable[[str], str]) -> Element:
    """Return an element inside a link or joint with the names of the enclosing model."""
    given = dict(element.given)
    for key in ("relative_to", "expressed_in"):
        if given.get(key):
            given[key] = scoped(given[key])
    if element.tag == "mimic":
        given["joint"] = scoped(given.get("joint", ""))
    text = element.text
    if element.tag in ("parent", "child", "gearbox_reference_body"):
        text = scoped(text.strip())
    inner = [_inside(child, scoped) for child in element.children]
    return replace(element, given=given, text=text, children=inner)


def _axis(element: Element, model: str, old: bool) -> Element:
    """Return an axis; a reference to the model frame becomes one to the nested model."""
    if element.tag not in ("axis", "axis2"):
        return element
    flag = element.first("use_parent_model_frame")
    if not old and (flag is None or flag.text.strip() not in ("true", "1")):
        return element
    children = [
        replace(
            child, given=child.given | {"expressed_in": child.given.get("expressed_in") or model}
        )
        if child.tag == "xyz"
        else child
        for child in element.children
        if child is not flag
    ]
    return replace(element, children=children)
