"""Solution: the results of a run, read from its file when asked for."""

from __future__ import annotations

import shutil
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.engine import BeamShape
from jousto.errors import InputError, Problem, suggest
from jousto.reduction import StressModes
from jousto.simulation.beams import GROUP, beam_knows_stress, read_beam
from jousto.simulation.events import Happening, happenings
from jousto.simulation.results import EVENT_COLUMNS, open_results
from jousto.simulation.state import MEMORY, State
from jousto.simulation.stress import knows_stress, read_stress

Array = NDArray[np.float64]
WORK = ("dissipated", "friction", "work")


@dataclass(frozen=True, eq=False)
class Energy:
    """Energy balance of a run, each (nt,) in J."""

    kinetic: Array
    strain: Array
    potential: Array
    springs: Array
    dissipated: Array
    friction: Array
    work: Array

    @property
    def total(self) -> Array:
        """Kinetic, strain and potential energy and that of the springs."""
        return self.kinetic + self.strain + self.potential + self.springs

    @property
    def error(self) -> Array:
        """What the balance misses since the start: total + dissipated + friction - work."""
        balance = self.total + self.dissipated + self.friction - self.work
        return np.asarray(balance - balance[0])


@dataclass(frozen=True, eq=False)
class Residuals:
    """Largest constraint residuals, each (nt,): ``|C|`` and ``|Cq v|``."""

    position: Array
    velocity: Array


@dataclass(frozen=True, eq=False)
class Work:
    """What a run cost, each (nt,).

    Attributes
    ----------
    steps, rejected, evaluations, iterations : array
        Steps taken, steps tried again with a shorter one, evaluations of the accelerations and
        iterations of Newton's method, all since the start.
    step : array
        Length of the last step, s.
    """

    steps: Array
    rejected: Array
    evaluations: Array
    iterations: Array
    step: Array


@dataclass(frozen=True, eq=False)
class BodyShape:
    """How to draw a body and where its state is.

    Attributes
    ----------
    name, kind : str
        Name; "rigid" or "flexible".
    q_offset, v_offset, n : int
        Its place in q and v, number of modes.
    nodes : (nn, 3) array
        Undeformed positions, body frame, m.
    elements : (ne, m) int array
        Nodes of each element.
    modes : (nn, 3, n) array
        Translation mode shapes.
    """

    name: str
    kind: str
    q_offset: int
    v_offset: int
    n: int
    nodes: Array
    elements: NDArray[np.int64]
    modes: Array


