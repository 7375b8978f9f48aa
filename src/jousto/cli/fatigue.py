"""The command that computes the life of parts: fatigue."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.cli.group import command
from jousto.cli.hotspots import plane_or_name
from jousto.cli.options import From, Output, Residue, Table, To, Vtu, amount, instant, tell_files
from jousto.cli.terminal import FAILED, say

if TYPE_CHECKING:
    from jousto.fatigue.cycles.duty import DutyCycle
    from jousto.fatigue.miner.check import FatigueCheck
    from jousto.fatigue.miner.damage_field import DamageField
    from jousto.materials.strength.mean_stress import MeanStress
    from jousto.materials.strength.sn import SN
    from jousto.schema.make.blocks.fatigue import Fatigue
    from jousto.simulation.results.solution import Solution


@command()
def fatigue(
    results: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="RESULT...", help="Results files; several are events of a duty cycle."
        ),
    ] = None,
    sn: Annotated[
        str | None,
        typer.Option(
            "--sn",
            metavar="NAME|FILE",
            help="S-N curve: a name of the model's fatigue block or of the library (RQC-100,"
            " S355), a weld class (fat71, fat71-en) or a YAML file. Without it the checks of the"
            " model.",
        ),
    ] = None,
    residue: Residue = None,
    bodies: Annotated[
        list[str] | None, typer.Option("--body", metavar="BODY", help="Bodies; all if none.")
    ] = None,
    sites: Annotated[
        list[str] | None, typer.Option("--site", metavar="SITE", help="Sites or node sets.")
    ] = None,
    criterion: Annotated[
        str,
        typer.Option(
            "--criterion",
            metavar="NAME",
            help="signed-von-mises, signed-principal, s11 .. s13, critical-plane or normal:x,y,z.",
        ),
    ] = "signed-von-mises",
    mean: Annotated[
        str | None,
        typer.Option(
            "--mean",
            metavar="RULE",
            help="Mean stress: 'goodman 500 MPa', 'gerber 500 MPa', 'morrow 900 MPa',"
            " 'soderberg 355 MPa', swt, 'walker 0.6', 'fkm 0.2'.",
        ),
    ] = None,
    duty: Annotated[
        Path | None,
        typer.Option("--duty", metavar="FILE.yaml", help="Duty cycle: results and repeats."),
    ] = None,
    transitions: Annotated[
        str | None,
        typer.Option(
            "--transitions", metavar="separate|sequence|worst", help="Between several results."
        ),
    ] = None,
    repeats: Annotated[
        list[float] | None,
        typer.Option("--repeats", metavar="N", help="Of each result, in their order; 1 if none."),
    ] = None,
    required: Annotated[
        str | None, typer.Option("--required", metavar="TIME", help="Life wanted, '10 years'.")
    ] = None,
    survival: Annotated[
        float | None, typer.Option("--survival", metavar="SHARE", help="Of parts, such as 0.975.")
    ] = None,
    allowable: Annotated[
        float, typer.Option("--allowable", metavar="SUM", help="Miner's sum that is allowed.")
    ] = 1.0,
    start: From = None,
    end: To = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="End with code 1 if a safety is below 1.")
    ] = False,
    csv: Table = None,
    output: Output = None,
    quantity: Annotated[
        str, typer.Option("--quantity", metavar="damage|life|safety", help="That -o draws.")
    ] = "damage",
    cycles: Annotated[
        Path | None,
        typer.Option(
            "--cycles", metavar="FILE.png|.csv", help="Draw or list the cycles of the worst place."
        ),
    ] = None,
    vtu: Vtu = None,
) -> None:
    """Count the cycles at every place and print damage and life.

    With several bodies, the output files are for the body with the largest damage. A safety
    below 1 means that the required life (or one repeat) exceeds the permitted damage.
    """
    from jousto.fatigue.miner.check import FatigueCheck
    from jousto.fatigue.miner.damage_field import damage_field

    span = (instant(start, "--from"), instant(end, "--to"))
    events = _events(results or [], repeats or [], transitions, duty)
    run = events.runs[0]
    known = _block(run)
    if sn is None:
        checks = _checks(run, known, bodies)
    else:
        options: dict[str, Any] = {"criterion": plane_or_name(criterion), "allowable": allowable}
        if mean is not None:
            options["mean"] = mean_rule(mean)
        if required is not None:
            options["required"] = amount(required, "s", "--required")
        if survival is not None:
            options["survival"] = survival
        curve = named_curve(sn, known)
        names = bodies or list(run.stressed)
        if not names:
            raise InputError(Problem(run.where, "no body with stress in these results"))
        places = tuple(sites) if sites else None
        options |= {"sn": curve, "residue": residue, "sites": places}
        checks = [FatigueCheck(body=name, **options) for name in names]
    found: list[tuple[DamageField, DutyCycle, FatigueCheck]] = []
    for check in checks:
        source = events.duty(check.body, check.sites, span)
        rule = residue or check.residue
        field = damage_field(source, check.sn, residue=rule, **check.options)
        if check.name != check.body:
            say(check.name, style="bold")
        say(str(field) + "\n")
        found.append((field, source, check))
    from jousto.base.ranking import largest

    worst = largest([item[0].damage.max(initial=0.0) for item in found])
    field, source, check = found[worst]
    tell_files(field, run, csv=csv, picture=output, vtu=vtu, quantity=quantity)
    if cycles is not None:
        _cycles(field, source, cycles)
    least = min(float(item[0].safety.min(initial=float("inf"))) for item in found)
    if strict and least < 1.0:
        say(f"not enough: the least safety is {least:.4g}", error=True, style="red")
        raise typer.Exit(FAILED)


@dataclass(frozen=True, eq=False)
class _Events:
    """Runs with the number of repeats of each."""

    runs: list[Solution]
    repeats: list[float]
    names: list[str]
    transitions: str | None

    def duty(self, body: str, sites: Any, span: tuple[float | None, float | None]) -> DutyCycle:
        """Return the duty cycle of a body."""
        from jousto.fatigue.cycles.duty import DutyCycle, DutyEvent
        from jousto.recovery.fields.build import stress_field

        found = [
            DutyEvent(stress_field(run, body, sites=sites, start=span[0], end=span[1]), times, name)
            for run, times, name in zip(self.runs, self.repeats, self.names, strict=True)
        ]
        return DutyCycle(found, transitions=self.transitions)


def _events(
    results: list[Path], repeats: list[float], transitions: str | None, duty: Path | None
) -> _Events:
    from jousto.schema.make.blocks.duty import read_duty
    from jousto.simulation.results.solution import load

    problems = Problems()
    if duty is not None:
        words = "results, repeats and transitions"
        for given, option in (
            (results, "RESULT"),
            (repeats, "--repeats"),
            (transitions, "--transitions"),
        ):
            if given:
                problems.add(
                    option,
                    f"cannot be combined with --duty: {duty.name} has {words}; leave one out",
                )
        problems.raise_if_any()
        content = read_duty(duty)
        return _Events(
            [load(path) for path, _, _ in content.events],
            [times for _, times, _ in content.events],
            [name for _, _, name in content.events],
            content.transitions,
        )
    if not results:
        problems.add("RESULT", "give a results file, or --duty FILE.yaml")
    if repeats and len(repeats) != len(results):
        problems.add("--repeats", f"given {len(repeats)} times for {len(results)} results")
    problems.raise_if_any()
    times = repeats or [1.0] * len(results)
    return _Events([load(p) for p in results], times, [p.stem for p in results], transitions)


def _block(run: Solution) -> Fatigue | None:
    """Return the fatigue block of the model whose results these are."""
    from jousto.schema.make.blocks.fatigue import parse_fatigue

    text = run.model_text
    return parse_fatigue(text, f"model in {run.path.name}") if text.strip() else None


def _checks(run: Solution, known: Fatigue | None, bodies: list[str] | None) -> list[FatigueCheck]:
    checks = [] if known is None else list(known.checks)
    if bodies:
        checks = [check for check in checks if check.body in bodies]
    if not checks:
        raise InputError(
            Problem(
                run.where,
                "its model has no fatigue: checks:"
                + (" of these bodies" if bodies else "")
                + "; give a curve, such as --sn fat71 --residue half",
            )
        )
    return checks


def check_fields(run: Solution, sn: str | None, residue: str | None) -> list[DamageField]:
    """Return the damage of bodies by the checks of the model, or of all bodies by one S-N curve."""
    from jousto.fatigue.miner.check import FatigueCheck
    from jousto.fatigue.miner.damage_field import damage_field
    from jousto.recovery.fields.build import stress_field

    known = _block(run)
    if sn is None:
        checks = _checks(run, known, None)
    else:
        given: dict[str, Any] = {"sn": named_curve(sn, known), "residue": residue}
        checks = [FatigueCheck(body=name, **given) for name in run.stressed]
    return [
        damage_field(
            stress_field(run, check.body, sites=check.sites),
            check.sn,
            residue=residue or check.residue,
            **check.options,
        )
        for check in checks
    ]


def named_curve(name: str, known: Fatigue | None) -> SN:
    """Return the S-N curve of an option: a name in the model, a file, or a name in the library."""
    from jousto.materials.strength.sn_library import sn_curve
    from jousto.schema.file.document import DOCUMENTS
    from jousto.schema.make.blocks.fatigue import read_curve

    curves = {} if known is None else known.curves
    if name in curves:
        return curves[name]
    if name.lower().endswith(DOCUMENTS):
        return read_curve(name)
    try:
        return sn_curve(name)
    except InputError:
        hint = suggest(name, [*curves, "fat71", "fat71-en", "S355", "RQC-100"])
        raise InputError(Problem("--sn", f"no S-N curve {name!r}{hint}")) from None


def mean_rule(text: str) -> MeanStress:
    """Return the mean-stress correction of an option such as 'goodman 500 MPa'."""
    from jousto.materials.strength.mean_stress import (
        FKM,
        SWT,
        Gerber,
        Goodman,
        Morrow,
        Soderberg,
        Walker,
    )

    word, _, value = text.strip().partition(" ")
    kinds: dict[str, Any] = {
        "goodman": (Goodman, "Pa"),
        "gerber": (Gerber, "Pa"),
        "morrow": (Morrow, "Pa"),
        "soderberg": (Soderberg, "Pa"),
        "walker": (Walker, "1"),
        "fkm": (FKM, "1"),
        "swt": (SWT, ""),
    }
    kind = word.lower()
    if kind not in kinds:
        raise InputError(Problem("--mean", f"no rule {word!r}{suggest(kind, kinds)}"))
    make, unit = kinds[kind]
    if bool(unit) != bool(value.strip()):
        example = {"Pa": f"'{kind} 500 MPa'", "1": f"'{kind} 0.2'", "": kind}[unit]
        raise InputError(Problem("--mean", f"is {text!r}, must be such as {example}"))
    return make() if not unit else make(amount(value, unit, "--mean"))  # type: ignore[no-any-return]


def _cycles(field: DamageField, source: DutyCycle, path: Path) -> None:
    """Draw the cycles of the place with the largest damage, or write them as CSV."""
    counted = field.cycles(source)
    if path.suffix.lower() == ".csv":
        counted.to_csv(path)
    else:
        from jousto.output.plot import plot

        plot(counted, field.sn, mean=field.mean, path=path)
    say(f"cycles of {field.worst(1)[0]} in {path}", style="green")
