"""How nouns show themselves in a line: small values as they are, of large ones what they are."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

__all__ = ["short_repr"]

LONGEST = 300
"""Characters of a line; what fields are longer than that are left out, and dots stand for them."""
_LONGEST_VALUE = 60


def short_repr(noun: Any) -> str:
    """Return a dataclass in a line of at most LONGEST characters: for its `__repr__`."""
    name = type(noun).__name__
    line = ""
    for field in fields(noun):
        if not field.repr:
            continue
        shown = f"{', ' if line else ''}{field.name}={_words(getattr(noun, field.name))}"
        if len(name) + len(line) + len(shown) + len("(, ...)") > LONGEST:
            return f"{name}({line}, ...)"
        line += shown
    return f"{name}({line})"


def _words(value: Any) -> str:
    """A value in a few words."""
    if isinstance(value, np.ndarray) and value.size > 3:
        return f"<array {value.shape}>"
    if isinstance(value, str) and len(value) > _LONGEST_VALUE:
        return repr(value[: _LONGEST_VALUE - 3] + "...")
    if isinstance(value, Collection) and not isinstance(value, (str, bytes, np.ndarray)):
        return _collection_words(value)
    text = repr(value)
    return text if len(text) <= _LONGEST_VALUE else f"<{type(value).__name__}>"


def _collection_words(value: Collection[Any]) -> str:
    """A collection as it is where that is short, else how many of what there are."""
    if len(value) <= 3 and not isinstance(value, Mapping):
        items = [_words(item) for item in value]
        text = f"({', '.join(items)}{',' if len(items) == 1 else ''})"
        if len(text) <= _LONGEST_VALUE:
            return text
    return f"<{type(value).__name__} of {len(value)}>" if len(value) else repr(value)
