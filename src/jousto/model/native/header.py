"""Declarations of jousto.h by name: kinds of enums and data of structs."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.model.native.library import ffi


@functools.cache
def kinds(enum: str) -> dict[str, int]:
    """Return the values of an enum by name, ``JO_FORCE_modal_load`` as "modal load"."""
    numbers: dict[str, int] = ffi().typeof(enum).relements
    prefix = f"{enum}_".upper()  # jo_residue: JO_RESIDUE_
    if not all(name.startswith(prefix) for name in numbers):
        prefix = f"{enum.rpartition('_')[0]}_".upper()  # jo_force_type: JO_FORCE_
    return {
        name.removeprefix(prefix).removeprefix("JO_").lower().replace("_", " "): number
        for name, number in sorted(numbers.items(), key=lambda item: item[1])
    }


def kind(enum: str, number: int) -> str:
    """Return the name of a value of an enum; see `kinds`."""
    return next((name for name, value in kinds(enum).items() if value == number), str(number))


@functools.cache
def places(struct: str) -> dict[str, slice]:
    """Return the offsets of the fields of a struct of jo_reals in its flat array."""
    real = ffi().sizeof("jo_real")
    return {
        name: slice(field.offset // real, (field.offset + ffi().sizeof(field.type)) // real)
        for name, field in ffi().typeof(struct).fields
    }


@functools.cache
def columns(struct: str) -> np.dtype[Any]:
    """Return the NumPy layout of a struct: numbers, arrays of numbers and pointers."""
    numbers = {"int": np.intc, "double": np.float64}
    formats: dict[str, tuple[Any, int]] = {}
    for name, field in ffi().typeof(struct).fields:
        kind = field.type
        count = kind.length if kind.kind == "array" else 0
        kind = kind.item if count else kind
        number: Any = np.uintp if kind.kind == "pointer" else numbers.get(kind.cname)
        if number is not None:  # function pointers have no number
            formats[name] = ((number, (count,)) if count else number, field.offset)
    names = list(formats)
    return np.dtype(
        {
            "names": names,
            "formats": [formats[name][0] for name in names],
            "offsets": [formats[name][1] for name in names],
            "itemsize": ffi().sizeof(struct),
        }
    )


def named(struct: str, data: NDArray[Any]) -> Any:
    """Return views of the fields of a struct of jo_reals in flat data (..., size).

    A number has the shape (...), an array (..., k); fields beyond the end of the data are 0.
    """
    size = max(place.stop for place in places(struct).values())
    if data.shape[-1] < size:
        missing = np.zeros((*data.shape[:-1], size - data.shape[-1]), data.dtype)
        data = np.concatenate([data, missing], axis=-1)
    return SimpleNamespace(
        **{
            name: data[..., at.start if at.stop - at.start == 1 else at]
            for name, at in places(struct).items()
        }
    )


def packed(struct: str, /, *rest: ArrayLike, **values: ArrayLike) -> NDArray[np.float64]:
    """Return the flat data of a struct of jo_reals, and the numbers that follow it in memory."""
    data = rows(struct, 1, {name: np.asarray(value)[None] for name, value in values.items()})[0]
    return np.concatenate([data, *(np.ravel(x) for x in rest)]) if rest else data


def rows(struct: str, count: int, values: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
    """Return the flat data (count, size) of structs of jo_reals, 0 for missing fields.

    Raises
    ------
    ValueError
        If a field is unknown or of another size.
    """
    fields = places(struct)
    if unknown := values.keys() - fields.keys():
        raise ValueError(f"{struct} has the fields {', '.join(fields)}, no {min(unknown)}")
    found = np.result_type(np.float64, *values.values())
    out = np.zeros((count, max(place.stop for place in fields.values())), found)
    for name, value in values.items():
        out[:, fields[name]] = np.reshape(value, (count, -1))
    return out
