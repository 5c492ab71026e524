"""What is said where a file cannot be opened, the same for every kind."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from workbench.errors import InputError
from workbench.files.inputs import note_input

__all__ = ["readable"]


@contextmanager
def readable(path: Path, kind: str) -> Iterator[None]:
    """Within it a file is opened and read; InputError where it is missing, a folder ("a YAML file is needed"), or the
    system refuses. kind: with its article, "a YAML file". The file is noted as an input, see `inputs`."""
    note_input(path)
    try:
        yield
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, {kind} is needed") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
