"""One machine of trees.py by version 0.1.0: microseconds of a Runge-Kutta step and a place.

    PYTHON benchmarks/former.py CASE

PYTHON is an interpreter that has version 0.1.0; `trees.py former=PYTHON` asks it so. Prints the
microseconds, and where the end of the last link is after SPAN, m.
"""

from __future__ import annotations

import sys
from typing import Any

import jousto as jo
from trees import cases, mechanism, our_place, ours

RK4 = 1  # its number of the method


def engine(model: Any) -> Any:
    """Return an engine of version 0.1.0 that takes methods by name."""
    from jousto.engine.native import Engine  # type: ignore[import-not-found]

    class Named(Engine):  # type: ignore[misc]
        def native_solver(self, method: str, step: float, projection: bool) -> Any:
            return super().native_solver({"rk4": RK4}[method], step, projection)

    return Named(model)


def main() -> None:
    if jo.__version__ != "0.1.0":
        sys.exit(f"{sys.executable} has jousto {jo.__version__}, not 0.1.0")
    model = jo.compile(mechanism(cases(quick=False)[sys.argv[1]]))
    print(ours(model, "rk4", 3, engine), *our_place(model, "rk4", make=engine))


if __name__ == "__main__":
    main()
