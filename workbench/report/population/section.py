"""The part of the page about a population: who fits, who does not, by what and by how much."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.body.people.proportions import TENTHS_FROM, percent, percent_number, percent_parts
from workbench.draw.camera import Camera, project
from workbench.draw.reach_map import BANDS, LEVELS, map_controls, reach_map_svg
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.views import four_views
from workbench.draw.web.views import WebMark, WebView, scene_view
from workbench.model.accommodation import DesignChange, GroupShare, ReachMap
from workbench.model.arrays import Bools, Floats, xyz
from workbench.model.body import Body
from workbench.model.person import Encumbrance
from workbench.model.population import MASS, SEXES, Population
from workbench.model.reach import MOST_SPARE
from workbench.model.result import Illustration, PopulationFound, TriedChange
from workbench.model.units import UNITS, plain
from workbench.posture.seating.seating import middle
from workbench.report.circles import circle_figure
from workbench.report.population.charts import (
    bar,
    margin_axis,
    margin_range,
    margin_strip,
    share_axis,
    whisker,
)
from workbench.report.population.sentences import (
    adjusted_words,
    certain_shares,
    certainty_percents,
    certainty_words,
    chief_reason,
    elsewhere_words,
    gain_sentence,
    lack_words,
    left_words,
    no_gain_words,
    person_sentence,
    requirement_sentence,
    settable_words,
    spare_words,
    who_words,
)
from workbench.report.section import Making, Section, SectionWriter
from workbench.report.sentences import HALF_MILLIMETRE, millimetres
from workbench.report.sight import Beheld, Glimpse, sight_sections
from workbench.report.states import TwoStates, two_states
from workbench.report.turnable import PageViews, still_picture
from workbench.study.checks.view import TOO_HIGH

__all__ = ["population_sections", "population_words"]

_PICTURE = 520
_MOST_MEASURES = 12
_MOST_PAIRS = 3
"""Changes that are shown before and after."""
_LOOKED_AT = ("sees", "reads")
_LINE = 0.8
"""[m] of a line of sight that is drawn: what is looked at may be far."""
_TO_SCALE = 0.002
"""[m] How far a line may be longer or shorter than what it says."""
_LEVELS = (1, 5, 50, 95, 99)
"""Percentiles of the measures of the people."""
_FROM = {
    "front": "from the front",
    "left": "from the left",
    "top": "from above",
    "corner": "from the front left",
}
_PLURALS = {"male": "men", "female": "women"}
_NUMBERS = ("no", "one", "two", "three", "four", "five")


def population_sections(result: PopulationFound, making: Making) -> list[Section]:
    """The sections of a page about a population: what to change, who fits, who does not, by what and
    by how much.

    Parameters
    ----------
    making
        What the sections of the page share; a turnable picture is added for each of the hardest
        people.
    """
    making.progress("drawing pictures")
    ends = margin_range(result.spread)
    bounded = bool(result.known.all() and result.of_surface.any())
    worst_first = np.lexsort((result.spread[:, 1], result.single)).tolist()
    requirements = [_figures(result, r) | _charts(result, r, ends) for r in worst_first]

    writer = SectionWriter("population", {"making": making, "bounded": bounded})
    margins = {"rows": requirements, "axis": Markup(margin_axis(ends))}
    women = len(set(result.people.sex.tolist())) == 2
    every = {"requirements": requirements, "women": women}
    return [
        *_changes(result, making, writer),
        *_who(result, requirements, making, writer),
        *sight_sections(_glimpses(result), [_beheld(result, one) for one in result.shown]),
        writer.section("questions", "margins", "Margins", margins),
        writer.section("people", "crowd", "The people of the population", _crowd(result)),
        writer.section("tables", "requirements", "All requirements", every),
        writer.section("method", "method", "Method and its limits", _method(result), folded=True),
    ]


def _beheld(result: PopulationFound, one: Illustration) -> Beheld:
    """Somebody as found."""
    role = result.place.role
    scene = Scene((SceneBody(one.placed, holds=one.environment),), one.environment)
    words = f"{who_words(result, one.row)}, {one.case}"
    return Beheld(scene, (role,), role, words, result.place.seat or "")


def _glimpses(result: PopulationFound) -> list[Glimpse]:
    """The criteria of sight as whoever comes nearest to missing them sees them."""
    criteria = {one.name: one for one in result.study.criteria}
    return [
        Glimpse(
            criteria[result.requirements[one.requirement].criterion],
            one.finding,
            _beheld(result, one),
            result.place.environment,
        )
        for one in result.beheld
        if one.finding is not None
    ]


def _changes(result: PopulationFound, making: Making, writer: SectionWriter) -> Iterator[Section]:
    """The section of changes that were tried, the greatest gain first."""
    tried = sorted(result.tried, key=lambda change: -_joint_gain(change.gain))
    gains = [
        _gain(change.gain, result)
        | {"picture": _tried_picture(result, change, making.views) if k < _MOST_PAIRS else ""}
        for k, change in enumerate(tried)
    ]
    no_gain = no_gain_words(result)
    if gains or no_gain:
        helpful = any(gain["helps"] for gain in gains)
        title = "Changes that would gain" if helpful else "Changes tried"
        yield writer.section("changes", "changes", title, {"gains": gains, "no_gain": no_gain})


def _who(
    result: PopulationFound,
    requirements: Sequence[Mapping[str, Any]],
    making: Making,
    writer: SectionWriter,
) -> Iterator[Section]:
    """The sections of who fits, what leaves people out, limiting measures, the hardest people and
    reach maps."""
    least = max(0.0, np.floor(20 * (min(g.low for g in result.shares) - 0.02)) / 20)
    fit = {
        "groups": [_group(group, least) for group in result.shares],
        "axis": Markup(share_axis(least)),
        "confidence": f"{100 * result.study.shares.confidence:g}",
        "notes": [elsewhere_words(result), certainty_words(result), adjusted_words(result)],
    }
    yield writer.section("questions", "fit", "Who fits", fit)
    left = {
        "worst": requirement_sentence(result),
        "criteria": _criteria(result),
        "requirements": requirements,
    }
    yield writer.section("questions", "left-out", "What leaves people out", left)
    if measures := _measures(result):
        values = {"measures": measures}
        yield writer.section("questions", "limiting", "Limiting dimensions", values)
    if result.hardest:
        count = len(result.hardest)
        words = _NUMBERS[count] if count < len(_NUMBERS) else str(count)
        title = f"The {words} hardest cases" if count > 1 else "The hardest case"
        title = "The tightest case" if result.served.all() else title
        people: list[dict[str, Any]] = []
        for row in result.hardest:
            making.progress(f"drawing pictures: {len(people)} of {count} of the hardest people")
            people.append(_person(result, row, making.views))
        yield writer.section("questions", "hardest", title, {"hardest": people})
    for k, found in enumerate(result.maps, start=1):
        map_ = _map(result, found)
        title = f"Who {'sees' if found.task.sees else 'reaches'} the {map_['part']}"
        yield writer.section("questions", f"map-{k}", title, {"m": map_, "key": _key()})


def _crowd(result: PopulationFound) -> dict[str, Any]:
    """Who the people are: their measures at five percentiles, and where they sit."""
    people = result.people
    women = int((people.sex == SEXES.index("female")).sum())
    measures: list[tuple[str, str, str, list[str]]] = []
    for name in people.names[:_MOST_MEASURES]:
        unit, factor = ("kg", 1.0) if name == MASS else ("mm", 1000.0)
        measures += _percentiles(people, plain(name), unit, people.column(name) * factor)
    for words, column in _position_names(result):
        measures += _percentiles(people, words, "mm", 1000.0 * result.seat[:, column])
    count = len(people)
    return {
        "count": f"{count:,}",
        "women": f"{women:,}",
        "men": f"{count - women:,}",
        "source": people.source,
        "measures": measures,
        "more": max(len(people.names) - _MOST_MEASURES, 0),
        "levels": _LEVELS,
        "seated": result.place.seat is not None,
    }


def _percentiles(
    people: Population, name: str, unit: str, values: Floats
) -> list[tuple[str, str, str, list[str]]]:
    """Values (P,) of people at five percentiles, of women and of men: pooled percentiles are those
    of nobody."""
    rows = []
    for code, whose in enumerate(SEXES):
        mine = values[people.sex == code]
        if len(mine):
            texts = [f"{value + 0.0:,.0f}" for value in np.percentile(mine, _LEVELS)]
            words = [text.replace("-", "−") for text in texts]
            rows.append((name, _PLURALS[whose], unit, words))
    return rows


def _position_names(result: PopulationFound) -> list[tuple[str, int]]:
    """What the position of people is called, and its column: none of those who cannot move."""
    if result.place.seat is not None:
        return [("seat position, forward", 0), ("seat position, up", 1)]
    stand = result.place.stand
    if stand is None or not stand.steps:
        return []
    return [("steps, forward", 0), ("steps, to the left", 1)]


def _method(result: PopulationFound) -> dict[str, Any]:
    """What the method and its limits depend on."""
    return {
        "body": _model_words(result.body),
        "clothes": [item.name for item in _clothes(result)],
        "seated": result.place.seat is not None,
        "steps": result.place.stand is not None and result.place.stand.steps,
        "bootstrap": result.study.shares.interval.method == "bootstrap",
        "sight": any(one.of_sight for one in result.requirements),
        "strength": any(one.check == "force" for one in result.requirements),
    }


def population_words(result: PopulationFound, role: str) -> str:
    """Who the people of a role are, where they sit, and what their bodies are made from."""
    body = result.body
    people = len(result.people)
    asked = len(result.requirements)
    detail = f" (level of detail {body.detail})" if body.detail else ""
    clothes = [item.name for item in _clothes(result)]
    worn = f", wearing {', '.join(clothes)}" if clothes else ""
    seat = result.place.seat
    where = f" in the seat “{plain(seat)}”" if seat is not None else ""
    settable = settable_words(result, "and")
    how = f" at once, in some setting of {settable}" if settable else ""
    return (
        f"{role}: {people:,} people ({result.people.source}){where}, "
        f"{asked} requirement{'s' if asked > 1 else ''} (one for each control, clearance and view that "
        f"the criteria ask for). A person fits who meets them all{how}. Each "
        f"person has a body of his or her own measures, {_model_words(body)}: "
        f"{len(body.sphere_names):,} spheres{detail}{worn}."
    )


def _model_words(body: Body) -> str:
    """Where the bodies of people come from: a family of shapes, or one body that is stretched."""
    return (
        f"stretched from {plain(body.name)}"
        if body.basis is None
        else f"from the family of bodies “{plain(body.basis.name.removesuffix('.npz'))}”"
    )


def _clothes(result: PopulationFound) -> tuple[Encumbrance, ...]:
    """What everybody wears."""
    crowd = result.study.crowd
    return crowd.clothes if crowd is not None else ()


def _group(group: GroupShare, least: float) -> dict[str, Any]:
    """A group of people: its share that fits, as a chart too that begins at `least`."""
    share = percent(group.share, group.count)
    low, high = (percent_number(value, group.count) for value in (group.low, group.high))
    interval = f"{low} to {high} %"
    said = f"{group.group}: {share} ({interval})"
    chart = whisker(group.low, group.share, group.high, least=least, said=said)
    return {
        "name": group.group,
        "share": share,
        "interval": interval,
        "without_overlap": percent(group.clear, group.count),
        "undecided": certainty_percents(group)[1],
        "count": f"{group.count:,}",
        "chart": Markup(chart),
    }


def _weights(result: PopulationFound) -> Floats:
    weight = result.people.weight
    return weight / weight.sum()


def _criteria(result: PopulationFound) -> list[dict[str, Any]]:
    """For each criterion the share that fails any of its requirements, and nothing of the others;
    worst first."""
    names = dict.fromkeys(requirement.criterion for requirement in result.requirements)
    rows = [_left_out(result, number, name) for number, name in enumerate(names)]
    rows.sort(key=lambda row: -row["out"])
    most = max([row["out"] for row in rows] + [0.05])
    for row in rows:
        said = f"{row['name']}: missed by {row['left']}, only this by {row['only']}"
        row["chart"] = Markup(bar(row["out"], row["alone"], most=most, said=said))
    return rows


def _left_out(result: PopulationFound, number: int, name: str) -> dict[str, Any]:
    """Who misses requirements of one criterion, who misses no others, and who would fit without
    it."""
    weight = _weights(result)
    mine = np.array([requirement.criterion == name for requirement in result.requirements])
    failed = ~result.met[:, mine].all(axis=1)
    out = float(weight @ failed)
    alone = float(weight @ (failed & result.met[:, ~mine].all(axis=1)))
    count = len(result.met)
    return {
        "name": plain(name),
        "count": int(mine.sum()),
        "people": int(failed.sum()),
        "out": out,
        "alone": alone,
        "met": percent(1 - out, count),
        "left": percent(out, count),
        "only": percent(alone, count),
        "without": percent(
            float(weight @ result.sets[:, len(result.requirements) + number]), count
        ),
        "all": not failed.any(),
    }


def _figures(result: PopulationFound, r: int) -> dict[str, Any]:
    """The shares of those who meet a requirement, and what limits the others."""
    requirement = result.requirements[r]
    met = result.met[:, r]
    count = len(met)
    out = float(1 - result.single[r])
    weight = _weights(result)
    sex = result.people.sex
    certain, possible = certain_shares(result, r)
    return {
        "name": plain(requirement.name),
        "criterion": plain(requirement.criterion),
        "zone": requirement.zone or "",
        "met": percent(1 - out, count),
        "undecided": _undecided(possible - certain, count) if requirement.of_surface else "–",
        "left": percent(out, count),
        "only": percent(float(result.only[r]), count),
        "without": percent(float(result.without[r]), count),
        "all": bool(met.all()),
        "people": int((~met).sum()),
        "by_sex": [_share_of_some(weight, sex == s, met) for s in (1, 0)],
        "applies": bool(np.isfinite(result.margin[:, r]).any()),
        "reason": chief_reason(result, r),
    }


def _undecided(share: float, count: int) -> str:
    """A share of people who are undecided by the body's own fit."""
    return "not known" if np.isnan(share) else percent(share, count)


