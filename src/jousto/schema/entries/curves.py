"""Entries of S-N curves and mean stress corrections, and the objects they say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from jousto.base.errors import InputError, suggest
from jousto.materials.strength.sn import SN
from jousto.schema.entries.base import Count, Entry, Flag, Length, Number, Pressure, Text
from jousto.schema.entries.choices import by_form, tagged
from jousto.schema.entries.declared import entry_of, extended, one_of
from jousto.schema.file.document import Loc

if TYPE_CHECKING:
    from jousto.schema.make.context import Builder

Rule: TypeAlias = Literal["original", "elementary", "haibach"]


SNEntry: Any = extended(
    entry_of(SN, implied=True),
    factors=(tuple[Number, ...] | None, Field(None, description="On S_D: surface, size ...")),
    pivot=(Count | None, Field(None, description="Cycles at which the factors no longer act")),
)


class WeldEntry(Entry):
    """`fat_class`: the S-N curve of a weld."""

    type: Literal["weld"] = "weld"
    fat: Number = Field(description="FAT class or detail category, such as 71")
    standard: Literal["iiw", "en"] | None = Field(None, description="iiw if not given")
    shear: Flag | None = None
    constant: Flag | None = Field(None, description="Loads of constant amplitude")
    thickness: Length | None = Field(None, description="Of the plate, for the thickness factor")
    joint: Text | None = Field(None, description="Kind of joint, for the thickness factor")
    factors: tuple[Number, ...] | None = Field(None, description="On the stress: 1/gamma_Mf ...")
    T_N: Number | None = Field(None, description="Scatter band in cycles, 10 % over 90 %")


class NamedEntry(Entry):
    """`sn_curve`: a curve of the library."""

    type: Literal["named"] = "named"
    library: Text = Field(description="Name such as RQC-100, S355 or fat71")
    rule: Rule | None = Field(None, description="Below the knee; that of the library if not given")
    factors: tuple[Number, ...] | None = Field(None, description="On S_D: surface, size ...")
    pivot: Count | None = Field(None, description="Cycles at which the factors no longer act")


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


class FKMEntry(Entry):
    """`FKM`, by its sensitivity or by the kind of material and its strength."""

    type: Literal["fkm"]
    M: Number | None = None
    kind: Text | None = Field(None, description="steel, aluminium ...: with S_u instead of M")
    S_u: Pressure | None = None


OTHER: Mapping[str, type[Entry]] = {"fkm": FKMEntry}
MeanEntry: Any = one_of("mean stress", "jousto.materials.strength", others=OTHER)


def build_curve(builder: Builder, loc: Loc, entry: Any, curves: dict[str, Any]) -> SN | None:
    """Return the S-N curve of an entry or a name, None if anything is wrong with it.

    Parameters
    ----------
    builder, loc
        As everywhere.
    entry : str, SNEntry, WeldEntry or NamedEntry
        Names are looked up among `curves`, then in the library.
    curves : dict
        Curves of the file by name; None those that are wrong.
    """
    from jousto.materials.strength.sn_library import sn_curve
    from jousto.materials.strength.welds import fat_class, thickness_factor

    if isinstance(entry, str):
        if entry in curves:
            return curves[entry]  # type: ignore[no-any-return]
        try:
            return sn_curve(entry)
        except InputError:
            known = [*curves, "fat71", "S355", "RQC-100"]
            builder.note(loc, f"no S-N curve {entry!r}{suggest(entry, known)}")
            return None
    values = entry.given("factors", "pivot", "thickness", "joint", "fat", "library")
    if isinstance(entry, SNEntry) and len(loc) > 1 and loc[-2] == "curves":
        values.setdefault("name", str(loc[-1]))
    factors = list(entry.factors or ())
    if isinstance(entry, WeldEntry):
        if entry.thickness is not None:
            joint = entry.joint or "cruciform"
            factor = builder.make((*loc, "thickness"), thickness_factor, entry.thickness, joint)
            if factor is None:
                return None
            factors.append(factor)
        elif entry.joint is not None:
            builder.note((*loc, "joint"), "joint is of the thickness factor; give thickness, too")
        product = 1.0
        for x in factors:
            product *= x
        return builder.make(loc, fat_class, entry.fat, factor=product, **values)
    made: SN | None
    if isinstance(entry, NamedEntry):
        made = builder.make(loc, sn_curve, entry.library, **values)
    else:
        made = builder.make(loc, SN, **values)
    if made is not None and factors:
        made = builder.make((*loc, "factors"), made.with_factors, *factors, pivot=entry.pivot)
    return made


def build_mean(builder: Builder, loc: Loc, entry: Any) -> Any:
    """Return the mean stress correction of an entry, None if anything is wrong with it."""
    from jousto.materials.strength.mean_stress import FKM
    from jousto.schema.make.declared import build_declared

    if isinstance(entry, FKMEntry):
        if entry.M is not None and (entry.kind or entry.S_u):
            builder.note(loc, "give either M, or kind and S_u")
            return None
        if entry.M is not None:
            return builder.make(loc, FKM, entry.M)
        if entry.kind is None or entry.S_u is None:
            builder.note(loc, "needs M, or kind (such as steel) and S_u")
            return None
        return builder.make(loc, FKM.of, entry.kind, entry.S_u)
    return build_declared(builder, loc, entry)
