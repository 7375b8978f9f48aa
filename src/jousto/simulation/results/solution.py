"""Solution: the results of a run, in memory or in a file."""

from __future__ import annotations

import dataclasses
import shutil
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, count, suggest
from jousto.base.rounding import Scales
from jousto.model.beam_record import BeamShape
from jousto.model.model import Model
from jousto.model.symbol_record import SymbolShape
from jousto.reduction.fields.stress import StressModes
from jousto.simulation.results import dataframes
from jousto.simulation.results.contacts import RunContacts
from jousto.simulation.results.dataframes import Names, pick, selected_names
from jousto.simulation.results.diagnostics import Energy, Residuals, Work
from jousto.simulation.results.events import Happening
from jousto.simulation.results.records import BodyShape, Records
from jousto.simulation.results.stored import FileRecords
from jousto.simulation.state import State

T = TypeVar("T")

LONG = 100  # maximum length of a name in `repr`, characters
WORK = ("dissipated", "friction", "work")
OF_CONTACT = "contact_energy"  # energies of contacts in a state
OF_CONTACTS = ("contacts", "restitution", "rubbed")  # their names in the balance
STATES = 256  # number of states read at a time


class Solution(Mapping[str, Array]):
    """Results of a run: a mapping from the names of sensors to their values.

    The results are in memory or in a file. Arrays of a file are read when they are used; the
    results of a run that continues or was killed are readable up to the last written piece. A
    pickle contains the results, or their path if they are in a file of the user.

    ``run[name]`` are the values of a sensor (nt, k), ``run["hinge.Fx"]`` those of one component
    (nt,); ``keys``, ``values``, ``items``, ``get``, ``len`` and ``in`` work as for every mapping.

    Parameters
    ----------
    source : path or Records
        The results file, or results in memory.
    temporary : bool
        Whether the folder of the file is removed together with this object.

    Attributes
    ----------
    attributes : dict
        Attributes of the run: solver, step, wall_time (s), real_time_factor, ended, complete ...
    """

    def __init__(self, source: str | Path | Records, *, temporary: bool = False) -> None:
        self._path = Path(source) if isinstance(source, (str, Path)) else None
        records = FileRecords(Path(source)) if isinstance(source, (str, Path)) else source
        self._records: Records = records
        self._temporary = temporary
        if self._path is not None:  # the file may change later
            vars(self)["attributes"] = dict(records.attributes)
        if temporary and self._path:
            self._remove_with_this(self._path.parent)

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the run: solver, step, wall_time (s), real_time_factor, ended ..."""
        return dict(self._records.attributes)

    def _remove_with_this(self, folder: Path) -> None:
        self._remove = weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)

    @property
    def path(self) -> Path:
        """Results file; for results in memory a temporary one, removed with this object."""
        if self._path is None:
            folder = Path(tempfile.mkdtemp(prefix="jousto-"))
            self._remove_with_this(folder)
            self._records.save(folder / "run.h5")
            self._path = folder / "run.h5"
        return self._path

    @property
    def where(self) -> str:
        """Name of the storage of these results in messages."""
        return self._records.where

    @explained
    def save(self, path: str | Path) -> Path:
        """Write the results into a file that `load` reads, and return its path.

        Parameters
        ----------
        path : path
            Results file (HDF5), overwritten.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        target = Path(path)
        self._records.save(target)
        return target

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the function and arguments that rebuild this object in another process."""
        if isinstance(self._records, FileRecords):
            if not self._temporary:
                return load, (self._records.path.resolve(),)
            return _unpacked, (self._records.path.read_bytes(),)
        return Solution, (self._records,)

    def __repr__(self) -> str:
        name = self.name if len(self.name) <= LONG else f"{self.name[: LONG - 3]}..."
        try:
            end = self._records.read("time", slice(self.nt - 1, None))[0] if self.nt else 0.0
        except InputError:
            return f"<Solution {name!r}: its file is gone, overwritten or damaged>"
        facts = [f"{self.nt} instants to {end:g} s", count(len(self.sensors), "sensor")]
        first, comma, _ = self._solver.partition(",")
        facts += [f"{first}, ...)" if comma else first] if first else []
        if not self.complete:
            facts.append("incomplete")
        return f"<Solution {name!r}: {', '.join(facts)}>"

    def __str__(self) -> str:
        """Return a summary: solver with the reason of its choice, ending and energy balance."""
        reason = str(self.attributes.get("chosen", ""))
        ended = str(self.attributes.get("ended", "still running or killed"))
        lines = [repr(self)]
        if self._solver:
            lines.append(f"solver {self._solver}" + (f", {reason}" if reason else ""))
        with suppress(InputError):  # the file was removed
            lines.append(f"{ended}; {self.energy.verdict}")
        return "\n".join(lines)

    @property
    def _solver(self) -> str:
        return str(self.attributes.get("solver", ""))

    def __len__(self) -> int:
        return len(self.sensors)

    def __iter__(self) -> Iterator[str]:
        return iter(self.sensors)

    def __bool__(self) -> bool:
        return True  # a mapping without sensors is true too

    def __eq__(self, other: object) -> bool:
        return self is other  # two runs are compared array by array

    def __hash__(self) -> int:
        return object.__hash__(self)

    @property
    def nt(self) -> int:
        """Number of stored instants."""
        return self._records.length

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
        return self._records.read("time")

    @property
    def q(self) -> Array:
        """Positions (nt, nq): [R e p] body after body."""
        return self._records.read("state/q")

    @property
    def v(self) -> Array:
        """Velocities (nt, nv): [R' w_local p'] body after body."""
        return self._records.read("state/v")

    @property
    def multipliers(self) -> Array:
        """Lagrange multipliers (nt, nrow), N or N m."""
        return self._records.read("state/multipliers")

    def _diagnostics(self, kind: type[T], suffix: str = "") -> T:
        names = (field.name for field in dataclasses.fields(kind))  # type: ignore[arg-type]
        return kind(*(self._records.read(f"diagnostics/{name}{suffix}") for name in names))

    @property
    def energy(self) -> Energy:
        """Energy balance."""
        names = [field.name for field in dataclasses.fields(Energy)][: -len(OF_CONTACTS)]
        whole = [self._records.read(f"diagnostics/{name}") for name in names]
        if OF_CONTACT not in self._records.memory():
            return Energy(*whole, *(np.zeros(self.nt) for _ in OF_CONTACTS))
        return Energy(*whole, *self._records.read(f"state/{OF_CONTACT}").T)

    @property
    def residuals(self) -> Residuals:
        """Constraint residuals."""
        return self._diagnostics(Residuals, "_residual")

    @property
    def work(self) -> Work:
        """Counts of steps, evaluations and iterations."""
        return self._diagnostics(Work)

    @property
    def events(self) -> tuple[Happening, ...]:
        """Events and stick-slip transitions of the run, in order of time."""
        return self._records.events()

    @cached_property
    def contacts(self) -> RunContacts:
        """Contacts of the run from touch to part, and those of an instant: `RunContacts`."""
        return RunContacts(self, *self._records.contacts())

    @explained
    def state(self, time: float = -1.0) -> State:
        """Return the state at a stored instant, from which `simulate` can continue.

        Parameters
        ----------
        time : float
            A stored instant, s; negative for the last one.

        Raises
        ------
        InputError
            If no instant is stored at that time.
        """
        instants = self.time
        k = len(instants) - 1 if time < 0 else int(np.argmin(np.abs(instants - time)))
        if time >= 0 and abs(instants[k] - time) > 1e-9 * max(1.0, abs(time)):
            raise InputError(
                Problem(
                    self.where,
                    f"no instant is stored at {time:g} s, the nearest is {instants[k]:.9g} s",
                )
            )
        return self._states(slice(k, k + 1))[0]

    def each_state(self, instants: Iterable[int] | None = None) -> Iterator[State]:
        """Yield the states at stored instants, each piece of the file read once.

        Parameters
        ----------
        instants : iterable of int, optional
            Indices of the instants, preferably ascending; by default all.
        """
        first, block = 0, list[State]()
        for k in range(self.nt) if instants is None else instants:
            if not first <= k < first + len(block):
                first = k - k % STATES
                block = self._states(slice(first, min(first + STATES, self.nt)))
            yield block[k - first]

    def _states(self, rows: slice) -> list[State]:
        """Return the states at consecutive instants."""
        read = self._records.read
        memory = {name: read(f"state/{name}", rows) for name in self._records.memory()}
        given = memory.pop("input", None)
        names = () if given is None else self._records.inputs()
        q, v, lam = (read(f"state/{name}", rows) for name in ("q", "v", "multipliers"))
        time, work = read("time", rows), [read(f"diagnostics/{name}", rows) for name in WORK]
        found = []
        for k in range(len(time)):
            inside: dict[str, Any] = {name: values[k] for name, values in memory.items()}
            if given is not None:
                inside["inputs"] = dict(zip(names, map(float, given[k]), strict=True))
            done = np.array([values[k] for values in work])
            found.append(State(q[k], v[k], lam[k], time=float(time[k]), work=done, **inside))
        return found

    @property
    def model(self) -> Model | None:
        """Compiled model, for results in memory; None for results of a file or another process."""
        found: Model | None = getattr(self._records, "model", None)
        if found is None:
            return None
        # copies for other processes contain neither functions of the user nor beams
        functions = all(f.function is not None for f in found.forces if f.kind == "user")
        return found if functions and (found.beams or not found.beam_shapes) else None

    @property
    def inputs(self) -> dict[str, Array]:
        """Values (nt,) of the external inputs, each for the interval that ends at the instant.

        The first value is that for the interval that begins at the first instant.
        """
        names = self._records.inputs()
        columns = self._records.read("state/input").T if names else ()
        return dict(zip(names, columns, strict=True))

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors."""
        return self._records.sensors

    @property
    def model_text(self) -> str:
        """Text of the model file, empty if the model was made in Python."""
        return self._records.model_text()

    def __getitem__(self, name: str) -> Array:
        """Return the values of a sensor, (nt, k), or of one of its components, (nt,).

        Raises
        ------
        InputError
            For an unknown name, with the nearest names; the error is a `KeyError` too.
        """
        sensor, columns = pick(self, name)
        values = self._records.read(f"sensors/{sensor}")
        if sensor == name:
            return values
        return values[:, columns[0]] if len(columns) == 1 else values[:, columns]

    def components(self, sensor: str) -> tuple[str, ...]:
        """Return the names of the components of a sensor."""
        return tuple(self._records.about(sensor)["components"])

    def about(self, name: str) -> dict[str, Any]:
        """Return unit, resolved_in, description and components of a sensor or component."""
        sensor, columns = pick(self, name)
        about = self._records.about(sensor)
        if sensor == name:
            return about
        units = dataframes.component_units(about)
        return about | {
            "unit": ", ".join(dict.fromkeys(units[k] for k in columns)),
            "components": tuple(about["components"][k] for k in columns),
        }

    def floors(self, name: str) -> Array:
        """Return the rounding level (k,) of each component of a sensor, in its unit.

        Smaller values are rounding errors. The level is 0 for dimensionless components and for
        results without the scales of the machine. See `jousto.base.rounding`.
        """
        about, known = self.about(name), self.attributes.get("scales")
        units = dataframes.component_units(about)
        if known is None:
            return np.zeros(len(units))
        scales = Scales(*(float(x) for x in known))
        return np.array([scales.floor(unit) for unit in units])

    def _columns(self, names: tuple[Names, ...], sensors: Names) -> list[dataframes.Column]:
        return [
            (name, self.about(name), self[name]) for name in selected_names(self, names, sensors)
        ]

    @explained
    def to_csv(self, path: str | Path, *names: Names, sensors: Names = ()) -> Path:
        """Write time and sensors as a table of text, one row for each instant.

        The first row names each column with its unit, as ``hinge.Fx (N)``; numbers have all their
        digits.

        Parameters
        ----------
        path : path
            File, overwritten.
        *names : str or list of str
            Sensors, or components such as ``hinge.Fx``; all sensors if none is named.
        sensors : str or list of str
            The same by keyword.

        Returns
        -------
        Path
            The file written.

        Raises
        ------
        InputError
            For an unknown sensor, or a path that cannot be written.
        """
        dataframes.to_csv(self.time, self._columns(names, sensors), Path(path))
        return Path(path)

    def to_pandas(self, *names: Names, sensors: Names = ()) -> Any:
        """Return sensors as a ``pandas.DataFrame`` with the time, s, as its index.

        Needs the extra ``frames``. ``frame.attrs["units"]`` has the unit of each column.

        Parameters
        ----------
        *names : str or list of str
            Sensors, or components such as ``hinge.Fx``; all sensors if none is named.
        sensors : str or list of str
            The same by keyword.

        Returns
        -------
        pandas.DataFrame
            A column for each component: ``frame["hinge.Fx"]``.

        Raises
        ------
        InputError
            For an unknown sensor, or if pandas is not installed.
        """
        return dataframes.to_pandas(self.time, self._columns(names, sensors))

    def to_xarray(self, *names: Names, sensors: Names = ()) -> Any:
        """Return sensors as an ``xarray.Dataset`` over time, s.

        Needs the extra ``frames``. Variables have their units, frame and description.

        Parameters
        ----------
        *names : str or list of str
            Sensors, or components such as ``hinge.Fx``; all sensors if none is named.
        sensors : str or list of str
            The same by keyword.

        Returns
        -------
        xarray.Dataset
            A variable for each sensor: ``data["hinge"].sel(hinge_component="Fx")``.

        Raises
        ------
        InputError
            For an unknown sensor, or if xarray is not installed.
        """
        facts = {"name": self.name, "solver": self._solver}
        return dataframes.to_xarray(self.time, self._columns(names, sensors), facts)

    @property
    def bodies(self) -> tuple[BodyShape, ...]:
        """Bodies with their geometry for pictures."""
        return self._records.bodies()

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies; their geometry is not read."""
        return tuple(self._records.places())

    def body(self, name: str) -> BodyShape | None:
        """Return the body with a name, without reading other bodies; None if there is none."""
        return self._records.body(name)

    @property
    def symbols(self) -> tuple[SymbolShape, ...]:
        """Symbols of joints, forces, sensors and named points, for pictures."""
        return self._records.symbols()

    @property
    def beams(self) -> tuple[BeamShape, ...]:
        """Beams of the mechanism, with the index of each node in `bodies`."""
        return self._records.beams()

    @explained
    def beam_states(self, beam: str, rows: slice = slice(None)) -> tuple[Array, Array]:
        """Return ``[R e]`` (nt, n + 1, 7) and ``[R' w_local]`` (nt, n + 1, 6) of a beam's nodes.

        Parameters
        ----------
        beam : str
            Name of the beam.
        rows : slice
            Range of instants; all if not given.

        Raises
        ------
        InputError
            If there is no such beam.
        """
        known = self._records.beam_places()
        if beam not in known:
            tail = suggest(beam, known) if known else "; this run has no beams"
            raise InputError(Problem(self.where, f"no beam '{beam}'{tail}"))
        found = []
        for place, width, at in zip(("q", "v"), (7, 6), known[beam], strict=True):
            first = int(at.min())
            near = slice(first, int(at.max()) + width)
            block = self._records.read(f"state/{place}", rows, near)
            found.append(np.asarray(block[:, (at - first)[:, None] + np.arange(width)]))
        return found[0], found[1]

    @explained
    def states(
        self, rows: slice = slice(None), *, velocities: bool = True
    ) -> tuple[Array, Array | None]:
        """Return q (k, nq) and v (k, nv) at some stored instants; only these are read.

        Parameters
        ----------
        rows : slice
            Range of instants; all if not given.
        velocities : bool
            Whether v is returned; if not, None is returned in its place.
        """
        q = self._records.read("state/q", rows)
        return q, self._records.read("state/v", rows) if velocities else None

    @property
    def stressed(self) -> tuple[str, ...]:
        """Names of the bodies and beams with stress modes or section points."""
        return self._records.stressed()

    @explained
    def stress_modes(self, body: str) -> StressModes | None:
        """Return the stress of each mode of a body; None if the results contain none of it.

        Parameters
        ----------
        body : str
            Name of the body.

        Returns
        -------
        StressModes
            All points of parts made of beams and of parts with chosen points
            (``part.with_stress``); the nodes of the surface of other solids.

        Raises
        ------
        InputError
            If there is no such body.
        """
        self._place(body)
        return self._records.stress_modes(body)

    def _place(self, body: str) -> tuple[int, int, int]:
        places = self._records.places()
        if body not in places:
            raise InputError(Problem(self.where, f"no body '{body}'{suggest(body, places)}"))
        return places[body]

    @explained
    def coordinates(self, body: str, rows: slice = slice(None)) -> Array:
        """Return the coordinates ``[R e p]`` of one body, (nt, 7 + n), at some stored instants.

        Other bodies and instants are not read from the file.

        Parameters
        ----------
        body : str
            Name of the body.
        rows : slice
            Range of instants; all if not given.

        Raises
        ------
        InputError
            If there is no such body.
        """
        first, _, modes = self._place(body)
        return self._records.read("state/q", rows, slice(first, first + 7 + modes))

    def rates(self, body: str, rows: slice = slice(None)) -> Array:
        """Return the velocities ``[R' w_local p']`` of one body, (nt, 6 + n); see `coordinates`."""
        _, first, modes = self._place(body)
        return self._records.read("state/v", rows, slice(first, first + 6 + modes))


def _unpacked(content: bytes) -> Solution:
    """Return the results that another process sent as the bytes of a results file."""
    folder = Path(tempfile.mkdtemp(prefix="jousto-"))
    try:
        (folder / "run.h5").write_bytes(content)
        return Solution(folder / "run.h5", temporary=True)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


@explained
def load(path: str | Path) -> Solution:
    """Return the results in a results file.

    Raises
    ------
    InputError
        If the file does not exist, is damaged, is not a results file, or contains no instant.
    """
    run = Solution(path)
    if not run.nt:
        raise InputError(
            Problem(
                run.where,
                "contains no instant: its run has just begun, or was killed before the first "
                "instant; wait, or run the model again",
            )
        )
    return run
