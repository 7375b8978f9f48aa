"""Functional mock-up unit in a separate process, so that its crash becomes an error message."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time as clock
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import JoustoError
from jousto.base.names import harmless
from jousto.base.pipes import broken_pipes_raise
from jousto.model.model import FmuModel

log = logging.getLogger(__name__)

MOST_LOG = 20
"""Maximum number of lines of the log of a unit in a message."""
PATIENCE = 5.0  # shutdown timeout of the FMU process, s
OPENING = 60.0  # smallest timeout of loading, s
LOOKS = 4  # number of checks of the clock within the timeout of an answer


class FmuFailed(JoustoError):
    """Error raised if a unit returns an error or crashes."""


class FmuProcess:
    """Client of the process of a functional mock-up unit; all values are in SI.

    Parameters
    ----------
    model : FmuModel
        Functional mock-up unit.
    values : (k,) array
        Inputs of the unit at time 0.
    stop : float
        End of the run, s.

    Raises
    ------
    FmuFailed
        From the constructor and all methods, if the unit returns an error, crashes or is late.
    """

    def __init__(self, model: FmuModel, values: Array, stop: float) -> None:
        self.fmu = model.fmu
        about = self.fmu.description
        self._last: list[str] = []
        self._folder = tempfile.TemporaryDirectory(prefix="jousto-", ignore_cleanup_errors=True)
        folder = Path(self._folder.name)
        with zipfile.ZipFile(self.fmu.file) as archive:  # file names were checked before
            archive.extractall(folder / "unit")
        (folder / "unit" / "resources").mkdir(exist_ok=True)
        self._printed = open(folder / "printed", "w+b")
        paths = os.pathsep.join(entry for entry in sys.path if entry)
        # -P: no import of modules from the working folder; a new session: no Ctrl-C of the user
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "jousto.simulation.cosimulation.fmu_worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._printed,
            env={**os.environ, "PYTHONPATH": paths},
            text=True,
            encoding="utf-8",
            start_new_session=True,
        )
        self._until: float | None = None  # deadline of the current answer, s of the clock
        self._late = False
        self._closed = threading.Event()
        self._guard = threading.Thread(target=self._watch, name="jousto-fmu", daemon=True)
        self._guard.start()
        self._into = [about.variables[name] for name in (*model.measured, *model.given)]
        self._out = [about.variables[name] for name in self.fmu.outputs]
        chosen = [about.variables[name] for name in self.fmu.parameters]
        given = [(x - v.offset) / v.factor for v, x in zip(chosen, self.fmu.parameters.values(),
                                                           strict=True)]  # fmt: skip
        try:
            self.values = self._ask(
                "open",
                0.0,
                version=about.version,
                folder=str(folder / "unit"),
                identifier=about.identifier,
                token=about.token,
                name=self.fmu.name,
                inputs=[v.reference for v in self._into],
                outputs=[v.reference for v in self._out],
                parameters=[[v.reference for v in chosen], given],
                values=self._theirs(values),
                stop=stop,
            )
        except BaseException:
            self.close()
            raise

    def step(self, time: float, step: float, values: Array) -> Array:
        """Return the outputs at the end of a step with these inputs."""
        return self._ask("step", time, at=time, step=step, values=self._theirs(values))

    def exchange(self, time: float, values: Array) -> Array:
        """Return the outputs at the current time with these inputs."""
        return self._ask("exchange", time, values=self._theirs(values))

    def save(self, time: float) -> None:
        """Save the state of the unit in its process."""
        self._ask("save", time)

    def restore(self, time: float) -> None:
        """Restore the saved state of the unit."""
        self._ask("restore", time)

    def close(self) -> None:
        """Terminate the unit and its process."""
        with broken_pipes_raise():  # closing the pipe writes its buffer
            self._close()

    def _close(self) -> None:
        process = self._process
        if process.poll() is None:
            try:
                if sys.exc_info()[0] is None:
                    self._ask("close", 0.0)
            except FmuFailed:
                pass  # all results were received before
            try:
                process.stdin.close()  # type: ignore[union-attr]
                process.wait(0.1 if sys.exc_info()[0] else PATIENCE)
            except (OSError, subprocess.TimeoutExpired):
                process.kill()
                process.wait()
        self._closed.set()
        self._guard.join()
        for stream in (process.stdin, process.stdout, self._printed):
            try:
                stream.close()  # type: ignore[union-attr]
            except OSError:
                pass
        self._folder.cleanup()

    def _watch(self) -> None:
        """Kill the process after the deadline; the thread that waits then reads an end of file."""
        while not self._closed.wait(min(1.0, self.fmu.patience / LOOKS)):
            until = self._until
            if until is not None and clock.monotonic() > until:
                self._late = True
                self._process.kill()
                return

    def _theirs(self, values: Array) -> list[float]:
        pairs = zip(self._into, values.tolist(), strict=True)
        return [(x - v.offset) / v.factor for v, x in pairs]

    def _ask(self, do: str, time: float, **task: Any) -> Array:
        process = self._process
        patience = max(self.fmu.patience, OPENING if do == "open" else 0.0)
        self._until = clock.monotonic() + patience
        try:
            with broken_pipes_raise():
                process.stdin.write(json.dumps({"do": do, **task}) + "\n")  # type: ignore[union-attr]
                process.stdin.flush()  # type: ignore[union-attr]
            line = process.stdout.readline()  # type: ignore[union-attr]
        except (BrokenPipeError, OSError):
            line = ""
        finally:
            self._until = None
        if self._late:
            process.wait()
            raise FmuFailed(
                self._sentence(
                    time,
                    f"it did not answer ({do}) within its patience of {patience:g} s and "
                    f"was ended{self._said()}",
                )
            )
        if not line:
            raise FmuFailed(self._sentence(time, _ending(process.wait()) + self._said()))
        answer = json.loads(line)
        for text in answer["log"]:
            log.info("fmu '%s' at %g s: %s", self.fmu.name, time, harmless(text))
        self._last = [*self._last, *answer["log"]][-MOST_LOG:]
        if "error" in answer:
            raise FmuFailed(self._sentence(time, answer["error"]))
        found = np.array(answer["values"], dtype=np.float64)
        if do in ("open", "step", "exchange"):
            bad = np.flatnonzero(~np.isfinite(found))
            if len(bad):
                name, value = self._out[int(bad[0])].name, found[bad[0]]
                raise FmuFailed(self._sentence(time, f"its output {name!r} is {value}"))
            found = found * [v.factor for v in self._out] + [v.offset for v in self._out]
        return found

    def _sentence(self, time: float, what: str) -> str:
        lines: Sequence[str] = [line.strip() for line in self._last if line.strip()]
        tail = "; its log ends: " + " | ".join(lines[-3:]) if lines else ""
        return harmless(f"fmu '{self.fmu.name}' at {time:.6g} s: {what}{tail}")

    def _said(self) -> str:
        self._printed.seek(0, os.SEEK_END)
        self._printed.seek(max(0, self._printed.tell() - 400))
        lines = self._printed.read().decode(errors="replace").split("\n")
        message = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return f", it printed {message[:160]!r}" if message else ""


def _ending(code: int) -> str:
    """Return a text that describes how the process of a unit ended, from its exit code.

    >>> _ending(-11)
    'its binary crashed (SIGSEGV)'
    """
    if code >= 0:
        return f"its binary ended the process (exit code {code})"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else str(code)
    if name == "SIGKILL":
        return "its process was killed; check the free memory"
    return f"its binary crashed ({name})"
