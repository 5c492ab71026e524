"""Deterministic English from data: what passed, what touches what, by how many millimetres."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence

import numpy as np

from workbench.body.people.proportions import percent, percent_number
from workbench.model.accommodation import GroupShare
from workbench.model.body import Body
from workbench.model.contacts import Contacts
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.person import Size
from workbench.model.reach import MOST_SPARE
from workbench.model.result import Finding, PersonFound, Verdict
from workbench.model.stops import motion_words
from workbench.model.surroundings import Move
from workbench.model.units import UNITS, plain, tenths
from workbench.study.checks.sight import BEYOND, FACE
from workbench.study.settings import setting_text

__all__ = [
    "HALF_MILLIMETRE",
    "adjusted_line",
    "contact_sentence",
    "finding_sentence",
    "finding_words",
    "for_reading",
    "in_words",
    "millimetres",
    "milliseconds",
    "moved_line",
    "part_count",
    "person_words",
    "proper_minus",
    "reach_spare",
    "share_sentence",
    "share_words",
    "surface_words",
    "verdict_sentence",
    "without_polygons",
]


_WAYS = (("forward", "back"), ("left", "right"), ("up", "down"))
"""The senses of x, y and z."""
_QUOTED = re.compile(r"((?<!\w)'[^']*'(?!\w)|“[^”]*”)")

HALF_MILLIMETRE = 5e-4
"""[m] What is nearer to another length reads like it in whole millimetres."""


def millimetres(metres: float, limit: float = 0.0) -> str:
    """ "12.4 mm" of a length in metres, finer where that would read like its limit [m]."""
    return f"{tenths(metres * 1000, limit * 1000)} mm"


def degrees(radians: float, limit: float = 0.0) -> str:
    """ "12.4 degrees" of an angle in radians, finer where that would read like its limit [rad]."""
    return f"{tenths(math.degrees(radians), math.degrees(limit))} degrees"


def minutes(radians: float, limit: float = 0.0) -> str:
    """ "12.4 arc minutes" of an angle in radians, finer where that would read like its limit [rad]."""
    unit = UNITS["arcmin"]
    return f"{tenths(unit.scale * radians, unit.scale * limit)}{unit.words}"


def finding_sentence(check: str, finding: Finding) -> str:
    """One finding in words.

    Of a posture its case and person come first: "cruise, pilot: right lower leg, knee cap (front)
    is ...". Of a motion the time comes last: "..., at 83.4 ms.".
    """
    words = finding_words(check, finding)
    if math.isfinite(finding.time):
        words = f"{words[:1].upper()}{words[1:]}"
        figure = check == "injury" and not finding.unit  # its window says when
        return f"{words}." if figure else f"{words}, at {milliseconds(finding.time)}."
    return f"{finding.case}, {finding.person}: {words}."


def finding_words(check: str, finding: Finding) -> str:
    """What was found, without case, person and time: "head (top) is 12.0 mm from canopy, 38.0 mm less
    than the 50.0 mm asked for"."""
    source = f" (by {finding.source})" if finding.source else ""
    return plain(without_polygons(_FINDING_WORDS[check](finding) + source))


def milliseconds(seconds: float) -> str:
    """ "83.4 ms" of a time in seconds."""
    text = f"{1000 * seconds:.1f}"
    return f"{text.removeprefix('-') if text == '-0.0' else text} ms"


def _stop_words(finding: Finding) -> str:
    motion = motion_words(finding.target)
    if finding.value < 0:
        past = degrees(-finding.value, -finding.limit)
        where = f"{past} past its stop in {motion}"
    else:
        where = f"{degrees(finding.value, finding.limit)} from its stop in {motion}"
    return f"{finding.subject} is {where}{_against(finding, degrees)}"


def _against(finding: Finding, figure: Callable[[float, float], str]) -> str:
    """What is asked for or allowed: ", 6.1 mm more than the 50.0 mm asked for", " (30.0 mm allowed)"; ""
    of a limit of 0."""
    if finding.limit <= 0:
        allowed = figure(-finding.limit, -finding.value)
        return f" ({allowed} allowed)" if finding.limit else ""
    way = "more" if finding.margin >= 0 else "less"
    asked = figure(finding.limit, finding.value)
    return f", {figure(abs(finding.margin), 0.0)} {way} than the {asked} asked for"


