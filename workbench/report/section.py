"""The sections of a page and what they are made with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from markupsafe import Markup

from workbench.report.turnable import PageViews

__all__ = ["ORDER", "Making", "Section"]

ORDER = (
    "compared",
    "changes",
    "view",
    "failed",
    "warnings",
    "passed",
    "questions",
    "people",
    "tables",
    "method",
)
"""The places of a page from top to bottom."""


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Parameters
    ----------
    place
        Where it stands, one of ORDER. Sections of one place stay in the order in which they are
        made.
    name
        Its anchor, different for each section of a page.
    title
        Its heading.
    html
        What stands below the heading.
    folded
        Whether it opens on a click: its heading is the summary then. Paper shows it open.
    """

    place: str
    name: str
    title: str
    html: Markup
    folded: bool = False


@dataclass(frozen=True, eq=False)
class Making:
    """What all sections of one page share while they are made."""

    views: PageViews
    """The turnable pictures of the page."""
    files: Sequence[str] = ()
    """The files that lie beside the page."""
    film: str = ""
    """The name of the film among them, "" where there is none."""
    progress: Callable[[str], None] = field(default=lambda words: None)
    """Called with words on how far it is."""

    def link(self, *names: str) -> Markup:
        """Links to those of some files that lie beside the page, as a part of a caption."""
        links = [
            Markup('<a href="{0}" download>{0}</a>').format(name)
            for name in names
            if name in self.files
        ]
        return (
            Markup(' <span class="files">{}</span>').format(Markup(" ").join(links))
            if links
            else Markup("")
        )
