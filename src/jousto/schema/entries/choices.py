"""Entries of several kinds: choice of the class by the key ``type``, imported on demand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, get_args

from pydantic import BaseModel, Discriminator, Tag
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import PydanticKnownError, SchemaValidator, core_schema

CHOICES = "jousto_choices"  # key in the metadata of a core schema


class Tagged:
    """Annotation of a union of tagged classes; the key ``type`` selects one of them.

    The schema of a class is built when its first entry is read, since a file uses few of the
    classes.

    Parameters
    ----------
    tag : callable, optional
        Returns the type of a mapping without the key ``type``.
    """

    def __init__(self, tag: Callable[[dict[str, Any]], str | None] | None = None) -> None:
        self.tag = tag

    def choose(self, value: Any) -> str | None:
        """Return the tag of a value, None without tag."""
        if isinstance(value, BaseModel):
            return str(getattr(value, "type", ""))
        if not isinstance(value, dict):
            return None
        given = value.get("type")
        if given is None and self.tag is not None:
            given = self.tag(value)
        return None if given is None else str(given)

    def known(self, source: Any) -> Callable[[], Mapping[str, Any]]:
        """Return the lookup of the union's classes by tag."""
        classes = {_tag(item): get_args(item)[0] for item in get_args(source)}
        return lambda: classes

    def entry(self, kind: Any) -> type[BaseModel]:
        """Return the class of a tag."""
        return kind  # type: ignore[no-any-return]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Validate with the class of the tag only."""
        known = self.known(source)
        name = f"{self.choose.__name__}()"
        prepared: dict[Any, SchemaValidator] = {}

        def check(value: Any, info: Any) -> Any:
            tag, kinds = self.choose(value), known()
            if tag is None:
                raise PydanticKnownError("union_tag_not_found", {"discriminator": name})
            if tag not in kinds:
                expected = ", ".join(f"'{tag}'" for tag in kinds)
                found = {"discriminator": name, "tag": tag, "expected_tags": expected}
                raise PydanticKnownError("union_tag_invalid", found)
            key = (tag, kinds[tag])
            if key not in prepared:
                schema = _schema(self.entry(kinds[tag]))
                schema = core_schema.tagged_union_schema({tag: schema}, self.choose)
                prepared[key] = SchemaValidator(schema)
            return prepared[key].validate_python(value, context=info.context)

        return core_schema.with_info_plain_validator_function(
            check, metadata={CHOICES: lambda: [self.entry(kind) for kind in known().values()]}
        )


def tagged(tag: Callable[[dict[str, Any]], str | None] | None = None) -> Tagged:
    """Return the choice of an entry's class by its key ``type``.

    Parameters
    ----------
    tag : callable, optional
        Returns the type of a mapping without the key ``type``.
    """
    return Tagged(tag)


class Later:
    """Annotation of one class, imported when its first entry is read."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Validate with the class."""
        return later(lambda: source)


def later(find: Callable[[], Any]) -> Any:
    """Return the core schema of one class that is imported on demand."""

    def check(value: Any, info: Any) -> Any:
        return find().model_validate(value, context=info.context)

    return core_schema.with_info_plain_validator_function(
        check, metadata={CHOICES: lambda: [find()]}
    )


def by_form() -> Discriminator:
    """Return the choice of a schema by the form of the value: mapping, list or scalar."""

    def choose(value: Any) -> str:
        if isinstance(value, dict | BaseModel):
            return "mapping"
        return "list" if isinstance(value, list | tuple) else "scalar"

    return Discriminator(choose)


class WholeSchema(GenerateJsonSchema):
    """JSON schema with all classes that a file may use."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._open: list[str] = []  # classes under description: an entry may contain its own kind

    def function_plain_schema(self, schema: Any) -> dict[str, Any]:
        """Describe the classes of `Tagged` and `Later`."""
        if not (classes := _classes(schema)):
            return super().function_plain_schema(schema)
        found = [self._class(item) for item in dict.fromkeys(classes)]
        return found[0] if len(found) == 1 else {"oneOf": found}

    def model_schema(self, schema: Any) -> dict[str, Any]:
        """Describe a class as a definition of its own, even if only one place uses it."""
        if _ref(_schema(schema["cls"])) in self._open:
            return super().model_schema(schema)
        return self._class(schema["cls"])

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Return whether a field gets a title: not if its class has one."""
        return len(_classes(schema)) != 1 and super().field_title_should_be_set(schema)

    def _class(self, item: type[BaseModel]) -> dict[str, Any]:
        schema = _schema(item)
        ref = _ref(schema)
        if ref in self._open:
            return self.generate_inner(core_schema.definition_reference_schema(ref))
        self._open.append(ref)
        try:
            return self.generate_inner(schema)
        finally:
            self._open.pop()


def _schema(item: type[BaseModel]) -> Any:
    """Return the core schema of a class."""
    item.model_rebuild()
    return item.__pydantic_core_schema__


def _ref(schema: Any) -> str:
    """Return the reference name of a class's core schema."""
    inner = schema["schema"] if schema["type"] == "definitions" else schema
    return str(inner["schema_ref"] if inner["type"] == "definition-ref" else inner["ref"])


def _classes(schema: Any) -> list[type[BaseModel]]:
    """Return the classes of a core schema of `Tagged` or `Later`."""
    found = (schema.get("metadata") or {}).get(CHOICES)
    return found() if found else []


def _tag(item: Any) -> str:
    """Return the tag of one member of a union."""
    return next(str(note.tag) for note in get_args(item)[1:] if isinstance(note, Tag))
