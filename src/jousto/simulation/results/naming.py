"""What the names of sensors and their components mean, and which of them were asked for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from jousto.base.errors import InputError, Problem, Problems, UnknownNameError, suggest

Names = str | Sequence[str]


class Sensed(Protocol):
    """What has sensors: a run."""

    @property
    def where(self) -> str:
        """Name for messages."""

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors."""

    def components(self, sensor: str) -> tuple[str, ...]:
        """Return the names of the components of a sensor."""


def pick(run: Sensed, name: Any, more: Iterable[str] = ()) -> tuple[str, list[int]]:
    """Return the sensor and the numbers of its components that a name means.

    ``middle`` is all of a sensor, ``middle.y`` and ``middle:y`` are one component of it,
    ``root:e1.a.top`` all components that begin like this, ``root.s11`` that of every site.

    Parameters
    ----------
    run : Solution
    name : str
    more : names
        To suggest besides the sensors.

    Raises
    ------
    UnknownNameError
        If there is no such sensor or component; the nearest name is suggested.
    """
    known = run.sensors
    if name in known:
        return name, list(range(len(run.components(name))))
    text = name if isinstance(name, str) else ""
    # the name of a sensor may hold dots, and so may a component: the longest sensor name counts
    places = [i for i, letter in enumerate(text) if letter in ".:" and text[:i] in known]
    if places:
        sensor, rest = text[: places[-1]], text[places[-1] + 1 :]
        components = run.components(sensor)
        chosen = [i for i, c in enumerate(components) if c == rest or c.startswith(f"{rest}:")]
        chosen = chosen or [i for i, c in enumerate(components) if c.endswith(f":{rest}")]
        if chosen:
            return sensor, chosen
        said = f"sensor '{sensor}' has no component '{rest}'{suggest(rest, components)}"
    else:
        said = f"no sensor {name!r}{suggest(name, [*known, *more])}"
    raise UnknownNameError(Problem(run.where, said))


def named(run: Sensed, names: Sequence[Any], sensors: Any) -> tuple[str, ...]:
    """Return the sensors and components that are named, all sensors if none is.

    Raises
    ------
    InputError
        For unknown ones, and what is no name.
    """
    problems, found = Problems(), []
    for given in (*names, sensors):
        if not isinstance(given, str | Sequence):
            problems.add(run.where, f"sensors is {given!r}, must be names of sensors")
            continue
        for name in (given,) if isinstance(given, str) else given:
            try:
                pick(run, name)
            except InputError as error:
                problems.found += error.problems
            found.append(name)
    problems.raise_if_any()
    return tuple(found) or run.sensors
