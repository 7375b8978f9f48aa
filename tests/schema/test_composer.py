"""libyaml and ruamel.yaml read the same: data, kinds and lines."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import jousto as jo
from jousto.schema.file import composer, document

pytestmark = pytest.mark.filterwarnings("ignore::ruamel.yaml.error.ReusedAnchorWarning")
ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "examples").glob("*.yaml"))
PAGES = [
    text
    for page in sorted((ROOT / "docs").glob("*.md"))
    for text in re.findall(r"```yaml\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
]
WORDS = """
010 0o10 0x1F 0b11 1_000 +1 -1 1. .5 1e3 1e-3 1E3 1.5e+3 12:30 1:2:3
.inf -.inf .NaN ~ null Null NULL
true True TRUE false yes Yes no on off y n 2001-01-01 2001-01-01T10:00:00Z = << a:b http://x.y/z:1
!x !!str !!int a#b a\\b "q\\u00b5" 'it''s' "\\/" @x `x %x - ? : ,a a,b [] {} &a *a |x >x "" ''
µm 7.85g/cm3 \U0001f600
0.1.2 1e 1e400 0777 0o9 -0 1__0 _1 . .. ... --- +.inf 1,5 0x 1e+ --1 é
""".split()


def both(text: str, monkeypatch: pytest.MonkeyPatch) -> list[tuple]:
    """Return what is read with libyaml, then without: data and lines, or errors."""
    found = []
    for read in (composer._libyaml, lambda: None):
        with monkeypatch.context() as patch:
            patch.setattr(composer, "_libyaml", read)
            try:
                made = document.parse_document(text)
                found.append((repr(made.data), made.lines))
            except jo.InputError as error:
                found.append((str(error), None))
    return found


def test_libyaml_is_there():
    assert composer._libyaml() is not None, "or these tests compare ruamel.yaml with itself"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_examples_read_the_same(path, monkeypatch):
    fast, slow = both(path.read_text(encoding="utf-8"), monkeypatch)
    assert fast == slow and fast[1]


def test_pages_read_the_same(monkeypatch):
    assert len(PAGES) > 5
    for text in PAGES:
        fast, slow = both(text, monkeypatch)
        assert fast == slow, text


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("form", ["a: {}\nb: 1", "a: [1, {}, 2]", "a: {{b: {}}}", "- {}", "{}: 1"])
def test_words_mean_the_same(word, form, monkeypatch):
    fast, slow = both(form.format(word), monkeypatch)
    assert fast == slow


TEXTS = [
    "a: &x {b: 1}\nc: *x\nd: {<<: *x, b: 2}\n",
    "a: 1\na: 2\n",
    "a:\n  - b\n  -\n  - c: 1\n    d:\n  - - 1\n    - 2\n",
    "a: |\n  x\n   y\n\nb: >-\n  x\n  y\n\n  z\nc: 1\n",
    "a: >\n  x\n  y\n   z\n  w\nb: 'x\n  y'\nc: \"x\\\n  y\"\n",
    "a:\r\n  b: 1\r\nc: 2\r\n",
    "a:\tb\n",
    "%YAML 1.1\n---\na: yes\n",
    "a: 1\n---\nb: 2\n",
    "--- \na: 1\n...\n",
    "? [a, b]\n: 1\n",
    "? a\n: 1\n",
    '{"a": {"b":1, "c":[1,2,{"d":null}]}}',
    "{a: b, c: [d, e,], f}\n",
    "a: b: c\n",
    "a: [1, 2\nb: 3\n",
    "a: *nowhere\n",
    "a: &x 1\nb: &x 2\nc: *x\n",
    "&x a: *x\n",
    "# only a comment\n",
    "",
    "a: 1 # c\n#d\nb: 'x # y'\n",
    "a\n",
    "a: \x01\n",
    "a: x\u2028y\n",
    "\ufeffa: 1\n",
    "a: " + "[" * 150 + "]" * 150,
    "a:\n" + "".join(" " * k + "- \n" for k in range(1, 8)),
    "- " * 200 + "x",
    "a: {b: {c: {d: [1, 2, [3, {e: f}]]}}}",
    "a: !force {b: 1}\nc: !x [1]\n",
    "a: b\n c\n  d\ne: f\n",
]


@pytest.mark.parametrize("text", TEXTS)
def test_texts_read_the_same(text, monkeypatch):
    fast, slow = both(text, monkeypatch)
    assert fast == slow


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(st.sampled_from(list("ab1:,-[]{}#'\"|>&*!?~%\n  .0")), max_size=30))
def test_any_text_reads_the_same(monkeypatch, text):
    fast, slow = both(text, monkeypatch)
    assert fast == slow


def test_folded_text_is_read_without_marks():
    data = document.parse_document("a: >\n  x\n  y\n\n  z\nb: {c: 1}\n").data
    assert data == {"a": "x y\nz\n", "b": {"c": 1}}
