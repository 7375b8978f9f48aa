"""Functional mock-up units of a machine, for co-simulation and model exchange."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from xml.etree import ElementTree as xml

from jousto.base.errors import Problems
from jousto.base.files import written
from jousto.base.version import __version__
from jousto.export import sources
from jousto.export.constants import number, text
from jousto.export.description import description, token, variables
from jousto.export.ports import Named
from jousto.export.program import Program, program
from jousto.export.project import flat_files
from jousto.export.toolchain import build, platforms
from jousto.model.model import Model
from jousto.simulation.solvers.base import Solver
from jousto.simulation.state import State

SHOWN = "documentation/model.png"
PICTURES = {2: ("model.png", SHOWN), 3: ("terminalsAndIcons/icon.png", SHOWN)}
"""Paths of a picture of the machine in units of both versions, and in their page."""
BAUMGARTE = 20.0  # rate of Baumgarte's stabilisation of joints in model exchange, 1/s


def write_fmu(
    model: Model,
    path: str | Path,
    solver: Solver | None = None,
    *,
    state: State | None = None,
    name: str = "",
    version: int = 3,
    on: Iterable[str] = ("here",),
    stop: float = 1.0,
    documents: dict[str, bytes] | None = None,
    derivatives: bool = False,
    named: Sequence[Named] = (),
) -> Path:
    """Write a functional mock-up unit (FMI 2.0 or 3.0) of a model; return its path.

    Co-simulation divides the steps of the importer into steps of the method. Model exchange, for
    machines without events, stick-slip friction and damage sensors, provides states and
    derivatives to the method of the importer, with Baumgarte's stabilisation of joints. The unit
    contains the sources, so that it can be built for other platforms.

    Parameters
    ----------
    model : Model
        From `compile`.
    path : path
        File that ends with ``.fmu``.
    solver : Solver, optional
        Method of fixed step; None: the choice of `simulate` for 10 s.
    state : State, optional
        Initial state; None: that of the model.
    name : str
        Identifier of the model; empty: the name of the file.
    version : int
        2 or 3.
    on : iterable of str
        Platforms of the binaries: "here", "x86_64-linux", "aarch64-linux", "x86_64-windows",
        "x86_64-darwin", "aarch64-darwin"; other platforms than "here" need the package ziglang.
        Empty for a unit with sources only.
    stop : float
        Stop time of the default experiment, s.
    documents : dict, optional
        Further files by their path in the unit: ``model.png``, ``resources/model.yaml``.
    derivatives : bool
        Whether to provide directional derivatives of outputs and rates by complex steps, which
        makes the binaries larger.
    named : sequence of Named
        Named constants that become parameters, from `named_constants`.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For unsupported items, unknown platforms, a missing compiler or an unwritable path.
    """
    problems = Problems()
    if version not in (2, 3):
        problems.add("fmu", f"version is {version!r}, must be 2 or 3")
    problems.positive("fmu", "stop", float(stop), "s")
    problems.raise_if_any()
    out = Path(path)
    chosen = platforms(on)
    made = program(model, solver, state=state, name=name or out.stem, named=named)
    why = why_not_exchanged(model)
    exchange = not why
    code = flat_files(made, "fmu.c", "fmu.h", f"fmi{version}.c")
    if derivatives:
        code |= slopes(code, made)
    identity = token(made, "".join(code.values()) + repr(sorted(made.fields.items())))
    code["plant.h"] += (
        f"#define PLANT_TOKEN {text(identity)}\n#define PLANT_BAUMGARTE {number(BAUMGARTE)}\n"
        f"#define PLANT_NOT_EXCHANGED {text(why)} /* reason; empty: model exchange is offered */\n"
    )
    if derivatives:
        code["plant.h"] += "#define PLANT_SLOPES\n"
    files: dict[str, bytes] = {
        "modelDescription.xml": description(
            *(made, version, identity),
            exchange=exchange,
            stop=float(stop),
            derivatives=derivatives,
        ).encode(),
        "documentation/index.html": _page(
            made, exchange=exchange, picture=SHOWN in (documents or {})
        ).encode(),
        "documentation/licenses/license.txt": LICENCE.encode(),
    }
    files |= {f"sources/{key}": value.encode() for key, value in code.items()}
    if version == 3:
        files["sources/buildDescription.xml"] = _recipe(made, code).encode()
    files |= documents or {}
    with tempfile.TemporaryDirectory(prefix="jousto-fmu-") as folder:
        for platform in chosen:
            binary = Path(folder) / f"{made.name}{platform.suffix}"
            build(code, platform, binary, flags=("-DJO_NO_ALLOCATION",), shared=True)
            place = platform.fmi3 if version == 3 else platform.fmi2
            files[f"binaries/{place}/{binary.name}"] = binary.read_bytes()
    with written(out) as beside, zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as archive:
        for key, content in sorted(files.items()):
            entry = zipfile.ZipInfo(key)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return out


def slopes(code: dict[str, str], made: Program) -> dict[str, str]:
    """Return the additional files of a unit with directional derivatives."""
    around = {f"{key}.{end}" for key in ("fmu", "fmi2", "fmi3") for end in "ch"}
    twice = {name: text for name, text in code.items() if name not in around}
    more = {name: sources.host(name) for name in ("slope.c", "slope.h")}
    return sources.complex_build(twice, f"{made.name}_plant") | more


def why_not_exchanged(model: Model) -> str:
    """Return why a model cannot be exchanged (model exchange); empty if it can."""
    if model.events:
        return "events of the machine are found in its own steps"
    if model.switched:
        return "rigid stops and locks change velocities at its own steps"
    if any(friction.sticks for friction in model.frictions):
        return "stick-slip friction changes its state at its own steps"
    if model.meters:
        return "damage is counted at its own steps"
    if found := next((one for one in model.forces if one.law.yields and one.states), None):
        return f"states of {found.name} change at the ends of its own steps"
    return ""


def _recipe(made: Program, code: dict[str, str]) -> str:
    root = xml.Element("fmiBuildDescription", fmiVersion="3.0")
    settings = xml.SubElement(root, "BuildConfiguration", modelIdentifier=made.name)
    files = xml.SubElement(settings, "SourceFileSet", language="C99")
    for name in sorted(code):
        if name.endswith(".c"):
            xml.SubElement(files, "SourceFile", name=name)
    xml.SubElement(files, "PreprocessorDefinition", name="JO_NO_ALLOCATION")
    xml.SubElement(settings, "Library", name="m")
    xml.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{xml.tostring(root, encoding="unicode")}\n'


def _page(made: Program, *, exchange: bool, picture: bool) -> str:
    rows = "\n".join(
        f"<tr><td>{escape(x.name)}</td><td>{escape(x.unit)}</td><td>{x.causality}</td>"
        f"<td>{escape(x.about)}</td></tr>"
        for x in variables(made, exchange=False)
    )
    why = why_not_exchanged(made.model)
    offered = "Co-simulation and model exchange." if exchange else f"Co-simulation only: {why}."
    image = '<p><img src="model.png" alt="the machine at its start" width="600"></p>\n'
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{escape(made.model.name)}</title>
<style>body{{font:16px sans-serif;max-width:60em;margin:2em auto}}td{{padding:.2em .8em}}</style>
</head><body><h1>{escape(made.model.name)}</h1>
<p>A flexible multibody machine, written by jousto {__version__}. {escape(offered)}</p>
<p>Its own step is {made.solver.step:g} s ({escape(type(made.solver).__name__)}); the importer's
steps must be multiples of it. Values are in SI units. In model exchange joints are stabilised by
Baumgarte's terms of {BAUMGARTE:g} 1/s.</p>
{image if picture else ""}<table>
<tr><th>variable</th><th>unit</th><th>causality</th><th>description</th></tr>
{rows}</table></body></html>
"""


LICENCE = """\
The engine in this unit is part of jousto, under the BSD-3-Clause licence (SPDX: BSD-3-Clause).
The constants belong to the author of the model.
"""
