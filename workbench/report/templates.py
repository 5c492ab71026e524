"""The templates of the page."""

from __future__ import annotations

from functools import cache

import jinja2

from workbench.model.units import plain
from workbench.report.sentences import for_reading, proper_minus

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
    environment.filters["for_reading"] = for_reading
    environment.filters["plain"] = plain
    environment.filters["percents"] = lambda text: text.replace(" %", "\u00a0%")
    environment.filters["minus"] = proper_minus
    return environment.get_template(name)
