"""The part of the page about people in postures: pictures, reaches, clearances, joint stops."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.contact.collide import allowed_depth
from workbench.draw.envelopes.sections import LEGEND
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.source import PEOPLE_COLOURS
from workbench.draw.views import four_views
from workbench.draw.web.case_view import case_view
from workbench.files.results.postures import ContactRow, PosturesRows, ReachRow
from workbench.model.result import Finding, PersonFound, PosturesFound
from workbench.report.postures.drawing import clearance_drawing
from workbench.report.postures.envelopes.pictures import envelope_pictures
from workbench.report.postures.reach_rows import doubt_sentence
from workbench.report.templates import template
from workbench.report.turnable import Look, PageViews, look, still_picture
from workbench.report.words import finding_sentence, millimetres

__all__ = ["postures_section"]

NEAR = 0.12
PICTURE = 520
DRAWING = 720
MOST_MARKS = 12
_MOST_OVERLAPS = 8
_ASKED_BY = {"contact": "environment", "self_contact": "self", "between_people": "between_people"}
"""The kind of contacts that each check asks about."""
_Breach = tuple[str, Finding]
"""A finding that does not meet its criterion, and the check of the criterion."""


def postures_section(
    result: PosturesFound, rows: PosturesRows, say: Callable[[str], None], views: PageViews
) -> Markup:
    """The part of the page about people in postures.

    Parameters
    ----------
    say
        Called with words on how far it is.
    views
        The turnable pictures of the page; one is added for each case.
    """
    cases = []
    for index, name in enumerate(result.cases):
        say(f"pictures of {name}")
        cases.append(_case(result, index, views) | {"overlaps": _unasked(result, rows, name)})
    shown = {case["name"]: case["view"] for case in cases}
    html = template("postures/section.html.j2").render(
        rows=rows,
        cases=cases,
        names=result.cases,
        matrices=[
            _matrix(result, person, case, cases[case]["view"])
            for person in result.people
            for case in range(len(result.cases))
        ],
        stops=[_stops(result, index) for index in range(len(result.people))],
        reaches=_reaches(result, rows, cases[0]["view"] if cases else -1),
        doubts=doubt_sentence([row.doubt for row in rows.reaches]),
        envelopes=[envelope_pictures(result, e) for e in result.envelopes],
        legend=LEGEND,
        most_overlaps=_MOST_OVERLAPS,
        contact_look=lambda view, row: look(view, row.point_mm),
        contacts=[
            (row, look(shown[row.case], row.point_mm) if row.excess_mm > 0 else Look())
            for row in rows.contacts
        ],
    )
    return Markup(html)


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
    control = row.control.replace("_", " ")
    return f"{row.person}: {control}, zone {row.zone}: {row.miss_mm:.0f} mm short"


def _zone_cell(row: ReachRow, place: Look) -> dict[str, Any]:
    """Whether a control is reached in a zone, by which limb or by how much not; then with a link to
    where the control is."""
    if row.reached:
        return {"text": str(row.limb), "kind": "far", "look": Look()}
    text = f"{row.miss_mm:.0f} mm short: {row.limit}"
    kind = "hit" if row.zone >= row.own_zone else "close"
    return {"text": text, "kind": kind, "look": place}


def _unasked(result: PosturesFound, rows: PosturesRows, case: str) -> list[ContactRow]:
    """The overlaps of a case beyond what is allowed that no criterion asks about, deepest first."""
    checks = {verdict.criterion.check for verdict in result.verdicts}
    kinds = {kind for check, kind in _ASKED_BY.items() if check not in checks}
    found = [
        row
        for row in rows.contacts
        if row.case == case and row.kind in kinds and row.excess_mm > 0.05
    ]
    return sorted(found, key=lambda row: -row.excess_mm)


def _case(result: PosturesFound, case: int, views: PageViews) -> dict[str, Any]:
    """Pictures and numbered findings of one case."""
    shown, rest = _shown(result, case)
    findings = [finding for _, finding in shown]
    scene = _scene(result, case, findings)
    stills = {
        name: still_picture(scene, camera)
        for name, camera in four_views(scene, width=PICTURE, height=PICTURE)
    }
    view = case_view(result, case, findings, within=NEAR)
    name = result.cases[case]
    index = views.add(view, case=name, row=result.row)
    words = f"{view.title}; red spheres overlap what they may not, blue lines are clearances"
    still = stills.pop("three_quarter")
    return {
        "name": name,
        "view": index,
        "turnable": views.place(
            index, still=still, alt=f"{name}, three quarter view", caption=words
        ),
        "people": [f"{p.name}: {p.postures[case].replace('_', ' ')}" for p in result.people],
        "stills": [(name.replace("_", " "), png) for name, png in stills.items()],
        "drawing": clearance_drawing(scene, result.people, case, within=NEAR, size=DRAWING),
        "marked": [
            (f"{finding_sentence(check, f)} {_place(f)}", _look(index, f)) for check, f in shown
        ],
        "unmarked": [finding_sentence(check, f) for check, f in rest],
    }


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
        SceneBody(person.placed, case, PEOPLE_COLOURS[i % len(PEOPLE_COLOURS)])
        for i, person in enumerate(result.people)
    )
    marks = _resting(result, case)
    marks += tuple(Mark(f.point, str(n)) for n, f in enumerate(findings, start=1) if f.point)
    name = result.cases[case]
    people = " and ".join(person.name for person in result.people)
    return Scene(
        bodies,
        result.environment,
        marks,
        f"{people} in {result.environment.name}, {name}",
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
        part = environment.parts[k].replace("_", " ")
        return f"{person.name}: {body.segment_names[n]} to {part}, {millimetres(distance[n, k])}"

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
        "text": f"{distance * 1000:.0f}".replace("-0", "0")
        if abs(distance) < 5e-4
        else f"{distance * 1000:.0f}",
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
        "text": f"{math.degrees(margin) + 0.0:.1f}",
        "motion": person.margin_motion[p][j].replace("_", " "),
        "kind": "hit" if margin < -1e-9 else "close" if margin < 0.0873 else "far",
    }
