"""Functions of the rooms above the nouns, for the methods by which nouns offer them.

Reading and drawing lie above the nouns, so no noun may import them. They are looked up by name, and
only when somebody calls such a method.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["above"]


def above(module: str, function: str) -> Any:
    """Return a function by its module (below `workbench`) and its name."""
    return getattr(import_module(f"workbench.{module}"), function)
