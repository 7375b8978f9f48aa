"""Block ``fatigue`` of a model file: S-N curves by name, and fatigue checks of bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from jousto.base.errors import suggest
from jousto.fatigue.miner.check import FatigueCheck
from jousto.materials.strength.sn import SN
from jousto.schema.entries.blocks.fatigue import FatigueEntry
from jousto.schema.entries.curves import CurveForm
from jousto.schema.file.document import Document, Loc, parse_document, read_document
from jousto.schema.file.error_messages import explain, finish
from jousto.schema.make.builder import Builder
from jousto.schema.make.curves import build_curve
from jousto.schema.make.declared import Place, build_declared
from jousto.schema.make.sensors import FORMS as OF_SENSORS


@dataclass(frozen=True, eq=False)
class Fatigue:
    """S-N curves and fatigue checks of a model file.

    Attributes
    ----------
    curves : dict of str to SN
        S-N curves by name.
    checks : tuple of FatigueCheck
        Checks in the order of the file.
    """

    curves: dict[str, SN]
    checks: tuple[FatigueCheck, ...]


def build_curves(builder: Builder, entry: FatigueEntry | None) -> dict[str, SN | None]:
    """Return the S-N curves by name; None for an invalid one, whose problem is added."""
    given = {} if entry is None or entry.curves is None else entry.curves
    return {
        name: build_curve(builder, ("fatigue", "curves", name), item, {})
        for name, item in given.items()
    }


def build_fatigue(
    builder: Builder,
    entry: FatigueEntry,
    bodies: Iterable[str] | None = None,
    known_curves: dict[str, SN | None] | None = None,
) -> Fatigue:
    """Return the curves and checks of an entry; problems are added to the builder.

    Parameters
    ----------
    builder : Builder
        Builder that collects problems with their lines.
    entry : FatigueEntry
    bodies : iterable of str, optional
        Names of the flexible bodies; None does not check them.
    known_curves : dict, optional
        Result of `build_curves`; None: the curves are built here.
    """
    from jousto.fatigue.cycles.rainflow import check_residue

    curves = build_curves(builder, entry) if known_curves is None else known_curves
    known = None if bodies is None else list(bodies)
    checks = []
    for i, check in enumerate(entry.checks or ()):
        loc: Loc = ("fatigue", "checks", i)
        before = len(builder.found)
        if known is not None and check.body not in known:
            builder.unknown((*loc, "body"), "bodies", "flexible body", check.body, known)
        made = build_declared(builder, loc, check, {"curves": curves})
        builder.make(loc, check_residue, check.residue, "")
        if made is not None and len(builder.found) == before:
            checks.append(made)
    return Fatigue({k: v for k, v in curves.items() if v is not None}, tuple(checks))


def flexible_bodies(entry: Any) -> list[str]:
    """Return the names of the flexible bodies of a model's entry."""
    return [body.name for body in entry.bodies if getattr(body, "part", None) is not None]


def criterion(place: Place, name: str) -> str:
    """Return the name of a criterion; add a problem if there is no such criterion."""
    from jousto.recovery.fields.criteria import criteria

    allowed = (*criteria(), "critical-plane")
    if name not in allowed:
        place.builder.note(place.loc, f"no criterion {name!r}{suggest(name, allowed)}")
    return name


def plane(place: Place, normal: Any) -> Any:
    """Return the plane of a normal; None, with a problem, if the normal is invalid."""
    from jousto.recovery.fields.criteria import Plane

    if place.values.get("criterion") is not None:
        place.builder.note(place.loc, "give either criterion or plane, not both")
    return place.builder.make(place.loc, Plane, normal)


FORMS: Mapping[str, Callable[[Place, Any], Any]] = {"criterion": criterion, "plane": plane}
"""How a value of each form becomes an object."""


class FatigueBuilder(Builder):
    """Builder of one block of a model file, or of the file of a curve or a duty cycle."""

    forms = {**OF_SENSORS, **FORMS}


def built(
    document: Document, form: Any, build: Callable[[Builder, Any], Any], prefix: Loc = ()
) -> Any:
    """Return the object built from a document or from one of its blocks.

    Parameters
    ----------
    document : Document
    form : type
        The entry.
    build : function
        Returns the object from a builder and a valid entry, and adds problems to the builder.
    prefix : tuple
        Path of the block.

    Raises
    ------
    InputError
        With all problems and their lines.
    """
    classes: dict[int, Any] = {}
    data = document.at(prefix) if prefix else document.data
    try:
        entry = TypeAdapter(form).validate_python(data, context=classes)
    except ValidationError as error:
        finish(document, explain(error, document, classes, prefix=prefix), [])
        raise AssertionError from None
    builder = FatigueBuilder(document)
    made = build(builder, entry)
    finish(document, builder.found, builder.warnings)
    return made


def parse_fatigue(text: str, name: str = "model") -> Fatigue | None:
    """Return the fatigue block of the text of a model; None if it has none.

    The rest of the model is not built. Therefore the function is fast, and it works for results
    whose mesh files are missing.

    Raises
    ------
    InputError
        With all problems of the block and their lines.
    """
    document = parse_document(text, name=name)
    if document.data.get("fatigue") is None:
        return None
    found: Fatigue = built(document, FatigueEntry, build_fatigue, ("fatigue",))
    return found


def read_curve(path: str | Path) -> SN:
    """Return the S-N curve of a YAML file with the keys of an entry of ``fatigue: curves``.

    Raises
    ------
    InputError
        If the file cannot be read, or with all its problems and their lines.
    """
    found: SN = built(
        read_document(path), CurveForm, lambda b, entry: build_curve(b, (), entry, {})
    )
    return found
