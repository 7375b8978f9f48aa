"""Every public object shows as ``<Kind 'name': facts>``, or as its short constructor."""

from __future__ import annotations

import dataclasses
import inspect
import re

import numpy as np
import pytest

import jousto as jo
from jousto.described import LIMIT, describe, described

CLASSES = sorted(
    name
    for name in jo.__all__
    if inspect.isclass(getattr(jo, name)) and not issubclass(getattr(jo, name), BaseException)
)
# numbers, words and tuples of them
PLAIN = re.compile(
    r"(?:float|int|str|bool|None|Literal\[[^\]]*\]|tuple\[(?:float|int|str|bool)"
    r"(?:, (?:float|int|str|bool|\.\.\.))*\]|\s|\|)+"
)
# values that keep the form of their constructor although they hold others or short vectors
VALUES = {
    *("Harmonic", "Constant", "ConstantSpeed", "Input", "Sum", "Product"),
    *("RK4", "ROS2", "InertiaRelief", "InBox", "InCylinder", "InSphere", "Nearest"),
}
BASES = {"MeanStress"}  # their kinds show themselves


def generated(kind: type) -> bool:
    """Whether the class shows as the generated constructor of a dataclass."""
    return dataclasses.is_dataclass(kind) and hasattr(kind.__repr__, "__wrapped__")


@pytest.mark.parametrize("name", CLASSES)
def test_no_public_class_prints_its_arrays(name: str) -> None:
    kind = getattr(jo, name)
    if name in BASES:
        return
    assert kind.__repr__ is not object.__repr__, "decorate it with @described"
    if generated(kind) and name not in VALUES:
        fields = [str(f.type) for f in dataclasses.fields(kind) if f.repr]
        assert all(PLAIN.fullmatch(text) for text in fields), "decorate it with @described"


def machine() -> list[object]:
    """Objects with arrays, markers and other objects in their fields."""
    many = {f"p{i}": (0, 0, i) for i in range(99)}
    body = jo.RigidBody.sphere("ball", 0.1, mass=1.0, markers=many)
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"])
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    cells = jo.Cells("tetra", [(0, 1, 2, 3)] * 5000)
    model = jo.compile(jo.Mechanism(body, hinge))
    return [
        *(body, hinge, hinge.angle, model, jo.Engine(model), cells),
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
        *(jo.doctor(model), jo.State(np.zeros(9999), np.zeros(9999), np.zeros(3))),
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
    assert shown.startswith("<Thing 'x': few (1, 2.5), many (3, 4), table 1 entries, word 'www")
    assert "none" not in shown
    long = Thing("y", [0] * 9, np.zeros(2), {}, "z")
    assert repr(long) == "<Thing 'y': few 9 items, many (0, 0), table 0 entries, word 'z'>"
    assert describe(long) == repr(long)
