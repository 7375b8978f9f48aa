"""Entries of several kinds: which class reads a mapping; each is prepared when a file needs it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, get_args

from pydantic import BaseModel, Discriminator, Tag
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import PydanticKnownError, SchemaValidator, core_schema

CHOICES = "jousto_choices"  # in the metadata of a core schema


class Tagged:
    """Annotation of a union of tagged classes, of which one reads a mapping by its key ``type``.

    A class is prepared when the first entry of its kind is read: a file has few kinds of the many.

    Parameters
    ----------
    tag : callable, optional
        Returns the type of a mapping that does not say it.
    """

    def __init__(self, tag: Callable[[dict[str, Any]], str | None] | None = None) -> None:
        self.tag = tag

    def choose(self, value: Any) -> str | None:
        """Return the tag of a value, None if it has none."""
        if isinstance(value, BaseModel):
            return str(getattr(value, "type", ""))
        if not isinstance(value, dict):
            return None
        given = value.get("type")
        if given is None and self.tag is not None:
            given = self.tag(value)
        return None if given is None else str(given)

    def known(self, source: Any) -> Callable[[], Mapping[str, Any]]:
        """Return what finds the kinds of a union by their tags."""
        classes = {_tag(item): get_args(item)[0] for item in get_args(source)}
        return lambda: classes

    def entry(self, kind: Any) -> type[BaseModel]:
        """Return the class that reads a kind."""
        return kind  # type: ignore[no-any-return]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Validate with the class of the tag alone."""
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
        Returns the type of a mapping that does not say it.
    """
    return Tagged(tag)


class Later:
    """Annotation of one class that is prepared when a file needs it."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Validate with the class."""
        return later(lambda: source)


def later(find: Callable[[], Any]) -> Any:
    """Return the core schema of one class, which is found when a file needs it."""

    def check(value: Any, info: Any) -> Any:
        return find().model_validate(value, context=info.context)

    return core_schema.with_info_plain_validator_function(
        check, metadata={CHOICES: lambda: [find()]}
    )


def by_form() -> Discriminator:
    """Return the choice between a mapping, a list and a scalar by what the file has."""

    def choose(value: Any) -> str:
        if isinstance(value, dict | BaseModel):
            return "mapping"
        return "list" if isinstance(value, list | tuple) else "scalar"

    return Discriminator(choose)


class WholeSchema(GenerateJsonSchema):
    """The JSON schema with all classes that a file may choose from."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._open: list[str] = []  # that are being described: an entry may hold its like

    def function_plain_schema(self, schema: Any) -> dict[str, Any]:
        """Describe what `Tagged` and `Later` choose from."""
        if not (classes := _classes(schema)):
            return super().function_plain_schema(schema)
        found = [self._class(item) for item in dict.fromkeys(classes)]
        return found[0] if len(found) == 1 else {"oneOf": found}

    def model_schema(self, schema: Any) -> dict[str, Any]:
        """Describe a class once, also one that is used in a single place of another."""
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
    """Return what the core schema of a class is known by."""
    inner = schema["schema"] if schema["type"] == "definitions" else schema
    return str(inner["schema_ref"] if inner["type"] == "definition-ref" else inner["ref"])


def _classes(schema: Any) -> list[type[BaseModel]]:
    """Return the classes that a core schema of `Tagged` or `Later` chooses from."""
    found = (schema.get("metadata") or {}).get(CHOICES)
    return found() if found else []


def _tag(item: Any) -> str:
    """Return the tag of one member of a union."""
    return next(str(note.tag) for note in get_args(item)[1:] if isinstance(note, Tag))
