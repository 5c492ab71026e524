"""A comparison of two designs in words."""

from __future__ import annotations

import numpy as np

from workbench.body.people.share import percent, percent_number
from workbench.model.accommodation import MET
from workbench.model.comparison import Comparison, Judged, PairedShare
from workbench.model.figures import plain
from workbench.model.population import person_name
from workbench.report.population.words import (
    spare_words,
)

__all__ = [
    "chance_words",
    "change_sentence",
    "comparison_headline",
    "difference_words",
    "worst_missed",
]

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


def chance_words(chance: float) -> str:
    """ "0.11", "under 0.001"."""
    return "under 0.001" if chance < 0.001 else f"{chance:.2g}" if chance < 0.995 else "1"


def comparison_headline(found: Comparison) -> str:
    """The whole comparison in two sentences."""
    everybody = found.groups[0]
    count = everybody.count
    chance = chance_words(everybody.chance)
    chance = chance.replace("under", "<") if chance.startswith("under") else f"= {chance}"
    shares = f"{percent(everybody.before, count)} of {count:,} people fit before and {percent(everybody.after, count)} after"
    if not everybody.gainers and not everybody.losers:
        return f"{shares}: the same people, nobody gains and nobody loses."
    return (
        f"{shares}, {difference_words(everybody)}. {_people(everybody.gainers)} gain{_s(everybody.gainers)} and "
        f"{_people(everybody.losers).lower()} lose{_s(everybody.losers)} "
        f"(exact McNemar test: p {chance})."
    )


def _people(count: int) -> str:
    return {0: "Nobody", 1: "One person"}.get(count, f"{count:,} people")


def _s(count: int) -> str:
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
