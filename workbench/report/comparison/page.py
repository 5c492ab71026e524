"""Everything a comparison leaves behind: comparison.json, people.csv, requirements.csv and
report.html."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.body.people.share import percent
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import policy, scripts_html, style
from workbench.files.output_file import Content
from workbench.files.output_folder import write_folder
from workbench.files.results.comparison import MARK, ChangedPersonRow, ComparisonFile, PairRow
from workbench.files.results.result import dump_json
from workbench.model.comparison import Comparison, PairedShare
from workbench.model.figures import plain
from workbench.model.population import SEXES, person_name
from workbench.model.population_found import ChangedPerson
from workbench.report.comparison.picture import changed_picture
from workbench.report.comparison.words import (
    chance_words,
    change_sentence,
    comparison_headline,
    difference_words,
)
from workbench.report.page_script import page_script, page_script_html
from workbench.report.population.charts import change_whisker, changes_axis
from workbench.report.section import (
    Section,
    SectionWriter,
    data_section,
    provenance_section,
)
from workbench.report.tables import csv_text
from workbench.report.templates import template

__all__ = ["comparison_file", "comparison_page", "comparison_tables", "write_comparison"]

_MOST = 40  # people on the page
_FILES = (
    (MARK, "everything on this page, with all decimals"),
    ("people.csv", "everybody, with every margin before and after"),
    ("requirements.csv", "each requirement with its shares"),
)
"""The files beside the page, and what is in them."""
_CHANGES = {
    (False, True): "gained",
    (True, False): "lost",
    (True, True): "fits",
    (False, False): "left out",
}
"""What becomes of a person, by whether the design before and the one after fit."""


def write_comparison(
    found: Comparison,
    folder: Path,
    *,
    provenance: Mapping[str, Mapping[str, str]] | None = None,
    seen: ChangedPerson | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> ComparisonFile:
    """Write a comparison into a folder, all of it or nothing; returns what is in comparison.json.

    seen: somebody who gains or loses, for a picture.

    tell: see write_folder. InputError where the folder holds something else or cannot be written.
    """
    rows = comparison_file(found, provenance=provenance or {})
    files: dict[str, Content] = {MARK: dump_json(rows), **comparison_tables(found)}
    page = comparison_page(found, rows, seen=seen)
    write_folder(folder, files | {"report.html": page}, holds="comparison", tell=tell)
    return rows


def comparison_file(
    found: Comparison, *, provenance: Mapping[str, Mapping[str, str]]
) -> ComparisonFile:
    """The comparison as plain rows."""
    changed = [("gained", row) for row in found.gained] + [("lost", row) for row in found.lost]
    before = found.before
    after = found.after
    return ComparisonFile(
        headline=comparison_headline(found),
        before=before.name,
        after=after.name,
        before_title=before.title,
        after_title=after.title,
        people=len(before.labels),
        confidence=before.confidence,
        groups=[_row(pair) for pair in found.groups],
        requirements=[_row(pair) for pair in found.pairs],
        changes=list(found.changes),
        only_before=list(found.only_before),
        only_after=list(found.only_after),
        changed=[
            ChangedPersonRow(
                person=before.labels[row],
                row=row,
                change=change,
                sentence=change_sentence(found, row),
            )
            for change, row in changed
        ],
        provenance={kind: dict(rows) for kind, rows in provenance.items()},
    )


def _row(pair: PairedShare) -> PairRow:
    return PairRow(
        name=pair.name,
        people=pair.count,
        before=_nine(pair.before),
        after=_nine(pair.after),
        gained=pair.gainers,
        lost=pair.losers,
        difference=_nine(pair.difference),
        low=_nine(pair.low),
        high=_nine(pair.high),
        chance=_nine(pair.chance),
    )


def _nine(value: float) -> float:
    """Nine decimals: the last bits of a machine do not show."""
    return round(value, 9) + 0.0


def comparison_tables(found: Comparison) -> dict[str, str | bytes]:
    """people.csv: everybody with both verdicts and the margins of every requirement;
    requirements.csv: the shares."""
    return {"people.csv": _people_table(found), "requirements.csv": _shares_table(found)}


def _people_table(found: Comparison) -> str:
    """A row for each person: who it is, both verdicts, and both margins of each requirement."""
    one = found.before
    two = found.after
    shared = [pair.name for pair in found.pairs]
    columns = [(one.requirements.index(name), two.requirements.index(name)) for name in shared]
    header = ["person", "sex", "weight", "stature_mm", "fits_before", "fits_after", "change"]
    units = [one.unit(name) for name in shared]
    header += [
        f"{name}: {when} [{unit.column}]"
        for name, unit in zip(shared, units, strict=True)
        for when in ("before", "after")
    ]
    people = (
        [
            label,
            SEXES[int(one.sex[p])],
            one.weight[p],
            _mm(one.stature[p]),
            _yes(one.served[p]),
            _yes(two.served[p]),
            _CHANGES[bool(one.served[p]), bool(two.served[p])],
            *(
                _mm(1e-3 * unit.shown(m))
                for unit, (a, b) in zip(units, columns, strict=True)
                for m in (one.margin[p, a], two.margin[p, b])
            ),
        ]
        for p, label in enumerate(one.labels)
    )
    return csv_text(header, people)


def _shares_table(found: Comparison) -> str:
    """A row for all requirements of each group of people, and for each requirement."""
    rows = [("all requirements", pair) for pair in found.groups]
    rows += [("requirement", pair) for pair in found.pairs]
    head = ["what", *PairRow.model_fields]
    return csv_text(head, ([what, *_row(pair).model_dump().values()] for what, pair in rows))


def _mm(metres: float) -> float | str:
    return round(1000 * float(metres), 3) + 0.0 if np.isfinite(metres) else ""


def _yes(value: object) -> str:
    return "yes" if value else "no"


def comparison_page(
    found: Comparison, rows: ComparisonFile, *, seen: ChangedPerson | None = None
) -> str:
    """The HTML text of a comparison; the same bytes for the same two results.

    seen: somebody who gains or loses, for a picture.
    """
    packing = Packing()
    picture = "" if seen is None else changed_picture(found, seen, packing)
    lead = []
    if seen is not None:
        title = f"In the round: {person_name(found.before.labels[seen.row])}, before and after"
        lead = [Section("view", "view", title, Markup(picture))]
    return template("comparison/page.html.j2").render(
        policy=policy(page_script()),
        page_script=Markup(page_script_html()),
        rows=rows,
        unseen=seen is None and bool(found.gained or found.lost),
        view_style=Markup(style() if picture else ""),
        view_scripts=Markup(scripts_html(packing)),
        sections=[*lead, *_sections(found, rows)],
        only=[
            ("before", [plain(n) for n in found.only_before]),
            ("after", [plain(n) for n in found.only_after]),
        ],
    )


def _sections(found: Comparison, rows: ComparisonFile) -> list[Section]:
    """The sections of the page in their order."""
    ends = [abs(v) for pair in (*found.groups, *found.pairs) for v in (pair.low, pair.high)]
    reach = max([*ends, 0.01])
    changed = [pair for pair in found.pairs if pair.gainers or pair.losers]
    changed.sort(key=lambda pair: -abs(pair.difference))

    writer = SectionWriter("comparison", {"axis": Markup(changes_axis(reach))})
    groups = {
        "pairs": [_shown(pair, reach) for pair in found.groups],
        "what": "Group",
        "caption": "Groups of people: the share that meets everything at once, before and after",
        "same": 0,
    }
    pairs = {
        "pairs": [_shown(pair, reach) for pair in changed],
        "what": "Requirement",
        "caption": "Requirements that are met by other people after than before",
        "same": len(found.pairs) - len(changed),
    }
    known = bool(found.before.design and found.after.design)
    differ = {"changes": found.changes, "known": known, "most": _MOST}
    sections = [
        writer.section("changes", "differ", "What was changed", differ),
        writer.section("questions", "shares-1", "All requirements together", groups),
        writer.section("questions", "shares-2", "By requirement", pairs),
    ]
    for k, (word, change) in enumerate((("gain", "gained"), ("lose", "lost")), start=1):
        sentences = [row.sentence for row in rows.changed if row.change == change]
        values = {"sentences": sentences[:_MOST], "count": len(sentences), "most": _MOST}
        sections.append(writer.section("people", f"changed-{k}", f"Who {word}s", values))
    method = {"confidence": f"{100 * rows.confidence:g}"}
    return [
        *sections,
        data_section(_FILES),
        writer.section("method", "method", "Method and its limits", method),
        *([provenance_section(rows.provenance)] if rows.provenance else []),
    ]


def _shown(pair: PairedShare, reach: float) -> dict[str, Any]:
    said = f"{pair.name}: {difference_words(pair)}"
    return {
        "name": plain(pair.name),
        "before": percent(pair.before, pair.count),
        "after": percent(pair.after, pair.count),
        "gained": f"{pair.gainers:,}",
        "lost": f"{pair.losers:,}",
        "difference": difference_words(pair),
        "chance": chance_words(pair.chance),
        "chart": Markup(
            change_whisker(pair.low, pair.difference, pair.high, reach=reach, said=said)
        ),
    }
