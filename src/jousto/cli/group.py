"""The application: commands that are imported when they are called."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer
from typer.core import TyperGroup

from jousto.base.errors import InputError, JoustoError, MissingFileError, Problem
from jousto.cli.options import Debug
from jousto.cli.terminal import log_to_screen, report, say, shown_warnings, spell_out

Function = TypeVar("Function", bound=Callable[..., None])

OFFERS = {
    "advise": "advise",
    "parts": "reduce",
    "export": "export",
    "realtime": "realtime",
    "commands": "check run info plot animate schema",
    "view": "view",
    "live": "live",
    "hotspots": "hotspots peaks",
    "fatigue": "fatigue",
    "stress": "stress",
    "forces": "forces",
    "contacts": "contacts",
    "friction": "friction",
    "gauges": "gauges",
    "meshes": "mesh",
    "monitor": "monitor",
    "multiaxial": "multiaxial strain-life hertz",
    "analyses": "path buckle equilibrium modes linearise kinematics",
    "study": "study",
    "identify": "identify",
    "reliability": "reliability",
    "optimise": "optimise",
    "verify": "verify",
}
PLACES = {name: place for place, names in OFFERS.items() for name in names.split()}
"""Commands in the order of the help, with the modules of this folder that offer them."""

# typer applications by the module that defines them, filled at import
OFFERED: dict[str, typer.Typer] = {}
SETTINGS = {"help_option_names": ["-h", "--help"]}


def command(name: str = "") -> Callable[[Function], Function]:
    """Return a decorator that makes a function a command; its name must be listed in `PLACES`.

    Errors of the command become lines on stderr and exit codes, or with ``--debug`` a traceback.
    """

    def add(function: Function) -> Function:
        @functools.wraps(function)
        def guarded(*args: Any, debug: bool = False, **kwargs: Any) -> None:
            spell_out()
            try:
                with shown_warnings():
                    function(*args, **kwargs)
            except (typer.Exit, typer.Abort):
                raise
            except (Exception, KeyboardInterrupt) as error:
                if debug:
                    raise
                raise typer.Exit(report(error)) from None

        old = inspect.signature(function, eval_str=True)
        more = inspect.Parameter(
            "debug", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Debug
        )
        guarded.__signature__ = old.replace(  # type: ignore[attr-defined]
            parameters=[*old.parameters.values(), more]
        )
        known = name or function.__name__
        one = typer.Typer(
            add_completion=False, pretty_exceptions_enable=False, context_settings=SETTINGS
        )
        OFFERED[known] = one
        return one.command(known)(guarded)  # type: ignore[return-value]

    return add


class _Prepared(Mapping[str, Any]):
    """Commands by name, imported at the first access."""

    def __getitem__(self, name: str) -> Any:
        import_module(f"jousto.cli.{PLACES[name]}")
        return typer.main.get_command(OFFERED[name])

    def __iter__(self) -> Iterator[str]:
        return iter(PLACES)

    def __len__(self) -> int:
        return len(PLACES)


class Commands(TyperGroup):
    """Command group that imports a command at its first use, which keeps the start short."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands: Any = _Prepared()


app = typer.Typer(
    cls=Commands,
    name="jousto",
    help="Simulate mechanisms with flexible bodies.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings=SETTINGS,
)


def own_classes(path: Path) -> None:
    """Import a Python file of the user that declares classes for model files.

    Raises
    ------
    InputError
        If the file is missing or fails.
    """
    from jousto.base.files import check_input, executed

    check_input(path)
    if not path.exists():
        raise MissingFileError(Problem(str(path), "no such file"))
    try:
        executed(path)
    except JoustoError:
        raise
    except Exception as error:  # user code may raise any exception
        text = f"cannot be imported: {type(error).__name__}: {error}"
        raise InputError(Problem(str(path), text)) from error


def _version(value: bool) -> None:
    if value:
        from jousto.base.version import __version__

        say(f"jousto {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
    verbose: Annotated[
        int,
        typer.Option(
            "--verbose", "-v", count=True, help="Say what is done and chosen; twice for details."
        ),
    ] = 0,
    files: Annotated[
        list[Path] | None,
        typer.Option(
            "--with",
            metavar="FILE.py",
            help="Run a file that declares own joints, forces, ... for model files. "
            "It is code that may do anything: trust it first.",
        ),
    ] = None,
) -> None:
    """Simulate mechanisms with flexible bodies."""
    log_to_screen(verbose)
    for path in files or ():
        try:
            own_classes(path)
        except Exception as error:
            raise typer.Exit(report(error)) from None
