"""An accommodation in words: who fits, who is left out, by what and by how many millimetres; the
same every time."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.body.people.proportions import TENTHS_FROM, percent, percent_number, percent_parts
from workbench.model.accommodation import (
    MET,
    OF_RULES,
    DesignChange,
    GroupShare,
    Requirement,
    met_of,
    most_missed,
)
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.criterion import NO_REASON, Reason
from workbench.model.population import MASS, SEXES
from workbench.model.reach import MOST_SPARE
from workbench.model.result import PopulationFound
from workbench.model.units import UNITS, Unit, plain
from workbench.report.control_region import ONE_PLACE
from workbench.study.accommodation.grips import grip_words
from workbench.study.checks.sight import shortfall_words
from workbench.study.checks.view import TOO_HIGH, TOO_LOW
from workbench.study.kept_reaches import kept_of_population, kept_words
from workbench.study.settings import setting_text

__all__ = [
    "adjusted_words",
    "capital",
    "certain_shares",
    "certainty_percents",
    "certainty_words",
    "chief_reason",
    "dropping_words",
    "elsewhere_words",
    "first_found",
    "gain_sentence",
    "interval_words",
    "lack_words",
    "left_words",
    "limiting_words",
    "no_gain_words",
    "person_sentence",
    "population_headline",
    "reason_words",
    "requirement_sentence",
    "settable_words",
    "spare_words",
    "who_words",
]

_NOUNS = {"female": ("woman", "her", "women"), "male": ("man", "his", "men")}
_MOST_SETTINGS = 4
"""Settings that are listed in a sentence."""
_MOST_KEPT = 3
"""Controls that nobody reaches that open the headline."""
_ALMOST_NOBODY = 0.05
"""Where no more than this share fits, the headline says what keeps people out and what mends it."""
_FEW = 20  # people of one sex: below, shares among them say little
_UNUSUAL = 0.75
"""Share of people of one sex who must have more, or less, of a measure that is called unusual."""


def interval_words(group: GroupShare, confidence: float) -> str:
    """ "95 % interval 79 to 83 %"."""
    low, high = (percent_number(value, group.count) for value in (group.low, group.high))
    return f"{100 * confidence:g} % interval {low} to {high} %"


def population_headline(result: PopulationFound) -> str:
    """A population in a few sentences: what keeps everybody from a control, the share that fits
    with its interval, and what leaves out most."""
    found = first_found(result)
    if not found:
        return _share_sentence(result)
    shown = [f"{capital(words)}." for words in found[:_MOST_KEPT]]
    more = len(found) - len(shown)
    if more > 0:
        shown.append(f"{more} more control{'s are' if more > 1 else ' is'} like that.")
    share = _share_sentence(result)
    return f"{' '.join(shown)} With the environment as described, {share[:1].lower()}{share[1:]}"


def first_found(result: PopulationFound) -> list[str]:
    """What is to be known before the share: the controls that are too flat for the grip that is
    asked for, and those that one part keeps everybody from, where the part may be the control's
    own, or nobody fits."""
    flat = {one.requirement for one in result.grips}
    nobody = not result.served.any()
    kept = [
        one
        for one in kept_of_population(result)
        if one.requirement not in flat and (one.beside or nobody)
    ]
    return [*grip_words(result.grips), *kept_words(kept)]


def _share_sentence(result: PopulationFound) -> str:
    """The share that fits with its interval and what leaves out most, how sure it is, and who
    overlaps nothing."""
    everybody = result.shares[0]
    count = len(result.served)
    if count == 1:
        fits = "fits" if result.served[0] else f"does not fit{_worst(result)}"
        return f"The one person {fits}.{clear_words(result)}"
    interval = interval_words(everybody, result.study.shares.confidence)
    if result.served.all():
        who = "Everybody fits"
    elif result.served.any():
        who = f"{percent(everybody.share, count)} of the population fits"
    else:
        who = "Nobody fits"
    stand = result.place.stand
    steps = stand is not None and stand.steps and len(result.requirements) > 1
    interval += f", {count:,} people" + (f", each from {ONE_PLACE}" * steps)
    fits = f"{who} ({interval}){_worst(result)}."
    if everybody.share <= _ALMOST_NOBODY:
        keeps = [] if first_found(result) else [_keeps_words(result)]
        fits = " ".join([f"{who} ({interval}).", *keeps, *_mends_words(result)])
    return f"{fits}{_undecided(everybody)}{clear_words(result)}"


def _keeps_words(result: PopulationFound) -> str:
    """What most people miss, by how much from the least to the most, and what limits most of them;
    what else nobody meets."""
    met = met_of(result.margin)
    chief = most_missed(result.margin, result.people.weight)
    rows = np.flatnonzero(~met[:, chief])
    ends = rows[np.argsort(-result.margin[rows, chief], kind="stable")][[0, -1]].tolist()
    size = " to ".join(dict.fromkeys(lack_words(result, row, chief) for row in ends))
    alone = f"{_share(result, 1 - result.single[chief])} of the people do not meet"
    who = alone if met[:, chief].any() else "Nobody meets"
    reason = chief_reason(result, chief)
    limited = ends_words(result, rows)
    if not limited and reason:
        limited = f", limited most often by {reason}"
    others = [r for r in np.flatnonzero(~met.any(axis=0)).tolist() if r != chief]
    nor = f" Nor does anybody meet {_listed(result, others, shares=False)}." if others else ""
    return (
        f"{who} “{plain(result.requirements[chief].name)}”: it is missed by {size}{limited}.{nor}"
    )


def ends_words(result: PopulationFound, rows: Ints) -> str:
    """ "; all of them stand at the front end of the area in which they may step, ..." of some people, ""
    where less than half stand at an end beyond which they would miss less."""
    count = {end: int(who[rows].sum()) for end, who in result.ends.items()}
    end = max(count, key=lambda name: count[name], default="")
    if not end or 2 * count[end] < len(rows):
        return ""
    who = "all" if count[end] == len(rows) else f"{count[end]}"
    area = "of the area in which they may step"
    return f"; {who} of them stand at the {end} end {area}, and would miss less beyond it"


def _mends_words(result: PopulationFound) -> list[str]:
    """What would let people fit where hardly anybody does: the criterion without which most would, or
    what whoever is nearest to fitting misses; and the change that gains most."""
    weight = result.people.weight / result.people.weight.sum()
    names = list(dict.fromkeys(one.criterion for one in result.requirements))
    columns = len(result.requirements) + np.arange(len(names))
    shares = weight @ result.sets[:, columns]
    best = int(np.argmax(shares))
    missed = ~met_of(result.margin)
    if shares[best] > result.shares[0].share + 1e-12:
        mine = [r for r, one in enumerate(result.requirements) if one.criterion == names[best]]
        lacks = sorted((r for r in mine if missed[:, r].any()), key=lambda r: result.single[r])
        share = percent(float(shares[best]), len(missed))
        said = f"Without “{plain(names[best])}” {share} would fit"
        if len(mine) > 1:
            said += f": of its {len(mine)} requirements those missed are {_listed(result, lacks)}"
    else:
        fewest = int(missed.sum(axis=1).min())
        found = Counter(
            tuple(np.flatnonzero(row).tolist()) for row in missed if row.sum() == fewest
        )
        ((few, _),) = found.most_common(1)
        left = _listed(result, few, shares=False)
        said = f"Dropping one criterion is not enough: who comes nearest to fitting misses {left}"
    gains = sorted(result.gains, key=lambda one: (one.joint_after, one.after - one.before))
    helps = [one for one in gains if one.after > one.before]
    gain = [gain_sentence(one, len(missed)) for one in helps[-1:]]
    return gain if len(names) == 1 else [f"{said}.", *gain]


def _share(result: PopulationFound, share: float) -> str:
    """A share of the people from 0 to 1, as fine as their number allows."""
    return percent(float(share), len(result.served))


def _listed(result: PopulationFound, rows: Sequence[int], *, shares: bool = True) -> str:
    """Requirements by their names, "“reach flaps” (94 % of the people)", with the share that misses each where that
    is wanted; of many the first few."""
    names = [
        f"“{plain(result.requirements[r].name)}”"
        + f" ({_share(result, 1 - result.single[r])} of the people)" * shares
        for r in rows[:_MOST_KEPT]
    ]
    more = len(rows) - len(names)
    if more:
        names.append(f"{more} more")
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]


def clear_words(result: PopulationFound) -> str:
    """ " 75 % fit and overlap nothing by more than is allowed; the deepest of the others: right hand in
    throttle_quadrant, 13 mm more than is allowed (16 people).", "" where nobody fits."""
    if not result.served.any():
        return ""
    if result.clear.all():
        return " Nobody overlaps anything by more than is allowed."
    share = _share(result, result.shares[0].clear)
    some = (
        f"{share} fit and overlap nothing"
        if result.clear.any()
        else "All of them overlap something"
    )
    one = f"The person overlaps {'nothing' if result.clear[0] else 'something'}"
    who = one if len(result.served) == 1 else some
    return f" {who} by more than is allowed{_deepest(result)}."


