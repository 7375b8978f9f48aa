"""Reader of robot files of any format, which is recognised by the root element."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem
from jousto.robots.description import Robot
from jousto.robots.readers.mjcf import read_mjcf
from jousto.robots.readers.sdf import read_sdf
from jousto.robots.readers.urdf import read_urdf
from jousto.robots.readers.xml import parse_file

READERS: dict[str, Callable[..., Robot]] = {
    "robot": read_urdf,
    "mujoco": read_mjcf,
    "sdf": read_sdf,
}


@explained
def read_robot(path: str | Path, **options: Any) -> Robot:
    """Return the robot in a URDF, MJCF or SDF file with any suffix.

    Parameters
    ----------
    path : str or Path
        Robot file.
    **options
        Options of `read_urdf`, `read_mjcf` or `read_sdf`.

    Raises
    ------
    InputError
        With all errors of the file, or for another format.
    """
    root = parse_file(Path(path))
    if root.tag not in READERS:
        known = ", ".join(f"<{tag}>" for tag in READERS)
        message = f"begins with <{root.tag}>; URDF, MJCF and SDF begin with {known}"
        raise InputError(Problem(f"{Path(path).name}:{root.line}", message))
    return READERS[root.tag](path, **options)
