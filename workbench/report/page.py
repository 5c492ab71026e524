"""report.html: one self-contained page of sections, each shown where its data is there."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from markupsafe import Markup

from workbench.draw.web.snippet import policy, scripts_html, style
from workbench.files.results.result import ResultFile
from workbench.model.environment import Environment
from workbench.model.reach import MOST_SPARE
from workbench.model.result import Result
from workbench.model.study import PredictedPosture
from workbench.report.criteria import criteria_sections
from workbench.report.headline import deciding
from workbench.report.page_script import page_script, page_script_html
from workbench.report.postures.section import overlap_lines, postures_sections
from workbench.report.section import (
    ORDER,
    Making,
    Section,
    assumed_section,
    data_section,
    method_section,
    provenance_section,
)
from workbench.report.sentences import adjusted_line, moved_line, part_count
from workbench.report.templates import template
from workbench.report.turnable import PageViews

__all__ = ["page"]

Say = Callable[[str], None]
_HOLDS = {
    "result.json": "everything on this page, with all decimals",
    "verdicts.csv": "each criterion with what decides it",
    "breaches.csv": "every place where a criterion is broken",
    "contacts.csv": "every contact, with the numbers of spheres and polygons",
    "clearance.csv": "distances",
    "stops.csv": "joint stops",
    "postures.csv": "joint angles",
    "placements.csv": "where bodies and seats are",
    "reaches.csv": "who reaches what in which zone",
    "envelopes.csv": "reach envelopes, a row a ray",
    "envelope_levels.csv": "level sections of envelopes",
    "figures.csv": "figures of signals",
    "signals.csv": "position, speed and acceleration over time",
    "forces.csv": "forces over time",
    "agreement.csv": "how far two motions are apart",
    "people.csv": "everybody, with every margin",
    "people.parquet": "the same, for large tables",
    "requirements.csv": "each requirement with its shares",
    "shares.csv": "the groups and their shares",
    "gains.csv": "changes that were tried",
}
"""What is in the files beside a page."""


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
    views = PageViews(wanted=_lead(result, rows))
    making = Making(views, files, film, progress or (lambda words: None))
    sections = _sections(result, rows, making)
    return template("page.html.j2").render(
        policy=policy(page_script(), media=bool(film)),
        view_style=Markup(style()),
        view_scripts=Markup(scripts_html(views.packing)),
        page_script=Markup(page_script_html()),
        rows=rows,
        share=_share(result, rows),
        doubtful=sum(verdict.doubtful for verdict in rows.verdicts),
        description=result.study.description,
        parts=part_count(_environment(result)),
        people=_people(result, rows),
        sections=sorted(sections, key=lambda section: ORDER.index(section.place)),
    )


def _lead(result: Result, rows: ResultFile) -> tuple[str, str] | None:
    """The row and the case of the picture at the top: of the verdict that decides, as the headline
    says it, else the first case; None where neither postures nor motions are looked at."""
    verdict = deciding([one for one in result.verdicts if one.share is None])
    if verdict is not None and verdict.worst is not None:
        names = {motion.name or motion.case for motion in rows.motions}
        return (
            ("", verdict.motion) if verdict.motion in names else (verdict.row, verdict.worst.case)
        )
    if rows.postures:
        return rows.postures[0].row or "", rows.postures[0].cases[0]
    return ("", rows.motions[0].name or rows.motions[0].case) if rows.motions else None


def _share(result: Result, rows: ResultFile) -> str:
    """ "27 of 30 people fit, 20 without overlap" of a population, "" where there is none, and where something is to be
    known before it."""
    if result.population is None or rows.population is None:
        return ""
    from workbench.report.population.sentences import first_found  # not loaded for other studies

    if first_found(result.population):
        return ""
    served = rows.population.people.served
    clear = sum(rows.population.people.clear)
    without = f", {clear:,} without overlap" if clear < sum(served) else ""
    return f"{sum(served):,} of {len(served):,} people fit{without}"


def _environment(result: Result) -> Environment:
    """The environment as it was checked: belts are parts of it."""
    return result.motions[0].study.environment if result.motions else result.study.environment


def _people(result: Result, rows: ResultFile) -> list[str]:
    """A line for each role: who it is and where."""
    lines = []
    for found in rows.postures:
        lead = f"{found.row}, " if found.row else ""
        lines += [f"{lead}{person.name}: {person.description}" for person in found.people]
    lines += moved_line(result.study.moved)
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


def _sections(result: Result, rows: ResultFile, making: Making) -> list[Section]:
    """The sections of the page, those of one place in the order in which they stand there."""
    found = []
    overlaps = []
    for k, (postures, some) in enumerate(zip(result.postures, rows.postures, strict=True)):
        found += postures_sections(postures, some, making, number=k)
        overlaps += overlap_lines(postures, making.views)
    if result.study.moved:
        from workbench.report.postures.moved import moved_sections  # not loaded for other studies

        found += moved_sections(result, making)
    if result.motions:
        from workbench.report.motions.section import (  # not loaded for other studies
            motions_sections,
            unasked_lines,
        )

        found += motions_sections(result, rows, making)
        overlaps += unasked_lines(result, making.views)
    if result.population is not None:
        from workbench.report.population.section import population_sections

        found += population_sections(result.population, making)
    found += criteria_sections(rows, making, overlaps)
    if making.views.lead:
        where = ", ".join(word for word in making.views.wanted or () if word)
        fits = result.population is not None and bool(result.population.served.all())
        title = f"In the round: {where or ('the tightest case' if fits else 'the hardest case')}"
        found.append(Section("view", "view", title, making.views.lead))
    if making.files:
        found.append(data_section([(name, _holds(name)) for name in making.files]))
    if result.population is None:
        found.append(method_section(_method(result)))
    found += assumed_section(result.study.environment.assumed)
    return [*found, provenance_section(rows.provenance)]


def _holds(name: str) -> str:
    """What is in a file beside a page."""
    if name.startswith("envelope_") and name.endswith(".stl"):
        clear = name.endswith("_clear.stl")
        return "a reach envelope as a solid" + (", without what obstacles take" if clear else "")
    return _HOLDS.get(name, "")


def _method(result: Result) -> dict[str, object]:
    """What of the method applies to people in postures and motions."""
    bodies = [person.body for found in result.postures for person in found.people]
    bodies += [motion.study.body for motion in result.motions]
    stated = {
        body.name: bool(np.isfinite(body.fit_error[:, np.diff(body.start) > 0]).all())
        for body in bodies
    }
    predicted = [
        role
        for case in result.study.cases
        for role, action in zip(result.study.roles, case.actions, strict=True)
        if isinstance(action, PredictedPosture)
    ]
    strong = [one.rule_set for one in result.study.criteria if one.check == "force"]
    return {
        "known": [name for name, known in stated.items() if known],
        "unknown": [name for name, known in stated.items() if not known],
        "predicted": any(role.seat is not None for role in predicted),
        "bent": any(role.seat is None for role in predicted),
        "reaches": any(found.reaches for found in result.postures),
        "most": f"{1000 * MOST_SPARE:.0f}",
        "envelopes": any(found.envelopes for found in result.postures),
        "motions": bool(result.motions),
        "strength": sorted({rules.all_told for rules in strong if rules is not None}),
    }
