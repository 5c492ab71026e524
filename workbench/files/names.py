"""Names in files: those that stand more than once, and patterns of names."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from unicodedata import combining, normalize

from workbench.errors import InputError, has_controls, printable

__all__ = [
    "LONGEST_NAME",
    "good_name",
    "is_for_eyes",
    "is_for_heels",
    "matches",
    "matching",
    "spelled",
    "unique_names",
    "words_of",
]

LONGEST_NAME = 80
"""Characters of a name that somebody types."""
_EYES = frozenset(
    [
        "eye",
        "eyes",
        "eyepoint",
        "dep",
        "derp",
        "auge",
        "augen",
        "augpunkt",
        "augenpunkt",
        "oeil",
        "yeux",
        "ojo",
        "ojos",
        "occhio",
        "occhi",
    ]
)
_HEELS = frozenset(
    ["heel", "heels", "ahp", "ferse", "fersen", "talon", "talons", "talones", "tallone"]
)
"""Words by which points are for eyes and for heels."""


def unique_names(names: Iterable[str], otherwise: str) -> list[str]:
    """Number repeated names, the one rule for parts of meshes and markers of motions.

    The first of several equal names stays, the others become `seat_2`, `seat_3`; a number that
    another name has already is passed over. White space is evened out, control characters are
    escaped, letters with accents are single characters (Unicode NFC), an empty name becomes
    `otherwise`.
    """
    wanted = [normalize("NFC", printable(" ".join(name.split()))) or otherwise for name in names]
    taken = set(wanted)
    last: dict[str, int] = {}
    given: list[str] = []
    for name in wanted:
        count = last.get(name, 0) + 1
        candidate = name
        if count > 1:
            while (candidate := f"{name}_{count}") in taken:
                count += 1
        last[name] = count
        taken.add(candidate)
        given.append(candidate)
    return given


def good_name(name: str, kind: str) -> str:
    """Return a typed name without white space around it, and a single space for each inside.

    Raises
    ------
    InputError
        If nothing is left, it is longer than `LONGEST_NAME`, or it has control characters in it.
    """
    found = " ".join(name.split())
    if not found or len(found) > LONGEST_NAME or has_controls(found):
        raise InputError(f"a {kind} needs a name of 1 to {LONGEST_NAME} characters")
    return found


def spelled(folder: Path, name: str) -> str:
    """Return the path of a file as the folders on its way spell it, which may be in another Unicode form
    (letters and accents as one character or two); as given where it is not there.

    folder: where a path that is not absolute begins.
    """
    parts = name.split("/")
    for k, part in enumerate(parts):
        way = "/".join(parts[:k]) or ("/" if k and not parts[0] else "")
        if part.isascii() or os.path.lexists(folder / way / part):
            continue
        try:
            there = [path.name for path in (folder / way).iterdir()]
        except (OSError, ValueError):
            break
        alike = (one for one in there if normalize("NFC", one) == normalize("NFC", part))
        parts[k] = next(alike, part)
    return "/".join(parts)


def matches(pattern: str, name: str) -> bool:
    """Whether a name is the one meant: `*` stands for any letters, `?` for one, all else for
    itself."""
    return _pattern(pattern).fullmatch(name) is not None


def matching(patterns: Sequence[str] | None, names: Iterable[str]) -> tuple[str, ...]:
    """The names that match any of the patterns, in their own order; all where None is given."""
    return tuple(
        name
        for name in names
        if patterns is None or any(matches(pattern, name) for pattern in patterns)
    )


@cache
def _pattern(pattern: str) -> re.Pattern[str]:
    signs = {"*": ".*", "?": "."}
    return re.compile("".join(signs.get(c, re.escape(c)) for c in pattern), re.DOTALL)


def words_of(name: str) -> list[str]:
    """The words of a name, small and without accents: "SteuerKnüppel_2" is steuer, knuppel."""
    apart = re.sub(r"(?<=[a-zß-ÿ])(?=[A-ZÀ-Þ])", " ", name)
    plain = normalize("NFKD", apart.casefold())
    return re.findall(r"[a-z]+", "".join(c for c in plain if not combining(c)))


def is_for_eyes(name: str) -> bool:
    """Whether the name of a point is that of an eye point."""
    return not _EYES.isdisjoint(words_of(name))


def is_for_heels(name: str) -> bool:
    """Whether the name of a point is that of a heel point."""
    return not _HEELS.isdisjoint(words_of(name))
