"""Validation of a model file that keeps the valid entries if others are invalid."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pydantic import ValidationError

from jousto.base.errors import Problem
from jousto.schema.entries.model import ModelEntry
from jousto.schema.file.document import Document, Loc
from jousto.schema.file.error_messages import explain
from jousto.schema.make.model import LISTS


@dataclass(frozen=True, eq=False)
class Valid:
    """Valid entries of a document, and the problems of the invalid ones.

    Parameters
    ----------
    entry : ModelEntry or None
        The file without its invalid entries; None if that cannot be read either.
    index : dict
        For each list, the indices in the file of the remaining entries.
    problems : list of (path, Problem)
        Problems of the invalid entries.
    broken : list of (section, name)
        Names of the excluded entries; None if any name may be missing.
    rest : list of (path, class)
        The excluded entries of lists, and the class that each declares.
    """

    entry: ModelEntry | None
    index: dict[str, list[int]]
    problems: list[tuple[Loc, Problem]] = field(default_factory=list)
    broken: list[Any] = field(default_factory=list)
    rest: list[tuple[Loc, Any]] = field(default_factory=list)


def validate(document: Document) -> Valid:
    """Return the valid entries of a document."""
    data = document.data
    if "robots" in data:  # robots add bodies
        data = {"bodies": [], **data}
    lists = {key: data[key] for key in LISTS if isinstance(data.get(key), list)}
    index = {key: list(range(len(lists.get(key, ())))) for key in LISTS}
    classes: dict[int, Any] = {}
    try:
        return Valid(ModelEntry.model_validate(data, context=classes), index)
    except ValidationError as error:
        problems = explain(error, document, classes)
    # leave out invalid entries, so that references and the rest can still be checked
    rest: dict[str, Any] = dict(data)
    broken: list[Any] = []
    left: list[tuple[Loc, Any]] = []
    for path in {loc[:2] for loc, _ in problems if loc}:
        key: Any = path[0]
        place: Any = path[1] if len(path) > 1 else None
        if key == "parts" and place is not None:
            broken.append((key, place))
            rest[key] = {k: v for k, v in rest[key].items() if k != place}
        elif key in lists and place is not None:
            item = data[key][place]
            name = item.get("name") if isinstance(item, dict) else None
            broken.append((key, name if isinstance(name, str) else None))
            index[key] = [i for i in index[key] if i != place]
            if (of := classes.get(id(item))) is not None:
                left.append(((key, place), of))
        else:
            # names that the invalid section would have defined
            broken.append((key, None))
            index[key] = []
            rest.pop(key, None)
    for key, items in lists.items():
        if key in rest:
            rest[key] = [items[i] for i in index[key]]
    if "bodies" not in rest:
        rest["bodies"] = []
        broken.append(("bodies", None))
    try:
        entry = ModelEntry.model_validate(rest, context=classes)
    except ValidationError:
        entry = None
    return Valid(entry, index, problems, broken, left)