def _deepest(result: PopulationFound) -> str:
    """The overlap that no criterion asks about that is deepest, "" where none is known."""
    if not result.overlaps:
        return ""
    one = max(result.overlaps, key=lambda overlap: overlap.deepest)
    where = one.part or f"their own {one.other_segment}"
    people = f"{one.people} {'people' if one.people > 1 else 'person'}"
    much = f"{1000 * one.deepest:.0f} mm more than is allowed"
    return f"; the deepest overlap: {one.segment} in {where}, by up to {much} ({people})"


def _undecided(group: GroupShare) -> str:
    """ " Allowing for the error of the body model's surface, 86 % fit, 12 % do not and 2 % are undecided.",
    "" where nobody is undecided or it is not known."""
    if not group.undecided > 0:
        return ""
    sure, undecided, out = certainty_percents(group)
    misses = f", {out} do not" if group.possible < 1 else ""
    return (
        f" Allowing for the error of the body model's surface, {sure} fit{misses} and {undecided} are "
        f"undecided."
    )


def certainty_percents(group: GroupShare) -> list[str]:
    """Of whom it is certain that they fit, who is undecided, and of whom it is certain that they do
    not: percentages that add to 100; "not known" where the fit error is not known."""
    return (
        ["not known"] * 3
        if math.isnan(group.undecided)
        else percent_parts((group.certain, group.undecided, 1 - group.possible), group.count)
    )


