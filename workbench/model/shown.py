"""How nouns show themselves in notebooks.

What draws lies above the nouns, so none of them may import it. It is looked up by its name, and
only when a notebook asks.
"""

from __future__ import annotations

from importlib import import_module

__all__ = ["shown_html"]

_PAINTER = "workbench.draw.web.notebook"


def shown_html(noun: object) -> str | None:
    """Return a noun as HTML for a notebook; None where there is nothing to be drawn."""
    found: str | None = import_module(_PAINTER).notebook_html(noun)
    return found