def _charts(result: PopulationFound, r: int, ends: tuple[float, float]) -> dict[str, Any]:
    """Whom a requirement leaves out, and its margins [mm], as charts."""
    name = plain(result.requirements[r].name)
    out = float(1 - result.single[r])
    most = max(float(1 - result.single.min()), 0.05)
    left = f"{name}: missed by {percent(out, len(result.met))}"
    spread = result.spread[r]
    most_known = _most_known(result, r)
    unit = result.requirements[r].unit
    length = unit is UNITS["m"]
    figures = [
        # what reads like the most that is looked for is no measurement either
        ("≥" if v >= most_known - HALF_MILLIMETRE else "")
        + f"{round(unit.shown(v), unit.places or None) + 0}".replace("-", "−")
        + ("" if length else unit.sign)
        if np.isfinite(v)
        else "–"
        for v in spread
    ]
    lead = f"{name}: margins at 1, 5, 50, 95 and 99 %"
    margins = f"{lead}: {', '.join(figures)}{unit.words if length else ''}"
    return {
        "figures": figures,
        "bar": Markup(bar(out, float(result.only[r]), most=most, said=left)),
        "strip": Markup(margin_strip(spread, ends, said=margins)),
    }


def _most_known(result: PopulationFound, r: int) -> float:
    """[m] The margin from which on a requirement is not measured: of a reach what is looked for, of
    pedals what a foot on its pedal has."""
    requirement = result.requirements[r]
    if requirement.check == "reach":
        return MOST_SPARE
    if requirement.check != "pedals":
        return np.inf
    criteria = result.study.criteria
    return next(one.at_most for one in criteria if one.name == requirement.criterion)