class Solution:
    """The results of a run.

    Arrays are read from the file when asked for; a run that is still going on or was killed is
    readable up to its last written piece.

    Parameters
    ----------
    path : path
        The results file.
    temporary : bool
        Remove the file's folder with this object.

    Attributes
    ----------
    path : Path
        The results file.
    attributes : dict
        Facts about the run: solver, step, wall_time (s), real_time_factor, ended, complete ...
    """

    def __init__(self, path: str | Path, *, temporary: bool = False) -> None:
        self.path = Path(path)
        with open_results(self.path) as file:
            self.attributes: dict[str, Any] = {
                key: _plain(value) for key, value in file.attrs.items()
            }
            self._sensors = tuple(file["sensors"])
            self._length = min(int(file["rows"][()]), len(file["time"]))
        if temporary:
            self._remove = weakref.finalize(
                self, shutil.rmtree, self.path.parent, ignore_errors=True
            )

    def __repr__(self) -> str:
        end = self.time[-1] if len(self) else 0.0
        state = "" if self.complete else ", incomplete"
        return f"<Solution {self.name!r}: {len(self)} instants to {end:g} s{state}>"

    def __len__(self) -> int:
        return self._length

    @contextmanager
    def _open(self) -> Iterator[Any]:
        with open_results(self.path) as file:
            if file.attrs["run"] != self.attributes["run"]:
                raise InputError(
                    Problem(
                        str(self.path),
                        "was overwritten by another run; open it again, load(path), or give every "
                        "run its own file",
                    )
                )
            yield file

    def _read(self, name: str) -> Array:
        with self._open() as file:
            dataset = file[name]
            return np.asarray(dataset[: self._length])

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return str(self.attributes["name"])

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return bool(self.attributes["complete"])

    @property
    def time(self) -> Array:
        """Instants (nt,), s."""
        return self._read("time")

    @property
    def q(self) -> Array:
        """Positions (nt, nq): [R e p] body after body."""
        return self._read("state/q")

    @property
    def v(self) -> Array:
        """Velocities (nt, nv): [R' w_local p'] body after body."""
        return self._read("state/v")

    @property
    def multipliers(self) -> Array:
        """Lagrange multipliers (nt, nrow), N or N m."""
        return self._read("state/multipliers")

    @property
    def energy(self) -> Energy:
        """Energy balance."""
        names = (
            "kinetic",
            "strain",
            "potential",
            "springs",
            "dissipated",
            "friction",
            "work",
        )
        return Energy(**{name: self._read(f"diagnostics/{name}") for name in names})

    @property
    def residuals(self) -> Residuals:
        """Constraint residuals."""
        return Residuals(
            self._read("diagnostics/position_residual"), self._read("diagnostics/velocity_residual")
        )

    @property
    def work(self) -> Work:
        """Steps taken and what they cost."""
        names = ("steps", "rejected", "evaluations", "iterations", "step")
        return Work(**{name: self._read(f"diagnostics/{name}") for name in names})

    @property
    def events(self) -> tuple[Happening, ...]:
        """Events and transitions of friction that happened, in their order."""
        with self._open() as file:
            if "events" not in file:
                return ()
            table = file["events"]
            count = int(table["rows"][()])
            columns = [table[name][:count] for name, _, _ in EVENT_COLUMNS]
            names = [name.decode() for name in table["names"][()]]
            joints = [""] * len(names)
            if "joints" in table:
                joints = [name.decode() for name in table["joints"][()]]
            return happenings(np.stack(columns, axis=1), names, int(table.attrs["events"]), joints)

    def state(self, time: float = -1.0) -> State:
        """Return the state at a stored instant, from which `simulate` can go on.

        Parameters
        ----------
        time : float
            A stored instant, s; negative for the last one.

        Raises
        ------
        InputError
            If nothing is stored at that time.
        """
        instants = self.time
        k = len(instants) - 1 if time < 0 else int(np.argmin(np.abs(instants - time)))
        if time >= 0 and abs(instants[k] - time) > 1e-9 * max(1.0, abs(time)):
            raise InputError(
                Problem(
                    str(self.path),
                    f"no instant is stored at {time:g} s, the nearest is {instants[k]:.9g} s",
                )
            )
        with self._open() as file:
            memory: dict[str, Any] = {
                name: np.asarray(file[f"state/{name}"][k])
                for name in MEMORY
                if f"state/{name}" in file
            }
            if "input" in memory:
                names = [name.decode() for name in file["state/input"].attrs["names"]]
                values = memory.pop("input")
                memory["inputs"] = dict(zip(names, map(float, values), strict=True))
            return State(
                q=np.asarray(file["state/q"][k]),
                v=np.asarray(file["state/v"][k]),
                lam=np.asarray(file["state/multipliers"][k]),
                time=float(instants[k]),
                work=np.array([file[f"diagnostics/{name}"][k] for name in WORK]),
                **memory,
            )

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors."""
        return self._sensors

    @property
    def model_text(self) -> str:
        """Text of the model file, empty if the model was made in Python."""
        with self._open() as file:
            return str(file["model"].asstr()[()])

    def __contains__(self, name: object) -> bool:
        return name in self._sensors

    def _dataset(self, name: str) -> str:
        if name not in self._sensors:
            raise InputError(
                Problem(str(self.path), f"no sensor '{name}'{suggest(name, self._sensors)}")
            )
        return f"sensors/{name}"

    def __getitem__(self, name: str) -> Array:
        """Return the values of a sensor, (nt, k)."""
        return self._read(self._dataset(name))

    def about(self, name: str) -> dict[str, Any]:
        """Return unit, resolved_in, description and components of a sensor."""
        with self._open() as file:
            place = self._dataset(name)
            attrs = file[place].attrs
            names = file[place.replace("sensors/", "components/", 1)][()]
            return {
                "unit": str(attrs["unit"]),
                "resolved_in": str(attrs["resolved_in"]),
                "description": str(attrs["description"]),
                "components": tuple(c.decode() for c in names),
            }

    @property
    def bodies(self) -> tuple[BodyShape, ...]:
        """Bodies with what is needed to draw them."""
        with self._open() as file:
            return tuple(
                BodyShape(
                    name=name,
                    kind=str(group.attrs["kind"]),
                    q_offset=int(group.attrs["q_offset"]),
                    v_offset=int(group.attrs["v_offset"]),
                    n=int(group.attrs["modes"]),
                    nodes=np.asarray(group["nodes"]),
                    elements=np.asarray(group["elements"]),
                    modes=np.asarray(group["mode_shapes"]),
                )
                for name, group in file["bodies"].items()
            )

    @property
    def beams(self) -> tuple[BeamShape, ...]:
        """Beams: their nodes are bodies, numbered as in `bodies`."""
        with self._open() as file:
            if GROUP not in file:
                return ()
            return tuple(read_beam(name, group) for name, group in file[GROUP].items())

    def beam_states(self, beam: str, rows: slice = slice(None)) -> tuple[Array, Array]:
        """Return ``[R e]`` (nt, n + 1, 7) and ``[R' w_local]`` (nt, n + 1, 6) of a beam's nodes.

        Parameters
        ----------
        beam : str
            Name of the beam.
        rows : slice
            Which instants; all of them if not given.

        Raises
        ------
        InputError
            If there is no such beam.
        """
        with self._open() as file:
            known = tuple(file[GROUP]) if GROUP in file else ()
            if beam not in known:
                tail = suggest(beam, known) if known else "; this run has no beams"
                raise InputError(Problem(str(self.path), f"no beam '{beam}'{tail}"))
            found = []
            start, stop, step = rows.indices(self._length)
            for place, width in (("q", 7), ("v", 6)):
                at = file[GROUP][beam][f"i{place}"][()]
                first = int(at.min())
                block = file[f"state/{place}"][start:stop:step, first : int(at.max()) + width]
                columns = (at - first)[:, None] + np.arange(width)
                found.append(np.asarray(block[:, columns]))
            return found[0], found[1]

    @property
    def stressed(self) -> tuple[str, ...]:
        """Names of the bodies and beams whose stress is known."""
        with self._open() as file:
            names = [k for k, g in file["bodies"].items() if knows_stress(g)]
            if GROUP in file:
                names += [name for name, group in file[GROUP].items() if beam_knows_stress(group)]
            return tuple(names)

    def stress_modes(self, body: str) -> StressModes | None:
        """Return the stress of each mode of a body, None if it is not known.

        Parameters
        ----------
        body : str
            Name of the body.

        Returns
        -------
        StressModes
            All places of parts made of beams and of parts whose places were chosen
            (``part.with_stress``); of other solids the nodes of their surface.

        Raises
        ------
        InputError
            If there is no such body.
        """
        with self._open() as file:
            if body not in file["bodies"]:
                raise InputError(
                    Problem(str(self.path), f"no body '{body}'{suggest(body, file['bodies'])}")
                )
            return read_stress(file["bodies"][body])

    def coordinates(self, body: str, rows: slice = slice(None)) -> Array:
        """Return the coordinates ``[R e p]`` of one body, (nt, 7 + n), at some stored instants.

        Only these are read from the file.

        Parameters
        ----------
        body : str
            Name of the body.
        rows : slice
            Which instants; all of them if not given.

        Raises
        ------
        InputError
            If there is no such body.
        """
        with self._open() as file:
            group = file["bodies"].get(body)
            if group is None:
                raise InputError(
                    Problem(str(self.path), f"no body '{body}'{suggest(body, file['bodies'])}")
                )
            first = int(group.attrs["q_offset"])
            last = first + 7 + int(group.attrs["modes"])
            start, stop, step = rows.indices(self._length)
            return np.asarray(file["state/q"][start:stop:step, first:last])


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode(errors="replace").rstrip()
    return value.item() if isinstance(value, np.generic) else value


def load(path: str | Path) -> Solution:
    """Open a results file.

    Raises
    ------
    InputError
        If there is no such file, it is damaged, or it is not a results file.
    """
    return Solution(path)
