"""Types of beams and their sections in model files."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Tag

from jousto.base.declare import SECTIONS
from jousto.mechanism.beams.body import BeamBody as BeamBody  # import registers its class
from jousto.schema.entries.base import Count, Number, Pressure, Text, Vector
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import FORMS, one_of
from jousto.schema.entries.parts import SectionEntry

AnySection: Any = one_of("sections", "jousto.sections", others=SECTIONS["beam sections"])
Sections: TypeAlias = Annotated[
    Annotated[AnySection, Tag("mapping")] | Annotated[tuple[AnySection, ...], Tag("list")],
    by_form(),
]
Inertia: TypeAlias = Annotated[
    Annotated[Literal["lumped", "corrected", "consistent"], Tag("word")]
    | Annotated[Number, Tag("number")],
    Discriminator(lambda v: "word" if isinstance(v, str) else "number"),
]
FORMS.update(
    {
        "section": lambda field: SectionEntry,
        "beam sections": lambda field: Sections,
        "beam inertia": lambda field: Inertia,
        "elasticity": lambda field: Annotated[tuple[Pressure, Number], Vector(2)],
        "counts": lambda field: tuple[Count, ...],
        "nodes": lambda field: dict[Text, Count],
    }
)
