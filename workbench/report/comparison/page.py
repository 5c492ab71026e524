"""Everything a comparison leaves behind: comparison.json, people.csv, requirements.csv and
report.html."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.body.people.proportions import percent, percent_number
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import policy, scripts_html, style
from workbench.draw.web.views import scene_view
from workbench.files.output_file import Content
from workbench.files.output_folder import write_folder
from workbench.files.results.comparison import MARK, ChangedPersonRow, ComparisonFile, PairRow
from workbench.files.results.result import dump_json
from workbench.model.accommodation import MET
from workbench.model.comparison import Comparison, Judged, PairedShare
from workbench.model.population import SEXES, person_name
from workbench.model.result import ChangedPerson, Illustration
from workbench.model.units import plain
from workbench.report.page_script import page_script, page_script_html
from workbench.report.population.charts import change_whisker, changes_axis
from workbench.report.population.sentences import (
    spare_words,
)
from workbench.report.section import (
    Section,
    SectionWriter,
    data_section,
    provenance_section,
)
from workbench.report.states import TwoStates, two_states
from workbench.report.tables import csv_text
from workbench.report.templates import template

__all__ = [
    "change_sentence",
    "changed_picture",
    "comparison_file",
    "comparison_headline",
    "comparison_page",
    "comparison_tables",
    "difference_words",
    "format_p_value",
    "person_to_show",
    "worst_missed",
    "write_comparison",
]

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
        "chance": format_p_value(pair.chance),
        "chart": Markup(
            change_whisker(pair.low, pair.difference, pair.high, reach=reach, said=said)
        ),
    }


_NAMES = ("before", "after")


def person_to_show(found: Comparison) -> tuple[int, str] | None:
    """Return the row of the first who gains, else of the first who loses, and the requirement that
    was, or is, missed by most; None where nobody changes or only one design asks for it."""
    for row in (*found.gained, *found.lost):
        name = worst_missed(found, row)
        if name in found.before.requirements and name in found.after.requirements:
            return row, name
    return None


def changed_picture(found: Comparison, seen: ChangedPerson, packing: Packing) -> str:
    """Return the place of the picture of somebody in both designs, and a sentence above it.

    Parameters
    ----------
    packing
        The pictures of the page; this one is added.
    """
    name = worst_missed(found, seen.row)
    pairs = ((found.before, seen.before), (found.after, seen.after))
    scenes = [_scene(judged, shown, name, seen.row) for judged, shown in pairs]
    who = found.before.labels[seen.row]
    title = f"{who}: {plain(name)}"
    place = two_states(
        TwoStates(
            views=(scene_view(scenes[0], [who]), scene_view(scenes[1], [who])),
            scenes=(scenes[0], scenes[1]),
            names=_NAMES,
            title=title,
            said=title,
            caption=f"{person_name(who)}, {plain(name)}: what is short or to spare in either design",
        ),
        packing,
    )
    return f'<p class="soft">{escape(change_sentence(found, seen.row))}</p>\n{place}\n'


def _scene(judged: Judged, shown: Illustration, name: str, row: int) -> Scene:
    """Somebody in one design, with what is short or to spare where the requirement is."""
    margin = float(judged.margin[row, judged.requirements.index(name)])
    short = not bool(judged.met[row, judged.requirements.index(name)])
    unit = judged.unit(name)
    words = f"{unit.short(-margin)} short" if short else spare_words(margin, unit)
    marks: tuple[Mark, ...] = ()
    if shown.target is not None:
        marks = (Mark(shown.target, words, "missed" if short else "reach"),)
    return Scene((SceneBody(shown.placed, 0, "warm"),), shown.environment, marks, judged.title)


_NOUNS = ("man", "woman")


def difference_words(pair: PairedShare) -> str:
    """ "+3 points (95 % interval +1 to +5)" of a difference of shares, in points of per cent."""
    difference, low, high = (
        _signed(share, pair.count) for share in (pair.difference, pair.low, pair.high)
    )
    return f"{difference} points ({100 * pair.confidence:g} % interval {low} to {high})"


def _signed(share: float, count: int) -> str:
    text = percent_number(share, count)
    return text.replace("-", "−") if float(text) <= 0 else f"+{text}"


def format_p_value(chance: float) -> str:
    """ "0.11", "under 0.001"."""
    return "under 0.001" if chance < 0.001 else f"{chance:.2g}" if chance < 0.995 else "1"


def comparison_headline(found: Comparison) -> str:
    """The whole comparison in two sentences."""
    everybody = found.groups[0]
    count = everybody.count
    chance = format_p_value(everybody.chance)
    chance = chance.replace("under", "<") if chance.startswith("under") else f"= {chance}"
    shares = f"{percent(everybody.before, count)} of {count:,} people fit before and {percent(everybody.after, count)} after"
    if not everybody.gainers and not everybody.losers:
        return f"{shares}: the same people, nobody gains and nobody loses."
    return (
        f"{shares}, {difference_words(everybody)}. {_people(everybody.gainers)} gain{_plural(everybody.gainers)} and "
        f"{_people(everybody.losers).lower()} lose{_plural(everybody.losers)} "
        f"(exact McNemar test: p {chance})."
    )


def _people(count: int) -> str:
    return {0: "Nobody", 1: "One person"}.get(count, f"{count:,} people")


def _plural(count: int) -> str:
    return "s" if count < 2 else ""


def change_sentence(found: Comparison, row: int) -> str:
    """Why somebody fits in one design only: "female 31, a woman of 1,512 mm: “reach flaps” was 41
    mm short, 12 mm to spare now."; the requirement that was, or is, missed by most, and how many
    others there are."""
    gained = row in found.gained
    failing, other = (found.before, found.after) if gained else (found.after, found.before)
    short = np.flatnonzero(~failing.met[row])
    name = worst_missed(found, row)
    worst = failing.requirements.index(name)
    lack = f"{failing.units[worst].short(-float(failing.margin[row, worst]))} short"
    spare = _spare(other, row, name)
    words = f"was {lack}, {spare} now"
    if not gained:
        words = f"is {lack}, {spare.replace('is ', 'was ')} before"
    more = f"; {len(short) - 1} more as well" if len(short) > 1 else ""
    return f"{_who(found.before, row)}: “{plain(name)}” {words}{more}."


def worst_missed(found: Comparison, row: int) -> str:
    """The requirement that somebody who fits in one design only misses by most in the other."""
    failing = found.before if row in found.gained else found.after
    short = np.flatnonzero(~failing.met[row])
    return failing.requirements[int(short[np.argmin(failing.margin[row, short])])]


def _who(judged: Judged, row: int) -> str:
    """ "female 31, a woman of 1,512 mm"."""
    tall = judged.stature[row]
    words = f"{person_name(judged.labels[row])}, a {_NOUNS[int(judged.sex[row])]}"
    return f"{words} of {1000 * tall:,.0f} mm" if np.isfinite(tall) else words


def _spare(judged: Judged, row: int, name: str) -> str:
    """ "12 mm to spare" of a requirement in the other design."""
    if name not in judged.requirements:
        return "is not asked for"
    margin = float(judged.margin[row, judged.requirements.index(name)])
    if np.isnan(margin):
        return "does not apply"
    unit = judged.unit(name)
    return spare_words(margin, unit) if margin >= -MET else f"{unit.short(-margin)} short"
