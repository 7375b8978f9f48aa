"""Spoilt model files: whatever is wrong with them, only errors of the library are seen."""

from __future__ import annotations

import copy
import json
import math
import random
import warnings
from pathlib import Path
from typing import Any

import pytest

from jousto.base.errors import JoustoError
from jousto.model.compile import compile
from jousto.schema.file.document import parse_document
from jousto.schema.read import parse_model

EXAMPLES = Path(__file__).parents[2] / "examples"
# quick to reduce, with most kinds of entries between them
FILES = ("belt_friction.yaml", "cantilever.yaml", "flexible_pendulum.yaml")
WRONG: tuple[Any, ...] = (
    *(None, True, 0, -1, 1, 10**30, 1e300, -1e300, 1e-300, math.nan, math.inf, 1.5),
    *("", " ", "abc", "ground", "ground.origin", "nan", "1e400", "-5 mm", "5 kg", "5 furlongs"),
    *("../../x", "\x1b[2J", "a.b.c", [], {}, [[]], [0, 0, 0], [1, 2], ["a"], {"a": 1}),
    *({"type": "abc"}, {"type": None}, {"type": ["revolute"]}, {"file": "/"}, {"file": "x.csv"}),
)


def places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths of all values below a value."""
    items = data.items() if isinstance(data, dict) else enumerate(data)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


def spoilt(data: Any, rng: random.Random) -> Any:
    """Return a copy of a model with one to three values wrong, gone, renamed or twice."""
    data = copy.deepcopy(data)
    for _ in range(rng.randint(1, 3)):
        path = rng.choice(places(data))
        owner = data
        for key in path[:-1]:
            owner = owner[key]
        kind = rng.randrange(5)
        if kind == 0:
            del owner[path[-1]]
        elif kind == 1 and isinstance(owner, dict):
            owner[rng.choice(("type", "nmae", "0", ""))] = owner.pop(path[-1])
        elif kind == 2 and isinstance(owner, list):
            owner.append(copy.deepcopy(owner[path[-1]]))
        else:
            owner[path[-1]] = copy.deepcopy(rng.choice(WRONG))
        if not places(data):
            return data
    return data


def only_ours(text: str, folder: Path) -> bool:
    """Return whether a model is accepted; fails on all errors but those of the library."""
    with warnings.catch_warnings():
        # of numbers near 1e300 NumPy warns, too
        warnings.simplefilter("ignore")
        try:
            compile(parse_model(text, folder=folder).mechanism)
        except JoustoError as error:
            assert str(error).strip()
            return False
        except Exception as error:
            error.add_note(text)
            raise
    return True


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("seed", range(6))
def test_spoilt_examples(name: str, seed: int, tmp_path: Path) -> None:
    data = parse_document((EXAMPLES / name).read_text(encoding="utf-8")).data
    rng = random.Random(f"{name} {seed}")
    accepted = sum(only_ours(json.dumps(spoilt(data, rng)), tmp_path) for _ in range(12))
    assert accepted < 12


@pytest.mark.parametrize("seed", range(6))
def test_spoilt_text(seed: int, tmp_path: Path) -> None:
    """Letters that are lost, doubled or replaced by those with a meaning in YAML."""
    rng = random.Random(seed)
    accepted = 0
    for _ in range(20):
        text = list((EXAMPLES / FILES[0]).read_text(encoding="utf-8"))
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(text))
            text[at] = rng.choice(("", text[at] * 2, *"{}[]:,&*!|>-#%@`\"'\t\n?=~\0\x85\u2028"))
        accepted += only_ours("".join(text), tmp_path)
    # letters of names and comments may change; most others may not
    assert accepted < 18


@pytest.mark.parametrize(
    "text",
    [
        "bodies: &a [*a]",
        "bodies: &a {name: *a}",
        "&a {bodies: *a}",
        "a: &a [x, x]\nb: &b [*a, *a]\nbodies: [*b, *b]",
        "bodies: !!python/object/apply:os.system [true]",
        "parts: {1: {type: beam}, null: {}, 2.5: 3, [a]: 1}",
        "? [a]\n: b",
        "<<: {<<: {bodies: 1}}",
        "[" * 1000,
        "bodies: " + "{a: " * 1000,
        "1",
        "",
        "\ufeff",
        "\x00",
    ],
)
def test_strange_documents(text: str, tmp_path: Path) -> None:
    assert not only_ours(text, tmp_path)
