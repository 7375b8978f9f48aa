"""Process of a functional mock-up unit: reads tasks as lines of JSON, writes one answer each."""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from jousto.simulation.cosimulation.fmu_process import MOST_LOG

STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")


class Worker:
    """Loaded functional mock-up unit with the lines of its log."""

    def __init__(self) -> None:
        self.log: list[str] = []
        self.saved: list[Any] = []

    def told(self, status: int, message: Any) -> None:
        """Append a message of the unit to the log; called by FMPy."""
        text = message.decode(errors="replace") if isinstance(message, bytes) else str(message)
        self.log = [*self.log[1 - MOST_LOG :], f"{STATUS[status % 6]}: {text}"]

    def open(self, task: dict[str, Any]) -> list[float]:
        """Load a unit, initialise it at time 0 with parameters and inputs, return its outputs."""
        from fmpy import calloc, fmi2, fmi3, free

        self.version = task["version"]
        self.refs = task["inputs"], task["outputs"]
        facts = {
            "guid": task["token"],
            "unzipDirectory": task["folder"],
            "modelIdentifier": task["identifier"],
            "instanceName": task["name"],
        }
        unit: Any
        if self.version == 2:
            self.unit = unit = fmi2.FMU2Slave(**facts)
            calls = fmi2.fmi2CallbackFunctions()
            calls.logger = fmi2.fmi2CallbackLoggerTYPE(
                lambda place, name, status, category, message: self.told(status, message)
            )
            calls.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
            calls.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
            expand_messages(calls)
            unit.instantiate(callbacks=calls, loggingOn=True)
            self.put, self.get = unit.setReal, unit.getReal
            self.put_some(*task["parameters"])
            unit.setupExperiment(startTime=0.0, stopTime=task["stop"])
            unit.enterInitializationMode()
        else:
            self.unit = unit = fmi3.FMU3Slave(**facts)
            unit.instantiate(
                loggingOn=True,
                logMessage=lambda place, status, category, message: self.told(status, message),
            )
            self.put, self.get = unit.setFloat64, unit.getFloat64
            self.put_some(*task["parameters"])
            unit.enterInitializationMode(startTime=0.0, stopTime=task["stop"])
        self.put_some(self.refs[0], task["values"])
        unit.exitInitializationMode()
        return self.values()

    def put_some(self, references: list[int], values: list[float]) -> None:
        """Set values of variables; an empty list causes no call of the unit."""
        if references:
            self.put(references, values)

    def values(self) -> list[float]:
        """Return the values of the outputs."""
        return list(self.get(self.refs[1])) if self.refs[1] else []

    def exchange(self, task: dict[str, Any]) -> list[float]:
        """Set the inputs and return the outputs."""
        self.put_some(self.refs[0], task["values"])
        return self.values()

    def step(self, task: dict[str, Any]) -> list[float]:
        """Set the inputs, make a step, and return the outputs at its end."""
        self.put_some(self.refs[0], task["values"])
        done = self.unit.doStep(task["at"], task["step"], not self.saved)
        if done and (done[1] or done[2]):
            word = "ended the simulation" if done[1] else f"returned early, at {done[3]:g} s"
            raise RuntimeError(f"the step {word}")
        return self.values()

    def save(self, task: dict[str, Any]) -> list[float]:
        """Save the state of the unit."""
        self.saved = [self.unit.getFMUState()]
        return []

    def restore(self, task: dict[str, Any]) -> list[float]:
        """Restore the saved state of the unit."""
        self.unit.setFMUState(self.saved[0])
        self.unit.freeFMUState(self.saved.pop())
        return []

    def close(self, task: dict[str, Any]) -> list[float]:
        """Terminate the unit."""
        self.unit.terminate()
        self.unit.freeInstance()
        return []


def expand_messages(calls: Any) -> None:
    """Install the native logger of FMPy, which inserts the values into printf formats.

    A callback in Python receives only the format. FMPy has no such library for some platforms;
    messages then contain ``%d`` in place of a value.
    """
    from ctypes import byref

    try:
        from fmpy.logging import addLoggerProxy
    except (ImportError, OSError):
        return
    addLoggerProxy(byref(calls))


def main() -> None:
    """Execute tasks until the end of the input."""
    # a separate copy of stdout for the answers, since the unit may print to stdout
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    worker = Worker()
    for line in sys.stdin:
        task = json.loads(line)
        answer: dict[str, Any] = {}
        try:
            answer["values"] = getattr(worker, task["do"])(task)
        except Exception as error:  # any error of the unit or its loader
            answer["error"] = str(error).strip() or type(error).__name__
        answer["log"], worker.log = worker.log, []
        answers.write(json.dumps(answer) + "\n")
        answers.flush()
        if task["do"] == "close":
            return


if __name__ == "__main__":
    main()