def certain_shares(result: PopulationFound, index: int) -> tuple[float, float]:
    """The share of the people who meet a requirement wherever the true surface of the body lies,
    and of those who do if it lies where it suits; NaN where it is not known how far from the
    spheres it may lie."""
    if not result.known[:, index].all():
        return float("nan"), float("nan")
    weight = result.people.weight / result.people.weight.sum()
    return float(weight @ result.certain[:, index]), float(weight @ result.possible[:, index])


def certainty_words(result: PopulationFound) -> str:
    """How many people fit, and how many do not, wherever the true surface of the body lies; "" where
    nothing depends on it."""
    surface = result.of_surface
    if not np.isfinite(result.margin[:, surface]).any():
        return ""
    if not result.known.all():
        return (
            "The error of the body model's surface is not stated for every segment, so it is not "
            "known how certain a margin near zero is."
        )
    less, more = (
        f"{1000 * float(np.nanmax(ends[:, surface])):.0f} mm"
        for ends in (result.margin - result.low, result.high - result.margin)
    )
    known = (
        f"The body model's surface has a stated error: a true clearance may be up to {less} smaller "
        f"or up to {more} larger than computed."
    )
    return f"{known} {_decided(result)}"


def _decided(result: PopulationFound) -> str:
    """Who fits for certain, who does not, and who is undecided."""
    everybody = result.shares[0]
    undecided = result.undecided
    count = int(undecided.sum())
    if not count:
        return "Wherever it lies within that error, the same people fit."
    sure, share, out = certainty_percents(everybody)
    who = f"{count:,} people ({share}) are" if count > 1 else f"one person ({share}) is"
    return (
        f"Wherever it lies within that error, {sure} of the people fit and {out} do not, in the "
        f"position that was found for them; {who} undecided. {_counted(result)} {_undecided_most(result)}"
    )


