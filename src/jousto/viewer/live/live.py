"""Function `live`: a machine that runs on a page while the user steers and pulls it."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.progress import in_notebook
from jousto.simulation.live.datagrams import Datagrams
from jousto.simulation.live.runner import Glance, Runner
from jousto.viewer.live.session import LiveDesk, Pusher
from jousto.viewer.live.sources import OpenedMachine, open_machine
from jousto.viewer.server import Server

if TYPE_CHECKING:
    from jousto.mechanism.mechanism import Mechanism
    from jousto.model.model import Model

HEIGHT = 640  # height of a notebook cell, pixels


class Live:
    """Running machine with its page, from `live`; ends with `close` or with the program."""

    def __init__(
        self,
        made: OpenedMachine,
        *,
        step: float | None,
        speed: float,
        playing: bool,
        ranges: Mapping[str, tuple[float, float]],
        record: Path | None,
        port: int,
        urgent: bool,
        udp: int | None,
    ) -> None:
        name = made.model.name or "machine"
        made = replace(made, rows=udp is not None)
        machine = made.machine(step)
        link = None if udp is None else Datagrams(machine, udp)
        self.runner = Runner(
            machine, speed=speed, playing=False, text=made.text, urgent=urgent, link=link
        )
        try:
            later = Path(f"{name.replace(' ', '-')}-live.h5")
            self._desk = LiveDesk(
                made, self.runner, step=step, ranges=ranges, record=record or later
            )
            self._server = Server(self._desk, port)
        except BaseException:
            self.runner.close()
            raise
        self.pictures = Pusher(self._desk, self._server.push)
        try:
            if record is not None:
                self.runner.record(record)
            if playing:
                self.runner.play()
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        where = self.address if self._server.running else "closed"
        return f"<Live {self._desk.title!r}: {self.time:.2f} s, {where}>"

    @property
    def address(self) -> str:
        """Address of the page on this computer; anyone with it can steer the machine."""
        return self._server.address

    @property
    def now(self) -> Glance:
        """State of the machine at this instant: q, the last row, timing."""
        return self.runner.glance

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.now.time

    def set(self, name: str, value: float) -> None:
        """Set the value of an input.

        Raises
        ------
        InputError
            If there is no such input, or the value is not finite.
        """
        self._desk.set(name, value)

    def pull(self, body: str, point: Any, target: Any) -> None:
        """Pull a point of a body towards a target until `release`.

        Parameters
        ----------
        body : str
            Name of the body.
        point : (3,) array_like
            Undeformed position in the frame of the body, m.
        target : (3,) array_like
            Target in the world, m.

        Raises
        ------
        InputError
            If there is no such body, or the points are invalid.
        """
        problems = Problems()
        names = [b.name for b in self.runner.machine.model.bodies]
        if body not in names:
            problems.add("pull", f"no body {body!r}; there are {', '.join(names)}")
        at = problems.array("pull", "point", point, (3,))
        to = problems.array("pull", "target", target, (3,))
        problems.raise_if_any()
        place, speed = names.index(body), self.runner.pace.speed
        here: Array = np.asarray(at)
        self.runner.do(lambda machine: machine.pull(place, here, to, speed=speed))

    def release(self) -> None:
        """Release the pulled point."""
        self.runner.do(lambda machine: machine.release())

    def play(self) -> None:
        """Start or continue the run."""
        self.runner.play()

    def pause(self) -> None:
        """Pause the run."""
        self.runner.pause()

    def reset(self) -> None:
        """Return to the initial state."""
        self.runner.reset()

    def record(self, path: str | Path | None) -> None:
        """Start a record into a results file; None ends it.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        self.runner.record(path)

    def change(self, parameter: str, value: float) -> None:
        """Set a parameter of the model file to a new value, in SI.

        Raises
        ------
        InputError
            If there is no such parameter, or the machine is invalid with its value.
        """
        self._desk.change(parameter, value)

    def open(self) -> bool:
        """Open the page in the browser; return whether a browser exists."""
        return self._server.open()

    def wait(self) -> None:
        """Wait until Ctrl-C, then close; for the end of a script."""
        try:
            self._server.wait()
        finally:
            self.close()

    def close(self) -> None:
        """End the machine, its record and its page; further calls have no effect."""
        self._server.close()
        self.pictures.close()
        self.runner.close()

    def _repr_html_(self) -> str:
        """Return the page as HTML of a notebook cell."""
        if not self._server.running:
            return f"<em>{html.escape(repr(self))}</em>"
        style = f"width: 100%; height: {HEIGHT}px; border: 0"
        return f'<iframe style="{style}" src="{html.escape(self.address)}"></iframe>'


@explained
def live(
    machine: str | Path | Mechanism | Model,
    *,
    step: float | None = None,
    speed: float = 1.0,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    record: str | Path | None = None,
    playing: bool = True,
    open: bool = True,
    port: int = 0,
    urgent: bool = False,
    udp: int | None = None,
    trust: bool = False,
) -> Live:
    """Run a machine in real time on a page: inputs become sliders, the mouse pulls its bodies.

    The mouse pulls by a spring and a damper at a point of a body, ``F = k (x - r) - c r'``; k and c
    depend on the effective mass of the point (`Live.pull`).

    Parameters
    ----------
    machine : path, Mechanism or Model
        Machine to run; parameters of a file can be changed.
    step : float, optional
        Step of the method, s; None: that of the file, or the choice of `simulate`.
    speed : float
        Simulated seconds per second of real time; 0: as fast as possible.
    ranges : dict of str to (float, float), optional
        Ranges of inputs in SI; by default they follow from the driven quantity.
    record : path, optional
        Results file that is written from the start.
    playing : bool
        Whether the machine starts immediately.
    open : bool
        Open the browser. In a notebook the page is shown in the cell instead.
    port : int
        Port of the server, 0 for any free port.
    urgent : bool
        Whether to request priority over other programs from the operating system;
        ``.runner.refused`` contains the reason of a refusal.
    udp : int, optional
        UDP port of this computer that receives frames of inputs and sends outputs, one per step; 0
        for any free port. ``.runner.link`` contains the port and the number of lost frames.
    trust : bool
        Whether Python functions and mock-up units that a model file names may run.

    Returns
    -------
    Live
        ``.set(name, value)``, ``.pull(...)``, ``.record(path)``, ``.wait()``, ``.close()``.

    Raises
    ------
    InputError
        If the machine cannot run, a range is empty, the port is taken, or the page was not built.

    Examples
    --------
    ``jo.live("crane.yaml").wait()``, ``jo.live(mechanism, record="run.h5")``
    """
    problems = Problems()
    if step is not None and problems.array("live", "step", step, ()) is not None:
        problems.positive("live", "step", float(step), "s")
    factor = problems.array("live", "speed", speed, ())
    if factor is not None and not float(factor) >= 0.0:
        problems.add(
            "live", f"speed is {speed}, must be positive, or 0 for the highest possible speed"
        )
    for key, whole in (("port", port), ("udp", 0 if udp is None else udp)):
        given: Any = whole
        if isinstance(given, bool) or not isinstance(given, int) or not 0 <= given < 65536:
            problems.add("live", f"{key} is {given!r}, must be a whole number from 0 to 65535")
    problems.raise_if_any()
    made = Live(
        open_machine(machine, trust=trust),
        step=None if step is None else float(step),
        speed=float(speed),
        playing=playing,
        ranges=dict(ranges or {}),
        record=None if record is None else Path(record),
        port=port,
        urgent=urgent,
        udp=udp,
    )
    if open and not in_notebook():
        made.open()
    return made
