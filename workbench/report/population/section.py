"""The part of the page about a population: who fits, who does not, by what and by how much."""

from __future__ import annotations

import base64
import io
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.body.people.share import TENTHS_FROM, percent, percent_number
from workbench.draw.camera import Camera, project
from workbench.draw.disks import disks
from workbench.draw.reach_map import BANDS, LEVELS, map_controls, reach_map_svg
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.views import four_views
from workbench.model.accommodation import ReachMap
from workbench.model.arrays import Bools, Floats
from workbench.model.encumbrance import Encumbrance
from workbench.model.measures import MASS
from workbench.model.population_found import PopulationFound, Shown
from workbench.posture.seating.sides import middle
from workbench.report.population.charts import (
    bar,
    margin_axis,
    margin_range,
    margin_strip,
    share_axis,
    whisker,
)
from workbench.report.population.words import (
    elsewhere_words,
    gain_sentence,
    millimetres_short,
    no_gain_words,
    person_sentence,
    plain,
    reason_words,
    requirement_sentence,
)
from workbench.report.templates import template

__all__ = ["population_section", "population_words"]

_PICTURE = 520
_MOST_MEASURES = 12
_FROM = {
    "front": "from the front",
    "left": "from the left",
    "top": "from above",
    "three_quarter": "from the front left",
}
_NUMBERS = ("no", "one", "two", "three", "four", "five")


def population_section(result: PopulationFound, say: Callable[[str], None]) -> Markup:
    """The part of the page about a population: who fits, who does not, by what and by how much.

    say: called with words on how far it is.
    """
    say("pictures of the hardest people")
    ends = margin_range(result.spread)
    least = max(0.0, np.floor(20 * (min(g.low for g in result.shares) - 0.02)) / 20)
    people = result.people
    hardest = len(result.hardest)
    html = template("population/section.html.j2").render(
        result=result,
        body=result.body.name,
        clothes=[item.name for item in _clothes(result)],
        seated=result.place.seat is not None,
        bootstrap=result.study.shares.interval.method == "bootstrap",
        groups=[_group(result, index, least) for index in range(len(result.shares))],
        group_axis=Markup(share_axis(least)),
        confidence=f"{100 * result.study.shares.confidence:g}",
        worst=requirement_sentence(result),
        elsewhere=elsewhere_words(result),
        criteria=_criteria(result),
        requirements=_requirements(result, ends),
        margin_axis=Markup(margin_axis(ends)),
        women=bool((people.sex == 1).any() and (people.sex == 0).any()),
        measures=_measures(result),
        gains=[_gain(result, index) for index in range(len(result.gains))],
        no_gain=no_gain_words(result),
        cases=_NUMBERS[hardest] if hardest < len(_NUMBERS) else str(hardest),
        hardest=[_person(result, index) for index in range(hardest)],
        maps=[_map(result, found) for found in result.maps],
        key=_key(),
    )
    return Markup(html)


def population_words(result: PopulationFound, role: str) -> str:
    """Who the people of a role are, where they sit, and what their bodies are made from."""
    body = result.body
    people = len(result.people)
    asked = len(result.requirements)
    family = "of the family of " if body.basis else ""
    detail = f" (level of detail {body.detail})" if body.detail else ""
    clothes = [item.name for item in _clothes(result)]
    worn = f", wearing {', '.join(clothes)}" if clothes else ""
    seat = result.place.seat
    where = f" in the seat “{plain(seat)}”" if seat is not None else ""
    return (
        f"{role}: {people:,} people ({result.people.source}){where}, "
        f"{asked} requirement{'s' if asked > 1 else ''}. A person fits who meets them all. Each "
        f"body is {family}{body.name}, scaled to that person’s measures: "
        f"{len(body.sphere_names):,} spheres{detail}{worn}."
    )


def _clothes(result: PopulationFound) -> tuple[Encumbrance, ...]:
    """What everybody wears."""
    crowd = result.study.crowd
    return crowd.clothes if crowd is not None else ()


def _group(result: PopulationFound, index: int, least: float) -> dict[str, Any]:
    group = result.shares[index]
    share = percent(group.share, group.count)
    low, high = (percent_number(value, group.count) for value in (group.low, group.high))
    interval = f"{low} to {high} %"
    said = f"{group.group}: {share} ({interval})"
    chart = whisker(group.low, group.share, group.high, least=least, said=said)
    return {
        "name": group.group,
        "share": share,
        "interval": interval,
        "count": f"{group.count:,}",
        "chart": Markup(chart),
    }


def _weights(result: PopulationFound) -> Floats:
    weight = result.people.weight
    share: Floats = weight / weight.sum()
    return share