def _counted(result: PopulationFound) -> str:
    """How many of the undecided count as fitting."""
    count = int(result.undecided.sum())
    fit = int((result.undecided & result.served).sum())
    moves = result.place.travel != ((0.0, 0.0), (0.0, 0.0))
    other = (
        f"; no other {_position_words(result)} was found in which they fit for certain"
        if fit and moves
        else ""
    )
    if count == 1:
        return f"This person counts as {'fitting' if fit else 'not fitting'} here{other}."
    who = "All of them count" if fit == count else f"{fit:,} of them count{'s' if fit == 1 else ''}"
    return f"{who if fit else 'None of them counts'} as fitting here{other}."


def _undecided_most(result: PopulationFound) -> str:
    """The requirement that is undecided of most people."""
    undecided = result.undecided[:, None] & ~result.certain & result.possible
    count = undecided.sum(axis=0)
    most = int(np.argmax(count))
    name = plain(result.requirements[most].name)
    return f"The requirement most often undecided is “{name}”: for {count[most]} of {len(undecided):,} people."


def _worst(result: PopulationFound) -> str:
    """ "; missed most often is “reach flaps”, by 40 % of the people (30 % miss only this)", "" where
    everybody fits."""
    out = 1 - np.asarray(result.single)
    if result.served.all():
        return ""
    worst = most_missed(result.margin, result.people.weight)
    name = f"“{plain(result.requirements[worst].name)}”"
    if len(out) == 1 or len(result.served) == 1:
        return f"; {name} is not met"
    alone = result.only[worst]
    only = f"{_share(result, alone)} miss only this" if alone > 0 else "nobody misses only this"
    if not alone > 0 and result.without[worst] > result.shares[0].share + 1e-12:
        would = _share(result, result.without[worst])
        only = f"{only}, but without it {would} would fit in some other {_position_words(result)}"
    share = _share(result, out[worst])
    ends = ends_words(result, np.flatnonzero(~met_of(result.margin[:, worst])))
    return f"; missed most often is {name}, by {share} of the people ({only}){ends}"


def elsewhere_words(result: PopulationFound) -> str:
    """How many people fit only in another position than the comfortable one, "" where nobody does
    and for a seat without travel."""
    count = int(result.moved.sum())
    if not count:
        return ""
    share = _share(result, result.people.weight @ result.moved / result.people.weight.sum())
    way = np.linalg.norm(result.seat - result.comfortable, axis=1)[result.moved]
    far = f"{1000 * float(np.median(way)):.0f} mm"
    who = f"{count:,} people" if count > 1 else "One person"
    fit = "fit" if count > 1 else "fits"
    middle = f"half of them within {far} of it" if count > 1 else f"{far} from it"
    return (
        f"{who} ({share}) {fit} only away from the most comfortable {_position_words(result)}, "
        f"{middle}."
    )


def _position_words(result: PopulationFound) -> str:
    """What a person may have otherwise: "position of the seat", or "place within the area"."""
    return "position of the seat" if result.place.seat is not None else "place within the area"


def adjusted_words(result: PopulationFound) -> str:
    """How many people fit only with something set otherwise than nominally, and how; "" where
    nothing can be set."""
    if not result.adjustments:
        return ""
    what = settable_words(result, "or")
    count = int(result.adjusted.sum())
    if not count:
        return f"Whoever fits does so at the nominal setting of {what}."
    share = _share(result, result.people.weight @ result.adjusted / result.people.weight.sum())
    who = f"{count:,} people ({share}) fit" if count > 1 else f"One person ({share}) fits"
    return f"{who} only with {what} away from its nominal setting: {_settings_list(result)}."


