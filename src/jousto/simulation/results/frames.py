"""Results as tables: columns with names and units, for text, pandas and xarray."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import write_table

Column = tuple[str, dict[str, Any], Array]
"""Name, ``solution.about(name)`` and values of a sensor or component."""


def component_units(about: dict[str, Any]) -> tuple[str, ...]:
    """Return the unit of each component of a sensor.

    Components of several units come in equal shares, in the order of the units.

    Parameters
    ----------
    about : dict
        From ``solution.about(name)``.

    Examples
    --------
    >>> component_units({"unit": "N, N m", "components": ("Fx", "Fy", "Mx", "My")})
    ('N', 'N', 'N m', 'N m')
    """
    units, count = about["unit"].split(", "), len(about["components"])
    return tuple(units[k * len(units) // count] for k in range(count))


def table(time: Array, columns: Sequence[Column]) -> tuple[list[str], list[str], Array]:
    """Return names, units and numbers (nt, k) of the columns, without time."""
    heads: list[str] = []
    units: list[str] = []
    blocks = [np.zeros((len(time), 0))]
    for name, about, values in columns:
        parts = about["components"]
        heads += [f"{name}.{part}" for part in parts] if len(parts) > 1 else [name]
        units += component_units(about)
        blocks.append(values.reshape(len(values), -1))
    return heads, units, np.concatenate(blocks, axis=1)


def to_csv(time: Array, columns: Sequence[Column], path: Path) -> None:
    """Write time and sensors as text, see `Solution.to_csv`."""
    heads, units, values = table(time, columns)
    first = [
        "time (s)",
        *(f"{h} ({u})" if u != "1" else h for h, u in zip(heads, units, strict=True)),
    ]
    rows = np.concatenate([time[:, None], values], axis=1)
    write_table(path, first, rows.tolist())


def to_pandas(time: Array, columns: Sequence[Column]) -> Any:
    """Return a DataFrame, see `Solution.to_pandas`."""
    try:
        import pandas
    except ImportError as error:
        raise _missing("to_pandas", "pandas") from error
    heads, units, values = table(time, columns)
    index = pandas.Index(time, name="time")
    frame = pandas.DataFrame(values, index=index, columns=heads)
    frame.attrs["units"] = {"time": "s", **dict(zip(heads, units, strict=True))}
    return frame


def to_xarray(time: Array, columns: Sequence[Column], run: dict[str, str]) -> Any:
    """Return a Dataset, see `Solution.to_xarray`."""
    try:
        import xarray
    except ImportError as error:
        raise _missing("to_xarray", "xarray") from error
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", time, {"units": "s"})}
    for name, about, values in columns:
        facts = {
            "units": about["unit"],
            "long_name": about["description"],
            "resolved_in": about["resolved_in"],
        }
        parts = list(about["components"])
        if len(parts) > 1:
            along = f"{name}_component"
            variables[name] = (("time", along), values, facts)
            coordinates[along] = parts
            coordinates[f"{name}_unit"] = (along, list(component_units(about)))
        else:
            variables[name] = ("time", values.reshape(len(values)), facts)
    return xarray.Dataset(variables, coordinates, run)


def _missing(function: str, package: str) -> InputError:
    return InputError(
        Problem(
            function,
            f"needs the package {package}, which is not installed: pip install {package} "
            "(it is part of the extra frames)",
        )
    )
