"""Messages for pydantic's errors: file, line, field, value found, and remedy."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import ValidationError

from jousto.base.errors import InputError, JoustoWarning, Problem, suggest
from jousto.base.units import describe
from jousto.schema.file.document import Document, Loc


def explain(
    error: ValidationError, document: Document, classes: Mapping[int, Any], prefix: Loc = ()
) -> list[tuple[Loc, Problem]]:
    """Return the problems of a validation error with their paths.

    Parameters
    ----------
    error : ValidationError
        Error of pydantic.
    document : Document
        The data that were validated.
    classes : mapping of int to class
        Class as which each mapping was read, by the id of the mapping.
    prefix : tuple
        Path of the validated data in the document.
    """
    found: list[tuple[Loc, Problem]] = []
    for raw in error.errors(include_url=False):
        item: Any = {**raw, "loc": (*prefix, *raw["loc"])}
        loc, message = sentence(item, document, classes)
        problem = Problem(document.where(loc), document.told(loc, message))
        if (loc, problem) not in found:
            found.append((loc, problem))
    return found


def data_path(loc: Loc, document: Document, keep_last: bool) -> Loc:
    """Return the path in the data, without the tags that pydantic adds for unions."""
    path: Loc = ()
    value: Any = document.data
    tag: Any = None
    for i, key in enumerate(loc):
        # a tag may also be a key, as in {type: rack, rack: slide.displacement}
        if isinstance(value, dict) and key == value.get("type") and tag is not value:
            tag = value
            continue
        if isinstance(value, dict) and key in value:
            value = value[str(key)]
        elif isinstance(value, list) and isinstance(key, int) and key < len(value):
            value = value[key]
        elif not (keep_last and i == len(loc) - 1):
            continue
        path = (*path, key)
    return path


def sentence(item: Any, document: Document, classes: Mapping[int, Any]) -> tuple[Loc, str]:
    """Return the path and the message of one of pydantic's errors."""
    kind, context = item["type"], item.get("ctx", {})
    missing, extra = kind == "missing", kind == "extra_forbidden"
    loc = data_path(item["loc"], document, keep_last=missing or extra)
    if item["loc"] and item["loc"][-1] == "[key]":
        loc = data_path(item["loc"][:-1], document, keep_last=False)
        return loc, f"the name {item['msg']}"
    value = document.at(loc)
    if missing:
        return loc[:-1], f"{str(loc[-1])!r} is missing"
    if extra:
        cls = classes.get(id(document.at(loc[:-1])))
        known = [] if cls is None else cls.keys()
        unused = [k for k in known if k not in document.at(loc[:-1])]
        return loc, f"unknown key {str(loc[-1])!r}{suggest(str(loc[-1]), unused or known)}"
    if kind == "union_tag_not_found":
        if not isinstance(value, dict):
            return loc, f"expects a mapping with a type, got {describe(value)}"
        return loc, missing_type(loc)
    if kind == "union_tag_invalid":
        known = re.findall(r"'([^']*)'", str(context.get("expected_tags", "")))
        if "type" not in (value if isinstance(value, dict) else {}):
            return loc, f"expects {' or '.join(forms(known))}, got {describe(value)}"
        tag = str(context.get("tag", ""))
        return (*loc, "type"), f"no {what(loc)} type {tag!r}{suggest(tag, known)}"
    if kind == "literal_error":
        known = re.findall(r"'([^']*)'", str(context.get("expected", "")))
        return loc, f"no {loc[-1]} {describe(value)}{suggest(str(value), known)}"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return loc, f"expects a mapping (key: value), got {describe(value)}"
    if kind in ("tuple_type", "list_type"):
        return loc, f"expects a list, got {describe(value)}"
    message = str(item["msg"])
    return loc, message[:1].lower() + message[1:] if kind != "jousto" else message


SINGULAR = {
    "parts": "part",
    "bodies": "body",
    "joints": "joint",
    "couplings": "coupling",
    "coordinates": "coordinate",
    "terms": "signal",
    "factors": "signal",
    "forces": "force",
    "frictions": "friction",
    "initial": "initial",
    "sensors": "sensor",
    "events": "event",
    "fmus": "fmu",
    "states": "block",
    "robots": "robot",
    "elastic_joints": "elastic joint",
    "sections": "section",
    "reduce": "reduction",
}


def what(loc: Loc) -> str:
    """Return the noun for an entry in messages, from the last key of its path."""
    words = [key for key in loc if isinstance(key, str)]
    if len(loc) == 2 and loc[0] == "parts":
        return "part"
    return SINGULAR.get(words[-1], words[-1]) if words else "part"


def missing_type(loc: Loc) -> str:
    """Return the message for an entry without the key ``type``."""
    if loc and loc[0] == "bodies":
        return (
            "give part: NAME for a flexible body, mass and inertia for a rigid one, or points and "
            "section for an exact beam"
        )
    return f"'type' of the {what(loc)} is missing"


def forms(tags: list[str]) -> list[str]:
    """Return a text that lists the forms that a value may have."""
    words = {"mapping": "a mapping", "list": "a list", "scalar": "a single value"}
    return [words.get(tag, tag) for tag in tags]


def finish(document: Document, found: list[tuple[Loc, Problem]], messages: Iterable[str]) -> None:
    """Issue the warnings, then raise the problems in the order of the file."""
    for message in messages:
        warnings.warn(JoustoWarning(message), stacklevel=4)
    if found:
        found = sorted(found, key=lambda pair: document.line(pair[0]))
        raise InputError([problem for _, problem in found])