def settable_words(result: PopulationFound, last: str) -> str:
    """What the people may set: "wheel tilt or wheel telescope", "" where nothing.

    last: the word before the last of several.
    """
    names = [plain(one.name) for one in result.adjustments]
    return f"{', '.join(names[:-1])} {last} {names[-1]}" if len(names) > 1 else "".join(names)


def _settings_list(result: PopulationFound) -> str:
    """The settings of those who need one, the most frequent first, with the number of people where
    there are several."""
    found = Counter(setting_words(result, row) for row in np.flatnonzero(result.adjusted).tolist())
    if len(found) == 1:
        return next(iter(found))
    shown = [f"{words} ({count})" for words, count in found.most_common(_MOST_SETTINGS)]
    more = len(found) - len(shown)
    if more:
        shown.append(f"and {more} other{'s' if more > 1 else ''}")
    return "; ".join(shown)


def setting_words(result: PopulationFound, row: int) -> str:
    """What a person has set otherwise than nominally: "wheel tilt at −4.0 degrees", "" where
    nothing."""
    values = zip(result.adjustments, result.setting[row].tolist(), strict=True)
    return ", ".join(setting_text(one, value) for one, value in values if value != one.at)


def requirement_sentence(result: PopulationFound) -> str:
    """Which requirement is met least by itself, and which would gain most if it were dropped."""
    if result.served.all():
        return "Everybody meets every requirement."
    most = most_missed(result.margin, result.people.weight)
    name = plain(result.requirements[most].name)
    out = _share(result, 1 - result.single[most])
    return f"The requirement missed most often is “{name}”: by {out} of the people. {dropping_words(result)}"


def dropping_words(result: PopulationFound) -> str:
    """What would be gained if one requirement were dropped."""
    most = most_missed(result.margin, result.people.weight)
    gain = int(np.argmax(result.without))
    if result.without[gain] <= result.shares[0].share + 1e-12:
        return (
            "Everybody who is left out misses two requirements or more: dropping a single "
            "requirement would gain nothing."
        )
    name = "it" if gain == most else f"“{plain(result.requirements[gain].name)}”"
    before = _share(result, result.shares[0].share)
    after = _share(result, result.without[gain])
    return (
        f"Dropping {name} would gain most: {after} of the people meet all the others, {before} "
        f"meet all."
    )


def gain_sentence(gain: DesignChange, count: int) -> str:
    """ "Moving flaps 32 mm aft takes “reach flaps” from 88 to 95 %, and all together from 81 to 84
    %." of so many people."""
    shares = (gain.before, gain.after, gain.joint_before, gain.joint_after)
    one, two, all_one, all_two = (percent_number(share, count) for share in shares)
    limit = f" {capital(plain(gain.limit))}." if gain.limit else ""
    joint = f"leaves all requirements together at {all_one} %"
    if all_one != all_two:
        joint = f"all requirements together from {all_one} to {all_two} %"
    own = f"takes “{plain(gain.requirement)}” from {one} to {two} %"
    if one == two:
        own = f"leaves “{plain(gain.requirement)}” at {one} %" + (
            " and takes" if all_one != all_two else ""
        )
        joint = joint if all_one != all_two else f"and {joint}"
        return f"{capital(plain(gain.words))} {own} {joint}.{limit}"
    return f"{capital(plain(gain.words))} {own} and {joint}.{limit}"


def no_gain_words(result: PopulationFound) -> list[str]:
    """What would gain and is not proposed; that no proposal gains anything, where people are left out
    and no changes were asked for; how well shares with a change are known; what was not looked at where
    a seat goes beyond its travel, or who steps beyond the area."""
    words = [f"Not proposed: {plain(one)}." for one in result.refused]
    if any(gain.joint_after < 1 for gain in result.gains):
        words.append(
            "With a change made, people are searched for in fewer positions: a run of the changed "
            "design may find more who fit."
        )
    seat = result.place.own_seat
    if any("letting the seat go" in one.words for one in result.gains) and not (
        seat and seat.moves
    ):
        words.append(
            "No part goes along with the seat (moves), so whether a seat beyond its travel meets the "
            "floor or other parts was not looked at."
        )
    if result.gains or result.served.all() or result.study.changes:
        return words
    what = "a control or a part"
    if result.place.goes:
        end = "the area to step in" if result.place.seat is None else "the seat's travel"
        what = f"a control, a part or an end of {end}"
    return [
        *words,
        f"No {'other ' if result.refused else ''}straight move of {what}, up to 100 mm, nor two of them together, was found that lets "
        "more people meet all requirements together.",
    ]


