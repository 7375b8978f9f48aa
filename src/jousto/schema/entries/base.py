"""Building blocks of the model file: numbers with units, vectors, markers, tagged entries."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, ClassVar, TypeAlias

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError, core_schema

from jousto.base.units import KINDS, UnitError, describe, quantity


class Entry(BaseModel):
    """Mapping in a model file; unknown keys are errors, missing keys take Python's defaults."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, protected_namespaces=(), defer_build=True
    )

    declared: ClassVar[Any] = None
    """Declared class from whose fields the entry is made."""

    @model_validator(mode="before")
    @classmethod
    def _note_class(cls, data: Any, info: Any) -> Any:
        # for messages that list the known keys of this class
        if isinstance(info.context, dict) and isinstance(data, dict):
            info.context.setdefault(id(data), cls)
        return data

    @classmethod
    def keys(cls) -> list[str]:
        """Return the keys that the mapping accepts."""
        return [key for key, field in cls.model_fields.items() if field.alias is None]

    def given(self, *leave_out: str) -> dict[str, Any]:
        """Return the given values by field, without defaults."""
        known, given, left = vars(self), self.model_fields_set, ("type", *leave_out)
        return {
            key: value
            for key, value in known.items()  # in the order of the fields
            if value is not None and key in given and key not in left
        }


def fail(message: str) -> PydanticCustomError:
    """Return a validation error with a message that is shown unchanged."""
    return PydanticCustomError("jousto", "{message}", {"message": message})


class Unit:
    """Annotation of a number or a text with unit, validated to a float in SI."""

    def __init__(self, unit: str, *, positive: bool = False) -> None:
        self.unit = unit
        self.positive = positive

    def _validate(self, value: Any) -> float:
        try:
            number = quantity(value, self.unit)
        except UnitError as error:
            raise fail(str(error)) from None
        if self.positive and number <= 0:
            raise fail(f"is {number:g} {self.unit}, must be positive")
        return number

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Convert the number or text to SI by `quantity`."""
        return core_schema.no_info_plain_validator_function(self._validate)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a number or a string."""
        text = KINDS.get(self.unit, "a number")
        text = text[0].upper() + text[1:]
        if self.unit != "1":
            text += f"; a number is in {self.unit}, a string may have another unit"
        return {"type": ["number", "string"], "description": text}


class _Amount:
    """Annotation of a number or a text whose unit is checked by the field that uses it."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Keep strings as they are."""

        def check(value: Any) -> float | str:
            if isinstance(value, str):
                return value
            try:
                return quantity(value, "1")
            except UnitError as error:
                raise fail(str(error)) from None

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a number or a string."""
        return {
            "type": ["number", "string"],
            "description": "A number in SI, or a string with a unit of what the value is used for",
        }


Amount: TypeAlias = Annotated[float | str, _Amount()]


class Vector:
    """Annotation of a tuple given as a list of fixed length."""

    def __init__(self, length: int) -> None:
        self.length = length

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Check the length before the entries."""

        def check(value: Any) -> Any:
            if not isinstance(value, list | tuple) or len(value) != self.length:
                raise fail(f"expects a list of {self.length} numbers, got {describe(value)}")
            return value

        return core_schema.no_info_before_validator_function(check, handler(source))


Length: TypeAlias = Annotated[float, Unit("m")]
Mass: TypeAlias = Annotated[float, Unit("kg")]
Time: TypeAlias = Annotated[float, Unit("s")]
Duration: TypeAlias = Annotated[float, Unit("s", positive=True)]
Angle: TypeAlias = Annotated[float, Unit("rad")]
Number: TypeAlias = Annotated[float, Unit("1")]
Velocity: TypeAlias = Annotated[float, Unit("m/s")]
AngularVelocity: TypeAlias = Annotated[float, Unit("rad/s")]
Acceleration: TypeAlias = Annotated[float, Unit("m/s2")]
ForceN: TypeAlias = Annotated[float, Unit("N")]
TorqueNm: TypeAlias = Annotated[float, Unit("N m")]
Pressure: TypeAlias = Annotated[float, Unit("Pa")]
Density: TypeAlias = Annotated[float, Unit("kg/m3")]
Area: TypeAlias = Annotated[float, Unit("m2")]
Inertia: TypeAlias = Annotated[float, Unit("kg m2")]
Frequency: TypeAlias = Annotated[float, Unit("Hz")]
Rate: TypeAlias = Annotated[float, Unit("1/s")]

