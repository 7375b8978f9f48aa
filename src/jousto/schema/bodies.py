"""Parts of the flexible bodies of a model file, without their modes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.parts.part import Part
from jousto.schema.entries.parts import ReducedEntry
from jousto.schema.file.document import Document
from jousto.schema.file.error_messages import finish
from jousto.schema.file.parameters import expand
from jousto.schema.make.matrices import is_superelement
from jousto.schema.make.model import ModelBuilder
from jousto.schema.partial_validation import validate


def parts_of(document: Document, values: Mapping[str, float], trust: bool) -> dict[str, Part]:
    """Return the Part of each flexible body that has a mesh, by body name.

    Parameters
    ----------
    document : Document
        A model file.
    values : dict of float
        Values of its parameters.
    trust : bool
        As in `read_model`.

    Raises
    ------
    InputError
        With all problems of these values and their lines.
    """
    document = expand(document, values).document
    valid = validate(document)
    entry = valid.entry
    builder = ModelBuilder(document, valid.broken, trust=trust)
    made: dict[str, Any] = {}
    found: dict[str, Part] = {}
    entries = {} if entry is None or entry.parts is None else entry.parts
    for body in () if entry is None else entry.bodies:
        name: Any = getattr(body, "part", None)
        part = entries.get(name)
        if part is None or isinstance(part, ReducedEntry) or is_superelement(part):
            continue
        if name not in made:
            made[name] = builder.part(("parts", name), name, part)
        found[body.name] = made[name]
    finish(document, [*valid.problems, *builder.found], [])
    return found