def _seated_words(finding: Finding) -> str:
    where = _apart(finding.value, finding.limit)
    return (
        f"{finding.subject} is {where} {finding.target}, where the seat states "
        f"{millimetres(-finding.limit)} into it"
    )


def _reach_words(finding: Finding) -> str:
    return (
        f"{finding.subject} reaches {finding.target}, {reach_spare(finding.value)} to spare"
        if finding.value >= 0
        else f"{finding.subject} stays {millimetres(-finding.value)} short of {finding.target}"
    )


def reach_spare(spare: float) -> str:
    """How much farther a limb would get, of [m]: "37.2 mm", "at least 200.0 mm"."""
    return f"{'at least ' if spare >= MOST_SPARE else ''}{millimetres(spare)}"


def _contact_words(finding: Finding) -> str:
    return f"{_distance_words(finding)}{_against(finding, millimetres)}"


def _distance_words(finding: Finding) -> str:
    other = finding.other_person
    target = f"{other}'s {finding.target}" if other else finding.target
    known = surface_words(finding.surface_known_to)
    return f"{finding.subject} is {_apart(finding.value, finding.limit, known)} {target}"


def _injury_words(finding: Finding) -> str:
    """Of a figure against the limit of a rule; the target is its source."""
    unit = f" {finding.unit}" if finding.unit else ""
    value = f"{-finding.value:.0f}"
    if value == f"{-finding.limit:.0f}":
        value = tenths(-finding.value, -finding.limit)
    return f"{finding.subject}: {value}{unit} ({finding.target} allows {-finding.limit:g}{unit})"


def _pedal_words(finding: Finding) -> str:
    return (
        f"{finding.subject} is on {finding.target}"
        if finding.value >= finding.limit
        else f"{finding.subject} stays {millimetres(-finding.value)} short of {finding.target}"
    )


def _seat_words(finding: Finding) -> str:
    if finding.value < 0:
        return f"{finding.subject} should be {millimetres(-finding.value)} beyond its travel"
    where = f"{millimetres(finding.value)} from the nearer end of its travel"
    return f"{finding.subject} is {where}{_against(finding, millimetres)}"


def _view_words(finding: Finding) -> str:
    """Of the height of the eyes, against what is asked for."""
    if finding.value < 0:
        return f"{finding.subject} miss the height for {finding.target} by {millimetres(-finding.value)}"
    return f"{finding.subject} meet the height for {finding.target}, {millimetres(finding.value)} to spare"


def _nose_words(finding: Finding) -> str:
    """Of the angle down to which eyes see straight ahead, and the part that stands there."""
    part = finding.target
    if not part:
        return f"nothing stands before {finding.subject}, straight ahead and down"
    if finding.value < 0:
        up = degrees(-finding.value)
        return f"{part} stands before {finding.subject} up to {up} above level{_against(finding, degrees)}"
    down = degrees(finding.value, finding.limit)
    return f"{finding.subject} look down to {down} below level, over {part}{_against(finding, degrees)}"


def _pillar_words(finding: Finding) -> str:
    """Of the angle that a pillar hides from both eyes."""
    hides = degrees(-finding.value, -finding.limit)
    against = _against(finding, degrees)
    return f"{finding.subject} hides {hides} from both eyes{against}; {finding.target}"


def _field_words(finding: Finding) -> str:
    """Of how wide something stands in the forward field."""
    if not finding.target:
        return "nothing stands in the forward field that may not"
    width = degrees(-finding.value, -finding.limit)
    against = _against(finding, degrees)
    return f"something stands in {width} of the forward field, most of it {finding.target}{against}"


def _reflection_words(finding: Finding) -> str:
    """Of the share of an instrument that is mirrored where the view must be clear."""
    share = f"{-100 * finding.value + 0.0:.0f} % of {finding.subject}"
    allowed = f" ({-100 * finding.limit:g} % allowed)" if finding.limit else ""
    return f"{share} is {finding.target or 'mirrored'} inside the outline{allowed}"


