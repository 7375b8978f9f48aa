"""Description of a functional mock-up unit: its variables, units and capabilities."""

from __future__ import annotations

import io
import stat
import zipfile
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from jousto.base.errors import InputError, Problem, suggest
from jousto.base.files import check_input
from jousto.base.names import harmless
from jousto.base.units import KINDS, UnitError, converted, parse_unit

LARGEST = 4 << 30  # largest total size of the unpacked files, bytes
LONGEST = 64 << 20  # largest size of modelDescription.xml, bytes
REALS = ("Real", "Float64")
BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Variable:
    """Variable of a unit; its value x corresponds to ``factor x + offset`` in SI units.

    Attributes
    ----------
    name, causality, variability, unit : str
        As in modelDescription.xml.
    reference : int
        Value reference of FMI.
    real : bool
        Whether the variable is a real scalar.
    settable : bool
        Whether its start value may be replaced.
    factor, offset : float Conversion to SI units. dimension : str
        SI unit, empty if the description has none.
    """

    name: str
    causality: str
    variability: str
    unit: str
    reference: int
    real: bool
    settable: bool
    factor: float = 1.0
    offset: float = 0.0
    dimension: str = ""


@dataclass(frozen=True)
class Description:
    """Description of a functional mock-up unit for co-simulation.

    Attributes
    ----------
    version : int
        Version of FMI, 2 or 3.
    identifier, token : str
        Name of the binary, and GUID or instantiation token.
    variables : dict
        Variables by name.
    states : bool
        Whether the unit can save and restore its state.
    variable_steps : bool
        Whether the communication step may vary.
    direct : dict
        Inputs on which outputs depend directly, by their names in ``<ModelStructure>``; an output
        without such an entry may depend on all inputs and is not in the dict.
    """

    version: int
    identifier: str
    token: str
    variables: dict[str, Variable]
    states: bool
    variable_steps: bool
    direct: dict[str, frozenset[str]]

    def feeds_through(self, output: str, given: str) -> bool:
        """Return whether an output may depend on an input at the same instant."""
        return output not in self.direct or given in self.direct[output]

    def named(self, *causality: str) -> list[str]:
        """Return the names of the variables with one of the given causalities."""
        return [x.name for x in self.variables.values() if x.causality in causality]


def read_description(path: Path, where: str) -> Description:
    """Return the description of a unit from its archive.

    Raises
    ------
    InputError
        If the file is not a co-simulation unit of FMI 2 or 3, or has no binary for this computer.
    """
    try:
        import fmpy
    except ImportError:
        message = "functional mock-up units need the package FMPy: pip install fmpy"
        raise InputError(Problem(where, message)) from None
    check_input(path)
    names = _names(path, where)
    try:
        with zipfile.ZipFile(path) as archive, archive.open("modelDescription.xml") as packed:
            text = packed.read(
                LONGEST + 1
            )  # limit that does not depend on the length given in the archive
        if len(text) > LONGEST:
            raise ValueError(f"it is larger than {LONGEST >> 20} MB")
        if b"<!DOCTYPE" in text:
            raise ValueError("it declares a document type, which is not allowed in a unit")
        with io.BytesIO() as alone:
            with zipfile.ZipFile(alone, "w") as archive:
                archive.writestr("modelDescription.xml", text)
            alone.seek(0)
            about = fmpy.read_model_description(alone, validate=False)
    except Exception as error:  # the reader raises many types of exceptions on malformed XML
        note = harmless(f"{error}").strip().splitlines() or [type(error).__name__]
        message = f"its modelDescription.xml cannot be read: {note[0][:200]}"
        raise InputError(Problem(where, message)) from None
    version = int(str(about.fmiVersion).partition(".")[0])
    if version not in (2, 3):
        raise InputError(Problem(where, f"is of FMI {about.fmiVersion}; FMI 2 and 3 are supported"))
    abilities = about.coSimulation
    if abilities is None:
        raise InputError(
            Problem(
                where,
                "offers no co-simulation; export it for co-simulation",
            )
        )
    identifier = str(abilities.modelIdentifier)
    if not identifier.isidentifier():
        raise InputError(
            Problem(where, f"its modelIdentifier {identifier!r} is not a valid C identifier")
        )
    _check_binary(fmpy, version, identifier, names, where)
    units = {unit.name: unit.baseUnit for unit in about.unitDefinitions}
    found = (_variable(v, units) for v in about.modelVariables)
    return Description(
        version=version,
        identifier=identifier,
        token=str(about.guid if version == 2 else about.instantiationToken),
        variables={x.name: x for x in found},
        states=bool(abilities.canGetAndSetFMUstate),
        variable_steps=bool(abilities.canHandleVariableCommunicationStepSize),
        direct={
            x.variable.name: frozenset(v.name for v in x.dependencies)
            for x in about.outputs
            if x.dependencies is not None
        },
    )


