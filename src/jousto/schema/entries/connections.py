"""Types of joints, forces and events in model files."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, Discriminator, Tag
from pydantic_core import core_schema

from jousto.base.units import describe
from jousto.schema.entries.base import (
    Amount,
    Components,
    Force3,
    Text,
    Vector,
    fail,
)
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import FORMS, NOTED, array, one_of
from jousto.schema.entries.signals import CurveEntry

# -- coordinates ----------------------------------------------------------------------------


class _CoordinateText:
    """Annotation of ``joint.coordinate``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Check for a dot with a name on both sides."""

        def check(value: Any) -> str:
            joint, dot, name = value.rpartition(".") if isinstance(value, str) else ("", "", "")
            if not (dot and joint.strip() and name.strip()):
                raise fail(
                    "expects a coordinate such as hinge.angle, slide.displacement or "
                    f"{{type: distance, a: arm.tip, b: ground.origin}}, got {describe(value)}"
                )
            return str(value)

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a string with a dot."""
        return {"type": "string", "pattern": r"^.+\.[^.]+$", "description": "joint.coordinate"}


CoordinateForm: Any = one_of("coordinates", "jousto.mechanism.joints")
CoordinateEntry: TypeAlias = Annotated[
    Annotated[str, _CoordinateText(), Tag("scalar")] | Annotated[CoordinateForm, Tag("mapping")],
    Discriminator(lambda v: "mapping" if isinstance(v, dict | BaseModel) else "scalar"),
]

# -- forces and events ----------------------------------------------------------------------

Six: TypeAlias = Annotated[
    tuple[Amount, Amount, Amount, Amount, Amount, Amount],
    Vector(6),
]
SixOrMatrix: TypeAlias = Annotated[
    Annotated[Six, Tag("scalar")]
    | Annotated[Annotated[tuple[Six, Six, Six, Six, Six, Six], Vector(6)], Tag("list")],
    Discriminator(lambda v: "list" if v and isinstance(v[0], list | tuple) else "scalar"),
]
Pattern: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")]
    | Annotated[tuple[Force3, ...], Tag("list")]
    | Annotated[dict[Text, Force3], Tag("mapping")],
    by_form(),
]


WatchedEntry: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[CoordinateForm, Tag("mapping")], by_form()
]


class _Function:
    """Annotation of ``module:function`` or ``file.py:function``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Check for a colon with a name on both sides."""

        def check(value: Any) -> str:
            place, colon, name = value.rpartition(":") if isinstance(value, str) else ("", "", "")
            if not (colon and place.strip() and name.isidentifier()):
                raise fail(
                    "expects module:function or file.py:function such as wind.py:drag, "
                    f"got {describe(value)}"
                )
            return str(value)

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a string with a colon."""
        return {"type": "string", "pattern": r"^.+:[^:]+$", "description": "module:function"}


def depth(value: Any) -> int:
    """Return the nesting depth of lists."""
    return 1 + depth(value[0]) if value and isinstance(value, list | tuple) else 0


def shapes(unit: str, known: tuple[tuple[int | None, ...], ...]) -> Any:
    """Return the type of an array with one of several shapes."""
    tags = [f"{len(shape)}" for shape in known]
    each = [NOTED[array(unit, shape), Tag(tag)] for shape, tag in zip(known, tags, strict=True)]
    least, most = len(known[0]), len(known[-1])
    choice = Discriminator(lambda v: f"{min(max(depth(v), least), most)}")
    return NOTED[reduce(or_, each), choice] if len(each) > 1 else array(unit, known[0])


FORMS.update(
    {
        "coordinate": lambda field: CoordinateEntry,
        "coordinates": lambda field: tuple[CoordinateEntry, ...],
        "curve": lambda field: CurveEntry,
        "matrix6": lambda field: SixOrMatrix,
        "wrench": lambda field: Six,
        "shapes": lambda field: shapes(field.unit, field.shapes),
        "pattern": lambda field: Pattern,
        "function": lambda field: Annotated[str, _Function()],
        "watched": lambda field: WatchedEntry,
        "component": lambda field: Components,
        "threshold": lambda field: Amount,
    }
)
