"""Scene as the header of a container, with the precision of each array.

A server sends mode shapes and modal stress as half floats with a scale for each mode: 3 digits,
enough for a picture. Displayed numbers come from the scene itself. A self-contained page contains 5
digits, relative to the largest value of each mode.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arrays import Array
from jousto.viewer.frames import Frames

if TYPE_CHECKING:
    from jousto.scene.scene import Body, Scene

VERSION = 1
TYPES = {
    "positions": "f4",
    "triangles": "u4",
    "lines": "u4",
    "edges": "u4",
    "static": "f4",
    "known": "u1",
    "nodes": "u4",
    "damage": "f4",
    "life": "f4",
    "places": "u4",
    "ends": "f8",
    "element": "u4",
    "share": "f8",
    "vertex_ring": "u4",
    "yz": "f4",
    "corner": "u2",
    "rows": "f8",
    "phi": "f8",
    "real": "f8",
    "imag": "f8",
}
"""Array types by field name; the page relies on them."""
PLAIN = ("up", "gravity", "u", "frame", "axis")  # short arrays that are sent as lists
MODAL = {"shapes": "shape_scale", "stress": "stress_scale"}
"""Arrays with one entry per mode, and the names of their scale factors."""
STEPS = 65536.0  # quantisation levels of modes in a self-contained page


def scene_header(scene: Scene, frames: Frames | None, *, half: bool) -> dict[str, Any]:
    """Return the header of a scene.

    Parameters
    ----------
    scene : Scene
    frames : Frames or None
        The instants that are shown, None if nothing moves.
    half : bool
        Half floats for mode shapes and modal stress, else floats with 5 digits.
    """
    times = np.zeros(0) if scene.motion is None else scene.motion.times
    header: dict[str, Any] = {
        "kind": "scene",
        "version": VERSION,
        **{
            field.name: plain(field.name, getattr(scene, field.name))
            for field in dataclasses.fields(scene)
            if field.name not in OWN
        },
        "bodies": [body_header(body, half=half) for body in scene.bodies],
        "row": len(scene.still),
        "still": np.asarray(scene.still, dtype=np.float64),
        "box": np.asarray(scene.box, dtype=np.float64).tolist(),
        "window": [float(times[0]), float(times[-1])] if len(times) else [0.0, 0.0],
    }
    return header | frames_header(times, frames)


OWN = {"bodies", "still", "box", "motion", "run"}
"""Fields of a scene that are packed separately or left out."""


def frames_header(times: Array, frames: Frames | None) -> dict[str, Any]:
    """Return the times of the frames and the number of stored instants per frame."""
    if frames is None:
        return {"frames": np.zeros(0), "thinned": 1}
    chosen = times[frames.first :: frames.every][: frames.number]
    return {"frames": np.asarray(chosen, dtype=np.float64), "thinned": frames.every}


def body_header(body: Body, *, half: bool) -> dict[str, Any]:
    """Return the header of a body."""
    found: dict[str, Any] = {}
    for field in dataclasses.fields(body):
        value = getattr(body, field.name)
        if field.name in MODAL and value is not None:
            found[field.name], scales = scaled(value) if half else rounded(value)
            found[MODAL[field.name]] = scales
        else:
            found[field.name] = plain(field.name, value)
    return found


def plain(name: str, value: Any) -> Any:
    """Return a value of a scene in the form of the header."""
    if value is None or isinstance(value, str | bool | int | float):
        return value
    if name in TYPES:
        return np.asarray(value, dtype=TYPES[name])
    if isinstance(value, np.ndarray):
        return value.tolist()
    if dataclasses.is_dataclass(value):
        return {
            field.name: plain(field.name, getattr(value, field.name))
            for field in dataclasses.fields(value)
        }
    if isinstance(value, Mapping):
        return {str(key): plain("", entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain("", entry) for entry in value]
    return value


def scaled(modes: Array) -> tuple[np.ndarray[Any, Any], list[float]]:
    """Return arrays (n, ...) as half floats with a scale factor each.

    Examples
    --------
    >>> halves, scales = scaled(np.array([[1e9, -2e9], [0.0, 0.0]]))
    >>> halves.dtype, (halves * np.array(scales)[:, None])[0]
    (dtype('float16'), array([ 1.e+09, -2.e+09]))
    """
    largest = np.array([float(np.abs(one).max(initial=0.0)) for one in modes])
    scales = np.where(largest > 0.0, largest, 1.0)
    halves = np.empty(modes.shape, dtype=np.float16)
    for j, scale in enumerate(scales):  # one mode after the other: a copy of all would be large
        halves[j] = modes[j] / scale
    return halves, scales.tolist()


def rounded(modes: Array) -> tuple[np.ndarray[Any, Any], list[float]]:
    """Return arrays (n, ...) rounded to 16 bits, which compress well, with a scale factor each.

    The error is up to 2^-17, 8e-6 of the largest value of the array.

    Examples
    --------
    >>> floats, scales = rounded(np.array([[300.0, 1.0, -100.0]]))
    >>> floats.dtype, (floats * scales[0]).round(3)
    (dtype('float32'), array([[300.   ,   0.998, -99.998]], dtype=float32))
    """
    largest = np.array([float(np.abs(one).max(initial=0.0)) for one in modes])
    scales = np.where(largest > 0.0, largest, 1.0)
    floats = np.empty(modes.shape, dtype=np.float32)
    for j, scale in enumerate(scales):
        floats[j] = np.round(modes[j] * (STEPS / scale)) / STEPS
    return floats, scales.tolist()
