"""The one rule for names that stand in files more than once."""

from __future__ import annotations

from collections.abc import Iterable

from workbench.errors import printable

__all__ = ["unique_names"]


def unique_names(names: Iterable[str], otherwise: str) -> list[str]:
    """Number repeated names, the one rule for parts of meshes and markers of motions.

    The first of several equal names stays, the others become `seat_2`, `seat_3`; a number that
    another name has already is passed over. White space is evened out, control characters are
    escaped, an empty name becomes `otherwise`.
    """
    wanted = [printable(" ".join(name.split())) or otherwise for name in names]
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