def _share_words(finding: Finding, what: str) -> str:
    """ "95.3 % of the outline is clear, 5.3 points more than the 90 % asked for; canopy hides 3.1 %"."""
    share = f"{tenths(100 * finding.value, 100 * finding.limit)} % {what}"
    return f"{share}{_share_against(finding)}{_kept_words(finding.target)}"


def _sees_words(finding: Finding) -> str:
    """Of the share of a thing that is seen, and what hides most of the rest."""
    share = f"{tenths(100 * finding.value, 100 * finding.limit)} %"
    against = _share_against(finding)
    return f"{finding.subject} is {share} visible{against}{_kept_words(finding.target)}"


def _share_against(finding: Finding) -> str:
    """ ", 5.3 points more than the 90 % asked for"."""
    way = "more" if finding.margin >= 0 else "less"
    asked = f"{100 * finding.limit:g} % asked for"
    return (
        f", the {asked}"
        if abs(finding.margin) < 5e-4
        else f", {100 * abs(finding.margin):.1f} points {way} than the {asked}"
    )


def _kept_words(why: str) -> str:
    """ "; left_stick hides 30 %", "" where nothing hides anything."""
    beyond = why in [one.text for one in BEYOND]
    return f"; it is {why}" if beyond else f"; {why}" if why else ""


def _reads_words(finding: Finding) -> str:
    """Of one of the limits of reading an instrument."""
    if finding.unit == "share":
        return _sees_words(finding)
    if finding.unit == "arcmin":
        lead = f"the characters of {finding.subject} are seen at"
        size = minutes(abs(finding.value), abs(finding.limit))
        return f"{lead} {size}{_against(finding, minutes)}"
    if finding.target == FACE:
        lead = f"{finding.subject} is looked at, from its face, at"
        return f"{lead} {degrees(finding.value, finding.limit)}{_against(finding, degrees)}"
    way = finding.target.removeprefix("angle ").removeprefix("above or ")
    off = degrees(-finding.value, -finding.limit)
    return f"{finding.subject} is {off} {way}{_against(finding, degrees)}"


def _excursion_words(finding: Finding) -> str:
    allowed = millimetres(-finding.limit)
    far = millimetres(-finding.value, -finding.limit)
    return f"{finding.subject} is {far} {finding.target} ({allowed} allowed)"


def _score_words(finding: Finding) -> str:
    """ "RULA of the right side is 5 points (4 allowed), 2.0 degrees from another band (upper arm)"."""
    points = "1 point" if finding.value == -1.0 else f"{-finding.value:.0f} points"
    return f"{finding.subject} is {points} ({-finding.limit:g} allowed), {finding.target}"


def _force_words(finding: Finding) -> str:
    """ "right hand on canopy handle: 143 N (150 needed) by 75 % of such women, the arm gives way first"."""
    return f"{finding.subject}: {finding.value:.0f} N ({finding.limit:g} needed) {finding.target}"


_FINDING_WORDS: dict[str, Callable[[Finding], str]] = {
    "contact": _contact_words,
    "clearance": _contact_words,
    "self_contact": _contact_words,
    "between_people": _contact_words,
    "stops": _stop_words,
    "seated": _seated_words,
    "reach": _reach_words,
    "injury": _injury_words,
    "pedals": _pedal_words,
    "preferred_seat": _seat_words,
    "eye_height": _view_words,
    "view_over": _view_words,
    "over_nose": _nose_words,
    "sees": _sees_words,
    "reads": _reads_words,
    "excursion": _excursion_words,
    "score": _score_words,
    "force": _force_words,
    "outline": lambda finding: _share_words(finding, "of the outline is clear"),
    "pillar": _pillar_words,
    "forward_field": _field_words,
    "mirror": lambda finding: _share_words(finding, f"of its ground is seen in {finding.subject}"),
    "reflection": _reflection_words,
}


def _apart(distance: float, limit: float = 0.0, known: str = "") -> str:
    """ "12.4 ± 3 mm into" or "12.4 mm from" of a distance [m], told from its limit [m]."""
    size, limit = (-distance, -limit) if distance < 0 else (distance, limit)
    figure = f"{tenths(1000 * size, 1000 * limit)}{known} mm"
    return f"{figure} {'into' if distance < 0 else 'from'}"


