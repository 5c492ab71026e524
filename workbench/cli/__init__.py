"""The command line: the only room that prints. Each command, or group of commands, has a file."""

from __future__ import annotations

from workbench.cli.application import app, main

__all__ = ["app", "main"]
