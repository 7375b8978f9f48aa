"""Entries of S-N curves and mean stress corrections."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, Tag

from jousto.materials.strength.mean_stress import FKM
from jousto.materials.strength.sn import SN
from jousto.materials.strength.welds import FatClass
from jousto.schema.entries.base import Count, Entry, Length, Number, Pressure, Text
from jousto.schema.entries.choices import by_form, tagged
from jousto.schema.entries.declared import entry_of, extended, keys_of, one_of, special

FACTORS: Any = (tuple[Number, ...] | None, Field(None, description="On S_D: surface, size ..."))
PIVOT: Any = (
    Count | None,
    Field(None, description="Cycles at which the factors no longer act"),
)

SNEntry: Any = extended(entry_of(SN, implied=True), factors=FACTORS, pivot=PIVOT)
WeldEntry: Any = special(
    FatClass,
    "weld",
    implied=True,
    **keys_of(FatClass),
    thickness=(
        Length | None,
        Field(None, description="Of the plate, for the thickness factor"),
    ),
    joint=(Text | None, Field(None, description="Kind of joint, for the thickness factor")),
    factors=(
        tuple[Number, ...] | None,
        Field(None, description="On the stress: 1/gamma_Mf ..."),
    ),
)
NamedEntry: Any = extended(
    Entry,
    "Named",
    type=(Literal["named"], "named"),
    library=(Text, Field(description="Name such as RQC-100, S355 or fat71")),
    rule=keys_of(SN)["rule"],
    factors=FACTORS,
    pivot=PIVOT,
)


def _kind(data: dict[str, Any]) -> str | None:
    if "fat" in data:
        return "weld"
    return "named" if "library" in data else "sn"


CurveForm: Any = Annotated[
    Annotated[SNEntry, Tag("sn")]
    | Annotated[WeldEntry, Tag("weld")]
    | Annotated[NamedEntry, Tag("named")],
    tagged(_kind),
]
SNOrName: Any = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[CurveForm, Tag("mapping")], by_form()
]


FKMEntry: Any = special(
    FKM,
    "fkm",
    **keys_of(FKM, optional=("M",)),
    kind=(
        Text | None,
        Field(None, description="steel, aluminium ...: with S_u instead of M"),
    ),
    S_u=(Pressure | None, None),
)
OTHER: Mapping[str, type[Entry]] = {"fkm": FKMEntry}
MeanEntry: Any = one_of("mean stress", "jousto.materials.strength", others=OTHER)
