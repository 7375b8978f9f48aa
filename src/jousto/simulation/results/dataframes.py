"""Tables of results as text, pandas and xarray: names, components and units of the columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, UnknownNameError, suggest
from jousto.base.files import write_table

Column = tuple[str, dict[str, Any], Array]
"""Name, ``solution.about(name)`` and values of a sensor or component."""


Names = str | Sequence[str]


def component_units(about: dict[str, Any]) -> tuple[str, ...]:
    """Return the unit of each component of a sensor.

    If a sensor has several units, each applies to an equal share of the components, in order.

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
    """Return names, units and values (nt, k) of the columns, without time."""
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


def _pandas() -> Any:
    try:
        import pandas
    except ImportError as error:
        raise _missing("to_pandas", "pandas") from error
    return pandas


def frame_of(columns: Mapping[str, tuple[str, Sequence[Any]]]) -> Any:
    """Return a DataFrame of columns with their units."""
    frame = _pandas().DataFrame({name: values for name, (_, values) in columns.items()})
    frame.attrs["units"] = {name: unit for name, (unit, _) in columns.items()}
    return frame


def to_pandas(time: Array, columns: Sequence[Column]) -> Any:
    """Return a DataFrame, see `Solution.to_pandas`."""
    pandas = _pandas()
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
            f"needs the package {package}, which is not installed; pip install {package} "
            "(it is part of the extra frames)",
        )
    )


class Sensed(Protocol):
    """Interface of results with sensors."""

    @property
    def where(self) -> str:
        """Name of the results in messages."""

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors."""

    def components(self, sensor: str) -> tuple[str, ...]:
        """Return the names of the components of a sensor."""


def pick(run: Sensed, name: Any, more: Iterable[str] = ()) -> tuple[str, list[int]]:
    """Return the sensor of a name and the indices of the components that the name selects.

    The name ``middle`` selects all components of the sensor, ``middle.y`` and ``middle:y`` one
    component, ``root:e1.a.top`` all components that begin with ``e1.a.top``, ``root.s11`` the
    component s11 of every point.

    Parameters
    ----------
    run : Solution
    name : str
    more : names
        Further names for the suggestion in the message.

    Raises
    ------
    UnknownNameError
        If there is no such sensor or component; the message contains the nearest name.
    """
    known = run.sensors
    if name in known:
        return name, list(range(len(run.components(name))))
    text = name if isinstance(name, str) else ""
    # sensor and component names may both contain dots: take the longest sensor name that fits
    places = [i for i, letter in enumerate(text) if letter in ".:" and text[:i] in known]
    if places:
        sensor, rest = text[: places[-1]], text[places[-1] + 1 :]
        components = run.components(sensor)
        chosen = [i for i, c in enumerate(components) if c == rest or c.startswith(f"{rest}:")]
        chosen = chosen or [i for i, c in enumerate(components) if c.endswith(f":{rest}")]
        if chosen:
            return sensor, chosen
        message = f"sensor '{sensor}' has no component '{rest}'{suggest(rest, components)}"
    else:
        message = f"no sensor {name!r}{suggest(name, [*known, *more])}"
    raise UnknownNameError(Problem(run.where, message))


def selected_names(run: Sensed, names: Sequence[Any], sensors: Any) -> tuple[str, ...]:
    """Return the named sensors and components; all sensors if no name is given.

    Raises
    ------
    InputError
        For unknown names and values that are not names.
    """
    problems, found = Problems(), []
    for given in (*names, sensors):
        if not isinstance(given, str | Sequence):
            problems.add(run.where, f"sensors is {given!r}, must be a name or a list of names")
            continue
        for name in (given,) if isinstance(given, str) else given:
            try:
                pick(run, name)
            except InputError as error:
                problems.found += error.problems
            found.append(name)
    problems.raise_if_any()
    return tuple(found) or run.sensors
