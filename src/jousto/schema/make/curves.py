"""S-N curves and mean stress corrections from their entries."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError, suggest
from jousto.materials.strength.mean_stress import FKM
from jousto.materials.strength.sn import SN
from jousto.materials.strength.welds import fat_class, thickness_factor
from jousto.schema.entries.curves import FKMEntry, NamedEntry, SNEntry, WeldEntry
from jousto.schema.file.document import Loc
from jousto.schema.make.declared import build_declared

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder


def build_curve(builder: Builder, loc: Loc, entry: Any, curves: dict[str, Any]) -> SN | None:
    """Return the S-N curve of an entry or a name; None, with problems, if it is invalid.

    Parameters
    ----------
    builder, loc
        Builder, and path of the entry.
    entry : str, SNEntry, WeldEntry or NamedEntry
        Names are looked up among `curves`, then in the library.
    curves : dict
        Curves of the file by name; None for invalid ones.
    """
    from jousto.materials.strength.sn_library import sn_curve

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
        return builder.make(loc, fat_class, entry.fat, factor=math.prod(factors), **values)
    made: SN | None
    if isinstance(entry, NamedEntry):
        made = builder.make(loc, sn_curve, entry.library, **values)
    else:
        made = builder.make(loc, SN, **values)
    if made is not None and factors:
        made = builder.make((*loc, "factors"), made.with_factors, *factors, pivot=entry.pivot)
    return made


def build_mean(builder: Builder, loc: Loc, entry: Any) -> Any:
    """Return the mean stress correction of an entry; None, with problems, if it is invalid."""
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
