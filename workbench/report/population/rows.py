"""A population as the rows of result.json and of the CSV tables, rounded for reading."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from workbench.body.people.proportions import percent, percent_number
from workbench.files.results.population import (
    GainRow,
    GroupRow,
    HardRow,
    MapRow,
    OverlapRow,
    PeopleRow,
    PopulationRows,
    RequirementRow,
)
from workbench.model.accommodation import DesignChange, GroupShare, ReachMap
from workbench.model.arrays import Floats
from workbench.model.criterion import NO_REASON
from workbench.model.population import MASS, SEXES
from workbench.model.result import PeopleOverlap, PopulationFound
from workbench.model.study import PeopleDrawn, Study
from workbench.model.units import plain
from workbench.report.population.sentences import (
    certain_shares,
    dropping_words,
    gain_sentence,
    no_gain_words,
)
from workbench.report.postures.rows import Held, held_tables, posture_row
from workbench.report.tables import Table
from workbench.study.accommodation.design import design_of

__all__ = ["people_table", "population_lines", "population_rows", "population_tables"]


def population_lines(result: PopulationFound) -> list[str]:
    """What the command line says: requirements that leave anybody out, worst first, gains, then
    groups."""
    order = [r for r in np.argsort(result.single, kind="stable") if result.single[r] < 1.0]
    count = len(result.served)
    lines = [
        f"{percent(float(result.single[r]), count):>7}  meet “{plain(result.requirements[r].name)}”"
        f"{_alone(result, r)}"
        for r in order
    ]
    if order and not any(_alone(result, r) for r in order):
        lines.append(dropping_words(result))
    best_first = sorted(result.gains, key=lambda one: one.joint_before - one.joint_after)
    lines += [gain_sentence(gain, count) for gain in best_first] + no_gain_words(result)
    nobody = not result.served.any()
    interval = f"{100 * result.study.shares.confidence:g} % interval"
    for row in result.shares[:1] if nobody else result.shares:  # of nobody in any group
        low, high = (percent_number(value, row.count) for value in (row.low, row.high))
        lines.append(
            f"{percent(row.share, row.count):>7}  fit: {row.group} ({interval} {low} to {high} %)"
        )
    clear = percent(result.shares[0].clear, count)
    if not nobody:
        lines.append(f"{clear:>7}  fit and overlap nothing by more than is allowed: everybody")
    return lines


def _alone(result: PopulationFound, r: int) -> str:
    """Who misses one requirement alone and who would fit without it, "" where that lets nobody in."""
    count = len(result.served)
    if result.without[r] <= result.shares[0].share + 1e-12:
        return ""
    without = f"without it {percent(float(result.without[r]), count)} would fit"
    only = percent(float(result.only[r]), count)
    alone = f"{only} miss only this, {without}"
    return f" ({alone if result.only[r] > 0.0 else f'{without}, in another position'})"


def population_rows(result: PopulationFound, people_hash: str) -> PopulationRows:
    """Convert what was found of a population: lengths in mm, shares 0 to 1."""
    return PopulationRows(
        role=result.place.role,
        seat=result.place.seat,
        body=result.body.name,
        population=result.people.source,
        people_hash=people_hash,
        seed=_seed(result.study),
        confidence=result.study.shares.confidence,
        shares=[_group(group) for group in result.shares],
        requirements=[_requirement(result, r) for r in range(len(result.requirements))],
        hardest=[_hard(result, row) for row in result.hardest],
        gains=[_gain(gain) for gain in result.gains],
        maps=[_map(found) for found in result.maps],
        overlaps=[_overlap(found) for found in result.overlaps],
        design=design_of(result.study),
        reasons=[one.text for one in result.reasons],
        people=_people(result),
    )


def _group(group: GroupShare) -> GroupRow:
    return GroupRow(
        group=group.group,
        share=_share(group.share),
        low=_share(group.low),
        high=_share(group.high),
        count=group.count,
        certain=_share_or_none(group.certain),
        possible=_share_or_none(group.possible),
        clear=_share_or_none(group.clear),
    )


def _overlap(found: PeopleOverlap) -> OverlapRow:
    return OverlapRow(
        segment=found.segment,
        part=found.part,
        other_segment=found.other_segment,
        people=found.people,
        share=_share(found.share),
        deepest_mm=_mm(found.deepest),
        person=found.person,
    )


def _gain(gain: DesignChange) -> GainRow:
    rate = gain.margin_rate
    return GainRow(
        words=gain.words,
        requirement=gain.requirement,
        move_mm=_mm(gain.move),
        rate_per_mm=_share(gain.rate / 1000),
        margin_rate=None if math.isnan(rate) else round(rate, 4) + 0.0,
        before=_share(gain.before),
        after=_share(gain.after),
        joint_before=_share(gain.joint_before),
        joint_after=_share(gain.joint_after),
    )


def _map(found: ReachMap) -> MapRow:
    return MapRow(
        part=found.task.part,
        grip=found.task.grip,
        zone=found.task.zone,
        hand=found.task.hand,
        sees=found.task.sees,
        points_mm=_rows(found.points),
        flat_mm=_rows(found.flat),
        share=[_share(v) for v in found.share.tolist()],
    )


def _seed(study: Study) -> int | None:
    """The seed that the people are drawn with, None where they are given."""
    crowd = study.crowd
    drawn = crowd.population if crowd is not None else None
    return drawn.seed if isinstance(drawn, PeopleDrawn) else None


def _requirement(result: PopulationFound, r: int) -> RequirementRow:
    row = result.requirements[r]
    certain, possible = certain_shares(result, r)
    return RequirementRow(
        name=row.name,
        criterion=row.criterion,
        check=row.check,
        target=row.target,
        zone=row.zone,
        share=_share(float(result.single[r])),
        only=_share(float(result.only[r])),
        without=_share(float(result.without[r])),
        certain=_share_or_none(certain),
        possible=_share_or_none(possible),
        unit=row.unit.column,
        unit_mm=_mm(row.unit.counts / row.unit.scale),
        spread_mm=[_number(value) for value in result.spread[r].tolist()],
    )


def _people(result: PopulationFound) -> PeopleRow:
    people = result.people
    return PeopleRow(
        label=_labels(result),
        sex=[SEXES[int(code)] for code in people.sex],
        weight=people.weight.tolist(),
        stature_mm=[_mm(v) for v in people.column("stature").tolist()]
        if "stature" in people.names
        else None,
        served=result.served.tolist(),
        certain=_certain(result),
        clear=result.clear.tolist(),
        limiting=list(result.limiting),
        seat_mm=_rows(result.seat),
        comfortable_mm=_rows(result.comfortable),
        window_mm=[
            _row(window) if math.isfinite(window[0]) else None for window in result.window.tolist()
        ],
        settings={
            one.column: column
            for one, column in zip(result.adjustments, _settings(result).T.tolist(), strict=True)
        },
        margin_mm=_cells(result.margin),
        margin_from_mm=_cells(np.where(result.of_surface, result.low, np.nan)),
        margin_to_mm=_cells(np.where(result.of_surface, result.high, np.nan)),
        reason=result.reason.tolist(),
    )


def _settings(result: PopulationFound) -> Floats:
    """(P, A) where each adjustment is set, in the unit in which it is shown."""
    units = np.array([one.shown_unit for one in result.adjustments])
    return np.round(result.setting / units, 3) + 0.0


def _hard(result: PopulationFound, row: int) -> HardRow:
    r = result.looked_at(row)
    reason = int(result.reason[row, r])
    shown = next((one for one in result.shown if one.row == row), None)
    return HardRow(
        person=_labels(result)[row],
        sex=SEXES[int(result.people.sex[row])],
        requirement=result.requirements[r].name,
        margin_mm=_mm(float(result.margin[row, r])),
        reason=result.reasons[reason].text if reason >= 0 else "",
        limiting=result.limiting[row],
        row=row,
        posture=None
        if shown is None
        else posture_row(shown.placed.body, shown.poses, shown.case, "found"),
    )


_SHARES = {
    "group": "group",
    "share": "share",
    "low": "low",
    "high": "high",
    "people": "count",
    "certain": "certain",
    "possible": "possible",
    "clear": "clear",
}
_REQUIREMENTS = (
    "criterion",
    "check",
    "target",
    "zone",
    "share",
    "only",
    "without",
    "certain",
    "possible",
    "unit",
)
_LEVELS = tuple(f"margin_{level}_percent" for level in (1, 5, 50, 95, 99))
_GAINS = {
    "change": "words",
    "requirement": "requirement",
    "move_mm": "move_mm",
    "share_per_mm": "rate_per_mm",
    "margin_per_mm": "margin_rate",
    "before": "before",
    "after": "after",
    "joint_before": "joint_before",
    "joint_after": "joint_after",
}
"""The columns of the tables, with the fields of the rows that are in them."""


def population_tables(result: PopulationFound, rows: PopulationRows) -> dict[str, Table]:
    """By name: shares, requirements, gains, and everybody with measures, margins and
    what limits."""
    requirements = (
        [q.name, *(getattr(q, field) for field in _REQUIREMENTS), *_in_unit(q)]
        for q in rows.requirements
    )
    return {
        "shares": _fields_table(_SHARES, rows.shares),
        "requirements": Table(["requirement", *_REQUIREMENTS, *_LEVELS], requirements),
        "gains": _fields_table(_GAINS, rows.gains),
        "people": people_table(result),
        **_shown_tables(rows),
    }


def _in_unit(row: RequirementRow) -> list[float | None]:
    """The spread of the margins of a requirement in its unit."""
    return [v if v is None else round(v / row.unit_mm, 3) + 0.0 for v in row.spread_mm]


def _shown_tables(rows: PopulationRows) -> dict[str, Table]:
    """The postures of the people who are shown; no table where nobody is."""
    held = [
        Held(
            [hard.posture.case, hard.person],
            rows.people.seat_mm[hard.row] if rows.seat else None,
            hard.posture,
        )
        for hard in rows.hardest
        if hard.posture is not None
    ]
    return held_tables(["case", "person"], held) if held else {}


def _fields_table(columns: Mapping[str, str], rows: Iterable[object]) -> Table:
    """A table of rows. columns: the field of each column."""
    lines = ([getattr(row, field) for field in columns.values()] for row in rows)
    return Table(list(columns), lines)


def people_table(result: PopulationFound) -> Table:
    """A row for everybody: who, seat, verdict and whether it is certain, a margin and what
    limits for each requirement, between what the margin truly lies where it is of the surface,
    measures."""
    surface = [row.name for row in result.requirements if row.of_surface]
    header = [
        "person",
        "sex",
        "weight",
        "served",
        "certain",
        "clear",
        "limiting",
        *_place_columns(sits=result.place.seat is not None),
        *(one.column for one in result.adjustments),
        *(f"{row.name} [{row.unit.column}]" for row in result.requirements),
        *(f"{row.name}: limited by" for row in result.requirements),
        *(f"{name}: {end} [mm]" for name in surface for end in ("from", "to")),
        *(f"{name}_{'kg' if name == MASS else 'mm'}" for name in result.people.names),
    ]
    return Table(header, _people_lines(result))


def _place_columns(*, sits: bool) -> Iterator[str]:
    """The names of the columns that say where people are: of who stands, steps ahead and to the
    left."""
    across = "up" if sits else "left"
    for what in ("seat", "comfortable") if sits else ("step", "stated"):
        yield from (f"{what}_{way}_mm" for way in ("forward", across))
    yield from (f"fits_{way}_{end}_mm" for way in ("forward", across) for end in ("from", "to"))


def _people_lines(result: PopulationFound) -> Iterator[list[object]]:
    """The row of each person under that header."""
    people = result.people
    factor = np.array([1.0 if name == MASS else 1000.0 for name in people.names])
    sizes = np.round(people.measures * factor, 1).tolist()
    # a reason of -1 is the last of these words: none
    every = [one.text for one in (*result.reasons, NO_REASON)]
    words = np.array(every, dtype=object)[result.reason].tolist()
    seat = _cells(np.hstack([result.seat, result.comfortable, result.window]))
    settings = _settings(result).tolist()
    # as they are read; `_cells` makes millimetres of metres
    units = np.array([1e-3 * row.unit.scale / row.unit.counts for row in result.requirements])
    margins = _cells(units * result.margin)
    surface = result.of_surface
    ends = np.stack([result.low[:, surface], result.high[:, surface]], axis=2)
    bounds = _cells(ends.reshape(len(ends), -1))
    certain = _certain(result)
    for p, label in enumerate(_labels(result)):
        yield [
            label,
            SEXES[int(people.sex[p])],
            float(people.weight[p]),
            bool(result.served[p]),
            certain[p],
            bool(result.clear[p]),
            result.limiting[p],
            *seat[p],
            *settings[p],
            *margins[p],
            *words[p],
            *bounds[p],
            *sizes[p],
        ]


def _certain(result: PopulationFound) -> list[bool | None]:
    """Whether it is certain of each person that he fits or does not, None where not known."""
    unknown = result.undecided & ~result.known.all(axis=1)
    found = (~result.undecided).astype(object)
    found[unknown] = None
    return found.tolist()


def _labels(result: PopulationFound) -> list[str]:
    people = result.people
    return list(people.labels) or [str(row + 1) for row in range(len(people))]


def _rows(values: Floats) -> list[Any]:
    """Lengths [m] as rows of millimetres."""
    return [_row(row) for row in values.tolist()]


def _row(metres: Iterable[float]) -> Any:
    return tuple(_mm(value) for value in metres)


def _cells(metres: Floats) -> list[list[float | None]]:
    """A table of lengths [m] in millimetres, None for NaN: many at once."""
    cells = (np.round(1000 * metres, 3) + 0.0).astype(object)
    cells[np.isnan(metres)] = None
    return cells.tolist()


def _number(metres: float) -> float | None:
    return None if math.isnan(metres) else _mm(metres)


def _mm(metres: float) -> float:
    return round(1000 * metres, 3) + 0.0


def _share(share: float) -> float:
    return round(share, 6) + 0.0


def _share_or_none(share: float) -> float | None:
    return None if math.isnan(share) else _share(share)
