"""The part of the page about people in postures: pictures, reaches, clearances, joint stops."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.contact.collide import allowed_depth
from workbench.draw.envelopes import LEGEND
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.source import PEOPLE_COLOURS
from workbench.draw.views import four_views
from workbench.draw.web.case_view import case_view
from workbench.draw.web.views import WebView
from workbench.files.results.postures import PosturesRows, ReachRow
from workbench.files.results.result import FindingRow
from workbench.model.accommodation import OF_SIGHT
from workbench.model.result import Finding, PersonFound, PosturesFound
from workbench.model.units import plain, tenths
from workbench.report.circles import circle_figure
from workbench.report.postures.drawing import clearance_drawing
from workbench.report.postures.envelopes import envelope_pictures
from workbench.report.postures.held import posture_words
from workbench.report.postures.people import people_sections
from workbench.report.postures.rows import doubt_sentence
from workbench.report.section import Making, Section, SectionWriter
from workbench.report.sentences import (
    contact_sentence,
    finding_sentence,
    millimetres,
    reach_spare,
    without_polygons,
)
from workbench.report.sight import Beheld, Glimpse, sight_sections
from workbench.report.states import TwoStates, two_states
from workbench.report.turnable import Look, PageViews, close_up, look, still_picture
from workbench.study.unasked import unasked_overlaps

__all__ = ["case_states", "overlap_lines", "postures_sections"]

NEAR = 0.12
PICTURE = 520
DRAWING = 720
MOST_MARKS = 12
BOTH = "marks are those of their own case"
_COLOUR_WORDS = {"warm": "tan", "blue": "blue", "green": "green", "rose": "pink", "grey": "grey"}
"""Families of colours as they are called."""
_Breach = tuple[str, Finding]
"""A finding that does not meet its criterion, and the check of the criterion."""


def postures_sections(
    result: PosturesFound, rows: PosturesRows, making: Making, *, number: int = 0
) -> list[Section]:
    """The sections of a page about people in postures.

    Parameters
    ----------
    making
        What the sections of the page share; a turnable picture is added for each case.
    number
        Of these people among the sizes that take a role one at a time, from 0.
    """
    cases = []
    for index, name in enumerate(result.cases):
        making.progress(f"pictures of {name}")
        cases.append(_case(result, index, making.views))
    both = _both(result, making.views)
    view = cases[0]["view"] if cases else -1
    size = f": {rows.row}" if rows.row else ""
    end = f"-{number + 1}" if number else ""

    writer = SectionWriter("postures", {"rows": rows, "making": making}, end, size)
    found = [writer.section("questions", "cases", "Cases", {"cases": cases, "both": both})]
    if rows.reaches:
        doubts = doubt_sentence([row.doubt for row in rows.reaches])
        reached = {"reaches": _reaches(result, rows, view), "doubts": doubts}
        found.append(writer.section("questions", "reach", "Reach", reached))
    for k, envelope in enumerate(result.envelopes):
        title = f"Reach envelope: {envelope.person}, {envelope.limb}, zone {envelope.zone}"
        values = {
            "envelope": rows.envelopes[k],
            "origin": envelope.origin_name,
            "pictures": envelope_pictures(result, envelope, making.views),
            "legend": LEGEND,
        }
        found.append(writer.section("questions", f"envelope-{k + 1}", title, values))
    people = tuple(person.name for person in result.people)
    beheld = {
        (in_case, one.name): Beheld(
            _scene(result, case, []),
            people,
            one.name,
            f"{plain(one.name)}, {in_case}",
            one.role.seat or "",
        )
        for case, in_case in enumerate(result.cases)
        for one in result.people
    }
    glimpses = [
        Glimpse(
            verdict.criterion,
            verdict.worst,
            beheld[verdict.worst.case, verdict.worst.person],
            result.environment,
        )
        for verdict in result.verdicts
        if verdict.criterion.check in OF_SIGHT and verdict.worst is not None
    ]
    return [
        *found,
        *sight_sections(glimpses, list(beheld.values()), end=end),
        *people_sections(result, rows, making, end=end),
        *_tables(result, rows, cases, writer),
    ]


def _tables(
    result: PosturesFound,
    rows: PosturesRows,
    cases: Sequence[Mapping[str, Any]],
    writer: SectionWriter,
) -> Iterator[Section]:
    """The sections of clearances, joint stops and contacts."""
    matrices = [
        _matrix(result, person, case, cases[case]["view"])
        for person in result.people
        for case in range(len(result.cases))
    ]
    yield writer.section("tables", "clearance", "Clearance", {"matrices": matrices})
    stops = [_stops(result, index) for index in range(len(result.people))]
    values = {"names": result.cases, "stops": stops}
    yield writer.section("tables", "stops", "Joint stops", values)
    shown = {case["name"]: case["view"] for case in cases}
    contacts = [
        (row, look(shown[row.case], row.point_mm) if row.excess_mm > 0 else Look())
        for row in rows.contacts
    ]
    yield writer.section("tables", "contacts", "Contacts", {"contacts": contacts})


def overlap_lines(result: PosturesFound, views: PageViews) -> list[Markup]:
    """The overlaps that no criterion asks about as lines that make the picture of their case look
    there."""
    lines = []
    for overlap in unasked_overlaps(
        result.study.criteria, result.cases, result.people, result.between
    ):
        words = contact_sentence(overlap.contacts, overlap.row, whose=overlap.other)
        lead = f"{result.row}, " if result.row else ""
        text = without_polygons(f"{lead}{overlap.case}, {overlap.person}: {words}")
        point = [1000.0 * value for value in overlap.contacts.point[overlap.row].tolist()]
        place = look(views.of_case(overlap.case, result.row), point)
        lines.append(place.link(plain(text)))
    return lines


def _reaches(result: PosturesFound, rows: PosturesRows, view: int) -> list[dict[str, Any]]:
    """For each person a line for each control, with a cell for each zone; view: of the first case,
    whose posture they begin from."""
    at = {control.name: np.array(control.at) for control in result.environment.controls}
    found: dict[str, dict[str, list[ReachRow]]] = {}
    for row in rows.reaches:
        found.setdefault(row.person, {}).setdefault(row.control, []).append(row)
    return [
        {
            "person": name,
            "reached": sum(
                any(row.reached for row in zones if row.zone == row.own_zone)
                for zones in controls.values()
            ),
            "lines": [
                {
                    "control": control,
                    "zone": zones[0].own_zone,
                    "cells": [
                        _zone_cell(
                            row, look(view, (1000.0 * at[control]).tolist(), said=_short(row))
                        )
                        for row in zones
                    ],
                }
                for control, zones in controls.items()
            ],
        }
        for name, controls in found.items()
    ]


def _short(row: ReachRow) -> str:
    """ "small woman: flaps, zone 2: 41 mm short"."""
    control = plain(row.control)
    return f"{row.person}: {control}, zone {row.zone}: {row.miss_mm:.0f} mm short"


def _zone_cell(row: ReachRow, place: Look) -> dict[str, Any]:
    """Whether a control is reached in a zone, by which limb and how much farther this would get, or by
    how much not; then with a link to where the control is."""
    if row.reached:
        spare = "" if row.spare_mm is None else f", {reach_spare(row.spare_mm / 1000)} to spare"
        return {"text": f"{row.limb}{spare}", "kind": "far", "look": Look()}
    text = f"{row.miss_mm:.0f} mm short: {row.limit}"
    kind = "hit" if row.zone >= row.own_zone else "close"
    return {"text": text, "kind": kind, "look": place}


def _case(result: PosturesFound, case: int, views: PageViews) -> dict[str, Any]:
    """Pictures and numbered findings of one case."""
    shown, rest = _shown(result, case)
    findings = [finding for _, finding in shown]
    scene = _scene(result, case, findings)
    name = result.cases[case]
    view = case_view(result, case, findings, within=NEAR)
    index = views.add(view, case=name, row=result.row, near=partial(_near, scene))
    same = _same_case(result, case)
    stills = {
        name: still_picture(scene, camera)
        for name, camera in four_views(scene, width=PICTURE, height=PICTURE)
        if not same or name == "corner"
    }
    still = stills.pop("corner")
    drawing = None
    if not same:
        drawing = clearance_drawing(scene, result.people, case, within=NEAR, size=DRAWING)
    circles = Markup("") if same else circle_figure(scene, name)
    overlaps = unasked_overlaps(result.study.criteria, result.cases, result.people, result.between)
    return {
        "name": name,
        "view": index,
        "same": same,
        "turnable": views.place(
            index, still=still, alt=f"{name}, corner view", caption=_caption(result, view)
        ),
        "people": [f"{person.name}: {posture_words(person, case)}" for person in result.people],
        "stills": [(plain(name), png) for name, png in stills.items()],
        "drawing": drawing,
        "circles": circles,
        "marked": [
            (f"{finding_sentence(check, f)} {_place(f)}", _look(index, f)) for check, f in shown
        ],
        "unmarked": [finding_sentence(check, f) for check, f in rest],
        "overlaps": sum(overlap.case == name for overlap in overlaps),
    }


def _both(result: PosturesFound, views: PageViews) -> Markup:
    """The place of one picture of the only two cases, "" where there are more, or they are alike."""
    if len(result.cases) != 2 or _same_case(result, 1):
        return Markup("")
    names = (result.cases[0], result.cases[1])
    found = [[finding for _, finding in _shown(result, case)[0]] for case in (0, 1)]
    one, two = (case_view(result, case, found[case], within=NEAR) for case in (0, 1))
    return two_states(
        TwoStates(
            views=(one, two),
            scenes=(_scene(result, 0, found[0]), _scene(result, 1, found[1])),
            names=names,
            title=f"{result.who}: {names[0]} and {names[1]}",
            said=result.who,
            caption=BOTH,
            side="corner",
        ),
        views.packing,
    )


def case_states(
    found: tuple[PosturesFound, PosturesFound],
    case: int,
    *,
    names: tuple[str, str],
    caption: str,
    making: Making,
) -> Markup:
    """Return the place of a picture of one case in two states of the environment.

    Parameters
    ----------
    found
        The same people in either state.
    case
        Index of the case.
    names, caption
        What the states are called, and what stands below the picture.
    making
        What the sections of the page share; a turnable picture is added.
    """
    marked = [[finding for _, finding in _shown(one, case)[0]] for one in found]
    one, two = (case_view(each, case, marked[k], within=NEAR) for k, each in enumerate(found))
    title = f"{one.title}: {names[0]} and {names[1]}"
    return two_states(
        TwoStates(
            views=(one, two),
            scenes=(_scene(found[0], case, marked[0]), _scene(found[1], case, marked[1])),
            names=names,
            title=title,
            said=one.title,
            caption=f"{one.title}; {caption}",
            side="corner",
        ),
        making.views.packing,
    )


def _same_case(result: PosturesFound, case: int) -> str:
    """The first earlier case in which everybody is as in this one, "" where there is none."""
    for earlier in range(case):
        if all(
            np.array_equal(person.placed.centres[earlier], person.placed.centres[case])
            for person in result.people
        ):
            return result.cases[earlier]
    return ""


def _near(scene: Scene, finding: FindingRow) -> str:
    """A close-up of a finding."""
    label = f"{tenths(abs(finding.value), abs(finding.limit))} {finding.unit}"
    struck = finding.target if finding.value < 0 and not finding.other_person else ""
    return close_up(scene, finding.point_mm or (), label, struck=struck)


def _caption(result: PosturesFound, view: WebView) -> str:
    """Who is seen, in which colour, and what the marks are that there are."""
    colours = [
        f"{person.name} {_COLOUR_WORDS[PEOPLE_COLOURS[k % len(PEOPLE_COLOURS)]]}"
        for k, person in enumerate(result.people)
    ]
    words = f"{view.title} ({', '.join(colours)})"
    if any(body.failing for body in view.bodies):
        words += "; red spheres are deeper in something than is allowed"
    if any(mark.failing for mark in view.marks):
        words += "; red marks are findings that break a criterion"
    if any(mark.to is not None and not mark.failing for mark in view.marks):
        words += "; blue lines are clearances, to scale"
    return words


def _shown(result: PosturesFound, case: int) -> tuple[list[_Breach], list[_Breach]]:
    """The breaches of a case with their checks: those that the pictures number, and the others.

    Numbered are those at a place, the first of each pair of a subject and a target.
    """
    breaches = [
        (verdict.criterion.check, finding)
        for verdict in result.verdicts
        for finding in verdict.breaches
        if finding.case == result.cases[case]
    ]
    first: dict[tuple[str, str, str, str], _Breach] = {}
    for check, finding in breaches:
        if finding.point is not None and np.all(np.isfinite(finding.point)):
            pair = (finding.person, finding.other_person, finding.subject, finding.target)
            first.setdefault(pair, (check, finding))
    shown = list(first.values())[:MOST_MARKS]
    return shown, [breach for breach in breaches if breach not in shown]


def _look(view: int, finding: Finding) -> Look:
    return look(view, [1000.0 * value for value in finding.point or ()])


def _place(finding: Finding) -> str:
    """ "(x 520, y -12, z 640 mm)" of a finding with a point."""
    x, y, z = (round(1000 * c) + 0 for c in finding.point or (0.0, 0.0, 0.0))
    return f"(x {x}, y {y}, z {z} mm)"


def _scene(result: PosturesFound, case: int, findings: list[Finding]) -> Scene:
    bodies = tuple(
        SceneBody(person.placed, case, PEOPLE_COLOURS[i % len(PEOPLE_COLOURS)], result.environment)
        for i, person in enumerate(result.people)
    )
    marks = _resting(result, case)
    marks += tuple(Mark(f.point, str(n)) for n, f in enumerate(findings, start=1) if f.point)
    name = result.cases[case]
    return Scene(
        bodies,
        result.environment,
        marks,
        f"{result.who} in {result.environment.name}, {name}",
        f"{len(findings)} numbered findings, {len(marks) - len(findings)} allowed contacts",
    )


def _resting(result: PosturesFound, case: int) -> tuple[Mark, ...]:
    """A mark without a number for each contact that is allowed: the deepest of each segment and
    part."""
    marks = []
    for person in result.people:
        deepest = person.contacts.deepest()
        for row in np.flatnonzero((deepest.pose == case) & (deepest.excess <= 0)):
            x, y, z = deepest.point[row].tolist()
            marks.append(Mark((x, y, z), "", "allowed"))
    return tuple(marks)


def _matrix(result: PosturesFound, person: PersonFound, case: int, view: int) -> dict[str, Any]:
    """Clearance of one person in one case: the parts that are near, nearest first; segments that
    have spheres."""
    body = person.placed.body
    environment = result.environment
    distance = person.clearance.distance[case]
    allowed = allowed_depth(body, environment)
    columns = np.flatnonzero(np.diff(body.start) > 0).tolist()
    least = np.where(np.isfinite(distance), distance, np.inf).min(axis=0)
    parts = [k for k in np.argsort(least, kind="stable").tolist() if least[k] < NEAR]
    points = 1000.0 * person.clearance.point[case]

    def said(n: int, k: int) -> str:
        part = plain(environment.parts[k])
        return (
            f"{person.name}: {body.segment_names[n]} to {part}, {_distance(float(distance[n, k]))}"
        )

    cells = {
        k: [
            _cell(distance[n, k], allowed[n, k], look(view, points[n, k], said=said(n, k)))
            for n in columns
        ]
        for k in parts
    }
    return {
        "person": person.name,
        "case": result.cases[case],
        "columns": [(body.segments[n], body.segment_names[n]) for n in columns],
        "lines": [{"part": environment.parts[k], "cells": cells[k]} for k in parts],
        "left_out": int(np.sum(~environment.hidden)) - len(parts),
    }


def _distance(metres: float) -> str:
    """ "3.6 mm deep", "12.0 mm apart"."""
    return f"{millimetres(abs(metres))} {'deep' if metres < 0 else 'apart'}"


def _cell(distance: float, allowed: float, place: Look) -> dict[str, Any]:
    """The distance of a segment to a part; a link to the place where it is beyond what is
    allowed."""
    if not math.isfinite(distance):
        return {"text": "", "kind": "none", "look": Look()}
    kind = "far"
    if distance < -allowed - 1e-9:
        kind = "hit"
    elif distance < 0:
        kind = "rest"
    elif distance < 0.025:
        kind = "close"
    elif distance < 0.1:
        kind = "near"
    return {
        "text": f"{round(distance * 1000) + 0}".replace("-", "−"),
        "kind": kind,
        "look": place if kind == "hit" else Look(),
    }


def _stops(result: PosturesFound, index: int) -> dict[str, Any]:
    """Joint-stop margins of one person: joints down, cases across."""
    person = result.people[index]
    lines = [
        {
            "joint": name,
            "cells": [_stop_cell(person, p, j) for p in range(len(person.placed))],
        }
        for j, name in enumerate(person.placed.body.joint_names)
        if np.isfinite(person.margin[:, j]).any()
    ]
    return {"person": person.name, "lines": lines}


def _stop_cell(person: PersonFound, p: int, j: int) -> dict[str, str]:
    """The margin of joint j to its stop in case p; near is under 5 degrees."""
    margin = person.margin[p, j]
    return {
        "text": f"{math.degrees(margin) + 0.0:.1f}".replace("-", "−"),
        "motion": plain(person.margin_motion[p][j]),
        "kind": "hit" if margin < -1e-9 else "close" if margin < 0.0873 else "far",
    }
