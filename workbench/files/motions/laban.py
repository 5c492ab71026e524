"""Labanotation as text (`.laban`): one movement a line, its beat, how many beats, the part,
direction and level."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

from workbench.errors import InputError, one_of
from workbench.files.motions.number_rows import numbered_lines
from workbench.files.schema import metres_in
from workbench.model.laban import DIRECTIONS, LEVELS, PARTS, SUBPARTS, Movement, Score, Sign

__all__ = ["read_score", "score_text"]

_NUMBER = re.compile(r"([0-9]{1,9}(?:\.[0-9]{1,12})?)(?:/([0-9]{1,9}))?")
_KEYS = ("title", "tempo", "step")
_MOST_BEATS = 100_000.0
_MOST_LINES = 100_000


def read_score(path: str | Path) -> Score:
    """A score of movements.

    First `key: value` lines: `tempo: 90` (beats a minute, needed), `title`, `step: 500 mm`. Then a
    line for each movement: `BEAT BEATS PART DIRECTION LEVEL`, or `BEAT BEATS PART hold`; beats
    count from 1 and may be fractions (1.5, 3/2). What follows a # is a remark. InputError, with the
    line, for what is not understood, for movements of one part that overlap, and where nothing
    moves.
    """
    source = Path(path)
    about: dict[str, tuple[int, str]] = {}
    movements: list[Movement] = []
    for number, line in numbered_lines(source):
        text = line.partition("#")[0].strip()
        key, colon, value = text.partition(":")
        if colon and not movements:
            _put(f"{source}, line {number}", about, (key.strip().lower(), number, value.strip()))
        elif text:
            movements.append(_movement(f"{source}, line {number}", text, number))
        if len(movements) > _MOST_LINES:
            raise InputError(f"{source}, line {number}: more than {_MOST_LINES} movements")
    if "tempo" not in about:
        raise InputError(f"{source}: the tempo is not stated (tempo: 90 is ninety beats a minute)")
    if not any(move.sign for move in movements):
        raise InputError(f"{source}: holds no movement")
    _refuse_overlaps(source, movements)
    number, word = about["tempo"]
    tempo = _number(f"{source}, line {number}", "tempo", word)
    if not 1 <= tempo <= 1000:
        raise InputError(
            f"{source}, line {number}: tempo {word}: 1 to 1000 beats a minute are possible"
        )
    ordered = tuple(sorted(movements, key=lambda m: (m.begin, PARTS.index(m.part))))
    return Score(ordered, tempo, _step(source, about), about.get("title", (0, ""))[1], str(source))


def score_text(score: Score) -> Iterator[str]:
    """Lines of a score that `read_score` gives back."""
    yield "# Labanotation: beat, beats, part, direction, level\n"
    if score.title:
        yield f"title: {score.title}\n"
    yield f"tempo: {score.tempo:g}\nstep: {1000 * score.step:g} mm\n\n"
    for move in score.movements:
        yield f"{move.begin:<8g}{move.beats:<8g}{move.part:<18}{move.sign or 'hold'}\n"


def _put(here: str, about: dict[str, tuple[int, str]], entry: tuple[str, int, str]) -> None:
    key, number, value = entry
    if key not in _KEYS:
        raise InputError(f"{here}: no key {key!r}; {one_of(key, _KEYS)}")
    if key in about:
        raise InputError(f"{here}: {key} stands twice")
    about[key] = number, value


def _movement(here: str, text: str, number: int) -> Movement:
    words = text.lower().split()
    if len(words) < 4:
        raise InputError(
            f"{here}: {text[:60]!r}: beat, beats, part, direction and level are needed (1 2 right arm "
            "forward high), or hold"
        )
    begin = _number(here, "beat", words[0])
    beats = _number(here, "beats", words[1])
    if not 1 <= begin <= _MOST_BEATS or not 1e-3 <= beats <= _MOST_BEATS:
        raise InputError(
            f"{here}: beat {words[0]} for {words[1]} beats: beats count from 1, and last longer than 0"
        )
    part, rest = _part(here, words[2:])
    sign = None if rest == "hold" else _sign(here, part, rest)
    return Movement(part, sign, begin, beats, number)


def _number(here: str, what: str, word: str) -> float:
    found = _NUMBER.fullmatch(word)
    if not found or (found[2] and not int(found[2])):
        raise InputError(f"{here}: {what} {word[:40]!r} is no number (2, 1.5 and 3/2 are)")
    return float(found[1]) / int(found[2] or 1)


def _part(here: str, words: list[str]) -> tuple[str, str]:
    """The part that is named first, the longest that fits, and what follows it."""
    for count in (3, 2, 1):
        name = " ".join(words[:count])
        if name in PARTS and len(words) >= count:
            return name, " ".join(words[count:])
    given = " ".join(words[:2])
    raise InputError(f"{here}: no part {given!r}; {one_of(given, PARTS)}")


def _sign(here: str, part: str, words: str) -> Sign:
    direction, _, level = words.rpartition(" ")
    swapped = " ".join(reversed(direction.split()))  # "forward left" is "left forward"
    direction = direction if direction in DIRECTIONS else swapped
    if level not in LEVELS or direction not in DIRECTIONS:
        raise InputError(
            f"{here}: {part}: {words!r} is no direction and level: one of {', '.join(DIRECTIONS)}, then "
            f"{', '.join(LEVELS)}; or hold"
        )
    if (direction, level) == ("place", "middle") and part not in ("support", *SUBPARTS):
        raise InputError(
            f"{here}: {part}: place middle is no direction; only a support, a whole arm or a whole leg "
            "has it"
        )
    return Sign(direction, level)


def _step(path: Path, about: dict[str, tuple[int, str]]) -> float:
    if "step" not in about:
        return Score.step
    number, text = about["step"]
    here = f"{path}, line {number}"
    value, _, unit = text.partition(" ")
    if unit.strip() not in metres_in:
        raise InputError(f"{here}: step {text!r} needs a number and a unit: {', '.join(metres_in)}")
    step = _number(here, "step", value) * metres_in[unit.strip()]
    if not 0 < step <= 3:
        raise InputError(f"{here}: step {text!r}: more than 0 and at most 3 m are possible")
    return step


def _refuse_overlaps(path: Path, movements: list[Movement]) -> None:
    """InputError where two lines are about one part, or a part and its limb, at the same time."""
    # parts of limbs first: in a limb's own turn none of them overlaps itself, so few are active at
    # once
    for part in sorted(PARTS, key=SUBPARTS.__contains__):
        own = [m for m in movements if m.part == part or m.part in SUBPARTS.get(part, ())]
        own.sort(key=lambda m: (m.begin, m.line))
        active: list[Movement] = []
        for move in own:
            active = [m for m in active if m.begin + m.beats > move.begin + 1e-9] + [move]
            for one, other in combinations(active, 2):
                if part in (one.part, other.part) and move in (one, other):
                    raise InputError(
                        f"{path}, line {max(one.line, other.line)}: {other.part} at beat {other.begin:g}: "
                        f"the {one.part} of line {min(one.line, other.line)} moves or holds until beat "
                        f"{one.begin + one.beats:g}"
                    )
