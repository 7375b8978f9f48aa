"""The command line, ``jousto``.

Exit codes: 0 success, 1 the run failed, 2 bad input. Problems and warnings go to stderr, one
line each. Everything heavy is imported inside the commands.
"""

import gc

GENERATION = 50_000  # new objects before a garbage collection; a start makes 100,000 that stay


def main() -> None:
    """Run the command line; the entry point of the ``jousto`` command."""
    gc.set_threshold(GENERATION)
    from jousto.cli.group import app

    app(prog_name="jousto")