def person_sentence(result: PopulationFound, row: int) -> str:
    """Who it is and what is farthest from being met: "A woman of 1,512 mm (female 31): her right
    hand stays 41 mm short of flaps in zone 2, limited by the length of the arm. Of her measures that
    matter for this, the most unusual is thumb tip reach, 652 mm; 97 % of the women here have more. 2
    more requirements are not met."."""
    whose = _NOUNS[SEXES[int(result.people.sex[row])]][1]
    text = f"{capital(who_words(result, row))}: "
    short = np.flatnonzero(~result.met[row])
    if not len(short):
        tight = result.looked_at(row)
        name = plain(result.requirements[tight].name)
        return f"{text}every requirement is met, “{name}” with {left_words(result, row, tight)}."
    worst = result.looked_at(row)
    text += _lacks(result, row, worst, whose) + "."
    if worst == short[np.argmin(result.margin[row, short])]:
        text += limiting_words(result, row)
    more = len(short) - 1
    if more:
        text += f" {more} more requirement{'s are' if more > 1 else ' is'} not met."
    setting = setting_words(result, row)
    return text + (f" The setting with the smallest shortfall: {setting}." if setting else "")


def who_words(result: PopulationFound, row: int) -> str:
    """Who it is: "a woman of 1,512 mm (female 31)"."""
    people = result.people
    tall = ""
    if "stature" in people.names:
        tall = f" of {1000 * people.column('stature')[row]:,.0f} mm"
    return f"a {_NOUNS[SEXES[int(people.sex[row])]][0]}{tall} ({people.called(row)})"


@dataclass(frozen=True)
class _Lack:
    """What one requirement lacks of one person.

    whose: "her" or "his"; by: how much, with its unit; limb: the one that is shown, "" where none
    is; reason: what limits; deep: how deep the body is in what it should be apart from, "" if it is
    not.
    """

    requirement: Requirement
    whose: str
    by: str
    limb: str
    reason: Reason
    deep: str = ""

    @property
    def why(self) -> str:
        """What limits, in brackets."""
        return f" ({reason_words(self.reason, self.limb)})" if self.reason else ""


def _lacks(result: PopulationFound, row: int, index: int, whose: str) -> str:
    """What one requirement lacks of one person, with what limits it."""
    requirement = result.requirements[index]
    found = next((s for s in result.shown if s.row == row and s.requirement == index), None)
    code = int(result.reason[row, index])
    lack = _Lack(
        requirement,
        whose,
        lack_words(result, row, index, asked=True),
        found.limb if found is not None else "",
        result.reasons[code] if code >= 0 else NO_REASON,
        _deep(result, row, index),
    )
    name = f"“{plain(requirement.name)}”"
    if requirement.check == "reach":
        return _reach_lacks(lack)
    if requirement.check in ("clearance", "contact"):
        return _clearance_lacks(lack)
    if requirement.check == "self_contact" and lack.reason.at:
        one, other = (plain(name) for name in (lack.reason.thing, lack.reason.at))
        return f"{whose} {one} is {lack.by} too deep in {whose} {other}"
    if lack.reason in (TOO_LOW, TOO_HIGH):
        return f"{whose} eyes are {lack.by} {lack.reason.text.removeprefix('eyes ')} for {name}"
    if requirement.check == "sees":
        least = next(
            one.at_least for one in result.study.criteria if one.name == requirement.criterion
        )
        share = least + float(result.margin[row, index]) / requirement.unit.counts
        him = {"her": "her", "his": "him"}[whose]
        seen = f"{plain(requirement.target)} is {100 * share:.0f} % visible to {him}"
        rest = "most of the rest" if 100 * share >= 0.5 else "most of it"
        return f"{seen}, {100 * least:g} % asked{_hides_words(lack.reason, whose, rest)}"
    if requirement.check in OF_RULES or requirement.check == "reads":
        return f"{name} is missed by {lack.by}{_hides_words(lack.reason, whose, 'most of it')}"
    if requirement.check == "over_nose":
        kept = f": {reason_words(lack.reason)} is in the way" if lack.reason else ""
        return f"{whose} eyes look down {lack.by} less than “{plain(requirement.name)}” asks{kept}"
    if foot := lack.reason.foot:
        limit = replace(lack.reason, foot="")
        why = f", limited by {reason_words(limit, foot)}"
        why = plain(limit.clause) if lack.reason.part else why
        return f"{whose} {foot} stays {lack.by} short of its pedal{why}"
    return f"{name} is missed by {lack.by}{lack.why}"


