"""The whole result in three sentences: how the criteria came out, with the number that decides; the
tightest gap; the deepest overlap that no criterion asks about."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from workbench.contact.collide import allowed_depth
from workbench.model.arrays import Bools
from workbench.model.environment import Environment
from workbench.model.result import PersonFound, PosturesFound, Result, Verdict
from workbench.model.units import UNITS, tenths
from workbench.report.motions.sentences import differs_words, motion_scope
from workbench.report.population.sentences import capital, population_headline
from workbench.report.sentences import (
    finding_words,
    in_words,
    millimetres,
    milliseconds,
    share_sentence,
    surface_words,
)
from workbench.study.kept_reaches import kept_of_people, kept_words
from workbench.study.unasked import (
    meeting_words,
    overlap_words,
    unasked_meetings,
    unasked_overlaps,
)
from workbench.study.warnings import lost_seats

__all__ = ["deciding", "headline", "outcome_words"]

_TOUCHING = 5e-5
"""[m] A smaller distance reads as 0.0 mm: there the body touches, or rests."""
_OF_THE_BODY = ("self_contact", "stops")


def headline(result: Result) -> str:
    """The whole result in three sentences, of a population besides what its own headline says."""
    lost = lost_seats(result.study.environment, result.study.roles).values()
    words = [capital(doubt.words) + "." * (not doubt.words.endswith("?")) for doubt in lost]
    if lost:
        words.append("Mend this first: all else is of people who are not on that seat.")
    shares = [verdict for verdict in result.verdicts if verdict.share is not None]
    of_postures = [verdict for found in result.postures for verdict in found.verdicts]
    known = {id(verdict) for verdict in (*shares, *of_postures)}
    of_motions = [verdict for verdict in result.verdicts if id(verdict) not in known]
    if result.population is not None:
        words.append(population_headline(result.population))
    if shares:
        words.append(f"{capital(outcome_words(shares))}.")
    if result.postures:
        words += _kept(result.postures)
        words.append(f"{_scope(result.postures)}: {_outcome(result.postures, of_postures)}.")
    if result.motions:
        words += _motions(result, of_motions)
    if lost:  # its gaps and overlaps say nothing more
        return in_words(" ".join(words))
    words += _least(_gaps(result), "The tightest gap is {}.")
    overlaps = ((-excess, words) for excess, words in _overlaps(result))
    words += _least(overlaps, "The deepest overlap that no criterion asks about: {}.")
    return in_words(" ".join(words))


def _kept(postures: Sequence[PosturesFound]) -> list[str]:
    """Which controls are kept by what may be their own pieces."""
    found = {
        words: None
        for one in postures
        for words in kept_words(kept_of_people(one.environment, one.study.criteria, one.reaches))
    }
    return [f"{capital(words)}." for words in found]


def _scope(postures: Sequence[PosturesFound]) -> str:
    """Who was looked at: "2 people in 1 case", "Guest, 3 sizes, in 2 cases"."""
    found = postures[0]
    people = len(found.people)
    cases = len(found.cases)
    who = f"{people} {'people' if people > 1 else 'person'}"
    if found.study.crowd is not None:  # those beside a population are not its people
        who = capital(found.who)
    if len(postures) > 1:
        who += f", {len(postures)} sizes,"
    return f"{who} in {cases} case{'s' if cases > 1 else ''}"


def _motions(result: Result, verdicts: Sequence[Verdict]) -> list[str]:
    """How the criteria of motions came out; of several, which come out differently."""
    if len(result.motions) == 1:
        return [f"{motion_scope(result.motions[0])}: {outcome_words(verdicts)}."]
    differs = differs_words(verdicts, [motion.study.name for motion in result.motions])
    said = [f"{capital(differs)}."]
    if decisive := deciding(verdicts):
        nearest = capital(_nearest_words(decisive, verdicts))
        lead = nearest if decisive.passed else "The worst"
        said.append(f"{lead} is “{decisive.criterion.name}”: {_verdict_words(decisive)}.")
    return said


def outcome_words(verdicts: Sequence[Verdict]) -> str:
    """How criteria came out, with what decides: "2 of 7 criteria fail, the worst “head to canopy”:
    head (top) is 12.0 mm from canopy, 38.0 mm less than the 50.0 mm asked for (cruise, pilot)"."""
    said = _counted(verdicts)
    decisive = deciding(verdicts)
    if decisive is None:
        return said
    words = _verdict_words(decisive)
    if len(_names(verdicts)) == 1:
        return f"{said}: {words}"
    lead = f"{_nearest_words(decisive, verdicts)} " if decisive.passed else "the worst "
    if sum(not verdict.passed for verdict in verdicts) == 1:
        lead = ""
    return f"{said}, {lead}“{decisive.criterion.name}”: {words}"


