"""Every public object shows as ``<Kind 'name': facts>``, or as its short constructor."""

from __future__ import annotations

import dataclasses
import inspect
import re
import warnings
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

import jousto as jo
import session
from jousto.base.object_repr import FEW, LIMIT, describe, described

PUBLIC = {
    place.rpartition(".")[2]: thing
    for place, thing in session.public().items()
    if not place.startswith("jo.planar.") or place == "jo.planar.PlanarFrame"
}
CLASSES = sorted(
    name
    for name, thing in PUBLIC.items()
    if inspect.isclass(thing) and not issubclass(thing, BaseException)
)
# numbers, words and tuples of them
PLAIN = re.compile(
    r"(?:float|int|str|bool|None|\"\w+\"|or|\{[^}]*\}|Literal\[[^\]]*\]|tuple\[(?:float|int|str|bool)"
    r"(?:, (?:float|int|str|bool|\.\.\.))*\]|\s|\|)+"
)
# values that keep the form of their constructor although they hold others or short vectors
VALUES = {
    *("Harmonic", "Constant", "ConstantSpeed", "Input", "Sum", "Product"),
    *(
        "RK4",
        "ROS2",
        "SSPRK3",
        "ROS3A",
        "InertiaRelief",
        "InBox",
        "MagicFormula",
        "InCylinder",
        "InSphere",
        "Nearest",
    ),
}
BASES = {"MeanStress", "Outcome"}  # their kinds show themselves
NOT_MADE = {"Matrices", "FourierLoads", "Histories"}  # of other programs, and of moving twins


def generated(kind: type) -> bool:
    """Whether the class shows as its constructor, of a dataclass or a class compared by value."""
    by_value = kind.__repr__.__module__ == "jousto.base.constructor"
    return dataclasses.is_dataclass(kind) and (by_value or hasattr(kind.__repr__, "__wrapped__"))


@pytest.mark.parametrize("name", sorted(set(CLASSES) - BASES))
def test_every_public_class_shows_itself(name: str) -> None:
    assert PUBLIC[name].__repr__ is not object.__repr__, "decorate it with @described"


GENERATED = sorted(name for name in set(CLASSES) - BASES - VALUES if generated(PUBLIC[name]))


@pytest.mark.parametrize("name", GENERATED)
def test_no_public_class_prints_its_arrays(name: str) -> None:
    kind = PUBLIC[name]
    declared = getattr(kind, "fields", {})  # whose classes say what they hold as help does
    fields = [
        declared[f.name].noun if f.name in declared else str(f.type)
        for f in dataclasses.fields(kind)
        if f.repr
    ]
    assert all(PLAIN.fullmatch(text) for text in fields), "decorate it with @described"


def test_both_kinds_of_classes_are_known() -> None:
    assert VALUES | BASES <= set(CLASSES)
    assert len(GENERATED) > 10


def machine() -> list[object]:
    """Objects with arrays, markers and other objects in their fields."""
    many = {f"p{i}": (0, 0, i) for i in range(99)}
    body = jo.RigidBody.sphere("ball", 0.1, mass=1.0, markers=many)
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"])
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    cells = jo.mesh.Cells("tetra", [(0, 1, 2, 3)] * 5000)
    model = jo.compile(jo.Mechanism(body, hinge))
    return [
        *(body, hinge, hinge.angle, model, jo.model.Engine(model), cells),
        *(jo.Initial(hinge.angle, rate=1.0), jo.Drive("d", hinge.angle, jo.ConstantSpeed(1.0))),
        jo.Mesh("wedge", corners, cells, node_sets={f"set {i}": [0, 1] for i in range(1000)}),
        jo.Table(np.arange(9999), np.arange(9999)),
        jo.SCurve(np.arange(9999), np.arange(9999)),
        jo.Spring("s" * 500, hinge.angle, 1.0),
        jo.Bushing("b", jo.ground["origin"], body["origin"], 3.0),
        jo.UserForce("u", body["origin"], lambda t, x: [0.0] * 6),
        jo.PositionSensor("p", body["p7"]),
        jo.CoordinateSensor("c", hinge.angle),
        *(jo.Gravity((0, 0, -9.81)), jo.Friction("f", hinge, 0.1, radius=0.02)),
        *(jo.doctor(model), jo.simulation.State(np.zeros(9999), np.zeros(9999), np.zeros(3))),
        *(jo.RK4(1e-3), jo.material("S355"), jo.Rectangle(0.1, 0.2)),
        jo.Rotate((0, 0, 1), degrees=3),
    ]


@pytest.mark.filterwarnings("ignore:.*moves freely")
def test_objects_are_short_and_say_what_they_are() -> None:
    for thing in machine():
        shown, kind = repr(thing), type(thing).__name__
        assert len(shown) < LIMIT, kind
        assert "\n" not in shown
        assert shown.startswith((f"<{kind}", f"{kind}(")), shown


