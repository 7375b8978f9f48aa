"""Progress bars on a terminal, or in the running cell of a notebook."""

from __future__ import annotations

import html
import multiprocessing
import sys
import time
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress

AT_MOST = 0.1  # s, interval of updates in a notebook


def bars(*columns: Any) -> Progress:
    """Return progress bars on standard error, or in the running cell of a notebook.

    Parameters
    ----------
    *columns : rich.progress.ProgressColumn or str
        Columns of a bar; the default of rich if there are none.
    """
    from rich.console import Console
    from rich.progress import Progress

    if in_notebook():
        return _cell(*columns)
    return Progress(*columns, console=Console(stderr=True))


def has_viewer() -> bool:
    """Return whether bars are visible: on a terminal, or in the kernel of a notebook.

    False in one of several processes, whose bars would overwrite one another.
    """
    alone = multiprocessing.parent_process() is None
    return alone and (in_notebook() or sys.stderr.isatty())


def in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


def _cell(*columns: Any) -> Progress:
    """Return bars in the cell of a notebook as HTML without widgets."""
    import io

    from rich.console import Console
    from rich.progress import BarColumn, Progress
    from rich.text import Text

    notebook: Any = import_module("IPython.display")
    HTML, display = notebook.HTML, notebook.display

    class Cell(Progress):
        shown: Any = None
        last = 0.0

        def start(self) -> None:
            self.shown = display(HTML(""), display_id=True)

        def stop(self) -> None:
            self.refresh()

        def update(self, *given: Any, **more: Any) -> None:
            super().update(*given, **more)
            if time.monotonic() - self.last > AT_MOST:
                self.refresh()

        def refresh(self) -> None:
            if self.shown is not None:
                self.last = time.monotonic()
                self.shown.update(HTML("".join(self.line(task) for task in self.tasks)))

        def line(self, task: Any) -> str:
            return f"<div>{' '.join(self.piece(column, task) for column in self.columns)}</div>"

        def piece(self, column: Any, task: Any) -> str:
            if isinstance(column, BarColumn):
                known = "" if task.total is None else f' value="{task.completed / task.total:.4f}"'
                return f"<progress{known}></progress>"
            if isinstance(column, str):
                return html.escape(column.format(task=task))
            found = column(task)
            return html.escape(found.plain if isinstance(found, Text) else "")

    return Cell(*columns, auto_refresh=False, console=Console(file=io.StringIO()))