def _share_of_some(weight: Floats, some: Bools, met: Bools) -> str:
    """The share of some people (P,) who meet a requirement, "–" where there are none."""
    if not some.any():
        return "–"
    return percent(float(weight[some] @ met[some]) / float(weight[some].sum()), int(some.sum()))


def _measures(result: PopulationFound) -> list[dict[str, Any]]:
    """For each limiting measure the people it limits, most first, and how they compare with all."""
    limiting = np.array(result.limiting)
    weight = result.people.weight
    count = int((limiting != "").sum())
    total = float(weight[limiting != ""].sum())
    rows: list[dict[str, Any]] = []
    for name in sorted(set(result.limiting) - {""}):
        mine = limiting == name
        row: dict[str, Any] = {
            "name": plain(name),
            "people": int(mine.sum()),
            "share": float(weight[mine].sum()) / total,
        }
        rows.append(row | _compared(result.people, name, mine))
    rows.sort(key=lambda row: (-row["share"], row["name"]))
    percents = percent_parts([row["share"] for row in rows], count)
    for row, words in zip(rows, percents, strict=True):
        share = row["share"]
        said = f"{row['name']}: {row['people']} people"
        row["chart"] = Markup(bar(share, share, most=rows[0]["share"], said=said))
        row["percent"] = words
    return rows[:_MOST_MEASURES]


