"""Files of hot spots: their table and their histories."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.base.files import write_table, written
from jousto.base.voigt import STRAIN_COMPONENTS, STRESS_COMPONENTS
from jousto.recovery.hotspots.report import certificate_lines
from jousto.recovery.hotspots.search_result import Found


def write_spots(found: Found, path: str | Path) -> Path:
    """Write the table of hot spots; return the path."""
    target = _target(path, (".csv",))
    unit = found.unit
    names = STRAIN_COMPONENTS if found.fields[0].strain else STRESS_COMPONENTS
    heads = ["rank", "body", "site", "node", f"{found.criterion} ({unit})", "time (s)"]
    heads += [f"{axis} (m)" for axis in "xyz"] + [f"{name} ({unit})" for name in names]
    heads += [*(f"normal {axis}" for axis in "123"), f"between ({unit})"]
    heads += ["mesh error (Pa)"]
    rows: list[list[Any]] = [
        [
            *(spot.rank, spot.body, spot.site, spot.node, spot.value, spot.time),
            *spot.position.tolist(),
            *spot.tensor.tolist(),
            *spot.normal.tolist(),
            *("" if np.isnan(x) else x for x in (spot.between, spot.mesh)),
        ]
        for spot in found
    ]
    write_table(target, heads, rows)
    return target


def write_histories(found: Found, path: str | Path) -> Path:
    """Write the histories of hot spots; return the path."""
    target = _target(path, (".csv", ".h5"))
    if target.suffix.lower() == ".h5":
        return _write_hdf5(found, target)
    time = found.fields[0].time
    if any(not np.array_equal(field.time, time) for field in found.fields):
        message = "the bodies have different instants, which do not fit into one table; write .h5"
        raise InputError(Problem(str(target), message))
    names = STRAIN_COMPONENTS if found.fields[0].strain else STRESS_COMPONENTS
    heads, columns = ["time (s)"], [time[:, None]]
    for spot in found:
        name = f"{spot.rank} {spot.body} {spot.site}"
        heads += [f"{name} {key} ({found.unit})" for key in (str(found.criterion), *names)]
        field = found.field(spot)
        columns += [found.history(spot)[:, None], field.history(spot.site)]
    write_table(target, heads, np.concatenate(columns, axis=1).tolist())
    return target


def _write_hdf5(found: Found, target: Path) -> Path:
    import h5py

    with written(target) as beside, h5py.File(beside, "w") as file:
        file.attrs["format"] = "jousto hot spots"
        file.attrs["criterion"] = str(found.criterion)
        file.attrs["extreme"] = found.extreme
        file.attrs["separation"] = found.separation
        file.attrs["certified"] = int(found.certified)
        file.attrs["bound"] = found.bound
        file.attrs["certificate"] = "\n".join(certificate_lines(found))
        for spot in found:
            group = file.create_group(str(spot.rank))
            field = found.field(spot)
            for key in ("body", "site", "node", "time", "value", "position", "normal"):
                group.attrs[key] = getattr(spot, key)
            group["time"] = field.time
            group["time"].attrs["unit"] = "s"
            group["criterion"] = found.history(spot)
            group["tensor"] = field.history(spot.site)
            for name in ("criterion", "tensor"):
                group[name].attrs["unit"] = found.unit
            group["tensor"].attrs["frame"] = field.frame
            names = STRAIN_COMPONENTS if field.strain else STRESS_COMPONENTS
            group["tensor"].attrs["components"] = [name.encode() for name in names]
    return target


def _target(path: str | Path, endings: tuple[str, ...]) -> Path:
    target = Path(path)
    if target.suffix.lower() not in endings:
        raise InputError(Problem(str(target), f"must end with {' or '.join(endings)}"))
    return target
