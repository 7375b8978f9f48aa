"""Time stamps of loggers since 1970, or in days, as seconds from the first one."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array

# ranges of time stamps since 1970 by unit, for the years 1973 to 2286
EPOCHS = (
    (1e17, 1e19, 1e-9, "nanoseconds since 1970"),
    (1e14, 1e16, 1e-6, "microseconds since 1970"),
    (1e11, 1e13, 1e-3, "milliseconds since 1970"),
)
# ranges of day numbers: spreadsheets (from 1900) 1954 to 2119, MATLAB 1916 to 2080
DAYS = ((2e4, 8e4, "days of a spreadsheet"), (7e5, 7.6e5, "days of MATLAB"))
DAY = 86400.0
DATES = ("date", "datetime", "timestamp", "time stamp", "datum")
FINE = 1e-3  # median step below which large numbers are days (1e-3 days = 86 s)


def counted(name: str, t: Array, label: str | None) -> tuple[Array, tuple[str, ...]]:
    """Return instants (nt,) in seconds from the first one if they are time stamps.

    Parameters
    ----------
    name : str
        Heading of the column.
    t : (nt,) array
        Instants as in the file.
    label : str or None
        Unit in the file, if any; with a unit numbers are used unchanged.

    Returns
    -------
    (nt,) array, tuple of str
        The instants, and notes on how the time stamps were interpreted, with the alternative.
    """
    good = t[np.isfinite(t)]
    if not len(good):
        return t, ()
    first, steps = float(good[0]), np.abs(np.diff(good))
    usual = float(np.median(steps)) if len(steps) else 0.0
    if label is None:
        remedy = f"give units={{'{name}': 's'}} if it is seconds"
        for low, high, factor, what in EPOCHS:
            if low < first < high:
                return factor * (t - first), (f"column '{name}' counts {what}; {remedy}",)
        for low, high, what in DAYS:
            if low < first < high and (name.lower() in DATES or usual < FINE):
                message = (
                    f"column '{name}' counts {what}, in steps of {DAY * usual:.4g} s; {remedy}"
                )
                return DAY * (t - first), (message,)
    return (t - first if float(np.abs(good).max()) > 1e8 else t), ()
