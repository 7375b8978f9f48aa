"""Terminal output of commands: lines, warnings, errors with exit codes, progress bar."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from io import TextIOWrapper
from typing import Any, Protocol, TextIO

from jousto.base.errors import InputError, JoustoError, JoustoWarning, SimulationError
from jousto.base.names import harmless

FAILED, BAD_INPUT = 1, 2


def say(text: str, *, error: bool = False, style: str = "") -> None:
    """Print one line, unwrapped and without markup; coloured on terminals only.

    Control characters in names from files are replaced by escape codes.
    """
    say_lines([text], error=error, style=style)


def say_lines(lines: Iterable[str], *, error: bool = False, style: str = "") -> None:
    """Print lines like `say`, all at once: a large model has a hundred thousand."""
    text = "\n".join(map(harmless, lines))
    stream = sys.stderr if error else sys.stdout
    if not (stream.isatty() or os.environ.get("FORCE_COLOR")):
        print(text, file=stream, flush=True)
        return
    from rich.console import Console

    console = Console(stderr=error, soft_wrap=True, markup=False, highlight=False, emoji=False)
    console.print(text, style=style)


@contextlib.contextmanager
def shown_warnings() -> Iterator[None]:
    """Print each JoustoWarning as one yellow line on stderr."""

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if not issubclass(category, JoustoWarning):
            default(message, category, filename, lineno, file, line)
        else:
            say(f"warning: {message}", error=True, style="yellow")

    with warnings.catch_warnings():
        default = warnings.showwarning
        warnings.simplefilter("always", JoustoWarning)
        warnings.showwarning = show
        yield


def spell_out() -> None:
    """Let output streams replace characters outside their encoding by escape codes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")


def report(error: BaseException) -> int:
    """Print an error and return its exit code."""
    if isinstance(error, InputError):
        for problem in error.problems:
            say(str(problem), error=True, style="red")
        return BAD_INPUT
    if isinstance(error, OSError):
        name = f"{error.filename}: " if error.filename else ""
        say(f"{name}{error.strerror or error}", error=True, style="red")
        return BAD_INPUT
    if not isinstance(error, JoustoError | KeyboardInterrupt):
        text = f"{type(error).__name__}: {error}".splitlines()[0]
        say(f"internal error, {text}", error=True, style="red")
        say("this is a bug of jousto; run again with --debug to see where", error=True)
        return FAILED
    say(str(error) or "interrupted", error=True, style="red")
    solution = getattr(error, "solution", None)
    if isinstance(error, SimulationError) and solution is not None:
        say(f"the results up to then are in {solution.path}", error=True)
    return FAILED


class _Page(Protocol):
    """Protocol of a page that a server on this computer offers."""

    @property
    def address(self) -> str: ...
    def open(self) -> bool: ...
    def wait(self) -> None: ...
    def close(self) -> None: ...


def until_ctrl_c(page: _Page, *, opens: bool) -> None:
    """Print the address of a page, open the browser if asked, and wait for Ctrl-C.

    The address is alone on its line, so that people and programs can copy it. Afterwards Ctrl-C
    ends the command without an error.
    """
    try:  # inside try before the text is printed: a reader of that text may interrupt at once
        say("Ctrl-C ends it", error=True)
        say(page.address)
        if opens and not page.open():
            say("no browser was found: open the address yourself", error=True, style="yellow")
        page.wait()
    except KeyboardInterrupt:  # interrupted before the wait began
        page.close()


def facts(rows: list[tuple[str, str]], title: str = "") -> None:
    """Print names and values in two columns."""
    if title:
        say(title, style="bold")
    width = max((len(name) for name, _ in rows), default=0)
    if rows:
        say_lines(f"  {name:<{width}}  {value}".rstrip() for name, value in rows)


def columns(rows: Iterable[Sequence[str]], sides: str = "<") -> None:
    """Print rows in columns; `sides`: ``<`` or ``>`` for each, the last one for all others."""
    rows = list(rows)
    widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = zip(row, sides.ljust(len(row), sides[-1]), widths, strict=True)
        lines.append("  " + "  ".join(f"{cell:{side}{width}}" for cell, side, width in cells))
    if lines:
        say_lines(map(str.rstrip, lines))


def most_at(shape: Mapping[str, Any]) -> str:
    """Return the text on the body that moves most in a mode shape; ties go to the first name."""
    import numpy as np

    from jousto.base.ranking import largest

    bodies = list(shape)
    return bodies[largest([np.abs(shape[body]).max(initial=0.0) for body in bodies], bodies)]


@contextlib.contextmanager
def progress_bar(text: str) -> Iterator[Callable[[int, int], None] | None]:
    """Show a progress bar on terminals; yields a function of the done and the total amount."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(escape(harmless(text)), total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def plain(value: Any) -> str:
    """Return a value as text for tables."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def numbers(values: Any) -> str:
    """Return values as text for tables, rounding errors as zero."""
    size = max((abs(value) for value in values), default=0.0)
    return " ".join(f"{0.0 if abs(x) <= 1e-9 * max(size, 1e-3) else x:.6g}" for x in values)


def named(values: Any, names: Sequence[str], unit: str) -> str:
    """Return values of a sensor as text: component names if there are several, and units.

    Examples
    --------
    >>> named([1.0, 2.0], ("Fx", "Mx"), "N, N m")
    'Fx = 1 N, Mx = 2 N m'
    >>> named([1.0, 0.0, 2.0], ("x", "y", "z"), "m")
    'x y z = 1 0 2 m'
    """
    units = unit.split(", ")
    size = len(values) // len(units)
    parts = []
    for k, one in enumerate(units):
        some = slice(k * size, (k + 1) * size)
        heads = (
            f"{' '.join(names[some])} = " if len(values) > 1 and len(names) == len(values) else ""
        )
        parts.append(f"{heads}{numbers(values[some])} {one}".rstrip())
    return ", ".join(parts)


def log_to_screen(verbose: int) -> None:
    """Write log records of the library to stderr: choices and progress (1), details too (2)."""
    log = logging.getLogger("jousto")
    log.handlers = [handler for handler in log.handlers if handler.name != "screen"]
    if not verbose:
        log.setLevel(logging.NOTSET)
        return
    handler = logging.StreamHandler(sys.stderr)
    handler.name = "screen"
    handler.setFormatter(logging.Formatter("%(name)s: %(message)s"))
    log.addHandler(handler)
    log.setLevel(logging.INFO if verbose == 1 else logging.DEBUG)
