"""The templates of the page."""

from __future__ import annotations

from functools import cache

import jinja2

from workbench.report.words import proper_minus, without_polygons

__all__ = ["template"]


@cache
def template(name: str) -> jinja2.Template:
    """A template of this room, by its file; everything put into it is escaped."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("workbench.report", "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["for_reading"] = _for_reading
    environment.filters["plain"] = lambda name: name.replace("_", " ")
    environment.filters["percents"] = lambda text: text.replace(" %", "\u00a0%")
    environment.filters["minus"] = proper_minus
    return environment.get_template(name)


def _for_reading(text: str) -> str:
    """A sentence of a result as it stands on a page."""
    return proper_minus(without_polygons(text).replace("_", " "))
