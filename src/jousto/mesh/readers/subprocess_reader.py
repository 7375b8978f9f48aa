"""Separate process for libraries that can crash on damaged files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problem, warn

TASK, ANSWER, ARRAYS = "task.json", "answer.json", "arrays.npz"


def apart(path: Path, function: str, remedy: str, **arguments: Any) -> Any:
    """Return the result of a function that runs in a new Python process.

    The data are returned as JSON and NumPy arrays without objects, so that they contain no code.

    Parameters
    ----------
    path : Path
        File that is read, for messages; also the argument `path` of the function.
    function : str
        ``"package.module:function"``. It returns nested lists and mappings of arrays and plain
        values.
    remedy : str
        Remedy for a crash of the process.
    **arguments
        Plain values.

    Raises
    ------
    InputError
        If the function raises an error, or the process ends early.

    Warns
    -----
    JoustoWarning
        For warnings of the function.
    """
    with tempfile.TemporaryDirectory(prefix="jousto-") as name:
        folder = Path(name)
        task = {"function": function, "arguments": {"path": str(path.absolute()), **arguments}}
        (folder / TASK).write_text(json.dumps(task), encoding="utf-8")
        # -P: do not import modules of the working folder
        command = [sys.executable, "-P", "-m", "jousto.mesh.readers.subprocess_worker", name]
        paths = os.pathsep.join(entry for entry in sys.path if entry)
        with open(folder / "told", "w+b") as told:
            code = subprocess.run(
                command,
                stdin=subprocess.DEVNULL,
                stdout=told,
                stderr=told,
                env={**os.environ, "PYTHONPATH": paths},
                check=False,
            ).returncode
            told.seek(max(0, told.tell() - 400))
            last = told.read().decode(errors="replace").split("\n")
        try:
            answer = json.loads((folder / ANSWER).read_text(encoding="utf-8"))
            with np.load(folder / ARRAYS, allow_pickle=False) as file:
                arrays = {key: file[key] for key in file.files}
        except (OSError, ValueError):
            message = next((line for line in reversed(last) if line.strip()), "")
            raise InputError(Problem(path.name, f"{ending(code, message)}; {remedy}")) from None
    for text in answer["warnings"]:
        warn("", text)
    if answer["problems"]:
        raise InputError([Problem(*problem) for problem in answer["problems"]])
    return unpacked(answer["value"], arrays)


def ending(code: int, said: str) -> str:
    """Return the reason why the process of a reader ended without a result.

    >>> ending(-11, "")
    'the library that reads it crashed (SIGSEGV)'
    """
    if code > 0:
        tail = f": {said.strip()[:160]}" if said else ""
        return f"the library that reads it failed (exit code {code}){tail}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else str(code)
    if name == "SIGKILL":
        return "the process that reads it was killed, probably for lack of memory"
    return f"the library that reads it crashed ({name})"


def packed(value: Any, arrays: dict[str, np.ndarray[Any, Any]]) -> Any:
    """Return a value in JSON form; arrays are stored in the mapping and replaced by their names.

    >>> arrays = {}
    >>> packed({"a": [1, np.arange(2)]}, arrays), list(arrays)
    ({'map': [['a', {'list': [1, {'array': '0'}]}]]}, ['0'])
    """
    if isinstance(value, np.ndarray):
        key = str(len(arrays))
        arrays[key] = value
        return {"array": key}
    if isinstance(value, Mapping):
        # keys may be numbers, which JSON would convert to text
        return {"map": [[packed(k, arrays), packed(v, arrays)] for k, v in value.items()]}
    if isinstance(value, list | tuple):
        return {"list": [packed(item, arrays) for item in value]}
    if isinstance(value, np.generic):
        return value.item()
    return value


def unpacked(value: Any, arrays: Mapping[str, np.ndarray[Any, Any]]) -> Any:
    """Return the packed value; tuples become lists."""
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    if kind == "array":
        return arrays[content]
    if kind == "list":
        return [unpacked(item, arrays) for item in content]
    return {unpacked(k, arrays): unpacked(v, arrays) for k, v in content}
