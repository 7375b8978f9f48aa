"""write_csv: results as a table of text."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jousto.errors import Problems, suggest
from jousto.files import write_table
from jousto.output.style import target
from jousto.simulation import Solution


def write_csv(run: Solution, path: str | Path, *names: str) -> Path:
    """Write time and sensors as a table, one row for each instant.

    The first row names the columns with their units, as ``tip.x (m)``; numbers have all their
    digits.

    Parameters
    ----------
    run : Solution
        The results.
    path : path
        Ends with .csv.
    *names : str
        Sensors; all of them if none is named.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For an unknown sensor, or a path that cannot be written.
    """
    out = target(path, ("csv",))
    problems = Problems()
    for name in names:
        if name not in run:
            problems.add(str(run.path), f"no sensor '{name}'{suggest(name, run.sensors)}")
    problems.raise_if_any()
    heads, columns = ["time (s)"], [np.asarray(run.time)[:, None]]
    for name in names or run.sensors:
        about, values = run.about(name), np.asarray(run[name])
        values = values.reshape(len(values), -1)
        parts = about["components"] if values.shape[1] > 1 else ("",)
        unit = f" ({about['unit']})" if about["unit"] != "1" else ""
        heads += [f"{name}.{part}{unit}" if part else f"{name}{unit}" for part in parts]
        columns.append(values)
    return write_table(out, heads, np.concatenate(columns, axis=1).tolist())
