"""Reading YAML: values, lines, and every way a file can be broken."""

from __future__ import annotations

import json
import math
import re

import pytest

from jousto.base.errors import InputError
from jousto.schema.file.document import parse_document, read_document


def problems(text: str, name: str = "m.yaml") -> list[str]:
    with pytest.raises(InputError) as error:
        parse_document(text, name=name)
    return [str(problem) for problem in error.value.problems]


def test_values_are_yaml_1_2_and_floats_without_a_dot_are_numbers():
    data = parse_document(
        "a: 1e9\nb: 1.5E-3\nc: .nan\nd: -.inf\ne: 0x10\nf: yes\ng: true\nh: ~\ni: '1e9'\n"
        "j: 210 GPa\nk: 2024-01-01\nl: 012\nm: 1_000\nn: +3\n"
    ).data
    assert math.isnan(data.pop("c"))
    assert data == {
        "a": 1e9, "b": 1.5e-3, "d": -math.inf, "e": 16, "f": "yes", "g": True, "h": None,
        "i": "1e9", "j": "210 GPa", "k": "2024-01-01", "l": 12, "m": 1000, "n": 3,
    }  # fmt: skip


def test_every_entry_knows_its_line():
    document = parse_document(
        "# comment\nname: x\njoints:\n  - type: a\n    b: 1\n  - {type: b,\n     b: 2}\n"
    )
    assert document.line(("name",)) == 2
    assert document.line(("joints", 0)) == 4
    assert document.line(("joints", 0, "b")) == 5
    assert document.line(("joints", 1, "type")) == 6
    assert document.line(("joints", 1, "b")) == 7
    # what is not there is where it belongs
    assert document.line(("joints", 1, "nothing")) == 6
    assert document.where(("joints", 0, "b")) == "model:5: joints.0.b"


def test_anchors_and_merge_keys_keep_the_line_of_the_text():
    document = parse_document("a: &a {x: 1, y: 2}\nb:\n  <<: *a\n  y: 3\nc: *a\n")
    assert document.data["b"] == {"x": 1, "y": 3}
    assert document.data["c"] == {"x": 1, "y": 2}
    assert document.line(("b", "y")) == 4


def test_json_with_tabs_is_read_with_lines():
    text = json.dumps({"name": "x", "bodies": [{"a": 1e-3}]}, indent="\t")
    document = parse_document(text, name="m.json")
    assert document.data == {"name": "x", "bodies": [{"a": 1e-3}]}
    assert document.line(("bodies", 0, "a")) == 5


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ["m.yaml: is empty"]),
        ("# only a comment\n", ["m.yaml: is empty"]),
        ("- 1\n", ["m.yaml:1: must be a mapping such as 'bodies: ...' at the top level"]),
        ("just text", ["m.yaml:1: must be a mapping such as 'bodies: ...' at the top level"]),
        ("a: 1\nb:\n  a: 2\na: 3\n", ["m.yaml:4: a: given twice, first in line 1"]),
        (
            "a: {x: 1, x: 2}\nb: {y: 1, y: 2}\n",
            [
                "m.yaml:1: a.x: given twice, first in line 1",
                "m.yaml:2: b.y: given twice, first in line 2",
            ],
        ),
        (
            "a: 1\nb: c: 2\n",
            [
                "m.yaml:2: YAML syntax: mapping values are not allowed here; check the "
                "indentation and put text with a colon in quotes"
            ],
        ),
        (
            "a:\n\tb: 1\n",
            [
                "m.yaml:2: YAML syntax: found character '\\t' that cannot start any token; "
                "indent with blanks, not with tabs"
            ],
        ),
        (
            "a: 1\nb: [1, 2\nc: 3\n",
            [
                "m.yaml:3: YAML syntax: expected ',' or ']', but got ':'; "
                "the '[' opened in line 2 is not closed"
            ],
        ),
        (
            "# [ {\nname: it's [one]\nbodies: ['[', \"{\", {name: x, at: [0, 0]}\njoints: 3\n",
            [
                "m.yaml:4: YAML syntax: expected ',' or ']', but got 'joints'; "
                "the '[' opened in line 3 is not closed"
            ],
        ),
        (
            '{"a": [1, 2],\n "b": {"c": 3\n',
            [
                "m.yaml:3: YAML syntax: expected ',' or '}', but got the end of the file; "
                "the '{' opened in line 2 is not closed"
            ],
        ),
        (
            "a: 'x\n",
            [
                "m.yaml:2: YAML syntax: found unexpected end of stream; "
                "the quote opened in line 1 is not closed"
            ],
        ),
        ("a: *b\n", ["m.yaml:1: YAML syntax: found undefined alias 'b'"]),
        ("a: !secret 1\n", ["m.yaml:1: a: unknown tag !secret"]),
        ("a: &a [*a]\n", ["m.yaml:1: a.0: refers to itself"]),
        ("? [1, 2]\n: 3\n", ["m.yaml:1: a key must be a plain word"]),
        (
            "a: 1\n---\nb: 2\n",
            ["m.yaml:2: YAML syntax: expected a single document in the stream, found another one"],
        ),
    ],
)
def test_broken_files_say_where_and_why(text, expected):
    assert problems(text) == expected


