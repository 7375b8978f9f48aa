"""Cost of each method of docs/seven-methods.md: runs the page's code and prints the wall time.

The code of the page is the benchmark: one block for each method after that of the machine. It runs
twice, since what is imported or drawn for the first time takes longer; the second time counts.
"""

from __future__ import annotations

import contextlib
import io
import re
import time
import warnings
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parent.parent / "docs" / "seven-methods.md"


def times() -> dict[str, float]:
    """Return the wall time of each block by its heading, s."""
    found, heading = {}, ""
    names: dict[str, Any] = {}
    pattern = r"^## ([^\n]+)$|^```python\n(.*?)^```$"
    for match in re.finditer(pattern, PAGE.read_text(encoding="utf-8"), re.M | re.S):
        if match[1]:
            heading = match[1]
            continue
        code = compile(match[2], str(PAGE), "exec")
        start = time.perf_counter()
        with contextlib.redirect_stdout(io.StringIO()):
            exec(code, names)
        found[heading] = time.perf_counter() - start
    return found


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    times()
    for heading, seconds in times().items():
        print(f"{heading:30} {1e3 * seconds:7.1f} ms")