def _compared(people: Population, name: str, mine: Bools) -> dict[str, str]:
    """How a measure of some people (P,) compares with that of all of their sex; nothing where it is
    not known."""
    if name not in people.names:
        return {}
    values = people.column(name)
    unit, factor = ("kg", 1.0) if name == MASS else ("mm", 1000.0)
    small = 0
    ranges = []
    for code, whose in enumerate(SEXES):
        alike: Bools = people.sex == code
        limited = values[mine & alike]
        if len(limited):
            small += int((limited < np.median(values[alike])).sum())
            low, high = np.percentile(values[alike], [5, 95]) * factor
            ranges.append(f"{_PLURALS[whose]} {_range(low, high)}")
    counts = (("small", small), ("large", int(mine.sum()) - small))
    ways = [(word, count) for word, count in counts if count]
    return {
        "way": ways[0][0] if len(ways) == 1 else ", ".join(f"{word} ({n})" for word, n in ways),
        "theirs": _range(values[mine].min() * factor, values[mine].max() * factor),
        "all": f"{', '.join(ranges)} {unit}",
    }


def _range(low: float, high: float) -> str:
    return f"{low:,.0f} to {high:,.0f}" if f"{low:.0f}" != f"{high:.0f}" else f"{low:,.0f}"


def _joint_gain(gain: DesignChange) -> float:
    """The share more that meets all requirements."""
    return gain.joint_after - gain.joint_before


