"""Results as a CSV table."""

from __future__ import annotations

from pathlib import Path

from jousto.base.arguments import explained_as
from jousto.output.style import target
from jousto.simulation.results.dataframes import Names
from jousto.simulation.results.solution import Solution


@explained_as("write")
def write_csv(run: Solution, path: str | Path, *names: Names, sensors: Names = ()) -> Path:
    """Write time and sensors as a table, one row for each instant.

    The first row names each column with its unit, as ``tip.x (m)`` or ``hinge.Mx (N m)``; numbers
    have all their digits. ``run.to_csv`` does the same, with any suffix.

    Parameters
    ----------
    run : Solution
        The results.
    path : path
        Ends with .csv.
    *names : str or list of str
        Sensors, or components such as ``hinge.Fx``; all sensors if none is named.
    sensors : str or list of str
        Sensors by keyword, as `names`.

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
    return run.to_csv(out, *names, sensors=sensors)
