"""Conversion of --vary and --limit, and checks shared by several commands."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError, Problem, suggest

if TYPE_CHECKING:
    from jousto.design.studies.outcomes.outcome import Outcome
    from jousto.design.studies.outcomes.requirement import Requirement
    from jousto.design.studies.parameters.parameter import Parameter
    from jousto.schema.read import ModelFile

LONG = 300
"""Digits of a number in --vary from which it cannot be a count."""
RANGE = re.compile(r"(.+?)\.\.(.+?)(?:/\s*(\d+))?")
WAYS = ("threads", "processes", "dask")


def problems_of(check: Callable[[], Any]) -> list[Problem]:
    """Return the problems of the InputError that a check raises; empty without an error."""
    try:
        check()
    except InputError as error:
        return list(error.problems)
    return []


def check_choice(option: str, word: str, known: tuple[str, ...]) -> None:
    """Raise InputError for a value that is not one of the choices of an option."""
    if word not in known:
        raise InputError(Problem(option, f"is {word!r}{suggest(word, known)}"))


def check_index(target: float | None) -> None:
    """Raise InputError for an index of reliability that is not positive.

    Raises
    ------
    InputError
        With the option and its value.
    """
    if target is not None and not target > 0.0:
        raise InputError(Problem("--target", f"is {target:g}, must be positive"))


def nothing_varied(known: dict[str, Any]) -> str:
    """Return the message that explains how to name the parameters to vary."""
    if not known:
        return "the model has no parameters; add parameters: {wall: 4 mm} and use ${wall}"
    return f"name the parameters to vary: {', '.join(known)}"


def varied(
    text: str,
    known: dict[str, Parameter],
    axes: dict[str, list[float]],
    option: str = "--vary",
) -> Parameter:
    """Return the parameter of one option such as --vary; grid values are added to `axes`."""
    from jousto.design.studies.parameters.distributions import CALL, read_distribution
    from jousto.design.studies.parameters.samples import check_count

    name, equals, values = (piece.strip() for piece in text.partition("="))
    where = f"{option} {name}"
    if name not in known:
        tail = suggest(name, known) if known else f"; {nothing_varied(known)}"
        raise InputError(Problem(option, f"no parameter {name!r}{tail}"))
    own = known[name]
    if not equals:
        return own
    if CALL.fullmatch(values):
        made = read_distribution(values, own.value, own.exponents, where)
        return replace(own, distribution=made)
    match = RANGE.fullmatch(values)
    if match is None:
        axes[name] = _numbers(values.split(","), own, where)
        return replace(own, bounds=None)
    low, high = _numbers([match[1], match[2]], own, where)
    if not low < high:
        raise InputError(Problem(where, f"{low:g} must be below {high:g}"))
    if match[3] is None:
        value = min(max(own.value, low), high)
        return replace(own, value=value, bounds=(low, high), distribution=None)
    count = int(match[3]) if len(match[3]) < LONG else math.inf
    check_count(where, count)
    if count < 2:
        raise InputError(Problem(where, f"has {count} values, must have 2 or more"))
    axes[name] = [low + (high - low) * k / (count - 1) for k in range(int(count))]
    return replace(own, bounds=None)


def limits_of(given: list[str] | None, file: ModelFile) -> list[Requirement]:
    """Return the limits of --limit, or those of the model file if there are none.

    Raises
    ------
    InputError
        If there are no limits, a text is not a limit, or two limits have the same name.
    """
    from jousto.design.studies.outcomes.outcomes import read_outcome
    from jousto.design.studies.outcomes.requirement import read_requirement
    from jousto.schema.make.blocks.limits import inlined

    if not given:
        if not file.limits:
            message = "none: give --limit 'max(tip.y) <= 12 mm', or limits: [...] in the model file"
            raise InputError(Problem("limits", message))
        return list(file.limits)
    problems: list[Problem] = []
    found: list[Requirement] = []
    for text in given:
        try:
            one = read_requirement(text)
            read_outcome(one.left)
            one = replace(one, bound=inlined(one.bound, file.variants.document.data))
        except InputError as error:
            problems += error.problems
            continue
        if one.name in [other.name for other in found]:
            message = f"{one.name!r} is limited twice; name them: 'a = {one.text}'"
            problems.append(Problem("--limit", message))
        found.append(one)
    if problems:
        raise InputError(problems)
    return found


def read_study(
    limit: list[str] | None,
    vary: list[str] | None,
    file: ModelFile,
    wanted: tuple[str, ...],
    checks: Iterable[Callable[[], object]],
) -> tuple[list[Requirement], list[Parameter]]:
    """Return the limits and the parameters of the options.

    Raises
    ------
    InputError
        With all problems of the checks, the limits and the parameters.
    """
    problems = [problem for check in checks for problem in problems_of(check)]
    limits: list[Requirement] = []
    parameters: list[Parameter] = []
    try:
        limits = limits_of(limit, file)
    except InputError as error:
        problems += error.problems
    try:
        parameters = parameters_of(vary, file, *wanted)
    except InputError as error:
        problems += error.problems
    if problems:
        raise InputError(problems)
    return limits, parameters


def outcomes_of(limits: Sequence[Requirement]) -> list[Outcome]:
    """Return the outcomes of limits, each once."""
    found = {one.outcome.name: one.outcome for one in limits}
    return list(found.values())


def parameters_of(given: list[str] | None, file: ModelFile, *wanted: str) -> list[Parameter]:
    """Return the parameters of a file, replaced or extended by those of --vary.

    Parameters
    ----------
    given : list of str
        Options ``--vary``.
    file : ModelFile
    *wanted : {"bounds", "distribution"}
        What an option must give: one of these, and each for at least one parameter. If both are
        allowed, new bounds keep the distribution of a parameter, and a new distribution its bounds.

    Raises
    ------
    InputError
        If an option gives something else.
    """
    known = {p.name: p for p in file.parameters}
    chosen = dict(known)
    problems: list[Problem] = []
    such = {"bounds": "bounds such as 2..8mm", "distribution": "normal(sd=0.1 mm)"}
    for text in given or ():
        axes: dict[str, list[float]] = {}
        try:
            one = varied(text, chosen, axes)
        except InputError as error:
            problems += error.problems
            continue
        if axes or not any(getattr(one, what) is not None for what in wanted):
            ways = " or ".join(such[what] for what in wanted)
            message = f"has no {' or '.join(wanted)}: give {ways}"
            problems.append(Problem(f"--vary {one.name}", message))
        if len(wanted) > 1 and one.distribution is None:
            one = replace(one, distribution=chosen[one.name].distribution)
        chosen[one.name] = one
    if problems:
        raise InputError(problems)
    for what in wanted:
        if not any(getattr(p, what) is not None for p in chosen.values()):
            message = f"no parameter has {what}; {nothing_varied(known)}"
            problems.append(Problem("--vary", message))
    if problems:
        raise InputError(problems)
    return list(chosen.values())


def _numbers(texts: list[str], parameter: Parameter, where: str) -> list[float]:
    """Return values in SI; values without unit take the unit of the last value."""
    from jousto.base.expressions import NONE, ExpressionError, evaluate

    unit = re.sub(r"^\s*[-+]?[\d._]+(?:[eE][-+]?\d+)?", "", texts[-1]).strip()
    found = []
    for text in texts:
        try:
            quantity = evaluate(text, {})
            if unit and quantity.exponents == NONE:
                quantity = evaluate(f"{text} {unit}", {})
        except ExpressionError as error:
            raise InputError(Problem(where, str(error))) from None
        if quantity.exponents not in (NONE, parameter.exponents):
            raise InputError(Problem(where, f"{quantity.said} must be in {parameter.unit}"))
        found.append(quantity.value)
    return found
