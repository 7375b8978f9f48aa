"""plot and write find the function for a thing; what they say of others."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import get_overloads

import pytest

import jousto as jo
from jousto.output.dispatch import implementation
from jousto.output.plot import BEAM, DRAWN, plot as undecorated_plot
from jousto.output.write import WRITTEN, write as undecorated_write
from session import objects


def named(what: object) -> set[str]:
    """Return the names of the arguments behind the first."""
    return set(list(inspect.signature(what).parameters)[1:])  # type: ignore[arg-type]


def kinds(what: object) -> list[str]:
    first = next(iter(inspect.signature(what).parameters.values()))  # type: ignore[arg-type]
    return [word.split("[")[0] for word in str(first.annotation).split(" | ")]


def test_what_type_checkers_see_of_plot_is_what_there_is() -> None:
    seen: dict[str, set[str]] = {}
    for one in get_overloads(inspect.unwrap(undecorated_plot)):
        for kind in kinds(one):
            place = BEAM if "beam" in named(one) else DRAWN.get(kind)
            if place is not None:  # Sequence and Mapping are of things that stand beside them
                assert named(one) == named(implementation(place)), kind
                seen.setdefault(kind, set())
    assert set(seen) == set(DRAWN)


def test_what_type_checkers_see_of_write_is_what_there_is() -> None:
    seen: dict[str, set[str]] = {}
    for one in get_overloads(inspect.unwrap(undecorated_write)):
        for kind in kinds(one):
            seen.setdefault(kind, set()).update(named(one))
    assert set(seen) == set(WRITTEN)
    for kind, formats in WRITTEN.items():
        assert seen[kind] == set().union(*(named(implementation(p)) for p in formats.values()))


def test_help_names_all_options() -> None:
    for verb, places in (
        (jo.plot, [*DRAWN.values(), BEAM]),
        (jo.write, [place for formats in WRITTEN.values() for place in formats.values()]),
    ):
        text = inspect.getdoc(verb) or ""
        for place in places:
            for name, one in inspect.signature(implementation(place)).parameters.items():
                if one.kind is one.KEYWORD_ONLY and name not in ("path", "sensors"):
                    assert f"`{name}`" in text or f"``{name}=" in text, f"{place}, {name}"


def test_things_that_cannot_be_drawn_or_written() -> None:
    with pytest.raises(jo.InputError, match="plot: does not accept a Material; known: Solution, "):
        jo.plot(jo.material("S355"))  # type: ignore[call-overload]
    with pytest.raises(jo.InputError, match="write: does not accept a str; known: Solution, "):
        jo.write("a", "b.csv")  # type: ignore[call-overload]


def test_arguments_that_are_missing_or_unknown(tmp_path: Path) -> None:
    made = objects()
    wanted = "plot of a DamageField: missing a required argument: 'run'; it takes run, quantity"
    with pytest.raises(TypeError, match=wanted):
        jo.plot(made["damage field"])
    with pytest.raises(TypeError, match="unexpected keyword argument 'site'; it takes sites, crit"):
        jo.plot(made["response"], "e1.a.top", site="e1.a.top")
    with pytest.raises(TypeError, match=".vtu of a StressField: missing a .* 'run'"):
        jo.write(made["field"], tmp_path / "field.vtu")
    with pytest.raises(jo.InputError, match=r"such as jo.write\(found, path, run, ...\)$"):
        jo.write(made["spots"], tmp_path / "spots.vtu")
    wanted = r"several runs need a label each: jo.plot\({'run 1': ..., 'run 2': ...}, ...\)"
    with pytest.raises(jo.InputError, match=wanted):
        jo.plot([made["run"], made["run"]], "tip")
    with pytest.raises(jo.InputError, match="'.txt' is not a format .* known: .csv, .vtu, .pvd"):
        jo.write(made["run"], tmp_path / "run.txt")
    with pytest.raises(jo.InputError, match=r"known: .*; its method save\(path\) writes .h5"):
        jo.write(made["run"], tmp_path / "run.h5")


def test_several_curves_and_several_runs() -> None:
    made = objects()
    assert len(jo.plot([made["curve"], made["curve"]]).axes[0].get_lines()) == 2
    assert jo.plot({"one": made["run"], "two": made["run"]}, "energy").legends