def _criteria(result: PopulationFound) -> list[dict[str, Any]]:
    """For each criterion the share that fails any of its requirements, and nothing of the others;
    worst first."""
    weight = _weights(result)
    met = result.met
    count = len(met)
    rows: list[dict[str, Any]] = []
    for number, name in enumerate(dict.fromkeys(r.criterion for r in result.requirements)):
        mine = np.array([r.criterion == name for r in result.requirements])
        failed = ~met[:, mine].all(axis=1)
        others = ~result.served & result.sets[:, len(result.requirements) + number]
        rows.append(
            {
                "name": plain(name),
                "count": int(mine.sum()),
                "people": int(failed.sum()),
                "out": float(weight @ failed),
                "alone": float(weight @ others),
            }
        )
    rows.sort(key=lambda row: -row["out"])
    most = max([row["out"] for row in rows] + [0.05])
    for row in rows:
        row |= {
            "met": percent(1 - row["out"], count),
            "left": percent(row["out"], count),
            "only": percent(row["alone"], count),
            "all": row["people"] == 0,
        }
        said = f"{row['name']}: {row['left']} left out, {row['only']} by it alone"
        row["chart"] = Markup(bar(row["out"], row["alone"], most=most, said=said))
    return rows


def _requirements(result: PopulationFound, ends: tuple[float, float]) -> list[dict[str, Any]]:
    """A row for each requirement, worst first: shares, charts, margins in millimetres, what limits
    most often."""
    weight = _weights(result)
    met = result.met
    sex = result.people.sex
    count = len(met)
    most = max(float(1 - result.single.min()), 0.05)
    rows = []
    for r in np.lexsort((result.spread[:, 1], result.single)).tolist():
        requirement = result.requirements[r]
        out = float(1 - result.single[r])
        alone = float(result.alone[r])
        name = plain(requirement.name)
        by_sex = [_share_of_some(weight, sex == s, met[:, r]) for s in (1, 0)]
        figures = [
            f"{round(1000 * v) + 0:d}".replace("-", "−") if np.isfinite(v) else "–"
            for v in result.spread[r]
        ]
        said = f"{name}: margins at 1, 5, 50, 95 and 99 %: {', '.join(figures)} mm"
        rows.append(
            {
                "name": name,
                "criterion": plain(requirement.criterion),
                "zone": requirement.zone or "",
                "met": percent(1 - out, count),
                "left": percent(out, count),
                "only": percent(alone, count),
                "all": bool(met[:, r].all()),
                "people": int((~met[:, r]).sum()),
                "by_sex": by_sex,
                "figures": figures,
                "bar": Markup(
                    bar(out, alone, most=most, said=f"{name}: {percent(out, count)} left out")
                ),
                "strip": Markup(margin_strip(result.spread[r], ends, said=said)),
                "applies": bool(np.isfinite(result.margin[:, r]).any()),
                "reason": _reason(result, r),
            }
        )
    return rows


def _share_of_some(weight: Floats, some: Bools, met: Bools) -> str:
    """The share of some people (P,) who meet a requirement, "–" where there are none."""
    if not some.any():
        return "–"
    return percent(float(weight[some] @ met[some]) / float(weight[some].sum()), int(some.sum()))


def _reason(result: PopulationFound, index: int) -> str:
    """What limits most often those who do not meet a requirement, and for how many of them."""
    found = Counter(int(code) for code in result.reason[~result.met[:, index], index] if code >= 0)
    if not found:
        return ""
    code, count = min(found.items(), key=lambda item: (-item[1], item[0]))
    words = reason_words(result.reasons[code], result.requirements[index].target)
    total = int((~result.met[:, index]).sum())
    return words if count == total else f"{words} ({count} of {total})"


def _measures(result: PopulationFound) -> list[dict[str, Any]]:
    """For each limiting measure the people it limits, most first, and how they compare with all."""
    people = result.people
    weight = result.people.weight
    limiting = np.array(result.limiting)
    total = float(weight[limiting != ""].sum())
    rows: list[dict[str, Any]] = []
    for name in sorted(set(result.limiting) - {""}):
        mine = limiting == name
        row: dict[str, Any] = {
            "name": plain(name),
            "people": int(mine.sum()),
            "share": float(weight[mine].sum()) / total,
        }
        if name in people.names:
            values = people.column(name)
            factor = 1.0 if name == MASS else 1000.0
            low, high = np.percentile(values, [5, 95])
            rank = np.mean([(values < v).mean() + (values == v).mean() / 2 for v in values[mine]])
            row["way"] = "small" if rank < 0.35 else "large" if rank > 0.65 else "either way"
            row["theirs"] = _range(values[mine].min() * factor, values[mine].max() * factor)
            row["all"] = _range(low * factor, high * factor) + (" kg" if name == MASS else " mm")
        rows.append(row)
    rows.sort(key=lambda row: (-row["share"], row["name"]))
    for row in rows:
        said = f"{row['name']}: {row['people']} people"
        row["chart"] = Markup(
            bar(row["share"], row["share"], most=max(r["share"] for r in rows), said=said)
        )
        row["percent"] = percent(row["share"], int((limiting != "").sum()))
    return rows[:_MOST_MEASURES]