def _deep(result: PopulationFound, row: int, index: int) -> str:
    """ "14 mm" of a body that overlaps what a clearance asks it to be apart from: margin + asked < 0."""
    requirement = result.requirements[index]
    if requirement.check != "clearance":
        return ""
    asked = next(c.at_least for c in result.study.criteria if c.name == requirement.criterion)
    apart = float(result.margin[row, index]) + asked
    return requirement.unit.short(-apart) if apart < 0.0 else ""


def lack_words(result: PopulationFound, row: int, index: int, *, asked: bool = False) -> str:
    """How much one requirement lacks of one person: "41 mm", "38 % of its surface"; with what is
    asked for where a sentence has room for it."""
    requirement = result.requirements[index]
    criterion = next(c for c in result.study.criteria if c.name == requirement.criterion)
    code = int(result.reason[row, index])
    reason = result.reasons[code] if code >= 0 else NO_REASON
    size = -float(result.margin[row, index])
    return shortfall_words(requirement, criterion, size, reason, asked=asked)


def _reach_lacks(lack: _Lack) -> str:
    """How far a limb stays short of its target, by its length or by a part of the environment."""
    requirement = lack.requirement
    who = f"{lack.whose} {lack.limb}" if lack.limb else "the reach"
    zone = f" in zone {requirement.zone}" if requirement.zone else ""
    target = f"{plain(requirement.target)}{zone}"
    limit = reason_words(lack.reason, lack.limb or requirement.target)
    why = f", limited by {limit}" if lack.reason else ""
    why = plain(lack.reason.clause) if lack.reason.part else why
    return f"{who} stays {lack.by} short of {target}{why}"


def _hides_words(reason: Reason, whose: str, rest: str) -> str:
    """ ": the left stick hides most of the rest", "" where nothing is known."""
    if not reason:
        return ""
    if reason.share or reason.kind in ("reading", "cuts", "mirrored"):
        return f": {reason_words(reason)}"
    if reason.kind == "beyond":
        return f": it is {reason.text}"
    who = f"{whose} {plain(reason.text)}" if reason.kind == "own" else reason_words(reason)
    return f": {who} hides {rest}"


def _clearance_lacks(lack: _Lack) -> str:
    """How much nearer than allowed a limb, or the segment of the reason, is to a part."""
    nearest = lack.reason.at
    who = lack.limb or (plain(lack.reason.thing) if nearest else "body")
    part = plain(nearest or lack.requirement.target)
    why = "" if nearest else lack.why
    if lack.deep:
        short = f", {lack.by} short of the clearance asked for" if lack.by != lack.deep else ""
        return f"{lack.whose} {who} is {lack.deep} deep in {part}{short}{why}"
    way = "deep in" if lack.requirement.check == "contact" else "close to"
    return f"{lack.whose} {who} is {lack.by} too {way} {part}{why}"