def _nearest_words(decisive: Verdict, verdicts: Sequence[Verdict]) -> str:
    """That a verdict is nearest to its limit, and what was left aside where that is nearer."""
    aside = [one for one in verdicts if one.worst and (_of_the_body(one) or _held(one))]
    if all(_margin(one) >= _margin(decisive) for one in aside):
        return "nearest to its limit"
    return (
        "nearest to its limit, apart from allowed contacts and the body's own overlaps and joint "
        "stops,"
    )


def _of_the_body(verdict: Verdict) -> bool:
    return verdict.criterion.check in _OF_THE_BODY


def _names(verdicts: Iterable[Verdict]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(verdict.criterion.name for verdict in verdicts))


def _counted(verdicts: Sequence[Verdict]) -> str:
    """How many criteria hold or fail: "2 of 7 criteria fail", "both criteria hold"."""
    names = _names(verdicts)
    count = len(names)
    failed = len(_names(verdict for verdict in verdicts if not verdict.passed))
    if not count:
        return "no criterion is asked"
    if count == 1:
        return f"“{names[0]}” {'fails' if failed else 'holds'}"
    if failed:
        return f"{failed} of {count} criteria fail{'s' if failed == 1 else ''}"
    return "both criteria hold" if count == 2 else f"all {count} criteria hold"


def deciding(verdicts: Sequence[Verdict]) -> Verdict | None:
    """The verdict that fails by most, else the one nearest to its limit; None where nothing was
    measured.

    Who is not on his seat decides before all else. A millimetre, a degree and a percent count alike; of other figures a hundredth of the limit. Where
    all hold, what the body model does to itself, and a contact that is allowed, as of a hand with what
    it holds, decide only where nothing else was measured.
    """
    known = [one for one in verdicts if one.worst is not None or one.share is not None]
    failed = [one for one in known if not one.passed]
    if failed:
        unseated = [one for one in failed if one.criterion.check == "seated"]
        return min(unseated or failed, key=_margin)
    if any(not one.passed for one in verdicts):
        return None
    known = [one for one in known if one.criterion.check != "pedals"]  # on them or not
    elsewhere = [one for one in known if not _of_the_body(one) and not _held(one)]
    return min(elsewhere or known, key=_margin, default=None)


def _held(verdict: Verdict) -> bool:
    """Whether a verdict is nearest to its limit in a contact that is allowed."""
    worst = verdict.worst
    return verdict.criterion.check == "contact" and worst is not None and worst.limit < 0


def _margin(verdict: Verdict) -> float:
    """The margin of a verdict, so that units can be compared."""
    worst = verdict.worst
    if worst is None:
        return 0.0
    rule = worst.unit in ("", "g")
    return worst.margin * (100.0 / max(abs(worst.limit), 1e-9) if rule else UNITS[worst.unit].scale)


def _verdict_words(verdict: Verdict) -> str:
    """What decides a verdict, and where: "head (top) is 56.1 mm from canopy, 6.1 mm more than the
    50.0 mm asked for (looking left, pilot)"."""
    if verdict.share is not None:
        return share_sentence(verdict.criterion, verdict.share).removesuffix(".")
    worst = verdict.worst
    assert worst is not None
    figure = verdict.criterion.check == "injury"  # its window says when
    time = milliseconds(worst.time) if math.isfinite(worst.time) and not figure else ""
    where = _named(verdict.row, worst.case, worst.person, time)
    return _placed(finding_words(verdict.criterion.check, worst), where)


def _placed(words: str, where: str) -> str:
    """What was found and where, in one pair of brackets: "left hand is 27.0 mm into left stick (30.0
    mm allowed; cruise, pilot)"."""
    return f"{words[:-1]}; {where})" if words.endswith(")") else f"{words} ({where})"


