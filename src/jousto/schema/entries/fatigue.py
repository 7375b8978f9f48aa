"""Fatigue in the model file: named S-N curves, and what is to be checked where."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag, TypeAdapter, ValidationError

from jousto.base.errors import suggest
from jousto.materials.strength.sn import SN
from jousto.schema.entries.base import Component, Direction, Duration, Entry, Number, Text
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.curves import CurveForm, MeanEntry, SNOrName, build_curve, build_mean
from jousto.schema.file.document import Document, Loc, parse_document, read_document
from jousto.schema.file.explain import explain, finish
from jousto.schema.make.context import Builder

Residue: TypeAlias = Literal["half", "repeat", "ignore"]
Sites: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[tuple[Component, ...], Tag("list")], by_form()
]


class CheckEntry(Entry):
    """A body whose life is to be found."""

    name: Text | None = None
    body: Text = Field(description="Name of a flexible body")
    sn: SNOrName = Field(description="A curve: a name of curves or of the library, or its keys")
    residue: Residue | None = Field(
        None, description="What counts of cycles that the history leaves open; must be given"
    )
    sites: Sites | None = Field(None, description="Sites, node sets or nodes; all if not given")
    criterion: Text | None = Field(None, description="signed-von-mises if not given")
    plane: Direction | None = Field(None, description="Normal of a plane, instead of a criterion")
    mean: MeanEntry | None = Field(None, description="Mean stress correction")
    required: Duration | None = Field(None, description="Life required")
    allowable: Number | None = Field(None, description="Miner's sum allowed, 1 if not given")
    survival: Number | None = Field(None, description="Probability of survival of the results")


class FatigueEntry(Entry):
    """S-N curves by name, and what is to be checked."""

    curves: dict[Text, CurveForm] | None = None
    checks: tuple[CheckEntry, ...] | None = None


# -- built ----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class FatigueCheck:
    """What is to be checked where; the arguments of `damage_field`.

    Attributes
    ----------
    name, body : str
        Name for tables; body.
    sn : SN
        Its curve.
    residue : str or None
        Rule of the count; the command line may leave it out.
    sites : tuple of str or int, or None
        Places; None for all.
    options : dict
        Other arguments of `damage_field`: criterion, mean, required, allowable, survival.
    """

    name: str
    body: str
    sn: SN
    residue: str | None
    sites: tuple[str | int, ...] | None
    options: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Fatigue:
    """What a model file says about fatigue.

    Attributes
    ----------
    curves : dict of str to SN
        By name.
    checks : tuple of FatigueCheck
        In the order of the file.
    """

    curves: dict[str, SN]
    checks: tuple[FatigueCheck, ...]


def build_curves(builder: Builder, entry: FatigueEntry | None) -> dict[str, SN | None]:
    """Return the curves of a file by name, None those that are wrong, which is noted."""
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
    """Return the curves and checks of an entry; what is wrong is noted.

    Parameters
    ----------
    builder : Builder
        Notes problems with their lines.
    entry : FatigueEntry
    bodies : iterable of str, optional
        Names of the flexible bodies; None does not check them.
    known_curves : dict, optional
        What `build_curves` made; None builds them here.
    """
    from jousto.fatigue.cycles.rainflow import check_residue
    from jousto.recovery.fields.criteria import Plane, criteria

    here: Loc = ("fatigue",)
    curves = build_curves(builder, entry) if known_curves is None else known_curves
    known = None if bodies is None else list(bodies)
    checks = []
    for i, check in enumerate(entry.checks or ()):
        loc: Loc = (*here, "checks", i)
        before = len(builder.found)
        options = check.given("name", "body", "sn", "residue", "sites", "plane")
        if known is not None and check.body not in known:
            builder.unknown((*loc, "body"), "bodies", "flexible body", check.body, known)
        sn = build_curve(builder, (*loc, "sn"), check.sn, curves)
        if check.mean is not None:
            options["mean"] = build_mean(builder, (*loc, "mean"), check.mean)
        allowed = (*criteria(), "critical-plane")
        if check.plane is not None:
            if check.criterion is not None:
                builder.note((*loc, "plane"), "give either criterion or plane, not both")
            options["criterion"] = builder.make((*loc, "plane"), Plane, check.plane)
        elif check.criterion is not None and check.criterion not in allowed:
            hint = suggest(check.criterion, allowed)
            builder.note((*loc, "criterion"), f"no criterion {check.criterion!r}{hint}")
        residue = builder.make(loc, check_residue, check.residue, "")
        if sn is None or residue is None or len(builder.found) > before:
            continue
        sites = (check.sites,) if isinstance(check.sites, str) else check.sites
        name = check.name or check.body
        checks.append(FatigueCheck(name, check.body, sn, residue, sites, options))
    return Fatigue({k: v for k, v in curves.items() if v is not None}, tuple(checks))


def flexible_bodies(entry: Any) -> list[str]:
    """Return the names of the flexible bodies of a model's entry."""
    return [body.name for body in entry.bodies if getattr(body, "part", None) is not None]


