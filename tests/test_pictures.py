"""Flow charts of the documentation: no text leaves its box, whatever fonts the computer has."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

DOCS = Path(__file__).parent.parent / "docs"
PICTURES = DOCS / "pictures"
LIMITS = "limits-and-where-to-go-on"


def script(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return a script of docs/pictures as a module."""
    monkeypatch.syspath_prepend(PICTURES)
    spec = importlib.util.spec_from_file_location(name, PICTURES / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, module)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["process_charts", "seven_methods"])
def test_charts_are_drawn_with_all_texts_in_their_boxes(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script("chart", monkeypatch)
    script(name, monkeypatch).main(tmp_path)
    drawn = sorted(path.name for path in tmp_path.iterdir())
    assert drawn and all((PICTURES / name).exists() for name in drawn)


def test_a_text_without_room_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chart = script("chart", monkeypatch)
    sheet = chart.Chart(4.0, 3.0)
    sheet.box(chart.Box(2.0, 2.3, 1.2, 0.62), "fits", "and this")
    sheet.box(chart.Box(2.0, 1.5, 0.9, 0.62), "wider than its box")
    sheet.question(chart.Box(2.0, 0.6, 1.4, 0.6), "too wide for this one")
    sheet.write((3.95, 0.2), "cut off")
    assert sheet.misfits() == ["wider than its box", "too wide for this one", "cut off"]
    with pytest.raises(ValueError, match="sheet.png: no room for 'wider than its box'"):
        sheet.save(tmp_path / "sheet.png")
    assert not list(tmp_path.iterdir())


def test_the_chart_of_methods_has_the_rows_of_its_page_and_each_has_its_limits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    script("chart", monkeypatch)
    methods = script("seven_methods", monkeypatch).METHODS
    page = (DOCS / "seven-methods.md").read_text(encoding="utf-8")
    pages = re.findall(rf"^\| \[.*\]\(([\w-]+)\.md#{LIMITS}\)", page, re.M)
    assert len(pages) == len(set(pages)) == len(methods) == 7
    for name in pages:
        text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
        _, _, section = text.partition("\n## Limits and where to go on\n")
        table, _, _ = section.partition("\n## ")
        rows = re.findall(r"^\| (.*) \| (.*) \| (.+) \|$", table, re.M)
        assert len(rows) >= 5 and sum(bool(re.search(r"\d", row[1])) for row in rows) >= 2, name
