"""Reading model files: parse, validate, build; all problems are reported at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.garbage_collection import uncollected
from jousto.base.object_repr import described
from jousto.design.studies.parameters.parameter import Parameter
from jousto.mechanism.mechanism import Mechanism
from jousto.robots.readers.suffixes import SUFFIXES
from jousto.schema.entries.choices import WholeSchema
from jousto.schema.entries.model import ModelEntry
from jousto.schema.entries.parts import ReducedEntry
from jousto.schema.entries.solids import PartEntry
from jousto.schema.file.document import (
    Document,
    Loc,
    parse_document,
    read_document,
)
from jousto.schema.file.error_messages import explain, finish
from jousto.schema.file.parameters import SECTION, expand
from jousto.schema.make.blocks.fatigue import Fatigue, build_fatigue, flexible_bodies
from jousto.schema.make.blocks.limits import (
    Reliability,
    build_limits,
    build_reliability,
    mentioned,
)
from jousto.schema.make.blocks.monitor import build_monitor
from jousto.schema.make.declared import build_declared
from jousto.schema.make.matrices import is_superelement
from jousto.schema.make.model import ModelBuilder
from jousto.schema.optimisation import Optimisation
from jousto.schema.partial_validation import validate
from jousto.schema.simulation import Simulation
from jousto.schema.variants import Variants

if TYPE_CHECKING:
    from jousto.design.studies.outcomes.requirement import Requirement

PART_TYPES = ("beam", "members", "frame", "solid", "matrices", "reduced")


@described
@dataclass(frozen=True, eq=False)
class ModelFile:
    """The content of a model file.

    Parameters
    ----------
    mechanism : Mechanism
        Bodies, joints, forces and sensors.
    simulation : Simulation or None
        Simulation settings, if the file contains them.
    text : str
        The text of the file, which is stored with the results.
    fatigue : Fatigue or None
        S-N curves and fatigue checks, if the file contains them.
    monitor : MonitorSettings or None
        Settings of the monitoring of measured strains, if the file contains them.
    parameters : tuple of Parameter
        Numbers that a study may vary.
    variants : Variants or None
        Source of machines for other parameter values, for `study`.
    limits : tuple of Requirement
        Outcomes and their bounds.
    reliability : Reliability
        Target and correlations of the parameters.
    optimisation : Optimisation or None
        Machine that an optimisation runs, if the file has it.
    """

    mechanism: Mechanism
    simulation: Simulation | Any = None
    text: str = ""
    fatigue: Fatigue | None = None
    monitor: Any = None
    parameters: tuple[Parameter, ...] = ()
    variants: Any = None
    limits: tuple[Requirement, ...] = ()
    reliability: Reliability = field(default_factory=Reliability)
    optimisation: Optimisation | Any = None


@explained
def read_model(
    path: str | Path,
    *,
    rigid: bool = False,
    trust: bool = False,
    progress: Any = None,
    parameters: Mapping[str, float] | None = None,
) -> ModelFile:
    """Read a YAML or JSON model file, or a robot (URDF, MJCF, SDF) as a mechanism.

    Parameters
    ----------
    path : str or Path
        The file; file names in it are relative to its folder. Files that end with .urdf, .mjcf,
        .sdf or .xml are read by `jo.robots.read_robot`, which has more options.
    rigid : bool
        Whether flexible bodies become rigid, with the mass and inertia of their parts, to see the
        effect of flexibility, or for `inverse_dynamics`. Sensors of modes and stress are omitted.
    trust : bool
        Whether Python functions (forces of type ``user-force``) and functional mock-up units
        (``fmus``) that the file names may run. Such code has all your rights on this computer:
        trust only files whose author you know. Without trust, functions raise an error here, and
        units when `simulate` loads them.
    progress : bool or function, optional
        Receiver of the progress of `reduce`, for large parts.
    parameters : dict of str to float, optional
        Values of parameters of the file in SI units, instead of those in the file.

    Raises
    ------
    InputError
        With all problems of the file and their lines.

    Warns
    -----
    JoustoWarning
        For all warnings of the constructors, with lines, and for unused parameters.
    """
    if Path(path).suffix.lower() in SUFFIXES:
        from jousto.robots.build import mechanism as robot_mechanism
        from jousto.robots.readers.files import read_robot

        return ModelFile(robot_mechanism(read_robot(path)))
    document = read_document(path)
    return build_model(document, rigid=rigid, trust=trust, progress=progress, parameters=parameters)


def parse_model(
    text: str, *, name: str = "model", folder: Path | None = None, trust: bool = False
) -> ModelFile:
    """Read a model from text; see `read_model`.

    Examples
    --------
    >>> model = parse_model('''
    ... bodies: [{name: ball, mass: 500 g, inertia: [1e-4, 1e-4, 1e-4], center: [0, -1 m, 0]}]
    ... joints: [{type: spherical, name: pivot, a: ground.origin, b: ball.origin}]
    ... gravity: [0, -9.81, 0]
    ... ''')
    >>> model.mechanism
    <Mechanism 'mechanism': 1 body, 1 joint, 0 forces, 0 sensors>
    """
    return build_model(parse_document(text, name=name, folder=folder), trust=trust)


@uncollected()
def build_model(
    document: Document,
    *,
    rigid: bool = False,
    trust: bool = False,
    progress: Any = None,
    parameters: Mapping[str, float] | None = None,
    kept: dict[Any, Any] | None = None,
) -> ModelFile:
    """Validate and build a document; see `read_model`.

    Reduced parts of `kept` are used again if their entries are unchanged.
    """
    whole, expanded = document, expand(document, parameters)
    document = expanded.document
    if "bodies" not in document.data and document.data.get("type") in PART_TYPES:
        message = (
            f"is a part, not a model: jousto reduce {document.name} makes its modes, "
            "a model takes it among its parts"
        )
        raise InputError(Problem(document.name, message))
    valid = validate(document)
    entry = valid.entry
    options = {} if progress is None else {"progress": progress}
    builder = ModelBuilder(document, valid.broken, rigid=rigid, trust=trust, options=options)
    builder.kept = {} if kept is None else kept
    mechanism, simulation, fatigue, monitor = None, None, None, None
    limits: tuple[Requirement, ...] = ()
    reliability, optimisation = Reliability(), None
    if entry is not None:
        mechanism = builder.mechanism(entry, valid.index)
        builder.check_names(valid.rest, {loc[:3] for loc, _ in valid.problems})
        if entry.simulation is not None:
            simulation = build_declared(builder, ("simulation",), entry.simulation)
        if entry.fatigue is not None:
            fatigue = build_fatigue(builder, entry.fatigue, flexible_bodies(entry), builder.curves)
        if entry.monitor is not None and mechanism is not None and not rigid:
            monitor = build_monitor(builder, entry.monitor, mechanism)
        limits = build_limits(builder, entry.limits or (), expanded.parameters, whole.data)
        if entry.reliability is not None:
            reliability = build_reliability(builder, entry.reliability, expanded.parameters)
        if entry.optimisation is not None:
            optimisation = build_declared(builder, ("optimisation",), entry.optimisation)
    named = mentioned(whole)
    unused = (
        f"{document.where((SECTION, name))}: nothing depends on it; ${{{name}}} stands for it"
        for name in expanded.unused
        if name not in named
    )
    finish(document, [*valid.problems, *builder.found], [*unused, *builder.warnings])
    # break reference cycles between sections and builder, which would keep all entries alive
    builder.known.clear()
    assert mechanism is not None
    variants = Variants(build_model, whole, expanded.parameters, rigid, trust, expanded.idle)
    given = (mechanism, simulation, document.text, fatigue, monitor)
    return ModelFile(*given, expanded.parameters, variants, limits, reliability, optimisation)


# -- parts alone and the schema -------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class PartFile:
    """Content of a file with one part.

    Parameters
    ----------
    name : str
        Name of the part.
    part : Part or None
        The part with its mesh; None if the file names a part that was reduced before.
    method : CraigBampton, FreeFree or None
        Method of its reduction.
    reduced : ReducedPart or None
        Its modes; None if they were not requested.
    """

    name: str
    part: Any
    method: Any
    reduced: Any


def read_part(path: str | Path, name: str | None = None) -> Any:
    """Return the ReducedPart of a file with one part, or of one entry of a model's parts.

    Parameters
    ----------
    path : str or Path
        YAML file whose top level is a part (``type: beam`` ...), or a model file.
    name : str, optional
        Name of the part in a model file; not needed if there is only one.

    Raises
    ------
    InputError
        With all problems of the part and their lines.
    """
    return read_part_file(path, name).reduced


def read_part_file(
    path: str | Path, name: str | None = None, *, reduce: bool = True, **options: Any
) -> PartFile:
    """Return the part of a file, its reduction settings, and its modes.

    Parameters
    ----------
    path, name
        As in `read_part`.
    reduce : bool
        Whether the part is reduced; reading alone is quick.
    **options
        Arguments of `reduce` with precedence over those of the file: solver, cache, progress.

    Raises
    ------
    InputError
        With all problems of the part and their lines.
    """
    document = expand(read_document(path)).document
    loc: Loc = ()
    data: Any = document.data
    if isinstance(data.get("parts"), dict):
        names = list(data["parts"])
        if name is None and len(names) != 1:
            known = ", ".join(names)
            raise InputError(Problem(document.where(("parts",)), f"which part? there are: {known}"))
        name = names[0] if name is None else name
        if name not in names:
            raise InputError(
                Problem(document.where(("parts",)), f"no part {name!r}{suggest(name, names)}")
            )
        loc = ("parts", name)
        data = data["parts"][name]
    name = Path(path).stem if name is None else name
    classes: dict[int, Any] = {}
    builder = ModelBuilder(document, options=options)
    try:
        entry: Any = TypeAdapter(PartEntry).validate_python(data, context=classes)
    except ValidationError as error:
        finish(document, explain(error, document, classes, prefix=loc), [])
    part: Any = None
    method: Any = None
    reduced: Any = None
    if not builder.part_name(loc, name):
        pass
    elif isinstance(entry, ReducedEntry) or is_superelement(entry):
        reduced = builder.reduced(loc, name, entry)
    else:
        part = builder.part(loc, name, entry)
        method = builder.method(loc, entry, part)
        if entry.in_plane is not None and entry.keep is not None:
            builder.note((*loc, "keep"), "give either keep or in_plane, not both")
        elif reduce:
            reduced = builder.reduction(loc, entry, part, method)
    finish(document, builder.found, builder.warnings)
    return PartFile(name, part, method, reduced)


def model_schema() -> dict[str, Any]:
    """Return the JSON schema of the model file, for editors."""
    schema = ModelEntry.model_json_schema(by_alias=True, schema_generator=WholeSchema)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "jousto model",
    }