def parse_fatigue(text: str, name: str = "model") -> Fatigue | None:
    """Return what the text of a model says about fatigue, None if it says nothing.

    Nothing else of the model is built, so that it is quick, and works for results whose meshes are
    elsewhere.

    Raises
    ------
    InputError
        What is wrong with the block, with lines.
    """
    document = parse_document(text, name=name)
    data = document.data.get("fatigue")
    if data is None:
        return None
    classes: dict[int, Any] = {}
    try:
        entry = FatigueEntry.model_validate(data, context=classes)
    except ValidationError as error:
        finish(document, explain(error, document, classes, prefix=("fatigue",)), [])
        raise AssertionError from None
    builder = Builder(document)
    made = build_fatigue(builder, entry)
    finish(document, builder.found, builder.warnings)
    return made


def read_curve(path: str | Path) -> SN:
    """Return the S-N curve of a YAML file with the keys of an entry of ``fatigue: curves``.

    Raises
    ------
    InputError
        If the file cannot be read, or what is wrong with it, with lines.
    """
    document: Document = read_document(path)
    classes: dict[int, Any] = {}
    try:
        entry: Any = TypeAdapter(CurveForm).validate_python(document.data, context=classes)
    except ValidationError as error:
        finish(document, explain(error, document, classes, prefix=()), [])
        raise AssertionError from None
    builder = Builder(document)
    made = build_curve(builder, (), entry, {})
    finish(document, builder.found, builder.warnings)
    assert made is not None
    return made


class DutyEventEntry(Entry):
    """A result and how often it happens."""

    result: Text = Field(description="Results file, relative to this one")
    repeats: Number | None = Field(None, description="1 if not given")
    name: Text | None = None


class DutyEntry(Entry):
    """A duty cycle: the file of `jousto fatigue --duty`."""

    transitions: Literal["separate", "sequence", "worst"] | None = None
    events: tuple[DutyEventEntry, ...]


@dataclass(frozen=True)
class Duty:
    """A duty cycle as a file says it.

    Attributes
    ----------
    transitions : str or None
    events : tuple of (Path, float, str)
        Results file, repeats and name.
    """

    transitions: str | None
    events: tuple[tuple[Path, float, str], ...]


def read_duty(path: str | Path) -> Duty:
    """Read the YAML file of a duty cycle.

    Raises
    ------
    InputError
        What is wrong with it, with lines.
    """
    document = read_document(path)
    classes: dict[int, Any] = {}
    try:
        entry = DutyEntry.model_validate(document.data, context=classes)
    except ValidationError as error:
        finish(document, explain(error, document, classes), [])
        raise AssertionError from None
    events = tuple(
        (
            document.folder / event.result,
            1.0 if event.repeats is None else event.repeats,
            event.name or Path(event.result).stem,
        )
        for event in entry.events
    )
    return Duty(entry.transitions, events)
