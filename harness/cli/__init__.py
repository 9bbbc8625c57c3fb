"""The command line ``esfem``: a file for each command or family of them."""

from esfem.cli.commands import app, main

__all__ = ["app", "main"]
