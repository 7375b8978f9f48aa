"""The page of words is made of the declarations of the readers."""

from __future__ import annotations

import importlib.util
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_page_has_what_the_readers_do() -> None:
    spec = importlib.util.spec_from_file_location("robot_words", ROOT / "tools" / "robot_words.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    written = (ROOT / "docs" / "robot-words.md").read_text(encoding="utf-8")
    assert written == tool.page(), "run python tools/robot_words.py"
