"""Worker process of `subprocess_reader`: runs one function and writes the result to a folder."""

from __future__ import annotations

import json
import sys
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.errors import InputError, JoustoWarning
from jousto.mesh.readers.subprocess_reader import ANSWER, ARRAYS, TASK, packed


def main(folder: Path) -> None:
    """Run the task of a folder."""
    task = json.loads((folder / TASK).read_text(encoding="utf-8"))
    module, name = task["function"].split(":")
    arguments = task["arguments"]
    arguments["path"] = Path(arguments["path"])
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    value, problems = None, []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            value = packed(getattr(import_module(module), name)(**arguments), arrays)
        except InputError as error:
            problems = [[problem.where, problem.sentence] for problem in error.problems]
    answer = {
        "value": value,
        "problems": problems,
        "warnings": [str(item.message) for item in caught if item.category is JoustoWarning],
    }
    with (folder / ARRAYS).open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)
    (folder / ANSWER).write_text(json.dumps(answer), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
