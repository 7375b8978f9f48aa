"""The command line: ``jousto``."""

from jousto.cli.commands import app, main

__all__ = ["app", "main"]