def surface_words(error: float) -> str:
    """ " ± 3": how well a distance is known [m], in millimetres; "" where it is not known."""
    return f" ± {max(1000 * error, 1.0):.0f}" if math.isfinite(error) else ""


def proper_minus(text: str) -> str:
    """A text for reading: the hyphens before numbers are minus signs. Files keep hyphens."""
    return re.sub(r"(?<![\w-])-(?=\.?\d)", "\u2212", text)


def without_polygons(sentence: str) -> str:
    """A sentence that names parts only: the numbers of polygons are for the tables."""
    return re.sub(r", polygon \d+\b", "", sentence)


def in_words(text: str) -> str:
    """A sentence with the names of parts as words and without the numbers of polygons; what is
    quoted stands as it does in a file."""
    pieces = _QUOTED.split(without_polygons(text))
    pieces[::2] = [plain(piece) for piece in pieces[::2]]
    return "".join(pieces)


def for_reading(text: str) -> str:
    """A sentence of a result as it stands on a page."""
    return proper_minus(in_words(text))


def contact_sentence(contacts: Contacts, row: int, *, whose: str = "") -> str:
    """A contact in words: "right hand, thumb tip (front): 12.4 mm into instrument_panel, polygon
    117". whose: who else the other segment belongs to, "" for the same body."""
    distance = float(contacts.distance[row])
    allowed = float(contacts.allowed[row])
    text = f"{contacts.name(row)}: {_apart(distance, -allowed)} {contacts.other_name(row)}"
    if contacts.part[row] < 0:
        text += f" of {whose or 'the same body'}"
    return f"{text} ({millimetres(allowed)} allowed)" if allowed > 0 else text


def verdict_sentence(verdict: Verdict) -> str:
    """A criterion's outcome in one or two sentences."""
    if verdict.share is not None:
        return share_sentence(verdict.criterion, verdict.share)
    if verdict.worst is None and verdict.words:
        return f"{verdict.words[:1].upper()}{verdict.words[1:]}."
    if verdict.worst is None:
        return (
            "Nothing could be measured: the parts it names are hidden, allowed to touch, or not in "
            "this study."
        )
    words = finding_sentence(verdict.criterion.check, verdict.worst)
    doubt = _doubt(verdict)
    if verdict.passed:
        return f"Nearest to the limit: {words}{doubt}"
    more = len(verdict.breaches) - 1
    too = f" {more} more place{'s break' if more > 1 else ' breaks'} it too." if more else ""
    return f"{words}{too}{doubt}"


def share_sentence(criterion: Criterion, group: GroupShare) -> str:
    """A share that is asked for in words: "81 % of the people meet all criteria (75 to 86 %); 80 %
    must.", and whether the surface of the body is known well enough to say so."""
    said = f"{share_words(criterion, group)}."
    if not group.leaves_open(criterion.at_least):
        return said
    sure, most = (percent(value, group.count) for value in (group.certain, group.possible))
    return (
        f"{said} Within the error of the body model's surface the share is {sure} to {most}, so "
        f"the verdict is undecided."
    )


def share_words(criterion: Criterion, group: GroupShare) -> str:
    """ "81 % of the people meet all criteria (75 to 86 %); 80 % must"."""
    low, high = (percent_number(value, group.count) for value in (group.low, group.high))
    what = "these criteria" if criterion.of else "all criteria"
    share = percent(group.share, group.count)
    must = f"{100 * criterion.at_least:g} % must"
    return f"{share} of the people meet {what} ({low} to {high} %); {must}"


def _doubt(verdict: Verdict) -> str:
    """ " Not certain: 1.0 mm to spare, and the body's surface is known to ± 3 mm there." where the verdict
    could turn, with what was found where that is not the worst."""
    found = verdict.doubtful
    if found is None:
        return ""
    known = surface_words(found.surface_known_to)
    left = f"{millimetres(abs(found.margin))} {'to spare' if verdict.passed else 'short'}"
    if found != verdict.worst:
        left = f"{finding_words(verdict.criterion.check, found)}: {left}"
    return f" Not certain: {left}, and the body's surface is known to{known} mm there."