def _gain(gain: DesignChange, result: PopulationFound) -> dict[str, Any]:
    """One change as a sentence, with what a millimetre of it gives at first where that says
    something: what is seen jumps."""
    count = len(result.met)
    one = next(one for one in result.requirements if one.name == gain.requirement)
    unit = one.unit
    jumps = one.of_sight and one.check != "over_nose"
    amount = 0.0 if jumps else unit.shown(1e-3 * gain.margin_rate)
    joint = _joint_gain(gain)
    helps = joint > 1e-9 or (gain.after > gain.before + 1e-9 and joint > -1e-9)
    rates = []
    if helps and amount >= 0.005:
        rates.append(f"gives those who miss it {amount:.2f}{unit.words} more margin on average")
    if helps and np.isfinite(gain.rate) and gain.rate >= 0.05 and count >= TENTHS_FROM:
        rates.append(f"lets {0.1 * gain.rate:.2f} % more of the people meet it")
    return {"sentence": gain_sentence(gain, count), "rate": " and ".join(rates), "helps": helps}


def _person(result: PopulationFound, row: int, views: PageViews) -> dict[str, Any]:
    """One of the hardest: a sentence and, where the body is at hand, its picture."""
    found = next((s for s in result.shown if s.row == row), None)
    picture = _picture(result, found, views) if found is not None else {}
    return {"sentence": person_sentence(result, row), **picture}


def _picture(
    result: PopulationFound, found: Illustration, views: PageViews
) -> dict[str, Markup | str]:
    """The body in the cockpit as found, from where the line of what is lacking shows longest."""
    lack = lack_words(result, found.row, found.requirement)
    name = plain(result.requirements[found.requirement].name)
    label = result.people.called(found.row)
    if result.met[found.row, found.requirement]:
        spare = left_words(result, found.row, found.requirement)
        mark = _tightest(result, found, spare)
        lack = f"is met with {spare}"
    else:
        mark = _lacking(result, found, lack)
        lack = f"is missed by {lack}"
    scene = _scene(found, mark, name, label)
    cameras = four_views(scene, width=_PICTURE, height=_PICTURE)
    view, camera = max(cameras, key=lambda pair: (_length(pair[1], mark), pair[0] == "left"))
    alt = f"“{name}” {lack}, seen {_FROM[view]}"
    index = views.add(replace(_view(scene, mark, alt), look_from=view))
    still = still_picture(scene, camera)
    sight = result.requirements[found.requirement].check in _LOOKED_AT
    scale = "; the line goes from the eyes toward it" if sight else "; the line is to scale"
    line = mark is not None and mark.to is not None
    caption = f"{label}: “{name}” {lack}{scale if line else ''}"
    drawn = "" if found is not result.shown[0] else circle_figure(scene, label)
    place = views.place(index, still=still, alt=alt, caption=caption)
    return {"turnable": place, "circles": drawn}


