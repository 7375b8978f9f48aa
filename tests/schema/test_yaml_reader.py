"""The language of model files: YAML 1.2 by libyaml, whose own rules are those of 1.1."""

from __future__ import annotations

import importlib
import json
import math
import re
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

import jousto as jo
from jousto.schema.file import yaml_reader
from jousto.schema.file.document import parse_document

ROOT = Path(__file__).parents[2]
TEXTS = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "examples").glob("*.yaml"))]
TEXTS += [
    text
    for page in sorted((ROOT / "docs").glob("*.md"))
    for text in re.findall(r"```yaml\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
]


def read(text):
    return parse_document(text).data


def wrong(text):
    with pytest.raises(jo.InputError) as error:
        parse_document(text)
    return str(error.value)


WORDS = {
    # YAML 1.2, section 10.3.2
    **dict.fromkeys(("~", "null", "Null", "NULL", "")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    "0": 0,
    "-0": 0,
    "+12": 12,
    "-19": -19,
    "0o14": 12,
    "0x1F": 31,
    "-0x1f": -31,
    "0b11": 3,
    "012": 12,
    "0777": 777,
    "1_000": 1000,
    "1.": 1.0,
    ".5": 0.5,
    "1e3": 1e3,
    "1E3": 1e3,
    "1.5e+3": 1500.0,
    "-1e-3": -1e-3,
    ".5e1": 5.0,
    ".inf": math.inf,
    "+.INF": math.inf,
    "-.Inf": -math.inf,
    "1e400": math.inf,
    # words of YAML 1.1 and others are text
    **{word: word for word in ("yes", "Yes", "no", "on", "off", "y", "n", "12:30", "1:2:3")},
    **{word: word for word in ("2001-01-01", "2001-01-01T10:00:00Z", "=", "<", "0.1.2", "1e")},
    **{word: word for word in ("_1", "._1", "0x", "0o9", "1e+", "--1", ".", "..", "1.5 mm", "é")},
    **{word: word for word in ("a:b", "http://x.y/z:1", "a#b", "a\\b", "x|y", "-x", "µm", "Nan")},
    "'1'": "1",
    '"true"': "true",
    "'it''s'": "it's",
    '"\\u00b5"': "µ",
    '"\\/"': "/",
    "!!str 1": "1",
    "!!str ~": "~",
    "'~'": "~",
    '""': "",
    "\U0001f600": "\U0001f600",
    '"\\ud83d\\ude00"': "\U0001f600",
    "'\\ud83d'": "\\ud83d",
    "C:\\ud800": "C:\\ud800",
    "x\u2028y": "x\u2028y",
    "'x\x85y'": "x\x85y",
}


@pytest.mark.parametrize("form", ["a: {}\nb: 1", "a: [1, {}, 2]", "a: {{b: {}}}", "a:\n- {}"])
@pytest.mark.parametrize("word", [word for word in WORDS if word])
def test_what_words_mean(word, form):
    found = read(form.format(word))["a"]
    if isinstance(found, list):
        found = found[len(found) // 2]
    found = found["b"] if isinstance(found, dict) else found
    assert (found, type(found)) == (WORDS[word], type(WORDS[word]))


def test_nothing_is_none_and_nan_is_not_a_number():
    assert read("a:\nb: {c: }\nd:\n-\n") == {"a": None, "b": {"c": None}, "d": [None]}
    assert all(math.isnan(x) for x in read("a: [.nan, .NaN, .NAN]")["a"])


@pytest.mark.parametrize("word", ["1", "true", "~", "1.5", "é", "<<x"])
def test_keys_are_words(word):
    assert read(f"{word}: 1") == {word: 1}


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("a:\n  - b\n  -\n  - c: 1\n    d:\n", ["b", None, {"c": 1, "d": None}]),
        ("a:\n- - 1\n  - 2\n", [[1, 2]]),
        ("a: |\n  x\n   y\n\nb: 1\n", "x\n y\n"),
        ("a: >-\n  x\n  y\n\n  z\n", "x y\nz"),
        ("a: >\n  x\n  y\n   z\n  w\n", "x y\n z\nw\n"),
        ("a: 'x\n  y'\n", "x y"),
        ('a: "x\\\n  y"\n', "xy"),
        ("a: b\n c\n  d\ne: f\n", "b c d"),
        ("a:\r\n  b: 1\r\nc: 2\r\n", {"b": 1}),
        ("a:\tb\t# c\n", "b"),
        ("--- \na: 1\n...\n", 1),
        ("%YAML 1.2\n---\na: yes\n", "yes"),
        ("? a\n: 1\n", 1),
        ("\ufeffa: 1\n", 1),
        ("a: 1 # c\n#d\nb: 'x # y'\n", 1),
        ("a: {b: {c: [1, [2, {e: f}],]},}", {"b": {"c": [1, [2, {"e": "f"}]]}}),
        ("a: &x {b: 1}\n", {"b": 1}),
        ("c: &x 1\nd: &x 2\na: *x\n", 2),
        ("c: &x [1, &y {z: 2}]\na: [*x, *y]\n", [[1, {"z": 2}], {"z": 2}]),
        ("c: &x {b: 1, e: 1}\na: {b: 2, <<: *x}\n", {"b": 2, "e": 1}),
        ("c: &x {b: 1}\nd: &y {b: 2, e: 3}\na: {<<: [*x, *y]}\n", {"b": 1, "e": 3}),
        ("a: !force {b: 1}\n", {"b": 1}),
    ],
)  # fmt: skip
def test_forms(text, data):
    assert read(text)["a"] == data


SYNTAX = {
    "a: @x": "1: found character '@' that cannot start any token; put the text in quotes",
    "a: - b": "1: an item of a list is not allowed here; begin the list in a line of its own",
    "a:\n  b: 1\n c: 2\n": "3: expected a key, but got 'c'; check the indentation and the brackets",
    "a: x\n\ty: 1\n": "2: found a tab in the indentation; indent with blanks, not with tabs",
    'a: "C:\\q"': "1: found an escape that YAML does not have; write the backslash twice, or the "
    "text in single quotes",
    "a: [1, ?, 2]": "1: expected ',' or ']', but got '2'; the '[' opened in line 1 is not closed",
    "a: 1\n... x\n": "2: expected the end of the file, but got 'x'; check the indentation and the "
    "brackets",
    "&x a: *y": "1: found undefined alias 'y'",
    "a: 1\n<<: [*a]\n": "2: found undefined alias 'a'",
}
OTHERS = {
    "%YAML 1.1\n---\na: yes\n": "model:1: is YAML 1.1, in which words mean other things; model "
    "files are 1.2",
    "a: \x01\n": "model:1: contains '\\x01', which YAML does not allow: leave it out",
    "b: 1\na: \ud800": "model:2: contains '\\ud800', which YAML does not allow: leave it out",
    "a: !x 1": "model:1: a: unknown tag !x",
}


@pytest.mark.parametrize("text", SYNTAX)
def test_syntax_errors(text):
    line, message = SYNTAX[text].split(": ", 1)
    assert wrong(text) == f"model:{line}: YAML syntax: {message}"


@pytest.mark.parametrize("text", OTHERS)
def test_what_is_not_read(text):
    assert wrong(text) == OTHERS[text]


def paths(data, path=()):
    items = enumerate(data) if isinstance(data, list) else ()
    for key, value in data.items() if isinstance(data, dict) else items:
        yield (*path, key), value
        yield from paths(value, (*path, key))


@pytest.mark.parametrize("text", TEXTS)
def test_every_entry_stands_in_its_line(text):
    """A number or a word that is written once stands in the line that its path is said to have."""
    document = parse_document(text)
    assert document.lines[()] >= 1
    lines = text.split("\n")
    checked = 0
    for path, value in paths(document.data):
        key = str(path[-1])
        if isinstance(path[-1], str) and "<<" not in text and "*" not in text:
            assert key in lines[document.lines[path] - 1], path
            checked += 1
        if type(value) is int and isinstance(path[-1], int):
            assert str(value) in lines[document.lines[path] - 1].replace("_", ""), path
    assert checked or "*" in text


# keys of YAML have at most 1024 signs, of which an escaped one is twelve; ${ opens an expression
WORD = st.text(max_size=80).filter(lambda text: text != "<<" and "${" not in text)
REAL = st.floats(allow_nan=False, allow_infinity=False)
ONE = st.none() | st.booleans() | st.integers(-(10**15), 10**15) | REAL | WORD
DATA = st.recursive(
    ONE,
    lambda items: st.lists(items, max_size=4) | st.dictionaries(WORD, items, max_size=4),
    max_leaves=12,
)


@pytest.mark.parametrize("indent", [None, 1, "\t"])
@settings(max_examples=200)
@given(DATA)
def test_json_is_read_as_json_is(indent, data):
    """With escapes for all that is not ASCII, as most programs write it."""
    text = json.dumps({"a": data}, indent=indent)
    assert read(text) == {"a": data}


@settings(max_examples=300)
@given(st.text(st.sampled_from(list("ab1:,-[]{}#'\"|>&*!?~%\n  .0\t")), max_size=30))
def test_any_text_is_read_or_refused_with_its_line(text):
    try:
        parse_document(text)
    except jo.InputError as error:
        lines = text.count("\n") + 1
        for problem in error.problems:
            found = re.match(r"model(:(\d+))?(: [^:]+)?$", problem.where, re.S)
            assert found and 1 <= int(found[2] or 1) <= lines, problem


def test_a_python_without_libyaml_is_told_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "yaml.cyaml", None)
    with pytest.raises(ImportError, match="libyaml.*pip install"):
        importlib.reload(yaml_reader)