def person_words(person: PersonFound) -> str:
    """Who somebody is and where: "bubbleman as a woman of stature 1525 mm, 51.3 kg, surface known to
    ± 9 mm, in seat left, 20 mm in front of its reference position"."""
    role = person.role
    words = plain(person.body.name)
    if role.size is not None:
        words += f" as a {_sized(role.size)}"
    if role.clothes:
        words += f", with {', '.join(item.name for item in role.clothes)}"
    words += f", {float(person.body.mass[0].sum()):.1f} kg, {_surface_known(person.body)}"
    if role.seat is not None:
        where = seat_position_words(person.forward, person.up)
        return f"{words}, in seat {plain(role.seat)}, {where}"
    if role.stand is not None:
        words += ", standing"
        for value, ahead, behind in (
            (person.forward, "forward", "back"),
            (person.up, "to the left", "to the right"),
        ):
            if abs(value) >= HALF_MILLIMETRE:
                words += f", stepped {abs(1000 * value):.0f} mm {ahead if value > 0 else behind}"
    return words


def seat_position_words(forward: float, up: float) -> str:
    """Where a seat is in its travel [m]: "20 mm behind and 5 mm above its reference position"."""
    ways = [
        f"{abs(1000 * value):.0f} mm {more if value > 0 else less}"
        for value, more, less in ((forward, "in front of", "behind"), (up, "above", "below"))
        if abs(value) >= HALF_MILLIMETRE
    ]
    return f"{' and '.join(ways)} its reference position" if ways else "in its reference position"


def _surface_known(body: Body) -> str:
    """How well the surface of a body is known, by its worst segment: "surface known to ± 25 mm"."""
    known = surface_words(float(np.max(body.fit_error[0, np.diff(body.start) > 0])))
    return f"surface known to{known} mm" if known else "error of the surface not stated"


def adjusted_line(environment: Environment, size: str = "") -> list[str]:
    """What of an environment is set otherwise than drawn: "set: wheel telescope at −20 mm"; nothing
    where all is at its nominal setting.

    size: of the person who takes a role, "" where there is one only.
    """
    found = [setting_text(one, one.at) for one in environment.adjustments if one.at]
    lead = f"{size}, set" if size else "set"
    return [f"{lead}: {', '.join(found)}"] if found else []


def moved_line(moves: Sequence[Move]) -> list[str]:
    """What stands elsewhere than the environment's file has it: "moved: throttle_lever by 15 mm
    forward"; nothing where nothing does."""
    found = []
    for move in moves:
        controls = "control " + ", ".join(move.controls) if move.controls else ""
        names = " and ".join(filter(None, (", ".join(move.parts), controls)))
        found.append(f"{names} by {_way_words(move.by)}")
    return [f"moved: {'; '.join(found)}"] if found else []


def _way_words(by: Sequence[float]) -> str:
    """A displacement (3,) [m] in words: "15 mm forward and 3 mm down"."""
    ways = [
        f"{1000 * abs(value):.4g} mm {more if value > 0 else less}"
        for value, (more, less) in zip(by, _WAYS, strict=True)
        if value
    ]
    return " and ".join(ways) or "0 mm"


def _sized(size: Size) -> str:
    """ "woman of stature 1525 mm, sitting height 800 mm"."""
    given = [
        f"{plain(name)} {1000 * value:.0f} mm"
        for name, value in size.measures.items()
        if name != "mass"
    ]
    return _kind(size) + (f" of {', '.join(given)}" if given else "")


def _kind(size: Size) -> str:
    """ "woman", or "girl of 6 years" with an age below 18."""
    if size.age is None or size.age >= 18:
        return "woman" if size.sex == "female" else "man"
    return f"{'girl' if size.sex == 'female' else 'boy'} of {size.age:g} years"


def part_count(environment: Environment) -> str:
    """ "31 parts, 402 polygons"."""
    return f"{len(environment.parts):,} parts, {len(environment.normal):,} polygons"