def reason_words(reason: Reason, limb: str = "") -> str:
    """What limits, as it stands in a sentence: "the length of the arm", "the right elbow
    (flexion)"."""
    if reason.kind == "deep" and reason.foot:
        return f"the {reason.foot.removesuffix('foot')}leg in {plain(reason.thing)}"
    if reason.foot:
        return f"the {reason.foot}, {reason_words(replace(reason, foot=''), reason.foot)}"
    if reason.kind == "limb":
        legs = not {"foot", "leg", "pedal", "heel"}.isdisjoint(re.split(r"[^a-z]+", limb.lower()))
        return f"the length of the {'leg' if legs else 'arm'}"
    words = plain(reason.text)
    if reason.kind == "own":
        return f"the body's {words}"
    named = reason.kind in ("stop", "segment", "near", "reading")
    return f"the {words}" if named and not words.startswith("the ") else words


def chief_reason(result: PopulationFound, index: int) -> str:
    """What limits most often those who do not meet a requirement, for how many of them, and between
    which shares it hides: "the canopy, 2.9 to 6.1 % (212 of 300)"."""
    codes = result.reason[~result.met[:, index], index]
    found = [result.reasons[int(code)] for code in codes if code >= 0]
    if not found:
        return ""
    ((chief, count),) = Counter(replace(one, share=0.0) for one in found).most_common(1)
    words = reason_words(chief, result.requirements[index].target)
    shares = [one.share for one in found if replace(one, share=0.0) == chief]
    if any(shares):
        ends = dict.fromkeys(f"{100 * share:.3g}" for share in (min(shares), max(shares)))
        words += f", {' to '.join(ends)} %"
    return words if count == len(codes) else f"{words} ({count} of {len(codes)})"


def limiting_words(result: PopulationFound, row: int) -> str:
    """ " Of her measures that matter for this, the most unusual is popliteal height, 352 mm; 97 % of the
    women here have more.", "" where no measure is named, or many people have one like it."""
    name = result.limiting[row]
    people = result.people
    if not name or name not in people.names:
        return ""
    value = float(people.column(name)[row])
    _, whose, plural = _NOUNS[SEXES[int(people.sex[row])]]
    unit = f"{value:.1f} kg" if name == MASS else f"{1000 * value:,.0f} mm"
    text = f" Of {whose} measures that matter for this, the most unusual is {plain(name)}, {unit}"
    alike: Bools = people.sex == people.sex[row]
    count = int(alike.sum())
    if count < _FEW:
        return text + "."
    share, way = _rank(people.column(name)[alike], people.weight[alike], value)
    return (
        ""
        if share < _UNUSUAL
        else f"{text}; {percent(share, min(count, TENTHS_FROM - 1))} of the {plural} here have {way}."
    )


def _rank(values: Floats, weight: Floats, value: float) -> tuple[float, str]:
    """The share of people, by their values and weights (P,), who have "more" or "less" than a
    value: the greater one."""
    parts = weight / weight.sum()
    more = float(parts @ (values > value))
    less = float(parts @ (values < value))
    return (more, "more") if more >= less else (less, "less")


def spare_words(margin: float, unit: Unit, *, of: str = "") -> str:
    """ "12 mm to spare"; "at least 200 mm to spare" of a reach, which is looked for no farther; "nothing
    to spare" of what is just met. margin [m] as it counts beside lengths, unit: in which it is
    read; of: what shares are of, " of the limit"."""
    most = "at least " if unit is UNITS["m"] and abs(margin - MOST_SPARE) < MET else ""
    size = unit.shown(max(margin, 0.0))
    places = unit.places + (margin > MET and size < 0.5 * 10.0**-unit.places)  # finer than nothing
    amount = f"{size:,.{places}f}"
    return (
        f"{most}{amount}{unit.words}{of} to spare"
        if float(amount.replace(",", ""))
        else "nothing to spare"
    )


def left_words(result: PopulationFound, row: int, index: int) -> str:
    """What one person has to spare in a requirement that is met: "12 mm to spare"."""
    one = result.requirements[index]
    of = " of the limit" if one.check == "reads" else ""
    return spare_words(float(result.margin[row, index]), one.unit, of=of)


def capital(text: str) -> str:
    """A sentence that begins with a capital letter."""
    return text[:1].upper() + text[1:]