def _names(path: Path, where: str) -> list[str]:
    """Return the file names in an archive after a check that they are inside the target folder."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
    except FileNotFoundError:
        near = suggest(path.name, [file.name for file in path.parent.glob("*.fmu")])
        raise InputError(Problem(where, f"no such file '{path}'{near}")) from None
    except (zipfile.BadZipFile, OSError, ValueError) as error:
        message = f"is not a zip archive of a functional mock-up unit: {error}"
        raise InputError(Problem(where, message)) from None
    for member in members:
        name = member.filename
        posix, windows = PurePosixPath(name), PureWindowsPath(name)
        outside = posix.is_absolute() or windows.drive or windows.root
        link = stat.S_ISLNK(member.external_attr >> 16)
        if outside or link or ".." in windows.parts:
            raise InputError(
                Problem(
                    where,
                    f"its archive has {harmless(name)!r}, which would be written outside of its "
                    "folder; do not trust this file",
                )
            )
    if sum(member.file_size for member in members) > LARGEST:
        raise InputError(Problem(where, f"unpacks to more than {LARGEST >> 30} GB"))
    return [member.filename for member in members]


def _check_binary(fmpy: Any, version: int, identifier: str, names: list[str], where: str) -> None:
    """Raise InputError if the unit has no binary for this computer."""
    platform = fmpy.platform_tuple if version == 3 else fmpy.platform
    wanted = f"binaries/{platform}/{identifier}{fmpy.sharedLibraryExtension}"
    if wanted in names:
        return
    known = sorted({name.split("/")[1] for name in names if name.startswith("binaries/")})
    there = f"it has {', '.join(map(harmless, known))}" if known else "it has no binary"
    sources = any(name.startswith("sources/") and name.endswith(".c") for name in names)
    remedy = (
        "; its sources can be compiled, `fmpy compile FILE` does that" if sources else
        "; ask the author of the unit for such a binary"
    )  # fmt: skip
    raise InputError(Problem(where, f"has no binary for {platform}, {there}{remedy}"))


def _variable(v: Any, units: dict[str, Any]) -> Variable:
    unit = v.unit or (v.declaredType.unit if v.declaredType is not None else "") or ""
    base = units.get(unit)
    factor, offset, dimension = 1.0, 0.0, ""
    if base is not None:
        factor, offset = float(base.factor), float(base.offset)
        powers = {word: int(getattr(base, word)) for word in BASE}
        dimension = " ".join(f"{word}{n if n != 1 else ''}" for word, n in powers.items() if n)
        try:
            dimension = named(dimension or "1") or dimension
        except UnitError:  # units of amounts of substance and of light
            pass
    elif unit:
        factor, dimension = _known(unit)
    single = not getattr(v, "dimensions", None) and not getattr(v, "shape", None)
    before = v.causality == "parameter" or v.initial in ("exact", "approx")
    return Variable(
        name=v.name,
        causality=v.causality or "local",
        variability=v.variability or "",
        unit=unit,
        reference=int(v.valueReference),
        real=v.type in REALS and single,
        settable=before and v.variability != "constant",
        factor=factor,
        offset=offset,
        dimension=dimension,
    )


def _known(unit: str) -> tuple[float, str]:
    """Return factor and SI unit of a unit without definition; an empty unit if it is unknown."""
    try:
        dimension = named(unit)
        return (converted(f"1 {unit}", dimension), dimension) if dimension else (1.0, "")
    except UnitError:
        return 1.0, ""


def named(unit: str) -> str:
    """Return the usual SI unit of the dimension of a unit; empty if there is none.

    >>> named("kg m s-2"), named("bar"), named("mm/s")
    ('N', 'Pa', 'm/s')
    """
    wanted = parse_unit(unit).dimensionality
    return next((si for si in KINDS if parse_unit(si).dimensionality == wanted), "")


def fits(a: str, b: str) -> bool:
    """Return whether two units have the same dimension; True if one of them is unknown.

    >>> fits("kg m s-2", "N"), fits("m", "rad"), fits("1/s", "rad/s")
    (True, False, True)
    """
    try:
        # most descriptions treat radians as plain numbers
        return _bare(a) == _bare(b)
    except UnitError:
        return True


def _bare(unit: str) -> dict[str, Any]:
    found = dict(parse_unit(unit).dimensionality)
    angle = found.pop("[angle]", 0)
    # a number and an angle are interchangeable only as part of a compound unit
    return found if found or not angle else {"[angle]": angle}
