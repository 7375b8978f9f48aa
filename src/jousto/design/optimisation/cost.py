"""Cost of a design from a model file: mass, another outcome without a run, or a formula."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from jousto.base.errors import InputError, Problem as Trouble
from jousto.base.expressions import ExpressionError, Quantity, evaluate
from jousto.design.studies.outcomes.outcome import Outcome
from jousto.design.studies.outcomes.outcomes import Mass, read_outcome
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.study import study
from jousto.parts.part import Part

Price = Callable[[Mapping[str, float], Mapping[str, Part]], float]


def read_price(text: str, file: Any, every: Sequence[Parameter]) -> Price:
    """Return the cost function (parameter values, parts) that a text describes.

    Raises
    ------
    InputError
        If the cost needs a run, is unknown, or is the same for all designs.
    """
    where = f"cost {text!r}"
    kinds = {p.name: p.exponents for p in every}
    outcome: Outcome | None = None
    try:
        outcome = read_outcome(text)
    except InputError:
        known = {p.name: Quantity(p.value, p.exponents) for p in every}
        used: set[str] = set()
        try:
            evaluate(text, known, used)
        except ExpressionError as error:
            raise InputError(Trouble(where, f"is neither an outcome nor: {error}")) from None
        free = [p.name for p in every if p.bounds is not None]
        if not used.intersection(free):
            message = f"is the same for all designs; name parameters with bounds: {', '.join(free)}"
            raise InputError(Trouble(where, message)) from None

        def arithmetic(values: Mapping[str, float], parts: Mapping[str, Part]) -> float:
            here = {name: Quantity(v, kinds[name]) for name, v in values.items() if name in kinds}
            return evaluate(text, here).value

        return arithmetic
    if outcome.needs_run:
        message = "needs a run at every design; the cost must follow from the dimensions"
        raise InputError(Trouble(where, message))
    wanted = study(file, list(every), outcome, t_end=1.0)
    if isinstance(outcome, Mass):
        body, total = outcome.body, float(wanted(wanted.nominal)[0])
        parts = file.variants.parts({})
        own = [name for name in parts if body in ("", name)]
        rest = total - sum(parts[name].mass for name in own)
        if not _moves(file, own):
            return lambda values, parts: rest + sum(parts[name].mass for name in own)
    return lambda values, parts: float(wanted([[values.get(p.name, p.value) for p in every]])[0, 0])


def _moves(file: Any, own: Sequence[str]) -> bool:
    """Return whether the masses of bodies without a part may depend on parameters."""
    data = file.variants.document.data
    others = [body for body in data.get("bodies", ()) if body.get("name") not in own]
    parts = [data.get("parts", {}).get(body.get("part")) for body in others]
    return "${" in repr((others, parts))
