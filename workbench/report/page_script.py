"""The script of a page: tables that are searched and sorted, values of curves under the mouse.

A page reads without it. Its bytes are the same each time, so that a content security policy can
name it by its hash.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files

__all__ = ["page_script", "page_script_html"]


@cache
def page_script() -> str:
    """Return the script."""
    return (files("workbench.report") / "page.js").read_text(encoding="utf-8")


def page_script_html() -> str:
    """Return the script as it stands at the end of a page."""
    return f'<script id="page-script">{page_script()}</script>'
