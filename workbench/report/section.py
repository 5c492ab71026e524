"""The sections of a page and what they are made with."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from markupsafe import Markup

from workbench.report.templates import template
from workbench.report.turnable import PageViews

__all__ = [
    "ORDER",
    "Making",
    "Section",
    "SectionWriter",
    "assumed_section",
    "data_section",
    "method_section",
    "provenance_section",
]

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


@dataclass(frozen=True, eq=False)
class SectionWriter:
    """Writes sections by the templates of one folder.

    Parameters
    ----------
    folder
        The folder. A section's template is its name without a number at the end.
    shared
        What all templates are given.
    anchor_end, title_end
        What the anchors and the headings end with.
    """

    folder: str
    shared: Mapping[str, Any]
    anchor_end: str = ""
    title_end: str = ""

    def section(
        self,
        place: str,
        name: str,
        title: str,
        values: Mapping[str, Any],
        *,
        folded: bool = False,
    ) -> Section:
        """Write a section, see `Section`.

        Parameters
        ----------
        values
            What its template is given beside `shared`.
        """
        file = f"{self.folder}/{name.rstrip('0123456789-')}.html.j2"
        html = Markup(template(file).render({**self.shared, **values}))
        title = f"{title}{self.title_end}"
        return Section(place, f"{name}{self.anchor_end}", title, html, folded)


def data_section(files: Sequence[tuple[str, str]]) -> Section:
    """The files beside a page. files: their names, and what is in them."""
    return Section("tables", "data", "Data", Markup(template("data.html.j2").render(files=files)))


def method_section(values: Mapping[str, Any]) -> Section:
    """How people in postures and motions are judged, and what that leaves out.

    values: what of it applies, see the template.
    """
    html = Markup(template("method.html.j2").render(values))
    return Section("method", "method", "Method and its limits", html, folded=True)


def assumed_section(sentences: Sequence[str]) -> list[Section]:
    """What the environment leaves open and was taken to be so; nothing where it leaves nothing."""
    if not sentences:
        return []
    html = Markup(template("assumed.html.j2").render(sentences=sentences))
    return [Section("method", "assumed", "Assumed of the environment", html, folded=True)]


def provenance_section(provenance: Mapping[str, Mapping[str, str]]) -> Section:
    """Hashes of the inputs and versions of what computed."""
    html = Markup(template("provenance.html.j2").render(provenance=provenance))
    return Section("method", "provenance", "Provenance", html, folded=True)
