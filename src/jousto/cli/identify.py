"""Command ``identify``: parameters of a model from measured records."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, JoustoWarning, Problem, suggest
from jousto.base.files import written
from jousto.cli.group import command
from jousto.cli.hotspots import check_targets
from jousto.cli.options import Model, Output, Trust, Workers
from jousto.cli.study_options import nothing_varied, problems_of, varied
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.design.identification.experiment import Experiment
    from jousto.design.identification.identified import Identified
    from jousto.design.identification.modal import Modal
    from jousto.design.studies.parameters.parameter import Parameter
    from jousto.measurement.gauges.record import Record
    from jousto.schema.read import ModelFile

MARK = "# jousto identify"
"""Begin of the files that this command writes."""
Pairs = dict[str, str]
Files = Annotated[
    list[Path] | None,
    typer.Option("--measured", metavar="FILE", help="A record to fit: CSV, UFF, LVM or HDF5."),
]


@command()
def identify(
    model: Model,
    measured: Files = None,
    output: Output = None,
    free: Annotated[
        list[str] | None,
        typer.Option(
            "--free",
            metavar="NAME[=LOW..HIGH]",
            help="A parameter to seek, with bounds; without the option those that have bounds.",
        ),
    ] = None,
    pair: Annotated[
        list[str] | None,
        typer.Option(
            "--pair",
            metavar="CHANNEL=NAME",
            help="The sensor or input of a channel; g3=-root turns its sign. By name otherwise.",
        ),
    ] = None,
    noise: Annotated[
        list[str] | None,
        typer.Option(
            "--noise",
            metavar="CHANNEL=SD",
            help="Standard deviation, '0.5 um' or '2 %' of the reading; estimated otherwise.",
        ),
    ] = None,
    gain: Annotated[
        list[str] | None,
        typer.Option("--gain", metavar="CHANNEL", help="Seek the gain of a channel, too."),
    ] = None,
    bias: Annotated[
        list[str] | None,
        typer.Option("--bias", metavar="CHANNEL", help="Seek the offset of a channel, too."),
    ] = None,
    shift: Annotated[
        list[str] | None,
        typer.Option("--shift", metavar="CHANNEL", help="Seek the delay of a channel, too."),
    ] = None,
    check: Annotated[
        list[Path] | None,
        typer.Option("--check", metavar="FILE", help="A record to compare with, never fitted."),
    ] = None,
    hammer: Annotated[
        list[Path] | None,
        typer.Option("--modes", metavar="FILE.uff", help="Modes of a hammer test to fit."),
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option("--unit", metavar="CHANNEL=UNIT", help="The unit that a file does not say."),
    ] = None,
    loss: Annotated[
        str,
        typer.Option(metavar="linear|huber|soft_l1|cauchy", help="Loss; all but linear forgive."),
    ] = "linear",
    starts: Annotated[int, typer.Option(min=1, help="Searches from further start values.")] = 1,
    workers: Workers = 1,
    page: Annotated[
        Path | None, typer.Option("--html", metavar="PAGE.html", help="Write a page, too.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No summary.")] = False,
    trust: Trust = False,
) -> None:
    """Find parameters of a model from measured records, and how sure they are.

    Channels are compared with the sensors of their name, and drive the inputs of their name. With
    -o the model file is written with the new values; its comments and units stay.
    """
    from jousto.design.identification.identify import identify as found_from
    from jousto.design.identification.modal import read_modes
    from jousto.schema.file.new_values import with_values
    from jousto.schema.read import read_model

    problems: list[Problem] = []
    for test in (
        lambda: check_targets({page: ("html", "htm")}),
        lambda: output and _target(output, model),
    ):
        problems += problems_of(test)
    file = read_model(model, trust=trust)
    parameters = _freed(problems, free, file)
    if output is not None:  # before the search: whether the values can be written
        old = {p.name: p.value for p in parameters}
        problems += problems_of(lambda: with_values(file.text, old, model.name))
    settings = {
        "pairs": _pairs(problems, "--pair", pair),
        "noise": _pairs(problems, "--noise", noise),
        "units": _pairs(problems, "--unit", unit),
    }
    sought = {"gain": gain or [], "bias": bias or [], "shift": shift or []}
    fitted = _read(problems, file, measured or [], settings, sought)
    checked = _read(problems, file, check or [], settings, dict.fromkeys(sought, []))
    _unused(problems, [*fitted, *checked], settings, sought)
    tests: list[Modal] = []
    for path in hammer or ():
        try:
            tests.append(read_modes(path))
        except InputError as error:
            problems += error.problems
    if not measured and not hammer:
        problems.append(Problem("--measured", "no record; give --measured FILE or --modes FILE"))
    if problems:
        raise InputError(problems)
    found = found_from(
        file,
        parameters,
        [*fitted, *tests],
        check=checked,
        loss=loss,
        starts=starts,
        workers=workers,
    )
    if not quiet:
        say(str(found))
    if output is not None:
        named = {p.name for p in parameters}
        values = {name: value for name, value in found.values.items() if name in named}
        text = with_values(file.text, values, model.name)
        head = _head(found, [*(measured or []), *(hammer or []), *(check or [])], model)
        with written(_target(output, model)) as beside:
            beside.write_text(head + text, encoding="utf-8")
        say(f"model with the new values in {output}", style="green")
    if page is not None:
        from jousto.output.write import write

        write(found, page)
        say(f"page in {page}", style="green")


def _target(path: Path, model: Path) -> Path:
    """Return the path of the new model file; only files of this command are overwritten.

    Raises
    ------
    InputError
        If the path is the model, another file, or cannot be written.
    """
    from jousto.schema.output_paths import output_path

    if path.is_file() and path.stat().st_size:
        with path.open("rb") as opened:
            ours = opened.read(len(MARK)) == MARK.encode()
        if not ours:
            message = "holds a file that this command has not written; give another -o FILE"
            raise InputError(Problem(str(path), message))
        if path.samefile(model):
            raise InputError(Problem(str(path), "is the model, it would be overwritten"))
        return path
    return output_path(path, model, ".yaml")


def _head(found: Identified, files: Sequence[Path], model: Path) -> str:
    """Return comments on where the values of a model file come from."""
    from datetime import date
    from hashlib import sha256

    lines = [f"{MARK} of {model.name} on {date.today().isoformat()} from"]
    for path in files:
        digest = sha256(path.read_bytes()).hexdigest()[:16]
        lines.append(f"#   {path.name} (sha256 {digest})")
    lines += [f"# {line}".rstrip() for line in str(found).splitlines()]
    return "\n".join(lines) + "\n"


def _freed(problems: list[Problem], given: list[str] | None, file: ModelFile) -> list[Parameter]:
    """Return the parameters to seek."""
    known = {p.name: p for p in file.parameters}
    if not given:
        found = [p for p in known.values() if p.bounds is not None]
        if not found:
            problems.append(Problem("--free", nothing_varied(known).replace("vary", "seek")))
        return found
    found = []
    for text in given:
        axes: dict[str, list[float]] = {}
        try:
            one = varied(text, known, axes, "--free")
        except InputError as error:
            problems += error.problems
            continue
        if axes:
            problems.append(Problem(f"--free {one.name}", "must have bounds, such as 2..8mm"))
        found.append(one)
    return found


def _pairs(problems: list[Problem], option: str, given: list[str] | None) -> Pairs:
    """Return the pairs of an option ``NAME=VALUE``."""
    found: Pairs = {}
    for text in given or ():
        name, equals, value = (piece.strip() for piece in text.partition("="))
        if not equals or not name or not value:
            problems.append(Problem(option, f"is {text!r}, must be CHANNEL=..."))
        elif name in found:
            problems.append(Problem(option, f"{name} is given twice"))
        found[name] = value
    return found


def _read(
    problems: list[Problem],
    file: ModelFile,
    paths: Sequence[Path],
    settings: dict[str, Pairs],
    sought: dict[str, list[str]],
) -> list[Experiment]:
    """Return the experiments of files, with what the options say of their channels."""
    from jousto.design.identification.experiment import Experiment
    from jousto.design.studies.parameters.parameter import Parameter
    from jousto.measurement.gauges.read import read_record
    from jousto.model.compile import compile

    found: list[Experiment] = []
    inputs = compile(file.mechanism).inputs if paths else ()
    for path in paths:
        try:
            heads = read_record(path, units=_of_file(path, settings["units"]))
            free: dict[str, Any] = {}
            for what, start in (("gain", 1.0), ("bias", 0.0), ("shift", 0.0)):
                own = [channel for channel in sought[what] if channel in heads]
                free[what] = {
                    channel: Parameter(
                        f"{what} {channel}",
                        start,
                        unit={"gain": "1", "bias": heads.units[channel] or "1", "shift": "s"}[what],
                    )
                    for channel in own
                }
            drives, compared = _meetings(heads, settings["pairs"], inputs)
            found.append(
                Experiment(
                    heads,
                    outputs=compared,
                    inputs=drives,
                    noise=_noise(problems, heads, settings["noise"]),
                    name=path.name,
                    **free,
                )
            )
        except InputError as error:
            problems += error.problems
    return found


def _of_file(path: Path, units: Pairs) -> Pairs | None:
    """Return the given units; those of channels that a file does not have are left out."""
    if not units:
        return None
    try:
        from jousto.measurement.gauges.read import read_record

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", JoustoWarning)
            known = read_record(path)
    except InputError:
        return units
    return {name: unit for name, unit in units.items() if name in known}


def _meetings(
    record: Record, pairs: Pairs, inputs: Sequence[str]
) -> tuple[Pairs | None, Pairs | None]:
    """Return channels by input and by sensor; None where names decide."""
    drives = {name: name for name in inputs if name in record}
    compared: Pairs = {}
    for channel, name in pairs.items():
        if channel not in record:
            continue
        turned = name.startswith("-")
        name = name.removeprefix("-")
        if name in inputs and not turned:
            drives[name] = channel
        else:
            compared[name] = f"-{channel}" if turned else channel
    if not pairs:
        return None, None
    return drives, compared or None


def _noise(problems: list[Problem], record: Record, given: Pairs) -> dict[str, Any]:
    """Return the noise of the channels of a record: a number in SI, or a share of the reading."""
    from jousto.cli.options import value_of

    found: dict[str, Any] = {}
    for channel, text in given.items():
        if channel not in record:
            continue
        if "%" in text or text in record:
            found[channel] = text
            continue
        try:
            found[channel] = value_of(text, record.units[channel] or "1", f"--noise {channel}")
        except InputError as error:
            problems += error.problems
    return found


def _unused(
    problems: list[Problem],
    experiments: Sequence[Experiment],
    settings: dict[str, Pairs],
    sought: dict[str, list[str]],
) -> None:
    """Report channels of options that no file has."""
    known = {name for one in experiments for name in one.record.channels}
    if not known:
        return
    given = {"--pair": settings["pairs"], "--noise": settings["noise"], "--unit": settings["units"]}
    for option, names in (*given.items(), *((f"--{what}", own) for what, own in sought.items())):
        for name in names:
            if name not in known:
                problems.append(Problem(option, f"no channel {name!r}{suggest(name, known)}"))
