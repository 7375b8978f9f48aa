"""Entries for the reliability of limits."""

from __future__ import annotations

from pydantic import Field

from jousto.schema.entries.base import Entry, Number, Text


class CorrelationEntry(Entry):
    """Correlation of two parameters."""

    of: tuple[Text, Text] = Field(description="Names of the two parameters")
    value: Number = Field(description="Their correlation, between -1 and 1")


class ReliabilityEntry(Entry):
    """Settings for the reliability of the limits."""

    target: Number | None = Field(None, description="Target reliability index of the limits")
    correlations: tuple[CorrelationEntry, ...] | None = None
