"""Problems carry the path of their field; no message is searched for words."""

from __future__ import annotations

import inspect
import pickle
import textwrap
import warnings

import pytest

import jousto as jo
from jousto.base.declare import SECTIONS
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Items, OptionalItem, field
from jousto.base.numbers import Number, Numbers, Values, Whole
from jousto.schema.make.builder import Builder
from jousto.schema.read import parse_model


def found(make, *given, **named) -> list[Problem]:
    with pytest.raises(InputError) as error:
        make(*given, **named)
    return list(error.value.problems)


def test_a_field_of_each_type_is_named():
    from jousto.base.declare import Declared

    class Thing(Declared):
        kind = "thing"
        width: Number = field("w", unit="m", above=0)
        count: Whole = field("n", least=1)
        factors: Numbers = field("f")
        table: Values = field("t", shape=(None, 2))
        inner: OptionalItem[jo.Material] = field("i", label="the inner one", key="core")
        more: Items[jo.Material] = field("m", default=())

    problems = found(Thing, -1, 0, [1, 0], [[1, float("nan")]], 3, [4])
    paths = [("width",), ("count",), ("factors", 1), ("table", 0, 1), ("core",), ("more", 0)]
    assert [p.path for p in problems] == paths
    assert problems[0].where == "thing" and problems[0].sentence.startswith("width is -1 m")


def test_a_message_without_its_field_shows_it_in_python():
    problems = Problems()
    problems.add("load 'f'", "'n9' is not a node", "path", 2, named=False)
    (problem,) = problems.found
    assert str(problem) == "load 'f': path.2: 'n9' is not a node"
    assert problem == Problem("load 'f'", "'n9' is not a node")  # where it stands is no part of it
    outer = problem.inside("machine 'm'", "forces", 1)
    assert outer.path == ("forces", 1, "path", 2)
    assert str(outer) == "machine 'm': forces.1.path.2: load 'f': path.2: 'n9' is not a node"
    assert pickle.loads(pickle.dumps(outer)).path == outer.path


def test_warnings_carry_their_field():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        jo.Material(210000, 0.3, 7850)
    (warning,) = [item.message for item in caught]
    assert warning.path == ("E",) and warning.where == "material"
    assert str(warning) == f"material: {warning.message}"


MODEL = """
bodies:
  - {name: rod, mass: 1, inertia: [1, 1, 1], markers: {tip: [1, 0, 0]}}
joints:
  - {type: revolute, name: j, a: ground.origin, b: rod.origin, axis: [0, 0, 1]}
forces:
  - {type: force, name: f, marker: rod.tip, vector: [1, 0, 0]}
  - type: servo
    name: hold
    coordinate: j.angle
    reference: 0
    kp: 1
"""


def test_a_word_of_another_field_in_a_message_leads_nowhere_else():
    """The message begins with the word of a field that it is not about."""
    text = MODEL + "    limit:\n      -1\n"
    with pytest.raises(InputError) as error:
        parse_model(text)
    assert str(error.value).startswith("model:13: forces.1.limit: limit is -1, must be positive")


def test_every_check_between_fields_names_fields_of_its_class():
    """A path that no field has would be dropped without a word."""
    import ast

    wrong = []
    for section in SECTIONS.values():
        for cls in section.values():
            own = vars(cls).get("consistent")
            if own is None or not cls.__module__.startswith("jousto."):
                continue
            tree = ast.parse(textwrap.dedent(inspect.getsource(own)))
            for call in ast.walk(tree):
                if isinstance(call, ast.Call) and ast.unparse(call.func) == "problems.add":
                    for one in call.args[2:3]:
                        if isinstance(one, ast.Constant):
                            keys = {*cls.fields, *(kind.key for kind in cls.fields.values())}
                            if one.value not in keys:
                                wrong.append((cls.__name__, ast.unparse(call)))
    assert not wrong


def test_the_reader_of_models_searches_no_message():
    source = inspect.getsource(inspect.getmodule(Builder))
    assert "import re\n" not in source
