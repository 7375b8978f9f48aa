"""The file of a duty cycle, ``jousto fatigue --duty``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from jousto.base.declare import Declared
from jousto.base.fields import AnyField, Choice, Items, OptionalText, field
from jousto.base.numbers import Number
from jousto.schema.entries.declared import entry_of
from jousto.schema.file.document import read_document
from jousto.schema.make.blocks.fatigue import built
from jousto.schema.make.declared import build_declared


class DutyLine(Declared):
    """Results file of a duty cycle and its number of repetitions."""

    result: AnyField = field("Results file, relative to this file", form="file")
    repeats: Number = field("Number of repetitions", default=1.0)
    name: OptionalText = field("Name in tables; by default that of the file", default=None)


class Duty(Declared):
    """Content of a duty-cycle file."""

    lines: Items[DutyLine] = field("Results files with their repetitions", key="events")
    transitions: Choice = field(
        "Rule for the transitions between the results",
        words=("separate", "sequence", "worst"),
        default=None,
    )

    @property
    def events(self) -> tuple[tuple[Path, float, str], ...]:
        """Results file, number of repetitions and name of each entry."""
        return tuple((e.result, e.repeats, e.name or e.result.stem) for e in self.lines)


def read_duty(path: str | Path) -> Duty:
    """Read the YAML file of a duty cycle.

    Raises
    ------
    InputError
        With all problems of the file and their lines.
    """
    form: Any = entry_of(Duty)
    found: Duty = built(read_document(path), form, lambda b, entry: build_declared(b, (), entry))
    return found
