"""Limits of outcomes in the model file, and the settings of their reliability."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError, suggest
from jousto.base.expressions import Quantity
from jousto.base.object_repr import described
from jousto.design.studies.parameters.parameter import Parameter
from jousto.schema.entries.blocks.limits import ReliabilityEntry
from jousto.schema.file.hidden_signs import EXPRESSION
from jousto.schema.make.builder import Builder

if TYPE_CHECKING:
    from jousto.design.studies.outcomes.requirement import Requirement

SECTION = "limits"
NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")


@described
@dataclass(frozen=True, eq=False)
class Reliability:
    """Settings of a model file for the reliability of its limits.

    Attributes
    ----------
    target : float or None
        Target reliability index of the limits.
    correlation : dict of (str, str) to float
        Correlation of pairs of parameters.
    """

    target: float | None = None
    correlation: Mapping[tuple[str, str], float] = field(default_factory=dict)


def inlined(text: str, data: Mapping[str, Any]) -> str:
    """Return a bound in which derived parameters are replaced by their expressions."""
    section = data.get("parameters")
    section = section if isinstance(section, dict) else {}
    derived = {
        name: match[1]
        for name, entry in section.items()
        if isinstance(entry, str) and (match := EXPRESSION.fullmatch(entry.strip()))
    }
    for _ in derived:
        text = NAME.sub(lambda m: f"({derived[m[0]]})" if m[0] in derived else m[0], text)
    return text


def build_limits(
    builder: Builder,
    texts: tuple[str, ...],
    parameters: tuple[Parameter, ...],
    data: Mapping[str, Any],
) -> tuple[Requirement, ...]:
    """Return the limits of a model; problems are added to the builder.

    Parameters
    ----------
    builder : Builder
        Builder that collects problems with their lines.
    texts : tuple of str
        Texts of the file.
    parameters : tuple of Parameter
        Parameters that may be varied.
    data : dict
        The file with its expressions.
    """
    if not texts:
        return ()
    # local import: outcomes import many modules
    from jousto.design.studies.outcomes.outcomes import read_outcome
    from jousto.design.studies.outcomes.requirement import read_requirement

    known = {p.name: Quantity(p.value, p.exponents) for p in parameters}
    found: list[Requirement] = []
    for i, text in enumerate(texts):
        try:
            one = read_requirement(text)
            one = replace(one, bound=inlined(one.bound, data))
            read_outcome(one.left)
            one.value(known)
        except InputError as error:
            for problem in error.problems:
                builder.note((SECTION, i), problem.sentence)
            continue
        if one.name in [other.name for other in found]:
            builder.note((SECTION, i), f"{one.name!r} is limited twice; name them: 'a = ...'")
        found.append(one)
    return tuple(found)


def build_reliability(
    builder: Builder, entry: ReliabilityEntry, parameters: tuple[Parameter, ...]
) -> Reliability:
    """Return the reliability settings of a model; problems are added to the builder."""
    if entry.target is not None and not entry.target > 0.0:
        builder.note(("reliability", "target"), f"is {entry.target:g}, must be positive")
    scattered = [p.name for p in parameters if p.distribution is not None]
    pairs: dict[tuple[str, str], float] = {}
    for i, one in enumerate(entry.correlations or ()):
        loc = ("reliability", "correlations", i)
        for name in one.of:
            if name not in scattered:
                tail = suggest(name, scattered)
                builder.note((*loc, "of"), f"no parameter {name!r} with a distribution{tail}")
        if one.of[0] == one.of[1]:
            builder.note((*loc, "of"), "names two different parameters")
        if not -1.0 < one.value < 1.0:
            builder.note((*loc, "value"), f"is {one.value:g}, must be between -1 and 1")
        pairs[one.of] = one.value
    return Reliability(entry.target, pairs)


def mentioned(document: Any) -> set[str]:
    """Return all names in the bounds of a document."""
    texts = document.data.get(SECTION)
    several = texts if isinstance(texts, list) else []
    return {name for text in several if isinstance(text, str) for name in NAME.findall(text)}
