"""Read and write Labanotation as text (`.laban`): one movement per line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

from workbench.errors import InputError, one_of
from workbench.files.motions.number_rows import numbered_lines
from workbench.files.schema import metres_in
from workbench.model.laban import DIRECTIONS, LEVELS, PARTS, SUBPARTS, Movement, Score, Sign

__all__ = ["read_score", "score_text"]

_NUMBER = re.compile(r"([0-9]{1,9}(?:\.[0-9]{1,12})?)(?:/([0-9]{1,9}))?")
_KEYS = ("title", "tempo", "step")
_MAX_BEATS = 100_000.0
_MAX_MOVEMENTS = 100_000


class _Entry(NamedTuple):
    """A line "key: value" of the header."""

    line: int
    value: str


def read_score(path: str | Path) -> Score:
    """Read a score of movements.

    The file begins with lines `key: value`: `tempo: 90` (beats per minute, required), `title`,
    `step: 500 mm`. Then each line is a movement: `BEAT BEATS PART DIRECTION LEVEL`, or `BEAT BEATS
    PART hold`. Beats count from 1 and may be fractions (1.5, 3/2). A # begins a comment.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    InputError
        With the line, if it is not understood, if movements of one part overlap, or if nothing
        moves.
    """
    source = Path(path)
    header: dict[str, _Entry] = {}
    movements: list[Movement] = []
    for number, line in numbered_lines(source):
        here = f"{source}, line {number}"
        text = line.partition("#")[0].strip()
        key, colon, value = text.partition(":")
        if colon and not movements:
            _add_entry(here, header, key.strip().lower(), _Entry(number, value.strip()))
        elif text:
            movements.append(_movement(here, text, number))
        if len(movements) > _MAX_MOVEMENTS:
            raise InputError(f"{here}: more than {_MAX_MOVEMENTS} movements")
    tempo = _tempo(source, header)
    if not any(move.sign for move in movements):
        raise InputError(f"{source}: holds no movement")
    _refuse_overlaps(source, movements)
    ordered = tuple(sorted(movements, key=lambda m: (m.begin, PARTS.index(m.part))))
    title = header["title"].value if "title" in header else ""
    return Score(ordered, tempo, _step(source, header), title, str(source))


def _tempo(path: Path, header: dict[str, _Entry]) -> float:
    """Return the tempo [beats/min] of a header."""
    if "tempo" not in header:
        raise InputError(f"{path}: the tempo is not stated (tempo: 90 is ninety beats a minute)")
    number, word = header["tempo"]
    here = f"{path}, line {number}"
    tempo = _number(here, "tempo", word)
    if not 1 <= tempo <= 1000:
        raise InputError(f"{here}: tempo {word}: 1 to 1000 beats a minute are possible")
    return tempo


def score_text(score: Score) -> Iterator[str]:
    """Yield the lines of a score, which `read_score` reads back."""
    yield "# Labanotation: beat, beats, part, direction, level\n"
    if score.title:
        yield f"title: {score.title}\n"
    yield f"tempo: {score.tempo:g}\nstep: {1000 * score.step:g} mm\n\n"
    for move in score.movements:
        yield f"{move.begin:<8g}{move.beats:<8g}{move.part:<18}{move.sign or 'hold'}\n"


def _add_entry(here: str, header: dict[str, _Entry], key: str, entry: _Entry) -> None:
    if key not in _KEYS:
        raise InputError(f"{here}: no key {key!r}; {one_of(key, _KEYS)}")
    if key in header:
        raise InputError(f"{here}: {key} stands twice")
    header[key] = entry


def _movement(here: str, text: str, number: int) -> Movement:
    words = text.lower().split()
    if len(words) < 4:
        raise InputError(
            f"{here}: {text[:60]!r}: beat, beats, part, direction and level are needed (1 2 right arm "
            "forward high), or hold"
        )
    begin = _number(here, "beat", words[0])
    beats = _number(here, "beats", words[1])
    if not 1 <= begin <= _MAX_BEATS or not 1e-3 <= beats <= _MAX_BEATS:
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
    """Return the longest name of a part at the beginning of some words, and what follows it."""
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


def _step(path: Path, header: dict[str, _Entry]) -> float:
    """Return the length [m] of a step of a header."""
    if "step" not in header:
        return Score.step
    number, text = header["step"]
    here = f"{path}, line {number}"
    value, _, unit = text.partition(" ")
    if unit.strip() not in metres_in:
        raise InputError(f"{here}: step {text!r} needs a number and a unit: {', '.join(metres_in)}")
    step = _number(here, "step", value) * metres_in[unit.strip()]
    if not 0 < step <= 3:
        raise InputError(f"{here}: step {text!r}: more than 0 and at most 3 m are possible")
    return step


def _refuse_overlaps(path: Path, movements: list[Movement]) -> None:
    """Refuse two movements of one part, or of a part and its limb, at the same time."""
    # Parts of limbs first: when a limb is checked, none of its parts overlaps itself any more, so
    # few are active at once.
    for part in sorted(PARTS, key=SUBPARTS.__contains__):
        own = [m for m in movements if m.part == part or m.part in SUBPARTS.get(part, ())]
        own.sort(key=lambda m: (m.begin, m.line))
        active: list[Movement] = []
        for move in own:
            active = [m for m in active if m.begin + m.beats > move.begin + 1e-9] + [move]
            for one, other in combinations(active, 2):
                if part in (one.part, other.part) and move in (one, other):
                    raise _overlap_error(path, one, other)


def _overlap_error(path: Path, one: Movement, other: Movement) -> InputError:
    first = min(one.line, other.line)
    second = max(one.line, other.line)
    return InputError(
        f"{path}, line {second}: {other.part} at beat {other.begin:g}: the {one.part} of line {first} "
        f"moves or holds until beat {one.begin + one.beats:g}"
    )
