"""Entries of S-N curves and mean stress corrections, and the objects they say."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from jousto.base.errors import InputError, suggest
from jousto.schema.entries.base import Count, Entry, Flag, Length, Number, Pressure, Text
from jousto.schema.entries.choices import by_form, tagged
from jousto.schema.file.document import Loc

if TYPE_CHECKING:
    from jousto.materials.strength.sn import SN
    from jousto.schema.make.builder import Builder

Rule: TypeAlias = Literal["original", "elementary", "haibach"]


class SNEntry(Entry):
    """`SN`: an S-N curve from its numbers."""

    type: Literal["sn"] = "sn"
    S_D: Pressure = Field(description="Stress amplitude at the knee")
    N_D: Number = Field(description="Cycles at the knee")
    k: Number = Field(description="Slope")
    rule: Rule | None = Field(None, description="Below the knee; elementary if not given")
    k2: Number | None = Field(None, description="Slope below the knee, with rule: haibach")
    N_cut: Number | None = Field(None, description="Cycles of the cut-off limit")
    R: Number | None = Field(None, description="Stress ratio of the tests, -1 if not given")
    T_S: Number | None = Field(None, description="Scatter band in stress, 10 % over 90 %")
    T_N: Number | None = Field(None, description="Scatter band in cycles, 10 % over 90 %")
    survival: Number | None = Field(None, description="Probability for which it holds, 50 %")
    S_u: Pressure | None = Field(None, description="Tensile strength")
    name: Text | None = Field(None, description="For tables")
    source: Text | None = None
    factors: tuple[Number, ...] | None = Field(None, description="On S_D: surface, size ...")
    pivot: Count | None = Field(None, description="Cycles at which the factors no longer act")


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


CurveForm: TypeAlias = Annotated[
    Annotated[SNEntry, Tag("sn")]
    | Annotated[WeldEntry, Tag("weld")]
    | Annotated[NamedEntry, Tag("named")],
    tagged(_kind),
]
SNOrName: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[CurveForm, Tag("mapping")], by_form()
]


class GoodmanEntry(Entry):
    """`Goodman`."""

    type: Literal["goodman"]
    S_u: Pressure
    credit: Flag | None = Field(None, description="Whether compression lengthens life")


class SoderbergEntry(Entry):
    """`Soderberg`."""

    type: Literal["soderberg"]
    S_y: Pressure
    credit: Flag | None = Field(None, description="Whether compression lengthens life")


class MorrowEntry(Entry):
    """`Morrow`."""

    type: Literal["morrow"]
    sf: Pressure
    credit: Flag | None = Field(None, description="Whether compression lengthens life")


class GerberEntry(Entry):
    """`Gerber`."""

    type: Literal["gerber"]
    S_u: Pressure


class SWTEntry(Entry):
    """`SWT`."""

    type: Literal["swt"]


class WalkerEntry(Entry):
    """`Walker`."""

    type: Literal["walker"]
    gamma: Number


class FKMEntry(Entry):
    """`FKM`, by its sensitivity or by the kind of material and its strength."""

    type: Literal["fkm"]
    M: Number | None = None
    kind: Text | None = Field(None, description="steel, aluminium ...: with S_u instead of M")
    S_u: Pressure | None = None


class WeldRatioEntry(Entry):
    """`WeldRatio`."""

    type: Literal["weld-ratio"]
    residual: Literal["low", "medium", "high"] | None = Field(None, description="high if not given")


class PartCompressionEntry(Entry):
    """`PartCompression`."""

    type: Literal["part-compression"]
    share: Number | None = None


MeanEntry: TypeAlias = Annotated[
    Annotated[GoodmanEntry, Tag("goodman")]
    | Annotated[SoderbergEntry, Tag("soderberg")]
    | Annotated[MorrowEntry, Tag("morrow")]
    | Annotated[GerberEntry, Tag("gerber")]
    | Annotated[SWTEntry, Tag("swt")]
    | Annotated[WalkerEntry, Tag("walker")]
    | Annotated[FKMEntry, Tag("fkm")]
    | Annotated[WeldRatioEntry, Tag("weld-ratio")]
    | Annotated[PartCompressionEntry, Tag("part-compression")],
    tagged(),
]


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
    from jousto.materials.strength.sn import SN
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
    from jousto.materials.strength.mean_stress import (
        FKM,
        SWT,
        Gerber,
        Goodman,
        Morrow,
        PartCompression,
        Soderberg,
        Walker,
        WeldRatio,
    )

    kinds: dict[str, Any] = {
        "goodman": Goodman,
        "soderberg": Soderberg,
        "morrow": Morrow,
        "gerber": Gerber,
        "walker": Walker,
        "swt": SWT,
        "weld-ratio": WeldRatio,
        "part-compression": PartCompression,
    }
    values = entry.given()
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
    return builder.make(loc, kinds[entry.type], **values)
