"""Commands of multiaxial and local fatigue: multiaxial, strain-life, hertz."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem, suggest
from jousto.cli.group import command
from jousto.cli.options import Output, Residue, Result, Table, amount, only_one, tell_files
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.recovery.fields.field import StressField

Body = Annotated[str | None, typer.Argument(metavar="[BODY]", help="Body; the only one if none.")]
Sites = Annotated[
    list[str] | None,
    typer.Option("--site", metavar="SITE", help="Places; else those of the largest stress."),
]
Count = Annotated[int, typer.Option("--count", metavar="N", help="Number of these places.")]


@command()
def multiaxial(
    result: Result,
    body: Body = None,
    criterion: Annotated[
        str,
        typer.Option(
            "--criterion",
            metavar="NAME",
            help="'findley 0.3', 'dang-van 0.36 155MPa' or normal-stress.",
        ),
    ] = "findley 0.3",
    sn: Annotated[
        str | None,
        typer.Option("--sn", metavar="NAME", help="S-N curve for damage, such as S355 or fat71."),
    ] = None,
    residue: Residue = None,
    sites: Sites = None,
    count: Count = 5,
    csv: Table = None,
) -> None:
    """Find the critical planes at the most stressed places; with --sn the damage of each plane."""
    from jousto.fatigue.multiaxial.counted_planes import PlaneDamage, plane_damage
    from jousto.fatigue.multiaxial.planes import DangVan, Multiaxial, multiaxial

    rule = _criterion(criterion)
    field = _field(result, body, sites, count)
    found: Multiaxial | PlaneDamage
    if sn is None:
        found = multiaxial(field, rule)
        say(str(found))
        if isinstance(rule, DangVan):
            say(f"least safety {found.safety.min():.4g}")
    else:
        from jousto.materials.strength.sn_library import sn_curve

        found = plane_damage(field, rule, sn_curve(sn), residue=_residue(residue))
        say(str(found))
    tell_files(found, csv=csv)


@command("strain-life")
def strain_life_command(
    result: Result,
    body: Body = None,
    material: Annotated[
        str, typer.Option("--material", metavar="NAME", help="Such as sae-1045 or rqc-100.")
    ] = "",
    residue: Residue = None,
    criterion: Annotated[
        str, typer.Option("--criterion", metavar="NAME", help="Stress that is followed.")
    ] = "signed-von-mises",
    rule: Annotated[
        str, typer.Option("--rule", metavar="neuber|glinka|elastic", help="Notch rule.")
    ] = "neuber",
    form: Annotated[
        str, typer.Option("--form", metavar="swt|morrow|coffin-manson", help="Mean stress.")
    ] = "swt",
    sites: Sites = None,
    count: Count = 5,
    csv: Table = None,
    output: Output = None,
) -> None:
    """Compute local stress and strain at the most stressed places and count hysteresis loops."""
    from jousto.fatigue.local.strain_life import strain_damage
    from jousto.materials.strength.strain_life import strain_life, strain_lives

    if not material:
        raise InputError(Problem("--material", f"is missing; known: {', '.join(strain_lives())}"))
    curve = strain_life(material)
    options: Any = {"residue": _residue(residue), "rule": rule, "form": form}
    field = _field(result, body, sites, count)
    found = strain_damage(field, curve, criterion=criterion, **options)
    say(str(found))
    tell_files(found, csv=csv)
    if output is not None:
        from jousto.base.ranking import ranking
        from jousto.output.plot import plot

        worst = found.labels[ranking(found.damage, found.labels)[0]]
        series = field.only([worst]).values(criterion)[:, 0]
        plot(curve, series, rule=options["rule"], path=output)
        say(f"loops of {worst} in {output}", style="green")


@command()
def hertz(
    force: Annotated[str, typer.Option("--force", metavar="F", help="Normal force, '10 kN'.")],
    radius: Annotated[str, typer.Option("--radius", metavar="R", help="Radius, '100 mm'.")],
    length: Annotated[
        str | None, typer.Option("--length", metavar="L", help="Length of a line contact.")
    ] = None,
    crown: Annotated[
        str | None,
        typer.Option("--crown", metavar="R", help="Second radius of a point contact."),
    ] = None,
    material: Annotated[
        str, typer.Option("--material", metavar="NAME", help="Of both bodies.")
    ] = "steel",
    friction: Annotated[
        float, typer.Option("--friction", metavar="MU", help="Tangential over normal traction.")
    ] = 0.0,
) -> None:
    """Compute pressure and stress of a wheel on a flat rail, in line or point contact."""
    from jousto.fatigue.contact.contact import hertz_line, hertz_point, shakedown_limit
    from jousto.materials.library import material as named

    if (length is None) == (crown is None):
        message = "give --length of a line contact or --crown of a point contact"
        raise InputError(Problem("hertz", message))
    F, R = amount(force, "N", "--force"), amount(radius, "m", "--radius")
    both = named(material)
    if length is not None:
        contact = hertz_line(F, length=amount(length, "m", "--length"), radius=R, material=both)
    else:
        contact = hertz_point(F, radii=(R, amount(crown, "m", "--crown")), material=both)
    shear, depth = contact.largest_shear()
    say(str(contact))
    note = " on the axis, without friction" if friction else ""
    say(f"largest shear{note} {1e-6 * shear:.4g} MPa, {1e3 * depth:.4g} mm deep")
    if friction:
        say(f"shear at the surface {1e-6 * friction * contact.p0:.4g} MPa by friction {friction:g}")
    if contact.kind == "line":
        k = contact.p0 / shakedown_limit(friction)
        say(f"shakes down if the material yields in shear above {1e-6 * k:.4g} MPa")


def _field(result: Path, body: str | None, sites: list[str] | None, count: int) -> StressField:
    """Return the stress at the named places, or at those with the largest von Mises stress."""
    from jousto.base.ranking import ranking
    from jousto.recovery.fields.build import stress_field
    from jousto.simulation.results.solution import load

    run = load(result)
    body = body or only_one(run.stressed, run.where, "bodies", "no body has stress data")
    if count < 1:
        raise InputError(Problem("--count", f"is {count}, must be 1 or more"))
    field = stress_field(run, body, sites=tuple(sites) if sites else None)
    if sites:
        return field
    top = field.envelope("von-mises").max
    return field.take(ranking(top, field.labels)[:count])


def _residue(residue: str | None) -> Any:
    if residue is None:
        raise InputError(
            Problem(
                "--residue",
                "is missing: half (ASTM), repeat (the run is repeated) or ignore; lives "
                "may differ tenfold",
            )
        )
    return residue


def _criterion(text: str) -> Any:
    """Return the criterion of an option such as 'findley 0.3'."""
    from jousto.fatigue.multiaxial.planes import DangVan, Findley, NormalStress

    words = text.replace(",", " ").split()
    known = ("findley", "dang-van", "normal-stress")
    kind = words[0].lower() if words else ""
    if kind == "normal-stress" and len(words) == 1:
        return NormalStress()
    if kind == "findley" and len(words) == 2:
        return Findley(_number(words[1]))
    if kind == "dang-van" and len(words) >= 3:
        return DangVan(_number(words[1]), amount(" ".join(words[2:]), "Pa", "--criterion"))
    if kind in known:
        message = f"is {text!r}, must be such as 'findley 0.3' or 'dang-van 0.36 155 MPa'"
    else:
        message = f"no criterion {kind!r}{suggest(kind, known)}"
    raise InputError(Problem("--criterion", message))


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(Problem("--criterion", f"{text!r} is not a number")) from None
