"""What jousto.h declares, by name: the kinds of an enum and the data of an object."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.model.native.library import ffi


@functools.cache
def kinds(enum: str) -> dict[str, int]:
    """Return the numbers of an enum by name: of ``JO_FORCE_MODAL_LOAD`` that of "modal load"."""
    numbers: dict[str, int] = ffi().typeof(enum).relements
    prefix = f"{enum.rpartition('_')[0]}_".upper()  # jo_force_type: JO_FORCE_
    return {name.removeprefix(prefix).lower().replace("_", " "): numbers[name] for name in numbers}


@functools.cache
def places(struct: str) -> dict[str, slice]:
    """Return where the fields of a struct of jo_reals lie in a flat array."""
    real = ffi().sizeof("jo_real")
    starts = {name: field.offset // real for name, field in ffi().typeof(struct).fields}
    ends = [*list(starts.values())[1:], ffi().sizeof(struct) // real]
    return {
        name: slice(start, end) for (name, start), end in zip(starts.items(), ends, strict=True)
    }


def packed(struct: str, *rest: ArrayLike, **values: ArrayLike) -> NDArray[np.float64]:
    """Return the flat data of a struct of jo_reals, and what follows behind it.

    Raises
    ------
    ValueError
        If a field is missing, unknown or of another size.
    """
    fields = places(struct)
    if fields.keys() != values.keys():
        raise ValueError(f"{struct} has the fields {', '.join(fields)}, not {', '.join(values)}")
    out = np.empty(ffi().sizeof(struct) // ffi().sizeof("jo_real"))
    for name, place in fields.items():
        out[place] = np.ravel(values[name])
    return np.concatenate([out, *(np.ravel(x) for x in rest)]) if rest else out