def test_aliases_that_repeat_without_end(monkeypatch):
    """Nine levels of ten aliases each are 1e9 entries in 0.4 kB."""
    monkeypatch.setattr("jousto.schema.file.yaml_reader.MOST_ENTRIES", 20_000)
    levels = [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 10)]
    (message,) = problems("\n".join(["a0: &a0 [x]", *levels]))
    assert re.fullmatch(r"m.yaml:[456]: too many entries, aliases repeat too often", message)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('sensors: [{type: "\\ud800", name: a}]', "model:1: sensors.0.type"),
        ('sensors:\n  - "\\udc00"', "model:2: sensors.0"),
        ('bodies:\n  "a\\ud800": 1', "model:2: bodies"),
        ('{"name": "a\\ud800b"}', "model:1: name"),
    ],
)
def test_half_of_a_character_is_refused_with_its_line(text, place):
    """UTF-8 has none; every message, results file and page that shows it would fail."""
    with pytest.raises(InputError, match=f"{place}: contains .u(d8|dc)00, half of a character"):
        parse_document(text)


def test_a_pair_of_escapes_is_a_character():
    """As RFC 8259, section 7, writes characters beyond the first plane."""
    assert parse_document('{"name": "\\ud83d\\ude00"}').data == {"name": "\U0001f600"}


@pytest.mark.parametrize("text", ["a: " + 1000 * "[", 1500 * "{a: " + "1" + 1500 * "}"])
def test_nested_too_deeply(text):
    assert problems(text) == ["m.yaml: is nested too deeply"]


def test_a_tree_that_the_parser_can_read_but_not_the_reader(monkeypatch):
    def deep(self, node):
        raise RecursionError

    monkeypatch.setattr("jousto.schema.file.yaml_reader.YamlReader.value", deep)
    assert problems("a: 1") == ["m.yaml: is nested too deeply"]


def test_files_that_cannot_be_read(tmp_path):
    def message(path):
        with pytest.raises(InputError) as error:
            read_document(path)
        return str(error.value)

    assert message(tmp_path / "no.yaml") == f"{tmp_path / 'no.yaml'}: no such file"
    assert message(tmp_path) == f"{tmp_path}: is a folder, must be a file"
    binary = tmp_path / "b.yaml"
    binary.write_bytes(b"\x89HDF\r\n\x1a\n\xff\xfe")
    assert message(binary) == f"{binary}: is not a text file (it looks like HDF5)"
    binary.write_bytes(b"\xff\xfe")
    assert message(binary) == f"{binary}: is not a text file"
    binary.write_text("name: x")
    assert read_document(binary).folder == tmp_path