def _range(low: float, high: float) -> str:
    return f"{low:,.0f} to {high:,.0f}" if f"{low:.0f}" != f"{high:.0f}" else f"{low:,.0f}"


def _gain(result: PopulationFound, index: int) -> dict[str, Any]:
    """One change as a sentence, with what a millimetre of it gives at first where that says
    something."""
    gain = result.gains[index]
    count = len(result.served)
    joint = gain.joint_after - gain.joint_before
    helps = joint > 1e-9 or (gain.after > gain.before + 1e-9 and joint > -1e-9)
    told = []
    if helps and gain.margin_rate >= 0.005:
        told.append(f"gives those who lack it {gain.margin_rate:.2f} mm of margin on average")
    if helps and np.isfinite(gain.rate) and gain.rate >= 0.05 and count >= TENTHS_FROM:
        told.append(f"lets {0.1 * gain.rate:.2f} % more of the people meet it")
    return {"sentence": gain_sentence(gain, count), "rate": " and ".join(told), "helps": helps}


def _person(result: PopulationFound, index: int) -> dict[str, Any]:
    """One of the hardest: a sentence and, where the body is at hand, its picture."""
    row = result.hardest[index]
    found = next((s for s in result.shown if s.row == row), None)
    picture = _picture(result, found) if found is not None else {}
    return {"sentence": person_sentence(result, row), **picture}


def _picture(result: PopulationFound, found: Shown) -> dict[str, str]:
    """The body in the cockpit as found, from where the line from tip to target shows longest."""
    lack = f"{millimetres_short(-float(result.margin[found.row, found.requirement]))} mm"
    name = plain(result.requirements[found.requirement].name)
    marks: tuple[Mark, ...] = ()
    if found.target is not None:
        reach = result.requirements[found.requirement].check == "reach"
        to = found.tip if found.tip is not None and found.tip != found.target else None
        marks = (
            Mark(found.target, lack, "missed" if reach else "clearance" if to else "contact", to),
        )
    scene = Scene(
        (SceneBody(found.placed, 0, "warm"),),
        found.environment,
        marks,
        name,
        "as found at the worst",
    )
    views = four_views(scene, width=_PICTURE, height=_PICTURE)
    view, camera = max(views, key=lambda pair: (_length(pair[1], found), pair[0] == "left"))
    out = (
        io.BytesIO()
    )  # to look for the smallest file takes longer than to draw it, and saves a tenth
    disks(scene, camera).save(out, "PNG")
    text = "data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii")
    return {
        "png": text,
        "view": _FROM[view],
        "alt": f"{name}: {lack} are lacking, seen {_FROM[view]}",
    }


def _length(camera: Camera, found: Shown) -> float:
    """[pixels] of the line that is lacking; 0 where none is known."""
    if found.target is None or found.tip is None:
        return 0.0
    ends = project(camera, np.array([found.target, found.tip]))[:, :2]
    return round(float(np.linalg.norm(ends[1] - ends[0])), 3)


def _map(result: PopulationFound, found: ReachMap) -> dict[str, Any]:
    """A reach map's picture, its caption, and the shares at the controls near it."""
    task = found.task
    environment = result.place.environment
    hand = "either hand" if task.hand == "either" else f"the {task.hand} hand"
    people = len(result.served)
    controls = []
    for control in map_controls(found, environment):
        nearest = int(np.argmin(np.linalg.norm(found.points - control.at, axis=1)))
        controls.append(
            {"name": plain(control.name), "share": percent(float(found.share[nearest]), people)}
        )
    points = len(found.points)
    area = [
        f"{percent(float(np.mean(found.share >= level)), points)} by {100 * level:.0f} %"
        for level in LEVELS
    ]
    return {
        "part": plain(task.part),
        "how": f"{hand}, {task.grip}, zone {task.zone}, {points:,} points",
        "svg": Markup(
            reach_map_svg(found, environment, sitter=tuple(middle(result.place).tolist()))
        ),
        "controls": controls,
        "areas": f"Reached of its points: {', '.join(area)} of the people or more.",
    }


def _key() -> list[dict[str, str]]:
    """The colours of a reach map in words."""
    edges = [f"{100 * level:.0f}" for level in LEVELS]
    words = [f"under {edges[0]} %", *(f"{a} to {b} %" for a, b in pairwise(edges))]
    return [
        {"words": w, "colour": c}
        for w, c in zip([*words, f"{edges[-1]} % and more"], BANDS, strict=True)
    ]
