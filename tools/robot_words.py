"""Write docs/robot-words.md: what the readers of robots do with every word of their formats.

    python tools/robot_words.py

The page is made of the declarations that the readers themselves use.
"""

from __future__ import annotations

from pathlib import Path

from jousto.robots.readers.formats import FORMATS
from jousto.robots.readers.words import TREATMENTS, Format, Tag

PAGE = Path(__file__).parent.parent / "docs" / "robot-words.md"
HEAD = """---
kind: reference
---

# Words of robot files

The readers of `jo.robots` treat every word of their formats, attributes and elements as follows.
A word is

* **done**: it has the meaning that the format defines;
* **without effect** on the motion;
* **warned of**, with its line and effect, if its value changes the motion;
* **refused**, with its line and the remedy.

A word that is not in the lists gets a warning. The tests compare the lists with the schemas of
the formats.
"""
TITLES = dict(zip(TREATMENTS, ("Done", "Without effect", "Warned of", "Refused"), strict=True))


def page() -> str:
    """Return the text of the page."""
    return "\n".join([HEAD, *(section(words) for words in FORMATS)])


def section(words: Format) -> str:
    """Return the part of a format."""
    lines = [f"## {words.name}", "", "| element | " + " | ".join(TITLES.values()) + " |"]
    lines.append("|---" * (len(TITLES) + 1) + "|")
    notes: dict[str, int] = {}
    rows: dict[str, list[str]] = {}
    for key, tag in words.tags.items():
        rows.setdefault(" | ".join(cells(tag, notes)), []).append(key)
    for row, keys in rows.items():
        lines.append(f"| {', '.join(f'`{key}`' for key in keys)} | {row} |")
    lines += ["", *(f"{number}. {text}" for text, number in notes.items()), ""]
    return "\n".join(lines)


def cells(tag: Tag, notes: dict[str, int]) -> list[str]:
    """Return the words of an element by their treatment, with the numbers of their notes."""
    found: dict[str, list[str]] = {treatment: [] for treatment in TREATMENTS}
    for name, word in [("all", tag.whole)] if tag.whole is not None else tag.all():
        number = notes.setdefault(word.text, len(notes) + 1) if word.text else 0
        shown = name if name == "all" else f"`{name}`"
        found[word.treatment].append(f"{shown} ({number})" if number else shown)
    return [" ".join(found[treatment]) for treatment in TREATMENTS]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
