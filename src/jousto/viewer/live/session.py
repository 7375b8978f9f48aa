"""Requests and pushed pictures of the page of a running machine."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.rotations import rotation_matrix
from jousto.scene.machine import rows_of
from jousto.scene.scene import Motion
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.live.ranges import input_ranges
from jousto.simulation.live.runner import Glance, Runner
from jousto.simulation.results.row_layout import columns
from jousto.viewer.container import pack
from jousto.viewer.live.initial_scene import damages, inputs_header, scene_at
from jousto.viewer.live.sources import OpenedMachine
from jousto.viewer.packing import scene_header
from jousto.viewer.queries import Answers
from jousto.viewer.requests import Request
from jousto.viewer.touches import Touches, packed, state_of_row

STALE = 0.5  # interval, s, after which a picture is sent without a change


class LiveDesk:
    """Scene of a running machine, answers to its page, and pictures for it.

    Parameters
    ----------
    made : Opened
        The machine.
    runner : Runner
        Runner that steps the machine.
    step : float or None
        Step of the method, s; None: that of the solver.
    ranges : mapping of str to (float, float)
        Ranges of inputs.
    record : Path
        File of a record that the page requests.
    """

    def __init__(
        self,
        made: OpenedMachine,
        runner: Runner,
        *,
        step: float | None,
        ranges: Mapping[str, tuple[float, float]],
        record: Path,
    ) -> None:
        self.runner, self._step, self._ranges, self._record = runner, step, dict(ranges), record
        self._held: tuple[int, int] | None = None
        self._number = 0
        self._take(made)

    @property
    def title(self) -> str:
        """Title of the page."""
        return f"{self._made.model.name}, live"

    def page(self) -> bytes:
        """Raise InputError: a running machine cannot be saved as a page."""
        message = "shows a machine that runs here; record it and save the page of the record"
        raise InputError(Problem("page", message))

    # -- requests of the page -------------------------------------------------------------------

    def answer(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the header of the answer to a request.

        Raises
        ------
        JoustoError
            With the sentence that the page shows.
        """
        asked = Request(request)
        if "do" not in request:
            return self._asked(request)
        known: dict[str, Callable[[Request], Any]] = {
            "play": lambda _: self.runner.play(),
            "pause": lambda _: self.runner.pause(),
            "step": lambda _: self.runner.step(),
            "reset": self._reset,
            "set": lambda a: self.set(a.name("name"), a.number("value")),
            "pull": self._pull,
            "release": self._release,
            "record": lambda a: self.record(request.get("on") is True),
            "parameter": lambda a: self.change(a.name("name"), a.number("value")),
            "speed": lambda a: self.runner.speed(a.number("value")),
        }
        what = asked.name("do")
        if what not in known:
            raise InputError(Problem("request", f"do is {what!r}; there are {', '.join(known)}"))
        known[what](asked)
        return {"kind": "done"}

    def _asked(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the answer to a request about the present instant."""
        if request.get("ask") == "scene":
            return self._header()
        glance, row = self.runner.glance, self._row(self.runner.glance)
        now = Motion(np.array([glance.time]), lambda which: row[None][which])
        return Answers([replace(self.scene, motion=now)]).answer(request)

    def _header(self) -> dict[str, Any]:
        header = scene_header(self.scene, None, half=True)
        values = self.runner.glance.inputs
        header["inputs"] = inputs_header(self._inputs, values)
        made = self._made
        header["parameters"] = [
            {
                "name": x.name,
                "value": made.values.get(x.name, x.value),
                "unit": x.unit,
                "low": None if x.bounds is None else x.bounds[0],
                "high": None if x.bounds is None else x.bounds[1],
            }
            for x in made.parameters
        ]
        return header

    # -- actions ----------------------------------------------------------------------------------

    def set(self, name: str, value: float) -> None:
        """Set the value of an input."""
        self.runner.do(lambda machine: machine.set(name, value))

    def _reset(self, _: Request) -> None:
        self._held = None
        self.runner.reset()

    def _release(self, _: Request) -> None:
        self._held = None
        self.runner.do(lambda machine: machine.release())

    def _pull(self, asked: Request) -> None:
        body = asked.whole("body", len(self.scene.bodies))
        vertex = asked.whole("vertex", len(self.scene.bodies[body].positions))
        self.pull(body, vertex, asked.vector("point"))

    def pull(self, body: int, vertex: int, target: Array) -> None:
        """Pull a vertex of a scene body towards a target in the world, m."""
        fresh = (body, vertex) != self._held
        self._held = (body, vertex)

        def act(machine: LiveMachine) -> None:
            if fresh:
                place, point = self._point(machine, body, vertex, target)
                machine.pull(place, point, speed=self.runner.pace.speed)
            machine.aim(target)

        try:
            self.runner.do(act)
        except InputError:
            self._held = None
            raise

    def _point(
        self, machine: LiveMachine, body: int, vertex: int, target: Array
    ) -> tuple[int, Array]:
        """Return the engine's body and the undeformed point in its frame."""
        seen, q = self.scene.bodies[body], machine.engine.q
        column = seen.place
        if seen.rings is not None:
            rings = seen.rings
            ring = int(rings.vertex_ring[vertex])
            node = int(rings.element[ring]) + (rings.share[ring] > 0.5)
            column = int(rings.places[node])
        for k, known in enumerate(machine.model.bodies):
            if known.iq == column:
                if seen.rings is None:
                    return k, np.asarray(seen.positions[vertex], dtype=np.float64)
                A = rotation_matrix(q[column + 3 : column + 7])
                return k, A.T @ (target - q[column : column + 3])
        raise InputError(Problem(f"body '{seen.name}'", "is fixed; it cannot be pulled"))

    def record(self, on: bool) -> None:
        """Start or end a record; existing files are never overwritten."""
        path, number = self._record, 1
        while on and path.exists():
            number += 1
            path = self._record.with_name(f"{self._record.stem}-{number}{self._record.suffix}")
        self.runner.record(path if on else None)

    def change(self, name: str, value: float) -> None:
        """Set a parameter to a new value: rebuild the machine and continue from its state.

        If the state does not fit the new machine, the machine restarts, with a message on the page.
        """
        made = self._made.changed(name, value)
        messages = []

        def replaced(old: LiveMachine) -> LiveMachine:
            new = made.machine(self._step)
            names = [body.name for body in old.model.bodies]
            try:
                if names != [body.name for body in new.model.bodies]:
                    raise InputError(Problem("live", "the new machine has other bodies"))
                new.carry(old.state(), old.inputs)
            except InputError as error:
                messages.append(f"with {name} = {value:g} the machine starts anew: {error}")
                new = made.machine(self._step)
            return new

        self.runner.replace(replaced, made.text)
        self._held = None
        self._take(made)
        self.runner.say(messages[0] if messages else "")

    # -- pictures ---------------------------------------------------------------------------------

    def _take(self, made: OpenedMachine) -> None:
        self._made = made
        self._inputs = input_ranges(made.model, self._ranges)
        run, self.scene = scene_at(made.model, made.state, self.title)
        self._rows = rows_of(run)[0]
        self._known = {c.place: c for c in columns(made.model)}
        self._touches = Touches(made.model) if made.model.touches else None
        self._number += 1

    def _row(self, glance: Glance) -> Array:
        v = self._known["state/v"]
        q = glance.q[None]
        return np.asarray(
            self._rows.from_states(q, glance.row[None, v.first : v.first + v.count])[0]
        )

    def live(self, glance: Glance) -> dict[str, Any]:
        """Return the header of a picture of the machine."""
        model = self._made.model
        first = self._known[f"sensors/{model.sensors[0].name}"].first if model.sensors else 0
        values = glance.row[first : first + model.nout]
        damage = [
            {"name": name, "value": float(values[place])} for name, place in damages(model).items()
        ]
        return {
            "kind": "live",
            "time": glance.time,
            "row": self._row(glance).astype(np.float32),
            "sensors": np.asarray(values, dtype=np.float64),
            "factor": glance.factor,
            "worst": glance.worst,
            "late": list(glance.late),
            "missed": glance.missed,
            "damage": damage,
            "playing": glance.playing,
            "recording": glance.recording or None,
            "message": glance.message,
            "scene": self._number,
            **self._contacts(glance),
        }

    def _contacts(self, glance: Glance) -> dict[str, Any]:
        """Return the points at which bodies touch; nothing for a machine without contacts."""
        if self._touches is None:
            return {}
        try:
            return {"touches": self._touches.at([state_of_row(glance.row, self._known)])}
        except InputError:  # a motion that has diverged
            return {"touches": packed([[]])}


class Pusher:
    """Thread that sends each new picture of the machine to all pages."""

    def __init__(self, desk: LiveDesk, push: Callable[[bytes], None]) -> None:
        self._desk, self._push, self._ended = desk, push, False
        self.pictures = 0
        self._thread = threading.Thread(target=self._run, name="jousto-pictures", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        runner = self._desk.runner
        while not self._ended:
            if runner.fresh.wait(STALE):
                runner.fresh.clear()
            glance = runner.glance
            if len(glance.q) != self._desk._made.model.nq:
                continue  # picture of a machine that is being replaced
            self._push(pack(self._desk.live(glance)))
            self.pictures += 1

    def close(self) -> None:
        """End the thread."""
        self._ended = True
        self._desk.runner.fresh.set()
        self._thread.join()