def _scene(found: Illustration, mark: WebMark | None, name: str, label: str) -> Scene:
    """The body in the cockpit as found, with a mark."""
    scene = Scene(
        (SceneBody(found.placed, 0, "warm", found.environment),), found.environment, (), name, label
    )
    if mark is None:
        return scene
    kind = "reach" if not mark.failing else "contact" if mark.to is None else "missed"
    return replace(scene, marks=(Mark(mark.point, mark.text, kind, mark.to),))


def _view(scene: Scene, mark: WebMark | None, title: str) -> WebView:
    """The same to be turned; the body is called what the scene says of it."""
    marks = () if mark is None else (mark,)
    return replace(scene_view(scene, [scene.description]), title=title, marks=marks)


def _tried_picture(result: PopulationFound, change: TriedChange, views: PageViews) -> Markup:
    """Somebody who gains by a change, before and after it; "" where nobody does."""
    person = change.person
    if person is None:
        return Markup("")
    after = change.margins[1]
    name = plain(change.gain.requirement)
    label = result.people.called(person.row)
    asked = result.requirements[person.before.requirement]
    left = spare_words(after, asked.unit, of=" of the limit" if asked.check == "reads" else "")
    lack = lack_words(result, person.row, person.before.requirement)
    point = person.after.tip or person.after.target
    spare = None if point is None else WebMark(point, left)
    marks = (_lacking(result, person.before, lack), spare)
    one, two = (
        _scene(found, mark, name, label)
        for found, mark in zip((person.before, person.after), marks, strict=True)
    )
    title = f"{label}, {name}"
    return two_states(
        TwoStates(
            views=(_view(one, marks[0], title), _view(two, marks[1], title)),
            scenes=(one, two),
            names=("as it is", plain(change.gain.words)),
            title=title,
            said=title,
            caption=(
                f"{label} misses “{name}” by {lack} as it is, and has {left} after "
                f"{plain(change.gain.words)}"
            ),
        ),
        views.packing,
    )


def _lacking(result: PopulationFound, found: Illustration, lack: str) -> WebMark | None:
    """What is lacking as a line to scale, or as a point where no line would be; None where there is
    nothing to point at.

    A reach: from where the limb got to its target. A clearance: from the surface of the body to
    what is too near. Eyes: the height that they lack, or have too much. What is looked at: the line
    toward it, not beyond what a picture shows.
    """
    if found.target is None:
        return None
    short = -float(result.margin[found.row, found.requirement])
    check = result.requirements[found.requirement].check
    target = np.array(found.target)
    tip = target if found.tip is None else np.array(found.tip)
    code = int(result.reason[found.row, found.requirement])
    if check in ("eye_height", "view_over"):
        high = code >= 0 and result.reasons[code] == TOO_HIGH
        x, y, z = tip.tolist()
        return WebMark((x, y, z), f"{lack} lacking", (x, y, z - short if high else z + short), True)
    way = tip - target
    apart = float(np.linalg.norm(way))
    if check == "self_contact":
        return WebMark(found.target, f"{lack} too deep", failing=True)
    if code >= 0 and result.reasons[code].kind == "deep":
        limb = result.reasons[code].at
        return WebMark(found.target, f"the {limb} is {lack} too deep", failing=True)
    if check in ("clearance", "contact") and apart > 0.0:
        why = f"{lack} too deep" if check == "contact" else f"{lack} too close"
        return _gap_mark(result, found, why, failing=True)
    if apart > 0.0 and check in _LOOKED_AT:
        end = xyz(tip - way * min(1.0, _LINE / apart))
        return WebMark(xyz(tip), f"{lack} lacking", end, failing=True)
    if apart > 0.0 and (check == "reach" or abs(apart - short) < _TO_SCALE):
        x, y, z = tip.tolist()
        return WebMark((x, y, z), f"{lack} short", found.target, failing=True)
    return WebMark(found.target, f"{lack} lacking", failing=True)