def _outcome(postures: Sequence[PosturesFound], verdicts: Sequence[Verdict]) -> str:
    """How the criteria of postures came out, and what the postures miss of what the study wants of
    them: "all 5 criteria hold, but 4 aims of the predicted postures are missed, the farthest: the
    eyes stay 45 mm below left design eye (flying, small woman)"."""
    short = [(one, found.row) for found in postures for one in found.short]
    if not short:
        return outcome_words(verdicts)
    worst, row = max(short, key=lambda one: one[0].size)
    missed = f"{len(short)} aims of the predicted postures are missed, the farthest"
    if len(short) == 1:
        missed = "one aim of the predicted postures is missed"
    missed += f": {worst.words} ({_named(row, worst.case, worst.person)})"
    return (
        f"{_counted(verdicts)}, but {missed}"
        if all(verdict.passed for verdict in verdicts)
        else f"{outcome_words(verdicts)}; and {missed}"
    )


def _least(found: Iterator[tuple[float, str]], sentence: str) -> list[str]:
    """A sentence about the least of what was found, nothing where nothing was."""
    words = min(found, key=lambda one: one[0], default=(0.0, ""))[1]
    return [sentence.format(words)] if words else []


def _gaps(result: Result) -> Iterator[tuple[float, str]]:
    """[m] and in words the least gap of each person: "12.4 mm: head from canopy (cruise, pilot)".

    A gap is a distance of a segment from a part that it may not touch. Hands and what they use,
    feet and what they use, are not apart by a gap, nor is what touches. A motion has a gap where
    nothing is touched in it.
    """
    for found in result.postures:
        for person in found.people:
            distance = np.where(
                _has_gap(person, found.environment), person.clearance.distance, np.inf
            )
            distance = np.where(distance > _TOUCHING, distance, np.inf)
            case, segment, part = np.unravel_index(np.argmin(distance), distance.shape)
            least = float(distance[case, segment, part])
            if math.isfinite(least):
                what = f"{person.body.segment_names[segment]} from {found.environment.parts[part]}"
                where = _named(found.row, found.cases[case], person.name)
                known = surface_words(float(person.body.fit_error[0, segment, 0]))
                yield least, f"{tenths(1000 * least)}{known} mm: {what} ({where})"
    for motion in result.motions:
        frame, segment = np.unravel_index(np.argmin(motion.clearance), motion.clearance.shape)
        least = float(motion.clearance[frame, segment])
        if _TOUCHING < least < math.inf:
            what = f"{motion.study.body.segment_names[segment]} from what it may not touch"
            time = milliseconds(float(motion.study.motion.clock[frame]))
            yield least, f"{millimetres(least)}: {what} ({_named(motion.study.name, time)})"


def _named(*names: str) -> str:
    return ", ".join(filter(None, names))


def _has_gap(person: PersonFound, environment: Environment) -> Bools:
    """(N, K) between which segments and parts a distance is a gap."""
    body = person.body
    gap = allowed_depth(body, environment) <= 0
    for control in environment.controls:
        used = np.isin(environment.parts, control.own_parts)
        ends = np.isin(body.segments, ("LF", "RF") if control.for_feet else ("LHN", "RHN"))
        gap &= ~(ends[:, None] & used)
    return np.asarray(gap, dtype=np.bool_)


def _overlaps(result: Result) -> Iterator[tuple[float, str]]:
    """[m] beyond what is allowed and in words each overlap that no criterion asks about: "right upper
    leg is 51.2 mm into left seat pan (20.0 mm allowed) (cruise, pilot)"."""
    for found in result.postures:
        criteria = found.study.criteria
        for one in unasked_overlaps(criteria, found.cases, found.people, found.between):
            where = _named(found.row, one.case, one.person)
            yield one.excess, _placed(overlap_words(one), where)
    for motion in result.motions:
        for meeting in unasked_meetings(motion.study.criteria, motion.meetings)[:1]:
            where = _named(motion.study.name, milliseconds(meeting.deepest))
            yield meeting.depth - meeting.allowed, _placed(meeting_words(meeting), where)