def test_what_is_said_of_fields() -> None:
    @described
    @dataclasses.dataclass
    class Thing:
        name: str
        few: object
        many: object
        table: dict
        word: str
        none: None = None

    shown = repr(Thing("x", (1, 2.5), np.zeros((3, 4)), {"a": 1}, "w" * 99))
    assert shown.startswith("<Thing 'x': few (1, 2.5), many (3, 4), table 1 entry, word 'www")
    assert "none" not in shown
    long = Thing("y", [0] * 9, np.zeros(2), {}, "z")
    assert repr(long) == "<Thing 'y': few 9 items, many (0, 0), table 0 entries, word 'z'>"
    assert describe(long) == repr(long)


def within_reach(path: str, thing: Any, found: dict[int, tuple[str, Any]]) -> None:
    """Gather what can be reached from an object through public attributes and items."""
    # arrays with names have the attributes of NumPy's, which do not always work
    ours = type(thing).__module__.partition(".")[0] == "jousto" and not isinstance(
        thing, np.ndarray
    )
    if id(thing) in found or not (ours or isinstance(thing, tuple | list | Mapping)):
        return
    found[id(thing)] = path, thing
    inside: list[tuple[str, Any]] = []
    if ours:
        names = [name for name in dir(thing) if not name.startswith("_")]
        fixed = [name for name in names if not callable(getattr(type(thing), name, None))]
        for name in fixed:
            with suppress(jo.JoustoError):  # says what is not known of this one
                inside.append((f"{path}.{name}", getattr(thing, name)))
    if isinstance(thing, Mapping):
        inside += [(f"{path}[{key!r}]", thing[key]) for key in list(thing)[:FEW]]
    elif isinstance(thing, tuple | list):
        inside += [(f"{path}[{i}]", item) for i, item in enumerate(thing[:FEW])]
    for where, item in inside:
        within_reach(where, item, found)


RULE = re.compile(r"<(\w+)(?: '[^']*')?(?:: .+)?>|(\w+)\(.*\)")


@pytest.fixture(scope="module")
def reached() -> dict[int, tuple[str, Any]]:
    """Everything that can be reached from the objects of a working day."""
    found: dict[int, tuple[str, Any]] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name, thing in session.objects().items():
            within_reach(name, thing, found)
    return found


def test_whatever_a_session_holds_is_short_and_says_what_it_is(
    reached: dict[int, tuple[str, Any]],
) -> None:
    wrong = []
    for path, thing in reached.values():
        if type(thing).__module__.partition(".")[0] != "jousto":
            continue
        shown, kind = repr(thing), type(thing).__name__
        match = RULE.fullmatch(shown)
        told = isinstance(thing, Mapping) or (match and kind in match.groups())
        good = told and len(shown) < LIMIT and "\n" not in shown
        if not good or "object at 0x" in shown or "array(" in shown:
            wrong.append(f"{path}, {len(shown)} characters: {shown[:LIMIT]}")
    assert not wrong, "\n".join(wrong)


def test_results_say_what_matters() -> None:
    """Numbers by closed forms or of the objects themselves, without noise of 1e-18."""
    made = session.objects()
    hole, run, spots, field = (made[k] for k in ("hole", "run", "spots", "damage field"))
    assert repr(hole) == (
        "<Hole 'hole1': point (0, 0, 0.025), axis (0, 0, 1), radius 0.04, length 0.05, "
        f"nodes ({len(hole.nodes)},)>"
    )
    assert repr(run.energy) == f"<Energy: 301 instants, {run.energy.verdict[7:]}>"
    assert "301 instants, position up to" in repr(run.residuals)
    assert f"{run.work.steps[-1]:.0f} steps, 0 rejected" in repr(run.work)
    worst = spots[0]
    assert f"worst {worst.value / 1e6:.6g} MPa at {worst.site} of 'arm'" in repr(spots)
    assert f"{worst.value:.6g} at {worst.site} of 'arm'" in repr(worst)
    assert f"damage {field.damage.max():.4g}" in repr(field) and "72 places of 'arm'" in repr(field)
    assert "largest range 4e+08, residue 'half'" in repr(made["cycles"])
    assert "10 rows, 12 motions, 2 motions of rigid bodies" in repr(made["doctor"])
    assert repr(made["solvers"]).startswith("(<SolverInfo 'pardiso': ")


def test_results_whose_file_is_gone_still_show(tmp_path: Any) -> None:
    run = session.objects()["filed"]
    kept = jo.load(run.save(tmp_path / "kept.h5"))
    (tmp_path / "kept.h5").unlink()
    assert repr(kept) == "<Solution 'swing': its file is gone, overwritten or damaged>"


def test_the_session_holds_what_functions_return(reached: dict[int, tuple[str, Any]]) -> None:
    """The walk is worth something only if it comes past the results that users meet."""
    kinds = {type(thing).__name__ for _, thing in reached.values()}
    functions = [one for one in PUBLIC.values() if inspect.isfunction(one)]
    returned = {str(inspect.signature(one).return_annotation) for one in functions}
    assert returned & set(CLASSES) - NOT_MADE - BASES <= kinds