def _tightest(result: PopulationFound, found: Illustration, left: str) -> WebMark | None:
    """What is met with least to spare, at the place where that is so; None where there is nothing to
    point at."""
    if found.target is None:
        return None
    check = result.requirements[found.requirement].check
    return (
        _gap_mark(result, found, left, failing=False)
        if check in ("clearance", "contact") and found.tip is not None
        else WebMark(found.tip or found.target, left)
    )


def _gap_mark(result: PopulationFound, found: Illustration, why: str, *, failing: bool) -> WebMark:
    """The line from the surface of the body to what is nearest, or the point where it is in that, with
    the distance, what is asked and what that comes to."""
    target, tip = np.array(found.target), np.array(found.tip)
    way = tip - target
    apart = float(np.linalg.norm(way))
    sphere = int(np.argmin(np.linalg.norm(found.placed.centres[0] - tip, axis=1)))
    room = apart - float(found.placed.body.radius[found.placed.person[0], sphere])
    point = target + way * (max(room, 0.0) / max(apart, 1e-12))
    requirement = result.requirements[found.requirement]
    where = f"{millimetres(abs(room))} {'deep' if room < 0.0 else 'apart'}"
    if requirement.check == "clearance":
        criteria = result.study.criteria
        asked = next(one.at_least for one in criteria if one.name == requirement.criterion)
        where += f", {1000 * asked:g} asked"
    to = found.target if room > 0.0 else None
    return WebMark(xyz(point), f"{where}: {why}", to, failing=failing)


def _length(camera: Camera, mark: WebMark | None) -> float:
    """[pixels] of the line that is lacking; 0 where none is known."""
    if mark is None or mark.to is None:
        return 0.0
    ends = project(camera, np.array([mark.to, mark.point]))[:, :2]
    return round(float(np.linalg.norm(ends[1] - ends[0])), 3)


def _map(result: PopulationFound, found: ReachMap) -> dict[str, Any]:
    """A reach map's picture, its caption, and the shares at the controls near it."""
    task = found.task
    environment = result.place.environment
    hand = "either hand" if task.hand == "either" else f"the {task.hand} hand"
    points = len(found.points)
    how = f"reach each of {points:,} points with {hand}, grip {task.grip}, harness zone {task.zone}"
    counts = "Lengths of limbs and joint stops are heeded, obstacles are not."
    if task.sees:
        how = f"see each of {points:,} points with either eye"
        counts = (
            "Parts, own limbs with the hands on their controls, and others who are there stand in "
            "the way. What is mounted on the part and stands out of it by 60 mm at most hides nothing "
            "of it. The head is as the posture has it."
        )
    reached = [float(np.mean(found.share >= level)) for level in LEVELS]
    areas = [
        f"{percent(share, points)} by at least {100 * level:.0f} %"
        for share, level in zip(reached, LEVELS, strict=True)
    ]
    areas[0] += " of the people"
    sitter = tuple(middle(result.place).tolist())
    return {
        "part": plain(task.part),
        "how": how,
        "counts": counts,
        "verb": "see" if task.sees else "reach",
        "svg": Markup(reach_map_svg(found, environment, sitter=sitter)),
        "controls": _controls(result, found),
        "areas": f"Share of its points that are {'seen' if task.sees else 'reached'}: {', '.join(areas)}.",
    }


def _controls(result: PopulationFound, found: ReachMap) -> list[dict[str, str]]:
    """The controls near a reach map, and the share of the people at its point nearest to each."""
    rows = []
    for control in map_controls(found, result.place.environment):
        nearest = int(np.argmin(np.linalg.norm(found.points - control.at, axis=1)))
        share = percent(float(found.share[nearest]), len(result.served))
        rows.append({"name": plain(control.name), "share": share})
    return rows


def _key() -> list[dict[str, str]]:
    """The colours of a reach map in words."""
    edges = [f"{100 * level:.0f}" for level in LEVELS]
    words = [f"under {edges[0]} %", *(f"{a} to {b} %" for a, b in pairwise(edges))]
    return [
        {"words": w, "colour": c}
        for w, c in zip([*words, f"{edges[-1]} % and more"], BANDS, strict=True)
    ]