Position: TypeAlias = Annotated[tuple[Length, Length, Length], Vector(3)]
Velocity3: TypeAlias = Annotated[tuple[Velocity, Velocity, Velocity], Vector(3)]
AngularVelocity3: TypeAlias = Annotated[
    tuple[AngularVelocity, AngularVelocity, AngularVelocity], Vector(3)
]
Acceleration3: TypeAlias = Annotated[tuple[Acceleration, Acceleration, Acceleration], Vector(3)]
Force3: TypeAlias = Annotated[tuple[ForceN, ForceN, ForceN], Vector(3)]
Direction: TypeAlias = Annotated[tuple[Number, Number, Number], Vector(3)]


EXPRESSION = r"^\$\{.*\}$"  # pattern in JSON schemas; expressions are evaluated before validation
LARGEST = 2**53  # largest whole number that floats represent exactly


class _Integer:
    """Annotation of a whole number; true and false are errors."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Accept integers and floats without a fraction."""

        def check(value: Any) -> int:
            whole = isinstance(value, int) or (isinstance(value, float) and value.is_integer())
            if isinstance(value, bool) or not whole:
                raise fail(f"expects a whole number, got {describe(value)}")
            if abs(value) >= LARGEST:
                raise fail(f"expects a whole number below 2^53, got {value:.3g}")
            return int(value)

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as an integer or an expression whose value is one."""
        return {"type": ["integer", "string"], "pattern": EXPRESSION}


class _Flag:
    """Annotation of true or false, including the words yes, no, on and off of YAML 1.1."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Accept booleans and the words yes, no, on and off."""

        def check(value: Any) -> bool:
            if isinstance(value, bool):
                return value
            word = value.lower() if isinstance(value, str) else None
            if word in ("yes", "on", "true", "no", "off", "false"):
                return word in ("yes", "on", "true")
            raise fail(f"expects true or false, got {describe(value)}")

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a boolean."""
        return {"type": "boolean"}


class _Text:
    """Annotation of a word; numbers must be quoted, since 1.10 would become 1.1."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Accept strings that are not empty."""

        def check(value: Any) -> str:
            if isinstance(value, bool | int | float):
                raise fail(f"expects text, got {describe(value)}; put it in quotes")
            if not isinstance(value, str):
                raise fail(f"expects text, got {describe(value)}")
            if not value.strip():
                raise fail("is empty")
            return value

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a string."""
        return {"type": "string", "minLength": 1}


Count: TypeAlias = Annotated[int, _Integer()]
Flag: TypeAlias = Annotated[bool, _Flag()]
Text: TypeAlias = Annotated[str, _Text()]
# index from 0, or name
Component: TypeAlias = Annotated[
    Annotated[int, _Integer(), Tag("number")] | Annotated[str, _Text(), Tag("text")],
    Discriminator(lambda v: "text" if isinstance(v, str) else "number"),
]
# one of them, or those whose size counts
Components: TypeAlias = Annotated[
    Annotated[Component, Tag("one")] | Annotated[tuple[Component, ...], Tag("list")],
    Discriminator(lambda v: "list" if isinstance(v, list | tuple) else "one"),
]


InertiaRow: TypeAlias = Annotated[tuple[Inertia, Inertia, Inertia], Vector(3)]
InertiaPart: TypeAlias = Annotated[
    Annotated[Inertia, Tag("scalar")] | Annotated[InertiaRow, Tag("list")],
    Discriminator(lambda v: "list" if isinstance(v, list | tuple) else "scalar"),
]
InertiaTensor: TypeAlias = Annotated[tuple[InertiaPart, InertiaPart, InertiaPart], Vector(3)]


# -- orientations and markers ---------------------------------------------------------------


class _Degrees:
    """Annotation of an angle in degrees, or a string with a unit."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Convert to degrees; values in degrees keep their digits."""

        def check(value: Any) -> float:
            text = f"{value}" if isinstance(value, str) else ""
            plain = re.fullmatch(r"([-+.\deE]+)\s*(?:deg|°)?", text.strip())
            try:
                if plain or not text:
                    return quantity(plain.group(1) if plain else value, "1")
                return math.degrees(quantity(value, "rad"))
            except UnitError as error:
                raise fail(str(error)) from None

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a number or a string."""
        text = "An angle; a number is in degrees, a string may have another unit"
        return {"type": ["number", "string"], "description": text}


_Angle: TypeAlias = Annotated[float, _Degrees()]


class RotateEntry(Entry):
    """Rotation about an axis, `Rotate(axis, degrees=angle_deg)`."""

    axis: Direction = Field(description="Direction of the axis")
    angle_deg: _Angle


class EulerEntry(Entry):
    """Euler angles in a convention, `Rotate.euler(convention, degrees=euler_deg)`."""

    euler_deg: Annotated[tuple[_Angle, _Angle, _Angle], Vector(3)]
    convention: Text = Field(
        description="Axes of the angles: ZXZ about the turned axes, zxz about those of the world"
    )


def _form(value: Any) -> str:
    """Return the name of the form in which an orientation is written."""
    if isinstance(value, EulerEntry) or isinstance(value, dict) and "euler_deg" in value:
        return "euler"
    return "rotate" if isinstance(value, dict | RotateEntry) else "numbers"


class _Orientation:
    """Annotation of an orientation: Euler parameters, matrix, axis and angle, or Euler angles."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Validate mappings by `RotateEntry` and `EulerEntry`, and lists as numbers."""
        rotate, euler = handler(RotateEntry), handler(EulerEntry)

        def numbers(value: Any) -> Any:
            try:
                if isinstance(value, list) and len(value) == 4:
                    return tuple(quantity(x, "1") for x in value)
                if isinstance(value, list) and len(value) == 3:
                    rows = [row if isinstance(row, list) else [] for row in value]
                    if all(len(row) == 3 for row in rows):
                        return tuple(tuple(quantity(x, "1") for x in row) for row in rows)
            except UnitError as error:
                raise fail(str(error)) from None
            raise fail(
                "expects {axis: [x, y, z], angle_deg: ...}, four Euler parameters (scalar first), "
                "the three rows of a rotation matrix or {euler_deg: [a, b, c], convention: ZXZ}, "
                f"got {describe(value)}"
            )

        return core_schema.tagged_union_schema(
            {
                "rotate": rotate,
                "euler": euler,
                "numbers": core_schema.no_info_plain_validator_function(numbers),
            },
            discriminator=_form,
        )

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe the four forms of an orientation in the JSON schema."""
        numbers = {"type": ["number", "string"], "pattern": EXPRESSION}
        row = {"type": "array", "items": numbers, "minItems": 3, "maxItems": 3}
        return {
            "anyOf": [
                handler(schema["choices"]["rotate"]),
                handler(schema["choices"]["euler"]),
                {"type": "array", "items": numbers, "minItems": 4, "maxItems": 4},
                {"type": "array", "items": row, "minItems": 3, "maxItems": 3},
            ]
        }


Orientation: TypeAlias = Annotated[Any, _Orientation()]


class MarkerEntry(Entry):
    """A marker with its own axes, or at a position of the ground or a body."""

    body: Text = Field(description="Name of the body, or ground")
    point: Text | None = Field(None, description="Name of the point")
    at: Position | None = Field(None, description="Position in the body frame, instead of a point")
    axes: Orientation | None = Field(None, description="Axes relative to the body frame")

    @model_validator(mode="after")
    def _one_place(self) -> MarkerEntry:
        if (self.point is None) == (self.at is None):
            raise fail("give either point: NAME or at: [x, y, z]")
        return self


class _MarkerText:
    """Annotation of ``body.point``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Split the text at its first dot into body and point."""

        def check(value: Any) -> str:
            body, dot, point = value.partition(".") if isinstance(value, str) else ("", "", "")
            if not (dot and body.strip() and point.strip()):
                raise fail(f"expects a marker such as arm.tip or ground.origin, got {value!r}")
            return str(value)

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a string with a dot."""
        return {"type": "string", "pattern": r"^[^.]+\..+$", "description": "body.point"}


Marker: TypeAlias = Annotated[
    Annotated[str, _MarkerText(), Tag("text")] | Annotated[MarkerEntry, Tag("mapping")],
    Discriminator(lambda v: "mapping" if isinstance(v, dict | MarkerEntry) else "text"),
]
