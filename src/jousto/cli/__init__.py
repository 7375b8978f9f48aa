"""The command line, ``jousto``.

Exit codes: 0 success, 1 the run failed, 2 bad input. Problems and warnings go to stderr, one
line each. Everything heavy is imported inside the commands.
"""

from jousto.cli.group import app

__all__ = ["app", "main"]


def main() -> None:
    """Run the command line; the entry point of the ``jousto`` command."""
    app(prog_name="jousto")
