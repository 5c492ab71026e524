"""report.html: one self-contained page of sections, each shown where its data is there."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from markupsafe import Markup

from workbench.draw.web.snippet import policy, scripts_html, style
from workbench.files.results.result import ResultFile, VerdictRow
from workbench.model.environment import Environment
from workbench.model.result import Result
from workbench.report.postures.section import postures_section
from workbench.report.templates import template
from workbench.report.turnable import PageViews
from workbench.report.words import adjusted_line, part_count

__all__ = ["page"]

Say = Callable[[str], None]


def page(
    result: Result,
    rows: ResultFile,
    *,
    files: Sequence[str] = (),
    film: str = "",
    progress: Say | None = None,
) -> str:
    """The HTML text of a result's report; the same bytes for the same result.

    Parameters
    ----------
    files
        The files beside the page that it links to.
    film
        The name of the film among them, "" where there is none.
    progress
        Called with words on how far it is.
    """
    say = progress or (lambda words: None)
    views = PageViews()
    sections = _sections(result, rows, film, say, views)
    verdicts = _by_criterion(rows.verdicts)
    return template("page.html.j2").render(
        policy=policy(media=bool(film)),
        view_style=Markup(style()),
        view_scripts=Markup(scripts_html(views.packing)),
        looks=[views.of_verdict(verdict) for verdict in verdicts],
        rows=rows,
        description=result.study.description,
        parts=part_count(_environment(result)),
        people=_people(result, rows),
        verdicts=verdicts,
        about=len({(verdict.row, verdict.motion) for verdict in rows.verdicts}) > 1,
        sections=sections,
        files=files,
    )


def _environment(result: Result) -> Environment:
    """The environment as it was checked: belts are parts of it."""
    if result.motions:
        return result.motions[0].study.environment
    return result.study.environment


def _people(result: Result, rows: ResultFile) -> list[str]:
    """A line for each role: who it is and where."""
    lines = []
    for found in rows.postures:
        lead = f"{found.row}, " if found.row else ""
        lines += [f"{lead}{person.name}: {person.description}" for person in found.people]
    for there in result.postures:
        lines += adjusted_line(there.environment, there.row)
    if rows.motions:
        from workbench.report.motions.section import motion_words  # not loaded for other studies

        lines += list(dict.fromkeys(motion_words(motion) for motion in rows.motions))
    if result.population is not None and rows.population is not None:
        from workbench.report.population.section import population_words

        lines.append(population_words(result.population, rows.population.role))
        if not result.postures:
            lines += adjusted_line(result.population.place.environment)
    return lines


def _by_criterion(verdicts: Sequence[VerdictRow]) -> list[VerdictRow]:
    """The verdicts in the order of the criteria, those of all motions on one criterion together."""
    order = list(dict.fromkeys(verdict.name for verdict in verdicts))
    return sorted(verdicts, key=lambda verdict: order.index(verdict.name))


def _sections(
    result: Result, rows: ResultFile, film: str, say: Say, views: PageViews
) -> list[Markup]:
    """The sections of the page, whose turnable pictures are added to `views`."""
    found = []
    for postures, some in zip(result.postures, rows.postures, strict=True):
        found.append(postures_section(postures, some, say, views))
    if result.motions:
        from workbench.report.motions.section import motions_section  # not loaded for other studies

        found.append(motions_section(result, rows, film=film, say=say, views=views))
    if result.population is not None:
        from workbench.report.population.section import population_section

        found.append(population_section(result.population, say, views))
    return found
